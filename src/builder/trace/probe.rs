//! Probes: the sky as the surface of one cell sees it. In: a cell key. Out: one small world-frame
//! sky texture, and the points that its rays started from.
//!
//! Rays start from many points of the cell, each texel from one of them. A cell stands for what
//! others see of it, so a point counts as far as it can be seen: not at all if it is
//! [hidden](super::hidden) in a party wall or below the terrain, less if surfaces close by hide it
//! ([`NEARBY`]). (Two alternatives were tried: weights in proportion to the sky that points see,
//! and leaving out all points that see none. Both give too much light in wells and canyons, where
//! lower parts see little sky and yet are seen.)
//!
//! Fine textures are traced on a base of half their side first. The other texels are traced only
//! where neighbours differ.

use std::cell::RefCell;

use glam::{DVec2, DVec3};

use crate::trace::hidden::{LOOKS, Verdict, hidden};
use crate::trace::kernel::ray::Ray;
use crate::trace::kernel::rays::Tracer;
use crate::trace::refinement::Refinement;
use crate::trace::surface::{CellSurfaces, POINTS, SurfacePoint, sample};
use heliotile_core::hemisphere::{
    Frame, cosine_direction_of, jitter, mix, r2, ray_direction, texel_direction, texels_in_blocks, unit,
};
use heliotile_core::light::radiosity::centres_f32;
use heliotile_core::site::cells::{CellKey, size_of};

/// Jittered directions through the texels of cells' n x n sky textures. There are a few patterns,
/// made once; each cell takes one of them by its seed.
pub struct Directions {
    pub n: usize,
    /// Weighting of the points of a cell.
    weighting: PointWeights,
    /// True if one texel of four is traced first, and the others only if that does not decide them.
    refined: bool,
    /// `[texel]`: mean direction.
    pub centres: Vec<[f32; 3]>,
    patterns: Vec<Vec<DVec3>>,
    /// Texels in the order of [`texels_in_blocks`].
    places: Vec<BlockTexel>,
}

/// Texel, its block, and its place in the block.
#[derive(Clone, Copy)]
struct BlockTexel {
    texel: usize,
    block: u64,
    inside: usize,
}

/// Largest side of a texture that is traced whole; larger ones are refined. A base of 16 loses
/// features: refined probes of 32 have 1.3 times the error in a dense block, and save a twentieth
/// of the time.
///
/// Skylines were tried, too: in each of 64 azimuths the altitude of the edge, from one point of the
/// cell, by coarse rays and bisection. On four drawn sites at `standard` with `probe=32` they save
/// 30 % of all rays and no time, because their short lists of rays from many points do not fill
/// packets. The error of reflected sunlight is 1.10 to 1.26 times that of whole textures: a column
/// sees the sky of one point, a whole texture that of 16.
const LARGEST_WHOLE: usize = 32;

/// Number of jitter patterns. A receiver sees some hundred probes, so their errors average out over
/// this many.
const PATTERNS: u64 = 64;

impl Directions {
    /// Creates the directions of textures of side n.
    pub fn new(n: usize, weighting: PointWeights) -> Self {
        let direction = |pattern: u64, texel: usize| {
            let seed = mix(0x7465_7865, pattern);
            match weighting {
                // Receivers look between the texels.
                PointWeights::Open => ray_direction(texel, n, seed),
                // Bits of bounce cells are summed: middles alone would miss small openings. In a
                // court of white walls the RMSE at `standard` is 5.2 %, with middles 5.5 %.
                PointWeights::Alike => texel_direction(texel % n, texel / n, n, jitter(seed, texel as u64)),
            }
        };
        let patterns = (0..PATTERNS).map(|k| (0..n * n).map(|t| direction(k, t)).collect()).collect();
        let place = |(column, row): (usize, usize)| BlockTexel {
            texel: row * n + column,
            block: (row / 4 * n.div_ceil(4) + column / 4) as u64,
            inside: (row % 4) * 4 + column % 4,
        };
        let places = texels_in_blocks(n).map(place).collect();
        Directions { n, weighting, refined: n > LARGEST_WHOLE, centres: centres_f32(n), patterns, places }
    }

