//! The response texture G. In: a receiver's hits, the probes it sees, the solved bounces, reflectances. Out: one 3-vector per
//! sky texel and first-hit class: diffuse light of any source is s . G at the source's texel.
//!
//! G[t] = sum_p w_p rho_p ( b_p[t] n_p + indirect_p[t] ): linear in the sources, so one texture serves every sun and sky.

use glam::DVec3;
use rayon::prelude::*;

use super::bounces::{Depth, Solved, Surround, centres_f32, seen, solve, surround};
use crate::hemisphere::{Frame, bilinear, jitter, texel_centres, texel_direction};
use crate::layers::hit::HitTile;
use crate::layers::probes::{Bounces, Probes};
use crate::layers::response::{CLASSES, Response};
use crate::scene::materials::Class;

/// Sizes that give the tables their shape.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Side of the hit texture.
    pub hit: usize,
    /// Side of the probes' sky texture, and of G.
    pub probe: usize,
    /// Side of the bounce cells' sky texture.
    pub bounce_sky: usize,
    /// Level of the bounce cells at middle distance: from here up cells see each other in circles.
    pub closed_level: i8,
}

/// Reflecting properties of a material that recombination needs.
#[derive(Clone, Copy, Debug)]
pub struct Reflector {
    pub diffuse: f64,
    pub class: Class,
}

/// What is needed of a receiver besides its hits.
#[derive(Clone, Copy, Debug)]
pub struct Viewer {
    pub normal: DVec3,
    /// Seed of its hit rays' jitter.
    pub seed: u64,
    /// Cosine-weighted share of its hemisphere that is sky, from the sky texture.
    pub sky_view: f64,
}

/// Weight of each cell of a tile's palette at one receiver.
#[derive(Clone, Debug)]
pub struct HitWeights {
    /// (palette index, cosine-weighted share of the hemisphere), in palette order.
    pub cells: Vec<(usize, f64)>,
}

/// Weights of the hits of a receiver. Rays above the horizon share what the (much finer) sky texture leaves, rays below
/// share the lower part of the hemisphere; so sky and surfaces add up to one exactly.
pub fn hit_weights(texels: &[u32], viewer: &Viewer) -> HitWeights {
    let n = texels.len().isqrt();
    let frame = Frame::of(viewer.normal);
    let (mut above, mut below) = (0.0, 0.0);
    let rays: Vec<(f64, bool)> = (0..texels.len())
        .map(|t| {
            let local = texel_direction(t % n, t / n, n, jitter(viewer.seed, t as u64));
            let up = frame.to_world(local).z > 0.0;
            if !up {
                below += local.z;
            } else if texels[t] != 0 {
                above += local.z;
            }
            (local.z, up)
        })
        .collect();
    let upper_half = (1.0 + viewer.normal.z) / 2.0;
    let ratio = |share: f64, sum: f64| if sum > 0.0 { share.max(0.0) / sum } else { 0.0 };
    let up_scale = ratio(upper_half - viewer.sky_view, above);
    let down_scale = ratio(1.0 - upper_half, below);
    let mut hits: Vec<(usize, f64)> = texels
        .iter()
        .zip(rays)
        .filter(|(cell, _)| **cell != 0)
        .map(|(&cell, (cos, up))| (cell as usize - 1, cos * if up { up_scale } else { down_scale }))
        .collect();
    hits.sort_by_key(|h| h.0);
    hits.dedup_by(|later, first| {
        let same = later.0 == first.0;
        if same {
            first.1 += later.1;
        }
        same
    });
    HitWeights { cells: hits }
}

/// Derives responses from probes and bounces for one set of reflectances.
pub struct Responder {
    probes: Probes,
    shape: Shape,
    reflectors: Vec<Reflector>,
    solved: Solved,
    depth: Depth,
    surrounds: Vec<Surround>,
    /// For each texel of G the four texels of the bounce texture and their weights.
    upsample: Vec<[(usize, f64); 4]>,
}

