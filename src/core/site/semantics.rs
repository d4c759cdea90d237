//! Semantics: the kinds and names that files state of faces and objects besides their geometry. In:
//! semantic surfaces, surface types, boundary conditions. Out: a kind for each face that has one,
//! and the names of what it is a part of.

use std::fmt::Write as _;

/// Kind of a surface, by which surfaces are selected for receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SurfaceKind {
    /// A roof of a building; without semantics, a face that looks up and is not ground.
    Roof,
    /// A wall of a building, including its doors; without semantics, a nearly vertical face.
    Wall,
    /// A window, glazed door or skylight; without semantics, a surface of stated glass.
    Window,
    /// Terrain, streets, water; without semantics, a surface of class ground.
    Ground,
    /// A surface that looks down: the floor of a storey that juts out, the underside of a building.
    Floor,
    /// A surface that only shades: an overhang, a screen, a neighbour in a building model.
    Shade,
}

impl SurfaceKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [SurfaceKind; 6] = [
        SurfaceKind::Roof,
        SurfaceKind::Wall,
        SurfaceKind::Window,
        SurfaceKind::Ground,
        SurfaceKind::Floor,
        SurfaceKind::Shade,
    ];

    /// Returns the name of the kind in options, tables and names of surfaces.
    pub fn name(self) -> &'static str {
        match self {
            SurfaceKind::Roof => "roof",
            SurfaceKind::Wall => "wall",
            SurfaceKind::Window => "window",
            SurfaceKind::Ground => "ground",
            SurfaceKind::Floor => "floor",
            SurfaceKind::Shade => "shade",
        }
    }
}

/// Statements of a file on a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaceNote {
    /// Kind of the face, if the file states it.
    pub kind: Option<SurfaceKind>,
    /// True if the sun may reach the face, false if not; `None` if the file does not state it.
    pub exposed: Option<bool>,
    /// Position of the face in its file.
    pub source: FaceSource,
}

/// Position of a face in its file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceSource {
    /// A face known by its line or, if the format has no lines, by its number in the file.
    #[default]
    Order,
    /// A face that has the name of its object.
    Named,
    /// A face of a city object: number of its geometry, and its place in the `boundaries`, as deep
    /// as there are arrays (1 to 3).
    Boundary {
        /// Number of the geometry, from 0.
        geometry: u32,
        /// Indices in the nested arrays, from 0.
        path: [u32; 3],
        /// Number of indices of `path` that count.
        depth: u8,
    },
}

/// A face of a scene as receivers on it name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SourceFace {
    /// Statements of its file.
    pub note: FaceNote,
    /// Line of the file, from 1; 0 if the format has no lines.
    pub line: u32,
    /// Number in the file, from 1.
    pub number: u32,
}

impl SourceFace {
    /// Returns the name of the face in tables; `object` is the name of its object.
    pub fn name(&self, object: &str) -> String {
        match self.note.source {
            FaceSource::Named => object.to_owned(),
            FaceSource::Boundary { geometry, path, depth } => {
                let mut name = format!("geometry[{geometry}].boundaries");
                for number in path.iter().take(usize::from(depth)) {
                    // Writing to a string cannot fail.
                    let _ = write!(name, "[{number}]");
                }
                name
            }
            FaceSource::Order if self.line > 0 => format!("line {}", self.line),
            FaceSource::Order => format!("face {}", self.number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face is named after its object, its place in a solid, its line or its number: 4 of 4.
    #[test]
    fn a_face_is_named_after_its_source() {
        let named = |source, line, number| {
            SourceFace { note: FaceNote { source, ..FaceNote::default() }, line, number }.name("Wall 1")
        };
        let boundary = FaceSource::Boundary { geometry: 2, path: [0, 17, 9], depth: 2 };
        assert_eq!(named(FaceSource::Named, 8, 1), "Wall 1");
        assert_eq!(named(boundary, 8, 1), "geometry[2].boundaries[0][17]");
        assert_eq!(named(FaceSource::Order, 8, 1), "line 8");
        assert_eq!(named(FaceSource::Order, 0, 3), "face 3");
    }
}