    /// Returns all texels. Neighbours in the list are neighbours on the sphere.
    pub fn texels(&self) -> impl Iterator<Item = usize> {
        self.places.iter().map(|place| place.texel)
    }

    /// Returns `[texel]`: the point from which its first ray starts. Each point gets texels in
    /// proportion to its weight, spread over the whole sky.
    fn owners(&self, key: CellKey, worth: &[f64]) -> Vec<u8> {
        let (seed, mut owner) = (key.seed(), vec![0_u8; self.n * self.n]);
        let (sum, turn) = (worth.iter().sum::<f64>(), seed as usize % POINTS);
        for place in &self.places {
            let first = (SPREAD[place.inside] + turn) % POINTS % worth.len();
            // A point gives up texels in proportion to the weight it lacks; they go to all
            // points by weight. Salts are ASCII words ("keep", "give"): each purpose has draws of
            // its own, independent of the others.
            let draw = |salt: u64| unit(mix(seed ^ salt, place.texel as u64));
            let is_kept = worth[first] >= 1.0 || draw(0x6b65_6570) < worth[first];
            // A number below POINTS, so a byte.
            owner[place.texel] = if is_kept { first } else { pick(worth, sum * draw(0x6769_7665)) } as u8;
        }
        owner
    }

    /// Returns the texels that are traced first, in the order of [`Directions::texels`]: all, or
    /// one of each 2 x 2.
    fn first(&self, key: CellKey) -> Vec<usize> {
        if !self.refined {
            return self.texels().collect();
        }
        let (seed, mut first) = (key.seed(), Vec::with_capacity(self.places.len() / 4));
        for of_block in self.places.chunk_by(|a, b| a.block == b.block) {
            let order = order(seed, of_block[0].block);
            let is_first = |place: &&BlockTexel| {
                let (row, column) = (place.inside / 4, place.inside % 4);
                let quarter = row / 2 * 2 + column / 2;
                (order >> (2 * quarter)) % 4 == (row % 2 * 2 + column % 2) as u64
            };
            first.extend(of_block.iter().filter(is_first).map(|place| place.texel));
        }
        first
    }

    /// Returns the distance within which surfaces decide how a cell's points count, as a multiple
    /// of the cell's edge.
    pub fn nearby(&self) -> f64 {
        if self.weighting == PointWeights::Open { NEARBY } else { 0.0 }
    }

    /// Returns `[texel]`: unit directions of a cell's rays, world frame.
    pub fn of(&self, key: CellKey) -> &[DVec3] {
        &self.patterns[(mix(key.seed(), 5) % PATTERNS) as usize]
    }
}

/// Smallest number of rays of a point, enough to know if it sees sky.
const MIN_RAYS: usize = 16;

/// Weighting of the points of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointWeights {
    /// Equal weights: for cells that others see from any distance.
    Alike,
    /// Weights by how far nearby surfaces leave the points open: for cells that receivers see from
    /// eight times their edge or more.
    Open,
}

/// Distance below which surfaces hide a point from those who see the cell, as a share of the cell's
/// edge. Points in crevices, such as those between terrain and a floor above it, are dark and
/// seldom seen. With equal weights one reflection in a dense block was too low by 1.7 times as much
/// at `fine`. Shares of 1 and 2 help as much there, and make courts too bright.
const NEARBY: f64 = 0.5;

/// Number of rays by which a point looks for nearby surfaces.
const NEARBY_RAYS: usize = 4;

/// Smallest weight of a point, so that a point that sees sky is never lost.
const MIN_WORTH: f64 = 1.0 / 64.0;

