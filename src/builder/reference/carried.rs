//! Throughput of a light path. In: surfaces and canopies that it meets. Out: additions to a
//! receiver's components, and to the changes by effects.

use super::estimate::{Batch, lane};
use crate::settings::Effect;
use heliotile_core::replay::components::Component;

/// Throughput of a path to its receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// Irradiance of the receiver for a radiance of 1 / pi from here.
    weight: f64,
    /// Weight if there were no canopies.
    bare: f64,
    /// Number of matt surfaces on the path.
    pub matt: u32,
    mirrored: bool,
    by_leaves: bool,
}

impl Carried {
    /// Throughput at the receiver.
    pub const START: Carried = Carried { weight: 1.0, bare: 1.0, matt: 0, mirrored: false, by_leaves: false };

    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Carried { weight: self.weight * factor, bare: self.bare * factor, ..self }
    }

    /// Returns the throughput behind canopies that let the share `through` pass.
    #[must_use]
    pub fn through(self, through: f64) -> Self {
        Carried { weight: self.weight * through, ..self }
    }

    #[must_use]
    pub fn reflected(self) -> Self {
        Carried { matt: self.matt + 1, ..self }
    }

    /// Returns the throughput after a leaf scattered the light; the leaf would be absent without
    /// canopies.
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
            true => [Component::SunDirect, Component::SunMirrored, Component::SunReflected],
            false => [Component::SkyDirect, Component::SkyMirrored, Component::SkyReflected],
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
