//! Rows of results. In: arrays of values of some places, and the extents of groups. Out: batches of
//! rows for a table in any format.

use std::borrow::Cow;
use std::path::Path;

use crate::outputs::groups::GroupGeometry;
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::{ChangeKind, Measure, PlaceValues, Quantity, ValueSource};
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::column::Digits;
use crate::outputs::tables::layout::{Fact, Layout};
use crate::outputs::tables::table::Table;
use crate::outputs::tables::writer::Places;
use heliotile_core::error::Result;
use heliotile_core::units::tilt_and_azimuth;

/// Columns of results, the labels of the rows of each place, and how rows are made.
#[derive(Clone, Debug)]
pub struct RowMaker {
    layout: Layout,
    labels: BinLabels,
    every: Option<Every>,
}

impl RowMaker {
    /// Returns rows of these columns and labels; `every` is the period of a row, `None` in a query.
    pub fn new(layout: Layout, labels: BinLabels, every: Option<Every>) -> Self {
        RowMaker { layout, labels, every }
    }

    /// Returns rows of receivers with their positions, directions and areas.
    #[must_use]
    pub fn with_positions(mut self) -> Self {
        self.layout.facts = Fact::OF_RECEIVERS.to_vec();
        self
    }

    /// Returns rows with other labels.
    #[must_use]
    pub fn with_labels(self, labels: BinLabels) -> Self {
        RowMaker { labels, ..self }
    }

    /// Returns the columns.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Returns the labels of the rows of a place.
    pub fn bin_labels(&self) -> &BinLabels {
        &self.labels
    }

    /// Returns the period of a row; `None` in a query.
    pub fn every(&self) -> Option<Every> {
        self.every
    }

    /// Starts a table in the format given by the ending of its name.
    pub fn table(&self, path: &Path, places: &Places, about: &Provenance) -> Result<Table> {
        Table::create(path, self.layout.columns(&self.labels), *places, Some(about))
    }

    /// Appends the rows of some places to a table. Values of another shape than names x bins are an
    /// error, and nothing is written then. `extents` has one entry for each group; for receivers it
    /// is empty, unless the table has their positions.
    pub fn write(
        &self,
        table: &mut Table,
        names: &[String],
        values: &PlaceValues,
        extents: &[GroupGeometry],
    ) -> Result<()> {
        let (came, expected) = ((values.places(), values.bins()), (names.len(), self.labels.len()));
        if came != expected {
            let what =
                format!("values of {} places x {} bins do not fit {} x {}", came.0, came.1, expected.0, expected.1);
            return Err(table.defect(what));
        }
        // Changes are computed from the rounded numbers, so that the printed numbers add up.
        let rounding = table.is_text().then(|| self.layout.digits_of_irradiance());
        table.write(&self.batch(names, values, extents, rounding))
    }

    /// Returns the rows of some receivers, or of groups with their `extents`.
    fn batch<'v>(
        &self,
        names: &'v [String],
        values: &PlaceValues<'v>,
        extents: &[GroupGeometry],
        rounding: Option<Digits>,
    ) -> Batch<'v> {
        let quantities = self.layout.quantities.iter().map(|quantity| self.column(quantity, values, rounding));
        let facts = self.layout.facts.iter().map(|fact| self.fact(*fact, values, extents));
        let places = Values::Texts(Cow::Borrowed(names));
        Batch { places: names.len(), values: std::iter::once(places).chain(quantities).chain(facts).collect() }
    }

    fn column<'v>(&self, quantity: &Quantity, values: &PlaceValues<'v>, rounding: Option<Digits>) -> Values<'v> {
        if quantity.measure.text(f32::NAN).is_some() {
            let of_place = |place: usize| {
                let texts = move |bin| quantity.measure.text(values.value(quantity.source, place, bin));
                (0..values.bins()).map(move |bin| texts(bin).unwrap_or_default())
            };
            return Values::Texts((0..values.places()).flat_map(of_place).collect());
        }
        if matches!(quantity.measure, Measure::Minutes | Measure::Number | Measure::Celsius | Measure::Hours) {
            let places = 0..values.places() * values.bins();
            let value = |i: usize| values.value(quantity.source, i / values.bins(), i % values.bins());
            return Values::Numbers(
                places.map(|i| Some(f64::from(value(i))).filter(|value| value.is_finite())).collect(),
            );
        }
        match (quantity.source, rounding) {
            (ValueSource::Array(number), _) => Values::Floats(Cow::Borrowed(values.array(number))),
            (ValueSource::Change { kind, from, to }, rounding) => {
                let pairs = values.array(from).iter().zip(values.array(to));
                Values::Numbers(pairs.map(|(from, to)| change(kind, [*from, *to], rounding)).collect())
            }
        }
    }

    /// Returns a fact at each row; a fact that does not depend on the bin is repeated in all rows
    /// of its group.
    fn fact(&self, fact: Fact, values: &PlaceValues, extents: &[GroupGeometry]) -> Values<'static> {
        let bins = values.bins();
        let of_group: fn(&GroupGeometry) -> f64 = match fact {
            Fact::Area => area_m2,
            Fact::Tilt => |extent| tilt_and_azimuth(extent.normal).0,
            Fact::Azimuth => |extent| tilt_and_azimuth(extent.normal).1,
            Fact::Sum => return self.sums(values, extents),
            Fact::Coordinate(_) | Fact::Direction(_) | Fact::Extent => {
                let numbers = extents.iter().flat_map(|extent| std::iter::repeat_n(exact(fact, extent), bins));
                return Values::Numbers(numbers.collect());
            }
        };
        let all = extents.iter().flat_map(|extent| std::iter::repeat_n(of_group(extent) as f32, bins));
        let all = all.chain(std::iter::repeat(0.0)).take(values.places() * bins);
        Values::Floats(all.collect())
    }

    /// Returns the sum of each group: its mean times its area.
    fn sums(&self, values: &PlaceValues, extents: &[GroupGeometry]) -> Values<'static> {
        let main = self.layout.main_quantity().source;
        let of_group = |(place, extent): (usize, &GroupGeometry)| {
            let area_m2 = area_m2(extent);
            (0..values.bins()).map(move |bin| (f64::from(values.value(main, place, bin)) * area_m2) as f32)
        };
        Values::Floats(extents.iter().take(values.places()).enumerate().flat_map(of_group).collect())
    }
}

