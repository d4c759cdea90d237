//! Reading of written archives: [`heliotile_core::archive::reader`].

use heliotile_core::archive::format::{self, BlockKind, Entry, TileNumber};
use heliotile_core::archive::reader::check_entries;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::Error;

use crate::writing::test_site;

/// Every block of the test site is read as it was written, by both ways of access: 3 receivers in 2
/// tiles.
#[test]
fn what_was_written_is_read() {
    let site = test_site::written();
    for access in [Access::Mapped, Access::Read] {
        let archive = Archive::open_with(&site.path, access).unwrap();
        assert_eq!((archive.tiles(), archive.manifest()), (2, &test_site::manifest()));
        for (kind, tile, raw) in test_site::blocks() {
            assert_eq!(archive.block(kind, tile).unwrap().bytes(), raw, "{}", format::block_name(kind, tile));
        }
        assert_eq!(archive.entries().len(), test_site::blocks().len());
        assert_eq!(archive.scan(format::RECEIVERS).map(|block| block.unwrap().items()).sum::<u32>(), 3);
        assert_eq!(archive.root(), site.summary.root);
    }
}

/// A block of kind 77 does not stop reading. The error for a missing block names it.
#[test]
fn unknown_kinds_are_skipped() {
    let site = test_site::written();
    let archive = Archive::open(&site.path).unwrap();
    assert_eq!(archive.entries_of(BlockKind(77)).len(), 1);
    assert_eq!(archive.scan(format::SKY).count(), 2);
    assert!(archive.has(format::SKY, TileNumber(1)) && !archive.has(format::SKY, TileNumber(2)));
    let error = archive.block(format::SKY, TileNumber(2)).unwrap_err().to_string();
    assert!(error.contains("holds no block sky/2"), "{error}");
}

/// Directories that are unsorted, overlap, leave the file or state wrong lengths are refused: 8 of
/// 8, with right hashes.
#[test]
fn lying_directories_are_refused() {
    let site = test_site::written();
    let good = Archive::open(&site.path).unwrap();
    let slot = good.header().slot;
    type Lie = fn(&mut Vec<Entry>);
    let lies: [(&str, Lie); 8] = [
        ("swapped", |e| e.swap(0, 1)),
        ("twice", |e| e[1] = e[0]),
        ("overlap", |e| e[1].offset = e[0].offset),
        ("header", |e| e[0].offset = 4096),
        ("beyond", |e| e[0].offset = u64::MAX - 63),
        ("unaligned", |e| e[0].offset += 1),
        ("bomb", |e| e[0].raw = u32::MAX),
        ("empty", |e| e[0].stored = 0),
    ];
    check_entries(&site.path, good.entries(), &slot).unwrap();
    for (name, lie) in lies {
        let mut entries = good.entries().to_vec();
        lie(&mut entries);
        assert!(matches!(check_entries(&site.path, &entries, &slot), Err(Error::Corrupt { .. })), "{name}");
    }
}
