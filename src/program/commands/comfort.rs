//! `heliotile comfort`: thermal comfort of people outdoors.

use super::Outcome;
use super::console::terminal::Terminal;
use crate::commands::console::voice::{note, remark_aside};
use heliotile::cases::Comfort;
use heliotile::text::counted;
use heliotile::{Provenance, Resources, Result, Site, SiteOptions};

/// `heliotile comfort`.
pub fn run(args: &Comfort, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching_beside_table();
    let resources = Resources::new(args.memory, &terminal);
    let (request, files) = (args.request(), &args.files);
    let place = args.archive(Some(&request), &resources)?;
    let site = Site::open_with(place, SiteOptions { memory: args.memory, about, ..SiteOptions::default() })?;
    site.note_of_north().iter().for_each(note);
    let done = site.comfort(&request, files, &resources)?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(format!("{} in {}\n", counted(done.points, "point"), counted(done.hours, "hour")));
    Ok(Outcome::Fine)
}
