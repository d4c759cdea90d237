//! A rectangle of a region that is built by itself. In: triangles with their objects. Out: the
//! triangles that receivers in the rectangle may see, and the receivers that belong to it.
//!
//! Objects stay whole, so that none has an open side; objects wider than the part are taken face by
//! face. All ground is taken: if it ended, receivers that look over the nearest roofs would see
//! nothing below the horizon.

use glam::{DVec2, DVec3};

use crate::mesh::RawTriangle;

/// A rectangle of a region: receivers inside belong to it, and neighbours around it count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionPart {
    /// South-west corner, input coordinates, metres; points on its edges are inside.
    pub low: DVec2,
    /// North-east corner; points on its edges are outside.
    pub high: DVec2,
    /// Distance from the rectangle in plan up to which everything counts, metres.
    pub halo_m: f64,
    /// Elevation angle above which a box beyond the halo counts, degrees: its top as seen from the
    /// rectangle's lowest point at its edge.
    pub skyline_deg: f64,
}

impl RegionPart {
    /// Returns true if a receiver belongs to this part.
    pub fn owns(&self, place: DVec3) -> bool {
        let place = place.truncate();
        place.cmpge(self.low).all() && place.cmplt(self.high).all()
    }

    /// Returns true if a box has a point in the rectangle, its edges included.
    pub fn touches(&self, low: DVec3, high: DVec3) -> bool {
        self.distance_m(low, high) == 0.0
    }

    /// Returns true if a box may matter to receivers in the rectangle, whose lowest point is at
    /// `base_m`.
    pub fn counts(&self, low: DVec3, high: DVec3, base_m: f64) -> bool {
        let distance_m = self.distance_m(low, high);
        distance_m <= self.halo_m || high.z - base_m > distance_m * self.skyline_deg.to_radians().tan()
    }

    /// Returns the distance from the rectangle to a box in plan, metres.
    fn distance_m(&self, low: DVec3, high: DVec3) -> f64 {
        (self.low - high.truncate()).max(low.truncate() - self.high).max(DVec2::ZERO).length()
    }

    /// Returns true if a box is wider than the rectangle.
    fn is_wider(&self, low: DVec3, high: DVec3) -> bool {
        (high - low).truncate().cmpgt(self.high - self.low).any()
    }

    /// Returns true for each triangle that may matter to receivers of this part. `objects` is the
    /// object of each triangle; `is_ground` is true for materials of ground.
    pub(crate) fn seen(
        &self,
        positions: &[DVec3],
        triangles: &[RawTriangle],
        objects: &[u32],
        is_ground: impl Fn(u32) -> bool,
    ) -> Vec<bool> {
        let box_of = |triangle: &RawTriangle| {
            let corners = triangle.corners.iter().filter_map(|&corner| positions.get(corner as usize));
            corners.fold(NOTHING, |(low, high), p| (low.min(*p), high.max(*p)))
        };
        // The box of each object, and true if all of it is ground: a building's floor counts only
        // with its walls.
        let mut extents = vec![(NOTHING, true); objects.iter().max().map_or(0, |&last| last as usize + 1)];
        let (mut inside_m, mut lowest_m) = (f64::INFINITY, f64::INFINITY);
        for (triangle, &object) in triangles.iter().zip(objects) {
            let (low, high) = box_of(triangle);
            if let Some((extent, is_all_ground)) = extents.get_mut(object as usize) {
                *extent = (extent.0.min(low), extent.1.max(high));
                *is_all_ground &= is_ground(triangle.material);
            }
            lowest_m = lowest_m.min(low.z);
            if self.touches(low, high) {
                inside_m = inside_m.min(low.z);
            }
        }
        let base_m = if inside_m.is_finite() { inside_m } else { lowest_m };
        let seen = |(triangle, &object): (&RawTriangle, &u32)| {
            let (low, high) = match extents.get(object as usize) {
                Some((_, true)) => return true,
                Some(&((low, high), false)) if !self.is_wider(low, high) => (low, high),
                _ => box_of(triangle),
            };
            self.counts(low, high, base_m)
        };
        triangles.iter().zip(objects).map(seen).collect()
    }
}

/// Box without a point.
const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

#[cfg(test)]
mod tests {
    use super::*;

    const PART: RegionPart =
        RegionPart { low: DVec2::ZERO, high: DVec2::new(100.0, 100.0), halo_m: 50.0, skyline_deg: 10.0 };

    /// Two parts side by side share none of their 3 points, and every point has one owner; 3 points
    /// outside have none.
    #[test]
    fn every_point_has_one_part_at_most() {
        let east = RegionPart { low: DVec2::new(100.0, 0.0), high: DVec2::new(200.0, 100.0), ..PART };
        let owners = |x: f64| [PART, east].iter().filter(|part| part.owns(DVec3::new(x, 0.0, 5.0))).count();
        assert_eq!([0.0, 100.0, 199.999].map(owners), [1, 1, 1]);
        assert_eq!([-0.001, 200.0, 250.0].map(owners), [0, 0, 0]);
    }

    /// Three of five boxes count: one inside, one in the halo and a tower of 30 m at 150 m (11.3
    /// degrees). A tower of 20 m there (7.6 degrees) and a box of 3 m that ends 151 m west of the
    /// part do not.
    #[test]
    fn near_or_tall_boxes_count_as_neighbours() {
        let counts =
            |x: f64, height: f64| PART.counts(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 10.0, 10.0, height), 0.0);
        assert_eq!([counts(50.0, 3.0), counts(149.0, 3.0), counts(250.0, 30.0)], [true; 3]);
        assert_eq!([counts(250.0, 20.0), counts(-161.0, 3.0)], [false; 2]);
    }

    /// A house of two triangles, one of them in the halo, is seen whole; of a viaduct 500 m wide
    /// only the triangle that touches the part is seen; of terrain as wide both are. A house 480 m
    /// away is not seen, neither its wall nor its floor, whose material is the ground's.
    #[test]
    fn small_objects_count_whole_and_wide_ones_cut() {
        const GROUND: u32 = 7;
        let at = |x: f64| [DVec3::new(x, 0.0, 0.0), DVec3::new(x + 20.0, 0.0, 0.0), DVec3::new(x, 20.0, 1.0)];
        let of = [
            (140.0, 0, 0, true),
            (155.0, 0, 0, true),
            (0.0, 1, 0, true),
            (480.0, 1, 0, false),
            (0.0, 2, GROUND, true),
            (480.0, 2, GROUND, true),
            (480.0, 3, 0, false),
            (480.0, 3, GROUND, false),
        ];
        let positions: Vec<DVec3> = of.iter().flat_map(|(x, ..)| at(*x)).collect();
        let triangle = |(first, (_, _, material, _)): (u32, &(f64, u32, u32, bool))| RawTriangle {
            corners: [0, 1, 2].map(|corner| 3 * first + corner),
            material: *material,
            object: 0,
        };
        let triangles: Vec<RawTriangle> = (0..).zip(&of).map(triangle).collect();
        let seen = PART.seen(&positions, &triangles, &of.map(|(_, object, ..)| object), |material| material == GROUND);
        assert_eq!(seen, of.map(|(.., seen)| seen));
    }
}
