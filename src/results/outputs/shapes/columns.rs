//! Columns of a map. In: the layout of a table, its bins. Out: names and units of a wide table
//! with one row a place, and the values of a tile in that order.

use super::row::MapRow;
use super::stated::{StatedColumns, TextKind};
use crate::outputs::groups::{GroupGeometry, ONE_WAY};
use crate::outputs::periods::Every;
use crate::outputs::pictures::colours::ColourScale;
use crate::outputs::quantities::{LightEnding, PlaceValues, Quantity, ValueSource, Verdict};
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::layout::{BinKind, By, Layout};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::message;
use heliotile_core::units::tilt_and_azimuth;

/// Largest number of value columns: GIS programs become slow long before file formats reach their
/// limits.
const MAX_COLUMNS: usize = 256;

/// Number of columns before the values: area, tilt and azimuth.
pub const FACTS: usize = 3;

/// Arrangement of bins in columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wide {
    /// One label: a column for each quantity.
    One,
    /// Each quantity of the sums of all bins, then the main quantity by bin.
    Sums,
    /// Each quantity of each bin.
    Each,
    /// No value columns: values are written elsewhere.
    None,
}

/// Columns of a map.
#[derive(Clone, Debug)]
pub struct MapColumns {
    /// Names of text columns: the place, the parts of the model it belongs to, then the attributes
    /// that the model states.
    pub texts: Vec<String>,
    /// `[column of texts]`: type of its values.
    pub kinds: Vec<TextKind>,
    /// Names and units of number columns.
    pub numbers: Vec<(String, &'static str)>,
    /// Index of the number column that gives colours.
    pub colour: usize,
    /// Colour scale of that column.
    pub scale: ColourScale,
    /// Index of the number column with the verdict of a rule on that column.
    pub verdict: Option<usize>,
    /// Indices of the number columns with the least and the most that meet the rule.
    pub thresholds: [Option<usize>; 2],
    quantities: Vec<Quantity>,
    /// Index of the main quantity.
    main: usize,
    wide: Wide,
    by: By,
    /// True if the last number is the main one times the area.
    has_sum: bool,
}

impl MapColumns {
    /// Returns the columns of a table's layout; `every` is `None` for a query. Several hours or
    /// days are refused, and so are too many columns.
    pub fn new(layout: &Layout, bins: &BinLabels, every: Option<Every>) -> Result<Self> {
        let quantities = layout.quantities.as_slice();
        let wide = match (every, bins.len()) {
            (Some(Every::Hour | Every::Day), 1) => Wide::One,
            (Some(Every::Hour | Every::Day), count) => {
                return Err(Error::argument(
                    "output",
                    format!("a map has one row for each place, and {count} columns for each component are too many"),
                    "give {every} total, year or month, or a time series for ParaView: a name that ends with .pvd",
                )
                .because(Problem::excludes("every")));
            }
            (Some(Every::Month), _) => Wide::Sums,
            (_, 1) => Wide::One,
            _ => Wide::Each,
        };
        let ending = ending(layout);
        let unit = |quantity: &Quantity| layout.unit_of(quantity);
        let mut values: Vec<(String, &'static str)> = match wide {
            Wide::One | Wide::Sums => quantities.iter().map(|one| (one.with_ending(ending), unit(one))).collect(),
            Wide::Each | Wide::None => {
                let of_bin = |bin: &String| {
                    let column = |one: &Quantity| (format!("{bin}_{}", one.with_ending(ending)), unit(one));
                    quantities.iter().map(column).collect::<Vec<_>>()
                };
                bins.text.iter().flat_map(of_bin).collect()
            }
        };
        let main = layout.main_quantity();
        if wide == Wide::Sums {
            let months = months(&bins.text);
            let of_month = |month: &String| {
                let named = Quantity { name: format!("{}_{month}", main.name), ..main.clone() };
                (named.with_ending(ending), unit(main))
            };
            values.extend(months.iter().map(of_month));
        }
        if values.len() > MAX_COLUMNS {
            let what = message!(
                "the number of columns of a map, {} of {} components (choose fewer with {{columns}} total, or write a table)",
                bins.len(),
                quantities.len()
            );
            return Err(Error::Limit { what, value: values.len() as u64, max: MAX_COLUMNS as u64 });
        }
        let has_sum = layout.has_energy && wide != Wide::Each;
        let numbers = facts().chain(values).chain(has_sum.then(|| layout.energy())).collect();
        let column = |name: &str| layout.quantities.iter().position(|one| one.name == name).map(|at| FACTS + at);
        Ok(MapColumns {
            numbers,
            colour: FACTS + layout.main,
            verdict: column(Verdict::COLUMN),
            thresholds: Verdict::THRESHOLDS.map(column),
            wide,
            has_sum,
            ..MapColumns::of_places(layout)
        })
    }