/// Returns `[point]`: its weight, 1 for the most open one, and the number of rays cast to find out.
fn worth_of(key: CellKey, starts: &Starts, weighting: PointWeights, tracer: &Tracer) -> (Vec<f64>, u64) {
    let count = starts.normals.len();
    if weighting == PointWeights::Alike || key.is_leaf() {
        return (vec![1.0; count], 0);
    }
    let offset = DVec2::new(unit(mix(key.seed(), 21)), unit(mix(key.seed(), 22)));
    let look = |i: usize| {
        let (point, square) = (i / NEARBY_RAYS, r2(i as f64, offset));
        starts.ray(point, Frame::new(starts.normals[point]).to_world(cosine_direction_of(square)))
    };
    let looks: Vec<Ray> = (0..count * NEARBY_RAYS).map(look).collect();
    let blocked = tracer.blocked_within(&looks, (size_of(key.level) * NEARBY) as f32);
    let open = |blocked: &[bool]| blocked.iter().filter(|&&blocked| !blocked).count();
    let open: Vec<usize> = blocked.chunks(NEARBY_RAYS).map(open).collect();
    let most = open.iter().copied().max().unwrap_or(0).max(1) as f64;
    (open.into_iter().map(|open| (open as f64 / most).max(MIN_WORTH)).collect(), looks.len() as u64)
}

/// Traced sky bits of a cell.
#[derive(Clone, Debug)]
pub struct ProbeTrace {
    /// Mean of the points' unit normals. Its length is 1 for a plane cell and less for a curved
    /// one; for leaves it is normalised.
    pub normal: DVec3,
    /// Sky bits, n x n, row-major, world frame, 8 to a byte from the lowest bit.
    pub bits: Vec<u8>,
    /// Points and the share of the cell that each stands for (sum 1).
    pub points: Vec<(SurfacePoint, f64)>,
    /// Starts of the rays.
    pub starts: Starts,
    /// `[texel]`: point from which the texel's ray was cast.
    pub owner: Vec<u8>,
    pub rays: u64,
    /// True if some points seemed hidden:
    /// [`Cell::doubtful`](heliotile_core::layers::cells::Cell::doubtful).
    pub doubtful: bool,
}

impl ProbeTrace {
    /// Creates a probe from weighted points, before anything is known of their sky.
    fn new(key: CellKey, points: Vec<SurfacePoint>, starts: Starts, worth: &[f64]) -> Self {
        let sum: f64 = worth.iter().sum();
        let points: Vec<(SurfacePoint, f64)> = points.into_iter().zip(worth.iter().map(|worth| worth / sum)).collect();
        let normal = mean_normal(key, points.iter().map(|(point, share)| point.normal * *share));
        ProbeTrace { normal, bits: Vec::new(), points, starts, owner: Vec::new(), rays: 0, doubtful: false }
    }
}

/// Starts of the rays of a cell's points: off the surface, for leaves on either side.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    /// `[point]`: unit normal.
    normals: Vec<DVec3>,
    /// `[point]`: start on the side of the normal.
    fronts: Vec<[f32; 3]>,
    /// `[point]`: start on the other side; empty except for leaves.
    backs: Vec<[f32; 3]>,
    /// True if light from all directions counts alike, as in a volume of leaves.
    all_ways: bool,
}

impl Starts {
    fn new(key: CellKey, points: &[SurfacePoint], tracer: &Tracer) -> Self {
        let backs = points.iter().filter(|_| key.is_leaf());
        // Points in a volume lie on no surface.
        let lift = |p: &SurfacePoint, side: f64| match key.is_volume() {
            true => tracer.grid().relative(p.position).as_vec3().to_array(),
            false => lifted(p.position, p.normal * side, tracer),
        };
        Starts {
            normals: points.iter().map(|p| p.normal).collect(),
            fronts: points.iter().map(|p| lift(p, 1.0)).collect(),
            backs: backs.map(|p| lift(p, -1.0)).collect(),
            all_ways: key.is_volume(),
        }
    }

    /// Returns `[point]`: unit normals.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// Returns the weight of light from a direction at a point; 0 or less if no light can come from
    /// there.
    pub fn cosine(&self, point: usize, direction: DVec3) -> f64 {
        let cosine = self.normals[point].dot(direction);
        match () {
            // As the mean of leaves of all normals.
            () if self.all_ways => 0.5,
            () if self.backs.is_empty() => cosine,
            () => cosine.abs(),
        }
    }

