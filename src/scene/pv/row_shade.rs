//! Shade of the sun's beam among trackers at any angle, by closed form. In: level modules, an
//! angle, the sun. Out: the share of each module that other rows shade.
//!
//! All modules have one angle, so the shadow of one on the plane of another is a copy of it, only
//! shifted along the rays. The share is that of a line up the slope in the middle of the module.

use glam::DVec3;

use super::layout::Module;
use super::tracker::Tracker;
use heliotile_core::site::north::North;

/// Modules of trackers, row by row.
#[derive(Clone, Debug)]
pub struct RowShade {
    tracker: Tracker,
    north: North,
    /// Direction of the axes, and the direction across them in plan, unit vectors.
    axes: [DVec3; 2],
    /// Middle and half of the height of each module, in the order given.
    places: Vec<(DVec3, f64)>,
    /// Rows in ascending order across the axes.
    rows: Vec<Row>,
    /// Greatest height of a hub, metres.
    highest_m: f64,
    /// Greatest half of a module's height, metres.
    reach_m: f64,
}

#[derive(Clone, Debug)]
struct Row {
    /// Distance across the axes, metres.
    across_m: f64,
    /// Modules in ascending order along the axis.
    modules: Vec<Turning>,
}

/// Module on its axis.
#[derive(Clone, Debug)]
struct Turning {
    /// Distance along the axis, metres.
    along_m: f64,
    middle: DVec3,
    /// Halves of the width along the axis and of the height across it, metres.
    half_m: [f64; 2],
}

/// Rows whose distance across the axes differs by less than this are one row, metres.
const SAME_ROW_M: f64 = 0.01;

impl RowShade {
    /// Prepares the level modules of trackers that all have one angle.
    pub fn new<'m>(tracker: Tracker, north: North, modules: impl Iterator<Item = &'m Module>) -> Self {
        let axes = tracker.axes(0.0, north);
        let turning = |module: &Module| {
            let [a, b, _, d] = module.front;
            let middle = module.middle();
            Turning { along_m: middle.dot(axes[0]), middle, half_m: [a.distance(b) / 2.0, a.distance(d) / 2.0] }
        };
        let mut all: Vec<Turning> = modules.map(turning).collect();
        let places = all.iter().map(|module| (module.middle, module.half_m[1])).collect();
        all.sort_by(|a, b| a.middle.dot(axes[1]).total_cmp(&b.middle.dot(axes[1])));
        let mut rows: Vec<Row> = Vec::new();
        for module in all {
            let across_m = module.middle.dot(axes[1]);
            match rows.last_mut().filter(|row| across_m - row.across_m < SAME_ROW_M) {
                Some(row) => row.modules.push(module),
                None => rows.push(Row { across_m, modules: vec![module] }),
            }
        }
        for row in &mut rows {
            row.modules.sort_by(|a, b| a.along_m.total_cmp(&b.along_m));
        }
        let greatest = |of: fn(&Turning) -> f64| {
            rows.iter().flat_map(|row| &row.modules).map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        let (highest_m, reach_m) = (greatest(|module| module.middle.z), greatest(|module| module.half_m[1]));
        RowShade { tracker, north, axes, places, rows, highest_m, reach_m }
    }

    /// Returns the unit normal of fronts at an angle, by true east, true north and up.
    pub fn normal(&self, angle_deg: f64) -> DVec3 {
        self.tracker.turn(angle_deg).normal()
    }

    /// Returns the share of a module, by its number, that is not in the shade of other rows, 0 to
    /// 1; `sun` is a unit vector by true east, true north and up.
    pub fn lit(&self, module: usize, angle_deg: f64, sun: DVec3) -> f64 {
        let Some(&(middle, half_height_m)) = self.places.get(module) else { return 1.0 };
        let sun = self.north.to_axes(sun);
        let [axis, across] = self.axes;
        let [_, up] = self.tracker.axes(angle_deg, self.north);
        let normal = axis.cross(up);
        let (towards, side, rise) = (sun.dot(normal), sun.dot(across), sun.z);
        if towards.abs() < 1e-9 || side.abs() < 1e-9 {
            return 1.0;
        }
        let here = middle.dot(across);
        let first = self.rows.partition_point(|row| row.across_m < here - SAME_ROW_M);
        let beyond = self.rows.partition_point(|row| row.across_m <= here + SAME_ROW_M);
        // Only rows on the side of the sun, the next one first.
        let count = if side > 0.0 { self.rows.len() - beyond } else { first };
        let number = |i: usize| if side > 0.0 { beyond + i } else { first - 1 - i };
        let mut shaded: Vec<[f64; 2]> = Vec::new();
        for row in (0..count).filter_map(|i| self.rows.get(number(i))) {
            // Where the lowest ray is above all modules, no further row is met.
            let nearest_m = (row.across_m - here).abs() - self.reach_m - half_height_m;
            if nearest_m > 0.0
                && middle.z - half_height_m + nearest_m / side.abs() * rise > self.highest_m + self.reach_m
            {
                break;
            }
            for module in row.near(middle, sun, normal, towards, axis) {
                let distance_m = (module.middle - middle).dot(normal) / towards;
                let off = middle + sun * distance_m - module.middle;
                let [half_width, half_height] = module.half_m;
                if distance_m > 1e-9 && off.dot(axis).abs() <= half_width {
                    let shift = off.dot(up);
                    let of = |end: f64| (end * half_height - shift).clamp(-half_height_m, half_height_m);
                    shaded.push([of(-1.0), of(1.0)]);
                }
            }
        }
        1.0 - covered(&mut shaded) / (2.0 * half_height_m)
    }
}

