//! Canopies at replay. In: canopy layers of an archive, transmittances by material. Out: the share of light that comes through along
//! each ray. What does not come through is absorbed: leaves reflect and scatter nothing.

use crate::layers::canopy::{Powers, SEEN, SKY};
use crate::layers::cells::Cells;
use crate::light::reflector::{Reflectance, Reflector};
use crate::site::material::Material;
use crate::weather::time::bins::Bins;

/// The transmittances that some states have, each set of them once.
#[derive(Clone, Debug, Default)]
pub struct TransmittanceStates {
    /// `[leafage]`
    pub powers: Vec<Powers>,
    /// `[state]`: its leafage.
    of_state: Vec<usize>,
}

impl TransmittanceStates {
    /// Takes the transmittances out of states that hold a value by material ([`Reflector::variable`]), and leaves reflectances: 0 of
    /// canopies. Without canopies all states have one leafage.
    pub fn split(reflectors: &[Reflector], states: &mut [Vec<f64>]) -> Self {
        let canopies: Vec<usize> = (0..reflectors.len()).filter(|&m| reflectors[m].transmittance.is_some()).collect();
        let mut known: Vec<Vec<f64>> = Vec::new();
        let mut leafages = TransmittanceStates::default();
        for state in states {
            let state: &mut Reflectance = state;
            let values: Vec<f64> = canopies.iter().map(|&m| std::mem::take(&mut state[m])).collect();
            let leafage = known.iter().position(|other| *other == values).unwrap_or(known.len());
            if leafage == known.len() {
                let of_material = |(&m, &tau): (&usize, &f64)| (m as u16, powers(tau));
                leafages.powers.push(canopies.iter().zip(&values).map(of_material).collect());
                known.push(values);
            }
            leafages.of_state.push(leafage);
        }
        leafages
    }

    /// How conditions add to the results with each leafage, of how they do in each state.
    pub fn ways(&self, states: &[Bins]) -> Vec<(Powers, Bins)> {
        let none = |bins: &Bins| Bins {
            count: bins.count,
            of_condition: bins.of_condition.iter().map(|b| (b.0, 0.0)).collect(),
        };
        let mut ways: Vec<(Powers, Bins)> =
            self.powers.iter().flat_map(|powers| states.first().map(|first| (powers.clone(), none(first)))).collect();
        for (&leafage, bins) in self.of_state.iter().zip(states) {
            let weights = ways[leafage].1.of_condition.iter_mut().zip(&bins.of_condition);
            weights.for_each(|(sum, (_, weight))| sum.1 += weight);
        }
        ways
    }

    /// States of a leafage.
    pub fn states(&self, leafage: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.of_state.len()).filter(move |&state| self.of_state[state] == leafage)
    }
}

/// Beer and Lambert: what k crossings of a transmittance leave.
fn powers(tau: f64) -> [f32; 256] {
    std::array::from_fn(|k| tau.powi(k as i32) as f32)
}

/// Shares of the light that come through to a cell.
#[derive(Clone, Debug, Default)]
pub struct Shade {
    /// `[texel of its sky]`; `None` where nothing is crossed.
    pub sky: Option<Vec<f32>>,
    /// `[ray]` to what it sees, likewise.
    pub seen: Option<Vec<f32>>,
}

impl Shade {
    /// Of cell `i` of a table.
    pub fn of(cells: &Cells, i: usize, powers: &Powers) -> Self {
        let through = |list| cells.canopy_of(i).and_then(|canopy| canopy.through(list, powers));
        Shade { sky: through(SKY), seen: through(SEEN) }
    }
}

/// Shares that come through by the transmittances that materials have; none if no one is a canopy.
pub fn stored(materials: &[Material]) -> Powers {
    let rows = (0..=u16::MAX).zip(materials);
    rows.filter_map(|(m, material)| Some((m, powers(material.transmittance?)))).collect()
}
