//! Tests of scenes in other units and places, and of the warnings about them.

use std::fs;

use glam::DVec3;

use crate::Scene;
use crate::placing::frame::{SiteFrame, UpAxis};
use crate::placing::plausible::far_receivers;
use crate::site::{Part, SceneFiles};
use crate::test_files::{TestFolder, areas_m2};
use heliotile_core::error::Result;
use heliotile_core::site::receiver::Receiver;

/// Returns a house of 10 x 8 m with walls of 6 m, each number times `unit`, at a place.
fn house(unit: f64, [x, y, z]: [f64; 3]) -> String {
    let mut text = String::new();
    for (dx, dy, dz) in [(0, 0, 0), (10, 0, 0), (10, 8, 0), (0, 8, 0), (0, 0, 6), (10, 0, 6), (10, 8, 6), (0, 8, 6)] {
        let at = |low: f64, step: i32| low + f64::from(step) * unit;
        text += &format!("v {} {} {}\n", at(x, dx), at(y, dy), at(z, dz));
    }
    text + "usemtl wall\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nusemtl roof\nf 5 6 7 8\n"
}

/// Returns heights of 500 to 530 m on 40 x 40 cells of 50 m around a point.
fn terrain([x, y]: [f64; 2]) -> String {
    let head = format!("ncols 40\nnrows 40\nxllcorner {}\nyllcorner {}\ncellsize 50\n", x - 1000.0, y - 1000.0);
    let row = |i: usize| (0..40).map(|j| format!("{} ", 500 + (i * 7 + j * 3) % 31)).collect::<String>() + "\n";
    head + &(0..40).map(row).collect::<String>()
}

struct Folder(TestFolder);

impl Folder {
    fn with(files: &[(&str, String)]) -> Folder {
        let folder = TestFolder::new();
        files.iter().for_each(|(name, text)| drop(folder.write(name, text)));
        Folder(folder)
    }

    fn load(&self, names: &[&str], frame: &SiteFrame) -> Result<Scene> {
        let files: Vec<_> = names.iter().map(|name| self.0.at(name)).collect();
        Scene::load_site(&SceneFiles::new(&files, None)?.framed(frame))
    }

    /// Returns the warnings about some files, without those about materials.
    fn said(&self, names: &[&str], frame: &SiteFrame) -> Vec<String> {
        let report = self.load(names, frame).expect("a scene").report;
        report.warnings.iter().map(|said| said.plain()).filter(|warning| !warning.contains("reflect")).collect()
    }
}

fn one(found: &[String], words: &[&str]) {
    assert_eq!(found.len(), 1, "{found:?}");
    words.iter().for_each(|word| assert!(found[0].contains(word), "{word}: {found:?}"));
}

/// A house in millimetres, centimetres or kilometres gets one warning each, with what to do; in
/// metres, or with the right scale, it gets none.
#[test]
fn a_wrong_unit_gets_one_warning() {
    let mm = house(1000.0, [0.0; 3]);
    let files = [("m.obj", house(1.0, [78_000.0, 457_000.0, 3.0])), ("mm.obj", mm), ("cm.obj", house(100.0, [0.0; 3]))];
    let folder = Folder::with(&files);
    let plain = SiteFrame::default();
    assert_eq!(folder.said(&["m.obj"], &plain), [""; 0]);
    one(
        &folder.said(&["mm.obj"], &plain),
        &["mm.obj: walls are", "millimetres: then give scale 0.001 (0.0254 for inches)"],
    );
    one(&folder.said(&["cm.obj"], &plain), &["cm.obj: walls are", "centimetres: then give scale 0.01 "]);
    for (name, scale) in [("mm.obj", 0.001), ("cm.obj", 0.01)] {
        let scene = folder.load(&[name], &SiteFrame { scale: Some(scale), ..plain }).expect("a scene");
        let (low, high) = scene.mesh.bounds();
        assert!((high - low - DVec3::new(10.0, 8.0, 6.0)).length() < 1e-3, "{name}: {}", high - low);
    }
    one(
        &folder.said(&["m.obj"], &SiteFrame { scale: Some(0.001), ..plain }),
        &["0.0100 m wide", "read with a scale of 0.001", "leave the scale out"],
    );
    // The message names the file that is not in metres, and the key of a site.toml.
    let two = folder.said(&["m.obj", "mm.obj"], &plain);
    assert!(
        two.iter().any(|said| said.contains("mm.obj: walls are") && said.contains("scale = 0.001 in its [[scene]]"))
    );
}

