//! Receivers are found by name or place without reading the others.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use heliotile_archives::transfer::{ArchiveReceivers, Bounds, Selection};
use heliotile_archives::writing::{Job, Writer};
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format::{BlockKind, TileNumber};
use heliotile_core::archive::tables::{ExtentsTable, NamesTable};
use heliotile_core::archive::{Access, Archive, Block, Blocks, EncodedBlock, format, verify};
use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::receiver::Receiver;

use crate::scenes::*;

/// Builds 600 receivers along a street, 10 tiles: every 30 of them are a house, of whose four
/// surfaces one has no name, and every two houses are a block.
fn street(path: &Path) -> Vec<Receiver> {
    let named = |i: usize| Receiver {
        surface: (!i.is_multiple_of(4)).then(|| format!("house {}/surface {}", i / 30, i % 4)),
        part: ModelPart {
            object: format!("house {}", i / 30),
            building: format!("block {}", i / 60),
            ..ModelPart::default()
        },
        ..receiver(&format!("{}-{i}", 7 * i % 600), v(0.5 * i as f64 - 150.0, 3.0, 1.0), tilted(90.0, 180.0))
    };
    let receivers: Vec<Receiver> = (0..600).map(named).collect();
    let scene = scene(&ground(400.0, 0.0, 0), &[0.2]);
    build(&scene, &mut tiles(&receivers, &scene), &plan(&BuildSettings::default(), path)).expect("a build");
    receivers
}

/// An archive whose reads of tables of receivers are counted.
struct Counted<'a> {
    archive: &'a Archive,
    read: AtomicUsize,
}

impl Blocks for Counted<'_> {
    fn path(&self) -> &Path {
        self.archive.path()
    }

    fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        self.archive.has(kind, tile)
    }

    fn rows(&self, kind: BlockKind, tile: TileNumber) -> Option<u32> {
        Blocks::rows(self.archive, kind, tile)
    }

    fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        self.read.fetch_add(usize::from(kind == format::RECEIVERS), Ordering::Relaxed);
        self.archive.block(kind, tile)
    }
}

/// Returns the receivers of a selection, by their ids in order, and the number of tables of
/// receivers that were read.
fn chosen(archive: &Archive, selection: &Selection) -> (Result<Vec<String>>, usize) {
    let counted = Counted { archive, read: AtomicUsize::new(0) };
    let site = OpenSite::new(&counted, archive.manifest()).expect("a site");
    let folder = archive.path().parent().expect("a folder");
    let kept = selection.resolve(&[site], folder, 1 << 20);
    let read = counted.read.load(Ordering::Relaxed);
    let of = OpenSite::open(archive).expect("a site");
    let ids = |kept: Vec<bool>| {
        let rows = ArchiveReceivers::<()>::new(&of).zip(kept).filter(|(_, kept)| *kept);
        rows.map(|(row, _)| row.expect("a receiver").receiver.id).collect()
    };
    (kept.map(ids), read)
}

/// A house, a block of two, a surface, a list, and a box select the receivers that a plain search
/// of all of them finds, 30, 60, 8, 3 and 20, and only those of 10 tables are read that hold some.
/// Unknown names and an empty box are 4 errors, and no table is read.
#[test]
fn some_receivers_are_found_by_reading_their_tiles_only() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("street.helio");
    let receivers = street(&path);
    let archive = Archive::open(&path).expect("an archive");
    assert_eq!(archive.tiles(), 10);
    let list = folder.path().join("list.csv");
    std::fs::write(&list, "receiver\n0-0\n7-1\n593-599\n").expect("written");
    let text = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let within = |x0: f64, x1: f64| Selection::Bounds(Bounds { low: v(x0, 2.0, 0.0), high: v(x1, 4.0, 2.0) });
    let tile_of = |id: &str| {
        let tile = |tile: &u32| {
            let block = archive.block(format::RECEIVERS, TileNumber(*tile)).expect("a table");
            let table = heliotile_core::archive::tables::ReceiversTable::from_block(&block).expect("receivers");
            table.ids.iter().any(|held| held == id)
        };
        (0..10).find(tile).expect("a tile")
    };
    type Meant<'a> = &'a dyn Fn(usize, &Receiver) -> bool;
    let cases: [(Selection, Meant, usize); 5] = [
        (Selection::Objects(text(&["house 7"])), &|i, _| i / 30 == 7, 30),
        (Selection::Objects(text(&["block 4"])), &|i, _| i / 60 == 4, 60),
        (Selection::Surfaces(text(&["house 19/surface 2"])), &|i, _| i / 30 == 19 && i % 4 == 2, 8),
        (Selection::Receivers(list), &|i, _| [0, 1, 599].contains(&i), 3),
        (within(0.0, 9.9), &|_, r| (0.0..=9.9).contains(&r.position.x), 20),
    ];
    for (selection, meant, count) in cases {
        let expected: Vec<&Receiver> =
            receivers.iter().enumerate().filter(|(i, r)| meant(*i, r)).map(|(_, r)| r).collect();
        let mut tiles: Vec<u32> = expected.iter().map(|receiver| tile_of(&receiver.id)).collect();
        tiles.sort_unstable();
        tiles.dedup();
        let (found, read) = chosen(&archive, &selection);
        let mut ids = found.expect("receivers");
        assert_eq!(read, tiles.len(), "{selection:?}");
        ids.sort_unstable();
        let mut expected: Vec<String> = expected.into_iter().map(|receiver| receiver.id.clone()).collect();
        expected.sort_unstable();
        assert_eq!((ids.len(), ids), (count, expected), "{selection:?}");
    }
    for (nobody, part) in [
        (Selection::Objects(text(&["house 20"])), "1 object: house 20"),
        (Selection::Surfaces(text(&["house 7"])), "1 surface: house 7"),
        (Selection::Ids(text(&["1-0"])), "1 receiver: 1-0"),
        (within(900.0, 901.0), "the selection holds none of the receivers"),
    ] {
        let (found, read) = chosen(&archive, &nobody);
        let said = found.expect_err("nobody").to_string();
        assert!(said.contains(part) && read == 0, "{said}: {read} tables");
    }
}

