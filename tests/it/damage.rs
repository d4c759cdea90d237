//! Damage to a whole archive from a real build: an error that names the part, or the same answers;
//! never other answers.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format;
use heliotile_core::archive::format::{ENTRY_SIZE, Entry, FIRST_BLOCK, SLOT_OFFSETS, SLOT_SIZE, Slot};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::Error;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::sky::model::SkyModel;
use rayon::prelude::*;

use crate::scenes::{Site, canyon, receiver, scene, site, sun, tilted, v};

/// Builds two receivers in a short street, with the coarsest textures and cells: every byte of the
/// archive is one more to change.
fn small() -> Site {
    let settings = BuildSettings {
        sky_base: 8,
        sky_fine: 16,
        hit: 8,
        cell_floor_m: 32.0,
        probe: 8,
        probe_hits: 2,
        closed_m: 32.0,
        bounce_sky: 8,
        bounce_hits: 2,
        ..BuildSettings::default()
    };
    let receivers =
        [receiver("a", v(0.1, 0.2, 0.0), tilted(0.0, 0.0)), receiver("b", v(4.9, 3.0, 4.0), tilted(90.0, 90.0))];
    site(&scene(&canyon(10.0, 14.0, 20.0), &[0.5, 0.5]), &receivers, &settings)
}

/// Reads the root, the directory, the manifest and all blocks: all that answers can depend on.
fn content(archive: &Archive) -> Result<[u8; 32], Error> {
    let mut all = blake3::Hasher::new();
    all.update(&archive.root());
    all.update(format!("{:?} {:?}", archive.entries(), archive.manifest()).as_bytes());
    for entry in archive.entries() {
        all.update(archive.block(entry.kind, entry.tile)?.bytes());
    }
    Ok(*all.finalize().as_bytes())
}

/// Reads all blocks and replays in two ways; returns the results as bits.
fn ask(path: &Path) -> Result<Vec<u32>, Error> {
    let archive = Archive::open_with(path, Access::Read)?;
    content(&archive)?;
    answers(&archive)
}

fn answers(archive: &Archive) -> Result<Vec<u32>, Error> {
    let mut answers = Vec::new();
    for depth in [MaxBounces::All, MaxBounces::Count(2)] {
        let settings = ReplaySettings {
            sky: SkyModel::Uniform,
            patches: 145,
            paths: depth.into(),
            components: ComponentSet::ALL,
            memory: MemoryBudget::new(1 << 26),
            storage: &InMemory,
        };
        let replay = Replay::new(&OpenSite::open(archive)?, &[sun(90.0, 60.0, 800.0, 100.0)], settings)?;
        for (ids, values) in replay.run(0..replay.tiles())? {
            for row in 0..ids.len() {
                answers.extend(Component::ALL.map(|component| values.row(component, row)[0].to_bits()));
            }
        }
    }
    Ok(answers)
}

