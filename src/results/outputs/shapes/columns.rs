//! The columns of a map. In: the layout of a table, its labels. Out: names and units, wide: one row a place, and a tile's values in that order.

use super::row::MapRow;
use crate::outputs::groups::{Extent, ONE_WAY};
use crate::outputs::periods::Every;
use crate::outputs::tables::layout::{By, Labels, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::units::tilt_and_azimuth;

/// Value columns at most: programs of GIS become slow before files end.
const MOST_COLUMNS: usize = 256;

/// Numbers that stand before the values: area, tilt and azimuth.
pub const FACTS: usize = 3;

/// How labels become columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wide {
    /// One label: a column for each component.
    One,
    /// The sum of all labels by component, then one component by label.
    Sums,
    /// Each component of each label.
    Each,
    /// None: values stand elsewhere.
    None,
}

/// Columns of a map.
#[derive(Clone, Debug)]
pub struct MapColumns {
    pub texts: Vec<String>,
    /// Names and units.
    pub numbers: Vec<(String, &'static str)>,
    /// The number that gives colours.
    pub colour: usize,
    components: Vec<Component>,
    /// The component that stands for all.
    main: Component,
    wide: Wide,
    by: By,
    /// Whether the last number is the main one times the area.
    has_sum: bool,
}

impl MapColumns {
    /// Of a table's layout; `every` is none for a query. Hours and days are refused, and so are too many columns.
    pub fn of(layout: &Layout, labels: &RowLabels, every: Option<Every>) -> Result<Self> {
        let components = layout.components().to_vec();
        let main = layout.main();
        let wide = match (every, labels.len()) {
            (Some(Every::Hour | Every::Day), 1) => Wide::One,
            (Some(Every::Hour | Every::Day), count) => {
                return Err(Error::argument(
                    "output",
                    format!("a map has a row for each place, and {count} columns of each component are too many"),
                    "give {every} total, year or month, or a time series for ParaView: a name that ends with .pvd",
                ));
            }
            (Some(Every::Month), _) => Wide::Sums,
            (_, 1) => Wide::One,
            _ => Wide::Each,
        };
        let suffix = suffix(layout);
        let mut values: Vec<String> = match wide {
            Wide::One | Wide::Sums => components.iter().map(|one| format!("{}_{suffix}", one.name())).collect(),
            Wide::Each | Wide::None => {
                let of_label = |label: &String| {
                    let name = |one: &Component| format!("{label}_{}_{suffix}", one.name());
                    components.iter().map(name).collect::<Vec<_>>()
                };
                labels.text.iter().flat_map(of_label).collect()
            }
        };
        if wide == Wide::Sums {
            values.extend(months(&labels.text).iter().map(|month| format!("{}_{month}_{suffix}", main.name())));
        }
        if values.len() > MOST_COLUMNS {
            let what = format!(
                "columns of values of a map, {} of {} components (take fewer with {{columns}} total, or write a table)",
                labels.len(),
                components.len()
            );
            return Err(Error::Limit { what, value: values.len() as u64, max: MOST_COLUMNS as u64 });
        }
        let has_sum = main == Component::Total && wide != Wide::Each;
        let sum = has_sum
            .then(|| if layout.labels == Labels::Sums { ("total_kwh".into(), "kWh") } else { ("total_w".into(), "W") });
        let unit = layout.unit();
        let numbers = facts().chain(values.into_iter().map(|name| (name, unit))).chain(sum).collect();
        let place = components.iter().position(|one| *one == main).unwrap_or_default();
        Ok(MapColumns {
            texts: texts(layout.by),
            numbers,
            colour: FACTS + place,
            components,
            main,
            wide,
            by: layout.by,
            has_sum,
        })
    }

    /// Without values, which are written for each label apart.
    pub fn of_places(layout: &Layout) -> Self {
        MapColumns {
            texts: texts(layout.by),
            numbers: facts().collect(),
            colour: 0,
            components: layout.components().to_vec(),
            main: Component::Total,
            wide: Wide::None,
            by: layout.by,
            has_sum: false,
        }
    }

    /// The component that stands for all.
    pub fn main(&self) -> Component {
        self.main
    }

    /// A row without polygons: what the receivers of a place have in common, its extent, and its values in a tile.
    pub fn row(
        &self,
        name: &str,
        common: &Receiver,
        extent: &Extent,
        area_m2: f64,
        values: &TileValues,
        row: usize,
    ) -> MapRow {
        let of_part = [
            common.surface.as_deref().unwrap_or_default(),
            &common.part.object,
            &common.part.building,
            &common.part.kind,
        ];
        let parts = OTHERS.iter().zip(of_part).filter(|(by, _)| **by != self.by).map(|(_, text)| text.to_owned());
        let texts = std::iter::once(name.to_owned()).chain(parts).collect();
        let (tilt, azimuth) = match extent.agreement >= ONE_WAY {
            true => tilt_and_azimuth(extent.normal),
            false => (f64::NAN, f64::NAN),
        };
        let mut numbers = vec![area_m2 as f32, tilt as f32, azimuth as f32];
        let sum = |one: Component| values.row(one, row).iter().map(|value| f64::from(*value)).sum::<f64>();
        match self.wide {
            Wide::One => numbers
                .extend(self.components.iter().map(|one| values.row(*one, row).first().copied().unwrap_or_default())),
            Wide::Sums => {
                numbers.extend(self.components.iter().map(|one| sum(*one) as f32));
                numbers.extend(values.row(self.main, row));
            }
            Wide::Each => {
                let of_label = |label: usize| {
                    self.components.iter().map(move |one| values.row(*one, row).get(label).copied().unwrap_or_default())
                };
                numbers.extend((0..values.labels()).flat_map(of_label));
            }
            Wide::None => {}
        }
        if self.has_sum {
            numbers.push((sum(self.main) * area_m2) as f32);
        }
        MapRow { texts, numbers, polygons: Vec::new() }
    }
}

/// Unit of the values, at the end of their names.
pub fn suffix(layout: &Layout) -> &'static str {
    match layout.labels {
        Labels::Sums => "kwh_m2",
        Labels::Conditions | Labels::Times => "w_m2",
    }
}

/// What a place may be a part of, in the order of columns.
const OTHERS: [By; 4] = [By::Surface, By::Object, By::Building, By::Kind];

fn texts(by: By) -> Vec<String> {
    let others = OTHERS.into_iter().filter(|other| *other != by);
    std::iter::once(by).chain(others).map(|by| by.name().to_owned()).collect()
}

fn facts() -> impl Iterator<Item = (String, &'static str)> {
    [("area_m2", "m2"), ("tilt_deg", "deg"), ("azimuth_deg", "deg")]
        .into_iter()
        .map(|(name, unit)| (name.to_owned(), unit))
}

/// Months without their year, where that is one; with underscores.
fn months(labels: &[String]) -> Vec<String> {
    let short = |label: &String| label.rsplit('-').next().unwrap_or_default().to_owned();
    let mut all: Vec<String> = labels.iter().map(short).collect();
    all.sort();
    all.dedup();
    match all.len() == labels.len() {
        true => labels.iter().map(short).collect(),
        false => labels.iter().map(|label| label.replace('-', "_")).collect(),
    }
}
