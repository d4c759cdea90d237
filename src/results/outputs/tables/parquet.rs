//! Tables as Parquet: one row group a batch, zstd level 1, times as differences of microseconds of
//! UTC, text as dictionary-encoded strings, numbers with their bytes split. The metadata contain
//! the Arrow schema, from which readers get categories, the zone of the times and the units of
//! fields. They contain the provenance, too.
//!
//! Columns of a batch are encoded in parallel, each into memory, then appended in order. A column
//! along steps is the same in every batch with as many places, so its bytes are kept and appended
//! again.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

use bytes::Bytes;
use parquet::arrow::add_encoded_arrow_schema_to_metadata;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, TimeUnit, Type as PhysicalType, ZstdLevel};
use parquet::column::writer::{ColumnCloseResult, ColumnWriter, get_column_writer};
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedFileWriter, SerializedPageWriter, TrackedWrite};
use parquet::schema::types::{ColumnDescPtr, ColumnPath, Type};
use rayon::prelude::*;

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::arrow;
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::column::{Along, BinValues, Column, Kind, TableColumns};
use crate::outputs::tables::writer::{FormatWriter, TableRequest, failed};
use heliotile_core::error::Result;

type ParquetResult<T> = std::result::Result<T, ParquetError>;

/// Largest size of a dictionary: labels of a year of minutes take 10 MB.
const DICTIONARY_BYTES: usize = 32 << 20;

/// Number of distinct names for which Bloom filters are sized. Names of a tile are neighbours in
/// space, not in the alphabet, so minimum and maximum do not tell readers which tile contains a
/// name; a Bloom filter of 80 bytes does.
const NAMES_OF_TILE: u64 = 64;

/// Number of rows of a place for which the name is handed over at a time.
const NAMES_AT_ONCE: usize = 512;

/// Rows of a data page. Readers skip by page, so pages must not be too large; each has a header, so
/// not too small. `PAGE_BYTES` is the limit of bytes.
const PAGE_ROWS: usize = 1 << 17;
const PAGE_BYTES: usize = 1 << 20;

/// Encoding of numbers. Splitting the bytes of floats costs 0.2 s for 4.5 million rows over plain
/// values and saves 10 to 70 % of the file; dictionaries of floats are slower and larger. Measured
/// in `writer_tests::a_year_takes_less_than_14_bytes_a_row`.
const NUMBER_ENCODING: Encoding = Encoding::BYTE_STREAM_SPLIT;

/// Encoding of times: equal steps take next to nothing as differences.
const TIME_ENCODING: Encoding = Encoding::DELTA_BINARY_PACKED;

/// Definition level of a number that is present, in a column with missing numbers.
const PRESENT: i16 = 1;

/// Encoded column of a batch, ready to be appended.
#[derive(Clone)]
struct Chunk {
    bytes: Bytes,
    close: ColumnCloseResult,
}

/// Values in the types of a column writer.
enum Part<'v> {
    Texts(Vec<ByteArray>),
    /// Counts, or microseconds since 1970-01-01 00:00 UTC.
    Whole(Vec<i64>),
    Floats(Cow<'v, [f32]>),
    /// Numbers that are present, and the definition level of each row.
    Doubles {
        values: Vec<f64>,
        present: Vec<i16>,
    },
}

/// Column of the file.
struct FileColumn {
    descriptor: ColumnDescPtr,
    /// Values of a place, if the column is along steps.
    of_steps: Option<Part<'static>>,
    /// Last encoding, and its number of places, if the column is along steps.
    encoded: Option<(usize, Chunk)>,
}

/// Parquet table being written.
pub struct ParquetTable {
    writer: SerializedFileWriter<Sink>,
    columns: Arc<TableColumns>,
    file_columns: Vec<FileColumn>,
    properties: WriterPropertiesPtr,
    path: PathBuf,
}

impl ParquetTable {
    pub fn new(sink: Sink, request: &TableRequest) -> Result<Self> {
        let path = sink.path().to_path_buf();
        let columns = Arc::clone(&request.columns);
        let about = request.about.cloned().unwrap_or_default();
        let (schema, properties) = schema(&columns, &about).map_err(|error| failed(&path, error))?;
        let properties = Arc::new(properties);
        let writer = SerializedFileWriter::new(sink, schema, properties.clone());
        let writer = writer.map_err(|error| failed(&path, error))?;
        let descriptors = writer.schema_descr().columns().iter().cloned();
        let file_columns = columns.all().iter().zip(descriptors).map(|(column, descriptor)| FileColumn {
            descriptor,
            of_steps: part_of_bins(column),
            encoded: None,
        });
        let file_columns = file_columns.collect();
        Ok(ParquetTable { writer, columns, file_columns, properties, path })
    }

