//! Results that conditions add to: one each, or sums over days, months or years. Light is linear in
//! its sources, so a sum over hours of sky light is the light of the summed sky.

/// Results that conditions add to, with weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins {
    /// Number of results.
    pub count: usize,
    /// `[condition]`: number of its result, below `count`, and the weight of its mean irradiance
    /// there: 1, or hours / 1000 for kWh/m2.
    pub of_condition: Vec<(usize, f64)>,
}

impl Bins {
    /// Returns a result of its own for every condition, with weight 1.
    pub fn each(conditions: usize) -> Self {
        Bins { count: conditions, of_condition: (0..conditions).map(|i| (i, 1.0)).collect() }
    }
}
