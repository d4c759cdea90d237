//! Sorter of byte records. In: records one by one. Out: [`Sorted`], from memory if the records fit
//! the budget, else from sorted runs in a file.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::spill::merge::{Plan, Sorted, Spilled};
use crate::spill::run::{LENGTHS, Run, RunWriter, lengths, parse_lengths};
use heliotile_core::error::Result;

/// Smallest budget, bytes. Smaller ones are raised to it.
const SMALLEST_BUDGET: usize = 64 << 10;

/// Sorter of byte records by key, compared byte by byte from the first. Equal keys keep the order
/// in which they were pushed.
pub struct Sorter {
    folder: PathBuf,
    budget: usize,
    batch: Batch,
    spill: Option<Spill>,
    largest_record: usize,
    unique: bool,
}

/// File for full batches.
struct Spill {
    writer: RunWriter,
    runs: Vec<Run>,
}

impl Sorter {
    /// Creates a sorter. `folder` takes the temporary file if one is needed. `budget_bytes`, at
    /// least 64 KiB, limits the memory held while records are pushed, merged and read, unless
    /// single records come near it.
    pub fn new(folder: &Path, budget_bytes: usize) -> Self {
        let budget = budget_bytes.max(SMALLEST_BUDGET);
        let write_buffer = budget / 16;
        Sorter {
            folder: folder.to_owned(),
            budget,
            batch: Batch::new(budget - write_buffer),
            spill: None,
            largest_record: 0,
            unique: false,
        }
    }

    /// Makes the sorter keep only the first pushed record of equal keys.
    pub fn unique(self) -> Self {
        Sorter { unique: true, ..self }
    }

    /// Adds a record. Its key and its payload must have less than 4 GiB each.
    pub fn push(&mut self, key: &[u8], payload: &[u8]) -> Result<()> {
        let lengths = lengths(key, payload)?;
        let length = LENGTHS + key.len() + payload.len();
        self.largest_record = self.largest_record.max(length);
        if self.batch.add(lengths, key, payload) {
            return Ok(());
        }
        self.spill_batch()?;
        if !self.batch.add(lengths, key, payload) {
            // A record larger than a whole batch becomes a run of its own.
            let spill = self.spill()?;
            spill.writer.append(&[&lengths, key, payload])?;
            spill.runs.push(spill.writer.end_run());
        }
        Ok(())
    }

    /// Sorts the pushed records.
    pub fn finish(mut self) -> Result<Sorted> {
        if self.spill.is_some() {
            self.spill_batch()?;
        }
        let Some(Spill { writer, runs }) = self.spill else {
            self.batch.sort(self.unique);
            return Ok(Sorted::of_memory(self.batch));
        };
        // Merging needs the memory of the batch.
        drop(self.batch);
        Sorted::of_file(Spilled {
            folder: self.folder,
            file: writer.finish()?,
            runs,
            budget: self.budget,
            largest_record: self.largest_record,
            unique: self.unique,
        })
    }

    fn spill_batch(&mut self) -> Result<()> {
        if self.batch.index.is_empty() {
            return Ok(());
        }
        self.batch.sort(self.unique);
        // The batch leaves `self` because the file is borrowed from `self`.
        let mut batch = std::mem::replace(&mut self.batch, Batch::new(0));
        let spill = self.spill()?;
        for entry in &batch.index {
            spill.writer.append(&[batch.record(entry)])?;
        }
        spill.runs.push(spill.writer.end_run());
        batch.clear();
        self.batch = batch;
        Ok(())
    }

    fn spill(&mut self) -> Result<&mut Spill> {
        let spill = match self.spill.take() {
            Some(spill) => spill,
            None => {
                let buffer = (self.budget / 16).min(Plan::new(self.budget, 0).buffer);
                Spill { writer: RunWriter::create(&self.folder, buffer)?, runs: Vec::new() }
            }
        };
        Ok(self.spill.insert(spill))
    }

    /// Returns the bytes held in memory at this moment.
    #[cfg(test)]
    fn buffered(&self) -> usize {
        self.batch.buffered() + self.spill.as_ref().map_or(0, |_| self.budget / 16)
    }
}

/// Records in memory: their bytes as in a run, and the position of each.
pub(super) struct Batch {
    bytes: Vec<u8>,
    index: Vec<Entry>,
    /// Most bytes of records; `places` is the largest number of records.
    room: usize,
    places: usize,
}

/// One record of a batch.
#[derive(Clone, Copy)]
struct Entry {
    /// First eight bytes of the key, padded with zeros, which decide most comparisons.
    prefix: u64,
    start: usize,
}

const ENTRY: usize = size_of::<Entry>();

impl Batch {
    /// Creates a batch of at most `budget` bytes. A quarter is for the index, enough for records of
    /// 48 bytes and more, and 1/16 for the old allocations while records move to the final ones.
    fn new(budget: usize) -> Self {
        let places = budget / 4 / ENTRY;
        Batch { bytes: Vec::new(), index: Vec::new(), room: budget / 16 * 11, places }
    }

