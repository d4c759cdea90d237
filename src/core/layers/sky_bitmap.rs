//! A decoded sky texture for lookups. Open and closed texels of the base square are one bit each;
//! only texels with an edge in them keep their fine bits. A receiver takes 5 to 20 kB, where the
//! whole square takes 128.

use std::collections::BTreeMap;

use crate::layers::bits::BitSquare;

/// Decoded sky texture of one receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkyBitmap {
    /// Number of fine texels to a side of a base texel.
    block: usize,
    /// Base texels that are sky throughout (`open`) and in part (`mixed`).
    pub(super) open: BitSquare,
    pub(super) mixed: BitSquare,
    /// `[word of mixed]`: number of mixed texels in the words before.
    ranks: Vec<u32>,
    /// `[mixed texel][word]`: fine bits of the texel, row by row, lowest bit first.
    pub(super) blocks: Vec<u64>,
}

/// Contents of a base texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texel<'a> {
    /// No part of the texel is sky.
    Closed,
    /// All of the texel is sky.
    Open,
    /// Part of the texel is sky: its fine bits, row by row.
    Mixed(&'a [u64]),
}

/// Skies that give the contents of one base texel at a time.
pub trait BaseTexels {
    /// Contents of a base texel.
    fn texel(&mut self, column: usize, row: usize) -> Texel<'_>;
}

impl BaseTexels for &SkyBitmap {
    #[inline]
    fn texel(&mut self, column: usize, row: usize) -> Texel<'_> {
        SkyBitmap::texel(self, column, row)
    }
}

/// Column and row of a base texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BaseTexel {
    /// Column, counted from the left.
    pub column: usize,
    /// Row, counted from the first.
    pub row: usize,
}

impl SkyBitmap {
    /// Makes the bitmap of a square of fine bits; `base` divides its side.
    pub fn new(dense: &BitSquare, base: usize) -> SkyBitmap {
        let block = dense.side() / base;
        let mut bitmap = SkyBitmap::closed(base, block);
        for row in 0..base {
            for column in 0..base {
                let bit = |i: usize| dense.get(column * block + i % block, row * block + i / block);
                match (0..block * block).filter(|&i| bit(i)).count() {
                    0 => {}
                    all if all == block * block => bitmap.open.set(column, row, true),
                    _ => {
                        bitmap.mixed.set(column, row, true);
                        let word = |w: usize| {
                            let bits = (w * 64..(w * 64 + 64).min(block * block)).enumerate();
                            bits.fold(0, |word, (k, i)| word | u64::from(bit(i)) << k)
                        };
                        bitmap.blocks.extend((0..bitmap.words()).map(word));
                    }
                }
            }
        }
        bitmap.rank();
        bitmap
    }

    /// Returns the part of the sky in the texels that a square over it shows, row-major; a texel of
    /// the square holds whole fine texels.
    pub fn within(&self, shown: &[bool]) -> SkyBitmap {
        let (side, block, fine) = (self.side(), self.block, self.block * self.block);
        let square = shown.len().isqrt();
        let wide = side * block / square;
        let mut out = SkyBitmap::closed(side, block);
        for (column, row) in (0..side * side).map(|texel| (texel % side, texel / side)) {
            let is_shown = |c: usize, r: usize| shown[r / wide * square + c / wide];
            let places = |at: usize| (at * block..(at + 1) * block).step_by(wide.min(block));
            let mut covering = places(row).flat_map(|r| places(column).map(move |c| is_shown(c, r)));
            let found = self.texel(column, row);
            let bit = |i: usize| match found {
                Texel::Closed => false,
                Texel::Open => true,
                Texel::Mixed(bits) => bits[i / 64] >> (i % 64) & 1 == 1,
            };
            match found {
                Texel::Closed => {}
                Texel::Open if covering.clone().all(|is| is) => out.open.set(column, row, true),
                _ if !covering.any(|is| is) => {}
                _ => {
                    let left = |i: usize| bit(i) && is_shown(column * block + i % block, row * block + i / block);
                    let word = |w: usize| {
                        let bits = (w * 64..(w * 64 + 64).min(fine)).enumerate();
                        bits.fold(0, |word, (k, i)| word | u64::from(left(i)) << k)
                    };
                    let words: Vec<u64> = (0..self.words()).map(word).collect();
                    if words.iter().any(|word| *word != 0) {
                        out.mixed.set(column, row, true);
                        out.blocks.extend(words);
                    }
                }
            }
        }
        out.rank();
        out
    }

    /// Returns a bitmap of `base` texels a side, each of `block` x `block` fine texels, without
    /// sky.
    pub fn closed(base: usize, block: usize) -> SkyBitmap {
        let (open, mixed) = (BitSquare::new(base), BitSquare::new(base));
        SkyBitmap { block, open, mixed, ranks: Vec::new(), blocks: Vec::new() }
    }

