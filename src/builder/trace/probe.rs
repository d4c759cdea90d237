//! Probes: what the surface of one cell sees of the sky. In: a cell key. Out: one small world-frame sky texture, and the
//! points it was traced from.
//!
//! Rays start from many points of the cell, each texel from one of them. Points [hidden](super::hidden) in party walls or below the terrain,
//! which no receiver sees either, must not count; all others count alike. (Weights in proportion to the sky that they see were tried, and so
//! was leaving out all that see none: too much light in wells and canyons, where lower parts see little sky and yet are seen.)

use std::cell::RefCell;

use glam::DVec3;

use crate::trace::hidden::{LOOKS, Verdict, hidden};
use crate::trace::kernel::rays::{Ray, Tracer};
use crate::trace::surface::{CellSurfaces, POINTS, SurfacePoint, sample};
use heliotile_core::hemisphere::{jitter, mix, texel_direction, texels_in_blocks, unit};
use heliotile_core::light::radiosity::centres_f32;
use heliotile_core::site::cells::CellKey;

/// Jittered directions through the texels of cells' n x n sky textures: a few patterns, made once, of which each cell takes
/// one by its seed.
pub struct Directions {
    pub n: usize,
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

/// Jitter patterns: a receiver sees some hundred probes, their errors average out over this many.
const PATTERNS: u64 = 64;

impl Directions {
    pub fn new(n: usize) -> Self {
        let direction = |k: u64, t: usize| texel_direction(t % n, t / n, n, jitter(mix(0x7465_7865, k), t as u64));
        let patterns = (0..PATTERNS).map(|k| (0..n * n).map(|t| direction(k, t)).collect()).collect();
        let place = |(column, row): (usize, usize)| Place {
            texel: row * n + column,
            block: (row / 4 * n.div_ceil(4) + column / 4) as u64,
            inside: (row % 4) * 4 + column % 4,
        };
        Directions { n, centres: centres_f32(n), patterns, places: texels_in_blocks(n).map(place).collect() }
    }

    /// All texels; neighbours in the list are neighbours on the sphere.
    pub fn texels(&self) -> impl Iterator<Item = usize> {
        self.places.iter().map(|place| place.texel)
    }

    /// [texel]: which of so many points of a cell asks it first: each the same share, spread over the whole sky.
    fn owners(&self, key: CellKey, points: usize) -> Vec<u8> {
        let (seed, mut owner) = (key.seed(), vec![0_u8; self.n * self.n]);
        for of_block in self.places.chunk_by(|a, b| a.block == b.block) {
            let turn = turn(seed, of_block[0].block);
            for place in of_block {
                // At most POINTS, so a byte.
                owner[place.texel] = (slot(place.inside, turn) * points / POINTS) as u8;
            }
        }
        owner
    }

    /// [texel]: unit directions of a cell's rays, world frame.
    pub fn of(&self, key: CellKey) -> &[DVec3] {
        &self.patterns[(mix(key.seed(), 5) % PATTERNS) as usize]
    }
}

/// Rays of a point at least, so that it is known whether it sees sky.
const LEAST_RAYS: usize = 16;

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

/// What [`trace_probe`] gives of a cell without hidden points whose sky bits are known, and no ray is cast.
pub fn known_probe(key: CellKey, bits: Vec<u8>, texture: &Directions, surfaces: CellSurfaces) -> ProbeTrace {
    let points = points_of(key, texture.n, surfaces);
    let share = 1.0 / points.len() as f64;
    ProbeTrace {
        normal: mean_normal(key, points.iter().map(|p| p.normal * share)),
        bits,
        starts: Starts::of(key, &points, surfaces.tracer),
        owner: texture.owners(key, points.len()),
        points: points.into_iter().map(|point| (point, share)).collect(),
        rays: 0,
        doubtful: false,
    }
}

/// The rays of the first round, those that [`trace_probe`] casts for a cell without hidden points.
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
    let mut bits = vec![0_u8; (n * n).div_ceil(8)];
    if count == 0 {
        let (points, starts, owner) = Default::default();
        return ProbeTrace { normal: DVec3::ZERO, bits, points, starts, owner, rays: 0, doubtful: false };
    }
    let seed = key.seed();
    let starts = Starts::of(key, &points, tracer);
    let mut look = Look { directions, starts: &starts, asked: ASKED.take(), cast: CAST.take() };

    // First round: every point gets the same share of texels, spread over the whole sky.
    let mut owner = texture.owners(key, count);
    texture.texels().for_each(|texel| look.ask(texel, usize::from(owner[texel])));
    let mut rays = look.cast.len() as u64;
    let mut open = vec![false; count];
    for (texel, point) in look.open(tracer) {
        open[point] = true;
        bits[texel / 8] |= 1 << (texel % 8);
    }
    let (Verdict { hidden, doubtful }, looks) = look.hidden(&open, &owner, key, texture, surfaces);
    rays += looks;

    // Second round: texels of hidden points are asked again from the others, of which there is one that sees sky if any is hidden.
    let worth: Vec<f64> = hidden.iter().map(|&hidden| f64::from(u8::from(!hidden))).collect();
    let shown: f64 = worth.iter().sum();
    for texel in texture.texels() {
        if hidden[usize::from(owner[texel])] {
            let point = pick(&worth, shown * unit(mix(seed ^ 0x6f70_656e, texel as u64)));
            owner[texel] = point as u8;
            look.ask(texel, point);
        }
    }
    rays += look.cast.len() as u64;
    look.open(tracer).for_each(|(texel, _)| bits[texel / 8] |= 1 << (texel % 8));
    let share: Vec<f64> = worth.iter().map(|w| w / shown).collect();
    ASKED.set(look.asked);
    CAST.set(look.cast);
    let normal = mean_normal(key, points.iter().zip(&share).map(|(p, &s)| p.normal * s));
    ProbeTrace { normal, bits, points: points.into_iter().zip(share).collect(), starts, owner, rays, doubtful }
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
    /// A ray from a point through a texel, unless that is behind the point's surface.
    fn ask(&mut self, texel: usize, point: usize) {
        let direction = self.directions[texel];
        if self.starts.cosine(point, direction) > 0.0 {
            self.asked.push((texel, point));
            self.cast.push(self.starts.ray(point, direction));
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

/// The order of a block.
fn turn(seed: u64, block: u64) -> usize {
    mix(seed ^ 0x736c_6f74, block) as usize % POINTS
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
