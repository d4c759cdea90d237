//! Scene with settings, ready to trace receivers and cells: the shared state of all stages of a
//! build.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use super::Workspace;
use super::layer_cache::LayerCache;
use super::prepared::PreparedScene;
use super::previous_build::PreviousBuild;
use crate::settings::{BuildSettings, Effect};
use crate::trace::Tracer;
use crate::trace::canopy::Canopies;
use crate::trace::mirror::Reflections;
use crate::trace::surface::CellSurfaces;
use heliotile_archives::writing::Writer;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::reflector::Reflector;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_core::opened::SiteFacts;
use heliotile_scene::Scene;

/// Shared state of all stages of a build.
pub(super) struct SiteTracer<'a> {
    pub scene: &'a Scene,
    /// Tracer of the opaque triangles.
    pub tracer: &'a Tracer,
    /// `[material]`: its reflector.
    pub reflectors: Vec<Reflector>,
    pub canopies: Option<&'a Canopies<'a>>,
    pub settings: &'a BuildSettings,
    /// Folder of temporary files.
    pub folder: PathBuf,
    pub memory: MemoryBudget,
    /// Facts of the site that are known before the archive is complete.
    pub facts: Arc<SiteFacts>,
    pub known: LayerCache<'a>,
    /// Archive of the scene before it was changed.
    pub before: Option<PreviousBuild<'a>>,
    /// Tracer of mirrors; `None` if there are none.
    pub reflections: Option<Reflections<'a>>,
    /// Largest shares of light that were lost behind the last mirror followed, as bits of an f64:
    /// of a receiver's light, of a cell's.
    pub lost: [AtomicU64; 2],
    pub observer: &'a dyn Observer,
}

impl<'a> SiteTracer<'a> {
    pub fn new(
        ready: &'a PreparedScene<'a>,
        settings: &'a BuildSettings,
        workspace: &Workspace,
        observer: &'a dyn Observer,
        facts: SiteFacts,
        known: LayerCache<'a>,
        before: Option<PreviousBuild<'a>>,
    ) -> Self {
        let scene = ready.scene;
        let reflections =
            ready.reflects(settings).then(|| Reflections::new(&scene.mesh, &ready.tracer, &ready.mirrors));
        let canopies = ready.canopies.as_ref().filter(|_| !settings.left_out.contains(Effect::Canopies));
        SiteTracer {
            scene,
            reflectors: scene.materials.iter().map(Reflector::new).collect(),
            tracer: &ready.tracer,
            settings,
            folder: workspace.folder.clone(),
            memory: workspace.memory,
            facts: Arc::new(facts),
            known,
            before,
            reflections,
            lost: Default::default(),
            canopies,
            observer,
        }
    }

    /// Returns the surfaces that cells lie on.
    pub fn surfaces(&self) -> CellSurfaces<'_> {
        let canopies = self.canopies.map(|canopies| (canopies.tracer(), canopies.volumes()));
        CellSurfaces { mesh: &self.scene.mesh, tracer: self.tracer, canopies }
    }

    /// Returns true if an effect is to be traced where the scene has it.
    pub fn traces(&self, effect: Effect) -> bool {
        let left_out = self.settings.left_out;
        !(left_out.contains(effect) || effect == Effect::Bounces && left_out.contains(Effect::Diffuse))
    }

    /// Writes a checkpoint if one is due, and ends the build if the user stopped it.
    pub fn checkpoint(&self, writer: &mut Writer) -> Result<()> {
        if !self.observer.cancelled() {
            return if writer.due() { writer.checkpoint() } else { Ok(()) };
        }
        writer.checkpoint()?;
        let what = match writer.committed() {
            Some(done) => format!("after {} blocks of {:.1} MB", done.blocks, done.bytes as f64 / 1e6),
            None => "before anything was written".into(),
        };
        Err(Error::Stopped { what })
    }
}
