//! Plan of a build. In: settings and estimates of their error. Out: a hash that identifies the
//! work.

use crate::settings::BuildSettings;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::error::Result;

/// Plan of a build: settings, and estimates of their error.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Settings, with the effects that are left out.
    pub settings: BuildSettings,
    /// Estimated error of the settings, for the manifest; `None` if there is no estimate.
    pub accuracy: Option<Accuracy>,
    /// Reason why effects are left out, if it rests on some weather; for the manifest.
    pub negligible: Option<Negligible>,
    /// True if the archive holds the scene's triangles, for viewers.
    pub with_scene: bool,
}

impl Plan {
    /// Creates a plan with the scene and without an estimate of the error.
    pub fn new(settings: BuildSettings) -> Self {
        Plan { settings, accuracy: None, negligible: None, with_scene: true }
    }

    /// Returns the hash of what a build writes. A build with another plan cannot resume it.
    pub fn hash(&self) -> Result<[u8; 32]> {
        let settings = self.settings.hash()?;
        Ok(match self.with_scene {
            true => settings,
            false => *blake3::hash(&[&settings[..], b"without scene"].concat()).as_bytes(),
        })
    }
}
