//! Writer of archives. In: blocks in an order that depends on the input alone, then a manifest.
//! Out: the finished file, complete or absent. Everything goes to `NAME.partial`, is synced, and
//! gets its name last. Checkpoints go to a journal beside it, so that an interrupted build resumes
//! where it was and ends with the same bytes.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::writing::disk::{Disk, Handle, SystemDisk};
use crate::writing::journal;
use crate::writing::journal::{InterruptedBuild, Job, Journal, Progress};
use heliotile_core::archive::Blocks;
use heliotile_core::archive::codec::block;
use heliotile_core::archive::codec::block::{Block, EncodedBlock};
use heliotile_core::archive::format;
use heliotile_core::archive::format::{
    BlockKind, COMPLETE, ENTRY_SIZE, Entry, FIRST_BLOCK, MAX_ENTRIES, SLOT_OFFSETS, Slot, TileNumber,
};
use heliotile_core::archive::manifest;
use heliotile_core::archive::manifest::{LayerSummary, Manifest};
use heliotile_core::error::{Error, Result};

/// Time after which a checkpoint is due; [`CHECKPOINT_BYTES`] is the number of bytes after which it
/// is due, too. They limit what a crash costs; a checkpoint takes two syncs.
pub(super) const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);
pub(super) const CHECKPOINT_BYTES: u64 = 64 << 20;

/// Summary of a finished archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Root hash, which identifies the content of the whole archive.
    pub root: [u8; 32],
    /// Length of the file, bytes.
    pub bytes: u64,
}

/// Action for an interrupted build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interrupted {
    Refuse,
    Discard,
    Resume,
}

/// Archive that is being written. If it is dropped before [`Writer::finish`], it leaves partial
/// file and journal for [`Writer::resume`] if there is a checkpoint, else nothing.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    log: PathBuf,
    disk: Arc<dyn Disk>,
    /// Partial file, locked until the end: no other process may remove, rename or write it, or
    /// touch the journal.
    partial: Handle,
    job: Job,
    /// Journal, created by the first checkpoint because most builds end before it.
    journal: Option<Journal>,
    entries: BTreeMap<(BlockKind, TileNumber), Entry>,
    /// Entries that the next checkpoint adds, in the order of writing.
    pending: Vec<Entry>,
    /// End of the bytes written.
    end: u64,
    committed: Option<Progress>,
    committed_at: Instant,
    checkpoint_every: Duration,
    resumed: Option<Progress>,
    /// True if a write or sync failed. The state of the disk is then unknown, and a repeated sync
    /// may report success wrongly.
    failed: bool,
    renamed: bool,
}

impl Writer {
    /// Starts `path`'s partial file. A file that another process writes is refused, and so is an
    /// interrupted build with a checkpoint; one without is overwritten. An archive at `path` stays
    /// as it is until [`Writer::finish`].
    pub fn create(path: &Path, job: &Job) -> Result<Self> {
        Writer::start(Arc::new(SystemDisk), path, job, Interrupted::Refuse)
    }

    /// Starts a build as [`Writer::create`] does, but discards an interrupted one.
    pub fn create_fresh(path: &Path, job: &Job) -> Result<Self> {
        Writer::start(Arc::new(SystemDisk), path, job, Interrupted::Discard)
    }

    /// Resumes an interrupted build of the same job after its last checkpoint, or starts again if
    /// there is none, see [`Writer::resumed`]. Blocks that [`Writer::has`] must not be appended
    /// again; the others come in the usual order.
    pub fn resume(path: &Path, job: &Job) -> Result<Self> {
        Writer::start(Arc::new(SystemDisk), path, job, Interrupted::Resume)
    }

