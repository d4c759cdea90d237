//! The response texture G. In: receivers' hits, the probes they see, the bounce cells, reflectances. Out: one 3-vector per sky
//! texel and first-hit class: diffuse light of any source is s . G at the source's texel.
//!
//! G[t] = sum_p w_p rho_p ( b_p[t] n_p + indirect_p[t] ): linear in the sources, so one texture serves every sun and sky.

use std::collections::HashSet;
use std::path::Path;

use rayon::prelude::*;

use super::bounces::{Closed, Depth, Rules, Surround, centres_f32, seen, surround};
use super::load::{Tables, TileView};
use super::response::{Reflector, Shape, Viewer, class_index, hit_weights};
use crate::error::{Error, Result};
use crate::hemisphere::{bilinear, texel_centres};
use crate::layers::cells::Cells;
use crate::layers::hit::HitTile;
use crate::layers::response::{CLASSES, Response};
use crate::scene::cells::CellKey;

/// Derives responses from an archive's cells for one set of reflectances. Only the closed system is solved as a whole; the
/// cells near some tiles are read and solved when these tiles are asked for.
pub struct Responder {
    shape: Shape,
    reflectors: Vec<Reflector>,
    rules: Rules,
    closed: Closed,
    /// Mean directions of the texels of the probes', and of the bounce cells' sky texture.
    centres: Vec<[f32; 3]>,
    bounce_centres: Vec<[f32; 3]>,
    /// For each texel of G the four texels of the bounce texture and their weights.
    upsample: Vec<[(usize, f64); 4]>,
    /// Bytes that the radiosities of a group of tiles may take.
    memory: u64,
}

impl Responder {
    /// Solves the closed system with the tables' reflectances. At most about `memory` bytes are used; what does not fit goes to a
    /// temporary file in `folder`.
    pub fn new(tables: &Tables, depth: Depth, memory: u64, folder: &Path) -> Result<Self> {
        let (shape, reflectors) = (tables.shape, tables.reflectors.clone());
        let reflectance = reflectors.iter().map(|r| r.diffuse).collect();
        let rules = Rules { side: shape.bounce_sky, closed_level: shape.closed_level, reflectance, depth };
        let memory = memory / 2;
        let closed = Closed::solve(&tables.bounces, &rules, memory, folder)?;
        Ok(Responder {
            closed,
            centres: centres_f32(shape.probe),
            bounce_centres: centres_f32(shape.bounce_sky),
            upsample: texel_centres(shape.probe).into_iter().map(|d| bilinear(d, shape.bounce_sky)).collect(),
            shape,
            reflectors,
            rules,
            memory,
        })
    }

    /// Responses of all receivers of some tiles, which had better be neighbours: [tile][receiver].
    pub fn derive(&self, tables: &Tables, tiles: &[TileView]) -> Result<Vec<Vec<Response>>> {
        let Some(group) = self.group(tables, tiles)? else {
            let (first, second) = tiles.split_at(tiles.len() / 2);
            let mut responses = self.derive(tables, first)?;
            responses.append(&mut self.derive(tables, second)?);
            return Ok(responses);
        };
        let of_tile = |tile: &TileView| -> Vec<Response> {
            let viewers = tile.viewers.par_iter().enumerate();
            viewers.map(|(index, viewer)| group.derive(&tile.hits, index, viewer)).collect()
        };
        Ok(tiles.par_iter().map(of_tile).collect())
    }

