//! The suns of a series of conditions, looked up once for all receivers. In: conditions and where they add to. Out: direct
//! irradiance of a receiver whose sky is at hand.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::layers::mosaic::{Mosaic, Texel};
use crate::layers::sides::TextureSides;
use crate::replay::canopy_transmittance::CanopyTransmittance;
use crate::replay::sky_masks::{LANES, SkyMasks};
use crate::replay::specular::MirrorView;
use crate::replay::sun_map::{Shine, SunMap};
use crate::sky::disc::disc_texels;
use crate::sky::model::SkyModel;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// One position of the sun.
#[derive(Clone, Debug)]
struct Sun {
    bin: usize,
    /// Normal irradiance x share of the condition's time x weight in the result.
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
    /// Its texels in [`SunLookups::fine`].
    fine: Range<usize>,
}

/// The suns of a result in one base texel.
#[derive(Clone, Debug)]
struct Passage {
    bin: usize,
    /// Base texel, row-major.
    texel: usize,
    /// Sum of strength x share of the disc x direction.
    whole: DVec3,
    /// Its suns and their parts in [`EachSun::passing`].
    passing: Range<usize>,
}

/// Suns made ready for receivers' textures: one by one where each has a result, added up where many share one.
pub enum SunLookups {
    /// Suns of hours.
    Each(EachSun),
    /// Suns of sums.
    Summed(SunMap),
}

/// From so many suns a result on they are added up.
const SUMMED_FROM: usize = 100;

/// Suns one by one.
#[derive(Default)]
pub struct EachSun {
    suns: Vec<Sun>,
    parts: Vec<Part>,
    /// Place in a base texel's bits, and share of the disc.
    fine: Vec<(u32, f32)>,
    /// By run of suns of one result, and texel.
    passages: Vec<Passage>,
    /// Sun, part.
    passing: Vec<(u32, u32)>,
}

impl SunLookups {
    /// Looks up all suns of all conditions with DNI.
    pub fn new(conditions: &[Condition], bins: &Bins, sides: TextureSides) -> Self {
        SunLookups::of(conditions, bins, sides, |c| c.dni_w_m2)
    }

    /// The same for the light that a model's skies send from where the suns are; most have none.
    pub fn circumsolar(conditions: &[Condition], bins: &Bins, sides: TextureSides, model: SkyModel) -> Self {
        let conditions = if model.brightens() { conditions } else { &[] };
        SunLookups::of(conditions, bins, sides, |c| model.parts(c).circumsolar_w_m2)
    }

    fn of(
        conditions: &[Condition],
        bins: &Bins,
        sides: TextureSides,
        normal_w_m2: impl Fn(&Condition) -> f64 + Sync,
    ) -> Self {
        let strong = conditions.par_iter().map(|c| (c, normal_w_m2(c))).zip(&bins.of_condition);
        let lit = strong.filter(|((_, normal_w_m2), (_, weight))| *normal_w_m2 > 0.0 && *weight != 0.0);
        let suns: Vec<Shine> = lit
            .flat_map_iter(|((c, normal_w_m2), &(bin, weight))| {
                c.suns.iter().filter(|instant| instant.sun.z > 0.0).map(move |instant| {
                    let strength = normal_w_m2 * instant.weight * weight;
                    Shine { bin, strength, direction: instant.sun }
                })
            })
            .collect();
        if suns.len() >= SUMMED_FROM * bins.count.max(1) {
            return SunLookups::Summed(SunMap::new(suns, sides));
        }
        let block = (sides.sky_fine / sides.sky_base).max(1) as u32;
        let discs: Vec<_> = suns.par_iter().map(|sun| disc_texels(sun.direction, sides.sky_fine)).collect();
        let mut found = EachSun::default();
        for (sun, mut disc) in suns.into_iter().zip(discs) {
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
            found.suns.push(Sun {
                bin: sun.bin,
                strength: sun.strength,
                direction: sun.direction,
                parts: first..found.parts.len(),
            });
        }
        found.add_passages(sides.sky_base);
        SunLookups::Each(found)
    }

    /// Whether there is no sun.
    pub fn is_empty(&self) -> bool {
        matches!(self, SunLookups::Each(each) if each.suns.is_empty())
    }

    /// Calls `each(receiver, result, irradiance)` for direct irradiances, which may add up: those of one result may come in parts.
    pub fn direct(&self, skies: &SkyMasks, each: impl FnMut(usize, usize, f64)) {
        match self {
            SunLookups::Each(suns) => suns.direct(skies, each),
            SunLookups::Summed(map) => map.direct(skies, each),
        }
    }

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors.
    pub fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
        match self {
            SunLookups::Each(each) => each.by_mirrors(normal, view, out),
            SunLookups::Summed(map) => map.by_mirrors(normal, view, out),
        }
    }

    /// The first of them behind a veil.
    pub fn direct_behind(&self, normal: DVec3, sky: &Mosaic, veil: &CanopyTransmittance, out: &mut [f64]) {
        match self {
            SunLookups::Each(each) => each.direct_behind(normal, sky, veil, out),
            SunLookups::Summed(map) => map.direct_behind(normal, sky, veil, out),
        }
    }
}

impl EachSun {
    /// Adds up the suns that pass a base texel, of `side` to a side, on their way through a result.
    fn add_passages(&mut self, side: usize) {
        let mut first = 0;
        for of_bin in self.suns.chunk_by(|a, b| a.bin == b.bin) {
            let numbered = of_bin.iter().enumerate().flat_map(|(i, sun)| sun.parts.clone().map(move |part| (i, part)));
            let place = |part: usize| self.parts[part].row as usize * side + self.parts[part].column as usize;
            let mut found: Vec<(usize, usize, usize)> = numbered.map(|(i, part)| (place(part), i, part)).collect();
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
    fn direct(&self, skies: &SkyMasks, mut each: impl FnMut(usize, usize, f64)) {
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

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors.
    fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
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

    /// The same behind a veil.
    fn direct_behind(&self, normal: DVec3, sky: &Mosaic, veil: &CanopyTransmittance, out: &mut [f64]) {
        for sun in &self.suns {
            let cos = normal.dot(sun.direction);
            if cos > 0.0 {
                let parts = self.parts[sun.parts.clone()].iter();
                let visible: f32 = parts.map(|part| self.visible_behind(part, sky, veil)).sum();
                out[sun.bin] += sun.strength * cos * f64::from(visible);
            }
        }
    }

    fn visible_behind(&self, part: &Part, sky: &Mosaic, veil: &CanopyTransmittance) -> f32 {
        let place = (part.column as usize, part.row as usize);
        let fine = self.fine[part.fine.clone()].iter();
        let through = |&(i, share): &(u32, f32)| share * veil.at(place, i as usize);
        match sky.texel(place.0, place.1) {
            Texel::Closed => 0.0,
            Texel::Open => fine.map(through).sum(),
            Texel::Mixed(bits) => fine.filter(|(i, _)| bits[*i as usize / 64] >> (i % 64) & 1 == 1).map(through).sum(),
        }
    }

    /// Share of the disc that is seen in a base texel.
    #[inline]
    fn share(&self, part: &Part, texel: Texel) -> f32 {
        match texel {
            Texel::Closed => 0.0,
            Texel::Open => part.share,
            Texel::Mixed(bits) => {
                let seen = |&&(i, _): &&(u32, f32)| bits[i as usize / 64] >> (i % 64) & 1 == 1;
                self.fine[part.fine.clone()].iter().filter(seen).map(|t| t.1).sum()
            }
        }
    }
}
