//! Tables of the program: each in each format, read by independent readers, equals its CSV.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int32Type, TimestampMicrosecondType, UInt64Type,
};
use arrow_array::{Array, ArrayRef, RecordBatch, StringArray};
use arrow_schema::DataType;
use heliotile_core::weather::time::calendar::Date;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use crate::cli::{Folder, golden, stderr};

/// Cells of a column.
#[derive(Clone, Debug)]
enum Cells {
    Texts(Vec<String>),
    /// Numbers; NaN where a cell is empty.
    Numbers(Vec<f64>),
    /// Times, seconds since 1970 in UTC.
    Times(Vec<i64>),
}

type Table = BTreeMap<String, Cells>;

impl Cells {
    fn len(&self) -> usize {
        match self {
            Cells::Texts(texts) => texts.len(),
            Cells::Numbers(numbers) => numbers.len(),
            Cells::Times(times) => times.len(),
        }
    }

    /// Returns the cells at some rows.
    fn at(&self, rows: impl Iterator<Item = usize>) -> Self {
        match self {
            Cells::Texts(texts) => Cells::Texts(rows.map(|row| texts[row].clone()).collect()),
            Cells::Numbers(numbers) => Cells::Numbers(rows.map(|row| numbers[row]).collect()),
            Cells::Times(times) => Cells::Times(rows.map(|row| times[row]).collect()),
        }
    }

    fn append(&mut self, more: Cells) {
        match (self, more) {
            (Cells::Texts(all), Cells::Texts(more)) => all.extend(more),
            (Cells::Numbers(all), Cells::Numbers(more)) => all.extend(more),
            (Cells::Times(all), Cells::Times(more)) => all.extend(more),
            (one, other) => panic!("{one:?} {other:?}"),
        }
    }

    /// Asserts that the cells are those of a CSV file, to the decimals that it has.
    fn check(&self, csv: &[String], called: &str) {
        assert_eq!(self.len(), csv.len(), "{called}");
        match self {
            Cells::Texts(texts) => assert_eq!(texts, csv, "{called}"),
            Cells::Times(times) => {
                let expected: Vec<i64> = csv.iter().map(|cell| seconds_of(cell)).collect();
                assert_eq!(times, &expected, "{called}");
            }
            Cells::Numbers(numbers) => {
                for (number, cell) in numbers.iter().zip(csv) {
                    let decimals = cell.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
                    let expected: f64 = if cell.is_empty() { f64::NAN } else { cell.parse().expect("a number") };
                    let room = 0.51 * 10_f64.powi(-decimals) + 1e-6 * expected.abs();
                    let fits = (number - expected).abs() <= room || (number.is_nan() && expected.is_nan());
                    assert!(fits, "{called}: {number} for `{cell}`");
                }
            }
        }
    }
}

/// Parses `2019-03-01T06:00+01:00` as seconds since 1970 in UTC; months, which state no zone, begin
/// at -07:00 as those of the golden weather do.
fn seconds_of(time: &str) -> i64 {
    if time.len() == 7 {
        return seconds_of(&format!("{time}-01T00:00-07:00"));
    }
    let part = |range: std::ops::Range<usize>| -> i64 { time[range].parse().expect("digits") };
    let date = Date::new(part(0..4) as i32, part(5..7) as u32, part(8..10) as u32).expect("a date");
    let offset = 60 * part(17..19) + part(20..22);
    let minutes = 60 * part(11..13) + part(14..16) - if &time[16..17] == "-" { -offset } else { offset };
    86_400 * i64::from(date.day_number()) + 60 * minutes
}

/// Reads the names of columns in order, and their cells.
fn csv_table(path: &Path) -> Vec<(String, Vec<String>)> {
    let mut reader = csv::Reader::from_path(path).expect("CSV");
    let mut columns: Vec<(String, Vec<String>)> =
        reader.headers().expect("a header").iter().map(|name| (name.to_owned(), Vec::new())).collect();
    for record in reader.records() {
        for ((_, cells), cell) in columns.iter_mut().zip(&record.expect("a row")) {
            cells.push(cell.to_owned());
        }
    }
    columns
}

fn numbers<T: ArrowPrimitiveType>(array: &ArrayRef, number: impl Fn(T::Native) -> f64) -> Cells {
    Cells::Numbers(array.as_primitive::<T>().iter().map(|value| value.map_or(f64::NAN, &number)).collect())
}

