//! Probes: what the surface of one cell sees of the sky. In: a cell key. Out: one small world-frame sky texture, and the
//! points it was traced from.
//!
//! Rays start from many points of the cell, each texel from one of them. A cell stands for what others see of it, so a point counts as far as it can
//! be seen: not at all if it is [hidden](super::hidden) in a party wall or below the terrain, less if surfaces close by hide it ([`NEARBY`]). (Weights in
//! proportion to the sky that points see were tried, and so was leaving out all that see none: too much light in wells and canyons, where lower
//! parts see little sky and yet are seen.)
//!
//! Fine textures are traced on a base of half their side first: the other texels only where neighbours differ.

use std::cell::RefCell;

use glam::{DVec2, DVec3};

use crate::trace::hidden::{LOOKS, Verdict, hidden};
use crate::trace::kernel::rays::{Ray, Tracer};
use crate::trace::refinement::Refinement;
use crate::trace::surface::{CellSurfaces, POINTS, SurfacePoint, sample};
use heliotile_core::hemisphere::{
    Frame, cosine_direction_of, jitter, mix, r2, texel_direction, texels_in_blocks, unit,
};
use heliotile_core::light::radiosity::centres_f32;
use heliotile_core::site::cells::{CellKey, size_of};

/// Jittered directions through the texels of cells' n x n sky textures: a few patterns, made once, of which each cell takes
/// one by its seed.
pub struct Directions {
    pub n: usize,
    /// How points of a cell count.
    weighting: PointWeights,
    /// Whether one texel of four is traced first, the others where that does not tell.
    refined: bool,
    /// `[texel]`: mean directions.
    pub centres: Vec<[f32; 3]>,
    patterns: Vec<Vec<DVec3>>,
    /// As [`texels_in_blocks`] lists them.
    places: Vec<Place>,
}

/// A texel, its block, and where it stands in it.
#[derive(Clone, Copy)]
struct Place {
    texel: usize,
    block: u64,
    inside: usize,
}

/// Larger textures are refined. From a base of 16 features are lost: probes of 32 are off by 1.3 times as much in a dense block then, for a
/// twentieth of the time.
const LARGEST_WHOLE: usize = 32;

/// Jitter patterns: a receiver sees some hundred probes, their errors average out over this many.
const PATTERNS: u64 = 64;

impl Directions {
    /// Textures of side n.
    pub fn new(n: usize, weighting: PointWeights) -> Self {
        let direction = |k: u64, t: usize| texel_direction(t % n, t / n, n, jitter(mix(0x7465_7865, k), t as u64));
        let patterns = (0..PATTERNS).map(|k| (0..n * n).map(|t| direction(k, t)).collect()).collect();
        let place = |(column, row): (usize, usize)| Place {
            texel: row * n + column,
            block: (row / 4 * n.div_ceil(4) + column / 4) as u64,
            inside: (row % 4) * 4 + column % 4,
        };
        let places = texels_in_blocks(n).map(place).collect();
        Directions { n, weighting, refined: n > LARGEST_WHOLE, centres: centres_f32(n), patterns, places }
    }

    /// All texels; neighbours in the list are neighbours on the sphere.
    pub fn texels(&self) -> impl Iterator<Item = usize> {
        self.places.iter().map(|place| place.texel)
    }

    /// `[texel]`: which point of a cell asks it first: each as many as it counts, spread over the whole sky.
    fn owners(&self, key: CellKey, worth: &[f64]) -> Vec<u8> {
        let (seed, mut owner) = (key.seed(), vec![0_u8; self.n * self.n]);
        let sum: f64 = worth.iter().sum();
        for of_block in self.places.chunk_by(|a, b| a.block == b.block) {
            let order = order(seed, of_block[0].block);
            for place in of_block {
                let first = slot(place.inside, order as usize % POINTS) * worth.len() / POINTS;
                // What a point does not count goes to all of them, as far as they count.
                let draw = |salt: u64| unit(mix(seed ^ salt, place.texel as u64));
                let is_kept = worth[first] >= 1.0 || draw(0x6b65_6570) < worth[first];
                // At most POINTS, so a byte.
                owner[place.texel] = if is_kept { first } else { pick(worth, sum * draw(0x6769_7665)) } as u8;
            }
        }
        owner
    }

    /// The texels that are traced first, in the order of [`Directions::texels`]: all, or one of each two by two.
    fn first(&self, key: CellKey) -> Vec<usize> {
        if !self.refined {
            return self.texels().collect();
        }
        let (seed, mut first) = (key.seed(), Vec::with_capacity(self.places.len() / 4));
        for of_block in self.places.chunk_by(|a, b| a.block == b.block) {
            let order = order(seed, of_block[0].block) >> 8;
            let is_first = |place: &&Place| {
                let (row, column) = (place.inside / 4, place.inside % 4);
                let quarter = row / 2 * 2 + column / 2;
                (order >> (2 * quarter)) % 4 == (row % 2 * 2 + column % 2) as u64
            };
            first.extend(of_block.iter().filter(is_first).map(|place| place.texel));
        }
        first
    }

