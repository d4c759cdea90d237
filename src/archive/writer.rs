//! Writing an archive. In: blocks in an order that follows from the input alone, then a manifest. Out: the finished file,
//! whole or not at all: everything goes to `NAME.partial`, is synced, and gets its name last.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::codec::{self, Block, EncodedBlock};
use super::format::{self, COMPLETE, ENTRY_SIZE, Entry, FIRST_BLOCK, MAX_ENTRIES, SLOT_OFFSETS, Slot};
use super::manifest::{self, LayerSummary, Manifest};
use super::source::{read_exact_at, write_all_at};
use crate::error::{Error, Result};

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Root hash: names the content of the whole archive.
    pub root: [u8; 32],
    /// Length of the file.
    pub bytes: u64,
}

/// An archive that is being written. Dropped before [`Writer::finish`], it removes its partial file.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    partial: Arc<Path>,
    /// Locked until the end: nobody else may remove, rename or write the partial file.
    file: File,
    entries: BTreeMap<(u32, u32), Entry>,
    /// End of the bytes written.
    end: u64,
    renamed: bool,
}

impl Writer {
    /// Starts `path`'s partial file. A left-over of an interrupted run is overwritten; one that another process writes is
    /// refused. An archive that exists under `path` stays as it is until [`Writer::finish`] replaces it.
    pub fn create(path: &Path) -> Result<Self> {
        let Some(name) = path.file_name() else {
            return Err(Error::input(path, None, "cannot be an archive", "name a file, such as site.helio"));
        };
        let mut name = name.to_os_string();
        name.push(".partial");
        let partial = path.with_file_name(name);
        let file = lock(&partial)?;
        let writer = Writer {
            path: path.to_path_buf(),
            partial: Arc::from(partial),
            file,
            entries: BTreeMap::new(),
            end: FIRST_BLOCK,
            renamed: false,
        };
        writer.file.set_len(0).map_err(Error::io(&writer.partial, "empty"))?;
        writer.write(SLOT_OFFSETS[0], &Slot::building().encode())?;
        Ok(writer)
    }

    /// Adds a block.
    pub fn append(&mut self, block: EncodedBlock) -> Result<()> {
        let EncodedBlock { mut entry, stored } = block;
        if self.entries.contains_key(&entry.key()) {
            let what = format!("block {} was written twice", entry.name());
            return Err(Error::input(&self.partial, None, what, "this is a fault of the program: please report it"));
        }
        if self.entries.len() as u64 >= MAX_ENTRIES {
            let value = MAX_ENTRIES.saturating_add(1);
            return Err(Error::Limit { what: "number of blocks".to_string(), value, max: MAX_ENTRIES });
        }
        entry.offset = self.place(stored.len())?;
        self.write(entry.offset, &stored)?;
        self.end = entry.offset.saturating_add(u64::from(entry.stored));
        self.entries.insert(entry.key(), entry);
        Ok(())
    }

    /// A block that was appended, read from the file and checked. Many threads may do so.
    pub fn read_back(&self, kind: u32, tile: u32) -> Result<Block> {
        let Some(entry) = self.entries.get(&(kind, tile)) else {
            let what = format!("block {} was not written yet", format::block_name(kind, tile));
            return Err(Error::input(&self.partial, None, what, "this is a fault of the program: please report it"));
        };
        let mut stored = vec![0; usize::try_from(entry.stored).unwrap_or(0)];
        read_exact_at(&self.file, &mut stored, entry.offset).map_err(Error::io(&self.partial, "read"))?;
        codec::decode(&self.partial, entry, &stored)
    }

    /// Number and size of the blocks so far, for [`Manifest::layers`].
    pub fn layers(&self) -> Vec<LayerSummary> {
        manifest::summarize(self.entries.values())
    }

    /// Writes directory and manifest, syncs, commits, and gives the file its name. On an error the name means what it
    /// did before and the partial file is gone; only if syncing the folder fails, the name may mean either after a crash.
    pub fn finish(mut self, manifest: &Manifest) -> Result<Summary> {
        let entries: Vec<Entry> = self.entries.values().copied().collect();
        manifest.check(&entries).map_err(|wrong| Error::Unsupported {
            what: format!("{}: the manifest does not fit the blocks", self.path.display()),
            found: wrong.got,
            supported: wrong.expected,
        })?;
        let json = manifest.to_json()?;
        let mut directory = Vec::with_capacity(entries.len().saturating_mul(ENTRY_SIZE));
        entries.iter().for_each(|entry| entry.encode(&mut directory));

        let directory_offset = self.place(directory.len())?;
        self.write(directory_offset, &directory)?;
        self.end = directory_offset.saturating_add(directory.len() as u64);
        let manifest_offset = self.place(json.len())?;
        self.write(manifest_offset, &json)?;
        self.end = manifest_offset.saturating_add(json.len() as u64);
        self.sync()?;

        let slot = Slot {
            state: COMPLETE,
            generation: 1,
            committed: self.end,
            directory_offset,
            directory_length: directory.len() as u64,
            directory_count: entries.len() as u64,
            manifest_offset,
            manifest_length: json.len() as u64,
            root: format::root_hash(&directory, &json),
            ..Slot::building()
        };
        for offset in SLOT_OFFSETS {
            self.write(offset, &slot.encode())?;
        }
        self.sync()?;
        std::fs::rename(&self.partial, &self.path).map_err(Error::io(&self.path, "rename the partial file to"))?;
        self.renamed = true;
        sync_folder(&self.path)?;
        Ok(Summary { root: slot.root, bytes: self.end })
    }

