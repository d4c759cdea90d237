//! What is to be built: settings, and what is known of their error.

use crate::settings::BuildSettings;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::negligible::Negligible;

/// What will be built: settings, and what is known of their error.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is traced, how finely, and what is left out.
    pub settings: BuildSettings,
    /// What the settings are known to be off by, for the manifest.
    pub accuracy: Option<Accuracy>,
    /// Why effects are left out, if that rests on some weather; for the manifest.
    pub negligible: Option<Negligible>,
}

impl Plan {
    /// Settings whose error nobody has estimated.
    pub fn of(settings: BuildSettings) -> Self {
        Plan { settings, accuracy: None, negligible: None }
    }
}