    /// Returns the ray of a point in a direction.
    pub fn ray(&self, point: usize, direction: DVec3) -> Ray {
        let back = self.backs.get(point).filter(|_| self.normals[point].dot(direction) < 0.0);
        Ray { origin: *back.unwrap_or(&self.fronts[point]), direction: direction.as_vec3().to_array() }
    }
}

/// Returns the weighted mean of unit normals. For leaves its length is 1, since light on either
/// side counts.
fn mean_normal(key: CellKey, normals: impl Iterator<Item = DVec3>) -> DVec3 {
    let mean: DVec3 = normals.sum();
    match () {
        () if key.is_volume() => DVec3::Z,
        () if key.is_leaf() => mean.normalize_or_zero(),
        () => mean,
    }
}

/// Returns the points of a cell for an n x n texture.
fn points_of(key: CellKey, n: usize, surfaces: CellSurfaces) -> Vec<SurfacePoint> {
    // With fewer rays per point, many points that see little sky would be checked for being hidden.
    sample(key, (n * n / MIN_RAYS).clamp(1, POINTS), surfaces)
}

/// Returns what [`trace_probe`] gives for a cell without hidden points whose sky bits are known,
/// without casting rays to the sky.
pub fn known_probe(key: CellKey, bits: Vec<u8>, texture: &Directions, surfaces: CellSurfaces) -> ProbeTrace {
    let points = points_of(key, texture.n, surfaces);
    let starts = Starts::new(key, &points, surfaces.tracer);
    let (worth, rays) = worth_of(key, &starts, texture.weighting, surfaces.tracer);
    let owner = if points.is_empty() { Vec::new() } else { texture.owners(key, &worth) };
    ProbeTrace { bits, owner, rays, ..ProbeTrace::new(key, points, starts, &worth) }
}

/// Returns all rays that [`trace_probe`] may cast to the sky for a cell without hidden points.
pub fn sky_rays<'a>(key: CellKey, probe: &'a ProbeTrace, texture: &'a Directions) -> impl Iterator<Item = Ray> + 'a {
    let directions = texture.of(key);
    let ray = |texel: usize| {
        let (point, direction) = (usize::from(probe.owner[texel]), directions[texel]);
        (probe.starts.cosine(point, direction) > 0.0).then(|| probe.starts.ray(point, direction))
    };
    let texels = texture.texels().filter(|_| !probe.points.is_empty());
    texels.filter_map(ray)
}