    /// Where the next `length` bytes go; the file cannot pass 2^64.
    fn place(&self, length: usize) -> Result<u64> {
        let max = u64::MAX;
        format::align(self.end).filter(|start| start.checked_add(length as u64).is_some()).ok_or(Error::Limit {
            what: "length of the archive in bytes".to_string(),
            value: self.end,
            max,
        })
    }

    fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        write_all_at(&self.file, bytes, offset).map_err(Error::io(&self.partial, "write"))
    }

    fn sync(&self) -> Result<()> {
        self.file.sync_all().map_err(Error::io(&self.partial, "sync"))
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        if !self.renamed {
            // Nothing can be done about a failure here; the next writer overwrites what is left.
            let _ = std::fs::remove_file(&self.partial);
        }
    }
}

/// Opens and locks a partial file. Between opening and locking, the process that held the lock may have renamed or removed the
/// file, so what was locked must still be what the name means; else it is tried again.
fn lock(partial: &Path) -> Result<File> {
    for _ in 0..16 {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(partial)
            .map_err(Error::io(partial, "create"))?;
        match file.try_lock() {
            Ok(()) if is_named(&file, partial)? => return Ok(file),
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => break,
            Err(TryLockError::Error(source)) => {
                return Err(Error::Io { path: partial.to_path_buf(), action: "lock", source });
            }
        }
    }
    let hint = "wait for it to end, or write to another file";
    Err(Error::input(partial, None, "is being written by another process", hint))
}

/// Whether `path` still names this open file.
#[cfg(unix)]
fn is_named(file: &File, path: &Path) -> Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let ours = file.metadata().map_err(Error::io(path, "look at"))?;
    match std::fs::metadata(path) {
        Ok(named) => Ok((named.dev(), named.ino()) == (ours.dev(), ours.ino())),
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(source) => Err(Error::io(path, "look at")(source)),
    }
}

/// Elsewhere a name whose file is gone is told by its absence only.
#[cfg(not(unix))]
fn is_named(_: &File, path: &Path) -> Result<bool> {
    path.try_exists().map_err(Error::io(path, "look at"))
}

/// Makes a rename in the folder of `path` last.
fn sync_folder(path: &Path) -> Result<()> {
    if cfg!(unix) {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let file = File::open(folder).map_err(Error::io(folder, "open"))?;
        file.sync_all().map_err(Error::io(folder, "sync"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Archive, test_site};
    use super::*;

    /// A second writer of the same file is refused while the first lives, and the file it would replace is untouched.
    #[test]
    fn two_writers_are_one_too_many() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        std::fs::write(&path, b"old").unwrap();
        let first = Writer::create(&path).unwrap();
        for _ in 0..3 {
            let error = Writer::create(&path).unwrap_err().to_string();
            assert!(error.contains("is being written by another process"), "{error}");
        }
        drop(first);
        assert!(Writer::create(&path).is_ok());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    /// A left-over of 100 kB of another run leaves no byte in the new file, and the 4 threads of a race make one writer.
    #[test]
    fn left_overs_are_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        let (clean, _) = test_site::bytes();
        std::fs::write(folder.path().join("site.helio.partial"), vec![0xAA; 100_000]).unwrap();
        let writers = std::thread::scope(|scope| {
            let all: Vec<_> = (0..4).map(|_| scope.spawn(|| Writer::create(&path))).collect();
            all.into_iter().map(|t| t.join().unwrap()).collect::<Vec<_>>()
        });
        let mut winners: Vec<_> = writers.into_iter().filter_map(|w| w.ok()).collect();
        assert_eq!(winners.len(), 1);
        test_site::fill(winners.pop().unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), clean);
    }

    /// Each of 5 blocks reads back before the end; a second one of the same name, and one never written, are errors.
    #[test]
    fn blocks_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(&folder.path().join("site.helio")).unwrap();
        for tile in 0..5_u8 {
            writer.append(codec::encode(3, tile.into(), 1, 1, &[tile; 900], 9).unwrap()).unwrap();
        }
        for tile in 0..5_u8 {
            assert_eq!(writer.read_back(3, tile.into()).unwrap().bytes(), [tile; 900]);
        }
        assert!(writer.read_back(3, 5).is_err());
        let error = writer.append(codec::encode(3, 4, 1, 1, &[0], 9).unwrap()).unwrap_err();
        assert!(error.to_string().contains("hit/4 was written twice"), "{error}");
        assert_eq!(writer.layers()[0].raw_bytes, 4500);
    }

    /// A file that was not finished says so, and a manifest that does not fit leaves no file at all: 0 names in the folder.
    #[test]
    fn unfinished_files_say_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        let writer = Writer::create(&path).unwrap();
        writer.file.set_len(10_000).unwrap();
        let error = Archive::open(&folder.path().join("site.helio.partial")).unwrap_err().to_string();
        assert!(error.contains("was not finished"), "{error}");
        let mut wrong = test_site::manifest();
        wrong.receivers.count = 9;
        assert!(writer.finish(&wrong).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
