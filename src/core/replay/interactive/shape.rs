//! Layout of a receiver's words. In: the sizes of its layers. Out: the number of texels of each
//! part, and words that fill them.

use crate::layers::sky_bitmap::SkyBitmap;

/// Number of words in a texel.
pub(super) const WORDS: usize = 4;

/// Number of patches in a texel of coefficients.
pub(super) const PATCHES: usize = 16;

/// Sizes of the parts of a receiver's words, which are equal in all tiles of an archive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    /// Texels of the coefficients.
    pub patches: usize,
    /// Texels of the response; 0 where nothing reflects.
    pub response: usize,
    /// Texels of the sky's base texels, of which each holds 64.
    pub groups: usize,
    /// Groups to a row of base texels: rows start new ones.
    pub stride: usize,
    /// Fine texels to a side of a base texel.
    pub block: usize,
    /// Words of a base texel in part whose rows are steps; 0 where all are bits.
    pub steps: usize,
}

impl Shape {
    /// Returns the layout for skies of `patches` patches, responses of `response` texels a side,
    /// and the sky bitmaps of a tile.
    pub(super) fn new(patches: usize, response: usize, sky: &SkyBitmap) -> Self {
        Shape {
            patches: patches.div_ceil(PATCHES),
            response: (response * response).div_ceil(WORDS),
            groups: sky.bits().0.len(),
            stride: sky.side().div_ceil(64),
            block: sky.block(),
            steps: step_words(sky.block()),
        }
    }

    /// Returns the number of words that hold the remainders of the response. Byte k of word i
    /// belongs to texel k x `rest` + i.
    pub(super) fn rest(self) -> usize {
        self.response.div_ceil(WORDS) * WORDS
    }
}

/// Appends words, filled up with zeros to `texels` texels.
pub(super) fn padded(words: &mut Vec<u32>, texels: usize, of: impl Iterator<Item = u32>) {
    let end = words.len() + texels * WORDS;
    words.extend(of.take(texels * WORDS));
    words.resize(end, 0);
}

/// Returns the number of words that the row lengths of a base texel take; 0 where they are not
/// shorter than its bits.
fn step_words(block: usize) -> usize {
    let words = (block * length_bits(block) + 2).div_ceil(32);
    if block <= 64 && words < bit_words(block) { words } else { 0 }
}

/// Returns the number of bits that the length of a row of a base texel takes.
pub(super) fn length_bits(block: usize) -> usize {
    block.max(1).ilog2() as usize + 1
}

/// Returns the number of words that the bits of a base texel take.
pub(super) fn bit_words(block: usize) -> usize {
    2 * (block * block).div_ceil(64)
}
