//! In: the bytes of a CSV file. Out: its records with the line each begins in, and errors that name file, line and column.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::text::excerpt;
use crate::error::{Error, Result};

/// Records one after the other, with true line numbers: the library's count blank lines to the record after them.
pub(super) struct Rows<'a> {
    bytes: &'a [u8],
    pub(super) file: &'a Path,
    reader: csv::Reader<&'a [u8]>,
    pub(super) record: StringRecord,
    /// 1-based line of `record`.
    pub(super) line: usize,
    /// Line ends before this offset are in `line`.
    counted: usize,
}

impl<'a> Rows<'a> {
    pub(super) fn new(bytes: &'a [u8], file: &'a Path) -> Self {
        let reader = ReaderBuilder::new().has_headers(false).flexible(true).trim(Trim::All).from_reader(bytes);
        Rows { bytes, file, reader, record: StringRecord::new(), line: 1, counted: 0 }
    }

    pub(super) fn advance(&mut self) -> Result<bool> {
        self.count_lines_to(self.reader.position().byte());
        self.reader.read_record(&mut self.record).map_err(|_| {
            let hint = "save the file as comma-separated UTF-8 text";
            Error::input(self.file, self.line, "the row is not UTF-8 text", hint)
        })
    }

    /// Counts up to `start` and over the blank lines that follow it.
    fn count_lines_to(&mut self, start: u64) {
        let start = usize::try_from(start).unwrap_or(usize::MAX);
        let mut rest = self.bytes.get(self.counted..).unwrap_or_default();
        while let [byte, after @ ..] = rest
            && (self.counted < start || matches!(byte, b'\n' | b'\r'))
        {
            let ends_line = *byte == b'\n' || (*byte == b'\r' && after.first() != Some(&b'\n'));
            self.line += usize::from(ends_line);
            self.counted += 1;
            rest = after;
        }
    }

    pub(super) fn error(&self, what: impl Into<String>, hint: impl Into<String>) -> Error {
        Error::input(self.file, self.line, what, hint)
    }

    pub(super) fn cell_error(&self, column: &str, text: &str, why: &str, hint: &str) -> Error {
        self.error(format!("column `{column}` is `{}`, {why}", excerpt(text.as_bytes())), hint)
    }
}