    /// Returns the bitmap of all fine texels that are not sky.
    pub fn inverse(&self) -> SkyBitmap {
        let (side, fine) = (self.side(), self.block * self.block);
        let mut out = SkyBitmap::closed(side, self.block);
        for texel in 0..side * side {
            let (column, row) = (texel % side, texel / side);
            match self.texel(column, row) {
                Texel::Closed => out.open.set(column, row, true),
                Texel::Open => {}
                Texel::Mixed(bits) => {
                    out.mixed.set(column, row, true);
                    let used = |word: usize| u64::MAX >> (64 - (fine - word * 64).min(64));
                    out.blocks.extend(bits.iter().enumerate().map(|(word, bits)| !bits & used(word)));
                }
            }
        }
        out.rank();
        out
    }

    /// Splits the sky by a property of its base texels, which `of` tells by their row-major
    /// numbers. Each fine texel that is sky is in one of the parts.
    pub fn split<K: Ord>(&self, mut of: impl FnMut(usize) -> K) -> BTreeMap<K, SkyBitmap> {
        let side = self.side();
        let mut parts: BTreeMap<K, SkyBitmap> = BTreeMap::new();
        for texel in 0..side * side {
            let (column, row) = (texel % side, texel / side);
            let found = self.texel(column, row);
            if found == Texel::Closed {
                continue;
            }
            let part = parts.entry(of(texel)).or_insert_with(|| SkyBitmap::closed(side, self.block));
            match found {
                Texel::Mixed(bits) => {
                    part.mixed.set(column, row, true);
                    part.blocks.extend(bits);
                }
                _ => part.open.set(column, row, true),
            }
        }
        parts.values_mut().for_each(SkyBitmap::rank);
        parts
    }

    /// Counts the mixed texels of each word, once all texels are there.
    pub(super) fn rank(&mut self) {
        self.ranks = ranks(&self.mixed);
    }

    /// Returns the number of words of a mixed texel.
    fn words(&self) -> usize {
        (self.block * self.block).div_ceil(64)
    }

    /// Returns the number of bytes that the bitmap's bits take.
    pub fn bytes(&self) -> usize {
        (self.open.words.len() + self.mixed.words.len() + self.blocks.len()) * 8 + self.ranks.len() * 4
    }

    /// Returns the side of the base square.
    pub fn side(&self) -> usize {
        self.open.side()
    }

    /// Number of fine texels to a side of a base texel.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Contents of a base texel.
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

    /// Returns word `word` of the base texels that are sky throughout, and of those that are sky in
    /// part. Words go row by row, lowest bit first; words beyond the square are 0.
    #[inline]
    pub fn words_at(&self, word: usize) -> (u64, u64) {
        let at = |square: &BitSquare| square.words.get(word).copied().unwrap_or_default();
        (at(&self.open), at(&self.mixed))
    }

    /// Returns all bits: the base texels that are sky throughout, and those that are sky in part,
    /// by rows of words, lowest bit first; for each word, the number of mixed texels in the words
    /// before; the fine bits of the mixed texels.
    pub fn bits(&self) -> (&[u64], &[u64], &[u32], &[u64]) {
        (&self.open.words, &self.mixed.words, &self.ranks, &self.blocks)
    }

    #[inline]
    fn mixed_at(&self, place: usize, bit: usize) -> &[u64] {
        let rank = (self.ranks[place] + (self.mixed.words[place] & ((1 << bit) - 1)).count_ones()) as usize;
        &self.blocks[rank * self.words()..(rank + 1) * self.words()]
    }

    /// Returns true if a fine texel is sky.
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

    /// Returns the share of a base texel that is sky. `texel` is its row-major number.
    pub fn share(&self, texel: usize) -> f64 {
        match self.texel(texel % self.side(), texel / self.side()) {
            Texel::Closed => 0.0,
            Texel::Open => 1.0,
            Texel::Mixed(bits) => {
                f64::from(bits.iter().map(|word| word.count_ones()).sum::<u32>()) / (self.block * self.block) as f64
            }
        }
    }

