//! A tile's coefficients as bytes. In: whole numbers of each receiver. Out: bytes, and back. Each receiver is told as what it adds to
//! one before it, or to nothing, and each coefficient in a context: how large those of lower frequencies above it are.

use crate::layers::rans::{self, Encoder, State, SymbolTables};
use crate::layers::response::transform::{BLOCK, LARGEST, PLANES};

/// Receivers that one may be told by are at most so many before it.
const FARTHEST: usize = 63;

/// Values around one, weighed, from which on it is in the next context.
const THRESHOLDS: [u32; 8] = [1, 3, 7, 13, 23, 39, 63, 103];

/// Larger values around one count as this.
const LARGE: u32 = 31;

/// Contexts of a place in a block: that of the mean value, then by what is around.
const PLACES: usize = THRESHOLDS.len() + 2;

/// Context of the receivers that others are told by.
const REFERENCE: usize = 0;

/// Contexts of extents, along and across.
const EXTENT: [usize; 2] = [1, 2];

/// First contexts of a block's places, along and across.
const PLACE: [usize; 2] = [3, 3 + PLACES];

const CONTEXTS: usize = 3 + 2 * PLACES;

/// What is said to be around the mean value.
const MEAN: u8 = u8::MAX;

/// `[values around, weighed]`: context of a place; none but [`MEAN`] is above 7 x 31.
const AROUND: [u8; 256] = {
    let mut contexts = [0; 256];
    let mut around = 0;
    while around < MEAN as usize {
        let mut next = 0;
        while next < THRESHOLDS.len() && THRESHOLDS[next] as usize <= around {
            next += 1;
        }
        contexts[around] = 1 + next as u8;
        around += 1;
    }
    contexts
};

/// Calls for each place of a block up to an extent with its context, and takes its folded value from the answer, until there is none.
/// Contexts follow from the rows above alone, so that a row's are known before its values are.
#[inline(always)]
fn places(extent: usize, mut value: impl FnMut(usize, usize, usize) -> Option<u32>) -> Option<()> {
    // The rows above, between columns of zeros.
    let (mut above, mut twice_above) = ([0_u8; BLOCK + 2], [0_u8; BLOCK]);
    for row in 0..extent.min(BLOCK) {
        let end = (extent - row).min(BLOCK);
        let around: [u8; BLOCK] = if row > 0 {
            std::array::from_fn(|i| 3 * above[i + 1] + 2 * above[i] + above[i + 2] + twice_above[i])
        } else {
            // Nothing is above: the nearer to the extent, the smaller.
            std::array::from_fn(|i| if i > 0 { 6 * extent.saturating_sub(1 + i) as u8 } else { MEAN })
        };
        let contexts = around.map(|around| AROUND[usize::from(around)]);
        twice_above.copy_from_slice(&above[1..=BLOCK]);
        above = [0; BLOCK + 2];
        for column in 0..end {
            let folded = value(row, column, usize::from(contexts[column]))?;
            above[column + 1] = folded.min(LARGE) as u8;
        }
    }
    Some(())
}

/// Bytes of the coefficients of a tile's receivers, each `[plane][block][row][column]`.
pub fn encode(receivers: &[Vec<i32>]) -> Vec<u8> {
    let mut encoder = Encoder::new(CONTEXTS);
    let small: Vec<Vec<i16>> =
        receivers.iter().map(|of| of.iter().map(|c| (*c).clamp(-255, 255) as i16).collect()).collect();
    let nothing: Vec<i32> = vec![0; receivers.first().map_or(0, Vec::len)];
    for (i, coefficients) in receivers.iter().enumerate() {
        let before = best_before(&small, i);
        encoder.put(REFERENCE, before as u32);
        let base = if before == 0 { &nothing } else { &receivers[i - before] };
        let rest: Vec<i32> = coefficients.iter().zip(base).map(|(c, base)| c - base).collect();
        let blocks = rest.as_chunks::<BLOCK>().0.as_chunks::<BLOCK>().0;
        let of_plane = (blocks.len() / PLANES).max(1);
        for (number, block) in blocks.iter().enumerate() {
            let across = usize::from(number / of_plane % 3 != 0);
            let extent = extent_of(block);
            encoder.put(EXTENT[across], extent as u32);
            // It answers always.
            let _ = places(extent, |row, column, context| {
                let folded = fold(block[row][column]);
                encoder.put(PLACE[across] + context, folded);
                Some(folded)
            });
        }
    }
    encoder.finish()
}

