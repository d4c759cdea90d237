//! Irradiance of a tile of receivers: the six components, their total and what else is asked for, as recombination gives and
//! outputs take them.

use crate::replay::components::ComponentSet;

/// Values of one tile: `[component][receiver][label]`, row-major, components in the order of their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct TileValues {
    values: Vec<f32>,
    components: usize,
    receivers: usize,
    labels: usize,
}

impl TileValues {
    /// Zeros for all components of light and a number of receivers and labels.
    pub fn new(receivers: usize, labels: usize) -> Self {
        TileValues::of(ComponentSet::ALL, receivers, labels)
    }

    /// Zeros that have a place for every component of light and of a set.
    pub fn of(set: ComponentSet, receivers: usize, labels: usize) -> Self {
        TileValues::zeros(set.places(), receivers, labels)
    }

    fn zeros(components: usize, receivers: usize, labels: usize) -> Self {
        TileValues { values: vec![0.0; components * receivers * labels], components, receivers, labels }
    }

    /// `[receiver][label]` of a component; empty for one that does not exist.
    pub fn component(&self, component: usize) -> &[f32] {
        let size = self.receivers * self.labels;
        self.values.get(component * size..(component + 1) * size).unwrap_or_default()
    }

    /// `[receiver][label]` of a component, to be filled.
    pub fn component_mut(&mut self, component: usize) -> &mut [f32] {
        let size = self.receivers * self.labels;
        self.values.get_mut(component * size..(component + 1) * size).unwrap_or_default()
    }

    /// `[label]` of a component at a receiver.
    pub fn row(&self, component: usize, receiver: usize) -> &[f32] {
        let range = receiver * self.labels..(receiver + 1) * self.labels;
        self.component(component).get(range).unwrap_or_default()
    }

    /// `[label]` of a component at a receiver, to be filled.
    pub fn row_mut(&mut self, component: usize, receiver: usize) -> &mut [f32] {
        let range = receiver * self.labels..(receiver + 1) * self.labels;
        self.component_mut(component).get_mut(range).unwrap_or_default()
    }

    /// The values of some receivers: those for which `kept` is true.
    pub fn select(&self, kept: &[bool]) -> TileValues {
        let rows: Vec<usize> = (0..self.receivers).filter(|row| kept.get(*row) == Some(&true)).collect();
        let mut out = TileValues::zeros(self.components, rows.len(), self.labels);
        for component in 0..self.components {
            for (to, &from) in rows.iter().enumerate() {
                out.row_mut(component, to).copy_from_slice(self.row(component, from));
            }
        }
        out
    }

    pub fn receivers(&self) -> usize {
        self.receivers
    }

    pub fn labels(&self) -> usize {
        self.labels
    }
}

/// Rounds sums; what is below 0 by the error of a texture is 0.
pub(super) fn put(sums: &[f64], out: &mut [f32]) {
    out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum.max(0.0) as f32);
}
