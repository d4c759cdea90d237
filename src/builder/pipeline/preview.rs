//! Previews: layers that a change of the scene alters by less than a bound are kept. In: an archive
//! of the scene before, the bound. Out: copied tiles, chunks of cells and responses, and the few
//! that are traced or derived again.
//!
//! The bound holds under a uniform sky, or in the mean over suns everywhere in the sky, as a share
//! of the light on open ground:
//!
//! - A cell that sees less than `unasked` of the change is kept. Its light is then off by less than
//!   `unasked / (1 - rho)` with all bounces, and that of a receiver by `rho` times as much:
//!   `unasked = bound (1 - rho) / rho`.
//! - A response is kept if the cells that the receiver sees alter by less than the bound, weighted
//!   by their share of its hemisphere and their reflectance. A cell alters by the light from the
//!   part of the change that it sees, and by the share of [`Reach::by_all_ways`] that the surfaces
//!   it sees reflect.
//! - Rays of receivers are not cast again, either, if the change fills less than half of the bound
//!   in their view, as estimated by a few rays towards it. That share counts for their responses.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rayon::prelude::*;

use super::Build;
use super::cells::{BounceCells, Cast, Written};
use super::previous_build::{PLANE, PreviousBuild};
use super::report::RayCounts;
use super::site_tracer::SiteTracer;
use super::tiles::CopiedTile;
use crate::settings::BuildSettings;
use crate::trace::change::Change;
use crate::trace::probe::Directions;
use crate::trace::reach::{Reach, SurfacePlace};
use heliotile_archives::pack::Chunks;
use heliotile_archives::writing::Writer;
use heliotile_core::archive::format::{CellKind, TileNumber};
use heliotile_core::archive::preview::Preview;
use heliotile_core::archive::{EncodedBlock, format};
use heliotile_core::error::Result;
use heliotile_core::layers::canopy::{Canopy, Powers};
use heliotile_core::layers::cells::{Cell, Cells, DOWN, MISS};
use heliotile_core::light::radiosity::{SidesOf, Surround, each_ray, surround};
use heliotile_core::light::response::{Viewer, texel_weights};
use heliotile_core::light::tile_view::TileView;
use heliotile_core::observer::Stage;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::cells::{CellKey, CellMap, CellSet};
use heliotile_core::site::receiver::Receiver;

/// Number of tiles whose bounds are found together.
const GROUP: usize = 64;

/// Layers that a preview keeps.
pub(super) struct PreviewState {
    percent: f64,
    reach: Reach,
    /// Share of a cell's light that the change may fill, below which the cell is kept.
    unasked: f64,
    /// Upper bounds of how much the light on probes alters. Probes that are not in the map alter by
    /// less than [`PreviewState::small`].
    alters: Mutex<CellMap<f32>>,
    /// Number of receivers whose responses are kept.
    receivers: AtomicU64,
}

impl PreviewState {
    /// Returns the preview as the manifest states it.
    pub fn stated(&self) -> Preview {
        let kept_receivers = self.receivers.load(Ordering::Relaxed);
        Preview { bound_percent: self.percent, kept_receivers, ..Preview::default() }
    }

    /// Returns the bound as a share.
    fn share(&self) -> f64 {
        self.percent / 100.0
    }

    /// Returns the share below which the alteration of a cell is not recorded.
    fn small(&self) -> f64 {
        self.share() / 4.0
    }

    /// Returns the largest alteration of the direct light at some receivers if their rays are not
    /// cast again; `None` if it is too large.
    pub fn direct(&self, receivers: &[Receiver], at: &SiteTracer, change: &Change) -> Option<f64> {
        let alters = receivers.iter().map(|receiver| {
            let view = at.viewpoint(receiver);
            let middle = DVec3::from(view.origin(at.tracer).map(f64::from));
            let in_view = self.reach.in_view(SurfacePlace { middle, spread_m: 0.0, normal: Some(view.normal) });
            if in_view <= 0.1 * self.share() {
                in_view
            } else {
                self.reach.shown(&view, view.seed(), change, at.tracer)
            }
        });
        alters
            .map(|share| (share <= 0.5 * self.share()).then_some(share))
            .try_fold(0.0, |most: f64, share| Some(most.max(share?)))
    }
}

/// Returns the place of a cell's surfaces.
fn surface(cells: &Cells, row: usize, change: &Change) -> SurfacePlace {
    let normal = DVec3::from(cells.normals[row].map(f64::from));
    let (middle, spread_m) = change.middle(cells.keys[row]);
    SurfacePlace { middle, spread_m, normal: (normal.length() >= PLANE).then(|| normal.normalize()) }
}

