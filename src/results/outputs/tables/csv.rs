//! Tables as CSV (RFC 4180, LF line ends). All quoting of cells happens here. A metadata file
//! beside the table describes its columns (see [`crate::outputs::tables::csvw`]); on standard
//! output there is none.
//!
//! Rows are formatted in parallel, some places at a time; cells that all places share are formatted
//! once.

use std::io::Write;
use std::ops::Range;
use std::sync::Arc;

use blake3::Hasher;
use rayon::prelude::*;

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::column::{Along, BinValues, Column, Digits, Kind, TableColumns};
use crate::outputs::tables::csvw;
use crate::outputs::tables::writer::{FormatWriter, TableRequest, failed};
use heliotile_core::error::Result;

/// Rows of a task, unless a single place has more of them. `TASKS_AT_ONCE` is the number of tasks
/// between two writes. Both limit the memory of text to a few 10 MB.
const ROWS_OF_TASK: usize = 1024;
const TASKS_AT_ONCE: usize = 16;

/// CSV table being written.
pub struct CsvTable {
    sink: Sink,
    columns: Arc<TableColumns>,
    /// `[column][step]`: formatted cells of columns along steps; empty for other columns.
    of_bins: Vec<Vec<String>>,
    /// `[task]`: buffers of text, which are reused.
    texts: Vec<Vec<u8>>,
    about: Option<Provenance>,
    /// Hash of the bytes written so far.
    hasher: Hasher,
}

