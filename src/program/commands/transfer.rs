//! `heliotile archive extract`, `merge` and `diff`. In: archives. Out: a part of one, the union of
//! two, or their differences.

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use heliotile::archive::{Assembled, format, transfer};
use heliotile::atlas::holding;
use heliotile::cases::{Diff, Extract, Merge};
use heliotile::output::{folder_of, guard_archive, guard_output};
use heliotile::text::counted;
use heliotile::tracing::Workspace;
use heliotile::{Access, Error, Provenance, Result};

/// `heliotile archive merge`.
pub fn merge(args: &Merge, _: Provenance) -> Result<Outcome> {
    let merged = args.write(&Terminal::default())?;
    let Assembled { receivers, tiles, cells, summary } = &merged.written;
    remark(format!(
        "{}: {receivers} receivers in {}, {} probes, {} bounce cells, {:.2} MB\n  {} from {}, {} from {}, {} in both\n  \
         root {}\n",
        args.output.display(),
        counted(u64::from(*tiles), "tile"),
        cells.probes,
        cells.bounce_cells,
        summary.bytes as f64 / 1e6,
        merged.of_each[0],
        args.first.display(),
        merged.of_each[1],
        args.second.display(),
        merged.shared,
        format::hex(&summary.root),
    ))?;
    Ok(Outcome::Fine)
}

/// `heliotile archive extract`.
pub fn extract(args: &Extract, _: Provenance) -> Result<Outcome> {
    let Some(selection) = args.receivers.selection() else {
        return Err(Error::argument(
            "extract",
            "no receivers are chosen",
            "choose some with --receivers, --bbox, --surface or --object",
        ));
    };
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(args.receivers.receivers.as_deref());
    guard_output(&args.output, &inputs)?;
    guard_archive(&args.output)?;
    let workspace = Workspace { folder: folder_of(&args.output).into(), memory: args.memory };
    let archive = holding(&args.archive, &selection, args.io.unwrap_or(Access::Read), &workspace)?;
    let extracted =
        transfer::extract(&archive, &selection, !args.no_scene, &args.output, &workspace, &Terminal::default())?;
    let Assembled { receivers, tiles, cells, summary } = &extracted.written;
    remark(format!(
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

/// `heliotile archive diff`: a difference is a finding (exit 1).
pub fn diff(args: &Diff, _: Provenance) -> Result<Outcome> {
    let (is_equal, text) = args.found()?;
    say(&text)?;
    Ok(if is_equal { Outcome::Fine } else { Outcome::ProblemFound })
}
