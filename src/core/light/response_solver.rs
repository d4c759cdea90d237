//! The response texture G. In: receivers' hits, the probes they see, the bounce cells,
//! reflectances. Out: one 3-vector per sky texel and first-hit class. Diffuse light of any source
//! is s . G at the source's texel. Several states of the reflectances share all that does not
//! depend on them: visibility, and the first bounce by material.
//!
//! `G[t] = sum_p w_p rho_p ( b_p[t] n_p + indirect_p[t] )`: linear in the sources, so one texture
//! serves every sun and sky.

use std::collections::hash_map::Entry;
use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::error::Result;
use crate::hemisphere::{bilinear, bit, texel_centres};
use crate::layers::canopy::{Canopy, SEEN};
use crate::layers::cells::Cells;
use crate::layers::mirror::CellMirrors;
use crate::layers::response::{CLASSES, Response};
use crate::light::canopies::{Shade, TransmittanceStates};
use crate::light::mirrors::{Chains, Lookout, left};
use crate::light::radiosity::{
    BLOCK, CellLight, ColumnBlock, MaxBounces, MirroredLight, RadiosityOptions, RadiositySolution, Surround, Weighted,
    add_block, centres_f32, each_ray, in_mirrors_lit, reflectance_of, seen, surround,
};
use crate::light::reflector::{Reflectance, Reflector};
use crate::light::response::{Viewer, hit_weights, texel_weights};
use crate::light::scratch::ScratchSpace;
use crate::light::slots::Slots;
use crate::light::tables::Tables;
use crate::light::tile_view::TileView;
use crate::memory::{MemoryBudget, Use};
use crate::opened::{CellSource, SiteSettings};
use crate::site::cells::{CellKey, CellMap, CellSet, sort_cells};

/// Largest difference of radiosity from an interpolation with half of the nodes, as a share. The
/// error with all nodes is about its square.
const MAX_BENT: f64 = 5e-3;

/// Derives responses from an archive's cells for some states of its reflectances. Only the closed
/// system is solved as a whole. The cells near a group of tiles are read and solved when
/// [`ResponseSolver::derive`] is called for these tiles.
pub struct ResponseSolver {
    settings: SiteSettings,
    reflectors: Vec<Reflector>,
    states: Vec<Reflectance>,
    leafages: TransmittanceStates,
    slots: Slots,
    rules: RadiosityOptions,
    closed: RadiositySolution,
    /// Mean directions of the texels of the probes' sky texture.
    centres: Vec<[f32; 3]>,
    /// Mean directions of the texels of the bounce cells' sky texture.
    bounce_centres: Vec<[f32; 3]>,
    /// `[texel of G]`: the four texels of the bounce texture and their weights.
    upsample: Vec<[(usize, f64); 4]>,
    /// Bytes that the radiosities of a group of tiles may take.
    memory: u64,
}

impl ResponseSolver {
    /// Solves the closed system with the tables' reflectances. Values beyond the share of `memory`
    /// go to `storage`.
    pub fn new(tables: &Tables, depth: MaxBounces, memory: MemoryBudget, storage: &dyn ScratchSpace) -> Result<Self> {
        let stored = tables.mirrors.reflectors.iter().map(Reflector::variable).collect();
        ResponseSolver::with_states(tables, vec![stored], depth, memory, storage)
    }

    /// Solves the closed system for other values by material ([`Reflector::variable`]), one state
    /// after the other.
    pub fn with_states(
        tables: &Tables,
        mut states: Vec<Vec<f64>>,
        depth: MaxBounces,
        memory: MemoryBudget,
        storage: &dyn ScratchSpace,
    ) -> Result<Self> {
        let (settings, reflectors) = (tables.settings, tables.mirrors.reflectors.clone());
        let rules = RadiosityOptions { side: settings.bounce_sky, closed_level: settings.closed_level, depth };
        let leafages = TransmittanceStates::split(&reflectors, &mut states);
        let closed =
            RadiositySolution::solve(tables, &rules, &states, &leafages, memory.share(Use::Radiosity), storage)?;
        Ok(ResponseSolver {
            closed,
            slots: Slots::new(&states),
            states,
            leafages,
            centres: centres_f32(settings.probe),
            bounce_centres: centres_f32(settings.bounce_sky),
            upsample: texel_centres(settings.probe).into_iter().map(|d| bilinear(d, settings.bounce_sky)).collect(),
            settings,
            reflectors,
            rules,
            memory: memory.share(Use::TileGroup),
        })
    }

