//! What a scene is made of. In: files on the command line. Out: one part for each, with its materials and its place.

use std::path::{Path, PathBuf};

use glam::DVec3;

/// Files that make up one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Site {
    pub parts: Vec<Part>,
}

/// One file of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub file: PathBuf,
    /// Its `materials.toml`; without one, what the file itself says.
    pub materials: Option<PathBuf>,
    /// Added to every position after `scale` and `y_up`, metres.
    pub offset: DVec3,
    /// Metres a unit of the file.
    pub scale: f64,
    /// Whether y points up and z south in the file, in place of z up and y north.
    pub y_up: bool,
    /// Level of detail where an object carries several; the finest without it.
    pub lod: Option<String>,
}

impl Part {
    /// A file in metres, where it says that it lies.
    pub fn plain(file: &Path, materials: Option<&Path>) -> Part {
        Part {
            file: file.to_owned(),
            materials: materials.map(Path::to_owned),
            offset: DVec3::ZERO,
            scale: 1.0,
            y_up: false,
            lod: None,
        }
    }

    /// Where a position of the file lies in the scene.
    pub(super) fn place(&self, p: DVec3) -> DVec3 {
        let p = p * self.scale;
        let p = if self.y_up { DVec3::new(p.x, -p.z, p.y) } else { p };
        p + self.offset + 0.0
    }
}
