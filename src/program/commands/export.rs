//! `heliotile export`: pictures of layers, view factors as a table, and the page that shows an
//! archive; and `heliotile report`: a statement about tables.

use super::Outcome;
use super::console::terminal::Terminal;
use super::console::voice::remark_aside;
use heliotile::cases::Export;
use heliotile::{Provenance, ReportRequest, Resources, Result};

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

/// `heliotile report`.
pub fn report(args: &ReportRequest, about: Provenance) -> Result<Outcome> {
    let done = args.write(&about, &Terminal::default())?;
    // Standard output may hold the page, so the remark goes to standard error.
    remark_aside(format!("{}\n", done.text()));
    Ok(Outcome::Fine)
}
