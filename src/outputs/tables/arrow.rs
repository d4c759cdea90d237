//! Tables as Arrow IPC files: one record batch a tile, times as timestamps with their zone, other labels and receivers as dictionaries,
//! values as f32, the unit in the metadata of each field, provenance in that of the schema. `.arrow` is plain, so that it can be mapped;
//! `.feather` is compressed.
//!
//! A file holds one dictionary a column, so all names must be known before the first row.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::types::Int32Type;
use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float32Array, RecordBatch, StringArray, TimestampMicrosecondArray,
    new_empty_array,
};
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use arrow_schema::{ArrowError, DataType, Field, Metadata, Schema, TimeUnit};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::table::Table;
use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::{Error, Result};

/// Of zstd: higher levels take longer for little on floats.
const LEVEL: i32 = 1;

/// Columns of a table: times, or a dictionary of strings; a dictionary of strings; values with their unit. And provenance.
pub fn schema(layout: &Layout, labels: &RowLabels, provenance: &Provenance) -> Schema {
    let names = DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
    let label = match &labels.instants {
        Some(instants) => DataType::Timestamp(TimeUnit::Microsecond, Some(instants.zone().into())),
        None => names.clone(),
    };
    let first = [Field::new(layout.label(), label, false), Field::new(layout.place(), names, false)];
    let value = |(name, unit): (String, &str)| {
        let unit = [("unit".to_string(), unit.to_string())];
        Field::new(name, DataType::Float32, false).with_metadata(Metadata::from(unit))
    };
    let values = layout.values().into_iter().zip(layout.units()).map(value);
    let fields: Vec<Field> = first.into_iter().chain(values).collect();
    Schema::new_with_metadata(fields, provenance.entries().into_iter().collect::<Metadata>())
}

/// Record batches of results: the first column says the label, the second the receiver.
pub struct ArrowRows {
    schema: Arc<Schema>,
    labels: RowLabels,
    names: Arc<StringArray>,
    /// The labels, again and again, for as many receivers as any batch had.
    label_column: ArrayRef,
}

impl ArrowRows {
    /// Of all names of the second column, in order. An error: more labels or names than a dictionary has numbers.
    pub fn new(layout: &Layout, labels: &RowLabels, names: &[String], provenance: &Provenance) -> Result<Self> {
        for (what, count) in
            [("rows of a receiver in an Arrow file", labels.len()), ("names in an Arrow file", names.len())]
        {
            if i32::try_from(count).is_err() {
                return Err(Error::Limit { what: what.into(), value: count as u64, max: i32::MAX as u64 });
            }
        }
        Ok(ArrowRows {
            schema: Arc::new(schema(layout, labels, provenance)),
            labels: labels.clone(),
            names: Arc::new(StringArray::from_iter_values(names)),
            label_column: new_empty_array(&DataType::Int32),
        })
    }

    /// What batches hold.
    pub fn schema(&self) -> &Arc<Schema> {
        &self.schema
    }

    /// The labels of some receivers.
    fn label_column(&self, count: usize) -> std::result::Result<ArrayRef, ArrowError> {
        Ok(match &self.labels.instants {
            Some(instants) => {
                let times = TimestampMicrosecondArray::from(instants.utc_us().repeat(count));
                Arc::new(times.with_timezone(instants.zone()))
            }
            None => {
                let keys: Vec<i32> = (0..count).flat_map(|_| 0..self.labels.len() as i32).collect();
                let words = Arc::new(StringArray::from_iter_values(&self.labels.text));
                Arc::new(DictionaryArray::<Int32Type>::try_new(keys.into(), words)?)
            }
        })
    }

    /// The rows of `count` names from number `first` on: `columns` are the values, `[name][label]`.
    pub fn batch(
        &mut self,
        first: usize,
        count: usize,
        columns: impl Iterator<Item = Float32Array>,
    ) -> std::result::Result<RecordBatch, ArrowError> {
        let (labels, rows) = (self.labels.len(), count * self.labels.len());
        if self.label_column.len() < rows {
            self.label_column = self.label_column(count)?;
        }
        let first = first as i32;
        let places = (first..first + count as i32).flat_map(|place| std::iter::repeat_n(place, labels));
        let names = DictionaryArray::<Int32Type>::try_new(places.collect::<Vec<_>>().into(), self.names.clone())?;
        let mut all: Vec<ArrayRef> = vec![self.label_column.slice(0, rows), Arc::new(names)];
        all.extend(columns.map(|column| Arc::new(column) as ArrayRef));
        RecordBatch::try_new(self.schema.clone(), all)
    }
}

/// An Arrow file being written.
pub struct ArrowTable {
    writer: FileWriter<Sink>,
    rows: ArrowRows,
    /// Names that were written.
    done: usize,
    path: PathBuf,
}

impl ArrowTable {
    pub fn new(
        sink: Sink,
        layout: &Layout,
        labels: &RowLabels,
        names: &[String],
        provenance: &Provenance,
        packed: bool,
    ) -> Result<Self> {
        let path = sink.path().to_path_buf();
        let rows = ArrowRows::new(layout, labels, names, provenance)?;
        let start = || {
            let mut options = IpcWriteOptions::default();
            if packed {
                options = options
                    .try_with_compression(Some(CompressionType::ZSTD))?
                    .try_with_compression_level(Some(LEVEL))?;
            }
            FileWriter::try_new_with_options(sink, rows.schema(), options)
        };
        Ok(ArrowTable { writer: start().map_err(|e| failed(&path, e))?, rows, done: 0, path })
    }
}

impl Table for ArrowTable {
    fn write_tile(&mut self, receivers: &[String], values: &TileColumns) -> Result<()> {
        let known = self.done + receivers.len() <= self.rows.names.len()
            && receivers.iter().enumerate().all(|(i, name)| self.rows.names.value(self.done + i) == name);
        if !known {
            return Err(Error::input(
                &self.path,
                None,
                "rows of names that were not announced",
                "this is a defect, report it",
            ));
        }
        let columns = (0..values.count()).map(|number| Float32Array::from(values.column(number).to_vec()));
        let batch = self.rows.batch(self.done, receivers.len(), columns).map_err(|e| failed(&self.path, e))?;
        self.done += receivers.len();
        self.writer.write(&batch).map_err(|e| failed(&self.path, e))
    }

    fn finish(mut self: Box<Self>) -> Result<u64> {
        // Writes the footer.
        self.writer.finish().map_err(|e| failed(&self.path, e))?;
        self.writer.into_inner().map_err(|e| failed(&self.path, e))?.finish()
    }
}

fn failed(path: &std::path::Path, error: ArrowError) -> Error {
    match error {
        ArrowError::IoError(_, source) => Error::io(path, "write")(source),
        other => Error::io(path, "write")(std::io::Error::other(other)),
    }
}
