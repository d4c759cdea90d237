//! Light that overlapping scenes and variants of a site share: cells, hits and responses, to the
//! bit.

use std::collections::BTreeMap;

use glam::DVec3;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::{Archive, format};
use heliotile_core::layers::cells::Cell;
use heliotile_core::opened::{CellSource, OpenSite};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::read_receivers_with_warnings;

use crate::scenes::*;

/// Position of the town, in coordinates of a national grid.
const PLACE: DVec3 = DVec3::new(85_321.7, 446_123.4, 3.3);

/// Returns settings that are cheap to trace.
fn coarse() -> BuildSettings {
    BuildSettings { sky_base: 32, sky_fine: 128, hit: 16, probe: 16, ..BuildSettings::default() }
}

fn moved(triangles: Triangles, shift: DVec3) -> Triangles {
    triangles.into_iter().map(|(corners, material)| (corners.map(|p| p + shift), material)).collect()
}

/// Returns a box of 10 m in front of a place and deep below it, which no surface of the scene sees:
/// it moves the bounding box only.
fn hidden(at: DVec3) -> Triangles {
    block(at, at + 10.0, 1)
}

/// Returns all cells of an archive, probes and bounce cells apart, by key.
fn cells(path: &std::path::Path) -> [BTreeMap<CellKey, Cell>; 2] {
    let archive = Archive::open(path).expect("an archive");
    let site = OpenSite::open(&archive).expect("a site");
    let sources = [CellSource::probes(&site).expect("probes"), CellSource::bounces(&site).expect("bounce cells")];
    sources.map(|source| {
        let chunk = |number: usize| {
            let cells = source.chunk(number).expect("a chunk");
            (0..cells.keys.len()).map(|row| cells.cell(row)).collect::<Vec<Cell>>()
        };
        (0..source.chunks()).flat_map(chunk).map(|cell| (cell.key, cell)).collect()
    })
}

/// Returns the kind, tile and content id of every block of an archive but scene and overview: the
/// scene holds all triangles, seen or not, and positions of the overview are relative to the origin
/// of the scene.
fn blocks(path: &std::path::Path) -> Vec<(String, [u8; 32])> {
    let archive = Archive::open(path).expect("an archive");
    let traced = archive.entries().iter().filter(|entry| ![format::SCENE, format::OVERVIEW].contains(&entry.kind));
    traced.map(|entry| (format::block_name(entry.kind, entry.tile), entry.content)).collect()
}

/// Returns the scene of a cut of The Hague as triangles in input coordinates, and its materials and
/// receivers.
fn hague_cut() -> (Triangles, Vec<Material>, Vec<Receiver>) {
    let scene = Scene::load(&data("scene.obj"), Some(&data("materials.toml"))).expect("a scene");
    let mesh = &scene.mesh;
    let triangle = |i: usize| (mesh.triangle_points(i).map(|p| p + mesh.origin), mesh.triangle_material[i]);
    let triangles = (0..mesh.triangles.len()).map(triangle).collect();
    let receivers =
        read_receivers_with_warnings(&data("receivers.csv"), North::default(), &mut Vec::new()).expect("receivers");
    (triangles, scene.materials, receivers)
}

/// A town, and the cut of The Hague, are built in two scenes each, whose origins lie 768 m and 512
/// m apart on each axis because of a box that no surface sees. Every block of the two archives is
/// equal to the bit: layers, cells and responses of 150 and 78 receivers.
#[test]
fn overlapping_scenes_share_all_blocks() {
    let (cut, materials, at_cut) = hague_cut();
    let (low, high) = cut.iter().flat_map(|t| t.0).fold((cut[0].0[0], cut[0].0[0]), |(l, h), p| (l.min(p), h.max(p)));
    let middle = 0.5 * (low + high);
    let at_town: Vec<Receiver> = many().into_iter().map(|r| Receiver { position: r.position + PLACE, ..r }).collect();
    let town = moved(town(), PLACE);
    let of_town = [Material::matt("m0", 0.2, Class::Ground), Material::matt("m1", 0.4, Class::Obstruction)].to_vec();
    for (triangles, materials, receivers, middle) in [(town, of_town, at_town, PLACE), (cut, materials, at_cut, middle)]
    {
        // The boxes pull the origins to either side.
        let scene = |side: f64| {
            let far = middle + DVec3::new(side * 900.0, side * 850.0, -800.0 - side * 20.0);
            let all = [triangles.clone(), hidden(far)].concat();
            Scene::from_triangles(&all, materials.clone()).expect("a scene")
        };
        let (west, east) = (scene(-1.0), scene(1.0));
        let apart = east.mesh.origin - west.mesh.origin;
        assert!(apart.x >= 512.0 && apart.y >= 512.0, "{apart}");
        let sites = [west, east].map(|scene| site(&scene, &receivers, &coarse()));
        let [a, b] = sites.each_ref().map(|site| blocks(&site.path));
        assert!(a.len() >= 9, "{}", a.len());
        let different: Vec<&String> = a.iter().zip(&b).filter(|(a, b)| a != b).map(|(a, _)| &a.0).collect();
        assert_eq!((different, a.len()), (Vec::new(), b.len()));
        let [probes, bounces] = cells(&sites[0].path).map(|cells| cells.len());
        eprintln!("{probes} probes, {bounces} bounce cells, origins {apart} apart");
        assert!(probes > 1_000 && bounces > 1_000, "{probes} {bounces}");
    }
}

