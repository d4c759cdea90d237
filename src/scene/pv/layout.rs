//! Layout of rows of modules. In: rows, the outline of their area, heights of the surface below.
//! Out: modules as boxes, row by row.

use glam::{DVec2, DVec3};

use super::rows::RowsOfModules;
use crate::covering::surfaces::Surface;
use crate::plan::is_within;

/// A module in input coordinates, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    /// Name `field/2/5`: rows, number of the row, number in the row.
    pub name: String,
    /// Corners of the front, lower edge first, counter-clockwise as seen from in front of it.
    pub front: [DVec3; 4],
    /// Unit normal, away from the front.
    pub normal: DVec3,
    /// Thickness from the front to the rear, metres.
    pub thickness_m: f64,
}

/// Outline of an area in plan.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Edges, in any order and direction.
    edges: Vec<[DVec2; 2]>,
}

/// Step along a row after a place where a module does not fit, metres.
const STEP_M: f64 = 0.05;
/// Tolerance of rounding, metres.
const ROUNDING_M: f64 = 1e-6;
/// Height by which a surface may rise above a module's rear and still only touch it, metres.
const TOUCHING_M: f64 = 1e-3;

impl Outline {
    /// Returns the outline of a polygon.
    pub fn of_polygon(corners: &[DVec2]) -> Self {
        let next = corners.iter().cycle().skip(1);
        Outline { edges: corners.iter().zip(next).map(|(a, b)| [*a, *b]).collect() }
    }

    /// Returns the outline of a surface: the edges that only one of its triangles has.
    pub fn of_surface(surface: &Surface) -> Self {
        let bits = |p: DVec3| p.to_array().map(f64::to_bits);
        let mut edges: Vec<([[u64; 3]; 2], [DVec2; 2])> = Vec::new();
        for &[a, b, c] in &surface.triangles {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                let mut key = [bits(p), bits(q)];
                key.sort_unstable();
                edges.push((key, [p.truncate(), q.truncate()]));
            }
        }
        edges.sort_unstable_by_key(|edge| edge.0);
        let once = edges.chunk_by(|a, b| a.0 == b.0).filter_map(|same| match same {
            [only] => Some(only.1),
            _ => None,
        });
        Outline { edges: once.collect() }
    }

    /// Returns the largest number of places in plan that [`lay`] tries for rows at a pitch.
    pub fn places(&self, pitch_m: f64) -> f64 {
        let corners = || self.edges.iter().flatten();
        let low = corners().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = corners().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        let across = (high - low).max(DVec2::ZERO).length();
        (across / pitch_m + 1.0) * (across / STEP_M + 1.0)
    }

    /// Returns true if a place in plan lies in the area.
    pub(super) fn contains(&self, p: DVec2) -> bool {
        is_within(self.edges.iter().copied(), p)
    }

    /// Returns true if a convex shape lies in the area, at least `setback_m` from all edges.
    fn holds(&self, shape: &[DVec2; 4], setback_m: f64) -> bool {
        let inside = |p: DVec2| self.contains(p);
        let sides = || shape.iter().zip(shape.iter().cycle().skip(1));
        let middle = shape.iter().sum::<DVec2>() / 4.0;
        // Corners may lie on the edge.
        inside(middle)
            && shape.iter().all(|p| inside(*p + (middle - *p).normalize_or_zero() * ROUNDING_M))
            && self.edges.iter().all(|[a, b]| {
                let near = sides().map(|(p, q)| between([*p, *q], [*a, *b])).fold(f64::INFINITY, f64::min);
                near >= setback_m - 2.0 * ROUNDING_M
            })
            && !self.edges.iter().any(|edge| sides().any(|(p, q)| cross(shrunk([*p, *q], middle), *edge)))
    }

    /// Returns the least and the greatest product of the outline's corners with a direction.
    fn extent(&self, along: DVec2) -> [f64; 2] {
        let all = self.edges.iter().flatten().map(|p| p.dot(along));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
}

fn shrunk(side: [DVec2; 2], middle: DVec2) -> [DVec2; 2] {
    side.map(|p| p + (middle - p).normalize_or_zero() * 2.0 * ROUNDING_M)
}

