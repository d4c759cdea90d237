//! The archives that results are made of. In: archives that are open. Out: one, or several of one scene's settings and place.

use std::path::Path;

use crate::outputs::provenance::Provenance;
use heliotile_core::archive::{Archive, Manifest, format};
use heliotile_core::error::{Error, Result};

/// Opened archives, at least one.
pub struct Sources {
    first: Archive,
    others: Vec<Archive>,
}

/// Archives that others hold, at least one.
#[derive(Clone, Copy)]
pub struct Archives<'a> {
    first: &'a Archive,
    others: &'a [Archive],
}

impl Sources {
    /// Archives in the order of results. An error: none (`none` says so), or some that cannot stand in one table.
    pub fn of(archives: Vec<Archive>, none: impl FnOnce() -> Error) -> Result<Self> {
        let mut archives = archives.into_iter();
        let first = archives.next().ok_or_else(none)?;
        let others: Vec<Archive> = archives.collect();
        others.iter().try_for_each(|other| check_fit(&first, other))?;
        Ok(Sources { first, others })
    }

    /// All of them.
    pub fn into_archives(self) -> impl Iterator<Item = Archive> {
        std::iter::once(self.first).chain(self.others)
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

    /// The root of the archive, or one for those of the parts of an atlas.
    pub fn root(self) -> String {
        match self.only() {
            Some(archive) => format::hex(&archive.root()),
            None => Provenance::root_of_parts(&self.iter().map(Archive::root).collect::<Vec<_>>()),
        }
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
    Err(Error::input(other.path(), None, what, "build the part again, with {part} K and {fresh}"))
}
