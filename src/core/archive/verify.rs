//! The full check of an archive. In: a path, or bytes from any source. Out: every part that is not
//! as it was written, by name and with the reason.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use crate::archive::codec::block::Block;
use crate::archive::format;
use crate::archive::format::{
    BANDS, BOUNCE, BOUNCE_CANOPY, BOUNCE_MIRROR, BlockKind, CANOPY, CellKind, EXTENTS, Entry, FIRST_BLOCK, HIT, INDEX,
    MATERIALS, MIRROR, MIRRORS, NAMES, OBJECTS, OPTICS, OVERVIEW, PARTS, PROBE_CANOPY, PROBE_MIRROR, PROBES, RECEIVERS,
    RESPONSE, SCENE, SKY, SLOT_OFFSETS, SLOT_SIZE, TileNumber,
};
use crate::archive::read_at::ReadAt;
use crate::archive::reader::{Archive, by_place};
#[cfg(any(unix, windows))]
use crate::archive::source::Access;
use crate::archive::source::Source;
use crate::archive::tables::{
    BandsTable, CellsTable, ExtentsTable, GeometryTable, IndexTable, MaterialsTable, MirrorsTable, NameOf, NameRow,
    NamesTable, ObjectsTable, OpticsTable, OverviewTable, PartsTable, ReceiversTable, TILES_A_CHUNK,
};
use crate::error::{Error, Result};
use crate::layers::canopy;
use crate::layers::canopy::{Canopy, RayLists};
use crate::layers::extras;
use crate::layers::hit::HitTile;
use crate::layers::mirror::{CellMirrors, ReceiverMirrors};
use crate::layers::response;
use crate::layers::sky::SkyTexture;
use crate::site::cells::CellKey;
use crate::site::chain::{Chain, MirrorStep};

/// Result of the check. The archive is good if `problems` is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct VerifyReport {
    /// Root hash, if header, directory and manifest are good.
    pub root: Option<[u8; 32]>,
    /// Number of blocks that were read, of all kinds.
    pub blocks: u64,
    /// Number of blocks among them of kinds that this release does not know. Their content hash was
    /// checked, their meaning was not.
    pub unknown_blocks: u64,
    /// Length of all blocks in the file, bytes.
    pub stored_bytes: u64,
    /// Length of all blocks after decoding, as their entries state it, bytes.
    pub raw_bytes: u64,
    /// Number of bytes after the end of the archive; they are ignored.
    pub trailing_bytes: u64,
    /// All parts that are wrong.
    pub problems: Vec<Problem>,
}

/// A part of an archive that is not as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Name of the block, such as `sky/3`, or of the part.
    pub part: String,
    /// Offset of the part in the file.
    pub offset: u64,
    /// Description of what is wrong with the part.
    pub reason: String,
}

/// Checks every byte of an archive in a file; see [`verify_bytes`]. With plain reads, a file that
/// changes meanwhile cannot end the process.
#[cfg(any(unix, windows))]
pub fn verify(path: &Path, access: Access, deep: bool) -> Result<VerifyReport> {
    verify_source(Source::open(path, access)?, deep)
}

/// Checks every byte of an archive from any source, and goes on after a bad block. An error means
/// that the check was not possible: the bytes are no archive, have another format or cannot be
/// read. `deep` also decodes every layer and follows every reference. For this it holds the keys of
/// all cells in memory, 20 bytes each.
pub fn verify_bytes(name: impl AsRef<Path>, bytes: impl ReadAt + 'static, deep: bool) -> Result<VerifyReport> {
    verify_source(Source::new(name.as_ref(), Box::new(bytes)), deep)
}

