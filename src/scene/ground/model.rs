//! The ground of an EnergyPlus model: an endless plane that no surface of the file draws. In: the
//! statements of the file. Out: the height of the plane, and its reflectance month by month.

/// Usual ground reflectance: the default of `Site:GroundReflectance` (Input Output Reference); Liu
/// and Jordan (1963) introduced it.
pub const USUAL: f64 = 0.2;

/// Ground of an EnergyPlus model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModelGround {
    /// Height of the plane, metres; in coordinates of the file until its part is placed.
    pub elevation_m: f64,
    /// Reflectances from January to December, each 0 to 1.
    pub reflectance: [f64; 12],
    /// Factor of the reflectance while snow lies, 0 or more.
    pub snow_modifier: f64,
    /// True if the file states the ground; false for the default of EnergyPlus.
    pub stated: bool,
}

impl ModelGround {
    /// Returns the ground of a model that states none.
    pub(crate) fn usual(elevation_m: f64) -> Self {
        ModelGround { elevation_m, reflectance: [USUAL; 12], snow_modifier: 1.0, stated: false }
    }

    /// Returns true if the reflectance depends on the month or on snow.
    pub(crate) fn changes(&self) -> bool {
        self.snow_modifier != 1.0 || self.reflectance.iter().any(|value| *value != self.reflectance[0])
    }

    /// Returns the reflectance in words.
    pub(crate) fn words(&self) -> String {
        let (low, high) = self.reflectance.iter().fold((1.0_f64, 0.0_f64), |(l, h), &r| (l.min(r), h.max(r)));
        let mut words = match low == high {
            true => format!("reflects {low}"),
            false => format!("reflects {low} to {high} by month"),
        };
        if self.snow_modifier != 1.0 {
            words += &format!(", times {} under snow", self.snow_modifier);
        }
        words
    }
}
