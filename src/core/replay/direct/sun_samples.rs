//! Suns one by one. In: positions of suns, and their strengths. Out: direct irradiance of receivers
//! with known skies, for any number of results.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::{BaseTexels, Texel};
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::sky_masks::{LANES, SkyMasks};
use crate::replay::direct::specular::MirrorView;
use crate::replay::sun_sample::SunSample;
use crate::sky::disc::disc_texels;

/// Position of the sun, and its light.
#[derive(Clone, Debug)]
struct Sun {
    bin: usize,
    /// Normal irradiance x share of the condition's time x weight in the result.
    strength: f64,
    direction: DVec3,
    /// Range of the sun's parts in `SunSamples::parts`.
    parts: Range<usize>,
}

/// The part of a sun's disc in one base texel of the sky texture.
#[derive(Clone, Debug)]
struct Part {
    column: u32,
    row: u32,
    /// Share of the disc that lies in the base texel.
    share: f32,
    /// Range of its fine texels in [`SunSamples::fine`].
    fine: Range<usize>,
    /// Range of its fine texels as bits in [`SunSamples::words`].
    words: Range<usize>,
}

/// Suns of one result in one base texel.
#[derive(Clone, Debug)]
struct Passage {
    bin: usize,
    /// Number of the base texel, row-major.
    texel: usize,
    /// Sum of strength x share of the disc x direction.
    whole: DVec3,
    /// Range of the suns and their parts in [`SunSamples::passing`].
    passing: Range<usize>,
}

/// Part of a sun's disc in one base texel, for code that adds up by itself.
pub struct DiscPart<'s> {
    /// Normal irradiance x direction of the sun.
    pub light: DVec3,
    /// Column and row of the base texel.
    pub column: u32,
    pub row: u32,
    /// Share of the disc in the base texel, and by fine texel: place in the base texel, share.
    pub share: f32,
    pub fine: &'s [(u32, f32)],
}

/// Suns one by one, with the parts of their discs.
#[derive(Default)]
pub struct SunSamples {
    suns: Vec<Sun>,
    parts: Vec<Part>,
    /// Place in a base texel's bits, and share of the disc.
    fine: Vec<(u32, f32)>,
    /// Number of a word of a base texel's bits, and the bits of it that a disc covers.
    words: Vec<(u32, u64)>,
    /// Passages, ordered by run of suns of one result, then by texel.
    passages: Vec<Passage>,
    /// Number of the sun, number of the part.
    passing: Vec<(u32, u32)>,
}

impl SunSamples {
    /// Looks up the discs of suns, which are in the order of their results.
    pub fn new(suns: Vec<SunSample>, sides: TextureSides) -> Self {
        let block = (sides.sky_fine / sides.sky_base).max(1) as u32;
        let discs: Vec<_> = suns.par_iter().map(|sun| disc_texels(sun.direction, sides.sky_fine)).collect();
        let mut found = SunSamples::default();
        for (sun, mut disc) in suns.into_iter().zip(discs) {
            let first = found.parts.len();
            // One part a base texel, so that a receiver looks up each base texel once.
            disc.sort_by_key(|t| (t.1 / block, t.0 / block));
            for part in disc.chunk_by(|a, b| (a.0 / block, a.1 / block) == (b.0 / block, b.1 / block)) {
                let start = found.fine.len();
                found.fine.extend(part.iter().map(|&(c, r, share)| (r % block * block + c % block, share)));
                // By whole words, `share` decides most discs without looking at each texel.
                let first_word = found.words.len();
                for &(place, _) in &found.fine[start..] {
                    match found.words[first_word..].iter_mut().find(|(word, _)| *word == place / 64) {
                        Some((_, bits)) => *bits |= 1 << (place % 64),
                        None => found.words.push((place / 64, 1 << (place % 64))),
                    }
                }
                found.parts.push(Part {
                    column: part[0].0 / block,
                    row: part[0].1 / block,
                    share: part.iter().map(|t| t.2).sum(),
                    fine: start..found.fine.len(),
                    words: first_word..found.words.len(),
                });
            }
            found.suns.push(Sun {
                bin: sun.bin,
                strength: sun.strength,
                direction: sun.direction,
                parts: first..found.parts.len(),
            });
        }
        found.add_passages(sides.sky_base);
        found
    }

    /// Returns true if there is no sun.
    pub fn is_empty(&self) -> bool {
        self.suns.is_empty()
    }

