//! Journal of a build, `NAME.partial.log`: the part of the partial file that is valid after a
//! crash. In: the directory entries of every checkpoint. Out: the longest intact sequence of them,
//! with the job that wrote them.
//!
//! It is a file beside the partial file because a checkpoint inside it would move every later
//! block: section 7.1 of `schema/heliotile-1.md`.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use crate::writing::disk::{Disk, Handle};
use heliotile_core::archive::codec::pack;
use heliotile_core::archive::format;
use heliotile_core::archive::format::{
    BlockKind, ENTRY_SIZE, Entry, FIRST_BLOCK, MAJOR, MAX_ENTRIES, MAX_RAW, MINOR, TileNumber,
};
use heliotile_core::error::{Error, Result};

/// First bytes of a journal.
pub const MAGIC: [u8; 8] = [0x89, b'H', b'L', b'J', 0x0d, 0x0a, 0x1a, 0x0a];
/// Layout of the batches. The header is the same in every version.
pub const VERSION: u16 = 1;
/// Size of checksums, bytes: complete BLAKE3 hashes.
pub const SUM_SIZE: usize = 32;
/// Size of the header with its checksum, bytes.
pub const HEADER_SIZE: usize = 208;
/// Size of the fields of [`Header`], which its checksum covers, bytes.
const HEADER_CHECKED: usize = 176;
/// Size of a batch without its entries and its checksum, bytes.
pub const BATCH_SIZE: usize = 16;

/// Hint that applies to an interrupted build of every command.
pub(super) const REMOVE: &str = "remove it to start again";

/// Hashes of the inputs of a build. Only an equal job may resume an interrupted build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Hash of geometry, materials and objects.
    pub scene: [u8; 32],
    /// Hash of all receivers, in the order of tiles.
    pub receivers: [u8; 32],
    /// Hash of the build's settings.
    pub settings: [u8; 32],
}

/// Part of a build that is on the disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Number of blocks in the partial file.
    pub blocks: u64,
    /// Length of the partial file, bytes.
    pub bytes: u64,
}

heliotile_core::record! {
    /// Header of a journal: the program and its job.
    Header {
        magic: [u8; 8],
        /// [`VERSION`].
        version: u16,
        /// Format of the archive.
        major: u16,
        minor: u16,
        reserved: [u8; 2],
        scene: [u8; 32],
        receivers: [u8; 32],
        settings: [u8; 32],
        /// Program and compressor with their versions, UTF-8, padded with zeros. Other versions may
        /// give other bytes.
        program: [u8; 64],
    }
}

heliotile_core::record! {
    /// Header of the entries that one checkpoint adds.
    Batch {
        /// Number of entries that follow.
        count: u64,
        /// Length of the partial file after the last of them.
        committed: u64,
    }
}

impl Header {
    fn new(job: &Job) -> Self {
        let name = format!("heliotile {}, zstd {}", env!("CARGO_PKG_VERSION"), pack::compressor_version());
        let mut program = [0; 64];
        program.iter_mut().zip(name.bytes()).for_each(|(place, byte)| *place = byte);
        Header {
            magic: MAGIC,
            version: VERSION,
            major: MAJOR,
            minor: MINOR,
            reserved: [0; 2],
            scene: job.scene,
            receivers: job.receivers,
            settings: job.settings,
            program,
        }
    }

    /// Returns the names of the parts that differ in another header.
    fn differences(&self, other: &Header) -> Vec<&'static str> {
        let version = |h: &Header| (h.version, h.major, h.minor, h.program);
        [
            ("scene", self.scene != other.scene),
            ("receivers", self.receivers != other.receivers),
            ("settings", self.settings != other.settings),
            ("program version", version(self) != version(other)),
        ]
        .into_iter()
        .filter_map(|(name, differs)| differs.then_some(name))
        .collect()
    }
}

/// Open journal that can take another batch.
#[derive(Debug)]
pub struct Journal {
    file: Handle,
    length: u64,
    /// Checksum of the last part. The next checksum covers it, so nothing after a damaged part
    /// counts.
    sum: [u8; SUM_SIZE],
}

