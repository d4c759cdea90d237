//! The suns of a series of conditions, looked up once for all receivers. In: conditions and where they add to. Out: irradiance of a
//! receiver whose sky and response textures are at hand.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::bins::Bins;
use super::conditions::Condition;
use super::disc::disc_texels;
use super::tile::TextureSides;
use crate::hemisphere::bilinear;
use crate::layers::mosaic::{Mosaic, Texel};

/// One position of the sun.
#[derive(Clone, Debug)]
struct Sun {
    bin: usize,
    /// DNI x share of the condition's time x weight in the result.
    strength: f64,
    direction: DVec3,
    /// Its [`Part`]s.
    parts: Range<usize>,
}

/// The part of a sun's disc in one base texel of the sky texture.
#[derive(Clone, Debug)]
struct Part {
    column: u32,
    row: u32,
    /// Share of the disc.
    share: f32,
    /// Its texels in [`Suns::fine`].
    fine: Range<usize>,
}

/// Suns made ready for receivers' textures.
pub struct Suns {
    suns: Vec<Sun>,
    parts: Vec<Part>,
    /// Place in a base texel's bits, and share of the disc.
    fine: Vec<(u32, f32)>,
    sources: Vec<Source>,
}

/// The suns of one result on the response texture.
#[derive(Clone, Debug)]
struct Source {
    bin: usize,
    /// Texels, and what their vectors are multiplied with: the sum of strength x bilinear weight x direction.
    texels: Vec<(u32, [f32; 3])>,
}

impl Suns {
    /// Looks up all suns of all conditions with DNI.
    pub fn new(conditions: &[Condition], bins: &Bins, sides: TextureSides) -> Self {
        let block = (sides.sky_fine / sides.sky_base).max(1) as u32;
        let mut found = Suns { suns: Vec::new(), parts: Vec::new(), fine: Vec::new(), sources: Vec::new() };
        let lit = conditions.par_iter().zip(&bins.of_condition).filter(|(c, _)| c.dni_w_m2 > 0.0);
        let discs: Vec<(Sun, Vec<_>)> = lit
            .flat_map_iter(|(c, &(bin, weight))| {
                c.suns.iter().filter(|instant| instant.sun.z > 0.0).map(move |instant| {
                    let strength = c.dni_w_m2 * instant.weight * weight;
                    let sun = Sun { bin, strength, direction: instant.sun, parts: 0..0 };
                    (sun, disc_texels(instant.sun, sides.sky_fine))
                })
            })
            .collect();
        for (sun, mut disc) in discs {
            let first = found.parts.len();
            disc.sort_by_key(|t| (t.1 / block, t.0 / block));
            for part in disc.chunk_by(|a, b| (a.0 / block, a.1 / block) == (b.0 / block, b.1 / block)) {
                let start = found.fine.len();
                found.fine.extend(part.iter().map(|&(c, r, share)| (r % block * block + c % block, share)));
                found.parts.push(Part {
                    column: part[0].0 / block,
                    row: part[0].1 / block,
                    share: part.iter().map(|t| t.2).sum(),
                    fine: start..found.fine.len(),
                });
            }
            found.suns.push(Sun { parts: first..found.parts.len(), ..sun });
        }
        found.sources = sources(&found.suns, sides.response);
        found
    }

    /// Adds the direct irradiance of a receiver with this normal and sky to `out[result]`.
    pub fn direct(&self, normal: DVec3, sky: &Mosaic, out: &mut [f64]) {
        for sun in &self.suns {
            let cos = normal.dot(sun.direction);
            if cos > 0.0 {
                let visible: f32 = self.parts[sun.parts.clone()].iter().map(|part| self.visible(part, sky)).sum();
                out[sun.bin] += sun.strength * cos * f64::from(visible);
            }
        }
    }

    /// Share of the disc that is seen in a base texel.
    #[inline]
    fn visible(&self, part: &Part, sky: &Mosaic) -> f32 {
        match sky.texel(part.column as usize, part.row as usize) {
            Texel::Closed => 0.0,
            Texel::Open => part.share,
            Texel::Mixed(bits) => {
                let seen = |&&(i, _): &&(u32, f32)| bits[i as usize / 64] >> (i % 64) & 1 == 1;
                self.fine[part.fine.clone()].iter().filter(seen).map(|t| t.1).sum()
            }
        }
    }

    /// Adds the reflected irradiance of a receiver with this response, `[texel][axis]`, to `out[result]`.
    pub fn diffuse(&self, response: &[[f32; 3]], out: &mut [f64]) {
        for Source { bin, texels } in &self.sources {
            let sum: f64 = texels
                .iter()
                .map(|&(t, s)| {
                    let g = response[t as usize];
                    f64::from(s[0] * g[0] + s[1] * g[1] + s[2] * g[2])
                })
                .sum();
            out[*bin] += sum;
        }
    }
}

/// Collects what the suns of each result multiply the texels of an n x n response texture with. Light is linear in its sources, so
/// those of a sum are added before any receiver is asked.
fn sources(suns: &[Sun], n: usize) -> Vec<Source> {
    let corners =
        |sun: &Sun| bilinear(sun.direction, n).map(|(t, w)| (sun.bin, t as u32, sun.direction * (sun.strength * w)));
    let mut terms: Vec<(usize, u32, DVec3)> = suns.iter().flat_map(corners).collect();
    // Stable: terms of one texel are added in the order of the conditions.
    terms.sort_by_key(|term| (term.0, term.1));
    let texel = |terms: &[(usize, u32, DVec3)]| {
        (terms[0].1, terms.iter().map(|term| term.2).sum::<DVec3>().as_vec3().to_array())
    };
    let of_bin = |terms: &[(usize, u32, DVec3)]| Source {
        bin: terms[0].0,
        texels: terms.chunk_by(|a, b| a.1 == b.1).map(texel).collect(),
    };
    terms.chunk_by(|a, b| a.0 == b.0).map(of_bin).collect()
}