    /// Encodes all columns of a batch.
    fn encode(&mut self, batch: &Batch) -> ParquetResult<Vec<Chunk>> {
        let mut values = batch.values.iter();
        let sources = self.columns.all().iter().map(|column| if column.is_of_bins() { None } else { values.next() });
        let sources: Vec<Option<&Values>> = sources.collect();
        let (steps, properties) = (self.columns.rows_of_place(), &self.properties);
        let columns = self.columns.all().par_iter().zip(&mut self.file_columns).zip(sources);
        let encoded = columns.map(|((column, to), values)| match values {
            None => to.encode_steps(batch.places, properties),
            Some(Values::Texts(names)) if column.along == Along::Places && steps > 1 => {
                to.encode_by(properties, |writer| names.iter().try_for_each(|name| write_name(writer, name, steps)))
            }
            Some(values) => to.encode(&part_of(column, values), 1, properties),
        });
        encoded.collect()
    }
}

impl FileColumn {
    /// Encodes a part `times` times into memory.
    fn encode(&self, part: &Part, times: usize, properties: &WriterPropertiesPtr) -> ParquetResult<Chunk> {
        self.encode_by(properties, |writer| (0..times).try_for_each(|_| write_part(writer, part)))
    }

    /// Encodes the steps of some places, or returns the last encoding if it fits.
    fn encode_steps(&mut self, places: usize, properties: &WriterPropertiesPtr) -> ParquetResult<Chunk> {
        match (&self.encoded, &self.of_steps) {
            (Some((known, chunk)), _) if *known == places => Ok(chunk.clone()),
            (_, Some(part)) => {
                let chunk = self.encode(part, places, properties)?;
                self.encoded = Some((places, chunk.clone()));
                Ok(chunk)
            }
            (_, None) => Err(ParquetError::General("a column has no values".into())),
        }
    }

    fn encode_by(
        &self,
        properties: &WriterPropertiesPtr,
        write: impl FnOnce(&mut ColumnWriter<'_>) -> ParquetResult<()>,
    ) -> ParquetResult<Chunk> {
        let mut buffer = TrackedWrite::new(Vec::new());
        let close = {
            let pages = Box::new(SerializedPageWriter::new(&mut buffer));
            let mut writer = get_column_writer(self.descriptor.clone(), properties.clone(), pages);
            write(&mut writer)?;
            writer.close()?
        };
        let bytes = Bytes::from(buffer.into_inner()?);
        Ok(Chunk { bytes, close })
    }
}

impl FormatWriter for ParquetTable {
    fn write(&mut self, batch: &Batch) -> Result<()> {
        let chunks = self.encode(batch).map_err(|error| failed(&self.path, error))?;
        append(&mut self.writer, chunks).map_err(|error| failed(&self.path, error))
    }

    fn finish(self: Box<Self>) -> Result<u64> {
        // `into_inner` writes the footer.
        let sink = self.writer.into_inner().map_err(|error| failed(&self.path, error))?;
        sink.finish()
    }
}

/// Appends a row group.
fn append(writer: &mut SerializedFileWriter<Sink>, chunks: Vec<Chunk>) -> ParquetResult<()> {
    let mut group = writer.next_row_group()?;
    for Chunk { bytes, close } in chunks {
        group.append_column(&bytes, close)?;
    }
    group.close().map(|_| ())
}

fn write_part(writer: &mut ColumnWriter<'_>, part: &Part) -> ParquetResult<()> {
    match (writer, part) {
        (ColumnWriter::ByteArrayColumnWriter(writer), Part::Texts(texts)) => writer.write_batch(texts, None, None),
        (ColumnWriter::Int64ColumnWriter(writer), Part::Whole(numbers)) => writer.write_batch(numbers, None, None),
        (ColumnWriter::FloatColumnWriter(writer), Part::Floats(numbers)) => writer.write_batch(numbers, None, None),
        (ColumnWriter::DoubleColumnWriter(writer), Part::Doubles { values, present }) => {
            writer.write_batch(values, Some(present), None)
        }
        _ => return Err(ParquetError::General("a column has values of another kind".into())),
    }
    .map(|_| ())
}

/// Writes the name of a place into all of its rows. A short part is written repeatedly: a clone for
/// each row would take longer than all values.
fn write_name(writer: &mut ColumnWriter<'_>, name: &str, rows: usize) -> ParquetResult<()> {
    let whole = Part::Texts(vec![ByteArray::from(name); rows.min(NAMES_AT_ONCE)]);
    (0..rows / NAMES_AT_ONCE).try_for_each(|_| write_part(writer, &whole))?;
    match rows % NAMES_AT_ONCE {
        0 => Ok(()),
        rest => write_part(writer, &Part::Texts(vec![ByteArray::from(name); rest])),
    }
}

/// Converts the values of a batch to the types of their column writer.
fn part_of<'v>(column: &Column, values: &'v Values) -> Part<'v> {
    match (column.kind, values) {
        (Kind::Number(_), Values::Numbers(numbers)) => Part::Doubles {
            values: numbers.iter().flatten().copied().collect(),
            present: numbers.iter().map(|number| if number.is_some() { PRESENT } else { 0 }).collect(),
        },
        (_, Values::Texts(texts)) => Part::Texts(texts.iter().map(|text| ByteArray::from(text.as_str())).collect()),
        // Counts beyond 2^63 keep their bits: the column is unsigned.
        (_, Values::Counts(counts)) => Part::Whole(counts.iter().map(|count| *count as i64).collect()),
        (_, values) => Part::Floats(values.floats()),
    }
}

