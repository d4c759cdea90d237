//! One writer publishes again and again while others read: every reader sees one complete
//! generation.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::writing::Writer;
use crate::writing::test_site;
use crate::writing::test_site::JOB;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::ReceiversTable;
use heliotile_core::archive::{Access, Archive, encode, format};
use heliotile_core::error::{Error, Result};

/// Returns bytes that identify their generation and tile; too many for one page, and not
/// compressible to one.
fn layer(generation: u64, tile: u32) -> Vec<u8> {
    let word = |i: u64| (generation << 20 | u64::from(tile)).wrapping_mul(2 * i + 1).to_le_bytes();
    let head = generation.to_le_bytes();
    head.into_iter().chain((0..2000).flat_map(word)).collect()
}

/// Publishes one generation: its number is in the receivers' ids, in both sky layers and in the
/// manifest.
fn publish(path: &Path, generation: u64) {
    let mut writer = Writer::create(path, &JOB).unwrap();
    for tile in 0..2 {
        let mut receivers = test_site::receivers(tile, 2 - tile as usize);
        receivers.ids.iter_mut().for_each(|id| *id = generation.to_string());
        writer.append(receivers.encode(format::RECEIVERS, TileNumber(tile), 1).unwrap()).unwrap();
        writer.append(encode(format::SKY, TileNumber(tile), 1, 1, &layer(generation, tile), 1).unwrap()).unwrap();
        writer.checkpoint().unwrap();
    }
    let mut manifest = test_site::manifest();
    manifest.counts.probes = generation;
    manifest.layers = writer.layers();
    writer.finish(&manifest).unwrap();
}

/// Reads everything, and returns the one generation that all parts belong to.
fn read(path: &Path, access: Access) -> Result<u64> {
    let archive = Archive::open_with(path, access)?;
    let generation = archive.manifest().counts.probes;
    for tile in 0..archive.tiles() {
        let receivers = ReceiversTable::from_block(&archive.block(format::RECEIVERS, TileNumber(tile))?)?;
        assert!(receivers.ids.iter().all(|id| *id == generation.to_string()), "{:?} in {generation}", receivers.ids);
        assert!(
            archive.block(format::SKY, TileNumber(tile))?.bytes() == layer(generation, tile),
            "sky/{tile} of {generation}"
        );
    }
    Ok(generation)
}

/// Eight readers, half of them through mappings, read for three seconds beside a writer that
/// publishes without pause. Over 1000 reads give 0 errors and 0 mixed generations, none is older
/// than one read before, and every reader sees the last one.
#[test]
fn readers_see_whole_generations() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.helio");
    publish(&path, 1);
    let (done, reads) = (AtomicBool::new(false), AtomicU64::new(0));
    let (published, seen) = std::thread::scope(|scope| {
        let follow = |access| {
            let (mut last, mut distinct) = (0, 0);
            // One more read after the end, so that the last generation is seen.
            loop {
                let ending = done.load(Ordering::Acquire);
                let generation = read(&path, access).unwrap();
                assert!(generation >= last, "{generation} after {last}");
                distinct += u64::from(generation > last);
                last = generation;
                reads.fetch_add(1, Ordering::Relaxed);
                if ending {
                    return (last, distinct);
                }
            }
        };
        let readers: Vec<_> =
            (0..8).map(|row| scope.spawn(move || follow([Access::Mapped, Access::Read][row % 2]))).collect();
        let end = Instant::now() + Duration::from_secs(3);
        let mut generation = 1;
        while Instant::now() < end {
            generation += 1;
            publish(&path, generation);
        }
        done.store(true, Ordering::Release);
        (generation, readers.into_iter().map(|reader| reader.join().unwrap()).collect::<Vec<_>>())
    });
    assert!(seen.iter().all(|(last, _)| *last == published), "{seen:?} of {published}");
    let distinct: u64 = seen.iter().map(|(_, distinct)| distinct).sum();
    assert!(reads.load(Ordering::Relaxed) > 1000 && distinct > 16, "{reads:?} reads, {distinct} changes seen");
}

/// An archive is shortened to each of 60 lengths under an open reader. Every block beyond the new
/// end is a typed error with plain reads, and every block before it is read unchanged.
#[test]
fn a_shortened_archive_is_a_typed_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.helio");
    let bytes = test_site::bytes().0;
    let (mut errors, mut good) = (0, 0);
    for step in 0..60 {
        std::fs::write(&path, &bytes).unwrap();
        let archive = Archive::open_with(&path, Access::Read).unwrap();
        let length = bytes.len() as u64 * step / 60;
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(length).unwrap();
        for (entry, block) in archive.entries().iter().map(|entry| (entry, archive.block(entry.kind, entry.tile))) {
            let inside = entry.end().unwrap() <= length;
            assert_eq!(block.is_ok(), inside, "{} of {length} bytes", entry.name());
            match block {
                Ok(_) => good += 1,
                Err(error) => {
                    assert!(matches!(error, Error::Io { action: "read", .. }), "{error}");
                    assert!(error.to_string().contains("site.helio"), "{error}");
                    errors += 1;
                }
            }
        }
    }
    assert!(errors > 400 && good > 20, "{errors} errors, {good} blocks");
}
