//! Second and later bounces. In: the closed system of coarse cells and their reflectances. Out:
//! each cell's radiosity per unit of irradiance from each direction of the sky.
//!
//! `X_j[t] = rho_j ( b_j[t] n_j + sum_k F_jk X_k[t] )` for every sky texel t (one 3-vector each, as
//! for the receiver's response; Goral et al. 1984 for the radiosity system). Only cells from the
//! closed level up see each other in circles. They are solved together, by a fixed number of Jacobi
//! steps. Finer cells see coarser ones only and follow once, level by level. So the result for a
//! cell depends on the cells reachable from it, not on the other cells in the table.

use std::ops::{Range, RangeInclusive};

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::hemisphere::{bit, texel_centres};
use crate::layers::canopy::Powers;
use crate::layers::cells::{Cells, DOWN, MISS};
use crate::light::canopies::{Shade, TransmittanceStates};
use crate::light::mirrors::{Chains, Lookout, left};
use crate::light::reflector::{Reflectance, Reflector};
use crate::light::scratch::Scratch;
use crate::light::scratch::ScratchSpace;
use crate::light::tables::Tables;
use crate::site::cells::{CellKey, CellMap};

/// Limit on the number of diffuse reflections; as JSON a number, or null for all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Option<u32>", try_from = "Option<u32>")]
pub enum MaxBounces {
    /// Reflections until less than [`TOLERANCE`] of the light is left.
    #[default]
    All,
    /// At most this many diffuse reflections; 1 is the model of the paper.
    Count(u32),
}

impl MaxBounces {
    /// Limits that a user may set.
    pub const COUNTS: RangeInclusive<u32> = 1..=64;
}

impl From<MaxBounces> for Option<u32> {
    fn from(bounces: MaxBounces) -> Option<u32> {
        match bounces {
            MaxBounces::All => None,
            MaxBounces::Count(count) => Some(count),
        }
    }
}

impl TryFrom<Option<u32>> for MaxBounces {
    type Error = String;

    fn try_from(count: Option<u32>) -> std::result::Result<Self, String> {
        match count {
            None => Ok(MaxBounces::All),
            Some(count) if Self::COUNTS.contains(&count) => Ok(MaxBounces::Count(count)),
            Some(count) => Err(format!("is {count}, not a number of reflections from 1 to {}", Self::COUNTS.end())),
        }
    }
}

/// Share of the reflected light that `MaxBounces::All` may leave out.
pub const TOLERANCE: f64 = 1e-3;

/// Number of columns that are solved together: small enough for a core's cache.
pub const BLOCK: usize = 32;

/// Values of one cell in the columns of a block.
pub type ColumnBlock = [f32; BLOCK];

/// Adds weight x values to `out`.
#[inline(always)]
pub fn add_block(out: &mut ColumnBlock, weight: f32, values: &ColumnBlock) {
    out.iter_mut().zip(values).for_each(|(o, x)| *o += weight * x);
}

/// Options by which the radiosity system is made and solved.
#[derive(Clone, Debug)]
pub struct RadiosityOptions {
    /// Side of the cells' sky texture.
    pub side: usize,
    /// Level from which on cells are solved together.
    pub closed_level: i8,
    /// Number of diffuse reflections that are followed.
    pub depth: MaxBounces,
}

/// Returns the reflectance of a cell. Its material must exist.
pub fn reflectance_of(reflectance: &Reflectance, key: &CellKey) -> f32 {
    reflectance[usize::from(key.material)] as f32
}

impl RadiosityOptions {
    /// Returns the number of values of one cell: `[axis][texel]`.
    pub fn width(&self) -> usize {
        3 * self.side * self.side
    }

    /// Returns true if a cell belongs to the closed system. With a bounded number of reflections
    /// every cell does, because each takes part in each step.
    pub fn closes(&self, key: &CellKey) -> bool {
        match self.depth {
            MaxBounces::All => key.level >= self.closed_level,
            MaxBounces::Count(bounces) => bounces > 1,
        }
    }

