//! Irradiance of a tile of receivers: the six components and their total, as recombination gives and outputs take them.

/// Value columns, in the order of [`TileValues`]; W/m2 means. Sums add [`SUM_SUFFIX`].
pub const COMPONENTS: [&str; 7] =
    ["sun_direct", "sky_direct", "sun_diffuse", "sky_diffuse", "sun_specular", "sky_specular", "total"];

/// Values of one tile: `[component][receiver][label]`, row-major, components as in [`COMPONENTS`].
#[derive(Clone, Debug, PartialEq)]
pub struct TileValues {
    values: Vec<f32>,
    receivers: usize,
    labels: usize,
}

impl TileValues {
    /// Zeros for a number of receivers and labels.
    pub fn new(receivers: usize, labels: usize) -> Self {
        TileValues { values: vec![0.0; COMPONENTS.len() * receivers * labels], receivers, labels }
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

    pub fn receivers(&self) -> usize {
        self.receivers
    }

    pub fn labels(&self) -> usize {
        self.labels
    }
}
