//! Squares of bits, of which all one-bit textures are made. In: bits by column and row, or bytes.
//! Out: counts, neighbours, and the square with twice the side.

use pulp::Arch;

/// A square of bits, row-major, rows padded to whole words, texel 0 = column 0, row 0 = lowest bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitSquare {
    n: usize,
    pub(super) stride: usize,
    pub(super) words: Vec<u64>,
}

impl BitSquare {
    /// Makes a square of `n` x `n` bits, all 0.
    pub fn new(n: usize) -> Self {
        let stride = n.div_ceil(64);
        BitSquare { n, stride, words: vec![0; stride * n] }
    }

    /// Returns the side of the square.
    pub fn side(&self) -> usize {
        self.n
    }

    /// Returns the bit at a column and a row, both below the side.
    #[inline]
    pub fn get(&self, column: usize, row: usize) -> bool {
        self.words[row * self.stride + column / 64] >> (column % 64) & 1 == 1
    }

    /// Sets the bit at a column and a row, both below the side.
    #[inline]
    pub fn set(&mut self, column: usize, row: usize, value: bool) {
        let word = &mut self.words[row * self.stride + column / 64];
        *word = *word & !(1 << (column % 64)) | (u64::from(value) << (column % 64));
    }

    /// Returns the number of set bits in the `size` x `size` block at a block column and row;
    /// `size` divides 64.
    pub fn count_block(&self, size: usize, block_column: usize, block_row: usize) -> u32 {
        let first = block_column * size;
        let mask = if size == 64 { u64::MAX } else { (1 << size) - 1 };
        (block_row * size..(block_row + 1) * size)
            .map(|row| (self.words[row * self.stride + first / 64] >> (first % 64) & mask).count_ones())
            .sum()
    }

    /// Returns the number of set bits.
    pub fn count(&self) -> u32 {
        self.words.iter().map(|word| word.count_ones()).sum()
    }

    /// Returns the set bits as (column, row), row by row.
    pub fn ones(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.words.iter().enumerate().flat_map(move |(i, &word)| {
            let (row, first) = (i / self.stride, i % self.stride * 64);
            std::iter::successors(Some(word), |w| Some(w & w.wrapping_sub(1)))
                .take_while(|&w| w != 0)
                .map(move |w| (first as u32 + w.trailing_zeros(), row as u32))
        })
    }

    /// Returns the bits of `within` whose 3 x 3 neighbourhood holds both values of this square.
    /// Neighbours outside `within` do not count.
    pub(super) fn mixed(&self, within: &Self) -> Self {
        let mut out = BitSquare::new(self.n);
        // Runs the code that is compiled for the processor at hand.
        Arch::new().dispatch(|| self.mix(within, &mut out));
        out
    }

    #[inline(always)]
    fn mix(&self, within: &Self, out: &mut Self) {
        let stride = self.stride;
        // Ones and zeros of three rows, each widened by its neighbours to the left and right: [row
        // of three][value][word].
        let mut wide = vec![0_u64; 6 * stride];
        // One row with an empty word at either end, so that the outermost words need no special
        // case.
        let mut plain = vec![0_u64; stride + 2];
        // A row is decided when the row below it is known, one turn later.
        for row in 0..=self.n {
            for value in 0..2 {
                let wide = &mut wide[(row % 3 * 2 + value) * stride..][..stride];
                if row == self.n {
                    wide.fill(0);
                    continue;
                }
                let range = row * stride..(row + 1) * stride;
                let flip = if value == 0 { 0 } else { u64::MAX };
                for ((p, bits), within) in
                    plain[1..].iter_mut().zip(&self.words[range.clone()]).zip(&within.words[range])
                {
                    *p = (bits ^ flip) & within;
                }
                for ((w, here), (before, after)) in wide.iter_mut().zip(&plain[1..]).zip(plain.iter().zip(&plain[2..]))
                {
                    *w = here | here << 1 | before >> 63 | here >> 1 | after << 63;
                }
            }
            if row > 0 {
                // Above the first row, the widened words are still 0.
                let range = (row - 1) * stride..row * stride;
                let (first, second) = wide.split_at(2 * stride);
                let (second, third) = second.split_at(2 * stride);
                let words = out.words[range.clone()].iter_mut().zip(&within.words[range]);
                for (i, (out, within)) in words.enumerate() {
                    let ones = first[i] | second[i] | third[i];
                    let zeros = first[stride + i] | second[stride + i] | third[stride + i];
                    *out = ones & zeros & within;
                }
            }
        }
    }

    /// Returns the square with twice the side, in which each bit becomes 2 x 2 bits.
    pub(super) fn double(&self) -> Self {
        let mut out = BitSquare::new(self.n * 2);
        Arch::new().dispatch(|| self.double_into(&mut out));
        out
    }