/// Returns true if two lines cross.
fn cross([p, q]: [DVec2; 2], [a, b]: [DVec2; 2]) -> bool {
    let side = |from: DVec2, to: DVec2, of: DVec2| (to - from).perp_dot(of - from);
    side(p, q, a) * side(p, q, b) < 0.0 && side(a, b, p) * side(a, b, q) < 0.0
}

/// Returns the distance between two lines that do not cross.
fn between(one: [DVec2; 2], other: [DVec2; 2]) -> f64 {
    let to_line = |p: DVec2, [a, b]: [DVec2; 2]| {
        let along = b - a;
        let share =
            if along == DVec2::ZERO { 0.0 } else { ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) };
        p.distance(a + along * share)
    };
    let ends = one.map(|p| to_line(p, other)).into_iter().chain(other.map(|p| to_line(p, one)));
    ends.fold(f64::INFINITY, f64::min)
}

/// Axes of rows in plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowAxes {
    /// Direction that fronts face, unit length.
    pub faces: DVec2,
    /// Direction to the right as seen from in front of a row, unit length.
    pub along: DVec2,
    /// First and last distance of the area against `faces`.
    pub behind: [f64; 2],
    /// First and last distance of the area along the rows.
    pub sides: [f64; 2],
}

impl RowAxes {
    /// Returns the axes of rows whose fronts have `normal` in the scene's axes.
    pub fn of(normal: DVec3, outline: &Outline) -> Self {
        // Modules that lie flat have their rows across y.
        let faces = normal.truncate().try_normalize().unwrap_or(DVec2::NEG_Y);
        let along = DVec2::new(-faces.y, faces.x);
        RowAxes { faces, along, behind: outline.extent(-faces), sides: outline.extent(along) }
    }

    /// Returns the distance of the first row's lower edge against `faces`.
    pub fn first_edge(&self, rows: &RowsOfModules) -> f64 {
        let [first, _] = self.behind;
        first + rows.setback_m
    }

    /// Returns the place in plan at distance `side` along the rows and `back` against `faces`.
    pub fn at(&self, side: f64, back: f64) -> DVec2 {
        self.along * side - self.faces * back
    }
}

/// Modules of rows in their places.
#[derive(Clone, Debug, Default)]
pub struct Laid {
    /// Modules row by row, from the row that faces outwards.
    pub modules: Vec<Module>,
    /// Number of modules that fit, but have no surface below or an obstacle through them.
    pub left_out: usize,
}

/// Lays out rows. `normal` is that of their fronts in the scene's axes; `below` gives the height of
/// the surface under a place in plan.
pub fn lay(rows: &RowsOfModules, normal: DVec3, outline: &Outline, below: impl Fn(DVec2) -> Option<f64>) -> Laid {
    let axes = RowAxes::of(normal, outline);
    let RowAxes { faces, along, behind: [_, last], sides: [left, right] } = axes;
    let (sin, cos) = (normal.truncate().length(), normal.z);
    let up = (-faces * cos).extend(sin);
    let depth = rows.height_m * cos.max(0.0);
    let mut laid = Laid::default();
    let mut number = 0;
    for row in 0_u32.. {
        let back = axes.first_edge(rows) + f64::from(row) * rows.pitch_m;
        if back + depth > last - rows.setback_m + ROUNDING_M {
            break;
        }
        let (mut side, mut count) = (left + rows.setback_m, 0);
        while side + rows.width_m <= right - rows.setback_m + ROUNDING_M {
            let lower = axes.at(side, back);
            let foot = [lower, lower + along * rows.width_m];
            let head = foot.map(|p| p - faces * depth);
            let plan = [foot[0], foot[1], head[1], head[0]];
            if !outline.holds(&plan, rows.setback_m) {
                side += STEP_M;
                continue;
            }
            side += rows.width_m + rows.gap_m;
            let Some(front) = raised(&plan, up * rows.height_m, normal, rows, &below) else {
                laid.left_out += 1;
                continue;
            };
            // A row gets its number with its first module, so that empty rows leave no gap.
            if count == 0 {
                number += 1;
            }
            count += 1;
            let name = format!("{}/{number}/{count}", rows.name);
            laid.modules.push(Module { name, front, normal, thickness_m: rows.thickness_m });
        }
    }
    laid
}

