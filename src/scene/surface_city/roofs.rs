//! Roofs as planes. In: cells of buildings with their heights. Out: pieces of roofs, each with a
//! plane and the cells that it covers. Cells that hang half over the edge of a building, because a
//! wall cuts them, become ground.
//!
//! Pieces grow from the cells whose surroundings are flattest (region growing, Rabbani, van den
//! Heuvel and Vosselman 2006). A neighbour joins if no step lies between, its height is within
//! [`NEAR_M`] of the plane and its own surroundings lean the same way. Pieces whose heights fit one
//! plane as well as two are joined. Small pieces and left cells go to the piece beside them that is
//! nearest in height.
//!
//! Heights in whole metres make stairs of a slope. Half a step is added to the distances then, the
//! surroundings are wider, and stairs are joined to one plane whose rounding errors they are.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use glam::DVec2;

use crate::surface_city::lattice::{Lattice, STEPS, Spot, beside};
use crate::surface_city::layers::Layers;
use crate::surface_city::plane::{Plane, Sums};
use crate::surface_city::standing::Standing;

/// Largest distance of a height from its plane, metres: three times the noise of lidar and of
/// photogrammetry on roofs (0.05 to 0.15 m).
const NEAR_M: f64 = 0.45;
/// Least cosine of the angle between a cell's surroundings and the plane that it joins (25
/// degrees).
const SAME_WAY: f64 = 0.906;
/// Root mean square of the distances of two pieces' heights from one plane, metres, up to which the
/// pieces are joined; and its largest ratio to that from their own planes.
const ONE_PLANE_M: f64 = 0.15;
const NEARLY: f64 = 1.15;
/// Root mean square of rounding errors, as a share of the step between heights (sqrt(1 / 12)), and
/// a margin.
const ROUNDED: f64 = 0.32;
/// Least slope of a plane through stairs (6 degrees): level roofs a step apart are two.
const MIN_STAIRS: f64 = 0.1;
/// Least reach of surroundings where heights are rounded, metres: two stairs of a slope of 0.4.
const REACH_ROUNDED_M: f64 = 2.0;
/// Least share of the cells of a level piece within rounding errors of two slopes, for which it is
/// their ridge.
const STAIRS_FIT: f64 = 0.9;
/// Most cells of that reach.
const MAX_REACH: f64 = 10.0;
/// Least step between heights that makes stairs, metres: smaller ones are below the noise.
const MIN_QUANTUM_M: f64 = 0.45;
/// Least area of a piece of a roof, m2, and its least number of cells.
const MIN_PIECE_M2: f64 = 4.0;
const MIN_CELLS: usize = 5;
/// Least gain in distance for which a cell changes to the plane beside it, metres, and number of
/// rounds over all cells.
const NEARER_M: f64 = 0.03;
const ROUNDS: usize = 4;

/// A piece of a roof.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoofPiece {
    /// Number of its building.
    pub building: u32,
    pub plane: Plane,
    /// Number of cells that the plane is fitted to, and root mean square of their distances from
    /// it, metres.
    cells: f64,
    off_m: f64,
}

/// Roofs of all buildings.
pub(super) struct Roofs {
    /// Number of each cell's piece, `[cell]`; `u32::MAX` for none. Cells of one piece are connected
    /// along sides.
    pub piece: Lattice<u32>,
    pub list: Vec<RoofPiece>,
}

impl Roofs {
    /// Returns true if planes were fitted through stairs of heights in steps of `quantum_m`.
    pub(super) fn have_stairs(&self, quantum_m: f64) -> bool {
        let is_one =
            |roof: &RoofPiece| roof.off_m > 0.5 * ROUNDED * quantum_m && roof.plane.slope.length() > MIN_STAIRS;
        quantum_m >= MIN_QUANTUM_M && self.list.iter().any(is_one)
    }

    /// Returns the root mean square of the distances of cells of roofs from their planes, metres.
    pub(super) fn off_m(&self) -> f64 {
        let cells: f64 = self.list.iter().map(|roof| roof.cells).sum();
        let squares: f64 = self.list.iter().map(|roof| roof.cells * roof.off_m * roof.off_m).sum();
        (squares / cells.max(1.0)).sqrt()
    }
}

