//! The first key of every chunk of cells, by which a reader finds a cell. In: keys. Out: a table,
//! and back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::INDEX;
use crate::archive::tables::cells::{check_keys, keys, pack_tag};
use crate::archive::tables::{Flaw, table};
use crate::site::cells::CellKey;

/// Table that indexes one kind of cells, schema 1: one row a chunk.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct IndexTable {
    /// Voxel of the chunk's first key.
    pub voxel: Vec<[i32; 3]>,
    /// Level and facing of the chunk's first key: [`pack_tag`].
    pub tag: Vec<u32>,
    /// Row of the materials table of the chunk's first key.
    pub material: Vec<u16>,
}

table!(IndexTable, [INDEX]);

impl IndexTable {
    /// Returns the index of chunks that start with these keys.
    pub fn new(firsts: &[CellKey]) -> Self {
        IndexTable {
            voxel: firsts.iter().map(|k| k.voxel).collect(),
            tag: firsts.iter().map(|k| pack_tag(k.level, k.facing)).collect(),
            material: firsts.iter().map(|k| k.material).collect(),
        }
    }

    /// Returns the first key of every chunk.
    pub fn firsts(&self) -> Vec<CellKey> {
        keys(&self.tag, &self.material, &self.voxel).collect()
    }

    /// Returns the number of chunks.
    pub fn rows(&self) -> usize {
        self.voxel.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        check_keys("row", &self.voxel, &self.tag, &self.material)?;
        if self.rows() == 0 { Err(Flaw::new("0 rows", "at least 1")) } else { Ok(()) }
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::block;

    /// Two keys have the known bytes and come back. Keys out of order, and an empty index, are
    /// refused.
    #[test]
    fn layout_is_frozen() {
        let key = |x| CellKey { level: 3, facing: 54, material: 1, voxel: [x, 0, 0] };
        let index = IndexTable::new(&[key(-1), key(2)]);
        let raw = index.to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (60, "3695a58f80601495".to_string()));
        let back = IndexTable::from_block(&block(&index.encode(INDEX, TileNumber(1), 9).unwrap())).unwrap();
        assert_eq!(back.firsts(), [key(-1), key(2)]);
        assert!(IndexTable::new(&[key(2), key(-1)]).to_bytes().is_err() && IndexTable::default().to_bytes().is_err());
    }
}