fn cells_of(array: &ArrayRef) -> Cells {
    let texts = |array: &StringArray| array.iter().map(|text| text.expect("a text").to_owned()).collect::<Vec<_>>();
    match array.data_type() {
        DataType::Utf8 => Cells::Texts(texts(array.as_string::<i32>())),
        DataType::Dictionary(..) => {
            let dictionary = array.as_dictionary::<Int32Type>();
            let words = texts(dictionary.values().as_string::<i32>());
            Cells::Texts(dictionary.keys().values().iter().map(|key| words[*key as usize].clone()).collect())
        }
        DataType::Timestamp(..) => {
            let micros = array.as_primitive::<TimestampMicrosecondType>().values().iter();
            Cells::Times(micros.map(|us| us / 1_000_000).collect())
        }
        DataType::UInt64 => numbers::<UInt64Type>(array, |count| count as f64),
        DataType::Float32 => numbers::<Float32Type>(array, f64::from),
        DataType::Float64 => numbers::<Float64Type>(array, |number| number),
        other => panic!("a column of {other}"),
    }
}

fn of_batches(batches: impl Iterator<Item = RecordBatch>) -> Table {
    let mut table = Table::new();
    for batch in batches {
        for (field, array) in batch.schema().fields().iter().zip(batch.columns()) {
            let cells = cells_of(array);
            match table.get_mut(field.name()) {
                Some(known) => known.append(cells),
                None => drop(table.insert(field.name().clone(), cells)),
            }
        }
    }
    table
}

/// Parses the shape and the cells of an array of NumPy.
fn numpy_array(bytes: &[u8]) -> (Vec<usize>, Cells) {
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let head = std::str::from_utf8(&bytes[10..end]).expect("text");
    let between = |from: &str, to: &str| head.split_once(from).and_then(|(_, rest)| rest.split_once(to)).expect(from).0;
    let shape = between("'shape': (", ")").split(',').filter_map(|size| size.trim().parse().ok()).collect();
    let values = &bytes[end..];
    let whole = || values.chunks_exact(8).map(|b| i64::from_le_bytes(b.try_into().expect("8 bytes")));
    let cells = match between("'descr': '", "'") {
        "<f4" => Cells::Numbers(
            values.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("4 bytes")).into()).collect(),
        ),
        "<f8" => Cells::Numbers(whole().map(|bits| f64::from_bits(bits as u64)).collect()),
        "<M8[s]" | "<m8[m]" => Cells::Times(whole().collect()),
        text => {
            let letters = values.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().expect("4 bytes")));
            let letters: Vec<u32> = letters.collect();
            let width: usize = text.strip_prefix("<U").and_then(|width| width.parse().ok()).expect("letters");
            let word = |word: &[u32]| word.iter().filter(|c| **c > 0).filter_map(|c| char::from_u32(*c)).collect();
            Cells::Texts(letters.chunks(width).map(word).collect())
        }
    };
    (shape, cells)
}

/// Returns the columns of `[place][step][column]` or `[place][column]`, and of its axes.
fn of_array((shape, values): (Vec<usize>, Cells), names: &[String], others: Table) -> Table {
    let (places, steps) = (shape[0], if shape.len() == 3 { shape[1] } else { 1 });
    assert!(shape[shape.len() - 1] == names.len() && (steps == 1 || places != steps), "{shape:?}");
    let rows = places * steps;
    let column = |i: usize| values.at((0..rows).map(|row| row * names.len() + i));
    let mut table: Table = names.iter().enumerate().map(|(i, name)| (name.clone(), column(i))).collect();
    for (name, cells) in others {
        let of_places = cells.len() == places;
        assert!(of_places || cells.len() == steps, "{name}: {shape:?}");
        let cells = cells.at((0..rows).map(|row| if of_places { row / steps } else { row % steps }));
        table.insert(name, cells);
    }
    table
}

fn npz_table(path: &Path) -> Table {
    let mut zip = zip::ZipArchive::new(File::open(path).expect("a file")).expect("a zip archive");
    let mut arrays = BTreeMap::new();
    for i in 0..zip.len() {
        let mut entry = zip.by_index(i).expect("an entry");
        let name = entry.name().expect("a name").trim_end_matches(".npy").to_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).expect("bytes");
        arrays.insert(name, numpy_array(&bytes));
    }
    let values = arrays.remove("values").expect("values");
    let Some((_, Cells::Texts(names))) = arrays.remove("column") else { panic!("no columns") };
    assert!(arrays.remove("unit").is_some() && arrays.remove("provenance").is_some());
    if let Some((_, Cells::Times(offset))) = arrays.remove("utc_offset")
        && let Some((_, Cells::Times(times))) = arrays.get_mut("time")
    {
        times.iter_mut().for_each(|time| *time -= 60 * offset[0]);
    }
    of_array(values, &names, arrays.into_iter().map(|(name, (_, cells))| (name, cells)).collect())
}

fn npy_table(path: &Path) -> Table {
    let values = numpy_array(&fs::read(path).expect("a file"));
    let axes: serde_json::Map<String, serde_json::Value> =
        serde_json::from_slice(&fs::read(path.with_extension("axes.json")).expect("axes")).expect("JSON");
    let texts = |name: &str| -> Vec<String> { serde_json::from_value(axes[name].clone()).expect("texts") };
    assert_eq!(axes["axes"].as_array().map(Vec::len), Some(values.0.len()));
    let others = axes.keys().filter(|name| !["axes", "unit", "provenance", "column"].contains(&name.as_str()));
    let others = others.map(|name| {
        let numbers = serde_json::from_value::<Vec<f64>>(axes[name].clone());
        (name.clone(), numbers.map_or_else(|_| Cells::Texts(texts(name)), Cells::Numbers))
    });
    of_array(values, &texts("column"), others.collect())
}

