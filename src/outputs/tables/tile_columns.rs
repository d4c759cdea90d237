//! The value columns of a tile's rows. In: irradiances as the engine gives them, and how large groups are. Out: columns in a table's order.

use std::borrow::Cow;

use crate::outputs::groups::Extent;
use crate::outputs::tables::layout::{Fact, Layout};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::units::tilt_and_azimuth;

/// Values of some receivers, or of some groups of them: `[column][receiver][label]`, row-major.
pub struct TileColumns<'v> {
    columns: Vec<Cow<'v, [f32]>>,
    receivers: usize,
    labels: usize,
}

impl<'v> TileColumns<'v> {
    /// The columns of a layout; `extents` are those of its groups, none for receivers. A value for the whole of the time stands in each
    /// row.
    pub fn of(values: &'v TileValues, layout: &Layout, extents: &[Extent]) -> Self {
        let (receivers, labels) = (values.receivers(), values.labels());
        let repeated = |value: &dyn Fn(&Extent) -> f64| -> Vec<f32> {
            let all = extents.iter().flat_map(|extent| std::iter::repeat_n(value(extent) as f32, labels));
            all.chain(std::iter::repeat(0.0)).take(receivers * labels).collect()
        };
        let area = |extent: &Extent| extent.area_m2.unwrap_or_default();
        let fact = |fact: &Fact| match fact {
            Fact::Area => repeated(&area),
            Fact::Tilt => repeated(&|extent| tilt_and_azimuth(extent.normal).0),
            Fact::Azimuth => repeated(&|extent| tilt_and_azimuth(extent.normal).1),
            Fact::Sum => {
                let means = values.component(Component::Total).chunks(labels.max(1)).zip(extents);
                means
                    .flat_map(|(row, extent)| row.iter().map(|mean| (f64::from(*mean) * area(extent)) as f32))
                    .collect()
            }
        };
        let components = layout.components().iter().map(|component| Cow::Borrowed(values.component(*component)));
        let facts = layout.facts.iter().map(|of| Cow::Owned(fact(of)));
        TileColumns { columns: components.chain(facts).collect(), receivers, labels }
    }

    /// `[receiver][label]` of a column.
    pub fn column(&self, number: usize) -> &[f32] {
        self.columns.get(number).map_or(&[], |column| column)
    }

    /// `[label]` of each column at a receiver.
    pub fn rows(&self, receiver: usize) -> Vec<&[f32]> {
        let range = receiver * self.labels..(receiver + 1) * self.labels;
        self.columns.iter().map(|column| column.get(range.clone()).unwrap_or_default()).collect()
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.columns.len()
    }

    pub fn receivers(&self) -> usize {
        self.receivers
    }

    pub fn labels(&self) -> usize {
        self.labels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::tables::layout::{By, Labels};
    use glam::DVec3;

    /// Two surfaces of 10 and 4 m2 with totals of 800 and 500 kWh/m2 sum to 8000 and 2000 kWh; the second looks south at 30 degrees.
    #[test]
    fn facts() {
        let components = "total".parse().expect("a name");
        let facts = vec![Fact::Area, Fact::Tilt, Fact::Azimuth, Fact::Sum];
        let layout = Layout { labels: Labels::Sums, by: By::Surface, components, facts };
        let mut values = TileValues::new(2, 1);
        values.component_mut(Component::Total).copy_from_slice(&[800.0, 500.0]);
        let extents = [
            Extent { area_m2: Some(10.0), normal: DVec3::Z, agreement: 1.0 },
            Extent { area_m2: Some(4.0), normal: DVec3::new(0.0, -0.5, 0.75_f64.sqrt()), agreement: 1.0 },
        ];
        let columns = TileColumns::of(&values, &layout, &extents);
        assert_eq!((columns.column(0), columns.column(1)), (&[800.0, 500.0][..], &[10.0, 4.0][..]));
        assert_eq!((columns.column(4), columns.count()), (&[8000.0, 2000.0][..], 5));
        assert_eq!(columns.rows(1), [[500.0], [4.0], [30.0], [180.0], [2000.0]]);
        assert_eq!(layout.names()[2..], ["total_kwh_m2", "area_m2", "tilt_deg", "azimuth_deg", "total_kwh"]);
        assert_eq!(layout.units(), ["kWh/m2", "m2", "deg", "deg", "kWh"]);
    }
}
