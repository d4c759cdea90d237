//! Decoder of sky textures from blocks to bitmaps. In: the raw bytes of a tile. Out: one bitmap a
//! receiver. It works only on the words that an edge runs through.
//!
//! [`crate::layers::sky`] says which texels are refined: those with both values in their 3 x 3
//! neighbourhood. The parent of such a texel was refined, or a neighbour of the parent was. So the
//! words that may hold refined texels follow from those of the level before.

use pulp::Arch;

use crate::layers::bits::{BitSquare, spread};
use crate::layers::sky::{decode, planes, sides};
use crate::layers::sky_bitmap::SkyBitmap;

/// Largest side of a square: the flags of a row's words fit into one word.
const LARGEST: usize = 4096;
/// Largest number of fine texels to a side of a base texel: a row of them lies within a word.
const WIDEST: usize = 64;

/// Returns true if [`decode_refined`] can decode textures of these sides.
pub fn is_refined(base: usize, fine: usize) -> bool {
    let block = fine / base.max(1);
    (2..=WIDEST).contains(&block) && block.is_power_of_two() && base * block == fine && fine <= LARGEST
}

/// Decodes the bitmaps of a raw block, for sides that [`is_refined`] accepts. Returns `None` if the
/// bytes do not describe `count` textures exactly.
pub fn decode_refined<'a>(raw: &'a [u8], count: usize, base: usize, fine: usize) -> Option<Vec<SkyBitmap>> {
    let (fronts, bits, mut rest) = planes(raw, count, base)?;
    let mut textures: Vec<RefinementDecoder> =
        fronts.into_iter().zip(bits).map(|(f, b)| RefinementDecoder::new(f, b)).collect();
    let arch = Arch::new();
    for _ in 1..sides(base, fine).count() {
        for texture in &mut textures {
            arch.dispatch(|| texture.take(&mut rest))?;
            arch.dispatch(|| texture.grow());
        }
    }
    // The last refinement is the largest, so only one texture holds it at a time.
    let mut scratch = Vec::new();
    let finish = |mut texture: RefinementDecoder<'a>| {
        arch.dispatch(|| texture.take(&mut rest))?;
        // Each size of blocks has code of its own.
        Some(match fine / base {
            2 => arch.dispatch(|| texture.finish::<2>(&mut scratch)),
            4 => arch.dispatch(|| texture.finish::<4>(&mut scratch)),
            8 => arch.dispatch(|| texture.finish::<8>(&mut scratch)),
            16 => arch.dispatch(|| texture.finish::<16>(&mut scratch)),
            32 => arch.dispatch(|| texture.finish::<32>(&mut scratch)),
            _ => arch.dispatch(|| texture.finish::<64>(&mut scratch)),
        })
    };
    let found = textures.into_iter().map(finish).collect::<Option<Vec<SkyBitmap>>>()?;
    rest.is_empty().then_some(found)
}

impl SkyBitmap {
    /// Unpacks the bitmaps of a raw `sky` block. Returns `None` if the bytes do not describe
    /// `count` textures exactly.
    pub fn unpack(raw: &[u8], count: usize, base: usize, fine: usize) -> Option<Vec<SkyBitmap>> {
        if is_refined(base, fine) {
            return decode_refined(raw, count, base, fine);
        }
        decode(raw, count, base, fine, |texture| SkyBitmap::new(&texture.dense(), base))
    }
}

/// Texture that is being decoded, level by level.
struct RefinementDecoder<'a> {
    side: usize,
    /// Number of words of a row.
    stride: usize,
    base_side: usize,
    /// `[row][word]`: bits of the level.
    bits: Vec<u64>,
    /// The surface's half of the hemisphere, equal in all rows of a base texel: `[base row][word]`.
    mask: Vec<u64>,
    /// `[row]`: a bit for each word that may hold refined texels.
    flags: Vec<u64>,
    /// `[row][word]`: texels that are refined.
    refined: Vec<u64>,
    /// Four bits of each refined texel, two texels to a byte.
    nibbles: &'a [u8],
}

impl<'a> RefinementDecoder<'a> {
    fn new(front: BitSquare, base: BitSquare) -> Self {
        let (side, stride) = (base.side(), base.stride);
        RefinementDecoder {
            side,
            stride,
            base_side: side,
            bits: base.words,
            mask: front.words,
            flags: vec![u64::MAX >> (64 - stride.clamp(1, 64)); side],
            refined: Vec::new(),
            nibbles: &[],
        }
    }

