//! The parts of an atlas, for programs that build and ask them one by one. In: the place of an atlas. Out: names, squares, archives.

use std::path::{Path, PathBuf};

use glam::DVec2;

use crate::opened::Atlas;
use crate::state::PartState;
use heliotile_builder::transfer::Bounds;
use heliotile_core::error::Result;

/// A part of an atlas.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPart {
    /// What `build --part` takes.
    pub name: String,
    /// South-west and north-east corner of its square, scene coordinates, metres.
    pub low: DVec2,
    /// See `low`.
    pub high: DVec2,
    /// How far beyond its square its receivers may stand, metres.
    pub reach_m: f64,
    /// What there is of it.
    pub state: PartState,
}

/// Parts of an atlas by their names, those that a box touches if there is one.
pub fn parts(atlas: &Path, within: Option<Bounds>) -> Result<Vec<ListedPart>> {
    Atlas::open(atlas)?.parts(within)
}

impl Atlas {
    /// The same of one that is open.
    pub fn parts(&self, within: Option<Bounds>) -> Result<Vec<ListedPart>> {
        let look = |names: &[String]| {
            let there = self.folder.has(names, self.plan.parts.len())?.into_iter();
            Ok(there.zip(names).map(|(there, name)| there.then(|| self.folder.join(name))).collect())
        };
        let listed = self.states(within, look)?.into_iter().map(|(part, state)| {
            let square = self.plan.region_part(part);
            ListedPart { name: part.name.clone(), low: square.low, high: square.high, reach_m: self.reach_m(), state }
        });
        Ok(listed.collect())
    }
}

impl ListedPart {
    /// Its archive, if it is built.
    pub fn archive(&self) -> Option<&PathBuf> {
        match &self.state {
            PartState::Built(path) => Some(path),
            PartState::Empty | PartState::Missing => None,
        }
    }
}