/// Reads many changed copies of a file: (errors, same answers). Panics on another answer, or on an
/// error that names no part. Of the copies whose content is that of the original, one in 17 is
/// replayed too; copies with any other content are.
fn ask_all(
    site: &Site,
    changes: &[(usize, u8)],
    change: impl Fn(&[u8], (usize, u8)) -> Vec<u8> + Sync,
) -> (usize, usize) {
    let original = fs::read(&site.path).expect("an archive");
    let expected = ask(&site.path).expect("answers");
    let whole = content(&Archive::open_with(&site.path, Access::Read).expect("an archive")).expect("blocks");
    let answered = |path: &Path, number: usize| {
        let archive = Archive::open_with(path, Access::Read)?;
        let is_same = content(&archive)? == whole && !number.is_multiple_of(17);
        if is_same { Ok(expected.clone()) } else { answers(&archive) }
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (errors, same) = (AtomicUsize::new(0), AtomicUsize::new(0));
    changes.par_iter().enumerate().for_each_init(
        || folder.path().join(format!("{:?}.helio", std::thread::current().id())),
        |path: &mut PathBuf, (number, &case)| {
            fs::write(&*path, change(&original, case)).expect("written");
            match answered(path, number) {
                Ok(answers) => {
                    assert!(answers == expected, "{case:?} changed the answers");
                    same.fetch_add(1, Ordering::Relaxed);
                }
                Err(Error::Corrupt { .. } | Error::Input { .. } | Error::Unsupported { .. }) => {
                    errors.fetch_add(1, Ordering::Relaxed);
                }
                Err(other) => panic!("{case:?}: {other}"),
            }
        },
    );
    (errors.into_inner(), same.into_inner())
}

/// Every single bit of the slots is flipped, and one bit of every other byte: there are 0 other
/// answers and 0 panics, and all flips outside slots and padding are errors. A copy that reads as
/// the original to the byte is replayed in one of 17 cases. `HELIOTILE_FLIPS=all` flips every bit
/// behind the header, which takes minutes.
#[test]
fn no_flipped_bit_is_silent() {
    let site = small();
    let length = fs::read(&site.path).expect("an archive").len();
    let of_block = if std::env::var_os("HELIOTILE_FLIPS").is_some() { 8 } else { 1 };
    let is_whole = |byte: usize| {
        byte >= FIRST_BLOCK as usize && of_block == 8
            || SLOT_OFFSETS.iter().any(|&slot| (slot as usize..slot as usize + SLOT_SIZE).contains(&byte))
    };
    let bits = |byte: usize| if is_whole(byte) { 0..8 } else { byte as u8 % 8..byte as u8 % 8 + 1 };
    let changes: Vec<(usize, u8)> = (0..length).flat_map(|byte| bits(byte).map(move |bit| (byte, bit))).collect();
    let (errors, same) = ask_all(&site, &changes, |original, (byte, bit)| {
        let mut bytes = original.to_vec();
        bytes[byte] ^= 1 << bit;
        bytes
    });
    println!("{length} bytes, {} flips: {errors} errors, {same} same answers", changes.len());
    assert_eq!(errors + same, changes.len());
    let padding: usize = 63 * of_block * 20;
    assert!(errors > (length - FIRST_BLOCK as usize) * of_block - padding, "{errors} errors");
}

/// The file cut at any length is an error.
#[test]
fn no_cut_is_silent() {
    let site = small();
    let length = fs::read(&site.path).expect("an archive").len();
    let cuts: Vec<(usize, u8)> = (0..length).map(|cut| (cut, 0)).collect();
    let (errors, same) = ask_all(&site, &cuts, |original, (cut, _)| original[..cut].to_vec());
    assert_eq!((errors, same), (length, 0));
}

/// Six files that promise too much under right checksums (2^60 entries, a directory and a manifest
/// beyond the file, a block of 4 GiB, a frame of 1 GiB, overlapping blocks) are refused.
/// `HELIOTILE_BOMBS=folder` keeps them for measuring time and memory.
#[test]
fn bombs_are_refused() {
    let site = small();
    let original = fs::read(&site.path).expect("an archive");
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = std::env::var_os("HELIOTILE_BOMBS").map_or(scratch.path().to_path_buf(), PathBuf::from);
    let slot = Slot::decode(&original).expect("a slot");
    let with_slot = |change: &dyn Fn(&mut Slot)| {
        let (mut bytes, mut slot) = (original.clone(), slot);
        change(&mut slot);
        SLOT_OFFSETS.iter().for_each(|&at| bytes[at as usize..][..SLOT_SIZE].copy_from_slice(&slot.encode()));
        bytes
    };
    let with_entry = |number: usize, change: &dyn Fn(&mut Entry, &mut Vec<u8>)| {
        let mut bytes = original.clone();
        let at = slot.directory_offset as usize + number * ENTRY_SIZE;
        let mut entry = Entry::decode(&original[at..]).expect("an entry");
        change(&mut entry, &mut bytes);
        let mut encoded = Vec::new();
        entry.encode(&mut encoded);
        bytes[at..at + ENTRY_SIZE].copy_from_slice(&encoded);
        let directory = &bytes[slot.directory_offset as usize..][..slot.directory_length as usize];
        let manifest = &bytes[slot.manifest_offset as usize..][..slot.manifest_length as usize];
        let sealed = Slot { root: format::root_hash(directory, manifest), ..slot };
        SLOT_OFFSETS.iter().for_each(|&at| bytes[at as usize..][..SLOT_SIZE].copy_from_slice(&sealed.encode()));
        bytes
    };
    let bombs = [
        ("count", with_slot(&|s| (s.directory_count, s.directory_length) = (1 << 60, 80 << 56))),
        ("directory", with_slot(&|s| (s.directory_count, s.directory_length) = (1 << 26, (1 << 26) * 80))),
        ("manifest", with_slot(&|s| s.manifest_length = 1 << 40)),
        ("raw", with_entry(0, &|e, _| e.raw = u32::MAX)),
        (
            "frame",
            with_entry(0, &|e, bytes| {
                // The header of a zstd frame that holds 2^30 bytes; the largest raw length that is
                // allowed.
                let head = [0x28, 0xb5, 0x2f, 0xfd, 0xa0, 0, 0, 0, 0x40];
                bytes[e.offset as usize..][..head.len()].copy_from_slice(&head);
                e.raw = format::MAX_RAW as u32;
                e.codec = format::CODEC_ZSTD;
                e.checksum = format::checksum(&bytes[e.offset as usize..][..e.stored as usize]);
            }),
        ),
        ("overlap", with_entry(1, &|e, _| e.offset -= 64)),
    ];
    for (name, bytes) in bombs {
        let path = folder.join(format!("{name}.helio"));
        fs::write(&path, bytes).expect("written");
        let error = ask(&path).expect_err(name).to_string();
        assert!(error.contains(".helio: "), "{name}: {error}");
    }
}
