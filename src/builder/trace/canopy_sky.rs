//! Crossings of canopies on the way to the sky. In: the tiles of a receiver's square that may show
//! sky. Out: the crossings along a ray through each of their texels.
//!
//! Rays are cast on a coarse grid. The grid is halved until it is the square. Each time, between
//! known rays, the codes of lengths in volumes are interpolated, and numbers of screens are those
//! around. Where codes differ much, or numbers at all, there is an edge, and a ray is cast. From
//! these rays edges are followed to where the coarse grid did not see them: the tip of a gap
//! between two crowns. The sun at the edge of a crown needs fine texels, the middle of a crown does
//! not. The layer predicts the same codes, so that interpolated ones take next to no bytes.

use std::sync::LazyLock;

use crate::trace::canopy::{Canopies, Path};
use crate::trace::kernel::ray::Ray;
use crate::trace::kernel::rays::Tracer;
use crate::trace::viewpoint::Viewpoint;
use crate::trace::volume::USUALLY_STOPPED;
use glam::DVec2;
use heliotile_core::hemisphere::texel_direction;
use heliotile_core::layers::canopy::{COUNTS, coarse_step, length_of, mean_code};
use heliotile_core::site::crossing::Crossing;

/// Largest difference of the light left along neighbouring rays, at the usual density of leaves,
/// between which lengths are interpolated.
const MAX_APART: f64 = 0.04;

/// `[code]`: light left after the length of a code, at the usual density of leaves.
static LEFT: LazyLock<[f64; COUNTS]> =
    LazyLock::new(|| std::array::from_fn(|code| (-USUALLY_STOPPED * length_of(code as u16)).exp()));

impl Canopies<'_> {
    /// Returns the crossings of rays through the texels of a square of `side` texels a side, each
    /// material's sorted by ray, and the number of rays cast. Rays are those of some texels (column
    /// and row) of the coarse grid, and of the texels from each of these to the next.
    pub(crate) fn towards_sky(
        &self,
        view: &Viewpoint,
        side: usize,
        coarse: &[(usize, usize)],
        tracer: &Tracer,
    ) -> (Vec<Crossing>, u64) {
        let mut step = coarse_step(side);
        let mut tiles: Vec<usize> = coarse.iter().map(|(column, row)| step * (row * side + column)).collect();
        let mut square = SquareOfRays { side, known: vec![Known::No; side * side], planes: Vec::new() };
        self.cast(view, &tiles, tracer, &mut square);
        let mut cast = tiles.len();
        tiles.retain(|tile| square.is_crossed_near(*tile, step) || square.know_empty(*tile, step));
        let mut asked = Vec::new();
        while step > 1 {
            let half = step / 2;
            let inside = (0..coarse_step(side)).step_by(half);
            let inside = || inside.clone().flat_map(|row| inside.clone().map(move |column| row * side + column));
            let between: Vec<usize> = inside().filter(|at| at / side % step + at % side % step > 0).collect();
            for texel in tiles.iter().flat_map(|tile| between.iter().map(move |at| tile + at)) {
                if !square.interpolate(texel, step) {
                    asked.push(texel);
                }
            }
            while !asked.is_empty() {
                cast += asked.len();
                self.cast(view, &asked, tracer, &mut square);
                asked = square.beyond_edges(&asked, half);
            }
            step = half;
        }
        (square.crossings(), cast as u64)
    }

    /// Casts rays through some texels, and notes what they cross.
    fn cast(&self, view: &Viewpoint, texels: &[usize], tracer: &Tracer, square: &mut SquareOfRays) {
        for &texel in texels {
            square.known[texel] = Known::Ray;
            square.planes.iter_mut().for_each(|plane| plane.codes[texel] = 0);
        }
        for passage in self.passages(&view.sky_paths(square.side, texels, tracer)) {
            for (material, amount) in self.crossed_before(&passage, f64::INFINITY) {
                let volume = self.volumes().stopped(material).is_some();
                square.plane(material, volume).codes[passage.place as usize] = self.code(material, amount);
            }
        }
    }
}

/// Crossings of the rays through the texels of a square, while they are cast.
struct SquareOfRays {
    /// Number of texels a side.
    side: usize,
    /// `[texel]`: how it is known what its ray crosses.
    known: Vec<Known>,
    /// Materials that some ray crosses.
    planes: Vec<Plane>,
}

/// Source of what is known of a texel.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    /// Nothing is known.
    No,
    /// It is interpolated.
    Between,
    /// A ray was cast, or nothing is near.
    Ray,
}

/// Crossings of one material.
struct Plane {
    material: u16,
    /// True if codes are those of lengths in a volume, false if they are numbers of screens.
    volume: bool,
    /// `[texel]`: codes; 0 where nothing is crossed or known.
    codes: Vec<u16>,
}

impl Plane {
    /// Returns true if an edge lies between two codes.
    fn is_edge(&self, a: u16, b: u16) -> bool {
        let left = |code: u16| LEFT[usize::from(code)];
        if self.volume { (left(a) - left(b)).abs() > MAX_APART } else { a != b }
    }
}

impl SquareOfRays {
    /// Returns the crossings of a material.
    fn plane(&mut self, material: u16, volume: bool) -> &mut Plane {
        let at = self.planes.iter().position(|plane| plane.material == material).unwrap_or_else(|| {
            self.planes.push(Plane { material, volume, codes: vec![0; self.side * self.side] });
            self.planes.len() - 1
        });
        &mut self.planes[at]
    }

    /// Returns true if a ray through a corner of a tile of `step` texels a side, or through one
    /// next to these, crosses anything.
    fn is_crossed_near(&self, tile: usize, step: usize) -> bool {
        let near = |at: usize| (at.saturating_sub(step)..self.side.min(at + 3 * step)).step_by(step);
        near(tile / self.side).any(|row| {
            near(tile % self.side)
                .any(|column| self.planes.iter().any(|plane| plane.codes[row * self.side + column] > 0))
        })
    }

