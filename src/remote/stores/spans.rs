//! Choice of ranges to request. In: blocks that will be read. Out: spans. Neighbouring blocks share
//! a span; no span is too long or holds too many unwanted bytes.

use std::ops::Range;

use heliotile_core::archive::format::{ALIGNMENT, Entry};

/// Widest gap between two blocks of a span, bytes.
const GAP: u64 = 64 << 10;
/// Unwanted bytes that a span may hold in any case; beyond that it may hold as many as it has
/// wanted bytes.
const SPARE: u64 = 16 << 10;
/// Longest span, bytes, unless one block is longer: several spans are under way at a time.
const LONGEST: u64 = 2 << 20;

/// A range with the blocks in it.
#[derive(Clone, Debug, PartialEq)]
pub struct ByteSpan {
    /// Bytes from the first block to the end of the last one's padding.
    pub range: Range<u64>,
    /// Blocks, by offset.
    pub blocks: Vec<Entry>,
}

/// Joins blocks of a file of `length` bytes to spans.
pub fn spans(mut blocks: Vec<Entry>, length: u64) -> Vec<ByteSpan> {
    blocks.sort_unstable_by_key(|block| (block.offset, block.stored));
    blocks.dedup_by_key(|block| block.offset);
    let mut spans: Vec<ByteSpan> = Vec::new();
    let mut wanted = 0;
    for block in blocks {
        let end = block.offset.saturating_add(block.stored.into()).next_multiple_of(ALIGNMENT).min(length);
        if let Some(span) = spans.last_mut() {
            let gap = block.offset.saturating_sub(span.range.end);
            let for_nothing = (span.range.end - span.range.start).saturating_sub(wanted);
            let near = gap <= GAP && for_nothing + gap <= wanted + SPARE;
            if near && end.saturating_sub(span.range.start) <= LONGEST {
                span.range.end = span.range.end.max(end);
                span.blocks.push(block);
                wanted += u64::from(block.stored);
                continue;
            }
        }
        wanted = block.stored.into();
        spans.push(ByteSpan { range: block.offset..end, blocks: vec![block] });
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(offset: u64, stored: u32) -> Entry {
        let zero = Entry::decode(&[0; 80]).expect("an entry");
        Entry { offset, stored, ..zero }
    }

    fn ranges(blocks: &[(u64, u32)]) -> Vec<(u64, u64)> {
        let blocks = blocks.iter().map(|&(at, long)| block(at, long)).collect();
        spans(blocks, 1 << 40).into_iter().map(|span| (span.range.start, span.range.end)).collect()
    }

    /// Neighbours come together with their padding in any order, and equal blocks once. Three small
    /// blocks 50 kB apart stay 3 requests, three large ones are 1. No span is longer than 2 MiB
    /// unless a block is. The last one ends with the file.
    #[test]
    fn near_blocks_join_into_spans_up_to_2_mib() {
        assert_eq!(ranges(&[(8256, 100), (8192, 60), (8256, 100)]), [(8192, 8384)]);
        assert_eq!(ranges(&[(0, 4000), (51_200, 4000), (102_400, 4000)]).len(), 3);
        assert_eq!(ranges(&[(0, 64_000), (102_400, 64_000), (204_800, 64_000)]), [(0, 268_800)]);
        let many: Vec<_> = (0..100).map(|i| (i * 65_536, 65_536)).collect();
        let found = ranges(&many);
        assert_eq!((found.len(), found.iter().map(|(start, end)| end - start).max()), (4, Some(2 << 20)));
        assert_eq!(ranges(&[(0, 5 << 20)]), [(0, 5 << 20)]);
        assert_eq!(spans(vec![block(64, 10)], 80)[0].range, 64..80);
    }
}
