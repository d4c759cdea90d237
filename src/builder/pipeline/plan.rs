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
    /// Of a scene that was changed: keep what the change can alter by less than so many percent, see [`Preview`](heliotile_core::archive::preview::Preview).
    pub preview_percent: Option<f64>,
}

impl Plan {
    /// Settings whose error nobody has estimated; with the scene.
    pub fn of(settings: BuildSettings) -> Self {
        Plan { settings, accuracy: None, negligible: None, with_scene: true, preview_percent: None }
    }

    /// Names what a build writes: one of another plan does not go on with it.
    pub fn hash(&self) -> Result<[u8; 32]> {
        let settings = self.settings.hash()?;
        let mut more = if self.with_scene { Vec::new() } else { b"without scene".to_vec() };
        more.extend(self.preview_percent.into_iter().flat_map(f64::to_le_bytes));
        Ok(match more.is_empty() {
            true => settings,
            false => *blake3::hash(&[&settings[..], &more].concat()).as_bytes(),
        })
    }
}
