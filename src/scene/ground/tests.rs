//! Tests of scenes with and without ground, in several formats.

use std::fs;
use std::path::Path;

use crate::Scene;
use crate::site::{MissingGround, Part, SceneFiles};
use crate::test_files::TestFolder;

/// A box of 4 x 6 x 3 m at 2 m, and below it a floor of the material `ground`.
const BOX: &str = "v 0 0 2\nv 4 0 2\nv 4 6 2\nv 0 6 2\nv 0 0 5\nv 4 0 5\nv 4 6 5\nv 0 6 5\nusemtl roof\nf 5 6 7 8\nusemtl wall\n\
                   f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nusemtl ground\nf 4 3 2 1\n";
const LAWN: &str = "v -9 -9 2\nv 9 -9 2\nv 9 9 2\nv -9 9 2\nusemtl grass\nf -4 -3 -2 -1\n";
const MODEL: &str = "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World;\n\
                     Site:GroundReflectance,0.4,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.4; Shading:Site:Detailed,S,,3, 0,9,1, 1,9,1, 1,9,2;\n";

fn load(files: &[&Path], materials: Option<&Path>) -> Scene {
    let parts = files.iter().map(|file| Part::plain(file, materials)).collect();
    Scene::load_site(&SceneFiles { parts, missing_ground: MissingGround::Assume, ..SceneFiles::default() })
        .expect("a scene")
}

/// Returns the lowest height of the scene and the reflectance of its endless ground.
fn plane(scene: &Scene) -> (f64, Option<f64>) {
    let low = scene.mesh.bounds().0 + scene.mesh.origin;
    let ground = scene.materials.iter().find(|material| material.name == "endless_ground");
    ((low.z * 1e3).round() / 1e3, ground.map(|ground| ground.diffuse))
}

/// A box with a floor gets a plane of 0.2 that lies 1 cm below it, and one warning states the
/// height and both alternatives. A lawn around it is ground, a table of 0.3 at 1 m takes
/// precedence, and a scene for which no ground is requested gets none.
#[test]
fn a_scene_without_ground_gets_a_plane() {
    let folder = TestFolder::new();
    let bare = folder.write("bare.obj", BOX);
    let scene = load(&[&bare], None);
    assert_eq!((plane(&scene), scene.mesh.triangles.len()), ((1.99, Some(0.2)), 14));
    let said: Vec<_> = scene.report.warnings.iter().filter(|text| text.contains("ground:")).collect();
    assert_eq!(said.len(), 1);
    assert!(
        said[0]
            .plain()
            .starts_with("the scene has no ground: a plane that reflects 0.2 is assumed at its lowest point, 2.00 m")
    );
    assert!(said[0].contains("no_ground") && said[0].contains("[endless_ground]"), "{:?}", said[0]);
    assert!(scene.report.assumed.contains(&"endless_ground".to_owned()));

    let around = folder.write("lawn.obj", format!("{BOX}{LAWN}"));
    assert_eq!(plane(&load(&[&around], None)), (2.0, None));
    let table = folder.write("m.toml", "[endless_ground]\ndiffuse = 0.3\nelevation = 1\n");
    assert_eq!(plane(&load(&[&bare], Some(&table))), (1.0, Some(0.3)));
    assert_eq!(plane(&Scene::load(&bare, None).expect("a scene")), (2.0, None));
}

/// A road beside a box, a road 40 m below it and wide land 40 m below it do not surround it: a
/// plane lies 1 cm below the feet of the box, at 2 m, and the warning says so. Before, the road
/// took the plane away, and walls got 785 of 912 kWh/m2.
#[test]
fn a_road_does_not_take_the_plane_away() {
    let folder = TestFolder::new();
    let land = |[x, y]: [[i32; 2]; 2], z: i32| {
        let corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
        let corners: String = corners.iter().map(|[x, y]| format!("v {x} {y} {z}\n")).collect();
        format!("{BOX}{corners}usemtl Road\nf -4 -3 -2 -1\n")
    };
    let cases = [
        (land([[-20, 20], [-15, -5]], 2), "its lowest point, 2.00 m"),
        (land([[-20, 20], [-15, -5]], -38), "the lowest point of what stands, 2.00 m"),
        (land([[-99, 99], [-99, 99]], -38), "the lowest point of what stands, 2.00 m"),
    ];
    for (text, at) in cases {
        let scene = load(&[&folder.write("land.obj", &text)], None);
        assert_eq!(plane(&scene).1, Some(0.2));
        let said =
            format!("the ground of the scene does not surround it: a plane that reflects 0.2 is assumed at {at}");
        assert!(
            scene.report.warnings.iter().any(|text| text.plain().starts_with(&said)),
            "{:?}",
            scene.report.warnings
        );
    }
}

