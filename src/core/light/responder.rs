//! The response texture G. In: receivers' hits, the probes they see, the bounce cells, reflectances. Out: one 3-vector per sky
//! texel and first-hit class: diffuse light of any source is s . G at the source's texel. Several states of the reflectances
//! share all that does not depend on them: what is seen, and the first bounce by material.
//!
//! G[t] = sum_p w_p rho_p ( b_p[t] n_p + indirect_p[t] ): linear in the sources, so one texture serves every sun and sky.

use std::collections::hash_map::Entry;
use std::ops::Range;
use std::path::Path;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::error::Result;
use crate::hemisphere::{bilinear, bit, texel_centres};
use crate::layers::canopy::SEEN;
use crate::layers::cells::Cells;
use crate::layers::extras::MIRROR;
use crate::layers::mirror::CellMirrors;
use crate::layers::response::{CLASSES, Response};
use crate::light::bounces::{
    BLOCK, Block, Closed, Depth, Lit, Reflectance, Rules, Surround, Weighted, add_block, centres_f32, each_ray,
    in_mirrors_lit, rho, seen, surround,
};
use crate::light::canopies::{Leafages, Shade};
use crate::light::load::{Tables, TileView};
use crate::light::mirrors::{Chains, left};
use crate::light::response::{Reflector, Shape, Viewer, hit_weights, texel_weights};
use crate::light::slots::Slots;
use crate::site::cells::{CellKey, CellMap, CellSet};

/// Most by which radiosity may differ from an interpolation with half of the nodes. The error with all of them is about its square.
const MOST_BENT: f64 = 5e-3;

