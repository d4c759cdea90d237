//! A chunk of cells, sorted by key; probes and bounce cells have the same columns. In: cells. Out:
//! a table, and back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{BOUNCE, PROBES};
use crate::archive::tables::{Flaw, column, flat_column, length_in, table};
use crate::layers::cells;
use crate::layers::cells::CHUNK_SEEN;
use crate::site::cells::CellKey;

/// Returns level and facing of a cell as one number that sorts as they do.
pub fn pack_tag(level: i8, facing: u8) -> u32 {
    let [level] = level.to_be_bytes();
    // Flipping the sign bit adds 128: -128 becomes 0.
    u32::from(level ^ 0x80) << 8 | u32::from(facing)
}

/// Returns level and facing of a tag; `None` beyond 16 bits.
pub fn unpack_tag(tag: u32) -> Option<(i8, u8)> {
    let [level, facing] = u16::try_from(tag).ok()?.to_be_bytes();
    Some((i8::from_be_bytes([level ^ 0x80]), facing))
}

/// Table of the cells of one chunk, schema 4.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct CellsTable {
    /// Voxel of the cell at its level.
    pub voxel: Vec<[i32; 3]>,
    /// Level and facing: [`pack_tag`].
    pub tag: Vec<u32>,
    /// Row of the materials table.
    pub material: Vec<u16>,
    /// Mean of the unit normals of the cell's points, so at most 1 long.
    pub normal: Vec<[f32; 3]>,
    /// `[cell][byte]`: sky bits, world frame, lowest bit first.
    pub bits: Vec<u8>,
    /// Voxels of the bounce cells that rays of the chunk met.
    pub seen_voxel: Vec<[i32; 3]>,
    /// Levels and facings ([`pack_tag`]), row by row as `seen_voxel`.
    pub seen_tag: Vec<u32>,
    /// Rows of the materials table, row by row as `seen_voxel`.
    pub seen_material: Vec<u16>,
    /// `[cell][ray]`: row of the cells seen, and a flag; see `schema/layers.md`.
    pub hits: Vec<u16>,
    /// `[cell]`: 1 where some of the cell's points seemed hidden, else 0.
    pub doubtful: Vec<u8>,
}

table!(CellsTable, [PROBES, BOUNCE]);

/// Flag of a ray below the horizon.
const DOWN: u16 = 1 << 15;
/// Row of a ray that met nothing, in 16 bits.
const MISS: u16 = DOWN - 1;

impl CellsTable {
    /// Returns the table of a chunk, which sees at most 32,767 cells.
    pub fn new(cells: &cells::Cells) -> Self {
        let narrow = |&hit: &u32| {
            let down = if hit & cells::DOWN == 0 { 0 } else { DOWN };
            u16::try_from(hit & !cells::DOWN).unwrap_or(MISS).min(MISS) | down
        };
        CellsTable {
            voxel: cells.keys.iter().map(|k| k.voxel).collect(),
            tag: cells.keys.iter().map(tag_of).collect(),
            material: cells.keys.iter().map(|k| k.material).collect(),
            normal: cells.normals.clone(),
            bits: cells.bits.clone(),
            seen_voxel: cells.seen.iter().map(|k| k.voxel).collect(),
            seen_tag: cells.seen.iter().map(tag_of).collect(),
            seen_material: cells.seen.iter().map(|k| k.material).collect(),
            hits: cells.hits.iter().map(narrow).collect(),
            doubtful: cells.doubtful.iter().map(|&doubtful| u8::from(doubtful)).collect(),
        }
    }

    /// Returns the cells of the table.
    pub fn into_cells(self) -> cells::Cells {
        let widen = |&hit: &u16| {
            let down = if hit & DOWN == 0 { 0 } else { cells::DOWN };
            let row = hit & !DOWN;
            down | if row == MISS { cells::MISS } else { u32::from(row) }
        };
        cells::Cells {
            keys: keys(&self.tag, &self.material, &self.voxel).collect(),
            seen: keys(&self.seen_tag, &self.seen_material, &self.seen_voxel).collect(),
            hits: self.hits.iter().map(widen).collect(),
            normals: self.normal,
            bits: self.bits,
            mirrors: Vec::new(),
            canopies: Vec::new(),
            doubtful: self.doubtful.iter().map(|&doubtful| doubtful == 1).collect(),
        }
    }

    /// Returns the number of cells.
    pub fn rows(&self) -> usize {
        self.voxel.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        check_keys("row", &self.voxel, &self.tag, &self.material)?;
        if rows == 0 {
            return Err(Flaw::new("0 rows", "at least 1"));
        }
        column("normal", &self.normal, rows, "length 0 to 1", |n| length_in(n.map(f64::from), 0.0, 1.0))?;
        flat_column("bits", self.bits.len(), rows)?;
        check_keys("seen row", &self.seen_voxel, &self.seen_tag, &self.seen_material)?;
        let seen = self.seen_voxel.len();
        if seen > CHUNK_SEEN {
            return Err(Flaw::new(format!("{seen} cells that are seen"), format!("at most {CHUNK_SEEN}")));
        }
        flat_column("hits", self.hits.len(), rows)?;
        column("hits", &self.hits, self.hits.len(), "a row of seen, or none", |hit| {
            hit & !DOWN == MISS || usize::from(hit & !DOWN) < seen
        })?;
        column("doubtful", &self.doubtful, rows, "0 or 1", |doubtful| *doubtful <= 1)
    }
}