    /// Reads and solves what some tiles need; `None` if it is too much for more than one tile at a time.
    fn group(&self, tables: &Tables, tiles: &[TileView]) -> Result<Option<Group<'_>>> {
        let mut keys: Vec<CellKey> = tiles.iter().flat_map(|t| t.hits.palette.iter().copied()).collect();
        keys.sort_unstable();
        keys.dedup();
        let probes = tables.probes.fetch(&keys)?;
        let first_only = self.rules.depth == Depth::Count(1);
        let mut known: HashSet<CellKey> = HashSet::new();
        let mut fine = Vec::new();
        let mut wave: Vec<CellKey> = if first_only { Vec::new() } else { probes.seen.clone() };
        while !wave.is_empty() {
            wave.retain(|key| known.insert(*key) && !self.rules.closes(key));
            let bytes = known.len() as u64 * self.rules.width() as u64 * 4;
            if tiles.len() > 1 && bytes > self.memory {
                return Ok(None);
            }
            let cells = tables.bounces.fetch(&wave)?;
            wave.clone_from(&cells.seen);
            fine.push(cells);
        }
        let surrounds = (0..keys.len())
            .into_par_iter()
            .map(|i| surround(probes.normals[i], probes.bits_of(i), &self.centres))
            .collect();
        let missing = |key: &CellKey| tables.bounces.missing(key);
        let radiosity = self.radiosity(known, &fine, &missing)?;
        let place = |key: &CellKey| if first_only { Ok(0) } else { radiosity.find(key).ok_or_else(|| missing(key)) };
        let places = probes.seen.iter().map(place).collect::<Result<_>>()?;
        Ok(Some(Group { responder: self, probes, surrounds, radiosity, places }))
    }

    /// Radiosities of the `known` cells: closed ones as solved, then `fine` ones from those that they see, coarser first.
    fn radiosity(
        &self,
        known: HashSet<CellKey>,
        fine: &[Cells],
        missing: &(dyn Fn(&CellKey) -> Error + Sync),
    ) -> Result<Radiosity> {
        let width = self.rules.width();
        let mut keys: Vec<CellKey> = known.into_iter().collect();
        keys.sort_unstable_by(|a, b| b.level.cmp(&a.level).then_with(|| a.cmp(b)));
        let mut places: Vec<(CellKey, u32)> = keys.iter().zip(0..).map(|(&key, i)| (key, i)).collect();
        places.sort_unstable();
        let mut radiosity = Radiosity { width, places, values: vec![0.0; keys.len() * width] };
        let closed = keys.partition_point(|key| self.rules.closes(key));
        let read = |(out, key): (&mut [f32], &CellKey)| {
            let cell = self.closed.find(key).ok_or_else(|| missing(key))?;
            self.closed.read(cell, out)
        };
        radiosity.values[..closed * width].par_chunks_mut(width).zip(&keys).try_for_each(read)?;

        let mut rows: Vec<(usize, usize, usize)> = Vec::with_capacity(keys.len() - closed);
        for (part, cells) in fine.iter().enumerate() {
            for (row, key) in cells.keys.iter().enumerate() {
                rows.push((radiosity.find(key).ok_or_else(|| missing(key))?, part, row));
            }
        }
        rows.sort_unstable();
        for level in rows.chunk_by(|a, b| keys[a.0].level == keys[b.0].level) {
            let (before, here) = radiosity.values.split_at_mut(level[0].0 * width);
            let solve = |(out, &(_, part, row)): (&mut [f32], &(usize, usize, usize))| {
                let cells = &fine[part];
                self.rules.source(cells, row, 0..width, out);
                for (seen, weight) in self.rules.row(cells, row, &self.bounce_centres) {
                    let key = &cells.seen[seen as usize];
                    // A cell sees coarser ones only, or this would never end.
                    let at = find(&radiosity.places, key).filter(|at| (at + 1) * width <= before.len());
                    let from = at.ok_or_else(|| missing(key))? * width;
                    out.iter_mut().zip(&before[from..from + width]).for_each(|(o, x)| *o += weight * x);
                }
                Ok(())
            };
            here.par_chunks_mut(width).zip(level).try_for_each(solve)?;
        }
        Ok(radiosity)
    }
}

/// Radiosities of some bounce cells.
struct Radiosity {
    width: usize,
    /// Sorted by key.
    places: Vec<(CellKey, u32)>,
    /// [cell][axis][texel], per unit normal irradiance.
    values: Vec<f32>,
}

