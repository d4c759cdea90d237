//! Estimates. In: sums of batches. Out: means and their standard errors.

use crate::settings::Effect;

/// Number of batches of a receiver's paths, each with a random shift of its own.
pub const BATCHES: usize = 16;

/// Number of the components, in the order of results, with their total.
pub const PARTS: usize = 7;

/// Number of effects, in the order of [`Effect::ALL`].
const EFFECTS: usize = Effect::ALL.len();

/// Sums of a batch: the six components, then the change of the total by each effect.
pub(super) type Batch = [f64; PARTS - 1 + EFFECTS];

/// Returns the place of an effect in a batch.
pub(super) fn lane(effect: Effect) -> usize {
    PARTS - 1 + effect as usize
}

/// Irradiance of a receiver under one condition, W/m2; under a year, kWh/m2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReferenceLight {
    /// Means of the six components and the total.
    pub mean: [f64; PARTS],
    /// Standard errors of the components and the total.
    pub error: [f64; PARTS],
    /// Loss of the total without each effect of [`Effect::ALL`]. For canopies it is the gain.
    pub by_effect: [f64; EFFECTS],
    /// Standard errors of [`ReferenceLight::by_effect`].
    pub by_effect_error: [f64; EFFECTS],
    /// Total by the number of matt surfaces that reflected the light: none, one, more.
    pub by_reflections: [f64; 3],
    /// Standard errors of [`ReferenceLight::by_reflections`].
    pub by_reflections_error: [f64; 3],
}

impl ReferenceLight {
    /// Creates the estimate from means of batches.
    pub(super) fn new(batches: &[Batch; BATCHES]) -> Self {
        let mut reference = ReferenceLight::default();
        for part in 0..PARTS {
            let value = |batch: &Batch| if part < PARTS - 1 { batch[part] } else { batch[..PARTS - 1].iter().sum() };
            (reference.mean[part], reference.error[part]) = mean_and_error(&batches.each_ref().map(value));
        }
        for effect in Effect::ALL {
            let values = batches.each_ref().map(|batch| batch[lane(effect)]);
            (reference.by_effect[effect as usize], reference.by_effect_error[effect as usize]) =
                mean_and_error(&values);
        }
        for reflections in 0..3 {
            let values = batches.each_ref().map(|batch| by_reflections(batch)[reflections]);
            (reference.by_reflections[reflections], reference.by_reflections_error[reflections]) =
                mean_and_error(&values);
        }
        reference
    }
}

/// Returns the total of a batch by the number of matt surfaces that reflected the light: none, one,
/// more.
fn by_reflections(batch: &Batch) -> [f64; 3] {
    let (matt, again) = (batch[lane(Effect::Diffuse)], batch[lane(Effect::Bounces)]);
    [batch[..PARTS - 1].iter().sum::<f64>() - matt, matt - again, again]
}

fn mean_and_error(values: &[f64; BATCHES]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / BATCHES as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / ((BATCHES - 1) * BATCHES) as f64).sqrt())
}
