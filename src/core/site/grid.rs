//! The absolute frame: the origin of a scene, and the grid that vertices and origins of rays lie
//! on. In: coordinates of the input. Out: coordinates relative to the origin that f32 holds
//! exactly, and back.
//!
//! Nothing here depends on the middle of a scene beyond a choice among multiples of 256 m. So two
//! scenes that hold the same surfaces (neighbouring parts of a region, variants of a site) hold
//! them at the same places, to the bit. Results that are computed from differences of vertices and
//! origins of rays are then the same numbers in the two scenes.

use glam::DVec3;

/// Distance between planes of the grid: 2^-14 m, 61 um.
pub const STEP_M: f64 = 1.0 / 16_384.0;

/// Steps between possible origins on each axis: 256 m.
const ORIGIN_STEPS: f64 = 4_194_304.0;

/// Distance from the origin, in steps, up to which f32 holds each plane of the grid: 1024 m.
/// Beyond, f32 rounds to coarser planes of it.
const EXACT_STEPS: f64 = 16_777_216.0;

/// Least width of a scene in steps. A scene of less than 4 m takes a finer step to reach it.
const MIN_STEPS: f64 = 65_536.0;

/// Distance of a ray's start from its surface, in steps. The two ends of this gap are rounded by at
/// most 0.87 steps (half the diagonal of a step) each.
const OFFSET_STEPS: f64 = 4.0;

/// Distance outside of a voxel, in steps, at which a surface may still have been hit inside of it:
/// 1 mm.
const SLACK_STEPS: f64 = 16.0;

/// Gap beyond the range that f32 holds exactly, as a share of the largest coordinate: some 30
/// roundings of f32.
const FAR_SHARE: f64 = 2e-6;

/// Largest distance of a scene from its origin on each axis, metres (2^20). Keys of cells repeat
/// after four times that.
pub const MAX_M: f64 = 1_048_576.0;

/// The frame of one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Origin in input coordinates, metres; a multiple of 2^22 steps.
    pub origin: DVec3,
    /// Distance between planes of the grid, metres; a power of two.
    pub step: f64,
}

impl Default for Grid {
    fn default() -> Self {
        Grid { origin: DVec3::ZERO, step: STEP_M }
    }
}

impl Grid {
    /// Returns the frame of a scene around `middle`; `extent_m` is the longest side of its bounding
    /// box.
    pub fn new(middle: DVec3, extent_m: f64) -> Self {
        // An exponent without mantissa is the largest power of two that is not above. Scenes below
        // 2^-40 m hold nothing to see.
        let whole = f64::from_bits(extent_m.max(1e-12).to_bits() >> 52 << 52);
        let step = (whole / MIN_STEPS).min(STEP_M);
        let coarse = step * ORIGIN_STEPS;
        // + 0.0 turns -0.0 into 0.0.
        Grid { origin: (middle / coarse).round() * coarse + 0.0, step }
    }

    /// Returns the nearest point of the grid, relative to the origin, as f32 holds it. Up to 1024 m
    /// it is exact.
    pub fn relative(&self, point: DVec3) -> DVec3 {
        let snapped = DVec3::from((point / self.step).to_array().map(nearest)) * self.step;
        (snapped - self.origin).as_vec3().as_dvec3() + 0.0
    }

    /// Returns the input coordinates of a point relative to the origin; exact for points of the
    /// grid.
    pub fn absolute(&self, relative: DVec3) -> DVec3 {
        relative + self.origin
    }

    /// Returns the start of rays from a surface point (input coordinates), relative to the origin:
    /// off the surface, on the grid.
    pub fn lifted(&self, point: DVec3, normal: DVec3) -> [f32; 3] {
        self.relative(point + normal * self.offset_m(point)).as_vec3().to_array()
    }

    /// Returns the distance by which a ray's origin leaves its surface, metres. It is above the
    /// rounding of coordinates at that place (input coordinates), and far below the details of a
    /// building.
    pub fn offset_m(&self, point: DVec3) -> f64 {
        self.gap_m(point, OFFSET_STEPS)
    }

    /// Returns the distance outside of a voxel (its lowest corner in input coordinates, its edge)
    /// at which surfaces count as inside, metres, because a hit is known to about 1e-6 of its
    /// distance. The point of the voxel that is nearest to the origin decides: a large voxel may
    /// have corners far beyond the scene, and scenes with other origins have to agree.
    pub fn slack_m(&self, low: DVec3, size_m: f64) -> f64 {
        self.gap_m(self.origin.clamp(low, low + size_m), SLACK_STEPS)
    }

    /// Returns true if f32 holds all of the grid around a point relative to the origin.
    pub fn holds_exactly(&self, relative: DVec3) -> bool {
        relative.abs().max_element() <= EXACT_STEPS * self.step
    }

