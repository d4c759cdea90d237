//! Reflectances that change from condition to condition. In: the stored reflectances and schedules.
//! Out: a few states that are each solved once, and the share of each state in each condition.
//!
//! All light is an analytic function of a reflectance, without poles up to 1. So where a schedule
//! has too many values to solve each, states are solved at Chebyshev's nodes between the smallest
//! and the largest, and results are interpolated (Trefethen, "Approximation Theory and
//! Approximation Practice", 2013, theorem 8.2: the error falls with the power of the number of
//! nodes).

use crate::error::{Error, Result};
use crate::layers::canopy::COUNTS;
use crate::light::reflector::Reflectance;
use crate::weather::time::bins::Bins;

/// Numbers of nodes of an interpolation, and of a finer one; the nodes of the first are among those
/// of the second.
const NODES: [usize; 2] = [5, 9];

/// Largest error of an interpolated power of a transmittance, for any number of crossings. It
/// bounds the error of light as a share of the light that open canopies let through, since all
/// light is a sum of such powers.
const MAX_OFF: f64 = 1e-4;

/// Largest number of crossings of a path that is checked: the largest count of a material.
const MAX_CROSSINGS: usize = COUNTS - 1;

/// Largest number of states that are solved as they are, where they cannot be interpolated.
const MAX: usize = 100;

/// Reflectances of some materials, or transmittances of some canopies.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Rows of the materials that share the values, in the materials table.
    pub materials: Vec<usize>,
    /// `[condition]`: diffuse reflectance, or transmittance at each crossing, 0 to 1.
    pub values: Vec<f64>,
}

/// States of the reflectances of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    /// `[state][material]`: diffuse reflectance, or transmittance of a canopy, from which its
    /// scattering follows.
    pub reflectances: Vec<Reflectance>,
    /// `[condition]`: states and their shares, which sum to 1.
    pub of_condition: Vec<Vec<(usize, f64)>>,
    /// Combinations of states that show the difference of light from an interpolation with half of
    /// the nodes; empty where nothing is interpolated.
    pub checks: Vec<Vec<f64>>,
}

impl States {
    /// Returns the states of some schedules. Where several schedules name a material, the last one
    /// counts. `lets_through` says which materials are canopies. `finer` interpolates between more
    /// nodes. It is an error if there are too many states and they cannot be interpolated.
    pub fn new(
        stored: &Reflectance,
        lets_through: &[bool],
        schedules: &[Schedule],
        conditions: usize,
        finer: bool,
    ) -> Result<States> {
        let distinct = States::distinct(stored, schedules, conditions);
        let mut series: Vec<&[f64]> = schedules.iter().map(|s| s.values.as_slice()).collect();
        series.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        series.dedup();
        series.retain(|values| values.iter().any(|v| *v != values[0]));
        let steep = |values: &[f64], nodes| {
            let of_canopy =
                |s: &Schedule| s.values == values && s.materials.iter().any(|&m| lets_through.get(m) == Some(&true));
            schedules.iter().any(of_canopy) && powers_off(&chebyshev(values, nodes)) > MAX_OFF
        };
        let any_steep = |nodes| series.iter().any(|values| steep(values, nodes));
        // Powers of transmittances that bend too much for the few nodes take the finer ones.
        let nodes = NODES[usize::from(finer || any_steep(NODES[0]))];
        let count = nodes.checked_pow(series.len() as u32).filter(|count| *count <= MAX && !any_steep(nodes));
        // Interpolation pays only if it needs fewer states than there are sets of values.
        let Some(count) = count.filter(|count| *count < distinct.reflectances.len()) else {
            let found = distinct.reflectances.len();
            if found > MAX && any_steep(nodes) {
                let what =
                    "number of different transmittances in the schedule, which vary too much to be interpolated \
                     (round them),"
                        .to_string();
                return Err(Error::Limit { what: what.into(), value: found as u64, max: MAX as u64 });
            }
            if found > MAX {
                let what = format!("number of states of {} reflectances that change independently", series.len());
                return Err(Error::Limit { what: what.into(), value: found as u64, max: MAX as u64 });
            }
            return Ok(distinct);
        };
        let axes: Vec<Vec<f64>> = series.iter().map(|values| chebyshev(values, nodes)).collect();
        let place = |state: usize, axis: usize| state / nodes.pow(axis as u32) % nodes;
        let reflectance = |state: usize| {
            let mut reflectance = stored.clone();
            for schedule in schedules {
                let axis = series.iter().position(|values| *values == schedule.values);
                let value = axis.map_or(schedule.values[0], |axis| axes[axis][place(state, axis)]);
                schedule.materials.iter().for_each(|&material| reflectance[material] = value);
            }
            reflectance
        };
        let shares = |condition: usize| {
            let weights: Vec<Vec<f64>> =
                axes.iter().zip(&series).map(|(axis, values)| lagrange(axis, values[condition])).collect();
            let share = |state| (state, (0..axes.len()).map(|axis| weights[axis][place(state, axis)]).product());
            (0..count).map(share).filter(|share: &(usize, f64)| share.1 != 0.0).collect()
        };
        Ok(States {
            reflectances: (0..count).map(reflectance).collect(),
            of_condition: (0..conditions).map(shares).collect(),
            checks: (0..axes.len()).flat_map(|axis| checks(&axes[axis], count, |state| place(state, axis))).collect(),
        })
    }