impl Responder {
    /// Solves the bounces; `reflectors` by material index.
    pub fn new(probes: Probes, bounces: Bounces, shape: Shape, reflectors: Vec<Reflector>, depth: Depth) -> Self {
        let reflectance: Vec<f64> = reflectors.iter().map(|r| r.diffuse).collect();
        let solved = solve(&bounces, shape.bounce_sky, shape.closed_level, &reflectance, depth);
        let centres = centres_f32(shape.probe);
        let row = centres.len().div_ceil(8);
        let surrounds = probes
            .normals
            .par_iter()
            .zip(probes.bits.par_chunks(row))
            .map(|(&normal, bits)| surround(normal, bits, &centres))
            .collect();
        let upsample = texel_centres(shape.probe).into_iter().map(|d| bilinear(d, shape.bounce_sky)).collect();
        Responder { probes, shape, reflectors, solved, depth, surrounds, upsample }
    }

    /// Response of receiver `index` of a tile. Cells that the tables do not hold are left out.
    pub fn derive(&self, tile: &HitTile, index: usize, viewer: &Viewer) -> Response {
        let per_receiver = self.shape.hit * self.shape.hit;
        let texels = self.shape.probe * self.shape.probe;
        let row = texels.div_ceil(8);
        let weights = hit_weights(&tile.texels[index * per_receiver..(index + 1) * per_receiver], viewer);
        let mut values = vec![0.0_f32; Response::len(self.shape.probe)];
        let rays = self.probes.hits.len().checked_div(self.probes.keys.len()).unwrap_or(0);
        // (bounce cell, class, what its radiosity is worth to this receiver)
        let mut indirect: Vec<(u32, usize, f32)> = Vec::new();
        for (cell, weight) in weights.cells {
            let key = tile.palette[cell];
            let Some(reflector) = self.reflectors.get(usize::from(key.material)) else { continue };
            let Some(probe) = self.probes.find(&key) else { continue };
            let class = class_index(reflector.class);
            let worth = weight * reflector.diffuse;
            let normal = self.probes.normals[probe].map(|c| c * worth as f32);
            let bits = &self.probes.bits[probe * row..(probe + 1) * row];
            let out = &mut values[class * 3 * texels..(class + 1) * 3 * texels];
            add_bits(out, bits, normal, texels);
            if self.depth != Depth::Count(1) {
                let around = self.surrounds[probe];
                let (above, below) = seen(&self.probes.hits[probe * rays..(probe + 1) * rays]);
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
        let width = self.solved.width;
        let mut coarse = vec![0.0_f32; CLASSES * width];
        worth.sort_by_key(|w| (w.0, w.1));
        for group in worth.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let sum: f32 = group.iter().map(|g| g.2).sum();
            let (cell, class) = (group[0].0 as usize, group[0].1);
            let x = self.solved.row(cell);
            for (o, x) in coarse[class * width..(class + 1) * width].iter_mut().zip(x) {
                *o += sum * x;
            }
        }
        let fine = self.upsample.len();
        let coarse_texels = width / 3;
        for (plane, coarse) in values.chunks_mut(fine).zip(coarse.chunks(coarse_texels)) {
            for (value, corners) in plane.iter_mut().zip(&self.upsample) {
                *value += corners.iter().map(|&(t, w)| coarse[t] * w as f32).sum::<f32>();
            }
        }
    }
}

/// Shares of a receiver's hemisphere whose first hit is ground and obstruction.
pub fn view_factors(texels: &[u32], tile: &HitTile, reflectors: &[Reflector], viewer: &Viewer) -> [f64; CLASSES] {
    let mut shares = [0.0; CLASSES];
    for (cell, weight) in hit_weights(texels, viewer).cells {
        if let Some(reflector) = reflectors.get(usize::from(tile.palette[cell].material)) {
            shares[class_index(reflector.class)] += weight;
        }
    }
    shares
}

fn class_index(class: Class) -> usize {
    match class {
        Class::Ground => 0,
        Class::Obstruction => 1,
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

/// Diffuse irradiance per unit normal irradiance of a source in direction `s`, from the sum of both classes [axis][texel].
pub fn respond(total: &[f32], s: DVec3, corners: &[(usize, f64); 4]) -> f64 {
    let texels = total.len() / 3;
    let at = |axis: usize| -> f64 { corners.iter().map(|&(t, w)| f64::from(total[axis * texels + t]) * w).sum() };
    s.x * at(0) + s.y * at(1) + s.z * at(2)
}