    /// Returns the parts of all discs.
    pub fn parts(&self) -> impl Iterator<Item = DiscPart<'_>> {
        self.suns.iter().flat_map(|sun| {
            self.parts[sun.parts.clone()].iter().map(|part| DiscPart {
                light: sun.direction * sun.strength,
                column: part.column,
                row: part.row,
                share: part.share,
                fine: &self.fine[part.fine.clone()],
            })
        })
    }

    /// Adds up the suns of each result by base texel. `side` is the number of base texels a side.
    fn add_passages(&mut self, side: usize) {
        let mut first = 0;
        for of_bin in self.suns.chunk_by(|a, b| a.bin == b.bin) {
            let numbered = of_bin.iter().enumerate().flat_map(|(i, sun)| sun.parts.clone().map(move |part| (i, part)));
            let place = |part: usize| self.parts[part].row as usize * side + self.parts[part].column as usize;
            let mut found: Vec<(usize, usize, usize)> = numbered.map(|(i, part)| (place(part), i, part)).collect();
            // No two entries name the same part, so an unstable sort has one result.
            found.sort_unstable();
            for passing in found.chunk_by(|a, b| a.0 == b.0) {
                let start = self.passing.len();
                self.passing.extend(passing.iter().map(|&(_, i, part)| ((first + i) as u32, part as u32)));
                let light = |&(_, i, part): &(usize, usize, usize)| {
                    of_bin[i].direction * (of_bin[i].strength * f64::from(self.parts[part].share))
                };
                self.passages.push(Passage {
                    bin: of_bin[0].bin,
                    texel: passing[0].0,
                    whole: passing.iter().map(light).sum(),
                    passing: start..self.passing.len(),
                });
            }
            first += of_bin.len();
        }
    }

    /// Calls `each(receiver, result, irradiance)` for each run of suns of one result.
    pub fn direct(&self, skies: &SkyMasks, mut each: impl FnMut(usize, usize, f64)) {
        for of_bin in self.passages.chunk_by(|a, b| a.bin == b.bin) {
            let (mut wholes, mut partials) = ([DVec3::ZERO; LANES], [0.0_f64; LANES]);
            for passage in of_bin {
                skies.whole(passage.texel).for_each(|receiver| wholes[receiver] += passage.whole);
                for (receiver, texel) in skies.partial(passage.texel) {
                    let normal = skies.normal(receiver);
                    for &(sun, part) in &self.passing[passage.passing.clone()] {
                        let sun = &self.suns[sun as usize];
                        let cos = normal.dot(sun.direction);
                        if cos > 0.0 {
                            let visible = self.share(&self.parts[part as usize], texel);
                            partials[receiver] += sun.strength * cos * f64::from(visible);
                        }
                    }
                }
            }
            for (receiver, (whole, partial)) in wholes.iter().zip(partials).enumerate().take(skies.receivers()) {
                each(receiver, of_bin[0].bin, skies.normal(receiver).dot(*whole) + partial);
            }
        }
    }

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors to
    /// `out[result]`.
    pub fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
        let image = view.reflection.image(normal);
        for sun in &self.suns {
            let cos = image.dot(sun.direction);
            if cos > 0.0 {
                let parts = self.parts[sun.parts.clone()].iter();
                let visible: f32 =
                    parts.map(|part| self.share(part, view.texel(part.column as usize, part.row as usize))).sum();
                if visible > 0.0 {
                    out[sun.bin] += sun.strength * cos * f64::from(visible) * view.reflection.share(sun.direction);
                }
            }
        }
    }

    /// Adds the direct irradiance of a receiver with this normal and sky to `out[result]`. Meant
    /// for few suns, for which building masks does not pay.
    pub fn direct_seen(&self, normal: DVec3, sky: &mut impl BaseTexels, out: &mut [f64]) {
        for sun in &self.suns {
            let cos = normal.dot(sun.direction);
            if cos > 0.0 {
                let parts = self.parts[sun.parts.clone()].iter();
                let visible: f32 =
                    parts.map(|part| self.share(part, sky.texel(part.column as usize, part.row as usize))).sum();
                out[sun.bin] += sun.strength * cos * f64::from(visible);
            }
        }
    }

    /// Adds the direct irradiance of a receiver with this normal and sky, behind canopies, to
    /// `out[result]`.
    pub fn direct_behind(&self, normal: DVec3, sky: &mut impl BaseTexels, veil: &CanopyTransmittance, out: &mut [f64]) {
        for sun in &self.suns {
            let cos = normal.dot(sun.direction);
            if cos > 0.0 {
                let parts = self.parts[sun.parts.clone()].iter();
                let visible: f32 = parts.map(|part| self.visible_behind(part, sky, veil)).sum();
                out[sun.bin] += sun.strength * cos * f64::from(visible);
            }
        }
    }

    fn visible_behind(&self, part: &Part, sky: &mut impl BaseTexels, veil: &CanopyTransmittance) -> f32 {
        let (column, row) = (part.column as usize, part.row as usize);
        let fine = self.fine[part.fine.clone()].iter();
        let through = |&(i, share): &(u32, f32)| share * veil.at(column, row, i as usize);
        let texel = sky.texel(column, row);
        if let Some(even) = veil.even(column, row) {
            return even * self.share(part, texel);
        }
        match texel {
            Texel::Closed => 0.0,
            Texel::Open => fine.map(through).sum(),
            Texel::Mixed(bits) => fine.filter(|(i, _)| bits[*i as usize / 64] >> (i % 64) & 1 == 1).map(through).sum(),
        }
    }

    /// Returns the share of the disc that is visible in a base texel.
    #[inline]
    fn share(&self, part: &Part, texel: Texel) -> f32 {
        match texel {
            Texel::Closed => 0.0,
            Texel::Open => part.share,
            Texel::Mixed(bits) => {
                // Most discs lie on one side of an edge, so that one or two words decide.
                let words = &self.words[part.words.clone()];
                let (mut hidden, mut shown) = (0, 0);
                for &(word, disc) in words {
                    hidden |= disc & !bits[word as usize];
                    shown |= disc & bits[word as usize];
                }
                if shown == 0 {
                    return 0.0;
                }
                if hidden == 0 {
                    return part.share;
                }
                let seen = |&&(i, _): &&(u32, f32)| bits[i as usize / 64] >> (i % 64) & 1 == 1;
                self.fine[part.fine.clone()].iter().filter(seen).map(|t| t.1).sum()
            }
        }
    }
}
