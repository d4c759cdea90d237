//! Verification of written archives: [`heliotile_core::archive::verify`].

use crate::writing::{Writer, test_site};
use heliotile_core::archive::format::{self, BOUNCE, BlockKind, CellKind, INDEX, MATERIALS, PROBES, TileNumber};
use heliotile_core::archive::tables::{CellsTable, IndexTable};
use heliotile_core::archive::{Access, Archive, verify};
use heliotile_core::layers::cells as layers;
use heliotile_core::site::cells::CellKey;

/// The test site is good: 11 blocks, one of an unknown kind, no problem.
#[test]
fn a_good_archive_has_no_problems() {
    let site = test_site::written();
    let report = verify(&site.path, Access::Read, false).unwrap();
    assert_eq!((report.problems.clone(), report.root), (vec![], Some(site.summary.root)));
    assert_eq!((report.blocks, report.unknown_blocks, report.trailing_bytes), (11, 1, 0));
    assert_eq!(report.raw_bytes, test_site::blocks().iter().map(|(_, _, raw)| raw.len() as u64).sum::<u64>());
}

/// Damage to 2 blocks, a slot and a gap gives these 4 names, and all 11 blocks are checked.
#[test]
fn damage_is_named_and_does_not_stop_the_check() {
    let site = test_site::written();
    let archive = Archive::open(&site.path).unwrap();
    let place = |kind| archive.entries_of(kind)[0].offset as usize;
    let mut bytes = std::fs::read(&site.path).unwrap();
    for place in [place(format::SKY), place(BlockKind(77)), 4100, 600] {
        bytes[place] ^= 1;
    }
    std::fs::write(&site.path, bytes).unwrap();
    let report = verify(&site.path, Access::Read, false).unwrap();
    let names: Vec<&str> = report.problems.iter().map(|problem| problem.part.as_str()).collect();
    assert_eq!(names, ["slot B", "sky/0", "kind-77/0", "padding"]);
    assert_eq!(report.blocks, 11);
}

/// Values that no single block can refuse are found: a material beyond the table, a chunk that the
/// index does not list, and, in a deep check, a probe and a cell that see a missing cell: 2 and 4
/// problems.
#[test]
fn blocks_are_checked_against_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.helio");
    let mut writer = Writer::create(&path, &test_site::JOB).unwrap();
    let good = test_site::cells(-1, 40);
    let key = |x: i32, material| CellKey { material, voxel: [x, 0, 0], ..good.keys[0] };
    let chunk = |number: u32, x: i32, material, seen: i32| {
        let seen = vec![CellKey { level: 2, facing: 58, material: 0, voxel: [seen, 0, 0] }];
        let cells = layers::Cells { keys: vec![key(x, material)], seen, ..good.clone() };
        CellsTable::new(&cells).encode(PROBES, TileNumber(number), 9).unwrap()
    };
    for block in [chunk(0, 10, 0, 1), chunk(1, 12, 0, 7), chunk(2, 13, 9, 1), chunk(3, 10, 0, 1)] {
        writer.append(block).unwrap();
    }
    let firsts = [key(10, 0), key(12, 0), key(13, 9)];
    writer.append(IndexTable::new(&firsts).encode(INDEX, CellKind::Probes.index(), 9).unwrap()).unwrap();
    let bounce = layers::Cells {
        keys: vec![CellKey { level: 2, facing: 58, material: 0, voxel: [1, 0, 0] }],
        seen: vec![CellKey { level: 3, facing: 58, material: 0, voxel: [1, 0, 0] }],
        ..good.clone()
    };
    writer.append(CellsTable::new(&bounce).encode(BOUNCE, TileNumber::FIRST, 9).unwrap()).unwrap();
    writer.append(IndexTable::new(&bounce.keys).encode(INDEX, CellKind::Bounces.index(), 9).unwrap()).unwrap();
    writer.append(test_site::materials().encode(MATERIALS, TileNumber::FIRST, 9).unwrap()).unwrap();
    let mut manifest = test_site::manifest();
    (manifest.receivers.tiles, manifest.receivers.count) = (0, 0);
    manifest.layers = writer.layers();
    writer.finish(&manifest).unwrap();
    for (deep, expected) in
        [(false, vec!["probes/2", "probes/3"]), (true, vec!["probes/1", "probes/2", "probes/3", "bounce/0"])]
    {
        let report = verify(&path, Access::Read, deep).unwrap();
        let names: Vec<&str> = report.problems.iter().map(|problem| problem.part.as_str()).collect();
        assert_eq!(names, expected, "{:?}", report.problems);
    }
}
