//! What a table is made of. In: a command line. Out: archives that are open, and which way their north lies.

use std::fs;

use crate::cli::TableArgs;
use crate::commands::atlas::opened::Atlas;
pub use crate::commands::atlas::sources::{Archives, Sources};
use crate::commands::voice::remark_aside;
use crate::files::open_archive;
use heliotile_core::archive::{Access, Archive, Manifest};
use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;

/// Opens the archive, or the parts of the atlas that a box touches.
pub fn open(args: &TableArgs) -> Result<Sources> {
    match Atlas::find(&args.archive)? {
        Some(atlas) => Sources::of_atlas(&atlas, args.of.bbox, args.io.unwrap_or_default()),
        None => open_archive(&args.archive, access(args)).map(Sources::from),
    }
}

/// Pages of a mapping count as memory of the program for as long as the system likes: a large archive is read instead.
fn access(args: &TableArgs) -> Access {
    let large = || fs::metadata(&args.archive).is_ok_and(|about| about.len() > args.memory.0 / 4);
    args.io.unwrap_or_else(|| if large() { Access::Read } else { Access::Mapped })
}

/// Says where true north is, if suns are turned to it.
pub fn say_north(args: &TableArgs, manifest: &Manifest) {
    let place = manifest.place.filter(|_| !args.grid_north);
    // Standard output may be the table.
    place.and_then(|place| place.note()).iter().for_each(|note| remark_aside(&format!("{note}\n")));
}

/// The site of an archive, with the north that is asked for.
pub fn site_of<'a>(args: &TableArgs, archive: &'a Archive) -> Result<OpenSite<'a>> {
    let site = OpenSite::of(archive)?;
    Ok(if args.grid_north { site.with_y_for_north() } else { site })
}
