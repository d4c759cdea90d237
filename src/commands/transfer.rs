//! Parts of archives (`extract`, `merge`) and what two do not share (`diff`).

use std::fmt::Write;
use std::path::Path;

use super::atlas::sources::holding;
use super::terminal::Terminal;
use super::{Outcome, guard_archive, guard_output, remark, say, workspace, workspace_beside};
use crate::cli::{DiffArgs, ExtractArgs, MergeArgs};
use crate::files::open_archive;
use heliotile_builder::transfer::{self, Assembled, Difference, Differences, listed};
use heliotile_core::archive::format;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;

/// `heliotile merge`.
pub fn merge(args: &MergeArgs) -> Result<Outcome> {
    guard_output(&args.output, &[&args.first, &args.second])?;
    guard_archive(&args.output)?;
    let [a, b] = [open_archive(&args.first, args.io)?, open_archive(&args.second, args.io)?];
    let workspace = workspace_beside(&args.output, args.memory);
    let merged = transfer::merge([&a, &b], &args.output, &workspace, &Terminal::default())?;
    let Assembled { receivers, tiles, cells, summary } = &merged.written;
    remark(&format!(
        "{}: {receivers} receivers in {}, {} probes, {} bounce cells, {:.2} MB\n  {} of {}, {} of {}, {} of both\n  \
         root {}\n",
        args.output.display(),
        counted(u64::from(*tiles), "tile"),
        cells.probes,
        cells.bounce_cells,
        summary.bytes as f64 / 1e6,
        merged.of_each[0],
        a.path().display(),
        merged.of_each[1],
        b.path().display(),
        merged.shared,
        format::hex(&summary.root),
    ))?;
    Ok(Outcome::Fine)
}

/// `heliotile extract`.
pub fn extract(args: &ExtractArgs) -> Result<Outcome> {
    let Some(selection) = args.of.selection() else {
        return Err(Error::argument(
            "extract",
            "no receivers are named",
            "name some by --receivers, --bbox, --surface or --object",
        ));
    };
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(args.of.receivers.as_deref());
    guard_output(&args.output, &inputs)?;
    guard_archive(&args.output)?;
    let workspace = workspace_beside(&args.output, args.memory);
    let archive = holding(&args.archive, &selection, args.io, &workspace)?;
    let extracted =
        transfer::extract(&archive, &selection, !args.no_scene, &args.output, &workspace, &Terminal::default())?;
    let Assembled { receivers, tiles, cells, summary } = &extracted.written;
    remark(&format!(
        "{}: {receivers} of {} receivers in {}, {} of {} probes, {} of {} bounce cells, {:.2} MB\n  root {}\n",
        args.output.display(),
        extracted.of.receivers,
        counted(u64::from(*tiles), "tile"),
        cells.probes,
        extracted.of.probes,
        cells.bounce_cells,
        extracted.of.bounce_cells,
        summary.bytes as f64 / 1e6,
        format::hex(&summary.root),
    ))?;
    Ok(Outcome::Fine)
}

/// `heliotile diff`: a difference is a finding (exit 1).
pub fn diff(args: &DiffArgs) -> Result<Outcome> {
    let [a, b] = [open_archive(&args.first, args.io)?, open_archive(&args.second, args.io)?];
    let found = transfer::diff(&a, &b, &workspace(std::env::temp_dir(), args.memory))?;
    say(&table(&found, [a.path(), b.path()]))?;
    Ok(if found.is_equal() { Outcome::Fine } else { Outcome::ProblemFound })
}

/// The differences as a short table.
fn table(found: &Differences, [a, b]: [&Path; 2]) -> String {
    let mut out = String::new();
    if found.is_equal() {
        let roots = match found.same_root {
            true => "and so are the roots",
            false => "but not the roots: cut or packed in another way, or written by another release",
        };
        return format!("equal, {roots}\n");
    }
    // Writing to a string cannot fail.
    let _ = writeln!(out, "A {}\nB {}", a.display(), b.display());
    for Difference { item, values: [a, b] } in &found.statements {
        let _ = writeln!(out, "{item}: {a} in A, {b} in B");
    }
    const CELLS: &str = " (level/facing/material/voxel)";
    for (thing, note, parted) in [
        ("receiver", "", &found.receivers),
        ("probe", CELLS, &found.probes),
        ("bounce cell", CELLS, &found.bounces),
        ("unknown block", "", &found.unknown),
    ] {
        for (side, names) in
            [("only in A", &parted.only_a), ("only in B", &parted.only_b), ("different", &parted.different)]
        {
            if names.count > 0 {
                let _ = writeln!(out, "{side:<9}  {}{note}", listed(names.count, thing, &names.first));
            }
        }
    }
    out
}
