//! Suns that are added up, as maps. In: positions of many suns, and their strengths. Out: direct
//! irradiance of receivers with known skies, at a cost that does not depend on the number of suns.
//!
//! The sum over suns of strength x visible share x cosine is linear in the vectors strength x
//! direction. The vectors that fall on one texel of the sky are therefore added up before any
//! receiver is computed. A receiver then takes an open base texel with one product, and a partly
//! open one by its bits.

use std::ops::Range;

use glam::{DVec3, Vec3};
use pulp::Arch;
use rayon::prelude::*;

use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::{SkyBitmap, Texel};
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::sky_masks::{LANES, SkyMasks};
use crate::replay::direct::specular::MirrorView;
use crate::replay::sun_sample::SunSample;
use crate::sky::disc::disc_texels;

/// Number of places of a base texel's bits that are read at a time: one byte.
const STRIP: usize = 8;

/// Number of suns whose discs are found at a time. All threads find them and one adds them up, so
/// this bounds the memory that they take.
const DISCS: usize = 8192;

/// Light on the places of one byte of a base texel's bits.
#[derive(Clone, Copy, Debug)]
struct Strip {
    /// Number of the byte.
    byte: u32,
    /// `[axis][place]`: irradiance x direction.
    vectors: [[f32; STRIP]; 3],
}

/// Light of one result on a base texel.
#[derive(Clone, Debug)]
struct LitTexel {
    bin: u32,
    /// Number of the base texel, row-major.
    texel: u32,
    /// Irradiance x direction, summed over the whole base texel.
    whole: DVec3,
    /// Range of the base texel's strips in [`SunMap::strips`].
    strips: Range<u32>,
}

/// Light of suns, added up by texel of the sky.
#[derive(Clone, Debug, Default)]
pub struct SunMap {
    side: usize,
    /// Lit base texels, ordered by result and texel.
    texels: Vec<LitTexel>,
    strips: Vec<Strip>,
}

impl SunMap {
    /// Adds up the light of suns. Light on one texel is added in the order given.
    pub fn new(mut suns: Vec<SunSample>, sides: TextureSides) -> Self {
        // The sort is stable, so sums do not depend on the number of threads.
        suns.sort_by_key(|sun| sun.bin);
        let block = (sides.sky_fine / sides.sky_base.max(1)).max(1);
        let mut map = SunMap { side: sides.sky_base, ..SunMap::default() };
        let mut sums = TexelSums::new(sides.sky_base, block);
        for of_bin in suns.chunk_by(|a, b| a.bin == b.bin) {
            for part in of_bin.chunks(DISCS) {
                let discs: Vec<_> = part.par_iter().map(|sun| disc_texels(sun.direction, sides.sky_fine)).collect();
                for (sun, disc) in part.iter().zip(&discs) {
                    let light = sun.direction * sun.strength;
                    disc.iter().for_each(|t| sums.add(t.0 as usize, t.1 as usize, light * f64::from(t.2)));
                }
            }
            map.take(of_bin[0].bin, &mut sums);
        }
        map
    }

    /// Moves the sums of a result into the map.
    fn take(&mut self, bin: usize, sums: &mut TexelSums) {
        sums.lit.sort_unstable();
        for &(texel, place) in &sums.lit {
            let (first, mut whole) = (self.strips.len() as u32, DVec3::ZERO);
            let per_texel = sums.block * sums.block;
            let vectors = sums.vectors.get(place as usize * per_texel..).unwrap_or_default();
            for (byte, places) in vectors.chunks(STRIP).enumerate().take(per_texel.div_ceil(STRIP)) {
                let places = places.get(..STRIP.min(per_texel)).unwrap_or(places);
                if places.iter().any(|v| *v != DVec3::ZERO) {
                    let mut strip = Strip { byte: byte as u32, vectors: [[0.0; STRIP]; 3] };
                    for (lane, v) in places.iter().enumerate() {
                        whole += *v;
                        (0..3).for_each(|axis| strip.vectors[axis][lane] = v[axis] as f32);
                    }
                    self.strips.push(strip);
                }
            }
            self.texels.push(LitTexel { bin: bin as u32, texel, whole, strips: first..self.strips.len() as u32 });
        }
        sums.clear();
    }

    fn strips_of(&self, texel: &LitTexel) -> &[Strip] {
        self.strips.get(texel.strips.start as usize..texel.strips.end as usize).unwrap_or_default()
    }

    /// Returns the column and the row of a base texel.
    fn place(&self, texel: &LitTexel) -> (usize, usize) {
        let texel = texel.texel as usize;
        (texel % self.side.max(1), texel / self.side.max(1))
    }

    /// Calls `each(receiver, result, irradiance)` for the direct irradiance of each receiver and
    /// result with a sun.
    pub fn direct(&self, skies: &SkyMasks, mut each: impl FnMut(usize, usize, f64)) {
        Arch::new().dispatch(|| {
            for of_bin in self.texels.chunk_by(|a, b| a.bin == b.bin) {
                let (mut wholes, mut partials) = ([DVec3::ZERO; LANES], [0.0_f64; LANES]);
                for lit in of_bin {
                    skies.whole(lit.texel as usize).for_each(|receiver| wholes[receiver] += lit.whole);
                    for (receiver, texel) in skies.partial(lit.texel as usize) {
                        let normal = skies.normal(receiver).as_vec3();
                        partials[receiver] += f64::from(seen_before(self.strips_of(lit), normal, texel));
                    }
                }
                for (receiver, (whole, partial)) in wholes.iter().zip(partials).enumerate().take(skies.receivers()) {
                    each(receiver, of_bin[0].bin as usize, skies.normal(receiver).dot(*whole) + partial);
                }
            }
        });
    }

