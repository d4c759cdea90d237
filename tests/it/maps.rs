//! Maps of results: independent readers find the values of the CSV of the same replay in them, in
//! the same place; results that no map can show are refused.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::Output;

use flatgeobuf::geozero::error::Result as GeozeroResult;
use flatgeobuf::geozero::{GeomProcessor, GeozeroGeometry};
use flatgeobuf::{FallibleStreamingIterator, FeatureProperties, FgbReader};
use glam::DVec3;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, RowAccessor};

use crate::cli::{Folder, golden, stderr, stdout};

/// Position of the cube of the command line tests: 85 km and 455 km from the origin of RD New.
pub const AT: DVec3 = DVec3::new(80_000.0, 455_000.0, 2.0);

/// Builds a cube of 10 m on a square of 60 m in RD New, its walls and its roof covered with
/// receivers, and an archive that `run` made with maps.
fn site() -> Folder {
    let folder = Folder::new();
    let scene = fs::read_to_string(folder.path("scene.obj")).expect("the scene");
    let moved = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().expect("a number")).collect();
            let [x, y, z] = numbers.try_into().expect("three numbers");
            let corner = DVec3::new(x, y, z) + AT;
            format!("v {} {} {}\n", corner.x, corner.y, corner.z)
        }
        None => format!("{line}\n"),
    };
    folder.write("scene.obj", &scene.lines().map(moved).collect::<String>());
    let options = "--on wall,roof --spacing 2.5 --quality draft --crs 28992 -o site.sun --map glb,fgb,geoparquet --map vtu,geojson";
    let run = format!("run scene.obj --materials materials.toml --weather {} {options}", golden().display());
    let output = folder.run(&run);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    folder
}

fn replay(folder: &Folder, rest: &str) -> Output {
    let output = folder.run(&format!("replay site.sun/site.helio --weather {} {rest}", golden().display()));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    output
}

/// Parses a CSV by its second column: the other columns, by name.
fn csv(output: &Output) -> BTreeMap<String, BTreeMap<String, f64>> {
    let text = stdout(output);
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = header.iter().zip(&cells).skip(2);
        let numbers = numbers.map(|(name, cell)| ((*name).to_owned(), cell.parse().expect("a number"))).collect();
        (cells[1].to_owned(), numbers)
    };
    lines.map(row).collect()
}

/// A row of a map: numbers by name, and closed rings.
pub type Place = (BTreeMap<String, f64>, Vec<Vec<DVec3>>);

/// Returns the area of polygons without holes, m2 (Newell).
fn area_m2(rings: &[Vec<DVec3>]) -> f64 {
    let of_ring = |ring: &Vec<DVec3>| -> f64 {
        let edges = ring.windows(2).map(|edge| (edge[0] - ring[0]).cross(edge[1] - ring[0]));
        edges.sum::<DVec3>().length() / 2.0
    };
    rings.iter().map(of_ring).sum()
}

#[derive(Default)]
struct Rings(Vec<Vec<DVec3>>);

impl GeomProcessor for Rings {
    fn dimensions(&self) -> flatgeobuf::geozero::CoordDimensions {
        flatgeobuf::geozero::CoordDimensions::xyz()
    }

    fn coordinate(
        &mut self,
        x: f64,
        y: f64,
        z: Option<f64>,
        _: Option<f64>,
        _: Option<f64>,
        _: Option<u64>,
        _: usize,
    ) -> GeozeroResult<()> {
        self.0.last_mut().expect("a ring").push(DVec3::new(x, y, z.expect("a height")));
        Ok(())
    }

    fn linestring_begin(&mut self, _: bool, _: usize, _: usize) -> GeozeroResult<()> {
        self.0.push(Vec::new());
        Ok(())
    }
}

