//! Longwave irradiance of receivers. In: emission of sky, ground and obstructions in each
//! condition, and the shares of a receiver's hemisphere that each of them fills. Out: W/m2, or sums
//! over periods.
//!
//! Surfaces are black: they emit sigma T^4 and reflect nothing. The sky is isotropic. A ray that
//! meets nothing points below the horizon, where the scene ends; its share counts as ground.

use std::path::Path;

use crate::error::{Error, Result};
use crate::weather::conditions::Condition;
use crate::weather::emission::Emission;
use crate::weather::time::bins::Bins;

/// Emissions of the results of a replay.
pub struct Longwave {
    /// `[result]`: sky, ground, obstructions.
    sums: Vec<[f64; 3]>,
}

impl Longwave {
    /// Adds up the emissions of conditions. A condition without an emission is an error, whose
    /// message names `archive`.
    pub fn new(conditions: &[Condition], bins: &Bins, archive: &Path) -> Result<Self> {
        let mut sums = vec![[0.0; 3]; bins.count];
        for (condition, &(bin, weight)) in conditions.iter().zip(&bins.of_condition) {
            let Some(Emission { sky_w_m2, ground_w_m2, obstruction_w_m2 }) = condition.emission else {
                let what = format!("condition `{}` has no infrared radiation and no temperatures", condition.label);
                let hint = "leave out the column `longwave`, or replay a weather file, which has them";
                return Err(Error::input(archive, None, what, hint));
            };
            if let Some(sum) = sums.get_mut(bin) {
                let parts = [sky_w_m2, ground_w_m2, obstruction_w_m2];
                sum.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part * weight);
            }
        }
        Ok(Longwave { sums })
    }

    /// Computes the irradiance of a receiver for each result. `views` are the shares of its
    /// hemisphere that are sky, ground and obstructions.
    pub fn irradiance(&self, views: [f32; 3], out: &mut [f32]) {
        let [sky, _, obstruction] = views.map(f64::from);
        // The ground takes the share of rays that meet nothing. The shares are rounded, so their
        // sum may be a little above 1.
        let ground = (1.0 - sky - obstruction).max(0.0);
        for (out, [of_sky, of_ground, of_obstruction]) in out.iter_mut().zip(&self.sums) {
            *out = (sky * of_sky + ground * of_ground + obstruction * of_obstruction) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn condition(emission: Option<[f64; 3]>) -> Condition {
        let of =
            |[sky_w_m2, ground_w_m2, obstruction_w_m2]: [f64; 3]| Emission { sky_w_m2, ground_w_m2, obstruction_w_m2 };
        let dark = Condition::new("midnight".into(), &[], DVec3::NEG_Z, 0.0, 0.0);
        Condition { emission: emission.map(of), ..dark }
    }

    /// Shares of 0.5, 0.2 and 0.2 give 0.5 x 300 + 0.3 x 400 + 0.2 x 500 = 370 W/m2: the tenth that
    /// meets nothing is ground. Two hours of 300 and 100 W/m2 from the sky alone sum to 0.4 kWh/m2.
    /// Shares that sum to a little more than 1 leave the ground at 0 or above.
    #[test]
    fn the_share_that_meets_nothing_is_ground() {
        let (day, night) = (condition(Some([300.0, 400.0, 500.0])), condition(Some([100.0, 400.0, 500.0])));
        let file = Path::new("a.helio");
        let get = |bins: &Bins, views| {
            let mut out = vec![0.0; bins.count];
            let both = [day.clone(), night.clone()];
            Longwave::new(&both, bins, file).expect("emissions").irradiance(views, &mut out);
            out
        };
        let hours = get(&Bins::each(2), [0.5, 0.2, 0.2]);
        assert!((hours[0] - 370.0).abs() < 1e-4 && (hours[1] - 270.0).abs() < 1e-4, "{hours:?}");
        let sum = Bins { count: 1, of_condition: vec![(0, 1e-3); 2] };
        assert_eq!(get(&sum, [1.0, 0.0, 0.0]), [0.4]);
        let over = get(&Bins::each(2), [0.75, 0.0, 0.250_000_1]);
        assert!((over[0] - 350.0).abs() < 1e-3, "{over:?}");
    }

    /// A condition without an emission is refused by its name, 1 of 2.
    #[test]
    fn a_condition_without_emission_is_refused_by_name() {
        let conditions = [condition(Some([1.0; 3])), condition(None)];
        let text = Longwave::new(&conditions, &Bins::each(2), Path::new("a.helio")).err().map(|e| e.to_string());
        assert!(text.is_some_and(|t| t.contains("a.helio: condition `midnight` has no infrared")));
    }
}
