//! `heliotile update`: an archive after edits of its scene.

use super::console::terminal::Terminal;
use super::{Outcome, remark};
use heliotile::cases::Update;
use heliotile::{Provenance, Resources, Result};

/// `heliotile update`.
pub fn run(args: &Update, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    remark(args.request().write(&resources)?.text())?;
    Ok(Outcome::Fine)
}