    /// Returns the number of Jacobi steps. The first reflection is that of the fine probe, the
    /// second is the source term.
    fn steps(&self, reflectance: &Reflectance) -> usize {
        match self.depth {
            MaxBounces::Count(bounces) => (bounces as usize).saturating_sub(2),
            MaxBounces::All => {
                // After k steps at most the k-th power of the largest reflectance is missing. 0.97
                // bounds the number of steps by 227; 1e-3 needs one step.
                let largest = reflectance.iter().copied().fold(0.0, f64::max).clamp(1e-3, 0.97);
                (TOLERANCE.ln() / largest.ln()).ceil() as usize
            }
        }
    }

    /// Returns the cells that cell `i` of a table sees, straight, in mirrors and as leaves, with
    /// the shares of its hemisphere that they fill.
    pub fn row(
        &self,
        cells: &Cells,
        i: usize,
        shade: &Shade,
        centres: &[[f32; 3]],
        reflectors: &[Reflector],
    ) -> Weighted<CellKey> {
        let around = surround(cells.keys[i], cells.normals[i], cells.bits_of(i), centres);
        let (above, below) = seen(cells.hits_of(i), shade.seen.as_deref());
        let scaled = |list: Weighted<u32>, share: f64| {
            list.into_iter().map(move |(cell, w)| (cells.seen[cell as usize], w * share as f32))
        };
        let mut row: Weighted<CellKey> = scaled(above, around.up).chain(scaled(below, around.down)).collect();
        let each = each_ray(cells.hits_of(i), around);
        let in_mirrors = cells.mirrors_of(i).into_iter().flat_map(|mirrors| &mirrors.paths);
        row.extend(in_mirrors.map(|p| (p.cell, (each[usize::from(p.up)] * left(&p.steps, reflectors)) as f32)));
        row.extend(&shade.leaves);
        row
    }

    /// Writes the source term of cell `i` of a table in some columns: its reflectance times its
    /// normal where it sees the sky, times the share of the sky's light that comes through
    /// canopies, plus the light that comes by mirrors.
    pub fn source(&self, cells: &Cells, i: usize, light: CellLight, columns: Range<usize>, out: &mut [f32]) {
        let CellLight { reflectance, shares, by_mirrors } = light;
        let (texels, bits) = (self.side * self.side, cells.bits_of(i));
        for (axis, n) in cells.normals[i].into_iter().enumerate() {
            let (plane, lit) = (axis * texels..(axis + 1) * texels, reflectance * n);
            let here = columns.start.max(plane.start)..columns.end.min(plane.end);
            for column in here {
                out[column - columns.start] = if bit(bits, column - plane.start) { lit } else { 0.0 };
            }
        }
        if let Some(shares) = shares {
            out.iter_mut().zip(columns.clone()).for_each(|(value, column)| *value *= shares[column % texels]);
        }
        let first = by_mirrors.partition_point(|&(column, _)| (column as usize) < columns.start);
        let here = by_mirrors[first..].iter().take_while(|&&(column, _)| (column as usize) < columns.end);
        here.for_each(|&(column, value)| out[column as usize - columns.start] += reflectance * value);
    }

    /// Returns the columns of a block.
    pub fn columns(&self, block: usize) -> Range<usize> {
        block * BLOCK..self.width().min((block + 1) * BLOCK)
    }
}

/// The closed system, solved for some states of its reflectances. The radiosity of a cell per unit
/// normal irradiance from direction s is s . X.
pub struct RadiositySolution {
    /// Sorted keys of the cells.
    keys: Vec<CellKey>,
    width: usize,
    /// `[state]`: solution.
    values: Vec<Values>,
}

/// Values of one state: `[block of columns][cell][column]`.
enum Values {
    Memory(Vec<Vec<ColumnBlock>>),
    Scratch(Box<dyn Scratch>),
}

