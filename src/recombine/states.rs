//! Reflectances that change from condition to condition. In: the stored reflectances and schedules. Out: a few states that are each
//! solved once, and how much of each condition belongs to each.
//!
//! All light is an analytic function of a reflectance, without poles up to 1. So where a schedule has too many values to solve each,
//! states are solved at Chebyshev's nodes between the smallest and the largest, and results are interpolated (Trefethen,
//! "Approximation Theory and Approximation Practice", 2013, theorem 8.2: the error falls with the power of the number of nodes).

use super::bins::Bins;
use super::bounces::Reflectance;
use crate::error::{Error, Result};

/// Most states that are solved as they are.
const MOST: usize = 24;

/// Nodes where one series of values is interpolated, and where two are.
const NODES: [usize; 2] = [8, 5];

/// Reflectances of some materials.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    pub materials: Vec<usize>,
    /// `[condition]`: diffuse reflectance, 0 to 1.
    pub values: Vec<f64>,
}

/// States of the reflectances of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    pub reflectances: Vec<Reflectance>,
    /// `[condition]`: states and their shares, which sum to 1.
    pub of_condition: Vec<Vec<(usize, f64)>>,
}

impl States {
    /// Where several schedules name a material, the last one counts.
    pub fn new(stored: &Reflectance, schedules: &[Schedule], conditions: usize) -> Result<States> {
        let distinct = States::distinct(stored, schedules, conditions);
        if distinct.reflectances.len() <= MOST {
            return Ok(distinct);
        }
        let mut series: Vec<&[f64]> = schedules.iter().map(|s| s.values.as_slice()).collect();
        series.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        series.dedup();
        series.retain(|values| values.iter().any(|v| *v != values[0]));
        let Some(&nodes) = series.len().checked_sub(1).and_then(|extra| NODES.get(extra)) else {
            return Err(Error::Limit {
                what: format!("states of {} reflectances that change independently", series.len()),
                value: distinct.reflectances.len() as u64,
                max: MOST as u64,
            });
        };
        let axes: Vec<Vec<f64>> = series.iter().map(|values| chebyshev(values, nodes)).collect();
        let count = nodes.pow(series.len() as u32);
        let node = |state: usize, axis: usize| axes[axis][state / nodes.pow(axis as u32) % nodes];
        let reflectance = |state: usize| {
            let mut reflectance = stored.clone();
            for schedule in schedules {
                let axis = series.iter().position(|values| *values == schedule.values);
                let value = axis.map_or(schedule.values[0], |axis| node(state, axis));
                schedule.materials.iter().for_each(|&material| reflectance[material] = value);
            }
            reflectance
        };
        let shares = |condition: usize| {
            let weights: Vec<Vec<f64>> =
                axes.iter().zip(&series).map(|(axis, values)| lagrange(axis, values[condition])).collect();
            let share = |state: usize| {
                let of_axis = |axis: usize| weights[axis][state / nodes.pow(axis as u32) % nodes];
                (state, (0..axes.len()).map(of_axis).product())
            };
            (0..count).map(share).filter(|share: &(usize, f64)| share.1 != 0.0).collect()
        };
        Ok(States {
            reflectances: (0..count).map(reflectance).collect(),
            of_condition: (0..conditions).map(shares).collect(),
        })
    }

    /// A state for every set of reflectances that occurs.
    fn distinct(stored: &Reflectance, schedules: &[Schedule], conditions: usize) -> States {
        let mut states = States { reflectances: Vec::new(), of_condition: Vec::with_capacity(conditions) };
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

    /// For each state, how conditions add to the results by way of it.
    pub fn ways(&self, bins: &Bins) -> Vec<Bins> {
        let none = Bins { count: bins.count, of_condition: bins.of_condition.iter().map(|b| (b.0, 0.0)).collect() };
        let mut ways = vec![none; self.reflectances.len()];
        for (i, (shares, (_, weight))) in self.of_condition.iter().zip(&bins.of_condition).enumerate() {
            shares.iter().for_each(|&(state, share)| ways[state].of_condition[i].1 = weight * share);
        }
        ways
    }
}

/// Chebyshev's points of the second kind between the smallest and the largest of some values.
fn chebyshev(values: &[f64], nodes: usize) -> Vec<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let last = (nodes - 1) as f64;
    let node = |k: usize| (low + high) / 2.0 - (high - low) / 2.0 * (std::f64::consts::PI * k as f64 / last).cos();
    // The ends are met exactly: nothing is extrapolated.
    (0..nodes).map(|k| node(k).clamp(low, high)).collect()
}

/// Values of Lagrange's polynomials of some nodes at a point.
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

    /// Three values in five conditions are three states in order of first use; a later schedule wins; no schedules are one state.
    #[test]
    fn few_values() {
        let stored = vec![0.1, 0.2, 0.3];
        let a = schedule(&[0, 1], &[0.5, 0.6, 0.5, 0.7, 0.6]);
        let states = States::new(&stored, &[a.clone(), schedule(&[1], &[0.9; 5])], 5).expect("states");
        assert_eq!(states.reflectances, [[0.5, 0.9, 0.3], [0.6, 0.9, 0.3], [0.7, 0.9, 0.3]]);
        assert_eq!(states.of_condition, [0, 1, 0, 2, 1].map(|state| vec![(state, 1.0)]));
        let bins = Bins { count: 1, of_condition: vec![(0, 2.0); 5] };
        let ways = states.ways(&bins);
        assert_eq!(ways[1].of_condition, [(0, 0.0), (0, 2.0), (0, 0.0), (0, 0.0), (0, 2.0)]);
        let none = States::new(&stored, &[], 2).expect("states");
        assert_eq!((none.reflectances, none.of_condition.len()), (vec![stored], 2));
    }

    /// 1,000 values of one group are 8 states, of two groups 25; the shares reproduce 1 / (1 - rho / 2) to 1e-7 and 1e-4, and the
    /// reflectances themselves; three independent groups are refused.
    #[test]
    fn many_values() {
        let stored = vec![0.3; 3];
        let a: Vec<f64> = (0..1000).map(|i| 0.2 + 0.6 * (f64::from(i) * 0.37).sin().abs()).collect();
        let b: Vec<f64> = (0..1000).map(|i| 0.5 + 0.4 * (f64::from(i) * 0.11).cos()).collect();
        let one = [schedule(&[0], &a)];
        let two = [schedule(&[0], &a), schedule(&[2], &b)];
        for (schedules, count, tolerance) in [(&one[..], 8, 1e-7), (&two[..], 25, 1e-4)] {
            let states = States::new(&stored, schedules, 1000).expect("states");
            assert_eq!(states.reflectances.len(), count);
            let light = |r: &[f64]| 1.0 / (1.0 - r[0] / 2.0) + r[2] / (1.0 - r[2] / 3.0);
            for i in 0..1000 {
                let sum: f64 = states.of_condition[i].iter().map(|(s, w)| w * light(&states.reflectances[*s])).sum();
                let expected = light(&[a[i], 0.3, if count == 8 { 0.3 } else { b[i] }]);
                assert!((sum - expected).abs() < tolerance * expected, "{sum} {expected}");
                let shares: f64 = states.of_condition[i].iter().map(|s| s.1).sum();
                assert!((shares - 1.0).abs() < 1e-12);
            }
        }
        let c: Vec<f64> = a.iter().map(|v| v * v).collect();
        let three = [two[0].clone(), two[1].clone(), schedule(&[1], &c)];
        let text = States::new(&stored, &three, 1000).expect_err("too many").to_string();
        assert!(text.contains("3 reflectances"), "{text}");
    }
}
