//! Minutes of a day with the planes of their rays. In: the sun of a day, the spells in which it
//! counts. Out: steps of a minute, and the steps whose rays from a place pass near a node.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::grid::Grid;
use heliotile_builder::siting::SunRays;
use heliotile_sunlight::{Spells, SunDay};

/// Number of sectors of the horizon by which steps are found.
const SECTORS: usize = 360;

/// Least share of a plane's normal that points up. The sun of a minute that rises more steeply has
/// no plane that is a height over the ground; its rays get a plane that is level across them.
const STEEP: f64 = 0.05;

/// Distance that a building keeps from the planes, metres: ten times the error of f32 rays and of
/// the chord of a minute at 100 m.
const KEPT_CLEAR_M: f64 = 0.01;

/// Sun of a minute, seen from any place.
struct Step {
    /// Unit vector to the sun at the middle of the minute.
    middle: DVec3,
    /// Horizontal unit vectors to the sun at the start and at the end, the second counterclockwise
    /// of the first.
    edges: [DVec2; 2],
    /// Slope of the plane of the rays: metres up by metres along x and y.
    slope: DVec2,
}

/// Steps of a day.
#[derive(Default)]
pub struct DaySteps {
    steps: Vec<Step>,
    /// `[step]`: minute of the day at which it starts.
    starts_min: Vec<f64>,
    /// `[sector of the horizon]`: numbers of steps whose right edge lies there.
    by_sector: Vec<Vec<u16>>,
    /// Largest number of sectors that a step reaches beyond that of its right edge.
    widest: usize,
}

impl DaySteps {
    /// Returns the minutes of a day that some spells touch.
    pub fn new(day: &SunDay, counts: &Spells) -> Self {
        let mut all = DaySteps { by_sector: vec![Vec::new(); SECTORS], ..DaySteps::default() };
        let mut next = 0;
        for spell in counts.iter() {
            let touched = (spell.start_min.floor() as usize).max(next)..spell.end_min.ceil() as usize;
            next = touched.end;
            for start in touched {
                let Some(step) = Step::new([0.0, 1.0].map(|later| day.sun(start as f64 + later))) else { continue };
                let [right, left] = step.edges.map(|edge| sector_of(edge.to_angle()));
                all.widest = all.widest.max((left + SECTORS - right) % SECTORS);
                all.by_sector[right].push(all.steps.len() as u16);
                all.steps.push(step);
                all.starts_min.push(start as f64);
            }
        }
        all
    }

    /// Returns the minutes of each step that lie within spells.
    pub fn within(&self, spells: &Spells) -> Vec<f64> {
        let minutes = |start: &f64| spells.within(&Spells::one(*start, start + 1.0)).minutes();
        self.starts_min.iter().map(minutes).collect()
    }

    /// Returns the minutes of each step that are left where `rays` meet nothing in its middle.
    pub fn left(&self, minutes: &[f64], rays: &SunRays) -> Vec<f64> {
        let lit: Vec<usize> = (0..minutes.len()).filter(|step| minutes[*step] > 0.0).collect();
        let suns: Vec<DVec3> = lit.iter().map(|step| self.steps[*step].middle).collect();
        let mut left = vec![0.0; minutes.len()];
        for (step, is_seen) in lit.into_iter().zip(rays.sees(&suns)) {
            left[step] = if is_seen { minutes[step] } else { 0.0 };
        }
        left
    }

    /// Hands on each chosen step whose rays from `place` pass over a square of a node, once for
    /// each such node, with the height to which the rays let a building rise there.
    ///
    /// A square that a ray passes over has each of its nodes below the plane of the ray's minute,
    /// so all of its surface is.
    pub fn limits(
        &self,
        place: DVec3,
        grid: &Grid,
        is_chosen: impl Fn(usize) -> bool,
        mut each: impl FnMut(usize, usize, f64),
    ) {
        let reach_m = grid.diagonal_m;
        for (number, node) in grid.nodes.iter().enumerate() {
            let to = node.at - place.truncate();
            let distance_m = to.length();
            let (first, count) = if distance_m > 2.0 * reach_m {
                // The tangent is larger than the arc, and needs no trigonometry.
                let half = reach_m / (distance_m * distance_m - reach_m * reach_m).sqrt();
                let first = sector_of(to.to_angle() - half) + SECTORS - self.widest;
                let count = (2.0 * half / TAU * SECTORS as f64).ceil() as usize + 1 + self.widest;
                (first, count.min(SECTORS))
            } else {
                (0, SECTORS)
            };
            for sector in 0..count {
                for step in &self.by_sector[(first + sector) % SECTORS] {
                    let index = usize::from(*step);
                    if is_chosen(index) && self.steps[index].passes(to, reach_m) {
                        each(index, number, place.z + self.steps[index].slope.dot(to) - KEPT_CLEAR_M);
                    }
                }
            }
        }
    }
}

impl Step {
    /// Returns the step between two suns; `None` if one of them stands in the zenith.
    fn new(suns: [DVec3; 2]) -> Option<Self> {
        let [start, end] = suns.map(|sun| sun.truncate().try_normalize());
        let mut edges = [start?, end?];
        if edges[0].perp_dot(edges[1]) < 0.0 {
            edges.swap(0, 1);
        }
        let normal = suns[0].cross(suns[1]);
        let slope = if normal.z.abs() > STEEP * normal.length() {
            -normal.truncate() / normal.z
        } else {
            let tangent = |sun: DVec3| sun.z / sun.truncate().length();
            (edges[0] + edges[1]).normalize_or_zero() * suns.map(tangent).into_iter().fold(f64::INFINITY, f64::min)
        };
        Some(Step { middle: (suns[0] + suns[1]).normalize_or_zero(), edges, slope })
    }

    /// Returns true if rays pass within `reach_m` of a place, relative to where they start.
    fn passes(&self, to: DVec2, reach_m: f64) -> bool {
        let [right, left] = self.edges;
        right.perp_dot(to) >= -reach_m && to.perp_dot(left) >= -reach_m && (right + left).dot(to) >= -2.0 * reach_m
    }
}

/// Returns the sector of an angle, radians.
fn sector_of(angle: f64) -> usize {
    ((angle.rem_euclid(TAU) / TAU * SECTORS as f64) as usize).min(SECTORS - 1)
}
