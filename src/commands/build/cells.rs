//! The cells of a build: fine probes and coarse bounce cells traced, put in tables, packed and compressed.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::{COMPRESSION, Job, Rays};
use crate::archive::{EncodedBlock, tables};
use crate::commands::progress::bar;
use crate::error::Result;
use crate::layers::probes::{Bounces, DOWN, MISS, Probes};
use crate::scene::cells::{CellKey, level_of};
use crate::trace::bounce::{BounceSettings, close};
use crate::trace::probe::{Directions, trace_probe};
use crate::trace::surroundings::{Seen, surroundings};

/// Probes, or bounce cells, in a block.
const PROBES_PER_BLOCK: usize = 16_384;
const BOUNCES_PER_BLOCK: usize = 8_192;

/// A traced probe: all but its key.
struct TracedProbe {
    normal: [f32; 3],
    bits: Vec<u8>,
    seen: Vec<Seen>,
    rays: u64,
}

impl Job<'_> {
    /// Probes of all keys, which are sorted, and the coarse cells that they see, directly or by further bounces.
    pub fn trace_cells(&self, keys: &[CellKey], rays: &mut Rays) -> (Probes, Bounces) {
        let (s, mesh, tracer) = (self.settings, &self.scene.mesh, self.tracer);
        let closed_level = level_of(s.closed_m);
        let texture = Directions::new(s.probe);
        let progress = bar("probes", Some(keys.len() as u64));
        let traced: Vec<TracedProbe> = keys
            .par_iter()
            .map(|&key| {
                let probe = trace_probe(key, &texture, mesh, tracer);
                let seen = surroundings(key, &probe, &texture, s.probe_hits, closed_level, mesh, tracer);
                progress.inc(1);
                let (normal, rays) = (probe.normal.as_vec3().to_array(), probe.rays + s.probe_hits as u64);
                TracedProbe { normal, bits: probe.bits, seen, rays }
            })
            .collect();
        progress.finish_and_clear();
        let progress = bar("bounces", None);
        let start: BTreeSet<CellKey> = traced.iter().flat_map(|p| &p.seen).filter_map(|seen| seen.cell).collect();
        let settings = BounceSettings { closed_level, hits: s.bounce_hits };
        let cells = close(start, &Directions::new(s.bounce_sky), settings, mesh, tracer, &|n| progress.inc(n));
        progress.finish_and_clear();
        rays.probe = traced.iter().map(|t| t.rays).sum();
        rays.bounce = cells.iter().map(|c| c.cast).sum();

        let rows: Vec<CellKey> = cells.iter().map(|c| c.key).collect();
        let probes = Probes {
            keys: keys.to_vec(),
            normals: traced.iter().map(|t| t.normal).collect(),
            hits: traced.par_iter().flat_map_iter(|t| row_numbers(&t.seen, &rows)).collect(),
            bits: traced.into_iter().flat_map(|t| t.bits).collect(),
        };
        let bounces = Bounces {
            normals: cells.iter().map(|c| c.normal.as_vec3().to_array()).collect(),
            hits: cells.par_iter().flat_map_iter(|c| row_numbers(&c.seen, &rows)).collect(),
            bits: cells.into_iter().flat_map(|c| c.bits).collect(),
            keys: rows,
        };
        (probes, bounces)
    }

    pub fn probe_blocks(&self, probes: &Probes) -> Result<Vec<EncodedBlock>> {
        let row = probes.bits.len().checked_div(probes.keys.len()).unwrap_or(0);
        let starts: Vec<usize> = (0..probes.keys.len()).step_by(PROBES_PER_BLOCK).collect();
        let block = |start: &usize| {
            let part = *start..(start + PROBES_PER_BLOCK).min(probes.keys.len());
            let keys = &probes.keys[part.clone()];
            let table = tables::Probes {
                voxel: keys.iter().map(|k| k.voxel).collect(),
                tag: keys.iter().map(tag).collect(),
                material: keys.iter().map(|k| k.material).collect(),
                normal: probes.normals[part.clone()].to_vec(),
                bits: probes.bits[part.start * row..part.end * row].to_vec(),
                hits: probes.hits[part.start * self.settings.probe_hits..part.end * self.settings.probe_hits].to_vec(),
            };
            table.encode((start / PROBES_PER_BLOCK) as u32, COMPRESSION)
        };
        starts.par_iter().map(block).collect()
    }

    pub fn bounce_blocks(&self, bounces: &Bounces) -> Result<Vec<EncodedBlock>> {
        let count = bounces.keys.len();
        let row = bounces.bits.len().checked_div(count).unwrap_or(0);
        let rays = bounces.hits.len().checked_div(count).unwrap_or(0);
        let starts: Vec<usize> = (0..count).step_by(BOUNCES_PER_BLOCK).collect();
        let block = |start: &usize| {
            let part = *start..(start + BOUNCES_PER_BLOCK).min(count);
            let keys = &bounces.keys[part.clone()];
            let table = tables::Bounce {
                voxel: keys.iter().map(|k| k.voxel).collect(),
                tag: keys.iter().map(tag).collect(),
                material: keys.iter().map(|k| k.material).collect(),
                normal: bounces.normals[part.clone()].to_vec(),
                bits: bounces.bits[part.start * row..part.end * row].to_vec(),
                hits: bounces.hits[part.start * rays..part.end * rays].to_vec(),
            };
            table.encode((start / BOUNCES_PER_BLOCK) as u32, COMPRESSION)
        };
        starts.par_iter().map(block).collect()
    }
}

/// What a cell sees as row numbers. Rays count alike, so their order means nothing: sorted, they compress.
fn row_numbers(seen: &[Seen], rows: &[CellKey]) -> Vec<u32> {
    let number = |s: &Seen| {
        // The system is closed: every cell that is seen has a row.
        let row = s.cell.and_then(|key| rows.binary_search(&key).ok()).map_or(MISS, |i| i as u32);
        if s.up { row } else { row | DOWN }
    };
    let mut numbers: Vec<u32> = seen.iter().map(number).collect();
    numbers.sort_unstable();
    numbers
}

fn tag(key: &CellKey) -> u32 {
    tables::pack_tag(key.level, key.facing)
}
