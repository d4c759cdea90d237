//! Geometry in archives: the scene's triangles and an overview of its receivers.

use std::fs;
use std::path::Path;

use glam::DVec3;
use heliotile_archives::transfer::{Bounds, ExtractContent, Selection, diff, extract, merge};
use heliotile_builder::pipeline::Plan;
use heliotile_builder::settings::{Quality, Rungs};
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::{GeometryTable, MAX_TRIANGLES, OverviewTable};
use heliotile_core::archive::{Archive, format, verify};
use heliotile_core::observer::Silent;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::north::North;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::place::Place;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::weather::clear::clear_year;
use heliotile_scene::Scene;

use crate::cli::Folder;
use crate::scenes::*;

/// Returns the corners and the material of every triangle of an archive, relative to its origin.
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

/// Returns seventy receivers, every other one with an area and a patch.
fn receivers() -> Vec<Receiver> {
    let mut receivers = many()[..70].to_vec();
    for receiver in receivers.iter_mut().step_by(2) {
        receiver.area = Some(2.25);
        receiver.patch = Patch::square(receiver.normal, 2.25);
    }
    receivers
}

fn built(scene: &Scene, path: &Path, with_scene: bool) -> Archive {
    let (whole, output) = plan(&Rungs::new(Quality::Draft).settings(), path);
    build(scene, &mut tiles(&receivers(), scene), &(Plan { with_scene, ..whole }, output)).expect("a build");
    Archive::open(path).expect("an archive")
}

/// An archive holds the triangles of its scene bit for bit, here those of a town (140 or more) and
/// of a hilly plane of 131,072 in 2 chunks. Parts and unions of archives hold the same triangles,
/// also if one of two has none (then without an overview), and extracts can leave them out.
/// Archives with and without triangles differ only in what the scene, the overview and the objects
/// state.
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
        let (window, content) = (Selection::Bounds(bounds), ExtractContent { scene: with_scene, replay_only: false });
        extract(&whole, Some(&window), content, &path(name), &place, &Silent).expect("an extract");
        Archive::open(&path(name)).expect("an archive")
    };
    let (west, east) = (part("west.helio", -1e3, 0.0, true), part("east.helio", 0.0, 1e3, true));
    let dark = part("dark.helio", 0.0, 1e3, false);
    assert!(triangles(&west) == expected && triangles(&dark).is_empty());
    for both in [[&west, &east], [&east, &west]] {
        merge(both, &path("both.helio"), &place, &Silent).expect("a union");
        assert!(fs::read(path("both.helio")).expect("bytes") == fs::read(path("whole.helio")).expect("bytes"));
    }
    for both in [[&west, &dark], [&dark, &west]] {
        merge(both, &path("half.helio"), &place, &Silent).expect("a union");
        let half = Archive::open(&path("half.helio")).expect("an archive");
        assert!(triangles(&half) == expected && !half.has(format::OVERVIEW, TileNumber::FIRST));
    }
    let found = diff(&whole, &bare, &place).expect("a comparison");
    let told: Vec<&str> = found.statements.iter().map(|told| told.item.as_str()).collect();
    assert!(told == ["shown.objects", "shown.overview", "shown.triangles"] && !found.same_root, "{told:?}");
    assert_eq!(found.receivers.different.count, 0);

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

/// In the program, `build --no-scene` writes an archive without triangles, and `repair` keeps both
/// kinds to the byte after a bit of the triangles or of the materials was flipped.
#[test]
fn repair_keeps_archives_with_and_without_triangles() {
    let folder = Folder::new();
    for (name, option, kind) in [("a.helio", "", format::SCENE), ("b.helio", "--no-scene", format::MATERIALS)] {
        folder.run(&format!("build scene.obj -m materials.toml -r receivers.csv -o {name} --quality draft {option}"));
        let whole = fs::read(folder.path(name)).expect("an archive");
        let archive = Archive::open(&folder.path(name)).expect("an archive");
        assert_eq!(archive.has(format::SCENE, TileNumber::FIRST), option.is_empty());
        let entry = &archive.entries_of(kind)[0];
        let mut bad = whole.clone();
        bad[entry.offset as usize + 20] ^= 4;
        drop(archive);
        fs::write(folder.path(name), bad).expect("written");
        folder.run(&format!("archive repair {name} scene.obj -m materials.toml -r receivers.csv"));
        assert!(fs::read(folder.path(name)).expect("repaired") == whole, "{name}");
    }
}

