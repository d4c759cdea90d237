//! Rows of a CSV file. In: the file, piece by piece. Out: its records with the line that each
//! begins in, and errors that name file, line and column.

use std::io::{self, Read};
use std::path::Path;

use csv::{ErrorKind, ReaderBuilder, StringRecord, Trim};

use crate::input;
use crate::text::{excerpt, without_byte_order_mark};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::Message;

/// Longest row that is read, bytes, including blank lines before it.
const MAX_ROW: usize = 16 << 20;

/// Reader of records with true line numbers: the library counts blank lines to the record after
/// them.
pub struct CsvRows<'a> {
    /// File.
    pub file: &'a Path,
    reader: csv::Reader<Ahead<'a>>,
    /// Present record.
    pub record: StringRecord,
    /// Line of `record`, from 1.
    pub line: usize,
}

impl<'a> CsvRows<'a> {
    /// Opens a file.
    pub fn open(file: &'a Path) -> Result<Self> {
        CsvRows::new(input::open(file)?, file)
    }

    /// Reads rows from a stream; errors name `file`.
    pub fn new(input: Box<dyn Read + 'a>, file: &'a Path) -> Result<Self> {
        CsvRows::delimited(input, file, b',')
    }

    /// Reads rows whose cells a byte delimits.
    pub fn delimited(mut input: Box<dyn Read + 'a>, file: &'a Path, delimiter: u8) -> Result<Self> {
        let mut start = Vec::new();
        input.by_ref().take(3).read_to_end(&mut start).map_err(Error::io(file, "read"))?;
        let start = io::Cursor::new(without_byte_order_mark(&start).to_vec());
        let ahead = Ahead { input: Box::new(start.chain(input)), kept: Vec::new(), done: 0, offset: 0 };
        let reader = ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .buffer_capacity(64 << 10)
            .from_reader(ahead);
        Ok(CsvRows { file, reader, record: StringRecord::new(), line: 1 })
    }

    /// Reads the next record; false at the end.
    pub fn advance(&mut self) -> Result<bool> {
        let start = self.reader.position().byte();
        let result = self.reader.read_record(&mut self.record);
        // Lines are counted after the read: blank lines in front of the record may not have been
        // read before.
        self.line += self.reader.get_mut().count_lines_to(start);
        result.map_err(|error| match error.into_kind() {
            ErrorKind::Io(source) if source.kind() == io::ErrorKind::FileTooLarge => {
                let what = format!("the row is longer than {} MiB", MAX_ROW >> 20);
                self.error(what, "close the quote that opens in it, or split it")
            }
            ErrorKind::Io(source) => Error::io(self.file, "read")(source),
            _ => self.error("the row is not UTF-8 text", "save the file as comma-separated UTF-8 text"),
        })
    }

    /// Returns the text of a cell; empty if the row has none there.
    pub fn cell(&self, place: usize) -> &str {
        self.record.get(place).unwrap_or_default()
    }

    /// Returns an error of the present row.
    pub fn error(&self, what: impl Into<Message>, hint: impl Into<Message>) -> Error {
        Error::input(self.file, self.line, what, hint)
    }

    /// Returns an error of a cell of the present row.
    pub fn cell_error(&self, column: &str, text: &str, why: &str, hint: impl Into<Message>) -> Error {
        cell_error(self.file, self.line, column, text, why, hint)
    }
}

/// Returns the error for one cell.
pub fn cell_error(file: &Path, line: usize, column: &str, text: &str, why: &str, hint: impl Into<Message>) -> Error {
    Error::input(file, line, format!("column `{column}` is `{}`, {why}", excerpt(text.as_bytes())), hint)
        .because(Problem::value(column, text))
}

/// Reader that keeps the bytes it returned until their lines are counted.
struct Ahead<'a> {
    input: Box<dyn Read + 'a>,
    kept: Vec<u8>,
    /// Number of bytes of `kept` whose lines are counted.
    done: usize,
    /// Offset of `kept` in the file.
    offset: u64,
}

impl Ahead<'_> {
    /// Counts the lines up to `start` and over the blank lines that follow it.
    fn count_lines_to(&mut self, start: u64) -> usize {
        let start = usize::try_from(start.saturating_sub(self.offset)).unwrap_or(usize::MAX);
        let mut lines = 0;
        let mut rest = self.kept.get(self.done..).unwrap_or_default();
        while let [byte, after @ ..] = rest
            && (self.done < start || matches!(byte, b'\n' | b'\r'))
        {
            let ends_line = *byte == b'\n' || (*byte == b'\r' && after.first() != Some(&b'\n'));
            lines += usize::from(ends_line);
            self.done += 1;
            rest = after;
        }
        lines
    }
}

impl Read for Ahead<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.kept.drain(..self.done);
        self.offset += std::mem::take(&mut self.done) as u64;
        if self.kept.len() > MAX_ROW {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        let count = self.input.read(buffer)?;
        self.kept.extend_from_slice(buffer.get(..count).unwrap_or_default());
        Ok(count)
    }
}
