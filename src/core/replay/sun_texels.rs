//! Suns of a series of conditions on the response texture. In: suns and their results. Out:
//! reflected irradiance of a receiver with a known response.

use glam::DVec3;

use crate::hemisphere::bilinear;
use crate::replay::sun_sample::SunSample;

/// Suns prepared for the responses of receivers. Light is linear in its sources, so the suns of a
/// sum are added up before any receiver is computed.
pub struct Sources {
    results: Vec<Source>,
}

/// Suns of one result.
struct Source {
    bin: usize,
    /// Texels, and the factors of their response vectors: the sum of normal irradiance x share of
    /// the time x weight in the result x bilinear weight x direction.
    texels: Vec<(u32, [f32; 3])>,
}

impl Sources {
    /// Looks up suns on an n x n response texture.
    pub fn new(suns: &[SunSample], n: usize) -> Self {
        let terms = |sun: &SunSample| {
            let SunSample { bin, strength, direction } = *sun;
            bilinear(direction, n).map(|(t, w)| (bin, t as u32, direction * (strength * w)))
        };
        let mut terms: Vec<(usize, u32, DVec3)> = suns.iter().flat_map(terms).collect();
        // The sort is stable: terms of one texel are added in the order of the suns.
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

    /// Returns true if there is no sun.
    pub fn is_empty(&self) -> bool {
        self.results.is_empty()
    }

    /// Calls `each(result, texel, vector)` for all light of the suns.
    pub fn vectors(&self, mut each: impl FnMut(usize, usize, [f64; 3])) {
        for Source { bin, texels } in &self.results {
            texels.iter().for_each(|(texel, v)| each(*bin, *texel as usize, v.map(f64::from)));
        }
    }

    /// Adds the reflected irradiance of a receiver with this response, `[texel][axis]`, to
    /// `out[result]`.
    pub fn irradiance(&self, response: &[[f32; 3]], out: &mut [f32]) {
        for Source { bin, texels } in &self.results {
            let term = |&(t, s): &(u32, [f32; 3])| {
                let g = response[t as usize];
                f64::from(s[0] * g[0] + s[1] * g[1] + s[2] * g[2])
            };
            out[*bin] += texels.iter().map(term).sum::<f64>() as f32;
        }
    }
}
