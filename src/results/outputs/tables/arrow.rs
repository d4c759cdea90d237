//! Tables as Arrow IPC files: one record batch for each batch of rows, times as timestamps with
//! their zone, categories as dictionaries, values of each column's type. The metadata of a field
//! state its unit, those of the schema the provenance. `.arrow` is uncompressed, so that it can be
//! memory-mapped; `.feather` is compressed.
//!
//! A file holds one dictionary a column, so all categories must be known before the first row.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::types::Int32Type;
use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float32Array, Float64Array, RecordBatch, StringArray, TimestampMicrosecondArray,
    UInt64Array,
};
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use arrow_schema::{ArrowError, DataType, Field, Metadata, Schema, TimeUnit};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::column::{Along, BinValues, Column, Kind, TableColumns};
use crate::outputs::tables::writer::{FormatWriter, TableRequest, failed, rows_defect};
use heliotile_core::error::{Error, Result};

type ArrowResult<T> = std::result::Result<T, ArrowError>;

/// Level of zstd: higher levels take longer and gain little on floats.
const LEVEL: i32 = 1;

/// Returns the schema of a table: its columns with their units, and provenance.
pub(super) fn schema(columns: &TableColumns, provenance: &Provenance) -> Schema {
    let fields: Vec<Field> = columns.all().iter().map(field).collect();
    Schema::new_with_metadata(fields, provenance.entries().into_iter().collect::<Metadata>())
}

fn field(column: &Column) -> Field {
    let kind = match (column.instants(), column.kind) {
        (Some(instants), _) => DataType::Timestamp(TimeUnit::Microsecond, Some(instants.zone().into())),
        (None, Kind::Text) => DataType::Utf8,
        (None, Kind::Category) => DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8)),
        (None, Kind::Count) => DataType::UInt64,
        (None, Kind::Number(_)) => DataType::Float64,
        (None, Kind::Float(_)) => DataType::Float32,
    };
    let unit = column.unit.map(|unit| ("unit".to_owned(), unit.to_owned()));
    let may_be_missing = matches!(column.kind, Kind::Number(_));
    Field::new(&column.name, kind, may_be_missing).with_metadata(unit.into_iter().collect::<Metadata>())
}

/// Record batches of a table.
pub struct ArrowRows {
    schema: Arc<Schema>,
    columns: Arc<TableColumns>,
    /// Names of places, if they are categories.
    names: Arc<StringArray>,
    /// `[column]`: values of a column along steps, repeated for the largest number of places of any
    /// batch; `None` for other columns.
    of_steps: Vec<Option<ArrayRef>>,
}

impl ArrowRows {
    /// Prepares the batches; `names` are all names of places in order, if they are categories.
    /// Errors: more labels or names than a dictionary can number.
    pub fn new(columns: Arc<TableColumns>, names: &[String], provenance: &Provenance) -> Result<Self> {
        for (what, count) in
            [("rows of a place in an Arrow file", columns.rows_of_place()), ("names in an Arrow file", names.len())]
        {
            if i32::try_from(count).is_err() {
                return Err(Error::Limit { what: what.into(), value: count as u64, max: i32::MAX as u64 });
            }
        }
        Ok(ArrowRows {
            schema: Arc::new(schema(&columns, provenance)),
            names: Arc::new(StringArray::from_iter_values(names)),
            of_steps: columns.all().iter().map(|_| None).collect(),
            columns,
        })
    }

    /// Returns the schema of the batches.
    pub fn schema(&self) -> &Arc<Schema> {
        &self.schema
    }

    /// Returns the rows of `count` places from index `first` on. `values` are the columns that are
    /// neither along steps nor categories of places.
    pub fn batch(
        &mut self,
        first: usize,
        count: usize,
        mut values: impl Iterator<Item = ArrayRef>,
    ) -> ArrowResult<RecordBatch> {
        let rows = count * self.columns.rows_of_place();
        let columns = Arc::clone(&self.columns);
        let mut all = Vec::with_capacity(columns.all().len());
        for (i, column) in columns.all().iter().enumerate() {
            all.push(match (&column.along, column.kind) {
                (Along::Bins(of_steps), _) => self.steps(i, column, of_steps, count)?.slice(0, rows),
                (Along::Places, Kind::Category) => self.categories(first, count)?,
                _ => values.next().ok_or_else(|| ArrowError::SchemaError("a column has no values".into()))?,
            });
        }
        RecordBatch::try_new(Arc::clone(&self.schema), all)
    }

    /// Returns the values of a column along steps, for at least `count` places.
    fn steps(&mut self, i: usize, column: &Column, values: &BinValues, count: usize) -> ArrowResult<ArrayRef> {
        let rows = count * self.columns.rows_of_place();
        match self.of_steps.get(i) {
            Some(Some(known)) if known.len() >= rows => Ok(Arc::clone(known)),
            _ => {
                let array = repeated(column, values, count)?;
                if let Some(known) = self.of_steps.get_mut(i) {
                    *known = Some(Arc::clone(&array));
                }
                Ok(array)
            }
        }
    }

