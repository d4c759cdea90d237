//! A decoded sky texture for lookups: open and closed texels of the base square are one bit each, only those with an edge in them
//! keep their fine bits. 5 to 20 kB a receiver where the whole square takes 128.

use pulp::Arch;

use crate::layers::bits::{BitSquare, spread};
use crate::layers::sky::{Decoded, decode};

/// Bits of one receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mosaic {
    /// Fine texels to a side of a base texel.
    block: usize,
    /// Base texels that are sky throughout, and those that are sky in part.
    open: BitSquare,
    mixed: BitSquare,
    /// `[word of mixed]`: how many mixed texels lie in the words before.
    ranks: Vec<u32>,
    /// `[mixed texel][word]`: its fine bits row by row, lowest bit first.
    blocks: Vec<u64>,
}

/// What a base texel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texel<'a> {
    /// No part of it is sky.
    Closed,
    /// All of it is sky.
    Open,
    /// Fine bits, row by row.
    Mixed(&'a [u64]),
}

/// Widest block that is put together word by word: its halved rows lie within a word.
const WIDEST: usize = 64;

impl Mosaic {
    /// The mosaics of a raw `sky` block; `None` if the bytes do not describe `count` textures exactly.
    pub fn unpack(raw: &[u8], count: usize, base: usize, fine: usize) -> Option<Vec<Mosaic>> {
        decode(raw, count, base, fine, |texture| Mosaic::from_decoded(texture, base, fine))
    }

    /// The mosaic of a square of fine bits; `base` divides its side.
    pub fn of(dense: &BitSquare, base: usize) -> Mosaic {
        let block = dense.side() / base;
        let mut mosaic = Mosaic::closed(base, block);
        for row in 0..base {
            for column in 0..base {
                let bit = |i: usize| dense.get(column * block + i % block, row * block + i / block);
                match (0..block * block).filter(|&i| bit(i)).count() {
                    0 => {}
                    all if all == block * block => mosaic.open.set(column, row, true),
                    _ => {
                        mosaic.mixed.set(column, row, true);
                        let word = |w: usize| {
                            let bits = (w * 64..(w * 64 + 64).min(block * block)).enumerate();
                            bits.fold(0, |word, (k, i)| word | u64::from(bit(i)) << k)
                        };
                        mosaic.blocks.extend((0..mosaic.words()).map(word));
                    }
                }
            }
        }
        mosaic.ranks = ranks(&mosaic.mixed);
        mosaic
    }

    fn closed(base: usize, block: usize) -> Mosaic {
        let (open, mixed) = (BitSquare::new(base), BitSquare::new(base));
        Mosaic { block, open, mixed, ranks: Vec::new(), blocks: Vec::new() }
    }

    fn from_decoded(texture: &Decoded, base: usize, fine: usize) -> Mosaic {
        let block = fine / base;
        let Some((refined, nibbles)) = texture.last.as_ref().filter(|_| block <= WIDEST) else {
            return Mosaic::of(&texture.dense(), base);
        };
        let mut mosaic = Mosaic::closed(base, block);
        Arch::new().dispatch(|| mosaic.classify(&texture.half, refined));
        mosaic.fill(&texture.half, refined, nibbles);
        mosaic.ranks = ranks(&mosaic.mixed);
        mosaic
    }

    /// Finds the open texels and those that may be mixed: many at a time, by words of the halved square.
    #[inline(always)]
    fn classify(&mut self, half: &BitSquare, refined: &BitSquare) {
        let (side, stride) = (self.block / 2, half.stride);
        let steps = side.trailing_zeros();
        let texels = 64 / side;
        for row in 0..self.open.side() {
            for i in 0..stride {
                let (mut all, mut any, mut edge) = (u64::MAX, 0, 0);
                for at in (row * side..(row + 1) * side).map(|r| r * stride + i) {
                    all &= half.words[at];
                    any |= half.words[at];
                    edge |= refined.words[at];
                }
                // Bits of a texel are gathered in its lowest one.
                for step in 0..steps {
                    all &= all >> (1 << step);
                    any |= any >> (1 << step);
                    edge |= edge >> (1 << step);
                }
                let (all, any, edge) = (every(all, steps), every(any, steps), every(edge, steps));
                let place = row * self.open.stride + i * texels / 64;
                let shift = i * texels % 64;
                if let (Some(open), Some(mixed)) = (self.open.words.get_mut(place), self.mixed.words.get_mut(place)) {
                    *open |= (all & !edge) << shift;
                    *mixed |= (edge | any & !all) << shift;
                }
            }
        }
    }

