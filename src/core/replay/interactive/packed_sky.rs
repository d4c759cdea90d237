//! The sky of a receiver as 32-bit words. In: a sky bitmap. Out: the words; the content of base
//! texels read from them.
//!
//! The words consist of four parts, one after another:
//! - `[group]`, one texel each: bits of the 64 base texels that are open throughout, then bits of
//!   those that are partly open, lowest bit first;
//! - `[group]`: number of partly open base texels in the groups before, filled up to whole texels;
//! - `[partly open base texel]`, [`Shape::steps`] words each: if the sky lies on one side of every
//!   row, its length in each row, in as few bits as the side of a base texel takes; the second
//!   highest bit of the last word is set if that side is the right one. Otherwise the highest bit
//!   of the last word is set, and the first word says where the base texel's bits start, in words
//!   from the start of this part;
//! - bits of the base texels that row lengths cannot describe, row by row, lowest first; the bits
//!   of all partly open base texels where [`Shape::steps`] is 0. Filled up to whole texels.

use crate::layers::sky_bitmap::{BaseTexels, SkyBitmap, Texel};
use crate::replay::interactive::shape::{Shape, WORDS, bit_words, length_bits, padded};

/// Flags in the last word of a base texel's row lengths.
const BITS: u32 = 1 << 31;
const RIGHT: u32 = 1 << 30;

/// Appends the words of a sky.
pub(super) fn pack(sky: &SkyBitmap, shape: Shape, words: &mut Vec<u32>) {
    let (open, mixed, ranks, blocks) = sky.bits();
    words.extend(open.iter().zip(mixed).flat_map(|(&open, &mixed)| halves(open).into_iter().chain(halves(mixed))));
    padded(words, shape.groups.div_ceil(WORDS), ranks.iter().copied());
    let first = words.len();
    let bits = (bit_words(shape.block) / 2).max(1);
    if shape.steps == 0 {
        words.extend(blocks.iter().flat_map(|&word| halves(word)));
    } else {
        let end = first + blocks.len() / bits * shape.steps;
        words.resize(end, 0);
        for (number, block) in blocks.chunks_exact(bits).enumerate() {
            let (start, here) = (words.len() - first, first + number * shape.steps);
            let here = &mut words[here..here + shape.steps];
            match side(block, shape.block) {
                Some(right) => {
                    pack_steps(block, shape.block, here);
                    here[shape.steps - 1] |= if right { RIGHT } else { 0 };
                }
                None => {
                    here[0] = start as u32;
                    here[shape.steps - 1] |= BITS;
                    words.extend(block.iter().flat_map(|&word| halves(word)));
                }
            }
        }
    }
    words.resize(first + (words.len() - first).next_multiple_of(WORDS), 0);
}

/// Returns the bits of one row of a base texel.
fn row_of(bits: &[u64], block: usize, row: usize) -> u64 {
    let place = row * block;
    let mask = if block == 64 { u64::MAX } else { (1 << block) - 1 };
    // Sides are powers of 2, so no row crosses a word.
    bits[place / 64] >> (place % 64) & mask
}

/// Returns `Some(true)` if the sky is on the right of all rows of a base texel, `Some(false)` if it
/// is on their left, and `None` if it lies otherwise.
fn side(bits: &[u64], block: usize) -> Option<bool> {
    if !block.is_power_of_two() {
        return None;
    }
    // The last bit of each row has no neighbour: rows lie within words. The quotient has the first
    // bit of each row.
    let ends = (u64::MAX / low(block as u32)) << (block - 1);
    let is_left = |word: &u64| word >> 1 & !word & !ends == 0;
    let is_right = |word: &u64| word & !(word >> 1) & !ends == 0;
    match bits.iter().all(is_left) {
        true => Some(false),
        false => bits.iter().all(is_right).then_some(true),
    }
}

/// Writes the lengths of the sky in the rows of a base texel to words, one length directly after
/// another.
fn pack_steps(bits: &[u64], block: usize, words: &mut [u32]) {
    let (mut held, mut count, mut words) = (0_u64, 0, words.iter_mut());
    let mut put = |held: u64| {
        if let Some(word) = words.next() {
            *word = held as u32;
        }
    };
    for row in 0..block {
        // A length has at most 7 bits and `count` is below 32, so `held` cannot overflow.
        held |= u64::from(row_of(bits, block, row).count_ones()) << count;
        count += length_bits(block);
        if count >= 32 {
            put(held);
            (held, count) = (held >> 32, count - 32);
        }
    }
    put(held);
}

/// Returns a word with the `count` lowest bits set.
fn low(count: u32) -> u64 {
    u64::MAX.checked_shr(64 - count).unwrap_or_default()
}

/// Sky of a receiver, read from its words.
pub(super) struct SkyWords<'w> {
    words: &'w [u32],
    shape: Shape,
    /// Bits of the base texel that was read last.
    bits: Vec<u64>,
}