    /// Returns the names of places, each in all of its rows.
    fn categories(&self, first: usize, count: usize) -> ArrowResult<ArrayRef> {
        let first = first as i32;
        let steps = self.columns.rows_of_place();
        let places = (first..first + count as i32).flat_map(|place| std::iter::repeat_n(place, steps));
        let keys = places.collect::<Vec<_>>().into();
        Ok(Arc::new(DictionaryArray::<Int32Type>::try_new(keys, self.names.clone())?))
    }
}

/// Returns the values of a column along steps, for `count` places.
fn repeated(column: &Column, values: &BinValues, count: usize) -> ArrowResult<ArrayRef> {
    Ok(match (values, column.instants(), column.kind) {
        (_, Some(instants), _) => {
            let times = TimestampMicrosecondArray::from(instants.utc_us().repeat(count));
            Arc::new(times.with_timezone(instants.zone()))
        }
        (BinValues::Labels(labels), None, Kind::Category) => {
            let keys: Vec<i32> = (0..count).flat_map(|_| 0..labels.len() as i32).collect();
            let words = Arc::new(StringArray::from_iter_values(&labels.text));
            Arc::new(DictionaryArray::<Int32Type>::try_new(keys.into(), words)?)
        }
        (BinValues::Labels(labels), None, _) => {
            Arc::new(StringArray::from_iter_values((0..count).flat_map(|_| &labels.text)))
        }
        (BinValues::Numbers(numbers), None, _) => {
            let floats: Vec<f32> = numbers.iter().map(|number| *number as f32).collect();
            Arc::new(Float32Array::from(floats.repeat(count)))
        }
    })
}

/// Compression of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    Plain,
    Zstd,
}

/// Arrow file being written.
pub struct ArrowTable {
    writer: FileWriter<Sink>,
    rows: ArrowRows,
    /// Number of places that were written.
    done: usize,
    path: PathBuf,
}

impl ArrowTable {
    pub fn new(sink: Sink, request: &TableRequest, packing: Packing) -> Result<Self> {
        let path = sink.path().to_path_buf();
        let is_category = |column: &Column| column.along == Along::Places && column.kind == Kind::Category;
        let names = match request.columns.all().iter().any(is_category) {
            true => (request.places.names)()?,
            false => Vec::new(),
        };
        let about = request.about.cloned().unwrap_or_default();
        let rows = ArrowRows::new(Arc::clone(&request.columns), &names, &about)?;
        let writer = start(sink, rows.schema(), packing).map_err(|error| failed(&path, error))?;
        Ok(ArrowTable { writer, rows, done: 0, path })
    }

    /// Returns true if the next places are those that were announced.
    fn knows(&self, names: &[String]) -> bool {
        self.done + names.len() <= self.rows.names.len()
            && names.iter().enumerate().all(|(i, name)| self.rows.names.value(self.done + i) == name)
    }
}

/// Starts a file.
fn start(sink: Sink, schema: &Schema, packing: Packing) -> ArrowResult<FileWriter<Sink>> {
    let options = match packing {
        Packing::Plain => IpcWriteOptions::default(),
        Packing::Zstd => IpcWriteOptions::default()
            .try_with_compression(Some(CompressionType::ZSTD))?
            .try_with_compression_level(Some(LEVEL))?,
    };
    FileWriter::try_new_with_options(sink, schema, options)
}

impl FormatWriter for ArrowTable {
    fn write(&mut self, batch: &Batch) -> Result<()> {
        let columns = Arc::clone(&self.rows.columns);
        let mut arrays = Vec::with_capacity(batch.values.len());
        for (column, values) in columns.in_batches().zip(&batch.values) {
            match (&column.along, column.kind) {
                (Along::Places, Kind::Category) if self.knows(values.texts()) => {}
                (Along::Places, Kind::Category) => {
                    return Err(rows_defect(&self.path, "names came that were not announced".into()));
                }
                (Along::Places, _) => {
                    let steps = columns.rows_of_place();
                    let rows = values.texts().iter().flat_map(|name| std::iter::repeat_n(name, steps));
                    arrays.push(Arc::new(StringArray::from_iter_values(rows)) as ArrayRef);
                }
                (_, kind) => arrays.push(array_of(kind, values)),
            }
        }
        let batch = match self.rows.batch(self.done, batch.places, arrays.into_iter()) {
            Ok(rows) => {
                self.done += batch.places;
                rows
            }
            Err(error) => return Err(failed(&self.path, error)),
        };
        self.writer.write(&batch).map_err(|error| failed(&self.path, error))
    }

    fn finish(mut self: Box<Self>) -> Result<u64> {
        // `finish` writes the footer.
        self.writer.finish().map_err(|error| failed(&self.path, error))?;
        self.writer.into_inner().map_err(|error| failed(&self.path, error))?.finish()
    }
}

/// Returns the values of rows as an array.
fn array_of(kind: Kind, values: &Values) -> ArrayRef {
    match (kind, values) {
        (Kind::Number(_), Values::Numbers(numbers)) => Arc::new(Float64Array::from_iter(numbers.iter().copied())),
        (_, Values::Texts(texts)) => Arc::new(StringArray::from_iter_values(texts.iter())),
        (_, Values::Counts(counts)) => Arc::new(UInt64Array::from(counts.clone())),
        (_, values) => Arc::new(Float32Array::from(values.floats().into_owned())),
    }
}