    /// Finds the texels that are refined, and takes their bits from the front of `rest`. Returns
    /// `None` if bits are missing.
    #[inline(always)]
    fn take(&mut self, rest: &mut &'a [u8]) -> Option<()> {
        self.refined = vec![0; self.bits.len()];
        let mut count = 0;
        // Binary logarithm of the rows of a base texel, whose number is a power of two.
        let steps = (self.side / self.base_side.max(1)).trailing_zeros();
        for row in 0..self.side {
            let mut flags = self.flags[row];
            while flags != 0 {
                let word = flags.trailing_zeros() as usize;
                flags &= flags - 1;
                let mixed = self.mixed(row, word, steps);
                count += mixed.count_ones() as usize;
                self.refined[row * self.stride + word] = mixed;
            }
        }
        let (level, tail) = rest.split_at_checked(count.div_ceil(2))?;
        (*rest, self.nibbles) = (tail, level);
        Some(())
    }

    /// Returns one word of [`BitSquare::mixed`].
    #[inline(always)]
    fn mixed(&self, row: usize, word: usize, steps: u32) -> u64 {
        let (mut ones, mut zeros, mut within) = (0, 0, 0);
        for near in row.saturating_sub(1)..(row + 2).min(self.side) {
            let bits = &self.bits[near * self.stride..][..self.stride];
            let mask = &self.mask[(near >> steps) * self.stride..][..self.stride];
            let (b, m) = (bits[word], mask[word]);
            let (one, zero) = (b & m, !b & m);
            ones |= one | one << 1 | one >> 1;
            zeros |= zero | zero << 1 | zero >> 1;
            if word > 0 {
                let (b, m) = (bits[word - 1], mask[word - 1]);
                ones |= (b & m) >> 63;
                zeros |= (!b & m) >> 63;
            }
            if word + 1 < self.stride {
                let (b, m) = (bits[word + 1], mask[word + 1]);
                ones |= (b & m) << 63;
                zeros |= (!b & m) << 63;
            }
            if near == row {
                within = m;
            }
        }
        ones & zeros & within
    }

    /// Makes the next level, with twice the side.
    #[inline(always)]
    fn grow(&mut self) {
        let (side, stride) = (self.side * 2, (self.side * 2).div_ceil(64));
        let mut bits = vec![0; side * stride];
        let mut flags = vec![0; side];
        let mut nibbles = Nibbles { bytes: self.nibbles, next: 0 };
        for row in 0..self.side {
            let (upper, lower) = bits[2 * row * stride..][..2 * stride].split_at_mut(stride);
            let mut near = 0;
            for word in 0..self.stride {
                let at = row * self.stride + word;
                let refined = self.refined[at];
                // All 64 texels are closed, as the new rows are from the start.
                if self.bits[at] | refined == 0 {
                    continue;
                }
                let [above, below] = doubled(self.bits[at], refined, &mut nibbles);
                (upper[2 * word], lower[2 * word]) = (above[0], below[0]);
                if 2 * word + 1 < stride {
                    (upper[2 * word + 1], lower[2 * word + 1]) = (above[1], below[1]);
                }
                if refined != 0 {
                    let wide = refined | refined << 1 | refined >> 1;
                    near |= u64::from(wide as u32 != 0) << (2 * word) | u64::from(wide >> 32 != 0) << (2 * word + 1);
                    // Texels at the ends of a word have neighbours in the words beside it.
                    near |= if word > 0 { (refined & 1) << (2 * word - 1) } else { 0 };
                    near |= if 2 * word + 2 < stride { (refined >> 63) << (2 * word + 2) } else { 0 };
                }
            }
            if near != 0 {
                near &= u64::MAX >> (64 - stride.clamp(1, 64));
                // The two rows of the children, and a row of neighbours on either side.
                flags[(2 * row).saturating_sub(1)..(2 * row + 3).min(side)].iter_mut().for_each(|f| *f |= near);
            }
        }
        let rows = self.mask.chunks(self.stride.max(1));
        let mut mask = vec![0; self.base_side * stride];
        for (row, out) in rows.zip(mask.chunks_mut(stride.max(1))) {
            for (&m, pair) in row.iter().zip(out.chunks_mut(2)) {
                let twice = [spread(m as u32), spread((m >> 32) as u32)];
                pair.copy_from_slice(&twice[..pair.len()]);
            }
        }
        self.mask = mask;
        (self.side, self.stride, self.bits, self.flags) = (side, stride, bits, flags);
    }