/// Returns a fact of a receiver; `None` if it has none.
fn exact(fact: Fact, extent: &GroupGeometry) -> Option<f64> {
    match fact {
        Fact::Coordinate(axis) => extent.position.to_array().get(axis).copied(),
        Fact::Direction(angle) => <[f64; 2]>::from(tilt_and_azimuth(extent.normal)).get(angle).map(|deg| clean(*deg)),
        Fact::Extent | Fact::Area | Fact::Tilt | Fact::Azimuth | Fact::Sum => extent.area_m2,
    }
}

/// Rounds an angle to 1e-9 degrees, so that an angle which was asked for comes back.
fn clean(deg: f64) -> f64 {
    (deg * 1e9).round() / 1e9
}

/// Returns the change from `pair[0]` to `pair[1]`. With `rounding` the difference of the printed
/// numbers is exact to their last digit.
fn change(kind: ChangeKind, pair: [f32; 2], rounding: Option<Digits>) -> Option<f64> {
    let pair = pair.map(f64::from);
    let Some(digits) = rounding else { return kind.of(pair[0], pair[1]) };
    let decimals = pair.map(|value| digits.decimals(value));
    let shown = [0, 1].map(|side| at_decimals(pair[side], decimals[side]));
    let found = kind.of(shown[0], shown[1])?;
    Some(match kind {
        ChangeKind::Difference => at_decimals(found, decimals.into_iter().flatten().max()),
        ChangeKind::Percent => found,
    })
}

/// Returns the number as printed with `count` decimals, or unchanged for `None`; never -0.
fn at_decimals(value: f64, count: Option<usize>) -> f64 {
    0.0 + count.and_then(|count| format!("{value:.count$}").parse().ok()).unwrap_or(value)
}

fn area_m2(extent: &GroupGeometry) -> f64 {
    extent.area_m2.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::tables::layout::{BinKind, By};
    use glam::DVec3;
    use heliotile_core::replay::components::{Component, ComponentList};
    use heliotile_core::replay::values::TileValues;

    /// Two surfaces of 10 and 4 m2 with totals of 800 and 500 kWh/m2 sum to 8000 and 2000 kWh; the
    /// second faces south at 30 degrees.
    #[test]
    fn sums_of_surfaces_are_means_times_areas() {
        let components: ComponentList = "total".parse().expect("a name");
        let facts = vec![Fact::Area, Fact::Tilt, Fact::Azimuth, Fact::Sum];
        let layout = Layout { facts, ..Layout::of_components(BinKind::Sums, By::Surface, &components) };
        let mut values = TileValues::new(2, 1);
        values.component_mut(Component::Total).copy_from_slice(&[800.0, 500.0]);
        let extents = [
            GroupGeometry { area_m2: Some(10.0), normal: DVec3::Z, ..GroupGeometry::default() },
            GroupGeometry {
                area_m2: Some(4.0),
                normal: DVec3::new(0.0, -0.5, 0.75_f64.sqrt()),
                ..GroupGeometry::default()
            },
        ];
        let names = ["roof", "wall"].map(str::to_owned);
        let maker = RowMaker::new(layout.clone(), BinLabels::words(vec!["total".into()]), None);
        let values = PlaceValues::new(&[&values], components.as_slice());
        let rows = maker.batch(&names, &values, &extents, None);
        let second: Vec<f32> = rows.values.iter().skip(1).map(|column| column.floats()[1]).collect();
        assert_eq!(second, [500.0, 4.0, 30.0, 180.0, 2000.0]);
        assert_eq!(rows.values[5].floats()[..], [8000.0, 2000.0]);
        assert_eq!(rows.misfit(&layout.columns(&BinLabels::words(vec!["total".into()]))), None);
        assert_eq!(layout.names()[2..], ["total_kwh_m2", "area_m2", "tilt_deg", "azimuth_deg", "total_kwh"]);
        assert_eq!(layout.units(), ["kWh/m2", "m2", "deg", "deg", "kWh"]);
    }

    /// Changes in text are differences of the printed numbers, exact to their last digit, and
    /// elsewhere differences of all digits; percent of zero is no number: 7 pairs.
    #[test]
    fn changes_add_up_as_text() {
        let of = |pair: [f32; 2], digits| change(ChangeKind::Difference, pair, Some(digits)).expect("a number");
        assert_eq!(of([1270.8849, 1265.1251], Digits::Six), -5.75);
        assert_eq!(of([998.7651, 1012.3449], Digits::Six), 13.575);
        assert_eq!(of([0.765_432_1, 1012.34], Digits::Six), 1_011.574_568);
        assert_eq!(of([0.000_4, 12.000_6], Digits::Thousandths), 12.001);
        assert_eq!(change(ChangeKind::Difference, [1.5, 1.25], None), Some(-0.25));
        let percent = |pair| change(ChangeKind::Percent, pair, None);
        assert_eq!((percent([80.0, 60.0]), percent([0.0, 60.0])), (Some(-25.0), None));
    }
}
