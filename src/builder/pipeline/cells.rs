//! Cells of a build, fine probes and coarse bounce cells. In: keys. Out: cells, traced a batch at a
//! time, sorted, packed, compressed and written. Only their keys stay in memory.

use std::borrow::Cow;
use std::sync::Arc;

use rayon::prelude::*;

use super::report::RayCounts;
use super::site_tracer::SiteTracer;
use crate::pipeline::canopies::canopy_of_cell;
use crate::settings::Effect;
use crate::trace::canopy::CellCrossings;
use crate::trace::probe::{Directions, PointWeights, ProbeTrace, trace_probe};
use crate::trace::surroundings::{SeenCell, SurroundingSettings, Surroundings, surroundings};
use heliotile_archives::pack::Chunks;
use heliotile_archives::writing::Writer;
use heliotile_core::archive::format::{CellKind, TileNumber};
use heliotile_core::archive::{Blocks, format, tables};
use heliotile_core::error::Result;
use heliotile_core::layers::cells::{Cell, Cells};
use heliotile_core::light::radiosity::surround;
use heliotile_core::memory::Use;
use heliotile_core::observer::Stage;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::cells::{CellKey, CellSet, level_of, sort_cells};
use heliotile_files::spill::{Sorter, damaged};

/// Number of bounce cells traced at a time.
const WAVE: usize = 8192;

/// Number of cells whose rays to their surroundings are cast together. One cell has 8 or 16 of them
/// in all directions, too few to fill packets of 16.
const TOGETHER: usize = 32;

/// Numbers of rays cast for cells: those that any scene needs, and those by way of mirrors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cast {
    pub plain: u64,
    pub mirror: u64,
}

impl Cast {
    pub fn and(self, other: Self) -> Self {
        Cast { plain: self.plain + other.plain, mirror: self.mirror + other.mirror }
    }
}

/// Number of cells written, and the cells that they see, for the next stage.
#[derive(Default)]
pub(super) struct Written {
    pub count: u64,
    pub seen: CellSet,
}

