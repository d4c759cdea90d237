//! What a path carries. In: surfaces and canopies that it meets. Out: shares of a receiver's components, and of what effects change.

use super::estimate::{Batch, lane};
use crate::settings::Effect;
use heliotile_core::replay::components::Component;

/// What a path carries to its receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// Irradiance of the receiver for a radiance of 1 / pi from here.
    weight: f64,
    /// The same if there were no canopies.
    bare: f64,
    /// Matt surfaces on the way.
    pub matt: u32,
    mirrored: bool,
    by_leaves: bool,
}

impl Carried {
    /// At the receiver.
    pub const START: Carried = Carried { weight: 1.0, bare: 1.0, matt: 0, mirrored: false, by_leaves: false };

    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Carried { weight: self.weight * factor, bare: self.bare * factor, ..self }
    }

    /// Behind canopies that let so much through.
    #[must_use]
    pub fn through(self, through: f64) -> Self {
        Carried { weight: self.weight * through, ..self }
    }

    #[must_use]
    pub fn reflected(self) -> Self {
        Carried { matt: self.matt + 1, ..self }
    }

    /// Scattered by a leaf, which would not be there without canopies.
    #[must_use]
    pub fn scattered(self) -> Self {
        Carried { by_leaves: true, bare: 0.0, ..self.reflected() }
    }

    #[must_use]
    pub fn mirrored(self) -> Self {
        Carried { mirrored: true, ..self }
    }

    /// Adds light of the sun or the sky to the sums of a batch.
    pub fn add(self, of_sun: bool, light: f64, sums: &mut Batch) {
        let [direct, specular, diffuse] = match of_sun {
            true => [Component::SunDirect, Component::SunSpecular, Component::SunDiffuse],
            false => [Component::SkyDirect, Component::SkySpecular, Component::SkyDiffuse],
        };
        let component = match self.matt {
            0 if self.mirrored => specular,
            0 => direct,
            _ => diffuse,
        };
        let added = self.weight * light;
        sums[component as usize] += added;
        let mut count = |effect: Effect, takes_part: bool, change: f64| {
            if takes_part {
                sums[lane(effect)] += change;
            }
        };
        count(Effect::Diffuse, self.matt > 0, added);
        count(Effect::Bounces, self.matt > 1, added);
        count(Effect::Mirrors, self.mirrored, added);
        count(Effect::Leaves, self.by_leaves, added);
        count(Effect::Canopies, self.bare != self.weight, (self.bare - self.weight) * light);
    }
}