/// Derives responses from an archive's cells for some states of its reflectances. Only the closed system is solved as a whole; the
/// cells near some tiles are read and solved when these tiles are asked for.
pub struct Responder {
    shape: Shape,
    reflectors: Vec<Reflector>,
    states: Vec<Reflectance>,
    leafages: Leafages,
    slots: Slots,
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
        let stored = tables.reflectors.iter().map(Reflector::variable).collect();
        Responder::with_states(tables, vec![stored], depth, memory, folder)
    }

    /// Solves it for other values by material ([`Reflector::variable`]), one state after the other.
    pub fn with_states(
        tables: &Tables,
        mut states: Vec<Vec<f64>>,
        depth: Depth,
        memory: u64,
        folder: &Path,
    ) -> Result<Self> {
        let (shape, reflectors) = (tables.shape, tables.reflectors.clone());
        let rules = Rules { side: shape.bounce_sky, closed_level: shape.closed_level, depth };
        let memory = memory / 2;
        let leafages = Leafages::split(&reflectors, &mut states);
        let closed = Closed::solve(tables, &rules, &states, &leafages, memory, folder)?;
        Ok(Responder {
            closed,
            slots: Slots::new(&states),
            states,
            leafages,
            centres: centres_f32(shape.probe),
            bounce_centres: centres_f32(shape.bounce_sky),
            upsample: texel_centres(shape.probe).into_iter().map(|d| bilinear(d, shape.bounce_sky)).collect(),
            shape,
            reflectors,
            rules,
            memory,
        })
    }

    /// Whether states are close enough to be interpolated between, see [`States::checks`](crate::light::states::States::checks).
    pub fn interpolates(&self, checks: &[Vec<f64>]) -> Result<bool> {
        for check in checks {
            if self.closed.combination(check)? > MOST_BENT {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Responses of all receivers of some tiles, which had better be neighbours: [tile][state][receiver].
    pub fn derive(&self, tables: &Tables, tiles: &[TileView]) -> Result<Vec<Vec<Vec<Response>>>> {
        let Some(group) = self.group(tables, tiles)? else {
            let (first, second) = tiles.split_at(tiles.len() / 2);
            let mut responses = self.derive(tables, first)?;
            responses.append(&mut self.derive(tables, second)?);
            return Ok(responses);
        };
        let mut responses: Vec<Vec<Vec<Response>>> =
            tiles.iter().map(|_| vec![Vec::new(); self.states.len()]).collect();
        for leafage in 0..self.leafages.powers.len() {
            let rows = group.rows(tables, leafage)?;
            let lights = |tile: &TileView| -> Vec<Light> {
                let viewers = tile.viewers.par_iter().enumerate();
                viewers.map(|(index, viewer)| group.light(tile, index, viewer, leafage)).collect()
            };
            let lights: Vec<Vec<Light>> = tiles.par_iter().map(lights).collect();
            for state in self.leafages.states(leafage) {
                for (of_tile, responses) in group.responses(&rows, state, &lights)?.into_iter().zip(&mut responses) {
                    responses[state] = of_tile;
                }
            }
        }
        Ok(responses)
    }

    /// Reads and solves what some tiles need; `None` if it is too much for more than one tile at a time.
    fn group(&self, tables: &Tables, tiles: &[TileView]) -> Result<Option<Group<'_>>> {
        let mut keys: Vec<CellKey> = tiles.iter().flat_map(TileView::reached).collect();
        keys.sort_unstable();
        keys.dedup();
        let probes = tables.probes.fetch(&keys)?;
        let first_only = self.rules.depth == Depth::Count(1);
        let mut known = CellSet::default();
        let mut fine = Vec::new();
        let mut wave: Vec<CellKey> = if first_only { Vec::new() } else { probes.reached().collect() };
        while !wave.is_empty() {
            wave.retain(|key| known.insert(*key) && !self.rules.closes(key));
            wave.sort_unstable();
            let bytes = (known.len() * self.rules.width()) as u64 * 4;
            if tiles.len() > 1 && bytes > self.memory {
                return Ok(None);
            }
            let cells = tables.bounces.fetch(&wave)?;
            wave = cells.reached().collect();
            fine.push(cells);
        }
        let surrounds = (0..keys.len())
            .into_par_iter()
            .map(|i| surround(probes.normals[i], probes.bits_of(i), &self.centres))
            .collect();
        let mut keys: Vec<CellKey> = known.into_iter().collect();
        keys.sort_unstable_by(|a, b| b.level.cmp(&a.level).then_with(|| a.cmp(b)));
        let places = keys.iter().zip(0..).map(|(&key, i)| (key, i)).collect();
        let find = |key: &CellKey| self.closed.find(key).ok_or_else(|| tables.bounces.missing(key));
        let closed = keys.iter().take_while(|key| self.rules.closes(key)).map(find).collect::<Result<_>>()?;
        let chains = Chains::of_cells(&probes, tables, &self.centres);
        let mirrors: Vec<CellMirrors> = (0..probes.extras[MIRROR].len()).map(|i| probes.mirrors(i)).collect();
        let mut group = Group {
            responder: self,
            probes,
            surrounds,
            seen: Vec::new(),
            mirrored: CellMap::default(),
            mirrors,
            chains,
            keys,
            places,
            closed,
            fine,
        };
        let of_probe = |key: &CellKey| if first_only { Ok(0) } else { group.place(tables, key) };
        let mut seen: Vec<usize> = group.probes.seen.iter().map(of_probe).collect::<Result<_>>()?;
        let mut mirrored: CellMap<usize> = group.probes.seen.iter().copied().zip(0..).collect();
        if group.mirrors.is_empty() {
            mirrored.clear();
        }
        for key in group.mirrors.iter().flat_map(CellMirrors::cells) {
            if let Entry::Vacant(entry) = mirrored.entry(key) {
                entry.insert(seen.len());
                seen.push(of_probe(&key)?);
            }
        }
        (group.seen, group.mirrored) = (seen, mirrored);
        Ok(Some(group))
    }
}

/// Everything that some neighbouring tiles see.
struct Group<'r> {
    responder: &'r Responder,
    probes: Cells,
    surrounds: Vec<Surround>,
    /// Place in `keys` of each cell that probes see, then of those that they see only in mirrors.
    seen: Vec<usize>,
    /// Where in `seen` each cell stands that probes see in mirrors; empty where there are no mirrors.
    mirrored: CellMap<usize>,
    /// `[probe]`: what it sees in mirrors; empty where none sees any.
    mirrors: Vec<CellMirrors>,
    /// By which chains probes see the sky.
    chains: Chains,
    /// Bounce cells, coarser first: closed ones, then those of `fine`.
    keys: Vec<CellKey>,
    /// Where the closed ones stand in the closed system.
    closed: Vec<usize>,
    /// Their places in `keys`, by key.
    places: CellMap<u32>,
    fine: Vec<Cells>,
}

/// A fine bounce cell: its place in the group's keys, where its textures are, how much of the sky's light comes through, and the places
/// and weights of what it sees.
struct Row {
    place: usize,
    part: usize,
    row: usize,
    shares: Option<Vec<f32>>,
    seen: Weighted<u32>,
    /// By mirrors.
    lit: Lit,
}

