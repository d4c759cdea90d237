//! Sample of the receivers, traced before the build. In: a site's tracer, receivers. Out: what they
//! see, and the cost of tracing them.

use std::time::Instant;

use rayon::prelude::*;

use super::cells::Cast;
use super::site_tracer::SiteTracer;
use crate::receiver_tiles::ReceiverTiles;
use crate::trace::receiver::SkyTrace;
use crate::trace::sky_fans::SkyFans;
use heliotile_core::archive::format::CellKind;
use heliotile_core::error::Result;
use heliotile_core::hemisphere::ray_direction;
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::cells::{Cell, Cells};
use heliotile_core::layers::mirror::CellPath;
use heliotile_core::light::mirrors::left;
use heliotile_core::light::radiosity::{each_ray, surround};
use heliotile_core::site::cells::{CellKey, CellSet, sort_cells};
use heliotile_core::site::receiver::Receiver;

/// Largest number of receivers whose hits are traced. If there are more, bounds assume the worst
/// that any receiver could see. One in [`WHOLE`] is traced completely.
const SAMPLE: usize = 512;
const WHOLE: usize = 16;

/// Largest number of cells of the sample that are traced.
const CELLS: usize = 512;

/// Results of tracing the sample.
pub(super) struct Sample {
    /// Number of receivers of the sample; `all` is that of the site.
    pub receivers: usize,
    pub all: usize,
    /// Rays of a receiver: sky, hits, mirrors, canopies.
    pub rays: [f64; 4],
    /// Seconds for the sky and hits of a receiver, for its mirrors and its canopies.
    pub seconds: [f64; 3],
    /// Largest share of a hemisphere that surfaces fill, weighted by their reflectance.
    pub reflecting: f64,
    pub sees_mirrors: bool,
    /// Numbers of cells that a quarter of the sample and all of it see.
    pub cells: [usize; 2],
    pub traced: TracedCells,
}

/// Results of tracing some of the seen cells.
#[derive(Default)]
pub(super) struct TracedCells {
    /// Rays of a probe and of a bounce cell. `mirror_rays` and `seconds` are the rays by way of
    /// mirrors and the seconds of these cells.
    pub rays: [f64; 2],
    pub mirror_rays: f64,
    pub seconds: [f64; 2],
    /// Largest share of a hemisphere that other surfaces fill, weighted by their reflectance.
    pub reflecting: f64,
    pub see_mirrors: bool,
}

/// Returns cells in order.
fn sorted(cells: CellSet) -> Vec<CellKey> {
    let mut cells: Vec<CellKey> = cells.into_iter().collect();
    sort_cells(&mut cells);
    cells
}