impl RadiositySolution {
    /// Solves the system of an archive's cells for each state, with the canopies of its leafage.
    /// Values beyond `memory` bytes go to `storage`.
    pub fn solve(
        tables: &Tables,
        rules: &RadiosityOptions,
        states: &[Reflectance],
        leafages: &TransmittanceStates,
        memory: u64,
        storage: &dyn ScratchSpace,
    ) -> Result<Self> {
        let (width, source) = (rules.width(), &tables.bounces);
        let mut keys = Vec::new();
        if rules.depth != MaxBounces::Count(1) {
            source.expect(0..source.chunks());
            for chunk in 0..source.chunks() {
                keys.extend(source.chunk(chunk)?.keys.into_iter().filter(|k| rules.closes(k)));
            }
        }
        let blocks = width.div_ceil(BLOCK);
        let bytes = (states.len() * keys.len() * blocks * size_of::<ColumnBlock>()) as u64;
        // A thread that solves a block holds three buffers of its size, so only as many threads run
        // at a time as fit.
        let of_thread = 3 * (keys.len() * size_of::<ColumnBlock>()) as u64;
        let at_once = (memory / of_thread.max(1)).clamp(1, rayon::current_num_threads() as u64) as usize;
        let solve = |system: &System, state: &Reflectance| {
            let mut solved =
                if bytes <= memory { Values::Memory(Vec::new()) } else { Values::Scratch(storage.scratch()?) };
            for first in (0..blocks).step_by(at_once) {
                let some = (first..blocks.min(first + at_once)).into_par_iter();
                let some = some.map_init(Default::default, |space, block| (block, system.solve(state, block, space)));
                match &mut solved {
                    Values::Memory(values) => values.par_extend(some.map(|(_, values)| values)),
                    Values::Scratch(scratch) => some.try_for_each(|(block, values)| {
                        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
                        scratch.write(bytes.len() as u64 * block as u64, &bytes)
                    })?,
                }
            }
            Ok(solved)
        };
        let mut values: Vec<(usize, Values)> = Vec::with_capacity(states.len());
        for (leafage, powers) in leafages.powers.iter().enumerate() {
            let system = System::load(tables, rules, &keys, powers)?;
            for state in leafages.states(leafage) {
                values.push((state, solve(&system, &states[state])?));
            }
        }
        // Each state has one leafage, so each comes once.
        values.sort_unstable_by_key(|of_state| of_state.0);
        Ok(RadiositySolution { keys, width, values: values.into_iter().map(|of_state| of_state.1).collect() })
    }

    /// Returns the index of a cell.
    pub fn find(&self, key: &CellKey) -> Option<usize> {
        self.keys.binary_search(key).ok()
    }

    /// Returns the largest value of a linear combination of the states, as a share of the largest
    /// value of any state. It looks at some thousand cells only.
    pub fn combination(&self, coefficients: &[f64]) -> Result<f64> {
        let step = self.keys.len().div_ceil(4096).max(1);
        let cells: Vec<usize> = (0..self.keys.len()).step_by(step).collect();
        let of_cell = |cell: &usize| {
            let (mut sum, mut one) = (vec![0.0_f64; self.width], vec![0.0_f32; self.width]);
            let mut largest = 0.0_f64;
            for (state, coefficient) in coefficients.iter().enumerate() {
                self.read(state, *cell, &mut one)?;
                for (sum, x) in sum.iter_mut().zip(&one) {
                    *sum += coefficient * f64::from(*x);
                    largest = largest.max(f64::from(x.abs()));
                }
            }
            Ok((sum.into_iter().map(f64::abs).fold(0.0, f64::max), largest))
        };
        let each = cells.par_iter().map(of_cell).collect::<Result<Vec<(f64, f64)>>>()?;
        let (sum, largest) = each.into_iter().fold((0.0, 0.0), |a: (f64, f64), b| (a.0.max(b.0), a.1.max(b.1)));
        Ok(if largest > 0.0 { sum / largest } else { 0.0 })
    }