/// Returns the values of a column along steps, at one place.
fn part_of_bins(column: &Column) -> Option<Part<'static>> {
    Some(match (&column.along, column.instants()) {
        (_, Some(instants)) => Part::Whole(instants.utc_us()),
        (Along::Bins(BinValues::Labels(labels)), None) => {
            Part::Texts(labels.text.iter().map(|label| ByteArray::from(label.as_str())).collect())
        }
        (Along::Bins(BinValues::Numbers(numbers)), None) => {
            Part::Floats(numbers.iter().map(|number| *number as f32).collect())
        }
        (Along::Rows | Along::Places, None) => return None,
    })
}

/// Returns the schema and settings. The key-value metadata are provenance, and units as
/// `unit.COLUMN`. The Arrow schema in them contains both again, because pyarrow reads nothing else
/// if it is there.
fn schema(columns: &TableColumns, provenance: &Provenance) -> ParquetResult<(Arc<Type>, WriterProperties)> {
    let about = provenance.entries().into_iter().map(|(name, value)| KeyValue::new(name, value));
    let mut about: Vec<KeyValue> = about.collect();
    let mut fields = Vec::with_capacity(columns.all().len());
    let mut properties = WriterProperties::builder()
        .set_created_by(concat!("heliotile ", env!("CARGO_PKG_VERSION")).to_string())
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(1)?))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_data_page_row_count_limit(PAGE_ROWS)
        .set_data_page_size_limit(PAGE_BYTES)
        .set_write_batch_size(8192)
        .set_dictionary_page_size_limit(DICTIONARY_BYTES);
    for column in columns.all() {
        let path = ColumnPath::from(column.name.as_str());
        if column.kind == Kind::Category && column.along == Along::Places {
            properties = properties
                .set_column_bloom_filter_enabled(path.clone(), true)
                .set_column_bloom_filter_max_ndv(path.clone(), NAMES_OF_TILE);
        }
        let encoding = match (column.instants(), column.kind) {
            (Some(_), _) => Some(TIME_ENCODING),
            (None, Kind::Number(_) | Kind::Float(_)) if !column.is_of_bins() => Some(NUMBER_ENCODING),
            _ => None,
        };
        if let Some(encoding) = encoding {
            properties =
                properties.set_column_dictionary_enabled(path.clone(), false).set_column_encoding(path, encoding);
        }
        if let Some(unit) = column.unit {
            about.push(KeyValue::new(format!("unit.{}", column.name), Some(unit.to_owned())));
        }
        fields.push(Arc::new(field(column)?));
    }
    let schema = Type::group_type_builder("results").with_fields(fields).build()?;
    let mut properties = properties.set_key_value_metadata(Some(about)).build();
    add_encoded_arrow_schema_to_metadata(&arrow::schema(columns, provenance), &mut properties);
    Ok((Arc::new(schema), properties))
}

fn field(column: &Column) -> ParquetResult<Type> {
    let (physical, logical) = match (column.instants(), column.kind) {
        (Some(_), _) => (PhysicalType::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
        (None, Kind::Text | Kind::Category) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        (None, Kind::Count) => (PhysicalType::INT64, Some(LogicalType::integer(64, false))),
        (None, Kind::Number(_)) => (PhysicalType::DOUBLE, None),
        (None, Kind::Float(_)) => (PhysicalType::FLOAT, None),
    };
    let repetition = match column.kind {
        Kind::Number(_) => Repetition::OPTIONAL,
        Kind::Text | Kind::Category | Kind::Count | Kind::Float(_) => Repetition::REQUIRED,
    };
    Type::primitive_type_builder(&column.name, physical).with_logical_type(logical).with_repetition(repetition).build()
}