/// Distance between the places of a module at which the surface below is compared with its rear,
/// metres: thinner obstacles may be missed.
const SAMPLE_M: f64 = 0.1;

/// Returns the front of a module over its plan, at least the clearance above the surface below each
/// corner of its rear. `None` without a surface below, or with an obstacle that is higher than the
/// rear anywhere, or nearer than the clearance below the middle.
fn raised(
    plan: &[DVec2; 4],
    up: DVec3,
    normal: DVec3,
    rows: &RowsOfModules,
    below: &impl Fn(DVec2) -> Option<f64>,
) -> Option<[DVec3; 4]> {
    let [a, b, c, d] = *plan;
    let rises = [0.0, 0.0, up.z, up.z];
    // The rear lies lower than the front.
    let down = normal.z * rows.thickness_m;
    let mut lowest = f64::NEG_INFINITY;
    for (p, rise) in plan.iter().zip(rises) {
        lowest = lowest.max(below(*p)? + rows.clearance_m - rise + down);
    }
    let front = [a.extend(lowest), b.extend(lowest), c.extend(lowest + up.z), d.extend(lowest + up.z)];
    let middle = front.iter().sum::<DVec3>() / 4.0;
    if below(middle.truncate())? + rows.clearance_m > middle.z + ROUNDING_M {
        return None;
    }
    let steps = |length_m: f64| (length_m / SAMPLE_M).ceil().max(1.0) as usize;
    let (across, along) = (steps(a.distance(b)), steps(a.distance(d)));
    for i in 0..=across {
        for j in 0..=along {
            let (right, back) = (i as f64 / across as f64, j as f64 / along as f64);
            let rear_m = lowest + back * up.z - down;
            if below(a + (b - a) * right + (d - a) * back)? > rear_m + TOUCHING_M {
                return None;
            }
        }
    }
    Some(front)
}

impl Module {
    /// Returns the middle of the front.
    pub fn middle(&self) -> DVec3 {
        self.front.iter().sum::<DVec3>() / 4.0
    }

    /// Returns the corners of the rear, in the order of the front's.
    pub fn rear(&self) -> [DVec3; 4] {
        self.front.map(|p| p - self.normal * self.thickness_m)
    }

    /// Returns true if a point lies inside the module.
    pub(super) fn holds(&self, p: DVec3) -> bool {
        let [a, b, _, d] = self.front;
        let from = p - a;
        let within = |side: DVec3| (0.0..=side.length_squared()).contains(&from.dot(side));
        within(b - a) && within(d - a) && (-self.thickness_m..=0.0).contains(&from.dot(self.normal))
    }

