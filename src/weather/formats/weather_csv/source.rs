//! Rows of a table. In: the bytes below its names, or records. Out: one record after the other,
//! each with its line.

use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};

use heliotile_core::error::{Error, Result};

/// Source of rows.
pub enum RowSource<'b> {
    /// Text with `above` lines above it; a blank as delimiter stands for any number of blanks.
    Text { bytes: &'b [u8], delimiter: u8, above: usize },
    /// Rows that do not come from text; their line is their number.
    Records(Vec<ByteRecord>),
}

/// Function that takes a row with its line; false ends the rows.
pub type TakeRow<'t> = &'t mut dyn FnMut(usize, &ByteRecord) -> Result<bool>;

impl RowSource<'_> {
    /// Calls `take` with each row, until it returns false.
    pub fn for_each(&self, path: &Path, take: TakeRow) -> Result<()> {
        match self {
            RowSource::Records(records) => {
                for (record, line) in records.iter().zip(1..) {
                    if !take(line, record)? {
                        break;
                    }
                }
                Ok(())
            }
            RowSource::Text { bytes, delimiter: b' ', above } => {
                for (line, number) in bytes.split(|byte| *byte == b'\n').zip(above + 1..) {
                    let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
                    let record = ByteRecord::from_iter(words);
                    if !record.is_empty() && !take(number, &record)? {
                        break;
                    }
                }
                Ok(())
            }
            RowSource::Text { bytes, delimiter, above } => {
                let mut reader = ReaderBuilder::new()
                    .has_headers(false)
                    .flexible(true)
                    .trim(Trim::All)
                    .delimiter(*delimiter)
                    .from_reader(*bytes);
                let mut record = ByteRecord::new();
                loop {
                    let more = reader.read_byte_record(&mut record).map_err(|error| {
                        let line = error.position().map(|at| at.line() as usize + above);
                        Error::input(path, line, error.to_string(), "save the file as CSV")
                    })?;
                    let line = record.position().map_or(0, |at| at.line() as usize) + above;
                    if !more || !take(line, &record)? {
                        return Ok(());
                    }
                }
            }
        }
    }
}
