//! Places on the ground among rows of modules: a grid in plan that is aligned with the rows. In:
//! rows, the outline of their area, modules, heights of the surface below. Out: the free places,
//! each with its distance behind the lower edge of a row.

use glam::{DVec2, DVec3};

use super::layout::{Module, Outline, RowAxes};
use super::rows::RowsOfModules;
use crate::covering::surfaces::SAME_PLANE_M;
use heliotile_core::site::north::North;

/// A place of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundPlace {
    /// Name `field/ground/2/5`: rows, line across them counted against the direction that fronts
    /// face, place in the line from the left as seen from there.
    pub name: String,
    /// Position in input coordinates, metres, at the given distance above the surface below.
    pub position: DVec3,
    /// Distance behind the lower edge of a row, in plan, from 0 to the pitch, metres.
    pub behind_m: f64,
}

/// Free places of a grid, and counts of places left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroundPlaces {
    /// Free places, line by line.
    pub list: Vec<GroundPlace>,
    /// Number of places in the area without a surface below.
    pub without_ground: usize,
    /// Number of places inside modules.
    pub in_modules: usize,
}

/// Grid of places among rows.
#[derive(Clone, Debug)]
pub struct GroundGrid<'a> {
    rows: &'a RowsOfModules,
    outline: &'a Outline,
    axes: RowAxes,
    /// Distances behind the first row's lower edge; a pitch holds a whole number of places.
    across: PlaceLine,
    /// Distances along the rows.
    along: PlaceLine,
}

/// Places at equal distances.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlaceLine {
    first: f64,
    step: f64,
    count: f64,
}

/// Tolerance of rounding, in steps.
const ROUNDING: f64 = 1e-6;

/// Returns the step nearest to the wanted one of which a length holds a whole number.
fn even_step(length: f64, wanted: f64) -> f64 {
    length / (length / wanted).round().max(1.0)
}

impl PlaceLine {
    /// Returns the middles of steps, which are counted from an origin, between two ends.
    fn new(origin: f64, step: f64, ends: [f64; 2]) -> Self {
        let [low, high] = ends.map(|end| (end - origin) / step - 0.5);
        let (low, high) = ((low - ROUNDING).ceil(), (high + ROUNDING).floor());
        PlaceLine { first: origin + (low + 0.5) * step, step, count: (high - low + 1.0).max(0.0) }
    }

    fn at(&self, place: usize) -> f64 {
        self.first + place as f64 * self.step
    }

    /// Returns the places from one distance to another.
    fn within(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let place = |distance: f64| ((distance - self.first) / self.step).clamp(0.0, self.count);
        place(from).floor() as usize..(place(to).floor() + 1.0).min(self.count) as usize
    }
}

impl<'a> GroundGrid<'a> {
    /// Returns the grid of rows; `step_m` is the
    /// approximate distance of its places. Across the rows a pitch holds a whole number of places,
    /// so that all pitches are alike; along the rows the area does.
    pub fn new(rows: &'a RowsOfModules, step_m: f64, north: North, outline: &'a Outline) -> Self {
        let axes = RowAxes::new(rows, north, outline);
        let [left, right] = axes.sides;
        let across = PlaceLine::new(axes.first_edge(rows), even_step(rows.pitch_m, step_m), axes.behind);
        let along = PlaceLine::new(left, even_step(right - left, step_m), axes.sides);
        GroundGrid { rows, outline, axes, across, along }
    }

    /// Returns the number of places of the grid, including those outside of the area.
    pub fn size(&self) -> f64 {
        self.across.count * self.along.count
    }