/// Pieces of roofs while they grow.
struct Growing<'a> {
    layers: &'a mut Layers,
    building: &'a Lattice<u32>,
    step_m: f64,
    piece: Lattice<u32>,
    sums: Vec<Sums>,
}

/// Surroundings of a cell.
#[derive(Clone, Copy)]
struct Around {
    plane: Plane,
    off_m: f64,
}

const NONE: u32 = u32::MAX;

/// Finds the planes of roofs. Cells at the edges of buildings may become ground. Cells without a
/// height get those of their roofs.
pub(super) fn roofs(layers: &mut Layers, standing: &mut Standing, step_m: f64) -> Roofs {
    let piece = standing.building.like(NONE);
    let building = &standing.building;
    let mut growing = Growing { layers: &mut *layers, building, step_m, piece, sums: Vec::new() };
    for cells in &standing.cells {
        let first = growing.sums.len();
        growing.grow(cells);
        growing.dilate(cells);
        growing.join(cells, first);
        growing.split_stairs(cells);
        growing.close(cells);
    }
    let cells: Vec<Spot> = standing.cells.iter().flatten().copied().collect();
    growing.settle(&cells);
    let Growing { mut piece, .. } = growing;
    give_back(layers, standing, &mut piece);
    whole(layers, standing, &piece)
}

