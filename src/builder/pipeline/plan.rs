//! What is to be built: settings, and what is known of their error.

use crate::settings::BuildSettings;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::error::Result;

/// What will be built: settings, and what is known of their error.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is traced, how finely, and what is left out.
    pub settings: BuildSettings,
    /// What the settings are known to be off by, for the manifest.
    pub accuracy: Option<Accuracy>,
    /// Why effects are left out, if that rests on some weather; for the manifest.
    pub negligible: Option<Negligible>,
    /// Whether the archive holds the scene's triangles, for those who look at it.
    pub with_scene: bool,
}

impl Plan {
    /// Settings whose error nobody has estimated; with the scene.
    pub fn of(settings: BuildSettings) -> Self {
        Plan { settings, accuracy: None, negligible: None, with_scene: true }
    }

    /// Names what a build writes: one of another plan does not go on with it.
    pub fn hash(&self) -> Result<[u8; 32]> {
        let settings = self.settings.hash()?;
        Ok(if self.with_scene {
            settings
        } else {
            *blake3::hash(&[&settings[..], b"without scene"].concat()).as_bytes()
        })
    }
}
