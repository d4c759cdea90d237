//! The sky of a receiver as words of 32 bits. In: its bitmap. Out: words; what base texels hold.
//!
//! One part after another:
//! - `[group]`, a texel each: bits of 64 base texels that are sky throughout, then of those that are in part, lowest first;
//! - `[group]`: how many are in part in the groups before, filled up to whole texels;
//! - `[base texel in part]`, [`Shape::steps`] words each: where the sky lies on one side of every row, its length in each row, in as
//!   few bits as the side of a base texel takes; the highest bit but one of the last word says that it is the right side. Where it lies otherwise the
//!   highest bit is set, and the first word says where its bits are, in words from the first of these;
//! - bits of those, row by row, lowest first; without steps, bits of all; filled up to whole texels.

use crate::layers::sky_bitmap::{BaseTexels, SkyBitmap, Texel};
use crate::replay::interactive::packed::{Shape, WORDS, padded};

/// Marks of the last word of steps.
const BITS: u32 = 1 << 31;
const RIGHT: u32 = 1 << 30;

/// Bits of the length of a row of a block.
fn length_bits(block: usize) -> usize {
    block.max(1).ilog2() as usize + 1
}

/// Words of the bits of a block.
fn bit_words(block: usize) -> usize {
    2 * (block * block).div_ceil(64)
}

/// Words of the steps of a block; 0 where they save nothing.
pub(super) fn step_words(block: usize) -> usize {
    let words = (block * length_bits(block) + 2).div_ceil(32);
    if block <= 64 && words < bit_words(block) { words } else { 0 }
}

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

/// A row of a block's bits.
fn row_of(bits: &[u64], block: usize, row: usize) -> u64 {
    let place = row * block;
    let mask = if block == 64 { u64::MAX } else { (1 << block) - 1 };
    // Sides are powers of 2, so no row crosses a word.
    bits[place / 64] >> (place % 64) & mask
}

/// Whether the sky is on the right of all rows of a block, or on their left; `None` if it lies otherwise.
fn side(bits: &[u64], block: usize) -> Option<bool> {
    if !block.is_power_of_two() {
        return None;
    }
    // The last bit of each row has no neighbour: rows lie within words.
    let ends = (u64::MAX / low(block as u32)) << (block - 1);
    let is_left = |word: &u64| word >> 1 & !word & !ends == 0;
    let is_right = |word: &u64| word & !(word >> 1) & !ends == 0;
    match bits.iter().all(is_left) {
        true => Some(false),
        false => bits.iter().all(is_right).then_some(true),
    }
}

/// Lengths of the sky in the rows of a block, one behind the other in words.
fn pack_steps(bits: &[u64], block: usize, words: &mut [u32]) {
    let (mut held, mut count, mut words) = (0_u64, 0, words.iter_mut());
    let mut put = |held: u64| {
        if let Some(word) = words.next() {
            *word = held as u32;
        }
    };
    for row in 0..block {
        held |= u64::from(row_of(bits, block, row).count_ones()) << count;
        count += length_bits(block);
        if count >= 32 {
            put(held);
            (held, count) = (held >> 32, count - 32);
        }
    }
    put(held);
}

/// So many of the lowest bits.
fn low(count: u32) -> u64 {
    u64::MAX.checked_shr(64 - count).unwrap_or_default()
}

/// The sky of a receiver in its words.
pub(super) struct SkyWords<'w> {
    words: &'w [u32],
    shape: Shape,
    /// Of the base texel that was asked for last.
    bits: Vec<u64>,
}

impl<'w> SkyWords<'w> {
    /// Of the words of a receiver from those of its sky on.
    pub fn new(words: &'w [u32], shape: Shape) -> Self {
        SkyWords { words, shape, bits: Vec::new() }
    }

    /// A word; 0 behind the last one, where no bit that counts lies: lengths of rows are read two words at a time.
    fn word(&self, place: usize) -> u32 {
        self.words.get(place).copied().unwrap_or_default()
    }

    fn pair(&self, place: usize) -> u64 {
        u64::from(self.word(place)) | u64::from(self.word(place + 1)) << 32
    }

    /// Makes the bits of the base texel in part of this number.
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

/// Low half first, as bits are counted.
fn halves(word: u64) -> [u32; 2] {
    [word as u32, (word >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::bits::BitSquare;

    /// Skies cut by straight lines, by two lines, and of single bits come back bit by bit from their words, with base texels of 4 to 64 fine
    /// texels a side: 40 skies a size. Lines take a third of the words of bits at 16.
    #[test]
    fn as_packed() {
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
                let bitmap = SkyBitmap::of(&dense, base);
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