    pub(super) fn start(disk: Arc<dyn Disk>, path: &Path, job: &Job, interrupted: Interrupted) -> Result<Self> {
        let Some(name) = path.file_name() else {
            return Err(Error::input(path, None, "cannot be an archive", "name a file, such as site.helio"));
        };
        let beside = |ending: &str| {
            let mut name = name.to_os_string();
            name.push(ending);
            path.with_file_name(name)
        };
        let (partial, log) = (beside(".partial"), beside(".partial.log"));
        let partial = Handle::new(&partial, disk.lock(&partial)?);
        check_own(&partial)?;
        let found = match interrupted {
            Interrupted::Discard => None,
            _ => journal::find(&*disk, &log, &partial)?,
        };
        let writer = Writer {
            path: path.to_path_buf(),
            log,
            disk,
            partial,
            job: *job,
            journal: None,
            entries: BTreeMap::new(),
            pending: Vec::new(),
            end: FIRST_BLOCK,
            committed: found.as_ref().map(InterruptedBuild::progress),
            committed_at: Instant::now(),
            checkpoint_every: CHECKPOINT_EVERY,
            resumed: None,
            failed: false,
            renamed: false,
        };
        match found {
            Some(found) => {
                found.check(writer.partial.path(), job)?;
                if interrupted == Interrupted::Refuse {
                    return Err(lies_there(writer.partial.path(), found.progress()));
                }
                writer.go_on(found)
            }
            None => writer.begin(),
        }
    }

    /// Starts with an empty partial file.
    fn begin(self) -> Result<Self> {
        match self.disk.remove(&self.log) {
            // An old journal must not come back after a crash, when the partial file holds other
            // bytes.
            Ok(()) => self.sync_folder()?,
            Err(source) if source.kind() == io::ErrorKind::NotFound => {}
            Err(source) => return Err(Error::io(&self.log, "remove")(source)),
        }
        self.reset(FIRST_BLOCK)?;
        Ok(self)
    }

    /// Starts with the partial file as it was at its last checkpoint.
    fn go_on(mut self, mut found: InterruptedBuild) -> Result<Self> {
        let progress = found.progress();
        self.entries = std::mem::take(&mut found.entries);
        self.journal = Some(found.into_journal()?);
        self.sync_folder()?;
        self.reset(progress.bytes)?;
        (self.end, self.resumed) = (progress.bytes, Some(progress));
        Ok(self)
    }

    /// Marks the partial file as "building", and cuts it. A run before may have ended between
    /// commit and rename, so the mark must be on the disk before a block is cut or overwritten.
    fn reset(&self, length: u64) -> Result<()> {
        let left_over = self.partial.length()? > 0;
        let mut header = Slot::building().encode();
        header.resize(usize::try_from(FIRST_BLOCK).unwrap_or(0), 0);
        self.partial.write(0, &header)?;
        if left_over {
            self.partial.sync()?;
        }
        self.partial.set_len(length)
    }

    /// Returns the progress that [`Writer::resume`] found; `None` if this build started from
    /// nothing.
    pub fn resumed(&self) -> Option<Progress> {
        self.resumed
    }

    /// Returns the progress that [`Writer::resume`] would find if the power failed now.
    pub fn committed(&self) -> Option<Progress> {
        self.committed
    }

    /// Appends a block.
    pub fn append(&mut self, block: EncodedBlock) -> Result<()> {
        let EncodedBlock { mut entry, stored } = block;
        if self.entries.contains_key(&entry.key()) {
            return Err(Error::defect(self.partial.path(), entry.name(), "number", "was written already"));
        }
        if self.entries.len() as u64 >= MAX_ENTRIES {
            let value = MAX_ENTRIES.saturating_add(1);
            return Err(Error::Limit { what: "number of blocks".into(), value, max: MAX_ENTRIES });
        }
        entry.offset = self.place(stored.len())?;
        self.attempt(|writer| writer.partial.write(entry.offset, &stored))?;
        self.end = entry.offset.saturating_add(u64::from(entry.stored));
        self.entries.insert(entry.key(), entry);
        self.pending.push(entry);
        Ok(())
    }