/// 0, 1, -1, 2, ... as 0, 1, 2, 3, ...
fn fold(value: i32) -> u32 {
    if value > 0 { 2 * value as u32 - 1 } else { 2 * value.unsigned_abs() }
}

/// Inverse of [`fold`] below 2^31.
#[inline]
fn unfold(folded: u32) -> i32 {
    let half = (folded / 2) as i32;
    if folded % 2 == 1 { half + 1 } else { -half }
}

/// How far before receiver i stands the one that it is told by; 0 for none. The nearest of the best.
fn best_before(receivers: &[Vec<i16>], i: usize) -> usize {
    let own = &receivers[i];
    let nothing: u32 = own.iter().map(|c| u32::from(c.unsigned_abs().min(8))).sum();
    let mut best = (nothing, 0);
    for before in 1..=i.min(FARTHEST) {
        let cost = difference(own, &receivers[i - before]);
        if cost < best.0 {
            best = (cost, before);
        }
    }
    best.1
}

/// What it takes to tell one by another, roughly.
fn difference(a: &[i16], b: &[i16]) -> u32 {
    let of_part = |(a, b): (&[i16], &[i16])| a.iter().zip(b).map(|(a, b)| (a - b).abs().min(8)).sum::<i16>() as u32;
    a.chunks(1024).zip(b.chunks(1024)).map(of_part).sum()
}

/// Coefficients are told where row + column is below this, 0 to 15: the others are 0.
fn extent_of(block: &[[i32; BLOCK]; BLOCK]) -> usize {
    let of_row =
        |(row, line): (usize, &[i32; BLOCK])| line.iter().rposition(|c| *c != 0).map_or(0, |column| row + column + 1);
    block.iter().enumerate().map(of_row).max().unwrap_or(0)
}

/// Reads the coefficients of one receiver after the other.
pub struct TileDecoder<'a> {
    tables: SymbolTables,
    state: State<'a>,
    blocks: usize,
    /// `[receiver][plane][block][row][column]` of those before.
    known: Vec<i32>,
}

impl<'a> TileDecoder<'a> {
    /// Of receivers with so many blocks a plane; `None` if the bytes do not start as they must.
    pub fn new(bytes: &'a [u8], blocks: usize) -> Option<Self> {
        let (tables, state) = rans::open(CONTEXTS, bytes)?;
        Some(TileDecoder { tables, state, blocks, known: Vec::new() })
    }

    /// The next receiver's coefficients; `None` if there are none, or wrong ones.
    #[inline(always)]
    pub fn receiver(&mut self) -> Option<&[i32]> {
        let (tables, mut state) = (&self.tables, self.state);
        let before = state.take(tables, REFERENCE)? as usize;
        let of_plane = self.blocks * BLOCK * BLOCK;
        let start = self.known.len();
        if before == 0 {
            self.known.resize(start + PLANES * of_plane, 0);
        } else {
            let base = start.checked_sub(before.checked_mul(PLANES * of_plane)?)?;
            self.known.extend_from_within(base..base + PLANES * of_plane);
        }
        for (plane, coefficients) in self.known[start..].chunks_exact_mut(of_plane).enumerate() {
            let across = usize::from(plane % 3 != 0);
            for block in coefficients.as_chunks_mut::<BLOCK>().0.as_chunks_mut::<BLOCK>().0 {
                let extent = state.take(tables, EXTENT[across])? as usize;
                if extent >= 2 * BLOCK {
                    return None;
                }
                state = add_block(tables, state, (PLACE[across], extent), block)?;
            }
        }
        self.state = state;
        Some(&self.known[start..])
    }

    /// Whether the bytes end with the last receiver.
    pub fn is_done(&self) -> bool {
        self.state.is_done()
    }
}

/// Adds the next coefficients, of contexts from one on and up to an extent, to those of a block; where they end.
#[inline(never)]
fn add_block<'a>(
    tables: &SymbolTables,
    mut state: State<'a>,
    (place, extent): (usize, usize),
    block: &mut [[i32; BLOCK]; BLOCK],
) -> Option<State<'a>> {
    places(extent, |row, column, context| {
        let folded = state.take(tables, place + context)?;
        // Neither can overflow: 2^22 and 2^23.
        block[row][column] += unfold(folded);
        Some(folded)
    })?;
    let large = block.as_flattened().iter().any(|c| c.unsigned_abs() > LARGEST as u32);
    (!large).then_some(state)
}
