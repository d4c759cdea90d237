//! Irradiance of a tile of receivers: the six components, their total and what else is asked for, as recombination gives and
//! outputs take them.

use crate::replay::components::Component;

/// Values of one tile: `[component][receiver][label]`, row-major, components in the order of their numbers. All components have a place,
/// and those that nobody asks for are zero: pages that are never written take no memory.
#[derive(Clone, Debug, PartialEq)]
pub struct TileValues {
    values: Vec<f32>,
    receivers: usize,
    labels: usize,
}

impl TileValues {
    /// Zeros for all components and a number of receivers and labels.
    pub fn new(receivers: usize, labels: usize) -> Self {
        TileValues { values: vec![0.0; Component::COUNT * receivers * labels], receivers, labels }
    }

    /// `[receiver][label]` of a component.
    pub fn component(&self, component: Component) -> &[f32] {
        let size = self.receivers * self.labels;
        &self.values[component as usize * size..][..size]
    }

    /// `[receiver][label]` of a component, to be filled.
    pub fn component_mut(&mut self, component: Component) -> &mut [f32] {
        let size = self.receivers * self.labels;
        &mut self.values[component as usize * size..][..size]
    }

    /// `[label]` of a component at a receiver of the tile.
    pub fn row(&self, component: Component, receiver: usize) -> &[f32] {
        let labels = self.labels;
        &self.component(component)[receiver * labels..][..labels]
    }

    /// `[label]` of a component at a receiver of the tile, to be filled.
    pub fn row_mut(&mut self, component: Component, receiver: usize) -> &mut [f32] {
        let labels = self.labels;
        &mut self.component_mut(component)[receiver * labels..][..labels]
    }

    /// The values of some receivers: those for which `kept` is true.
    pub fn select(&self, kept: &[bool]) -> TileValues {
        let rows: Vec<usize> = (0..self.receivers).filter(|row| kept.get(*row) == Some(&true)).collect();
        let mut out = TileValues::new(rows.len(), self.labels);
        for component in Component::ALL.into_iter().chain(Component::FURTHER) {
            for (to, &from) in rows.iter().enumerate() {
                out.row_mut(component, to).copy_from_slice(self.row(component, from));
            }
        }
        out
    }

    /// Number of receivers, the second axis.
    pub fn receivers(&self) -> usize {
        self.receivers
    }

    /// Number of labels, the third axis: conditions, or bins of sums.
    pub fn labels(&self) -> usize {
        self.labels
    }
}

/// Rounds sums; what is below 0 by the error of a texture is 0.
pub(super) fn put(sums: &[f64], out: &mut [f32]) {
    out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum.max(0.0) as f32);
}