/// What a receiver sees, before reflectances that vary.
struct Light {
    /// `[slot]`: first bounces, the fixed materials together, those that vary per unit of reflectance.
    first: Vec<Vec<f32>>,
    /// By cell and class.
    indirect: Vec<Indirect>,
}

/// What a bounce cell's radiosity is worth to a receiver; its place in the group's `seen`.
#[derive(Clone, Copy)]
struct Indirect {
    cell: usize,
    class: usize,
    slot: usize,
    worth: f32,
}

/// What a bounce cell's radiosity is worth to a receiver in a state; its place in the group's `keys`.
#[derive(Clone, Copy)]
struct Worth {
    place: usize,
    class: usize,
    worth: f32,
}

impl Group<'_> {
    /// Place of a bounce cell in `keys`.
    fn place(&self, tables: &Tables, key: &CellKey) -> Result<usize> {
        self.places.get(key).map(|&place| place as usize).ok_or_else(|| tables.bounces.missing(key))
    }

    /// The fine bounce cells behind the leaves of a leafage, by place.
    fn rows(&self, tables: &Tables, leafage: usize) -> Result<Vec<Row>> {
        let Responder { rules, leafages, bounce_centres, reflectors, .. } = self.responder;
        let mut rows: Vec<Row> = Vec::with_capacity(self.keys.len() - self.closed.len());
        for (part, cells) in self.fine.iter().enumerate() {
            let chains = Chains::of_cells(cells, tables, bounce_centres);
            let of_cell = |row: usize| {
                let shade = Shade::of(cells, row, rules.side, &leafages.powers[leafage]);
                let weighted = rules.row(cells, row, &shade, bounce_centres, reflectors).into_iter();
                let seen = weighted.map(|(cell, w)| Ok((self.place(tables, &cell)? as u32, w)));
                let (place, seen) = (self.place(tables, &cells.keys[row])?, seen.collect::<Result<_>>()?);
                Ok(Row { place, part, row, shares: shade.sky, seen, lit: in_mirrors_lit(cells, row, &chains) })
            };
            rows.append(&mut (0..cells.keys.len()).into_par_iter().map(of_cell).collect::<Result<_>>()?);
        }
        rows.sort_unstable_by_key(|row| row.place);
        for level in rows.chunk_by(|a, b| self.keys[a.place].level == self.keys[b.place].level) {
            // A cell sees coarser ones only, or this would never end.
            let first = level[0].place;
            if let Some(row) = level.iter().find(|row| row.seen.iter().any(|seen| seen.0 as usize >= first)) {
                return Err(tables.bounces.missing(&self.keys[row.place]));
            }
        }
        Ok(rows)
    }

    /// Radiosities in a state in a block of columns, by cell of `keys`, per unit normal irradiance: closed cells as solved, the others
    /// from those that they see, given in `rows`.
    fn solve(&self, rows: &[Row], state: usize, block: usize, values: &mut Vec<Block>) -> Result<()> {
        let Responder { rules, closed, states, .. } = self.responder;
        values.clear();
        for &cell in &self.closed {
            values.push(closed.block(state, block, cell)?);
        }
        values.resize(self.keys.len(), [0.0; BLOCK]);
        let (state, columns) = (&states[state], rules.columns(block));
        Arch::new().dispatch(Follow { group: self, rows, state, columns, values });
        Ok(())
    }

    /// What receiver `index` of a tile of the group sees through the leaves of a leafage.
    fn light(&self, tile: &TileView, index: usize, viewer: &Viewer, leafage: usize) -> Light {
        let Responder { shape, slots, reflectors, rules, leafages, .. } = self.responder;
        let powers = &leafages.powers[leafage];
        let per_receiver = shape.hit * shape.hit;
        let texels = shape.probe * shape.probe;
        let shares = tile.canopies.get(index).and_then(|canopy| canopy.through(SEEN, per_receiver, powers));
        let texels_of = &tile.hits.texels[index * per_receiver..(index + 1) * per_receiver];
        let mut first = vec![vec![0.0_f32; Response::len(shape.probe)]; slots.len()];
        let mut indirect: Vec<Indirect> = Vec::new();
        let direct = hit_weights(texels_of, viewer, shares.as_deref()).cells.into_iter().map(|(cell, weight)| {
            let key = tile.hits.palette[cell];
            (key, key.material, weight)
        });
        let paths = tile.mirrored.get(index).map_or(&[][..], Vec::as_slice);
        let on_texels = if paths.is_empty() { Vec::new() } else { texel_weights(texels_of, viewer) };
        // The class is that of what is seen first: the mirror.
        let in_mirrors = paths.iter().filter_map(|path| {
            let weight = on_texels.get(path.texel as usize)? * left(&path.steps, reflectors);
            Some((path.cell, path.steps.first()?.0, weight))
        });
        let mut lights: Vec<(CellKey, u16, f64)> = direct.chain(in_mirrors).collect();
        lights.sort_by_key(|light| (light.0, light.1));
        let same = |a: &(CellKey, u16, f64), b: &(CellKey, u16, f64)| (a.0, a.1) == (b.0, b.1);
        for lights in lights.chunk_by(same) {
            let (key, seen_first, weight) = (lights[0].0, lights[0].1, lights.iter().map(|light| light.2).sum::<f64>());
            let Some(reflector) = reflectors.get(usize::from(seen_first)) else { continue };
            // The group holds all keys of its tiles' palettes.
            let Ok(probe) = self.probes.keys.binary_search(&key) else { continue };
            let class = reflector.class.index();
            let (slot, fixed) = slots.of(key.material);
            let worth = weight * fixed;
            if worth == 0.0 {
                continue;
            }
            let scaled = |normal: [f32; 3]| normal.map(|c| c * worth as f32);
            let out = &mut first[slot][class * 3 * texels..(class + 1) * 3 * texels];
            let shade = Shade::of(&self.probes, probe, shape.probe, powers);
            match &shade.sky {
                None => add_bits(out, self.probes.bits_of(probe), scaled(self.probes.normals[probe]), texels),
                Some(shares) => add_shares(out, self.probes.bits_of(probe), scaled(self.probes.normals[probe]), shares),
            }
            let (windows, paths) = self.mirrors.get(probe).map_or((&[][..], &[][..]), |m| (&m.windows, &m.paths));
            for window in windows {
                if let Some((image, shares)) = self.chains.image(&window.chain, self.probes.normals[probe]) {
                    add_texels(out, &window.texels, scaled(image), shares);
                }
            }
            if rules.depth != Depth::Count(1) {
                let around = self.surrounds[probe];
                let (above, below) = seen(self.probes.hits_of(probe), shade.seen.as_deref());
                for (list, share) in [(above, around.up), (below, around.down)] {
                    let share = (worth * share) as f32;
                    let entry = |(cell, w): (u32, f32)| Indirect { cell: cell as usize, class, slot, worth: w * share };
                    indirect.extend(list.into_iter().map(entry));
                }
                let each = each_ray(self.probes.hits_of(probe), around);
                for path in paths {
                    let share = each[usize::from(path.up)] * left(&path.steps, reflectors) * worth;
                    // The group holds all that its probes see.
                    let Some(&cell) = self.mirrored.get(&path.cell) else { continue };
                    indirect.push(Indirect { cell, class, slot, worth: share as f32 });
                }
            }
        }
        indirect.sort_by_key(|w| (w.cell, w.class, w.slot));
        let merge = |same: &[Indirect]| Indirect { worth: same.iter().map(|w| w.worth).sum(), ..same[0] };
        let same = |a: &Indirect, b: &Indirect| (a.cell, a.class, a.slot) == (b.cell, b.class, b.slot);
        Light { first, indirect: indirect.chunk_by(same).map(merge).collect() }
    }

    /// Responses in a state: [tile][receiver]. A block of columns is solved at a time, so that the cells' values stay in a core's cache.
    fn responses(&self, rows: &[Row], state: usize, lights: &[Vec<Light>]) -> Result<Vec<Vec<Response>>> {
        let Responder { rules, slots, .. } = self.responder;
        let factors = slots.factors(state);
        let flat: Vec<&Light> = lights.iter().flatten().collect();
        let worth: Vec<Vec<Worth>> = flat.par_iter().map(|light| self.worth(&light.indirect, factors)).collect();
        let in_block = |values: &mut Vec<Block>, block: usize| {
            self.solve(rows, state, block, values)?;
            Ok(worth.iter().map(|worth| Arch::new().dispatch(Gather { worth, values })).collect())
        };
        let blocks = (0..rules.width().div_ceil(BLOCK)).into_par_iter();
        let coarse: Vec<Vec<[Block; CLASSES]>> = blocks.map_init(Vec::new, in_block).collect::<Result<_>>()?;
        let response = |(number, light): (usize, &&Light)| self.response(light, factors, number, &coarse);
        let responses: Vec<Response> = flat.par_iter().enumerate().map(response).collect();
        let mut responses = responses.into_iter();
        Ok(lights.iter().map(|of_tile| responses.by_ref().take(of_tile.len()).collect()).collect())
    }

    /// What the cells are worth that a receiver's probes see, by cell and class.
    fn worth(&self, indirect: &[Indirect], factors: &[f32]) -> Vec<Worth> {
        let of_cells = indirect.chunk_by(|a, b| (a.cell, a.class) == (b.cell, b.class));
        let worth = |of_cell: &[Indirect]| Worth {
            place: self.seen[of_cell[0].cell],
            class: of_cell[0].class,
            worth: of_cell.iter().map(|w| w.worth * factors[w.slot]).sum(),
        };
        of_cells.map(worth).collect()
    }

    /// The response of a receiver of a number; `coarse` is what the probes themselves get from other surfaces, by block and receiver.
    fn response(&self, light: &Light, factors: &[f32], number: usize, coarse: &[Vec<[Block; CLASSES]>]) -> Response {
        let mut slots = light.first.iter().zip(factors);
        let mut values = slots.next().map_or_else(Vec::new, |(fixed, _)| fixed.clone());
        for (slot, factor) in slots {
            values.iter_mut().zip(slot).for_each(|(value, v)| *value += factor * v);
        }
        let (upsample, width) = (&self.responder.upsample, self.responder.rules.width());
        let of_class = |class: usize| -> Vec<f32> {
            coarse.iter().flat_map(|of_block| of_block[number][class]).take(width).collect()
        };
        for (planes, coarse) in values.chunks_mut(3 * upsample.len()).zip((0..CLASSES).map(of_class)) {
            for (plane, coarse) in planes.chunks_mut(upsample.len()).zip(coarse.chunks(width / 3)) {
                for (value, corners) in plane.iter_mut().zip(upsample) {
                    *value += corners.iter().map(|&(t, w)| coarse[t] * w as f32).sum::<f32>();
                }
            }
        }
        Response { values }
    }
}