fn tag_of(key: &CellKey) -> u32 {
    pack_tag(key.level, key.facing)
}

/// Iterates over the keys that three checked columns hold.
pub fn keys<'a>(tag: &'a [u32], material: &'a [u16], voxel: &'a [[i32; 3]]) -> impl Iterator<Item = CellKey> + 'a {
    tag.iter().zip(material).zip(voxel).map(|((&tag, &material), &voxel)| {
        let (level, facing) = unpack_tag(tag).unwrap_or_default();
        CellKey { level, facing, material, voxel }
    })
}

/// Checks that columns hold keys in ascending order.
pub fn check_keys(name: &str, voxel: &[[i32; 3]], tag: &[u32], material: &[u16]) -> Result<(), Flaw> {
    let rows = voxel.len();
    column("tag", tag, rows, "a level and a facing: below 65536", |tag| unpack_tag(*tag).is_some())?;
    column("material", material, rows, "a number", |_| true)?;
    match keys(tag, material, voxel).zip(keys(tag, material, voxel).skip(1)).position(|(a, b)| a >= b) {
        Some(row) => Err(Flaw::new(format!("{name} {row} not before the next"), "rows sorted by key")),
        None => Ok(()),
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};
    use crate::archive::{encode, format};

    fn known() -> CellsTable {
        CellsTable {
            voxel: vec![[-1, 2, 3], [-1, 2, 4]],
            tag: vec![pack_tag(-1, 53); 2],
            material: vec![1, 1],
            normal: vec![[0.0, 0.0, 1.0], [0.5, -0.25, 0.0]],
            bits: vec![0xff, 0x01, 0x00, 0x80],
            seen_voxel: vec![[0, 0, 0], [0, 1, 0]],
            seen_tag: vec![pack_tag(2, 58); 2],
            seen_material: vec![0, 0],
            hits: vec![0, DOWN | 1, 1, DOWN | MISS],
            doubtful: vec![0, 1],
        }
    }

    /// All 65 536 tags unpack to their level and facing and sort as these do.
    #[test]
    fn tags_sort_as_levels() {
        let mut last = None;
        for level in i8::MIN..=i8::MAX {
            for facing in 0..=u8::MAX {
                let tag = pack_tag(level, facing);
                assert_eq!(unpack_tag(tag), Some((level, facing)));
                assert!(last < Some(tag));
                last = Some(tag);
            }
        }
        assert_eq!((last, unpack_tag(65_536)), (Some(65_535), None));
    }

    /// The known value has the known bytes, so the layout of schema 4 is unchanged. It reads back
    /// equal, for the two kinds of cells.
    #[test]
    fn layout_is_frozen() {
        let raw = known().to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (192, "128026b4de5053a2".to_string()));
        for kind in [PROBES, BOUNCE] {
            let back = CellsTable::from_block(&block(&known().encode(kind, TileNumber::FIRST, 9).unwrap())).unwrap();
            assert_eq!(back, known());
            assert_eq!(CellsTable::new(&back.into_cells()), known());
        }
        assert!(known().encode(format::SKY, TileNumber::FIRST, 9).is_err());
    }

    /// A value out of range in any of 12 ways is refused on writing and, under right checksums, on
    /// reading.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut CellsTable); 12] = [
            |p| p.voxel[1][2] = 3,
            |p| p.voxel.swap(0, 1),
            |p| p.tag[1] = 65_536,
            |p| p.normal[0][0] = 0.1,
            |p| p.normal[1][0] = f32::NAN,
            |p| p.material.truncate(1),
            |p| p.bits.truncate(3),
            |p| p.hits[1] = 2,
            |p| p.hits.truncate(3),
            |p| p.seen_voxel.swap(0, 1),
            |p| p.doubtful[0] = 2,
            |p| p.doubtful.truncate(1),
        ];
        for (number, flaw) in flaws.into_iter().enumerate() {
            let mut wrong = known();
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err(), "{number}");
            let raw = rkyv::to_bytes::<rkyv::rancor::Error>(&wrong).unwrap();
            let schema = format::schema_of(format::PROBES).unwrap();
            let encoded = encode(format::PROBES, format::TileNumber::FIRST, schema, 2, &raw, 9);
            let error = CellsTable::from_block(&block(&encoded.unwrap())).unwrap_err();
            let said = error.to_string();
            assert!(said.contains("block probes/0") && !said.contains("schema"), "{number}: {error}");
        }
    }

    /// No change of one bit and no cut ends the program, though checksums are right. All cuts are
    /// refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(PROBES, 2, &raw, CellsTable::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
