//! Blocks of 4 x 4 texels, in which a trace asks for texels of a square of bits and gets the
//! answers. In: squares of bits. Out: the blocks that hold set bits or children of set bits; and
//! back.

use super::bits::BitSquare;

/// Block of 4 x 4 texels of an n x n texture, some of which are asked for. Masks hold column `c`
/// and row `r` of the block at bit 4 r + c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelBlock {
    /// Column of the block: a quarter of the column of its first texel.
    pub column: u32,
    /// Row of the block.
    pub row: u32,
    /// Mask of the texels that are asked for.
    pub wanted: u16,
    /// Answer: mask of the texels asked for that are 1.
    pub ones: u16,
}

impl TexelBlock {
    /// Number of texels to a side of a block.
    pub const SIDE: u32 = 4;

    fn asked(column: usize, row: usize, wanted: u16) -> Self {
        TexelBlock { column: column as u32, row: row as u32, wanted, ones: 0 }
    }

    /// Returns the column and row of the texel at a bit of the masks.
    #[inline]
    pub fn texel(&self, bit: u32) -> (u32, u32) {
        (self.column * Self::SIDE + bit % Self::SIDE, self.row * Self::SIDE + bit / Self::SIDE)
    }

    /// Returns true if another block holds the same texels.
    pub fn lies_at(&self, other: &Self) -> bool {
        (self.row, self.column) == (other.row, other.column)
    }

    /// Returns the bits, in the masks, of the texels that are asked for.
    pub fn bits(&self) -> impl Iterator<Item = u32> + use<> {
        let wanted = self.wanted;
        (0..u16::BITS).filter(move |bit| wanted >> bit & 1 == 1)
    }

    /// Turns a function that answers for lists of texels into one that answers for blocks of an n x
    /// n texture.
    pub fn by_texels(
        mut answer: impl FnMut(usize, &[(u32, u32)]) -> Vec<bool>,
    ) -> impl FnMut(usize, &mut [TexelBlock]) {
        move |n, blocks| {
            let places: Vec<(usize, u32)> = blocks
                .iter()
                .enumerate()
                .flat_map(|(place, block)| block.bits().map(move |bit| (place, bit)))
                .collect();
            let texels: Vec<(u32, u32)> = places.iter().map(|&(place, bit)| blocks[place].texel(bit)).collect();
            for ((place, bit), one) in places.into_iter().zip(answer(n, &texels)) {
                blocks[place].ones |= u16::from(one) << bit;
            }
        }
    }
}

/// Texels of an n x n square that were asked for, and their answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answers {
    pub(super) asked: BitSquare,
    pub(super) bits: BitSquare,
}

impl Answers {
    /// Returns two masks of a block: its texels that were asked for, and those of them that are 1.
    #[inline]
    pub fn of(&self, block: &TexelBlock) -> (u16, u16) {
        let asked = self.asked.block(block.column, block.row);
        (asked, asked & self.bits.block(block.column, block.row))
    }
}

impl BitSquare {
    /// Finds the blocks of the set bits, row by row.
    pub(super) fn blocks(&self, blocks: &mut Vec<TexelBlock>) {
        blocks.clear();
        for (row, band) in self.words.chunks(4 * self.stride).enumerate() {
            for i in 0..self.stride {
                let word = |r: usize| band.get(r * self.stride + i).copied().unwrap_or_default();
                let words = [word(0), word(1), word(2), word(3)];
                let mut any = words.iter().fold(0, |any, word| any | word);
                while any != 0 {
                    let shift = any.trailing_zeros() & !3;
                    any &= !(15 << shift);
                    let wanted = words.iter().rev().fold(0, |wanted, word| wanted << 4 | (word >> shift & 15) as u16);
                    blocks.push(TexelBlock::asked(16 * i + shift as usize / 4, row, wanted));
                }
            }
        }
    }

