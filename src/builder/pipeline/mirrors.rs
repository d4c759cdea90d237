//! Views of receivers and cells in mirrors: traced here, packed as `layers/mirror.rs` says.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec2, DVec3};

use super::site_tracer::SiteTracer;
use crate::settings::Effect;
use crate::trace::Ray;
use crate::trace::mirror::{End, Look, MirrorRay, ReflectedHit, Reflections};
use crate::trace::probe::{Directions, ProbeTrace, lifted};
use crate::trace::receiver::{CellSettings, HitTrace};
use crate::trace::surroundings::{Surroundings, seen_from};
use crate::trace::viewpoint::Viewpoint;
use heliotile_core::hemisphere::{HEMISPHERE_SR, mix, texel_direction};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::mirror::{CellMirrors, CellPath, CellWindow, MirrorPath, Window};
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::layers::texel_block::TexelBlock;
use heliotile_core::light::mirrors::left;
use heliotile_core::site::cells::{CellKey, level_of};

impl SiteTracer<'_> {
    /// Returns the surfaces that a receiver sees in mirrors, and adds the rays cast to `rays`.
    pub(super) fn mirror_paths(&self, view: &Viewpoint, hits: &HitTrace, rays: &mut u64) -> Vec<MirrorPath> {
        let Some(reflections) = self.reflections.as_ref().filter(|_| self.traces(Effect::Diffuse)) else {
            return Vec::new();
        };
        let cells = CellSettings { factor: self.settings.cell_factor(), floor_m: self.settings.cell_floor_m };
        let texel_angle = (HEMISPHERE_SR / (self.settings.hit * self.settings.hit) as f64).sqrt();
        let starts: Vec<MirrorRay> = hits.mirrors.iter().map(|(_, start)| *start).collect();
        let mut paths = Vec::new();
        let mut lost = 0.0;
        for ((texel, start), (met, end)) in hits.mirrors.iter().zip(reflections.follow(&starts, rays)) {
            let path = |met: ReflectedHit| {
                let level = cells.level(met.length_m, texel_angle);
                MirrorPath { texel: *texel as u32, cell: reflections.cell(&met, level), steps: met.steps }
            };
            if end == End::Cut {
                let share = met.last().map_or(0.0, |met| left(&met.steps, &self.reflectors));
                lost += share * view.normal.dot(start.direction).max(0.0);
            }
            paths.extend(met.into_iter().map(path));
        }
        // A texel has 2 pi / n^2 sr, of the pi of a cosine-weighted hemisphere.
        note_lost(&self.lost[0], lost * 2.0 / (self.settings.hit * self.settings.hit) as f64);
        paths
    }

    /// Returns the parts of the sky that a receiver sees in mirrors, and adds the rays cast to
    /// `rays`.
    pub(super) fn mirror_windows(&self, view: &Viewpoint, rays: &mut u64) -> Vec<Window> {
        let Some(reflections) = &self.reflections else { return Vec::new() };
        let (base, fine) = (self.settings.sky_base, self.settings.sky_fine);
        let around = reflections.around_mirrors(base, FINER, view, rays);
        let origin = lifted(view.position, view.normal, self.tracer);
        let mut windows = Vec::new();
        for (chain, texels) in reflections.reached(&around, base, rays) {
            let map = reflections.seen_from(&chain);
            let low = |axis: fn(&(u32, u32)) -> u32| texels.iter().map(axis).min().unwrap_or(0);
            let high = |axis: fn(&(u32, u32)) -> u32| texels.iter().map(axis).max().unwrap_or(0);
            let (column, row) = (low(|t| t.0), low(|t| t.1));
            let side = (high(|t| t.0) - column).max(high(|t| t.1) - row) + 1;
            // A square near the border is moved inwards.
            let (column, row) = (column.min(base as u32 - side), row.min(base as u32 - side));
            let mut front = BitSquare::new(side as usize);
            texels.iter().for_each(|&(c, r)| front.set((c - column) as usize, (r - row) as usize, true));
            let visible = |n: usize, texels: &[(u32, u32)]| {
                let scale = (n / side as usize) as u32;
                let whole: Vec<(u32, u32)> =
                    texels.iter().map(|&(c, r)| (c + column * scale, r + row * scale)).collect();
                let look = |&(c, r): &(u32, u32), n: usize| {
                    let sky = texel_direction(c as usize, r as usize, n, DVec2::splat(0.5));
                    Look { chain: 0, sky, origin, normal: view.normal }
                };
                let n = base * scale as usize;
                // A texel that is not refined further takes the answer of its centre.
                let split = if n < fine { (base * FINER / n).max(1) as u32 } else { 1 };
                let parts = |&(c, r): &(u32, u32)| {
                    let part = move |i: u32| (c * split + i % split, r * split + i / split);
                    (0..split * split).map(move |i| look(&part(i), n * split as usize))
                };
                let looks: Vec<Look> = whole.iter().flat_map(parts).collect();
                let lit = reflections.lit(&[(chain, map)], &looks, rays);
                let of_texel = lit.chunks((split * split) as usize);
                refinable(texels, &of_texel.map(SeenPart::new).collect::<Vec<SeenPart>>())
            };
            let (texture, dense) =
                SkyTexture::trace(front, side as usize * (fine / base), TexelBlock::by_texels(visible));
            if dense.count() > 0 {
                windows.push(Window {
                    chain,
                    column: column as u16,
                    row: row as u16,
                    side: side as u16,
                    texture: SkyTexture::pack(&[texture]),
                });
            }
        }
        windows
    }

    /// Returns the surfaces and parts of the sky that a cell sees in mirrors, and adds the rays
    /// cast to `rays`.
    pub(super) fn cell_mirrors(
        &self,
        key: CellKey,
        probe: &ProbeTrace,
        texture: &Directions,
        surroundings: &Surroundings,
        rays: &mut u64,
    ) -> CellMirrors {
        // Leaves do not look into mirrors.
        let Some(reflections) = self.reflections.as_ref().filter(|_| !key.is_leaf()) else {
            return CellMirrors::default();
        };
        let starts: Vec<MirrorRay> = surroundings.mirrors.iter().map(|(_, start)| *start).collect();
        let closed = level_of(self.settings.closed_m);
        let mut paths = Vec::new();
        let mut lost = 0.0;
        for ((up, _), (met, end)) in surroundings.mirrors.iter().zip(reflections.follow(&starts, rays)) {
            if end == End::Cut {
                lost += met.last().map_or(0.0, |met| left(&met.steps, &self.reflectors));
            }
            let path = |met: ReflectedHit| {
                let cell = seen_from(key, met.length_m, closed, |level| reflections.cell(&met, level));
                CellPath { up: *up, cell, steps: met.steps }
            };
            paths.extend(met.into_iter().map(path));
        }
        note_lost(&self.lost[1], lost / surroundings.seen.len().max(1) as f64);
        CellMirrors { windows: cell_windows(reflections, key, probe, texture, rays), paths }
    }
}

