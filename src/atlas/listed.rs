//! The parts of an atlas, for programs that build and query them one by one. In: the place of an
//! atlas. Out: names, squares, archives.

use std::path::{Path, PathBuf};

use glam::DVec2;
use serde_json::json;

use crate::opened::Atlas;
use crate::state::PartState;
use heliotile_archives::transfer::Bounds;
use heliotile_core::error::Result;

/// A part of an atlas.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPart {
    /// Name of the part, as `build --part` takes it.
    pub name: String,
    /// South-west corner of its square, scene coordinates, metres.
    pub low: DVec2,
    /// North-east corner of its square, scene coordinates, metres.
    pub high: DVec2,
    /// Distance beyond its square at which its receivers may stand, metres.
    pub reach_m: f64,
    /// State of the part, with its archive if it is built.
    pub state: PartState,
}

/// Returns the parts of an atlas in the order of its plan; with `within`, only the parts that this
/// box touches.
pub fn parts(atlas: &Path, within: Option<Bounds>) -> Result<Vec<ListedPart>> {
    Atlas::open(atlas)?.parts(within)
}

impl Atlas {
    /// Returns the parts of this atlas in the order of its plan; with `within`, only the parts that
    /// this box touches.
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
    /// Returns the archive of the part, if it is built.
    pub fn archive(&self) -> Option<&PathBuf> {
        match &self.state {
            PartState::Built(path) => Some(path),
            PartState::Empty | PartState::Missing => None,
        }
    }
}

/// File name of the list.
pub const PARTS: &str = "parts.json";

/// Returns the address of a built part's archive, relative to the folder of the atlas, and the
/// archive's path.
pub fn archive_of(part: &ListedPart) -> Option<(String, &PathBuf)> {
    let path = part.archive()?;
    let file = path.file_name()?.to_string_lossy();
    Some((format!("parts/{}/{file}", part.name), path))
}

/// Returns the list as JSON, one part a line.
pub fn list(parts: &[ListedPart]) -> String {
    let line = |part: &ListedPart| {
        json!({
            "name": part.name, "state": part.state.word(), "low": part.low.to_array(), "high": part.high.to_array(),
            "archive": archive_of(part).map(|(address, _)| address),
        })
        .to_string()
    };
    format!("{{\"parts\": [\n{}\n]}}\n", parts.iter().map(line).collect::<Vec<_>>().join(",\n"))
}