/// Reads a map with the library of FlatGeobuf: its EPSG number, and rows by name.
pub fn fgb(path: &Path) -> (i32, BTreeMap<String, Place>) {
    let mut file = BufReader::new(File::open(path).expect("a file"));
    let reader = FgbReader::open(&mut file).expect("FlatGeobuf");
    let header = reader.header();
    let (epsg, columns) = (header.crs().expect("a system").code(), header.columns().expect("columns"));
    let names: Vec<String> = columns.iter().map(|column| column.name().to_owned()).collect();
    let mut rows = reader.select_all().expect("rows");
    let mut found = BTreeMap::new();
    while let Some(feature) = rows.next().expect("a row") {
        let mut rings = Rings::default();
        feature.process_geom(&mut rings).expect("a polygon");
        let number = |name: &String| Some((name.clone(), f64::from(feature.property::<f32>(name).ok()?)));
        let name: String = feature.property(&names[0]).expect("a name");
        found.insert(name, (names.iter().filter_map(number).collect(), rings.0));
    }
    (epsg, found)
}

/// Parses rings of WKB: a polygon or a multipolygon with heights, without holes.
fn wkb(bytes: &[u8]) -> Vec<Vec<DVec3>> {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes"));
    let many = word(1) == 1006;
    let (mut at, count) = if many { (9, word(5)) } else { (0, 1) };
    let mut ring = || {
        assert_eq!((bytes[at], word(at + 1), word(at + 5)), (1, 1003, 1), "one ring of one polygon with heights");
        let count = word(at + 9) as usize;
        let metres = bytes[at + 13..][..24 * count]
            .chunks(8)
            .map(|eight| f64::from_le_bytes(eight.try_into().expect("8 bytes")));
        at += 13 + 24 * count;
        metres.collect::<Vec<f64>>().chunks(3).map(DVec3::from_slice).collect()
    };
    let rings = (0..count).map(|_| ring()).collect();
    assert_eq!(at, bytes.len());
    rings
}

/// Reads a map with the library of Parquet: the key `geo`, and rows by name.
pub fn geoparquet(path: &Path) -> (serde_json::Value, BTreeMap<String, Place>) {
    let reader = SerializedFileReader::new(File::open(path).expect("a file")).expect("Parquet");
    let metadata = reader.metadata().file_metadata();
    let keys = metadata.key_value_metadata().expect("metadata");
    let geo = keys.iter().find(|key| key.key == "geo").and_then(|key| key.value.as_ref()).expect("the key geo");
    let mut found = BTreeMap::new();
    for row in reader.get_row_iter(None).expect("rows") {
        let row = row.expect("a row");
        let numbers = row.get_column_iter().filter_map(|(name, field)| match field {
            Field::Float(number) => Some((name.clone(), f64::from(*number))),
            _ => None,
        });
        let geometry = row.get_bytes(row.len() - 1).expect("a geometry");
        found.insert(row.get_string(0).expect("a name").clone(), (numbers.collect(), wkb(geometry.data())));
    }
    (serde_json::from_str(geo).expect("JSON"), found)
}

/// Returns the number of compared values and their largest relative difference, over all columns
/// that map and table share.
fn off(map: &BTreeMap<String, Place>, table: &BTreeMap<String, BTreeMap<String, f64>>) -> (usize, f64) {
    assert_eq!(map.len(), table.len());
    let mut found = (0, 0.0_f64);
    for (name, (numbers, _)) in map {
        for (column, number) in numbers {
            if let Some(expected) = table[name].get(column) {
                found = (found.0 + 1, found.1.max((number - expected).abs() / expected.abs().max(1.0)));
            }
        }
    }
    found
}

