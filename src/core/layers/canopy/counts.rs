//! Counts of the crossings of one material along a list of rays. In: crossings. Out: bytes, and
//! back: bit planes of blocks of 64 rays, or codes of lengths that are predicted from each other
//! along a receiver's square ([`square`]).

use super::square;
use super::{COUNTS, Crossing};

/// Number of rays in a block of bit planes.
const BLOCK: usize = 64;

/// Number of rays in a span, which is kept if something is crossed in it.
const SPAN: usize = 16;

/// Number of bits of the largest count.
const MAX_BITS: u32 = (COUNTS - 1).ilog2() + 1;

/// First byte of predicted codes. That of bit planes is their number, 0 if nothing is crossed.
const PREDICTED: u8 = 128;

/// Share of the bytes of bit planes below which codes are predicted: zstd, which packs the layer,
/// leaves about this share of bit planes, and most of predicted codes.
const WORTH: usize = 3;

/// Counts of crossings along a list of rays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// True if the bytes hold predicted codes, false if they hold bit planes.
    predicted: bool,
    /// `[span / 64]`: spans in which something is crossed.
    used: Vec<u64>,
    /// `[used span][ray]`.
    counts: Vec<[u16; SPAN]>,
}

impl Counts {
    /// Takes the crossings of one material, sorted by ray.
    pub fn new(crossings: &[&Crossing]) -> Self {
        let mut counts = Counts::default();
        for of_span in crossings.chunk_by(|a, b| a.ray as usize / SPAN == b.ray as usize / SPAN) {
            let mut span = [0; SPAN];
            of_span.iter().for_each(|crossing| span[crossing.ray as usize % SPAN] = crossing.count);
            counts.push(of_span[0].ray as usize / SPAN, span);
        }
        counts
    }

    /// Appends a span behind all others; it is left out if nothing is crossed in it.
    fn push(&mut self, number: usize, span: [u16; SPAN]) {
        if span.iter().any(|count| *count > 0) {
            self.used.resize(number / 64 + 1, 0);
            self.used[number / 64] |= 1 << (number % 64);
            self.counts.push(span);
        }
    }

    /// Takes the counts along all rays.
    fn of_all(counts: &[u16], predicted: bool) -> Self {
        let mut found = Counts { predicted, ..Counts::default() };
        for (number, of_span) in counts.chunks(SPAN).enumerate() {
            let mut span = [0; SPAN];
            span[..of_span.len()].copy_from_slice(of_span);
            found.push(number, span);
        }
        found
    }

    /// Returns the counts along all of `rays` rays.
    fn all(&self, rays: usize) -> Vec<u16> {
        let mut all = vec![0; rays];
        for (number, span) in self.spans() {
            all.iter_mut().skip(number * SPAN).zip(span).for_each(|(count, own)| *count = *own);
        }
        all
    }

    /// Returns the used spans with their numbers.
    fn spans(&self) -> impl Iterator<Item = (usize, &[u16; SPAN])> {
        let numbers = self.used.iter().enumerate().flat_map(|(i, &word)| {
            let bits = std::iter::successors(Some(word), |w| Some(w & w.wrapping_sub(1))).take_while(|&w| w != 0);
            bits.map(move |w| i * 64 + w.trailing_zeros() as usize)
        });
        numbers.zip(&self.counts)
    }

    /// Returns true if nothing is crossed.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Returns the largest count.
    pub fn most(&self) -> u16 {
        self.counts.as_flattened().iter().fold(0, |most, count| most.max(*count))
    }

    /// Calls `each(ray, count)` for all rays that cross something.
    pub fn for_each(&self, mut each: impl FnMut(usize, u16)) {
        for (number, span) in self.spans() {
            for (i, &count) in span.iter().enumerate().filter(|(_, count)| **count > 0) {
                each(number * SPAN + i, count);
            }
        }
    }

    /// Multiplies the share along each ray by the share that its count lets through.
    pub fn dim(&self, shares: &mut [f32], powers: &[f32; COUNTS]) {
        for (number, span) in self.spans() {
            for (share, count) in shares[number * SPAN..].iter_mut().zip(span) {
                *share *= powers[usize::from(*count)];
            }
        }
    }

