//! Tables as CSV (RFC 4180, LF line ends). W/m2 with three decimals, kWh/m2 with six significant digits, exact zeros as `0`. What the
//! columns are stands beside a file (see [`crate::outputs::tables::csvw`]), not beside the standard output.

use std::io::Write;

use rayon::prelude::*;

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::csvw::{self, CsvColumn};
use crate::outputs::tables::layout::{Labels, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::table::Table;
use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::{Error, Result};

/// Receivers formatted before a write: bounds the memory of a tile's text to a few 10 MB.
const RECEIVERS_AT_ONCE: usize = 16;

/// A CSV table being written.
pub struct CsvTable {
    sink: Sink,
    /// Quoted where needed.
    labels: Vec<String>,
    /// So many columns are components, those behind them facts of groups.
    components: usize,
    number: fn(&mut Vec<u8>, f32),
    columns: Vec<CsvColumn>,
    provenance: Provenance,
}

impl CsvTable {
    pub fn new(mut sink: Sink, layout: &Layout, labels: &RowLabels, provenance: &Provenance) -> Result<Self> {
        let header = layout.names().join(",") + "\n";
        if let Err(error) = sink.write_all(header.as_bytes()) {
            return Err(Error::io(sink.path(), "write to")(error));
        }
        Ok(CsvTable {
            sink,
            labels: labels.text.iter().map(|l| quoted(l)).collect(),
            components: layout.components().len(),
            number: match layout.labels {
                Labels::Sums => six_digits,
                Labels::Conditions | Labels::Times => three_decimals,
            },
            columns: CsvColumn::of_results(layout, labels),
            provenance: provenance.clone(),
        })
    }

    fn rows_of(&self, name: &str, receiver: usize, values: &TileColumns) -> Vec<u8> {
        let columns = values.rows(receiver);
        let mut text = Vec::with_capacity(self.labels.len() * (name.len() + 64));
        for (i, label) in self.labels.iter().enumerate() {
            text.extend_from_slice(label.as_bytes());
            text.push(b',');
            text.extend_from_slice(name.as_bytes());
            for (place, column) in columns.iter().enumerate() {
                text.push(b',');
                let number = if place < self.components { self.number } else { six_digits };
                number(&mut text, column.get(i).copied().unwrap_or(0.0));
            }
            text.push(b'\n');
        }
        text
    }
}

impl Table for CsvTable {
    fn write_tile(&mut self, receivers: &[String], values: &TileColumns) -> Result<()> {
        for (chunk, names) in receivers.chunks(RECEIVERS_AT_ONCE).enumerate() {
            let texts: Vec<Vec<u8>> = names
                .par_iter()
                .enumerate()
                .map(|(i, name)| self.rows_of(&quoted(name), chunk * RECEIVERS_AT_ONCE + i, values))
                .collect();
            for text in texts {
                if let Err(error) = self.sink.write_all(&text) {
                    return Err(Error::io(self.sink.path(), "write to")(error));
                }
            }
        }
        Ok(())
    }

    fn is_closed(&self) -> bool {
        self.sink.is_closed()
    }

    fn finish(self: Box<Self>) -> Result<u64> {
        // The table last: where it is, so is what is said of it.
        let beside = match self.sink.file_path() {
            Some(path) => csvw::write(path, &self.columns, &self.provenance)?,
            None => 0,
        };
        Ok(beside + self.sink.finish()?)
    }
}

/// A cell, quoted if it holds a comma, a quote or a line end.
pub fn quoted(cell: &str) -> String {
    if cell.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_string() }
}

/// Fixed three decimals.
fn three_decimals(text: &mut Vec<u8>, value: f32) {
    if value == 0.0 {
        text.push(b'0');
        return;
    }
    let thousandths = (f64::from(value) * 1000.0).round();
    // Beyond 2^53 thousandths, or not a number: rare, so the slow way.
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

/// Six significant digits, in plain notation down to 1e-9.
fn six_digits(text: &mut Vec<u8>, value: f32) {
    if value == 0.0 {
        text.push(b'0');
        return;
    }
    let magnitude = f64::from(value).abs().log10().floor();
    let decimals = (5.0 - magnitude).clamp(0.0, 14.0) as usize;
    let _ = write!(text, "{value:.decimals$}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(number: fn(&mut Vec<u8>, f32), value: f32) -> String {
        let mut text = Vec::new();
        number(&mut text, value);
        String::from_utf8(text).expect("ASCII")
    }

    /// The fast formatting equals Rust's own `{:.3}` of the f64 value, ties aside, for 20,000 values from 1e-6 to 1e6 of both
    /// signs, and special values have their own text.
    #[test]
    fn fast_numbers() {
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
    fn significant_digits() {
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
    fn quoting() {
        assert_eq!(quoted("a b"), "a b");
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("a\"b\n"), "\"a\"\"b\n\"");
    }
}