fn verify_source(source: Source, deep: bool) -> Result<VerifyReport> {
    let mut report = VerifyReport::default();
    let archive = match Archive::read(source) {
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
    archive.source().expect(archive.entries());
    let site = Site::new(&archive, deep);
    let results: Vec<Result<()>> = archive.entries().par_iter().map(|entry| check(&archive, entry, &site)).collect();
    for (entry, result) in archive.entries().iter().zip(results) {
        report.blocks = report.blocks.saturating_add(1);
        report.unknown_blocks =
            report.unknown_blocks.saturating_add(u64::from(format::schema_of(entry.kind).is_none()));
        report.stored_bytes = report.stored_bytes.saturating_add(u64::from(entry.stored));
        report.raw_bytes = report.raw_bytes.saturating_add(u64::from(entry.raw));
        let problem = |reason: String| Problem { part: entry.name(), offset: entry.offset, reason };
        match result {
            Ok(()) => {}
            Err(Error::Corrupt { got, expected, .. }) => report.problems.push(problem(found(&got, &expected))),
            Err(error) => report.problems.push(problem(error.to_string())),
        }
    }
    report.problems.extend(padding(&archive)?);
    report.trailing_bytes = archive.source().length().saturating_sub(archive.header().slot.committed);
    Ok(report)
}

/// Facts by which blocks are checked against each other.
struct Site {
    materials: u64,
    /// `[material]`: above 0 for canopies.
    canopies: Vec<u8>,
    /// Number of orientations of mirrors.
    orientations: u64,
    /// First keys of the chunks of probes, by the index; empty if the index cannot be read.
    probes: Vec<CellKey>,
    /// First keys of the chunks of bounce cells, by the index; empty if the index cannot be read.
    bounces: Vec<CellKey>,
    /// Keys of all cells, for a deep check.
    keys: Option<Keys>,
}

/// Sorted keys of all cells whose chunks are good.
struct Keys {
    probes: Vec<CellKey>,
    bounces: Vec<CellKey>,
}

impl Site {
    fn new(archive: &Archive, deep: bool) -> Self {
        let index = |cells: CellKind| {
            let table = archive.block(INDEX, cells.index()).and_then(|block| IndexTable::from_block(&block));
            table.map(|index| index.firsts()).unwrap_or_default()
        };
        let keys_of = |kind| {
            let chunk =
                |entry: &Entry| CellsTable::from_block(&archive.fetch(entry)?).map(|cells| cells.into_cells().keys);
            let mut keys: Vec<CellKey> =
                archive.entries_of(kind).par_iter().flat_map_iter(|entry| chunk(entry).unwrap_or_default()).collect();
            keys.par_sort_unstable();
            keys
        };
        let optics = archive.block(OPTICS, TileNumber::FIRST).and_then(|block| OpticsTable::from_block(&block));
        let items = |kind| archive.entries_of(kind).iter().map(|entry| u64::from(entry.items)).sum();
        Site {
            canopies: optics.map(|optics| optics.canopy).unwrap_or_default(),
            materials: items(MATERIALS),
            orientations: items(MIRRORS),
            probes: index(CellKind::Probes),
            bounces: index(CellKind::Bounces),
            keys: deep.then(|| Keys { probes: keys_of(PROBES), bounces: keys_of(BOUNCE) }),
        }
    }
}

/// Reads one block and makes all checks of its kind.
fn check(archive: &Archive, entry: &Entry, site: &Site) -> Result<()> {
    let block = match archive.fetch(entry) {
        // A later release may pack its own kinds in its own way; the checksum was right.
        Err(Error::Unsupported { .. }) if format::schema_of(entry.kind).is_none() => return Ok(()),
        block => block?,
    };
    block.check_content()?;
    let settings = &archive.manifest().settings;
    let rows = block.items() as usize;
    let shape = |good: bool| {
        if good { Ok(()) } else { Err(block.corrupt("a malformed layer", "a layer that matches the manifest")) }
    };
    let cell = |side: u32, seen: u32| RayLists::of_cell((side as usize).saturating_pow(2), seen as usize);
    match entry.kind {
        RECEIVERS => ReceiversTable::from_block(&block).map(|_| ()),
        PARTS => {
            same_rows(archive, &block, RECEIVERS)?;
            PartsTable::from_block(&block).map(|_| ())
        }
        MATERIALS if entry.tile != TileNumber::FIRST => {
            Err(block.corrupt(format!("tile {}", entry.tile), "tile 0 only"))
        }
        MATERIALS => MaterialsTable::from_block(&block).map(|_| ()),
        OPTICS => {
            let optics = OpticsTable::from_block(&block)?;
            if optics.rows() as u64 == site.materials { Ok(()) } else { shape(false) }
        }
        BANDS => check_materials(&block, BandsTable::from_block(&block)?.material.into_iter(), site),
        MIRRORS => check_materials(&block, MirrorsTable::from_block(&block)?.material.into_iter(), site),
        SCENE => check_materials(&block, GeometryTable::from_block(&block)?.material.into_iter(), site),
        OBJECTS => {
            same_rows(archive, &block, SCENE)?;
            ObjectsTable::from_block(&block).map(|_| ())
        }
        OVERVIEW => {
            same_rows(archive, &block, RECEIVERS)?;
            OverviewTable::from_block(&block).map(|_| ())
        }
        EXTENTS => check_extents(archive, &block, site.keys.is_some()),
        NAMES if entry.tile == TileNumber::FIRST && site.keys.is_some() => check_names(archive, &block),
        NAMES => NamesTable::from_block(&block).map(|_| ()),
        INDEX => IndexTable::from_block(&block).map(|_| ()),
        PROBES => check_cells(&block, &site.probes, site),
        BOUNCE => check_cells(&block, &site.bounces, site),
        SKY if site.keys.is_some() => {
            let (base, fine) = (settings.sky_base as usize, settings.sky_fine as usize);
            shape(fine <= MAX_FINE && SkyTexture::unpack(block.bytes(), rows, base, fine).is_some())
        }
        RESPONSE if site.keys.is_some() => {
            shape(response::unpack(block.bytes(), rows, settings.probe as usize).is_some())
        }
        MIRROR | PROBE_MIRROR | BOUNCE_MIRROR => check_mirrors(archive, &block, site),
        HIT => match &site.keys {
            Some(keys) => {
                let texels = (settings.hit as usize).saturating_pow(2).saturating_mul(rows);
                let Some(hits) = HitTile::unpack(block.bytes(), texels) else { return shape(false) };
                check_references(&block, &hits.palette, &keys.probes)
            }
            None => block.require(&[HIT]),
        },
        CANOPY if site.keys.is_some() => {
            let sky = canopy::sky_side(settings.sky_base as usize, settings.sky_fine as usize);
            check_canopies(
                archive,
                &block,
                RECEIVERS,
                RayLists::of_receiver(sky, (settings.hit as usize).saturating_pow(2)),
                site,
            )
        }
        PROBE_CANOPY if site.keys.is_some() => {
            check_canopies(archive, &block, PROBES, cell(settings.probe, settings.probe_hits), site)
        }
        BOUNCE_CANOPY if site.keys.is_some() => {
            check_canopies(archive, &block, BOUNCE, cell(settings.bounce_sky, settings.bounce_hits), site)
        }
        kind if format::schema_of(kind).is_some() => block.require(&[kind]),
        _ => Ok(()),
    }
}

/// Checks the boxes of tiles: their number and, in a deep check, that they are those of the
/// receivers.
fn check_extents(archive: &Archive, block: &Block, deep: bool) -> Result<()> {
    let table = ExtentsTable::from_block(block)?;
    let first = (block.entry().tile.0 as usize).saturating_mul(TILES_A_CHUNK);
    let expected = (archive.tiles() as usize).saturating_sub(first).min(TILES_A_CHUNK);
    if table.rows() != expected {
        return Err(block.corrupt(format!("{} tiles", table.rows()), format!("{expected}")));
    }
    let held = archive.entries_of(RECEIVERS).iter().skip(first);
    for (entry, stated) in held.zip(table.boxes()).filter(|_| deep) {
        // Receivers that cannot be read are a problem of their own block.
        let Ok(receivers) = archive.fetch(entry).and_then(|block| ReceiversTable::from_block(&block)) else { continue };
        if ExtentsTable::around(receivers.position.iter().map(|&p| p.into())) != Some(stated) {
            return Err(block.corrupt(
                format!("a box of tile {} that its receivers do not have", entry.tile),
                "the box around its receivers",
            ));
        }
    }
    Ok(())
}

/// Checks all chunks of names by the chunk of first names: they ascend from chunk to chunk, begin
/// as it states, and are the names of the receivers.
fn check_names(archive: &Archive, block: &Block) -> Result<()> {
    let firsts = NamesTable::from_block(block)?.names();
    let chunks = archive.entries_of(NAMES).get(1..).unwrap_or_default();
    let (mut stated, mut last): (NameDigest, Option<NameRow>) = Default::default();
    if chunks.len() != firsts.len() {
        return Err(block.corrupt(format!("first names of {} chunks", firsts.len()), format!("{}", chunks.len())));
    }
    for (first, entry) in firsts.iter().zip(chunks) {
        // A chunk that cannot be read is a problem of its own block.
        let Ok(rows) = archive.fetch(entry).and_then(|block| Ok(NamesTable::from_block(&block)?.names())) else {
            return Ok(());
        };
        let begins = rows.first().is_some_and(|row| (row.of, &row.name) == (first.of, &first.name));
        if TileNumber(first.tile) != entry.tile || !begins || last.as_ref() >= rows.first() {
            return Err(block.corrupt(
                format!("chunk {} with names that do not match the list of first names", entry.tile),
                "names in order",
            ));
        }
        rows.iter().for_each(|row| stated.add(row.of, &row.name, row.tile));
        last = rows.into_iter().next_back();
    }
    let mut held = NameDigest::default();
    for tile in 0..archive.tiles() {
        let Ok(receivers) = PartsTable::receivers(archive, tile) else { return Ok(()) };
        let names: BTreeSet<(NameOf, &str)> = receivers.iter().flat_map(NameOf::names).collect();
        names.iter().filter(|(_, name)| !name.is_empty()).for_each(|(of, name)| held.add(*of, name, tile));
    }
    if held == stated {
        Ok(())
    } else {
        Err(block.corrupt("names that differ from those of the receivers", "the names of the receivers"))
    }
}

/// Digest by which two sets of names are compared, in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct NameDigest {
    count: u64,
    sum: u64,
}