/// Each of 80 receivers is one row of FlatGeobuf and GeoParquet, both in EPSG:28992, with the seven
/// sums of the CSV to its six digits and the 6.25 m2 around it. Binary glTF has the same totals at
/// its corners, 85 km from the origin within a millimetre. `run` wrote the same maps.
#[test]
fn maps_hold_each_receiver_with_the_sums_of_the_csv() {
    let folder = site();
    let table = csv(&replay(&folder, "--every total"));
    assert_eq!(table.len(), 80);
    replay(&folder, "--every total -o map.fgb");
    replay(&folder, "--every total -o map.parquet --geo");
    replay(&folder, "--every total -o map.glb");
    let (epsg, of_fgb) = fgb(&folder.path("map.fgb"));
    let (geo, of_parquet) = geoparquet(&folder.path("map.parquet"));
    assert_eq!((epsg, &geo["columns"]["geometry"]["crs"]["id"]["code"]), (28992, &serde_json::json!(28992)));
    for map in [&of_fgb, &of_parquet] {
        let (count, worst) = off(map, &table);
        assert!(count == 80 * 7 && worst < 6e-6, "{count} {worst}");
        let drawn = |(numbers, rings): &Place| (area_m2(rings) / numbers["area_m2"] - 1.0).abs();
        assert!(map.values().all(|place| drawn(place) < 2e-3 && (place.0["area_m2"] - 6.25).abs() < 1e-3));
    }
    assert!(of_fgb.iter().all(|(name, place)| of_parquet[name].1 == place.1));
    let whole = of_fgb.values().flat_map(|(_, rings)| rings.iter().flatten());
    let (low, high) = whole.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    assert!((low - AT).length() < 1e-3 && (high - AT - 10.0).length() < 1e-3, "{low} {high}");

    let gltf::Gltf { document, blob } = gltf::Gltf::open(folder.path("map.glb")).expect("glTF");
    let mesh = document.meshes().find(|mesh| mesh.name() == Some("map")).expect("a map");
    assert_eq!(document.meshes().filter(|mesh| mesh.name() == Some("surroundings")).count(), 1);
    let primitive = mesh.primitives().next().expect("a primitive");
    let reader = primitive.reader(|_| blob.as_deref());
    let corners: Vec<[f32; 3]> = reader.read_positions().expect("corners").collect();
    // Rings of maps are closed; a ring of n corners has n - 2 triangles.
    let rings: Vec<usize> = of_fgb.values().flat_map(|(_, rings)| rings.iter().map(|ring| ring.len() - 1)).collect();
    let triangles = reader.read_indices().expect("triangles").into_u32().count() / 3;
    assert_eq!((corners.len(), triangles), (rings.iter().sum(), rings.iter().map(|corners| corners - 2).sum()));
    let json = glb_json(&folder.path("map.glb"));
    let extras = &json["asset"]["extras"];
    let origin: Vec<f64> =
        extras["origin_m"].as_array().expect("an origin").iter().filter_map(|m| m.as_f64()).collect();
    let origin = DVec3::from_slice(&origin);
    let raised = extras["raised_m"].as_f64().expect("a height");
    assert_eq!((raised, &extras["epsg"]), (0.01, &serde_json::json!(28992)));
    let absolute = |corner: &[f32; 3]| DVec3::from_array(corner.map(f64::from)) + origin;
    let (low, high) = corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), corner| {
        (l.min(absolute(corner)), h.max(absolute(corner)))
    });
    // Walls are raised to the sides, the roof upwards.
    assert!((low.truncate() - AT.truncate() + raised).length() < 1e-3, "{low}");
    assert!((high - AT - 10.0 - raised).length() < 1e-3, "{high}");

    for (annual, made) in [("annual.fgb", &of_fgb), ("annual.parquet", &of_parquet)] {
        let annual = folder.path("site.sun/golden_3_days").join(annual);
        let found = if annual.ends_with("annual.fgb") { fgb(&annual).1 } else { geoparquet(&annual).1 };
        assert_eq!(found.len(), made.len());
        let same = found.iter().filter(|(name, place)| made[*name] == **place).count();
        assert_eq!(same, 80);
    }
    for ending in ["glb", "vtu", "geojson"] {
        let annual = folder.path("site.sun/golden_3_days/annual").with_extension(ending);
        assert!(fs::metadata(&annual).expect("a map").len() > 20_000, "{ending}");
    }
}

/// Returns the JSON of a binary glTF file.
pub fn glb_json(path: &Path) -> serde_json::Value {
    let bytes = fs::read(path).expect("a file");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("4 bytes")) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).expect("JSON")
}