/// A house of one storey in centimetres, 1000 x 800 x 300, gets a warning; four towers of 60 x 60 x
/// 300 m, a hall of 200 x 100 x 100 m and a leaning dam of 400 x 200 m get none.
#[test]
fn centimetres_are_told_from_tall_buildings() {
    let block = |size: [f64; 3], at: [f64; 2], first: usize| {
        let mut text = String::new();
        for (x, y, z) in [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)] {
            let [x, y, z] = [f64::from(x), f64::from(y), f64::from(z)];
            text += &format!("v {} {} {}\n", at[0] + x * size[0], at[1] + y * size[1], z * size[2]);
        }
        text += "usemtl wall\n";
        for face in [[1, 4, 3, 2], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]] {
            text += &format!("f {}\n", face.map(|corner| (corner + first).to_string()).join(" "));
        }
        text
    };
    let towers: String =
        (0..4).map(|i| block([60.0, 60.0, 300.0], [f64::from(i) * 300.0, 0.0], 8 * i as usize)).collect();
    let folder = Folder::with(&[
        ("storey.obj", block([1000.0, 800.0, 300.0], [0.0; 2], 0)),
        ("low.obj", block([1400.0, 900.0, 250.0], [0.0; 2], 0)),
        ("towers.obj", towers),
        ("hall.obj", block([200.0, 100.0, 100.0], [0.0; 2], 0)),
        ("dam.obj", "v 0 0 0\nv 400 0 0\nv 400 60 200\nv 0 60 200\nusemtl wall\nf 1 2 3 4\n".to_owned()),
    ]);
    let plain = SiteFrame::default();
    for name in ["storey.obj", "low.obj"] {
        one(&folder.said(&[name], &plain), &[name, "if the file is in centimetres, give scale 0.01"]);
    }
    for name in ["towers.obj", "hall.obj", "dam.obj"] {
        assert_eq!(folder.said(&[name], &plain), [""; 0], "{name}");
    }
}

/// A region of 0.01 degrees with houses of 17 m gets a warning; a mast of 0.3 m and 17 m gets none.
#[test]
fn coordinates_in_degrees_get_a_warning() {
    let region = |x: f64, y: f64, wide: f64| {
        let mut text = String::new();
        for (dx, dy, z) in [(0., 0., 0.), (1., 0., 0.), (1., 1., 0.), (0., 0., 17.), (1., 0., 17.), (1., 1., 17.)] {
            text += &format!("v {} {} {z}\n", x + wide * dx, y + wide * dy);
        }
        text + "usemtl wall\nf 1 2 5 4\nf 2 3 6 5\nf 4 5 6\n"
    };
    let folder = Folder::with(&[("region.obj", region(4.31, 52.08, 0.01)), ("mast.obj", region(0.5, 0.5, 0.3))]);
    let plain = SiteFrame::default();
    one(&folder.said(&["region.obj"], &plain), &["x and y look like degrees (4.3100 52.0800", "reproject the file"]);
    assert_eq!(folder.said(&["mast.obj"], &plain), [""; 0]);
}

