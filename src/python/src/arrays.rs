//! Results in memory. In: tiles of irradiance. Out: a column of f32 for each component,
//! `[receiver][label]`, which NumPy and Arrow share; columns by pvlib's names.

use std::collections::BTreeMap;
use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{ArrayRef, Float32Array, RecordBatch, RecordBatchReader};
use arrow_buffer::{Buffer, ScalarBuffer};
use arrow_schema::{ArrowError, SchemaRef};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::errors::raised;
use crate::memory::Block;
use crate::work;
use heliotile::tables::{ArrowRows, Layout, ONE_SIDE};
use heliotile::{
    BinLabels, By, Component, ComponentList, ComponentSet, Error, Provenance, Result, SideHours, SiteReplay, Tile,
    TileSink,
};

/// Smallest number of rows of a record batch, but for the last.
const BATCH_ROWS: usize = 1 << 20;

/// Description of results: number of receivers, labels, columns, and provenance.
pub struct Frame {
    pub receivers: usize,
    pub labels: BinLabels,
    components: ComponentList,
    layout: Layout,
    about: Provenance,
}

impl Frame {
    /// Describes the results of a replay of `receivers` receivers.
    pub fn new(replay: &SiteReplay, receivers: usize) -> Self {
        let (about, components, stream) = (replay.provenance(), replay.columns(), replay.stream());
        let layout = Layout::of_components(stream.series.kind, By::Receiver, &components);
        Frame { receivers, labels: stream.series.labels.clone(), components, layout, about }
    }

    pub fn components(&self) -> &[Component] {
        self.components.as_slice()
    }

    /// Returns the index of a column by its name, with or without the suffix of sums.
    pub fn column(&self, name: &str) -> Option<usize> {
        let names = self.layout.values();
        let place = self.components().iter().position(|component| self.components.name_of(*component) == name);
        place.or_else(|| names.iter().position(|known| known == name))
    }
}

/// Irradiance of some receivers under a series of conditions.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct Recombined {
    frame: Arc<Frame>,
    /// Ids of receivers, in the order of rows.
    names: Vec<String>,
    /// `[column]`: f32, `[receiver][label]`.
    columns: Vec<Buffer>,
}

/// Results to which tiles are appended.
pub struct Gathered<'a> {
    frame: &'a Frame,
    columns: Vec<Vec<f32>>,
}

impl<'a> Gathered<'a> {
    /// Returns results without rows.
    pub fn new(frame: &'a Frame) -> Self {
        Gathered { frame, columns: Vec::new() }
    }

    /// Returns the columns, `[receiver][label]`.
    pub fn columns(self) -> Vec<Buffer> {
        self.columns.into_iter().map(Buffer::from_vec).collect()
    }
}

impl TileSink for Gathered<'_> {
    fn components(&self) -> ComponentSet {
        ComponentSet::new(self.frame.components())
    }

    /// Reserves memory for all results; fails if there is not enough.
    fn start(&mut self) -> Result<()> {
        let len = self.frame.receivers * self.frame.labels.len();
        let columns = self.frame.components().iter().map(|_| {
            let mut column = Vec::new();
            column.try_reserve_exact(len).map_err(|_| Error::Limit {
                what:
                    "memory for results in bytes (open the archive with xarray, or choose fewer receivers or columns)"
                        .into(),
                value: 4 * len as u64,
                max: isize::MAX as u64,
            })?;
            Ok(column)
        });
        self.columns = columns.collect::<Result<_>>()?;
        Ok(())
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        for (column, component) in self.columns.iter_mut().zip(self.frame.components()) {
            column.extend_from_slice(tile.values.component(*component));
        }
        work::count_tiles(1);
        Ok(true)
    }
}

impl Recombined {
    /// Returns results of receivers with these ids.
    pub fn new(frame: Frame, names: Vec<String>, columns: Vec<Buffer>) -> Self {
        Recombined { frame: Arc::new(frame), names, columns }
    }
}

#[pymethods]
impl Recombined {
    /// Returns the description of these results.
    fn frame(&self) -> FrameHandle {
        FrameHandle(Arc::clone(&self.frame))
    }

    /// Ids of receivers, in the order of rows.
    #[getter]
    fn receivers(&self) -> Vec<String> {
        self.names.clone()
    }

    /// Returns a column by its name, `[receiver][label]`.
    fn column(&self, name: &str) -> PyResult<Block> {
        let frame = &self.frame;
        let found = frame.column(name).and_then(|place| self.columns.get(place));
        let buffer = found.ok_or_else(|| PyKeyError::new_err(no_column(frame, name)))?;
        Ok(Block::shared::<f32>(buffer.clone(), &[frame.receivers, frame.labels.len()]))
    }

