//! `heliotile archive audit`: a check of the error that an archive states.

use super::console::terminal::Terminal;
use super::{Outcome, say};
use heliotile::cases::Audit;
use heliotile::{Provenance, Resources, Result, Verdict};

/// `heliotile archive audit`: an error larger than the stated one is a finding (exit 1).
pub fn run(args: &Audit, about: Provenance) -> Result<Outcome> {
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