    /// Returns the path of the partial file.
    pub fn partial(&self) -> &Path {
        self.partial.path()
    }

    /// Returns true if a block was appended, in this run or before a resume.
    pub fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        self.entry(kind, tile).is_some()
    }

    /// Returns the directory entry of a block.
    pub fn entry(&self, kind: BlockKind, tile: TileNumber) -> Option<&Entry> {
        self.entries.get(&(kind, tile))
    }

    /// Reads an appended block from the file and checks it. Several threads may do so at once.
    pub fn read_back(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        let Some(entry) = self.entry(kind, tile) else {
            let name = format::block_name(kind, tile);
            return Err(Error::defect(self.partial.path(), name, "number", "was not written yet"));
        };
        let stored = self.partial.read(entry.offset, usize::try_from(entry.stored).unwrap_or(0))?;
        block::decode(self.partial.path(), entry, &stored)
    }

    /// Returns true if enough was written since the last checkpoint that the next one is worth its
    /// syncs.
    pub fn due(&self) -> bool {
        let done = self.committed.map_or(FIRST_BLOCK, |progress| progress.bytes);
        let much = self.end.saturating_sub(done) >= CHECKPOINT_BYTES;
        !self.pending.is_empty() && (much || self.committed_at.elapsed() >= self.checkpoint_every)
    }

    /// Sets the time after which a checkpoint is due, 30 seconds by default.
    pub fn set_checkpoint_every(&mut self, every: Duration) {
        self.checkpoint_every = every;
    }

    /// Makes everything appended so far survive a crash. Does nothing if there is nothing new.
    pub fn checkpoint(&mut self) -> Result<()> {
        if !self.pending.is_empty() {
            self.attempt(Writer::commit)?;
        }
        Ok(())
    }

    /// Ends the build for now, with a last checkpoint. [`Writer::resume`] can continue it.
    pub fn keep(mut self) -> Result<()> {
        self.checkpoint()
    }

    /// Syncs blocks, then the journal that names them, then, once, the names of both files.
    fn commit(&mut self) -> Result<()> {
        self.partial.sync()?;
        let first = self.journal.is_none();
        let mut journal = match self.journal.take() {
            Some(journal) => journal,
            None => Journal::create(&*self.disk, &self.log, &self.job)?,
        };
        journal.append(&self.pending, self.end)?;
        if first {
            self.sync_folder()?;
        }
        self.journal = Some(journal);
        self.pending.clear();
        self.committed = Some(Progress { blocks: self.entries.len() as u64, bytes: self.end });
        self.committed_at = Instant::now();
        Ok(())
    }

    /// Returns number and size of the blocks so far, for [`Manifest::layers`].
    pub fn layers(&self) -> Vec<LayerSummary> {
        manifest::summarize(self.entries.values())
    }

    /// Writes directory and manifest, syncs, commits, and gives the file its name. After an error
    /// the name refers to the file it did before; only if syncing the folder fails, it may refer to
    /// either after a crash.
    pub fn finish(mut self, manifest: &Manifest) -> Result<Summary> {
        let entries: Vec<Entry> = self.entries.values().copied().collect();
        manifest.check(&entries).map_err(|wrong| Error::Unsupported {
            what: format!("{}: the manifest does not fit the blocks", self.path.display()).into(),
            found: wrong.got,
            supported: wrong.expected.into(),
        })?;
        let json = manifest.to_json()?;
        self.attempt(|writer| writer.publish(&entries, &json))
    }

    fn publish(&mut self, entries: &[Entry], json: &[u8]) -> Result<Summary> {
        let mut directory = Vec::with_capacity(entries.len().saturating_mul(ENTRY_SIZE));
        entries.iter().for_each(|entry| entry.encode(&mut directory));
        let directory_offset = self.place(directory.len())?;
        self.partial.write(directory_offset, &directory)?;
        self.end = directory_offset.saturating_add(directory.len() as u64);
        let manifest_offset = self.place(json.len())?;
        self.partial.write(manifest_offset, json)?;
        self.end = manifest_offset.saturating_add(json.len() as u64);
        self.partial.sync()?;

        let slot = Slot {
            state: COMPLETE,
            generation: 1,
            committed: self.end,
            directory_offset,
            directory_length: directory.len() as u64,
            directory_count: entries.len() as u64,
            manifest_offset,
            manifest_length: json.len() as u64,
            root: format::root_hash(&directory, json),
            ..Slot::building()
        };
        for offset in SLOT_OFFSETS {
            // The two slots are equal: if one is torn, its checksum is wrong, and the other counts.
            self.partial.write(offset, &slot.encode())?;
        }
        self.partial.sync()?;
        let rename = self.disk.rename(self.partial.path(), &self.path);
        rename.map_err(Error::io(&self.path, "rename the partial file to"))?;
        self.renamed = true;
        self.sync_folder()?;
        if self.journal.is_some() {
            // The archive is complete and has its name. A journal that stays is dropped by the next
            // build.
            let _ = self.disk.remove(&self.log);
        }
        Ok(Summary { root: slot.root, bytes: self.end })
    }

    /// Does work that changes files. After a failure nothing is tried again.
    fn attempt<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        if self.failed {
            let source = io::Error::other("an earlier write or sync of this build failed");
            return Err(Error::Io { path: self.partial.path().to_path_buf(), action: "go on writing", source });
        }
        // Set before the work, so that an early return and a panic both leave it set.
        self.failed = true;
        let done = work(self)?;
        self.failed = false;
        Ok(done)
    }

    /// Returns the offset of the next `length` bytes. The file cannot pass 2^64.
    fn place(&self, length: usize) -> Result<u64> {
        let max = u64::MAX;
        format::align(self.end).filter(|start| start.checked_add(length as u64).is_some()).ok_or(Error::Limit {
            what: "length of the archive in bytes".into(),
            value: self.end,
            max,
        })
    }

    fn sync_folder(&self) -> Result<()> {
        self.disk.sync_folder(&self.path).map_err(Error::io(&self.path, "sync the folder of"))
    }
}

