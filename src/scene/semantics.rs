//! What files say of their faces and objects besides where they are. In: semantic surfaces, surface types, boundary conditions. Out: a
//! kind for each face that has one, and names of what it is a part of.

use std::fmt::Write as _;

/// What a surface is for who puts receivers on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SurfaceKind {
    /// A roof of a building; without semantics, what looks up and is no ground.
    Roof,
    /// A wall of a building, its doors too; without semantics, what is about vertical.
    Wall,
    /// A window, glazed door or skylight; without semantics, a surface of stated glass.
    Window,
    /// Terrain, streets, water; without semantics, what is of class ground.
    Ground,
    /// What looks down: the floor of a storey that juts out, the underside of a building.
    Floor,
    /// A surface that only shades: an overhang, a screen, a neighbour as a model of a building knows it.
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

    /// As options, tables and names of surfaces call it.
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

/// What a reader knows of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaceNote {
    /// What it is, if the file says so.
    pub kind: Option<SurfaceKind>,
    /// Whether the sun may reach it, if the file says so.
    pub exposed: Option<bool>,
    /// Where its file has it.
    pub source: FaceSource,
}

/// Where a face stands in its file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceSource {
    /// So many faces stand before it; a line is better where the format has lines.
    #[default]
    Order,
    /// Its name is that of its object.
    Named,
    /// A face of a city object: number of its geometry, and its place in the `boundaries`, as deep as there are arrays (1 to 3).
    Boundary {
        /// Counted from 0.
        geometry: u32,
        /// Counted from 0.
        path: [u32; 3],
        /// How many numbers of `path` count.
        depth: u8,
    },
}

/// A face of a scene as receivers on it name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SourceFace {
    /// What its reader knows.
    pub note: FaceNote,
    /// 1-based line; 0 where the format has none.
    pub line: u32,
    /// 1-based number in the file.
    pub number: u32,
}

impl SourceFace {
    /// Its name in tables, given that of its object.
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
    fn names() {
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
