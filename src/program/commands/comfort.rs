//! `heliotile comfort`: thermal comfort of people outdoors.

use std::path::PathBuf;

use super::Outcome;
use super::console::terminal::Terminal;
use crate::commands::console::voice::remark_aside;
use heliotile::cases::Comfort;
use heliotile::memory::SystemTemp;
use heliotile::scene::input;
use heliotile::text::counted;
use heliotile::{Error, Observer, Provenance, Resources, Result, Site, SiteOptions};

/// Refuses positions of people if an archive holds them already.
fn check(args: &Comfort) -> Result<()> {
    let people = &args.people;
    if args.place().is_some() && (people.points.is_some() || !people.folder.as_os_str().is_empty() || people.replace) {
        let what = "apply to scene files only: an archive states where people stand";
        let hint = "leave them out, or give the scene files in place of the archive";
        return Err(Error::argument("points, folder, replace", what, hint));
    }
    Ok(())
}

/// `heliotile comfort`.
pub fn run(args: &Comfort, about: Provenance) -> Result<Outcome> {
    check(args)?;
    let terminal = Terminal::watching_beside_table();
    let memory = args.memory;
    let resources = Resources { memory, storage: &SystemTemp, files: &input::read, observer: &terminal };
    let (request, files) = (args.request(), &args.files);
    let place = match args.place() {
        Some(place) => place.to_path_buf(),
        None => {
            let site = args.site();
            request.check(files, &site.scene.files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
            site.build(Some(&request), &resources)?
        }
    };
    let site = Site::open_with(place, SiteOptions { memory, about, ..SiteOptions::default() })?;
    site.note_of_north().iter().for_each(|note| terminal.note(note));
    let done = site.comfort(&request, files, &resources)?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(&format!("{} in {}\n", counted(done.points, "point"), counted(done.hours, "hour")));
    Ok(Outcome::Fine)
}