    /// How far from a cell surfaces decide how its points count, over the cell's edge.
    pub fn nearby(&self) -> f64 {
        if self.weighting == PointWeights::Open { NEARBY } else { 0.0 }
    }

    /// [texel]: unit directions of a cell's rays, world frame.
    pub fn of(&self, key: CellKey) -> &[DVec3] {
        &self.patterns[(mix(key.seed(), 5) % PATTERNS) as usize]
    }
}

/// Rays of a point at least, so that it is known whether it sees sky.
const LEAST_RAYS: usize = 16;

/// How points of a cell count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointWeights {
    /// All alike: cells that others see from any distance.
    Alike,
    /// By how far surfaces nearby leave them open: cells that receivers see from eight times their edge or more.
    Open,
}

/// Surfaces nearer than this share of a cell's edge hide a point from those who see the cell. Points in crevices, such as those between terrain and
/// a floor above it, are dark and seldom seen: with all points alike one reflection in a dense block was 1.7 times as much too low at `fine`. Shares
/// of 1 and 2 help as much there, and make courts too bright.
const NEARBY: f64 = 0.5;

/// Rays by which a point looks for surfaces nearby.
const NEARBY_RAYS: usize = 4;

/// No point counts less: one that sees sky is never lost.
const LEAST_WORTH: f64 = 1.0 / 64.0;

/// `[point]`: how much the points of a cell count, 1 for the one that is open the most, and the rays that it took to find out.
fn worth_of(key: CellKey, starts: &Starts, weighting: PointWeights, tracer: &Tracer) -> (Vec<f64>, u64) {
    let count = starts.normals.len();
    if weighting == PointWeights::Alike || key.is_leaf() {
        return (vec![1.0; count], 0);
    }
    let offset = DVec2::new(unit(mix(key.seed(), 21)), unit(mix(key.seed(), 22)));
    let look = |i: usize| {
        let (point, square) = (i / NEARBY_RAYS, r2(i as f64, offset));
        starts.ray(point, Frame::of(starts.normals[point]).to_world(cosine_direction_of(square)))
    };
    let looks: Vec<Ray> = (0..count * NEARBY_RAYS).map(look).collect();
    let blocked = tracer.blocked_within(&looks, (size_of(key.level) * NEARBY) as f32);
    let open = |blocked: &[bool]| blocked.iter().filter(|&&blocked| !blocked).count();
    let open: Vec<usize> = blocked.chunks(NEARBY_RAYS).map(open).collect();
    let most = open.iter().copied().max().unwrap_or(0).max(1) as f64;
    (open.into_iter().map(|open| (open as f64 / most).max(LEAST_WORTH)).collect(), looks.len() as u64)
}

/// Sky bits of a cell.
#[derive(Clone, Debug)]
pub struct ProbeTrace {
    /// Mean of the points' unit normals, so its length is 1 for a plane cell and below for a curved one; of leaves made 1 long.
    pub normal: DVec3,
    /// n x n bits, row-major, world frame, 8 to a byte from the lowest bit.
    pub bits: Vec<u8>,
    /// Points and the share of the cell that each stands for (sum 1).
    pub points: Vec<(SurfacePoint, f64)>,
    /// Where its rays start.
    pub starts: Starts,
    /// [texel]: the point that the texel's ray was cast from.
    pub owner: Vec<u8>,
    pub rays: u64,
    /// Whether some points seemed hidden: [`Cell::doubtful`](heliotile_core::layers::cells::Cell::doubtful).
    pub doubtful: bool,
}

impl ProbeTrace {
    /// Points that count so much, before anything is known of their sky.
    fn of(key: CellKey, points: Vec<SurfacePoint>, starts: Starts, worth: &[f64]) -> Self {
        let sum: f64 = worth.iter().sum();
        let points: Vec<(SurfacePoint, f64)> = points.into_iter().zip(worth.iter().map(|worth| worth / sum)).collect();
        let normal = mean_normal(key, points.iter().map(|(point, share)| point.normal * *share));
        ProbeTrace { normal, bits: Vec::new(), points, starts, owner: Vec::new(), rays: 0, doubtful: false }
    }
}

/// Where rays of the points of a cell start: off the surface, of leaves on either side.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    /// `[point]`: unit normals.
    normals: Vec<DVec3>,
    /// `[point]`: on the side of the normal.
    fronts: Vec<[f32; 3]>,
    /// `[point]`: on the other side; none but for leaves.
    backs: Vec<[f32; 3]>,
}