/// Traces the n x n sky bits of a cell. A cell without any surface (which no hit can name) has zero
/// bits and no points.
pub fn trace_probe(key: CellKey, texture: &Directions, surfaces: CellSurfaces) -> ProbeTrace {
    let (n, directions, tracer) = (texture.n, texture.of(key), surfaces.tracer);
    let points = points_of(key, n, surfaces);
    let count = points.len();
    let mut sky = SkyBits { bits: vec![0_u8; (n * n).div_ceil(8)] };
    let starts = Starts::new(key, &points, tracer);
    if count == 0 {
        return ProbeTrace { bits: sky.bits, ..ProbeTrace::new(key, points, starts, &[]) };
    }
    let seed = key.seed();
    let (mut worth, mut rays) = worth_of(key, &starts, texture.weighting, tracer);
    let mut look = Look { directions, starts: &starts, asked: ASKED.take(), cast: CAST.take() };

    // First round: every point gets its share of texels, spread over the whole sky.
    let mut owner = texture.owners(key, &worth);
    let first = texture.first(key);
    first.iter().for_each(|&texel| look.ask(texel, usize::from(owner[texel])));
    rays += look.cast.len() as u64;
    let mut open = vec![false; count];
    for (texel, point) in look.open(tracer) {
        open[point] = true;
        sky.set(texel);
    }
    let (Verdict { hidden, doubtful }, looks) = look.hidden(&open, &owner, key, texture, surfaces);
    rays += looks;

    // Second round: texels of hidden points are traced again from the other points. If any point is
    // hidden, one of the others sees sky.
    if hidden.contains(&true) {
        worth.iter_mut().zip(&hidden).filter(|(_, hidden)| **hidden).for_each(|(worth, _)| *worth = 0.0);
        let shown: f64 = worth.iter().sum();
        let lost: Vec<usize> = first.iter().copied().filter(|&texel| hidden[usize::from(owner[texel])]).collect();
        for (texel, owner) in owner.iter_mut().enumerate().filter(|(_, owner)| hidden[usize::from(**owner)]) {
            *owner = pick(&worth, shown * unit(mix(seed ^ 0x6f70_656e, texel as u64))) as u8;
        }
        lost.into_iter().for_each(|texel| look.ask(texel, usize::from(owner[texel])));
        rays += look.cast.len() as u64;
        look.open(tracer).for_each(|(texel, _)| sky.set(texel));
    }

    // Third round: the remaining texels, where those traced first do not decide them.
    if texture.refined {
        let base = Refinement::new(n, &first, &sky.bits, |texel| look.is_before(texel, usize::from(owner[texel])));
        for texel in texture.texels().filter(|&texel| !base.is_traced(texel)) {
            let point = usize::from(owner[texel]);
            match base.told(texel) {
                None => look.ask(texel, point),
                // The points of a curved cell have normals of their own, so an open direction may
                // still lie behind the surface of this texel's point.
                Some(is_open) if is_open && look.is_before(texel, point) => sky.set(texel),
                Some(_) => {}
            }
        }
        rays += look.cast.len() as u64;
        look.open(tracer).for_each(|(texel, _)| sky.set(texel));
    }
    ASKED.set(look.asked);
    CAST.set(look.cast);
    ProbeTrace { bits: sky.bits, owner, rays, doubtful, ..ProbeTrace::new(key, points, starts, &worth) }
}

/// Sky bits of a texture.
struct SkyBits {
    bits: Vec<u8>,
}

impl SkyBits {
    fn set(&mut self, texel: usize) {
        self.bits[texel / 8] |= 1 << (texel % 8);
    }
}

thread_local! {
    /// Memory of a thread for the lists of [`Look`], reused for one cell after the other.
    static ASKED: RefCell<Vec<(usize, usize)>> = RefCell::default();
    static CAST: RefCell<Vec<Ray>> = RefCell::default();
}

/// Queries for the sky behind texels from points of a cell.
struct Look<'a> {
    directions: &'a [DVec3],
    starts: &'a Starts,
    /// Texels and points of the rays to be cast.
    asked: Vec<(usize, usize)>,
    cast: Vec<Ray>,
}

impl Look<'_> {
    /// Returns true if a texel lies in front of a point's surface.
    fn is_before(&self, texel: usize, point: usize) -> bool {
        self.starts.cosine(point, self.directions[texel]) > 0.0
    }

    /// Adds a ray from a point through a texel, unless the texel lies behind the point's surface.
    fn ask(&mut self, texel: usize, point: usize) {
        if self.is_before(texel, point) {
            self.asked.push((texel, point));
            self.cast.push(self.starts.ray(point, self.directions[texel]));
        }
    }

    /// Returns the hidden points, and the number of rays cast to find out. Points are checked only
    /// if they see no sky and others see some, because only those others could take over their
    /// rays. Leaves are not checked: the inside of a crown is no solid.
    fn hidden(
        &self,
        open: &[bool],
        owner: &[u8],
        key: CellKey,
        texture: &Directions,
        surfaces: CellSurfaces,
    ) -> (Verdict, u64) {
        if key.is_leaf() || !open.contains(&true) || !open.contains(&false) {
            return (Verdict { hidden: vec![false; open.len()], doubtful: false }, 0);
        }
        // Each point has a texel in each block, so take some blocks, spread over the sky.
        let stride = (texture.n * texture.n / (POINTS * LOOKS)).max(1) as u64;
        let some = texture.places.iter().filter(|place| place.block % stride == 0);
        let asked = some.map(|place| (usize::from(owner[place.texel]), self.directions[place.texel]));
        let dark = asked.filter(|&(point, direction)| !open[point] && self.starts.cosine(point, direction) > 0.0);
        let looks: Vec<(usize, Ray)> =
            dark.map(|(point, direction)| (point, self.starts.ray(point, direction))).collect();
        (hidden(open.len(), &looks, key.is_back(), surfaces.mesh, surfaces.tracer), looks.len() as u64)
    }

    /// Casts the queued rays and returns the texels and points that see sky. The queue is empty
    /// afterwards.
    fn open(&mut self, tracer: &Tracer) -> impl Iterator<Item = (usize, usize)> {
        let met = tracer.occluded_many(&self.cast);
        self.cast.clear();
        self.asked.drain(..).zip(met).filter(|(_, met)| !met).map(|(asked, _)| asked)
    }
}

