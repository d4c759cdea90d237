//! Blocks that were announced, are under way or have arrived. In: blocks that will be read, spans
//! that arrived. Out: which spans to request next, and blocks. Plain bookkeeping: nothing here
//! waits or sends requests.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use heliotile_core::archive::format::{ALIGNMENT, Entry};

use crate::stores::failure::Failure;
use crate::stores::spans::{ByteSpan, spans};

/// Most requests under way for announced blocks. A block that is read now does not wait for them.
const UNDER_WAY: usize = 16;
/// Bytes that are under way or have arrived and are unread, above which nothing more is requested
/// ahead.
const ROOM: u64 = 64 << 20;
/// Most bytes of blocks in memory.
const KEPT: u64 = 128 << 20;
/// Least share of [`ROOM`] and of [`KEPT`] that each file may take, bytes, however many files are
/// open.
const MIN: u64 = 4 << 20;
/// Number of later announcements after which a block that was not read no longer counts as unread.
const FORGOTTEN: u64 = 8;

/// State of an announced block.
#[derive(Debug)]
enum State {
    Queued,
    OnItsWay,
    Here { bytes: Bytes, read: bool, used: u64, told: u64 },
    Failed(Failure),
}

/// Answer to a look-up of a block.
#[derive(Debug)]
pub enum Lookup {
    /// Bytes of the block.
    Bytes(Bytes),
    /// Reason why the block did not arrive. The next look-up requests it again.
    Failed(Failure),
    /// The block is under way.
    OnItsWay,
    /// The block arrives if the caller fetches this span, which is taken out of the queue.
    Fetch(ByteSpan),
    /// The block was not announced.
    Unknown,
}

/// Number of files that are open at the same time. They share the memory for blocks.
#[derive(Debug, Default)]
pub struct OpenFiles(AtomicU64);

impl OpenFiles {
    /// Returns a count of zero files.
    pub const fn none() -> Self {
        OpenFiles(AtomicU64::new(0))
    }

    /// Returns the share of `bytes` that each open file may take.
    fn share(&self, bytes: u64) -> u64 {
        (bytes / self.0.load(Ordering::Relaxed).max(1)).max(MIN)
    }
}

/// All announced blocks of a file.
#[derive(Debug)]
pub struct Ahead {
    open: &'static OpenFiles,
    /// Blocks by offset.
    blocks: HashMap<u64, State>,
    queue: VecDeque<ByteSpan>,
    under_way: usize,
    /// Bytes under way, or in memory and unread.
    unread: u64,
    /// Bytes in memory.
    here: u64,
    /// Padding between blocks that arrived with them, by offset.
    between: BTreeMap<u64, Bytes>,
    clock: u64,
    told: u64,
}

