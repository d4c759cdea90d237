//! Results as a table. In: irradiances of tiles as the engine gives them, and how large groups are. Out: rows in any format of tables.

use std::borrow::Cow;
use std::path::Path;

use crate::outputs::groups::Extent;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::format::Places;
use crate::outputs::tables::layout::{Fact, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::writer::{Stats, TableWriter};
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::units::tilt_and_azimuth;

/// A table of results being written.
pub struct ResultTable {
    table: TableWriter,
    layout: Layout,
    labels: usize,
}

impl ResultTable {
    /// Starts a table in the format that the name says.
    pub fn create(
        path: &Path,
        layout: &Layout,
        labels: &RowLabels,
        places: &Places,
        about: &Provenance,
    ) -> Result<Self> {
        let table = TableWriter::create(path, layout.columns(labels), *places, Some(about))?;
        Ok(ResultTable { table, layout: layout.clone(), labels: labels.len() })
    }

    /// Appends the rows of a tile; a shape other than names x labels is an error, nothing is written then.
    /// `extents` are those of groups, as many as rows have names; none for receivers.
    pub fn write_tile(&mut self, names: &[String], values: &TileValues, extents: &[Extent]) -> Result<()> {
        let (came, expected) = ((values.receivers(), values.labels()), (names.len(), self.labels));
        if came != expected {
            let what =
                format!("values of {} places x {} labels do not fit {} x {}", came.0, came.1, expected.0, expected.1);
            return Err(self.table.defect(what));
        }
        self.table.write(&batch(names, values, &self.layout, extents))
    }

    /// Whether the reader of the output has gone away: the caller may stop.
    pub fn is_closed(&self) -> bool {
        self.table.is_closed()
    }

    /// Completes the table; only now does its file appear.
    pub fn finish(self) -> Result<Stats> {
        self.table.finish()
    }
}

/// The rows of a tile of receivers, or of groups: `extents` are those of groups.
fn batch<'v>(names: &'v [String], values: &'v TileValues, layout: &Layout, extents: &[Extent]) -> Batch<'v> {
    let components = layout.components().iter().map(|component| Cow::Borrowed(values.component(*component)));
    let facts = layout.facts.iter().map(|fact| Cow::Owned(fact_column(*fact, values, extents)));
    let columns = components.chain(facts).map(Values::Floats);
    let places = Values::Texts(Cow::Borrowed(names));
    Batch { places: names.len(), values: std::iter::once(places).chain(columns).collect() }
}

/// What a fact is at each row. One that holds for the whole of the time stands in each row of its group.
fn fact_column(fact: Fact, values: &TileValues, extents: &[Extent]) -> Vec<f32> {
    let labels = values.labels();
    let of_group: fn(&Extent) -> f64 = match fact {
        Fact::Area => area_m2,
        Fact::Tilt => |extent| tilt_and_azimuth(extent.normal).0,
        Fact::Azimuth => |extent| tilt_and_azimuth(extent.normal).1,
        Fact::Sum => return sums(values, extents),
    };
    let all = extents.iter().flat_map(|extent| std::iter::repeat_n(of_group(extent) as f32, labels));
    all.chain(std::iter::repeat(0.0)).take(values.receivers() * labels).collect()
}

/// What all of a group gets.
fn sums(values: &TileValues, extents: &[Extent]) -> Vec<f32> {
    let means = values.component(Component::Total).chunks(values.labels().max(1)).zip(extents);
    means.flat_map(|(row, extent)| row.iter().map(|mean| (f64::from(*mean) * area_m2(extent)) as f32)).collect()
}

fn area_m2(extent: &Extent) -> f64 {
    extent.area_m2.unwrap_or_default()
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
        let names = ["roof", "wall"].map(str::to_owned);
        let rows = batch(&names, &values, &layout, &extents);
        let second: Vec<f32> = rows.values.iter().skip(1).map(|column| column.floats()[1]).collect();
        assert_eq!(second, [500.0, 4.0, 30.0, 180.0, 2000.0]);
        assert_eq!(rows.values[5].floats()[..], [8000.0, 2000.0]);
        assert_eq!(rows.misfit(&layout.columns(&RowLabels::words(vec!["total".into()]))), None);
        assert_eq!(layout.names()[2..], ["total_kwh_m2", "area_m2", "tilt_deg", "azimuth_deg", "total_kwh"]);
        assert_eq!(layout.units(), ["kWh/m2", "m2", "deg", "deg", "kWh"]);
    }
}