impl Build<'_> {
    /// Returns what is kept within a bound. Warns and returns `None` if nothing can be bounded.
    pub(super) fn preview_within(
        &self,
        percent: f64,
        before: &PreviousBuild,
        settings: &BuildSettings,
    ) -> Option<PreviewState> {
        if self.scene.reflects(settings) || before.file.has(format::MIRRORS, TileNumber::FIRST) {
            self.observer.warn(
                "the scene has mirrors, so a change may show anywhere: {preview} has no effect, and the whole archive is built",
            );
            return None;
        }
        let brightest = self.scene.scene.materials.iter().map(|material| material.diffuse).fold(0.0, f64::max);
        let unasked = (percent / 100.0 * (1.0 - brightest) / brightest).min(1.0);
        let reach = Reach::new(&before.change, brightest);
        Some(PreviewState { percent, reach, unasked, alters: Mutex::default(), receivers: AtomicU64::new(0) })
    }
}

/// Chunk of cells as it will be written, under a number that is not known yet.
struct Piece {
    first: CellKey,
    cells: u64,
    blocks: Vec<EncodedBlock>,
}

/// Cells of a chunk that are new or were traced again.
#[derive(Default)]
struct Retraced {
    cells: Vec<Cell>,
    cast: Cast,
    /// Upper bounds of how much the light on cells alters, for cells where it is not small.
    alters: Vec<(CellKey, f32)>,
}

/// Chunk of the archive before, updated.
struct Updated {
    pieces: Vec<Piece>,
    retraced: Retraced,
}

/// Chunk of the archive before, with the present numbers of materials.
struct PreviousChunk {
    cells: Cells,
    /// Cells that see a material which is gone.
    lost: Vec<CellKey>,
}

impl PreviousBuild<'_> {
    fn previous_chunk(&self, kind: CellKind, chunk: usize) -> Result<PreviousChunk> {
        let Some(source) = self.archive.source(kind).filter(|source| chunk < source.firsts().len()) else {
            return Ok(PreviousChunk { cells: Cells::default(), lost: Vec::new() });
        };
        let cells = source.chunk(chunk)?;
        if self.same_numbers {
            return Ok(PreviousChunk { cells, lost: Vec::new() });
        }
        let (mut lost, mut kept) = (Vec::new(), Vec::new());
        for row in 0..cells.rows() {
            match self.renumbered(cells.cell(row)) {
                Some(cell) => kept.push(cell),
                None => lost.extend(self.now(cells.keys[row])),
            }
        }
        Ok(PreviousChunk { cells: Cells::new(&kept), lost })
    }

    /// Returns `[chunk]`: a key above all keys of the chunks before and not above any key in the
    /// chunk; `None` if no keys are left in it or after it.
    fn starts(&self, kind: CellKind) -> Result<Vec<Option<CellKey>>> {
        let firsts = self.archive.source(kind).map_or(&[][..], |source| source.firsts());
        if self.same_numbers {
            return Ok(firsts.iter().copied().map(Some).collect());
        }
        let first = |chunk: usize| {
            let PreviousChunk { cells, lost } = self.previous_chunk(kind, chunk)?;
            Ok(cells.keys.first().into_iter().chain(lost.first()).min().copied())
        };
        let mut starts: Vec<Option<CellKey>> = (0..firsts.len()).into_par_iter().map(first).collect::<Result<_>>()?;
        for chunk in (1..starts.len()).rev() {
            starts[chunk - 1] = starts[chunk - 1].or(starts[chunk]);
        }
        Ok(starts)
    }
}

