//! A chunk of the coarse cells that carry second and later bounces, sorted by key.

use rkyv::{Archive, Deserialize, Serialize};

use super::probes::{Key, check_cells, highest_hit, keys};
use super::{Flaw, flat_column, per_row, table};
use crate::archive::format::BOUNCE;

/// Columns of one chunk, schema 1; the columns are those of [`super::Probes`].
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct Bounce {
    pub voxel: Vec<[i32; 3]>,
    pub tag: Vec<u32>,
    pub material: Vec<u16>,
    pub normal: Vec<[f32; 3]>,
    /// `[cell][byte]`: sky bits, world frame, lowest bit first.
    pub bits: Vec<u8>,
    /// `[cell][ray]`: row of the cell met, counted over all chunks, and a flag; see `schema/layers.md`.
    pub hits: Vec<u32>,
}

table!(Bounce, BOUNCE);

impl Bounce {
    /// Number of cells.
    pub fn rows(&self) -> usize {
        self.voxel.len()
    }

    /// Bytes of sky bits per cell.
    pub fn bytes_per_cell(&self) -> usize {
        per_row(self.bits.len(), self.rows())
    }

    /// Hit rays per cell.
    pub fn rays_per_cell(&self) -> usize {
        per_row(self.hits.len(), self.rows())
    }

    /// Keys in the order of rows.
    pub fn keys(&self) -> impl Iterator<Item = Key> + '_ {
        keys(&self.tag, &self.material, &self.voxel)
    }

    /// Highest cell that a ray met. It must be below the number of cells of all chunks, which one block cannot know.
    pub fn highest_hit(&self) -> Option<u32> {
        highest_hit(&self.hits)
    }

    fn check(&self) -> Result<(), Flaw> {
        check_cells(&self.voxel, &self.tag, &self.material, &self.normal)?;
        let rows = self.rows();
        flat_column("bits", self.bits.len(), rows)?;
        flat_column("hits", self.hits.len(), rows)
    }
}

#[cfg(test)]
mod tests {
    use super::super::pack_tag;
    use super::super::probes::NOTHING;
    use super::super::tests::{block, hostile};
    use super::*;
    use crate::archive::{codec, format};

    fn known() -> Bounce {
        Bounce {
            voxel: vec![[0, 0, 0], [0, 0, 1]],
            tag: vec![pack_tag(2, 54), pack_tag(3, 59)],
            material: vec![0, 1],
            normal: vec![[0.0, 0.0, 1.0], [0.5, -0.25, 0.0]],
            bits: vec![1, 2],
            hits: vec![0, 1, NOTHING, 1 << 31 | 1, u32::MAX, 0],
        }
    }

    /// The known value has the known 148 bytes, so the layout of schema 1 is what it was; it reads back as it was.
    #[test]
    fn layout_is_frozen() {
        let raw = known().to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (136, "6c62f1d4e4ba5057".to_string()));
        let back = Bounce::from_block(&block(&known().encode(0, 9).unwrap())).unwrap();
        assert_eq!((back.rays_per_cell(), back.bytes_per_cell(), back.highest_hit()), (3, 1, Some(1)));
        assert_eq!(back, known());
    }

    /// A value out of range in any of 4 ways is refused on writing and, under right checksums, on reading.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut Bounce); 4] =
            [|b| b.tag.swap(0, 1), |b| b.normal[0][0] = f32::INFINITY, |b| b.hits.truncate(5), |b| b.bits.clear()];
        for (number, flaw) in flaws.into_iter().enumerate() {
            let mut wrong = known();
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err(), "{number}");
            let raw = rkyv::to_bytes::<rkyv::rancor::Error>(&wrong).unwrap();
            let error = Bounce::from_block(&block(&codec::encode(6, 0, 1, 2, &raw, 9).unwrap())).unwrap_err();
            assert!(error.to_string().contains("block bounce/0"), "{number}: {error}");
        }
    }

    /// No change of one of 1184 bits and none of 147 cuts ends the program, though checksums fit; all cuts are refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(BOUNCE, 2, &raw, Bounce::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