    /// Writes the values of one cell in a state, `[axis][texel]`, to `out`.
    fn read(&self, state: usize, cell: usize, out: &mut [f32]) -> Result<()> {
        for (block, part) in out[..self.width].chunks_mut(BLOCK).enumerate() {
            part.copy_from_slice(&self.block(state, block, cell)?[..part.len()]);
        }
        Ok(())
    }

    /// Returns the values of one cell in a state in a block of columns; values beyond the last
    /// column mean nothing.
    pub fn block(&self, state: usize, block: usize, cell: usize) -> Result<ColumnBlock> {
        match &self.values[state] {
            Values::Memory(blocks) => Ok(blocks[block][cell]),
            Values::Scratch(scratch) => {
                let mut bytes = [0; size_of::<ColumnBlock>()];
                let place = (block * self.keys.len() + cell) * bytes.len();
                scratch.read(place as u64, &mut bytes)?;
                let mut values = [0.0; BLOCK];
                for (value, bytes) in values.iter_mut().zip(bytes.as_chunks().0) {
                    *value = f32::from_le_bytes(*bytes);
                }
                Ok(values)
            }
        }
    }
}

/// The closed system in memory: about 0.3 kB a cell.
struct System<'a> {
    rules: &'a RadiosityOptions,
    /// Keys, normals and sky bits of the cells; the cells that they see are in `rows`.
    cells: Cells,
    /// `[cell][texel]`: share of the sky's light that comes through; `None` where all does.
    shares: Vec<Option<Vec<f32>>>,
    /// Starts of the cells' rows in `rows`.
    starts: Vec<usize>,
    /// Rows of all cells, one after the other: (cell, weight).
    rows: Weighted<u32>,
    /// `[cell]`: light that comes by mirrors.
    lit: Vec<MirroredLight>,
}

impl<'a> System<'a> {
    /// Reads the cells of `keys`, which are all closed cells in order. `powers` are the
    /// transmittances of the canopies before them.
    fn load(tables: &Tables, rules: &'a RadiosityOptions, keys: &[CellKey], powers: &Powers) -> Result<Self> {
        let (source, centres) = (&tables.bounces, centres_f32(rules.side));
        let (shares, rows, lit) = (Vec::new(), Vec::new(), Vec::new());
        let mut system = System { rules, cells: Cells::default(), shares, starts: vec![0], rows, lit };
        if keys.is_empty() {
            return Ok(system);
        }
        source.expect(0..source.chunks());
        for number in 0..source.chunks() {
            let chunk = source.chunk(number)?;
            let chains = Chains::of_cells(&chunk, source, &tables.mirrors, &centres)?;
            // Cells of the closed system see cells of it only.
            let place: CellMap<u32> =
                chunk.reached().filter_map(|key| Some((key, keys.binary_search(&key).ok()? as u32))).collect();
            for i in (0..chunk.keys.len()).filter(|&i| rules.closes(&chunk.keys[i])) {
                let shade = Shade::new(&chunk, i, powers, &centres);
                for (key, weight) in rules.row(&chunk, i, &shade, &centres, &tables.mirrors.reflectors) {
                    let cell = *place.get(&key).ok_or_else(|| source.missing(&key, source.block_of(&chunk.keys[i])))?;
                    system.rows.push((cell, weight));
                }
                system.lit.push(in_mirrors_lit(&chunk, i, &chains));
                system.starts.push(system.rows.len());
                system.cells.keys.push(chunk.keys[i]);
                system.cells.normals.push(chunk.normals[i]);
                system.cells.bits.extend(chunk.bits_of(i));
                system.shares.push(shade.sky);
            }
        }
        Ok(system)
    }

