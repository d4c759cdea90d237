//! The cells of a row. In: a record of a CSV file. Out: numbers, or an error that names line and column.

use std::borrow::Cow;
use std::path::Path;

use csv::ByteRecord;

use crate::error::{Error, Result};
use crate::weather::judging::raw_weather::irradiance;

/// From this down a number means that there is none: -999, -9999 and -9900 are in use.
const MISSING_BELOW: f64 = -900.0;

/// Light from here up is no measurement; some programs write 9999 for missing.
const MISSING_RADIATION: f64 = 9999.0;

/// Words for a missing number.
const MISSING: [&str; 7] = ["", "nan", "na", "n/a", "null", "none", "-"];

/// A row of a file.
pub struct Cells<'a> {
    pub path: &'a Path,
    pub line: usize,
    pub record: &'a ByteRecord,
}

/// A cell as text; empty beyond the end.
pub fn cell(record: &ByteRecord, place: usize) -> Cow<'_, str> {
    String::from_utf8_lossy(record.get(place).unwrap_or_default())
}

impl Cells<'_> {
    pub fn text(&self, place: usize) -> Cow<'_, str> {
        cell(self.record, place)
    }

    /// An error about a cell in the column of this name.
    pub fn bad(&self, place: usize, name: &str, hint: &str) -> Error {
        Error::input(self.path, self.line, format!("column `{name}` holds `{}`", self.text(place)), hint)
    }

    /// GHI, DNI or DHI; `None` where missing.
    pub fn light(&self, place: usize, name: &str, negative: &mut bool) -> Result<Option<f64>> {
        let text = self.text(place);
        if MISSING.iter().any(|word| text.eq_ignore_ascii_case(word)) {
            return Ok(None);
        }
        let missing = |value: f64| value.is_finite() && (value <= MISSING_BELOW || value >= MISSING_RADIATION);
        let hint = "write W/m2 from 0 up, with a decimal point; leave the cell empty where missing";
        irradiance(&text, missing, negative, || self.bad(place, name, hint))
    }

    /// Any other number within limits; `None` where it is missing, outside or no number.
    pub fn number(&self, place: Option<usize>, [low, high]: [f64; 2]) -> Option<f64> {
        self.text(place?).parse().ok().filter(|value| (low..=high).contains(value))
    }
}