/// Each of 5 surfaces is one outline of 4 corners and 100 m2, at the corners of the cube within 2
/// mm, with the sums, area, tilt and azimuth of the CSV; months are columns, which add up to the
/// total.
#[test]
fn surfaces_are_outlines() {
    let folder = site();
    let table = csv(&replay(&folder, "--every total --by surface"));
    replay(&folder, "--every month --by surface -o map.fgb");
    let (_, map) = fgb(&folder.path("map.fgb"));
    let (count, worst) = off(&map, &table);
    assert!(table.len() == 5 && count == 5 * 11 && worst < 6e-6, "{count} {worst}");
    let months = |numbers: &BTreeMap<String, f64>| {
        numbers
            .iter()
            .filter(|(name, _)| name.starts_with("total_0") && name.ends_with("_kwh_m2"))
            .map(|(_, sum)| *sum)
            .collect::<Vec<_>>()
    };
    for (numbers, rings) in map.values() {
        let [corners] = rings.as_slice() else { panic!("{} rings", rings.len()) };
        assert!(corners.len() == 5 && (area_m2(rings) - 100.0).abs() < 0.1);
        let sums = months(numbers);
        assert!(sums.len() == 1 && (sums[0] / numbers["total_kwh_m2"] - 1.0).abs() < 1e-6, "{sums:?}");
        let away = |corner: &DVec3| {
            (*corner - AT).to_array().map(|m| m.abs().min((m - 10.0).abs())).into_iter().fold(0.0, f64::max)
        };
        assert!(corners.iter().all(|corner| away(corner) < 0.002), "{corners:?}");
    }
}