impl<'w> SkyWords<'w> {
    /// Reads the sky from the words of a receiver, which start with those of its sky.
    pub fn new(words: &'w [u32], shape: Shape) -> Self {
        SkyWords { words, shape, bits: Vec::new() }
    }

    /// Returns a word, or 0 behind the last one. Row lengths are read two words at a time, and the
    /// bits behind the last word do not count.
    fn word(&self, place: usize) -> u32 {
        self.words.get(place).copied().unwrap_or_default()
    }

    fn pair(&self, place: usize) -> u64 {
        u64::from(self.word(place)) | u64::from(self.word(place + 1)) << 32
    }

    /// Fills `bits` with those of the partly open base texel of this number.
    fn unfold(&mut self, number: usize) {
        let Shape { groups, block, steps, .. } = self.shape;
        let first = groups * WORDS + groups.div_ceil(WORDS) * WORDS;
        let count = bit_words(block) / 2;
        let here = first + number * if steps == 0 { 2 * count } else { steps };
        let last = self.word(here + steps.saturating_sub(1));
        self.bits.clear();
        if steps == 0 || last & BITS != 0 {
            let start = if steps == 0 { here } else { first + (self.word(here) & !BITS) as usize };
            for word in 0..count {
                let pair = self.pair(start + 2 * word);
                self.bits.push(pair);
            }
            return;
        }
        self.bits.resize(count, 0);
        let wide = length_bits(block);
        for row in 0..block {
            let length = (self.pair(here + row * wide / 32) >> (row * wide % 32)) as u32 & ((1 << wide) - 1);
            let length = length.min(block as u32);
            let shift = if last & RIGHT == 0 { 0 } else { block as u32 - length };
            let place = row * block;
            self.bits[place / 64] |= low(length).checked_shl(shift).unwrap_or_default() << (place % 64);
        }
    }
}

impl BaseTexels for SkyWords<'_> {
    fn texel(&mut self, column: usize, row: usize) -> Texel<'_> {
        let (group, bit) = (row * self.shape.stride + column / 64, column % 64);
        let [open, mixed] = [0, 2].map(|half| self.pair(group * WORDS + half));
        if open >> bit & 1 == 1 {
            return Texel::Open;
        }
        if mixed >> bit & 1 == 0 {
            return Texel::Closed;
        }
        let before = self.word(self.shape.groups * WORDS + group);
        self.unfold((before + (mixed & ((1 << bit) - 1)).count_ones()) as usize);
        Texel::Mixed(&self.bits)
    }
}

/// Splits a word into its low and its high half, the low half first, which is the order of the
/// bits.
fn halves(word: u64) -> [u32; 2] {
    [word as u32, (word >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::bits::BitSquare;

    /// Sky bitmaps cut by one straight line, cut by two lines, and of single bits come back bit by
    /// bit from their words, with base texels of 4 to 64 fine texels a side: 40 skies for each
    /// size. At 16 fine texels a side, skies cut by a line take at most 0.38 of the words that
    /// their bits take.
    #[test]
    fn packed_skies_come_back_bit_by_bit() {
        for (base, block, most) in [(16, 4, 1.01), (64, 8, 1.01), (64, 16, 0.38), (8, 32, 0.25), (3, 64, 0.15)] {
            let fine = base * block;
            for seed in 0..40_usize {
                let [a, b, c] = [7, 11, 13].map(|k| (((seed + 1) * k * k) % 31) as i64 - 15);
                let line = |x: usize, y: usize| a * x as i64 + b * y as i64 > (a + b) * fine as i64 / 2 + c;
                let sky = |x: usize, y: usize| match seed % 3 {
                    0 => line(x, y),
                    1 => line(x, y) || line(fine - x, y / 2),
                    _ => (x * 31 + y * 17 + seed).is_multiple_of(5),
                };
                let mut dense = BitSquare::new(fine);
                (0..fine * fine).for_each(|i| dense.set(i % fine, i / fine, sky(i % fine, i / fine)));
                let bitmap = SkyBitmap::new(&dense, base);
                let shape = Shape::new(145, 0, &bitmap);
                let mut words = Vec::new();
                pack(&bitmap, shape, &mut words);
                assert!(words.len() % WORDS == 0);
                let mut found = SkyWords::new(&words, shape);
                for place in 0..base * base {
                    let at = (place % base, place / base);
                    assert_eq!(found.texel(at.0, at.1), bitmap.texel(at.0, at.1), "{base} {block} {seed} {at:?}");
                }
                if seed % 3 == 0 {
                    let before = shape.groups * WORDS + shape.groups.div_ceil(WORDS) * WORDS;
                    let of_bits = bitmap.bits().3.len() * 2;
                    assert!((words.len() - before) as f64 <= most * of_bits as f64 + 4.0, "{block} {seed}");
                }
            }
        }
    }
}
