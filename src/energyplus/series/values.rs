//! Values of the series for each surface and step. In: the light of the surface with all
//! surroundings, and of the model alone. Out: the light that is added as if from the ground, and
//! the factor by which windows multiply the light that EnergyPlus gives them itself.
//!
//! EnergyPlus lights the model alone, U. The light with all surroundings is T. To arrive at T, the
//! light reflected + sky_T - sky_U + sun_T - sun_U is added; it is below 0 where surroundings take
//! more away than they reflect. Sun that falls through windows has a direction, so there m = sun_T
//! / sun_U multiplies all light, and what m takes from the sky is given back.

/// Smallest multiplier of windows: below it nothing would be left to multiply.
const MIN_MULTIPLIER: f64 = 0.001;

/// Sun on the model alone below which it counts as no sun, W/m2.
const NO_SUN_W_M2: f64 = 0.5;

/// Light of one step, W/m2. Fields `alone_...` are of the model alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepLight {
    pub reflected: f64,
    pub sky: f64,
    pub sun: f64,
    /// Sky light on the model alone.
    pub alone_sky: f64,
    pub alone_sun: f64,
}

impl StepLight {
    /// Returns the factor by which a window multiplies its light.
    pub fn multiplier(&self) -> f64 {
        if self.alone_sun < NO_SUN_W_M2 { 1.0 } else { (self.sun / self.alone_sun).clamp(MIN_MULTIPLIER, 1.0) }
    }

    /// Returns the light to add as if from the ground before a window multiplies it, W/m2; opaque
    /// surfaces multiply by 1.
    pub fn added_before(&self, multiplier: f64) -> f64 {
        let after = self.reflected + self.sky - multiplier * self.alone_sky + self.sun - multiplier * self.alone_sun;
        after / multiplier.max(MIN_MULTIPLIER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall in half of 400 W/m2 of sun and half of 100 of sky that gets 30 by reflection has -220
    /// added. A window there multiplies by 0.5 and has 60 added before, so that 0.5
    /// (400 + 100 + 60) = 280 = 30 + 50 + 200. Without sun nothing is multiplied.
    #[test]
    fn half_a_sun_is_subtracted_or_multiplied() {
        let light = StepLight { reflected: 30.0, sky: 50.0, sun: 200.0, alone_sky: 100.0, alone_sun: 400.0 };
        assert_eq!((light.added_before(1.0), light.multiplier(), light.added_before(0.5)), (-220.0, 0.5, 60.0));
        let dull = StepLight { sun: 0.0, alone_sun: 0.0, ..light };
        assert_eq!((dull.multiplier(), dull.added_before(1.0)), (1.0, -20.0));
        assert_eq!(StepLight { sun: 0.0, ..light }.multiplier(), 0.001);
    }
}
