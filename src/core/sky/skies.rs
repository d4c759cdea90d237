//! Skies of a series of conditions as patch radiances. In: conditions and the results that they add
//! to; then receivers' sky and response textures. Out: coefficients of the patches, and irradiances
//! by one dense product for a tile.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::DVec3;
use ndarray::ArrayView2;
use rayon::prelude::*;

use crate::layers::sky::half_texel;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Number of skies that a task sums up.
const PART: usize = 64;

/// Sums of radiances by way and result.
type Sums = BTreeMap<(usize, usize), Vec<f64>>;

/// Patch radiances of the results that have a sky, followed by the irradiance of a wall from the
/// band at the horizon, if the model has one.
#[derive(Default)]
pub struct Skies {
    /// Results with a sky.
    bins: Vec<usize>,
    /// `[result with a sky][source]`: radiances of patches, W/(m2 sr) x weight, then the band.
    radiances: Vec<f32>,
    /// Number of sources: patches, and the band if there is one.
    sources: usize,
}

impl Skies {
    /// Returns the skies for each of several ways to add conditions to results. Skies that add to
    /// one result are summed here, before any receiver is read. `open_horizontal_sr` must come from
    /// the projection that makes the coefficients.
    pub fn new(
        conditions: &[Condition],
        ways: &[&Bins],
        model: SkyModel,
        patches: &Patches,
        open_horizontal_sr: &[f64],
    ) -> Vec<Self> {
        let sources = patches.len() + usize::from(model.brightens());
        // Parts have a fixed size and are added in order, so the sum does not depend on the number
        // of threads.
        let parts: Vec<Sums> = (0..conditions.len().div_ceil(PART))
            .into_par_iter()
            .map(|part| {
                let mut sums = Sums::new();
                for (i, condition) in conditions.iter().enumerate().skip(part * PART).take(PART) {
                    if condition.dhi_w_m2 > 0.0 {
                        let mut radiances = patches.radiances(model, condition, open_horizontal_sr);
                        if model.brightens() {
                            radiances.push(model.parts(condition).horizon_w_m2);
                        }
                        for (way, bins) in ways.iter().enumerate() {
                            let (bin, weight) = bins.of_condition[i];
                            let weight = weight * condition.scale.sky;
                            if weight != 0.0 {
                                let sum = sums.entry((way, bin)).or_insert_with(|| vec![0.0; sources]);
                                sum.iter_mut().zip(&radiances).for_each(|(sum, l)| *sum += l * weight);
                            }
                        }
                    }
                }
                sums
            })
            .collect();
        let mut sums = Sums::new();
        for (place, part) in parts.into_iter().flatten() {
            match sums.entry(place) {
                Entry::Vacant(free) => {
                    free.insert(part);
                }
                Entry::Occupied(mut sum) => sum.get_mut().iter_mut().zip(part).for_each(|(sum, l)| *sum += l),
            }
        }
        let none = || Skies { bins: Vec::new(), radiances: Vec::new(), sources };
        let mut found: Vec<Skies> = ways.iter().map(|_| none()).collect();
        for ((way, bin), sum) in sums {
            found[way].bins.push(bin);
            found[way].radiances.extend(sum.into_iter().map(|l| l as f32));
        }
        found
    }

    /// Returns true if no result has a sky.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// Returns the results with a sky.
    pub fn bins(&self) -> &[usize] {
        &self.bins
    }

    /// Iterates over the sources of each result with a sky.
    pub fn radiances(&self) -> impl Iterator<Item = &[f32]> {
        self.radiances.chunks(self.sources.max(1))
    }

    /// Calls `each(receiver, result, irradiance)` for coefficients `[receiver][source]`: (receivers
    /// x sources) times (sources x results).
    pub fn irradiance(&self, coefficients: &[f32], mut each: impl FnMut(usize, usize, f32)) {
        let shape = (coefficients.len() / self.sources.max(1), self.sources);
        if self.bins.len() == 1 {
            // One result is summed in a fixed order, equal on every processor: the sums of
            // overviews are stored.
            for (receiver, coefficients) in coefficients.chunks_exact(self.sources.max(1)).enumerate() {
                for (&bin, radiances) in self.bins.iter().zip(self.radiances()) {
                    let pairs = coefficients.iter().zip(radiances);
                    each(receiver, bin, pairs.map(|(c, l)| f64::from(*c) * f64::from(*l)).sum::<f64>() as f32);
                }
            }
            return;
        }
        // The shapes follow from how the two vectors were filled, so neither view can fail.
        let (Ok(a), Ok(b)) = (
            ArrayView2::from_shape(shape, coefficients),
            ArrayView2::from_shape((self.bins.len(), self.sources), &self.radiances),
        ) else {
            return;
        };
        let product = a.dot(&b.t());
        // The product is row-major, as are both factors.
        let rows = product.as_slice().into_iter().flat_map(|values| values.chunks_exact(self.bins.len().max(1)));
        for (receiver, values) in rows.enumerate() {
            self.bins.iter().zip(values).for_each(|(&bin, &v)| each(receiver, bin, v));
        }
    }
}

/// Appends the irradiance per unit radiance of each patch, sr: visible share x cosine x solid angle
/// of the texels. Then appends the coefficient of the band at the horizon, if there is one.
pub fn sky_coefficients(projection: &Projection, normal: DVec3, sky: &SkyBitmap, out: &mut Vec<f32>) {
    let half = half_texel(projection.side());
    let mut sums = vec![0.0_f64; projection.patches()];
    sky.for_visible(|texel, share| {
        let cos = mean_positive(normal.dot(projection.mean_directions[texel]), half);
        if cos > 0.0 {
            projection.add(texel, cos * share, &mut sums);
        }
    });
    out.extend(sums.into_iter().map(|sum| (sum * projection.texel_sr()) as f32));
    out.extend(projection.horizon().map(|band| band.seen(normal, |texel| sky.share(texel)) as f32));
}

/// Appends the coefficients of reflected light: d . G x solid angle, and that of the band at the
/// horizon, if there is one; `response` is `[texel][axis]`.
pub fn response_coefficients(projection: &Projection, response: &[[f32; 3]], out: &mut Vec<f32>) {
    let mut sums = vec![0.0_f64; projection.patches()];
    for (texel, (d, g)) in projection.mean_directions.iter().zip(response).enumerate() {
        let value = d.dot(DVec3::from(g.map(f64::from)));
        if value != 0.0 {
            projection.add(texel, value, &mut sums);
        }
    }
    out.extend(sums.into_iter().map(|sum| (sum * projection.texel_sr()) as f32));
    out.extend(projection.horizon().map(|band| band.reflected(response) as f32));
}

/// Returns the mean of max(x, 0) for x spread evenly over `centre` +- `half`: the cosine of a texel
/// that the surface's plane cuts.
#[inline(always)]
pub fn mean_positive(centre: f64, half: f64) -> f64 {
    if centre >= half {
        centre
    } else if centre <= -half {
        0.0
    } else {
        (centre + half) * (centre + half) / (4.0 * half)
    }
}
