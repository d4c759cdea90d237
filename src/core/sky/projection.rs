//! Projection from texels to sky patches: the patches that a texel of a world-frame hemisphere
//! texture covers, and their shares of it.
//!
//! In: a subdivision of the sky and the side of the texture. Out: sparse rows
//! [`Projection::of_texel`] and the sums that follow from them. Radiances are scaled with
//! `open_horizontal_sr`, so an unobstructed horizontal receiver whose coefficients come from the
//! same rows gets DHI exactly, at any resolution.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::hemisphere::{HEMISPHERE_SR, azimuth_and_z, direction_of, r2};
use crate::sky::horizon::HorizonBand;
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;

/// Patches of every texel of an n x n texture, with their shares.
#[derive(Clone, Debug)]
pub struct Projection {
    /// Side of the texture, texels.
    n: usize,
    /// `[texel]`: first of its entries; texel t has the entries `starts[t]..starts[t + 1]`.
    starts: Vec<u32>,
    /// (patch, share of the texel's area); shares of a texel sum to 1.
    entries: Vec<(u16, f32)>,
    /// Mean direction of each texel, not normalised: n . mean is the texel's mean cosine on a
    /// surface that sees all of it.
    pub mean_directions: Vec<DVec3>,
    /// Solid angle of each patch as the texels count it, sr.
    pub solid_angle_sr: Vec<f64>,
    /// Sum over texels of share x solid angle x mean cosine on a horizontal surface, sr.
    pub open_horizontal_sr: Vec<f64>,
    /// Band at the horizon, a source beside the patches that some models have.
    horizon: Option<HorizonBand>,
}

/// Largest side: texel and entry numbers stay in 32 bits.
const MAX_SIDE: usize = 4096;