    /// Takes a tile of `step` texels a side for known: nothing is crossed. Returns false.
    fn know_empty(&mut self, tile: usize, step: usize) -> bool {
        (0..step).for_each(|row| self.known[tile + row * self.side..][..step].fill(Known::Ray));
        false
    }

    /// Takes a texel between those of a grid of `step` texels for known, with mean codes in volumes
    /// and equal numbers of crossings. Returns false if no ray around is known, or if rays around
    /// differ much in volumes or cross unequal numbers of screens.
    fn interpolate(&mut self, texel: usize, step: usize) -> bool {
        let (mut around, mut count) = ([0; 4], 0);
        let beside = |at: usize| [at / step * step, at.div_ceil(step) * step];
        let ([above, below], [left, right]) = (beside(texel / self.side), beside(texel % self.side));
        for row in [above, below].into_iter().take(1 + usize::from(below > above)).filter(|row| *row < self.side) {
            for column in [left, right].into_iter().take(1 + usize::from(right > left)).filter(|c| *c < self.side) {
                if self.known[row * self.side + column] != Known::No {
                    around[count] = row * self.side + column;
                    count += 1;
                }
            }
        }
        let around = &around[..count];
        let range = |plane: &Plane| {
            let codes = around.iter().map(|texel| plane.codes[*texel]);
            codes.fold([u16::MAX, 0], |[least, most], code| [code.min(least), code.max(most)])
        };
        let is_even = |plane: &Plane| {
            let [least, most] = range(plane);
            least == most || least > 0 && !plane.is_edge(least, most)
        };
        if around.is_empty() || !self.planes.iter().all(is_even) {
            return false;
        }
        for plane in &mut self.planes {
            let sum = around.iter().map(|texel| u32::from(plane.codes[*texel])).sum();
            // What the layer predicts: it takes next to no bytes.
            plane.codes[texel] = mean_code(sum, count as u32) as u16;
        }
        self.known[texel] = Known::Between;
        true
    }

    /// Returns the interpolated texels, on a grid of `step` texels, next to some rays that cross
    /// something else.
    fn beyond_edges(&self, rays: &[usize], step: usize) -> Vec<usize> {
        let differs = |ray: usize, texel: usize| {
            self.planes.iter().any(|plane| plane.is_edge(plane.codes[ray], plane.codes[texel]))
        };
        let near = |at: usize| (at.saturating_sub(step)..self.side.min(at + 2 * step)).step_by(step);
        let beside = |&ray: &usize| {
            let around = near(ray / self.side)
                .flat_map(move |row| near(ray % self.side).map(move |column| row * self.side + column));
            around.filter(move |texel| differs(ray, *texel))
        };
        let mut found: Vec<usize> =
            rays.iter().flat_map(beside).filter(|texel| self.known[*texel] == Known::Between).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns the crossings of all rays.
    fn crossings(&self) -> Vec<Crossing> {
        let of_plane = |plane: &Plane| {
            let crossing = |(ray, count)| Crossing { ray: ray as u32, material: plane.material, count };
            let crossed = plane.codes.iter().copied().enumerate().filter(|(_, code)| *code > 0);
            crossed.map(crossing).collect::<Vec<_>>()
        };
        self.planes.iter().flat_map(of_plane).collect()
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use heliotile_core::hemisphere::texels_in_blocks;
    use heliotile_core::site::material::{Class, Material};
    use heliotile_scene::Scene;

    /// Two screens 10 m above a point leave a gap that narrows to nothing between the rays of the
    /// coarse grid. Beside rays through all of 512 x 512 texels at most 6 differ, for 8 places and
    /// turns of the gap; at most one texel of 8 gets a ray.
    #[test]
    fn gaps_are_followed_to_their_tip() {
        for turn in 0..8 {
            let (sin, cos) = (0.3 + 0.785 * f64::from(turn)).sin_cos();
            let at = |x: f64, y: f64| {
                let x = x + 0.37 * f64::from(turn);
                DVec3::new(cos * x - sin * y, sin * x + cos * y, 10.0)
            };
            let (tip, end) = (at(0.0, -4.0), at(0.0, -20.0));
            let side = |x: f64| [[tip, at(x, 20.0), at(20.0 * x, 20.0)], [tip, at(20.0 * x, 20.0), end]];
            let triangles: Vec<_> = [side(1.0), side(-1.0)].concat().into_iter().map(|points| (points, 0)).collect();
            let screen = Material { transmittance: Some(0.3), ..Material::matt("screen", 0.0, Class::Obstruction) };
            let scene = Scene::from_triangles(&triangles, vec![screen]).expect("a scene");
            let (tracer, canopies) = Canopies::split(&scene);
            let canopies = canopies.expect("canopies");
            let view = Viewpoint { position: DVec3::ZERO, normal: DVec3::Z };
            let coarse: Vec<(usize, usize)> = texels_in_blocks(128).collect();
            let (mut found, rays) = canopies.towards_sky(&view, 512, &coarse, &tracer);
            found.sort_unstable();
            let texels: Vec<usize> = (0..512 * 512).collect();
            let all = canopies.counted(&canopies.passages(&view.sky_paths(512, &texels, &tracer)));
            let missing = |these: &[Crossing], those: &[Crossing]| {
                these.iter().filter(|one| those.binary_search(one).is_err()).count()
            };
            let differ = missing(&all, &found) + missing(&found, &all);
            assert!(differ <= 6, "{turn}: {differ}");
            assert!(rays < 512 * 512 / 8, "{turn}: {rays}");
        }
    }
}
