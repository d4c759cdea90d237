//! Blocks on this machine's disk. In: blocks with the checksums of an archive's directory. Out: the
//! same bytes, checked again.
//!
//! A block's file is named by its content hash and its checksum. So no block can be taken for
//! another, whatever is at an address, and archives that share blocks share their files. Files
//! appear whole, and processes need no agreement: they write the same bytes under the same names,
//! and a missing file is fetched again. The least recently used files are removed first.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use heliotile_core::archive::format::{self, Entry, Slot};
use heliotile_core::error::{Error, Result};

use crate::stores::traffic;

/// Divisor of the size limit: old files are looked for each time that this share of it was written.
const LOOK_EVERY: u64 = 16;
/// Share of the size limit that stays when files are removed, percent.
const KEPT_PERCENT: u64 = 90;
/// Age from which an unfinished file of another process is removed.
const ABANDONED: Duration = Duration::from_secs(3600);
/// Largest directory and manifest that are kept, bytes.
const LONGEST_DIRECTORY: u64 = 256 << 20;

/// Prefix of the names of files that are being written.
const UNFINISHED: &str = ".heliotile-";

/// Bytes that this process has written to each folder since it last looked for old files there.
static WRITTEN: Mutex<BTreeMap<PathBuf, u64>> = Mutex::new(BTreeMap::new());

/// A folder of cached blocks.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    limit_bytes: u64,
}

impl Cache {
    /// Opens a cache and makes its folder. An error: the folder cannot be made.
    pub fn open(folder: &Path, limit_bytes: u64) -> Result<Self> {
        for part in ["blocks", "directories"] {
            fs::create_dir_all(folder.join(part)).map_err(Error::io(folder, "make the cache"))?;
        }
        Ok(Cache { folder: folder.to_path_buf(), limit_bytes })
    }

    /// Returns true if a block is in the cache. Its bytes are checked when it is read.
    pub fn has(&self, block: &Entry) -> bool {
        self.name_of(block).exists()
    }

    /// Returns the stored bytes of a block, or `None` if it is not there. A damaged file is
    /// removed.
    pub fn block(&self, block: &Entry) -> Option<Vec<u8>> {
        let right =
            |bytes: &[u8]| bytes.len() as u64 == u64::from(block.stored) && format::checksum(bytes) == block.checksum;
        read(&self.name_of(block), block.stored.into(), right)
    }

    /// Keeps the stored bytes of a block, which the caller has checked. Bytes that cannot be
    /// written are not kept.
    pub fn keep_block(&self, block: &Entry, bytes: &[u8]) {
        self.write(&self.name_of(block), bytes);
    }

    /// Returns directory and manifest of the archive that `slot` describes: the bytes from the
    /// directory on. `None` if they are not there or belong to another archive.
    pub fn directory(&self, slot: &Slot) -> Option<Vec<u8>> {
        let length = slot.committed.checked_sub(slot.directory_offset).filter(|&length| length <= LONGEST_DIRECTORY)?;
        read(&self.name_of_directory(slot), length, |bytes| has_root(bytes, slot))
    }

    /// Keeps directory and manifest of an archive, if they have the root that `slot` states.
    pub fn keep_directory(&self, slot: &Slot, bytes: &[u8]) {
        let name = self.name_of_directory(slot);
        if bytes.len() as u64 <= LONGEST_DIRECTORY && has_root(bytes, slot) && !name.exists() {
            self.write(&name, bytes);
        }
    }

    fn name_of(&self, block: &Entry) -> PathBuf {
        let content = format::hex(&block.content);
        let name = format!("{content}-{}", format::hex(&block.checksum));
        self.folder.join("blocks").join(content.get(..2).unwrap_or_default()).join(name)
    }

    fn name_of_directory(&self, slot: &Slot) -> PathBuf {
        // The offset is part of the name: the padding before the manifest depends on it.
        self.folder.join("directories").join(format!("{}-{}", format::hex(&slot.root), slot.directory_offset))
    }