/// A day's hours for ParaView are 24 grids that the `.pvd` names, 0 to 23 hours apart, each with
/// the total of its hour in the CSV, the greatest by day. GeoJSON lies where RD New does, at 52.08
/// degrees north, and its polygons are closed.
#[test]
fn paraview_has_24_hours_and_geojson_degrees() {
    let folder = site();
    let day = "--every hour --from 03-20 --to 03-20 --by surface --columns total";
    replay(&folder, &format!("{day} -o day.pvd"));
    let list = fs::read_to_string(folder.path("day.pvd")).expect("the list");
    assert_eq!(
        (list.matches("<DataSet ").count(), list.contains("timestep=\"23\" file=\"day/day_0023.vtu\"")),
        (24, true)
    );
    let table = stdout(&replay(&folder, day));
    let mut greatest = (0, 0.0);
    for hour in 0..24 {
        let bytes = fs::read(folder.path(&format!("day/day_{hour:04}.vtu"))).expect("a grid");
        let text = String::from_utf8_lossy(&bytes);
        let element = text.lines().find(|line| line.contains("Name=\"total_w_m2\"")).expect("an array");
        let offset = element.split("offset=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("an offset");
        let start = bytes.windows(2).position(|two| two == b"\n_").expect("data")
            + 2
            + offset.parse::<usize>().expect("a number");
        assert_eq!(u64::from_le_bytes(bytes[start..start + 8].try_into().expect("8 bytes")), 5 * 4);
        let values: Vec<f32> = bytes[start + 8..start + 28]
            .chunks(4)
            .map(|four| f32::from_le_bytes(four.try_into().expect("4 bytes")))
            .collect();
        // The table has all hours of a surface, then those of the next one.
        let rows: Vec<&str> = table.lines().skip(1).collect();
        for (surface, value) in values.iter().enumerate() {
            let cells: Vec<&str> = rows[surface * 24 + hour].split(',').collect();
            let expected: f32 = cells[2].parse().expect("a number");
            // The CSV has three decimals.
            assert!((value - expected).abs() < 6e-4, "{hour} {surface}: {value} {expected}");
        }
        let sum: f32 = values.iter().sum();
        if sum > greatest.1 {
            greatest = (hour, sum);
        }
    }
    assert!((9..17).contains(&greatest.0), "{greatest:?}");

    let text = fs::read_to_string(folder.path("site.sun/golden_3_days/annual.geojson")).expect("GeoJSON");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let features = json["features"].as_array().expect("features");
    assert_eq!(features.len(), 80);
    for feature in features {
        let coordinates = &feature["geometry"]["coordinates"];
        let polygon = if feature["geometry"]["type"] == "Polygon" { coordinates } else { &coordinates[0] };
        let ring = polygon[0].as_array().expect("a ring");
        assert!(ring.len() > 3 && ring.first() == ring.last());
        let at = |i: usize| ring[0][i].as_f64().expect("a number");
        // Values of PROJ (pyproj 3.7.2): 80,005 and 455,005 lie at 4.29319 east and 52.07824 north.
        assert!((at(0) - 4.293_19).abs() < 2e-4 && (at(1) - 52.078_24).abs() < 2e-4, "{ring:?}");
    }
}

/// Nine wrong requests are refused: receivers without areas, GeoJSON without a system, hours on a
/// map, 1,000 columns, `--geo` of a CSV, an unknown extension, factors on a map, a series of too
/// many files. No file is left behind.
#[test]
fn wrong_maps_are_refused_and_leave_no_file() {
    let folder = Folder::new();
    assert_eq!(folder.build().status.code(), Some(0));
    let replay = format!("replay site.helio --weather {}", golden().display());
    folder.fails(&format!("{replay} --every total -o map.glb"), "input lacks site.helio area");
    let rows = "receiver,x,y,z,nx,ny,nz,area\nroof,5,5,10.02,0,0,1,4\nsouth,5,-0.02,4,0,-1,0,1\n";
    folder.write("receivers.csv", rows);
    assert_eq!(folder.build().status.code(), Some(0));
    let total = format!("{replay} --every total");
    folder.fails(&format!("{total} -o map.geojson"), "argument lacks --output place");
    folder.fails(&format!("{replay} -o map.fgb"), "argument excludes --output --every");
    folder.fails(&format!("{total} --geo -o map.csv"), "argument ending --geo");
    folder.fails(&format!("{total} -o map.gpkg"), "unsupported `map.gpkg`");
    folder.fails("energyplus factors site.helio -o map.fgb", "unsupported `map.fgb`");
    let conditions: String = (0..1000).map(|i| format!("c{i},180,50,{i},100\n")).collect();
    folder.write("many.csv", &format!("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n{conditions}"));
    folder.fails("replay site.helio -c many.csv --columns total -o map.fgb", "limit 1000");
    folder.fails("replay site.helio -c conditions.csv -o site.helio/map.fgb", "input lacks site.helio/map.fgb folder");
    let left = fs::read_dir(folder.path(""))
        .expect("the folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    assert_eq!(left.filter(|name| name.starts_with("map") || name.contains(".partial")).count(), 0);

    // Two conditions are two columns of each component; receivers without a patch are squares of
    // their area.
    let output = folder.run("replay site.helio -c conditions.csv --columns total -o map.parquet --geo");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let (geo, map) = geoparquet(&folder.path("map.parquet"));
    assert!(geo["columns"]["geometry"]["crs"].is_null());
    let names: Vec<&str> = map["roof"].0.keys().map(String::as_str).collect();
    assert_eq!(names, ["area_m2", "azimuth_deg", "noon_total_w_m2", "overcast_total_w_m2", "tilt_deg"]);
    let corners = &map["roof"].1[0];
    assert!((corners[0] - corners[1]).length() == 2.0 && (corners[0].z - 10.02).abs() < 1e-9, "{corners:?}");
}

/// GeoJSON of 10,001 polygons is written with a warning of their number; of 10,000 there is none.
#[test]
fn large_geojson_is_warned() {
    let folder = Folder::new();
    let row = |i: usize| {
        format!("r{i},{},{},0.02,0,0,1,0.04\n", 11.0 + 0.1 * (i % 101) as f64, 11.0 + 0.1 * (i / 101) as f64)
    };
    let rows: String = (0..10_001).map(row).collect();
    folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz,area\n{rows}"));
    let keep: String = (0..10_000).map(|i| format!("r{i}\n")).collect();
    folder.write("list.csv", &format!("receiver\n{keep}"));
    let build = "build scene.obj --materials materials.toml --receivers receivers.csv --crs 28992 --quality draft -o site.helio";
    let built = folder.run(build);
    assert_eq!(built.status.code(), Some(0), "{}", stderr(&built));
    let query = "replay site.helio -c conditions.csv --columns total";
    let many = folder.run(&format!("{query} -o map.geojson"));
    assert!(many.status.success() && stderr(&many).contains("map.geojson has 10001 polygons"), "{}", stderr(&many));
    let fewer = folder.run(&format!("{query} -r list.csv -o map.geojson"));
    assert!(fewer.status.success() && !stderr(&fewer).contains("polygons"), "{}", stderr(&fewer));
}
