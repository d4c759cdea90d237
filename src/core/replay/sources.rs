//! The suns of a series of conditions on the response texture. In: conditions and where they add to. Out: reflected irradiance of a
//! receiver whose response is at hand.

use glam::DVec3;

use crate::hemisphere::bilinear;
use crate::sky::model::SkyModel;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Suns made ready for receivers' responses. Light is linear in its sources, so those of a sum are added before any receiver is asked.
pub struct Sources {
    results: Vec<Source>,
}

/// The suns of one result.
struct Source {
    bin: usize,
    /// Texels, and what their vectors are multiplied with: the sum of normal irradiance x share of the time x weight in the result x bilinear
    /// weight x direction.
    texels: Vec<(u32, [f32; 3])>,
}

impl Sources {
    /// Looks up all suns of all conditions with DNI on an n x n response texture.
    pub fn new(conditions: &[Condition], bins: &Bins, n: usize) -> Self {
        Sources::of(conditions, bins, n, |c| c.dni_w_m2)
    }

    /// The same for the light that a model's skies send from where the suns are; most have none.
    pub fn circumsolar(conditions: &[Condition], bins: &Bins, n: usize, model: SkyModel) -> Self {
        let conditions = if model.brightens() { conditions } else { &[] };
        Sources::of(conditions, bins, n, |c| model.parts(c).circumsolar_w_m2)
    }

    fn of(conditions: &[Condition], bins: &Bins, n: usize, normal_w_m2: impl Fn(&Condition) -> f64) -> Self {
        let mut terms: Vec<(usize, u32, DVec3)> = Vec::new();
        for (condition, &(bin, weight)) in conditions.iter().zip(&bins.of_condition) {
            let strength = normal_w_m2(condition) * weight;
            if strength != 0.0 {
                for instant in condition.suns.iter().filter(|instant| instant.sun.z > 0.0) {
                    let corners = bilinear(instant.sun, n);
                    let term = |(t, w)| (bin, t as u32, instant.sun * (strength * instant.weight * w));
                    terms.extend(corners.map(term));
                }
            }
        }
        // Stable: terms of one texel are added in the order of the conditions.
        terms.sort_by_key(|term| (term.0, term.1));
        let texel = |terms: &[(usize, u32, DVec3)]| {
            (terms[0].1, terms.iter().map(|term| term.2).sum::<DVec3>().as_vec3().to_array())
        };
        let of_bin = |terms: &[(usize, u32, DVec3)]| Source {
            bin: terms[0].0,
            texels: terms.chunk_by(|a, b| a.1 == b.1).map(texel).collect(),
        };
        Sources { results: terms.chunk_by(|a, b| a.0 == b.0).map(of_bin).collect() }
    }

    /// Whether there is no sun.
    pub fn is_empty(&self) -> bool {
        self.results.is_empty()
    }

    /// Calls `each(result, texel, vector)` for all of their light.
    pub fn vectors(&self, mut each: impl FnMut(usize, usize, [f64; 3])) {
        for Source { bin, texels } in &self.results {
            texels.iter().for_each(|(texel, v)| each(*bin, *texel as usize, v.map(f64::from)));
        }
    }

    /// Adds the reflected irradiance of a receiver with this response, `[texel][axis]`, to `out[result]`.
    pub fn irradiance(&self, response: &[[f32; 3]], out: &mut [f64]) {
        for Source { bin, texels } in &self.results {
            let term = |&(t, s): &(u32, [f32; 3])| {
                let g = response[t as usize];
                f64::from(s[0] * g[0] + s[1] * g[1] + s[2] * g[2])
            };
            out[*bin] += texels.iter().map(term).sum::<f64>();
        }
    }
}
