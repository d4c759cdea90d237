//! Hours in pvlib's names. In: light on one side of a point or on both, hour by hour. Out: CSV or Parquet, point after point.
//!
//! One side: the columns of pvlib's `get_total_irradiance`. Two sides: those of `pvlib.bifacial.infinite_sheds.get_irradiance`, whose
//! `poa_global` is the front and the rear times the bifaciality.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float32Array, RecordBatch, StringArray, TimestampMicrosecondArray};
use arrow_schema::{ArrowError, DataType, Field, Metadata, Schema, TimeUnit};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::csvw::{self, CsvColumn};
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::Component;

/// Columns of points.
pub const ONE_SIDE: [&str; 5] = ["poa_global", "poa_direct", "poa_diffuse", "poa_sky_diffuse", "poa_ground_diffuse"];

/// Columns of modules with a rear.
pub const TWO_SIDES: [&str; 11] = [
    "poa_global",
    "poa_front",
    "poa_front_direct",
    "poa_front_diffuse",
    "poa_front_sky_diffuse",
    "poa_front_ground_diffuse",
    "poa_back",
    "poa_back_direct",
    "poa_back_diffuse",
    "poa_back_sky_diffuse",
    "poa_back_ground_diffuse",
];

/// Unit of all columns.
const UNIT: &str = "W/m2";

/// Light on one side, `[hour]`, W/m2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SideHours {
    /// The sun, straight and by mirrors.
    pub direct: Vec<f32>,
    /// The sky, straight and by mirrors.
    pub sky: Vec<f32>,
    /// What ground and surroundings reflect diffusely.
    pub reflected: Vec<f32>,
}

impl SideHours {
    /// Of irradiances by component, `[hour]`, W/m2.
    pub fn of<'v>(component: impl Fn(Component) -> &'v [f32]) -> Self {
        let both = |a: Component, b: Component| component(a).iter().zip(component(b)).map(|(a, b)| a + b).collect();
        SideHours {
            direct: both(Component::SunDirect, Component::SunSpecular),
            sky: both(Component::SkyDirect, Component::SkySpecular),
            reflected: both(Component::SunDiffuse, Component::SkyDiffuse),
        }
    }

    /// Adds a share of others, hour by hour.
    pub fn add(&mut self, other: &SideHours, share: f32) {
        let pairs = [(&mut self.direct, &other.direct), (&mut self.sky, &other.sky)];
        for (sum, more) in pairs.into_iter().chain([(&mut self.reflected, &other.reflected)]) {
            sum.resize(more.len().max(sum.len()), 0.0);
            sum.iter_mut().zip(more).for_each(|(sum, value)| *sum += share * value);
        }
    }

    /// Total, direct, diffuse, and its two parts.
    fn columns(&self) -> [Vec<f32>; 5] {
        let diffuse: Vec<f32> = self.sky.iter().zip(&self.reflected).map(|(a, b)| a + b).collect();
        let global = self.direct.iter().zip(&diffuse).map(|(a, b)| a + b).collect();
        [global, self.direct.clone(), diffuse, self.sky.clone(), self.reflected.clone()]
    }

    /// Of a point with one side, in the order of [`ONE_SIDE`].
    pub fn one_side(&self) -> Vec<Vec<f32>> {
        self.columns().into()
    }

    /// Of a module with a rear, in the order of `TWO_SIDES`.
    pub fn with_rear(&self, rear: &SideHours, bifaciality: f32) -> Vec<Vec<f32>> {
        let (front, back) = (self.columns(), rear.columns());
        let global = front[0].iter().zip(&back[0]).map(|(front, back)| front + bifaciality * back).collect();
        std::iter::once(global).chain(front).chain(back).collect()
    }
}

/// A table of hours being written.
pub struct HourlyTable {
    path: PathBuf,
    labels: RowLabels,
    to: Target,
}

enum Target {
    Csv(Sink),
    Parquet(Box<ArrowWriter<Sink>>, Arc<Schema>),
}

