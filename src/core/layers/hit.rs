//! The hit texture: which cell each texel of a receiver's own hemisphere meets. In: keys per texel.
//! Out: a tile's palette of keys and 32-bit indices into it, and back.

use crate::layers::cells::numbered;
use crate::site::cells::CellKey;

/// Hits of the receivers of one tile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HitTile {
    /// Cells seen by any receiver of the tile, sorted, no two equal.
    pub palette: Vec<CellKey>,
    /// `[receiver][texel]`, row-major, surface frame: 0 = nothing met, else palette index + 1.
    pub texels: Vec<u32>,
}

/// Bytes of a key in the block.
const KEY_BYTES: usize = 16;

impl HitTile {
    /// Gathers the receivers' textures, which all have the same number of texels.
    pub fn new(receivers: &[impl AsRef<[Option<CellKey>]>]) -> Self {
        let textures = || receivers.iter().flat_map(AsRef::as_ref);
        let (palette, numbers) = numbered(textures().flatten().copied());
        // Every key of the textures is in the palette.
        let index = |key: &Option<CellKey>| key.and_then(|key| numbers.get(&key)).map_or(0, |number| number + 1);
        let texels = textures().map(index).collect();
        HitTile { palette, texels }
    }

    /// Returns the textures of `receivers` receivers, as they were given to [`HitTile::new`].
    pub fn split(&self, receivers: usize) -> Vec<Vec<Option<CellKey>>> {
        let texels = self.texels.len().checked_div(receivers).unwrap_or(0);
        // Index 0 stands for a texel that meets nothing.
        let key = |&texel: &u32| (texel as usize).checked_sub(1).and_then(|i| self.palette.get(i).copied());
        (0..receivers).map(|r| self.texels[r * texels..(r + 1) * texels].iter().map(key).collect()).collect()
    }

    /// Packs the tile into a raw block, little-endian: palette length (u32), key columns (level i8,
    /// facing u8, material u16, voxel x, y, z as i32), then the four byte planes of the texel
    /// indices, each receiver by receiver.
    pub fn pack(&self) -> Vec<u8> {
        let mut raw = Vec::with_capacity(4 + self.palette.len() * KEY_BYTES + self.texels.len() * 4);
        raw.extend((self.palette.len() as u32).to_le_bytes());
        raw.extend(self.palette.iter().map(|k| k.level as u8));
        raw.extend(self.palette.iter().map(|k| k.facing));
        raw.extend(self.palette.iter().flat_map(|k| k.material.to_le_bytes()));
        for axis in 0..3 {
            raw.extend(self.palette.iter().flat_map(|k| k.voxel[axis].to_le_bytes()));
        }
        // Indices are small, so the upper planes are nearly all 0. zstd packs byte planes into two
        // thirds of the bytes of whole indices.
        for byte in 0..4 {
            raw.extend(self.texels.iter().map(|t| t.to_le_bytes()[byte]));
        }
        raw
    }

    /// Unpacks a tile of `texels` indices from the bytes of [`HitTile::pack`]. Returns `None` if
    /// the bytes are anything else or an index is out of range.
    pub fn unpack(raw: &[u8], texels: usize) -> Option<Self> {
        let (head, rest) = raw.split_at_checked(4)?;
        let count = u32::from_le_bytes(head.try_into().ok()?) as usize;
        let keys = count.checked_mul(KEY_BYTES)?;
        if rest.len() != keys.checked_add(texels.checked_mul(4)?)? {
            return None;
        }
        let (keys, planes) = rest.split_at(keys);
        let half = |i: usize| u16::from_le_bytes([keys[2 * count + 2 * i], keys[2 * count + 2 * i + 1]]);
        let word = |axis: usize, i: usize| {
            let at = 4 * count * (axis + 1) + 4 * i;
            i32::from_le_bytes([keys[at], keys[at + 1], keys[at + 2], keys[at + 3]])
        };
        let palette = (0..count)
            .map(|i| CellKey {
                level: keys[i] as i8,
                facing: keys[count + i],
                material: half(i),
                voxel: [word(0, i), word(1, i), word(2, i)],
            })
            .collect();
        let texels: Vec<u32> =
            (0..texels).map(|i| u32::from_le_bytes([0, 1, 2, 3].map(|b| planes[b * texels + i]))).collect();
        texels.iter().all(|&t| t as usize <= count).then_some(HitTile { palette, texels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Hits of two receivers with shared and missing cells survive packing and splitting, and every
    /// truncated block is refused.
    #[test]
    fn hits_come_back_and_cut_blocks_are_refused() {
        let key = |x: f64| Some(CellKey::new(DVec3::new(x, -3.0, 7.5), DVec3::X, false, 2, 1));
        let receivers = [vec![key(0.0), None, key(50.0), key(0.0)], vec![key(50.0), None, None, key(-90.0)]];
        let tile = HitTile::new(&receivers);
        assert_eq!(tile.split(2), receivers);
        assert_eq!(tile.palette.len(), 3);
        let raw = tile.pack();
        assert_eq!(HitTile::unpack(&raw, 8), Some(tile));
        assert_eq!((0..raw.len()).filter(|&cut| HitTile::unpack(&raw[..cut], 8).is_some()).count(), 0);
    }
}