    /// Returns `count` points of one side, evenly up the slope in the middle of the width, at
    /// distance `off_m` from it.
    pub fn points(&self, is_rear: bool, count: usize, off_m: f64) -> Vec<DVec3> {
        let [a, b, c, d] = if is_rear { self.rear() } else { self.front };
        let (foot, head) = ((a + b) / 2.0, (c + d) / 2.0);
        let off = self.normal * if is_rear { -off_m } else { off_m };
        (0..count).map(|i| foot.lerp(head, (i as f64 + 0.5) / count as f64) + off).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::pv::rows::RowsGround;
    use heliotile_core::orientation::fan::Orientation;

    /// Returns rows of modules of 1 m x 2 m, 3 m apart.
    pub fn rows(tilt_deg: f64, azimuth_deg: f64, setback_m: f64) -> RowsOfModules {
        RowsOfModules {
            name: "r".into(),
            ground: RowsGround::Area(Vec::new()),
            turn: Orientation { tilt_deg, azimuth_deg },
            pitch_m: 3.0,
            width_m: 1.0,
            height_m: 2.0,
            clearance_m: 0.5,
            setback_m,
            gap_m: 0.0,
            thickness_m: 0.03,
            reflectances: [0.05; 2],
            samples: 4,
            ground_step_m: None,
        }
    }

    fn square(side: f64) -> Vec<DVec2> {
        [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(DVec2::from).to_vec()
    }

    /// An area of 10 x 10 m holds 4 rows of 10 modules of 1 x 2 m at 60 degrees, 3 m apart, and
    /// with a setback of 1 m 3 rows of 8. The first module's lower edge lies in the south 0.5 m
    /// above the ground, its upper edge 1 m north of it and 1.732 m higher, and its front faces
    /// south.
    #[test]
    fn a_square_holds_4_rows_of_10_modules() {
        let outline = Outline::of_polygon(&square(10.0));
        for (setback, count) in [(0.0, 40), (1.0, 24)] {
            let rows = rows(60.0, 180.0, setback);
            let laid = lay(&rows, rows.turn.normal(), &outline, |_| Some(0.0));
            assert_eq!((laid.modules.len(), laid.left_out), (count, 0), "{setback}");
            let [a, b, c, _] = laid.modules[0].front;
            let low = 0.5 + 0.5 * 0.03;
            assert!(a.distance(DVec3::new(setback, setback, low)) < 1e-9, "{a}");
            assert!(b.distance(DVec3::new(setback + 1.0, setback, low)) < 1e-9, "{b}");
            assert!(c.distance(DVec3::new(setback + 1.0, setback + 1.0, low + 3.0_f64.sqrt())) < 1e-9, "{c}");
            assert!((b - a).cross(c - a).normalize().distance(laid.modules[0].normal) < 1e-9);
            assert_eq!(laid.modules[0].name, "r/1/1");
        }
    }

    /// With fronts turned west, rows begin in the west. An L-shaped area has no module over its
    /// missing quarter. Four points of a rear lie 0.25 of the slope apart and 5 mm below the rear.
    #[test]
    fn turned_rows_leave_a_missing_quarter_free() {
        let west = rows(60.0, 270.0, 0.0);
        let laid = lay(&west, west.turn.normal(), &Outline::of_polygon(&square(10.0)), |_| Some(0.0));
        assert_eq!(laid.modules.len(), 40);
        assert!(laid.modules[0].front[0].x.abs() < 1e-9, "{:?}", laid.modules[0]);
        let l = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (5.0, 5.0), (5.0, 10.0), (0.0, 10.0)].map(DVec2::from);
        let south = rows(60.0, 180.0, 0.0);
        let laid = lay(&south, south.turn.normal(), &Outline::of_polygon(&l), |_| Some(0.0));
        // Rows at 0 and 3 m have 10 modules, rows at 6 and 9 m have 5.
        assert_eq!(laid.modules.len(), 30);
        assert!(laid.modules.iter().all(|m| m.front.iter().all(|p| p.x < 5.0 + 1e-6 || p.y < 5.0 + 1e-6)));
        let module = &laid.modules[0];
        let points = module.points(true, 4, 0.005);
        assert!((points[0].distance(points[1]) - 0.5).abs() < 1e-9);
        let off = (points[2] - module.middle()).dot(module.normal);
        assert!((off + 0.035).abs() < 1e-9, "{off}");
    }

    /// Flush on a roof of 30 degrees every corner of the rear is 0.1 m above the roof; where a
    /// chimney or a pipe stands, the one or two modules that it would pass through are left out.
    #[test]
    fn flush_modules_keep_their_distance_to_a_roof() {
        let mut rows = rows(30.0, 180.0, 0.0);
        (rows.clearance_m, rows.pitch_m) = (0.1, 2.0);
        let plane = |p: DVec2| p.y * 30.0_f64.to_radians().tan();
        let outline = Outline::of_polygon(&square(10.0));
        let laid = lay(&rows, rows.turn.normal(), &outline, |p| Some(plane(p)));
        assert_eq!(laid.modules.len(), 50);
        let gap = |p: DVec3| p.z - plane(p.truncate());
        // Heights are measured straight up from the roof.
        let off = laid.modules.iter().flat_map(|m| m.front).map(gap);
        let expected = 0.1 + 0.03 * 30.0_f64.to_radians().cos();
        assert!(off.into_iter().all(|off| (off - expected).abs() < 1e-9));
        // A chimney in the middle of a module, a pipe near its corner, one between two modules.
        for (x, y, radius, left_out) in [(4.5, 0.866, 0.3, 1), (4.25, 1.3, 0.15, 1), (5.0, 0.866, 0.15, 2)] {
            let pipe = |p: DVec2| Some(if p.distance(DVec2::new(x, y)) < radius { 9.0 } else { plane(p) });
            assert_eq!(lay(&rows, rows.turn.normal(), &outline, pipe).left_out, left_out, "{x} {y}");
        }
    }
}