    /// Collects the fine bits of the texels that may be mixed; those whose bits are all equal are not.
    fn fill(&mut self, half: &BitSquare, refined: &BitSquare, nibbles: &[u8]) {
        let side = self.block / 2;
        let before = ranks(refined);
        let low = (1_u64 << side) - 1;
        let candidates = std::mem::replace(&mut self.mixed, BitSquare::new(self.open.side()));
        let mut block = vec![0; self.words()];
        let full = u32::try_from(self.block * self.block).unwrap_or(u32::MAX);
        for (column, row) in candidates.ones() {
            block.fill(0);
            let (first, shift) = (column as usize * side / 64, column as usize * side % 64);
            for r in 0..side {
                let at = (row as usize * side + r) * half.stride + first;
                let mut rows = [spread((half.words[at] >> shift & low) as u32); 2];
                let mut edge = refined.words[at] >> shift & low;
                if edge != 0 {
                    let mut rank = (before[at] + (refined.words[at] & ((1 << shift) - 1)).count_ones()) as usize;
                    while edge != 0 {
                        let c = edge.trailing_zeros();
                        let nibble = u64::from(nibbles[rank / 2] >> (rank % 2 * 4));
                        rows[0] = rows[0] & !(3 << (2 * c)) | (nibble & 3) << (2 * c);
                        rows[1] = rows[1] & !(3 << (2 * c)) | (nibble >> 2 & 3) << (2 * c);
                        rank += 1;
                        edge &= edge - 1;
                    }
                }
                for (k, bits) in rows.into_iter().enumerate() {
                    let first = (2 * r + k) * self.block;
                    block[first / 64] |= bits << (first % 64);
                }
            }
            let count: u32 = block.iter().map(|word| word.count_ones()).sum();
            if count == full {
                self.open.set(column as usize, row as usize, true);
            } else if count > 0 {
                self.mixed.set(column as usize, row as usize, true);
                self.blocks.extend_from_slice(&block);
            }
        }
    }

    /// Words of a mixed texel.
    fn words(&self) -> usize {
        (self.block * self.block).div_ceil(64)
    }

    /// Bytes that its bits take.
    pub fn bytes(&self) -> usize {
        (self.open.words.len() + self.mixed.words.len() + self.blocks.len()) * 8 + self.ranks.len() * 4
    }

    /// Side of the base square.
    pub fn side(&self) -> usize {
        self.open.side()
    }

    /// Fine texels to a side of a base texel.
    pub fn block(&self) -> usize {
        self.block
    }

    /// What a base texel holds.
    #[inline]
    pub fn texel(&self, column: usize, row: usize) -> Texel<'_> {
        let (place, bit) = (row * self.open.stride + column / 64, column % 64);
        if self.open.words[place] >> bit & 1 == 1 {
            Texel::Open
        } else if self.mixed.words[place] >> bit & 1 == 1 {
            Texel::Mixed(self.mixed_at(place, bit))
        } else {
            Texel::Closed
        }
    }

    #[inline]
    fn mixed_at(&self, place: usize, bit: usize) -> &[u64] {
        let rank = (self.ranks[place] + (self.mixed.words[place] & ((1 << bit) - 1)).count_ones()) as usize;
        &self.blocks[rank * self.words()..(rank + 1) * self.words()]
    }

    /// Whether a fine texel is sky.
    pub fn get(&self, column: usize, row: usize) -> bool {
        match self.texel(column / self.block, row / self.block) {
            Texel::Closed => false,
            Texel::Open => true,
            Texel::Mixed(bits) => {
                let i = row % self.block * self.block + column % self.block;
                bits[i / 64] >> (i % 64) & 1 == 1
            }
        }
    }

    /// Share of a base texel that is sky, by its number.
    pub fn share(&self, texel: usize) -> f64 {
        match self.texel(texel % self.side(), texel / self.side()) {
            Texel::Closed => 0.0,
            Texel::Open => 1.0,
            Texel::Mixed(bits) => {
                f64::from(bits.iter().map(|word| word.count_ones()).sum::<u32>()) / (self.block * self.block) as f64
            }
        }
    }

    /// Calls `each` for every base texel, row by row, of which something is sky: its number and the share that is.
    #[inline]
    pub fn for_visible(&self, mut each: impl FnMut(usize, f64)) {
        let all = (self.block * self.block) as f64;
        let mut blocks = self.blocks.chunks_exact(self.words());
        let side = self.side();
        for (place, (&open, &mixed)) in self.open.words.iter().zip(&self.mixed.words).enumerate() {
            let first = place / self.open.stride * side + place % self.open.stride * 64;
            let mut any = open | mixed;
            while any != 0 {
                let bit = any.trailing_zeros();
                let share = match mixed >> bit & 1 {
                    0 => 1.0,
                    _ => f64::from(blocks.next().map_or(0, |b| b.iter().map(|word| word.count_ones()).sum())) / all,
                };
                each(first + bit as usize, share);
                any &= any - 1;
            }
        }
    }
}

