//! Irradiance of a tile of receivers: the six components, their total and further requested
//! columns, between replays and outputs.

use std::sync::{Arc, Mutex, PoisonError};

use crate::replay::components::Component;

/// Values of one tile: `[component][receiver][bin]`, row-major, components in the order of their
/// numbers. All components have a place. Components that are not requested are zero: pages that are
/// never written take no memory.
#[derive(Clone, Debug)]
pub struct TileValues {
    values: Vec<f32>,
    receivers: usize,
    bins: usize,
    /// Bits of the components that may not be zero.
    written: u32,
    /// Store that takes the memory back when the values are dropped.
    home: Option<Arc<Spares>>,
}

impl PartialEq for TileValues {
    fn eq(&self, other: &Self) -> bool {
        (self.receivers, self.bins, &self.values) == (other.receivers, other.bins, &other.values)
    }
}

/// Memory of dropped tiles, each with the bits of the components that may not be zero. With results
/// for each hour, fresh pages would cost a quarter of the time.
#[derive(Debug, Default)]
pub(super) struct Spares(Mutex<Vec<(Vec<f32>, u32)>>);

impl Spares {
    /// Takes memory for exactly `len` values, set to zero, if there is any.
    fn take(&self, len: usize) -> Option<Vec<f32>> {
        let (mut values, written) = {
            let mut spares = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let place = spares.iter().position(|(values, _)| values.len() == len)?;
            spares.swap_remove(place)
        };
        let columns = values.chunks_mut((len / Component::COUNT).max(1)).enumerate();
        columns.filter(|(i, _)| written >> i & 1 == 1).for_each(|(_, column)| column.fill(0.0));
        Some(values)
    }
}

impl Drop for TileValues {
    fn drop(&mut self) {
        if let Some(home) = &self.home {
            let spare = (std::mem::take(&mut self.values), self.written);
            home.0.lock().unwrap_or_else(PoisonError::into_inner).push(spare);
        }
    }
}

impl TileValues {
    /// Returns zeros for all components and a number of receivers and bins.
    pub fn new(receivers: usize, bins: usize) -> Self {
        let values = vec![0.0; Component::COUNT * receivers * bins];
        TileValues { values, receivers, bins, written: 0, home: None }
    }

    /// Returns zeros in memory that is taken from a store, and goes back to it on drop.
    pub(super) fn from_spares(home: &Arc<Spares>, receivers: usize, bins: usize) -> Self {
        let len = Component::COUNT * receivers * bins;
        let values = home.take(len).unwrap_or_else(|| vec![0.0; len]);
        TileValues { values, receivers, bins, written: 0, home: Some(Arc::clone(home)) }
    }

    /// Returns `[receiver][bin]` of a component.
    pub fn component(&self, component: Component) -> &[f32] {
        let size = self.receivers * self.bins;
        &self.values[component as usize * size..][..size]
    }

    /// Returns `[receiver][bin]` of a component to be filled.
    pub fn component_mut(&mut self, component: Component) -> &mut [f32] {
        let size = self.receivers * self.bins;
        self.written |= 1 << component as u32;
        &mut self.values[component as usize * size..][..size]
    }

    /// Returns `[bin]` of a component at a receiver of the tile.
    pub fn row(&self, component: Component, receiver: usize) -> &[f32] {
        let bins = self.bins;
        &self.component(component)[receiver * bins..][..bins]
    }

    /// Returns `[bin]` of a component at a receiver of the tile to be filled.
    pub fn row_mut(&mut self, component: Component, receiver: usize) -> &mut [f32] {
        let bins = self.bins;
        &mut self.component_mut(component)[receiver * bins..][..bins]
    }

    /// Returns the values of the receivers for which `kept` is true.
    pub fn select(&self, kept: &[bool]) -> TileValues {
        let rows: Vec<usize> = (0..self.receivers).filter(|row| kept.get(*row) == Some(&true)).collect();
        let mut out = TileValues::new(rows.len(), self.bins);
        for component in Component::every() {
            for (to, &from) in rows.iter().enumerate() {
                out.row_mut(component, to).copy_from_slice(self.row(component, from));
            }
        }
        out
    }

    /// Returns the number of receivers, the second axis.
    pub fn receivers(&self) -> usize {
        self.receivers
    }

    /// Returns the number of bins, the third axis: conditions, or bins of sums.
    pub fn bins(&self) -> usize {
        self.bins
    }
}

/// Rounds sums to f32. Sums below 0, by the error of a texture, become 0.
pub(super) fn put(sums: &[f64], out: &mut [f32]) {
    out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum.max(0.0) as f32);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 tiles that reuse memory of which 2 columns were written are zero wherever they are read,
    /// as a fresh tile is. A tile of another size has its own memory.
    #[test]
    fn reused_memory_reads_as_zero() {
        let home = Arc::new(Spares::default());
        for receivers in [3, 3, 3, 2] {
            let mut tile = TileValues::from_spares(&home, receivers, 5);
            assert_eq!(tile, TileValues::new(receivers, 5));
            tile.component_mut(Component::Total).fill(7.0);
            tile.row_mut(Component::SunDirect, 1).fill(f32::NAN);
        }
        assert_eq!(home.0.lock().expect("no thread failed").len(), 2);
    }
}
