//! Joins the patches of a face to outlines. In: polygons of neighbouring receivers, rounded to mm.
//! Out: polygons, one for each connected piece of a plane, with holes. Polygons of curved surfaces
//! stay as they are.

use glam::DVec3;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};

use super::row::MapPolygon;
use heliotile_core::hemisphere::Frame;

/// Polygon of a patch, with the normal of its receiver.
#[derive(Clone, Debug)]
pub struct Piece {
    pub ring: Vec<DVec3>,
    pub normal: DVec3,
}

/// Distance by which polygons are grown and shrunk, metres, so that gaps of up to twice this are
/// closed. Corners are rounded to mm around their receivers and fine corners are removed, so
/// neighbours have gaps or overlaps of up to sqrt(3) mm.
const CLOSED_M: f64 = 0.002_5;

/// Corners nearer than this to the line through their neighbours are removed, metres.
const STRAIGHT_M: f64 = 0.002;

/// Largest distance, metres, at which two corners are replaced by the intersection of the lines
/// beside them. All replacements are kept only if the area of the ring changes by less than
/// `FEWER_SHARE`.
const NEAR_M: f64 = 0.005;
const FEWER_SHARE: f64 = 1e-4;

/// Largest difference of the normals of pieces in one plane (1 degree); `SAME_PLANE_M` is the
/// largest distance of corners from the plane, metres.
const SAME_WAY: f64 = 0.017_45;
const SAME_PLANE_M: f64 = 0.01;

/// Largest number of planes; a surface with more is curved.
const MAX_PLANES: usize = 512;

/// Largest difference in area between an outline and its pieces, as a share of the pieces' area.
/// The rounding of its rim may explain more: `RIM_M` times its length.
const AREA_SHARE: f64 = 0.001;
const RIM_M: f64 = 0.001;

type Ring = Vec<[f64; 2]>;

/// Pieces of one plane.
struct Plane {
    frame: Frame,
    origin: DVec3,
    pieces: Vec<Piece>,
}

impl Plane {
    fn holds(&self, piece: &Piece) -> bool {
        (piece.normal - self.frame.n).length() < SAME_WAY
            && piece.ring.iter().all(|corner| (*corner - self.origin).dot(self.frame.n).abs() < SAME_PLANE_M)
    }

    fn flat(&self, ring: &[DVec3]) -> Ring {
        let local = ring.iter().map(|corner| self.frame.to_local(*corner - self.origin));
        let mut ring: Ring = local.map(|local| [local.x, local.y]).collect();
        if area_m2(&ring) < 0.0 {
            ring.reverse();
        }
        ring
    }

    fn lifted(&self, ring: &Ring) -> Vec<DVec3> {
        let corner = |&[x, y]: &[f64; 2]| self.origin + self.frame.to_world(DVec3::new(x, y, 0.0));
        ring.iter().map(corner).collect()
    }

    /// Returns the outlines of the pieces: grown, united and shrunk again, which closes narrow
    /// gaps. Returns `None` if the area changes too much.
    fn outlines(&self) -> Option<Vec<MapPolygon>> {
        let flat: Vec<Vec<Ring>> = self.pieces.iter().map(|piece| vec![self.flat(&piece.ring)]).collect();
        let pieces_m2: f64 = flat.iter().flatten().map(area_m2).sum();
        let style = |offset: f64| OutlineStyle::new(offset).line_join(LineJoin::Miter(0.1));
        let closed = flat.outline(&style(CLOSED_M)).outline(&style(-CLOSED_M));
        let (mut found, mut found_m2, mut rim_m) = (Vec::new(), 0.0, 0.0);
        for shape in closed {
            let rings: Vec<Ring> = shape.iter().map(with_few_corners).filter(is_wide).collect();
            found_m2 += rings.iter().map(area_m2).sum::<f64>();
            rim_m += rings.iter().map(length_m).sum::<f64>();
            if !rings.is_empty() {
                found.push(MapPolygon { rings: rings.iter().map(|ring| self.lifted(ring)).collect() });
            }
        }
        let allowed = (AREA_SHARE * pieces_m2).max(RIM_M * rim_m);
        (!found.is_empty() && (found_m2 - pieces_m2).abs() <= allowed).then_some(found)
    }
}