    fn write(&self, name: &Path, bytes: &[u8]) {
        let Some(folder) = name.parent() else { return };
        let written = fs::create_dir_all(folder).and_then(|()| {
            let mut file = tempfile::Builder::new().prefix(UNFINISHED).tempfile_in(folder)?;
            file.write_all(bytes)?;
            file.persist(name).map(drop).map_err(|error| error.error)
        });
        if written.is_err() {
            return;
        }
        let length = bytes.len() as u64;
        if self.is_time_to_look(length) {
            self.clear_old();
        }
    }

    /// Counts written bytes and returns true if old files are to be looked for; true at the first
    /// call for a folder.
    fn is_time_to_look(&self, length: u64) -> bool {
        let mut all = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        let written = all.entry(self.folder.clone()).or_insert(u64::MAX / 2);
        *written = written.saturating_add(length);
        let is_time = *written > self.limit_bytes / LOOK_EVERY;
        if is_time {
            *written = 0;
        }
        is_time
    }

    /// Removes the least recently used files until the rest is below the limit.
    fn clear_old(&self) {
        let now = SystemTime::now();
        let mut files = Vec::new();
        for folder in folders_of(&self.folder) {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let Ok(about) = entry.metadata() else { continue };
                let used = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                let name = entry.file_name().to_string_lossy().into_owned();
                match (about.is_file() && is_own(&name), name.starts_with(UNFINISHED)) {
                    (false, _) => {}
                    (true, true) if now.duration_since(used).is_ok_and(|age| age > ABANDONED) => {
                        drop(fs::remove_file(entry.path()))
                    }
                    (true, true) => {}
                    (true, false) => files.push((used, about.len(), entry.path())),
                }
            }
        }
        let mut all: u64 = files.iter().map(|file| file.1).sum();
        if all <= self.limit_bytes {
            return;
        }
        files.sort_unstable();
        for (_, length, path) in files {
            if all <= self.limit_bytes / 100 * KEPT_PERCENT {
                break;
            }
            // Another process may have removed the file first.
            if fs::remove_file(path).is_ok() {
                all = all.saturating_sub(length);
            }
        }
    }
}

/// Returns true if a file has a name that caches give: of a block, of a directory, or of an
/// unfinished one. Other files are not removed.
fn is_own(name: &str) -> bool {
    let is_hex = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    let named = |(hash, rest): (&str, &str)| hash.len() >= 32 && is_hex(hash) && is_hex(rest);
    name.starts_with(UNFINISHED) || name.split_once('-').is_some_and(named)
}

/// Returns the folders that hold the files of the cache.
fn folders_of(folder: &Path) -> Vec<PathBuf> {
    let of_blocks = fs::read_dir(folder.join("blocks")).into_iter().flatten().flatten().map(|entry| entry.path());
    of_blocks.filter(|path| path.is_dir()).chain([folder.join("directories")]).collect()
}

/// Reads a file that has `length` bytes and passes the test `right`, and marks it as used. A file
/// that fails is removed.
fn read(name: &Path, length: u64, right: impl Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
    let mut file = File::open(name).ok()?;
    let mut bytes = Vec::new();
    let whole = Read::by_ref(&mut file).take(length.saturating_add(1)).read_to_end(&mut bytes).is_ok();
    if !whole || bytes.len() as u64 != length || !right(&bytes) {
        let _ = fs::remove_file(name);
        return None;
    }
    // Modification times record the last use; where they cannot be set, they record when the file
    // was written.
    let _ = File::options().append(true).open(name).and_then(|file| file.set_modified(SystemTime::now()));
    traffic::cached(bytes.len());
    Some(bytes)
}

