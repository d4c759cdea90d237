//! Estimates. In: sums of batches. Out: means and their standard errors.

/// Batches that a receiver's paths are drawn in, each with a shift of its own.
pub const BATCHES: usize = 16;

/// The six components, in the order of results, and their total.
pub const PARTS: usize = 7;

/// Irradiance of a receiver under one condition, W/m2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Judged {
    /// The six components and the total.
    pub mean: [f64; PARTS],
    /// Standard errors of these.
    pub error: [f64; PARTS],
}

impl Judged {
    /// Of means of batches.
    pub(super) fn of(batches: &[[f64; 6]; BATCHES]) -> Self {
        let mut judged = Judged::default();
        for part in 0..PARTS {
            let value = |batch: &[f64; 6]| if part < 6 { batch[part] } else { batch.iter().sum() };
            let mean = batches.iter().map(value).sum::<f64>() / BATCHES as f64;
            let squares: f64 = batches.iter().map(|batch| (value(batch) - mean).powi(2)).sum();
            judged.mean[part] = mean;
            judged.error[part] = (squares / ((BATCHES - 1) * BATCHES) as f64).sqrt();
        }
        judged
    }
}
