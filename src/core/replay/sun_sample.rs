//! Positions of the sun that contribute to results. In: conditions and their bins. Out: directions
//! and strengths.

use glam::DVec3;
use rayon::prelude::*;

use crate::sky::model::SkyModel;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Position of the sun that contributes to a result.
#[derive(Clone, Copy, Debug)]
pub struct SunSample {
    /// Number of the result.
    pub bin: usize,
    /// Normal irradiance x [`Condition::scale`] x share of the time x share that clouds let through
    /// x weight in the result.
    pub strength: f64,
    /// Direction of the middle of the disc.
    pub direction: DVec3,
}

impl SunSample {
    /// Returns the suns of all conditions with DNI, in the order of the conditions.
    pub fn of_suns(conditions: &[Condition], bins: &Bins) -> Vec<SunSample> {
        SunSample::new(conditions, bins, |c| c.dni_w_m2 * c.scale.sun)
    }

    /// Returns the circumsolar light of a model's skies as suns at the positions of the sun, in the
    /// order of the conditions. Most models have none.
    pub fn of_circumsolar(conditions: &[Condition], bins: &Bins, model: SkyModel) -> Vec<SunSample> {
        let conditions = if model.brightens() { conditions } else { &[] };
        SunSample::new(conditions, bins, |c| model.parts(c).circumsolar_w_m2 * c.scale.sky)
    }

    fn new(conditions: &[Condition], bins: &Bins, normal_w_m2: impl Fn(&Condition) -> f64 + Sync) -> Vec<SunSample> {
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
