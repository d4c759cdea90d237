//! Positions of the sun as results feel them. In: conditions and where they add to. Out: directions
//! and strengths.

use glam::DVec3;
use rayon::prelude::*;

use crate::sky::model::SkyModel;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// A sun that samples on a result.
#[derive(Clone, Copy, Debug)]
pub struct SunSample {
    /// Result.
    pub bin: usize,
    /// Irradiance normal to it x [`Condition::scale`] x share of the time x what clouds let through
    /// x weight in the result.
    pub strength: f64,
    /// Of its middle.
    pub direction: DVec3,
}

impl SunSample {
    /// Suns of all conditions with DNI, in their order.
    pub fn of_suns(conditions: &[Condition], bins: &Bins) -> Vec<SunSample> {
        SunSample::of(conditions, bins, |c| c.dni_w_m2 * c.scale.sun)
    }

    /// The same for the light that a model's skies send from where the suns are; most have none.
    pub fn of_circumsolar(conditions: &[Condition], bins: &Bins, model: SkyModel) -> Vec<SunSample> {
        let conditions = if model.brightens() { conditions } else { &[] };
        SunSample::of(conditions, bins, |c| model.parts(c).circumsolar_w_m2 * c.scale.sky)
    }

    fn of(conditions: &[Condition], bins: &Bins, normal_w_m2: impl Fn(&Condition) -> f64 + Sync) -> Vec<SunSample> {
        let strong = conditions.par_iter().map(|c| (c, normal_w_m2(c))).zip(&bins.of_condition);
        let lit = strong.filter(|((_, normal_w_m2), (_, weight))| *normal_w_m2 > 0.0 && *weight != 0.0);
        let suns = lit.flat_map_iter(|((c, normal_w_m2), &(bin, weight))| {
            c.suns.iter().filter(|instant| instant.sun.z > 0.0).map(move |instant| {
                let strength = normal_w_m2 * instant.lit() * weight;
                SunSample { bin, strength, direction: instant.sun }
            })
        });
        suns.collect()
    }
}