impl NameDigest {
    fn add(&mut self, of: NameOf, name: &str, tile: u32) {
        let row = [&[of as u8], &tile.to_le_bytes()[..], name.as_bytes()].concat();
        self.count = self.count.saturating_add(1);
        self.sum = self.sum.wrapping_add(u64::from_le_bytes(format::checksum(&row)));
    }
}

/// Checks that a block has as many rows as the block of kind `of` with its number.
fn same_rows(archive: &Archive, block: &Block, of: BlockKind) -> Result<()> {
    let (tile, rows) = (block.entry().tile, block.items());
    let of_kind = archive.entries_of(of).iter().find(|entry| entry.tile == tile).map(|entry| entry.items);
    if of_kind == Some(rows) {
        return Ok(());
    }
    Err(block.corrupt(format!("{rows} rows"), format!("as many as {}", format::block_name(of, tile))))
}

/// Checks the crossings of the rows of a block of another kind.
fn check_canopies(archive: &Archive, block: &Block, of: BlockKind, rays: RayLists, site: &Site) -> Result<()> {
    let rows = block.items();
    same_rows(archive, block, of)?;
    let is_canopy = |material: u16| site.canopies.get(usize::from(material)).is_some_and(|kind| *kind > 0);
    let good = |row: &Vec<u8>| Canopy::from_bytes(row, rays, is_canopy).is_some();
    match extras::unpack(block.bytes(), rows as usize) {
        Some(found) if found.iter().all(good) => Ok(()),
        _ => Err(block.corrupt(
            "malformed crossings of canopies",
            "crossings of canopies that match the textures and rays of the settings",
        )),
    }
}