fn read(path: &Path, ending: &str) -> Table {
    let file = || File::open(path).expect("a file");
    match ending {
        "parquet" => {
            let reader = ParquetRecordBatchReaderBuilder::try_new(file()).and_then(|reader| reader.build());
            of_batches(reader.expect("Parquet").map(|batch| batch.expect("a batch")))
        }
        "npz" => npz_table(path),
        "npy" => npy_table(path),
        _ => {
            let reader = arrow_ipc::reader::FileReader::try_new(file(), None).expect("an Arrow file");
            of_batches(reader.map(|batch| batch.expect("a batch")))
        }
    }
}

/// Builds an archive of a house, a shed and a lawn, whose names need quotes in CSV, and writes two
/// points for modules.
fn house() -> Folder {
    let folder = Folder::new();
    let mut text = String::from("receiver,x,y,z,nx,ny,nz,area,surface,object,building,kind,object_type,face,patch\n");
    let patch = "-500 -500 0;500 -500 0;500 500 0;-500 500 0";
    for i in 0..24 {
        let (x, y) = (0.5 + f64::from(i % 4), 0.5 + f64::from(i / 4));
        text += &format!("\"r,{i}\",{x},{y},10.02,0,0,1,1,top,hall,\"the \"\"house\"\"\",roof,,,{patch}\n");
    }
    text += "low,5,-0.02,2,0,-1,0,3,front,hall,\"the \"\"house\"\"\",wall,,,\n";
    text += "shed,12,-20,0.02,0,0,1,5,lid,shed,,roof,,,\n";
    text += "lawn,15,5,0.02,0,0,1,7,lawn,garden,,ground,,,\n";
    folder.write("receivers.csv", &text);
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\n\"p,1\",5,-25,1,30,180\nq,5,5,11,0,0\n");
    assert_eq!(folder.build().status.code(), Some(0));
    folder
}

/// The 10 tables of results, factors, buildings, roof faces, places, view factors and of modules'
/// hours are the same in 5 formats as in CSV: 50 files, read by the readers of Arrow and Parquet or
/// as NumPy's arrays, have its columns, texts, times and numbers to its decimals.
#[test]
fn every_table_is_the_same_in_every_format() {
    let folder = house();
    let year = format!("site.helio --weather {}", golden().display());
    let pv = format!("pv scene.obj -m materials.toml -w {} --points points.csv -o out", golden().display());
    let tables = [
        (format!("replay {year} --year 2019 --columns total,sun_direct -o h.END"), "h.END"),
        (format!("replay {year} --every month --by object -o m.END"), "m.END"),
        (format!("replay {year} --every total --by kind -o k.END"), "k.END"),
        ("replay site.helio -c conditions.csv -o q.END".to_owned(), "q.END"),
        ("energyplus factors site.helio --azimuth-step 90 --altitude-step 30 -o r.END".to_owned(), "r.END"),
        ("energyplus factors site.helio --by surface --azimuth-step 30 -o g.END".to_owned(), "g.END"),
        (format!("buildings {year} --threshold 8 -o b.END --faces f.END"), "f.END"),
        (format!("places {year} --grid-north --module 1x1 --best 3 -o p.END"), "p.END"),
        ("export site.helio --view-factors -o v.END".to_owned(), "v.END"),
        (format!("{pv} --format END"), "out/hourly.END"),
    ];
    let mut files = 0;
    for (command, name) in &tables {
        let file = |ending: &str| {
            let done = folder.run(&command.replace("END", ending));
            assert_eq!(done.status.code(), Some(0), "{command} {ending}: {}", stderr(&done));
            folder.path(&name.replace("END", ending))
        };
        let csv = csv_table(&file("csv"));
        assert!(!csv[0].1.is_empty(), "{name}");
        for ending in ["parquet", "arrow", "feather", "npy", "npz"] {
            let table = read(&file(ending), ending);
            assert_eq!(table.len(), csv.len(), "{name} {ending}: {:?}", table.keys());
            for (column, cells) in &csv {
                let called = format!("{name} {ending} {column}");
                table.get(column).expect(&called).check(cells, &called);
            }
            files += 1;
        }
    }
    assert_eq!(files, 50);
    // The rows of buildings were written beside those of faces.
    let buildings = csv_table(&folder.path("b.csv"));
    let table = read(&folder.path("b.npz"), "npz");
    buildings.iter().for_each(|(column, cells)| table[column].check(cells, column));
    assert_eq!(buildings[0].1, ["shed", "the \"house\""]);
}