impl SiteTracer<'_> {
    /// Traces receivers spread evenly over the site.
    pub fn sample(&self, receivers: &mut ReceiverTiles) -> Result<Sample> {
        let (count, step) = (receivers.count(), receivers.count().div_ceil(SAMPLE).max(1));
        let mut sample: Vec<Receiver> = Vec::new();
        let mut number = 0;
        for tile in receivers.tiles()? {
            for receiver in tile? {
                if number % step == 0 {
                    sample.push(receiver);
                }
                number += 1;
            }
        }
        Ok(self.look(&sample, count))
    }

    /// Traces the hits of the whole sample, and the rest for some of it.
    fn look(&self, receivers: &[Receiver], all: usize) -> Sample {
        let fans = SkyFans::new(self.settings.sky_base, self.settings.sky_fine);
        let reflectors = &self.reflectors;
        let rho = |key: &CellKey| reflectors.get(usize::from(key.material)).map_or(0.0, |r| r.diffuse);
        let whole: Vec<&Receiver> = receivers.iter().step_by(WHOLE).collect();
        let timed = Instant::now();
        let skies: Vec<(BitSquare, u64)> = whole
            .par_iter()
            .map(|receiver| {
                let SkyTrace { bits, rays, .. } = self.viewpoint(receiver).sky(&fans, self.tracer);
                (bits, rays)
            })
            .collect();
        let sky = skies.iter().map(|sky| sky.1).sum::<u64>();
        let sky_s = timed.elapsed().as_secs_f64() / whole.len().max(1) as f64;
        let timed = Instant::now();
        let behind = whole.par_iter().zip(&skies).filter(|_| self.canopies.is_some());
        let leaves = behind.map(|(receiver, (bits, _))| {
            let view = self.viewpoint(receiver);
            self.canopy_of_receiver(&view, bits, &self.trace_hits(&view), true).1
        });
        let leaves = leaves.sum::<u64>();
        let leaves_s = timed.elapsed().as_secs_f64() / whole.len().max(1) as f64;
        let timed = Instant::now();
        let windows = |receiver: &&Receiver| {
            let mut rays = 0;
            let seen = self.mirror_windows(&self.viewpoint(receiver), &mut rays);
            (!seen.is_empty(), rays)
        };
        let windows: Vec<(bool, u64)> = whole.par_iter().map(windows).collect();
        let windows_s = timed.elapsed().as_secs_f64() / whole.len().max(1) as f64;
        let timed = Instant::now();
        let hits = |receiver: &Receiver| {
            let (view, mut rays) = (self.viewpoint(receiver), 0);
            let hits = self.trace_hits(&view);
            let paths = self.mirror_paths(&view, &hits, &mut rays);
            (view, self.leaf_cells(&view, &hits), hits.cells, paths, rays)
        };
        // Receivers that no light reaches see cells that are not traced.
        let in_light = receivers.par_iter().filter(|receiver| self.is_reached(&self.viewpoint(receiver)));
        let hits: Vec<_> = in_light.map(hits).collect();
        let hits_s = timed.elapsed().as_secs_f64() / hits.len().max(1) as f64;

        let n = self.settings.hit;
        let mut reflecting = 0.0_f64;
        let mut cells = [CellSet::default(), CellSet::default()];
        for (i, (view, leaves, keys, paths, _)) in hits.iter().enumerate() {
            let weight = |texel: usize| ray_direction(texel, n, view.seed()).z * 2.0 / (n * n) as f64;
            let direct = keys.iter().enumerate().filter_map(|(t, key)| Some((t, key.as_ref()?, 1.0)));
            let in_mirrors = paths.iter().map(|p| (p.texel as usize, &p.cell, left(&p.steps, reflectors)));
            let mut share = 0.0;
            for (texel, key, left) in direct.chain(in_mirrors).filter(|light| rho(light.1) > 0.0) {
                share += weight(texel) * left * rho(key);
                if i % 4 == 0 {
                    cells[0].insert(*key);
                }
                cells[1].insert(*key);
            }
            if i % 4 == 0 {
                cells[0].extend(leaves.iter().copied());
            }
            cells[1].extend(leaves.iter().copied());
            reflecting = reflecting.max(share);
        }
        let of_windows = windows.iter().map(|w| w.1 as f64).sum::<f64>() / windows.len().max(1) as f64;
        let of_paths = hits.iter().map(|h| h.4 as f64).sum::<f64>() / hits.len().max(1) as f64;
        let counts = [cells[0].len(), cells[1].len()];
        let [_, cells] = cells.map(sorted);
        Sample {
            receivers: receivers.len(),
            all,
            rays: [
                sky as f64 / whole.len().max(1) as f64,
                (n * n) as f64,
                of_windows + of_paths,
                leaves as f64 / whole.len().max(1) as f64,
            ],
            seconds: [sky_s + hits_s, windows_s, leaves_s],
            reflecting,
            sees_mirrors: windows.iter().any(|w| w.0) || hits.iter().any(|h| !h.3.is_empty()),
            cells: counts,
            traced: self.look_at_cells(&cells),
        }
    }

    /// Traces some of the seen cells, evenly chosen.
    fn look_at_cells(&self, keys: &[CellKey]) -> TracedCells {
        let reflectors = &self.reflectors;
        let some: Vec<CellKey> = keys.iter().copied().step_by(keys.len().div_ceil(CELLS).max(1)).collect();
        if some.is_empty() {
            return TracedCells::default();
        }
        let texture = self.directions(CellKind::Probes);
        let timed = Instant::now();
        let traced = self.trace_cells(CellKind::Probes, &some, &texture);
        let probe_s = timed.elapsed().as_secs_f64() / some.len() as f64;
        let share = |(cell, _): &(Cell, Cast)| {
            let cells = Cells::new(std::slice::from_ref(cell));
            let each = each_ray(cells.hits_of(0), surround(cell.key, cell.normal, &cell.bits, &texture.centres));
            let rho = |key: &CellKey| reflectors.get(usize::from(key.material)).map_or(0.0, |r| r.diffuse);
            let direct: f64 =
                cell.seen.iter().filter_map(|(up, key)| Some(each[usize::from(*up)] * rho(key.as_ref()?))).sum();
            let path = |p: &CellPath| each[usize::from(p.up)] * left(&p.steps, reflectors) * rho(&p.cell);
            direct + cell.mirrors.paths.iter().map(path).sum::<f64>()
        };
        let reflecting = traced.iter().map(share).fold(0.0, f64::max);
        let next = sorted(traced.iter().flat_map(|(cell, _)| cell.reached()).collect());
        let next: Vec<CellKey> = next.iter().copied().step_by(next.len().div_ceil(CELLS / 4).max(1)).collect();
        let texture = self.directions(CellKind::Bounces);
        let timed = Instant::now();
        let bounces: Vec<u64> =
            self.trace_cells(CellKind::Bounces, &next, &texture).iter().map(|(_, cast)| cast.plain).collect();
        let bounce_s = timed.elapsed().as_secs_f64() / next.len().max(1) as f64;
        let count = some.len() as f64;
        TracedCells {
            rays: [
                traced.iter().map(|t| t.1.plain as f64).sum::<f64>() / count,
                bounces.iter().sum::<u64>() as f64 / bounces.len().max(1) as f64,
            ],
            mirror_rays: traced.iter().map(|t| t.1.mirror as f64).sum::<f64>() / count,
            seconds: [probe_s, bounce_s],
            reflecting,
            see_mirrors: traced.iter().any(|(cell, _)| !cell.mirrors.is_empty()),
        }
    }
}
