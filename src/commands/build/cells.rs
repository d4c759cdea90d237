//! The cells of a build: fine probes and coarse bounce cells traced, put in tables, packed and compressed.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::{COMPRESSION, Job, Rays};
use crate::archive::{EncodedBlock, tables};
use crate::commands::progress::bar;
use crate::error::Result;
use crate::layers::probes::{Bounces, DOWN, MISS, Probes};
use crate::scene::cells::{CellKey, level_of};
use crate::trace::bounce::{BounceSettings, BounceTrace, Seen, close};
use crate::trace::probe::trace_probe;

/// Probes, or bounce cells, in a block.
const PROBES_PER_BLOCK: usize = 16_384;
const BOUNCES_PER_BLOCK: usize = 8_192;

impl Job<'_> {
    /// Probes of all keys, which are sorted.
    pub fn trace_probes(&self, keys: &[CellKey], rays: &mut Rays) -> Probes {
        let progress = bar("probes", Some(keys.len() as u64));
        let traced: Vec<_> = keys
            .par_iter()
            .map(|&key| {
                let probe = trace_probe(key, self.settings.probe, &self.scene.mesh, self.tracer);
                progress.inc(1);
                (probe.normal.as_vec3().to_array(), probe.bits, probe.rays)
            })
            .collect();
        progress.finish_and_clear();
        rays.probe = traced.iter().map(|t| t.2).sum();
        Probes {
            keys: keys.to_vec(),
            normals: traced.iter().map(|t| t.0).collect(),
            bits: traced.into_iter().flat_map(|t| t.1).collect(),
        }
    }

    /// The coarse cells that probes lie in, and all that are reachable from them.
    pub fn trace_bounces(&self, keys: &[CellKey], rays: &mut Rays) -> Bounces {
        let tier = level_of(self.settings.tier_m);
        let start: BTreeSet<CellKey> = keys.iter().map(|k| k.coarse(tier)).collect();
        let settings = BounceSettings {
            closed_level: level_of(self.settings.closed_m),
            sky: self.settings.bounce_sky,
            hits: self.settings.bounce_hits,
        };
        let progress = bar("bounces", None);
        let cells = close(&start, settings, &self.scene.mesh, self.tracer, &|n| progress.inc(n));
        progress.finish_and_clear();
        rays.bounce = cells.iter().map(|c| c.cast).sum();
        bounce_table(&cells)
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
            };
            table.encode((start / PROBES_PER_BLOCK) as u32, COMPRESSION)
        };
        starts.par_iter().map(block).collect()
    }

    pub fn bounce_blocks(&self, bounces: &Bounces) -> Result<Vec<EncodedBlock>> {
        let count = bounces.keys.len();
        let row = bounces.bits.len().checked_div(count).unwrap_or(0);
        let rays = bounces.hits.len().checked_div(count).unwrap_or(0);
        // Cells that others see make up the closed system; the rest only gather for the probes that lie in them.
        let mut seen = vec![0_u8; count];
        for hit in bounces.hits.iter().map(|h| h & !DOWN).filter(|&cell| cell != MISS) {
            seen[hit as usize] = 1;
        }
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
                tier: seen[part.clone()].to_vec(),
            };
            table.encode((start / BOUNCES_PER_BLOCK) as u32, COMPRESSION)
        };
        starts.par_iter().map(block).collect()
    }
}

/// Columns of traced cells, sorted by key; the cells they see become row numbers.
fn bounce_table(cells: &[BounceTrace]) -> Bounces {
    let keys: Vec<CellKey> = cells.iter().map(|c| c.key).collect();
    let row = |&(up, seen): &(bool, Seen)| {
        // The system is closed: every cell that is seen has a row.
        let index = match seen {
            Seen::Cell(key) => keys.binary_search(&key).map_or(MISS, |i| i as u32),
            Seen::Nothing => MISS,
        };
        if up { index } else { index | DOWN }
    };
    let hits = cells.par_iter().flat_map_iter(|c| c.rays.iter().map(row)).collect();
    Bounces {
        normals: cells.iter().map(|c| c.normal.as_vec3().to_array()).collect(),
        bits: cells.iter().flat_map(|c| c.bits.iter().copied()).collect(),
        hits,
        keys,
    }
}

fn tag(key: &CellKey) -> u32 {
    tables::pack_tag(key.level, key.facing)
}
