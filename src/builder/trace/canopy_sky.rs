//! Crossings of canopies on the way to the sky. In: the texels of a receiver's square that may show
//! sky. Out: the crossings along a ray through each.
//!
//! Rays are cast through every second texel of every second row. In between, the codes of lengths
//! in volumes are interpolated, and numbers of screens are those around. Where codes differ much,
//! or numbers at all, there is an edge, and a ray is cast. The sun at the edge of a crown needs
//! fine texels, the middle of a crown does not. The layer predicts the same codes, so that
//! interpolated ones take next to no bytes.

use std::collections::BTreeMap;

use crate::trace::canopy::{Canopies, Passage, Path};
use crate::trace::kernel::ray::Ray;
use crate::trace::kernel::rays::Tracer;
use crate::trace::viewpoint::Viewpoint;
use crate::trace::volume::USUALLY_STOPPED;
use glam::DVec2;
use heliotile_core::hemisphere::texel_direction;
use heliotile_core::layers::canopy::{length_of, mean_code};
use heliotile_core::site::crossing::Crossing;

/// Largest difference of the light left along neighbouring rays, at the usual density of leaves,
/// between which lengths are interpolated.
const MAX_APART: f64 = 0.04;

/// Materials that a ray crosses, ascending, with the number of crossings, or the code of the length
/// inside.
type Counts = Vec<(u16, u16)>;

impl Canopies<'_> {
    /// Returns the crossings of rays through some texels (column and row) of a square of `side`
    /// texels a side, sorted by ray, and the number of rays cast.
    pub(crate) fn towards_sky(
        &self,
        view: &Viewpoint,
        side: usize,
        texels: &[(usize, usize)],
        tracer: &Tracer,
    ) -> (Vec<Crossing>, u64) {
        let (first, between): (Vec<_>, Vec<_>) = texels
            .iter()
            .map(|&(column, row)| row * side + column)
            .partition(|texel| texel % side % 2 + texel / side % 2 == 0);
        // `[texel]`: true if a ray was cast through it at first.
        let mut cast = vec![false; side * side];
        first.iter().for_each(|texel| cast[*texel] = true);
        let mut found = self.counts(&view.sky_paths(side, &first, tracer));
        let none = Counts::new();
        let (mut told, mut asked) = (Vec::new(), Vec::new());
        for texel in between {
            let beside = around(texel, side).filter(|other| cast[*other]);
            let rays: Vec<&Counts> = beside.map(|other| found.get(&other).unwrap_or(&none)).collect();
            match self.between(&rays) {
                Some(counts) => told.push((texel, counts)),
                None => asked.push(texel),
            }
        }
        found.extend(self.counts(&view.sky_paths(side, &asked, tracer)));
        found.extend(told);
        let crossing = |texel: usize, (material, count): (u16, u16)| Crossing { ray: texel as u32, material, count };
        let crossings =
            found.into_iter().flat_map(|(texel, of_ray)| of_ray.into_iter().map(move |one| crossing(texel, one)));
        (crossings.collect(), (first.len() + asked.len()) as u64)
    }

    /// Returns the counts of the rays that cross anything, by place.
    fn counts(&self, paths: &[Path]) -> BTreeMap<usize, Counts> {
        let passages = self.passages(paths);
        let counts = |passage: &Passage| {
            let crossed = self.crossed_before(passage, f64::INFINITY).into_iter();
            crossed.map(|(material, amount)| (material, self.code(material, amount))).collect()
        };
        passages.iter().map(|passage| (passage.place as usize, counts(passage))).collect()
    }

    /// Returns the counts between some rays: mean codes in volumes, and equal numbers of crossings.
    /// `None` if the rays are none, differ much in volumes, or cross unequal numbers of screens.
    fn between(&self, rays: &[&Counts]) -> Option<Counts> {
        if rays.is_empty() {
            return None;
        }
        let of = |counts: &Counts, material: u16| counts.iter().find(|one| one.0 == material).map_or(0, |one| one.1);
        let mut materials: Vec<u16> = rays.iter().flat_map(|counts| counts.iter().map(|one| one.0)).collect();
        materials.sort_unstable();
        materials.dedup();
        let mut between = Counts::new();
        for material in materials {
            let codes = rays.iter().map(|counts| of(counts, material));
            let [least, most] = codes.clone().fold([u16::MAX, 0], |[a, b], code| [a.min(code), b.max(code)]);
            if self.volumes().stopped(material).is_none() {
                if least != most {
                    return None;
                }
                between.push((material, most));
                continue;
            }
            let left = |code: u16| (-USUALLY_STOPPED * length_of(code)).exp();
            if left(least) - left(most) > MAX_APART || least == 0 {
                return None;
            }
            // What the layer predicts: it takes next to no bytes.
            between.push((material, mean_code(codes.map(u32::from).sum(), rays.len() as u32) as u16));
        }
        Some(between)
    }
}

/// Returns the texels of even row and column around another one: two or four, fewer at the rim; the
/// first one lies in its 2 x 2.
fn around(texel: usize, side: usize) -> impl Iterator<Item = usize> {
    let (column, row) = (texel % side, texel / side);
    let even = move |at: usize| [at - at % 2, at + at % 2].into_iter().take(1 + at % 2).filter(move |at| *at < side);
    even(row).flat_map(move |row| even(column).map(move |column| row * side + column))
}

impl Viewpoint {
    /// Returns a ray through the middle of each of some texels of an n x n world-frame texture:
    /// shares are interpolated between middles. A ray that would go behind the surface goes along
    /// it.
    fn sky_paths(&self, n: usize, texels: &[usize], tracer: &Tracer) -> Vec<Path> {
        let origin = self.origin(tracer);
        let path = |&texel: &usize| {
            let d = texel_direction(texel % n, texel / n, n, DVec2::splat(0.5));
            let behind = self.normal.dot(d);
            let d = if behind > 0.0 { d } else { d - self.normal * (behind - 1e-4) };
            Path { place: texel as u32, ray: Ray { origin, direction: d.as_vec3().to_array() }, reach_m: f32::INFINITY }
        };
        texels.iter().map(path).collect()
    }
}
