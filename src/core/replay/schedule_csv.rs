//! Reader of schedules: one value a line. In: the bytes of a CSV file with a column such as
//! `reflectance`, and the dates of a weather file's rows. Out: a checked value for each row.

use std::path::Path;

use crate::error::{Error, Problem, Result};
use crate::weather::time::calendar::Date;

/// Column that is read, with the range of its values; further columns (a time, a note) are ignored.
#[derive(Clone, Copy, Debug)]
pub struct Column<'n> {
    /// Name of the column in the header.
    pub name: &'n str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Column<'_> {
    /// Returns true if a value is in range; false for NaN.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// Function that returns the bytes of a schedule that a user names: from a disk, or from files
/// given to a page.
pub type ReadFile<'r> = &'r dyn Fn(&Path) -> Result<Vec<u8>>;

/// Rows that a schedule gives values for.
#[derive(Clone, Copy, Debug)]
pub enum Rows<'d> {
    /// Rows of a weather file, by their dates.
    Dated(&'d [Date]),
    /// Number of conditions, which have no dates.
    Conditions(usize),
}

impl Rows<'_> {
    /// Returns the number of rows.
    pub fn count(self) -> usize {
        match self {
            Rows::Dated(dates) => dates.len(),
            Rows::Conditions(count) => count,
        }
    }
}

/// Reads the bytes of a schedule with a value for each row or, where rows have dates, with twelve
/// values, one a month; messages call it `path`.
pub fn parse_schedule(path: &Path, bytes: &[u8], column: Column, rows: Rows) -> Result<Vec<f64>> {
    let values = parse(path, bytes, column)?;
    let found = values.len();
    if found == rows.count() {
        return Ok(values);
    }
    let (of, hint) = match rows {
        Rows::Dated(dates) if found == 12 => {
            return Ok(dates.iter().filter_map(|date| values.get(date.month as usize - 1).copied()).collect());
        }
        Rows::Dated(_) => {
            ("a weather file of", "give a line for each row of the weather file, or 12 lines, one a month")
        }
        Rows::Conditions(_) => ("a table of conditions of", "give a line for each condition, in their order"),
    };
    Err(Error::input(path, None, format!("{found} values for {of} {} rows", rows.count()), hint)
        .because(Problem::OutOfRange { found: found as f64, least: rows.count() as f64, most: rows.count() as f64 }))
}

fn parse(path: &Path, bytes: &[u8], column: Column) -> Result<Vec<f64>> {
    let Column { name, low, high } = column;
    let value = |(line, text): (usize, String)| {
        text.parse::<f64>().ok().filter(|value| column.holds(*value)).ok_or_else(|| {
            let what = format!("column `{name}` holds `{text}`");
            Error::input(path, line, what, format!("write a number from {low} to {high}"))
                .because(Problem::value(name, &text))
        })
    };
    column_texts(path, bytes, name)?.into_iter().map(value).collect()
}

/// Returns the names of the columns of a table; messages call it `path`.
pub fn column_names(path: &Path, bytes: &[u8]) -> Result<Vec<String>> {
    let mut table = reader(bytes);
    let header = table.headers().map_err(|error| broken(path, &error))?;
    Ok(header.iter().map(str::to_owned).collect())
}

/// Returns the texts of a column with their lines, from 1.
pub fn column_texts(path: &Path, bytes: &[u8], name: &str) -> Result<Vec<(usize, String)>> {
    let Some(place) = column_names(path, bytes)?.iter().position(|cell| cell == name) else {
        let what = format!("column `{name}` is missing from the header");
        let hint = format!("name the column of the values `{name}`");
        return Err(Error::input(path, 1, what, hint).because(Problem::no_column(name)));
    };
    let text = |record: csv::Result<csv::StringRecord>| {
        let record = record.map_err(|error| broken(path, &error))?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        Ok((line, record.get(place).unwrap_or_default().to_owned()))
    };
    reader(bytes).into_records().map(text).collect()
}

fn reader(bytes: &[u8]) -> csv::Reader<&[u8]> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(bytes)
}

fn broken(path: &Path, error: &csv::Error) -> Error {
    let line = error.position().map(|p| p.line() as usize);
    Error::input(path, line, error.to_string(), "save the file as CSV in UTF-8")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve values follow the months of 3 rows, and as many values as rows are taken in order.
    /// Seven broken files are errors that name the line or the two numbers.
    #[test]
    fn twelve_values_follow_the_months() {
        let dates = [(1, 31), (2, 1), (12, 5)].map(|(month, day)| Date::new(2021, month, day).expect("a date"));
        let column = Column { name: "reflectance", low: 0.0, high: 1.0 };
        let read = |text: &str| parse_schedule(Path::new("s.csv"), text.as_bytes(), column, Rows::Dated(&dates));
        let months: String = (1..=12).map(|m| format!("{m},0.{m:02}\n")).collect();
        assert_eq!(read(&format!("month, reflectance\r\n{months}")).expect("months"), [0.01, 0.02, 0.12]);
        assert_eq!(read("\u{feff}reflectance\n0\n1\n0.5\n").expect("rows"), [0.0, 1.0, 0.5]);
        let of_query =
            |count| parse_schedule(Path::new("s.csv"), b"reflectance\n0\n1\n", column, Rows::Conditions(count));
        assert_eq!(of_query(2).expect("rows"), [0.0, 1.0]);
        assert!(
            of_query(12).expect_err("too few").to_string().contains("2 values for a table of conditions of 12 rows")
        );
        for (text, expected) in [
            ("", "column `reflectance` is missing"),
            ("albedo\n1\n1\n1\n", "column `reflectance` is missing"),
            ("reflectance\n0\n1\n", "2 values for a weather file of 3 rows"),
            ("reflectance\n0\n1.1\n0\n", "line 3: column `reflectance` holds `1.1`"),
            ("reflectance\n0\nNaN\n0\n", "line 3: column `reflectance` holds `NaN`"),
            ("reflectance\n0\n-0.1\n0\n", "holds `-0.1`"),
            ("a,reflectance\n0\n", "line 2: column `reflectance` holds ``"),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
