//! Choice of the minutes that places keep. In: the minutes in which each place sees the sun, and
//! how many it needs. Out: the height to which each node of the plot may be built.
//!
//! Places with the least freedom choose first. Each takes the minutes that cut least off what the
//! places before it left. Later rounds choose again among minutes that the envelope so far leaves
//! free, so that it can only grow.

use std::cmp::Ordering;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::day_steps::DaySteps;
use super::grid::Grid;
use super::solid::Solid;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::siting::Siting;
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;
use heliotile_core::site::material::{Class, Material};
use heliotile_scene::Scene;

/// Largest number of rounds.
const MAX_ROUNDS: usize = 6;

/// Number of needs that choose at once, without regard for each other.
const NEEDS_AT_ONCE: usize = 8;

/// Number of rounds in which needs ask for less.
const MAX_TRIMS: usize = 8;

/// Share of what a need has beyond its minutes by which it asks for less in the next round.
const TRIMMED: f64 = 0.7;

/// Work that was going on when the search is stopped.
const STOPPED: &str = "before the envelope was found";

/// Largest distance of minutes that count as equal.
const CLOSE_MIN: f64 = 1e-6;

/// Growth of the volume at which rounds end.
const LEAST_GROWTH: f64 = 1e-3;

/// Minutes that a place keeps beyond those asked for: rays and textures round the ends of spells.
const SPARE_MIN: f64 = 0.5;

/// Need of one place: on a day, or on the days that count together.
pub struct Need {
    /// Place that needs sun.
    pub place: DVec3,
    /// Days of the need, and the sun that the place sees on them.
    pub days: Vec<LitDay>,
    /// Number of minutes to keep.
    pub minutes: f64,
    /// Way in which they are chosen.
    pub choice: Choice,
}

/// Sun that a place sees on a day.
pub struct LitDay {
    /// Number of the day.
    pub day: usize,
    /// `[step]`: minutes of sun.
    pub minutes: Vec<f64>,
}

/// Way to choose minutes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Any minutes of the days.
    Any,
    /// Minutes of one spell.
    OneSpell,
}

/// Costs of a need, `[day][step]`, m3.
type Costs = Vec<Vec<f64>>;

/// Steps that a need keeps, `[day][step]`, and what they cost.
struct Kept {
    steps: Vec<Vec<bool>>,
    cost: f64,
}

impl LitDay {
    /// Returns the minutes of sun that count.
    pub fn minutes(&self, choice: Choice) -> f64 {
        match choice {
            Choice::Any => self.minutes.iter().sum(),
            Choice::OneSpell => self.runs().map(|run| self.minutes[run].iter().sum()).fold(0.0, f64::max),
        }
    }

    /// Iterates over the steps with sun that follow each other.
    fn runs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let mut start = 0;
        self.minutes.split(|minutes| *minutes <= 0.0).filter_map(move |run| {
            let steps = start..start + run.len();
            start = steps.end + 1;
            (!steps.is_empty()).then_some(steps)
        })
    }
}

impl Need {
    /// Returns what each step with sun cuts off the tops of nodes.
    fn costs(&self, days: &[DaySteps], grid: &Grid, tops_m: &[f64]) -> Costs {
        let of_day = |lit: &LitDay| {
            let mut costs = vec![0.0; lit.minutes.len()];
            let is_lit = |step: usize| lit.minutes[step] > 0.0;
            days[lit.day].limits(self.place, grid, is_lit, |step, node, height_m| {
                costs[step] += (tops_m[node] - height_m).max(0.0) * grid.nodes[node].area_m2;
            });
            costs
        };
        self.days.iter().map(of_day).collect()
    }

    /// Returns what the need cuts off the tops of nodes at least, m3.
    pub fn cost_m3(&self, days: &[DaySteps], grid: &Grid, tops_m: &[f64]) -> f64 {
        let costs = self.costs(days, grid, tops_m);
        if costs.iter().flatten().all(|cost| *cost == 0.0) {
            0.0
        } else {
            self.cheapest([&costs, &costs], self.minutes + SPARE_MIN).cost
        }
    }

    /// Lowers the tops of nodes below the rays of some steps of a day.
    fn lower(&self, is_kept: impl Fn(usize) -> bool, day: &DaySteps, grid: &Grid, tops_m: &mut [f64]) {
        day.limits(self.place, grid, is_kept, |_, node, height_m| tops_m[node] = tops_m[node].min(height_m));
    }

    /// Returns the minutes of sun that count.
    fn has(&self) -> f64 {
        let minutes = self.days.iter().map(|day| day.minutes(self.choice));
        if self.choice == Choice::Any { minutes.sum() } else { minutes.fold(0.0, f64::max) }
    }

    /// Returns the number of minutes beyond those needed.
    fn freedom(&self) -> f64 {
        self.days.iter().map(|day| day.minutes(Choice::Any)).sum::<f64>() - self.minutes
    }

