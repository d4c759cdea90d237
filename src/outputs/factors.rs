//! Factors over positions of the sun as a table. In: factors of receivers or surfaces, one after the other. Out: CSV or Parquet, a row for
//! each sun.

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float32Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Metadata, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;

use super::provenance::Provenance;
use super::sink::Sink;
use crate::outputs::tables::csvw::{self, CsvColumn};
use crate::outputs::tables::quoted;
use crate::outputs::tables::records::is_parquet;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::factors::{FACTORS, SunGrid};

/// What errors call the file.
const FILE: &str = "the file of factors";

/// Columns before the factors and behind the name.
const SUN: [&str; 2] = ["sun_azimuth_deg", "sun_altitude_deg"];

/// A table being written.
pub struct FactorTable {
    out: Out,
    /// Azimuth and altitude of each row of a name.
    suns: Vec<(f64, f64)>,
    path: std::path::PathBuf,
}

enum Out {
    Csv(Sink),
    Parquet(Box<ArrowWriter<Sink>>, Arc<Schema>),
}

impl FactorTable {
    /// Whether a table of this name can be written; `-` is CSV on the standard output.
    pub fn check(path: &Path) -> Result<()> {
        is_parquet(path, FILE).map(drop)
    }

    /// Rows are named by a column `place`: `receiver`, `surface` and the like.
    pub fn create(path: &Path, place: &str, grid: &SunGrid, about: &Provenance) -> Result<Self> {
        let (suns, parquet) = (grid.suns().collect(), is_parquet(path, FILE)?);
        let names: Vec<&str> = std::iter::once(place).chain(SUN).chain(FACTORS).collect();
        let mut sink = if path == Path::new("-") { Sink::stdout() } else { Sink::file(path)? };
        let out = if parquet {
            let fields = names.iter().enumerate().map(|(i, name)| {
                let (kind, unit) = match i {
                    0 => return Field::new(*name, DataType::Utf8, false),
                    1 | 2 => (DataType::Float32, "deg"),
                    _ => (DataType::Float32, "1"),
                };
                let unit = Metadata::from([("unit".to_string(), unit.to_string())]);
                Field::new(*name, kind, false).with_metadata(unit)
            });
            let about = about.entries().into_iter().collect::<Metadata>();
            let schema = Arc::new(Schema::new_with_metadata(fields.collect::<Vec<_>>(), about));
            let packed = Compression::ZSTD(ZstdLevel::default());
            let properties = WriterProperties::builder().set_compression(packed).build();
            let writer = ArrowWriter::try_new(sink, schema.clone(), Some(properties));
            Out::Parquet(Box::new(writer.map_err(|e| failed(path, e))?), schema)
        } else {
            if sink.file_path().is_some() {
                let columns = |name: &&str| match *name {
                    name if name == place => CsvColumn::text(name),
                    name => CsvColumn::number(name),
                };
                csvw::write(path, &names.iter().map(columns).collect::<Vec<_>>(), about)?;
            }
            writeln!(sink, "{}", names.join(",")).map_err(Error::io(path, "write to"))?;
            Out::Csv(sink)
        };
        Ok(FactorTable { out, suns, path: path.to_owned() })
    }

    /// Appends the factors of a receiver or surface: one row for each sun.
    pub fn write(&mut self, name: &str, factors: impl Iterator<Item = [f64; 5]>) -> Result<()> {
        let rows: Vec<[f64; 5]> = factors.collect();
        match &mut self.out {
            Out::Csv(sink) => {
                let name = quoted(name);
                let mut text = String::new();
                for ((azimuth, altitude), [a, b, c, d, e]) in self.suns.iter().zip(rows) {
                    text += &format!("{name},{azimuth},{altitude},{a:.6},{b:.6},{c:.6},{d:.6},{e:.6}\n");
                }
                sink.write_all(text.as_bytes()).map_err(Error::io(&self.path, "write to"))
            }
            Out::Parquet(writer, schema) => {
                let numbers = |of: &dyn Fn(usize) -> f64| -> ArrayRef {
                    Arc::new(Float32Array::from_iter_values((0..rows.len()).map(|row| of(row) as f32)))
                };
                let names = StringArray::from_iter_values((0..rows.len()).map(|_| name));
                let mut columns: Vec<ArrayRef> = vec![Arc::new(names)];
                columns.push(numbers(&|row| self.suns.get(row).map_or(0.0, |sun| sun.0)));
                columns.push(numbers(&|row| self.suns.get(row).map_or(0.0, |sun| sun.1)));
                columns.extend((0..FACTORS.len()).map(|factor| numbers(&|row| rows[row][factor])));
                let batch = RecordBatch::try_new(schema.clone(), columns);
                let batch = batch.map_err(|e| Error::io(&self.path, "write to")(std::io::Error::other(e)))?;
                writer.write(&batch).map_err(|e| failed(&self.path, e))
            }
        }
    }

    /// Whether nobody reads any more.
    pub fn is_closed(&self) -> bool {
        matches!(&self.out, Out::Csv(sink) if sink.is_closed())
    }

    /// Completes the table; only now does its file appear.
    pub fn finish(self) -> Result<u64> {
        match self.out {
            Out::Csv(sink) => sink.finish(),
            Out::Parquet(writer, _) => writer.into_inner().map_err(|e| failed(&self.path, e))?.finish(),
        }
    }
}

fn failed(path: &Path, error: ParquetError) -> Error {
    match error {
        ParquetError::External(source) => match source.downcast::<std::io::Error>() {
            Ok(source) => Error::io(path, "write to")(*source),
            Err(other) => Error::io(path, "write to")(std::io::Error::other(other)),
        },
        other => Error::io(path, "write to")(std::io::Error::other(other)),
    }
}