/// An overview holds for each of 70 receivers its place within 0.1 mm, its normal within 0.01
/// degrees, its area, its sky view within 1/510, its patch, and the sum over the clear year within
/// 0.02 % of the hours one by one plus half a step. It stands in one range, and without a place
/// there are no sums.
#[test]
fn overviews_hold_places_and_sums_of_receivers() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut town = mirror_town();
    let nowhere = built(&town, &folder.path().join("nowhere.helio"), true);
    let place = Place { latitude_deg: 52.08, longitude_deg: 4.31, convergence_deg: 12.0, epsg: None };
    town.place = Some(place);
    let archive = built(&town, &folder.path().join("site.helio"), true);
    let site = OpenSite::open(&archive).expect("a site");
    let (conditions, bins) = clear_year(&place);
    assert!(conditions.len() > 100, "{}", conditions.len());
    let settings = ReplaySettings { patches: 145, ..ReplaySettings::default() };
    let replay = Replay::new(&site, &conditions, settings).expect("a replay");
    let (mut seen, mut given) = (0, receivers());
    for tile in 0..archive.tiles() {
        let of = |archive: &Archive| {
            OverviewTable::from_block(&archive.block(format::OVERVIEW, TileNumber(tile)).expect("a block"))
                .expect("an overview")
        };
        let (overview, views) = (of(&archive), site.tile_receivers(tile).expect("receivers").sky_view);
        assert!(of(&nowhere).clear_year.is_empty() && of(&nowhere).patches() == overview.patches());
        let (ids, values) = &replay.run([tile]).expect("hours")[0];
        for (row, (id, patch)) in ids.iter().zip(overview.patches()).enumerate() {
            let receiver = given.remove(given.iter().position(|receiver| receiver.id == *id).expect("a receiver"));
            let position = town.mesh.origin + DVec3::from(overview.position[row].map(f64::from));
            assert!((position - receiver.position).length() < 1e-4, "{id}");
            let normal = DVec3::from(overview.normal[row].map(f64::from)) / 32_767.0;
            assert!((normal - receiver.normal).length() < 2e-4, "{id}");
            assert_eq!((overview.area[row], &patch), (receiver.area.unwrap_or(0.0) as f32, &receiver.patch));
            assert!((f32::from(overview.sky_view[row]) / 255.0 - views[row]).abs() <= 1.001 / 510.0, "{id}");
            let hours = values.row(Component::Total, row).iter().zip(&bins.of_condition);
            let sum: f64 = hours.map(|(value, (_, weight))| f64::from(*value) * weight).sum();
            let off = (f64::from(overview.clear_year[row]) - sum).abs();
            assert!(off <= 0.125 + 2e-4 * sum, "{id}: {} for {sum}", overview.clear_year[row]);
            seen += 1;
        }
    }
    assert_eq!(seen, 70);
    let ranges: Vec<(u64, u64)> =
        archive.entries_of(format::OVERVIEW).iter().map(|entry| (entry.offset, u64::from(entry.stored))).collect();
    assert!(ranges.windows(2).all(|pair| pair[1].0 - pair[0].0 - pair[0].1 < 64), "{ranges:?}");
}

/// In the program, the patches of a table of receivers make up their areas within 0.5 %, all 100 or
/// more of them, and the archive holds them unchanged.
#[test]
fn patches_come_from_the_table() {
    let folder = Folder::new();
    folder.run("receivers scene.obj -m materials.toml -o grid.csv --spacing 1.5m --on all");
    folder.run("build scene.obj -m materials.toml -r grid.csv -o grid.helio --quality draft");
    let rows = heliotile_scene::points::receivers::read_receivers(&folder.path("grid.csv"), North::default())
        .expect("receivers");
    let archive = Archive::open(&folder.path("grid.helio")).expect("an archive");
    let mut shown = Vec::new();
    for tile in 0..archive.tiles() {
        let table = OverviewTable::from_block(&archive.block(format::OVERVIEW, TileNumber(tile)).expect("a block"))
            .expect("a table");
        let site = OpenSite::open(&archive).expect("a site");
        shown.extend(site.tile_receivers(tile).expect("receivers").ids.into_iter().zip(table.patches()));
    }
    for receiver in &rows {
        let exact = |corner: [i32; 3]| DVec3::from(corner.map(f64::from)) / 1e3;
        let area = |[a, b, c]: [[i32; 3]; 3]| (exact(b) - exact(a)).cross(exact(c) - exact(a)).length() / 2.0;
        let (sum, given) = (receiver.patch.triangles().map(area).sum::<f64>(), receiver.area.expect("an area"));
        assert!((sum / given - 1.0).abs() < 5e-3, "{}: {sum} of {given}", receiver.id);
        assert!(shown.iter().any(|(id, patch)| *id == receiver.id && *patch == receiver.patch), "{}", receiver.id);
    }
    assert!(rows.len() >= 100 && rows.len() == shown.len(), "{}", rows.len());
}