    /// Calls `each` with the number of every base texel that is sky at least in part, and its share
    /// of sky, row by row.
    #[inline(always)]
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

/// Returns, for each word, the number of set bits in the words before.
fn ranks(square: &BitSquare) -> Vec<u32> {
    let before = |sum: &mut u32, word: &u64| {
        let rank = *sum;
        *sum += word.count_ones();
        Some(rank)
    };
    square.words.iter().scan(0, before).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{texel_centres, texel_direction};
    use crate::layers::sky::{SkyTexture, front_of};
    use crate::layers::texel_block::TexelBlock;
    use glam::{DVec2, DVec3};

    /// A skyline, refined and packed for 3 receivers of different normals, gives the same bitmap by
    /// the direct decoder as by way of the whole square, for 6 pairs of sides. Every fine bit and
    /// every share of it equals the square's.
    #[test]
    fn the_direct_decoder_gives_the_bitmap_of_the_square() {
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
            let bitmaps = SkyBitmap::unpack(&raw, 3, base, fine).unwrap_or_default();
            assert_eq!(bitmaps, traces.clone().map(|t| SkyBitmap::new(&t.1, base)).to_vec(), "{base} {fine}");
            for (bitmap, (_, dense)) in bitmaps.iter().zip(&traces) {
                let wrong =
                    (0..fine * fine).filter(|t| bitmap.get(t % fine, t / fine) != dense.get(t % fine, t / fine));
                assert_eq!(wrong.count(), 0);
                let mut shares = vec![0.0; base * base];
                bitmap.for_visible(|texel, share| shares[texel] = share);
                assert!(shares.iter().enumerate().all(|(texel, share)| bitmap.share(texel) == *share));
                let block = fine / base;
                if block <= 64 {
                    for (t, share) in shares.iter().enumerate() {
                        let count = dense.count_block(block, t % base, t / base);
                        assert_eq!(*share, f64::from(count) / (block * block) as f64);
                    }
                }
            }
            assert!((0..raw.len()).step_by(97).all(|cut| SkyBitmap::unpack(&raw[..cut], 3, base, fine).is_none()));
        }
    }

    /// Returns a sky whose base texels are open, closed or a random mixture, a third each.
    fn random_sky(base: usize, block: usize) -> SkyBitmap {
        let fine = base * block;
        let mut dense = BitSquare::new(fine);
        for t in 0..fine * fine {
            let kind = crate::hemisphere::mix(5, (t / fine / block * base + t % fine / block) as u64) % 3;
            let one = kind == 1 || kind == 2 && crate::hemisphere::mix(7, t as u64).is_multiple_of(2);
            dense.set(t % fine, t / fine, one);
        }
        SkyBitmap::new(&dense, base)
    }

    /// For blocks of 1, 2, 8 and 16 fine texels a side, each fine texel of a random sky is in
    /// exactly one of the sky, and the parts of its inverse by the remainder of its base texel
    /// divided by 3.
    #[test]
    fn parts_of_the_inverse_hold_what_the_sky_does_not() {
        for block in [1, 2, 8, 16] {
            let (base, fine) = (33, 33 * block);
            let sky = random_sky(base, block);
            let parts = sky.inverse().split(|texel| texel % 3);
            assert_eq!(parts.len(), 3);
            for (column, row) in (0..fine * fine).map(|t| (t % fine, t / fine)) {
                let of = (row / block * base + column / block) % 3;
                let found: Vec<usize> = parts.iter().filter(|p| p.1.get(column, row)).map(|p| *p.0).collect();
                assert_eq!(found, if sky.get(column, row) { vec![] } else { vec![of] });
            }
        }
    }

    /// For blocks of 1, 2, 8 and 16 fine texels a side and squares coarser and finer than the base,
    /// each fine texel of a random sky stays where the square shows it, and no other does; all stay
    /// in a square that shows all.
    #[test]
    fn a_square_hides_its_texels_of_the_sky() {
        for (block, square) in [(1, 8), (2, 64), (8, 64), (16, 16), (8, 256)] {
            let (base, fine) = (32, 32 * block);
            let sky = random_sky(base, block);
            let shown: Vec<bool> =
                (0..square * square).map(|i| crate::hemisphere::mix(9, i as u64).is_multiple_of(3)).collect();
            let part = sky.within(&shown);
            for (column, row) in (0..fine * fine).map(|t| (t % fine, t / fine)) {
                let is_shown = shown[row * square / fine * square + column * square / fine];
                assert_eq!(part.get(column, row), sky.get(column, row) && is_shown, "{block} {square}");
            }
            assert_eq!(sky.within(&vec![true; square * square]), sky);
        }
    }

    /// Bits behind the last of 33 columns are no texels: an all-open texture whose bytes have them
    /// set shows 1,089 open texels.
    #[test]
    fn bits_behind_the_last_column_are_no_texels() {
        let raw = [0xff; 2 * 5 * 33];
        let bitmaps = SkyBitmap::unpack(&raw, 1, 33, 66).unwrap_or_default();
        let dense = SkyTexture::unpack(&raw, 1, 33, 66).unwrap_or_default();
        assert_eq!(bitmaps, [SkyBitmap::new(&dense[0], 33)]);
        let mut seen = Vec::new();
        bitmaps[0].for_visible(|texel, share| seen.push((texel, share)));
        assert_eq!(seen, (0..1089).map(|texel| (texel, 1.0)).collect::<Vec<_>>());
    }
}