/// Finer cells from those that they see, in a block of columns, compiled as [`crate::light::bounces`] compiles its steps.
struct Follow<'a> {
    group: &'a Group<'a>,
    rows: &'a [Row],
    state: &'a Reflectance,
    columns: Range<usize>,
    values: &'a mut [Block],
}

impl WithSimd for Follow<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Group { responder, keys, fine, .. } = self.group;
        for row in self.rows {
            let (before, here) = self.values.split_at_mut(row.place);
            let (out, rho) = (&mut here[0], rho(self.state, &keys[row.place]));
            let lit = (rho, row.shares.as_deref(), &row.lit);
            responder.rules.source(&fine[row.part], row.row, lit, self.columns.clone(), out);
            for &(place, weight) in &row.seen {
                add_block(out, weight * rho, &before[place as usize]);
            }
        }
    }
}

/// What the cells of one block of columns give a receiver, by class.
struct Gather<'a> {
    worth: &'a [Worth],
    values: &'a [Block],
}

impl WithSimd for Gather<'_> {
    type Output = [Block; CLASSES];
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut coarse = [[0.0; BLOCK]; CLASSES];
        for w in self.worth {
            add_block(&mut coarse[w.class], w.worth, &self.values[w.place]);
        }
        coarse
    }
}

/// out[axis][t] += normal[axis] x shares[t] for some texels t.
fn add_texels(out: &mut [f32], texels: &[u16], normal: [f32; 3], shares: &[f32]) {
    for (plane, n) in out.chunks_mut(shares.len().max(1)).zip(normal) {
        for t in texels.iter().map(|t| usize::from(*t)) {
            if let (Some(value), Some(share)) = (plane.get_mut(t), shares.get(t)) {
                *value += n * share;
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

/// out[axis][t] += normal[axis] x the share of light that is left on its way, where bit t is set.
fn add_shares(out: &mut [f32], bits: &[u8], normal: [f32; 3], shares: &[f32]) {
    for (plane, n) in out.chunks_mut(shares.len()).zip(normal) {
        for (t, (value, share)) in plane.iter_mut().zip(shares).enumerate() {
            *value += if bit(bits, t) { n * share } else { 0.0 };
        }
    }
}
