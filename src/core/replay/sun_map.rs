//! The suns of sums as maps. In: where the discs of many suns lie, and how strong they are. Out: direct irradiance of a receiver whose sky is at
//! hand, at a price that does not depend on how many suns there were.
//!
//! The sum over suns of strength x visible share x cosine is linear in the vectors strength x direction: those that fall on one texel of the
//! sky are added before any receiver is asked. A receiver then takes whole base texels by one product, and those with an edge by their bits.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::layers::mosaic::{Mosaic, Texel};
use crate::layers::sky::half_texel;
use crate::replay::canopy_transmittance::CanopyTransmittance;
use crate::replay::specular::MirrorView;

/// Light that falls on one fine texel of the sky: which result it adds to, where, and what.
#[derive(Clone, Copy, Debug)]
pub struct Glint {
    /// Result.
    pub bin: u32,
    /// Base texel.
    pub column: u32,
    /// Base texel.
    pub row: u32,
    /// Place in the base texel's bits.
    pub place: u32,
    /// Irradiance x direction.
    pub vector: DVec3,
}

/// The light of a result on a base texel.
#[derive(Clone, Debug)]
struct LitTexel {
    bin: u32,
    column: u32,
    row: u32,
    /// Of all of it.
    whole: Vec3,
    /// Below this product with a normal a surface's plane may cut the texel.
    cut: f32,
    /// Its fine texels in [`SunMap::fine`].
    fine: Range<u32>,
}

/// Suns added up, texel by texel of the sky.
#[derive(Clone, Debug, Default)]
pub struct SunMap {
    /// By result, row and column.
    texels: Vec<LitTexel>,
    /// Place in a base texel's bits, irradiance x direction.
    fine: Vec<(u32, Vec3)>,
}

impl SunMap {
    /// Adds up light; what falls on one texel is added in the order given.
    pub fn new(mut glints: Vec<Glint>, base: usize) -> Self {
        // Twice the half: texels are wider along than across.
        let wide = 2.0 * half_texel(base) as f32;
        let key = |glint: &Glint| (glint.bin, glint.row, glint.column, glint.place);
        // Stable: sums do not depend on the number of threads.
        glints.par_sort_by_key(key);
        let mut map = SunMap::default();
        for of_texel in glints.chunk_by(|a, b| (a.bin, a.row, a.column) == (b.bin, b.row, b.column)) {
            let first = map.fine.len() as u32;
            for of_place in of_texel.chunk_by(|a, b| a.place == b.place) {
                let sum: DVec3 = of_place.iter().map(|glint| glint.vector).sum();
                map.fine.push((of_place[0].place, sum.as_vec3()));
            }
            let whole: DVec3 = of_texel.iter().map(|glint| glint.vector).sum();
            let (Glint { bin, column, row, .. }, whole) = (of_texel[0], whole.as_vec3());
            let (cut, fine) = (wide * whole.length(), first..map.fine.len() as u32);
            map.texels.push(LitTexel { bin, column, row, whole, cut, fine });
        }
        map
    }

    fn fine_of(&self, texel: &LitTexel) -> &[(u32, Vec3)] {
        self.fine.get(texel.fine.start as usize..texel.fine.end as usize).unwrap_or_default()
    }

    /// Adds the direct irradiance of a receiver with this normal and sky to `out[result]`.
    pub fn direct(&self, normal: DVec3, sky: &Mosaic, out: &mut [f64]) {
        let normal = normal.as_vec3();
        for texel in &self.texels {
            let sum = match sky.texel(texel.column as usize, texel.row as usize) {
                Texel::Closed => continue,
                Texel::Open => match normal.dot(texel.whole) {
                    before if before > texel.cut => before,
                    behind if behind < -texel.cut => continue,
                    _ => self.fine_of(texel).iter().map(|(_, v)| normal.dot(*v).max(0.0)).sum(),
                },
                Texel::Mixed(bits) => seen(self.fine_of(texel), bits).map(|(_, v)| normal.dot(v).max(0.0)).sum(),
            };
            out[texel.bin as usize] += f64::from(sum);
        }
    }

    /// The same behind a veil.
    pub fn direct_behind(&self, normal: DVec3, sky: &Mosaic, veil: &CanopyTransmittance, out: &mut [f64]) {
        let normal = normal.as_vec3();
        for texel in &self.texels {
            let place = (texel.column as usize, texel.row as usize);
            let through = |(i, v): (u32, Vec3)| normal.dot(v).max(0.0) * veil.at(place, i as usize);
            let fine = self.fine_of(texel);
            let sum: f32 = match sky.texel(place.0, place.1) {
                Texel::Closed => continue,
                Texel::Open => fine.iter().copied().map(through).sum(),
                Texel::Mixed(bits) => seen(fine, bits).map(through).sum(),
            };
            out[texel.bin as usize] += f64::from(sum);
        }
    }

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors.
    pub fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
        let image = view.reflection.image(normal);
        let left = |v: Vec3| {
            let v = v.as_dvec3();
            let cos = image.dot(v);
            if cos > 0.0 { cos * view.reflection.share(v.normalize_or_zero()) } else { 0.0 }
        };
        for texel in &self.texels {
            let fine = self.fine_of(texel);
            let sum: f64 = match view.texel(texel.column as usize, texel.row as usize) {
                Texel::Closed => continue,
                Texel::Open => fine.iter().map(|(_, v)| left(*v)).sum(),
                Texel::Mixed(bits) => seen(fine, bits).map(|(_, v)| left(v)).sum(),
            };
            out[texel.bin as usize] += sum;
        }
    }
}

/// Those of the fine texels whose bits are set.
fn seen<'f>(fine: &'f [(u32, Vec3)], bits: &'f [u64]) -> impl Iterator<Item = (u32, Vec3)> + 'f {
    fine.iter().copied().filter(|(i, _)| bits[*i as usize / 64] >> (i % 64) & 1 == 1)
}
