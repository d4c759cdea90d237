//! Readers of values of sky patches. In: the bytes of a table (CSV) or of a matrix of Radiance, as
//! `gendaymtx` and `genskyvec` write it. Out: a checked [`PatchFile`], and the match of its rows
//! with conditions.

mod matrix;
mod table;

pub use matrix::luminance;

use std::collections::HashMap;
use std::path::Path;

use heliotile_core::dome::grid::PatchGrid;
use heliotile_core::dome::series::PatchSeries;
use heliotile_core::error::{Error, Problem, Result};

/// Quantity of the values of patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchQuantity {
    /// Radiances, W/m2/sr: 0 or more.
    Radiance,
    /// Shares of light that come through: 0 to 1.
    Transmittance,
}

impl PatchQuantity {
    /// Returns true if a number is in the range of the quantity; false for NaN.
    pub fn holds(self, number: f64) -> bool {
        match self {
            PatchQuantity::Radiance => (0.0..=MAX_RADIANCE_W_M2_SR).contains(&number),
            PatchQuantity::Transmittance => (0.0..=1.0).contains(&number),
        }
    }

    /// Returns the range of the quantity, for messages.
    pub fn range(self) -> &'static str {
        match self {
            PatchQuantity::Radiance => "radiances are numbers of W/m2/sr, 0 or more",
            PatchQuantity::Transmittance => "transmittances are numbers from 0 to 1",
        }
    }
}

/// Largest radiance, W/m2/sr: half of that of the sun itself, which no patch reaches.
const MAX_RADIANCE_W_M2_SR: f64 = 1e7;

/// Values of patches in a file.
#[derive(Debug)]
pub struct PatchFile {
    /// Rows of the file.
    pub series: PatchSeries,
    /// Names of the rows: times or conditions; `None` where only their order counts.
    pub labels: Option<Vec<String>>,
    /// True if the file is a matrix of Radiance.
    pub is_matrix: bool,
}

/// Conditions that the rows of a file are matched with.
#[derive(Clone, Copy, Debug)]
pub struct PatchRows<'r> {
    /// Names of the conditions: times of the form `2019-03-01T06:00`, or words.
    pub labels: &'r [&'r str],
    /// `[condition]`: true if it must have a row.
    pub needed: &'r [bool],
    /// `[condition]`: its index among the rows of its file.
    pub places: &'r [usize],
    /// Number of rows of its file, unused rows included.
    pub rows: usize,
    /// Kind of its file, for messages: `a weather file`.
    pub file: &'static str,
}

/// Reads the bytes of a table or a matrix; messages call it `path`.
pub fn parse_patch_file(path: &Path, bytes: &[u8], quantity: PatchQuantity) -> Result<PatchFile> {
    match matrix::is_matrix(bytes) {
        true => matrix::parse_matrix(path, bytes, quantity),
        false => table::parse_table(path, bytes, quantity),
    }
}

impl PatchFile {
    /// Returns `[condition]`: the row of this file for it. Named rows are matched by name (a time
    /// without a year matches any year). Otherwise the only row serves all, or rows are matched by
    /// index. A condition that needs no row may have none.
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
                    "give one row for each of these rows, in their order, or a single row for all",
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
                let what = format!("none of {found} rows is named `{label}`");
                let hint = "name rows as the results name them; a time is the start of its interval in local \
                            standard time";
                Error::input(path, None, what, hint).because(Problem::unknown(label, []))
            };
            if row.is_none() && *needed { Err(missing()) } else { Ok(row) }
        };
        to.labels.iter().zip(to.needed).map(of).collect()
    }
}

/// Returns the name of a row with times written as in results: `2019-03-01 06:00:00` becomes
/// `2019-03-01T06:00`.
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

/// Returns the subdivision of `patches` patches, and true if the first of them is the ground.
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

    /// One row serves all. Rows without names are matched by index. Names are times with a year,
    /// without one and with seconds, or words. A missing row, a repeated name and another count are
    /// three errors.
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
        assert!(refused(file(Some(&["03-01T07:00"]), 1)).contains("none of 1 rows is named `2019-03-01T06:00`"));
        assert!(refused(file(Some(&["a", "a"]), 2)).contains("`a` is the name of two rows"));
    }
}
