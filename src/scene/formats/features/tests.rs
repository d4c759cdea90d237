//! Files of features: one town in four formats and two systems, other layouts, damaged files.

use std::path::{Path, PathBuf};

use crate::Scene;
use crate::footprint_options::FootprintOptions;
use crate::load::ObjectTriangles;
use crate::site::{Part, SceneFiles};
use crate::test_files::{Random, TestFolder, areas_m2};

/// Returns the path of a file of the town that `tests/data/footprints/town.py` writes.
fn town(ending: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/footprints")).join(format!("town.{ending}"))
}

fn site(file: &Path, options: &FootprintOptions, epsg: Option<u32>) -> SceneFiles {
    let part = Part { footprints: options.clone(), ..Part::plain(file, None) };
    let mut site = SceneFiles { parts: vec![part], ..SceneFiles::default() };
    site.frame.epsg = epsg;
    site
}

fn load(file: &Path, options: &FootprintOptions) -> (Scene, ObjectTriangles) {
    Scene::load_with_objects(&site(file, options, None)).expect("a scene")
}

/// Writes a text to a file in a new folder.
fn written(name: &str, text: &str) -> (TestFolder, PathBuf) {
    let folder = TestFolder::new();
    let path = folder.write(name, text);
    (folder, path)
}

/// In GeoJSON (degrees), GeoPackage, a zipped shapefile and GeoParquet the town has the 2,576 m2 of
/// roofs and 6,220 m2 of walls of a sum by hand, within 0.2 % because of UTM's scale. 9 of 10
/// buildings have a height, and the tower keeps its name and year.
#[test]
fn four_formats_give_the_same_town() {
    for (ending, epsg) in [("geojson", 32632), ("gpkg", 25832), ("shp.zip", 25832), ("parquet", 25832)] {
        let (scene, soup) = load(&town(ending), &FootprintOptions::default());
        let [roofs, walls] = areas_m2(&scene, &soup);
        assert!(
            (roofs / 2576.0 - 1.0).abs() < 2e-3 && (walls / 6220.0 - 1.0).abs() < 2e-3,
            "{ending}: {roofs} {walls}"
        );
        assert_eq!(scene.place.and_then(|place| place.epsg), Some(epsg), "{ending}");
        assert_eq!(soup.object_names.len(), 9, "{ending}");
        let tower = soup.object_names.iter().position(|name| name == "tower").expect("a tower");
        let stated = &soup.object_notes[tower].attributes;
        assert!(stated.contains("\"year\":1974") && stated.contains("\"name\":\"Turm\""), "{ending}: {stated}");
        assert!(
            scene.report.warnings.iter().any(|said| said.contains("1 of 10 features state neither a height")),
            "{ending}"
        );
        assert_eq!(scene.objects.list.len(), 9);
    }
}

/// Degrees become metres of the system that the user asks for. The shed gets the last height of the
/// list, and storeys of 4 m make the court 20 m high.
#[test]
fn the_user_sets_system_and_heights() {
    let options = FootprintOptions {
        height: ["height", "levels", "2.5m"].map(|text| text.parse().expect("a source")).to_vec(),
        storey_height_m: Some(4.0),
        base: Some("100m".parse().expect("a source")),
        ..FootprintOptions::default()
    };
    let (scene, soup) = Scene::load_with_objects(&site(&town("geojson"), &options, Some(31468))).expect("a scene");
    assert_eq!(scene.place.and_then(|place| place.epsg), Some(31468));
    let [roofs, walls] = areas_m2(&scene, &soup);
    assert!((roofs / (2576.0 + 80.0) - 1.0).abs() < 1e-3, "{roofs}");
    assert!((walls / (6220.0 + 160.0 * 5.0 + 36.0 * 2.5) - 1.0).abs() < 1e-3, "{walls}");
    assert!((scene.mesh.bounds().0.z + scene.mesh.origin.z - 100.0).abs() < 0.01);
    let refused = Scene::load_site(&site(&town("geojson"), &FootprintOptions::default(), Some(27700)));
    assert!(refused.is_ok() || refused.is_err_and(|error| error.to_string().contains("EPSG:27700")));
}