    /// Returns the bitmap of the last refinement, with `BLOCK` fine texels to a side of a base
    /// texel.
    #[inline(always)]
    fn finish<const BLOCK: usize>(self, scratch: &mut Vec<u64>) -> SkyBitmap {
        let (base, rows) = (self.base_side, BLOCK / 2);
        let steps = rows.trailing_zeros();
        let in_word = 64 / rows;
        let mut bitmap = SkyBitmap::closed(base, BLOCK);
        let mut nibbles = Nibbles { bytes: self.nibbles, next: 0 };
        // `[fine row of the base row][word]`, filled in active words only.
        let wide = 2 * self.stride;
        scratch.resize(BLOCK * wide, 0);
        let low = u64::MAX >> (64 - BLOCK);
        for base_row in 0..base {
            let active = self.flags[base_row * rows..][..rows].iter().fold(0, |all, f| all | f);
            for row in 0..rows {
                let mut words = active;
                while words != 0 {
                    let word = words.trailing_zeros() as usize;
                    words &= words - 1;
                    let at = (base_row * rows + row) * self.stride + word;
                    let [above, below] = doubled(self.bits[at], self.refined[at], &mut nibbles);
                    scratch[2 * row * wide + 2 * word..][..2].copy_from_slice(&above);
                    scratch[(2 * row + 1) * wide + 2 * word..][..2].copy_from_slice(&below);
                }
            }
            for word in 0..self.stride {
                let (first, open) = (word * in_word, base_row * bitmap.open.stride + word * in_word / 64);
                if active >> word & 1 == 0 {
                    // No edge: each base texel is one value.
                    let bits = every(self.bits[base_row * rows * self.stride + word], steps);
                    if bits != 0 {
                        bitmap.open.words[open] |= bits << (first % 64);
                    }
                    continue;
                }
                let (mut all, mut any, mut pairs) = ([u64::MAX; 2], [0; 2], [[0; 2]; BLOCK]);
                for (pair, row) in pairs.iter_mut().zip(scratch.chunks_exact(wide)) {
                    pair.copy_from_slice(&row[2 * word..][..2]);
                    (0..2).for_each(|i| (all[i], any[i]) = (all[i] & pair[i], any[i] | pair[i]));
                }
                for texel in 0..in_word.min(base.saturating_sub(first)) {
                    let (half, shift) = (texel * BLOCK / 64, texel * BLOCK % 64);
                    if any[half] >> shift & low == 0 {
                        continue;
                    }
                    if all[half] >> shift & low == low {
                        bitmap.open.set(first + texel, base_row, true);
                        continue;
                    }
                    bitmap.mixed.set(first + texel, base_row, true);
                    let in_place = (64 / BLOCK).min(BLOCK);
                    let place = |rows: &[[u64; 2]]| {
                        let row = |(i, pair): (usize, &[u64; 2])| (pair[half] >> shift & low) << (i * BLOCK);
                        rows.iter().enumerate().map(row).fold(0, |all, bits| all | bits)
                    };
                    bitmap.blocks.extend(pairs.chunks_exact(in_place).map(place));
                }
            }
        }
        bitmap.rank();
        bitmap
    }
}

/// Bits of refined texels, in the order in which they are stored.
struct Nibbles<'a> {
    bytes: &'a [u8],
    next: usize,
}

impl Nibbles<'_> {
    #[inline(always)]
    fn take(&mut self) -> u64 {
        let byte = self.bytes.get(self.next / 2).copied().unwrap_or_default();
        let nibble = u64::from(byte >> (self.next % 2 * 4)) & 15;
        self.next += 1;
        nibble
    }
}

/// Returns the two rows of two words that 64 texels become. Refined texels take their bits from
/// `nibbles`; each other texel is doubled.
#[inline(always)]
fn doubled(bits: u64, mut refined: u64, nibbles: &mut Nibbles) -> [[u64; 2]; 2] {
    let twice = match bits {
        0 => [0; 2],
        u64::MAX => [u64::MAX; 2],
        _ => [spread(bits as u32), spread((bits >> 32) as u32)],
    };
    let [mut above, mut below] = [twice; 2];
    while refined != 0 {
        let column = refined.trailing_zeros();
        refined &= refined - 1;
        let (nibble, half, shift) = (nibbles.take(), column as usize / 32, column % 32 * 2);
        above[half] = above[half] & !(3 << shift) | (nibble & 3) << shift;
        below[half] = below[half] & !(3 << shift) | (nibble >> 2) << shift;
    }
    [above, below]
}

/// Returns every 2^steps-th bit of a word, moved together.
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
