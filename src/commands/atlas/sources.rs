//! The archives that results are made of. In: an archive, or an atlas and the box that is asked for. Out: the archive, or those of the parts
//! that the box touches, of one scene's settings and place.

use std::path::Path;

use super::opened::Atlas;
use crate::files::open_archive;
use crate::outputs::provenance::Provenance;
use heliotile_builder::build::Workspace;
use heliotile_builder::transfer::{Bounds, Selection};
use heliotile_core::archive::{Access, Archive, Manifest};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
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

/// Those of the parts of an atlas, at its place, that a box touches. A part that is not built is an error.
pub fn archives(atlas: &Path, within: Option<Bounds>, access: Access) -> Result<Sources> {
    Sources::of_atlas(&Atlas::open(atlas)?, within, access)
}

/// The archive at a place; of an atlas there that of the part which holds the receivers that are chosen. An error: several parts hold some.
pub fn holding(place: &Path, chosen: &Selection, access: Access, workspace: &Workspace) -> Result<Archive> {
    let Some(atlas) = Atlas::find(place)? else { return open_archive(place, access) };
    let within = if let Selection::Bounds(bounds) = chosen { Some(*bounds) } else { None };
    let sources = Sources::of_atlas(&atlas, within, access)?;
    let counts = {
        let sites = sources.borrowed().iter().map(OpenSite::of).collect::<Result<Vec<_>>>()?;
        let kept = chosen.resolve(&sites, &workspace.folder, workspace.memory.length(Use::ReceiverList))?;
        let mut kept = kept.into_iter();
        let count = |site: &OpenSite| kept.by_ref().take(site.receivers() as usize).filter(|kept| *kept).count();
        sites.iter().map(count).collect::<Vec<_>>()
    };
    let archives = std::iter::once(sources.first).chain(sources.others).zip(counts);
    let mut holding: Vec<Archive> = archives.filter_map(|(archive, count)| (count > 0).then_some(archive)).collect();
    match (holding.pop(), holding.len()) {
        (Some(only), 0) => Ok(only),
        (last, others) => {
            let what = format!("{} parts of it hold receivers that are chosen, and one is taken", others + 1);
            let named = last.map(|archive| archive.path().display().to_string()).unwrap_or_default();
            Err(Error::input(&atlas.shown(), None, what, format!("name the archives one by one, such as {named}")))
        }
    }
}

impl Sources {
    /// The archive at a place, or those of all parts of an atlas there.
    pub fn open(place: &Path, access: Access) -> Result<Self> {
        match Atlas::find(place)? {
            Some(atlas) => Sources::of_atlas(&atlas, None, access),
            None => open_archive(place, access).map(Sources::from),
        }
    }

    /// Those of the parts of an atlas that a box touches.
    pub fn of_atlas(atlas: &Atlas, within: Option<Bounds>, access: Access) -> Result<Self> {
        let mut archives = atlas.archives(within, access)?.into_iter();
        let Some(first) = archives.next() else {
            let what = "no part of it holds a receiver of what is asked for";
            return Err(Error::input(&atlas.shown(), None, what, "a box is in the coordinates of the scene files"));
        };
        let others: Vec<Archive> = archives.collect();
        others.iter().try_for_each(|other| check_fit(&first, other))?;
        Ok(Sources { first, others })
    }

    /// To be asked.
    pub fn borrowed(&self) -> Archives<'_> {
        Archives { first: &self.first, others: &self.others }
    }
}

impl From<Archive> for Sources {
    fn from(first: Archive) -> Self {
        Sources { first, others: Vec::new() }
    }
}

impl<'a> Archives<'a> {
    /// One archive by itself.
    pub fn one(archive: &'a Archive) -> Self {
        Archives { first: archive, others: &[] }
    }

    /// All of them, in the order of results.
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

    /// The first one.
    pub fn first(self) -> &'a Archive {
        self.first
    }

    /// What is known of results, with the archive at a place, or the atlas there and the roots of its parts in their order.
    pub fn told_in(self, about: Provenance, place: &Path) -> Provenance {
        match self.only() {
            Some(archive) => about.with_archive(place, archive),
            None => about.with_parts(place, &self.iter().map(Archive::root).collect::<Vec<_>>()),
        }
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