/// Number of parts per side of a base texel that are traced where mirrors may be, since panes are
/// often narrower than a base texel.
const FINER: usize = 4;

/// Visibility of a texel by its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SeenPart {
    Nothing,
    Some,
    All,
}

impl SeenPart {
    fn new(parts: &[bool]) -> Self {
        match parts.iter().filter(|part| **part).count() {
            0 => SeenPart::Nothing,
            count if count == parts.len() => SeenPart::All,
            _ => SeenPart::Some,
        }
    }
}

/// Returns bits such that each texel that is partly seen is refined. [`SkyTexture::trace`] refines
/// a texel that differs from a neighbour, so a partly seen texel gets a bit that differs.
fn refinable(texels: &[(u32, u32)], seen: &[SeenPart]) -> Vec<bool> {
    let of = |((column, row), seen): (&(u32, u32), &SeenPart)| match seen {
        SeenPart::Nothing => false,
        SeenPart::All => true,
        SeenPart::Some => (column + row) % 2 == 0,
    };
    let mut bits: Vec<bool> = texels.iter().zip(seen).map(of).collect();
    if !seen.contains(&SeenPart::Some) {
        return bits;
    }
    let places: HashMap<(u32, u32), usize> = texels.iter().copied().zip(0..).collect();
    for (place, (column, row)) in texels.iter().enumerate().filter(|(place, _)| seen[*place] == SeenPart::Some) {
        let near = |at: &u32| at.saturating_sub(1)..at + 2;
        let mut around = near(row).flat_map(|r| near(column).map(move |c| (c, r)));
        let own = bits[place];
        if around.all(|at| places.get(&at).is_none_or(|other| bits[*other] == own)) {
            bits[place] = !own;
        }
    }
    bits
}

/// Keeps the largest share of light that is lost behind the last mirror that is followed.
fn note_lost(largest: &AtomicU64, share: f64) {
    // Numbers that are not negative sort as their bits do.
    largest.fetch_max(share.max(0.0).to_bits(), Ordering::Relaxed);
}

/// Returns the rays that look for mirrors around a cell.
pub(super) fn around_cell(reflections: &Reflections, key: CellKey, probe: &ProbeTrace, n: usize) -> Vec<(DVec3, Ray)> {
    let lit: Vec<_> = probe.points.iter().filter(|p| p.1 > 0.0).map(|p| p.0).collect();
    if lit.is_empty() {
        return Vec::new();
    }
    let seed = key.seed();
    reflections.around(n, seed, |texel| {
        let point = lit[(mix(seed ^ 0x6c6f_6f6b, texel as u64) % lit.len() as u64) as usize];
        (point.position, point.normal)
    })
}

/// Returns the texels of the sky that a cell sees in mirrors, each from the point that also traces
/// it directly.
fn cell_windows(
    reflections: &Reflections,
    key: CellKey,
    probe: &ProbeTrace,
    texture: &Directions,
    rays: &mut u64,
) -> Vec<CellWindow> {
    let (n, directions) = (texture.n, texture.of(key));
    let around = around_cell(reflections, key, probe, n);
    let (mut chains, mut looks, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (chain, texels) in reflections.reached(&around, n, rays) {
        let map = reflections.seen_from(&chain);
        for texel in texels.into_iter().map(|(column, row)| row as usize * n + column as usize) {
            let point = probe.points[usize::from(probe.owner[texel])].0;
            let origin = reflections.origin(point.position, point.normal);
            looks.push(Look { chain: chains.len(), sky: directions[texel], origin, normal: point.normal });
            places.push(texel);
        }
        chains.push((chain, map));
    }
    let mut seen: Vec<Vec<u16>> = vec![Vec::new(); chains.len()];
    for ((look, texel), lit) in looks.iter().zip(places).zip(reflections.lit(&chains, &looks, rays)) {
        if lit {
            // There are at most 128 texels a side.
            seen[look.chain].push(texel as u16);
        }
    }
    let windows = chains.into_iter().zip(seen).filter(|(_, texels)| !texels.is_empty());
    windows.map(|((chain, _), texels)| CellWindow { chain, texels }).collect()
}
