//! Update of an archive after edits of its scene. In: an archive that holds its scene, edits by the
//! names of objects, files that are added. Out: the archive of the edited scene; only light that
//! the edits can alter is traced.

mod receivers;
mod request;

use std::collections::BTreeSet;
use std::path::PathBuf;

use glam::DVec3;
use heliotile_archives::Workspace;
use heliotile_builder::held::{held_receivers, held_scene};
use heliotile_builder::pipeline::{Build, BuildReport, Output, Plan, PreparedScene, ReusedArchives, Start};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::memory::Use;
use heliotile_core::observer::{Observer, Tone};
use heliotile_core::opened::SiteSettings;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{counted, with_list};
use heliotile_files::writing::copy::folder_of;
use heliotile_files::writing::guards::{check_archive_name, guard_archive};
use heliotile_remote::places::open_archive;
use heliotile_results::horizon::black_below_horizon;
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::change::TracedScene;
use heliotile_scene::edit::EditedScene;
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::materials::materials_of;
use heliotile_scene::placing::plausible::far_objects;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;
use heliotile_scene::site::guard_site;
use receivers::{SceneStates, UpdatedReceivers, cover, usual_spacing};
pub use request::UpdateRequest;

/// Result of an update.
#[derive(Clone, Debug)]
pub struct UpdateDone {
    /// New archive.
    pub archive: PathBuf,
    /// Number of receivers that stay where they were.
    pub kept: usize,
    /// Number of receivers that moved with their object.
    pub moved: usize,
    /// Number of receivers that were removed with their object, or with its old shape.
    pub gone: usize,
    /// Names of receivers that are now inside an object or covered, and are left out.
    pub buried: Vec<String>,
    /// Number of receivers on new surfaces.
    pub new: usize,
    /// Report of the build.
    pub report: BuildReport,
}

impl UpdateDone {
    /// Returns a line of text about the receivers.
    pub fn text(&self) -> String {
        let moved = if self.moved > 0 { format!(", {} moved", self.moved) } else { String::new() };
        format!(
            "{}: {} kept{moved}, {} removed, {} left out, {} new\n",
            self.archive.display(),
            counted(self.kept as u64, "receiver"),
            self.gone,
            self.buried.len(),
            self.new
        )
    }
}

impl UpdateRequest {
    /// Writes the archive of the edited scene. Its bytes are those of a build from scratch with the
    /// same triangles and receivers.
    pub fn write(&self, resources: &Resources) -> Result<UpdateDone> {
        let observer = resources.observer;
        if self.edits.is_empty() && self.add.files.is_empty() {
            let hint = "give an edit with it, or with {remove}, {move}, {height} or {material}";
            return Err(Error::argument("add", "no edit is given", hint).because(Problem::Missing));
        }
        // No ground is assumed below what is added.
        let add = SceneRequest { no_ground: true, ..self.add.clone() };
        let added = if add.files.is_empty() { SceneFiles::default() } else { add.site()? };
        check_ranges(&self.cover)?;
        check_archive_name(&self.output)?;
        guard_site(&self.output, &added, &[Some(&self.before), self.add.materials.as_deref()])?;
        guard_archive(&self.output)?;
        let before = open_archive(&self.before, Access::Read)?;
        let held = held_scene(&before)?;
        let described = self.add.materials.as_deref().map(materials_of).transpose()?.unwrap_or_default();
        let mut edited = self.edits.apply(&held, &described, before.path())?;
        let new = self.add_files(&mut edited, &held, &before, &added, resources)?;
        if !edited.changed {
            observer.warn("the edits change nothing: the new archive is that of the same scene");
        }
        let scene = self.edited_scene(&edited, &held, &before)?;
        let states = SceneStates { held: &held, edited: &edited, scene: &scene };
        let after = self.receivers(&states, held_receivers(&before)?, new, observer)?;
        let report = self.build(&before, &scene, &after.receivers, resources)?;
        let UpdatedReceivers { kept, moved, gone, buried, new, .. } = after;
        Ok(UpdateDone { archive: self.output.clone(), kept, moved, gone, buried, new, report })
    }