/// Returns the outlines of the pieces of a surface, an object or a building.
pub fn outlines(pieces: Vec<Piece>) -> Vec<MapPolygon> {
    let mut planes: Vec<Plane> = Vec::new();
    let mut loose = Vec::new();
    for piece in pieces {
        if let Some(plane) = planes.iter_mut().rev().find(|plane| plane.holds(&piece)) {
            plane.pieces.push(piece);
            continue;
        }
        let origin = piece.ring.first().copied().unwrap_or_default();
        let plane = Plane { frame: Frame::new(piece.normal), origin, pieces: Vec::new() };
        if planes.len() < MAX_PLANES && plane.holds(&piece) {
            planes.push(Plane { pieces: vec![piece], ..plane });
        } else {
            loose.push(piece);
        }
    }
    let as_it_is = |piece: Piece| MapPolygon { rings: vec![piece.ring] };
    let mut found: Vec<MapPolygon> = Vec::new();
    for plane in planes {
        match plane.outlines() {
            Some(outlines) if plane.pieces.len() > 1 => found.extend(outlines),
            _ => found.extend(plane.pieces.into_iter().map(as_it_is)),
        }
    }
    found.extend(loose.into_iter().map(as_it_is));
    found
}

/// Returns the signed area, positive if anticlockwise.
fn area_m2(ring: &Ring) -> f64 {
    let following = ring.iter().cycle().skip(1);
    ring.iter().zip(following).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
}

fn length_m(ring: &Ring) -> f64 {
    let following = ring.iter().cycle().skip(1);
    ring.iter().zip(following).map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
}

/// Returns true if a ring is more than a slit between patches.
fn is_wide(ring: &Ring) -> bool {
    ring.len() > 2 && area_m2(ring).abs() > CLOSED_M * length_m(ring)
}

/// Removes corners that come from rounding, even if rounding made several out of one.
fn with_few_corners(ring: &Ring) -> Ring {
    let straight = straightened(ring);
    let fewer = straightened(&sharpened(&straight));
    let change_m2 = (area_m2(&fewer) - area_m2(&straight)).abs();
    if change_m2 <= FEWER_SHARE * area_m2(&straight).abs() { fewer } else { straight }
}

/// Replaces edges of a few mm by the intersection of the lines beside them.
fn sharpened(ring: &Ring) -> Ring {
    let mut ring = ring.clone();
    let mut i = 0;
    while ring.len() > 3 && i < ring.len() {
        let count = ring.len();
        let at = |k: usize| ring.get(k % count).copied().unwrap_or_default();
        let (b, c) = (at(i), at(i + 1));
        let far = |p: &[f64; 2]| (p[0] - b[0]).hypot(p[1] - b[1]).max((p[0] - c[0]).hypot(p[1] - c[1]));
        match meeting([at(i + count - 1), b], [c, at(i + 2)]).filter(|p| far(p) <= NEAR_M) {
            Some(corner) => {
                ring[i] = corner;
                ring.remove((i + 1) % count);
                // The search starts again, as the ring has changed.
                i = 0;
            }
            None => i += 1,
        }
    }
    ring
}

