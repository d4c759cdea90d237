//! The skies of a few results as radiances of texels. In: patch radiances and a projection. Out: what a receiver gets of each, without a
//! coefficient for every patch: for few results that is cheaper.

use glam::DVec3;
use pulp::Arch;

use crate::layers::sky::half_texel;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::sky::projection::Projection;
use crate::sky::skies::{Skies, mean_positive};

/// Up to so many results with a sky, texels are cheaper than patches.
pub const FEW: usize = 48;

/// Radiances of texels x their solid angle.
pub struct SkyField {
    bins: Vec<usize>,
    /// `[texel][result with a sky]`, W/m2 x weight.
    radiances: Vec<f64>,
    /// `[result with a sky]`: what the band at the horizon gives an open wall; empty if there is none.
    horizons: Vec<f64>,
}

impl SkyField {
    /// `None` if there are many results.
    pub fn of(skies: &Skies, projection: &Projection) -> Option<Self> {
        let bins = skies.bins().to_vec();
        if bins.len() > FEW {
            return None;
        }
        let texels = projection.mean_directions.len();
        let mut radiances = vec![0.0; texels * bins.len()];
        for (texel, out) in radiances.chunks_mut(bins.len().max(1)).enumerate() {
            for (out, of_result) in out.iter_mut().zip(skies.radiances()) {
                let of = |(patch, share): &(u16, f32)| f64::from(*share) * f64::from(of_result[usize::from(*patch)]);
                *out = projection.of_texel(texel).iter().map(of).sum::<f64>() * projection.texel_sr();
            }
        }
        let patches = projection.patches();
        let horizons = skies.radiances().filter_map(|of_result| of_result.get(patches).map(|l| f64::from(*l)));
        let horizons = if projection.horizon().is_some() { horizons.collect() } else { Vec::new() };
        Some(SkyField { bins, radiances, horizons })
    }

    /// Calls `each(result, irradiance)` for a receiver with this normal and sky.
    pub fn irradiance(
        &self,
        projection: &Projection,
        normal: DVec3,
        sky: &SkyBitmap,
        mut each: impl FnMut(usize, f64),
    ) {
        let half = half_texel(projection.side());
        let mut sums = vec![0.0_f64; self.bins.len()];
        let count = sums.len();
        let add = |texel: usize, share: f64| {
            let cos = mean_positive(normal.dot(projection.mean_directions[texel]), half) * share;
            if cos > 0.0 {
                let radiances = &self.radiances[texel * count..][..count];
                sums.iter_mut().zip(radiances).for_each(|(sum, l)| *sum += cos * l);
            }
        };
        Arch::new().dispatch(|| sky.for_visible(add));
        if let Some(band) = projection.horizon().filter(|_| !self.horizons.is_empty()) {
            let seen = band.seen(normal, |texel| sky.share(texel));
            sums.iter_mut().zip(&self.horizons).for_each(|(sum, l)| *sum += seen * l);
        }
        self.bins.iter().zip(sums).for_each(|(bin, sum)| each(*bin, sum));
    }

    /// Vectors whose product with a response is what a receiver gets of each result by way of surfaces: `each(result, texel, vector)`.
    pub fn vectors(&self, projection: &Projection, mut each: impl FnMut(usize, usize, DVec3)) {
        let count = self.bins.len();
        for (texel, d) in projection.mean_directions.iter().enumerate() {
            let radiances = &self.radiances[texel * count..][..count];
            self.bins.iter().zip(radiances).for_each(|(bin, l)| each(*bin, texel, *d * *l));
        }
        for found in projection.horizon().into_iter().flat_map(|band| band.texels()) {
            let flat = found.flat.extend(0.0);
            self.bins.iter().zip(&self.horizons).for_each(|(bin, l)| each(*bin, found.texel, flat * *l));
        }
    }
}