impl Starts {
    fn of(key: CellKey, points: &[SurfacePoint], tracer: &Tracer) -> Self {
        let backs = points.iter().filter(|_| key.is_leaf());
        Starts {
            normals: points.iter().map(|p| p.normal).collect(),
            fronts: points.iter().map(|p| lifted(p.position, p.normal, tracer)).collect(),
            backs: backs.map(|p| lifted(p.position, -p.normal, tracer)).collect(),
        }
    }

    /// `[point]`: unit normals.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// What light from a direction weighs on a point; no more than 0 where none comes from there.
    pub fn cosine(&self, point: usize, direction: DVec3) -> f64 {
        let cosine = self.normals[point].dot(direction);
        if self.backs.is_empty() { cosine } else { cosine.abs() }
    }

    /// The ray of a point in a direction.
    pub fn ray(&self, point: usize, direction: DVec3) -> Ray {
        let back = self.backs.get(point).filter(|_| self.normals[point].dot(direction) < 0.0);
        Ray { origin: *back.unwrap_or(&self.fronts[point]), direction: direction.as_vec3().to_array() }
    }
}

/// Mean of unit normals that stand for these shares; of leaves 1 long, since light on either side counts.
fn mean_normal(key: CellKey, normals: impl Iterator<Item = DVec3>) -> DVec3 {
    let mean: DVec3 = normals.sum();
    if key.is_leaf() { mean.normalize_or_zero() } else { mean }
}

/// The points of a cell for an n x n texture.
fn points_of(key: CellKey, n: usize, surfaces: CellSurfaces) -> Vec<SurfacePoint> {
    // With fewer rays a point, many that see little sky would have to be looked at for whether they are hidden.
    sample(key, (n * n / LEAST_RAYS).clamp(1, POINTS), surfaces)
}

/// What [`trace_probe`] gives of a cell without hidden points whose sky bits are known, and no ray is cast to the sky.
pub fn known_probe(key: CellKey, bits: Vec<u8>, texture: &Directions, surfaces: CellSurfaces) -> ProbeTrace {
    let points = points_of(key, texture.n, surfaces);
    let starts = Starts::of(key, &points, surfaces.tracer);
    let (worth, rays) = worth_of(key, &starts, texture.weighting, surfaces.tracer);
    let owner = if points.is_empty() { Vec::new() } else { texture.owners(key, &worth) };
    ProbeTrace { bits, owner, rays, ..ProbeTrace::of(key, points, starts, &worth) }
}

/// All rays that [`trace_probe`] may cast to the sky for a cell without hidden points.
pub fn sky_rays<'a>(key: CellKey, probe: &'a ProbeTrace, texture: &'a Directions) -> impl Iterator<Item = Ray> + 'a {
    let directions = texture.of(key);
    let ray = |texel: usize| {
        let (point, direction) = (usize::from(probe.owner[texel]), directions[texel]);
        (probe.starts.cosine(point, direction) > 0.0).then(|| probe.starts.ray(point, direction))
    };
    let texels = texture.texels().filter(|_| !probe.points.is_empty());
    texels.filter_map(ray)
}

/// Traces the n x n sky bits of a cell. A cell without any surface (which no hit can name) has zero bits and no points.
pub fn trace_probe(key: CellKey, texture: &Directions, surfaces: CellSurfaces) -> ProbeTrace {
    let (n, directions, tracer) = (texture.n, texture.of(key), surfaces.tracer);
    let points = points_of(key, n, surfaces);
    let count = points.len();
    let mut sky = SkyBits { bits: vec![0_u8; (n * n).div_ceil(8)] };
    let starts = Starts::of(key, &points, tracer);
    if count == 0 {
        return ProbeTrace { bits: sky.bits, ..ProbeTrace::of(key, points, starts, &[]) };
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

    // Second round: texels of hidden points are asked again from the others, of which there is one that sees sky if any is hidden.
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

    // Third round: the other texels, where those traced first do not tell.
    if texture.refined {
        let base = Refinement::of(n, &first, &sky.bits, |texel| look.is_before(texel, usize::from(owner[texel])));
        for texel in texture.texels().filter(|&texel| !base.is_traced(texel)) {
            let point = usize::from(owner[texel]);
            match base.told(texel) {
                None => look.ask(texel, point),
                Some(is_open) if is_open && look.is_before(texel, point) => sky.set(texel),
                Some(_) => {}
            }
        }
        rays += look.cast.len() as u64;
        look.open(tracer).for_each(|(texel, _)| sky.set(texel));
    }
    ASKED.set(look.asked);
    CAST.set(look.cast);
    ProbeTrace { bits: sky.bits, owner, rays, doubtful, ..ProbeTrace::of(key, points, starts, &worth) }
}

/// Bits of a texture.
struct SkyBits {
    bits: Vec<u8>,
}

impl SkyBits {
    fn set(&mut self, texel: usize) {
        self.bits[texel / 8] |= 1 << (texel % 8);
    }
}

thread_local! {
    /// Memory of a thread for the lists of [`Look`], which serves one cell after the other.
    static ASKED: RefCell<Vec<(usize, usize)>> = RefCell::default();
    static CAST: RefCell<Vec<Ray>> = RefCell::default();
}

/// Asks for the sky behind texels from points of a cell.
struct Look<'a> {
    directions: &'a [DVec3],
    starts: &'a Starts,
    /// Texels and points of the rays to be cast.
    asked: Vec<(usize, usize)>,
    cast: Vec<Ray>,
}