impl HourlyTable {
    /// Begins a table; the ending of the path says its format.
    pub fn create(path: &Path, columns: &[&str], labels: &RowLabels, about: &Provenance) -> Result<Self> {
        let mut sink = Sink::file(path)?;
        let to = if path.extension().is_some_and(|ending| ending == "parquet") {
            let schema = Arc::new(schema(columns, labels, about));
            let start = || {
                let level = Compression::ZSTD(ZstdLevel::try_new(1)?);
                let properties = WriterProperties::builder().set_compression(level).build();
                ArrowWriter::try_new(sink, Arc::clone(&schema), Some(properties))
            };
            Target::Parquet(Box::new(start().map_err(|e| failed(path, e))?), schema)
        } else {
            let names = [&["time", "point"], columns].concat();
            writeln!(sink, "{}", names.join(",")).map_err(Error::io(path, "write to"))?;
            let columns = columns.iter().map(|name| CsvColumn::number(name).with_unit(UNIT));
            let columns: Vec<CsvColumn> = ["time", "point"].map(CsvColumn::text).into_iter().chain(columns).collect();
            csvw::write(path, &columns, about)?;
            Target::Csv(sink)
        };
        Ok(HourlyTable { path: path.to_owned(), labels: labels.clone(), to })
    }

    /// Writes all hours of a point: `[column][hour]`, W/m2.
    pub fn write(&mut self, point: &str, columns: &[Vec<f32>]) -> Result<()> {
        match &mut self.to {
            Target::Csv(sink) => {
                let mut text = Vec::new();
                let name = quoted(point);
                for (hour, label) in self.labels.text.iter().enumerate() {
                    text.extend_from_slice(format!("{label},{name}").as_bytes());
                    for column in columns {
                        let value = column.get(hour).copied().unwrap_or_default();
                        text.extend_from_slice(format!(",{value:.3}").as_bytes());
                    }
                    text.push(b'\n');
                }
                sink.write_all(&text).map_err(Error::io(&self.path, "write to"))
            }
            Target::Parquet(writer, schema) => {
                let mut arrays: Vec<ArrayRef> = Vec::with_capacity(columns.len() + 2);
                arrays.push(match &self.labels.instants {
                    Some(instants) => {
                        Arc::new(TimestampMicrosecondArray::from(instants.utc_us()).with_timezone(instants.zone()))
                    }
                    None => Arc::new(StringArray::from_iter_values(&self.labels.text)),
                });
                arrays.push(Arc::new(StringArray::from_iter_values(std::iter::repeat_n(point, self.labels.len()))));
                arrays.extend(columns.iter().map(|column| Arc::new(Float32Array::from(column.clone())) as ArrayRef));
                let batch = RecordBatch::try_new(Arc::clone(schema), arrays);
                let written = batch.map_err(ParquetError::from).and_then(|batch| {
                    writer.write(&batch)?;
                    // A point is a row group: memory stays that of one.
                    writer.flush()
                });
                written.map_err(|e| failed(&self.path, e))
            }
        }
    }

    /// Makes the table visible.
    pub fn finish(self) -> Result<()> {
        let sink = match self.to {
            Target::Csv(sink) => sink,
            Target::Parquet(writer, _) => writer.into_inner().map_err(|e| failed(&self.path, e))?,
        };
        sink.finish().map(|_| ())
    }
}

/// A name as a cell of CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

fn schema(columns: &[&str], labels: &RowLabels, about: &Provenance) -> Schema {
    let time = match &labels.instants {
        Some(instants) => DataType::Timestamp(TimeUnit::Microsecond, Some(instants.zone().into())),
        None => DataType::Utf8,
    };
    let first = [Field::new("time", time, false), Field::new("point", DataType::Utf8, false)];
    let value = |name: &&str| {
        let unit = [("unit".to_string(), UNIT.to_string())];
        Field::new(*name, DataType::Float32, false).with_metadata(Metadata::from(unit))
    };
    let fields: Vec<Field> = first.into_iter().chain(columns.iter().map(value)).collect();
    Schema::new_with_metadata(fields, about.entries().into_iter().collect::<Metadata>())
}

fn failed(path: &Path, error: ParquetError) -> Error {
    let source = match error {
        ParquetError::External(source) => source,
        other => Box::new(ArrowError::ParquetError(other.to_string())),
    };
    Error::io(path, "write")(std::io::Error::other(source))
}