    /// Returns the cheapest steps that hold `wanted` minutes, or all of them if they hold too few.
    /// `costs` are those that decide, and those that decide among equals.
    fn cheapest(&self, costs: [&Costs; 2], wanted: f64) -> Kept {
        let mut kept = Kept { steps: self.days.iter().map(|day| vec![false; day.minutes.len()]).collect(), cost: 0.0 };
        let chosen: Vec<(usize, usize)> = match self.choice {
            Choice::Any => {
                let steps = |(day, lit): (usize, &LitDay)| (0..lit.minutes.len()).map(move |step| (day, step));
                let minutes = |(day, step): (usize, usize)| self.days[day].minutes[step];
                let all = self.days.iter().enumerate().flat_map(steps);
                let mut all: Vec<(usize, usize)> = all.filter(|step| minutes(*step) > 0.0).collect();
                let cost = |(day, step): (usize, usize)| costs.map(|costs| costs[day][step]);
                all.sort_by(|a, b| compare(cost(*a), cost(*b)));
                let mut sum = 0.0;
                let enough = all.iter().position(|step| {
                    sum += minutes(*step);
                    sum >= wanted
                });
                all.truncate(enough.map_or(all.len(), |last| last + 1));
                all
            }
            Choice::OneSpell => {
                let windows = self.days.iter().enumerate().flat_map(|(day, lit)| {
                    let windows = lit.runs().flat_map(move |run| windows(&lit.minutes, run, wanted));
                    windows.map(move |window| (costs.map(|costs| costs[day][window.clone()].iter().sum()), day, window))
                });
                let best = windows.min_by(|a, b| compare(a.0, b.0)).map(|(_, day, window)| (day, window));
                let longest = || {
                    let runs =
                        self.days.iter().enumerate().flat_map(|(day, lit)| lit.runs().map(move |run| (day, run)));
                    runs.max_by_key(|(_, run)| run.len())
                };
                let steps = |(day, window): (usize, Range<usize>)| window.map(move |step| (day, step));
                best.or_else(longest).into_iter().flat_map(steps).collect()
            }
        };
        for (day, step) in chosen {
            kept.steps[day][step] = true;
            kept.cost += costs[0][day][step];
        }
        kept
    }
}

/// Returns the shortest windows of a run that hold enough minutes, one from each step.
fn windows(minutes: &[f64], run: Range<usize>, wanted: f64) -> Vec<Range<usize>> {
    let (mut found, mut sum, mut end) = (Vec::new(), 0.0, run.start);
    for start in run.clone() {
        while end < run.end && sum < wanted {
            sum += minutes[end];
            end += 1;
        }
        if sum < wanted {
            break;
        }
        found.push(start..end);
        sum -= minutes[start];
    }
    found
}

fn compare(a: [f64; 2], b: [f64; 2]) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}

/// Search for the heights of nodes.
pub struct Search<'a> {
    /// Needs with a choice.
    needs: Vec<Need>,
    days: &'a [DaySteps],
    grid: &'a Grid,
    /// Heights of the nodes without these needs, input coordinates, metres.
    limits_m: Vec<f64>,
}

impl<'a> Search<'a> {
    /// Returns the search below `limits_m`. Needs that have no minute to spare keep all they have.
    pub fn new(needs: Vec<Need>, days: &'a [DaySteps], grid: &'a Grid, mut limits_m: Vec<f64>) -> Self {
        let (needs, all): (Vec<Need>, Vec<Need>) =
            needs.into_iter().partition(|need| need.has() > need.minutes + SPARE_MIN);
        for need in &all {
            for lit in &need.days {
                need.lower(|step| lit.minutes[step] > 0.0, &days[lit.day], grid, &mut limits_m);
            }
        }
        Search { needs, days, grid, limits_m }
    }

    /// Returns the height to which each node may rise, input coordinates, metres.
    pub fn tops(&self, observer: &dyn Observer) -> Result<Vec<f64>> {
        let mut order: Vec<usize> = (0..self.needs.len()).collect();
        order.sort_by(|a, b| self.needs[*a].freedom().total_cmp(&self.needs[*b].freedom()));
        let asked: Vec<f64> = self.needs.iter().map(|need| need.minutes + SPARE_MIN).collect();
        let mut best = self.round(&order, &asked, None);
        let mut best_m3 = self.volume_m3(&best);
        for _ in 1..MAX_ROUNDS {
            observer.stop_if_cancelled(STOPPED)?;
            best = self.round(&order, &asked, Some(&best));
            let was_m3 = std::mem::replace(&mut best_m3, self.volume_m3(&best));
            if best_m3 < was_m3 * (1.0 + LEAST_GROWTH) {
                break;
            }
        }
        // The surface between nodes leaves minutes beside the kept ones free, too. Needs that get
        // more than they ask for in this way ask for less, as long as all of them are met.
        let guide = best.clone();
        let (mut wanted, mut tops_m) = (asked.clone(), best.clone());
        for _ in 0..MAX_TRIMS {
            observer.stop_if_cancelled(STOPPED)?;
            let has = self.minutes_beside(&tops_m)?;
            let is_met = has.iter().zip(&asked).all(|(has, asked)| *has >= asked - CLOSE_MIN);
            let m3 = self.volume_m3(&tops_m);
            if is_met && m3 > best_m3 {
                best = tops_m;
                let was_m3 = std::mem::replace(&mut best_m3, m3);
                if m3 < was_m3 * (1.0 + LEAST_GROWTH) {
                    break;
                }
            }
            for ((wanted, has), asked) in wanted.iter_mut().zip(&has).zip(&asked) {
                *wanted = (*wanted - (has - asked) * if has > asked { TRIMMED } else { 1.0 }).clamp(0.0, *asked);
            }
            tops_m = self.round(&order, &wanted, Some(&guide));
        }
        Ok(best)
    }