    /// Returns the free places in the area; `top` gives the height of the highest surface at a
    /// place in plan, `off_m` is the distance of places from what rows stand on. Places on objects
    /// that stand on a flat surface are left out.
    pub fn places<'m>(
        &self,
        off_m: f64,
        top: impl Fn(DVec2) -> Option<f64>,
        modules: impl Iterator<Item = &'m Module>,
    ) -> GroundPlaces {
        let below = |p: DVec2| {
            let (stand_m, top_m) = (self.outline.stand(p, &top)?, top(p)?);
            (top_m <= stand_m + SAME_PLANE_M).then_some(stand_m)
        };
        let (lines, in_line) = (self.across.count as usize, self.along.count as usize);
        let mut found = GroundPlaces::default();
        let mut positions: Vec<Option<DVec3>> = Vec::with_capacity(lines * in_line);
        for line in 0..lines {
            for place in 0..in_line {
                let plan = self.axes.at(self.along.at(place), self.across.at(line));
                let is_inside = self.outline.contains(plan);
                let position = is_inside.then(|| below(plan)).flatten().map(|z| plan.extend(z + off_m));
                found.without_ground += usize::from(is_inside && position.is_none());
                positions.push(position);
            }
        }
        // Only places within the box of a module in plan are tested.
        for module in modules {
            let corners = || module.front.into_iter().chain(module.rear()).map(DVec3::truncate);
            let [behind, side] = [-self.axes.faces, self.axes.along].map(|axis| {
                let all = corners().map(|corner| corner.dot(axis));
                all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
            });
            for line in self.across.within(behind[0], behind[1]) {
                for place in self.along.within(side[0], side[1]) {
                    let Some(position) = positions.get_mut(line * in_line + place) else { continue };
                    if position.is_some_and(|position| module.holds(position)) {
                        *position = None;
                        found.in_modules += 1;
                    }
                }
            }
        }
        let first_edge = self.axes.first_edge(self.rows);
        let numbers = (0..lines).flat_map(|line| (0..in_line).map(move |place| (line, place)));
        let free = numbers.zip(positions).filter_map(|((line, place), position)| {
            let name = format!("{}/ground/{}/{}", self.rows.name, line + 1, place + 1);
            let behind_m = (self.across.at(line) - first_edge).rem_euclid(self.rows.pitch_m);
            Some(GroundPlace { name, position: position?, behind_m })
        });
        found.list = free.collect();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pv::layout::{self, lay};

    const STEP_M: f64 = 0.7;
    const OFF_M: f64 = 0.005;

    fn rows(tilt_deg: f64, azimuth_deg: f64, clearance_m: f64) -> RowsOfModules {
        RowsOfModules { clearance_m, ground_step_m: Some(STEP_M), ..layout::tests::rows(tilt_deg, azimuth_deg, 0.5) }
    }

    /// Returns the places among rows on a polygon, over ground of a height.
    fn among(rows: &RowsOfModules, corners: &[(f64, f64)], below: impl Fn(DVec2) -> Option<f64>) -> GroundPlaces {
        let corners: Vec<DVec2> = corners.iter().copied().map(DVec2::from).collect();
        let outline = Outline::of_polygon(&corners);
        let laid = lay(rows, North::default(), &outline, &below);
        assert!(!laid.modules.is_empty());
        GroundGrid::new(rows, STEP_M, North::default(), &outline).places(OFF_M, below, laid.modules.iter())
    }

    const SQUARE: [(f64, f64); 4] = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];

    /// At a wanted step of 0.7 m, a pitch of 3 m holds 4 places and 10 m along the rows hold 14. An
    /// area of 10 x 10 m has 14 lines of 14 places, 5 mm above the ground; the first line is 0.125
    /// m from the edge, 2.625 m behind a row before the first one. Places 4 lines apart lie equally
    /// far behind their rows.
    #[test]
    fn a_pitch_holds_a_whole_number_of_places() {
        let found = among(&rows(60.0, 180.0, 0.5), &SQUARE, |p| Some(0.1 * p.y));
        assert_eq!((found.list.len(), found.without_ground, found.in_modules), (14 * 14, 0, 0));
        let first = &found.list[0];
        assert_eq!(first.name, "r/ground/1/1");
        let expected = DVec3::new(5.0 / 14.0, 0.125, 0.0125 + OFF_M);
        assert!(first.position.distance(expected) < 1e-9 && (first.behind_m - 2.625).abs() < 1e-9, "{first:?}");
        for (place, next) in found.list.iter().zip(found.list.iter().skip(4 * 14)) {
            assert!((place.behind_m - next.behind_m).abs() < 1e-9, "{place:?} {next:?}");
            assert!((next.position.y - place.position.y - 3.0).abs() < 1e-9, "{place:?} {next:?}");
        }
    }

    /// With rows turned to 240 degrees, lines follow the rows: the places of a line lie equally far
    /// behind an edge. An L-shaped area has no places in its notch. Places without ground below and
    /// free places are all places of the area.
    #[test]
    fn lines_of_places_follow_turned_rows() {
        let l = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (5.0, 5.0), (5.0, 10.0), (0.0, 10.0)];
        let rows = rows(20.0, 240.0, 0.5);
        let all = among(&rows, &l, |_| Some(0.0));
        assert!(all.list.iter().all(|place| place.position.x < 5.0 || place.position.y < 5.0));
        let faces = rows.turn.normal().truncate().normalize();
        let line = |place: &GroundPlace| place.name.split('/').nth(2).and_then(|line| line.parse::<usize>().ok());
        for pair in all.list.windows(2).filter(|pair| line(&pair[0]) == line(&pair[1])) {
            let [a, b] = [&pair[0], &pair[1]].map(|place| place.position.truncate());
            assert!((a - b).dot(faces).abs() < 1e-9, "{pair:?}");
        }
        let some = among(&rows, &l, |p| (p.x + p.y < 9.0).then_some(0.0));
        assert!(some.without_ground > 0);
        assert_eq!(some.list.len() + some.without_ground, all.list.len());
    }

    /// Modules of 3 cm that lie on the ground hold 108 of 196 places, 3 of the 4 lines of each row,
    /// and no free place is left there; modules 0.2 m above the ground hold none.
    #[test]
    fn places_inside_of_modules_are_left_out() {
        let lying = among(&rows(0.0, 180.0, 0.0), &SQUARE, |_| Some(0.0));
        assert_eq!((lying.list.len(), lying.in_modules), (88, 108));
        // Rows begin 0.5 m from the edges, and the last one ends at 8.5 m.
        let is_covered = |place: &GroundPlace| {
            let p = place.position;
            place.behind_m < 2.0 && (0.5..8.5).contains(&p.y) && (0.5..9.5).contains(&p.x)
        };
        assert!(!lying.list.iter().any(is_covered), "{:?}", lying.list);
        assert_eq!(among(&rows(0.0, 180.0, 0.2), &SQUARE, |_| Some(0.0)).in_modules, 0);
    }
}
