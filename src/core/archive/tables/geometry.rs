//! Triangles of the scene. In: vertices and triangles. Out: a table, and back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_MATERIALS, SCENE};
use crate::archive::tables::{Flaw, column, table};
use crate::site::grid::MAX_M;

/// Table of the triangles of a chunk, a row each, and of their vertices, schema 1. Chunks hold the
/// scene's triangles in its order, each with its own vertices.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct GeometryTable {
    /// Positions relative to the scene's origin, metres, as they were traced.
    pub vertex: Vec<[f32; 3]>,
    /// Corners of the triangle, rows of `vertex`, in the winding of the input.
    pub corner: Vec<[u32; 3]>,
    /// Row of the materials table.
    pub material: Vec<u16>,
}

table!(GeometryTable, [SCENE]);

/// Largest number of triangles of a chunk.
pub const MAX_TRIANGLES: usize = 1 << 16;

impl GeometryTable {
    /// Returns the number of triangles.
    pub fn rows(&self) -> usize {
        self.corner.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let (rows, vertices) = (self.rows(), self.vertex.len());
        if rows == 0 || rows > MAX_TRIANGLES {
            return Err(Flaw::new(format!("{rows} triangles"), format!("1 to {MAX_TRIANGLES}")));
        }
        if vertices > rows.saturating_mul(3) {
            return Err(Flaw::new(format!("{vertices} vertices"), format!("3 at most for each of {rows} triangles")));
        }
        let near = |vertex: &[f32; 3]| vertex.iter().all(|x| f64::from(x.abs()) <= MAX_M);
        column("vertex", &self.vertex, vertices, "2^20 m from the origin at most", near)?;
        let there = |corners: &[u32; 3]| corners.iter().all(|&corner| (corner as usize) < vertices);
        column("corner", &self.corner, rows, "rows of the vertices", there)?;
        column("material", &self.material, rows, "a row of the materials", |row| usize::from(*row) < MAX_MATERIALS)
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};

    fn two() -> GeometryTable {
        GeometryTable {
            vertex: vec![[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 1.0, -0.25], [0.0, 1.0, 0.0]],
            corner: vec![[0, 1, 2], [0, 2, 3]],
            material: vec![1, 0],
        }
    }

    /// Known values have the known 100 bytes and come back. None of more than 800 changes of a bit
    /// and cuts ends the program.
    #[test]
    fn layout_is_frozen() {
        let (known, raw) = (two(), two().to_bytes().unwrap());
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (100, "b0fe0613e95c96d2".to_string()));
        assert_eq!(
            GeometryTable::from_block(&block(&known.encode(SCENE, TileNumber::FIRST, 9).unwrap())).unwrap(),
            known
        );
        let (refused, accepted) = hostile(SCENE, 2, &raw, |block| GeometryTable::from_block(block).map(|_| ()));
        assert!(refused > 100 && refused + accepted > 800, "{refused} {accepted}");
    }

    /// Each of 6 values out of range is refused.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut GeometryTable); 6] = [
            |g| g.vertex[0][1] = f32::NAN,
            |g| g.vertex[2][0] = 2e6,
            |g| g.corner[1][2] = 4,
            |g| g.material.truncate(1),
            |g| g.vertex.resize(7, [0.0; 3]),
            |g| {
                g.corner.clear();
                g.material.clear();
            },
        ];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = two();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 6);
    }
}
