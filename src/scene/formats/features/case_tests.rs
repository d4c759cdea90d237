//! Files that stand for one kind of fault each, with the areas that are right.

use std::path::{Path, PathBuf};

use crate::Scene;
use crate::footprint_options::HeightAbove;
use crate::load::ObjectTriangles;
use crate::site::{Part, SceneFiles};
use crate::test_files::{areas_m2, load_case};

fn case(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/footprints/cases")).join(name)
}

fn load(name: &str) -> Result<(Scene, ObjectTriangles), String> {
    load_case(&format!("footprints/cases/{name}"))
}

/// Seventeen files have the objects, roofs and walls (m2) of a sum by hand, within 0.6 %: shapes by
/// the index and without deleted rows, turned rings, overlaps, buildings of OpenStreetMap only, one
/// layer of several, feet, solids with a column of heights, a date that is none, tags in a map.
#[test]
fn seventeen_files_have_the_areas_of_a_sum_by_hand() {
    let mut wrong = Vec::new();
    for (name, objects, roofs, walls) in [
        ("deleted_record.shp", 3, 300.0, 3200.0),
        ("edited_in_place.shp", 3, 600.0, f64::NAN),
        ("null_padded.shp", 2, 200.0, f64::NAN),
        ("rings_reversed.shp", 1, 800.0, f64::NAN),
        ("multipolygon_overlap.geojson", 1, 150.0, 500.0),
        ("osm_not_buildings.geojson", 1, 80.0, 324.0),
        ("osm_roof.geojson", 1, 200.0, 0.0),
        ("web_mercator_900913.geojson", 1, 100.0, f64::NAN),
        ("height_sentinel.geojson", 3, 300.0, 1320.0),
        ("feet_height.gpkg", 2, f64::NAN, 6096.0),
        ("mixed_layers.gpkg", 1, 100.0, 320.0),
        ("lods_as_layers.gpkg", 1, 100.0, f64::NAN),
        ("solid_with_height.gpkg", 1, 100.0, 240.0),
        ("curve.gpkg", 3, f64::NAN, f64::NAN),
        ("feet_noid.parquet", 2, 1858.0, f64::NAN),
        ("null_date.shp", 2, 200.0, 720.0),
        ("map_tags.parquet", 1, 100.0, 480.0),
    ] {
        let found = load(name).map(|(scene, soup)| (soup.object_names.len(), areas_m2(&scene, &soup)));
        let near = |found: f64, right: f64| right.is_nan() || (found - right).abs() <= 6e-3 * right;
        let is_right = found
            .as_ref()
            .is_ok_and(|(count, [roof, wall])| *count == objects && near(*roof, roofs) && near(*wall, walls));
        if !is_right {
            wrong.push(format!("{name}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Heights of roofs above the sea get a hint that names the level; with it and a column of the
/// ground five buildings of 10 to 14 m have roofs of 600 and walls of 2,640 m2. Without ground they
/// are refused, and one below its ground is left out.
#[test]
fn roofs_above_the_sea_stand_on_their_ground() {
    let at = |base: Option<&str>, level| {
        let mut part = Part::plain(&case("roof_above_sea.geojson"), None);
        part.footprints.height_above = level;
        part.footprints.base = base.map(|text| text.parse().expect("a source"));
        let site = SceneFiles { parts: vec![part], ..SceneFiles::default() };
        Scene::load_with_objects(&site).map_err(|error| error.to_string())
    };
    let hints = |scene: &Scene| scene.report.warnings.iter().any(|warning| warning.contains("height_above sea"));
    assert!(hints(&at(None, None).expect("a scene").0));
    let (scene, soup) = at(Some("ground"), Some(HeightAbove::Sea)).expect("a scene");
    assert_eq!(areas_m2(&scene, &soup).map(f64::round), [600.0, 2640.0]);
    assert!(!hints(&scene) && (soup.bounds().0.z, soup.bounds().1.z) == (408.0, 422.0));
    let message = at(None, Some(HeightAbove::Sea)).expect_err("refused");
    assert!(message.contains("5 footprints with a roof above the sea") && message.contains("base ground"), "{message}");
    let (scene, soup) = at(Some("418m"), Some(HeightAbove::Sea)).expect("a scene");
    assert_eq!(areas_m2(&scene, &soup).map(f64::round), [480.0, 440.0]);
    assert!(
        scene.report.warnings.iter().any(|warning| warning.contains("1 left out whose roof")),
        "{:?}",
        scene.report
    );
}

/// Names in Latin 1 are read by the .cpg, a file of well-known text in Parquet is placed, and
/// outlines at the height of the terrain without a column of heights are left out.
#[test]
fn names_places_and_missing_heights_are_those_of_the_file() {
    let mut part = Part::plain(&case("enc_latin1.shp"), None);
    part.footprints.height = vec!["9m".parse().expect("metres")];
    let site = SceneFiles { parts: vec![part], ..SceneFiles::default() };
    let (_, soup) = Scene::load_with_objects(&site).expect("a scene");
    let all: String = soup.object_notes.iter().map(|note| note.attributes.clone()).collect();
    assert!(all.contains("M\u{fc}llerweg") && all.contains("\u{c5}ngstr\u{f6}mgatan"), "{all}");
    let (scene, _) = load("wktcrs.parquet").expect("a scene");
    assert!(scene.place.is_some(), "{:?}", scene.report);
    let message = load("campus_z.geojson").expect_err("refused");
    assert!(message.contains("1 without a height"), "{message}");
}

/// Two files with latitude first are read in the other order, with a warning, where the stated one
/// lies in Antarctica under a named EPSG:4326 or beyond a latitude of 90: 200 m2 in Washington and
/// near Tokyo, within 0.3 %.
#[test]
fn latitude_first_is_read_where_longitude_first_cannot_be_meant() {
    for (name, latitude, longitude, said) in [
        ("lat_first_4326.geojson", 38.9, -77.0, "which is in Antarctica"),
        ("lat_first_beyond_90.geojson", 35.25, 139.7, "no place on Earth"),
    ] {
        let (scene, soup) = load(name).expect(name);
        let (place, [roof, _]) = (scene.place.expect("a place"), areas_m2(&scene, &soup));
        assert!(
            (place.latitude_deg - latitude).abs() < 1e-3 && (place.longitude_deg - longitude).abs() < 1e-3,
            "{place:?}"
        );
        assert!((roof / 200.0 - 1.0).abs() < 3e-3, "{name}: {roof}");
        assert!(scene.report.warnings.iter().any(|warning| warning.contains(said)), "{:?}", scene.report.warnings);
    }
}
