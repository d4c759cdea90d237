//! One tile of receivers under a series of conditions. In: the tile's decoded layers and the weather prepared once. Out: six
//! components and their total for every receiver and condition.

use glam::DVec3;
use ndarray::ArrayView2;
use rayon::prelude::*;

use super::bins::Bins;
use super::conditions::Condition;
use super::disc::SunLookup;
use super::patches::Patches;
use super::projection::Projection;
use super::response::respond;
use super::sky::SkyModel;
use super::values::TileValues;
use crate::layers::response::Response;
use crate::layers::sky::{BitSquare, half_texel};

const SUN_DIRECT: usize = 0;
const SKY_DIRECT: usize = 1;
const SUN_DIFFUSE: usize = 2;
const SKY_DIFFUSE: usize = 3;
const TOTAL: usize = 6;

/// Points per texel side when textures are projected on patches.
const PROJECTION_SAMPLES: usize = 8;

/// Skies added at a time.
const PART: usize = 64;

/// Sides of the textures that forcing is looked up in.
#[derive(Clone, Copy, Debug)]
pub struct TextureSides {
    pub sky_base: usize,
    pub sky_fine: usize,
    pub response: usize,
}

/// Decoded layers of one tile.
pub struct TileLayers {
    pub normals: Vec<DVec3>,
    pub sky: Vec<BitSquare>,
    pub responses: Vec<Response>,
}

/// Weather made ready once for all tiles.
pub struct Forcing {
    /// Number of results.
    bins: usize,
    /// (result, DNI x share of the condition's time x weight in the result, lookup), only where there is sun.
    suns: Vec<(usize, f64, SunLookup)>,
    /// Results with a sky, and their patch radiances: [result with a sky][patch], W/m2 sr x weight.
    sky_bins: Vec<usize>,
    radiances: Vec<f32>,
    patches: usize,
    sky_projection: Projection,
    response_projection: Projection,
}

impl Forcing {
    /// Looks up suns and skies of all conditions. Skies that add to one result are added before any receiver is asked.
    pub fn new(conditions: &[Condition], bins: &Bins, model: SkyModel, patches: &Patches, sides: TextureSides) -> Self {
        let suns = conditions
            .par_iter()
            .zip(&bins.of_condition)
            .filter(|(c, _)| c.dni_w_m2 > 0.0)
            .flat_map_iter(|(c, &(bin, weight))| {
                c.suns.iter().filter_map(move |sun| {
                    let lookup = SunLookup::new(sun.sun, sides.sky_fine, sides.response)?;
                    Some((bin, c.dni_w_m2 * sun.weight * weight, lookup))
                })
            })
            .collect();
        let mut skies: Vec<(usize, usize)> = (0..conditions.len().min(bins.of_condition.len()))
            .filter(|&i| conditions[i].dhi_w_m2 > 0.0)
            .map(|i| (bins.of_condition[i].0, i))
            .collect();
        skies.sort_unstable();
        let sky_projection = Projection::new(patches, sides.sky_base, PROJECTION_SAMPLES);
        let open = &sky_projection.open_horizontal_sr;
        // Parts of a fixed size, added in order: the sum does not depend on the number of threads.
        let parts: Vec<&[(usize, usize)]> =
            skies.chunk_by(|a, b| a.0 == b.0).flat_map(|of_bin| of_bin.chunks(PART)).collect();
        let sums: Vec<(usize, Vec<f64>)> = parts
            .into_par_iter()
            .map(|part| {
                let mut sum = vec![0.0_f64; patches.len()];
                for &(_, i) in part {
                    let radiances = patches.radiances(model, &conditions[i], open);
                    sum.iter_mut().zip(radiances).for_each(|(sum, l)| *sum += l * bins.of_condition[i].1);
                }
                (part[0].0, sum)
            })
            .collect();
        let mut sky_bins = Vec::new();
        let mut radiances: Vec<f32> = Vec::new();
        for of_bin in sums.chunk_by(|a, b| a.0 == b.0) {
            sky_bins.push(of_bin[0].0);
            let patch_sum = |patch: usize| of_bin.iter().map(|(_, sum)| sum[patch]).sum::<f64>() as f32;
            radiances.extend((0..patches.len()).map(patch_sum));
        }
        Forcing {
            bins: bins.count,
            suns,
            sky_bins,
            radiances,
            patches: patches.len(),
            sky_projection,
            response_projection: Projection::new(patches, sides.response, PROJECTION_SAMPLES),
        }
    }

    /// Irradiance of every receiver of a tile.
    pub fn replay(&self, tile: &TileLayers) -> TileValues {
        let receivers = tile.normals.len();
        let mut out = TileValues::new(receivers, self.bins);
        for receiver in 0..receivers {
            self.add_sun(tile, receiver, &mut out);
        }
        self.add_sky(tile, &mut out);
        let mut total = vec![0.0_f32; self.bins];
        for receiver in 0..receivers {
            total.fill(0.0);
            for component in 0..TOTAL {
                total.iter_mut().zip(out.row(component, receiver)).for_each(|(total, v)| *total += v);
            }
            out.row_mut(TOTAL, receiver).copy_from_slice(&total);
        }
        out
    }

