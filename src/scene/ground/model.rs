//! The ground of an EnergyPlus model: an endless plane that no surface of the file draws. In: what the file states. Out: where it lies and
//! what it reflects, month by month.

/// Default of `Site:GroundReflectance` (Input Output Reference); Liu and Jordan (1963) introduced it.
pub const USUAL: f64 = 0.2;

/// What an EnergyPlus model says of its ground.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModelGround {
    /// Where the plane lies; in coordinates of the file until its part is placed, metres.
    pub elevation_m: f64,
    /// January to December, each 0 to 1.
    pub reflectance: [f64; 12],
    /// Factor while snow lies, 0 or more.
    pub snow_modifier: f64,
    /// Whether the file says so; the default of EnergyPlus if not.
    pub stated: bool,
}

impl ModelGround {
    /// Of a model that states nothing.
    pub(crate) fn usual(elevation_m: f64) -> Self {
        ModelGround { elevation_m, reflectance: [USUAL; 12], snow_modifier: 1.0, stated: false }
    }

    /// Whether months or snow matter.
    pub(crate) fn changes(&self) -> bool {
        self.snow_modifier != 1.0 || self.reflectance.iter().any(|value| *value != self.reflectance[0])
    }

    /// What it reflects, in words.
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