impl Growing<'_> {
    fn height(&self, spot: Spot) -> f64 {
        f64::from(self.layers.surface.at(spot))
    }

    /// Returns the step between heights, metres, if it makes stairs of slopes, or else 0.
    fn quantum_m(&self) -> f64 {
        if self.layers.quantum_m >= MIN_QUANTUM_M { self.layers.quantum_m } else { 0.0 }
    }

    fn add(&mut self, number: u32, spot: Spot) {
        self.piece.set(spot, number);
        let (place, height) = (self.layers.middle(spot), self.height(spot));
        if let Some(sums) = self.sums.get_mut(number as usize) {
            sums.push(place, height);
        }
    }

    fn plane(&self, number: u32) -> Option<Plane> {
        self.sums.get(number as usize).map(Sums::plane)
    }

    /// Returns the neighbours in the same building without a step between.
    fn near(&self, spot: Spot) -> impl Iterator<Item = Spot> + '_ {
        let (own, height) = (self.building.at(spot), self.height(spot));
        let around = STEPS.map(|step| beside(spot, step)).into_iter();
        around
            .filter(move |other| self.building.at(*other) == own && (self.height(*other) - height).abs() <= self.step_m)
    }

    fn around(&self, spot: Spot) -> Around {
        // Slopes of smaller cells are noisier, so that the surroundings are some 3 m wide.
        let mut reach = if self.layers.cell_m() < 0.75 { 2 } else { 1 };
        if self.quantum_m() > 0.0 {
            reach = reach.max((REACH_ROUNDED_M / self.layers.cell_m()).ceil().min(MAX_REACH) as i64);
        }
        let (own, height, mut sums) = (self.building.at(spot), self.height(spot), Sums::default());
        let origin = self.layers.middle(spot);
        for x in -reach..=reach {
            for y in -reach..=reach {
                let other = beside(spot, [x, y]);
                let off = self.height(other) - height;
                if self.building.at(other) == own && off.abs() <= self.step_m * reach as f64 {
                    sums.push(self.layers.middle(other) - origin, off);
                }
            }
        }
        let plane = sums.plane();
        Around { plane, off_m: sums.rms(&plane) }
    }

    /// Grows pieces over the cells of a building.
    fn grow(&mut self, cells: &[Spot]) {
        let known = cells.iter().filter(|spot| !self.height(**spot).is_nan());
        let mut seeds: Vec<(Spot, Around)> = known.map(|spot| (*spot, self.around(*spot))).collect();
        let known: BTreeMap<Spot, Around> = seeds.iter().copied().collect();
        // The sort is stable: ties stay in the order from the north-west.
        seeds.sort_by(|a, b| a.1.off_m.total_cmp(&b.1.off_m));
        let least = self.least();
        let mut tried = BTreeSet::new();
        let near_m = NEAR_M + 0.5 * self.quantum_m();
        for (seed, about) in seeds {
            if self.piece.at(seed) != NONE || tried.contains(&seed) {
                continue;
            }
            let number = self.sums.len() as u32;
            self.sums.push(Sums::default());
            self.add(number, seed);
            let mut plane = Plane { middle: self.layers.middle(seed), height: self.height(seed), ..about.plane };
            let (mut members, mut next, mut fitted) = (vec![seed], VecDeque::from([seed]), 8);
            while let Some(spot) = next.pop_front() {
                let beside: Vec<Spot> = self.near(spot).filter(|other| self.piece.at(*other) == NONE).collect();
                for other in beside {
                    let off = (self.height(other) - plane.at(self.layers.middle(other))).abs();
                    let leans = known.get(&other).is_some_and(|about| about.plane.cosine(&plane) >= SAME_WAY);
                    if off > near_m || !leans {
                        continue;
                    }
                    self.add(number, other);
                    members.push(other);
                    next.push_back(other);
                    if members.len() >= fitted {
                        plane = self.plane(number).unwrap_or(plane);
                        fitted = members.len() * 5 / 4 + 1;
                    }
                }
            }
            if members.len() < least {
                members.iter().for_each(|spot| self.piece.set(*spot, NONE));
                tried.extend(members);
                self.sums.pop();
            }
        }
    }

    fn least(&self) -> usize {
        ((MIN_PIECE_M2 / self.layers.cell_m2()).ceil() as usize).max(MIN_CELLS)
    }

    /// Gives left cells to the pieces beside them, first the cells near in height. Cells that are
    /// near to no piece make one of their own if they are enough and wide enough.
    fn dilate(&mut self, cells: &[Spot]) {
        self.spread(cells, self.step_m);
        let is_left = |spot: &Spot| self.piece.at(*spot) == NONE && !self.height(*spot).is_nan();
        let left: Vec<Spot> = cells.iter().copied().filter(is_left).collect();
        if left.is_empty() {
            return;
        }
        let flags = &self.piece;
        let own = cells.first().map(|spot| self.building.at(*spot));
        let is_left = |spot: Spot| flags.at(spot) == NONE && Some(self.building.at(spot)) == own;
        let joins = |a: Spot, b: Spot| (self.height(a) - self.height(b)).abs() <= self.step_m;
        let found = pieces_of(&left, is_left, joins);
        let least = self.least();
        let has_any = left.len() < cells.len();
        for piece in found {
            let wide = |spot: &Spot| {
                let square = [[1, 0], [0, 1], [1, 1]].map(|step| beside(*spot, step));
                square.iter().all(|other| piece.contains(other))
            };
            let is_wide = piece.len() >= least && piece.iter().any(wide);
            if is_wide || !has_any {
                let number = self.sums.len() as u32;
                self.sums.push(Sums::default());
                piece.iter().for_each(|spot| self.add(number, *spot));
            }
        }
        self.spread(cells, f64::INFINITY);
    }

    fn spread(&mut self, cells: &[Spot], most_m: f64) {
        loop {
            let mut found = Vec::new();
            for &spot in cells.iter().filter(|spot| self.piece.at(**spot) == NONE) {
                let own = self.building.at(spot);
                let others = STEPS.map(|step| beside(spot, step)).into_iter();
                let others = others.filter(|other| self.building.at(*other) == own).map(|other| self.piece.at(other));
                if let Some((number, off)) = self.nearest(spot, others)
                    && off <= most_m
                {
                    found.push((spot, number));
                }
            }
            if found.is_empty() {
                return;
            }
            // Planes stay those of the cells that fit. A round is applied as a whole, so that the
            // order of cells does not matter.
            found.into_iter().for_each(|(spot, number)| self.piece.set(spot, number));
        }
    }

    /// Returns the nearest of some pieces to a cell, and the cell's distance from its plane.
    fn nearest(&self, spot: Spot, pieces: impl Iterator<Item = u32>) -> Option<(u32, f64)> {
        let place = self.layers.middle(spot);
        let off = |number: u32| self.plane(number).map(|plane| (number, (self.height(spot) - plane.at(place)).abs()));
        pieces.filter_map(off).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Joins pieces of a building that lie in one plane.
    fn join(&mut self, cells: &[Spot], first: usize) {
        let mut of: Vec<u32> = (first as u32..self.sums.len() as u32).collect();
        let mut pairs: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for &spot in cells {
            let own = self.piece.at(spot);
            for other in self.near(spot).map(|other| self.piece.at(other)).filter(|other| *other > own) {
                *pairs.entry([own, other]).or_default() += 1;
            }
        }
        let root = |of: &[u32], mut number: u32| {
            while let Some(up) = of.get(number as usize - first).filter(|up| **up != number) {
                number = *up;
            }
            number
        };
        // All pairs are tried until nothing more joins: pieces are few.
        loop {
            let mut best: Option<(f64, u32, u32)> = None;
            for [a, b] in pairs.keys() {
                let (a, b) = (root(&of, *a), root(&of, *b));
                let (Some(one), Some(two)) = (self.sums.get(a as usize), self.sums.get(b as usize)) else { continue };
                if a == b {
                    continue;
                }
                let rms = |sums: &Sums| sums.rms(&sums.plane());
                let both = rms(&(*one + *two));
                let apart =
                    ((one.count * rms(one).powi(2) + two.count * rms(two).powi(2)) / (one.count + two.count)).sqrt();
                let is_level = (*one + *two).plane().slope.length() < MIN_STAIRS;
                let rounded = if is_level { 0.0 } else { ROUNDED * self.quantum_m() };
                let limit = ONE_PLANE_M.max(NEARLY * apart).max(rounded);
                if both <= limit && best.is_none_or(|(least, ..)| both / limit < least) {
                    best = Some((both / limit, a.min(b), a.max(b)));
                }
            }
            let Some((_, keep, gone)) = best else { break };
            let more = self.sums.get(gone as usize).copied().unwrap_or_default();
            if let Some(sums) = self.sums.get_mut(keep as usize) {
                *sums += more;
            }
            if let Some(up) = of.get_mut(gone as usize - first) {
                *up = keep;
            }
        }
        for &spot in cells {
            let own = self.piece.at(spot);
            if own != NONE {
                self.piece.set(spot, root(&of, own));
            }
        }
    }

    /// Gives level pieces on ridges to the slopes on both sides. Rounded heights make a level stair
    /// of a ridge, whose cells are within the rounding error of the lower one of two planes.
    fn split_stairs(&mut self, cells: &[Spot]) {
        let quantum_m = self.quantum_m();
        if quantum_m == 0.0 {
            return;
        }
        let mut members: BTreeMap<u32, Vec<Spot>> = BTreeMap::new();
        for spot in cells.iter().filter(|spot| self.piece.at(**spot) != NONE) {
            members.entry(self.piece.at(*spot)).or_default().push(*spot);
        }
        let is_level = |plane: &Plane| plane.slope.length() < MIN_STAIRS;
        for (number, cells) in members {
            if !self.plane(number).is_some_and(|plane| is_level(&plane)) {
                continue;
            }
            let beside: BTreeSet<u32> =
                cells.iter().flat_map(|spot| self.near(*spot)).map(|other| self.piece.at(other)).collect();
            let planes = beside.into_iter().filter_map(|number| Some((number, self.plane(number)?)));
            let slopes: Vec<(u32, Plane)> = planes.filter(|(_, plane)| !is_level(plane)).collect();
            let lowest = |place: DVec2| {
                let all = slopes.iter().map(|(number, plane)| (*number, plane.at(place)));
                all.min_by(|a, b| a.1.total_cmp(&b.1))
            };
            let most_m = (0.5 + ROUNDED) * quantum_m;
            let fits = |spot: &&Spot| {
                let found = lowest(self.layers.middle(**spot));
                found.is_some_and(|(_, height)| (self.height(**spot) - height).abs() <= most_m)
            };
            let fitting = cells.iter().filter(fits).count();
            if slopes.len() > 1 && fitting as f64 >= STAIRS_FIT * cells.len() as f64 {
                for spot in cells {
                    if let Some((slope, _)) = lowest(self.layers.middle(spot)) {
                        self.add(slope, spot);
                    }
                }
            }
        }
    }

    /// Gives cells without a height to the pieces beside them, and their heights on the planes of
    /// these. Where pieces meet, the lower plane counts: roofs fall away from their ridges.
    fn close(&mut self, cells: &[Spot]) {
        let mut open: Vec<Spot> = cells.iter().copied().filter(|spot| self.piece.at(*spot) == NONE).collect();
        while !open.is_empty() {
            let mut found = Vec::new();
            for &spot in &open {
                let place = self.layers.middle(spot);
                let near = STEPS.map(|step| self.piece.at(beside(spot, step))).into_iter();
                let heights = near.filter_map(|number| Some((number, self.plane(number)?.at(place))));
                found.extend(heights.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(number, height)| (spot, number, height)));
            }
            if found.is_empty() {
                return;
            }
            for (spot, number, height) in found {
                self.piece.set(spot, number);
                self.layers.surface.set(spot, height as f32);
            }
            open.retain(|spot| self.piece.at(*spot) == NONE);
        }
    }

    /// Moves cells between two planes to the nearer one.
    fn settle(&mut self, cells: &[Spot]) {
        let planes: Vec<Plane> = self.sums.iter().map(Sums::plane).collect();
        let off = |grown: &Self, spot: Spot, number: u32| {
            let plane = planes.get(number as usize);
            plane.map_or(f64::INFINITY, |plane| (grown.height(spot) - plane.at(grown.layers.middle(spot))).abs())
        };
        for _ in 0..ROUNDS {
            let mut changes = Vec::new();
            for &spot in cells {
                let own = self.piece.at(spot);
                let now = off(self, spot, own);
                let others: Vec<u32> = self.near(spot).map(|other| self.piece.at(other)).collect();
                let alike = others.iter().filter(|other| **other == own).count();
                for &other in others.iter().filter(|other| **other != own && **other != NONE) {
                    let joined = others.iter().filter(|number| **number == other).count();
                    let then = off(self, spot, other);
                    // A cell that neighbours of another piece surround joins them if that costs
                    // little.
                    let gain = if joined >= 3 && alike <= 1 { NEAR_M / 2.0 } else { -NEARER_M };
                    if then < now + gain && joined + 1 >= alike {
                        changes.push((spot, other));
                        break;
                    }
                }
            }
            if changes.is_empty() {
                return;
            }
            changes.into_iter().for_each(|(spot, number)| self.piece.set(spot, number));
        }
    }
}