    /// Returns the heights after each need chose its steps, in order. `former` are the heights of
    /// the round before: steps that they leave free are preferred.
    fn round(&self, order: &[usize], wanted: &[f64], former: Option<&Vec<f64>>) -> Vec<f64> {
        let Search { needs, days, grid, limits_m } = self;
        let mut tops_m = limits_m.clone();
        for some in order.chunks(NEEDS_AT_ONCE) {
            let chosen = |number: &usize| {
                let need = &needs[*number];
                let now = need.costs(days, grid, &tops_m);
                let by_former = former.map(|former| need.costs(days, grid, former));
                (need, need.cheapest([by_former.as_ref().unwrap_or(&now), &now], wanted[*number]))
            };
            let chosen: Vec<(&Need, Kept)> = some.par_iter().map(chosen).collect();
            for (need, kept) in chosen {
                for (lit, kept) in need.days.iter().zip(&kept.steps) {
                    need.lower(|step| kept[step], &days[lit.day], grid, &mut tops_m);
                }
            }
        }
        tops_m
    }

    /// Returns the minutes of sun that each need has beside a body of these heights, by rays.
    fn minutes_beside(&self, tops_m: &[f64]) -> Result<Vec<f64>> {
        let corners: Vec<([DVec3; 3], u16)> =
            Solid::new(self.grid, tops_m).triangles().map(|three| (three, 0)).collect();
        if corners.is_empty() {
            return Ok(self.needs.iter().map(Need::has).collect());
        }
        let scene = Scene::from_triangles(&corners, vec![Material::matt("envelope", 0.0, Class::Obstruction)])?;
        let prepared = PreparedScene::new(&scene)?;
        let siting = Siting::new(&prepared);
        let minutes = |need: &Need| {
            let rays = siting.sun_rays(need.place, DVec3::Z);
            let left = |lit: &LitDay| LitDay { day: lit.day, minutes: self.days[lit.day].left(&lit.minutes, &rays) };
            Need { place: need.place, days: need.days.iter().map(left).collect(), ..*need }.has()
        };
        Ok(self.needs.par_iter().map(minutes).collect())
    }

    fn volume_m3(&self, tops_m: &[f64]) -> f64 {
        Solid::new(self.grid, tops_m).volume_m3_and_height_m().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(days: &[&[f64]], choice: Choice) -> Need {
        let days = days.iter().enumerate().map(|(day, minutes)| LitDay { day, minutes: minutes.to_vec() });
        Need { place: DVec3::ZERO, days: days.collect(), minutes: 1.5, choice }
    }

    /// Any 2 minutes of two days with 2.5 and 3 minutes of sun are the two cheapest steps; in one
    /// spell they are the cheapest window that does not reach over a gap. Without a long enough
    /// spell all of the longest one is kept.
    #[test]
    fn the_cheapest_minutes_are_kept() {
        let days: [&[f64]; 2] = [&[0.5, 1.0, 1.0, 0.0], &[1.0, 0.0, 1.0, 1.0]];
        let costs: Costs = vec![vec![9.0, 1.0, 4.0, 0.0], vec![2.0, 0.0, 3.0, 1.5]];
        let any = need(&days, Choice::Any).cheapest([&costs, &costs], 2.0);
        assert_eq!((any.cost, any.steps[0][1], any.steps[1][3]), (2.5, true, true));
        let one = need(&days, Choice::OneSpell).cheapest([&costs, &costs], 2.0);
        assert_eq!((one.cost, &one.steps[1][..]), (4.5, &[false, false, true, true][..]));
        let long = need(&days, Choice::OneSpell);
        assert_eq!(
            (long.has(), long.cheapest([&costs, &costs], 9.0).steps[0].iter().filter(|kept| **kept).count()),
            (2.5, 3)
        );
        assert_eq!(need(&days, Choice::Any).has(), 5.5);
    }
}