    /// Solves one block of columns for a state. `space` holds two buffers that serve block after
    /// block.
    fn solve(&self, state: &Reflectance, block: usize, space: &mut [Vec<ColumnBlock>; 2]) -> Vec<ColumnBlock> {
        let [source, next] = space;
        let columns = self.rules.columns(block);
        source.clear();
        source.resize(self.cells.keys.len(), [0.0_f32; BLOCK]);
        for (i, (source, key)) in source.iter_mut().zip(&self.cells.keys).enumerate() {
            let (reflectance, shares) = (reflectance_of(state, key), self.shares[i].as_deref());
            let light = CellLight { reflectance, shares, by_mirrors: &self.lit[i] };
            self.rules.source(&self.cells, i, light, columns.clone(), source);
        }
        let mut now = source.clone();
        // A step writes every value of `next`, so old ones need not be cleared.
        next.resize(source.len(), [0.0_f32; BLOCK]);
        for _ in 0..self.rules.steps(state) {
            Arch::new().dispatch(Step { system: self, state, source, now: &now, next });
            std::mem::swap(&mut now, next);
        }
        now
    }
}

/// One Jacobi step, compiled for the processor at hand; the body of a closure would not be. It
/// takes sums and products only, so its results have the same bits everywhere.
struct Step<'a> {
    system: &'a System<'a>,
    state: &'a Reflectance,
    source: &'a [ColumnBlock],
    now: &'a [ColumnBlock],
    next: &'a mut [ColumnBlock],
}

impl WithSimd for Step<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let System { cells, starts, rows, .. } = self.system;
        let of_cells = cells.keys.iter().zip(starts.windows(2));
        for ((next, source), (key, range)) in self.next.iter_mut().zip(self.source).zip(of_cells) {
            let (mut sum, reflectance_of) = (*source, reflectance_of(self.state, key));
            for &(cell, weight) in &rows[range[0]..range[1]] {
                add_block(&mut sum, weight * reflectance_of, &self.now[cell as usize]);
            }
            *next = sum;
        }
    }
}

/// The sides of a cell that light falls on: one of a surface, two of leaves, all of a volume of
/// leaves that face all ways.
#[derive(Clone, Copy, Debug)]
pub struct SidesOf(pub CellKey);

impl SidesOf {
    /// Returns the weight of light by the cosine between its direction and the normal.
    pub fn cosine(self, cosine: f32) -> f32 {
        match () {
            // The mean of half of the cosine over all normals.
            () if self.0.is_volume() => 0.25,
            () if self.0.is_leaf() => 0.5 * cosine.abs(),
            () => cosine.max(0.0),
        }
    }

    /// Returns the factor that turns a cosine other than 0 of a cell of leaves into its weight.
    pub fn factor(self, cosine: f32) -> f32 {
        match () {
            // Its normal points upwards, and so does every direction to the sky.
            () if self.0.is_volume() => 0.25 / cosine.max(f32::MIN_POSITIVE),
            () => 0.5_f32.copysign(cosine),
        }
    }

    /// Returns the cosine-weighted share of the hemisphere above the horizon, for a normal of this
    /// z.
    pub fn above(self, normal_z: f64) -> f64 {
        if self.0.is_leaf() { 0.5 } else { (1.0 + normal_z) / 2.0 }
    }

    /// Returns the cosine-weighted share of the hemisphere below the horizon, for a normal of this
    /// z.
    pub fn below(self, normal_z: f64) -> f64 {
        if self.0.is_leaf() { 0.5 } else { (1.0 - normal_z) / 2.0 }
    }
}

/// Shares of a cell's hemisphere that its two kinds of rays stand for.
#[derive(Clone, Copy, Debug)]
pub struct Surround {
    /// Cosine-weighted share of the hemisphere above the horizon that is not sky.
    pub up: f64,
    /// Cosine-weighted share of the hemisphere below the horizon.
    pub down: f64,
}

