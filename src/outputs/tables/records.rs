//! Tables of records: texts, counts and numbers in named columns, a few thousand rows. In: rows. Out: CSV or Parquet by the ending of the
//! name, whole or not there. Results of receivers, which are many, have [`super::writer`].

use std::io::{self, Write as _};
use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Field, Metadata, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;

use super::csvw::{self, CsvColumn};
use super::quoted;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// A value; all of a column are of one sort.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Text(String),
    Count(u64),
    /// An empty cell where there is none.
    Number(Option<f64>),
}

/// Rows under their columns, whose names end with their units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

impl Records {
    /// Whether a table of this name can be written; `-` is CSV on the standard output.
    pub fn check(path: &Path) -> Result<()> {
        is_parquet(path, RECORDS).map(drop)
    }

    /// Writes the table; gives its size in bytes.
    pub fn write(&self, path: &Path, about: &Provenance) -> Result<u64> {
        match is_parquet(path, RECORDS)? {
            true => self.write_parquet(path, about),
            false => self.write_csv(path, about),
        }
    }

    fn write_csv(&self, path: &Path, about: &Provenance) -> Result<u64> {
        let mut sink = if path == Path::new("-") { Sink::stdout() } else { Sink::file(path)? };
        let mut text = self.columns.join(",") + "\n";
        for row in &self.rows {
            text += &row.iter().map(Cell::csv).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        sink.write_all(text.as_bytes()).map_err(Error::io(path, "write to"))?;
        if sink.file_path().is_some() {
            let columns = self.columns.iter().enumerate().map(|(i, name)| match self.sort(i) {
                Some(Cell::Text(_)) => CsvColumn::text(name),
                _ => CsvColumn::number(name),
            });
            csvw::write(path, &columns.collect::<Vec<_>>(), about)?;
        }
        sink.finish()
    }

    fn write_parquet(&self, path: &Path, about: &Provenance) -> Result<u64> {
        let failed = |error: &dyn std::fmt::Display| Error::io(path, "write to")(io::Error::other(error.to_string()));
        let columns: Vec<(DataType, ArrayRef)> = (0..self.columns.len()).map(|i| self.array(i)).collect();
        let fields = self.columns.iter().zip(&columns).map(|(name, (kind, _))| {
            let unit = csvw::unit_of(name).map(|unit| ("unit".to_owned(), unit.to_owned()));
            Field::new(name, kind.clone(), *kind == DataType::Float64)
                .with_metadata(unit.into_iter().collect::<Metadata>())
        });
        let about = about.entries().into_iter().collect::<Metadata>();
        let schema = Arc::new(Schema::new_with_metadata(fields.collect::<Vec<_>>(), about));
        let arrays = columns.into_iter().map(|(_, array)| array).collect();
        let batch = RecordBatch::try_new(schema.clone(), arrays).map_err(|error| failed(&error))?;
        let packed = Compression::ZSTD(ZstdLevel::default());
        let properties = WriterProperties::builder().set_compression(packed).build();
        let writer = ArrowWriter::try_new(Sink::file(path)?, schema, Some(properties));
        let mut writer = writer.map_err(|error| failed(&error))?;
        writer.write(&batch).map_err(|error| failed(&error))?;
        writer.into_inner().map_err(|error| failed(&error))?.finish()
    }

    /// An example of what a column holds.
    fn sort(&self, column: usize) -> Option<&Cell> {
        self.rows.first().and_then(|row| row.get(column))
    }

    fn array(&self, column: usize) -> (DataType, ArrayRef) {
        let cells = || self.rows.iter().filter_map(|row| row.get(column));
        match self.sort(column) {
            Some(Cell::Text(_)) => {
                let texts = cells().map(|cell| if let Cell::Text(text) = cell { text.as_str() } else { "" });
                (DataType::Utf8, Arc::new(StringArray::from_iter_values(texts)))
            }
            Some(Cell::Count(_)) => {
                let counts = cells().map(|cell| if let Cell::Count(count) = cell { *count } else { 0 });
                (DataType::UInt64, Arc::new(UInt64Array::from_iter_values(counts)))
            }
            _ => {
                let numbers = cells().map(|cell| if let Cell::Number(number) = cell { *number } else { None });
                (DataType::Float64, Arc::new(numbers.collect::<Float64Array>()))
            }
        }
    }
}

impl Cell {
    fn csv(&self) -> String {
        match self {
            Cell::Text(text) => quoted(text),
            Cell::Count(count) => count.to_string(),
            Cell::Number(number) => number.map_or(String::new(), |number| format!("{number:.3}")),
        }
    }
}

/// What errors call such a table.
const RECORDS: &str = "a table of records";

/// Whether a file is Parquet and not CSV, by its ending; `what` it is, for errors.
pub fn is_parquet(path: &Path, what: &str) -> Result<bool> {
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match ending.as_deref() {
        _ if path == Path::new("-") => Ok(false),
        Some("csv") => Ok(false),
        Some("parquet") => Ok(true),
        _ => Err(Error::Unsupported {
            what: format!("ending of {what}"),
            found: format!("`{}`", path.display()),
            supported: ".csv and .parquet (or - for CSV on the standard output)".into(),
        }),
    }
}
