//! Merging of sorted runs. In: sorted runs, in memory or in a temporary file. Out: their records as
//! one sorted sequence.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

use crate::spill::batch::Batch;
use crate::spill::run::{Record, Run, RunReader, RunWriter};
use heliotile_core::error::Result;

/// Buffer size from which on a read is worth a seek, bytes. Used if the budget allows it.
const BUFFER: usize = 64 << 10;
/// Largest buffer, bytes: larger ones read no faster.
const LARGEST_BUFFER: usize = 256 << 10;
/// Smallest buffer, bytes: slow, but it works.
const SMALLEST_BUFFER: usize = 4 << 10;

/// Number of runs that are merged at once, and the size of their buffers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    fan_in: usize,
    pub(super) buffer: usize,
}

impl Plan {
    /// Returns the plan for `budget` bytes and records of at most `largest_record` bytes. Each run
    /// that is read takes a buffer and its front record, and so does the run that is written. The
    /// plan stays within the budget unless the budget cannot hold three records with small buffers.
    pub(super) fn new(budget: usize, largest_record: usize) -> Plan {
        let fan_in = (budget / BUFFER.saturating_add(largest_record)).saturating_sub(1).max(2);
        Plan { fan_in, buffer: Plan::buffer(budget, fan_in, largest_record) }
    }

    /// Returns the buffer size of a pass over `runs`: larger for fewer runs.
    fn buffer(budget: usize, runs: usize, largest_record: usize) -> usize {
        (budget / (runs + 1)).saturating_sub(largest_record).clamp(SMALLEST_BUFFER, LARGEST_BUFFER)
    }
}

/// Runs in a temporary file, in the order in which their records were pushed.
pub(super) struct Spilled {
    pub(super) folder: PathBuf,
    pub(super) file: Arc<File>,
    pub(super) runs: Vec<Run>,
    pub(super) budget: usize,
    pub(super) largest_record: usize,
    pub(super) unique: bool,
}

impl Spilled {
    /// Merges neighbouring runs until one merge can read all of them. Neighbours only, so that
    /// equal keys keep the order of pushes.
    pub(super) fn reduce(mut self) -> Result<Spilled> {
        let plan = Plan::new(self.budget, self.largest_record);
        while self.runs.len() > plan.fan_in {
            let mut writer = RunWriter::create(&self.folder, plan.buffer)?;
            let mut runs = Vec::new();
            for group in self.runs.chunks(plan.fan_in) {
                let mut merge = self.merge(group, plan.buffer)?;
                while let Some((key, payload)) = merge.next()? {
                    writer.append_record(&key, &payload)?;
                }
                runs.push(writer.end_run());
            }
            self = Spilled { file: writer.finish()?, runs, ..self };
        }
        Ok(self)
    }

    fn merge(&self, runs: &[Run], buffer: usize) -> Result<Merge> {
        let readers =
            runs.iter().map(|run| RunReader::new(&self.file, *run, buffer, &self.folder)).collect::<Vec<RunReader>>();
        Merge::new(readers, self.unique)
    }

    fn last_merge(&self) -> Result<Merge> {
        self.merge(&self.runs, Plan::buffer(self.budget, self.runs.len(), self.largest_record))
    }
}

/// Front record of a run.
struct Head {
    record: Record,
    run: usize,
}

impl Ord for Head {
    /// Compares in reverse: the heap returns its greatest item, which must be the least key of the
    /// earliest run.
    fn cmp(&self, other: &Self) -> Ordering {
        (&other.record.0, other.run).cmp(&(&self.record.0, self.run))
    }
}

impl PartialOrd for Head {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Head {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Head {}

/// Merge of several runs into one sequence.
struct Merge {
    readers: Vec<RunReader>,
    heads: BinaryHeap<Head>,
    unique: bool,
}

impl Merge {
    fn new(mut readers: Vec<RunReader>, unique: bool) -> Result<Self> {
        let mut heads = BinaryHeap::with_capacity(readers.len());
        for (run, reader) in readers.iter_mut().enumerate() {
            heads.extend(reader.next()?.map(|record| Head { record, run }));
        }
        Ok(Merge { readers, heads, unique })
    }