/// Returns true if `bytes`, which begin at the directory, have the root that `slot` states.
pub(crate) fn has_root(bytes: &[u8], slot: &Slot) -> bool {
    let part = |start: u64, length: u64| {
        let start = usize::try_from(start).ok()?;
        bytes.get(start..start.checked_add(usize::try_from(length).ok()?)?)
    };
    let directory = part(0, slot.directory_length);
    let manifest =
        slot.manifest_offset.checked_sub(slot.directory_offset).and_then(|at| part(at, slot.manifest_length));
    directory.zip(manifest).is_some_and(|(directory, manifest)| format::root_hash(directory, manifest) == slot.root)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(bytes: &[u8]) -> Entry {
        let zero = Entry::decode(&[0; 80]).expect("an entry");
        Entry { stored: bytes.len() as u32, checksum: format::checksum(bytes), content: *blake3_of(bytes), ..zero }
    }

    fn blake3_of(bytes: &[u8]) -> Box<[u8; 32]> {
        Box::new(format::content_id(format::RECEIVERS, 1, bytes))
    }

    fn files(folder: &Path) -> usize {
        folders_of(folder).iter().map(|folder| fs::read_dir(folder).expect("a folder").count()).sum()
    }

    /// A block is read back. After each of 3 kinds of damage (a bit, a cut, a byte behind) it is
    /// not, and its file is gone. Another block of the same content, packed otherwise, is another
    /// file.
    #[test]
    fn a_damaged_block_is_never_served() {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = Cache::open(folder.path(), 1 << 20).expect("a cache");
        let (bytes, entry) = (vec![7; 500], block(&[7; 500]));
        assert_eq!((cache.has(&entry), cache.block(&entry)), (false, None));
        for damage in [[vec![6], vec![7; 499]].concat(), vec![7; 499], vec![7; 501]] {
            cache.keep_block(&entry, &bytes);
            assert_eq!((cache.has(&entry), cache.block(&entry)), (true, Some(bytes.clone())));
            fs::write(cache.name_of(&entry), damage).expect("written");
            assert_eq!((cache.block(&entry), cache.has(&entry)), (None, false));
        }
        cache.keep_block(&entry, &bytes);
        let packed = Entry { checksum: [1; 8], stored: 3, ..entry };
        assert_eq!((cache.block(&packed), files(folder.path())), (None, 1));
    }

    /// After 40 blocks of 1000 bytes in a cache of 20,000 bytes, 17 to 24 files stay, and the block
    /// that is read between all others is among them. A file that a process left unfinished long
    /// ago is removed, a new one stays, and so do files of other programs.
    #[test]
    fn the_least_recently_used_blocks_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = Cache::open(folder.path(), 20_000).expect("a cache");
        let bytes = |i: u8| [vec![i], vec![0; 999]].concat();
        cache.keep_block(&block(&bytes(0)), &bytes(0));
        let left = folder.path().join("directories").join(".heliotile-left");
        File::create(&left).and_then(|file| file.set_modified(SystemTime::now() - 2 * ABANDONED)).expect("a file");
        fs::write(folder.path().join("directories").join(".heliotile-now"), b"x").expect("written");
        let theirs = [folder.path().join("directories/thesis.docx"), folder.path().join("blocks/ab/model.bin")];
        fs::create_dir_all(folder.path().join("blocks/ab")).expect("a folder");
        theirs.iter().for_each(|file| fs::write(file, [0; 9000]).expect("written"));
        for i in 1..40 {
            std::thread::sleep(Duration::from_millis(2));
            cache.keep_block(&block(&bytes(i)), &bytes(i));
            assert_eq!(cache.block(&block(&bytes(0))), Some(bytes(0)), "{i}");
        }
        let stay = files(folder.path());
        assert!((17..=24).contains(&stay) && !left.exists(), "{stay}");
        assert!(theirs.iter().all(|file| file.is_file()));
    }

    /// 4 threads that write and read the same 50 blocks in a cache that holds 20 of them get right
    /// bytes or none: they get bytes in 100 to 4,000 of 4,000 reads.
    #[test]
    fn four_threads_get_right_bytes_or_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let bytes = |i: u8| vec![i; 1000];
        let read: usize = std::thread::scope(|scope| {
            let work = |t: usize| {
                let cache = Cache::open(folder.path(), 20_000).expect("a cache");
                (0..1000)
                    .filter(|n| {
                        let i = (n * 7 + t * 13) as u8 % 50;
                        let found = cache.block(&block(&bytes(i)));
                        assert!(found.as_ref().is_none_or(|found| *found == bytes(i)));
                        cache.keep_block(&block(&bytes(i)), &bytes(i));
                        found.is_some()
                    })
                    .count()
            };
            let threads: Vec<_> = (0..4).map(|t| scope.spawn(move || work(t))).collect();
            threads.into_iter().map(|thread| thread.join().expect("a thread")).sum()
        });
        assert!((100..4000).contains(&read), "{read}");
    }
}
