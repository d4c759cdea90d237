//! From texels to sky patches: which patches a texel of a world-frame hemisphere texture covers, and by how much.
//!
//! In: a subdivision of the sky and the side of the texture. Out: sparse rows [`Projection::of_texel`] and the sums that
//! follow from them. Radiances are scaled with `open_horizontal_sr`, so an unobstructed horizontal receiver whose
//! coefficients come from the same rows gets DHI exactly, whatever the resolution.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::patches::Patches;
use crate::hemisphere::{HEMISPHERE_SR, texel_direction};

/// The patches of every texel of an n x n texture.
#[derive(Clone, Debug)]
pub struct Projection {
    /// Side of the texture.
    n: usize,
    /// Texel t owns the entries `starts[t]..starts[t + 1]`.
    starts: Vec<u32>,
    /// (patch, share of the texel's area); shares of a texel sum to 1.
    entries: Vec<(u16, f32)>,
    /// Mean direction of each texel, not normalised: n . mean is the texel's mean cosine on a surface that sees all of it.
    pub mean_directions: Vec<DVec3>,
    /// Solid angle of each patch as the texels count it, sr.
    pub solid_angle_sr: Vec<f64>,
    /// Sum over texels of share x solid angle x mean cosine on a horizontal surface, sr.
    pub open_horizontal_sr: Vec<f64>,
}

/// Largest side: texel and entry numbers stay in 32 bits.
const MAX_SIDE: usize = 4096;

impl Projection {
    /// Projection of an n x n texture (n from 1 to 4096, clamped) by `samples` squared points in each texel; 8 is
    /// enough for n = 128.
    pub fn new(patches: &Patches, n: usize, samples: usize) -> Self {
        let (n, samples) = (n.clamp(1, MAX_SIDE), samples.clamp(1, 64));
        let share = 1.0 / (samples * samples) as f64;
        let texels: Vec<(Vec<(u16, f32)>, DVec3)> = (0..n * n)
            .into_par_iter()
            .with_min_len(n)
            .map(|texel| {
                let mut found: Vec<u16> = Vec::with_capacity(samples * samples);
                let mut mean = DVec3::ZERO;
                for i in 0..samples * samples {
                    let inside = lattice(i, samples * samples, texel);
                    let direction = texel_direction(texel % n, texel / n, n, inside);
                    mean += direction * share;
                    found.push(patches.patch_of(direction) as u16);
                }
                found.sort_unstable();
                let runs = found.chunk_by(|a, b| a == b);
                let entries = runs.filter_map(|run| Some((*run.first()?, (run.len() as f64 * share) as f32))).collect();
                (entries, mean)
            })
            .collect();
        let mut projection = Projection {
            n,
            starts: Vec::with_capacity(n * n + 1),
            entries: Vec::new(),
            mean_directions: Vec::with_capacity(n * n),
            solid_angle_sr: vec![0.0; patches.len()],
            open_horizontal_sr: vec![0.0; patches.len()],
        };
        let texel_sr = projection.texel_sr();
        projection.starts.push(0);
        for (entries, mean) in texels {
            for &(patch, share) in &entries {
                let (patch, area_sr) = (usize::from(patch), f64::from(share) * texel_sr);
                if let Some(sum) = projection.solid_angle_sr.get_mut(patch) {
                    *sum += area_sr;
                }
                if let Some(sum) = projection.open_horizontal_sr.get_mut(patch) {
                    *sum += area_sr * mean.z;
                }
            }
            projection.entries.extend(entries);
            projection.starts.push(projection.entries.len() as u32);
            projection.mean_directions.push(mean);
        }
        projection
    }

    /// Side of the texture.
    pub fn side(&self) -> usize {
        self.n
    }

    /// Solid angle of a texel, sr.
    pub fn texel_sr(&self) -> f64 {
        HEMISPHERE_SR / (self.n * self.n) as f64
    }

    /// The (patch, share of area) pairs of a texel; none for a texel that does not exist.
    pub fn of_texel(&self, texel: usize) -> &[(u16, f32)] {
        let range = match self.starts.get(texel..).map(|rest| (rest.first(), rest.get(1))) {
            Some((Some(&start), Some(&end))) => start as usize..end as usize,
            _ => 0..0,
        };
        self.entries.get(range).unwrap_or_default()
    }
}

/// The i-th of `count` points in a texel: a lattice by the golden section, shifted from texel to texel by Roberts' R2 sequence.
/// Rows of patches are squares on the texture, so equal grids in all texels would miscount them by up to 2 %, an unshifted
/// lattice by 1 %.
fn lattice(i: usize, count: usize, texel: usize) -> DVec2 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const R2: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    let x = i as f64 + 0.5;
    (DVec2::new(x / count as f64, x * GOLDEN) + R2 * texel as f64).fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares of each texel sum to 1 (1e-6), patch solid angles to 2 pi (1e-9) and open coefficients to pi (1e-5 at n = 128), for three
    /// texture sides and the three subdivisions.
    #[test]
    fn sums() {
        for count in [145, 577, 2305] {
            let patches = Patches::new(count).expect("known count");
            for (n, samples, tolerance) in [(1, 64, 5e-3), (32, 8, 1e-4), (128, 8, 1e-5)] {
                let p = Projection::new(&patches, n, samples);
                for texel in 0..n * n {
                    let sum: f32 = p.of_texel(texel).iter().map(|e| e.1).sum();
                    assert!((sum - 1.0).abs() < 1e-6, "{sum}");
                }
                let solid: f64 = p.solid_angle_sr.iter().sum();
                assert!((solid - HEMISPHERE_SR).abs() < 1e-9, "{solid}");
                let open: f64 = p.open_horizontal_sr.iter().sum();
                assert!((open / std::f64::consts::PI - 1.0).abs() < tolerance, "{n}: {open}");
                assert!(p.of_texel(n * n).is_empty());
            }
        }
    }

    /// At n = 128 and 8 x 8 points the texels count each of the 577 patches within 1 % of its exact solid angle.
    #[test]
    fn patch_areas() {
        let patches = Patches::new(577).expect("known count");
        let p = Projection::new(&patches, 128, 8);
        for (counted, exact) in p.solid_angle_sr.iter().zip(patches.solid_angles_sr()) {
            assert!((counted / exact - 1.0).abs() < 0.01, "{counted} {exact}");
        }
    }
}
