//! Archives that results come from. In: open archives. Out: one archive, or several that share a
//! scene's settings and place.

use std::path::Path;

use crate::outputs::provenance::Provenance;
use heliotile_core::archive::{Archive, Manifest, format};
use heliotile_core::error::{Error, Problem, Result};

/// Opened archives that are owned, at least one.
pub struct Sources {
    first: Archive,
    others: Vec<Archive>,
}

/// Borrowed archives, at least one.
#[derive(Clone, Copy)]
pub struct Archives<'a> {
    first: &'a Archive,
    others: &'a [Archive],
}

impl Sources {
    /// Returns `archives` in the order of results. Errors: no archive (`none` makes the error), or
    /// archives that cannot share one table.
    pub fn new(archives: Vec<Archive>, none: impl FnOnce() -> Error) -> Result<Self> {
        let mut archives = archives.into_iter();
        let first = archives.next().ok_or_else(none)?;
        let others: Vec<Archive> = archives.collect();
        others.iter().try_for_each(|other| check_fit(&first, other))?;
        Ok(Sources { first, others })
    }

    /// Returns all archives, in the order of results.
    pub fn into_archives(self) -> impl Iterator<Item = Archive> {
        std::iter::once(self.first).chain(self.others)
    }

    /// Returns the archives borrowed.
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
    /// Returns one archive by itself.
    pub fn one(archive: &'a Archive) -> Self {
        Archives { first: archive, others: &[] }
    }

    /// Returns all archives, in the order of results.
    pub fn iter(self) -> impl Iterator<Item = &'a Archive> {
        std::iter::once(self.first).chain(self.others)
    }

    /// Returns the first archive's manifest. Place and settings in it hold for all archives; all
    /// else holds for the first only.
    pub fn manifest(self) -> &'a Manifest {
        self.first.manifest()
    }

    /// Returns the archive if there is exactly one.
    pub fn only(self) -> Option<&'a Archive> {
        self.others.is_empty().then_some(self.first)
    }

    /// Returns the first archive.
    pub fn first(self) -> &'a Archive {
        self.first
    }

    /// Returns the root of the only archive, or one root made of the roots of an atlas's parts.
    pub fn root(self) -> String {
        match self.only() {
            Some(archive) => format::hex(&archive.root()),
            None => Provenance::root_of_parts(&self.iter().map(Archive::root).collect::<Vec<_>>()),
        }
    }

    /// Adds the sources to `about`: the archive at `place`, or the atlas at `place` and the roots
    /// of its parts in their order.
    pub fn told_in(self, about: Provenance, place: &Path) -> Provenance {
        match self.only() {
            Some(archive) => about.with_archive(place, archive),
            None => about.with_parts(place, &self.iter().map(Archive::root).collect::<Vec<_>>()),
        }
    }
}

/// Checks that two archives can share one table: equal settings, and a known place in both or in
/// neither.
fn check_fit(first: &Archive, other: &Archive) -> Result<()> {
    let [a, b] = [first, other].map(Archive::manifest);
    let what = match () {
        () if a.settings.hash()? != b.settings.hash()? => "other settings",
        () if a.place.is_some() != b.place.is_some() => "another place",
        () => return Ok(()),
    };
    let what = format!("was built with {what} than {}", first.path().display());
    Err(Error::input(other.path(), None, what, "build the part again, with {part} K and {fresh}")
        .because(Problem::OtherInputs))
}