impl Drop for Ahead {
    fn drop(&mut self) {
        self.open.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Ahead {
    /// Starts the bookkeeping of one more open file.
    pub fn among(open: &'static OpenFiles) -> Self {
        open.0.fetch_add(1, Ordering::Relaxed);
        Ahead {
            open,
            blocks: HashMap::new(),
            queue: VecDeque::new(),
            under_way: 0,
            unread: 0,
            here: 0,
            between: BTreeMap::new(),
            clock: 0,
            told: 0,
        }
    }

    /// Announces blocks of a file of `length` bytes that will be read; blocks that are known
    /// already are skipped.
    pub fn tell(&mut self, blocks: impl Iterator<Item = Entry>, length: u64) {
        self.told += 1;
        let new: Vec<Entry> = blocks.filter(|block| !self.blocks.contains_key(&block.offset)).collect();
        for span in spans(new, length) {
            self.blocks.extend(span.blocks.iter().map(|block| (block.offset, State::Queued)));
            self.queue.push_back(span);
        }
        if self.unread > self.open.share(ROOM) / 2 {
            self.forget();
        }
    }

    /// Marks blocks as read that were announced long ago and not read since, so that their memory
    /// can be freed.
    fn forget(&mut self) {
        let before = self.told.saturating_sub(FORGOTTEN);
        for state in self.blocks.values_mut() {
            if let State::Here { bytes, read: read @ false, told, .. } = state
                && *told < before
            {
                *read = true;
                self.unread = self.unread.saturating_sub(bytes.len() as u64);
            }
        }
    }

    /// Takes the next span to request from the queue, if the limits allow a request.
    pub fn next(&mut self) -> Option<ByteSpan> {
        if self.under_way >= UNDER_WAY || self.unread >= self.open.share(ROOM) {
            return None;
        }
        let span = self.queue.pop_front()?;
        self.begin(&span);
        Some(span)
    }

    /// Marks a span as under way that is requested at once.
    pub fn begin(&mut self, span: &ByteSpan) {
        self.under_way += 1;
        self.unread += size_of(span);
        self.blocks.extend(span.blocks.iter().map(|block| (block.offset, State::OnItsWay)));
    }

    /// Looks up a block that is read now.
    pub fn find(&mut self, offset: u64) -> Lookup {
        self.clock += 1;
        match self.blocks.get_mut(&offset) {
            None => Lookup::Unknown,
            Some(State::OnItsWay) => Lookup::OnItsWay,
            Some(State::Here { bytes, read, used, .. }) => {
                *used = self.clock;
                if !std::mem::replace(read, true) {
                    self.unread = self.unread.saturating_sub(bytes.len() as u64);
                }
                Lookup::Bytes(bytes.clone())
            }
            // The failure is forgotten, so that the next look-up requests the block again.
            Some(State::Failed(failure)) => {
                let failure = failure.clone();
                self.blocks.remove(&offset);
                Lookup::Failed(failure)
            }
            Some(State::Queued) => {
                let holds = |span: &ByteSpan| span.blocks.iter().any(|block| block.offset == offset);
                match self.queue.iter().position(holds).and_then(|place| self.queue.remove(place)) {
                    Some(span) => Lookup::Fetch(span),
                    None => Lookup::Unknown,
                }
            }
        }
    }

    /// Stores the blocks of a span that has arrived.
    pub fn came(&mut self, span: &ByteSpan, bytes: &Bytes) {
        self.under_way = self.under_way.saturating_sub(1);
        self.unread = self.unread.saturating_sub(size_of(span));
        self.clock += 1;
        let (start, mut at) = (span.range.start, span.range.start);
        let part = |from: u64, to: u64| {
            let place =
                |offset: u64| usize::try_from(offset.saturating_sub(start)).unwrap_or(usize::MAX).min(bytes.len());
            // The bytes are copied: a slice would keep the whole span in memory.
            Bytes::copy_from_slice(bytes.get(place(from)..place(to)).unwrap_or_default())
        };
        for block in &span.blocks {
            let end = block.offset.saturating_add(block.stored.into());
            self.keep_between(at, block.offset, part);
            at = at.max(end);
            let bytes = part(block.offset, end);
            (self.unread, self.here) = (self.unread + bytes.len() as u64, self.here + bytes.len() as u64);
            let state = State::Here { bytes, read: false, used: self.clock, told: self.told };
            self.blocks.insert(block.offset, state);
        }
        self.keep_between(at, span.range.end, part);
        if self.here > self.open.share(KEPT) {
            self.drop_read();
        }
    }

    fn keep_between(&mut self, from: u64, to: u64, part: impl Fn(u64, u64) -> Bytes) {
        if from < to && to - from < ALIGNMENT {
            self.between.insert(from, part(from, to));
        }
    }

    /// Marks the blocks of a span as failed.
    pub fn failed(&mut self, span: &ByteSpan, failure: &Failure) {
        self.under_way = self.under_way.saturating_sub(1);
        self.unread = self.unread.saturating_sub(size_of(span));
        self.blocks.extend(span.blocks.iter().map(|block| (block.offset, State::Failed(failure.clone()))));
    }

    /// Returns `length` bytes of padding at `offset`, if they arrived with a block.
    pub fn between(&self, offset: u64, length: usize) -> Option<Bytes> {
        let (start, bytes) = self.between.range(..=offset).next_back()?;
        let at = usize::try_from(offset - start).ok()?;
        let end = at.checked_add(length).filter(|&end| end <= bytes.len())?;
        Some(bytes.slice(at..end))
    }

    /// Frees the memory of blocks that were read, the least recently used first.
    fn drop_read(&mut self) {
        let mut read: Vec<(u64, u64, u64)> = Vec::new();
        for (offset, state) in &self.blocks {
            if let State::Here { bytes, read: true, used, .. } = state {
                read.push((*used, *offset, bytes.len() as u64));
            }
        }
        read.sort_unstable();
        let kept = self.open.share(KEPT) / 4 * 3;
        for (_, offset, length) in read {
            if self.here <= kept {
                break;
            }
            self.blocks.remove(&offset);
            self.here -= length;
        }
    }
}

fn size_of(span: &ByteSpan) -> u64 {
    span.range.end.saturating_sub(span.range.start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stores::failure::Cause;

    fn block(offset: u64, stored: u32) -> Entry {
        Entry { offset, stored, ..Entry::decode(&[0; 80]).expect("an entry") }
    }

    fn alone() -> Ahead {
        Ahead::among(Box::leak(Box::default()))
    }

    /// With 10 open files, each keeps 8 to 14 MiB of blocks that were read (its share is 12.8)
    /// instead of 128; when 9 are closed, the tenth keeps 100 MiB or more again.
    #[test]
    fn ten_open_files_share_the_memory() {
        let open: &'static OpenFiles = Box::leak(Box::default());
        let mut files: Vec<Ahead> = (0..10).map(|_| Ahead::among(open)).collect();
        let mut last = files.pop().expect("a file");
        let read = |file: &mut Ahead, from: u64| {
            file.tell((from..from + 100).map(|i| block(i << 20, 1 << 20)), 1 << 40);
            while let Some(span) = file.next() {
                file.came(&span, &vec![0; (span.range.end - span.range.start) as usize].into());
                span.blocks.iter().for_each(|block| drop(file.find(block.offset)));
            }
            file.here >> 20
        };
        assert!((8..=14).contains(&read(&mut last, 0)), "{}", last.here);
        drop(files);
        assert!(read(&mut last, 100) >= 100, "{}", last.here);
    }

    /// For 100 blocks of 1 MiB, 16 spans of 2 MiB are under way at first. As they arrive and are
    /// read, all 100 blocks arrive, each once and with its own bytes. Announced again, they are not
    /// requested again while they are in memory.
    #[test]
    fn each_announced_block_is_requested_once() {
        let blocks: Vec<Entry> = (0..100).map(|i| block(i << 20, 1 << 20)).collect();
        let mut ahead = alone();
        ahead.tell(blocks.iter().copied(), 100 << 20);
        let mut under_way: VecDeque<ByteSpan> = std::iter::from_fn(|| ahead.next()).collect();
        assert_eq!(under_way.len(), 16);
        let (mut asked, mut read) = (under_way.len(), 0);
        while let Some(span) = under_way.pop_front() {
            let bytes: Vec<u8> =
                (span.range.start >> 20..span.range.end >> 20).flat_map(|i| vec![i as u8; 1 << 20]).collect();
            ahead.came(&span, &bytes.into());
            for block in &span.blocks {
                let Lookup::Bytes(bytes) = ahead.find(block.offset) else { panic!("it came") };
                assert!(bytes.len() == 1 << 20 && bytes.iter().all(|byte| u64::from(*byte) == block.offset >> 20));
                read += 1;
            }
            let more: Vec<ByteSpan> = std::iter::from_fn(|| ahead.next()).collect();
            asked += more.len();
            under_way.extend(more);
        }
        assert_eq!((asked, read, ahead.unread, ahead.under_way), (50, 100, 0, 0));
        ahead.tell(blocks.iter().copied(), 100 << 20);
        assert!(ahead.next().is_none() && ahead.here == 100 << 20);
    }

    /// At most 64 MiB that are unread are requested ahead (32 spans of 2 MiB), but a block that is
    /// read now is requested; memory stays below 128 MiB and one span.
    #[test]
    fn at_most_64_mib_are_requested_ahead() {
        let mut ahead = alone();
        ahead.tell((0..400).map(|i| block(i << 20, 1 << 20)), 400 << 20);
        let mut spans = 0;
        while let Some(span) = ahead.next() {
            ahead.came(&span, &vec![0; (span.range.end - span.range.start) as usize].into());
            spans += 1;
        }
        assert_eq!(spans, 32);
        let Lookup::Fetch(span) = ahead.find(300 << 20) else { panic!("it is queued") };
        ahead.begin(&span);
        assert!(matches!(ahead.find(301 << 20), Lookup::OnItsWay));
        ahead.failed(&span, &Failure::new(Cause::Passing, "x"));
        assert!(matches!(ahead.find(300 << 20), Lookup::Failed(_)) && matches!(ahead.find(300 << 20), Lookup::Unknown));
        for i in 0..400 {
            if let Lookup::Fetch(span) = ahead.find(i << 20) {
                ahead.begin(&span);
                ahead.came(&span, &vec![0; (span.range.end - span.range.start) as usize].into());
                ahead.find(i << 20);
            }
            assert!(ahead.here <= KEPT + (2 << 20), "{}", ahead.here);
        }
    }

    /// The 28 bytes of padding between two blocks are known once both have arrived, and the 36
    /// behind the last one; no other padding is.
    #[test]
    fn padding_is_known_once_its_blocks_arrived() {
        let mut ahead = alone();
        ahead.tell([block(64, 100), block(192, 92)].into_iter(), 1000);
        let span = ahead.next().expect("a span");
        ahead.came(&span, &(64..320_u32).map(|i| i as u8).collect::<Vec<_>>().into());
        assert_eq!(ahead.between(164, 28).map(|bytes| (bytes.len(), bytes[0])), Some((28, 164)));
        assert_eq!(ahead.between(284, 36).map(|bytes| bytes[35]), Some(63));
        assert!(ahead.between(164, 29).is_none() && ahead.between(100, 4).is_none() && ahead.between(0, 1).is_none());
    }
}