impl Journal {
    /// Starts a journal. Its header gets to the disk with the first batch.
    pub fn create(disk: &dyn Disk, path: &Path, job: &Job) -> Result<Self> {
        let file = Handle::new(path, disk.create(path).map_err(Error::io(path, "create"))?);
        let mut bytes = Vec::with_capacity(HEADER_SIZE);
        Header::new(job).put(&mut bytes);
        let sum = chain(&[], &bytes);
        bytes.extend_from_slice(&sum);
        file.write(0, &bytes)?;
        Ok(Journal { file, length: bytes.len() as u64, sum })
    }

    /// Appends the entries written since the last batch, and syncs the journal. The partial file
    /// must be synced up to `committed`.
    pub fn append(&mut self, entries: &[Entry], committed: u64) -> Result<()> {
        let mut bytes = Vec::with_capacity(batch_length(entries.len()).unwrap_or(0));
        Batch { count: entries.len() as u64, committed }.put(&mut bytes);
        entries.iter().for_each(|entry| entry.encode(&mut bytes));
        let sum = chain(&self.sum, &bytes);
        bytes.extend_from_slice(&sum);
        self.file.write(self.length, &bytes)?;
        self.file.sync()?;
        self.length = self.length.saturating_add(bytes.len() as u64);
        self.sum = sum;
        Ok(())
    }
}

/// Interrupted build.
#[derive(Debug)]
pub struct InterruptedBuild {
    header: Header,
    journal: Journal,
    /// Valid bytes of the journal.
    bytes: Vec<u8>,
    pub entries: BTreeMap<(BlockKind, TileNumber), Entry>,
    /// End of the last block.
    pub end: u64,
}

/// Returns the interrupted build that journal and partial file describe; `None` if no checkpoint is
/// valid. Blocks are compared with their checksums, so a journal beside another partial file, or
/// none, does not count.
pub fn find(disk: &dyn Disk, path: &Path, partial: &Handle) -> Result<Option<InterruptedBuild>> {
    let file = match disk.open(path) {
        Ok(file) => Handle::new(path, file),
        Err(source) if source.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(Error::io(path, "open")(source)),
    };
    let (length, partial_length) = (file.length()?, partial.length()?);
    if length < HEADER_SIZE as u64 {
        return Ok(None);
    }
    let bytes = file.read(0, HEADER_SIZE)?;
    let Some((header, sum)) = decode_header(&bytes) else { return Ok(None) };
    let journal = Journal { file, length: HEADER_SIZE as u64, sum };
    let mut found = InterruptedBuild { header, journal, bytes, entries: BTreeMap::new(), end: FIRST_BLOCK };
    if header.version != VERSION {
        // Batches of another version cannot be read, but they are finished work.
        return Ok((partial_length > FIRST_BLOCK).then_some(found));
    }
    while found.take_batch(length, partial, partial_length)? {}
    Ok((!found.entries.is_empty()).then_some(found))
}

impl InterruptedBuild {
    /// Takes the next batch if it is intact and its blocks are in the partial file.
    fn take_batch(&mut self, length: u64, partial: &Handle, partial_length: u64) -> Result<bool> {
        let Some(bytes) = self.next_batch(length)? else { return Ok(false) };
        let Some((checked, sum)) = bytes.split_last_chunk::<SUM_SIZE>() else { return Ok(false) };
        let Some((batch, entries)) = Batch::take(checked) else { return Ok(false) };
        if chain(&self.journal.sum, checked) != *sum || batch.committed > partial_length {
            return Ok(false);
        }
        let entries: Vec<Entry> = entries.chunks_exact(ENTRY_SIZE).filter_map(Entry::decode).collect();
        let mut end = self.end;
        for entry in &entries {
            match block_end(partial, entry, end, batch.committed)? {
                Some(next) if !self.entries.contains_key(&entry.key()) => end = next,
                _ => return Ok(false),
            }
        }
        if end != batch.committed {
            return Ok(false);
        }
        self.entries.extend(entries.iter().map(|entry| (entry.key(), *entry)));
        self.end = end;
        self.journal.length = self.journal.length.saturating_add(bytes.len() as u64);
        self.journal.sum = *sum;
        self.bytes.extend_from_slice(&bytes);
        Ok(true)
    }

