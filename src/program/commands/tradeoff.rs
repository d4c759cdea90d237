//! `heliotile tradeoff`: the cost of accuracy on the user's own site.

use super::console::terminal::Terminal;
use super::{Outcome, say};
use heliotile::cases::Tradeoff;
use heliotile::{Provenance, Resources, Result};

/// `heliotile tradeoff`.
pub fn run(args: &Tradeoff, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::default();
    let resources = Resources::new(args.memory, &terminal);
    let done = args.request.write(about, &resources, say)?;
    say(&format!("{}: open it in a browser\n", done.page.display()))?;
    Ok(Outcome::Fine)
}
