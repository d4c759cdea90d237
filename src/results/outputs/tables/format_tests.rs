//! Tests of the formats that other programs read: written values are read back bit for bit.

use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Int32Type, TimestampMicrosecondType};
use arrow_ipc::reader::FileReader;
use arrow_schema::{DataType, Metadata, Schema, TimeUnit};
use parquet::arrow::parquet_to_arrow_schema;
use parquet::basic::{Encoding, LogicalType};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::RowAccessor;

use crate::outputs::provenance;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::tables::bin_labels::{BinLabels, Precision};
use crate::outputs::tables::layout::{BinKind, By, Layout};
use crate::outputs::tables::table::tests::ResultTable;
use crate::outputs::tables::table::tests::{create, names, tile, value};
use crate::outputs::tables::writer::Places;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::utc_offset::UtcOffset;

/// Returns hours from 2019-03-01 on in a time zone.
fn hours(count: u32, zone_hours: f64) -> BinLabels {
    let date = Date::new(2019, 3, 1).expect("a date");
    let moments: Vec<_> = (0..count).map(|hour| (date, f64::from(60 * hour))).collect();
    BinLabels::moments(&moments, UtcOffset::of_hours(zone_hours), Precision::Minute)
}

/// Writes a file with 2 receivers x 24 hours of a time zone.
fn written_hours(folder: &tempfile::TempDir, name: &str, zone_hours: f64) -> PathBuf {
    let path = folder.path().join(name);
    let layout = Layout { bins: BinKind::Times, ..layout() };
    let receivers = names("r", 2);
    let places = Places { count: 2, names: &|| Ok(receivers.clone()) };
    let about = provenance::tests::example();
    let mut writer = ResultTable::create(&path, &layout, &hours(24, zone_hours), &places, &about).expect("created");
    writer.write_tile(&receivers, &two_of(&tile(0, 2, 24)), &[]).expect("written");
    assert_eq!(writer.finish().expect("finished").rows, 48);
    path
}

/// Midnight of 1 March 2019 at +01:00, microseconds of UTC.
const FIRST_US: i64 = 1_551_394_800_000_000;
const HOUR_US: i64 = 3_600_000_000;

/// Returns the times of two receivers, one after the other.
fn expected_us() -> Vec<i64> {
    (0..48).map(|row| FIRST_US + row % 24 * HOUR_US).collect()
}

/// Checks that the metadata of a schema have the 4 entries of provenance, with the options as JSON.
fn check_provenance(metadata: &Metadata) {
    assert_eq!(metadata.iter().filter(|(name, _)| name.starts_with("heliotile.")).count(), 4);
    assert_eq!(metadata.get("heliotile.options").map(String::as_str), Some(r#"{"every":"hour"}"#));
    assert_eq!(metadata.get("heliotile.command").map(String::as_str), Some("heliotile replay été.helio"));
}

/// Hours in Arrow files are timestamps in microseconds with their zone, `+01:00` or, at half hours,
/// the name of one; 48 values count from midnight of that zone, and the schema has the provenance.
#[test]
fn times_in_arrow_have_their_zone() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, zone_hours, zone) in
        [("t.arrow", 1.0, "+01:00"), ("t.feather", 5.5, "Asia/Kolkata"), ("n.arrow", -3.5, "-03:30")]
    {
        let file = File::open(written_hours(&folder, name, zone_hours)).expect("open");
        let reader = FileReader::try_new(file, None).expect("an Arrow file");
        let expected = DataType::Timestamp(TimeUnit::Microsecond, Some(zone.into()));
        assert_eq!(reader.schema().field(0).data_type(), &expected);
        check_provenance(reader.schema().metadata());
        let batches: Vec<_> = reader.map(|batch| batch.expect("a batch")).collect();
        let times = batches[0].column(0).as_primitive::<TimestampMicrosecondType>();
        let shift = ((zone_hours - 1.0) * 3.6e9) as i64;
        assert_eq!(times.values().iter().map(|us| us + shift).collect::<Vec<_>>(), expected_us());
    }
}

/// Hours in Parquet are 64-bit microseconds of UTC with the logical type of instants, encoded as
/// differences: 48 values. The Arrow schema in the metadata has the zone, and both hold the
/// provenance.
#[test]
fn times_in_parquet_are_instants_of_utc() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = File::open(written_hours(&folder, "t.parquet", 1.0)).expect("open");
    let reader = SerializedFileReader::new(file).expect("Parquet");
    let metadata = reader.metadata().file_metadata();
    let column = metadata.schema_descr().column(0);
    assert_eq!(column.logical_type_ref(), Some(&LogicalType::timestamp(true, parquet::basic::TimeUnit::MICROS)));
    assert_eq!(column.physical_type(), parquet::basic::Type::INT64);
    let chunk = reader.metadata().row_group(0).column(0);
    assert!(chunk.encodings().any(|encoding| encoding == Encoding::DELTA_BINARY_PACKED));
    let times = reader.get_row_iter(None).expect("rows").map(|row| row.expect("a row").get_timestamp_micros(0));
    assert_eq!(times.map(|us| us.expect("a time")).collect::<Vec<_>>(), expected_us());
    let pairs = metadata.key_value_metadata().expect("metadata");
    assert_eq!(pairs.iter().filter(|pair| pair.key.starts_with("heliotile.")).count(), 4);
    let schema = parquet_to_arrow_schema(metadata.schema_descr(), metadata.key_value_metadata()).expect("a schema");
    let zoned = DataType::Timestamp(TimeUnit::Microsecond, Some("+01:00".into()));
    assert_eq!(schema.field(0).data_type(), &zoned);
    check_provenance(schema.metadata());
}