    /// Adds a record, or returns false if there is no room.
    fn add(&mut self, lengths: [u8; LENGTHS], key: &[u8], payload: &[u8]) -> bool {
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
    fn sort(&mut self, unique: bool) {
        let mut index = std::mem::take(&mut self.index);
        index.par_sort_unstable_by(|a, b| {
            a.prefix.cmp(&b.prefix).then_with(|| self.parts(a).0.cmp(self.parts(b).0)).then(a.start.cmp(&b.start))
        });
        if unique {
            index.dedup_by(|a, b| self.parts(a).0 == self.parts(b).0);
        }
        self.index = index;
    }

    fn clear(&mut self) {
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

    fn record(&self, entry: &Entry) -> &[u8] {
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    type Records = Vec<(Vec<u8>, Vec<u8>)>;

    struct Random(u64);

    impl Random {
        fn below(&mut self, end: usize) -> usize {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 % end as u64) as usize
        }

        fn bytes(&mut self, shortest: usize, end: usize, values: usize) -> Vec<u8> {
            (0..shortest + self.below(end)).map(|_| self.below(values) as u8).collect()
        }
    }

    fn sort(records: &Records, sorter: Sorter, budget: usize) -> Records {
        let mut sorter = sorter;
        for (key, payload) in records {
            sorter.push(key, payload).expect("pushed");
            assert!(sorter.buffered() <= budget, "{} bytes", sorter.buffered());
        }
        let mut sorted = sorter.finish().expect("sorted");
        let mut all = Vec::new();
        while let Some(record) = sorted.next() {
            assert!(sorted.buffered() <= budget, "{} bytes", sorted.buffered());
            all.push(record.expect("read"));
        }
        sorted.rewind().expect("rewound");
        assert!(sorted.map(|record| record.expect("read")).eq(all.iter().cloned()), "a second reading differs");
        all
    }

    /// 100,000 random records, many with equal keys, sorted with 64 KiB give over 50 runs that are
    /// merged in passes. The result equals the stable sort in memory and, for unique keys, its
    /// first records. Neither 64 KiB nor 1 MiB of budget is ever exceeded.
    #[test]
    fn sorting_by_runs_equals_the_stable_sort() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let records: Records = (0..100_000).map(|_| (random.bytes(0, 13, 3), random.bytes(0, 40, 256))).collect();
        let size: usize = records.iter().map(|(key, payload)| LENGTHS + key.len() + payload.len()).sum();
        assert!(size > 50 << 16);
        let mut expected = records.clone();
        expected.sort_by(|a, b| a.0.cmp(&b.0));
        for budget in [64 << 10, 1 << 20] {
            assert!(sort(&records, Sorter::new(folder.path(), budget), budget) == expected);
        }
        expected.dedup_by(|a, b| a.0 == b.0);
        assert!(expected.len() < 90_000);
        assert!(sort(&records, Sorter::new(folder.path(), 64 << 10).unique(), 64 << 10) == expected);
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }

    /// Records that fit the budget are sorted without a file, in a folder that does not exist.
    /// Beyond the budget the error names the folder.
    #[test]
    fn small_inputs_stay_in_memory() {
        let nowhere = Path::new("/nowhere/at all");
        assert_eq!(sort(&Vec::new(), Sorter::new(nowhere, 0), 64 << 10), []);
        let record = |key: &str| (key.as_bytes().to_vec(), key.as_bytes().to_vec());
        let sorted =
            sort(&vec![record("b"), record(""), record("a\0"), record("a")], Sorter::new(nowhere, 0), 64 << 10);
        assert_eq!(sorted, [record(""), record("a"), record("a\0"), record("b")]);
        let mut sorter = Sorter::new(nowhere, 0);
        let refused = (0..1000).find_map(|_| sorter.push(b"key", &[0; 100]).err()).expect("too much for memory");
        let message = refused.to_string();
        assert!(message.starts_with("cannot create a temporary file in /nowhere/at all: "), "{message}");
    }

    /// Three records of up to four times the budget among 2,000 small ones are sorted correctly.
    #[test]
    fn records_larger_than_the_budget_are_sorted() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let mut random = Random(7);
        let mut records: Records = (0..2_000).map(|_| (random.bytes(4, 1, 256), random.bytes(0, 60, 256))).collect();
        records.insert(1_500, (vec![128; 70_000], vec![1; 9]));
        records.insert(700, (vec![128], vec![1; 4 << 16]));
        records.push((Vec::new(), vec![2; 80_000]));
        let mut expected = records.clone();
        expected.sort_by(|a, b| a.0.cmp(&b.0));
        // Several such records are in memory when runs that hold them are merged.
        assert!(sort(&records, Sorter::new(folder.path(), 64 << 10), 10 << 16) == expected);
    }
}