    /// Finds the blocks of the children of the set bits, in a square with twice the side, row by
    /// row.
    pub(super) fn child_blocks(&self, blocks: &mut Vec<TexelBlock>) {
        // Masks of two columns, by their two bits: each bit becomes 2 x 2 bits.
        const TWICE: [u16; 4] = [0, 0x33, 0xcc, 0xff];
        blocks.clear();
        for (row, band) in self.words.chunks(2 * self.stride).enumerate() {
            for i in 0..self.stride {
                let words = [band[i], band.get(self.stride + i).copied().unwrap_or_default()];
                let mut any = words[0] | words[1];
                while any != 0 {
                    let shift = any.trailing_zeros() & !1;
                    any &= !(3 << shift);
                    let [upper, lower] = words.map(|word| TWICE[(word >> shift & 3) as usize]);
                    blocks.push(TexelBlock::asked(32 * i + shift as usize / 2, row, upper | lower << 8));
                }
            }
        }
    }

    /// Stores the answers of a block.
    #[inline]
    pub(super) fn put(&mut self, block: &TexelBlock) {
        let (first, side) = (block.row as usize * 4, self.side());
        let (place, shift) = (block.column as usize / 16, block.column % 16 * 4);
        for row in first..(first + 4).min(side) {
            let nibble = |mask: u16| u64::from(mask >> (row % 4 * 4) & 15) << shift;
            let word = &mut self.words[row * self.stride + place];
            *word = *word & !nibble(block.wanted) | nibble(block.ones & block.wanted);
        }
    }

    /// Returns the bits of a block as [`TexelBlock`] holds them; 0 beyond the square.
    #[inline]
    fn block(&self, column: u32, row: u32) -> u16 {
        let (place, shift) = (column as usize / 16, column % 16 * 4);
        let rows = (row as usize * 4..self.side()).take(4);
        rows.zip((0..).step_by(4))
            .fold(0, |block, (row, bit)| block | ((self.words[row * self.stride + place] >> shift & 15) as u16) << bit)
    }

    /// Returns the four bits of each texel of `refined`, a square with half the side. It is the
    /// inverse of [`BitSquare::refine`].
    pub(super) fn nibbles(&self, refined: &Self) -> Vec<u8> {
        let mut nibbles = Vec::with_capacity((refined.count() as usize).div_ceil(2));
        let mut half = None;
        for (i, &word) in refined.words.iter().enumerate() {
            let (row, first) = (i / refined.stride, i % refined.stride * 2);
            let mut rest = word;
            while rest != 0 {
                let column = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                // Two columns never lie in two words.
                let (place, shift) = (2 * row * self.stride + first + column / 32, column % 32 * 2);
                let two = |place: usize| (self.words[place] >> shift & 3) as u8;
                let nibble = two(place) | two(place + self.stride) << 2;
                match half.take() {
                    Some(low) => nibbles.push(low | nibble << 4),
                    None => half = Some(nibble),
                }
            }
        }
        nibbles.extend(half);
        nibbles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{jitter, mix};

    /// For 600 random bits in squares of 5 sides, also sides that 4 does not divide, the blocks
    /// hold each bit once and nothing else, and the child blocks hold four for each. Answers put
    /// into a square and read as nibbles come back.
    #[test]
    fn blocks_hold_each_bit_of_a_square_once() {
        for side in [3, 8, 70, 128, 200] {
            let mut square = BitSquare::new(side);
            for i in 0..600 {
                let p = jitter(mix(5, side as u64), i) * side as f64;
                square.set(p.x as usize, p.y as usize, true);
            }
            let texels = |blocks: &[TexelBlock]| -> Vec<(u32, u32)> {
                let mut all: Vec<_> = blocks.iter().flat_map(|b| b.bits().map(|bit| b.texel(bit))).collect();
                all.sort_unstable_by_key(|&(c, r)| (r, c));
                all
            };
            let mut blocks = Vec::new();
            square.blocks(&mut blocks);
            assert_eq!(texels(&blocks), square.ones().collect::<Vec<_>>());
            square.child_blocks(&mut blocks);
            assert_eq!(texels(&blocks), square.double().ones().collect::<Vec<_>>());
            let mut fine = square.double();
            blocks.iter_mut().enumerate().for_each(|(i, block)| block.ones = mix(7, i as u64) as u16);
            blocks.iter().for_each(|block| fine.put(block));
            for block in &blocks {
                let given = block.bits().filter(|&bit| {
                    let (column, row) = block.texel(bit);
                    fine.get(column as usize, row as usize) == (block.ones >> bit & 1 == 1)
                });
                assert_eq!(given.count() as u32, block.wanted.count_ones());
            }
            assert_eq!(square.refine(&square, &fine.nibbles(&square)), fine);
        }
    }
}
