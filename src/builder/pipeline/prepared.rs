//! Scene ready for rays. In: a scene. Out: its tree, its mirrors and its canopies.

use std::time::Instant;

use crate::settings::{BuildSettings, Effect};
use crate::trace::Tracer;
use crate::trace::canopy::Canopies;
use heliotile_core::error::Result;
use heliotile_scene::Scene;
use heliotile_scene::mirrors::Mirrors;

/// Scene with all that does not depend on settings.
pub struct PreparedScene<'a> {
    /// Scene as it was loaded.
    pub scene: &'a Scene,
    /// Tracer of the opaque triangles.
    pub(crate) tracer: Tracer,
    pub(crate) canopies: Option<Canopies<'a>>,
    pub(crate) mirrors: Mirrors,
    pub(super) seconds: f64,
}

impl<'a> PreparedScene<'a> {
    /// Builds the tree and finds the mirrors.
    pub fn new(scene: &'a Scene) -> Result<Self> {
        let start = Instant::now();
        let (tracer, canopies) = Canopies::split(scene);
        let mirrors = Mirrors::find(&scene.mesh, &scene.materials)?;
        Ok(PreparedScene { scene, tracer, canopies, mirrors, seconds: start.elapsed().as_secs_f64() })
    }

    /// Returns true if there are mirrors and they are to be traced.
    pub(super) fn reflects(&self, settings: &BuildSettings) -> bool {
        !self.mirrors.is_empty() && !settings.left_out.contains(Effect::Mirrors)
    }
}