/// `[word]`: number of set bits in the words before.
fn ranks(square: &BitSquare) -> Vec<u32> {
    let before = |sum: &mut u32, word: &u64| {
        let rank = *sum;
        *sum += word.count_ones();
        Some(rank)
    };
    square.words.iter().scan(0, before).collect()
}

/// Keeps every 2^steps-th bit of a word, moved together.
#[inline(always)]
fn every(word: u64, steps: u32) -> u64 {
    (0..steps).fold(word, |w, _| {
        let mut w = w & 0x5555_5555_5555_5555;
        w = (w | w >> 1) & 0x3333_3333_3333_3333;
        w = (w | w >> 2) & 0x0f0f_0f0f_0f0f_0f0f;
        w = (w | w >> 4) & 0x00ff_00ff_00ff_00ff;
        w = (w | w >> 8) & 0x0000_ffff_0000_ffff;
        (w | w >> 16) & 0xffff_ffff
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{texel_centres, texel_direction};
    use crate::layers::sky::{SkyTexture, front_of};
    use crate::layers::texel_block::TexelBlock;
    use glam::{DVec2, DVec3};

    /// A skyline, refined and packed for 3 receivers of different normals, gives the same mosaic by the short way as by way of the
    /// whole square, for 6 pairs of sides; every fine bit and every share of it is that of the square.
    #[test]
    fn short_way() {
        let skyline = |d: DVec3| {
            let azimuth = d.y.atan2(d.x);
            d.z > 0.3 + 0.2 * (3.0 * azimuth).sin() + 0.05 * (11.0 * azimuth).cos()
        };
        for (base, fine) in [(128, 1024), (64, 1024), (32, 64), (16, 256), (64, 64), (4, 512)] {
            let trace = |normal| {
                let visible = |n, texels: &[(u32, u32)]| {
                    let at = |t: &(u32, u32)| texel_direction(t.0 as usize, t.1 as usize, n, DVec2::splat(0.5));
                    texels.iter().map(|t| skyline(at(t))).collect()
                };
                let front = front_of(base, normal, &texel_centres(base));
                SkyTexture::trace(front, fine, TexelBlock::by_texels(visible))
            };
            let traces = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::NEG_Y].map(trace);
            let raw = SkyTexture::pack(&traces.clone().map(|t| t.0));
            let mosaics = Mosaic::unpack(&raw, 3, base, fine).unwrap_or_default();
            assert_eq!(mosaics, traces.clone().map(|t| Mosaic::of(&t.1, base)).to_vec(), "{base} {fine}");
            for (mosaic, (_, dense)) in mosaics.iter().zip(&traces) {
                let wrong =
                    (0..fine * fine).filter(|t| mosaic.get(t % fine, t / fine) != dense.get(t % fine, t / fine));
                assert_eq!(wrong.count(), 0);
                let mut shares = vec![0.0; base * base];
                mosaic.for_visible(|texel, share| shares[texel] = share);
                assert!(shares.iter().enumerate().all(|(texel, share)| mosaic.share(texel) == *share));
                let block = fine / base;
                if block <= 64 {
                    for (t, share) in shares.iter().enumerate() {
                        let count = dense.count_block(block, t % base, t / base);
                        assert_eq!(*share, f64::from(count) / (block * block) as f64);
                    }
                }
            }
            assert!((0..raw.len()).step_by(97).all(|cut| Mosaic::unpack(&raw[..cut], 3, base, fine).is_none()));
        }
    }

    /// Bits behind the last of 33 columns are no texels: of an all open texture whose bytes have them set 1,089 texels are seen.
    #[test]
    fn padding() {
        let raw = [0xff; 2 * 5 * 33];
        let mosaics = Mosaic::unpack(&raw, 1, 33, 66).unwrap_or_default();
        let dense = SkyTexture::unpack(&raw, 1, 33, 66).unwrap_or_default();
        assert_eq!(mosaics, [Mosaic::of(&dense[0], 33)]);
        let mut seen = Vec::new();
        mosaics[0].for_visible(|texel, share| seen.push((texel, share)));
        assert_eq!(seen, (0..1089).map(|texel| (texel, 1.0)).collect::<Vec<_>>());
    }
}