/// Returns the connected pieces of a list of cells.
fn pieces_of(
    cells: &[Spot],
    belongs: impl Fn(Spot) -> bool,
    joins: impl Fn(Spot, Spot) -> bool,
) -> Vec<BTreeSet<Spot>> {
    let mut open: BTreeSet<Spot> = cells.iter().copied().collect();
    let mut found = Vec::new();
    while let Some(first) = open.pop_first() {
        let (mut piece, mut next) = (BTreeSet::from([first]), vec![first]);
        while let Some(spot) = next.pop() {
            for other in STEPS.map(|step| beside(spot, step)) {
                if open.contains(&other) && belongs(other) && joins(spot, other) {
                    open.remove(&other);
                    piece.insert(other);
                    next.push(other);
                }
            }
        }
        found.push(piece);
    }
    found
}

/// Returns cells at the edge of a building to the ground if they are nearer to it than to the roof:
/// a wall cuts such cells.
fn give_back(layers: &Layers, standing: &mut Standing, piece: &mut Lattice<u32>) {
    let mut sums: BTreeMap<u32, Sums> = BTreeMap::new();
    for spot in piece.spots().filter(|spot| piece.at(*spot) != NONE) {
        sums.entry(piece.at(spot)).or_default().push(layers.middle(spot), f64::from(layers.surface.at(spot)));
    }
    let planes: BTreeMap<u32, Plane> = sums.iter().map(|(number, sums)| (*number, sums.plane())).collect();
    let mut gone = Vec::new();
    for spot in standing.cells.iter().flatten().copied() {
        let around = STEPS.map(|step| beside(spot, step));
        let ground = around.iter().filter(|other| standing.building.at(**other) == NONE);
        let ground = ground.map(|other| f64::from(standing.ground.at(*other))).filter(|height| !height.is_nan());
        let Some(ground) = ground.reduce(f64::min) else { continue };
        let Some(plane) = planes.get(&piece.at(spot)) else { continue };
        let (height, roof) = (f64::from(layers.surface.at(spot)), plane.at(layers.middle(spot)));
        let is_cut = (height - roof).abs() > 2.0 * NEAR_M;
        if is_cut && height - ground < 0.5 * (roof - ground) {
            gone.push((spot, ground as f32));
        }
    }
    for (spot, height) in gone {
        let below = standing.below.as_ref().map(|below| below.at(spot));
        standing.building.set(spot, NONE);
        standing.ground.set(spot, below.unwrap_or(height));
        piece.set(spot, NONE);
    }
}

