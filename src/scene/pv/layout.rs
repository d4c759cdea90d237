//! Layout of rows of modules. In: rows, the outline of their area, heights of the surface below.
//! Out: modules as boxes, row by row.

use glam::{DVec2, DVec3};

use super::rows::RowsOfModules;
use crate::covering::surfaces::{SAME_PLANE_M, Surface};
use crate::plan::is_within;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::north::North;

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
    /// Plane of a flat surface: a point and the normal. Modules stand on it, not on what stands
    /// there.
    plane: Option<[DVec3; 2]>,
    /// The outline is that of a number of rows, which fill it: upright ones have no width in plan.
    is_filled: bool,
}

/// Step along a row after a place where a module does not fit, metres.
const STEP_M: f64 = 0.05;
/// Tolerance of computations, metres.
const ROUNDING_M: f64 = 1e-6;
/// Distance by which a module may stand out of its area, metres: corners of areas are often given
/// to the centimetre.
const OUTSIDE_M: f64 = 0.01;
/// Height by which a surface may rise above a module's rear and still only touch it, metres.
const TOUCHING_M: f64 = 1e-3;
/// Smallest upward part of the normal of a flat surface on which modules stand: steeper ones are
/// walls.
const MIN_UP: f64 = 0.05;
/// Change of height over [`SAMPLE_M`] that is a wall and no slope, metres.
const WALL_M: f64 = 0.3;

impl Outline {
    /// Returns the outline of a polygon.
    pub fn of_polygon(corners: &[DVec2]) -> Self {
        let next = corners.iter().cycle().skip(1);
        Outline { edges: corners.iter().zip(next).map(|(a, b)| [*a, *b]).collect(), plane: None, is_filled: false }
    }

    /// Returns the outline of a number of rows and of modules in each around a place in plan.
    pub fn of_rows(rows: &RowsOfModules, [count, modules]: [u32; 2], middle: DVec2, north: North) -> Self {
        let Facing { faces, along } = Facing::new(rows, north);
        let steps = |count: u32, step: f64, last: f64| f64::from(count - 1) * step + last + 2.0 * rows.setback_m;
        let right = along * 0.5 * steps(modules, rows.width_m + rows.gap_m, rows.width_m);
        let back = faces * 0.5 * steps(count, rows.pitch_m, rows.depth_m());
        let corners = [right + back, back - right, -right - back, right - back].map(|corner| middle + corner);
        Outline { is_filled: true, ..Outline::of_polygon(&corners) }
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
        let is_flat = |[point, normal]: &[DVec3; 2]| {
            let off = |p: &DVec3| (*p - *point).dot(*normal).abs();
            normal.z >= MIN_UP && surface.triangles.iter().flatten().all(|p| off(p) <= SAME_PLANE_M)
        };
        let plane = surface.triangles.first().map(|[point, ..]| [*point, surface.normal]);
        Outline { edges: once.collect(), plane: plane.filter(is_flat), is_filled: false }
    }

    /// Returns the height that modules stand on at a place in plan: that of a flat surface,
    /// whatever stands on it, or else of what is highest there.
    pub(super) fn stand(&self, p: DVec2, top: impl Fn(DVec2) -> Option<f64>) -> Option<f64> {
        match self.plane {
            Some([point, normal]) => Some(point.z - (p - point.truncate()).dot(normal.truncate()) / normal.z),
            None => top(p),
        }
    }