    /// Returns the irradiance of one receiver by pvlib's names, W/m2.
    fn pvlib(&self, py: Python<'_>, receiver: usize) -> PyResult<Vec<(&'static str, Block)>> {
        let (frame, labels) = (&self.frame, self.frame.labels.len());
        if receiver >= frame.receivers {
            return Err(PyIndexError::new_err(format!(
                "receiver {receiver} is out of range: there are {} receivers",
                frame.receivers
            )));
        }
        let six = &Component::ALL[..6];
        if let Some(missing) = six.iter().find(|component| !frame.components().contains(component)) {
            let what = format!("`{}` is missing, and pvlib's columns need all six components", missing.name());
            return Err(raised(py, Error::argument("columns", what, "leave columns out")));
        }
        let hours = SideHours::new(|component| {
            let place = frame.components().iter().position(|known| *known == component);
            let all = place.and_then(|place| self.columns.get(place)).map(Buffer::typed_data::<f32>);
            all.and_then(|all| all.get(receiver * labels..(receiver + 1) * labels)).unwrap_or_default()
        });
        let columns = ONE_SIDE.into_iter().zip(hours.one_side());
        Ok(columns.map(|(name, values)| (name, Block::new(values, &[labels]))).collect())
    }

    /// Returns the Arrow C stream of all rows; values are not copied.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The protocol allows a schema other than the requested one.
        let _ = requested_schema;
        let frame = &self.frame;
        let rows = ArrowRows::new(Arc::new(frame.layout.columns(&frame.labels)), &self.names, &frame.about);
        let rows = rows.map_err(|error| raised(py, error))?;
        let columns = self.columns.iter().map(|column| ScalarBuffer::from(column.clone())).collect();
        let batches = Batches { rows, columns, frame: Arc::clone(frame), next: 0 };
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), c"arrow_array_stream")
    }
}

/// Returns the message about an unknown column, with the names of the known ones.
pub fn no_column(frame: &Frame, name: &str) -> String {
    let known: Vec<&str> = frame.components().iter().map(|component| frame.components.name_of(*component)).collect();
    format!("no column `{name}`; the columns are {}", known.join(", "))
}

/// Record batches of results, some receivers at a time.
struct Batches {
    rows: ArrowRows,
    columns: Vec<ScalarBuffer<f32>>,
    frame: Arc<Frame>,
    next: usize,
}

impl Iterator for Batches {
    type Item = std::result::Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        let labels = self.frame.labels.len();
        let (first, left) = (self.next, self.frame.receivers.saturating_sub(self.next));
        if left == 0 || labels == 0 {
            return None;
        }
        let count = (BATCH_ROWS / labels).max(1).min(left);
        self.next += count;
        let of = |column: &ScalarBuffer<f32>| -> ArrayRef {
            Arc::new(Float32Array::new(column.slice(first * labels, count * labels), None))
        };
        Some(self.rows.batch(first, count, self.columns.iter().map(of)))
    }
}

impl RecordBatchReader for Batches {
    fn schema(&self) -> SchemaRef {
        Arc::clone(self.rows.schema())
    }
}

/// Description of results for Python.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct FrameHandle(pub Arc<Frame>);

#[pymethods]
impl FrameHandle {
    /// Number of receivers.
    #[getter]
    fn receivers(&self) -> usize {
        self.0.receivers
    }

    /// Text of each label, as in CSV files.
    #[getter]
    fn labels(&self) -> Vec<String> {
        self.0.labels.text.clone()
    }

    /// Seconds since 1970 in UTC, and minutes of the local clock ahead of UTC; `None` if labels are
    /// names of conditions.
    #[getter]
    fn instants(&self) -> Option<(Block, i32)> {
        let instants = self.0.labels.instants.as_ref()?;
        let block = Block::new(instants.utc_s.clone(), &[instants.utc_s.len()]);
        Some((block, instants.offset.minutes()))
    }

    /// Names of components, and names of their columns in files.
    #[getter]
    fn columns(&self) -> Vec<(String, String)> {
        let names = self.0.components().iter().map(|component| self.0.components.name_of(*component).to_owned());
        names.zip(self.0.layout.values()).collect()
    }

    /// Units of the columns, in their order.
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        self.0.layout.units()
    }

    /// Light paths of the columns in words, in their order.
    #[getter]
    fn meanings(&self) -> Vec<&'static str> {
        self.0.components().iter().map(|component| component.meaning()).collect()
    }

    /// Name of the label column, `time` or `condition`.
    #[getter]
    fn label(&self) -> &'static str {
        self.0.layout.label()
    }

    /// Unit of the values, `W/m2` or `kWh/m2`.
    #[getter]
    fn unit(&self) -> &'static str {
        self.0.layout.unit()
    }

    /// Provenance of the results.
    #[getter]
    fn provenance(&self) -> BTreeMap<String, String> {
        self.0.about.entries().into_iter().collect()
    }
}