    /// Returns the columns without values, which are written separately for each bin.
    pub fn of_places(layout: &Layout) -> Self {
        MapColumns {
            kinds: texts(layout.by).iter().map(|_| TextKind::Text).collect(),
            texts: texts(layout.by),
            numbers: facts().collect(),
            colour: 0,
            scale: match layout.main_quantity().source {
                ValueSource::Array(_) => ColourScale::FromZero,
                ValueSource::Change { .. } => ColourScale::AroundZero,
            },
            verdict: None,
            thresholds: [None; 2],
            quantities: layout.quantities.clone(),
            main: layout.main,
            wide: Wide::None,
            by: layout.by,
            has_sum: false,
        }
    }

    /// Adds columns of the attributes that the model states for objects.
    pub fn stating(mut self, stated: &StatedColumns) -> Self {
        for (name, kind) in &stated.columns {
            self.texts.push(name.clone());
            self.kinds.push(*kind);
        }
        self
    }

    /// Returns the names of all columns.
    pub fn names(&self) -> Vec<String> {
        self.texts.iter().cloned().chain(self.numbers.iter().map(|(name, _)| name.clone())).collect()
    }

    /// Returns a row without polygons, from the properties that the receivers of a place share, its
    /// extent, and its values in a tile.
    pub fn row(
        &self,
        name: &str,
        common: &Receiver,
        extent: &GroupGeometry,
        area_m2: f64,
        values: &PlaceValues,
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
        let sources = || self.quantities.iter().map(|quantity| quantity.source);
        let main = sources().nth(self.main);
        let of_bin = |bin: usize| sources().map(move |source| values.value(source, row, bin));
        match self.wide {
            Wide::One => numbers.extend(of_bin(0)),
            Wide::Sums => {
                numbers.extend(sources().map(|source| values.value_of_sums(source, row) as f32));
                let bins = 0..values.bins();
                numbers
                    .extend(main.into_iter().flat_map(|main| bins.clone().map(move |at| values.value(main, row, at))));
            }
            Wide::Each => numbers.extend((0..values.bins()).flat_map(of_bin)),
            Wide::None => {}
        }
        if self.has_sum {
            numbers.extend(main.map(|main| (values.value_of_sums(main, row) * area_m2) as f32));
        }
        MapRow { texts, numbers, polygons: Vec::new() }
    }
}

/// Returns the kind of ending of the names of light columns.
pub fn ending(layout: &Layout) -> LightEnding {
    match layout.bins {
        BinKind::Sums => LightEnding::Sums,
        BinKind::Conditions | BinKind::Times | BinKind::Dates | BinKind::Rules => LightEnding::Means,
    }
}

/// Parts of the model that a place may belong to, in the order of columns.
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

/// Returns the names of months without their year if that keeps them distinct, or else with
/// underscores.
fn months(bins: &[String]) -> Vec<String> {
    let short = |bin: &String| bin.rsplit('-').next().unwrap_or_default().to_owned();
    let mut all: Vec<String> = bins.iter().map(short).collect();
    all.sort();
    all.dedup();
    match all.len() == bins.len() {
        true => bins.iter().map(short).collect(),
        false => bins.iter().map(|bin| bin.replace('-', "_")).collect(),
    }
}
