//! The archives that results are made of. In: an archive's place, or an atlas with what of it is asked for. Out: the archive, or those parts
//! that hold what is asked for, of one scene's settings and place.

use std::fs;

use crate::cli::TableArgs;
use crate::commands::atlas::opened::Atlas;
use crate::commands::voice::remark_aside;
use crate::files::open_archive;
use heliotile_core::archive::{Access, Archive, Manifest};
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;

/// Opened archives, at least one.
pub struct Sources {
    first: Archive,
    others: Vec<Archive>,
}

/// The same, held by somebody.
#[derive(Clone, Copy)]
pub struct Archives<'a> {
    first: &'a Archive,
    others: &'a [Archive],
}

impl Sources {
    /// Opens what a table is made of.
    pub fn open(args: &TableArgs) -> Result<Self> {
        let Some(atlas) = Atlas::find(&args.archive)? else {
            return Ok(Sources { first: open_archive(&args.archive, access(args))?, others: Vec::new() });
        };
        let mut archives = atlas.archives(args.of.bbox, args.io.unwrap_or_default())?.into_iter();
        let Some(first) = archives.next() else {
            let what = "no part of it holds a receiver of what is asked for";
            return Err(Error::input(&atlas.shown(), None, what, "--bbox is in the coordinates of the scene files"));
        };
        let others: Vec<Archive> = archives.collect();
        others.iter().try_for_each(|other| check_fit(&first, other))?;
        Ok(Sources { first, others })
    }

    pub fn borrowed(&self) -> Archives<'_> {
        Archives { first: &self.first, others: &self.others }
    }
}

impl<'a> Archives<'a> {
    /// One archive by itself.
    pub fn one(archive: &'a Archive) -> Self {
        Archives { first: archive, others: &[] }
    }

    pub fn iter(self) -> impl Iterator<Item = &'a Archive> {
        std::iter::once(self.first).chain(self.others)
    }

    /// What all of them state: place, settings. What each states of its own is that of the first.
    pub fn manifest(self) -> &'a Manifest {
        self.first.manifest()
    }

    /// If it is one.
    pub fn only(self) -> Option<&'a Archive> {
        self.others.is_empty().then_some(self.first)
    }

    pub fn first(self) -> &'a Archive {
        self.first
    }

    /// The roots of all, in their order.
    pub fn roots(self) -> Vec<[u8; 32]> {
        self.iter().map(Archive::root).collect()
    }
}

/// Refuses parts that cannot stand in one table.
fn check_fit(first: &Archive, other: &Archive) -> Result<()> {
    let [a, b] = [first, other].map(Archive::manifest);
    let what = match () {
        () if a.settings.hash()? != b.settings.hash()? => "other settings",
        () if a.place.is_some() != b.place.is_some() => "another place",
        () => return Ok(()),
    };
    let what = format!("was built with {what} than {}", first.path().display());
    Err(Error::input(other.path(), None, what, "build the part again, with `heliotile build ATLAS --part K --fresh`"))
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