impl Projection {
    /// Returns the projection of an n x n texture (n is clamped to 1..=4096) by `samples` squared
    /// points in each texel; 8 is enough for n = 128.
    pub fn new(patches: &Patches, n: usize, samples: usize) -> Self {
        let (n, samples) = (n.clamp(1, MAX_SIDE), samples.clamp(1, 64));
        let share = 1.0 / (samples * samples) as f64;
        let lattice = lattice(samples * samples);
        let texels: Vec<(Vec<(u16, f32)>, DVec3)> = (0..n * n)
            .into_par_iter()
            .with_min_len(n)
            .map(|texel| {
                let corner = DVec2::new((texel % n) as f64, (texel / n) as f64);
                let mut found: Vec<(u16, u32)> = Vec::new();
                if let Some(patch) = whole(patches, corner, n) {
                    return (vec![(patch as u16, 1.0)], mean_direction(corner, n));
                }
                let shift = shift(texel);
                for &point in &lattice {
                    let (turns, z) = azimuth_and_z((corner + wrapped(point, shift)) / n as f64);
                    let patch = patches.patch_at(turns, z) as u16;
                    match found.iter_mut().find(|entry| entry.0 == patch) {
                        Some(entry) => entry.1 += 1,
                        None => found.push((patch, 1)),
                    }
                }
                found.sort_unstable();
                let entries = found.into_iter().map(|(patch, count)| (patch, (f64::from(count) * share) as f32));
                (entries.collect(), mean_direction(corner, n))
            })
            .collect();
        let mut projection = Projection {
            n,
            starts: Vec::with_capacity(n * n + 1),
            entries: Vec::new(),
            mean_directions: Vec::with_capacity(n * n),
            solid_angle_sr: vec![0.0; patches.len()],
            open_horizontal_sr: vec![0.0; patches.len()],
            horizon: None,
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

    /// Adds the band at the horizon if the skies of `model` have one, or removes it.
    pub fn under(self, model: SkyModel) -> Self {
        let horizon = model.brightens().then(|| HorizonBand::new(self.n));
        Projection { horizon, ..self }
    }

    /// Returns the band at the horizon, whose coefficient follows those of the patches.
    pub fn horizon(&self) -> Option<&HorizonBand> {
        self.horizon.as_ref()
    }

    /// Returns the side of the texture, texels.
    pub fn side(&self) -> usize {
        self.n
    }

    /// Returns the solid angle of a texel, sr.
    pub fn texel_sr(&self) -> f64 {
        HEMISPHERE_SR / (self.n * self.n) as f64
    }

    /// Returns the number of patches.
    pub fn patches(&self) -> usize {
        self.solid_angle_sr.len()
    }

    /// Adds a texel's value to the patches that it covers, by its shares.
    #[inline]
    pub fn add(&self, texel: usize, value: f64, sums: &mut [f64]) {
        for &(patch, share) in self.of_texel(texel) {
            sums[usize::from(patch)] += value * f64::from(share);
        }
    }

    /// Returns the (patch, share of area) pairs of a texel; none for a texel that does not exist.
    pub fn of_texel(&self, texel: usize) -> &[(u16, f32)] {
        match self.starts.get(texel..) {
            Some([start, end, ..]) => self.entries.get(*start as usize..*end as usize).unwrap_or_default(),
            _ => &[],
        }
    }
}

/// Returns true if the texel at `corner` of an n x n texture lies on a diagonal of the square,
/// where the map has a crease.
fn creased(corner: DVec2, n: usize) -> bool {
    corner.x == corner.y || corner.x + corner.y + 1.0 == n as f64
}

/// Returns the patch that holds a texel wholly, if all four corners lie in it. Off the diagonals
/// texel and patch are convex.
fn whole(patches: &Patches, corner: DVec2, n: usize) -> Option<usize> {
    if creased(corner, n) {
        return None;
    }
    // A corner on a border between patches counts to the patch on the texel's side of it.
    const INSIDE: [f64; 2] = [1e-9, 1.0 - 1e-9];
    let at = |i: usize| {
        let (turns, z) = azimuth_and_z((corner + DVec2::new(INSIDE[i % 2], INSIDE[i / 2])) / n as f64);
        patches.patch_at(turns, z)
    };
    let first = at(0);
    // A patch that goes half round the sky, as the cap does, is not convex.
    (first + 1 < patches.len() && (1..4).all(|i| at(i) == first)).then_some(first)
}

/// Returns the mean direction of the texel at `corner` of an n x n texture, by Gauss rules: 2 x 2
/// points for n >= 64, more where texels are large and on the diagonals, where the map has a
/// crease.
fn mean_direction(corner: DVec2, n: usize) -> DVec3 {
    // 1 / (2 sqrt(3)): the two points of the Gauss-Legendre rule on an interval of length 1.
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    let rules = (64 / n).clamp(1, 8) * if creased(corner, n) { 4 } else { 1 };
    let at = |i: usize| ((i / 2) as f64 + 0.5 + [-GAUSS, GAUSS][i % 2]) / rules as f64;
    let points = (0..4 * rules * rules).map(|i| DVec2::new(at(i % (2 * rules)), at(i / (2 * rules))));
    let sum: DVec3 = points.map(|inside| direction_of((corner + inside) / n as f64)).sum();
    sum / (4 * rules * rules) as f64
}

/// Returns the points in a texel: a lattice by the golden section, shifted from texel to texel
/// ([`shift`]). Rows of patches are squares on the texture, so equal grids in all texels would
/// miscount them by up to 2 %, an unshifted lattice by 1 %.
fn lattice(count: usize) -> Vec<DVec2> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let point = |i: usize| DVec2::new((i as f64 + 0.5) / count as f64, (i as f64 + 0.5) * GOLDEN).fract();
    (0..count).map(point).collect()
}

fn shift(texel: usize) -> DVec2 {
    r2(texel as f64, DVec2::ZERO)
}

/// Returns the sum of two points of the unit square, wrapped.
fn wrapped(a: DVec2, b: DVec2) -> DVec2 {
    let one = |x: f64| if x >= 1.0 { x - 1.0 } else { x };
    DVec2::new(one(a.x + b.x), one(a.y + b.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::texel_direction;

    /// Shares of each texel sum to 1 (1e-6), patch solid angles to 2 pi (1e-9) and open
    /// coefficients to pi (1e-5 at n = 128), for three texture sides and the three subdivisions.
    #[test]
    fn shares_of_texels_sum_to_1() {
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

    /// A texel with all corners in one patch has all of 16 x 16 points in it: for n = 16 and 128
    /// and the three subdivisions.
    #[test]
    fn whole_texels_lie_in_one_patch() {
        let mut found = 0;
        for (count, n) in [(145, 16), (577, 16), (145, 128), (577, 128), (2305, 128)] {
            let patches = Patches::new(count).expect("known count");
            for texel in 0..n * n {
                let corner = DVec2::new((texel % n) as f64, (texel / n) as f64);
                if let Some(patch) = whole(&patches, corner, n) {
                    found += 1;
                    for i in 0..256 {
                        let inside = DVec2::new(f64::from(i % 16) + 0.5, f64::from(i / 16) + 0.5) / 16.0;
                        let direction = texel_direction(texel % n, texel / n, n, inside);
                        assert_eq!(patches.patch_of(direction), patch, "{count} {n} {texel}");
                    }
                }
            }
        }
        assert!(found > 20_000, "{found}");
    }

    /// At n = 128 and 8 x 8 points the texels count each of the 577 patches within 1 % of its exact
    /// solid angle.
    #[test]
    fn texels_count_patches_by_their_solid_angle() {
        let patches = Patches::new(577).expect("known count");
        let p = Projection::new(&patches, 128, 8);
        for (counted, exact) in p.solid_angle_sr.iter().zip(patches.solid_angles_sr()) {
            assert!((counted / exact - 1.0).abs() < 0.01, "{counted} {exact}");
        }
    }
}
