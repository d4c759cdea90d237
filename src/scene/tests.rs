//! Tests of whole files and of triangles in memory: a scene does not depend on how it was written
//! down.

use std::path::{Path, PathBuf};

use crate::site::{Part, SceneFiles};
use crate::test_files::{Random, TestFolder};
use crate::*;

const VERTICES: &str = "v 78000.125 457000.5 3.25\nv 78010.125 457000.5 3.25\nv 78010.125 457010.5 3.25\n\
                        v 78000.125 457010.5 3.25\nv 78005.125 457005.5 9.75\n";
const MATERIALS: &str = "[roof]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.3\nspecular = 0.1\ngroup = \"facade\"\n";

fn load(obj: &str, materials: &str) -> Result<Scene> {
    let folder = TestFolder::new();
    let obj = folder.write("town.obj", obj);
    Scene::load(&obj, Some(&folder.write("materials.toml", materials)))
}

fn message(obj: &str, materials: &str) -> String {
    load(obj, materials).expect_err("refused").to_string()
}

/// Faces, materials and vertices in another order give the same content hash and, byte for byte,
/// the same mesh.
#[test]
fn the_order_of_faces_keeps_hash_and_mesh() {
    let faces = "usemtl wall\nf 1 2 5\nf 2 3 5\nusemtl roof\nf 1 4 3 2\n";
    let one = load(&format!("{VERTICES}{faces}"), MATERIALS).expect("readable");
    let reversed: String = VERTICES.lines().rev().map(|line| format!("{line}\r\n")).collect();
    let other =
        format!("{reversed}usemtl roof\r\nf -4 -3 -2 -1\r\nusemtl wall\r\nf 3//1 1//1 4//1\r\nf 5/1 4/1 1/1\r\n");
    let other = load(&other, MATERIALS).expect("readable");
    assert_eq!(one.mesh.triangles.len(), 4);
    assert_eq!(one.mesh.triangles, other.mesh.triangles);
    assert_eq!(one.mesh.vertices, other.mesh.vertices);
    assert_eq!(one.mesh.origin, DVec3::new(78_080.0, 456_960.0, 0.0));
    assert_eq!(one.content_hash(), other.content_hash());
}

/// Every part of the content changes the hash: eight scenes have eight hashes. The report does not
/// change it.
#[test]
fn every_part_of_the_content_changes_the_hash() {
    let faces = "usemtl wall\nf 1 2 5\nusemtl roof\nf 1 4 3 2\n";
    let obj = format!("{VERTICES}{faces}");
    let mut hashes: Vec<[u8; 32]> = [
        (obj.clone(), MATERIALS.to_owned()),
        (obj.replace("3.25", "3.26"), MATERIALS.to_owned()),
        (obj.replace("457", "458"), MATERIALS.to_owned()),
        (obj.replace("f 1 2 5", "f 2 1 5"), MATERIALS.to_owned()),
        (obj.replace("wall", "mall"), MATERIALS.replace("wall", "mall")),
        (obj.clone(), MATERIALS.replace("0.3", "0.4")),
        (obj.clone(), MATERIALS.replace("facade", "front")),
        (obj.clone(), MATERIALS.replace("0.2", "0.2\nclass = \"ground\"")),
    ]
    .iter()
    .map(|(obj, materials)| load(obj, materials).expect("readable").content_hash())
    .collect();
    let with_twin = load(&format!("{obj}f 1 4 3 2\nf 1 1 2\n"), MATERIALS).expect("readable");
    assert_eq!((with_twin.report.duplicates_dropped, with_twin.report.degenerate_dropped), (0, 1));
    assert!(
        with_twin.report.warnings[0].contains("1 face of `town` appeared twice"),
        "{:?}",
        with_twin.report.warnings
    );
    assert_eq!(with_twin.content_hash(), hashes[0]);
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 8);
}

/// The report counts faces, triangles by material, dropped faces and concave faces; unused tables
/// get a warning.
#[test]
fn the_report_counts_faces_and_triangles() {
    let obj = format!("{VERTICES}usemtl wall\nf 1 2 5\nf 1 2\nusemtl roof\nf 1 5 2 3 4\nusemtl gone\nf 1 1 1\n");
    let scene = load(&obj, &format!("{MATERIALS}[glass]\ndiffuse = 0\n")).expect("readable");
    let report = &scene.report;
    assert_eq!((report.faces_read, report.triangles, report.degenerate_dropped), (4, 4, 2));
    assert_eq!((report.duplicates_dropped, report.concave_faces), (0, 1));
    let used: Vec<(&str, usize)> =
        report.materials.iter().map(|entry| (entry.name.as_str(), entry.triangles)).collect();
    assert_eq!(used, [("roof", 3), ("wall", 1)]);
    assert_eq!(scene.materials.iter().map(|material| material.diffuse).collect::<Vec<_>>(), [0.2, 0.3]);
    assert_eq!(report.warnings.len(), 2);
    assert!(report.warnings[0].contains("1 faces are not flat"), "{:?}", report.warnings[0]);
    assert!(report.warnings[1].contains("does not use material `glass`"), "{:?}", report.warnings[1]);
}