    fn add_sun(&self, tile: &TileLayers, receiver: usize, out: &mut TileValues) {
        let (normal, sky) = (tile.normals[receiver], &tile.sky[receiver]);
        let total = tile.responses[receiver].total();
        let (mut direct, mut diffuse) = (vec![0.0_f64; self.bins], vec![0.0_f64; self.bins]);
        for (bin, dni, sun) in &self.suns {
            let cos = normal.dot(sun.direction);
            if cos > 0.0 {
                let visible: f32 =
                    sun.disc.iter().filter(|(c, r, _)| sky.get(*c as usize, *r as usize)).map(|t| t.2).sum();
                direct[*bin] += dni * cos * f64::from(visible);
            }
            diffuse[*bin] += dni * respond(&total, sun.direction, &sun.response).max(0.0);
        }
        for (component, sums) in [(SUN_DIRECT, direct), (SUN_DIFFUSE, diffuse)] {
            out.row_mut(component, receiver).iter_mut().zip(sums).for_each(|(out, sum)| *out = sum as f32);
        }
    }

    /// Both sky components: (receivers x patches) times (patches x results).
    fn add_sky(&self, tile: &TileLayers, out: &mut TileValues) {
        let (rows, columns) = (tile.normals.len() * 2, self.sky_bins.len());
        if rows == 0 || columns == 0 {
            return;
        }
        let mut coefficients = Vec::with_capacity(rows * self.patches);
        for (normal, sky) in tile.normals.iter().zip(&tile.sky) {
            coefficients.extend(self.direct_coefficients(*normal, sky));
        }
        for response in &tile.responses {
            coefficients.extend(self.response_coefficients(response));
        }
        // Shapes follow from how the two vectors were filled, so neither view can fail.
        let (Ok(a), Ok(b)) = (
            ArrayView2::from_shape((rows, self.patches), &coefficients),
            ArrayView2::from_shape((columns, self.patches), &self.radiances),
        ) else {
            return;
        };
        let product = a.dot(&b.t());
        for (row, values) in product.rows().into_iter().enumerate() {
            let component = if row < tile.normals.len() { SKY_DIRECT } else { SKY_DIFFUSE };
            let target = out.row_mut(component, row % tile.normals.len());
            for (&bin, &v) in self.sky_bins.iter().zip(values.iter()) {
                target[bin] = v.max(0.0);
            }
        }
    }

    /// Irradiance per unit radiance of each patch, sr: visible share x cosine x solid angle of the texels.
    fn direct_coefficients(&self, normal: DVec3, sky: &BitSquare) -> Vec<f32> {
        let cosines = visible_cosines(normal, sky, &self.sky_projection.mean_directions);
        self.gather(&self.sky_projection, cosines)
    }

    /// The same for light that is reflected: d . G x solid angle.
    fn response_coefficients(&self, response: &Response) -> Vec<f32> {
        let total = response.total();
        let directions = &self.response_projection.mean_directions;
        let values = directions.iter().enumerate().map(|(t, d)| {
            let at = |axis: usize| f64::from(total[axis * directions.len() + t]);
            d.x * at(0) + d.y * at(1) + d.z * at(2)
        });
        self.gather(&self.response_projection, values)
    }

    /// Sums texels into patches: value x share of the texel x its solid angle.
    fn gather(&self, projection: &Projection, values: impl IntoIterator<Item = f64>) -> Vec<f32> {
        let mut sums = vec![0.0_f64; self.patches];
        for (texel, value) in values.into_iter().enumerate().filter(|(_, v)| *v != 0.0) {
            for &(patch, share) in projection.of_texel(texel) {
                sums[usize::from(patch)] += value * f64::from(share);
            }
        }
        sums.into_iter().map(|s| (s * projection.texel_sr()) as f32).collect()
    }
}

/// Per base texel: visible share x mean cosine of the part in front of the surface. `directions` of the base texels.
pub fn visible_cosines(normal: DVec3, sky: &BitSquare, directions: &[DVec3]) -> Vec<f64> {
    let n = directions.len().isqrt();
    let block = sky.side() / n;
    let half = half_texel(n);
    directions
        .iter()
        .enumerate()
        .map(|(t, d)| {
            let cos = mean_positive(normal.dot(*d), half);
            if cos == 0.0 {
                return 0.0;
            }
            let visible = sky.count_block(block, t % n, t / n);
            cos * f64::from(visible) / (block * block) as f64
        })
        .collect()
}

/// Cosine-weighted share of a receiver's hemisphere that is sky.
pub fn sky_view_factor(normal: DVec3, sky: &BitSquare, directions: &[DVec3]) -> f64 {
    visible_cosines(normal, sky, directions).iter().sum::<f64>() * 2.0 / directions.len() as f64
}

/// Mean of max(x, 0) for x spread evenly over `centre` +- `half`: the cosine of a texel that the surface's plane cuts.
fn mean_positive(centre: f64, half: f64) -> f64 {
    if centre >= half {
        centre
    } else if centre <= -half {
        0.0
    } else {
        (centre + half) * (centre + half) / (4.0 * half)
    }
}