    #[inline(always)]
    fn double_into(&self, out: &mut Self) {
        let stride = out.stride;
        for (words, rows) in self.words.chunks_exact(self.stride).zip(out.words.chunks_exact_mut(2 * stride)) {
            let (upper, lower) = rows.split_at_mut(stride);
            for (pair, &word) in upper.chunks_mut(2).zip(words) {
                for (half, w) in pair.iter_mut().enumerate() {
                    *w = spread((word >> (32 * half)) as u32);
                }
            }
            lower.copy_from_slice(upper);
        }
    }

    /// Returns the square with twice the side. Each texel of `refined` takes its four bits from
    /// `nibbles`: two texels to a byte in the order of [`BitSquare::ones`], the two columns of a
    /// row side by side. Every other texel repeats its one bit.
    pub(super) fn refine(&self, refined: &Self, nibbles: &[u8]) -> Self {
        let mut out = self.double();
        for (i, (column, row)) in refined.ones().enumerate() {
            let nibble = u64::from(nibbles[i / 2] >> (i % 2 * 4));
            // Two columns never lie in two words.
            let (place, shift) = (2 * row as usize * out.stride + column as usize / 32, column % 32 * 2);
            for (place, bits) in [(place, nibble & 3), (place + out.stride, nibble >> 2 & 3)] {
                let word = &mut out.words[place];
                *word = *word & !(3 << shift) | bits << shift;
            }
        }
        out
    }

    /// Appends the rows to `out` as whole bytes, lowest bit first.
    pub(super) fn to_bytes(&self, out: &mut Vec<u8>) {
        let row_bytes = self.n.div_ceil(8);
        for row in self.words.chunks(self.stride) {
            out.extend(row.iter().flat_map(|w| w.to_le_bytes()).take(row_bytes));
        }
    }

    pub(super) fn from_bytes(n: usize, bytes: &[u8]) -> Self {
        let mut square = BitSquare::new(n);
        let row_bytes = n.div_ceil(8);
        for (row, bytes) in square.words.chunks_mut(square.stride).zip(bytes.chunks(row_bytes)) {
            for (word, bytes) in row.iter_mut().zip(bytes.chunks(8)) {
                let mut padded = [0; 8];
                padded[..bytes.len()].copy_from_slice(bytes);
                *word = u64::from_le_bytes(padded);
            }
            // Bits behind the last column are no texels, whatever the bytes say.
            if let Some(last) = row.last_mut().filter(|_| !n.is_multiple_of(64)) {
                *last &= (1 << (n % 64)) - 1;
            }
        }
        square
    }
}

/// Returns a word with each bit of `x` twice (Morton spreading).
#[inline(always)]
pub(super) fn spread(x: u32) -> u64 {
    let mut v = u64::from(x);
    v = (v | v << 16) & 0x0000_ffff_0000_ffff;
    v = (v | v << 8) & 0x00ff_00ff_00ff_00ff;
    v = (v | v << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    v = (v | v << 2) & 0x3333_3333_3333_3333;
    v = (v | v << 1) & 0x5555_5555_5555_5555;
    v | v << 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{jitter, mix};

    /// For a 96-wide square with 64 random bits, doubling and the mixed bits within 8,000 random
    /// ones agree with their plain definitions.
    #[test]
    fn bit_operations_agree_with_plain_loops() {
        let mut square = BitSquare::new(96);
        for i in 0..64 {
            let p = jitter(mix(1, 2), i) * 96.0;
            square.set(p.x as usize, p.y as usize, true);
        }
        let mut within = BitSquare::new(96);
        for i in 0..18_000 {
            let p = jitter(mix(3, 4), i) * 96.0;
            within.set(p.x as usize, p.y as usize, true);
        }
        assert!((7_000..9_000).contains(&within.count()));
        let (mixed, doubled) = (square.mixed(&within), square.double());
        for row in 0..96_usize {
            for column in 0..96_usize {
                let near = |v: usize| v.saturating_sub(1)..(v + 2).min(96);
                let has =
                    |value| near(row).any(|r| near(column).any(|c| within.get(c, r) && square.get(c, r) == value));
                let expected = within.get(column, row) && has(true) && has(false);
                assert_eq!(mixed.get(column, row), expected, "{column} {row}");
                let own = square.get(column, row);
                assert!(
                    [(0, 0), (1, 0), (0, 1), (1, 1)]
                        .iter()
                        .all(|(i, j)| doubled.get(2 * column + i, 2 * row + j) == own)
                );
            }
        }
        assert_eq!(
            square.ones().count() as u32,
            (0..12).flat_map(|r| (0..12).map(move |c| (c, r))).map(|(c, r)| square.count_block(8, c, r)).sum::<u32>()
        );
    }
}
