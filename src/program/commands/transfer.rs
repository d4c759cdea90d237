//! Commands on archives: `heliotile update`, and `heliotile archive extract`, `merge`, `diff`,
//! `repair` and `audit`. In: archives. Out: an edited one, a part of one, the union of two, their
//! differences, one without damage, or a check of the stated error.

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use heliotile::archive::{Assembled, format, transfer};
use heliotile::atlas::holding;
use heliotile::cases::{Audit, Diff, Extract, Merge, Repair, Update};
use heliotile::output::{folder_of, guard_archive, guard_output};
use heliotile::text::counted;
use heliotile::tracing::Workspace;
use heliotile::{Access, ExtractContent, Provenance, Resources, Result, Verdict};

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
    let workspace = Workspace { folder: folder_of(&args.output).into(), memory: args.memory };
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

/// `heliotile update`.
pub fn update(args: &Update, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    remark(args.request().write(&resources)?.text())?;
    Ok(Outcome::Fine)
}

/// `heliotile archive repair`.
pub fn repair(args: &Repair, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    remark(args.request.write(&resources)?.text())?;
    Ok(Outcome::Fine)
}

/// `heliotile archive audit`: an error larger than the stated one is a finding (exit 1).
pub fn audit(args: &Audit, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::default();
    let resources = Resources::new(args.memory, &terminal);
    let report = args.request.run(&resources)?;
    say(&report.text())?;
    if let Some(folder) = &args.output {
        say(&format!("{}: open it in a browser\n", report.write(folder, about)?.display()))?;
    }
    Ok(match report.verdict {
        Verdict::Refuted => Outcome::ProblemFound,
        Verdict::Holds | Verdict::NothingStated => Outcome::Fine,
    })
}
