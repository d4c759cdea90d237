//! Sorter of byte records. In: records one by one. Out: [`Sorted`], from memory if the records fit
//! the budget, else from sorted runs in a file.

use std::path::{Path, PathBuf};

use crate::spill::batch::Batch;
use crate::spill::merge::{Plan, Sorted, Spilled};
use crate::spill::run::{LENGTHS, Run, RunWriter, lengths};
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
