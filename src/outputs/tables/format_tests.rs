//! Tests of the formats that other programs read: what is written comes back bit for bit.

use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Int32Type};
use arrow_ipc::reader::FileReader;
use arrow_schema::{DataType, Schema};
use parquet::arrow::parquet_to_arrow_schema;
use parquet::file::reader::{FileReader as _, SerializedFileReader};

use crate::outputs::tables::layout::{By, Labels, Layout};
use crate::outputs::tables::writer::tests::{create, names, tile, value};
use heliotile_core::replay::components::Component;

/// Two columns, the last one first.
fn layout() -> Layout {
    Layout { labels: Labels::Sums, by: By::Surface, components: "total,sky_direct".parse().expect("names") }
}

/// 2 + 1 receivers x 48 labels in a file of a kind.
fn written(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    let path = folder.path().join(name);
    let receivers = names("été ", 3);
    let mut writer = create(&path, &layout(), &names("l", 48), &receivers).expect("created");
    writer.write_tile(&receivers[..2], &tile(0, 2, 48)).expect("written");
    writer.write_tile(&receivers[2..], &tile(2, 1, 48)).expect("written");
    assert_eq!(writer.finish().expect("finished").rows, 144);
    path
}

/// Both strings are dictionaries, both values f32 with their unit in the field: 2 and 2 fields.
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

/// Plain and compressed Arrow files give the 144 rows in 2 batches, their names from one dictionary each.
#[test]
fn arrow_round_trip() {
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

/// Parquet's metadata hold the Arrow schema: 2 dictionaries and 2 values with units; each of the 2 row groups has a
/// Bloom filter of its names.
#[test]
fn parquet_holds_the_arrow_schema() {
    let folder = tempfile::tempdir().expect("a folder");
    let reader = SerializedFileReader::new(File::open(written(&folder, "t.parquet")).expect("open")).expect("Parquet");
    let filters = reader.metadata().row_groups().iter().filter_map(|g| g.column(1).bloom_filter_length());
    assert_eq!(filters.count(), 2);
    let metadata = reader.metadata().file_metadata();
    check(&parquet_to_arrow_schema(metadata.schema_descr(), metadata.key_value_metadata()).expect("a schema"));
}

/// Values of an array of 3 x 48 x 2: `[surface][label][column]`.
fn check_values(array: &[u8]) {
    let head = b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f4', 'fortran_order': False, 'shape': (3, 48, 2), }";
    assert!(array.starts_with(head) && array.len() == 128 + 3 * 48 * 2 * 4);
    for (i, bytes) in array[128..].chunks_exact(4).enumerate() {
        let component = [Component::Total, Component::SkyDirect][i % 2] as usize;
        let got = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        assert_eq!(got, value(component, i / 96, i / 2 % 48), "{i}");
    }
}

/// An `.npy` file holds the 288 values, the file beside it the names of its 3 axes; nothing else is left in the folder.
#[test]
fn npy_and_axes() {
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

/// An `.npz` file holds the same array and 4 of strings in UTF-32; a table with a receiver too few is refused and leaves no
/// file.
#[test]
fn npz_round_trip() {
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
        writer.write_tile(&names("r", 2), &tile(0, 2, 48)).expect("written");
        let text = writer.finish().expect_err("too few").to_string();
        assert!(text.contains("2 receivers came, 3 were announced"), "{text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}