/// Six layouts of GeoJSON hold the same house: a collection, a feature, a geometry, lines with and
/// without separators, and a file with a `crs` in metres.
#[test]
fn all_layouts_of_geojson_give_the_same_house() {
    let ring = "[[[4.3,52.0],[4.3002,52.0],[4.3002,52.0001],[4.3,52.0001],[4.3,52.0]]]";
    let feature = format!(
        "{{\"type\":\"Feature\",\"properties\":{{\"height\":10}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":{ring}}}}}"
    );
    let plane = "[[[80000,455000],[80013.73,455000],[80013.73,455011.13],[80000,455011.13],[80000,455000]]]";
    let crs = "\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"urn:ogc:def:crs:EPSG::28992\"}}";
    let metres = format!("{{\"features\":[{}],\"type\":\"FeatureCollection\",{crs}}}", feature.replace(ring, plane));
    let geometry = format!("{{\"type\":\"MultiPolygon\",\"coordinates\":[{ring}]}}");
    for (name, text) in [
        ("a.geojson", format!("{{\"type\":\"FeatureCollection\",\"features\":[{feature}]}}")),
        ("a.json", format!("{{\"type\": \"FeatureCollection\", \"features\": [{feature}]}}")),
        ("a.geojson", feature.clone()),
        ("a.geojson", geometry),
        ("a.geojsonl", format!("{feature}\n\n")),
        ("a.geojsonl", format!("\u{1e}{feature}\n")),
        ("a.geojson", metres),
    ] {
        let (_folder, path) = written(name, &text);
        let options = FootprintOptions { height: vec!["10m".parse().expect("metres")], ..FootprintOptions::default() };
        let (scene, soup) = load(&path, &options);
        let [roofs, walls] = areas_m2(&scene, &soup);
        assert!((roofs - 152.7).abs() < 0.5 && (walls - 497.0).abs() < 1.0, "{text}: {roofs} {walls}");
    }
}

/// Eight files that cannot be meant are refused or get a warning, with a hint on how to correct
/// them.
#[test]
fn implausible_files_are_refused_with_a_hint() {
    let polygon = |ring: &str, properties: &str| {
        format!(
            "{{\"type\":\"FeatureCollection\",\"features\":[{{\"type\":\"Feature\",\"properties\":{{{properties}}},\
             \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[{ring}]}}}}]}}"
        )
    };
    let here = "[[4.3,52.0],[4.3002,52.0],[4.3002,52.0001],[4.3,52.0]]";
    for (text, said) in [
        (String::new(), "the file is empty"),
        ("{\"type\":\"FeatureCollection\",\"features\":[]}".to_owned(), "holds no features"),
        (polygon(here, ""), "none of its 1 features became a building or a tree; left out: 1 without a height"),
        (
            polygon("[[690000,5330000],[690010,5330000],[690010,5330010]]", "\"height\":3"),
            "stated as longitude and latitude, but reach",
        ),
        (polygon("[[4.3,52.0],[4.4]]", "\"height\":3"), "not two or three numbers"),
        (polygon("[[4.3,52.0],[4.4,52],[1e999,3]]", "\"height\":3"), "not valid GeoJSON"),
        ("{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\"".to_owned(), "not valid GeoJSON"),
        (
            "{\"type\":\"Feature\",\"geometry\":{\"type\":\"Point\",\"coordinates\":[4.3,52]},\"properties\":{}}"
                .to_owned(),
            "1 as points or lines",
        ),
    ] {
        let (_folder, path) = written("a.geojson", &text);
        let message = Scene::load(&path, None).expect_err("refused").to_string();
        assert!(message.contains(said), "{text}: {message}");
    }
    let (_folder, path) =
        written("a.geojson", &polygon("[[4.3,52.0],[4.301,52.001],[4.301,52.0],[4.3,52.001]]", "\"height\":3"));
    let scene = Scene::load(&path, None).expect("mended");
    assert!(
        scene.report.warnings.iter().any(|said| said.contains("1 outlines cross themselves")),
        "{:?}",
        scene.report
    );
}

/// Each of the six files is read or refused, and nothing panics, when it is cut at any of 60
/// lengths or has one byte changed at any of 300 places.
#[test]
fn damaged_files_cause_no_panic() {
    let (folder, mut random) = (TestFolder::new(), Random::new());
    for ending in ["geojson", "gpkg", "shp.zip", "parquet", "shp", "dbf"] {
        let whole = match ending {
            "shp" | "dbf" => {
                let parts =
                    heliotile_files::input::zipped_shapefile(&town("shp.zip")).expect("a zip").expect("a shapefile");
                let table = parts.table.expect("a table");
                folder.write("x.dbf", &table);
                folder.write("x.shp", &parts.shapes);
                if ending == "shp" { parts.shapes } else { table }
            }
            _ => std::fs::read(town(ending)).expect("there"),
        };
        let asked = folder.at(&format!("x.{}", if ending == "dbf" { "shp" } else { ending }));
        let (mut read, mut refused) = (0, 0);
        for step in 0..360 {
            let mut bytes = whole.clone();
            match step {
                0..60 => bytes.truncate(random.below(whole.len())),
                _ => bytes[random.below(whole.len())] ^= 1 << random.below(8),
            }
            folder.write(&format!("x.{ending}"), &bytes);
            let loaded = Scene::load_site(&site(&asked, &FootprintOptions::default(), None));
            if loaded.is_ok() { read += 1 } else { refused += 1 }
        }
        assert_eq!(read + refused, 360);
        assert!(refused > 20, "{ending}: {read} read, {refused} refused");
    }
}
