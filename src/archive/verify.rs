//! The full check of an archive. In: a path. Out: every part that is not as it was written, by name and with the reason.

use std::path::Path;

use rayon::prelude::*;

use super::codec::Block;
use super::format::{self, BOUNCE, Entry, FIRST_BLOCK, MATERIALS, PROBES, RECEIVERS, SLOT_OFFSETS, SLOT_SIZE};
use super::reader::{Archive, by_place};
use super::source::Access;
use super::tables::{Bounce, Materials, Probes, Receivers};
use crate::error::{Error, Result};

/// What the check found. The archive is good if `problems` is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Root hash, if header, directory and manifest are good.
    pub root: Option<[u8; 32]>,
    /// Blocks that were read, of all kinds.
    pub blocks: u64,
    /// Blocks among them of kinds that this release does not know: their content was compared, their meaning was not.
    pub unknown_blocks: u64,
    pub stored_bytes: u64,
    pub raw_bytes: u64,
    /// Bytes after the end of the archive; they are ignored.
    pub trailing_bytes: u64,
    pub problems: Vec<Problem>,
}

/// A part of an archive that is not as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Name of the block, such as `sky/3`, or of the part.
    pub part: String,
    /// Where it starts in the file.
    pub offset: u64,
    pub reason: String,
}

/// Checks every byte of an archive; goes on after a bad block. An error means that the check could not be made: no such file,
/// no archive, or a later format. Uses plain reads, so a file that changes meanwhile cannot end the process.
pub fn verify(path: &Path) -> Result<Report> {
    verify_with(path, Access::Read)
}

/// [`verify`] with another way of reading.
pub fn verify_with(path: &Path, access: Access) -> Result<Report> {
    let mut report = Report::default();
    let archive = match Archive::open_with(path, access) {
        Ok(archive) => archive,
        Err(Error::Corrupt { block, offset, got, expected, .. }) => {
            report.problems.push(Problem { part: block, offset, reason: found(&got, &expected) });
            return Ok(report);
        }
        Err(error) => return Err(error),
    };
    report.root = Some(archive.root());
    for (offset, name) in SLOT_OFFSETS.into_iter().zip(["slot A", "slot B"]) {
        if archive.header().damaged.contains(&name) {
            report.problems.push(Problem { part: name.to_string(), offset, reason: "wrong checksum".to_string() });
        }
    }
    let site = Site {
        materials: archive.entries_of(MATERIALS).iter().map(|entry| u64::from(entry.items)).sum(),
        cells: archive.entries_of(BOUNCE).iter().map(|entry| u64::from(entry.items)).sum(),
    };
    let results: Vec<Result<Option<Ends>>> =
        archive.entries().par_iter().map(|entry| check(&archive, entry, &site)).collect();
    let mut before: Option<(u32, Ends)> = None;
    for (entry, result) in archive.entries().iter().zip(results) {
        report.blocks = report.blocks.saturating_add(1);
        report.unknown_blocks =
            report.unknown_blocks.saturating_add(u64::from(format::schema_of(entry.kind).is_none()));
        report.stored_bytes = report.stored_bytes.saturating_add(u64::from(entry.stored));
        report.raw_bytes = report.raw_bytes.saturating_add(u64::from(entry.raw));
        let problem = |reason: String| Problem { part: entry.name(), offset: entry.offset, reason };
        match result {
            Ok(None) => {}
            Ok(Some(ends)) => {
                if before.is_some_and(|(kind, last)| kind == entry.kind && last.last >= ends.first) {
                    report.problems.push(problem("found keys that do not follow the chunk before".to_string()));
                }
                before = Some((entry.kind, ends));
            }
            Err(Error::Corrupt { got, expected, .. }) => report.problems.push(problem(found(&got, &expected))),
            Err(error) => report.problems.push(problem(error.to_string())),
        }
    }
    report.problems.extend(padding(&archive)?);
    report.trailing_bytes = archive.source().length().saturating_sub(archive.header().slot.committed);
    Ok(report)
}

/// What blocks must know of each other.
struct Site {
    materials: u64,
    cells: u64,
}

/// First and last key of a chunk.
#[derive(Clone, Copy)]
struct Ends {
    first: Option<(u32, u16, [i32; 3])>,
    last: Option<(u32, u16, [i32; 3])>,
}

/// Reads one block and asks everything that can be asked of it.
fn check(archive: &Archive, entry: &Entry, site: &Site) -> Result<Option<Ends>> {
    let block = match archive.fetch(entry) {
        // A later release may pack its own kinds in its own way; the checksum was right.
        Err(Error::Unsupported { .. }) if format::schema_of(entry.kind).is_none() => return Ok(None),
        block => block?,
    };
    block.check_content()?;
    match entry.kind {
        RECEIVERS => Receivers::from_block(&block).map(|_| None),
        MATERIALS if entry.tile > 0 => Err(block.corrupt(format!("tile {}", entry.tile), "tile 0 only")),
        MATERIALS => Materials::from_block(&block).map(|_| None),
        PROBES => {
            let table = Probes::from_block(&block)?;
            check_materials(&block, &table.material, site)?;
            check_hits(&block, table.highest_hit(), site)?;
            Ok(Some(Ends { first: table.keys().next(), last: table.keys().last() }))
        }
        BOUNCE => {
            let table = Bounce::from_block(&block)?;
            check_materials(&block, &table.material, site)?;
            check_hits(&block, table.highest_hit(), site)?;
            Ok(Some(Ends { first: table.keys().next(), last: table.keys().last() }))
        }
        kind if format::schema_of(kind).is_some() => block.require(kind).map(|()| None),
        _ => Ok(None),
    }
}

