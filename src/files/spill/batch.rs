//! Records in memory. In: records one by one, while there is room. Out: the same, sorted.

use rayon::prelude::*;

use crate::spill::run::{LENGTHS, parse_lengths};

/// Records in memory: their bytes as in a run, and the position of each.
pub(super) struct Batch {
    bytes: Vec<u8>,
    pub(super) index: Vec<Entry>,
    /// Most bytes of records; `places` is the largest number of records.
    room: usize,
    places: usize,
}

/// One record of a batch.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// First eight bytes of the key, padded with zeros, which decide most comparisons.
    prefix: u64,
    start: usize,
}

const ENTRY: usize = size_of::<Entry>();

impl Batch {
    /// Creates a batch of at most `budget` bytes. A quarter is for the index, enough for records of
    /// 48 bytes and more, and 1/16 for the old allocations while records move to the final ones.
    pub(super) fn new(budget: usize) -> Self {
        let places = budget / 4 / ENTRY;
        Batch { bytes: Vec::new(), index: Vec::new(), room: budget / 16 * 11, places }
    }

    /// Adds a record, or returns false if there is no room.
    pub(super) fn add(&mut self, lengths: [u8; LENGTHS], key: &[u8], payload: &[u8]) -> bool {
        let length = LENGTHS + key.len() + payload.len();
        if length > self.room - self.bytes.len() || self.index.len() == self.places {
            return false;
        }
        grow(&mut self.bytes, length, self.room);
        grow(&mut self.index, 1, self.places);
        let mut prefix = [0; 8];
        prefix.iter_mut().zip(key).for_each(|(slot, byte)| *slot = *byte);
        self.index.push(Entry { prefix: u64::from_be_bytes(prefix), start: self.bytes.len() });
        for part in [&lengths, key, payload] {
            self.bytes.extend_from_slice(part);
        }
        true
    }

    /// Sorts the index. Entries that `unique` removes leave their bytes unused.
    pub(super) fn sort(&mut self, unique: bool) {
        let mut index = std::mem::take(&mut self.index);
        // The start decides between equal keys, so that they keep the order of pushes.
        index.par_sort_unstable_by(|a, b| {
            a.prefix.cmp(&b.prefix).then_with(|| self.parts(a).0.cmp(self.parts(b).0)).then(a.start.cmp(&b.start))
        });
        if unique {
            index.dedup_by(|a, b| self.parts(a).0 == self.parts(b).0);
        }
        self.index = index;
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.index.clear();
    }

    /// Returns the n-th record of the index.
    pub(super) fn get(&self, n: usize) -> Option<(&[u8], &[u8])> {
        self.index.get(n).map(|entry| self.parts(entry))
    }

    fn split(&self, entry: &Entry) -> (&[u8], usize, usize) {
        let rest = self.bytes.get(entry.start..).unwrap_or_default();
        let (key, payload) = rest.first_chunk().map_or((0, 0), |head| parse_lengths(*head));
        (rest, LENGTHS + key, LENGTHS + key + payload)
    }

    fn parts(&self, entry: &Entry) -> (&[u8], &[u8]) {
        let (rest, key_end, end) = self.split(entry);
        (rest.get(LENGTHS..key_end).unwrap_or_default(), rest.get(key_end..end).unwrap_or_default())
    }

    pub(super) fn record(&self, entry: &Entry) -> &[u8] {
        let (rest, _, end) = self.split(entry);
        rest.get(..end).unwrap_or_default()
    }

    #[cfg(test)]
    pub(super) fn buffered(&self) -> usize {
        self.bytes.capacity() + self.index.capacity() * ENTRY
    }
}

/// Reserves room for `more` items out of at most `most`: first a sixteenth of `most`, so that small
/// inputs cost little, then all of it at once. Doubling would hold up to three times as much as
/// needed while it copies.
fn grow<T>(list: &mut Vec<T>, more: usize, most: usize) {
    if list.capacity() - list.len() < more {
        let first = most / 16;
        let wanted = if list.len() + more <= first { first } else { most };
        list.reserve_exact(wanted - list.len());
    }
}