/// Column of a batch, or neighbouring columns with one number format.
enum BatchColumn<'a> {
    /// Cells by `[step]`, for all places.
    Steps(&'a [String]),
    /// Names by `[place]`.
    Names(&'a [String]),
    /// Values of neighbouring columns, `[column][place][step]`.
    Floats(Vec<&'a [f32]>, Digits),
    Rows(&'a Values<'a>, Digits),
}

/// Cells of a place in a column, or in neighbouring columns with one number format.
enum PlaceCells<'a> {
    /// Formatted cells, `[step]`.
    Steps(&'a [String]),
    /// Formatted text that stands in all rows.
    Name(String),
    /// Values by `[column][step]`, and the function that formats a number.
    Floats(Vec<&'a [f32]>, fn(&mut Vec<u8>, f64)),
    /// Values of all rows, and the index of the place's first row.
    Rows(&'a Values<'a>, usize, Digits),
}

impl CsvTable {
    pub fn new(mut sink: Sink, request: &TableRequest) -> Result<Self> {
        let columns = Arc::clone(&request.columns);
        let names: Vec<&str> = columns.all().iter().map(|column| column.name.as_str()).collect();
        let header = names.join(",") + "\n";
        sink.write_all(header.as_bytes()).map_err(|error| failed(sink.path(), error))?;
        let of_bins = columns.all().iter().map(cells_of_bins).collect();
        let texts = vec![Vec::new(); TASKS_AT_ONCE];
        let mut hasher = Hasher::new();
        hasher.update(header.as_bytes());
        Ok(CsvTable { sink, columns, of_bins, texts, about: request.about.cloned(), hasher })
    }

    /// Returns the columns of a batch.
    fn columns_of<'a>(&'a self, batch: &'a Batch) -> Vec<BatchColumn<'a>> {
        let mut values = batch.values.iter();
        let mut columns = Vec::with_capacity(self.columns.all().len());
        for (column, of_bins) in self.columns.all().iter().zip(&self.of_bins) {
            if column.is_of_bins() {
                columns.push(BatchColumn::Steps(of_bins));
                continue;
            }
            let Some(values) = values.next() else { continue };
            match (columns.last_mut(), BatchColumn::new(column, values)) {
                (Some(BatchColumn::Floats(all, before)), BatchColumn::Floats(one, digits)) if *before == digits => {
                    all.extend(one);
                }
                (_, other) => columns.push(other),
            }
        }
        columns
    }

    /// Formats the rows of some places into a buffer.
    fn put(&self, text: &mut Vec<u8>, columns: &[BatchColumn], places: &Range<usize>) {
        let steps = self.columns.rows_of_place();
        for place in places.clone() {
            let columns: Vec<PlaceCells> = columns.iter().map(|column| column.at(place, steps)).collect();
            for step in 0..steps {
                columns.iter().for_each(|cells| cells.push(text, step));
                // The line end replaces the last comma.
                text.pop();
                text.push(b'\n');
            }
        }
    }
}

impl<'a> BatchColumn<'a> {
    /// Returns the values of a column that is not along steps.
    fn new(column: &Column, values: &'a Values) -> Self {
        match (values, digits_of(column.kind)) {
            (Values::Texts(names), _) if column.along == Along::Places => BatchColumn::Names(names),
            (Values::Floats(floats), digits @ (Digits::Thousandths | Digits::Six)) => {
                BatchColumn::Floats(vec![floats], digits)
            }
            (values, digits) => BatchColumn::Rows(values, digits),
        }
    }

    /// Returns the cells of a place.
    fn at(&self, place: usize, steps: usize) -> PlaceCells<'a> {
        let first = place * steps;
        match self {
            BatchColumn::Steps(cells) => PlaceCells::Steps(cells),
            BatchColumn::Names(names) => {
                PlaceCells::Name(names.get(place).map(|name| quoted(name)).unwrap_or_default())
            }
            BatchColumn::Floats(columns, digits) => {
                let write = if *digits == Digits::Six { six_digits } else { three_decimals };
                let of_place = |floats: &&'a [f32]| floats.get(first..first + steps).unwrap_or_default();
                PlaceCells::Floats(columns.iter().map(of_place).collect(), write)
            }
            BatchColumn::Rows(values, digits) => PlaceCells::Rows(values, first, *digits),
        }
    }
}

impl PlaceCells<'_> {
    /// Writes the cells of a step, each followed by a comma.
    fn push(&self, text: &mut Vec<u8>, step: usize) {
        match self {
            PlaceCells::Steps(cells) => push_text(text, cells.get(step)),
            PlaceCells::Name(name) => text.extend_from_slice(name.as_bytes()),
            PlaceCells::Floats(columns, write) => {
                for (i, floats) in columns.iter().enumerate() {
                    if i > 0 {
                        text.push(b',');
                    }
                    write(text, f64::from(floats.get(step).copied().unwrap_or_default()));
                }
            }
            PlaceCells::Rows(values, first, digits) => push_value(text, values, first + step, *digits),
        }
        text.push(b',');
    }
}

impl FormatWriter for CsvTable {
    fn write(&mut self, batch: &Batch) -> Result<()> {
        let places_of_task = (ROWS_OF_TASK / self.columns.rows_of_place().max(1)).max(1);
        let tasks: Vec<Range<usize>> = (0..batch.places)
            .step_by(places_of_task)
            .map(|first| first..(first + places_of_task).min(batch.places))
            .collect();
        let mut texts = std::mem::take(&mut self.texts);
        for tasks in tasks.chunks(TASKS_AT_ONCE) {
            let columns = self.columns_of(batch);
            tasks.par_iter().zip(&mut texts).for_each(|(places, text)| {
                text.clear();
                self.put(text, &columns, places);
            });
            for text in texts.iter().take(tasks.len()) {
                self.hasher.update(text);
                self.sink.write_all(text).map_err(|error| failed(self.sink.path(), error))?;
            }
        }
        self.texts = texts;
        Ok(())
    }

    fn is_closed(&self) -> bool {
        self.sink.is_closed()
    }

    fn finish(self: Box<Self>) -> Result<u64> {
        // The table is completed last: if it exists, so does its metadata file.
        let beside = match (self.sink.file_path(), &self.about) {
            (Some(path), Some(about)) => csvw::write(path, self.columns.all(), about, self.hasher.finalize())?,
            _ => 0,
        };
        Ok(beside + self.sink.finish()?)
    }
}

/// Returns the formatted cells of a column along steps; empty for other columns.
fn cells_of_bins(column: &Column) -> Vec<String> {
    match &column.along {
        Along::Bins(BinValues::Labels(labels)) => labels.text.iter().map(|label| quoted(label)).collect(),
        Along::Bins(BinValues::Numbers(numbers)) => {
            let cell = |number: &f64| {
                let mut text = Vec::new();
                push_number(&mut text, *number, digits_of(column.kind));
                String::from_utf8_lossy(&text).into_owned()
            };
            numbers.iter().map(cell).collect()
        }
        Along::Rows | Along::Places => Vec::new(),
    }
}

/// Returns the digits of the numbers of a kind.
fn digits_of(kind: Kind) -> Digits {
    match kind {
        Kind::Number(digits) | Kind::Float(digits) => digits,
        Kind::Text | Kind::Category | Kind::Count => Digits::Fewest,
    }
}

fn push_text(text: &mut Vec<u8>, cell: Option<&String>) {
    text.extend_from_slice(cell.map_or(&[][..], |cell| cell.as_bytes()));
}

/// Writes the cell of a row.
fn push_value(text: &mut Vec<u8>, values: &Values, row: usize, digits: Digits) {
    match values {
        Values::Floats(floats) => {
            floats.get(row).iter().for_each(|value| push_number(text, f64::from(**value), digits));
        }
        Values::Numbers(numbers) => {
            numbers.get(row).copied().flatten().iter().for_each(|value| push_number(text, *value, digits));
        }
        // Writing into memory cannot fail.
        Values::Counts(counts) => drop(counts.get(row).map(|count| write!(text, "{count}"))),
        Values::Texts(texts) => push_text(text, texts.get(row).map(|cell| quoted(cell)).as_ref()),
    }
}

fn push_number(text: &mut Vec<u8>, value: f64, digits: Digits) {
    match digits {
        Digits::Thousandths => three_decimals(text, value),
        Digits::Six => six_digits(text, value),
        // Writing into memory cannot fail.
        Digits::Decimals(count) => drop(write!(text, "{value:.count$}")),
        Digits::Fewest => drop(write!(text, "{value}")),
    }
}

/// Returns a cell, quoted if it contains a comma, a quote or a line end.
pub fn quoted(cell: &str) -> String {
    if cell.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_string() }
}

