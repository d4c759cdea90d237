//! A damaged archive made whole: what is good is kept, what is not is traced again.

use super::build::{BuildPlan, BuildSettings, Start, build_with};
use super::{Outcome, guard_output, interrupt, say, temporary_folder, warn};
use crate::archive::{self, Access, Archive, Blocks, format, tables};
use crate::cli::RepairArgs;
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::scene::receiver_tiles::ReceiverTiles;
use crate::scene::receivers::Receiver;
use glam::DVec3;

/// `heliotile repair`.
pub fn run(args: &RepairArgs) -> Result<Outcome> {
    let output = args.output.as_ref().unwrap_or(&args.archive);
    let inputs: Vec<&std::path::Path> = [Some(&args.scene), args.materials.as_ref(), args.receivers.as_ref()]
        .into_iter()
        .flatten()
        .map(|p| &**p)
        .collect();
    guard_output(output, &inputs)?;
    // A damaged block makes references to it dangle: those are no damage of their own.
    let mut report = archive::verify(&args.archive, Access::Read, false)?;
    if report.problems.is_empty() {
        report = archive::verify(&args.archive, Access::Read, true)?;
    }
    if report.problems.is_empty() {
        say(&format!("{}: nothing to repair\n", args.archive.display()))?;
        return Ok(Outcome::Fine);
    }
    // Without header, directory and manifest nothing is known of the rest.
    let archive = Archive::open_with(&args.archive, Access::Read)?;
    let scene = Scene::load(&args.scene, args.materials.as_deref())?;
    let (found, expected) = (format::hex(&scene.content_hash()), &archive.manifest().scene.content_hash);
    if found != *expected {
        let what = format!("is not the scene of the archive: its hash is {found}, that of the archive {expected}");
        return Err(Error::input(
            &args.scene,
            None,
            what,
            "give the scene and the materials that the archive was built from",
        ));
    }
    let folder = temporary_folder(output);
    let budget = args.memory.0 as usize / 8;
    let mut receivers = match &args.receivers {
        Some(path) => {
            let mut warnings = Vec::new();
            let receivers = ReceiverTiles::open(path, scene.mesh.origin, folder, budget, &mut warnings)?;
            warnings.iter().for_each(|w| warn(w));
            receivers
        }
        None => ReceiverTiles::from_receivers(&receivers_of(&archive)?, scene.mesh.origin, folder, budget)?,
    };
    interrupt::watch();
    let plan = BuildPlan {
        settings: BuildSettings::of(&archive.manifest().settings),
        output: output.clone(),
        memory_bytes: args.memory.0,
        start: Start::Fresh,
        checkpoint_every: std::time::Duration::from_secs(30),
    };
    let root = archive.root();
    let done = build_with(&scene, &mut receivers, &plan, &[archive])?;
    let rays = done.rays.sky + done.rays.hit + done.rays.probe + done.rays.bounce;
    let same = if done.root == root { "root as before" } else { "another root than before" };
    let bad = report.problems.len();
    say(&format!("{}: {bad} problems repaired with {rays} rays, {same}\n", output.display()))?;
    Ok(Outcome::Fine)
}

/// Receivers of all tiles, which must be good.
fn receivers_of(archive: &Archive) -> Result<Vec<Receiver>> {
    let mut receivers = Vec::new();
    for tile in 0..archive.tiles() {
        let table =
            Blocks::block(archive, format::RECEIVERS, tile).and_then(|block| tables::Receivers::from_block(&block));
        let Ok(table) = table else {
            let what = format!("the receivers of tile {tile} are damaged");
            return Err(Error::input(archive.path(), None, what, "give the receivers file with --receivers"));
        };
        for row in 0..table.ids.len() {
            receivers.push(Receiver {
                id: table.ids[row].clone(),
                position: DVec3::from(table.position[row]),
                normal: DVec3::from(table.normal[row]),
                area: Some(table.area[row]).filter(|area| *area > 0.0),
                surface: Some(table.surface[row].clone()).filter(|name| !name.is_empty()),
            });
        }
    }
    Ok(receivers)
}