    /// Returns the receivers that stay, and those on new objects or objects with another shape.
    fn receivers(
        &self,
        states: &SceneStates,
        held: Vec<Receiver>,
        mut new: ObjectTriangles,
        observer: &dyn Observer,
    ) -> Result<UpdatedReceivers> {
        let density = self.density.unwrap_or_else(|| usual_spacing(&held));
        let mut after = states.stay(held)?;
        if !after.buried.is_empty() {
            let (count, names) = (counted(after.buried.len() as u64, "receiver"), after.buried.iter().cloned());
            observer.warn(with_list(
                format!("{count} left out: the edits put them inside an object, or cover them"),
                names,
            ));
        }
        let numbers = states.numbers(states.edited.materials.iter().map(|material| material.name.as_str()));
        for material in &mut new.materials {
            *material = numbers.get(usize::from(*material)).copied().unwrap_or(u16::MAX);
        }
        for soup in [states.reshaped(), new] {
            let placed = cover(self, density, states.scene, soup, observer)?;
            after.new += placed.len();
            after.receivers.extend(placed);
        }
        let mut names: BTreeSet<&str> = BTreeSet::new();
        if let Some(twice) = after.receivers.iter().find(|receiver| !names.insert(&receiver.id)) {
            let what = format!("two receivers would be called `{}`", twice.id);
            return Err(Error::input(self.add.first(), None, what, "give the object that is added another name"));
        }
        Ok(after)
    }

    /// Adds the files and returns their triangles.
    fn add_files(
        &self,
        edited: &mut EditedScene,
        held: &TracedScene,
        before: &Archive,
        added: &SceneFiles,
        resources: &Resources,
    ) -> Result<ObjectTriangles> {
        if self.add.files.is_empty() {
            return Ok(ObjectTriangles::default());
        }
        let first = self.add.first();
        if held.objects.list.is_empty() {
            let hint = "build it again from its scene files: this release stores the names of their objects";
            return Err(Error::input(&self.before, None, "the archive names no objects, so none can be added", hint));
        }
        let (scene, mut soup) = Scene::load_with_objects(added)?;
        scene.report.tell(resources.observer);
        let (low, high) = scene.mesh.bounds();
        let lies = [low, high].map(|corner| corner + scene.mesh.origin);
        if let Some(far) = far_objects(first, lies, before.manifest().scene.bounds_m.map(DVec3::from_array)) {
            resources.observer.warn(&far);
        }
        let called = first.file_stem().unwrap_or_default().to_string_lossy();
        let numbers = edited.add(&scene, &called, first)?;
        for material in &mut soup.materials {
            *material = numbers.get(usize::from(*material)).copied().unwrap_or(u16::MAX);
        }
        Ok(soup)
    }

    /// Returns the scene after the edits, at the place of the archive before.
    fn edited_scene(&self, edited: &EditedScene, held: &TracedScene, before: &Archive) -> Result<Scene> {
        let manifest = before.manifest();
        let mut scene = edited.scene(held)?;
        scene.place = manifest.place;
        let is_there = |name: &str| scene.materials.iter().any(|material| material.name == name);
        scene.ground = manifest.ground.clone().filter(|ground| is_there(&ground.material));
        scene.report.degenerate_dropped += manifest.scene.degenerate_dropped as usize;
        Ok(scene)
    }

    fn build(
        &self,
        before: &Archive,
        scene: &Scene,
        receivers: &[Receiver],
        resources: &Resources,
    ) -> Result<BuildReport> {
        let (manifest, observer) = (before.manifest(), resources.observer);
        SiteSettings::new(&manifest.settings, before.path())?;
        if let Some(negligible) = &manifest.negligible {
            let left_out = manifest.settings.left_out.join(", ");
            observer.warn(format!(
                "{} leaves out {left_out}, which contributed little under {}: their contribution to the edited scene is not known",
                before.path().display(),
                negligible.weather
            ));
        }
        let workspace = Workspace { folder: folder_of(&self.output).into(), memory: resources.memory };
        let budget = workspace.memory.length(Use::SortedReceivers);
        let mut tiles = ReceiverTiles::from_receivers(receivers, scene.mesh.origin, &workspace.folder, budget)?;
        let prepared = PreparedScene::new(scene)?;
        let plan = Plan::new(BuildSettings::of(&manifest.settings));
        let output =
            Output { start: if self.fresh { Start::Fresh } else { Start::Resume }, ..Output::new(self.output.clone()) };
        let sources = ReusedArchives { earlier: None, before: Some(before) };
        let mut build = Build { scene: &prepared, receivers: &mut tiles, workspace: &workspace, observer };
        let report = build.write(&plan, &output, &sources).map_err(|error| error.advise(OTHER_EDITS))?;
        report.tell(scene, &self.output, Tone::Report, observer);
        let built = Archive::open_with(&self.output, Access::Read)?;
        black_below_horizon(&built)?.iter().for_each(|lost| observer.warn(lost));
        Ok(report)
    }
}

/// Hint for an interrupted update with other edits.
const OTHER_EDITS: &str =
    "repeat the edits that started it to continue, or give {fresh} to discard it, or another {output}";