impl Row {
    /// Returns the modules that rays through `middle` may meet.
    fn near(&self, middle: DVec3, sun: DVec3, normal: DVec3, towards: f64, axis: DVec3) -> &[Turning] {
        // Hubs of a row may differ in height, which moves the point by little along the axis.
        let along = |module: &Turning| {
            let distance_m = (module.middle - middle).dot(normal) / towards;
            (middle + sun * distance_m).dot(axis)
        };
        let places = [self.modules.first(), self.modules.last()].map(|module| module.map_or(0.0, along));
        let [low, high] = [places[0].min(places[1]), places[0].max(places[1])];
        let from = self.modules.partition_point(|module| module.along_m + module.half_m[0] < low);
        let to = self.modules.partition_point(|module| module.along_m - module.half_m[0] <= high);
        self.modules.get(from..to).unwrap_or_default()
    }
}

/// Returns the length that intervals cover together.
fn covered(intervals: &mut [[f64; 2]]) -> f64 {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut sum, mut end) = (0.0, f64::NEG_INFINITY);
    for &[from, to] in intervals.iter() {
        sum += (to - from.max(end)).max(0.0);
        end = end.max(to);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pv::layout::{Outline, lay, tests::rows};
    use crate::pv::rows::RowsOfModules;
    use glam::DVec2;
    use heliotile_core::site::place::Place;
    use heliotile_core::units::direction_from_degrees;

    /// Returns level modules of 1 m x 2 m, 5 m apart, on ground that rises `slope` to the east, and
    /// their rows.
    fn field(axis_deg: f64, slope: f64, north: North) -> (RowsOfModules, Vec<Module>) {
        let tracker = Tracker { axis_deg, hub_m: 1.5, max_deg: 60.0, backtracks: true, step_deg: 10.0 };
        let of = RowsOfModules {
            turn: tracker.turn(0.0),
            tracker: Some(tracker),
            pitch_m: 5.0,
            clearance_m: 1.47,
            ..rows(0.0, axis_deg + 90.0, 0.0)
        };
        let outline = Outline::of_rows(&of, [9, 40], DVec2::ZERO, north);
        let laid = lay(&of, north, &outline, |p| Some(slope * p.x));
        assert_eq!(laid.modules.len(), 9 * 40);
        (of, laid.modules)
    }

    /// Returns the lit share of a module by 4,000 rays at turned rectangles; the sun is in their
    /// axes.
    fn by_rays(all: &[Module], module: usize, sun: DVec3) -> f64 {
        let [a, b, c, d] = all[module].front;
        let (foot, head) = ((a + b) / 2.0, (c + d) / 2.0);
        let meets = |p: DVec3, other: &Module| {
            let [a, b, _, d] = other.front;
            let distance = (a - p).dot(other.normal) / sun.dot(other.normal);
            let from = p + sun * distance - a;
            let within = |side: DVec3| (0.0..=side.length_squared()).contains(&from.dot(side));
            distance > 1e-6 && within(b - a) && within(d - a)
        };
        let is_lit = |i: &i32| {
            let p = foot.lerp(head, (f64::from(*i) + 0.5) / 4000.0);
            !all.iter().any(|other| meets(p, other))
        };
        (0..4000).filter(is_lit).count() as f64 / 4000.0
    }

    /// At 20 pairs of sun and angle, level, about turned axes and on a slope of 10 %, the lit share
    /// of a module in the middle and of one at a corner of the field is that of rays to 0.001.
    #[test]
    fn shade_is_that_of_rays() {
        let turned_by = |convergence_deg| {
            North::new(Some(&Place { latitude_deg: 50.0, longitude_deg: 9.0, convergence_deg, epsg: None }))
        };
        for (axis_deg, slope, north_deg) in
            [(180.0, 0.0, 0.0), (155.0, 0.0, 0.0), (180.0, 0.1, 0.0), (170.0, 0.0, 25.0)]
        {
            let north = turned_by(north_deg);
            let (of, modules) = field(axis_deg, slope, north);
            let tracker = of.tracker.expect("tracker");
            let shade = RowShade::new(tracker, north, modules.iter());
            let mut partial = 0;
            for (azimuth, altitude) in [(95.0, 4.0), (110.0, 15.0), (160.0, 8.0), (250.0, 12.0), (265.0, 25.0)] {
                let sun = direction_from_degrees(azimuth, altitude);
                for angle_deg in [-60.0, -35.0, 20.0, 50.0] {
                    let all: Vec<Module> =
                        modules.iter().map(|module| tracker.turned(module, angle_deg, north)).collect();
                    for module in [0, 4 * 40 + 20] {
                        let found = shade.lit(module, angle_deg, sun);
                        let expected = by_rays(&all, module, north.to_axes(sun));
                        assert!(
                            (found - expected).abs() < 1e-3,
                            "{azimuth} {altitude} {angle_deg}: {found} {expected}"
                        );
                        partial += usize::from(expected > 0.01 && expected < 0.99);
                    }
                }
            }
            assert!(partial >= 5, "{partial}");
        }
    }

    /// Rows that turn back are not shaded by their neighbours at four suns, and without it the lit
    /// share is the cosine of the angle times pitch over height.
    #[test]
    fn turning_back_leaves_no_shade() {
        let (of, modules) = field(180.0, 0.0, North::default());
        let tracker = of.tracker.expect("tracker");
        let shade = RowShade::new(tracker, North::default(), modules.iter());
        let middle = 4 * 40 + 20;
        let ahead = Tracker { backtracks: false, max_deg: 89.0, ..tracker };
        for altitude in [3.0, 8.0, 15.0, 40.0] {
            let sun = direction_from_degrees(90.0, altitude);
            assert!(shade.lit(middle, tracker.angle_deg(sun, of.cover()), sun) > 1.0 - 1e-6, "{altitude}");
            let angle_deg = ahead.angle_deg(sun, of.cover());
            let expected = (angle_deg.to_radians().cos() / of.cover()).min(1.0);
            let found = shade.lit(middle, angle_deg, sun);
            assert!((found - expected).abs() < 1e-6, "{altitude}: {found} {expected}");
        }
    }
}