/// Returns the intersection of the lines through two edges; `None` if they are parallel.
fn meeting([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let across = u[0] * v[1] - u[1] * v[0];
    let share = ((c[0] - a[0]) * v[1] - (c[1] - a[1]) * v[0]) / across;
    share.is_finite().then(|| [a[0] + share * u[0], a[1] + share * u[1]])
}

/// Removes corners on a straight line.
fn straightened(ring: &Ring) -> Ring {
    let mut ring = ring.clone();
    let mut i = 0;
    while ring.len() > 3 && i < ring.len() {
        let count = ring.len();
        let at = |k: usize| ring.get(k % count).copied().unwrap_or_default();
        let ([ax, ay], [bx, by], [cx, cy]) = (at(i + count - 1), at(i), at(i + 1));
        let across = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if across.abs() <= STRAIGHT_M * (cx - ax).hypot(cy - ay) {
            ring.remove(i);
        } else {
            i += 1;
        }
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORIGIN: DVec3 = DVec3::new(78_593.650_9, 457_825.906, 14.317);

    /// Returns squares of a metre, with corners rounded to mm around their middles, in a plane
    /// tilted by 40 degrees; squares for which `there` is false are left out.
    fn roof(side: i32, there: impl Fn(i32, i32) -> bool) -> Vec<Piece> {
        let normal = DVec3::new(0.4, -0.5, 0.8).normalize();
        let frame = Frame::new(normal);
        let origin = ORIGIN;
        let places = (0..side).flat_map(|i| (0..side).map(move |j| (i, j))).filter(|(i, j)| there(*i, *j));
        let piece = |(i, j): (i32, i32)| {
            let middle = origin + frame.to_world(DVec3::new(f64::from(i) + 0.5, f64::from(j) + 0.5, 0.0));
            let corner = |(x, y): (f64, f64)| {
                let to = frame.to_world(DVec3::new(x, y, 0.0));
                middle + DVec3::from_array(to.to_array().map(|metres| (metres * 1e3).round() / 1e3))
            };
            Piece { ring: [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(corner).to_vec(), normal }
        };
        places.map(piece).collect()
    }

    fn total_m2(polygons: &[MapPolygon]) -> f64 {
        polygons.iter().map(MapPolygon::area_m2).sum()
    }

    /// 100 squares with gaps and overlaps of a mm become one outline of 4 corners instead of 400,
    /// within 5 mm of the true square, of 100 m2 within 0.1 % and with the same normal. Without
    /// four squares in the middle it has one hole of 4 m2.
    #[test]
    fn squares_become_one_outline() {
        let whole = outlines(roof(10, |_, _| true));
        assert!(whole.len() == 1 && whole[0].corners().count() == 4, "{whole:?}");
        let frame = Frame::new(DVec3::new(0.4, -0.5, 0.8).normalize());
        for corner in [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)] {
            let corner = ORIGIN + frame.to_world(DVec3::new(corner.0, corner.1, 0.0));
            let off = whole[0].corners().map(|found| (*found - corner).length()).fold(f64::INFINITY, f64::min);
            assert!(off < 0.005, "{off}");
        }
        assert!((total_m2(&whole) - 100.0).abs() < 0.1, "{}", total_m2(&whole));
        assert!(whole[0].normal().dot(DVec3::new(0.4, -0.5, 0.8).normalize()) > 0.999_99);
        let holed = outlines(roof(10, |i, j| !((4..6).contains(&i) && (4..6).contains(&j))));
        assert_eq!((holed.len(), holed[0].rings.len()), (1, 2));
        assert!((total_m2(&holed) - 96.0).abs() < 0.096, "{}", total_m2(&holed));
    }

    /// A square of 2 m with a corner cut by 3 mm gets its corner back within 0.1 mm. An octagon of
    /// 1 cm keeps its 8 corners, as its area would change. A step of 4 mm in an edge stays, too, as
    /// its lines do not meet.
    #[test]
    fn true_corners_stay() {
        let cut = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.997], [1.997, 2.0], [0.0, 2.0]];
        let found = with_few_corners(&cut);
        assert!(found.len() == 4 && found.iter().any(|p| (p[0] - 2.0).hypot(p[1] - 2.0) < 1e-4), "{found:?}");
        let octagon = (0..8)
            .map(|i| (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos())
            .map(|(s, c)| [0.01 * c, 0.01 * s])
            .collect();
        assert_eq!(with_few_corners(&octagon).len(), 8);
        let step = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.996], [0.0, 1.996]];
        assert_eq!(with_few_corners(&step).len(), 6);
    }

    /// Two faces of a ridge are two outlines, two separate pieces of a roof are two, and 900 pieces
    /// of a bowl stay 900 polygons of the same area.
    #[test]
    fn planes_stay_apart() {
        let mut ridge = roof(4, |_, _| true);
        ridge.extend(roof(4, |_, _| true).into_iter().map(|piece| Piece {
            ring: piece.ring.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).rev().collect(),
            normal: DVec3::new(-piece.normal.x, piece.normal.y, piece.normal.z),
        }));
        assert_eq!(outlines(ridge).len(), 2);
        assert_eq!(outlines(roof(5, |i, _| i != 2)).len(), 2);
        let bowl: Vec<Piece> = (0..900)
            .map(|i| {
                let (x, y) = (f64::from(i % 30), f64::from(i / 30));
                let height = |x: f64, y: f64| DVec3::new(x, y, 0.01 * (x * x + y * y));
                let ring = vec![height(x, y), height(x + 1.0, y), height(x, y + 1.0)];
                let normal = (ring[1] - ring[0]).cross(ring[2] - ring[0]).normalize();
                Piece { ring, normal }
            })
            .collect();
        let before: f64 = bowl.iter().map(|piece| MapPolygon { rings: vec![piece.ring.clone()] }.area_m2()).sum();
        let found = outlines(bowl);
        assert!(found.len() == 900 && (total_m2(&found) - before).abs() < 1e-9);
    }
}