    /// Returns true if the states are close enough to interpolate between them, see
    /// [`States::checks`](crate::light::states::States::checks).
    pub fn interpolates(&self, checks: &[Vec<f64>]) -> Result<bool> {
        for check in checks {
            if self.closed.combination(check)? > MAX_BENT {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns the responses of all receivers of some tiles: `[tile][state][receiver]`.
    /// Neighbouring tiles share cells and so take less time.
    pub fn derive(&self, tables: &Tables, tiles: &[TileView]) -> Result<Vec<Vec<Vec<Response>>>> {
        // A group that does not fit the memory is halved; a single tile is always solved.
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
            let lights = |tile: &TileView| -> Result<Vec<Transport>> {
                let viewers = tile.viewers.par_iter().enumerate();
                viewers.map(|(index, viewer)| group.light(tables, tile, index, viewer, leafage)).collect()
            };
            let lights: Vec<Vec<Transport>> = tiles.par_iter().map(lights).collect::<Result<_>>()?;
            for state in self.leafages.states(leafage) {
                for (of_tile, responses) in group.responses(&rows, state, &lights)?.into_iter().zip(&mut responses) {
                    responses[state] = of_tile;
                }
            }
        }
        Ok(responses)
    }

    /// Reads and solves the cells that some tiles need; `None` if those of more than one tile do
    /// not fit the memory.
    fn group(&self, tables: &Tables, tiles: &[TileView]) -> Result<Option<Group<'_>>> {
        let mut keys: Vec<CellKey> = tiles.iter().flat_map(TileView::reached).collect();
        sort_cells(&mut keys);
        keys.dedup();
        let by_tiles = |key: &CellKey| {
            let tile = tiles.iter().find(|tile| tile.reached().any(|reached| reached == *key));
            tile.map_or_else(|| "hit".to_string(), |tile| tile.block_that_sees(key))
        };
        let probes = tables.probes.fetch(&keys, by_tiles)?;
        let first_only = self.rules.depth == MaxBounces::Count(1);
        let mut known = CellSet::default();
        let mut fine: Vec<Cells> = Vec::new();
        // A wave holds the cells that the wave before sees. Closed cells end it: they are solved.
        let mut wave: Vec<CellKey> = if first_only { Vec::new() } else { probes.reached().collect() };
        while !wave.is_empty() {
            wave.retain(|key| known.insert(*key) && !self.rules.closes(key));
            sort_cells(&mut wave);
            let bytes = (known.len() * self.rules.width()) as u64 * 4;
            if tiles.len() > 1 && bytes > self.memory {
                return Ok(None);
            }
            let by_cells = |key: &CellKey| match fine.last() {
                Some(cells) => tables.bounces.observer_of(cells, key),
                None => tables.probes.observer_of(&probes, key),
            };
            let cells = tables.bounces.fetch(&wave, by_cells)?;
            wave = cells.reached().collect();
            fine.push(cells);
        }
        let surrounds = (0..keys.len())
            .into_par_iter()
            .map(|i| surround(probes.keys[i], probes.normals[i], probes.bits_of(i), &self.centres))
            .collect();
        let mut keys: Vec<CellKey> = known.into_iter().collect();
        // Coarser cells come first, because finer cells follow from them.
        keys.sort_unstable_by(|a, b| b.level.cmp(&a.level).then_with(|| a.cmp(b)));
        let places = keys.iter().zip(0..).map(|(&key, i)| (key, i)).collect();
        let find = |key: &CellKey| {
            let no_cell = || tables.bounces.missing(key, seen_by(&probes, &fine, tables, key));
            self.closed.find(key).ok_or_else(no_cell)
        };
        let closed = keys.iter().take_while(|key| self.rules.closes(key)).map(find).collect::<Result<_>>()?;
        let chains = Chains::of_cells(&probes, &tables.probes, &tables.mirrors, &self.centres)?;
        let mut group = Group {
            responder: self,
            probes,
            surrounds,
            seen: Vec::new(),
            besides: CellMap::default(),
            chains,
            keys,
            places,
            closed,
            fine,
        };
        let of_probe = |key: &CellKey| if first_only { Ok(0) } else { group.place(tables, key) };
        let mut seen: Vec<usize> = group.probes.seen.iter().map(of_probe).collect::<Result<_>>()?;
        let in_mirrors = group.probes.mirrors.iter().flat_map(CellMirrors::cells);
        let mut others = in_mirrors.chain(group.probes.canopies.iter().flat_map(Canopy::cells)).peekable();
        let mut besides = CellMap::default();
        if others.peek().is_some() {
            besides = group.probes.seen.iter().copied().zip(0..).collect();
        }
        for key in others {
            if let Entry::Vacant(entry) = besides.entry(key) {
                entry.insert(seen.len());
                seen.push(of_probe(&key)?);
            }
        }
        (group.seen, group.besides) = (seen, besides);
        Ok(Some(group))
    }
}

/// Returns the name of the block of a cell, among some probes and bounce cells, that sees a given
/// bounce cell.
fn seen_by(probes: &Cells, fine: &[Cells], tables: &Tables, key: &CellKey) -> String {
    let of_source =
        |source: &CellSource, cells: &Cells| cells.observer_of(key).map(|observer| source.block_of(&observer));
    let of_fine = || fine.iter().find_map(|cells| of_source(&tables.bounces, cells));
    of_source(&tables.probes, probes).or_else(of_fine).unwrap_or_else(|| "probes".to_string())
}

/// The cells that some neighbouring tiles see.
struct Group<'r> {
    responder: &'r ResponseSolver,
    probes: Cells,
    surrounds: Vec<Surround>,
    /// Index in `keys` of each cell that probes see, then of the cells that they see only in
    /// mirrors, and of leaves.
    seen: Vec<usize>,
    /// Index in `seen` of each cell that probes see in mirrors, and of leaves; empty where there
    /// are none.
    besides: CellMap<usize>,
    /// The chains of mirrors by which probes see the sky.
    chains: Chains,
    /// Keys of the bounce cells, coarser first: closed ones, then those of `fine`.
    keys: Vec<CellKey>,
    /// `[closed cell]`: index in the closed system.
    closed: Vec<usize>,
    /// Index in `keys` of each bounce cell.
    places: CellMap<u32>,
    fine: Vec<Cells>,
}