/// Returns the ray origin of a surface point (input coordinates): lifted off the surface, on the
/// grid, relative to the scene origin.
pub fn lifted(position: DVec3, normal: DVec3, tracer: &Tracer) -> [f32; 3] {
    tracer.grid().lifted(position, normal)
}

/// `[texel of a 4 x 4 block]`: the point that traces it, before all points are turned by the cell's
/// seed. Each four neighbours, across blocks too, take points that lie far apart among [`r2`]'s
/// first 16, so that a lookup between their texels averages over the whole cell. Found by annealing
/// of the variance of the light of a cell that an edge crosses; a test compares it with points in
/// random order.
const SPREAD: [usize; POINTS] = [13, 0, 15, 14, 12, 6, 5, 11, 9, 3, 4, 10, 7, 1, 2, 8];

/// Returns random bits of a block of 4 x 4 texels. Four pairs choose the texel of each 2 x 2 that
/// is traced first.
fn order(seed: u64, block: u64) -> u64 {
    mix(seed ^ 0x736c_6f74, block)
}

/// Returns the first index at which the running sum of `weights` exceeds `at`, or the last positive
/// one if rounding leaves none.
pub fn pick(weights: &[f64], at: f64) -> usize {
    let mut running = 0.0;
    for (i, w) in weights.iter().enumerate() {
        running += w;
        if running > at {
            return i;
        }
    }
    weights.iter().rposition(|&w| w > 0.0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::test_scenes::matt;
    use heliotile_core::hemisphere::bit;
    use heliotile_core::site::cells::level_of;
    use heliotile_scene::Scene;

    /// Returns a scene with a plane of 200 m and a house of 20 x 12 m, 9 m high, whose floor lies 2
    /// cm above the plane.
    fn house() -> Scene {
        let (x, y, z, low) = (20.0 * DVec3::X, 12.0 * DVec3::Y, 9.0 * DVec3::Z, DVec3::new(3.0, 0.0, 0.02));
        let ground = [DVec3::new(-100.0, -100.0, 0.0), 200.0 * DVec3::X, 200.0 * DVec3::Y];
        let walls = [[low, x, z], [low + x, y, z], [low + x + y, -x, z], [low + y, -y, z]];
        matt(&[&[ground][..], &walls[..], &[[low + z, x, y], [low, y, x]][..]].concat())
    }

    /// Edges cross a cell at random, and a lookup averages the bits of four neighbouring texels.
    /// The variance about the covered share of the cell is at most 0.8 of that of points in random
    /// order, over the 16 places of a block.
    #[test]
    fn neighbouring_texels_take_points_far_apart() {
        let number = |salt: u64, i: usize| unit(mix(salt, i as u64));
        let covered = |edge: usize, at: DVec2| {
            let (turn, through) =
                (number(1, edge) * std::f64::consts::TAU, DVec2::new(number(2, edge), number(3, edge)));
            DVec2::from_angle(turn).dot(at - through) < 0.0
        };
        let share = |edge: usize| {
            let grid = (0..32 * 32).map(|i| DVec2::new(f64::from(i % 32) + 0.5, f64::from(i / 32) + 0.5) / 32.0);
            grid.filter(|&at| covered(edge, at)).count() as f64 / 1024.0
        };
        let shares: Vec<f64> = (0..400).map(share).collect();
        let variance = |order: &[usize; POINTS]| {
            let lookup = |edge: usize, place: usize| {
                let start = DVec2::new(number(4, edge), number(5, edge));
                let around =
                    [0, 1].map(|down| [0, 1].map(|right| (place / 4 + down) % 4 * 4 + (place % 4 + right) % 4));
                let met = around.as_flattened().iter().filter(|&&texel| covered(edge, r2(order[texel] as f64, start)));
                met.count() as f64 / 4.0
            };
            let squares = (0..400).flat_map(|edge| (0..POINTS).map(move |place| (edge, place)));
            squares.map(|(edge, place)| (lookup(edge, place) - shares[edge]).powi(2)).sum::<f64>() / (400.0 * 16.0)
        };
        let random = |seed: u64| {
            let mut order: [usize; POINTS] = std::array::from_fn(|i| i);
            order.sort_by_key(|&i| mix(seed, i as u64));
            variance(&order)
        };
        let by_chance = (10..30).map(random).sum::<f64>() / 20.0;
        assert!(variance(&SPREAD) <= 0.8 * by_chance, "{} {by_chance}", variance(&SPREAD));
    }

    /// Part of a cell of ground, 8 m wide, lies below a floor 2 cm above it. With equal weights its
    /// points have more than half of the weight, with weights by openness less than 3 %. The sky
    /// bits rise accordingly.
    #[test]
    fn crevices_do_not_count() {
        let scene = house();
        let tracer = Tracer::new(&scene.mesh).expect("a tree");
        let surfaces = CellSurfaces { mesh: &scene.mesh, tracer: &tracer, canopies: None };
        let key = CellKey::new(DVec3::new(1.0, 4.0, 0.0), DVec3::Z, false, 0, level_of(8.0));
        let of = |weighting| {
            let probe = trace_probe(key, &Directions::new(32, weighting), surfaces);
            let below = probe.points.iter().filter(|(point, _)| point.position.x > 3.0).map(|(_, share)| share);
            let open = (0..32 * 32).filter(|&texel| bit(&probe.bits, texel)).count();
            (below.sum::<f64>(), open as f64 / (32.0 * 32.0))
        };
        let ((below, sky), (below_open, sky_open)) = (of(PointWeights::Alike), of(PointWeights::Open));
        assert!(below > 0.5 && below_open < 0.03, "{below} {below_open}");
        assert!((sky_open * (1.0 - below) / sky - 1.0).abs() < 0.05, "{sky} {sky_open}");
    }

    /// Probes of 64 x 64 texels of 24 cells on and around a house are traced whole and refined. At
    /// most 0.5 % of all bits differ, for less than half of the rays.
    #[test]
    fn refined_probes_are_whole_ones() {
        let scene = house();
        let tracer = Tracer::new(&scene.mesh).expect("a tree");
        let surfaces = CellSurfaces { mesh: &scene.mesh, tracer: &tracer, canopies: None };
        let refined = Directions::new(64, PointWeights::Open);
        let whole = Directions { refined: false, ..Directions::new(64, PointWeights::Open) };
        let (mut differ, mut rays) = (0, [0, 0]);
        for i in 0..24 {
            let (at, outward) = match i % 2 {
                0 => (DVec3::new(f64::from(i), -1.0 - f64::from(i % 7), 0.0), DVec3::Z),
                _ => (DVec3::new(23.0, 6.0, 0.5 + f64::from(i) / 3.0), DVec3::X),
            };
            let key = CellKey::new(at, outward, false, 0, level_of(0.5));
            let [a, b] = [&refined, &whole].map(|texture| trace_probe(key, texture, surfaces));
            differ += a.bits.iter().zip(&b.bits).map(|(a, b)| (a ^ b).count_ones()).sum::<u32>();
            rays = [rays[0] + a.rays, rays[1] + b.rays];
        }
        assert!(f64::from(differ) <= 0.005 * 24.0 * 4096.0, "{differ}");
        assert!(2 * rays[0] < rays[1], "{rays:?}");
    }
}