/// Refuses a file at the name of the partial file that no build wrote: its bytes would be lost. A
/// header that did not reach the disk before a loss of power is zeros.
fn check_own(partial: &Handle) -> Result<()> {
    let length = partial.length()?.min(format::MAGIC.len() as u64);
    let head = partial.read(0, usize::try_from(length).unwrap_or(0))?;
    if format::MAGIC.starts_with(&head) || head.iter().all(|byte| *byte == 0) {
        return Ok(());
    }
    let what = "is no interrupted build, and a build to this name would replace it";
    Err(Error::input(partial.path(), None, what, "move it away, or give the archive another name"))
}

/// Returns the error for a build that would overwrite an interrupted one.
fn lies_there(partial: &Path, done: Progress) -> Error {
    let what = format!("is an interrupted build of which {} blocks, {} bytes are done", done.blocks, done.bytes);
    Error::Incomplete { partial: partial.to_path_buf(), what: what.into(), hint: journal::REMOVE.into() }
}

impl Drop for Writer {
    fn drop(&mut self) {
        if !self.renamed && self.committed.is_none() {
            // A failure here can be ignored, because the next writer overwrites the files that
            // stay.
            let _ = self.disk.remove(&self.log);
            let _ = self.disk.remove(self.partial.path());
        }
    }
}

impl Blocks for Writer {
    fn path(&self) -> &Path {
        Writer::partial(self)
    }

    fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        Writer::has(self, kind, tile)
    }

    fn rows(&self, kind: BlockKind, tile: TileNumber) -> Option<u32> {
        self.entry(kind, tile).map(|entry| entry.items)
    }

    fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        self.read_back(kind, tile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::writing::test_site;
    use crate::writing::test_site::JOB;
    use heliotile_core::archive::{Archive, encode};

    /// A second writer of the same file is refused while the first exists, and the file that it
    /// would replace is untouched.
    #[test]
    fn two_writers_are_one_too_many() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        std::fs::write(&path, b"old").unwrap();
        let first = Writer::create(&path, &JOB).unwrap();
        for _ in 0..3 {
            let error = Writer::create(&path, &JOB).unwrap_err().to_string();
            assert!(error.contains("is being written by another process"), "{error}");
        }
        drop(first);
        assert!(Writer::create(&path, &JOB).is_ok());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    /// A partial file of 100 kB from another run leaves no byte in the new file, and 4 threads that
    /// race make one writer. A file of that name that no build wrote is refused and keeps its 4
    /// bytes.
    #[test]
    fn left_overs_are_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        let (clean, _) = test_site::bytes();
        let partial = folder.path().join("site.helio.partial");
        std::fs::write(&partial, "mine").unwrap();
        assert!(Writer::create(&path, &JOB).unwrap_err().to_string().contains("is no interrupted build"));
        assert_eq!(std::fs::read(&partial).unwrap(), b"mine");
        std::fs::write(&partial, [&format::MAGIC[..], &[0xAA; 100_000]].concat()).unwrap();
        let writers = std::thread::scope(|scope| {
            let all: Vec<_> = (0..4).map(|_| scope.spawn(|| Writer::create(&path, &JOB))).collect();
            all.into_iter().map(|t| t.join().unwrap()).collect::<Vec<_>>()
        });
        let mut winners: Vec<_> = writers.into_iter().filter_map(|w| w.ok()).collect();
        assert_eq!(winners.len(), 1);
        test_site::fill(winners.pop().unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), clean);
    }

    /// Each of 5 blocks reads back before the end. A second one of the same name, and one never
    /// written, are errors.
    #[test]
    fn blocks_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(&folder.path().join("site.helio"), &JOB).unwrap();
        for tile in 0..5_u8 {
            writer.append(encode(format::HIT, TileNumber(tile.into()), 1, 1, &[tile; 900], 9).unwrap()).unwrap();
        }
        for tile in 0..5_u8 {
            assert_eq!(writer.read_back(format::HIT, TileNumber(tile.into())).unwrap().bytes(), [tile; 900]);
        }
        assert!(writer.read_back(format::HIT, TileNumber(5)).is_err());
        let error = writer.append(encode(format::HIT, format::TileNumber(4), 1, 1, &[0], 9).unwrap()).unwrap_err();
        assert!(error.to_string().contains("block hit/4, number: was written already"), "{error}");
        assert_eq!(writer.layers()[0].raw_bytes, 4500);
    }

    /// 30 s after the last checkpoint the next one is due if there is a block for it: 1 of 3 times
    /// here.
    #[test]
    fn checkpoints_fall_due_in_time() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(&folder.path().join("site.helio"), &JOB).unwrap();
        let due = |writer: &mut Writer| {
            writer.committed_at = Instant::now().checked_sub(CHECKPOINT_EVERY).unwrap();
            writer.due()
        };
        assert!(!due(&mut writer));
        writer.append(encode(format::HIT, format::TileNumber::FIRST, 1, 1, &[0; 900], 9).unwrap()).unwrap();
        assert!(due(&mut writer));
        writer.checkpoint().unwrap();
        assert!(!due(&mut writer));
    }

    /// An unfinished file says so, and a manifest that does not fit leaves no file at all: 0 names
    /// in the folder.
    #[test]
    fn unfinished_files_say_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        let writer = Writer::create(&path, &JOB).unwrap();
        writer.partial.set_len(10_000).unwrap();
        let error = Archive::open(&folder.path().join("site.helio.partial")).unwrap_err().to_string();
        assert!(error.contains("was not finished"), "{error}");
        let mut wrong = test_site::manifest();
        wrong.receivers.count = 9;
        assert!(writer.finish(&wrong).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