/// A fine bounce cell: its index in the group's keys, the place of its textures, the share of the
/// sky's light that comes through, and the indices and weights of the cells that it sees.
struct Row {
    place: usize,
    part: usize,
    row: usize,
    shares: Option<Vec<f32>>,
    seen: Weighted<u32>,
    /// Light that comes by mirrors.
    lit: MirroredLight,
}

/// Light transport to a receiver, before the reflectances that vary.
struct Transport {
    /// `[slot]`: first bounces. Slot 0 holds those of fixed materials; the others hold them per
    /// unit of the slot's factor.
    first: Vec<Vec<f32>>,
    /// Weights of the bounce cells, by cell and class.
    indirect: Vec<IndirectTerm>,
}

/// Weight of a bounce cell's radiosity for a receiver, by slot; `cell` is its index in the group's
/// `seen`.
#[derive(Clone, Copy)]
struct IndirectTerm {
    cell: usize,
    class: usize,
    slot: usize,
    weight: f32,
}

/// Weight of a bounce cell's radiosity for a receiver in a state; `place` is its index in the
/// group's `keys`.
#[derive(Clone, Copy)]
struct WeightedCell {
    place: usize,
    class: usize,
    weight: f32,
}

impl Group<'_> {
    /// Returns the index of a bounce cell in `keys`.
    fn place(&self, tables: &Tables, key: &CellKey) -> Result<usize> {
        self.places
            .get(key)
            .map(|&place| place as usize)
            .ok_or_else(|| tables.bounces.missing(key, seen_by(&self.probes, &self.fine, tables, key)))
    }

    /// Returns the fine bounce cells with the canopies of a leafage, sorted by index.
    fn rows(&self, tables: &Tables, leafage: usize) -> Result<Vec<Row>> {
        let ResponseSolver { rules, leafages, bounce_centres, reflectors, .. } = self.responder;
        let mut rows: Vec<Row> = Vec::with_capacity(self.keys.len() - self.closed.len());
        for (part, cells) in self.fine.iter().enumerate() {
            let chains = Chains::of_cells(cells, &tables.bounces, &tables.mirrors, bounce_centres)?;
            let of_cell = |row: usize| {
                let shade = Shade::new(cells, row, &leafages.powers[leafage], bounce_centres);
                let weighted = rules.row(cells, row, &shade, bounce_centres, reflectors).into_iter();
                let seen = weighted.map(|(cell, w)| Ok((self.place(tables, &cell)? as u32, w)));
                let (place, seen) = (self.place(tables, &cells.keys[row])?, seen.collect::<Result<_>>()?);
                Ok(Row { place, part, row, shares: shade.sky, seen, lit: in_mirrors_lit(cells, row, &chains) })
            };
            rows.append(&mut (0..cells.keys.len()).into_par_iter().map(of_cell).collect::<Result<_>>()?);
        }
        rows.sort_unstable_by_key(|row| row.place);
        for level in rows.chunk_by(|a, b| self.keys[a.place].level == self.keys[b.place].level) {
            // A cell sees coarser ones only. Otherwise the levels could not be solved one after the
            // other.
            let first = level[0].place;
            if let Some(row) = level.iter().find(|row| row.seen.iter().any(|seen| seen.0 as usize >= first)) {
                let key = &self.keys[row.place];
                return Err(tables.bounces.defect(
                    key,
                    "cells that are seen",
                    "a seen cell is not coarser than the cell that sees it",
                ));
            }
        }
        Ok(rows)
    }

    /// Computes the radiosities in a state in a block of columns, by cell of `keys`, per unit
    /// normal irradiance. Closed cells are taken as solved, the others follow from the cells that
    /// they see, given in `rows`.
    fn solve(&self, rows: &[Row], state: usize, block: usize, values: &mut Vec<ColumnBlock>) -> Result<()> {
        let ResponseSolver { rules, closed, states, .. } = self.responder;
        values.clear();
        for &cell in &self.closed {
            values.push(closed.block(state, block, cell)?);
        }
        values.resize(self.keys.len(), [0.0; BLOCK]);
        let (state, columns) = (&states[state], rules.columns(block));
        Arch::new().dispatch(Follow { group: self, rows, state, columns, values });
        Ok(())
    }

    /// Returns the light transport to receiver `index` of a tile of the group through the canopies
    /// of a leafage.
    fn light(
        &self,
        tables: &Tables,
        tile: &TileView,
        index: usize,
        viewer: &Viewer,
        leafage: usize,
    ) -> Result<Transport> {
        let ResponseSolver { settings, slots, reflectors, rules, leafages, centres, .. } = self.responder;
        let powers = &leafages.powers[leafage];
        let per_receiver = tile.hits.texels.len() / tile.viewers.len();
        let texels = settings.probe * settings.probe;
        let shares = tile.canopies.get(index).and_then(|canopy| canopy.through(SEEN, powers));
        let texels_of = &tile.hits.texels[index * per_receiver..(index + 1) * per_receiver];
        let mut first = vec![vec![0.0_f32; Response::len(settings.probe)]; slots.len()];
        let mut indirect: Vec<IndirectTerm> = Vec::new();
        let direct = hit_weights(texels_of, viewer, shares.as_deref()).cells.into_iter().map(|(cell, weight)| {
            let key = tile.hits.palette[cell];
            (key, key.material, weight)
        });
        let paths = tile.mirrors.get(index).map_or(&[][..], |mirrors| &mirrors.paths);
        let on_texels = if paths.is_empty() { Vec::new() } else { texel_weights(texels_of, viewer) };
        // The class is that of the first surface on the path: the mirror.
        let in_mirrors = paths.iter().map(|path| {
            // Texels and materials were checked when the tile was read, and a path has at least one
            // mirror.
            let weight = on_texels[path.texel as usize] * left(&path.steps, reflectors);
            (path.cell, path.steps[0].0, weight)
        });
        let leaves = tile.canopies.get(index).map_or_else(Vec::new, |canopy| canopy.leaves(powers));
        let leaves = leaves.into_iter().map(|(key, share)| (key, key.material, f64::from(share)));
        let mut lights: Vec<(CellKey, u16, f64)> = direct.chain(in_mirrors).chain(leaves).collect();
        lights.sort_by_key(|light| (light.0, light.1));
        let same = |a: &(CellKey, u16, f64), b: &(CellKey, u16, f64)| (a.0, a.1) == (b.0, b.1);
        for lights in lights.chunk_by(same) {
            let (key, seen_first, weight) = (lights[0].0, lights[0].1, lights.iter().map(|light| light.2).sum::<f64>());
            // The group holds all cells that its tiles see.
            let no_probe = |_| tables.probes.missing(&key, tile.block_that_sees(&key));
            let probe = self.probes.keys.binary_search(&key).map_err(no_probe)?;
            let class = reflectors[usize::from(seen_first)].class.index();
            let (slot, fixed) = slots.of(key.material);
            let weight = weight * fixed;
            if weight == 0.0 {
                continue;
            }
            let scaled = |normal: [f32; 3]| normal.map(|c| c * weight as f32);
            let out = &mut first[slot][class * 3 * texels..(class + 1) * 3 * texels];
            let shade = Shade::new(&self.probes, probe, powers, centres);
            match &shade.sky {
                None => add_bits(out, self.probes.bits_of(probe), scaled(self.probes.normals[probe]), texels),
                Some(shares) => add_shares(out, self.probes.bits_of(probe), scaled(self.probes.normals[probe]), shares),
            }
            for Lookout { image, shares, texels } in self.chains.lookouts(&self.probes, probe) {
                add_texels(out, texels, scaled(image), shares);
            }
            if rules.depth != MaxBounces::Count(1) {
                let around = self.surrounds[probe];
                let (above, below) = seen(self.probes.hits_of(probe), shade.seen.as_deref());
                for (list, share) in [(above, around.up), (below, around.down)] {
                    let share = (weight * share) as f32;
                    let entry =
                        |(cell, w): (u32, f32)| IndirectTerm { cell: cell as usize, class, slot, weight: w * share };
                    indirect.extend(list.into_iter().map(entry));
                }
                let each = each_ray(self.probes.hits_of(probe), around);
                for path in self.probes.mirrors_of(probe).into_iter().flat_map(|mirrors| &mirrors.paths) {
                    let share = each[usize::from(path.up)] * left(&path.steps, reflectors) * weight;
                    // The group holds all cells that its probes see.
                    let no_cell = || tables.bounces.missing(&path.cell, tables.probes.block_of(&key));
                    let cell = *self.besides.get(&path.cell).ok_or_else(no_cell)?;
                    indirect.push(IndirectTerm { cell, class, slot, weight: share as f32 });
                }
                for (leaf, share) in &shade.leaves {
                    let no_cell = || tables.bounces.missing(leaf, tables.probes.block_of(&key));
                    let cell = *self.besides.get(leaf).ok_or_else(no_cell)?;
                    indirect.push(IndirectTerm { cell, class, slot, weight: share * weight as f32 });
                }
            }
        }
        indirect.sort_by_key(|w| (w.cell, w.class, w.slot));
        let merge = |same: &[IndirectTerm]| IndirectTerm { weight: same.iter().map(|w| w.weight).sum(), ..same[0] };
        let same = |a: &IndirectTerm, b: &IndirectTerm| (a.cell, a.class, a.slot) == (b.cell, b.class, b.slot);
        Ok(Transport { first, indirect: indirect.chunk_by(same).map(merge).collect() })
    }

    /// Returns the responses in a state: `[tile][receiver]`. It solves one block of columns at a
    /// time, so that the cells' values stay in a core's cache.
    fn responses(&self, rows: &[Row], state: usize, lights: &[Vec<Transport>]) -> Result<Vec<Vec<Response>>> {
        let ResponseSolver { rules, slots, .. } = self.responder;
        let factors = slots.factors(state);
        let flat: Vec<&Transport> = lights.iter().flatten().collect();
        let terms: Vec<Vec<WeightedCell>> =
            flat.par_iter().map(|light| self.weighted(&light.indirect, factors)).collect();
        let in_block = |values: &mut Vec<ColumnBlock>, block: usize| {
            self.solve(rows, state, block, values)?;
            Ok(terms.iter().map(|terms| Arch::new().dispatch(Gather { terms, values })).collect())
        };
        let blocks = (0..rules.width().div_ceil(BLOCK)).into_par_iter();
        let coarse: Vec<Vec<[ColumnBlock; CLASSES]>> = blocks.map_init(Vec::new, in_block).collect::<Result<_>>()?;
        let response = |(number, light): (usize, &&Transport)| self.response(light, factors, number, &coarse);
        let responses: Vec<Response> = flat.par_iter().enumerate().map(response).collect();
        let mut responses = responses.into_iter();
        Ok(lights.iter().map(|of_tile| responses.by_ref().take(of_tile.len()).collect()).collect())
    }

    /// Returns the weights of the cells that a receiver's probes see, by cell and class.
    fn weighted(&self, indirect: &[IndirectTerm], factors: &[f32]) -> Vec<WeightedCell> {
        let of_cells = indirect.chunk_by(|a, b| (a.cell, a.class) == (b.cell, b.class));
        let weighted = |of_cell: &[IndirectTerm]| WeightedCell {
            place: self.seen[of_cell[0].cell],
            class: of_cell[0].class,
            weight: of_cell.iter().map(|w| w.weight * factors[w.slot]).sum(),
        };
        of_cells.map(weighted).collect()
    }

    /// Returns the response of receiver `number` of all lights. `coarse` is the light that the
    /// probes themselves get from other surfaces, by block and receiver.
    fn response(
        &self,
        light: &Transport,
        factors: &[f32],
        number: usize,
        coarse: &[Vec<[ColumnBlock; CLASSES]>],
    ) -> Response {
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

/// Computes finer cells from the cells that they see, in a block of columns, compiled for the
/// processor as the steps of [`crate::light::radiosity`] are.
struct Follow<'a> {
    group: &'a Group<'a>,
    rows: &'a [Row],
    state: &'a Reflectance,
    columns: Range<usize>,
    values: &'a mut [ColumnBlock],
}

