//! Canopies at replay. In: canopy layers of an archive, transmittances by material. Out: the share
//! of light that comes through along each ray, and the weights of the leaves that scatter light.
//!
//! A leaf scatters the same light to its two sides (a bi-Lambertian leaf whose reflectance equals
//! its transmittance: Goudriaan 1977, "Crop micrometeorology: a simulation study"). The radiosity
//! of either side is its `diffuse` times the mean irradiance of the two.

use crate::layers::canopy::{COUNTS, Powers, SEEN, SKY, length_of};
use crate::layers::cells::Cells;
use crate::light::radiosity::SidesOf;
use crate::light::reflector::{Reflectance, Reflector};
use crate::site::cells::CellKey;
use crate::site::material::Material;
use crate::weather::time::bins::Bins;

/// The distinct sets of canopy transmittances ("leafages") that some states have.
#[derive(Clone, Debug, Default)]
pub struct TransmittanceStates {
    /// `[leafage]`: light left after crossings, by material.
    pub powers: Vec<Powers>,
    /// `[state]`: index of its leafage.
    of_state: Vec<usize>,
}

impl TransmittanceStates {
    /// Takes the transmittances out of states that hold a value by material
    /// ([`Reflector::variable`]). The states keep reflectances; for a canopy that is the share that
    /// its leaves scatter. Without canopies all states have one leafage.
    pub fn split(reflectors: &[Reflector], states: &mut [Vec<f64>]) -> Self {
        let canopies: Vec<usize> = (0..reflectors.len()).filter(|&m| reflectors[m].transmittance.is_some()).collect();
        let mut known: Vec<Vec<f64>> = Vec::new();
        let mut leafages = TransmittanceStates::default();
        for state in states {
            let state: &mut Reflectance = state;
            let values: Vec<f64> = canopies.iter().map(|&m| state[m]).collect();
            canopies.iter().zip(&values).for_each(|(&m, &value)| state[m] = reflectors[m].scattered(value));
            let leafage = known.iter().position(|other| *other == values).unwrap_or(known.len());
            if leafage == known.len() {
                let of_material = |(&m, &tau): (&usize, &f64)| (m as u16, powers(tau, reflectors[m].volume));
                leafages.powers.push(canopies.iter().zip(&values).map(of_material).collect());
                known.push(values);
            }
            leafages.of_state.push(leafage);
        }
        leafages
    }

    /// Returns for each leafage its powers and its bins. The weight of a condition is the sum of
    /// its weights in the states of the leafage.
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

    /// Iterates over the states of a leafage.
    pub fn states(&self, leafage: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.of_state.len()).filter(move |&state| self.of_state[state] == leafage)
    }
}

/// Returns the share of light left after 0 to 1023 crossings of a transmittance, or in a volume
/// after the lengths of these codes (law of Beer and Lambert).
fn powers(tau: f64, volume: bool) -> [f32; COUNTS] {
    let stopped = -tau.ln();
    std::array::from_fn(|code| match (volume, code) {
        (false, _) => tau.powi(code as i32) as f32,
        // All light is left of 0 m, also where 1 m leaves none.
        (true, 0) => 1.0,
        (true, _) => (-stopped * length_of(code as u16)).exp() as f32,
    })
}

/// Shares of the light that come through to a cell.
#[derive(Clone, Debug, Default)]
pub struct Shade {
    /// `[texel of its sky]`: factor of the cell's normal; `None` where all are 1. For a cell of
    /// leaves it is half of the share, negative for light on their other side. For one of a volume
    /// it turns each cosine into 1/4.
    pub sky: Option<Vec<f32>>,
    /// `[ray]` to the cells it sees: the share that comes through; `None` where nothing is crossed.
    pub seen: Option<Vec<f32>>,
    /// Cells of leaves that it sees, with the shares of its hemisphere that come from them.
    pub leaves: Vec<(CellKey, f32)>,
}

impl Shade {
    /// Returns the shares of cell `i` of a table whose sky has texels with these centres.
    pub fn new(cells: &Cells, i: usize, powers: &Powers, centres: &[[f32; 3]]) -> Self {
        let canopy = cells.canopy_of(i);
        let through = |list| canopy.and_then(|canopy| canopy.through(list, powers));
        let mut sky = through(SKY);
        if cells.keys[i].is_leaf() {
            let [x, y, z] = cells.normals[i];
            let sides = sky.get_or_insert_with(|| vec![1.0; centres.len()]).iter_mut().zip(centres);
            let side = SidesOf(cells.keys[i]);
            sides.for_each(|(share, d)| *share *= side.factor(x * d[0] + y * d[1] + z * d[2]));
        }
        Shade { sky, seen: through(SEEN), leaves: canopy.map_or_else(Vec::new, |canopy| canopy.leaves(powers)) }
    }
}

/// Returns the shares that come through by the transmittances of the materials as stored; empty if
/// none is a canopy.
pub fn stored(materials: &[Material]) -> Powers {
    let rows = (0..=u16::MAX).zip(materials);
    rows.filter_map(|(m, material)| Some((m, powers(material.transmittance?, material.volume)))).collect()
}