/// Without `materials.toml` the MTL libraries beside the OBJ file count; with a table of all
/// materials they are not even opened.
#[test]
fn mtl_counts_without_materials_toml() {
    let folder = TestFolder::new();
    let obj =
        folder.write("town.obj", format!("mtllib a.mtl b.mtl\n{VERTICES}usemtl wall\nf 1 2 5\nusemtl roof\nf 1 3 4\n"));
    folder.write("a.mtl", "newmtl wall\nKd 0.4 0.5 0.6\n");
    folder.write("b.mtl", "newmtl roof\nKd 0.1 0.1 0.1\nKs 0.5 0.5 0.5\nillum 3\n");
    let scene = Scene::load(&obj, None).expect("readable");
    assert_eq!((scene.materials[0].specular, scene.materials[1].diffuse), (0.5, 0.5));
    folder.write("b.mtl", "newmtl roof\nKd red\n");
    let refusal = Scene::load(&obj, None).expect_err("bad library").to_string();
    assert!(refusal.contains("b.mtl, line 2") && refusal.contains("`red`"), "{refusal}");
    let materials = folder.write("materials.toml", MATERIALS);
    assert_eq!(Scene::load(&obj, Some(&materials)).expect("readable").materials[1].diffuse, 0.3);
}

/// If only the table counts, a material that it does not describe is an error with the file, the
/// count and the lines to add.
#[test]
fn a_material_missing_in_the_table_is_an_error() {
    let folder = TestFolder::new();
    let obj = folder.write("town.obj", format!("{VERTICES}f 1 2 3 4\n"));
    let materials = folder.write("materials.toml", MATERIALS);
    let strict = Part { materials_only: true, ..Part::plain(&obj, Some(&materials)) };
    let refused = Scene::load_site(&SceneFiles { parts: vec![strict], ..SceneFiles::default() });
    let found = refused.expect_err("not described").to_string();
    for part in ["materials.toml: ", "`default`, which 2 triangles use", "[default]"] {
        assert!(found.contains(part), "{found}");
    }
}

/// A table of the wall alone leaves the roof to the library, and a bad library block of the wall
/// does no harm; a misspelt `rof` is reported with the `roof` that it may stand for. Two files that
/// state 0.5 and 0.1 for a wall have one wall of 0.3 under the table, and two walls without it.
#[test]
fn a_table_overlays_the_library() {
    let folder = TestFolder::new();
    let town = |name: &str, library: &str| {
        folder.write(&format!("{name}.mtl"), library);
        folder.write(
            &format!("{name}.obj"),
            format!("mtllib {name}.mtl\n{VERTICES}usemtl wall\nf 1 2 5\nusemtl roof\nf 1 3 4\n"),
        )
    };
    let obj = town("town", "newmtl wall\nKd red\nnewmtl roof\nKd 0.4 0.5 0.6\n");
    let materials = folder.write("materials.toml", "[wall]\ndiffuse = 0.3\n[rof]\ndiffuse = 0.1\n");
    let scene = Scene::load(&obj, Some(&materials)).expect("readable");
    assert_eq!(scene.materials.iter().map(|material| material.diffuse).collect::<Vec<_>>(), [0.5, 0.3]);
    let [warning] = scene.report.warnings.as_slice() else { panic!("{:?}", scene.report.warnings) };
    assert!(warning.plain().ends_with("does not use material `rof` (did you mean `roof`?)"), "{warning:?}");

    let roof = "newmtl roof\nKd 0.2\nnewmtl wall\nKd";
    let files = [town("a", &format!("{roof} 0.5\n")), town("b", &format!("{roof} 0.1\n"))];
    let walls = |materials: Option<&Path>| -> Vec<f64> {
        let part = |file: &PathBuf, x| Part { offset: DVec3::new(x, 0.0, 0.0), ..Part::plain(file, materials) };
        let parts = vec![part(&files[0], 0.0), part(&files[1], 50.0)];
        let scene = Scene::load_site(&SceneFiles { parts, ..SceneFiles::default() }).expect("readable");
        let walls = scene.materials.iter().filter(|material| material.name.starts_with("wall"));
        walls.map(|material| material.diffuse).collect()
    };
    assert_eq!((walls(Some(&materials)), walls(None)), (vec![0.3], vec![0.5, 0.1]));
}

