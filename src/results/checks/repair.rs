//! A damaged archive made whole: what is good is kept, what is not is traced again. In: an archive, its scene. Out: an archive of the same root.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::original;
use crate::resources::Resources;
use heliotile_builder::held::{complete, held_receivers};
use heliotile_builder::pipeline::{Build, Output, Plan, PreparedScene, ReusedArchives, Start, Workspace};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_builder::writing::copy::{copy_whole, folder_of};
use heliotile_builder::writing::guards::{check_archive_name, guard_archive, guard_site};
use heliotile_core::archive::{self, Access, Archive, Problem, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::SiteSettings;
use heliotile_core::text::counted;
use heliotile_remote::places::require_file;
use heliotile_scene::Scene;
use heliotile_scene::request::SceneRequest;

/// What is asked of a repair.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RepairRequest {
    /// The damaged archive.
    pub archive: PathBuf,
    /// The scene that it was built from; where that lies the archive says.
    pub scene: SceneRequest,
    /// Table of the receivers that it was built from; needed where the archive's own are damaged.
    pub receivers: Option<PathBuf>,
    /// The archive to write; none: in place of the damaged one.
    pub output: Option<PathBuf>,
}

/// What a repair did.
#[derive(Clone, Debug)]
pub struct RepairDone {
    /// The whole archive.
    pub archive: PathBuf,
    /// What was wrong; nothing if the archive was whole.
    pub problems: Vec<Problem>,
    /// Rays that were traced again.
    pub rays: u64,
}

impl RepairDone {
    /// What was done, as a line.
    pub fn text(&self) -> String {
        let (archive, problems) = (self.archive.display(), self.problems.len() as u64);
        match problems {
            0 => format!("{archive}: nothing to repair\n"),
            _ => {
                let (problems, rays) = (counted(problems, "problem"), counted(self.rays, "ray"));
                format!("{archive}: {problems} repaired with {rays}, root as before\n")
            }
        }
    }
}

impl RepairRequest {
    /// Writes the whole archive. An archive that is whole is copied, if there is an output.
    pub fn write(&self, resources: &Resources) -> Result<RepairDone> {
        require_file(&self.archive, "only files are repaired")?;
        let output = self.output.as_ref().unwrap_or(&self.archive);
        let site = original::site_of(&self.archive, &self.scene)?;
        guard_site(output, &site, &[self.receivers.as_deref()])?;
        if output != &self.archive {
            check_archive_name(output)?;
            guard_archive(output)?;
        }
        // A damaged block makes references to it dangle: those are no damage of their own.
        let mut report = archive::verify(&self.archive, Access::Read, false)?;
        if report.problems.is_empty() {
            report = archive::verify(&self.archive, Access::Read, true)?;
        }
        let problems = report.problems;
        if problems.is_empty() {
            if output != &self.archive {
                copy_whole(&self.archive, output)?;
            }
            return Ok(RepairDone { archive: self.archive.clone(), problems, rays: 0 });
        }
        // Without header, directory and manifest nothing is known of the rest.
        let archive = Archive::open_with(&self.archive, Access::Read)?;
        complete(&archive)?;
        let scene = original::scene_of(&archive, &site, self.scene.first(), resources.observer)?;
        let workspace = Workspace { folder: folder_of(output).into(), memory: resources.memory };
        let mut receivers = self.receivers(&archive, &scene, &workspace, resources)?;
        // Under a name of its own until it is known to be what it was.
        let repaired = with_ending(output, ".repaired");
        SiteSettings::of(&archive.manifest().settings, archive.path())?;
        let settings = BuildSettings::of(&archive.manifest().settings);
        let plan = Plan {
            accuracy: archive.manifest().accuracy.clone(),
            negligible: archive.manifest().negligible.clone(),
            with_scene: !archive.entries_of(format::SCENE).is_empty(),
            ..Plan::of(settings)
        };
        let to = Output { start: Start::Resume, ..Output::new(repaired.clone()) };
        let root = archive.root();
        let (scene, receivers, observer) = (&PreparedScene::new(&scene)?, &mut receivers, resources.observer);
        let done = Build { scene, receivers, workspace: &workspace, observer }.write(
            &plan,
            &to,
            &ReusedArchives { earlier: &[archive], before: None },
        )?;
        if done.root != root {
            let what = "has another root than the archive had: another release wrote that, or receivers were not those of the archive";
            let hint = "compare the two with `{command:diff}`, and take its name if it is right";
            return Err(Error::input(&repaired, None, what, hint));
        }
        std::fs::rename(&repaired, output).map_err(Error::io(output, "rename the repaired archive to"))?;
        Ok(RepairDone { archive: output.clone(), problems, rays: done.rays.total() })
    }

    /// The receivers that the archive was built from: those of the table, if there is one, or the archive's own.
    fn receivers(
        &self,
        archive: &Archive,
        scene: &Scene,
        workspace: &Workspace,
        resources: &Resources,
    ) -> Result<ReceiverTiles> {
        let Some(path) = &self.receivers else {
            let budget = workspace.memory.length(Use::SortedReceivers);
            let held = held_receivers(archive).map_err(|error| {
                let what = format!("its receivers are damaged: {error}");
                Error::input(archive.path(), None, what, "give the receivers file with {receivers}")
            })?;
            return ReceiverTiles::from_receivers(&held, scene.mesh.origin, &workspace.folder, budget);
        };
        let mut receivers = workspace.read_receivers(path, scene, resources.observer)?;
        match receivers.difference(archive)? {
            Some(what) => Err(Error::input(path, None, what, "give the receivers that the archive was built from")),
            None => Ok(receivers),
        }
    }
}

/// A path with something behind its name.
fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(ending);
    PathBuf::from(name)
}
