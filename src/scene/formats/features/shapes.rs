//! Polygons of geometries. In: what the crate `geozero` finds in well-known binary (OGC 06-103r4).
//! Out: the polygons of a feature.

use std::f64::consts::{PI, TAU};

use geozero::error::{GeozeroError, Result};
use geozero::{CoordDimensions, GeomProcessor};
use glam::DVec3;

use super::feature::{Feature, FeaturePolygon};
use crate::text::excerpt;

/// Most corners of one geometry: the coast of a country has fewer.
const MAX_CORNERS: usize = 1 << 24;

/// Angle of a side that replaces a piece of an arc, radians: 5 degrees, so that a disc loses 0.13
/// %.
const STROKE_RAD: f64 = PI / 36.0;

/// Deepest nesting of collections: the crate `geozero` calls itself for each, and files that
/// programs write have one or two.
const MAX_NESTED: usize = 32;

/// Collector of the polygons of one geometry.
#[derive(Default)]
pub(super) struct Shapes {
    polygons: Vec<FeaturePolygon>,
    points: Vec<DVec3>,
    polygon: FeaturePolygon,
    ring: Vec<DVec3>,
    corners: usize,
    /// Number of collections that contain the geometry that comes next.
    nested: usize,
    /// True if the lines that come are rings of a polygon or triangle.
    in_polygon: bool,
    /// True if the lines that come are pieces of one ring.
    in_compound: bool,
    /// Corners of a line or circular string; a ring is made of one or more.
    piece: Vec<DVec3>,
    is_body: bool,
    has_others: bool,
}

/// Returns why a geometry cannot be read.
pub(super) fn unreadable(error: &GeozeroError) -> String {
    format!("its geometry cannot be read: {}", excerpt(error.to_string().as_bytes()))
}

impl Shapes {
    /// Moves the polygons that were found into a feature.
    pub(super) fn fill(self, feature: &mut Feature) {
        feature.polygons = self.polygons;
        feature.points = self.points;
        feature.is_body = self.is_body;
        feature.has_others = self.has_others;
    }

    /// Adds a piece to the ring; without a compound curve it is the ring.
    fn add(&mut self, piece: Vec<DVec3>) -> Result<()> {
        if !self.in_compound {
            self.ring = piece;
            return self.end_ring();
        }
        let joins = usize::from(self.ring.last() == piece.first());
        self.ring.extend(piece.into_iter().skip(joins));
        Ok(())
    }

    fn end_ring(&mut self) -> Result<()> {
        let ring = std::mem::take(&mut self.ring);
        match self.in_polygon {
            true => self.polygon.push(ring),
            false => self.has_others = true,
        }
        Ok(())
    }

    fn end(&mut self) -> Result<()> {
        self.in_polygon = false;
        self.polygons.push(std::mem::take(&mut self.polygon));
        Ok(())
    }
}

impl GeomProcessor for Shapes {
    fn dimensions(&self) -> CoordDimensions {
        CoordDimensions::xyz()
    }

    fn xy(&mut self, x: f64, y: f64, _: usize) -> Result<()> {
        self.coordinate(x, y, None, None, None, None, 0)
    }

    fn coordinate(
        &mut self,
        x: f64,
        y: f64,
        z: Option<f64>,
        _: Option<f64>,
        _: Option<f64>,
        _: Option<u64>,
        _: usize,
    ) -> Result<()> {
        self.corners += 1;
        if self.corners > MAX_CORNERS {
            return Err(GeozeroError::Geometry("a geometry has more than 16 million corners".to_owned()));
        }
        // Some files write missing heights as NaN.
        let z = z.filter(|z| z.is_finite()).unwrap_or_default();
        self.piece.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn point_begin(&mut self, _: usize) -> Result<()> {
        self.has_others = true;
        self.piece.clear();
        Ok(())
    }

    fn point_end(&mut self, _: usize) -> Result<()> {
        self.points.append(&mut self.piece);
        Ok(())
    }

    fn multipoint_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.point_begin(0)
    }

    fn multipoint_end(&mut self, _: usize) -> Result<()> {
        self.point_end(0)
    }

    fn polygon_begin(&mut self, _: bool, _: usize, _: usize) -> Result<()> {
        self.in_polygon = true;
        self.polygon.clear();
        self.ring.clear();
        Ok(())
    }

    fn polygon_end(&mut self, _: bool, _: usize) -> Result<()> {
        self.end()
    }

    fn triangle_begin(&mut self, _: bool, _: usize, _: usize) -> Result<()> {
        self.polygon_begin(true, 0, 0)
    }

    fn triangle_end(&mut self, _: bool, _: usize) -> Result<()> {
        self.end()
    }

