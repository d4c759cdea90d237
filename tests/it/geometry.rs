//! The scene's triangles in an archive.

use std::fs;
use std::path::Path;

use heliotile_builder::build::Plan;
use heliotile_builder::observer::Silent;
use heliotile_builder::settings::{Quality, Rungs};
use heliotile_builder::transfer::{Bounds, Selection, diff, extract, merge};
use heliotile_core::archive::tables::{GeometryTable, MAX_TRIANGLES};
use heliotile_core::archive::{Archive, format, verify};
use heliotile_scene::Scene;

use crate::cli::Folder;
use crate::scenes::*;

/// Corners and material of every triangle of an archive, relative to its origin.
fn triangles(archive: &Archive) -> Vec<([[f32; 3]; 3], u16)> {
    let chunk = |entry: &format::Entry| {
        let table = GeometryTable::from_block(&archive.fetch(entry).expect("a block")).expect("a table");
        let corners = table.corner.iter().map(|row| row.map(|corner| table.vertex[corner as usize]));
        corners.zip(table.material.iter().copied()).collect::<Vec<_>>()
    };
    archive.entries_of(format::SCENE).iter().flat_map(chunk).collect()
}

fn of_mesh(scene: &Scene) -> Vec<([[f32; 3]; 3], u16)> {
    let mesh = &scene.mesh;
    let corners = |i: usize| mesh.triangle_points(i).map(|point| point.as_vec3().to_array());
    (0..mesh.triangles.len()).map(|i| (corners(i), mesh.triangle_material[i])).collect()
}

fn built(scene: &Scene, path: &Path, with_scene: bool) -> Archive {
    let (whole, output) = plan(&Rungs::of(Quality::Draft).settings(), path);
    let receivers = &many()[..70];
    build(scene, &mut tiles(receivers, scene), &(Plan { with_scene, ..whole }, output)).expect("a build");
    Archive::open(path).expect("an archive")
}

/// An archive holds the triangles of its scene bit for bit, here those of a town (140 or more) and of a hilly plane of 131,072 in 2 chunks; parts and
/// unions of archives hold the same, also where one of two has none; extracts can do without; and each that has them differs from one that does not in
/// this one statement.
#[test]
fn triangles_are_those_that_were_traced() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let place = workspace(folder.path(), 64 << 20);
    let town = scene(&town(), &[0.2, 0.4]);
    let (whole, bare) = (built(&town, &path("whole.helio"), true), built(&town, &path("bare.helio"), false));
    let expected = of_mesh(&town);
    assert!(
        expected.len() >= 140 && triangles(&whole) == expected && triangles(&bare).is_empty(),
        "{}",
        expected.len()
    );
    assert!(verify(whole.path(), heliotile_core::archive::Access::Read, true).expect("verified").problems.is_empty());
    let part = |name: &str, low: f64, high: f64, with_scene: bool| {
        let bounds = Bounds { low: v(low, -1e3, -1e3), high: v(high, 1e3, 1e3) };
        extract(&whole, &Selection::Bounds(bounds), with_scene, &path(name), &place, &Silent).expect("an extract");
        Archive::open(&path(name)).expect("an archive")
    };
    let (west, east) = (part("west.helio", -1e3, 0.0, true), part("east.helio", 0.0, 1e3, false));
    assert!(triangles(&west) == expected && triangles(&east).is_empty());
    for both in [[&west, &east], [&east, &west]] {
        merge(both, &path("both.helio"), &place, &Silent).expect("a union");
        assert!(fs::read(path("both.helio")).expect("bytes") == fs::read(path("whole.helio")).expect("bytes"));
    }
    let found = diff(&whole, &bare, &place).expect("a comparison");
    let told: Vec<&str> = found.statements.iter().map(|told| told.item.as_str()).collect();
    assert!(told == ["triangles shown"] && !found.same_root, "{told:?}");

    let side = 256;
    let at = |i: usize, j: usize| v(i as f64, j as f64, 3.0 * (i as f64 * 0.1).sin() * (j as f64 * 0.07).cos());
    let cells = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    let hills: Triangles = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [([a, b, c], 0), ([a, c, d], 0)]
        })
        .collect();
    let hills = scene(&hills, &[0.3]);
    let archive = built(&hills, &path("hills.helio"), true);
    assert_eq!((archive.entries_of(format::SCENE).len(), hills.mesh.triangles.len()), (2, 2 * MAX_TRIANGLES));
    assert!(triangles(&archive) == of_mesh(&hills));
}

/// By the program: `build --no-scene` writes an archive without triangles, and `repair` keeps both kinds as they were, to the byte, after a bit of the
/// triangles or of the materials was flipped.
#[test]
fn with_and_without() {
    let folder = Folder::new();
    for (name, option, kind) in [("a.helio", "", format::SCENE), ("b.helio", "--no-scene", format::MATERIALS)] {
        folder.run(&format!("build scene.obj -m materials.toml -r receivers.csv -o {name} --quality draft {option}"));
        let whole = fs::read(folder.path(name)).expect("an archive");
        let archive = Archive::open(&folder.path(name)).expect("an archive");
        assert_eq!(archive.has(format::SCENE, 0), option.is_empty());
        let entry = &archive.entries_of(kind)[0];
        let mut bad = whole.clone();
        bad[entry.offset as usize + 20] ^= 4;
        drop(archive);
        fs::write(folder.path(name), bad).expect("written");
        folder.run(&format!("repair {name} scene.obj -m materials.toml -r receivers.csv"));
        assert!(fs::read(folder.path(name)).expect("repaired") == whole, "{name}");
    }
}
