//! Probes: what the surface of one cell sees of the sky. In: a cell key. Out: one small world-frame sky texture, and the
//! points it was traced from.
//!
//! Rays start from many points of the cell, each texel from one of them. Points hidden in party walls or below the terrain,
//! which no receiver sees either, must not count: points that see no sky drop out, all others count alike. (Weights in
//! proportion to the sky that they see were tried: too much light in wells and canyons, where lower parts see little sky and
//! yet are seen.)

use glam::DVec3;

use super::rays::{Ray, Tracer};
use super::surface::{POINTS, SurfacePoint, sample};
use crate::hemisphere::{jitter, mix, texel_direction, texels_in_blocks, unit};
use crate::scene::cells::CellKey;
use crate::scene::mesh::Mesh;

/// Jittered directions through the texels of cells' n x n sky textures: a few patterns, made once, of which each cell takes
/// one by its seed.
pub struct Directions {
    pub n: usize,
    patterns: Vec<Vec<DVec3>>,
}

/// Jitter patterns: a receiver sees some hundred probes, their errors average out over this many.
const PATTERNS: u64 = 64;

impl Directions {
    pub fn new(n: usize) -> Self {
        let direction = |k: u64, t: usize| texel_direction(t % n, t / n, n, jitter(mix(0x7465_7865, k), t as u64));
        let patterns = (0..PATTERNS).map(|k| (0..n * n).map(|t| direction(k, t)).collect()).collect();
        Directions { n, patterns }
    }

    /// [texel]: unit directions of a cell's rays, world frame.
    pub fn of(&self, key: CellKey) -> &[DVec3] {
        &self.patterns[(mix(key.seed(), 5) % PATTERNS) as usize]
    }
}

/// Sky bits of a cell.
#[derive(Clone, Debug)]
pub struct ProbeTrace {
    /// Mean of the points' unit normals, so its length is 1 for a plane cell and below for a curved one.
    pub normal: DVec3,
    /// n x n bits, row-major, world frame, 8 to a byte from the lowest bit.
    pub bits: Vec<u8>,
    /// Points and the share of the cell that each stands for (sum 1).
    pub points: Vec<(SurfacePoint, f64)>,
    /// [texel]: the point that the texel's ray was cast from.
    pub owner: Vec<u8>,
    pub rays: u64,
}

/// Traces the n x n sky bits of a cell. A cell without any surface (which no hit can name) has zero bits and no points.
pub fn trace_probe(key: CellKey, texture: &Directions, mesh: &Mesh, tracer: &Tracer) -> ProbeTrace {
    let (n, directions) = (texture.n, texture.of(key));
    let points = sample(key, mesh, tracer);
    let count = points.len();
    let mut bits = vec![0_u8; (n * n).div_ceil(8)];
    if count == 0 {
        return ProbeTrace { normal: DVec3::ZERO, bits, points: Vec::new(), owner: Vec::new(), rays: 0 };
    }
    let seed = key.seed();
    let origins: Vec<[f32; 3]> = points.iter().map(|p| lifted(p.position, p.normal, tracer)).collect();
    let texels: Vec<usize> = texels_in_blocks(n).map(|(column, row)| row * n + column).collect();
    let mut rays = 0;
    // Answers for (texel, point): `None` where the texel is behind the point's surface.
    let mut look = |asked: &[(usize, usize)]| -> Vec<Option<bool>> {
        let mut cast = Vec::with_capacity(asked.len());
        let mut answers: Vec<Option<bool>> = Vec::with_capacity(asked.len());
        for &(texel, point) in asked {
            let d = directions[texel];
            let front = points[point].normal.dot(d) > 0.0;
            answers.push(front.then_some(false));
            if front {
                cast.push(Ray { origin: origins[point], direction: d.as_vec3().to_array() });
            }
        }
        rays += cast.len() as u64;
        let met = tracer.occluded_many(&cast);
        answers.iter_mut().flatten().zip(met).for_each(|(answer, met)| *answer = !met);
        answers
    };

    // First round: every point gets the same share of texels, spread over the whole sky.
    let mut owners: Vec<(usize, usize)> =
        texels.iter().map(|&texel| (texel, slot(texel, n, seed) * count / POINTS)).collect();
    // At most POINTS, so a byte.
    let mut owner = vec![0_u8; n * n];
    owners.iter().for_each(|&(texel, point)| owner[texel] = point as u8);
    let mut open = vec![0_u32; count];
    for (&(texel, point), sky) in owners.iter().zip(look(&owners)) {
        if let Some(sky) = sky {
            open[point] += u32::from(sky);
            set(&mut bits, texel, sky);
        }
    }
    let worth: Vec<f64> = open.iter().map(|&o| if o > 0 { 1.0 } else { 0.0 }).collect();
    let lit: f64 = worth.iter().sum();

    // Second round: texels of points in the dark are asked again from the others.
    let share: Vec<f64> = if lit > 0.0 {
        owners.retain(|&(_, point)| open[point] == 0);
        for (texel, point) in &mut owners {
            *point = pick(&worth, lit * unit(mix(seed ^ 0x6f70_656e, *texel as u64)));
        }
        for (&(texel, _), sky) in owners.iter().zip(look(&owners)) {
            set(&mut bits, texel, sky.unwrap_or(false));
        }
        owners.iter().for_each(|&(texel, point)| owner[texel] = point as u8);
        worth.iter().map(|w| w / lit).collect()
    } else {
        vec![1.0 / count as f64; count]
    };
    let normal = points.iter().zip(&share).map(|(p, &s)| p.normal * s).sum();
    ProbeTrace { normal, bits, points: points.into_iter().zip(share).collect(), owner, rays }
}

/// Ray origin of a surface point: lifted off the surface, f32.
pub fn lifted(position: DVec3, normal: DVec3, tracer: &Tracer) -> [f32; 3] {
    (position + normal * tracer.offset_m(position)).as_vec3().to_array()
}

/// Which of 16 points a texel asks in the first round: each 4 x 4 block asks all of them, in an order of its own.
fn slot(texel: usize, n: usize, seed: u64) -> usize {
    let (column, row) = (texel % n, texel / n);
    let block = (row / 4 * n.div_ceil(4) + column / 4) as u64;
    let turn = mix(seed ^ 0x736c_6f74, block) as usize;
    (((row % 4) * 4 + column % 4) * 5 % 16) ^ (turn & 15)
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

fn set(bits: &mut [u8], index: usize, value: bool) {
    let (byte, bit) = (index / 8, index % 8);
    bits[byte] = bits[byte] & !(1 << bit) | (u8::from(value) << bit);
}
