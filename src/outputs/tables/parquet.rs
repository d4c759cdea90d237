//! Tables as Parquet: one row group a tile, zstd level 1, times as differences of microseconds of UTC, other labels and receivers as
//! dictionary-encoded strings, values as f32. The Arrow schema stands in the metadata: readers make categories of the strings, know the
//! zone of the times and the unit of a field; provenance stands beside it.
//!
//! Columns of a tile are encoded in parallel, each into memory, then appended in order. The label column is the same in
//! every tile with as many receivers, so its bytes are kept and appended again.

use std::path::Path;
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
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::table::Table;
use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::{Error, Result};

/// Dictionaries up to this size stay dictionaries: labels of a year of minutes are 10 MB.
const DICTIONARY_BYTES: usize = 32 << 20;

/// Names of tiles are neighbours in space, not in the alphabet, so least and greatest do not tell readers which tile holds one;
/// a Bloom filter of 80 bytes does.
const NAMES_OF_TILE: u64 = 64;

/// Rows of a receiver whose name is handed over at a time.
const NAMES_AT_ONCE: usize = 512;

/// Rows of a data page: a reader skips by page, so not too many; each has a header, so not too few.
const PAGE_ROWS: usize = 1 << 17;
const PAGE_BYTES: usize = 1 << 20;

/// A column of a tile, ready to be appended.
#[derive(Clone)]
struct Chunk {
    bytes: Bytes,
    close: ColumnCloseResult,
}

/// The label column of a receiver.
enum LabelValues {
    Words(Vec<ByteArray>),
    /// Microseconds since 1970-01-01 00:00 UTC.
    Times(Vec<i64>),
}

/// A Parquet table being written.
pub struct ParquetTable {
    writer: SerializedFileWriter<Sink>,
    columns: Vec<ColumnDescPtr>,
    properties: WriterPropertiesPtr,
    labels: LabelValues,
    rows_of_name: usize,
    /// The label column of the last tile, and its number of receivers.
    label_chunk: Option<(usize, Chunk)>,
    path: std::path::PathBuf,
}

impl ParquetTable {
    pub fn new(sink: Sink, layout: &Layout, labels: &RowLabels, provenance: &Provenance) -> Result<Self> {
        let path = sink.path().to_path_buf();
        let fail = |e: ParquetError| failed(&path, e);
        let (schema, properties) = schema(layout, labels, provenance).map_err(fail)?;
        let properties = Arc::new(properties);
        let writer = SerializedFileWriter::new(sink, schema, properties.clone()).map_err(fail)?;
        let columns = writer.schema_descr().columns().to_vec();
        Ok(ParquetTable {
            writer,
            columns,
            properties,
            labels: match &labels.instants {
                Some(instants) => LabelValues::Times(instants.utc_us()),
                None => LabelValues::Words(labels.text.iter().map(|l| ByteArray::from(l.as_str())).collect()),
            },
            rows_of_name: labels.len(),
            label_chunk: None,
            path,
        })
    }

    /// Encodes a column, given in parts, into memory.
    fn encode<T>(
        &self,
        column: &ColumnDescPtr,
        parts: impl Iterator<Item = T>,
        write: impl Fn(&mut ColumnWriter<'_>, T) -> std::result::Result<(), ParquetError>,
    ) -> std::result::Result<Chunk, ParquetError> {
        let mut buffer = TrackedWrite::new(Vec::new());
        let close = {
            let pages = Box::new(SerializedPageWriter::new(&mut buffer));
            let mut writer = get_column_writer(column.clone(), self.properties.clone(), pages);
            for part in parts {
                write(&mut writer, part)?;
            }
            writer.close()?
        };
        let bytes = Bytes::from(buffer.into_inner()?);
        Ok(Chunk { bytes, close })
    }
}

impl Table for ParquetTable {
    fn write_tile(&mut self, receivers: &[String], values: &TileColumns) -> Result<()> {
        let path = self.path.clone();
        let chunks: Vec<Chunk> = self
            .columns
            .par_iter()
            .enumerate()
            .map(|(i, column)| match (i, &self.label_chunk) {
                (0, Some((count, chunk))) if *count == receivers.len() => Ok(chunk.clone()),
                (0, _) => match &self.labels {
                    LabelValues::Words(words) => {
                        self.encode(column, receivers.iter().map(|_| words), |w, words| write_strings(w, words))
                    }
                    LabelValues::Times(times) => {
                        self.encode(column, receivers.iter().map(|_| times), |w, times| write_times(w, times))
                    }
                },
                (1, _) => self.encode(column, receivers.iter(), |writer, name| {
                    // A short part again and again: a clone for each row would take longer than all values.
                    let part = vec![ByteArray::from(name.as_str()); self.rows_of_name.min(NAMES_AT_ONCE)];
                    let mut rows_left = self.rows_of_name;
                    while rows_left > 0 {
                        let rows = rows_left.min(part.len());
                        write_strings(writer, part.get(..rows).unwrap_or_default())?;
                        rows_left -= rows;
                    }
                    Ok(())
                }),
                _ => self.encode(column, std::iter::once(values.column(i - 2)), write_floats),
            })
            .collect::<std::result::Result<_, ParquetError>>()
            .map_err(|e| failed(&path, e))?;
        if let Some(first) = chunks.first() {
            self.label_chunk = Some((receivers.len(), first.clone()));
        }
        let append = |writer: &mut SerializedFileWriter<Sink>| {
            let mut group = writer.next_row_group()?;
            for Chunk { bytes, close } in chunks {
                group.append_column(&bytes, close)?;
            }
            group.close().map(|_| ())
        };
        append(&mut self.writer).map_err(|e| failed(&path, e))
    }