/// Two parts of the cut of The Hague overlap by 120 m, with the receivers of the middle 80 m. Most
/// cells that both archives hold see nothing that only one part has, and these are equal to the
/// bit: over 70 % of the probes, 65 % of the bounce cells.
#[test]
fn parts_of_a_city_share_most_cells() {
    let (cut, materials, receivers) = hague_cut();
    let xs = || cut.iter().flat_map(|t| t.0).map(|p| p.x);
    let middle = 0.5 * (xs().fold(f64::MAX, f64::min) + xs().fold(f64::MIN, f64::max));
    let near: Vec<Receiver> = receivers.into_iter().filter(|r| (r.position.x - middle).abs() < 40.0).collect();
    assert!(near.len() > 10, "{}", near.len());
    let part = |side: f64| {
        let kept = |corners: &[DVec3; 3]| corners.iter().any(|p| (p.x - middle) * side > -60.0);
        let mut triangles: Triangles = cut.iter().filter(|t| kept(&t.0)).cloned().collect();
        triangles.extend(hidden(DVec3::new(middle + side * 700.0, cut[0].0[0].y, -700.0)));
        Scene::from_triangles(&triangles, materials.clone()).expect("a scene")
    };
    let (west, east) = (part(-1.0), part(1.0));
    assert!((east.mesh.origin - west.mesh.origin).x > 256.0);
    let [of_west, of_east] = [west, east].map(|scene| cells(&site(&scene, &near, &coarse()).path));
    let mut shares = Vec::new();
    for (a, b) in of_west.iter().zip(&of_east) {
        let both: Vec<(&Cell, &Cell)> = a.iter().filter_map(|(key, cell)| Some((cell, b.get(key)?))).collect();
        let equal = both.iter().filter(|(a, b)| a == b).count();
        eprintln!("{} and {} cells, {} in both, {equal} of them equal", a.len(), b.len(), both.len());
        shares.push(equal as f64 / both.len() as f64);
    }
    assert!(shares[0] > 0.70 && shares[1] > 0.65, "{shares:?}");
}

/// A tower adds one material, whose name moves the numbers of all others: every cell of the town
/// that has its back to it is equal to the bit but for these numbers, and each of the others that
/// is not equal sees the tower, in its hits or as less sky.
#[test]
fn variants_share_what_does_not_see_the_change() {
    let receivers: Vec<Receiver> = many().into_iter().map(|r| Receiver { position: r.position + PLACE, ..r }).collect();
    let base = scene(&moved(town(), PLACE), &[0.2, 0.4]);
    let mut materials = base.materials.clone();
    materials.push(Material::matt("a tower", 0.6, Class::Obstruction));
    let tower = block(PLACE + v(120.0, 120.0, 0.0), PLACE + v(150.0, 150.0, 70.0), 2);
    let variant = Scene::from_triangles(&[moved(town(), PLACE), tower].concat(), materials).expect("a scene");
    assert_eq!(variant.materials[0].name, "a tower");

    let renumbered = |key: CellKey| CellKey { material: key.material + 1, ..key };
    let as_in_variant = |cell: &Cell| Cell {
        key: renumbered(cell.key),
        seen: cell.seen.iter().map(|(up, key)| (*up, key.map(renumbered))).collect(),
        ..cell.clone()
    };
    let [before, after] = [&base, &variant].map(|scene| cells(&site(scene, &receivers, &coarse()).path));
    for (before, after) in before.iter().zip(&after) {
        let (mut both, mut equal, mut turned_away) = (0, 0, 0);
        for (key, cell) in before {
            let Some(now) = after.get(&renumbered(*key)) else { continue };
            let same = *now == as_in_variant(cell);
            both += 1;
            equal += usize::from(same);
            let (axis, sign) = key.axis();
            if axis < 2 && sign < 0.0 {
                turned_away += 1;
                assert!(same, "{key:?}");
            }
            let sees_it = now.seen.iter().any(|(_, key)| key.is_some_and(|key| key.material == 0));
            let less_sky = now.bits != cell.bits && now.bits.iter().zip(&cell.bits).all(|(now, was)| now & !was == 0);
            assert!(same || sees_it || less_sky, "{key:?}");
        }
        eprintln!("{both} cells in both, {equal} equal, {turned_away} turned away");
        assert!(turned_away > 100 && equal * 2 > both, "{both} {equal} {turned_away}");
    }
}
