//! Cells that can be reached from some keys. In: keys. Out: a mark for each cell, one byte.

use std::collections::VecDeque;
use std::path::Path;

use heliotile_core::error::Result;
use heliotile_core::layers::cells::Cells;
use heliotile_core::opened::CellSource;
use heliotile_core::site::cells::CellKey;
use heliotile_files::spill::{Sorted, Sorter};

/// Keys of cells, each once, sorted in temporary files.
pub struct Keys(Sorter);

impl Keys {
    pub fn new(folder: &Path, budget_bytes: usize) -> Self {
        Keys(Sorter::new(folder, budget_bytes).unique())
    }

    pub fn push(&mut self, key: CellKey) -> Result<()> {
        self.0.push(&key.to_bytes(), &[])
    }

    /// Returns all keys, ascending.
    fn finish(self) -> Result<impl Iterator<Item = Result<CellKey>> + use<>> {
        let key = |record: Result<(Vec<u8>, Vec<u8>)>| {
            let mut bytes = [0; CellKey::BYTES];
            bytes.copy_from_slice(&record?.0);
            Ok(CellKey::from_bytes(&bytes))
        };
        let sorted: Sorted = self.0.finish()?;
        Ok(sorted.map(key))
    }
}

/// Number of keys that are read ahead, to prefetch their chunks.
const AHEAD: usize = 1 << 16;

/// Marks of the cells of one kind that are kept.
#[derive(Default)]
pub struct Marks(Vec<Vec<bool>>);

impl Marks {
    /// Returns the numbers of the chunks with a marked cell.
    pub fn chunks(&self) -> Vec<usize> {
        let kept = self.0.iter().enumerate().filter(|(_, rows)| rows.contains(&true));
        kept.map(|(chunk, _)| chunk).collect()
    }

    pub fn contains(&self, chunk: usize, row: usize) -> bool {
        self.0.get(chunk).and_then(|rows| rows.get(row)).copied().unwrap_or(false)
    }

    /// Marks the cells of some keys. `see` gets the keys that newly marked cells see. A key without
    /// a cell means that the layer the keys come from is damaged.
    pub fn add(
        &mut self,
        source: &CellSource,
        from: &str,
        keys: Keys,
        mut see: impl FnMut(CellKey) -> Result<()>,
    ) -> Result<()> {
        self.0.resize(source.chunks(), Vec::new());
        let mut open: Option<(usize, Cells)> = None;
        let mut keys = keys.finish()?;
        let mut ahead = VecDeque::new();
        loop {
            if ahead.is_empty() {
                ahead = keys.by_ref().take(AHEAD).collect::<Result<_>>()?;
                let mut chunks: Vec<usize> = ahead.iter().filter_map(|key| source.chunk_of(key)).collect();
                // Keys ascend, so keys of one chunk are neighbours.
                chunks.dedup();
                source.expect(chunks);
            }
            let Some(key) = ahead.pop_front() else { break };
            let number = source.chunk_of(&key).ok_or_else(|| source.missing(&key, from))?;
            let chunk = match open.take().filter(|(same, _)| *same == number) {
                Some((_, chunk)) => chunk,
                None => source.chunk(number)?,
            };
            let row = chunk.keys.binary_search(&key).map_err(|_| source.missing(&key, from))?;
            if let Some(marks) = self.0.get_mut(number) {
                marks.resize(chunk.keys.len(), false);
                if !std::mem::replace(&mut marks[row], true) {
                    chunk.cell(row).reached().try_for_each(&mut see)?;
                }
            }
            open = Some((number, chunk));
        }
        Ok(())
    }

    /// Marks the cells of some keys and all cells that can be reached from them.
    pub fn add_reachable(
        &mut self,
        source: &CellSource,
        mut from: &'static str,
        mut keys: Keys,
        new: impl Fn() -> Keys,
    ) -> Result<()> {
        loop {
            let (mut next, mut any) = (new(), false);
            self.add(source, from, keys, |key| {
                any = true;
                next.push(key)
            })?;
            if !any {
                return Ok(());
            }
            (from, keys) = ("bounce", next);
        }
    }
}
