//! A remote archive that is read by ranges. In: an address. Out: its bytes, of one version.
//! Announced blocks are fetched together, many at a time; blocks that are in the cache are not
//! fetched.

use std::io;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use bytes::Bytes;
use heliotile_core::archive::ReadAt;
use heliotile_core::archive::format::{self, Entry};
use heliotile_core::error::Result;
use tokio::runtime::Runtime;

use crate::stores::address::Address;
use crate::stores::ahead::{Ahead, Lookup, OpenFiles};
use crate::stores::cache::Cache;
use crate::stores::failure::{Cause, Failure};
use crate::stores::opening::Opened;
use crate::stores::spans::ByteSpan;
use crate::stores::store::{Connection, Locator, runtime};

/// Longest wait for a block, in time limits of one request: the request, its retries, and requests
/// queued before it.
const PATIENCE: u32 = 6;

/// Files that share the memory for blocks.
static OPEN: OpenFiles = OpenFiles::none();

/// An object, open for reading. Many threads may read from it.
#[derive(Debug)]
pub struct RemoteFile(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    place: Locator,
    opened: Opened,
    cache: Option<Cache>,
    runtime: &'static Runtime,
    ahead: Mutex<Ahead>,
    /// Signals that a span arrived or failed.
    news: Condvar,
}

impl RemoteFile {
    /// Opens the object at an address, or the archive that a pointer there leads to. Errors: it is
    /// not there, may not be read or cannot be reached, or it is large and its server has no
    /// ranges.
    pub fn open(address: &Address, connection: Connection, cache: Option<Cache>) -> Result<Self> {
        RemoteFile::look(address, connection, cache)?.map_err(|failure| failure.at(address))
    }

    /// Opens the object at an address, or returns `None` for a failure that `absent` accepts.
    pub fn find(
        address: &Address,
        connection: Connection,
        cache: Option<Cache>,
        absent: fn(&Failure) -> bool,
    ) -> Result<Option<Self>> {
        match RemoteFile::look(address, connection, cache)? {
            Ok(file) => Ok(Some(file)),
            Err(failure) if absent(&failure) => Ok(None),
            Err(failure) => Err(failure.at(address)),
        }
    }

    /// Opens the object at an address. The inner result holds the failure of the address itself;
    /// the outer one holds errors of the object that a pointer there leads to.
    fn look(
        address: &Address,
        connection: Connection,
        cache: Option<Cache>,
    ) -> Result<std::result::Result<Self, Failure>> {
        let runtime = runtime()?;
        let open = |place: &Locator| runtime.block_on(Opened::open_sound(place, cache.as_ref()));
        let mut place = Locator::connect(address, connection)?;
        let mut opened = match open(&place) {
            Ok(opened) => opened,
            Err(failure) => return Ok(Err(failure)),
        };
        // The bytes must be those that the pointer was written for.
        if let Some(pointer) = opened.pointer().map_err(|failure| failure.at(address))? {
            place = Locator::connect(&address.beside(&pointer.name), connection)?;
            opened = open(&place).map_err(|failure| failure.at(&place.address))?;
            let root = opened.slot().map(|slot| format::hex(&slot.root));
            if root.as_ref() != Some(&pointer.root) || opened.length != pointer.length {
                let what = format!(
                    "is not the archive that {} points to: that has root {}",
                    address.shown().display(),
                    pointer.root
                );
                return Err(Failure::new(Cause::Refused, what).at(&place.address));
            }
        }
        let (ahead, news) = (Mutex::new(Ahead::among(&OPEN)), Condvar::new());
        Ok(Ok(RemoteFile(Arc::new(Shared { place, opened, cache, runtime, ahead, news }))))
    }

    /// Returns the name for messages: the address, or the address of the archive that a pointer
    /// leads to.
    pub fn name(&self) -> &Path {
        self.0.place.address.shown()
    }

    /// Returns true if the object begins as an archive does.
    pub fn is_archive(&self) -> bool {
        self.0.opened.head.starts_with(&format::MAGIC)
    }

    /// Returns the root that the header of the archive states, or `None` if the object is no
    /// archive.
    pub fn root(&self) -> Option<[u8; 32]> {
        self.0.opened.slot().map(|slot| slot.root)
    }
}

