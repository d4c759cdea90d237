//! Weights of a receiver's hits. In: a tile's hits, and a receiver. Out: the weight of every cell
//! that the receiver sees, and its view factors.

use glam::DVec3;

use crate::hemisphere::{Frame, ray_direction};
use crate::layers::hit::HitTile;
use crate::layers::response::CLASSES;
use crate::light::reflector::Reflector;

/// Properties of a receiver that the weights of its hits need.
#[derive(Clone, Copy, Debug)]
pub struct Viewer {
    /// Unit normal, world frame.
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

/// Returns the weights of the hits of a receiver, cell by cell. `shares` gives the light that comes
/// through along each ray, if not all does.
pub fn hit_weights(texels: &[u32], viewer: &Viewer, shares: Option<&[f32]>) -> HitWeights {
    let mut weights = texel_weights(texels, viewer);
    if let Some(shares) = shares {
        weights.iter_mut().zip(shares).for_each(|(weight, &share)| *weight *= f64::from(share));
    }
    let mut hits: Vec<(usize, f64)> = texels
        .iter()
        .zip(weights)
        .filter(|(cell, _)| **cell != 0)
        .map(|(&cell, weight)| (cell as usize - 1, weight))
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

/// Returns the cosine-weighted share of the hemisphere that each texel stands for; 0 where the ray
/// met nothing. Rays above the horizon divide the share that the (much finer) sky texture leaves.
/// Rays below divide the lower part of the hemisphere. So sky and surfaces add up to one exactly.
pub fn texel_weights(texels: &[u32], viewer: &Viewer) -> Vec<f64> {
    let n = texels.len().isqrt();
    let frame = Frame::new(viewer.normal);
    let (mut above, mut below) = (0.0, 0.0);
    let rays: Vec<(f64, bool)> = (0..texels.len())
        .map(|t| {
            let local = ray_direction(t, n, viewer.seed);
            let up = frame.to_world(local).z > 0.0;
            if !up {
                below += local.z;
            } else if texels[t] != 0 {
                above += local.z;
            }
            (local.z, up)
        })
        .collect();
    // A tilted surface sees the share (1 + cos tilt) / 2 of its hemisphere above the horizon.
    let upper_half = (1.0 + viewer.normal.z) / 2.0;
    let ratio = |share: f64, sum: f64| if sum > 0.0 { share.max(0.0) / sum } else { 0.0 };
    let up_scale = ratio(upper_half - viewer.sky_view, above);
    let down_scale = ratio(1.0 - upper_half, below);
    let weight = |(&cell, (cos, up))| match cell {
        0 => 0.0,
        _ => cos * if up { up_scale } else { down_scale },
    };
    texels.iter().zip(rays).map(weight).collect()
}

/// Returns the shares of a receiver's hemisphere whose first hit is ground and obstruction;
/// canopies hide nothing.
pub fn view_factors(texels: &[u32], tile: &HitTile, reflectors: &[Reflector], viewer: &Viewer) -> [f64; CLASSES] {
    let mut shares = [0.0; CLASSES];
    for (cell, weight) in hit_weights(texels, viewer, None).cells {
        // The palette's materials were checked when it was read or traced.
        shares[reflectors[usize::from(tile.palette[cell].material)].class.index()] += weight;
    }
    shares
}
