//! Repairs a damaged archive: good blocks are kept, bad ones are traced again. In: an archive, its
//! scene. Out: an archive of the same root.

use std::path::{Path, PathBuf};

use super::original;
use heliotile_archives::Workspace;
use heliotile_builder::held::held_receivers;
use heliotile_builder::pipeline::{Build, Output, Plan, PreparedScene, ReusedArchives, Start, read_receivers};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::{self, Access, Archive, Problem, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::SiteSettings;
use heliotile_core::text::counted;
use heliotile_files::writing::copy::{copy_whole, folder_of};
use heliotile_files::writing::guards::{check_archive_name, guard_archive};
use heliotile_remote::places::require_file;
use heliotile_requests::Request;
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::guard_site;

/// Request for a repair.
#[derive(Clone, Debug, Default, Request)]
pub struct RepairRequest {
    /// Archive to repair.
    #[field(positional, required, input = Archive)]
    pub archive: PathBuf,
    /// Scene that the archive was built from; the archive states its place.
    #[field(flatten)]
    pub scene: SceneRequest,
    /// Table of the receivers that the archive was built from; needed if the archive's own table is
    /// damaged.
    #[field(short = 'r', input = Receivers)]
    pub receivers: Option<PathBuf>,
    /// Repaired archive to write [default: replace the damaged one].
    #[field(short = 'o', metavar = "SITE.helio", output = Archive)]
    pub output: Option<PathBuf>,
}

/// Result of a repair.
#[derive(Clone, Debug)]
pub struct RepairDone {
    /// Repaired archive.
    pub archive: PathBuf,
    /// Problems that were found; empty if the archive was whole.
    pub problems: Vec<Problem>,
    /// Number of rays that were traced again.
    pub rays: u64,
}

impl RepairDone {
    /// Returns a line of text about the repair.
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
    /// Writes the repaired archive. An archive without damage is copied if `output` is given.
    pub fn write(&self, resources: &Resources) -> Result<RepairDone> {
        require_file(&self.archive, "only files are repaired")?;
        let output = self.output.as_ref().unwrap_or(&self.archive);
        let site = original::site_of(&self.archive, &self.scene)?;
        guard_site(output, &site, &[self.receivers.as_deref()])?;
        if output != &self.archive {
            check_archive_name(output)?;
            guard_archive(output)?;
        }
        // References to a damaged block dangle, but they are no damage of their own: they are
        // checked only if all blocks are good.
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
        // Header, directory and manifest must be good: nothing is known of the rest without them.
        let archive = Archive::open_with(&self.archive, Access::Read)?;
        let scene = original::scene_of(&archive, &site, self.scene.first(), resources.observer)?;
        let workspace = Workspace { folder: folder_of(output).into(), memory: resources.memory };
        let mut receivers = self.receivers(&archive, &scene, &workspace, resources)?;
        // The new archive has a temporary name until its root is known to be right.
        let repaired = with_ending(output, ".repaired");
        SiteSettings::new(&archive.manifest().settings, archive.path())?;
        let settings = BuildSettings::of(&archive.manifest().settings);
        let plan = Plan {
            accuracy: archive.manifest().accuracy.clone(),
            negligible: archive.manifest().negligible.clone(),
            with_scene: !archive.entries_of(format::SCENE).is_empty(),
            ..Plan::new(settings)
        };
        let to = Output { start: Start::Resume, ..Output::new(repaired.clone()) };
        let root = archive.root();
        let (scene, receivers, observer) = (&PreparedScene::new(&scene)?, &mut receivers, resources.observer);
        let done = Build { scene, receivers, workspace: &workspace, observer }.write(
            &plan,
            &to,
            &ReusedArchives { earlier: Some(&archive), before: None },
        )?;
        if done.root != root {
            let what = "the repaired archive has another root than the original: another release wrote the original, or its receivers were others";
            let hint = "compare the two with `{command:archive diff}`; if the repaired one is right, rename it to replace the original";
            return Err(Error::input(&repaired, None, what, hint).because(heliotile_core::error::Problem::OtherInputs));
        }
        std::fs::rename(&repaired, output).map_err(Error::io(output, "rename the repaired archive to"))?;
        Ok(RepairDone { archive: output.clone(), problems, rays: done.rays.total() })
    }

    /// Returns the receivers that the archive was built from, out of the table if there is one, or
    /// out of the archive.
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
                let what = format!("its receivers are damaged: {error:#}");
                Error::input(archive.path(), None, what, "give the receivers file with {receivers}")
            })?;
            return ReceiverTiles::from_receivers(&held, scene.mesh.origin, &workspace.folder, budget);
        };
        let mut receivers = read_receivers(workspace, path.as_path(), scene, resources.observer)?;
        match receivers.difference(archive)? {
            Some(what) => Err(Error::input(path, None, what, "give the receivers that the archive was built from")),
            None => Ok(receivers),
        }
    }
}

/// Returns `path` with `ending` appended to its name.
fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(ending);
    PathBuf::from(name)
}
