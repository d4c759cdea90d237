//! A damaged archive made whole: what is good is kept, what is not is traced again.

use std::path::{Path, PathBuf};

use super::console::terminal::Terminal;
use super::{Outcome, original, remark, workspace_beside};
use crate::cli::RepairArgs;
use heliotile_builder::pipeline::{Build, Output, Plan, PreparedScene, Start};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_builder::writing::copy::copy_whole;
use heliotile_builder::writing::guards::{guard_archive, guard_site};
use heliotile_core::archive;
use heliotile_core::archive::{Access, Archive, format, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::SiteSettings;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::counted;
use heliotile_remote::places::require_file;

/// `heliotile repair`.
pub fn run(args: &RepairArgs) -> Result<Outcome> {
    require_file(&args.archive, "only files are repaired")?;
    let output = args.output.as_ref().unwrap_or(&args.archive);
    let site = original::site_of(&args.archive, &args.scene)?;
    guard_site(output, &site, &[args.receivers.as_deref()])?;
    if output != &args.archive {
        guard_archive(output)?;
    }
    // A damaged block makes references to it dangle: those are no damage of their own.
    let mut report = archive::verify(&args.archive, Access::Read, false)?;
    if report.problems.is_empty() {
        report = archive::verify(&args.archive, Access::Read, true)?;
    }
    if report.problems.is_empty() {
        if output != &args.archive {
            copy_whole(&args.archive, output)?;
        }
        remark(&format!("{}: nothing to repair\n", args.archive.display()))?;
        return Ok(Outcome::Fine);
    }
    // Without header, directory and manifest nothing is known of the rest.
    let archive = Archive::open_with(&args.archive, Access::Read)?;
    let scene = original::scene_of(&archive, &site, args.scene.first())?;
    let (workspace, terminal) = (workspace_beside(output, args.memory), Terminal::watching());
    let mut receivers = match &args.receivers {
        Some(path) => {
            let mut receivers = workspace.read_receivers(path, &scene, &terminal)?;
            if let Some(what) = receivers.difference(&archive)? {
                return Err(Error::input(path, None, what, "give the receivers that the archive was built from"));
            }
            receivers
        }
        None => {
            let budget = workspace.memory.length(Use::SortedReceivers);
            ReceiverTiles::from_receivers(&receivers_of(&archive)?, scene.mesh.origin, &workspace.folder, budget)?
        }
    };
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
    let prepared = PreparedScene::new(&scene)?;
    let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: &terminal };
    let done = build.write(&plan, &to, &[archive])?;
    let rays = done.rays.total();
    if done.root != root {
        let what = "has another root than the archive had: another release wrote that, or receivers were not those of the archive";
        return Err(Error::input(
            &repaired,
            None,
            what,
            "compare the two with `heliotile diff`, and take its name if it is right",
        ));
    }
    std::fs::rename(&repaired, output).map_err(Error::io(output, "rename the repaired archive to"))?;
    let bad = counted(report.problems.len() as u64, "problem");
    remark(&format!("{}: {bad} repaired with {}, root as before\n", output.display(), counted(rays, "ray")))?;
    Ok(Outcome::Fine)
}

/// A path with something behind its name.
fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(ending);
    PathBuf::from(name)
}

/// Receivers of all tiles, which must be good.
fn receivers_of(archive: &Archive) -> Result<Vec<Receiver>> {
    let mut receivers = Vec::new();
    for tile in 0..archive.tiles() {
        let held = tables::PartsTable::receivers(archive, tile)
            .and_then(|mut held| tables::OverviewTable::join(archive, tile, &mut held).map(|_| held));
        let Ok(held) = held else {
            let what = format!("the receivers of tile {tile} are damaged");
            return Err(Error::input(archive.path(), None, what, "give the receivers file with --receivers"));
        };
        receivers.extend(held);
    }
    Ok(receivers)
}