    /// Returns the light on each visible place of a texel: place in the texel's bits, irradiance x
    /// direction.
    fn seen<'a>(&'a self, lit: &LitTexel, texel: Texel<'a>) -> impl Iterator<Item = (usize, Vec3)> + 'a {
        self.strips_of(lit).iter().flat_map(move |strip| {
            let byte = byte_of(texel, strip.byte as usize);
            let [x, y, z] = strip.vectors;
            let of = move |lane: usize| (strip.byte as usize * STRIP + lane, Vec3::new(x[lane], y[lane], z[lane]));
            (0..STRIP).filter(move |lane| byte >> lane & 1 == 1).map(of).filter(|(_, v)| *v != Vec3::ZERO)
        })
    }

    /// Adds the direct irradiance of a receiver with this normal and sky, behind canopies, to
    /// `out[result]`.
    pub fn direct_behind(&self, normal: DVec3, sky: &SkyBitmap, veil: &CanopyTransmittance, out: &mut [f64]) {
        let normal = normal.as_vec3();
        Arch::new().dispatch(|| {
            for lit in &self.texels {
                let (column, row) = self.place(lit);
                let (texel, strips) = (sky.texel(column, row), self.strips_of(lit));
                let sum = match (texel, veil.even(column, row)) {
                    (Texel::Closed, _) => continue,
                    (_, Some(share)) => share * seen_before(strips, normal, texel),
                    (_, None) => {
                        let through = |(i, v): (usize, Vec3)| normal.dot(v).max(0.0) * veil.at(column, row, i);
                        self.seen(lit, texel).map(through).sum()
                    }
                };
                out[lit.bin as usize] += f64::from(sum);
            }
        });
    }

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors to
    /// `out[result]`.
    pub fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
        let image = view.reflection.image(normal);
        let left = |(_, v): (usize, Vec3)| {
            let v = v.as_dvec3();
            let cos = image.dot(v);
            if cos > 0.0 { cos * view.reflection.share(v.normalize_or_zero()) } else { 0.0 }
        };
        for lit in &self.texels {
            let (column, row) = self.place(lit);
            let sum: f64 = self.seen(lit, view.texel(column, row)).map(left).sum();
            out[lit.bin as usize] += sum;
        }
    }
}

/// Returns eight places of a texel as a byte: a bit is set where the sky is open.
#[inline(always)]
fn byte_of(texel: Texel, byte: usize) -> u8 {
    match texel {
        Texel::Closed => 0,
        Texel::Open => u8::MAX,
        Texel::Mixed(bits) => bits.get(byte / STRIP).map_or(0, |word| (word >> (byte % STRIP * STRIP)) as u8),
    }
}

/// Returns the irradiance of a surface from the visible places of a texel, of which some may lie
/// behind the surface. Eight sums are kept side by side and added at the end. A compiler keeps the
/// order of additions of floats, so only separate sums fill a vector register.
#[inline(always)]
fn seen_before(strips: &[Strip], normal: Vec3, texel: Texel) -> f32 {
    let mut sums = [0.0_f32; STRIP];
    for Strip { byte, vectors: [x, y, z] } in strips {
        let seen = u32::from(byte_of(texel, *byte as usize));
        for lane in 0..STRIP {
            let before = normal.x * x[lane] + normal.y * y[lane] + normal.z * z[lane];
            let counts = before > 0.0 && seen >> lane & 1 == 1;
            sums[lane] += if counts { before } else { 0.0 };
        }
    }
    sums.iter().sum()
}

/// Sums of the vectors of one result by fine texel.
struct TexelSums {
    side: usize,
    block: usize,
    /// `[base texel]`: its place in `vectors`, counted from 1; 0 if no light fell on it.
    places: Vec<u32>,
    /// Lit base texels, and their places counted from 0.
    lit: Vec<(u32, u32)>,
    /// `[place][fine texel]`: sum of the vectors, in the order of a texel's bits.
    vectors: Vec<DVec3>,
}

impl TexelSums {
    fn new(side: usize, block: usize) -> Self {
        TexelSums { side, block, places: vec![0; side * side], lit: Vec::new(), vectors: Vec::new() }
    }

    fn add(&mut self, column: usize, row: usize, light: DVec3) {
        let texel = row / self.block * self.side + column / self.block;
        let Some(place) = self.places.get_mut(texel) else { return };
        let per_texel = self.block * self.block;
        if *place == 0 {
            self.lit.push((texel as u32, self.lit.len() as u32));
            *place = self.lit.len() as u32;
            self.vectors.resize(self.lit.len() * per_texel, DVec3::ZERO);
        }
        let inside = row % self.block * self.block + column % self.block;
        if let Some(sum) = self.vectors.get_mut((*place as usize - 1) * per_texel + inside) {
            *sum += light;
        }
    }

    fn clear(&mut self) {
        for (texel, _) in self.lit.drain(..) {
            self.places[texel as usize] = 0;
        }
        self.vectors.clear();
    }
}
