//! Search for ground. In: triangles of class ground, and triangles that may stand on them. Out:
//! whether the ground lies free, which the floor of a house below its roof does not, and whether it
//! surrounds what stands on it, which a road beside a house does not.

use glam::{DVec2, DVec3};

/// A triangle in input coordinates, metres.
pub(crate) type Corners = [DVec3; 3];

/// Least share of the ground that lies free. Below it the ground is floors of buildings, whose
/// roofs are drawn a little smaller than they are.
const FREE: f64 = 0.05;
/// Least share of the open plan around the standing triangles that ground covers if it surrounds
/// them.
const AROUND: f64 = 0.25;
/// Width of the rim around the standing triangles that counts as their plan, in their mean height:
/// most of the light that a wall gets from the ground comes from about that far.
const RIM_HEIGHTS: f64 = 0.5;
/// Height of the lowest standing triangle above the highest ground beyond which nothing stands on
/// that ground, metres: land that was drawn at height 0.
pub(crate) const DETACHED_M: f64 = 5.0;
/// Height up to which a surface lies on the ground, metres.
const SAME_HEIGHT_M: f64 = 0.01;
/// Least upward component of the unit normal, up or down, of a face that counts; steeper faces are
/// standing.
const UPRIGHT: f64 = 0.1;
/// Points on each side of the plan: the most of these that need at most `MAX_VISITS` tests of a
/// point in a triangle's box.
const SIDES: [usize; 6] = [1024, 512, 256, 128, 64, 32];
const MAX_VISITS: f64 = 3e8;
/// Points on each side if all of `SIDES` need more tests.
const MIN_SIDE: usize = 16;
/// Points on each side of the plan around standing triangles.
const AROUND_SIDE: usize = 128;

/// Returns true if some ground lies free, with nothing of `above` over it. Standing triangles do
/// not count.
pub(crate) fn lies_free(
    ground: impl Iterator<Item = Corners> + Clone,
    above: impl Iterator<Item = Corners> + Clone,
) -> bool {
    let level = |[a, b, c]: &Corners| {
        let normal = (*b - *a).cross(*c - *a);
        normal.z.abs() > UPRIGHT * normal.length()
    };
    let (ground, above) = (ground.filter(level), above.filter(level));
    let corners = ground.clone().flatten().map(|p| p.truncate());
    let (low, high) = corners.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let extent = high - low;
    if !(extent.is_finite() && extent.min_element() > 0.0) {
        return false;
    }
    let share = |triangle: Corners| {
        let [a, b, c] = triangle.map(|p| ((p.truncate() - low) / extent).clamp(DVec2::ZERO, DVec2::ONE));
        (a.max(b).max(c) - a.min(b).min(c)).element_product()
    };
    let shares: f64 = ground.clone().chain(above.clone()).map(share).sum();
    let fits = |side: &usize| shares * (side * side) as f64 <= MAX_VISITS;
    let side = SIDES.into_iter().find(fits).unwrap_or(MIN_SIDE);
    let plan = Plan { low, cell: extent / side as f64, side };
    let (ground, above) = (plan.highest(ground), plan.highest(above));
    let (mut free, mut all) = (0_usize, 0_usize);
    for (ground, above) in ground.iter().zip(&above).filter(|(ground, _)| ground.is_finite()) {
        all += 1;
        free += usize::from(*above <= *ground + SAME_HEIGHT_M as f32);
    }
    free as f64 > FREE * all as f64
}

/// Returns true if ground covers a quarter of the open plan in and around the box of the triangles
/// that stand, and its highest open point lies at most `DETACHED_M` below the lowest of them.
/// Floors below roofs are not open. Without standing triangles the ground is the scene.
pub(crate) fn surrounds(
    ground: impl Iterator<Item = Corners> + Clone,
    standing: impl Iterator<Item = Corners> + Clone,
) -> bool {
    let bounds = |corners: &mut dyn Iterator<Item = DVec3>| {
        corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    };
    let (low, high) = bounds(&mut standing.clone().flatten());
    if !(low.is_finite() && high.is_finite()) {
        return true;
    }
    // The mean height of what has a roof: one tower does not widen the rim of a town.
    let side = AROUND_SIDE;
    let extent = (high - low).truncate().max(DVec2::splat(SAME_HEIGHT_M));
    let roofs = Plan { low: low.truncate(), cell: extent / side as f64, side }.highest(standing.clone());
    let (mut tops, mut count) = (0.0, 0_usize);
    for top in roofs.iter().filter(|top| top.is_finite()) {
        (tops, count) = (tops + f64::from(*top), count + 1);
    }
    let mean_top = if count == 0 { high.z } else { tops / count as f64 };
    let rim = (RIM_HEIGHTS * (mean_top - low.z)).max(SAME_HEIGHT_M);
    let (corner, extent) = (low.truncate() - rim, (high - low).truncate() + 2.0 * rim);
    let near = |triangle: &Corners| {
        let (low_of, high_of) = bounds(&mut triangle.iter().copied());
        high_of.truncate().cmpge(corner).all() && low_of.truncate().cmple(corner + extent).all()
    };
    let plan = Plan { low: corner, cell: extent / side as f64, side };
    let (ground, standing) = (plan.highest(ground.filter(near)), plan.highest(standing));
    let (mut covered, mut all, mut top) = (0_usize, 0_usize, f32::NEG_INFINITY);
    for (ground, _) in ground.iter().zip(&standing).filter(|(_, standing)| !standing.is_finite()) {
        all += 1;
        covered += usize::from(ground.is_finite());
        top = top.max(*ground);
    }
    let attached = f64::from(top) >= low.z - DETACHED_M;
    all == 0 || attached && covered as f64 >= AROUND * all as f64
}

