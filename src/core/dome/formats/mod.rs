//! Readers of numbers of patches. In: the bytes of a table (CSV) or of a matrix of Radiance, as `gendaymtx` and `genskyvec` write it. Out: a
//! checked [`PatchFile`], and which of its rows goes with which condition.

mod matrix;
mod table;

pub use matrix::luminance;

use std::collections::HashMap;
use std::path::Path;

use crate::dome::grid::PatchGrid;
use crate::dome::series::PatchSeries;
use crate::error::{Error, Result};

/// What numbers of patches are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchQuantity {
    /// Radiances, W/m2/sr: 0 or more.
    Radiance,
    /// Shares of light that come through: 0 to 1.
    Transmittance,
}

impl PatchQuantity {
    /// Whether a number can be one; false for NaN.
    pub fn holds(self, number: f64) -> bool {
        match self {
            PatchQuantity::Radiance => (0.0..=MAX_RADIANCE_W_M2_SR).contains(&number),
            PatchQuantity::Transmittance => (0.0..=1.0).contains(&number),
        }
    }

    /// What its numbers are, for messages.
    pub fn range(self) -> &'static str {
        match self {
            PatchQuantity::Radiance => "radiances are numbers of W/m2/sr from 0 on",
            PatchQuantity::Transmittance => "transmittances are numbers from 0 to 1",
        }
    }
}

/// Half of that of the sun itself, which no patch reaches.
const MAX_RADIANCE_W_M2_SR: f64 = 1e7;

/// A file of numbers of patches.
#[derive(Debug)]
pub struct PatchFile {
    /// Its rows.
    pub series: PatchSeries,
    /// What its rows are called: times or conditions; none where only their order counts.
    pub labels: Option<Vec<String>>,
    /// Whether it is a matrix of Radiance.
    pub is_matrix: bool,
}

/// The rows that those of a file go with.
#[derive(Clone, Copy, Debug)]
pub struct PatchRows<'r> {
    /// Names of the conditions that count: times of the form `2019-03-01T06:00`, or words.
    pub labels: &'r [&'r str],
    /// `[condition]`: whether it cannot be without a row.
    pub needed: &'r [bool],
    /// `[condition]`: its place among the rows of its file.
    pub places: &'r [usize],
    /// Number of rows of its file, with those that do not count.
    pub rows: usize,
    /// What its file is, for messages: `a weather file`.
    pub file: &'static str,
}

/// Reads the bytes of a table or a matrix; `path` is its name in messages.
pub fn parse_patch_file(path: &Path, bytes: &[u8], quantity: PatchQuantity) -> Result<PatchFile> {
    match matrix::is_matrix(bytes) {
        true => matrix::parse_matrix(path, bytes, quantity),
        false => table::parse_table(path, bytes, quantity),
    }
}

impl PatchFile {
    /// `[condition]`: the row of this file that goes with it: the one of its name, where rows have names (a time without a year is that of any
    /// year); or else the only one there is, or the one at its place. A condition that needs none may be without.
    pub fn matched(&self, path: &Path, to: PatchRows) -> Result<Vec<Option<usize>>> {
        let found = self.series.rows();
        let Some(labels) = &self.labels else {
            if found == 1 {
                return Ok(vec![Some(0); to.labels.len()]);
            }
            if found != to.rows {
                let rows = if self.is_matrix { "columns of time" } else { "rows" };
                let what = format!("{found} {rows} for {} of {} rows", to.file, to.rows);
                return Err(Error::input(
                    path,
                    None,
                    what,
                    "make it of the same rows, in their order, or of one row for all",
                ));
            }
            return Ok(to.places.iter().map(|place| Some(*place)).collect());
        };
        let mut places: HashMap<String, usize> = HashMap::with_capacity(found);
        for (row, label) in labels.iter().enumerate() {
            let name = label_key(label);
            if places.insert(name, row).is_some() {
                let what = format!("`{label}` is the name of two rows");
                return Err(Error::input(path, None, what, "give every row its own time or condition"));
            }
        }
        let of = |(label, needed): (&&str, &bool)| {
            let without_year = label.split_once('-').map_or("", |(_, rest)| rest);
            let row = places.get(*label).or_else(|| places.get(without_year)).copied();
            let missing = || {
                let what = format!("no row for `{label}` among {found}");
                let hint = "name rows as the results do, times by the start of their interval in local standard time";
                Error::input(path, None, what, hint)
            };
            if row.is_none() && *needed { Err(missing()) } else { Ok(row) }
        };
        to.labels.iter().zip(to.needed).map(of).collect()
    }
}

/// A name of a row, times as results write them: `2019-03-01 06:00:00` is `2019-03-01T06:00`.
fn label_key(label: &str) -> String {
    let is_time = label.len() >= 11 && label.bytes().all(|b| b.is_ascii_digit() || b"-: T".contains(&b));
    if !is_time {
        return label.to_owned();
    }
    let key = label.replacen(' ', "T", 1);
    match key.strip_suffix(":00").filter(|rest| rest.matches(':').count() == 1) {
        Some(minutes) => minutes.to_owned(),
        None => key,
    }
}

/// The subdivision of so many patches, and whether the first of them is the ground.
fn grid_of(patches: usize) -> Option<(PatchGrid, bool)> {
    let whole = PatchGrid::of_count(patches).map(|grid| (grid, false));
    whole.or_else(|| PatchGrid::of_count(patches.checked_sub(1)?).map(|grid| (grid, true)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(labels: Option<&[&str]>, rows: usize) -> PatchFile {
        let grid = PatchGrid::of_factor(1);
        let series = PatchSeries::new(grid, vec![1.0; 145 * rows]).expect("rows");
        let labels = labels.map(|labels| labels.iter().map(|label| (*label).to_owned()).collect());
        PatchFile { series, labels, is_matrix: false }
    }

    fn matched(file: &PatchFile, labels: &[&str], rows: usize) -> Result<Vec<Option<usize>>> {
        let places: Vec<usize> = (0..labels.len()).map(|i| i + 1).collect();
        let needed: Vec<bool> = labels.iter().map(|label| !label.contains("T08")).collect();
        let to = PatchRows { labels, needed: &needed, places: &places, rows, file: "a weather file" };
        file.matched(Path::new("p.csv"), to)
    }

    /// One row serves all; rows without names go by place; names are times with a year, without one and with seconds, or words; a row that is
    /// missing, a name that comes twice and another count are three errors.
    #[test]
    fn rows_find_their_conditions() {
        let hours = ["2019-03-01T06:00", "2019-03-01T07:00", "2019-03-01T08:00"];
        assert_eq!(matched(&file(None, 1), &hours, 9).expect("one"), [Some(0); 3]);
        assert_eq!(matched(&file(None, 9), &hours, 9).expect("places"), [Some(1), Some(2), Some(3)]);
        let named = file(Some(&["03-01T07:00", "2019-03-01 06:00:00"]), 2);
        assert_eq!(matched(&named, &hours, 9).expect("times"), [Some(1), Some(0), None]);
        assert_eq!(matched(&file(Some(&["noon"]), 1), &["noon"], 1).expect("words"), [Some(0)]);
        let refused = |file: PatchFile| matched(&file, &hours, 9).expect_err("refused").to_string();
        assert!(refused(file(None, 8)).contains("8 rows for a weather file of 9 rows"));
        assert!(refused(file(Some(&["03-01T07:00"]), 1)).contains("no row for `2019-03-01T06:00` among 1"));
        assert!(refused(file(Some(&["a", "a"]), 2)).contains("`a` is the name of two rows"));
    }
}
