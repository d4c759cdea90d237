//! An open atlas, in a folder or below an address. In: its place. Out: its plan, read once; the
//! state of its parts; their archives.

use std::path::Path;

use glam::DVec2;

use crate::plan::{AtlasPlan, FILE, PlannedPart};
use crate::state::PartState;
use heliotile_archives::transfer::Bounds;
use heliotile_core::archive::format::{BlockKind, Entry};
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::opened::{OpenSite, tiles_within};
use heliotile_core::text::message;
use heliotile_remote::Directory;
use heliotile_remote::naming::{is_address, shown};
use heliotile_remote::places::find_archive;

/// Most parts that a message names.
const NAMED: usize = 5;

/// Kinds of blocks that every computation of results reads first.
const READ_FIRST: [BlockKind; 7] = [
    format::MATERIALS,
    format::OPTICS,
    format::MIRRORS,
    format::BANDS,
    format::RECEIVERS,
    format::PARTS,
    format::EXTENTS,
];

/// Distance that rounding may move a receiver, metres.
const ROUNDING_M: f64 = 0.01;

/// A region in parts.
pub struct Atlas {
    /// Folder of the atlas.
    pub folder: Directory,
    /// Plan of the atlas, as it was when it was opened; all requests use this one.
    pub plan: AtlasPlan,
}

/// Refuses an archive with receivers farther than `reach_m` from the square between `low` and
/// `high`, the square of the part of this name.
pub fn check_square(archive: &Archive, part: &str, low: DVec2, high: DVec2, reach_m: f64) -> Result<()> {
    let within = [(low - reach_m).extend(f64::NEG_INFINITY), (high + reach_m).extend(f64::INFINITY)];
    if tiles_within(&OpenSite::open(archive)?, within)?.len() == archive.tiles() as usize {
        return Ok(());
    }
    let what = format!("holds receivers outside the square of part {part}");
    let hint = message!(
        "it belongs to another part: build {part} again with {{command:build}} ATLAS {{part}} {part} {{fresh}}"
    );
    Err(Error::input(archive.path(), None, what, hint).because(Problem::OtherSite))
}

impl Atlas {
    /// Opens the atlas at a place, or returns `None` if the place holds something else.
    pub fn find(place: &Path) -> Result<Option<Self>> {
        let is_archive = || shown(place).extension().is_some_and(|ending| ending == "helio");
        if is_address(place) && is_archive() {
            return Ok(None);
        }
        let folder = Directory::at(place);
        let Some(bytes) = folder.read(FILE, false)? else { return Ok(None) };
        let plan = AtlasPlan::of_file(&shown(&folder.join(FILE)), &bytes)?;
        Ok(Some(Atlas { folder, plan }))
    }

    /// Opens the atlas at a place. An error: no atlas is there.
    pub fn open(place: &Path) -> Result<Self> {
        Ok(Atlas { folder: Directory::at(place), plan: AtlasPlan::read(place)? })
    }

    /// Returns the name of the atlas for messages.
    pub fn shown(&self) -> std::path::PathBuf {
        shown(self.folder.place())
    }

    /// Returns the distance beyond the square of its part at which a receiver may stand, metres:
    /// the point of the surface below the receiver lies in the square.
    pub fn reach_m(&self) -> f64 {
        self.plan.cut.cover.offset_m.abs() + ROUNDING_M
    }

    /// Returns the parts whose receivers may stand in a box, or all parts without a box.
    fn touched(&self, within: Option<Bounds>) -> Vec<&PlannedPart> {
        let reach = self.reach_m();
        let touches = |part: &&PlannedPart| {
            within.is_none_or(|bounds| self.plan.region_part(part).touches(bounds.low - reach, bounds.high + reach))
        };
        self.plan.parts.iter().filter(touches).collect()
    }

    /// Returns the state of each part that a box touches. `look` gets the names of the archives in
    /// the folder and returns for each what it found, or `None`.
    pub fn states<A>(
        &self,
        within: Option<Bounds>,
        look: impl FnOnce(&[String]) -> Result<Vec<Option<A>>>,
    ) -> Result<Vec<(&PlannedPart, PartState<A>)>> {
        let parts = self.touched(within);
        let found = look(&parts.iter().map(|part| part.archive()).collect::<Vec<_>>())?;
        let rest = parts.iter().zip(&found).filter(|(_, found)| found.is_none());
        let rest: Vec<String> = rest.map(|(part, _)| part.empty_marker()).collect();
        let mut empty = self.folder.has(&rest, self.plan.parts.len())?.into_iter();
        let state = |found: Option<A>| match found {
            Some(archive) => PartState::Built(archive),
            None if empty.next() == Some(true) => PartState::Empty,
            None => PartState::Missing,
        };
        Ok(parts.into_iter().zip(found.into_iter().map(state)).collect())
    }

    /// Returns the state of all parts, with the result of `about` for each archive. An archive is
    /// open only while `about` runs.
    pub fn each_archive<T: Send>(
        &self,
        about: impl Fn(Archive) -> T + Sync,
    ) -> Result<Vec<(&PlannedPart, PartState<T>)>> {
        let open = |name: &String| Ok(find_archive(&self.folder.join(name), Access::Read)?.map(&about));
        self.states(None, |names| self.folder.each(names, open))
    }

    /// Refuses an archive whose receivers do not stand in the square of `part`, as it belongs to
    /// another part.
    pub fn check_place(&self, part: &PlannedPart, archive: &Archive) -> Result<()> {
        let square = self.plan.region_part(part);
        check_square(archive, &part.name, square.low, square.high, self.reach_m())
    }

    /// Opens the archives of the parts that a box touches, in the order of the plan, and announces
    /// the blocks that are read first. An error: a part that is not built.
    pub fn archives(&self, within: Option<Bounds>, access: Access) -> Result<Vec<Archive>> {
        let open = |name: &String| {
            let archive = find_archive(&self.folder.join(name), access)?;
            if let Some(archive) = &archive {
                let first = archive.entries().iter().filter(|entry| READ_FIRST.contains(&entry.kind));
                archive.expect(first.map(Entry::key));
            }
            Ok(archive)
        };
        // All archives are opened before one is read, so that their first blocks arrive together.
        let parts = self.states(within, |names| self.folder.each(names, open))?;
        for (part, state) in &parts {
            if let PartState::Built(archive) = state {
                self.check_place(part, archive)?;
            }
        }
        let is_missing = |state: &PartState<Archive>| matches!(state, PartState::Missing);
        let missing = parts.iter().filter(|(_, state)| is_missing(state)).map(|(part, _)| part.name.as_str());
        let missing: Vec<&str> = missing.collect();
        let Some(first) = missing.first() else {
            let archive = |(_, state)| if let PartState::Built(archive) = state { Some(archive) } else { None };
            return Ok(parts.into_iter().filter_map(archive).collect());
        };
        let hint = message!(
            "build it with {{command:build}} {} {{part}} {first}, or choose other parts with {{bbox}}",
            self.shown().display()
        );
        let named = missing.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
        let verb = if missing.len() == 1 { "is" } else { "are" };
        let what = format!("{} of its parts {verb} not built yet: {named}", missing.len());
        Err(Error::input(&self.shown(), None, what, hint).because(Problem::Lacks("parts")))
    }
}
