//! `heliotile export`: pictures of layers, view factors as a table, and the page that shows an
//! archive.

use super::Outcome;
use super::console::terminal::Terminal;
use heliotile::cases::Export;
use heliotile::{Provenance, Resources, Result};

/// `heliotile export`.
pub fn run(args: &Export, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::default();
    let resources = Resources::new(args.memory, &terminal);
    match args.page() {
        Some(page) => page.write(&resources)?,
        None => args.request().write(about, &resources)?,
    }
    Ok(Outcome::Fine)
}
