//! Tests of [`super`].

use super::*;
use crate::outputs::groups::GroupGeometry;
use crate::outputs::provenance;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::row_maker::RowMaker;
use crate::outputs::tables::bin_labels::{BinLabels, Precision};
use crate::outputs::tables::layout::{BinKind, By, Layout};
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::RowAccessor;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::values::TileValues;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::utc_offset::UtcOffset;

/// Table of results, and what makes its rows.
pub(in crate::outputs) struct ResultTable(RowMaker, Table);

impl ResultTable {
    pub fn create(path: &Path, layout: &Layout, bins: &BinLabels, places: &Places, about: &Provenance) -> Result<Self> {
        let rows = RowMaker::new(layout.clone(), bins.clone(), None);
        let table = rows.table(path, places, about)?;
        Ok(ResultTable(rows, table))
    }

    pub fn write_tile(&mut self, names: &[String], values: &PlaceValues, extents: &[GroupGeometry]) -> Result<()> {
        self.0.write(&mut self.1, names, values, extents)
    }

    pub fn finish(self) -> Result<Stats> {
        self.1.finish()
    }
}

/// Returns a layout of all columns.
fn all(labels: BinKind) -> Layout {
    Layout::of_components(labels, By::Receiver, &ComponentList::all())
}

pub(in crate::outputs) fn create(
    path: &Path,
    layout: &Layout,
    labels: &[String],
    receivers: &[String],
) -> Result<ResultTable> {
    let places = Places { count: receivers.len() as u64, names: &|| Ok(receivers.to_vec()) };
    let labels = BinLabels::words(labels.to_vec());
    ResultTable::create(path, layout, &labels, &places, &provenance::tests::example())
}

pub(in crate::outputs) fn names(prefix: &str, count: usize) -> Vec<String> {
    (0..count).map(|i| format!("{prefix}{i}")).collect()
}

/// Returns the value of component c, receiver r (of the whole table), label l; zero for half of the
/// labels.
pub(in crate::outputs) fn value(c: usize, r: usize, l: usize) -> f32 {
    if l % 24 < 12 {
        return 0.0;
    }
    // Values have noise in all bits of the mantissa, as real results have.
    let seed = (r * 8760 + l) as u64 * 7 + c as u64;
    let mixed = (seed ^ (seed >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let noise = (mixed >> 40) as f32 / (1_u64 << 24) as f32;
    (1.0 + noise) * [300.0, 90.0, 20.0, 9.0, 1.0, 0.3, 420.0][c]
}

pub(in crate::outputs) fn tile(first: usize, receivers: usize, labels: usize) -> TileValues {
    let mut t = TileValues::new(receivers, labels);
    for c in 0..7 {
        let cells = t.component_mut(Component::ALL[c]);
        for r in 0..receivers {
            for l in 0..labels {
                cells[r * labels + l] = value(c, first + r, l);
            }
        }
    }
    t
}

/// Returns all columns of a tile.
fn all_of(values: &TileValues) -> PlaceValues<'_> {
    PlaceValues::new(&[values], &Component::ALL)
}

/// Two tiles (3 and 2 receivers x 30 labels) are read back from CSV with 150 rows in order, to the
/// 3 decimals written.
#[test]
fn csv_gives_all_rows_back_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.csv");
    let labels = names("l,", 30);
    let mut writer = create(&path, &all(BinKind::Conditions), &labels, &[]).expect("created");
    writer.write_tile(&names("r", 3), &all_of(&tile(0, 3, 30)), &[]).expect("written");
    writer.write_tile(&names("s", 2), &all_of(&tile(3, 2, 30)), &[]).expect("written");
    let stats = writer.finish().expect("finished");
    let text = std::fs::read_to_string(&path).expect("read");
    let beside = std::fs::metadata(folder.path().join("t.csv-metadata.json")).expect("metadata").len();
    assert_eq!((stats.rows, stats.bytes), (150, text.len() as u64 + beside));
    let head = "condition,receiver,sun_direct,sky_direct,sun_reflected,sky_reflected,sun_mirrored,sky_mirrored,total\n";
    assert!(text.starts_with(head), "{text}");
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    let mut rows = 0;
    for (i, record) in reader.records().enumerate() {
        let record = record.expect("a row");
        let (r, l) = (i / 30, i % 30);
        let receiver = if r < 3 { format!("r{r}") } else { format!("s{}", r - 3) };
        assert_eq!((&record[0], &record[1]), (labels[l].as_str(), receiver.as_str()));
        for c in 0..7 {
            let got: f32 = record[2 + c].parse().expect("a number");
            assert!((got - value(c, r, l)).abs() < 6e-4, "{got}");
        }
        rows += 1;
    }
    assert_eq!(rows, 150);
}

