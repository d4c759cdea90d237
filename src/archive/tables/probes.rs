//! A chunk of probes, sorted by key.

use rkyv::{Archive, Deserialize, Serialize};

use super::{Flaw, column, flat_column, length_in, per_row, table};
use crate::archive::format::PROBES;

/// Order of keys: tag, material, voxel x, y, z. It is the order of (level, facing, material, voxel).
pub type Key = (u32, u16, [i32; 3]);

/// Level and facing of a cell as one number that sorts as they do.
pub fn pack_tag(level: i8, facing: u8) -> u32 {
    let [level] = level.to_be_bytes();
    // Flipping the sign bit is adding 128: -128 becomes 0.
    u32::from(level ^ 0x80) << 8 | u32::from(facing)
}

/// Level and facing of a tag; `None` beyond 16 bits.
pub fn unpack_tag(tag: u32) -> Option<(i8, u8)> {
    let [level, facing] = u16::try_from(tag).ok()?.to_be_bytes();
    Some((i8::from_be_bytes([level ^ 0x80]), facing))
}

/// Columns of one chunk, schema 1.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct Probes {
    /// Voxel of the cell at its level.
    pub voxel: Vec<[i32; 3]>,
    /// [`pack_tag`].
    pub tag: Vec<u32>,
    /// Row of the materials table.
    pub material: Vec<u16>,
    /// Mean of the unit normals of the cell's points, so at most 1 long.
    pub normal: Vec<[f32; 3]>,
    /// `[probe][byte]`: sky bits, world frame, lowest bit first.
    pub bits: Vec<u8>,
    /// [probe][ray]: row of the bounce cell met, counted over all chunks, and a flag; see `schema/layers.md`.
    pub hits: Vec<u32>,
}

table!(Probes, PROBES);

impl Probes {
    /// Number of probes.
    pub fn rows(&self) -> usize {
        self.voxel.len()
    }

    /// Bytes of sky bits per probe.
    pub fn bytes_per_probe(&self) -> usize {
        per_row(self.bits.len(), self.rows())
    }

    /// Keys in the order of rows.
    pub fn keys(&self) -> impl Iterator<Item = Key> + '_ {
        keys(&self.tag, &self.material, &self.voxel)
    }

    /// Highest bounce cell that a ray met. It must be below the number of cells of all bounce chunks, which one block cannot know.
    pub fn highest_hit(&self) -> Option<u32> {
        highest_hit(&self.hits)
    }

    fn check(&self) -> Result<(), Flaw> {
        check_cells(&self.voxel, &self.tag, &self.material, &self.normal)?;
        flat_column("bits", self.bits.len(), self.rows())?;
        flat_column("hits", self.hits.len(), self.rows())
    }
}

/// The bits of a hit that hold a cell; bit 31 says that the ray goes below the horizon.
const CELL: u32 = u32::MAX >> 1;
/// The cell of a ray that met nothing.
pub(super) const NOTHING: u32 = CELL;

/// Highest cell of a column of hits.
pub(super) fn highest_hit(hits: &[u32]) -> Option<u32> {
    hits.iter().map(|hit| hit & CELL).filter(|cell| *cell != NOTHING).max()
}

/// Keys of three columns.
pub(super) fn keys<'a>(tag: &'a [u32], material: &'a [u16], voxel: &'a [[i32; 3]]) -> impl Iterator<Item = Key> + 'a {
    tag.iter().zip(material).zip(voxel).map(|((tag, material), voxel)| (*tag, *material, *voxel))
}

/// What probes and bounce cells have in common.
pub(super) fn check_cells(voxel: &[[i32; 3]], tag: &[u32], material: &[u16], normal: &[[f32; 3]]) -> Result<(), Flaw> {
    let rows = voxel.len();
    if rows == 0 {
        return Err(Flaw::new("0 rows", "at least 1"));
    }
    column("tag", tag, rows, "a level and a facing: below 65536", |tag| unpack_tag(*tag).is_some())?;
    column("material", material, rows, "a number", |_| true)?;
    column("normal", normal, rows, "length 0 to 1", |n| length_in(n.map(f64::from), 0.0, 1.0))?;
    let ordered = keys(tag, material, voxel).zip(keys(tag, material, voxel).skip(1)).position(|(a, b)| a >= b);
    match ordered {
        Some(row) => Err(Flaw::new(format!("row {row} not before the next"), "rows sorted by tag, material, voxel")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{block, hostile};
    use super::*;
    use crate::archive::{codec, format};

    fn known() -> Probes {
        Probes {
            voxel: vec![[-1, 2, 3], [-1, 2, 4]],
            tag: vec![pack_tag(-1, 53); 2],
            material: vec![1, 1],
            normal: vec![[0.0, 0.0, 1.0], [0.5, -0.25, 0.0]],
            bits: vec![0xff, 0x01, 0x00, 0x80],
            hits: vec![0, 1 << 31 | 1],
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

    /// The known value has the known 104 bytes, so the layout of schema 1 is what it was; it reads back as it was.
    #[test]
    fn layout_is_frozen() {
        let raw = known().to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (120, "e558abcd6d4a9102".to_string()));
        let back = Probes::from_block(&block(&known().encode(0, 9).unwrap())).unwrap();
        assert_eq!((back.bytes_per_probe(), &back), (2, &known()));
    }

    /// A value out of range in any of 7 ways is refused on writing and, under right checksums, on reading.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut Probes); 7] = [
            |p| p.voxel[1][2] = 3,
            |p| p.voxel.swap(0, 1),
            |p| p.tag[1] = 65_536,
            |p| p.normal[0][0] = 0.1,
            |p| p.normal[1][0] = f32::NAN,
            |p| p.material.truncate(1),
            |p| p.bits.truncate(3),
        ];
        for (number, flaw) in flaws.into_iter().enumerate() {
            let mut wrong = known();
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err(), "{number}");
            let raw = rkyv::to_bytes::<rkyv::rancor::Error>(&wrong).unwrap();
            let error = Probes::from_block(&block(&codec::encode(5, 0, 1, 2, &raw, 9).unwrap())).unwrap_err();
            assert!(error.to_string().contains("block probes/0"), "{number}: {error}");
        }
    }

    /// No change of one of 832 bits and none of 103 cuts ends the program, though checksums fit; all cuts are refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(PROBES, 2, &raw, Probes::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
