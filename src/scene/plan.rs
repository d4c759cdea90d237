//! Rings in plan. In: corners, the first not repeated at the end. Out: their signed area, and true
//! for places within.

use glam::DVec2;

/// Returns the area of a ring, m2; positive if the ring runs anticlockwise. Corners count from the
/// first one, because national coordinates are large.
pub(crate) fn signed_area_m2(ring: &[DVec2]) -> f64 {
    let first = ring.first().copied().unwrap_or_default();
    0.5 * sides(ring).map(|[a, b]| (a - first).perp_dot(b - first)).sum::<f64>()
}

/// Returns true if a place lies within sides that enclose an area, by crossings of a ray to the
/// east (Shimrat 1962).
pub(crate) fn is_within(sides: impl Iterator<Item = [DVec2; 2]>, at: DVec2) -> bool {
    let crossed =
        sides.filter(|[a, b]| (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x));
    crossed.count() % 2 == 1
}

/// Returns the sides of a ring; the last one leads back to the first corner.
pub(crate) fn sides(ring: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 4 m has 16 m2 far from the origin, and -16 m2 the other way round; its middle
    /// lies within, a place beside it does not.
    #[test]
    fn areas_have_a_sign_and_places_are_within() {
        let at = |x: f64, y: f64| DVec2::new(500_000.0 + x, 5_000_000.0 + y);
        let mut ring = vec![at(0., 0.), at(4., 0.), at(4., 4.), at(0., 4.)];
        assert!((signed_area_m2(&ring) - 16.0).abs() < 1e-9);
        assert!(is_within(sides(&ring), at(2., 2.)) && !is_within(sides(&ring), at(5., 2.)));
        ring.reverse();
        assert!((signed_area_m2(&ring) + 16.0).abs() < 1e-9 && signed_area_m2(&[]) == 0.0);
    }
}