    /// Returns true if the area is that of a wall or a line: it has no width in plan.
    pub fn is_empty(&self) -> bool {
        let start = self.edges.first().map_or(DVec2::ZERO, |edge| edge[0]);
        let doubled: f64 = self.edges.iter().map(|[a, b]| (*a - start).perp_dot(*b - start)).sum();
        let length: f64 = self.edges.iter().map(|[a, b]| a.distance(*b)).sum();
        !self.is_filled && doubled.abs() <= OUTSIDE_M * length
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

    /// Returns true if a rectangle lies in the area, at least `setback_m` from all edges;
    /// [`OUTSIDE_M`] of it may stand out.
    fn holds(&self, shape: &[DVec2; 4], setback_m: f64) -> bool {
        let inner = inset(shape);
        let sides = || inner.iter().zip(inner.iter().cycle().skip(1)).map(|(p, q)| [*p, *q]);
        let is_clear = |edge: &[DVec2; 2]| {
            sides().all(|side| !cross(side, *edge) && between(side, *edge) >= setback_m - 2.0 * ROUNDING_M)
        };
        let is_within = || self.contains(inner.iter().sum::<DVec2>() / 4.0) && inner.iter().all(|p| self.contains(*p));
        self.is_filled || is_within() && self.edges.iter().all(is_clear)
    }

    /// Returns the least and the greatest product of the outline's corners with a direction.
    fn extent(&self, along: DVec2) -> [f64; 2] {
        let all = self.edges.iter().flatten().map(|p| p.dot(along));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
}

/// Returns a rectangle whose sides lie [`OUTSIDE_M`] further inside, or less in one that is narrow.
fn inset([a, b, c, d]: &[DVec2; 4]) -> [DVec2; 4] {
    let inwards = |side: DVec2| side.normalize_or_zero() * OUTSIDE_M.min(side.length() / 4.0);
    let (right, back) = (inwards(*b - *a), inwards(*d - *a));
    [*a + right + back, *b - right + back, *c - right - back, *d + right - back]
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

/// Directions of rows in plan, unit length.
struct Facing {
    faces: DVec2,
    along: DVec2,
}

impl Facing {
    /// Returns the directions in the scene's axes. Modules that lie flat face their azimuth, too.
    fn new(rows: &RowsOfModules, north: North) -> Self {
        let upright = Orientation { tilt_deg: 90.0, ..rows.turn };
        let faces = north.to_axes(upright.normal()).truncate().normalize_or(DVec2::NEG_Y);
        Facing { faces, along: DVec2::new(-faces.y, faces.x) }
    }
}

impl RowAxes {
    /// Returns the axes of rows in the scene's axes.
    pub fn new(rows: &RowsOfModules, north: North, outline: &Outline) -> Self {
        let Facing { faces, along } = Facing::new(rows, north);
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
    /// Number of rows with modules.
    pub rows: usize,
    /// Number of modules that fit, but have no surface below or an obstacle through them.
    pub left_out: usize,
}

/// Lays out rows. `top` gives the height of the highest surface at a place in plan.
pub fn lay(rows: &RowsOfModules, north: North, outline: &Outline, top: impl Fn(DVec2) -> Option<f64>) -> Laid {
    let axes = RowAxes::new(rows, north, outline);
    let RowAxes { faces, along, behind: [_, last], sides: [left, right] } = axes;
    let normal = north.to_axes(rows.turn.normal());
    let up = (-faces * normal.z).extend(normal.truncate().length());
    let depth = rows.depth_m();
    let mut laid = Laid::default();
    for row in 0_u32.. {
        let back = axes.first_edge(rows) + f64::from(row) * rows.pitch_m;
        if back + depth > last - rows.setback_m + OUTSIDE_M {
            break;
        }
        let (mut side, mut count) = (left + rows.setback_m, 0);
        while side + rows.width_m <= right - rows.setback_m + OUTSIDE_M {
            let lower = axes.at(side, back);
            let foot = [lower, lower + along * rows.width_m];
            let head = foot.map(|p| p - faces * depth);
            let plan = [foot[0], foot[1], head[1], head[0]];
            if !outline.holds(&plan, rows.setback_m) {
                side += STEP_M;
                continue;
            }
            side += rows.width_m + rows.gap_m;
            let module = |front| Module { name: String::new(), front, normal, thickness_m: rows.thickness_m };
            let raised = raised(&plan, up * rows.height_m, normal, rows, outline, &top).map(module);
            let Some(module) = raised.filter(|module| turns_freely(module, rows, north, &top)) else {
                laid.left_out += 1;
                continue;
            };
            // A row gets its number with its first module, so that empty rows leave no gap.
            laid.rows += usize::from(count == 0);
            count += 1;
            let name = format!("{}/{}/{count}", rows.name, laid.rows);
            laid.modules.push(Module { name, ..module });
        }
    }
    laid
}

/// Distance between the places of a module at which the surface below is compared with its rear,
/// metres: thinner obstacles may be missed.
const SAMPLE_M: f64 = 0.1;

/// Returns the front of a module over its plan, at least the clearance above what it stands on
/// below each corner of its rear. `None` without a surface below, with an obstacle that is higher
/// than the rear anywhere or nearer than the clearance below the middle, or half on a wall's top.
fn raised(
    plan: &[DVec2; 4],
    up: DVec3,
    normal: DVec3,
    rows: &RowsOfModules,
    outline: &Outline,
    top: &impl Fn(DVec2) -> Option<f64>,
) -> Option<[DVec3; 4]> {
    let [a, b, c, d] = *plan;
    // The surface may end a little before the module does.
    let within = (a + c) / 2.0;
    let top = |p: DVec2| top(p).or_else(|| top(p.move_towards(within, 2.0 * OUTSIDE_M)));
    let stand = |p: DVec2| outline.stand(p, top);
    let steps = |length_m: f64| (length_m / SAMPLE_M).ceil().max(1.0) as usize;
    let (mut height_m, mut walls_m) = (stand(a)?, 0.0);
    for [from, to] in [[a, b], [b, c], [c, d]] {
        let count = steps(from.distance(to));
        for i in 1..=count {
            let next_m = stand(from.lerp(to, i as f64 / count as f64))?;
            let rise_m = next_m - height_m;
            walls_m += if rise_m.abs() > WALL_M { rise_m } else { 0.0 };
            height_m = next_m;
        }
        if walls_m.abs() > WALL_M {
            return None;
        }
    }
    let rises = [0.0, 0.0, up.z, up.z];
    // The rear lies lower than the front.
    let down = normal.z * rows.thickness_m;
    let mut lowest = f64::NEG_INFINITY;
    for (p, rise) in plan.iter().zip(rises) {
        lowest = lowest.max(stand(*p)? + rows.clearance_m - rise + down);
    }
    let front = [a.extend(lowest), b.extend(lowest), c.extend(lowest + up.z), d.extend(lowest + up.z)];
    let middle = front.iter().sum::<DVec3>() / 4.0;
    if top(middle.truncate())? + rows.clearance_m > middle.z + ROUNDING_M {
        return None;
    }
    let (across, along) = (steps(a.distance(b)), steps(a.distance(d)));
    for i in 0..=across {
        for j in 0..=along {
            let (right, back) = (i as f64 / across as f64, j as f64 / along as f64);
            let rear_m = lowest + back * up.z - down;
            if top(a + (b - a) * right + (d - a) * back)? > rear_m + TOUCHING_M {
                return None;
            }
        }
    }
    Some(front)
}

/// Returns true if a level module reaches its largest angles without a corner below the surface.
fn turns_freely(module: &Module, rows: &RowsOfModules, north: North, top: &impl Fn(DVec2) -> Option<f64>) -> bool {
    let is_above = |p: DVec3| top(p.truncate()).is_none_or(|z| p.z >= z - TOUCHING_M);
    let Some(tracker) = rows.tracker else { return true };
    let ends = [-tracker.max_deg, tracker.max_deg].map(|angle_deg| tracker.turned(module, angle_deg, north));
    ends.iter().flat_map(Module::rear).all(is_above)
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

    /// Returns the middles of equal parts of one side, `across` of them along the row and `up` the
    /// slope, row by row from below, at distance `off_m` from it.
    pub fn points(&self, is_rear: bool, [across, up]: [usize; 2], off_m: f64) -> Vec<DVec3> {
        let [a, b, _, d] = if is_rear { self.rear() } else { self.front };
        let start = a + self.normal * if is_rear { -off_m } else { off_m };
        let share = |part: usize, count: usize| (part as f64 + 0.5) / count as f64;
        let point = |i: usize| start + (b - a) * share(i % across, across) + (d - a) * share(i / across, up);
        (0..across * up).map(point).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::points::places::Rating;
    use crate::pv::rows::RowsGround;

    /// Returns rows of modules of 1 m x 2 m, 3 m apart.
    pub fn rows(tilt_deg: f64, azimuth_deg: f64, setback_m: f64) -> RowsOfModules {
        RowsOfModules {
            name: "r".into(),
            ground: RowsGround::Area(Vec::new()),
            turn: Orientation { tilt_deg, azimuth_deg },
            tracker: None,
            pitch_m: 3.0,
            width_m: 1.0,
            height_m: 2.0,
            clearance_m: 0.5,
            setback_m,
            gap_m: 0.0,
            thickness_m: 0.03,
            reflectances: [0.05; 2],
            samples: 4,
            cells: None,
            ground_step_m: None,
            rating: Rating::default(),
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
            let laid = lay(&rows, North::default(), &outline, |_| Some(0.0));
            let of_rows = count / laid.rows;
            assert_eq!(
                (laid.modules.len(), of_rows, laid.left_out),
                (count, 10 - 2 * setback as usize, 0),
                "{setback}"
            );
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
        let laid = lay(&west, North::default(), &Outline::of_polygon(&square(10.0)), |_| Some(0.0));
        assert_eq!(laid.modules.len(), 40);
        assert!(laid.modules[0].front[0].x.abs() < 1e-9, "{:?}", laid.modules[0]);
        let l = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (5.0, 5.0), (5.0, 10.0), (0.0, 10.0)].map(DVec2::from);
        let south = rows(60.0, 180.0, 0.0);
        let laid = lay(&south, North::default(), &Outline::of_polygon(&l), |_| Some(0.0));
        // Rows at 0 and 3 m have 10 modules, rows at 6 and 9 m have 5.
        assert_eq!(laid.modules.len(), 30);
        assert!(laid.modules.iter().all(|m| m.front.iter().all(|p| p.x < 5.0 + 1e-6 || p.y < 5.0 + 1e-6)));
        let module = &laid.modules[0];
        let points = module.points(true, [1, 4], 0.005);
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
        let laid = lay(&rows, North::default(), &outline, |p| Some(plane(p)));
        assert_eq!(laid.modules.len(), 50);
        let gap = |p: DVec3| p.z - plane(p.truncate());
        // Heights are measured straight up from the roof.
        let off = laid.modules.iter().flat_map(|m| m.front).map(gap);
        let expected = 0.1 + 0.03 * 30.0_f64.to_radians().cos();
        assert!(off.into_iter().all(|off| (off - expected).abs() < 1e-9));
        // A chimney in the middle of a module, a pipe near its corner, one between two modules.
        for (x, y, radius, left_out) in [(4.5, 0.866, 0.3, 1), (4.25, 1.3, 0.15, 1), (5.0, 0.866, 0.15, 2)] {
            let pipe = |p: DVec2| Some(if p.distance(DVec2::new(x, y)) < radius { 9.0 } else { plane(p) });
            assert_eq!(lay(&rows, North::default(), &outline, pipe).left_out, left_out, "{x} {y}");
        }
    }

    /// A hut of 4 m x 4 m and 2.65 m stands on a flat roof of 20 m x 10 m. On the surface of the
    /// roof all modules stand at its height, none over the hut. On the same area others may stand
    /// wholly on the hut's top, none half on it.
    #[test]
    fn modules_do_not_climb_a_hut() {
        let hut = |p: DVec2| (12.0..=16.0).contains(&p.x) && (4.0..=8.0).contains(&p.y);
        let top = |p: DVec2| Some(if hut(p) { 10.65 } else { 8.0 });
        let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)].map(DVec2::from);
        let area = Outline::of_polygon(&corners);
        let surface = Outline { plane: Some([DVec3::new(3.0, 2.0, 8.0), DVec3::Z]), ..area.clone() };
        for pitch_m in [2.2, 2.7, 3.0] {
            let rows = RowsOfModules { pitch_m, ..rows(10.0, 180.0, 0.0) };
            let on_surface = lay(&rows, North::default(), &surface, top);
            let free = lay(&rows, North::default(), &surface, |_| Some(8.0)).modules.len();
            assert!(on_surface.left_out >= 4, "{pitch_m}: {}", on_surface.left_out);
            assert_eq!(on_surface.modules.len() + on_surface.left_out, free, "{pitch_m}");
            for module in &on_surface.modules {
                assert!(module.front.iter().all(|p| !hut(p.truncate())) && module.front[0].z < 9.0, "{module:?}");
            }
            for module in lay(&rows, North::default(), &area, top).modules {
                let on_hut = module.front.iter().filter(|p| hut(p.truncate())).count();
                let is_high = module.front[0].z > 10.0;
                assert!(if is_high { on_hut == 4 } else { on_hut == 0 }, "{pitch_m} {module:?}");
            }
        }
    }

    /// An area of 10 m x 13 m that faces 232.5 degrees holds 5 rows of 10 modules whether its
    /// corners are exact, or rounded to the millimetre or the centimetre; with corners 3 cm
    /// inwards it holds fewer.
    #[test]
    fn rounded_corners_lose_no_row() {
        let mut west = rows(60.0, 232.5, 0.0);
        for (setback, grown) in [(0.0, 0.0), (0.5, 0.5)] {
            west.setback_m = setback;
            let faces = west.turn.normal().truncate().normalize();
            let along = DVec2::new(-faces.y, faces.x);
            let corner = |side: f64, back: f64| along * side - faces * back + DVec2::new(78_725.7, 457_942.2);
            let (low, wide, deep) = (-grown, 10.0 + grown, 13.0 + grown);
            let exact = [corner(low, low), corner(wide, low), corner(wide, deep), corner(low, deep)];
            for digits in [1e9, 1e3, 1e2] {
                let corners = exact.map(|p| (p * digits).round() / digits);
                let laid = lay(&west, North::default(), &Outline::of_polygon(&corners), |_| Some(0.0));
                assert_eq!((laid.modules.len(), laid.rows, laid.left_out), (50, 5, 0), "{setback} {digits}");
            }
        }
        let south = rows(60.0, 180.0, 0.0);
        let narrow = [(0.0, 0.0), (9.97, 0.0), (9.97, 10.0), (0.0, 10.0)].map(DVec2::from);
        let laid = lay(&south, North::default(), &Outline::of_polygon(&narrow), |_| Some(0.0));
        assert_eq!(laid.modules.len(), 36);
    }

    /// Rows of a stated number have all their modules at any tilt and azimuth, in the stated place:
    /// upright ones, too, which have no width in plan.
    #[test]
    fn counted_rows_have_all_their_modules() {
        for tilt_deg in [0.0, 35.0, 89.9, 90.0] {
            for azimuth_deg in [0.0, 90.0, 180.0, 211.7, 300.0] {
                let (rows, middle) = (rows(tilt_deg, azimuth_deg, 0.0), DVec2::new(78_725.7, 457_942.2));
                let outline = Outline::of_rows(&rows, [5, 10], middle, North::default());
                let laid = lay(&rows, North::default(), &outline, |_| Some(0.0));
                assert_eq!((laid.modules.len(), laid.rows, laid.left_out), (50, 5, 0), "{tilt_deg} {azimuth_deg}");
                let mean = laid.modules.iter().map(Module::middle).sum::<DVec3>() / 50.0;
                assert!(mean.truncate().distance(middle) < 0.02, "{tilt_deg} {azimuth_deg}: {mean}");
            }
        }
    }

    /// Flat modules of 1 m x 2 m that face east, in rows 5 m apart, fill 20 m x 40 m with 4 rows of
    /// 40; facing south they fill it with 8 rows of 20.
    #[test]
    fn flat_rows_keep_their_azimuth() {
        let area = [(-10.0, -20.0), (10.0, -20.0), (10.0, 20.0), (-10.0, 20.0)].map(DVec2::from);
        for (azimuth_deg, in_rows, modules) in [(90.0, 4, 160), (180.0, 8, 160), (270.0, 4, 160)] {
            let flat = RowsOfModules { pitch_m: 5.0, ..rows(0.0, azimuth_deg, 0.0) };
            let laid = lay(&flat, North::default(), &Outline::of_polygon(&area), |_| Some(0.0));
            assert_eq!((laid.rows, laid.modules.len()), (in_rows, modules), "{azimuth_deg}");
            let [a, b, c, _] = laid.modules[0].front;
            assert!((b - a).cross(c - b).normalize().distance(DVec3::Z) < 1e-9, "{azimuth_deg}");
        }
    }
}