/// Hits of probes and of bounce cells alike are rows of the bounce table.
fn check_hits(block: &Block, highest: Option<u32>, site: &Site) -> Result<()> {
    match highest {
        Some(cell) if u64::from(cell) >= site.cells => {
            Err(block.corrupt(format!("a hit of cell {cell}"), format!("below {}", site.cells)))
        }
        _ => Ok(()),
    }
}

fn check_materials(block: &Block, material: &[u16], site: &Site) -> Result<()> {
    match material.iter().max() {
        Some(number) if u64::from(*number) >= site.materials => {
            Err(block.corrupt(format!("material {number}"), format!("below {}", site.materials)))
        }
        _ => Ok(()),
    }
}

/// Bytes between the parts that are not zero. Later generations leave old blocks there, so only the first one is asked.
fn padding(archive: &Archive) -> Result<Vec<Problem>> {
    let slot = &archive.header().slot;
    let mut problems = Vec::new();
    if slot.generation != 1 {
        return Ok(problems);
    }
    let slots = SLOT_OFFSETS.iter().map(|offset| (*offset, offset.saturating_add(SLOT_SIZE as u64)));
    let places = by_place(archive.entries());
    let blocks = places.iter().map(|entry| (entry.offset, entry.end().unwrap_or(u64::MAX)));
    let tables = [
        (slot.directory_offset, slot.directory_offset.saturating_add(slot.directory_length)),
        (slot.manifest_offset, slot.committed),
    ];
    let mut end = 0;
    for (start, next) in slots.chain(blocks).chain(tables) {
        while end < start {
            let length = start.saturating_sub(end).min(FIRST_BLOCK);
            let bytes = archive.source().read(end, length)?;
            if let Some(place) = bytes.iter().position(|byte| *byte != 0) {
                let offset = end.saturating_add(place as u64);
                problems.push(Problem { part: "padding".to_string(), offset, reason: "not zero".to_string() });
            }
            end = end.saturating_add(length);
        }
        end = end.max(next);
    }
    Ok(problems)
}

fn found(got: &str, expected: &str) -> String {
    format!("found {got}, expected {expected}")
}

#[cfg(test)]
mod tests {
    use super::super::{Writer, test_site};
    use super::*;

    /// The test site is good: 9 blocks, one of an unknown kind, no problem.
    #[test]
    fn a_good_archive_has_no_problems() {
        let site = test_site::written();
        let report = verify(&site.path).unwrap();
        assert_eq!((report.problems.clone(), report.root), (vec![], Some(site.summary.root)));
        assert_eq!((report.blocks, report.unknown_blocks, report.trailing_bytes), (9, 1, 0));
        assert_eq!(report.raw_bytes, test_site::blocks().iter().map(|(_, _, raw)| raw.len() as u64).sum::<u64>());
    }

    /// Damage of 2 blocks, a slot and a gap gives these 4 names, and all 9 blocks are checked.
    #[test]
    fn damage_is_named_and_does_not_stop_the_check() {
        let site = test_site::written();
        let archive = Archive::open(&site.path).unwrap();
        let place = |kind| archive.entries_of(kind)[0].offset as usize;
        let mut bytes = std::fs::read(&site.path).unwrap();
        for place in [place(format::SKY), place(77), 4100, 600] {
            bytes[place] ^= 1;
        }
        std::fs::write(&site.path, bytes).unwrap();
        let report = verify(&site.path).unwrap();
        let names: Vec<&str> = report.problems.iter().map(|problem| problem.part.as_str()).collect();
        assert_eq!(names, ["slot B", "sky/0", "kind-77/0", "padding"]);
        assert_eq!(report.blocks, 9);
    }

    /// Values that no single block can refuse are found: a material beyond the table, hits of a probe and of a cell beyond the
    /// cells, chunks out of order: 4 problems.
    #[test]
    fn blocks_are_checked_against_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        let mut writer = Writer::create(&path, &test_site::JOB).unwrap();
        let mut probes = test_site::probes();
        writer.append(probes.encode(0, 9).unwrap()).unwrap();
        writer.append(probes.encode(1, 9).unwrap()).unwrap();
        probes.voxel[0][0] += 9;
        probes.material[0] += 9;
        writer.append(probes.encode(2, 9).unwrap()).unwrap();
        probes.voxel[0][0] += 9;
        (probes.material[0], probes.hits[0]) = (0, 7);
        writer.append(probes.encode(3, 9).unwrap()).unwrap();
        let mut bounce = test_site::bounce();
        bounce.hits[0] = 7;
        writer.append(bounce.encode(0, 9).unwrap()).unwrap();
        writer.append(test_site::materials().encode(0, 9).unwrap()).unwrap();
        let mut manifest = test_site::manifest();
        (manifest.receivers.tiles, manifest.receivers.count) = (0, 0);
        manifest.layers = writer.layers();
        writer.finish(&manifest).unwrap();
        let report = verify(&path).unwrap();
        let names: Vec<&str> = report.problems.iter().map(|problem| problem.part.as_str()).collect();
        assert_eq!(names, ["probes/1", "probes/2", "probes/3", "bounce/0"], "{:?}", report.problems);
    }
}