/// Terrain 462 km from its house gets a warning with both names, terrain 4,538 km from it is an
/// error, and a house on its terrain gets neither. A house at 0 m below a plateau of 500 m gets a
/// warning until an elevation lifts it.
#[test]
fn files_far_apart_are_warned_of_or_refused() {
    let files = [
        ("house.obj", house(1.0, [0.0; 3])),
        ("near.obj", house(1.0, [78_000.0, 457_000.0, 510.0])),
        ("rd.asc", terrain([78_000.0, 457_000.0])),
        ("utm.asc", terrain([592_000.0, 4_500_000.0])),
    ];
    let folder = Folder::with(&files);
    let plain = SiteFrame::default();
    let found = folder.said(&["house.obj", "rd.asc"], &plain);
    one(
        &found,
        &["rd.asc lies 462 km from", "house.obj", "neither names its coordinate system", "`offset = [x, y, z]`"],
    );
    assert_eq!(folder.said(&["near.obj", "rd.asc"], &plain), [""; 0]);
    let error = folder.load(&["house.obj", "utm.asc"], &plain).expect_err("out of sight").to_string();
    assert!(error.contains("utm.asc") && error.contains("lies 4538 km from"), "{error}");
    fs::write(
        folder.0.at("site.toml"),
        "[[scene]]\nfile = \"house.obj\"\noffset = [78000, 457000, 0]\n[[scene]]\nfile = \"rd.asc\"\n",
    )
    .expect("written");
    one(&folder.said(&["site.toml"], &plain), &["(0 to 6 m high) lies wholly below the lowest point of", "elevation"]);
    let lifted = SiteFrame { elevation_m: Some(525.0), ..plain };
    assert_eq!(folder.said(&["site.toml"], &lifted), [""; 0]);
    let scene = folder.load(&["site.toml"], &lifted).expect("a scene");
    let top = scene.mesh.bounds().1.z + scene.mesh.origin.z;
    assert!((top - 531.0).abs() < 1e-3, "{top}");
}

/// Receivers 90 km off get a warning with the distance. Swapped ones, ones in millimetres and local
/// ones are recognised; receivers at the house and 9 km from it get no warning.
#[test]
fn receivers_far_away_get_a_reason() {
    let folder = Folder::with(&[("near.obj", house(1.0, [78_000.0, 457_000.0, 0.0]))]);
    let scene = folder.load(&["near.obj"], &SiteFrame::default()).expect("a scene");
    let said = |x: f64, y: f64| {
        let position = DVec3::new(x, y, 5.0);
        let receiver = Receiver::new("r".into(), position, DVec3::Z);
        far_receivers(&scene, [position; 2], &receiver, 4)
    };
    assert_eq!((said(78_001.0, 457_001.0), said(87_000.0, 457_001.0)), (None, None));
    let far = said(168_010.0, 457_001.0).expect("far").what;
    assert!(far.contains("all 4 receivers") && far.contains("is 90 km from the scene"), "{far:?}");
    for (x, y, words, is_mistake) in [
        (457_001.0, 78_001.0, "x and y look swapped", true),
        (78_001_000.0, 457_001_000.0, "look like millimetres", true),
        (5.0, 5.0, "look local", false),
        (592_000.0, 5_770_000.0, "another coordinate system?", false),
    ] {
        let far = said(x, y).expect(words);
        assert!(far.what.contains(words) && far.is_mistake == is_mistake, "{far:?}");
    }
}