impl Shared {
    fn ahead(&self) -> MutexGuard<'_, Ahead> {
        // A thread that panicked leaves the bookkeeping usable: it still holds what arrived.
        self.ahead.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns bytes that were read when the object was opened.
    fn at_hand(&self, offset: u64, length: usize) -> Option<&[u8]> {
        let Opened { head, end: (start, end), .. } = &self.opened;
        let part = |bytes: &'_ Bytes, at: u64| -> Option<std::ops::Range<usize>> {
            let at = usize::try_from(at).ok()?;
            let end = at.checked_add(length).filter(|&end| end <= bytes.len())?;
            Some(at..end)
        };
        let in_head = part(head, offset).and_then(|range| head.get(range));
        in_head.or_else(|| end.get(part(end, offset.checked_sub(*start)?)?))
    }

    /// Returns a block from the bytes read at opening if its checksum is right. A damaged block is
    /// fetched again.
    fn block_at_hand(&self, block: &Entry) -> Option<&[u8]> {
        let bytes = self.at_hand(block.offset, usize::try_from(block.stored).ok()?)?;
        (format::checksum(bytes) == block.checksum).then_some(bytes)
    }

    fn failed(&self, failure: Failure) -> io::Error {
        io::Error::other(failure.at(&self.place.address))
    }

    /// Requests the next spans of the queue.
    fn go_on(self: &Arc<Self>) {
        let next: Vec<ByteSpan> = {
            let mut ahead = self.ahead();
            std::iter::from_fn(|| ahead.next()).collect()
        };
        next.into_iter().for_each(|span| self.fetch(span));
    }

    /// Requests a span that is marked as under way.
    fn fetch(self: &Arc<Self>, span: ByteSpan) {
        let Some(object) = self.opened.object.clone() else { return };
        let shared = Arc::clone(self);
        self.runtime.spawn(async move {
            let mut came = object.range(span.range.clone()).await;
            if came.as_ref().is_ok_and(|bytes| good(&span, bytes).count() < span.blocks.len()) {
                // Blocks may have been damaged on the way.
                came = object.range(span.range.clone()).await;
            }
            // The cache is written on a blocking thread, so that requests do not wait for the disk.
            tokio::task::spawn_blocking(move || shared.took(&span, came));
        });
    }

    fn took(self: &Arc<Self>, span: &ByteSpan, came: std::result::Result<Bytes, Failure>) {
        match came {
            Ok(bytes) => {
                if let Some(cache) = &self.cache {
                    good(span, &bytes).for_each(|(block, stored)| cache.keep_block(block, stored));
                }
                self.ahead().came(span, &bytes);
            }
            Err(failure) => self.ahead().failed(span, &failure),
        }
        self.news.notify_all();
        self.go_on();
    }

    /// Returns a block from memory or from the cache, or fetches it.
    fn block(self: &Arc<Self>, block: &Entry) -> std::result::Result<Bytes, Failure> {
        let begun = Instant::now();
        let patience = self.place.connection.timeout * PATIENCE;
        let mut ahead = self.ahead();
        loop {
            match ahead.find(block.offset) {
                Lookup::Bytes(bytes) => {
                    drop(ahead);
                    self.go_on();
                    return Ok(bytes);
                }
                Lookup::Failed(failure) => return Err(failure),
                Lookup::Fetch(span) => {
                    ahead.begin(&span);
                    self.fetch(span);
                }
                Lookup::Unknown => {
                    drop(ahead);
                    if let Some(bytes) = self.cache.as_ref().and_then(|cache| cache.block(block)) {
                        return Ok(bytes.into());
                    }
                    ahead = self.ahead();
                    ahead.tell([*block].into_iter(), self.opened.length);
                }
                Lookup::OnItsWay => {
                    let left = patience.saturating_sub(begun.elapsed());
                    if left.is_zero() {
                        return Err(Failure::new(Cause::Passing, "gave no complete answer in time"));
                    }
                    ahead = self.news.wait_timeout(ahead, left).unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        }
    }
}

/// Returns the blocks of a span whose bytes have the right checksum, with these bytes.
fn good<'s>(span: &'s ByteSpan, bytes: &'s Bytes) -> impl Iterator<Item = (&'s Entry, &'s [u8])> {
    span.blocks.iter().filter_map(|block| {
        let start = usize::try_from(block.offset.checked_sub(span.range.start)?).ok()?;
        let stored = bytes.get(start..start.checked_add(usize::try_from(block.stored).ok()?)?)?;
        (format::checksum(stored) == block.checksum).then_some((block, stored))
    })
}

impl ReadAt for RemoteFile {
    fn length(&self) -> u64 {
        self.0.opened.length
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        let shared = &self.0;
        if let Some(here) = shared.at_hand(offset, bytes.len()) {
            bytes.copy_from_slice(here);
            return Ok(());
        }
        let between = shared.ahead().between(offset, bytes.len());
        let found = match (between, &shared.opened.object) {
            (Some(found), _) => found,
            (None, Some(object)) => {
                let end = offset.checked_add(bytes.len() as u64).filter(|&end| end <= self.length());
                let end = end.ok_or(io::ErrorKind::UnexpectedEof)?;
                shared.runtime.block_on(object.parts(offset..end)).map_err(|failure| shared.failed(failure))?
            }
            (None, None) => return Err(io::ErrorKind::UnexpectedEof.into()),
        };
        match found.len() == bytes.len() {
            true => bytes.copy_from_slice(&found),
            false => return Err(io::ErrorKind::UnexpectedEof.into()),
        }
        Ok(())
    }

    fn expect(&self, blocks: &[Entry]) {
        let shared = &self.0;
        if shared.opened.object.is_none() {
            return;
        }
        let far = |block: &&Entry| {
            shared.block_at_hand(block).is_none() && !shared.cache.as_ref().is_some_and(|cache| cache.has(block))
        };
        let far: Vec<Entry> = blocks.iter().filter(far).copied().collect();
        shared.ahead().tell(far.into_iter(), shared.opened.length);
        shared.go_on();
    }

    fn copy_block(&self, block: &Entry) -> io::Result<Vec<u8>> {
        match self.0.block_at_hand(block) {
            Some(bytes) => Ok(bytes.to_vec()),
            // The reader of the block checks it.
            None if self.0.opened.object.is_none() => self.copy_at(block.offset, block.stored as usize),
            None => self.0.block(block).map(Into::into).map_err(|failure| self.0.failed(failure)),
        }
    }
}