    /// Predicts the codes along the `rays` rays of a square, where this is worth it. A list without
    /// crossings is not predicted.
    pub fn predicted(mut self, rays: usize) -> Self {
        if self.is_empty() {
            return self;
        }
        let planes = mask_bytes(rays) + 8 * self.bits() as usize * self.blocks(rays).count();
        let code = square::encode(&self.all(rays)).filter(|code| WORTH * code.len() < planes);
        self.predicted = code.is_some();
        self
    }

    /// Returns the number of bits of the largest count.
    fn bits(&self) -> u32 {
        u16::BITS - self.most().leading_zeros()
    }

    /// Returns the blocks in which something is crossed, with their numbers.
    fn blocks(&self, rays: usize) -> impl Iterator<Item = (usize, Vec<u16>)> {
        let all = self.all(rays);
        let blocks: Vec<_> = all.chunks(BLOCK).map(<[u16]>::to_vec).enumerate().collect();
        blocks.into_iter().filter(|(_, counts)| counts.iter().any(|count| *count > 0))
    }

    /// Appends the bytes for `rays` rays.
    pub fn put(&self, bytes: &mut Vec<u8>, rays: usize) {
        let code = if self.predicted { square::encode(&self.all(rays)) } else { None };
        if let Some(code) = code {
            bytes.push(PREDICTED);
            bytes.extend((code.len() as u32).to_le_bytes());
            bytes.extend(code);
            return;
        }
        bytes.push(self.bits() as u8);
        if self.is_empty() {
            return;
        }
        let mask = bytes.len();
        bytes.resize(mask + mask_bytes(rays), 0);
        for (number, counts) in self.blocks(rays) {
            bytes[mask + number / 8] |= 1 << (number % 8);
            for bit in 0..self.bits() {
                let word = counts.iter().rev().fold(0_u64, |word, count| word << 1 | u64::from(count >> bit & 1));
                bytes.extend(word.to_le_bytes());
            }
        }
    }

    /// Reads the counts along `rays` rays from the front of `bytes` and moves past them. Only those
    /// along the square of a receiver may be predicted.
    pub fn take(bytes: &mut &[u8], rays: usize, square: bool) -> Option<Self> {
        let (&form, rest) = bytes.split_first()?;
        *bytes = rest;
        match form {
            0 => Some(Counts::default()),
            PREDICTED if square => {
                let (length, rest) = bytes.split_first_chunk()?;
                let (code, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
                *bytes = rest;
                let counts = Counts::of_all(&square::decode(code, rays)?, true);
                (!counts.is_empty()).then_some(counts)
            }
            bits => Counts::take_planes(bytes, rays, u32::from(bits)),
        }
    }

    /// Reads bit planes. Equal counts have equal bytes, so some count has all bits, and each block
    /// has a count above 0.
    fn take_planes(bytes: &mut &[u8], rays: usize, bits: u32) -> Option<Self> {
        let (mask, rest) = bytes.split_at_checked(mask_bytes(rays))?;
        let blocks: Vec<usize> = (0..8 * mask.len()).filter(|&block| mask[block / 8] >> (block % 8) & 1 == 1).collect();
        let (planes, rest) = rest.split_at_checked(8 * bits as usize * blocks.len())?;
        *bytes = rest;
        // Only ten planes or fewer make counts that are known.
        if bits > MAX_BITS || blocks.last().is_some_and(|block| block * BLOCK >= rays) {
            return None;
        }
        let mut counts = Counts::default();
        for (block, planes) in blocks.into_iter().zip(planes.chunks_exact(8 * bits as usize)) {
            let mut spans = [[0_u16; SPAN]; BLOCK / SPAN];
            for (bit, word) in planes.as_chunks().0.iter().enumerate() {
                let mut word = u64::from_le_bytes(*word);
                while word != 0 {
                    spans.as_flattened_mut()[word.trailing_zeros() as usize] |= 1 << bit;
                    word &= word - 1;
                }
            }
            let beyond = spans.as_flattened().iter().skip(rays - block * BLOCK).any(|count| *count > 0);
            if beyond || spans.as_flattened().iter().all(|count| *count == 0) {
                return None;
            }
            spans.iter().zip(block * (BLOCK / SPAN)..).for_each(|(span, number)| counts.push(number, *span));
        }
        (counts.bits() == bits).then_some(counts)
    }
}

/// Returns the number of bytes of the mask of used blocks for a number of rays.
fn mask_bytes(rays: usize) -> usize {
    rays.div_ceil(BLOCK).div_ceil(8)
}