    fn gap_m(&self, point: DVec3, steps: f64) -> f64 {
        let far = (point - self.origin).abs().max_element();
        let near = steps * self.step;
        if far <= EXACT_STEPS * self.step { near } else { near.max(far * FAR_SHARE) }
    }
}

/// Returns the nearest integer, the even one of two at equal distance, without a call of the C
/// library, since scenes have millions of vertices.
fn nearest(x: f64) -> f64 {
    // From 2^52 on a double has no room for a fraction. Below 2^51 the sum lies between 2^52 and
    // 2^53, also for a negative `x`.
    const SHIFT: f64 = 1.5 * 4_503_599_627_370_496.0;
    if x.abs() < 2_251_799_813_685_248.0 { (x + SHIFT) - SHIFT } else { x.round() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{mix, unit};

    /// For scenes of 4 m to 100 km the step is 2^-14 m and the origin a multiple of 256 m, at most
    /// 128 m from the middle. Smaller scenes, down to a micrometre, are at least 65,536 steps wide
    /// and at most 32 times as far from the origin as they are wide.
    #[test]
    fn the_origin_and_step_fit_the_size_of_the_scene() {
        let middle = DVec3::new(78_005.125, -457_005.5, 131.0);
        for extent in [4.0, 100.0, 1e5] {
            let grid = Grid::new(middle, extent);
            assert_eq!((grid.step, grid.origin), (STEP_M, DVec3::new(78_080.0, -456_960.0, 256.0)));
        }
        for extent in [3.9, 1.0, 1e-3, 1e-6] {
            let grid = Grid::new(middle, extent);
            assert!(extent / grid.step >= 65_536.0 && extent / grid.step < 131_072.0, "{extent}");
            assert!((grid.origin - middle).abs().max_element() <= 32.0 * extent, "{extent} {grid:?}");
        }
        assert_eq!(Grid::new(DVec3::splat(-0.1), 10.0).origin.to_array().map(f64::to_bits), [0; 3]);
    }

    /// 10,000 points within 700 m of two origins 512 m apart lie at the same place to the bit in
    /// the two frames, at most 0.87 steps from their stated place. The starts of their rays do,
    /// too, 3 to 5 steps off the surface.
    #[test]
    fn points_lie_at_equal_places_in_two_frames() {
        let [a, b] = [85_100.0, 85_612.0].map(|x| Grid::new(DVec3::new(x, 446_333.0, 10.0), 900.0));
        assert_eq!(b.origin - a.origin, DVec3::new(512.0, 0.0, 0.0));
        for i in 0..10_000_u64 {
            let part = |k: u64| unit(mix(i, k)) - 0.5;
            let point = DVec3::new(85_356.0 + 512.0 * part(1), 446_333.0 + 900.0 * part(2), 300.0 * part(3));
            let normal = DVec3::new(part(4), part(5), part(6)).normalize();
            let [from_a, from_b] = [a, b].map(|grid| grid.absolute(grid.relative(point)));
            assert_eq!(from_a.to_array().map(f64::to_bits), from_b.to_array().map(f64::to_bits));
            assert!((from_a - point).length() <= 0.87 * STEP_M);
            let [from_a, from_b] = [a, b].map(|g| g.absolute(DVec3::from(g.lifted(point, normal).map(f64::from))));
            assert_eq!(from_a, from_b);
            let off = (from_a - point).dot(normal) / STEP_M;
            assert!((3.0..5.0).contains(&off), "{off}");
        }
    }

    /// Eleven numbers, among them halves and numbers beyond 2^51, have the nearest integer that the
    /// standard library gives them.
    #[test]
    fn rounding_equals_that_of_the_standard_library() {
        let far = 2_251_799_813_685_248.0;
        for x in [0.0, -0.0, 0.49, 0.5, 1.5, -2.5, -7.51, far - 0.5, far + 0.25, -far, 1e300] {
            assert_eq!(nearest(x), x.round_ties_even(), "{x}");
        }
    }

    /// Gaps beyond 1024 m of the origin grow with the distance: the offset is 0.24 mm at 1 km and
    /// 20 mm at 10 km, the slack 4 mm at 2 km. A voxel of 2048 m that reaches to 100 m from the
    /// origin has the slack of a near one.
    #[test]
    fn offsets_grow_with_the_distance_from_the_origin() {
        let grid = Grid::default();
        assert_eq!(grid.offset_m(DVec3::new(0.0, -1024.0, 3.0)), 4.0 * STEP_M);
        assert_eq!(grid.slack_m(DVec3::splat(1000.0), 8.0), 16.0 * STEP_M);
        assert_eq!(grid.slack_m(DVec3::new(-2148.0, 0.0, 0.0), 2048.0), 16.0 * STEP_M);
        assert_eq!(grid.slack_m(DVec3::new(2000.0, 0.0, 0.0), 8.0), 2000.0 * 2e-6);
        assert_eq!(grid.offset_m(DVec3::new(10_000.0, 0.0, 0.0)), 0.02);
    }
}