impl SiteTracer<'_> {
    /// Writes the probes of the archive before and those of more keys, which are sorted. Probes are
    /// traced again if they may see the change.
    pub(super) fn update_probes(
        &self,
        keys: impl Iterator<Item = Result<CellKey>>,
        writer: &mut Writer,
        rays: &mut RayCounts,
    ) -> Result<Written> {
        let (Some(preview), kind) = (self.preview(), CellKind::Probes) else { return Ok(Written::default()) };
        let texture = self.directions(kind);
        let mut seen = CellSet::default();
        let mut alters = CellMap::default();
        let update = |held: &PreviousChunk, wanted| {
            let mut retraced = self.again(kind, held, wanted, &texture);
            retraced.alters = self.alters_of(&held.cells, &retraced.cells);
            retraced
        };
        let count = self.merge_cells(
            kind,
            keys,
            |key| *key,
            update,
            writer,
            |retraced| {
                seen.extend(retraced.cells.iter().flat_map(Cell::reached));
                alters.extend(retraced.alters.iter().copied());
                rays.probe += retraced.cast.plain;
            },
        )?;
        *preview.alters.lock().unwrap_or_else(PoisonError::into_inner) = alters;
        Ok(Written { count, seen })
    }

    /// Writes the bounce cells of the archive before, and all that can be reached from `start`.
    pub(super) fn update_bounces(&self, start: CellSet, writer: &mut Writer, rays: &mut RayCounts) -> Result<u64> {
        let (kind, texture) = (CellKind::Bounces, self.directions(CellKind::Bounces));
        let Some(before) = &self.before else { return Ok(0) };
        let (mut met, mut reached) = (CellSet::default(), start);
        let mut found = BounceCells::new(self, Vec::new());
        let chunks: Vec<usize> = (0..before.starts(kind)?.len()).collect();
        for batch in chunks.chunks(2 * rayon::current_num_threads()) {
            let again = |&chunk: &usize| {
                let held = before.previous_chunk(kind, chunk)?;
                let again = self.again(kind, &held, Vec::new(), &texture);
                Ok((held, again))
            };
            for updated in batch.par_iter().map(again).collect::<Vec<Result<_>>>() {
                let (held, Retraced { cells, cast, .. }) = updated?;
                rays.bounce += cast.plain;
                met.extend(held.cells.keys.into_iter().chain(held.lost));
                for cell in cells {
                    reached.extend(cell.reached());
                    found.push(&cell)?;
                }
            }
            self.checkpoint(writer)?;
        }
        found.wave = reached.into_iter().filter(|key| met.insert(*key)).collect();
        self.close(&mut found, met, writer, rays)?;
        let as_traced = |_: &PreviousChunk, cells: Vec<Cell>| Retraced { cells, ..Retraced::default() };
        self.merge_cells(kind, found.sorted(self)?, |cell| cell.key, as_traced, writer, |_| {})
    }

    /// Traces the cells of a chunk that may see the change, those that see a material which is
    /// gone, and the wanted ones.
    fn again(&self, kind: CellKind, held: &PreviousChunk, wanted: Vec<CellKey>, texture: &Directions) -> Retraced {
        let (Some(before), Some(preview)) = (&self.before, self.preview()) else { return Retraced::default() };
        let PreviousChunk { cells, lost } = held;
        let altered = |row: &usize| {
            // Which points of a doubtful cell are hidden depends on more than what the cell sees.
            let asked =
                cells.doubtful[*row] || preview.reach.in_view(surface(cells, *row, &before.change)) >= preview.unasked;
            asked && !self.stands(&cells.cell(*row), before, texture, self.looks(kind))
        };
        let altered: Vec<CellKey> =
            (0..cells.rows()).into_par_iter().filter(altered).map(|row| cells.keys[row]).collect();
        before.cells[usize::from(kind == CellKind::Bounces)]
            .fetch_add((cells.rows() - altered.len()) as u64, Ordering::Relaxed);
        let mut missing: Vec<CellKey> = wanted
            .into_iter()
            .filter(|key| cells.keys.binary_search(key).is_err())
            .chain(lost.iter().copied())
            .collect();
        missing.sort_unstable();
        missing.dedup();
        let mut traced = self.trace_cells(kind, &altered, texture);
        // Cells whose surface is gone stay for the cells that still refer to them, which see so
        // little of the change that they are kept.
        traced.retain(|(cell, _)| cell.normal != [0.0; 3]);
        traced.extend(self.trace_cells(kind, &missing, texture));
        traced.sort_unstable_by_key(|(cell, _)| cell.key);
        let cast = traced.iter().fold(Cast::default(), |sum, (_, cast)| sum.and(*cast));
        Retraced { cells: traced.into_iter().map(|(cell, _)| cell).collect(), cast, alters: Vec::new() }
    }

    /// Returns upper bounds of how much the light on some probes alters, and on those that are
    /// traced again, where it is not small.
    fn alters_of(&self, cells: &Cells, traced: &[Cell]) -> Vec<(CellKey, f32)> {
        let (Some(before), Some(preview)) = (&self.before, self.preview()) else { return Vec::new() };
        let replaced: CellSet = traced.iter().map(|cell| cell.key).collect();
        let traced = Cells::new(traced);
        let mut alters = Vec::new();
        for (cells, are_traced) in [(cells, false), (&traced, true)] {
            let reflected = |key: &CellKey| {
                let (middle, spread_m) = before.change.middle(*key);
                let all = preview.reach.by_all_ways(SurfacePlace { middle, spread_m, normal: None });
                self.reflectors.get(usize::from(key.material)).map_or(0.0, |of| of.diffuse) * all
            };
            let seen: Vec<f64> = cells.seen.iter().map(reflected).collect();
            for row in (0..cells.rows()).filter(|row| are_traced || !replaced.contains(&cells.keys[*row])) {
                let in_view = preview.reach.in_view(surface(cells, row, &before.change));
                let leaves = cells.canopy_of(row).map_or_else(Vec::new, |canopy| canopy.leaves(&Powers::new()));
                let leaves: f64 = leaves.iter().map(|(key, share)| reflected(key) * f64::from(*share)).sum();
                // Of the other cells it is known that they do not see the change.
                let mut most = leaves + if are_traced || in_view < preview.unasked { in_view } else { 0.0 };
                let (hits, normal) = (cells.hits_of(row), cells.normals[row]);
                let from = |around: Surround| -> f64 {
                    let [below, above] = each_ray(hits, around);
                    let met = hits.iter().filter(|hit| *hit & !DOWN != MISS);
                    met.map(|hit| seen[(hit & !DOWN) as usize] * if hit & DOWN == 0 { above } else { below }).sum()
                };
                // First count all that is above the horizon, as if none of it were sky; this bound
                // is cheaper.
                let half = SidesOf(cells.keys[row]).above(f64::from(normal[2]));
                if most + from(Surround { up: half, down: 1.0 - half }) > preview.small() {
                    most += from(surround(cells.keys[row], normal, cells.bits_of(row), &self.probe_centres));
                }
                if most > preview.small() {
                    alters.push((cells.keys[row], most as f32));
                }
            }
        }
        alters
    }

    /// Writes the cells of a kind of the archive before. `others` come sorted by key and replace
    /// the cells of their keys; chunks without any are copied. Returns the number of all cells.
    fn merge_cells<T: Send>(
        &self,
        kind: CellKind,
        others: impl Iterator<Item = Result<T>>,
        key: fn(&T) -> CellKey,
        update: impl Fn(&PreviousChunk, Vec<T>) -> Retraced + Sync,
        writer: &mut Writer,
        mut told: impl FnMut(&Retraced),
    ) -> Result<u64> {
        let Some(before) = &self.before else { return Ok(0) };
        let progress = Stage::begin(self.observer, "cells", None);
        let mut chunks = self.chunks(kind);
        let (starts, mut others) = (before.starts(kind)?, others.peekable());
        let numbers: Vec<usize> = (0..starts.len().max(1)).collect();
        for batch in numbers.chunks(2 * rayon::current_num_threads()) {
            let mut parts = Vec::with_capacity(batch.len());
            for &chunk in batch {
                // A cell goes to the chunk whose range of keys holds its own.
                let end = starts.get(chunk + 1).copied().flatten();
                let before_end = |other: &Result<T>| match (other, end) {
                    (Ok(other), Some(end)) => key(other) < end,
                    _ => true,
                };
                let mut part = Vec::new();
                while let Some(other) = others.next_if(before_end) {
                    part.push(other?);
                }
                parts.push((chunk, part));
            }
            let updated = |(chunk, part): (usize, Vec<T>)| {
                let held = before.previous_chunk(kind, chunk)?;
                let retraced = update(&held, part);
                let pieces = self.pieces(kind, chunk, held, &retraced.cells, &chunks)?;
                Ok(Updated { pieces, retraced })
            };
            let done: Vec<Result<Updated>> = parts.into_par_iter().map(updated).collect();
            for updated in done {
                let updated = updated?;
                told(&updated.retraced);
                for Piece { first, cells, blocks } in updated.pieces {
                    progress.advance(cells);
                    chunks.add_numbered(first, cells, blocks, writer)?;
                }
            }
            self.checkpoint(writer)?;
        }
        chunks.finish(writer)
    }

    /// Returns a chunk of the archive before, unchanged or with some cells replaced.
    fn pieces(
        &self,
        kind: CellKind,
        chunk: usize,
        held: PreviousChunk,
        changed: &[Cell],
        chunks: &Chunks,
    ) -> Result<Vec<Piece>> {
        let cells = held.cells;
        let Some(before) = &self.before else { return Ok(Vec::new()) };
        // An unchanged chunk is copied as it is encoded, which keeps its bytes.
        if let Some(&first) = cells.keys.first().filter(|_| before.same_numbers && changed.is_empty()) {
            let [mirror, canopy] = kind.extras();
            let copy = |kind| before.copy(kind, TileNumber(chunk as u32), TileNumber::FIRST).transpose();
            let blocks = [kind.chunks(), mirror, canopy].into_iter().filter_map(copy).collect::<Result<_>>()?;
            return Ok(vec![Piece { first, cells: cells.rows() as u64, blocks }]);
        }
        let replaced: CellSet = changed.iter().map(|cell| cell.key).collect();
        let kept = (0..cells.rows()).filter(|row| !replaced.contains(&cells.keys[*row])).map(|row| cells.cell(row));
        let mut all: Vec<Cell> = kept.chain(changed.iter().cloned()).collect();
        all.sort_unstable_by_key(|cell| cell.key);
        let piece = |part: &[Cell]| {
            let blocks = chunks.encode(TileNumber::FIRST, &Cells::new(part))?;
            Ok(Piece { first: part[0].key, cells: part.len() as u64, blocks })
        };
        all.par_chunks(chunks.size()).map(piece).collect()
    }

    /// Copies the responses of those copied tiles whose reflected light alters by less than the
    /// bound.
    pub(super) fn keep_responses(&self, copied: &[CopiedTile], writer: &mut Writer) -> Result<()> {
        let (Some(before), Some(preview)) = (&self.before, self.preview()) else { return Ok(()) };
        if !before.same_light {
            self.observer.note("reflectances or transmittances have changed: all reflected light is calculated again");
            return Ok(());
        }
        let alters = std::mem::take(&mut *preview.alters.lock().unwrap_or_else(PoisonError::into_inner));
        for group in copied.chunks(GROUP) {
            let site = OpenSite::over(&*writer, Arc::clone(&self.facts));
            let kept = |of: &CopiedTile| {
                let view = TileView::read(&site, of.tile)?;
                if self.tile_alters(&view, of.direct, preview, &alters) > preview.share() {
                    return Ok(None);
                }
                let block = before.copy(format::RESPONSE, TileNumber(of.from), TileNumber(of.tile))?;
                Ok(block.inspect(|_| {
                    preview.receivers.fetch_add(view.viewers.len() as u64, Ordering::Relaxed);
                }))
            };
            let blocks: Vec<Option<EncodedBlock>> = group.par_iter().map(kept).collect::<Result<_>>()?;
            blocks.into_iter().flatten().try_for_each(|block| writer.append(block))?;
            self.checkpoint(writer)?;
        }
        Ok(())
    }

    /// Returns an upper bound of how much the change alters the light of any receiver of a tile, as
    /// a share of the light on open ground. `direct` is the bound for its direct light.
    fn tile_alters(&self, view: &TileView, direct: f64, preview: &PreviewState, alters: &CellMap<f32>) -> f64 {
        let of_cell = |key: &CellKey| {
            let most = alters.get(key).map_or(preview.small(), |most| f64::from(*most));
            // Its material is one of the scene's.
            self.reflectors[usize::from(key.material)].diffuse * most
        };
        let cells: Vec<f64> = view.hits.palette.iter().map(of_cell).collect();
        let most = cells.iter().copied().fold(0.0, f64::max);
        let texels = self.settings.hit * self.settings.hit;
        let by_leaves = |canopy: &Canopy| -> f64 {
            canopy.leaves(&Powers::new()).iter().map(|(key, share)| of_cell(key) * f64::from(*share)).sum()
        };
        let direct = direct + view.canopies.iter().map(by_leaves).fold(0.0, f64::max);
        let bound = |(viewer, texels): (&Viewer, &[u32])| {
            // A bound without weights comes first: as if the cell that alters most filled all but
            // the sky.
            let at_most = direct + most * (1.0 - viewer.sky_view);
            if at_most <= preview.share() {
                return at_most;
            }
            let met = texels.iter().zip(texel_weights(texels, viewer)).filter(|(cell, _)| **cell != 0);
            direct + met.map(|(cell, weight)| weight * cells[*cell as usize - 1]).sum::<f64>()
        };
        view.viewers.iter().zip(view.hits.texels.chunks(texels)).map(bound).fold(0.0, f64::max)
    }
}