    fn finish(self: Box<Self>) -> Result<u64> {
        // Writes the footer.
        let sink = self.writer.into_inner().map_err(|e| failed(&self.path, e))?;
        sink.finish()
    }
}

fn write_strings(writer: &mut ColumnWriter<'_>, values: &[ByteArray]) -> std::result::Result<(), ParquetError> {
    match writer {
        ColumnWriter::ByteArrayColumnWriter(writer) => writer.write_batch(values, None, None).map(|_| ()),
        _ => Err(ParquetError::General("a string column is not one".into())),
    }
}

fn write_times(writer: &mut ColumnWriter<'_>, values: &[i64]) -> std::result::Result<(), ParquetError> {
    match writer {
        ColumnWriter::Int64ColumnWriter(writer) => writer.write_batch(values, None, None).map(|_| ()),
        _ => Err(ParquetError::General("a time column is not one".into())),
    }
}

fn write_floats(writer: &mut ColumnWriter<'_>, values: &[f32]) -> std::result::Result<(), ParquetError> {
    match writer {
        ColumnWriter::FloatColumnWriter(writer) => writer.write_batch(values, None, None).map(|_| ()),
        _ => Err(ParquetError::General("a float column is not one".into())),
    }
}

/// Schema and settings. The key-value metadata are provenance, and units as `unit.COLUMN`; the Arrow schema in them has both again, as
/// pyarrow looks nowhere else where there is one.
fn schema(
    layout: &Layout,
    labels: &RowLabels,
    provenance: &Provenance,
) -> std::result::Result<(Arc<Type>, WriterProperties), ParquetError> {
    let names = layout.names();
    let mut fields = Vec::with_capacity(names.len());
    let about = provenance.entries().into_iter().map(|(name, value)| KeyValue::new(name, value));
    let mut about: Vec<KeyValue> = about.collect();
    let mut properties = WriterProperties::builder()
        .set_created_by(concat!("heliotile ", env!("CARGO_PKG_VERSION")).to_string())
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(1)?))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_data_page_row_count_limit(PAGE_ROWS)
        .set_data_page_size_limit(PAGE_BYTES)
        .set_write_batch_size(8192)
        .set_dictionary_page_size_limit(DICTIONARY_BYTES)
        .set_column_bloom_filter_enabled(ColumnPath::from(layout.place()), true)
        .set_column_bloom_filter_max_ndv(ColumnPath::from(layout.place()), NAMES_OF_TILE);
    let units = layout.units();
    for (i, name) in names.iter().enumerate() {
        let field = if i == 0 && labels.instants.is_some() {
            let column = ColumnPath::from(name.as_str());
            properties = properties
                .set_column_dictionary_enabled(column.clone(), false)
                .set_column_encoding(column, TIME_ENCODING);
            let utc = LogicalType::timestamp(true, TimeUnit::MICROS);
            Type::primitive_type_builder(name, PhysicalType::INT64).with_logical_type(Some(utc))
        } else if i < 2 {
            Type::primitive_type_builder(name, PhysicalType::BYTE_ARRAY).with_logical_type(Some(LogicalType::String))
        } else {
            let column = ColumnPath::from(name.as_str());
            properties = properties
                .set_column_dictionary_enabled(column.clone(), FLOAT_DICTIONARY)
                .set_column_encoding(column, FLOAT_ENCODING);
            about.push(KeyValue::new(format!("unit.{name}"), units.get(i - 2).map(|unit| (*unit).to_owned())));
            Type::primitive_type_builder(name, PhysicalType::FLOAT)
        };
        fields.push(Arc::new(field.with_repetition(Repetition::REQUIRED).build()?));
    }
    let schema = Type::group_type_builder("results").with_fields(fields).build()?;
    let mut properties = properties.set_key_value_metadata(Some(about)).build();
    add_encoded_arrow_schema_to_metadata(&arrow::schema(layout, labels, provenance), &mut properties);
    Ok((Arc::new(schema), properties))
}

/// Splitting the bytes of the floats costs 0.2 s a 4.5 million rows over plain values and saves 10 to 70 % of the file;
/// dictionaries of floats are slower and larger. Measured in `table_tests::year_of_rows`.
const FLOAT_DICTIONARY: bool = false;
const FLOAT_ENCODING: Encoding = Encoding::BYTE_STREAM_SPLIT;

/// Equal steps take next to nothing as differences.
const TIME_ENCODING: Encoding = Encoding::DELTA_BINARY_PACKED;

fn failed(path: &Path, error: ParquetError) -> Error {
    Error::io(path, "write")(std::io::Error::other(error))
}