/// Numbers pieces so that each is connected; small ones go to the neighbour with which they share
/// most sides. Planes are those of the cells.
fn whole(layers: &Layers, standing: &Standing, piece: &Lattice<u32>) -> Roofs {
    let building = &standing.building;
    let joins = |piece: &Lattice<u32>, a: Spot, b: Spot| piece.at(a) == piece.at(b) && building.at(a) == building.at(b);
    let (mut numbers, found) = piece.pieces(|spot| piece.at(spot) != NONE, |a, b| joins(piece, a, b));
    for cells in found.iter().filter(|cells| cells.len() < MIN_CELLS) {
        let mut sides: BTreeMap<u32, usize> = BTreeMap::new();
        for spot in cells {
            for other in STEPS.map(|step| beside(*spot, step)) {
                let number = numbers.at(other);
                if building.at(other) == building.at(*spot) && number != NONE && number != numbers.at(*spot) {
                    *sides.entry(number).or_default() += 1;
                }
            }
        }
        if let Some((number, _)) = sides.into_iter().max_by_key(|(number, sides)| (*sides, std::cmp::Reverse(*number)))
        {
            cells.iter().for_each(|spot| numbers.set(*spot, number));
        }
    }
    let (piece, found) = numbers.pieces(|spot| numbers.at(spot) != NONE, |a, b| joins(&numbers, a, b));
    let list = found.iter().map(|cells| fitted(layers, building, cells)).collect();
    Roofs { piece, list }
}