    fn next(&mut self) -> Result<Option<Record>> {
        let Some(record) = self.pop()? else { return Ok(None) };
        while self.unique && self.heads.peek().is_some_and(|head| head.record.0 == record.0) {
            self.pop()?;
        }
        Ok(Some(record))
    }

    fn pop(&mut self) -> Result<Option<Record>> {
        let Some(head) = self.heads.pop() else { return Ok(None) };
        if let Some(reader) = self.readers.get_mut(head.run) {
            self.heads.extend(reader.next()?.map(|record| Head { record, run: head.run }));
        }
        Ok(Some(head.record))
    }
}

/// All records of a sorter by key. Records of equal keys keep the order in which they were pushed.
///
/// After an error the records that follow cannot be trusted.
pub struct Sorted(SortedStorage);

enum SortedStorage {
    Memory { batch: Batch, next: usize },
    File { spilled: Spilled, merge: Merge },
}

impl Sorted {
    pub(super) fn of_memory(batch: Batch) -> Self {
        Sorted(SortedStorage::Memory { batch, next: 0 })
    }

    pub(super) fn of_file(spilled: Spilled) -> Result<Self> {
        let spilled = spilled.reduce()?;
        Ok(Sorted(SortedStorage::File { merge: spilled.last_merge()?, spilled }))
    }

    /// Starts again with the first record.
    pub fn rewind(&mut self) -> Result<()> {
        match &mut self.0 {
            SortedStorage::Memory { next, .. } => *next = 0,
            SortedStorage::File { spilled, merge } => {
                // Drop the old buffers before the new ones are allocated, to stay within the
                // budget.
                merge.readers.clear();
                *merge = spilled.last_merge()?;
            }
        }
        Ok(())
    }

    /// Returns the bytes held in memory at this moment.
    #[cfg(test)]
    pub(super) fn buffered(&self) -> usize {
        match &self.0 {
            SortedStorage::Memory { batch, .. } => batch.buffered(),
            SortedStorage::File { merge, .. } => {
                let heads = merge.heads.iter().map(|head| head.record.0.capacity() + head.record.1.capacity());
                merge.readers.iter().map(RunReader::buffered).sum::<usize>() + heads.sum::<usize>()
            }
        }
    }
}

impl Iterator for Sorted {
    type Item = Result<Record>;

    fn next(&mut self) -> Option<Result<Record>> {
        match &mut self.0 {
            SortedStorage::Memory { batch, next } => {
                let (key, payload) = batch.get(*next)?;
                *next += 1;
                Some(Ok((key.to_vec(), payload.to_vec())))
            }
            SortedStorage::File { merge, .. } => merge.next().transpose(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For 30 budgets from 64 KiB to 32 GiB and records of up to a fifth of them, the buffers and
    /// records of every pass fit the budget.
    #[test]
    fn every_pass_fits_the_budget() {
        for budget in (0..20).map(|i| 65536_usize << i).chain((0..10).map(|i| 100_000 * (i + 1))) {
            for largest in [9, 100, 5_000, budget / 5] {
                let plan = Plan::new(budget, largest);
                let held = (plan.fan_in + 1) * (plan.buffer + largest);
                assert!(held <= budget, "{budget}, records of {largest}: {plan:?} holds {held}");
                for runs in 1..=plan.fan_in.min(300) {
                    let buffer = Plan::buffer(budget, runs, largest);
                    assert!((runs + 1) * (buffer + largest) <= budget, "{budget}, {largest}, {runs} runs");
                }
            }
        }
        assert_eq!(Plan::new(64 << 20, 100).fan_in, 1021);
    }
}