/// Hours of an `.npz` file are readings of the local clock in seconds; the first of 24 is midnight
/// of 1 March 2019. An array beside them has the clock's offset from UTC: 60 minutes. Provenance is
/// JSON, as in the axes of an `.npy` file, whose times have the offset.
#[test]
fn times_in_numpy_are_local_readings() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = File::open(written_hours(&folder, "t.npz", 1.0)).expect("open");
    let mut zip = zip::ZipArchive::new(file).expect("a zip archive");
    let mut array = |name: &str| {
        let mut bytes = Vec::new();
        zip.by_name(name).expect("an array").read_to_end(&mut bytes).expect("read");
        bytes
    };
    let whole = |bytes: &[u8]| i64::from_le_bytes(bytes.try_into().expect("8 bytes"));
    let times = array("time.npy");
    assert!(times[10..].starts_with(b"{'descr': '<M8[s]', 'fortran_order': False, 'shape': (24,), }"));
    let seconds: Vec<i64> = times[128..].chunks_exact(8).map(whole).collect();
    assert_eq!((seconds.len(), seconds[0], seconds[23]), (24, 1_551_398_400, 1_551_398_400 + 23 * 3600));
    let offset = array("utc_offset.npy");
    let head = String::from_utf8_lossy(&offset[10..offset.len() - 8]).trim().to_string();
    assert_eq!(head, "{'descr': '<m8[m]', 'fortran_order': False, 'shape': (), }");
    assert_eq!(whole(&offset[offset.len() - 8..]), 60);
    let letters = array("provenance.npy");
    let text: String = letters[128..]
        .chunks_exact(4)
        .filter_map(|b| char::from_u32(u32::from_le_bytes([b[0], b[1], b[2], b[3]])))
        .collect();
    let provenance: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(provenance["heliotile.options"]["every"], "hour");

    written_hours(&folder, "t.npy", 1.0);
    let axes = std::fs::read_to_string(folder.path().join("t.axes.json")).expect("axes");
    let axes: serde_json::Value = serde_json::from_str(&axes).expect("JSON");
    assert_eq!((&axes["time"][6], &axes["provenance"]), (&serde_json::json!("2019-03-01T06:00+01:00"), &provenance));
}

/// A CSV file of hours has times with their offset, and a metadata file beside it with its name and
/// its 4 columns; nothing else is in the folder.
#[test]
fn times_in_csv_have_their_offset() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written_hours(&folder, "t.csv", 5.5);
    let text = std::fs::read_to_string(&path).expect("read");
    assert_eq!(text.lines().filter(|line| line.starts_with("2019-03-01T06:00+05:30,r")).count(), 2);
    let beside = std::fs::read_to_string(folder.path().join("t.csv-metadata.json")).expect("metadata");
    let beside: serde_json::Value = serde_json::from_str(&beside).expect("JSON");
    let columns = beside["tableSchema"]["columns"].as_array().map(Vec::len);
    assert_eq!((&beside["url"], columns), (&serde_json::json!("t.csv"), Some(4)));
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2);
}

/// Returns a layout of two columns in the order total, sky_direct.
fn layout() -> Layout {
    Layout::of_components(BinKind::Sums, By::Surface, &"total,sky_direct".parse().expect("names"))
}

/// Returns the columns of one tile.
fn two_of(values: &TileValues) -> PlaceValues<'_> {
    PlaceValues::new(&[values], &[Component::Total, Component::SkyDirect])
}

/// Writes a file of 2 + 1 receivers x 48 labels.
fn written(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    let path = folder.path().join(name);
    let receivers = names("été ", 3);
    let mut writer = create(&path, &layout(), &names("l", 48), &receivers).expect("created");
    writer.write_tile(&receivers[..2], &two_of(&tile(0, 2, 48)), &[]).expect("written");
    writer.write_tile(&receivers[2..], &two_of(&tile(2, 1, 48)), &[]).expect("written");
    assert_eq!(writer.finish().expect("finished").rows, 144);
    path
}

/// Checks that both text columns are dictionaries and both value columns f32 with their unit in the
/// field: 2 and 2 fields.
fn check(schema: &Schema) {
    let text =
        |i: usize| matches!(schema.field(i).data_type(), DataType::Dictionary(_, values) if **values == DataType::Utf8);
    assert!(text(0) && text(1) && schema.fields().len() == 4, "{schema}");
    for (i, name) in [(2, "total_kwh_m2"), (3, "sky_direct_kwh_m2")] {
        let field = schema.field(i);
        assert_eq!((field.name().as_str(), field.data_type()), (name, &DataType::Float32));
        assert_eq!(field.metadata().get("unit").map(String::as_str), Some("kWh/m2"));
    }
}