impl Look<'_> {
    /// Whether a texel is not behind a point's surface.
    fn is_before(&self, texel: usize, point: usize) -> bool {
        self.starts.cosine(point, self.directions[texel]) > 0.0
    }

    /// A ray from a point through a texel, unless that is behind the point's surface.
    fn ask(&mut self, texel: usize, point: usize) {
        if self.is_before(texel, point) {
            self.asked.push((texel, point));
            self.cast.push(self.starts.ray(point, self.directions[texel]));
        }
    }

    /// Which points are hidden, and the rays that it took to find out. Only points that see no sky are suspected, and only where others
    /// see some: only those could take their rays. Leaves are not asked: the inside of a crown is no solid.
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
        // Each point has a texel in each block: some blocks, spread over the sky.
        let stride = (texture.n * texture.n / (POINTS * LOOKS)).max(1) as u64;
        let some = texture.places.iter().filter(|place| place.block % stride == 0);
        let asked = some.map(|place| (usize::from(owner[place.texel]), self.directions[place.texel]));
        let dark = asked.filter(|&(point, direction)| !open[point] && self.starts.cosine(point, direction) > 0.0);
        let looks: Vec<(usize, Ray)> =
            dark.map(|(point, direction)| (point, self.starts.ray(point, direction))).collect();
        (hidden(open.len(), &looks, key.is_back(), surfaces.mesh, surfaces.tracer), looks.len() as u64)
    }

    /// Those texels and points, of all asked for, that see sky; after that none is asked for.
    fn open(&mut self, tracer: &Tracer) -> impl Iterator<Item = (usize, usize)> {
        let met = tracer.occluded_many(&self.cast);
        self.cast.clear();
        self.asked.drain(..).zip(met).filter(|(_, met)| !met).map(|(asked, _)| asked)
    }
}

/// Ray origin of a surface point (input coordinates): lifted off the surface, on the grid, relative to the scene origin.
pub fn lifted(position: DVec3, normal: DVec3, tracer: &Tracer) -> [f32; 3] {
    tracer.grid().lifted(position, normal)
}

/// Which of 16 points a texel asks in the first round, by its place in a 4 x 4 block: each block asks all of them, in an order of
/// its own.
fn slot(inside: usize, turn: usize) -> usize {
    (inside * 5 % 16) ^ turn
}

/// Random bits of a block of 4 x 4 texels: the lowest four say which point asks which of them, four pairs from the ninth on which texel of each two by
/// two is traced first.
fn order(seed: u64, block: u64) -> u64 {
    mix(seed ^ 0x736c_6f74, block)
}

/// First index at which the running sum of `weights` exceeds `at`; the last positive one if rounding leaves none.
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

    /// A plane of 200 m with a house of 20 x 12 m, 9 m high, whose floor lies 2 cm above it.
    fn house() -> Scene {
        let (x, y, z, low) = (20.0 * DVec3::X, 12.0 * DVec3::Y, 9.0 * DVec3::Z, DVec3::new(3.0, 0.0, 0.02));
        let ground = [DVec3::new(-100.0, -100.0, 0.0), 200.0 * DVec3::X, 200.0 * DVec3::Y];
        let walls = [[low, x, z], [low + x, y, z], [low + x + y, -x, z], [low + y, -y, z]];
        matt(&[&[ground][..], &walls[..], &[[low + z, x, y], [low, y, x]][..]].concat())
    }

    /// Of a cell of ground, 8 m wide, the part below a floor 2 cm above it is no part of what others see: it has more than a half of the
    /// weight of points that count alike and less than 3 % of that of points that count by how open they are; the bits of the sky rise by as much.
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

    /// Probes of 64 x 64 texels around a house, traced whole and refined: of 24 cells on its walls and before them at most 0.5 % of all bits differ, for
    /// less than half of the rays.
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