/// Returns the shares of a cell with mean normal n and n x n sky bits. The share above the horizon
/// is the rest beside the sky bits, so that sky and surroundings always add up to the whole
/// hemisphere: a white furnace stays white. For leaves it is the mean of the two hemispheres.
pub fn surround(key: CellKey, normal: [f32; 3], bits: &[u8], centres: &[[f32; 3]]) -> Surround {
    let sides = SidesOf(key);
    // A texel has 2 pi / n^2 sr, of the pi of a cosine-weighted hemisphere.
    let share = 2.0 / centres.len() as f64;
    let mut sky = 0.0;
    for (t, d) in centres.iter().enumerate() {
        if bit(bits, t) {
            sky += f64::from(sides.cosine(normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2]));
        }
    }
    let half = sides.above(f64::from(normal[2]));
    Surround { up: (half - sky * share).max(0.0), down: (1.0 - half).max(0.0) }
}

/// Returns the texel centres of an n x n texture in f32.
pub fn centres_f32(n: usize) -> Vec<[f32; 3]> {
    texel_centres(n).iter().map(|d| d.as_vec3().to_array()).collect()
}

/// Cells with their weights.
pub type Weighted<T> = Vec<(T, f32)>;

/// Columns with the light that a cell gets in them per unit of reflectance; sorted by column, some
/// columns come more than once.
pub type MirroredLight = Vec<(u32, f32)>;

/// Light of the sky on a cell: how much of it arrives and is reflected.
#[derive(Clone, Copy, Debug)]
pub struct CellLight<'a> {
    /// Reflectance of the cell's material.
    pub reflectance: f32,
    /// `[texel]`: shares of the sky's light that come through canopies; `None` if all of it does.
    pub shares: Option<&'a [f32]>,
    /// Light of the sky that mirrors send to the cell.
    pub by_mirrors: &'a MirroredLight,
}

/// Returns the share of a cell's hemisphere that each of its rays stands for: below the horizon,
/// above it.
pub fn each_ray(hits: &[u32], around: Surround) -> [f64; 2] {
    let below = hits.iter().filter(|&&h| h & DOWN != 0).count();
    let above = hits.iter().filter(|&&h| h & DOWN == 0 && h != MISS).count();
    [around.down / below.max(1) as f64, around.up / above.max(1) as f64]
}

/// Returns the light that a bounce cell gets by mirrors per unit of reflectance: column and value.
pub fn in_mirrors_lit(cells: &Cells, row: usize, chains: &Chains) -> MirroredLight {
    let mut lit: MirroredLight = Vec::new();
    for Lookout { image, shares, texels } in chains.lookouts(cells, row) {
        for t in texels.iter().map(|t| usize::from(*t)) {
            lit.extend((0..3).map(|axis| ((axis * shares.len() + t) as u32, image[axis] * shares[t])));
        }
    }
    // The sort is stable, so the values of one column are always added in the same order.
    lit.sort_by_key(|lit| lit.0);
    lit
}

/// Returns the weights of the cells that one cell sees, separately for its rays above and below the
/// horizon. Each list sums to the share of rays that met something (for the upper rays, of those
/// that met something). Lists are in the order of the first ray. `shares` gives the light that
/// comes through along each ray, if not all does.
pub fn seen(hits: &[u32], shares: Option<&[f32]>) -> (Weighted<u32>, Weighted<u32>) {
    let rays = || hits.iter().enumerate().map(|(ray, &hit)| (hit, shares.map_or(1.0, |shares| shares[ray])));
    let below: Weighted<u32> = rays().filter(|(h, _)| h & DOWN != 0).map(|(h, share)| (h & !DOWN, share)).collect();
    let above: Weighted<u32> = rays().filter(|(h, _)| h & DOWN == 0 && *h != MISS).collect();
    let merge = |rays: &[(u32, f32)]| {
        let each = 1.0 / rays.len().max(1) as f32;
        let mut merged: Weighted<u32> = Vec::with_capacity(rays.len());
        for &(cell, share) in rays.iter().filter(|(h, _)| *h != MISS) {
            let weight = each * share;
            match merged.iter_mut().find(|m| m.0 == cell) {
                Some(m) => m.1 += weight,
                None => merged.push((cell, weight)),
            }
        }
        merged
    };
    (merge(&above), merge(&below))
}
