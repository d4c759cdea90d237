//! `heliotile pv`: light on solar modules.

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use crate::cli::quoted;
use heliotile::cases::Pv;
use heliotile::{Provenance, PvDone, Resources, Result};

/// `heliotile pv`.
pub fn run(args: &Pv, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    let done = args.request.write(about, &resources)?;
    say(&done.table)?;
    remark(summary(args, &done))?;
    Ok(Outcome::Fine)
}

/// Returns a remark on the files that were written, with the next command.
fn summary(args: &Pv, done: &PvDone) -> String {
    let lists = if args.request.points.is_some() { ", horizon/ (a list for each point)" } else { ", modules.obj" };
    let pictures = if args.request.search { " and turns/ (a picture for each point)" } else { "" };
    let shade = if args.request.shade { " and shade/ (of the array)" } else { "" };
    format!(
        "{}: {}{lists}{pictures}{shade}; about the archive: heliotile info {}\n",
        done.folder.display(),
        done.files.join(", "),
        quoted(&done.archive.to_string_lossy())
    )
}