    /// Returns a state for every set of reflectances that occurs.
    fn distinct(stored: &Reflectance, schedules: &[Schedule], conditions: usize) -> States {
        let of_condition = Vec::with_capacity(conditions);
        let mut states = States { reflectances: Vec::new(), of_condition, checks: Vec::new() };
        let mut known: std::collections::HashMap<Vec<u64>, usize> = std::collections::HashMap::new();
        for condition in 0..conditions {
            let values: Vec<f64> = schedules.iter().map(|s| s.values[condition]).collect();
            let next = states.reflectances.len();
            let state = *known.entry(values.iter().map(|v| v.to_bits()).collect()).or_insert(next);
            if state == next {
                let mut reflectance = stored.clone();
                for (schedule, value) in schedules.iter().zip(values) {
                    schedule.materials.iter().for_each(|&material| reflectance[material] = value);
                }
                states.reflectances.push(reflectance);
            }
            states.of_condition.push(vec![(state, 1.0)]);
        }
        states
    }

    /// Returns bins for each state: the weight of a condition times the share of the state in it.
    pub fn ways(&self, bins: &Bins) -> Vec<Bins> {
        let none = Bins { count: bins.count, of_condition: bins.of_condition.iter().map(|b| (b.0, 0.0)).collect() };
        let mut ways = vec![none; self.reflectances.len()];
        for (i, (shares, (_, weight))) in self.of_condition.iter().zip(&bins.of_condition).enumerate() {
            shares.iter().for_each(|&(state, share)| ways[state].of_condition[i].1 = weight * share);
        }
        ways
    }
}

/// Returns Chebyshev's points of the second kind between the smallest and the largest of some
/// values.
fn chebyshev(values: &[f64], nodes: usize) -> Vec<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let last = (nodes - 1) as f64;
    let node = |k: usize| (low + high) / 2.0 - (high - low) / 2.0 * (std::f64::consts::PI * k as f64 / last).cos();
    // Clamping meets the ends exactly, so nothing is extrapolated.
    (0..nodes).map(|k| node(k).clamp(low, high)).collect()
}

/// Returns the largest error of the powers of a transmittance that are interpolated between nodes,
/// at 200 points between the first and the last.
fn powers_off(nodes: &[f64]) -> f64 {
    let (low, high) = (nodes[0], nodes[nodes.len() - 1]);
    let of_point = |i: usize| {
        let at = low + (high - low) * (i as f64 + 0.5) / 200.0;
        let weights = lagrange(nodes, at);
        let (mut powers, mut exact, mut worst) = (weights, 1.0, 0.0_f64);
        for _ in 0..MAX_CROSSINGS {
            exact *= at;
            powers.iter_mut().zip(nodes).for_each(|(power, node)| *power *= node);
            worst = worst.max((powers.iter().sum::<f64>() - exact).abs());
        }
        worst
    };
    (0..200).map(of_point).fold(0.0, f64::max)
}

/// Returns for every second node of an axis the combination "state at the node minus its
/// interpolation between the other nodes of the axis". The other axes are at their first nodes.
fn checks(axis: &[f64], states: usize, place: impl Fn(usize) -> usize) -> Vec<Vec<f64>> {
    let even: Vec<f64> = axis.iter().step_by(2).copied().collect();
    let check = |node: usize| {
        let weights = lagrange(&even, axis[node]);
        let mut check = vec![0.0; states];
        // The first state of each index on the axis has all other axes at their first nodes.
        for k in 0..axis.len() {
            let coefficient = if k % 2 == 0 { -weights[k / 2] } else { f64::from(u8::from(k == node)) };
            if let Some(state) = (0..states).find(|&state| place(state) == k) {
                check[state] = coefficient;
            }
        }
        check
    };
    (1..axis.len()).step_by(2).map(check).collect()
}

