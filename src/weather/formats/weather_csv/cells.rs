//! The cells of a row. In: a record of a table. Out: numbers, or an error that names line and
//! column.

use std::borrow::Cow;
use std::path::Path;

use csv::ByteRecord;

use crate::judging::raw_weather::MISSING_99;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::excerpt;

/// Largest number of W/m2 that stands for a missing value: -999, -9999 and -9900 are in use.
const MISSING_BELOW: f64 = -900.0;

/// Least radiation that is no measurement; some programs write 9999 for missing.
pub const MISSING_RADIATION: f64 = 9999.0;

/// Words for a missing number.
const MISSING: [&str; 11] = ["", "nan", "na", "n/a", "null", "none", "-", "--", "---", "*", "missing"];

/// Number of characters of a cell that a message shows.
pub const SHOWN: usize = 60;

/// Style of the numbers of a file, and its code for a missing value.
#[derive(Clone, Copy, Debug, Default)]
pub struct NumberStyle {
    /// True if 1,5 is one and a half.
    pub decimal_comma: bool,
    /// Code that the file states for a missing value.
    pub no_data: Option<f64>,
}

/// Cells of a row of a file.
pub struct Cells<'a> {
    pub path: &'a Path,
    pub line: usize,
    pub record: &'a ByteRecord,
    pub style: NumberStyle,
}

/// Returns a cell as text; empty beyond the end.
pub fn cell(record: &ByteRecord, place: usize) -> Cow<'_, str> {
    String::from_utf8_lossy(record.get(place).unwrap_or_default())
}

/// Returns true if a cell is a word for a missing value.
pub fn is_missing(text: &str) -> bool {
    MISSING.iter().any(|word| text.eq_ignore_ascii_case(word))
}

impl Cells<'_> {
    pub fn text(&self, place: usize) -> Cow<'_, str> {
        cell(self.record, place)
    }

    /// Returns an error about a cell in the column of this name.
    pub fn bad(&self, place: usize, name: &str, hint: &'static str) -> Error {
        let (name, text) = (excerpt(name, SHOWN), self.text(place));
        Error::input(self.path, self.line, format!("column `{name}` holds `{}`", excerpt(&text, SHOWN)), hint)
            .because(Problem::value(name, text))
    }

    fn parse(&self, text: &str) -> Option<f64> {
        if self.style.decimal_comma && text.matches(',').count() == 1 && !text.contains('.') {
            return text.replace(',', ".").parse().ok();
        }
        text.parse().ok()
    }

    /// Returns GHI, DNI or DHI in the column's own unit; `None` where missing.
    pub fn light(&self, place: usize, name: &str, in_watts: bool) -> Result<Option<f64>> {
        let text = self.text(place);
        if is_missing(&text) {
            return Ok(None);
        }
        let Some(value) = self.parse(&text).filter(|value| value.is_finite()) else {
            let hint = "write W/m2 from 0 up, with a decimal point; leave the cell empty where missing";
            return Err(self.bad(place, name, hint));
        };
        let codes = MISSING_99.contains(&value)
            || in_watts && (value <= MISSING_BELOW || value >= MISSING_RADIATION)
            || !in_watts && is_code(&text);
        Ok((!codes && Some(value) != self.style.no_data).then_some(value))
    }

    /// Returns any other number; `None` where it is missing or no number.
    pub fn number(&self, place: usize) -> Option<f64> {
        self.parse(&self.text(place)).filter(|value| Some(*value) != self.style.no_data)
    }
}

/// Returns true for -999, 9999 and similar codes, which mean a missing value in every unit.
pub fn is_code(text: &str) -> bool {
    let digits = text.trim_start_matches('-');
    let whole = digits.split('.').next().unwrap_or_default();
    whole.len() >= 3 && whole.bytes().all(|byte| byte == b'9') && (text.starts_with('-') || whole.len() >= 4)
        || text.starts_with("-9900")
}