/// Returns the plane of a piece, fitted without cells that stand out: chimneys, cells that a wall
/// cuts.
fn fitted(layers: &Layers, building: &Lattice<u32>, cells: &[Spot]) -> RoofPiece {
    let origin = cells.first().map(|spot| layers.middle(*spot)).unwrap_or_default();
    let sums_of = |takes: &dyn Fn(DVec2, f64) -> bool| {
        let mut sums = Sums::default();
        for spot in cells {
            let (place, height) = (layers.middle(*spot) - origin, f64::from(layers.surface.at(*spot)));
            if takes(place, height) {
                sums.push(place, height);
            }
        }
        sums
    };
    let mut sums = sums_of(&|_, _| true);
    let mut plane = sums.plane();
    for _ in 0..2 {
        let most = (2.5 * sums.rms(&plane)).clamp(0.1, 1.0);
        let near = sums_of(&|place, height| (height - plane.at(place)).abs() <= most);
        if 2.0 * near.count < cells.len() as f64 {
            break;
        }
        sums = near;
        plane = sums.plane();
    }
    let off_m = sums.rms(&plane);
    let building = cells.first().map_or(NONE, |spot| building.at(*spot));
    RoofPiece { building, plane: Plane { middle: plane.middle + origin, ..plane }, cells: sums.count, off_m }
}