    fn polyhedralsurface_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.is_body = true;
        Ok(())
    }

    fn tin_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.is_body = true;
        Ok(())
    }

    fn linestring_begin(&mut self, _: bool, _: usize, _: usize) -> Result<()> {
        self.piece.clear();
        Ok(())
    }

    fn linestring_end(&mut self, _: bool, _: usize) -> Result<()> {
        let piece = std::mem::take(&mut self.piece);
        self.add(piece)
    }

    fn circularstring_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.piece.clear();
        Ok(())
    }

    fn circularstring_end(&mut self, _: usize) -> Result<()> {
        let piece = stroked(&std::mem::take(&mut self.piece));
        self.add(piece)
    }

    fn compoundcurve_begin(&mut self, _: usize, _: usize) -> Result<()> {
        if self.in_compound {
            return Err(GeozeroError::Geometry("a compound curve holds another one".to_owned()));
        }
        self.in_compound = true;
        self.ring.clear();
        Ok(())
    }

    fn compoundcurve_end(&mut self, _: usize) -> Result<()> {
        self.in_compound = false;
        self.end_ring()
    }

    fn geometrycollection_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.nested += 1;
        if self.nested > MAX_NESTED {
            return Err(GeozeroError::Geometry(format!("collections are nested more than {MAX_NESTED} deep")));
        }
        Ok(())
    }

    fn geometrycollection_end(&mut self, _: usize) -> Result<()> {
        self.nested -= 1;
        Ok(())
    }

    fn curvepolygon_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.polygon_begin(true, 0, 0)
    }

    fn curvepolygon_end(&mut self, _: usize) -> Result<()> {
        self.end()
    }
}

/// Returns a circular string (ISO 13249-3: arcs of three points, each from the end of the last one)
/// as straight sides. A full circle has its second point opposite of the first.
fn stroked(points: &[DVec3]) -> Vec<DVec3> {
    let mut line: Vec<DVec3> = points.first().copied().into_iter().collect();
    let mut rest = points;
    while let [a, b, c, ..] = rest {
        arc(*a, *b, *c, &mut line);
        rest = rest.get(2..).unwrap_or_default();
    }
    line
}

/// Adds the points of an arc from `a` through `b` to `c`, without `a`.
fn arc(a: DVec3, b: DVec3, c: DVec3, line: &mut Vec<DVec3>) {
    let is_circle = a.truncate() == c.truncate();
    let (p, q) = ((b - a).truncate(), (c - a).truncate());
    let middle = match is_circle {
        true => Some(0.5 * p),
        // Centre of the circle through three points.
        false => {
            let turn = 2.0 * p.perp_dot(q);
            let centre = (p.length_squared() * q.perp() - q.length_squared() * p.perp()) / -turn;
            (turn.abs() > 1e-12 * p.length() * q.length()).then_some(centre)
        }
    };
    let Some(middle) = middle.filter(|middle| middle.is_finite() && middle.length() > 0.0) else {
        // Three points on a line.
        line.extend([b, c]);
        return;
    };
    let spoke = -middle;
    let angle = |to: glam::DVec2| {
        let turned = spoke.angle_to(to - middle);
        if turned < 0.0 { turned + TAU } else { turned }
    };
    let sweep = match is_circle {
        true => TAU,
        false if angle(p) <= angle(q) => angle(q),
        false => angle(q) - TAU,
    };
    let sides = (sweep.abs() / STROKE_RAD).ceil().max(2.0) as u32;
    for side in 1..sides {
        let share = f64::from(side) / f64::from(sides);
        let at = a.truncate() + middle + glam::DVec2::from_angle(sweep * share).rotate(spoke);
        line.push(at.extend(a.z + (c.z - a.z) * share));
    }
    line.push(c);
}

#[cfg(test)]
mod tests {
    use geozero::GeozeroGeometry;
    use geozero::wkb::Wkb;

    use super::*;
    use crate::plan::signed_area_m2;

    /// Half a disc of 10 m radius on a square of 20 m has 100 pi m2 / 2 within 0.5 %, drawn either
    /// way, and so has a full circle of two arcs or one.
    #[test]
    fn arcs_become_straight_sides() {
        let at = |x: f64, y: f64| DVec3::new(500_000.0 + x, 5_400_000.0 + y, 0.0);
        let disc = std::f64::consts::PI * 100.0;
        for (points, expected) in [
            (vec![at(10., 0.), at(0., 10.), at(-10., 0.)], 0.5 * disc),
            (vec![at(-10., 0.), at(0., 10.), at(10., 0.)], -0.5 * disc),
            (vec![at(10., 0.), at(0., 10.), at(-10., 0.), at(0., -10.), at(10., 0.)], disc),
            (vec![at(10., 0.), at(-10., 0.), at(10., 0.)], disc),
        ] {
            let ring: Vec<glam::DVec2> = stroked(&points).iter().map(|corner| corner.truncate()).collect();
            let area = signed_area_m2(&ring);
            assert!((area / expected - 1.0).abs() < 5e-3, "{area} {expected}");
        }
        assert_eq!(stroked(&[at(0., 0.), at(5., 0.), at(10., 0.)]).len(), 3);
    }

    /// 32 collections around a triangle give one polygon; 33 are refused, and so are 100,000, which
    /// would overflow the stack of the library.
    #[test]
    fn collections_nest_thirty_two_deep_at_most() {
        let nested = |depth: usize| {
            let mut bytes = [1, 7, 0, 0, 0, 1, 0, 0, 0].repeat(depth);
            bytes.extend([1, 3, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0]);
            bytes.extend([0.0, 0.0, 9.0, 0.0, 9.0, 9.0_f64].iter().flat_map(|number| number.to_le_bytes()));
            let mut shapes = Shapes::default();
            Wkb(bytes).process_geom(&mut shapes).map(|()| shapes.polygons.len())
        };
        assert_eq!(nested(MAX_NESTED).expect("read"), 1);
        for depth in [MAX_NESTED + 1, 100_000] {
            let message = nested(depth).expect_err("too deep").to_string();
            assert!(message.contains("nested more than 32 deep"), "{message}");
        }
    }
}
