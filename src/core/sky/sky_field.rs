//! Skies of a few results as radiances of texels. In: patch radiances and a projection. Out: the
//! irradiance of a receiver under each sky, without a coefficient for every patch. For few results
//! that is cheaper.

use glam::DVec3;
use pulp::Arch;

use crate::layers::sky::half_texel;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::sky::projection::Projection;
use crate::sky::skies::{Skies, mean_positive};

/// Largest number of results with a sky for which texels are cheaper than patches.
pub const FEW: usize = 48;

/// Radiances of texels times their solid angle.
pub struct SkyField {
    /// Results with a sky.
    bins: Vec<usize>,
    /// `[texel][result with a sky]`, W/m2 x weight.
    radiances: Vec<f64>,
    /// `[result with a sky]`: irradiance of an open wall from the band at the horizon, W/m2 x
    /// weight; empty if there is no band.
    horizons: Vec<f64>,
}

impl SkyField {
    /// Returns the radiances of the texels, or `None` for more than [`FEW`] results.
    pub fn new(skies: &Skies, projection: &Projection) -> Option<Self> {
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

    /// Calls `each(result, texel, vector)`. The product of the vectors with a receiver's response
    /// is its irradiance from the sky by reflection.
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
