//! Summary of an atlas. In: an atlas. Out: text; the parts that are built.

use std::path::PathBuf;

use crate::listed::ListedPart;
use crate::opened::Atlas;
use crate::plan::PlannedPart;
use crate::state::PartState;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, counted, listed, message};

/// Most missing parts that the summary names.
const NAMED: usize = 8;

/// Returns the parts that are built, with the places of their archives. An error: no part is built.
pub fn built(atlas: &Atlas) -> Result<Vec<(&PlannedPart, PathBuf)>> {
    let listed = atlas.parts(None)?;
    let archives = listed.iter().map(ListedPart::archive);
    let paths: Vec<_> =
        atlas.plan.parts.iter().zip(archives).filter_map(|(part, path)| Some((part, path?.clone()))).collect();
    match paths.is_empty() {
        true => Err(Error::input(
            &atlas.shown(),
            None,
            "has no built part",
            "build the parts with {command:build} ATLAS {part} all",
        )
        .because(Problem::Lacks("parts"))),
        false => Ok(paths),
    }
}

/// Describes an atlas: its parts, scene files, receivers, bytes and seams.
pub fn info(atlas: &Atlas) -> Result<Message> {
    let plan = &atlas.plan;
    let (mut receivers, mut bytes, mut built, mut empty, mut missing) = (0, 0, 0, 0, Vec::new());
    for (part, state) in atlas.each_archive(|archive| (archive.manifest().receivers.count, archive.length()))? {
        match state {
            PartState::Built((count, length)) => {
                receivers += count;
                bytes += length;
                built += 1;
            }
            PartState::Empty => empty += 1,
            PartState::Missing => missing.push(part.name.as_str()),
        }
    }
    let mut out = message!("{}\n", atlas.shown().display());
    let mut line = |name: &str, text: Message| {
        out = std::mem::take(&mut out).and(format!("  {name:<11} ")).and(text).and("\n");
    };
    line(
        "parts",
        message!(
            "{} of {} m, with surroundings within {} m and farther ones that rise by {} degrees",
            plan.parts.len(),
            plan.cut.part_size_m,
            plan.cut.halo_m,
            plan.cut.skyline_deg
        ),
    );
    line("scene", counted(plan.files.len() as u64, "file").into());
    line("built", message!("{built}: {}, {:.1} MB", counted(receivers, "receiver"), bytes as f64 / 1e6));
    if empty > 0 {
        line("", message!("{empty} without receivers"));
    }
    if let Some(first) = missing.first() {
        let named = listed(missing.iter().take(NAMED), missing.len());
        line("to build", message!("{}: {named} ({{command:build}} ATLAS {{part}} {first})", missing.len()));
    }
    if let Some(seams) = &plan.seams {
        line("seams", seams.words().into());
        let parts = seams.components_percent.iter().filter(|(_, percent)| **percent > 0.0);
        let parts: Vec<String> = parts.map(|(name, percent)| format!("{name} {percent} %")).collect();
        if !parts.is_empty() {
            line("", parts.join(", ").into());
        }
    }
    Ok(out)
}