impl SiteTracer<'_> {
    /// Traces and writes the probes of all keys, which are sorted.
    pub fn write_probes(
        &self,
        keys: impl Iterator<Item = Result<CellKey>>,
        writer: &mut Writer,
        rays: &mut RayCounts,
    ) -> Result<Written> {
        let texture = self.directions(CellKind::Probes);
        let progress = Stage::begin(self.observer, "probes", None);
        let mut chunks = self.chunks(CellKind::Probes);
        let mut seen = CellSet::default();
        let looks = self.looks(CellKind::Probes);
        let mut keys = keys.peekable();
        while keys.peek().is_some() {
            let batch: Vec<CellKey> = keys.by_ref().take(chunks.batch()).collect::<Result<_>>()?;
            progress.advance(batch.len() as u64);
            let known = |keys: &[CellKey]| self.known_cells(CellKind::Probes, keys, &texture, looks);
            let trace = |keys: &[CellKey]| {
                let (cells, cast) = self.trace_missing(CellKind::Probes, keys, known(keys), &texture);
                (cells.into(), cast)
            };
            let cast = self.write_chunks(&mut chunks, &batch, trace, writer, |chunk| seen.extend(chunk.reached()))?;
            rays.probe += cast.plain;
            rays.mirror += cast.mirror;
        }
        drop(progress);
        let count = chunks.finish(writer)?;
        Ok(Written { count, seen })
    }

    /// Returns the number of rays that each cell of a kind casts to its surroundings.
    pub(super) fn looks(&self, kind: CellKind) -> usize {
        let traced = kind == CellKind::Bounces || self.traces(Effect::Bounces);
        if traced { self.hits(kind) } else { 0 }
    }

    /// Returns the number of hits on its surroundings that a cell of a kind stores.
    fn hits(&self, kind: CellKind) -> usize {
        match kind {
            CellKind::Probes => self.settings.probe_hits,
            CellKind::Bounces => self.settings.bounce_hits,
        }
    }

    /// Returns a writer for chunks of cells of a kind, none of them written.
    pub(super) fn chunks(&self, kind: CellKind) -> Chunks {
        Chunks::new(kind, self.hits(kind), self.side(kind))
    }

    /// Returns the side of the sky textures of cells of a kind.
    fn side(&self, kind: CellKind) -> usize {
        match kind {
            CellKind::Probes => self.settings.probe,
            CellKind::Bounces => self.settings.bounce_sky,
        }
    }

    /// Returns the directions of the sky rays of cells of a kind.
    pub(super) fn directions(&self, kind: CellKind) -> Directions {
        let weighting = match kind {
            CellKind::Probes => PointWeights::Open,
            CellKind::Bounces => PointWeights::Alike,
        };
        Directions::new(self.side(kind), weighting)
    }

    /// Traces cells of a kind in the order of their keys, and returns each with the numbers of rays
    /// cast.
    pub(super) fn trace_cells(&self, kind: CellKind, keys: &[CellKey], texture: &Directions) -> Vec<(Cell, Cast)> {
        let settings = SurroundingSettings { closed_level: level_of(self.settings.closed_m), rays: self.hits(kind) };
        let (surfaces, reflections) = (self.surfaces(), self.reflections.as_ref());
        let trace = |keys: &[CellKey]| {
            let probes: Vec<ProbeTrace> = keys.iter().map(|&key| trace_probe(key, texture, surfaces)).collect();
            let cells = || keys.iter().copied().zip(&probes);
            let seen = match self.looks(kind) {
                0 => cells().map(|_| Surroundings::none(settings.rays)).collect(),
                _ => surroundings(cells(), texture, settings, surfaces, reflections),
            };
            let cell = |((&key, probe), seen)| self.cell(key, probe, seen, texture);
            keys.iter().zip(probes).zip(seen).map(cell).collect::<Vec<_>>()
        };
        // A few cells, such as those of late waves, are split into smaller parts to keep all
        // threads busy.
        let together = keys.len().div_ceil(rayon::current_num_threads()).clamp(1, TOGETHER);
        keys.par_chunks(together).flat_map_iter(trace).collect()
    }

    /// Packs a traced cell, and counts the rays cast for it: for the cell itself, and for its views
    /// in mirrors.
    pub(super) fn cell(
        &self,
        key: CellKey,
        probe: ProbeTrace,
        seen: Surroundings,
        texture: &Directions,
    ) -> (Cell, Cast) {
        let mut mirror = 0;
        let mirrors = self.cell_mirrors(key, &probe, texture, &seen, &mut mirror);
        let (normal, doubtful) = (probe.normal.as_vec3().to_array(), probe.doubtful);
        let around = || surround(key, normal, &probe.bits, &texture.centres);
        let leaves = self.leaf_view(self.traces(Effect::Bounces));
        let crossings = CellCrossings::new(leaves, key, &probe, texture, &seen.seen, around);
        let cast = Cast { plain: probe.rays + seen.cast + crossings.rays, mirror };
        let canopy = canopy_of_cell(crossings, texture.n, seen.seen.len());
        (Cell { key, normal, bits: probe.bits, seen: pairs(seen.seen), mirrors, canopy, doubtful }, cast)
    }

    /// Traces and writes all bounce cells that can be reached from `start`: the closed system.
    pub fn write_bounces(&self, start: CellSet, writer: &mut Writer, rays: &mut RayCounts) -> Result<u64> {
        // The index is written after all chunks, so a resumed build holds all cells if it is there.
        if writer.has(format::INDEX, CellKind::Bounces.index()) {
            let index = tables::IndexTable::from_block(&writer.block(format::INDEX, CellKind::Bounces.index())?)?;
            let items = |chunk: u32| Ok(u64::from(writer.block(format::BOUNCE, TileNumber(chunk))?.items()));
            return (0..index.rows() as u32).map(items).sum();
        }
        let mut found = BounceCells::new(self, start.iter().copied().collect());
        self.close(&mut found, start, writer, rays)?;
        let mut chunks = self.chunks(CellKind::Bounces);
        let mut sorted = found.sorted(self)?.peekable();
        while sorted.peek().is_some() {
            let batch: Vec<Cell> = sorted.by_ref().take(chunks.batch()).collect::<Result<_>>()?;
            let keys: Vec<CellKey> = batch.iter().map(|c| c.key).collect();
            let traced = |keys: &[CellKey]| {
                let start = batch.partition_point(|c| c.key < keys[0]);
                (Cow::Borrowed(&batch[start..start + keys.len()]), Cast::default())
            };
            self.write_chunks(&mut chunks, &keys, traced, writer, |_| {})?;
        }
        chunks.finish(writer)
    }
}

/// Bounce cells that are traced but not yet in chunks.
pub(super) struct BounceCells {
    sorter: Sorter,
    /// Cells that are to be traced next, before the cells that they see.
    pub wave: Vec<CellKey>,
}

impl BounceCells {
    pub fn new(at: &SiteTracer, wave: Vec<CellKey>) -> Self {
        BounceCells { sorter: Sorter::new(&at.folder, at.memory.length(Use::BounceCells)), wave }
    }