/// Writes a number with three decimals.
fn three_decimals(text: &mut Vec<u8>, value: f64) {
    if value == 0.0 {
        text.push(b'0');
        return;
    }
    let thousandths = (value * 1000.0).round();
    // Values beyond 2^53 thousandths and NaN are rare, so they may take the slow way.
    if thousandths.is_nan() || thousandths.abs() >= 9e15 {
        // Writing into memory cannot fail.
        let _ = write!(text, "{value:.3}");
        return;
    }
    if thousandths < 0.0 {
        text.push(b'-');
    }
    let mut rest = thousandths.abs() as u64;
    let mut digits = [b'0'; 24];
    let mut count = 0;
    for digit in digits.iter_mut() {
        if count == 3 {
            *digit = b'.';
        } else {
            if rest == 0 && count > 4 {
                break;
            }
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
        count += 1;
    }
    text.extend(digits.iter().take(count).rev());
}

/// Writes a number with six significant digits, in plain notation down to 1e-9.
fn six_digits(text: &mut Vec<u8>, value: f64) {
    if value == 0.0 {
        text.push(b'0');
        return;
    }
    let decimals = Digits::Six.decimals(value).unwrap_or_default();
    let _ = write!(text, "{value:.decimals$}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(number: fn(&mut Vec<u8>, f64), value: f32) -> String {
        let mut text = Vec::new();
        number(&mut text, f64::from(value));
        String::from_utf8(text).expect("ASCII")
    }

    /// For 20,000 values from 1e-6 to 1e6 of both signs, the fast formatting equals Rust's `{:.3}`
    /// of the f64 value, except for ties; special values have their own text.
    #[test]
    fn fast_numbers_equal_those_of_rust() {
        for i in 0..20_000_u32 {
            let value = (1.37 * 10_f64.powf(f64::from(i % 120) / 10.0 - 6.0)) as f32;
            for value in [value, -value, value * i as f32] {
                let expected = format!("{:.3}", f64::from(value));
                let got = written(three_decimals, value);
                let close = (got.parse::<f64>().expect("a number") - f64::from(value)).abs();
                assert!(got == expected || value == 0.0 || close <= 0.000_501, "{got} {expected}");
            }
        }
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1.000"),
            (-12.5, "-12.500"),
            (0.001, "0.001"),
            (999.9996, "1000.000"),
            (1234.5, "1234.500"),
            (f32::NAN, "NaN"),
            (f32::INFINITY, "inf"),
            (1e20, "100000002004087734272.000"),
        ] {
            assert_eq!(written(three_decimals, value), text);
        }
    }

    /// Sums keep six significant digits: 1234.56, 0.123456, 0.000123456.
    #[test]
    fn sums_keep_six_significant_digits() {
        for (value, text) in [
            (1_234.56, "1234.56"),
            (0.123_456, "0.123456"),
            (0.000_123_456, "0.000123456"),
            (12_345_678.0, "12345678"),
            (0.0, "0"),
            (-2.5, "-2.50000"),
            (f32::NAN, "NaN"),
        ] {
            assert_eq!(written(six_digits, value), text);
        }
    }

    /// Names with a comma, a quote or a line end are quoted, others are not: 3 cases.
    #[test]
    fn only_names_that_need_quotes_get_them() {
        assert_eq!(quoted("a b"), "a b");
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("a\"b\n"), "\"a\"\"b\n\"");
    }
}