impl WithSimd for Follow<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Group { responder, keys, fine, .. } = self.group;
        for row in self.rows {
            // `rows` refuses cells that see any but coarser ones, and coarser ones come first.
            let (before, here) = self.values.split_at_mut(row.place);
            let (out, reflectance) = (&mut here[0], reflectance_of(self.state, &keys[row.place]));
            let light = CellLight { reflectance, shares: row.shares.as_deref(), by_mirrors: &row.lit };
            responder.rules.source(&fine[row.part], row.row, light, self.columns.clone(), out);
            for &(place, weight) in &row.seen {
                add_block(out, weight * reflectance, &before[place as usize]);
            }
        }
    }
}

/// Sums the light of the cells of one block of columns at a receiver, by class.
struct Gather<'a> {
    terms: &'a [WeightedCell],
    values: &'a [ColumnBlock],
}

impl WithSimd for Gather<'_> {
    type Output = [ColumnBlock; CLASSES];
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut coarse = [[0.0; BLOCK]; CLASSES];
        for w in self.terms {
            add_block(&mut coarse[w.class], w.weight, &self.values[w.place]);
        }
        coarse
    }
}

/// Adds normal[axis] x shares[t] to out[axis][t] for some texels t.
fn add_texels(out: &mut [f32], texels: &[u16], normal: [f32; 3], shares: &[f32]) {
    for (plane, n) in out.chunks_mut(shares.len().max(1)).zip(normal) {
        for t in texels.iter().map(|t| usize::from(*t)) {
            plane[t] += n * shares[t];
        }
    }
}

/// Adds normal[axis] to out[axis][t] where bit t is set.
fn add_bits(out: &mut [f32], bits: &[u8], normal: [f32; 3], texels: usize) {
    for (plane, n) in out.chunks_mut(texels).zip(normal) {
        for (eight, &byte) in plane.chunks_mut(8).zip(bits) {
            for (k, value) in eight.iter_mut().enumerate() {
                *value += if byte >> k & 1 == 1 { n } else { 0.0 };
            }
        }
    }
}

/// Adds normal[axis] x shares[t], the share of light that is left on its way, to out[axis][t] where
/// bit t is set.
fn add_shares(out: &mut [f32], bits: &[u8], normal: [f32; 3], shares: &[f32]) {
    for (plane, n) in out.chunks_mut(shares.len()).zip(normal) {
        for (t, (value, share)) in plane.iter_mut().zip(shares).enumerate() {
            *value += if bit(bits, t) { n * share } else { 0.0 };
        }
    }
}