/// Without any description a usual reflectance of 0.20 is assumed; one warning names the material
/// and the way to state a better value.
#[test]
fn an_undescribed_material_is_assumed() {
    let folder = TestFolder::new();
    let scene = Scene::load(&folder.write("town.obj", format!("{VERTICES}f 1 2 3 4\n")), None).expect("assumed");
    assert_eq!((scene.materials[0].diffuse, scene.report.warnings.len()), (0.2, 1));
    let found = &scene.report.warnings[0];
    assert!(found.contains("`default` diffuse 0.2") && found.contains("materials"), "{found:?}");
}

/// Scenes of nothing but degenerate faces and files that do not exist are refused by name.
#[test]
fn scenes_without_faces_are_refused() {
    let found = message(&format!("{VERTICES}f 1 2 1\nf 2 2 3\n"), MATERIALS);
    assert!(found.contains("town.obj: none of the 2 faces has an area"), "{found}");
    let found = Scene::load(Path::new("/nowhere/town.obj"), None).expect_err("no file").to_string();
    assert!(found.contains("cannot read /nowhere/town.obj"), "{found}");
}

/// A scene from triangles in memory equals the one read from a file, whatever the order of its
/// materials.
#[test]
fn a_scene_from_memory_equals_the_file() {
    let file = load(&format!("{VERTICES}usemtl wall\nf 1 2 5\nusemtl roof\nf 1 2 3\n"), MATERIALS).expect("readable");
    let [roof, wall] = file.materials.as_slice() else { panic!("two materials") };
    let unused = Material { name: "unused".to_owned(), ..roof.clone() };
    let corner = |x: f64, y: f64, z: f64| DVec3::new(78_000.125 + x, 457_000.5 + y, 3.25 + z);
    let base = [corner(0., 0., 0.), corner(10., 0., 0.), corner(10., 10., 0.)];
    let side = [corner(5., 5., 6.5), corner(0., 0., 0.), corner(10., 0., 0.)];
    let memory =
        Scene::from_triangles(&[(base, 2), (side, 0)], vec![wall.clone(), unused, roof.clone()]).expect("valid");
    assert_eq!(memory.content_hash(), file.content_hash());
    assert_eq!(memory.materials.len(), 2);

    let dark = Material { diffuse: -0.1, ..roof.clone() };
    for (triangles, materials, quoted) in [
        (vec![(base, 1)], vec![roof.clone()], "triangle 0 has material number 1, but the number of materials is 1"),
        (vec![([base[0], base[1], DVec3::NAN], 0)], vec![roof.clone()], "triangle 0 has a corner at [NaN"),
        (vec![(base, 0)], vec![roof.clone(), roof.clone()], "two materials are called `roof`"),
        (vec![(base, 0)], vec![dark], "`diffuse` is -0.1"),
        (vec![([base[0]; 3], 0)], vec![roof.clone()], "none of the 1 triangles has an area"),
        (vec![], vec![], "none of the 0 triangles"),
    ] {
        let found = Scene::from_triangles(&triangles, materials).expect_err(quoted).to_string();
        assert!(found.contains(quoted), "{found}");
    }
}

/// 20,000 damaged files are read or refused; every mesh that comes out keeps the promises of its
/// type.
#[test]
fn damaged_files_give_valid_meshes_or_errors() {
    let whole =
        format!("{VERTICES}mtllib x.mtl\nusemtl wall\nf 1 2 5\nf 2/1 3/1/2 -1//4\nusemtl roof # r\nf 1 2 \\\n 5 3 4\n");
    let mut random = Random::new();
    let mut read = 0;
    for _ in 0..20_000 {
        let mut bytes = whole.clone().into_bytes();
        for _ in 0..1 + random.below(4) {
            let place = random.below(bytes.len());
            match random.below(3) {
                0 => bytes[place] = b"0123456789.-+e/ \\\n\r#vfn\xff"[random.below(24)],
                1 => drop(bytes.remove(place)),
                _ => bytes.insert(place, b"0123456789.-+e/ \\\n\r#vfn\xff"[random.below(24)]),
            }
        }
        let Ok((obj, _)) = formats::obj::parse(&bytes, Path::new("town.obj")) else {
            continue;
        };
        let cut = polygon::triangulate(&obj).expect("small faces");
        // A digit or an exponent more may put a vertex too far away.
        let Ok(Canonical { mesh, .. }) = canonical(&obj.vertices, cut.triangles, None) else { continue };
        assert!(mesh.vertices.is_sorted_by(|a, b| heliotile_core::site::morton::lexicographic(*a, *b).is_lt()));
        for (i, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            assert!(a < b && a < c && mesh.normal(i).is_normalized());
        }
        read += 1;
    }
    assert!(read > 5_000, "{read}");
}