/// Returns the values of Lagrange's polynomials of some nodes at a point.
fn lagrange(nodes: &[f64], at: f64) -> Vec<f64> {
    let polynomial = |k: usize| -> f64 {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, node)| (at - node) / (nodes[k] - node)).product()
    };
    (0..nodes.len()).map(polynomial).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(materials: &[usize], values: &[f64]) -> Schedule {
        Schedule { materials: materials.to_vec(), values: values.to_vec() }
    }

    /// Three values in five conditions are three states in order of first use. A later schedule
    /// overrides an earlier one. Without schedules there is one state.
    #[test]
    fn few_values_become_states_in_order_of_first_use() {
        let stored = vec![0.1, 0.2, 0.3];
        let a = schedule(&[0, 1], &[0.5, 0.6, 0.5, 0.7, 0.6]);
        let states = States::new(&stored, &[], &[a.clone(), schedule(&[1], &[0.9; 5])], 5, false).expect("states");
        assert_eq!(states.reflectances, [[0.5, 0.9, 0.3], [0.6, 0.9, 0.3], [0.7, 0.9, 0.3]]);
        assert_eq!(states.of_condition, [0, 1, 0, 2, 1].map(|state| vec![(state, 1.0)]));
        let bins = Bins { count: 1, of_condition: vec![(0, 2.0); 5] };
        let ways = states.ways(&bins);
        assert_eq!(ways[1].of_condition, [(0, 0.0), (0, 2.0), (0, 0.0), (0, 0.0), (0, 2.0)]);
        let none = States::new(&stored, &[], &[], 2, false).expect("states");
        assert_eq!((none.reflectances, none.of_condition.len()), (vec![stored], 2));
    }

    /// 1,000 values of one group are 5 or 9 states, of two groups 25 or 81. The shares reproduce
    /// sums of 1 / (1 - rho / 2) and rho / (1 - rho / 3) to 1e-4 and 1e-7 for one group, and to
    /// 1e-3 and 1e-6 for two. The checks lie between that and 10 times its square root. Three
    /// independent groups of 1,000 values are refused, of 20 values not.
    #[test]
    fn many_values_are_interpolated_between_few_states() {
        let stored = vec![0.3; 3];
        let a: Vec<f64> = (0..1000).map(|i| 0.2 + 0.6 * (f64::from(i) * 0.37).sin().abs()).collect();
        let b: Vec<f64> = (0..1000).map(|i| 0.5 + 0.4 * (f64::from(i) * 0.11).cos()).collect();
        let one = [schedule(&[0], &a)];
        let two = [schedule(&[0], &a), schedule(&[2], &b)];
        let cases =
            [(&one[..], false, 5, 1e-4), (&one, true, 9, 1e-7), (&two, false, 25, 1e-3), (&two, true, 81, 1e-6)];
        for (schedules, finer, count, tolerance) in cases {
            let states = States::new(&stored, &[], schedules, 1000, finer).expect("states");
            assert_eq!(states.reflectances.len(), count);
            let light = |r: &[f64]| 1.0 / (1.0 - r[0] / 2.0) + r[2] / (1.0 - r[2] / 3.0);
            for i in 0..1000 {
                let sum: f64 = states.of_condition[i].iter().map(|(s, w)| w * light(&states.reflectances[*s])).sum();
                let expected = light(&[a[i], 0.3, if schedules.len() == 1 { 0.3 } else { b[i] }]);
                assert!((sum - expected).abs() < tolerance * expected, "{sum} {expected}");
                let shares: f64 = states.of_condition[i].iter().map(|s| s.1).sum();
                assert!((shares - 1.0).abs() < 1e-12);
            }
            let bent = |check: &Vec<f64>| {
                let sum: f64 = check.iter().zip(&states.reflectances).map(|(c, r)| c * light(r)).sum();
                sum.abs()
            };
            let worst = states.checks.iter().map(bent).fold(0.0, f64::max);
            assert!(worst > tolerance && worst < 10.0 * tolerance.sqrt(), "{worst}");
        }
        let c: Vec<f64> = a.iter().map(|v| v * v).collect();
        let three = [two[0].clone(), two[1].clone(), schedule(&[1], &c)];
        let text = States::new(&stored, &[], &three, 1000, false).expect_err("too many").to_string();
        assert!(text.contains("3 reflectances"), "{text}");
        let few = three.map(|s| Schedule { values: s.values[..20].to_vec(), ..s });
        assert_eq!(States::new(&stored, &[], &few, 20, false).expect("states").reflectances.len(), 20);
    }

    /// 1,000 transmittances from 0.1 to 0.6 are 9 states whose shares reproduce tau^k within 1e-4
    /// for k of 1 to 40. From 0.1 to 1, where powers bend too much, 1,000 are refused with advice,
    /// and 90 are 90 states. As reflectances 1,000 are 5 states.
    #[test]
    fn powers_of_many_transmittances_are_interpolated() {
        let value = |i: u32, high: f64| 0.1 + (high - 0.1) * (f64::from(i) * 0.37).sin().abs();
        let of = |count: u32, high| [schedule(&[1], &(0..count).map(|i| value(i, high)).collect::<Vec<_>>())];
        let states = |schedules: &[Schedule], canopies: &[bool]| {
            States::new(&vec![0.3; 2], canopies, schedules, schedules[0].values.len(), false)
        };
        let nine = states(&of(1000, 0.6), &[false, true]).expect("states");
        assert_eq!(nine.reflectances.len(), 9);
        for (i, shares) in (0..).zip(&nine.of_condition) {
            for k in 1..=40 {
                let sum: f64 = shares.iter().map(|(s, w)| w * nine.reflectances[*s][1].powi(k)).sum();
                assert!((sum - value(i, 0.6).powi(k)).abs() < 1e-4, "{i} {k}: {sum}");
            }
        }
        let text = states(&of(1000, 1.0), &[false, true]).expect_err("too steep").to_string();
        assert!(text.contains("transmittances") && text.contains("round them"), "{text}");
        assert_eq!(states(&of(90, 1.0), &[false, true]).expect("states").reflectances.len(), 90);
        assert_eq!(states(&of(1000, 1.0), &[]).expect("states").reflectances.len(), 5);
    }
}
