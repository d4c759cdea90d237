//! Materials grouped by how their reflectances change. In: the reflectances of some states. Out: a
//! slot for each material. Light by way of a slot is linear in one factor a state.

use crate::light::reflector::Reflectance;

/// Slots of materials. Slot 0 holds all materials that never change, with factor 1. Each other slot
/// holds materials that change alike.
#[derive(Clone, Debug)]
pub struct Slots {
    /// `[material]`: its slot, and the reflectance that does not change: 1 where the slot's factor
    /// is the reflectance.
    of_material: Vec<(usize, f64)>,
    /// `[state][slot]`: factor.
    factors: Vec<Vec<f32>>,
}

impl Slots {
    /// Groups the materials of `states`: at least one state; all states have the same materials.
    pub fn new(states: &[Reflectance]) -> Self {
        let mut histories: Vec<Vec<f64>> = vec![vec![1.0; states.len()]];
        let of_material = (0..states.first().map_or(0, Vec::len))
            .map(|material| {
                let history: Vec<f64> = states.iter().map(|state| state[material]).collect();
                if history.iter().all(|rho| *rho == history[0]) {
                    return (0, history[0]);
                }
                let slot = histories.iter().skip(1).position(|known| *known == history).map(|found| found + 1);
                let slot = slot.unwrap_or_else(|| {
                    histories.push(history);
                    histories.len() - 1
                });
                (slot, 1.0)
            })
            .collect();
        let factors_of = |state: usize| histories.iter().map(|history| history[state] as f32).collect();
        Slots { of_material, factors: (0..states.len()).map(factors_of).collect() }
    }

    /// Returns the number of slots, at least 1.
    pub fn len(&self) -> usize {
        self.factors.first().map_or(1, Vec::len)
    }

    /// Returns the slot of a material, which must exist, and its unchanging reflectance.
    pub fn of(&self, material: u16) -> (usize, f64) {
        self.of_material[usize::from(material)]
    }

    /// Returns the factor of each slot in a state.
    pub fn factors(&self, state: usize) -> &[f32] {
        &self.factors[state]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five materials in three states, of which two never change, two change alike and one changes
    /// alone, have 3 slots. Factor x fixed share is the reflectance of each in each state (15
    /// values).
    #[test]
    fn materials_that_change_alike_share_a_slot() {
        let states = vec![vec![0.2, 0.1, 0.3, 0.1, 0.5], vec![0.2, 0.4, 0.3, 0.4, 0.6], vec![0.2, 0.1, 0.3, 0.1, 0.7]];
        let slots = Slots::new(&states);
        assert_eq!(slots.len(), 3);
        for (state, reflectances) in states.iter().enumerate() {
            for (material, rho) in reflectances.iter().enumerate() {
                let (slot, fixed) = slots.of(material as u16);
                assert!((fixed * f64::from(slots.factors(state)[slot]) - rho).abs() < 1e-7);
            }
        }
        assert_eq!(Slots::new(&states[..1]).len(), 1);
    }
}