/// Three tiles (4, 4 and 2 receivers x 48 labels) are read back from Parquet bit for bit: 480 rows
/// in 3 row groups, with the unit of each of the 7 value columns in the metadata.
#[test]
fn parquet_gives_all_values_back_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.parquet");
    let labels = names("2019-01-", 48);
    let mut writer = create(&path, &all(BinKind::Sums), &labels, &[]).expect("created");
    let receivers = names("r", 10);
    for (first, count) in [(0, 4), (4, 4), (8, 2)] {
        let part = &receivers[first..first + count];
        writer.write_tile(part, &all_of(&tile(first, count, 48)), &[]).expect("written");
    }
    let stats = writer.finish().expect("finished");
    let file = std::fs::File::open(&path).expect("open");
    assert_eq!(stats, Stats { rows: 480, bytes: file.metadata().expect("size").len() });
    let reader = SerializedFileReader::new(file).expect("a Parquet file");
    assert_eq!(reader.num_row_groups(), 3);
    let metadata = reader.metadata().file_metadata().clone();
    let units = metadata.key_value_metadata().expect("units");
    assert_eq!(units.iter().filter(|kv| kv.value.as_deref() == Some("kWh/m2")).count(), 7);
    assert_eq!(metadata.schema_descr().column(8).name(), "total_kwh_m2");
    let mut rows = 0;
    for (i, row) in reader.get_row_iter(None).expect("rows").enumerate() {
        let row = row.expect("a row");
        let (r, l) = (i / 48, i % 48);
        assert_eq!(row.get_string(0).expect("label"), &labels[l]);
        assert_eq!(row.get_string(1).expect("receiver"), &receivers[r]);
        for c in 0..7 {
            assert_eq!(row.get_float(2 + c).expect("a value"), value(c, r, l));
        }
        rows += 1;
    }
    assert_eq!(rows, 480);
}

/// An unknown ending is refused with all 6 endings named, before a file is made; a wrong shape is
/// refused; an empty table has 0 rows and a header.
#[test]
fn an_unknown_ending_is_refused_with_all_endings() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["t.xlsx", "t", ".csv"] {
        let error = create(&folder.path().join(name), &all(BinKind::Times), &[], &[]).err();
        let text = error.map(|e| e.to_string()).unwrap_or_default();
        assert!(text.contains(".csv, .parquet, .arrow, .feather, .npy and .npz"), "{text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    for name in ["t.csv", "t.PARQUET", "t.arrow", "t.Feather", "t.npz", "t.npy"] {
        let path = folder.path().join(name);
        let mut writer = create(&path, &all(BinKind::Times), &names("t", 2), &[]).expect("created");
        assert!(writer.write_tile(&names("r", 2), &all_of(&tile(0, 2, 3)), &[]).is_err());
        assert!(writer.write_tile(&names("r", 3), &all_of(&tile(0, 2, 2)), &[]).is_err());
        writer.write_tile(&[], &all_of(&tile(0, 0, 2)), &[]).expect("nothing to write");
        let stats = writer.finish().expect("finished");
        assert!(stats.rows == 0 && stats.bytes > 70, "{stats:?}");
    }
}

/// 16 receivers x 8760 hours of noise, half of the hours zero, take less than 14 bytes a row of
/// Parquet (7 values are 28).
///
/// Measured in release for 480 receivers (HELIOTILE_ROWS=480, one of 2 shared cores, best of 3):
/// Parquet 0.8 s, 46 MB (values plain 56 MB, as dictionary 87 MB); CSV 0.7 s, 284 MB; `.arrow` 0.5
/// s, 168 MB; `.feather` 0.6 s, 52 MB; `.npy` 0.3 s, `.npz` 0.7 s, 118 MB.
#[test]
fn a_year_takes_less_than_14_bytes_a_row() {
    let count: usize = std::env::var("HELIOTILE_ROWS").ok().and_then(|n| n.parse().ok()).unwrap_or(16);
    let folder = tempfile::tempdir().expect("a folder");
    let date = |day: u32| Date::new(2019, 1 + day / 31, 1 + day % 31);
    let days = (0..372).filter_map(date);
    let moments: Vec<_> = days.flat_map(|date| (0..24).map(move |hour| (date, f64::from(60 * hour)))).collect();
    let labels = BinLabels::moments(&moments, UtcOffset::of_hours(1.0), Precision::Minute);
    assert_eq!(labels.len(), 8760);
    let receivers = names("receiver_", count);
    for ending in ["parquet", "csv", "arrow", "feather", "npy", "npz"] {
        let path = folder.path().join(format!("t.{ending}"));
        let tiles: Vec<_> = (0..count.div_ceil(64)).map(|t| tile(t * 64, (count - t * 64).min(64), 8760)).collect();
        let start = std::time::Instant::now();
        let places = Places { count: count as u64, names: &|| Ok(receivers.clone()) };
        let about = provenance::tests::example();
        let mut writer = ResultTable::create(&path, &all(BinKind::Times), &labels, &places, &about).expect("created");
        for (tile, names) in tiles.iter().zip(receivers.chunks(64)) {
            writer.write_tile(names, &all_of(tile), &[]).expect("written");
        }
        let stats = writer.finish().expect("finished");
        println!("{ending}: {stats:?} {:.2} s", start.elapsed().as_secs_f64());
        assert!(ending != "parquet" || stats.bytes < stats.rows * 14, "{stats:?}");
    }
}
