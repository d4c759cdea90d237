//! `heliotile partition`: a region cut into parts. In: scene files, however many. Out: `atlas.json`, and what the halo costs. No part is
//! traced; files are read one after the other, so that memory is that of the largest.

use std::fs;
use std::path::Path;

use super::listed::parts;
use super::part::PartState;
use super::plan::{AtlasPlan, Cut, FILE, absolute, is_atlas};
use super::seams;
use crate::cli::PartitionArgs;
use crate::cli::quoted;
use crate::commands::build::settings_of;
use crate::commands::{Outcome, remark, warn, workspace};
use crate::outputs::sink::write_texts;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;

/// `heliotile partition`.
pub fn run(args: &PartitionArgs) -> Result<Outcome> {
    let atlas = args.output.as_path();
    check_folder(args, atlas)?;
    let scene = absolute(&args.scene)?;
    let surveyed = scene.site()?.survey()?;
    let cut = Cut {
        part_size_m: args.part_size.0,
        halo_m: args.halo.0,
        skyline_deg: args.skyline,
        scene,
        cover: &args.cover,
        quality: args.quality,
        set: &args.set,
        no_scene: args.no_scene,
    };
    let mut plan = AtlasPlan::new(cut, &surveyed)?;
    settings_of(&plan.accuracy()?)?;
    if plan.parts.is_empty() {
        let hint = "cover what there is with --on ground, or --types all";
        return Err(Error::argument("SCENE", "no file has an object that receivers go on", hint));
    }
    if args.halo.0 < 50.0 {
        warn(&format!("a halo of {} m leaves out neighbours that matter: 300 m is usual", args.halo.0));
    }
    if args.sample > 0 {
        let folder = tempfile::tempdir().map_err(Error::io(&std::env::temp_dir(), "make a folder in"))?;
        plan.seams = seams::measure(&plan, atlas, args.sample, &workspace(folder.path(), args.memory))?;
    }
    fs::create_dir_all(atlas).map_err(Error::io(atlas, "create"))?;
    write_texts(atlas, &[(FILE, plan.to_json()?)])?;
    remark(&summary(&plan, atlas))?;
    Ok(Outcome::Fine)
}

/// Parts of another plan must not lie beside this one.
fn check_folder(args: &PartitionArgs, atlas: &Path) -> Result<()> {
    if !is_atlas(atlas) {
        return Ok(());
    }
    if !args.replace {
        let what = "holds an atlas already";
        return Err(Error::input(
            atlas,
            None,
            what,
            "--output FOLDER to keep both, or --replace if nothing of it is built",
        ));
    }
    match parts(atlas, None)?.iter().find(|part| part.state != PartState::Missing) {
        None => Ok(()),
        Some(part) => {
            let what = format!("holds parts that are built, such as {}", part.name);
            Err(Error::input(atlas, None, what, "--output FOLDER, or remove its folder `parts`"))
        }
    }
}

fn summary(plan: &AtlasPlan, atlas: &Path) -> String {
    let mut text = format!(
        "{}: {} of {} m with {} m around them, of {}\n",
        atlas.join(FILE).display(),
        counted(plan.parts.len() as u64, "part"),
        plan.part_size_m,
        plan.halo_m,
        counted(plan.files.len() as u64, "file")
    );
    if let Some(seams) = &plan.seams {
        text += &format!("  {}\n", seams.words());
    }
    let last = plan.parts.len() - 1;
    text + &format!(
        "  next: heliotile build {} --part K, K from 0 to {last}, in any order and anywhere; or --part all\n",
        quoted(&atlas.to_string_lossy())
    )
}