/// Checks one chunk of cells: its materials exist, it is in its place among the chunks, and in a
/// deep check the cells that it sees exist.
fn check_cells(block: &Block, firsts: &[CellKey], site: &Site) -> Result<()> {
    let cells = CellsTable::from_block(block)?.into_cells();
    check_materials(block, cells.keys.iter().chain(&cells.seen).map(|key| key.material), site)?;
    let chunk = block.entry().tile.0 as usize;
    if cells.keys.first() != firsts.get(chunk) {
        return Err(block.corrupt("a first cell that differs from the index", "the first cell that the index states"));
    }
    if cells.keys.last().zip(firsts.get(chunk.saturating_add(1))).is_some_and(|(last, next)| last >= next) {
        return Err(block.corrupt("keys beyond the first key of the next chunk", "keys that rise from chunk to chunk"));
    }
    match &site.keys {
        Some(keys) => check_references(block, &cells.seen, &keys.bounces),
        None => Ok(()),
    }
}

/// Checks the mirror layer of receivers or cells: it has as many rows as they do. A deep check also
/// reads its windows, and checks that its mirrors, materials and cells exist.
fn check_mirrors(archive: &Archive, block: &Block, site: &Site) -> Result<()> {
    let (entry, settings) = (block.entry(), &archive.manifest().settings);
    let (of, side) = match entry.kind {
        MIRROR => (RECEIVERS, settings.hit),
        PROBE_MIRROR => (PROBES, settings.probe),
        _ => (BOUNCE, settings.bounce_sky),
    };
    let owners = archive.entries_of(of);
    let owner = owners.binary_search_by_key(&entry.tile, |owner| owner.tile).ok();
    let expected = owner.and_then(|row| owners.get(row)).map_or(0, |owner| owner.items);
    if entry.items != expected {
        return Err(block.corrupt(format!("{} rows", entry.items), format!("{expected}, as {}", format::kind_name(of))));
    }
    let bad = || block.corrupt("a malformed layer", "a layer that matches the manifest");
    let rows = extras::unpack(block.bytes(), entry.items as usize).ok_or_else(bad)?;
    let Some(keys) = &site.keys else { return Ok(()) };
    let side = side as usize;
    let (base, fine) = (settings.sky_base as usize, settings.sky_fine as usize);
    for row in rows {
        let (chains, steps, mut cells): (Vec<Chain>, Vec<Vec<MirrorStep>>, Vec<CellKey>);
        let known;
        if entry.kind == MIRROR {
            // Writing the row again reveals a key of another region.
            let found = ReceiverMirrors::from_bytes(&row, base, side).filter(|found| found.to_bytes() == row);
            let found = found.ok_or_else(bad)?;
            let doubled = fine.checked_div(base).unwrap_or(0);
            let whole = found.windows.iter().all(|window| {
                let side = usize::from(window.side);
                fine <= MAX_FINE && SkyTexture::unpack(&window.texture, 1, side, side.saturating_mul(doubled)).is_some()
            });
            if !whole {
                return Err(bad());
            }
            chains = found.windows.iter().map(|window| window.chain).collect();
            (steps, cells) = found.paths.into_iter().map(|path| (path.steps, path.cell)).unzip();
            known = &keys.probes;
        } else {
            let bytes = side.saturating_mul(side).div_ceil(8);
            let found = CellMirrors::from_bytes(&row, bytes).filter(|found| found.to_bytes(bytes) == row);
            let found = found.ok_or_else(bad)?;
            chains = found.windows.iter().map(|window| window.chain).collect();
            (steps, cells) = found.paths.into_iter().map(|path| (path.steps, path.cell)).unzip();
            known = &keys.bounces;
        }
        let mirrors = chains.iter().flat_map(Chain::numbers);
        if let Some(number) = mirrors.max().filter(|&number| u64::from(number) >= site.orientations) {
            return Err(block.corrupt(format!("mirror {number}"), format!("below {}", site.orientations)));
        }
        check_materials(block, steps.iter().flatten().map(|step| step.0), site)?;
        cells.dedup();
        // An archive for replay only does not hold the cells.
        if !archive.manifest().replay_only {
            check_references(block, &cells, known)?;
        }
    }
    Ok(())
}

/// Largest side of a refined sky, as `schema/layers.md` states it. With a larger one a few bytes
/// could stand for gigabytes.
const MAX_FINE: usize = 4096;

/// Checks that all keys are among the known ones.
fn check_references(block: &Block, keys: &[CellKey], known: &[CellKey]) -> Result<()> {
    match keys.iter().find(|key| known.binary_search(key).is_err()) {
        Some(key) => Err(block.corrupt(format!("{key:?}, which does not exist"), "cells that exist")),
        None => Ok(()),
    }
}

fn check_materials(block: &Block, materials: impl Iterator<Item = u16>, site: &Site) -> Result<()> {
    match materials.max() {
        Some(number) if u64::from(number) >= site.materials => {
            Err(block.corrupt(format!("material {number}"), format!("below {}", site.materials)))
        }
        _ => Ok(()),
    }
}

/// Returns the bytes between the parts that are not zero. Later generations leave old blocks there,
/// so only the first generation is checked.
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
            // A forged gap may be large, so it is read in pieces.
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
