//! Maps as GeoParquet 1.1, which geopandas, DuckDB and GDAL read. In: rows. Out: one file; polygons
//! as WKB (OGC 06-103r4), a column with their bounding boxes, and the key `geo` that describes
//! both.

use std::sync::Arc;

use arrow_array::builder::{
    BinaryBuilder, BooleanBuilder, Float32Builder, Float64Builder, Int64Builder, StringBuilder,
};
use arrow_array::{ArrayRef, RecordBatch, StructArray};
use arrow_schema::{DataType, Field, Fields, Metadata, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde_json::json;

use super::columns::MapColumns;
use super::crs::MapCrs;
use super::row::MapRow;
use super::rows::MapRows;
use super::stated::TextKind;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// Rows that are in memory at a time; `GROUP_ROWS` are those of a row group.
const ROWS_AT_ONCE: usize = 4096;
const GROUP_ROWS: usize = 32_768;

/// Name of the geometry column; `BOX` is the column of bounding boxes.
const GEOMETRY: &str = "geometry";
const BOX: &str = "bbox";
const CORNERS: [&str; 4] = ["xmin", "ymin", "xmax", "ymax"];

/// WKB type of a polygon with heights; `MULTIPOLYGON_Z` is that of a multipolygon.
const POLYGON_Z: u32 = 1003;
const MULTIPOLYGON_Z: u32 = 1006;

/// Columns of some rows.
struct Batch {
    texts: Vec<TextColumn>,
    numbers: Vec<Float32Builder>,
    corners: [Float64Builder; 4],
    geometry: BinaryBuilder,
    rows: usize,
}

/// Column of texts, or of typed values that texts stand for.
enum TextColumn {
    Text(StringBuilder),
    Whole(Int64Builder),
    Number(Float64Builder),
    Truth(BooleanBuilder),
}

impl TextColumn {
    fn new(kind: TextKind) -> Self {
        match kind {
            TextKind::Text => TextColumn::Text(StringBuilder::new()),
            TextKind::Whole => TextColumn::Whole(Int64Builder::new()),
            TextKind::Number => TextColumn::Number(Float64Builder::new()),
            TextKind::Truth => TextColumn::Truth(BooleanBuilder::new()),
        }
    }

    fn append(&mut self, text: &str) {
        match self {
            TextColumn::Text(column) => column.append_option((!text.is_empty()).then_some(text)),
            TextColumn::Whole(column) => column.append_option(text.parse().ok()),
            TextColumn::Number(column) => column.append_option(text.parse().ok()),
            TextColumn::Truth(column) => column.append_option(text.parse().ok()),
        }
    }

    fn finish(&mut self) -> ArrayRef {
        match self {
            TextColumn::Text(column) => Arc::new(column.finish()),
            TextColumn::Whole(column) => Arc::new(column.finish()),
            TextColumn::Number(column) => Arc::new(column.finish()),
            TextColumn::Truth(column) => Arc::new(column.finish()),
        }
    }
}

impl Batch {
    fn new(columns: &MapColumns) -> Self {
        Batch {
            texts: columns.kinds.iter().map(|kind| TextColumn::new(*kind)).collect(),
            numbers: columns.numbers.iter().map(|_| Float32Builder::new()).collect(),
            corners: Default::default(),
            geometry: BinaryBuilder::new(),
            rows: 0,
        }
    }

    fn add(&mut self, row: &MapRow, crs: &MapCrs) {
        for (column, text) in self.texts.iter_mut().zip(&row.texts) {
            column.append(text);
        }
        for (column, number) in self.numbers.iter_mut().zip(&row.numbers) {
            column.append_option(number.is_finite().then_some(*number));
        }
        let mut found = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for corner in row.polygons.iter().flat_map(|polygon| polygon.corners()) {
            let [x, y, _] = crs.coordinates(*corner);
            found = [found[0].min(x), found[1].min(y), found[2].max(x), found[3].max(y)];
        }
        self.corners.iter_mut().zip(found).for_each(|(column, value)| column.append_value(value));
        self.geometry.append_value(wkb(row, crs));
        self.rows += 1;
    }

    fn finish(&mut self, schema: &Arc<Schema>) -> std::result::Result<RecordBatch, ParquetError> {
        let corners = self.corners.iter_mut().map(|column| Arc::new(column.finish()) as ArrayRef).collect();
        let boxes = StructArray::new(box_fields(), corners, None);
        let texts = self.texts.iter_mut().map(TextColumn::finish);
        let numbers = self.numbers.iter_mut().map(|column| Arc::new(column.finish()) as ArrayRef);
        let mut columns: Vec<ArrayRef> = texts.chain(numbers).collect();
        columns.push(Arc::new(boxes));
        columns.push(Arc::new(self.geometry.finish()));
        self.rows = 0;
        Ok(RecordBatch::try_new(schema.clone(), columns)?)
    }
}

/// Writes the file.
pub fn write(sink: Sink, rows: &mut MapRows, columns: &MapColumns, crs: &MapCrs, about: &Provenance) -> Result<u64> {
    let path = sink.path().to_owned();
    let failed = |error: ParquetError| Error::io(&path, "write to")(std::io::Error::other(error));
    let schema = Arc::new(schema(columns, about));
    let mut notes: Vec<KeyValue> =
        about.entries().into_iter().map(|(name, value)| KeyValue::new(name, value)).collect();
    notes.push(KeyValue::new("geo".into(), geo(rows, crs)));
    let level = ZstdLevel::try_new(3).map_err(failed)?;
    let properties = WriterProperties::builder()
        .set_created_by(concat!("heliotile ", env!("CARGO_PKG_VERSION")).to_string())
        .set_compression(Compression::ZSTD(level))
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(notes))
        .build();
    let mut writer = ArrowWriter::try_new(sink, schema.clone(), Some(properties)).map_err(failed)?;
    let mut batch = Batch::new(columns);
    rows.each(|row| {
        batch.add(row, crs);
        if batch.rows < ROWS_AT_ONCE {
            return Ok(());
        }
        let whole = batch.finish(&schema).and_then(|batch| writer.write(&batch));
        whole.map_err(failed)
    })?;
    if batch.rows > 0 {
        batch.finish(&schema).and_then(|batch| writer.write(&batch)).map_err(failed)?;
    }
    writer.into_inner().map_err(failed)?.finish()
}

