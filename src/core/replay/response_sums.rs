//! Sources of a few results on the response texture, added up. In: suns and skies. Out: reflected
//! irradiance of a receiver by one product of its response with a map.

use pulp::Arch;

use crate::layers::response::{CLASSES, Response};
use crate::replay::sun_texels::Sources;
use crate::site::material::Class;
use crate::sky::projection::Projection;
use crate::sky::sky_field::SkyField;

/// Number of partial sums that are added side by side, in a fixed order.
const SIDE_BY_SIDE: usize = 16;

/// Sums of the sources as one vector for each texel and result.
pub struct ResponseSums {
    /// Results with light.
    bins: Vec<usize>,
    /// `[result with light][axis][texel]`: irradiance x direction.
    maps: Vec<f32>,
    /// Number of values of a result: 3 n^2.
    len: usize,
}

impl ResponseSums {
    /// Adds up suns, and skies if there are any, on the response texture of a projection.
    pub fn new(suns: &Sources, skies: Option<&SkyField>, projection: &Projection) -> Self {
        let texels = projection.mean_directions.len();
        let mut sums = Vec::new();
        let mut add = |bin: usize, texel: usize, vector: [f64; 3]| {
            let place = bins_place(&mut sums, bin, 3 * texels);
            (0..3).for_each(|axis| place[axis * texels + texel] += vector[axis]);
        };
        suns.vectors(&mut add);
        if let Some(skies) = skies {
            skies.vectors(projection, |bin, texel, v| add(bin, texel, v.to_array()));
        }
        let maps = sums.iter().flat_map(|(_, map)| map.iter().map(|v| *v as f32)).collect();
        ResponseSums { bins: sums.iter().map(|(bin, _)| *bin).collect(), maps, len: 3 * texels }
    }

    /// Adds the irradiance by a response, or by one class of surfaces in it, to `out[result]`.
    pub fn irradiance(&self, response: &Response, class: Option<Class>, out: &mut [f64]) {
        let of_class = response.values.chunks((response.values.len() / CLASSES).max(1)).enumerate();
        for (_, values) in of_class.filter(|(i, _)| class.is_none_or(|class| class.index() == *i)) {
            for (bin, map) in self.bins.iter().zip(self.maps.chunks(self.len.max(1))) {
                out[*bin] += f64::from(Arch::new().dispatch(|| product(map, values)));
            }
        }
    }
}

/// Returns the map of a result, which is added if it is new.
fn bins_place(sums: &mut Vec<(usize, Vec<f64>)>, bin: usize, len: usize) -> &mut [f64] {
    let place = sums.iter().position(|(other, _)| *other == bin).unwrap_or_else(|| {
        sums.push((bin, vec![0.0; len]));
        sums.len() - 1
    });
    &mut sums[place].1
}

/// Returns the sum of the products of two lists of equal length.
#[inline(always)]
pub(super) fn product(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; SIDE_BY_SIDE];
    let (mut a, mut b) = (a.chunks_exact(SIDE_BY_SIDE), b.chunks_exact(SIDE_BY_SIDE));
    for (a, b) in a.by_ref().zip(b.by_ref()) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    let rest: f32 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f32>() + rest
}
