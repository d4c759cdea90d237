//! Light that objects take and give as a table. In: shares of receivers or groups. Out: a table of
//! any format, a row for each object and period.

use std::path::Path;

use super::provenance::Provenance;
use super::tables::batch::{Batch, Values};
use super::tables::bin_labels::BinLabels;
use super::tables::column::{Column, Digits, Kind, TableColumns};
use super::tables::layout::{BinKind, By};
use super::tables::table::Table;
use super::tables::writer::Places;
use heliotile_core::error::Result;
use heliotile_core::replay::by_object::{GIVEN, ObjectLight};

/// Number of shares that become one batch of rows.
const SHARES_AT_ONCE: usize = 1024;

/// Light of one object at one receiver or group.
pub struct Share {
    /// Number of the receiver or group, and its name.
    pub group: usize,
    pub place: String,
    pub area_m2: Option<f64>,
    /// Name and class of the object; `is_own` says that the receiver is on it.
    pub taker: String,
    pub class: &'static str,
    pub is_own: bool,
    /// `[sun, sky][period]`: light under a free sky.
    pub free: [Vec<f64>; 2],
    pub light: ObjectLight,
}

/// Periods of a table, and what its rows stand for besides them.
pub struct ShareRows<'l> {
    pub by: By,
    pub kind: BinKind,
    pub labels: &'l BinLabels,
}

/// Writes the table of `shares`, with a row for each and each period.
pub fn write_shares(path: &Path, rows: &ShareRows, shares: &[Share], about: &Provenance) -> Result<u64> {
    let (are_sums, periods) = (rows.kind == BinKind::Sums, rows.labels.len());
    let has_areas = shares.iter().any(|share| share.area_m2.is_some());
    let label = if rows.kind == BinKind::Conditions { "condition" } else { "time" };
    let light = |name: &str| match are_sums {
        true => Column::float(format!("{name}_kwh_m2"), Digits::Six),
        false => Column::float(name, Digits::Thousandths).with_unit("W/m2"),
    };
    let mut columns = vec![
        Column::of_bins(label, Kind::Category, rows.labels),
        Column::of_places(rows.by.name(), Kind::Text),
        Column::of_places("taker", Kind::Text),
        Column::of_places("class", Kind::Text),
        Column::count("own"),
    ];
    columns.extend(["sun_taken", "sky_taken"].map(light));
    columns.extend(GIVEN.map(|component| light(component.name())));
    columns.extend(["sun_taken_percent", "sky_taken_percent"].map(|name| Column::number(name, 2)));
    if has_areas {
        columns.push(Column::number_as("area_m2", Digits::Six));
        if are_sums {
            columns.extend(["taken_kwh", "given_kwh"].map(|name| Column::number_as(name, Digits::Six)));
        }
    }
    let count = shares.len() as u64;
    let mut table = Table::create(path, TableColumns::new(columns), Places::counted(count), Some(about))?;
    for some in shares.chunks(SHARES_AT_ONCE) {
        if table.is_closed() {
            break;
        }
        table.write(&batch(some, periods, has_areas, are_sums))?;
    }
    Ok(table.finish()?.bytes)
}

/// Returns the rows of some shares.
fn batch(shares: &[Share], periods: usize, has_areas: bool, are_sums: bool) -> Batch<'static> {
    let rows = || shares.iter().flat_map(|share| (0..periods).map(move |period| (share, period)));
    let texts = |text: fn(&Share) -> String| Values::Texts(shares.iter().map(text).collect::<Vec<_>>().into());
    let light = |of: &dyn Fn(&Share) -> &[f64]| {
        Values::Floats(rows().map(|(share, period)| of(share)[period] as f32).collect::<Vec<_>>().into())
    };
    let numbers = |of: &dyn Fn(&Share, usize) -> Option<f64>| {
        Values::Numbers(rows().map(|(share, period)| of(share, period)).collect())
    };
    let mut values = vec![
        texts(|share| share.place.clone()),
        texts(|share| share.taker.clone()),
        texts(|share| share.class.to_owned()),
        Values::Counts(rows().map(|(share, _)| u64::from(share.is_own)).collect()),
    ];
    values.extend((0..2).map(|column| light(&|share| &share.light.taken[column])));
    values.extend((0..GIVEN.len()).map(|column| light(&|share| &share.light.given[column])));
    values.extend((0..2).map(|column| {
        numbers(&|share, period| {
            let (free, taken) = (share.free[column][period], share.light.taken[column][period]);
            (free > 0.0).then(|| 100.0 * taken / free)
        })
    }));
    if has_areas {
        values.push(numbers(&|share, _| share.area_m2));
        if are_sums {
            let all = |share: &Share, columns: &[Vec<f64>], period: usize| {
                Some(share.area_m2? * columns.iter().map(|column| column[period]).sum::<f64>())
            };
            values.push(numbers(&|share, period| all(share, &share.light.taken, period)));
            values.push(numbers(&|share, period| all(share, &share.light.given, period)));
        }
    }
    Batch { places: shares.len(), values }
}
