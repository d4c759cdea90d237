//! `heliotile archive repair`: traces the damaged parts of an archive again.

use super::console::terminal::Terminal;
use super::{Outcome, remark};
use heliotile::cases::Repair;
use heliotile::{Provenance, Resources, Result};

/// `heliotile archive repair`.
pub fn run(args: &Repair, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    remark(args.request.write(&resources)?.text())?;
    Ok(Outcome::Fine)
}