/// Returns the value of the key `geo` (GeoParquet 1.1.0).
fn geo(rows: &MapRows, crs: &MapCrs) -> String {
    let [low, high] = rows.facts.bounds.map(|corner| crs.coordinates(corner));
    let types = match rows.facts.polygons > rows.facts.rows {
        true => vec!["Polygon Z", "MultiPolygon Z"],
        false => vec!["Polygon Z"],
    };
    let covering: serde_json::Map<_, _> =
        CORNERS.into_iter().map(|corner| (corner.to_owned(), json!([BOX, corner]))).collect();
    json!({
        "version": "1.1.0", "primary_column": GEOMETRY,
        "columns": {GEOMETRY: {
            "encoding": "WKB", "geometry_types": types, "crs": crs.projjson(), "edges": "planar",
            "bbox": low.into_iter().chain(high).collect::<Vec<f64>>(), "covering": {"bbox": covering},
        }},
    })
    .to_string()
}

fn box_fields() -> Fields {
    CORNERS.iter().map(|corner| Field::new(*corner, DataType::Float64, false)).collect()
}

fn schema(columns: &MapColumns, about: &Provenance) -> Schema {
    let texts = columns.texts.iter().zip(&columns.kinds).map(|(name, kind)| {
        let kind = match kind {
            TextKind::Text => DataType::Utf8,
            TextKind::Whole => DataType::Int64,
            TextKind::Number => DataType::Float64,
            TextKind::Truth => DataType::Boolean,
        };
        Field::new(name, kind, true)
    });
    let numbers = columns.numbers.iter().map(|(name, unit)| {
        let unit = Metadata::from([("unit".to_string(), (*unit).to_string())]);
        Field::new(name, DataType::Float32, true).with_metadata(unit)
    });
    let geometry =
        [Field::new(BOX, DataType::Struct(box_fields()), false), Field::new(GEOMETRY, DataType::Binary, false)];
    let fields: Vec<Field> = texts.chain(numbers).chain(geometry).collect();
    Schema::new_with_metadata(fields, about.entries().into_iter().collect::<Metadata>())
}

/// Returns the little-endian WKB of a row: a polygon if it has exactly one, or else a multipolygon.
fn wkb(row: &MapRow, crs: &MapCrs) -> Vec<u8> {
    let mut bytes = Vec::new();
    let head = |bytes: &mut Vec<u8>, kind: u32, count: usize| {
        bytes.push(1);
        bytes.extend(kind.to_le_bytes());
        bytes.extend((count as u32).to_le_bytes());
    };
    if row.polygons.len() != 1 {
        head(&mut bytes, MULTIPOLYGON_Z, row.polygons.len());
    }
    for polygon in &row.polygons {
        head(&mut bytes, POLYGON_Z, polygon.rings.len());
        for ring in &polygon.rings {
            bytes.extend((ring.len() as u32 + 1).to_le_bytes());
            let closed = ring.iter().chain(ring.first());
            closed.flat_map(|corner| crs.coordinates(*corner)).for_each(|number| bytes.extend(number.to_le_bytes()));
        }
    }
    bytes
}