/// Plain and compressed Arrow files have the 144 rows in 2 batches, with names from one dictionary
/// a column.
#[test]
fn arrow_files_hold_all_rows_in_2_batches() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["t.arrow", "t.feather"] {
        let file = File::open(written(&folder, name)).expect("open");
        let reader = FileReader::try_new(file, None).expect("an Arrow file");
        check(&reader.schema());
        let batches: Vec<_> = reader.map(|batch| batch.expect("a batch")).collect();
        assert_eq!(batches.iter().map(|b| b.num_rows()).collect::<Vec<_>>(), [96, 48]);
        for (first, batch) in [(0, &batches[0]), (2, &batches[1])] {
            let strings =
                |i: usize| batch.column(i).as_dictionary::<Int32Type>().downcast_dict::<arrow_array::StringArray>();
            let (labels, surfaces) = (strings(0).expect("labels"), strings(1).expect("surfaces"));
            for row in 0..batch.num_rows() {
                let (r, l) = (first + row / 48, row % 48);
                use arrow_array::ArrayAccessor;
                assert_eq!((labels.value(row), surfaces.value(row)), (&*format!("l{l}"), &*format!("été {r}")));
                let floats = |i: usize| batch.column(i).as_primitive::<Float32Type>().value(row);
                assert_eq!((floats(2), floats(3)), (value(6, r, l), value(1, r, l)));
            }
        }
    }
}

/// Parquet's metadata hold the Arrow schema with 2 dictionaries and 2 values with units; each of
/// the 2 row groups has a Bloom filter of its names.
#[test]
fn parquet_holds_the_arrow_schema() {
    let folder = tempfile::tempdir().expect("a folder");
    let reader = SerializedFileReader::new(File::open(written(&folder, "t.parquet")).expect("open")).expect("Parquet");
    let filters = reader.metadata().row_groups().iter().filter_map(|g| g.column(1).bloom_filter_length());
    assert_eq!(filters.count(), 2);
    let metadata = reader.metadata().file_metadata();
    check(&parquet_to_arrow_schema(metadata.schema_descr(), metadata.key_value_metadata()).expect("a schema"));
}

/// Checks the values of an array of 3 x 48 x 2: `[surface][label][column]`.
fn check_values(array: &[u8]) {
    let head = b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f4', 'fortran_order': False, 'shape': (3, 48, 2), }";
    assert!(array.starts_with(head) && array.len() == 128 + 3 * 48 * 2 * 4);
    for (i, bytes) in array[128..].chunks_exact(4).enumerate() {
        let component = [Component::Total, Component::SkyDirect][i % 2] as usize;
        let got = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        assert_eq!(got, value(component, i / 96, i / 2 % 48), "{i}");
    }
}

/// An `.npy` file holds the 288 values, the file beside it the names of its 3 axes; nothing else is
/// left in the folder.
#[test]
fn an_npy_file_has_its_axes_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written(&folder, "t.npy");
    check_values(&std::fs::read(&path).expect("read"));
    let text = std::fs::read_to_string(folder.path().join("t.axes.json")).expect("axes");
    let axes: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(axes["axes"], serde_json::json!(["surface", "time", "column"]));
    assert_eq!(axes["surface"], serde_json::json!(names("été ", 3)));
    assert_eq!(axes["time"], serde_json::json!(names("l", 48)));
    assert_eq!(axes["column"], serde_json::json!(["total_kwh_m2", "sky_direct_kwh_m2"]));
    assert_eq!(axes["unit"], "kWh/m2");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2);
}

/// An `.npz` file holds the array of values and 4 arrays of strings in UTF-32; a table that lacks
/// one receiver is refused and leaves no file.
#[test]
fn an_npz_file_holds_values_and_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut zip = zip::ZipArchive::new(File::open(written(&folder, "t.npz")).expect("open")).expect("a zip archive");
    let mut array = |name: &str| {
        let mut bytes = Vec::new();
        zip.by_name(name).expect("an array").read_to_end(&mut bytes).expect("read");
        bytes
    };
    check_values(&array("values.npy"));
    let surfaces = array("surface.npy");
    assert!(surfaces[10..].starts_with(b"{'descr': '<U5', 'fortran_order': False, 'shape': (3,), }"));
    let letters: Vec<u32> =
        surfaces[128..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let text: String = letters.into_iter().filter_map(char::from_u32).collect();
    assert_eq!(text, "été 0été 1été 2");
    assert_eq!([array("time.npy").len(), array("column.npy").len(), array("unit.npy").len()], [704, 264, 152]);

    for name in ["short.npz", "short.npy"] {
        let mut writer =
            create(&folder.path().join(name), &layout(), &names("l", 48), &names("r", 3)).expect("created");
        writer.write_tile(&names("r", 2), &two_of(&tile(0, 2, 48)), &[]).expect("written");
        let text = writer.finish().expect_err("too few").to_string();
        assert!(text.contains("2 places came, 3 were announced"), "{text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}