/// 1,600 m2 of a material `slab` below a box are ground by their shape, which a warning says; the
/// roof of the box and a floor below it are not, and `asphalt` is ground by its name.
#[test]
fn ground_without_a_name_for_it_is_reported() {
    let folder = TestFolder::new();
    let said = |name: &str| {
        let text = format!("{BOX}v -20 -20 2\nv 20 -20 2\nv 20 20 2\nv -20 20 2\nusemtl {name}\nf -4 -3 -2 -1\n");
        let scene = load(&[&folder.write("box.obj", &text)], None);
        let about = |text: &&heliotile_core::text::Message| text.contains("counts as an obstruction");
        (scene.report.warnings.iter().find(about).cloned(), plane(&scene).1)
    };
    let (warning, assumed) = said("slab");
    assert!(warning.is_some_and(|text| {
        text.plain().starts_with("material `slab` counts as an obstruction, but its 1600 m2 lie below")
    }));
    assert_eq!(assumed, Some(0.2));
    assert_eq!(said("asphalt"), (None, None));
}

/// The Hague with its terrain gets no plane; without the terrain it gets one at the lowest point of
/// 54 buildings, 3.692 m: floors are no ground. Three buildings of another city model get a plane
/// as well.
#[test]
fn floors_of_a_city_model_are_no_ground() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/cityjson");
    let whole = data.join("hague.city.json");
    assert_eq!(plane(&load(&[&whole], None)).1, None);
    let mut city: serde_json::Value = serde_json::from_slice(&fs::read(&whole).expect("bytes")).expect("JSON");
    let objects = city["CityObjects"].as_object_mut().expect("objects");
    objects.retain(|_, object| object["type"] != "TINRelief");
    let folder = TestFolder::new();
    let bare = folder.write("bare.city.json", city.to_string());
    assert_eq!(plane(&load(&[&bare], None)), (3.692, Some(0.2)));
    assert_eq!(plane(&load(&[&data.join("small.city.jsonl")], None)).1, Some(0.2));
}

/// A model of 0.4 in two months and 0.2 in ten gets a plane of their mean at z = 0, 1 m below its
/// only surface; a note says so, and the months are kept. A table of 0.3 takes precedence over
/// both, a lawn beside the model over the plane. A model of 0.2 in all months keeps no months.
#[test]
fn a_model_gets_its_monthly_ground() {
    let folder = TestFolder::new();
    let model = folder.write("m.idf", MODEL);
    let scene = load(&[&model], None);
    let (low, diffuse) = plane(&scene);
    assert!(low == -0.01 && diffuse.is_some_and(|diffuse| (diffuse - 2.8 / 12.0).abs() < 1e-12), "{low} {diffuse:?}");
    let months = scene.ground.expect("by month");
    assert_eq!((months.of(12, None), months.of(6, None), months.material.as_str()), (0.4, 0.2, "endless_ground"));
    let [note] = scene.report.notes.as_slice() else { panic!("{:?}", scene.report.notes) };
    assert!(note.plain().starts_with("ground: a plane at 0.00 m that reflects 0.2 to 0.4 by month, as "), "{note:?}");
    assert!(!scene.report.warnings.iter().any(|text| text.contains("ground")), "{:?}", scene.report.warnings);

    let table = folder.write("m.toml", "[endless_ground]\ndiffuse = 0.3\n");
    let scene = load(&[&model], Some(&table));
    assert_eq!((plane(&scene), scene.ground), ((1.0, Some(0.3)), None));
    let lawn = folder.write("lawn.obj", LAWN);
    let scene = load(&[&model, &lawn], None);
    assert_eq!((plane(&scene), scene.ground), ((1.0, None), None));
    let plain = folder.write("plain.idf", MODEL.replace("0.4", "0.2"));
    let scene = load(&[&plain], None);
    assert_eq!((plane(&scene), scene.ground), ((-0.01, Some(0.2)), None));
}
