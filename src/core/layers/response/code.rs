//! A tile's coefficients as bytes. In: whole numbers of each receiver. Out: bytes, and back. Each
//! receiver is told as what it adds to one before it, or to nothing, and each coefficient in a
//! context: how large those of lower frequencies above it are.

use crate::layers::rans::{self, Encoder, Reader, SymbolTables};
use crate::layers::response::transform::{BLOCK, LARGEST, PLANES, is_across};

/// Receivers that one may be told by are at most so many before it.
const FARTHEST: usize = 63;

/// Values around one, weighed, from which on it is in the next context.
const THRESHOLDS: [u8; 8] = [1, 3, 7, 13, 23, 39, 63, 103];

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

/// The rows of folded values above one: values of 8 bits, at most [`LARGE`], column 0 the lowest.
#[derive(Default)]
struct Above {
    row: u64,
    twice: u64,
}

impl Above {
    /// Contexts of a row's places in a block of some extent. They follow from the rows above alone,
    /// so that no value of a row waits for another.
    #[inline(always)]
    fn contexts(&self, row: usize, extent: usize) -> [u8; BLOCK] {
        // No sum exceeds 7 x 31.
        let around = if row > 0 {
            (3 * self.row + 2 * (self.row << 8) + (self.row >> 8) + self.twice).to_le_bytes()
        } else {
            // Nothing is above: the nearer to the extent, the smaller.
            std::array::from_fn(|column| 6 * extent.saturating_sub(1 + column) as u8)
        };
        let mut contexts = [1; BLOCK];
        for threshold in THRESHOLDS {
            for column in 0..BLOCK {
                contexts[column] += u8::from(around[column] >= threshold);
            }
        }
        if row == 0 {
            // The mean value.
            contexts[0] = 0;
        }
        contexts
    }

    /// Goes on behind a row of such values.
    #[inline(always)]
    fn push(&mut self, row: u64) {
        *self = Above { row, twice: self.row };
    }
}

/// A folded value of a row among its others.
#[inline(always)]
fn in_row(column: usize, folded: u32) -> u64 {
    u64::from(folded.min(LARGE)) << (8 * column)
}

/// Bytes of the coefficients of a tile's receivers, each `[plane][block][row][column]`.
pub fn encode(receivers: &[Vec<i32>]) -> Vec<u8> {
    let mut encoder = Encoder::new(CONTEXTS);
    let small: Vec<Vec<i16>> =
        receivers.iter().map(|of| of.iter().map(|c| (*c).clamp(-255, 255) as i16).collect()).collect();
    let nothing: Vec<i32> = vec![0; receivers.first().map_or(0, Vec::len)];
    for (i, coefficients) in receivers.iter().enumerate() {
        let before = best_before(&small, i);
        encoder.put(REFERENCE, 0, before as u32);
        let base = if before == 0 { &nothing } else { &receivers[i - before] };
        let rest: Vec<i32> = coefficients.iter().zip(base).map(|(c, base)| c - base).collect();
        let blocks = rest.as_chunks::<BLOCK>().0.as_chunks::<BLOCK>().0;
        let of_plane = (blocks.len() / PLANES).max(1);
        for (number, block) in blocks.iter().enumerate() {
            let across = usize::from(is_across(number / of_plane));
            let extent = extent_of(block);
            encoder.put(EXTENT[across], 0, extent as u32);
            let mut above = Above::default();
            for (row, line) in block.iter().enumerate().take(extent) {
                let (contexts, mut values) = (above.contexts(row, extent), 0);
                for column in 0..(extent - row).min(BLOCK) {
                    let folded = fold(line[column]);
                    encoder.put(PLACE[across] + usize::from(contexts[column]), column, folded);
                    values |= in_row(column, folded);
                }
                above.push(values);
            }
        }
    }
    encoder.finish()
}

/// 0, 1, -1, 2, ... as 0, 1, 2, 3, ...
fn fold(value: i32) -> u32 {
    if value > 0 { 2 * value as u32 - 1 } else { 2 * value.unsigned_abs() }
}

/// Inverse of [`fold`] below 2^31.
#[inline(always)]
fn unfold(folded: u32) -> i32 {
    let half = (folded / 2) as i32;
    if folded % 2 == 1 { half + 1 } else { -half }
}

/// How far before receiver i stands the one that it is told by; 0 for none. The nearest of the
/// best.
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
    reader: Reader<'a>,
    /// Blocks of a plane.
    blocks: usize,
    /// `[receiver modulo those that are kept][plane][block][row][column]`.
    known: Vec<i32>,
    /// Receivers that were read.
    count: usize,
}

impl<'a> TileDecoder<'a> {
    /// Of so many receivers with so many blocks a plane; `None` if the bytes do not start as they
    /// must.
    pub fn new(bytes: &'a [u8], receivers: usize, blocks: usize) -> Option<Self> {
        let (tables, reader) = rans::open(CONTEXTS, bytes)?;
        let known = vec![0; receivers.min(FARTHEST + 1) * PLANES * blocks * BLOCK * BLOCK];
        Some(TileDecoder { tables, reader, blocks, known, count: 0 })
    }

    /// The next receiver's coefficients, of at most as many as were said; `None` if there are none,
    /// or wrong ones.
    #[inline(always)]
    pub fn receiver(&mut self) -> Option<&[i32]> {
        let before = self.reader.take(&self.tables, REFERENCE, 0) as usize;
        let of_plane = self.blocks * BLOCK * BLOCK;
        let at = |receiver: usize| {
            let start = receiver % (FARTHEST + 1) * PLANES * of_plane;
            start..start + PLANES * of_plane
        };
        if before > self.count.min(FARTHEST) {
            return None;
        }
        let own = at(self.count);
        if before == 0 {
            self.known[own.clone()].fill(0);
        } else {
            self.known.copy_within(at(self.count - before), own.start);
        }
        let coefficients = &mut self.known[own];
        for (plane, coefficients) in coefficients.chunks_exact_mut(of_plane).enumerate() {
            let across = usize::from(is_across(plane));
            for block in coefficients.as_chunks_mut::<BLOCK>().0.as_chunks_mut::<BLOCK>().0 {
                let extent = self.reader.take(&self.tables, EXTENT[across], 0) as usize;
                if extent >= 2 * BLOCK {
                    return None;
                }
                if extent > 0 {
                    add_block(&self.tables, &mut self.reader, PLACE[across], extent, block)?;
                }
            }
        }
        self.count += 1;
        (!self.reader.is_beyond()).then_some(coefficients)
    }

    /// Whether the bytes end with the last receiver.
    pub fn is_done(&self) -> bool {
        self.reader.is_done()
    }
}

/// Adds the next coefficients, of contexts from one on and up to an extent, to those of a block;
/// `None` if one gets too large.
#[inline(always)]
fn add_block(
    tables: &SymbolTables,
    reader: &mut Reader,
    place: usize,
    extent: usize,
    block: &mut [[i32; BLOCK]; BLOCK],
) -> Option<()> {
    let mut above = Above::default();
    for (row, line) in block.iter_mut().enumerate().take(extent) {
        let (contexts, mut values) = (above.contexts(row, extent), 0);
        for column in 0..(extent - row).min(BLOCK) {
            let folded = reader.take(tables, place + usize::from(contexts[column]), column);
            // Neither can overflow: 2^22 and 2^23.
            line[column] += unfold(folded);
            values |= in_row(column, folded);
        }
        above.push(values);
    }
    let large = block.as_flattened().iter().any(|c| c.unsigned_abs() > LARGEST as u32);
    (!large).then_some(())
}
