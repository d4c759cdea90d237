//! A region cut into parts. In: any number of scene files. Out: `atlas.json`, and the error that
//! the halo makes. No part is traced. Files are read one after the other, so that memory is that of
//! the largest.

use std::fs;
use std::path::PathBuf;

use crate::listed::parts;
use crate::plan::{AtlasPlan, CutRequest, FILE, absolute, is_atlas};
use crate::seam_trial;
use crate::state::PartState;
use heliotile_archives::Workspace;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_files::spill::parse_memory;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::sink::write_texts;

/// Halo width below which a warning says that neighbours that matter are left out, metres.
const NARROW_M: f64 = 50.0;

/// A region to be cut.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct PartitionRequest {
    /// Parts, halo and settings of the cut.
    #[field(flatten)]
    pub cut: CutRequest,
    /// Folder of the atlas to write: atlas.json, and a folder for each part once it is built.
    #[field(name = "output", short = 'o', metavar = "ATLAS", output = Folder(&[]), required)]
    pub atlas: PathBuf,
    /// Replace the plan of an atlas that has no built parts.
    #[field(neutral)]
    pub replace: bool,
    /// Number of receivers that are also traced with three times the halo, to estimate the error
    /// due to the halo; 0 for no estimate.
    #[field(metavar = "N", default = 256)]
    pub sample: usize,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

/// Cuts a region into parts and writes its plan.
pub fn partition(request: &PartitionRequest, observer: &dyn Observer) -> Result<AtlasPlan> {
    check_ranges(request)?;
    let (atlas, cut) = (request.atlas.as_path(), &request.cut);
    check_folder(request)?;
    let scene = absolute(&cut.scene)?;
    let surveyed = scene.site()?.survey()?;
    cut.accuracy.settings()?;
    let mut plan = AtlasPlan::new(CutRequest { scene, ..cut.clone() }, &surveyed)?;
    if plan.parts.is_empty() {
        let hint = "put receivers on the ground with {on} ground, or on all objects with {types} all";
        return Err(Error::argument("on", "no scene file has objects for receivers", hint));
    }
    if cut.halo_m < NARROW_M {
        observer.warn(format!("a halo of {} m leaves out neighbours that matter: 300 m is usual", cut.halo_m));
    }
    if request.sample > 0 {
        let folder = tempfile::tempdir().map_err(Error::io(&std::env::temp_dir(), "make a folder in"))?;
        let workspace = Workspace { folder: folder.path().into(), memory: request.memory };
        plan.seams = seam_trial::measure(&plan, atlas, request.sample, &workspace, observer)?;
    }
    fs::create_dir_all(atlas).map_err(Error::io(atlas, "create"))?;
    write_texts(atlas, &[(FILE, plan.to_json()?)])?;
    Ok(plan)
}

/// Refuses a folder with another plan that has built parts: they must not lie beside this plan.
fn check_folder(request: &PartitionRequest) -> Result<()> {
    let atlas = request.atlas.as_path();
    if !is_atlas(atlas) {
        return Ok(());
    }
    if !request.replace {
        let hint = "keep both with {output} FOLDER, or replace it with {replace} if none of its parts is built";
        return Err(Error::input(atlas, None, "holds an atlas already", hint).because(Problem::Exists));
    }
    match parts(atlas, None)?.iter().find(|part| part.state != PartState::Missing) {
        None => Ok(()),
        Some(part) => {
            let what = format!("holds built parts, such as {}", part.name);
            Err(Error::input(
                atlas,
                None,
                what,
                "name another folder with {output} FOLDER, or remove its folder `parts`",
            )
            .because(Problem::Exists))
        }
    }
}
