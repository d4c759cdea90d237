//! The parts of an atlas, for programs that build and ask them one by one. In: the folder of an atlas. Out: names, squares, archives.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::part::{PartState, state};
use super::plan::AtlasPlan;
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
    /// What there is of it.
    pub state: PartState,
}

/// Parts of an atlas by their names, those that a box touches if there is one.
pub fn parts(atlas: &Path, within: Option<Bounds>) -> Result<Vec<ListedPart>> {
    let plan = AtlasPlan::read(atlas)?;
    let listed = plan.parts.iter().filter_map(|part| {
        let square = plan.region_part(part);
        let touched = within.is_none_or(|bounds| square.touches(bounds.low, bounds.high));
        let (low, high) = (square.low, square.high);
        touched.then(|| ListedPart { name: part.name.clone(), low, high, state: state(atlas, part) })
    });
    Ok(listed.collect())
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