/// Writes an archive again, with some blocks changed.
fn again(archive: &Archive, path: &Path, change: &dyn Fn(&Block) -> Option<EncodedBlock>) {
    let job = Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] };
    let mut writer = Writer::create(path, &job).expect("a writer");
    for entry in archive.entries() {
        let changed = change(&archive.block(entry.kind, entry.tile).expect("a block"));
        writer.append(changed.unwrap_or_else(|| archive.copy(entry).expect("a block"))).expect("written");
    }
    let mut manifest = archive.manifest().clone();
    manifest.layers = writer.layers();
    writer.finish(&manifest).expect("an archive");
}

/// Names and boxes that are well-formed but not those of the receivers are found by a deep check,
/// each by name: a name in another tile, a name too few, chunk 0 with another first name, another
/// box. Boxes of too few tiles are found by any check.
#[test]
fn wrong_names_and_boxes_of_receivers_are_found() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let [path, bad] = ["street.helio", "bad.helio"].map(|name| folder.path().join(name));
    street(&path);
    let archive = Archive::open(&path).expect("an archive");
    assert!(verify(&path, Access::Read, true).expect("checked").problems.is_empty());
    let names = |block: &Block, tile: u32, change: &dyn Fn(&mut NamesTable)| {
        (block.entry().key() == (format::NAMES, TileNumber(tile))).then(|| {
            let mut table = NamesTable::from_block(block).expect("names");
            change(&mut table);
            table.encode(format::NAMES, TileNumber(tile), 3).expect("a block")
        })
    };
    let boxes = |block: &Block, change: &dyn Fn(&mut ExtentsTable)| {
        (block.entry().key() == (format::EXTENTS, TileNumber::FIRST)).then(|| {
            let mut table = ExtentsTable::from_block(block).expect("boxes");
            change(&mut table);
            table.encode(format::EXTENTS, TileNumber::FIRST, 3).expect("a block")
        })
    };
    let fewer = |table: &mut NamesTable| *table = NamesTable::new(&table.names()[1..]);
    type Change<'a> = &'a dyn Fn(&Block) -> Option<EncodedBlock>;
    let cases: [(Change, &str, bool); 5] = [
        (&|block| names(block, 1, &|table| table.tile[5] = (table.tile[5] + 1) % 10), "names/0", true),
        (&|block| names(block, 1, &fewer), "names/0", true),
        (&|block| names(block, 0, &|table| table.text[0] = b'/'), "names/0", true),
        (&|block| boxes(block, &|table| table.high[3][1] += 0.5), "extents/0", true),
        (
            &|block| {
                boxes(block, &|table| {
                    table.low.pop();
                    table.high.pop();
                })
            },
            "extents/0",
            false,
        ),
    ];
    for (number, (change, part, only_deep)) in cases.into_iter().enumerate() {
        again(&archive, &bad, change);
        let parts = |deep| -> Vec<String> {
            let found = verify(&bad, Access::Read, deep).expect("checked");
            found.problems.into_iter().map(|problem| problem.part).collect()
        };
        assert_eq!(parts(true), [part], "{number}");
        assert_eq!(parts(false).is_empty(), only_deep, "{number}");
    }
}
