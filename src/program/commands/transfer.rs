//! `heliotile archive extract`, `merge` and `diff`. In: archives. Out: a part of one, the union of
//! two, or their differences.

use super::console::terminal::Terminal;
use super::{Outcome, remark, say, workspace_beside};
use heliotile::archive::{Assembled, format, transfer};
use heliotile::atlas::holding;
use heliotile::cases::{Diff, Extract, Merge};
use heliotile::output::{guard_archive, guard_output};
use heliotile::text::counted;
use heliotile::{Access, ExtractContent, Provenance, Result};

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
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(args.receivers.receivers.as_deref());
    guard_output(&args.output, &inputs)?;
    guard_archive(&args.output)?;
    let workspace = workspace_beside(&args.output, args.memory);
    let receivers = args.receivers.selection();
    let archive = holding(&args.archive, receivers.as_ref(), args.io.unwrap_or(Access::Read), &workspace)?;
    let content = ExtractContent { scene: !args.no_scene, replay_only: args.replay_only };
    let terminal = Terminal::default();
    let extracted = transfer::extract(&archive, receivers.as_ref(), content, &args.output, &workspace, &terminal)?;
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