impl Radiosity {
    fn find(&self, key: &CellKey) -> Option<usize> {
        find(&self.places, key)
    }
}

fn find(places: &[(CellKey, u32)], key: &CellKey) -> Option<usize> {
    places.binary_search_by_key(key, |place| place.0).ok().map(|i| places[i].1 as usize)
}

/// Everything that some neighbouring tiles see.
struct Group<'r> {
    responder: &'r Responder,
    probes: Cells,
    surrounds: Vec<Surround>,
    radiosity: Radiosity,
    /// Where the radiosity of each cell that probes see stands.
    places: Vec<usize>,
}

impl Group<'_> {
    /// Response of receiver `index` of a tile of the group.
    fn derive(&self, tile: &HitTile, index: usize, viewer: &Viewer) -> Response {
        let shape = self.responder.shape;
        let per_receiver = shape.hit * shape.hit;
        let texels = shape.probe * shape.probe;
        let weights = hit_weights(&tile.texels[index * per_receiver..(index + 1) * per_receiver], viewer);
        let mut values = vec![0.0_f32; Response::len(shape.probe)];
        // (bounce cell, class, what its radiosity is worth to this receiver)
        let mut indirect: Vec<(u32, usize, f32)> = Vec::new();
        for (cell, weight) in weights.cells {
            let key = tile.palette[cell];
            let Some(reflector) = self.responder.reflectors.get(usize::from(key.material)) else { continue };
            // The group holds all keys of its tiles' palettes.
            let Ok(probe) = self.probes.keys.binary_search(&key) else { continue };
            let class = class_index(reflector.class);
            let worth = weight * reflector.diffuse;
            let normal = self.probes.normals[probe].map(|c| c * worth as f32);
            let out = &mut values[class * 3 * texels..(class + 1) * 3 * texels];
            add_bits(out, self.probes.bits_of(probe), normal, texels);
            if self.responder.rules.depth != Depth::Count(1) {
                let around = self.surrounds[probe];
                let (above, below) = seen(self.probes.hits_of(probe));
                for (list, share) in [(above, around.up), (below, around.down)] {
                    let share = (worth * share) as f32;
                    indirect.extend(list.into_iter().map(|(cell, w)| (cell, class, w * share)));
                }
            }
        }
        self.add_indirect(&mut values, indirect);
        Response { values }
    }

    /// Adds the light that the probes themselves get from other surfaces.
    fn add_indirect(&self, values: &mut [f32], mut worth: Vec<(u32, usize, f32)>) {
        let width = self.radiosity.width;
        let mut coarse = vec![0.0_f32; CLASSES * width];
        worth.sort_by_key(|w| (w.0, w.1));
        for group in worth.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let sum: f32 = group.iter().map(|g| g.2).sum();
            let (from, class) = (self.places[group[0].0 as usize] * width, group[0].1);
            let x = &self.radiosity.values[from..from + width];
            coarse[class * width..(class + 1) * width].iter_mut().zip(x).for_each(|(o, x)| *o += sum * x);
        }
        let upsample = &self.responder.upsample;
        for (plane, coarse) in values.chunks_mut(upsample.len()).zip(coarse.chunks(width / 3)) {
            for (value, corners) in plane.iter_mut().zip(upsample) {
                *value += corners.iter().map(|&(t, w)| coarse[t] * w as f32).sum::<f32>();
            }
        }
    }
}

/// out[axis][t] += normal[axis] where bit t is set.
fn add_bits(out: &mut [f32], bits: &[u8], normal: [f32; 3], texels: usize) {
    for (plane, n) in out.chunks_mut(texels).zip(normal) {
        for (eight, &byte) in plane.chunks_mut(8).zip(bits) {
            for (k, value) in eight.iter_mut().enumerate() {
                *value += if byte >> k & 1 == 1 { n } else { 0.0 };
            }
        }
    }
}