    /// Adds a traced cell, and adds the cells that it sees to the wave unless they are in `met`.
    pub fn add(&mut self, cell: &Cell, met: &mut CellSet) -> Result<()> {
        self.wave.extend(cell.reached().filter(|key| met.insert(*key)));
        self.push(cell)
    }

    /// Adds a traced cell.
    pub fn push(&mut self, cell: &Cell) -> Result<()> {
        self.sorter.push(&cell.key.to_bytes(), &cell.to_bytes())
    }

    /// Returns all cells by key.
    pub fn sorted(self, at: &SiteTracer) -> Result<impl Iterator<Item = Result<Cell>> + use<>> {
        let (texels, folder) = (at.settings.bounce_sky * at.settings.bounce_sky, at.folder.clone());
        let cell = move |record: Result<(Vec<u8>, Vec<u8>)>| {
            let (key, cell) = record?;
            Cell::from_bytes(&key, &cell, texels).ok_or_else(|| damaged(&folder))
        };
        Ok(self.sorter.finish()?.map(cell))
    }
}

impl SiteTracer<'_> {
    /// Traces all cells of a wave and, wave by wave, the cells that they see and that are not in
    /// `met`.
    pub(super) fn close(
        &self,
        found: &mut BounceCells,
        mut met: CellSet,
        writer: &mut Writer,
        rays: &mut RayCounts,
    ) -> Result<()> {
        let texture = self.directions(CellKind::Bounces);
        let progress = Stage::begin(self.observer, "bounces", None);
        while !found.wave.is_empty() {
            let mut wave = std::mem::take(&mut found.wave);
            sort_cells(&mut wave);
            for part in wave.chunks(WAVE) {
                let known = self.known_cells(CellKind::Bounces, part, &texture, self.looks(CellKind::Bounces));
                let (cells, cast) = self.trace_missing(CellKind::Bounces, part, known, &texture);
                rays.bounce += cast.plain;
                rays.mirror += cast.mirror;
                cells.iter().try_for_each(|cell| found.add(cell, &mut met))?;
                progress.advance(part.len() as u64);
                self.checkpoint(writer)?;
            }
        }
        Ok(())
    }

    /// Traces the cells that are not known. Returns all cells, sorted by key, and the rays cast.
    fn trace_missing(
        &self,
        kind: CellKind,
        keys: &[CellKey],
        mut known: Vec<Cell>,
        texture: &Directions,
    ) -> (Vec<Cell>, Cast) {
        let is_known = |key: &CellKey| known.binary_search_by_key(key, |cell| cell.key).is_ok();
        let missing: Vec<CellKey> = keys.iter().filter(|key| !is_known(key)).copied().collect();
        let traced = self.trace_cells(kind, &missing, texture);
        let cast = traced.iter().fold(Cast::default(), |sum, t| sum.and(t.1));
        let all_new = known.is_empty();
        known.extend(traced.into_iter().map(|t| t.0));
        if !all_new {
            known.sort_unstable_by_key(|cell| cell.key);
        }
        (known, cast)
    }

    /// Writes the chunks of some keys, which are sorted and come a batch at a time; only the last
    /// batch may be smaller. A chunk that the file already holds is read instead of traced. Returns
    /// the rays cast.
    fn write_chunks<'c>(
        &self,
        chunks: &mut Chunks,
        keys: &[CellKey],
        trace: impl Fn(&[CellKey]) -> (Cow<'c, [Cell]>, Cast) + Sync,
        writer: &mut Writer,
        mut see: impl FnMut(&Cells),
    ) -> Result<Cast> {
        let first = chunks.next();
        let site = OpenSite::over(&*writer, Arc::clone(&self.facts));
        let done: Vec<Result<_>> = keys
            .par_chunks(chunks.size())
            .enumerate()
            .map(|(i, keys)| {
                let number = TileNumber(first.0 + i as u32);
                if writer.has(chunks.kind().chunks(), number) {
                    return Ok((site.cells(chunks.kind(), number)?, Vec::new(), Cast::default()));
                }
                let (traced, cast) = trace(keys);
                let chunk = Cells::new(&traced);
                let blocks = chunks.encode(number, &chunk)?;
                Ok((chunk, blocks, cast))
            })
            .collect();
        let mut rays = Cast::default();
        // Chunks are appended in order, so that the bytes do not depend on threads.
        for part in done {
            let (chunk, blocks, cast) = part?;
            chunks.add(&chunk, blocks, writer)?;
            see(&chunk);
            rays = rays.and(cast);
        }
        self.checkpoint(writer)?;
        Ok(rays)
    }
}

fn pairs(seen: Vec<SeenCell>) -> Vec<(bool, Option<CellKey>)> {
    seen.into_iter().map(|s| (s.up, s.cell)).collect()
}
