//! What is to be built: settings, and what is known of their error.

use crate::settings::BuildSettings;
use heliotile_core::archive::accuracy::Accuracy;

/// What will be built: settings, and what is known of their error.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is traced, how finely, and what is left out.
    pub settings: BuildSettings,
    /// What the settings are known to be off by, for the manifest.
    pub accuracy: Option<Accuracy>,
}

impl Plan {
    /// Settings whose error nobody has estimated.
    pub fn of(settings: BuildSettings) -> Self {
        Plan { settings, accuracy: None }
    }
}