/// The place of the option takes precedence over a file's, with a warning. Latitude and longitude
/// beside a system only confirm it, unless they contradict it. A rotation adds to the convergence,
/// and needs a place. Feet get a warning until they are scaled by 0.3048006.
#[test]
fn the_requested_place_takes_precedence() {
    let rd = house(1.0, [78_000.0, 457_000.0, 0.0]);
    let toml = "[site]\nepsg = 28992\nrotate_deg = 30\n[[scene]]\nfile = \"a.obj\"\nepsg = 25832\n";
    let folder = Folder::with(&[("a.obj", rd), ("site.toml", toml.into())]);
    let plain = SiteFrame::default();
    let place = |names: &[&str], frame: &SiteFrame| folder.load(names, frame).expect("a scene").place.expect("a place");
    assert_eq!(folder.load(&["a.obj"], &plain).expect("a scene").place, None);
    let system = SiteFrame { epsg: Some(7415), ..plain };
    let known = place(&["a.obj"], &system);
    // PROJ: 52.0957 N 4.2634 E, -0.8866 degrees.
    assert!((known.latitude_deg - 52.0957).abs() < 1e-3 && (known.convergence_deg + 0.887).abs() < 2e-3, "{known:?}");
    one(&folder.said(&["site.toml"], &plain), &["a.obj states EPSG:25832, but the requested EPSG:28992 is used"]);
    let turned = place(&["site.toml"], &plain);
    assert!((turned.convergence_deg - known.convergence_deg - 30.0).abs() < 1e-9, "{turned:?}");
    let here = SiteFrame { latitude_deg: Some(52.1), longitude_deg: Some(4.3), ..system };
    assert_eq!(place(&["a.obj"], &here), known);
    let there = SiteFrame { latitude_deg: Some(40.0), ..here };
    one(&folder.said(&["a.obj"], &there), &["the stated latitude 40.0000 and longitude 4.3000 are 1345 km from"]);
    assert_eq!(place(&["a.obj"], &there).convergence_deg, 0.0);
    let nowhere = SiteFrame { rotate_deg: Some(10.0), ..plain };
    let error = folder.load(&["a.obj"], &nowhere).expect_err("no place").to_string();
    assert!(error.contains("rotate_deg") && error.contains("give latitude and longitude as well"), "{error}");
    let york = Folder::with(&[("york.obj", house(3.28, [998_114.0, 194_309.3, 0.0]))]);
    let feet = SiteFrame { epsg: Some(2263), ..plain };
    one(
        &york.said(&["york.obj"], &feet),
        &["coordinates of EPSG:2263 are in units of 0.3048006 m", "give scale 0.3048006"],
    );
    let scaled = SiteFrame { scale: Some(0.3048006), ..feet };
    assert_eq!(york.said(&["york.obj"], &scaled), [""; 0]);
    let place = york.load(&["york.obj"], &scaled).expect("a scene").place.expect("a place");
    assert!((place.latitude_deg - 40.7).abs() < 1e-3 && (place.longitude_deg + 73.95).abs() < 1e-3, "{place:?}");
    let web = Folder::with(&[("web.obj", house(1.0, [478_600.0, 6_814_000.0, 0.0]))]);
    let found = web.said(&["web.obj"], &SiteFrame { epsg: Some(3857), ..plain });
    one(&found, &["a metre of EPSG:3857 is 0.6", "EPSG:32631"]);
}

/// A file that is turned by 90 degrees clockwise has its y axis along x; the scene's own rotation
/// leaves coordinates as they are.
#[test]
fn a_turned_file_has_its_y_axis_along_x() {
    let toml = "[site]\nlatitude_deg = 50\nlongitude_deg = 9\nrotate_deg = 45\n\
                [[scene]]\nfile = \"a.obj\"\nrotate_deg = 90\noffset = [100, 0, 0]\n";
    let folder = Folder::with(&[("a.obj", house(1.0, [0.0; 3])), ("site.toml", toml.into())]);
    let scene = folder.load(&["site.toml"], &SiteFrame::default()).expect("a scene");
    let (low, high) = scene.mesh.bounds();
    let (low, high) = (low + scene.mesh.origin, high + scene.mesh.origin);
    assert!(
        (low - DVec3::new(100.0, -10.0, 0.0)).length() < 1e-3 && (high - DVec3::new(108.0, 0.0, 6.0)).length() < 1e-3
    );
    assert_eq!(scene.place.expect("stated").convergence_deg, 45.0);
    assert!(scene.report.notes.first().expect("a note").contains("45.00 degrees east"));
}

/// Two houses with y up, one by Blender and one with a comment, get a warning that names the
/// option. With y up they have a roof of 100 and walls of 240 m2; with a stated axis there is no
/// warning.
#[test]
fn houses_on_their_side_get_a_hint() {
    for (text, words) in [
        (include_str!("../../../tests/data/footprints/cases/blender_y_up.obj"), "look towards y"),
        (include_str!("../../../tests/data/footprints/cases/osm_y_up_with_place.obj"), "a comment of the file"),
    ] {
        let folder = TestFolder::new();
        let file = folder.write("house.obj", text);
        let load = |up| {
            let site = SceneFiles { parts: vec![Part { up, ..Part::plain(&file, None) }], ..SceneFiles::default() };
            Scene::load_with_objects(&site).expect("a scene")
        };
        let hint = |scene: &Scene| scene.report.warnings.iter().find(|warning| warning.contains("up y")).cloned();
        let (plain, _) = load(None);
        assert!(hint(&plain).is_some_and(|hint| hint.contains(words)), "{:?}", plain.report.warnings);
        assert_eq!(hint(&load(Some(UpAxis::Z)).0), None);
        let (scene, soup) = load(Some(UpAxis::Y));
        assert_eq!((areas_m2(&scene, &soup).map(f64::round), hint(&scene)), ([100.0, 240.0], None));
    }
}