    /// Reads the next batch, if the file is long enough for it.
    fn next_batch(&self, length: u64) -> Result<Option<Vec<u8>>> {
        let file = &self.journal.file;
        let (start, rest) = (self.journal.length, length.saturating_sub(self.journal.length));
        if rest < BATCH_SIZE as u64 {
            return Ok(None);
        }
        let Some((batch, _)) = Batch::take(&file.read(start, BATCH_SIZE)?) else { return Ok(None) };
        let count = usize::try_from(batch.count).ok().filter(|_| batch.count <= MAX_ENTRIES);
        match count.and_then(batch_length).filter(|&size| size as u64 <= rest) {
            Some(size) => file.read(start, size).map(Some),
            None => Ok(None),
        }
    }

    pub fn progress(&self) -> Progress {
        Progress { blocks: self.entries.len() as u64, bytes: self.end }
    }

    /// Refuses to resume with another job.
    pub fn check(&self, partial: &Path, job: &Job) -> Result<()> {
        let ours = Header::new(job);
        let differences = self.header.differences(&ours);
        if differences.is_empty() {
            return Ok(());
        }
        let mut what = format!("is an interrupted build that differs in: {}", differences.join(", "));
        if self.header.program != ours.program {
            what += &format!(" (it was written by {}, this is {})", text(&self.header.program), text(&ours.program));
        }
        Err(Error::Incomplete { partial: partial.to_path_buf(), what: what.into(), hint: REMOVE.into() })
    }

    /// Returns the journal without its invalid end. The valid bytes are written again in place,
    /// because after a failed sync of the run before they may have been in memory only.
    pub fn into_journal(self) -> Result<Journal> {
        let InterruptedBuild { journal, bytes, .. } = self;
        journal.file.write(0, &bytes)?;
        journal.file.set_len(journal.length)?;
        journal.file.sync()?;
        Ok(journal)
    }
}

/// Returns the end of a block that was written after `end`; `None` unless it is intact, follows
/// zeros only and ends by `committed`.
fn block_end(partial: &Handle, entry: &Entry, end: u64, committed: u64) -> Result<Option<u64>> {
    let stored = usize::try_from(entry.stored).ok().filter(|stored| (1..=MAX_RAW).contains(stored));
    let next = entry.end().filter(|&next| next <= committed && format::align(end) == Some(entry.offset));
    let (Some(stored), Some(next)) = (stored, next) else { return Ok(None) };
    let padding = usize::try_from(entry.offset.saturating_sub(end)).unwrap_or(0);
    let zeros = partial.read(end, padding)?.iter().all(|byte| *byte == 0);
    let whole = format::checksum(&partial.read(entry.offset, stored)?) == entry.checksum;
    Ok((zeros && whole).then_some(next))
}

/// Returns the size of a batch of `count` entries, bytes.
fn batch_length(count: usize) -> Option<usize> {
    count.checked_mul(ENTRY_SIZE)?.checked_add(BATCH_SIZE)?.checked_add(SUM_SIZE)
}

/// Returns the checksum of a part that follows one with the checksum `previous`.
fn chain(previous: &[u8], bytes: &[u8]) -> [u8; SUM_SIZE] {
    *blake3::Hasher::new().update(previous).update(bytes).finalize().as_bytes()
}

/// Decodes a header, and returns it if its checksum is right.
fn decode_header(bytes: &[u8]) -> Option<(Header, [u8; SUM_SIZE])> {
    let (checked, sum) = bytes.split_at_checked(HEADER_CHECKED)?;
    let (header, _) = Header::take(checked)?;
    let right = chain(&[], checked);
    (header.magic == MAGIC && sum == right).then_some((header, right))
}

/// Returns text without its padding of zeros.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim_end_matches('\0').to_string()
}