/// Points of a rectangle, each in the middle of its cell.
struct Plan {
    low: DVec2,
    cell: DVec2,
    side: usize,
}

impl Plan {
    /// Returns the height of the highest triangle over each point, `[row][column]`; minus infinity
    /// over points without one.
    fn highest(&self, triangles: impl Iterator<Item = Corners>) -> Vec<f32> {
        let mut heights = vec![f32::NEG_INFINITY; self.side * self.side];
        for [a, b, c] in triangles {
            let [p, q, r] = [a, b, c].map(|corner| (corner.truncate() - self.low) / self.cell);
            let area = (q - p).perp_dot(r - p);
            if area == 0.0 {
                continue;
            }
            // `as` saturates: boxes outside give an empty range or end at the border.
            let range = |from: f64, to: f64| (from + 0.5) as usize..((to + 0.5) as usize).min(self.side);
            let (least, most) = (p.min(q).min(r), p.max(q).max(r));
            for row in range(least.y, most.y) {
                for column in range(least.x, most.x) {
                    let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                    let (of_b, of_c) = ((at - p).perp_dot(r - p) / area, (q - p).perp_dot(at - p) / area);
                    let of_a = 1.0 - of_b - of_c;
                    if of_a >= 0.0
                        && of_b >= 0.0
                        && of_c >= 0.0
                        && let Some(height) = heights.get_mut(row * self.side + column)
                    {
                        *height = height.max((of_a * a.z + of_b * b.z + of_c * c.z) as f32);
                    }
                }
            }
        }
        heights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two triangles over a rectangle.
    fn rectangle([x0, y0, x1, y1]: [f64; 4], z: f64) -> Vec<Corners> {
        let corner = |x, y| DVec3::new(x, y, z);
        let [a, b, c, d] = [corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1)];
        vec![[a, b, c], [a, c, d]]
    }

    fn free(ground: &[Corners], above: &[Corners]) -> bool {
        lies_free(ground.iter().copied(), above.iter().copied())
    }

    /// Floors of two houses 30 km apart below roofs that are 1 cm shorter on each side are no
    /// ground. A ring of a tenth of the area around one of them is ground, and so is a field; a
    /// field under a larger hall is not, and a cellar's ceiling below a field hides none of it: 5
    /// of 5.
    #[test]
    fn floors_are_no_ground() {
        let floors =
            [rectangle([0., 0., 10., 10.], 0.0), rectangle([30_000., 30_000., 30_010., 30_010.], 3.0)].concat();
        let roofs =
            [rectangle([0.01, 0.01, 9.99, 9.99], 6.0), rectangle([30_000.01, 30_000.01, 30_009.99, 30_009.99], 9.0)];
        let field = rectangle([-50., -50., 50., 50.], 2.0);
        let hall = rectangle([-60., -60., 60., 60.], 7.0);
        let cellar = rectangle([-50., -50., 50., 50.], -1.0);
        assert!(!free(&floors, &roofs.concat()));
        assert!(free(&rectangle([-0.25, -0.25, 10.25, 10.25], 0.0), &roofs[0]));
        assert!(free(&field, &roofs[0]));
        assert!(!free(&field, &hall));
        assert!(free(&field, &cellar));
    }

    /// A scene without ground, and one whose only triangle of class ground is standing, have none:
    /// 2 of 2.
    #[test]
    fn standing_triangles_are_no_ground() {
        let standing = [DVec3::ZERO, DVec3::X, DVec3::Z];
        assert!(!free(&[], &rectangle([0., 0., 1., 1.], 0.0)));
        assert!(!free(&[standing], &[]));
    }

    /// A house of 10 x 10 x 8 m: a lawn with a rim of 20 m surrounds it; a road beside it, a
    /// manhole and a plate with a rim of 1 m do not, nor does land that lies 40 m below it, with or
    /// without the floor of the house: 5 of 6 do not. Ground on which nothing stands surrounds
    /// itself.
    #[test]
    fn a_road_or_a_manhole_does_not_surround_a_house() {
        let wall = [DVec3::ZERO, DVec3::new(10., 0., 0.), DVec3::new(0., 0., 8.)];
        let house = [rectangle([0., 0., 10., 10.], 8.0), vec![wall]].concat();
        let around = |ground: Vec<Corners>| surrounds(ground.into_iter(), house.iter().copied());
        assert!(around(rectangle([-20., -20., 30., 30.], 0.0)));
        let without = [
            ([-20., -15., 40., -5.], 0.0),
            ([20., 0., 21., 1.], 0.0),
            ([-1., -1., 11., 11.], 0.0),
            ([-200., -200., 200., 200.], -40.0),
        ];
        assert_eq!(without.map(|(plan, z)| around(rectangle(plan, z))), [false; 4]);
        let floor = rectangle([0., 0., 10., 10.], 0.0);
        assert!(!around([floor, rectangle([-200., -200., 200., 200.], -40.0)].concat()));
        assert!(surrounds(rectangle([0., 0., 1., 1.], 0.0).into_iter(), [].into_iter()));
    }
}
