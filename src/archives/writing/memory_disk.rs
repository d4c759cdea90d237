//! Disk in memory for tests. It knows what would survive the loss of power: all synced bytes, and
//! any part of the rest.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

use crate::writing::disk::{Disk, DiskFile};
use heliotile_core::error::{Error, Result};

/// Size of a sector, bytes. Sectors are written completely or not at all.
const SECTOR: u64 = 512;

/// Random numbers (splitmix64; Steele, Lea and Flood 2014) that are the same in every run.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % limit
    }
}

/// Event at an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The operation fails. After a failed sync the unsynced bytes are forgotten, as operating
    /// systems do.
    Fail,
    /// The operation is the last one, and later ones fail. Its effect is not synced.
    Stop,
}

/// Bytes of a file, and its unsynced changes.
#[derive(Clone, Debug, Default)]
struct File {
    bytes: Vec<u8>,
    durable: Vec<u8>,
    changes: Vec<Change>,
}

#[derive(Clone, Debug)]
enum Change {
    Write(u64, Vec<u8>),
    Length(u64),
}

#[derive(Clone, Debug)]
enum Naming {
    Is(PathBuf, usize),
    Rename(PathBuf, PathBuf),
    Remove(PathBuf),
}

type Names = BTreeMap<PathBuf, usize>;

#[derive(Debug, Default)]
struct State {
    files: Vec<File>,
    names: Names,
    durable_names: Names,
    namings: Vec<Naming>,
    operations: u64,
    event: Option<(u64, Event)>,
    stopped: bool,
}

#[derive(Clone, Debug, Default)]
pub struct MemoryDisk(Arc<Mutex<State>>);

#[derive(Debug)]
struct Open(MemoryDisk, usize);

fn put(bytes: &mut Vec<u8>, offset: u64, new: &[u8]) {
    let (start, end) = (offset as usize, offset as usize + new.len());
    bytes.resize(bytes.len().max(end), 0);
    bytes[start..end].copy_from_slice(new);
}

fn rename(names: &mut Names, naming: &Naming) {
    match naming {
        Naming::Is(path, file) => drop(names.insert(path.clone(), *file)),
        Naming::Remove(path) => drop(names.remove(path)),
        Naming::Rename(from, to) => {
            if let Some(file) = names.remove(from) {
                names.insert(to.clone(), file);
            }
        }
    }
}

impl File {
    /// Returns the file after the loss of power. Of unsynced sectors and lengths, `percent` are
    /// kept.
    fn survivor(&self, percent: u64, random: &mut Random) -> File {
        let mut bytes = self.durable.clone();
        let mut kept = || percent == 100 || random.below(100) < percent;
        for change in &self.changes {
            match change {
                Change::Length(length) if kept() => bytes.resize(*length as usize, 0),
                Change::Length(_) => {}
                Change::Write(offset, new) => {
                    let end = offset + new.len() as u64;
                    let mut start = *offset;
                    while start < end {
                        let next = (start / SECTOR * SECTOR + SECTOR).min(end);
                        if kept() {
                            put(&mut bytes, start, &new[(start - offset) as usize..(next - offset) as usize]);
                        }
                        start = next;
                    }
                    // The length may be written without the bytes, which leaves a hole of zeros.
                    if kept() {
                        put(&mut bytes, end, &[]);
                    }
                }
            }
        }
        File { durable: bytes.clone(), bytes, changes: Vec::new() }
    }
}

impl State {
    /// Counts an operation, and returns its error if it fails. A stop lets the effect happen,
    /// unsynced, before the error: see `after`.
    fn before(&mut self) -> io::Result<()> {
        if self.stopped {
            return Err(io::Error::other("stopped"));
        }
        self.operations += 1;
        match self.event {
            Some((at, Event::Fail)) if at == self.operations => Err(ErrorKind::StorageFull.into()),
            _ => Ok(()),
        }
    }

    fn after(&mut self) -> io::Result<()> {
        if self.event == Some((self.operations, Event::Stop)) {
            self.stopped = true;
            return Err(io::Error::other("stopped"));
        }
        Ok(())
    }

    fn name(&mut self, naming: Naming) {
        rename(&mut self.names, &naming);
        self.namings.push(naming);
    }

    fn make(&mut self, path: &Path) -> usize {
        self.files.push(File::default());
        self.name(Naming::Is(path.to_path_buf(), self.files.len() - 1));
        self.files.len() - 1
    }
}

impl MemoryDisk {
    /// Creates a disk with one synced file.
    pub fn with(path: &Path, bytes: &[u8]) -> Self {
        let disk = MemoryDisk::default();
        disk.put(path, bytes);
        disk
    }

    /// Adds a synced file.
    pub fn put(&self, path: &Path, bytes: &[u8]) {
        let mut state = self.state();
        state.files.push(File { bytes: bytes.to_vec(), durable: bytes.to_vec(), changes: Vec::new() });
        let file = state.files.len() - 1;
        state.names.insert(path.to_path_buf(), file);
        state.durable_names.insert(path.to_path_buf(), file);
    }

    pub fn get(&self, path: &Path) -> Option<Vec<u8>> {
        let state = self.state();
        state.names.get(path).map(|&file| state.files[file].bytes.clone())
    }

    pub fn names(&self) -> Vec<PathBuf> {
        self.state().names.keys().cloned().collect()
    }

    pub fn operations(&self) -> u64 {
        self.state().operations
    }

    /// Sets the event of the n-th operation from now, and ends the event before.
    pub fn plan(&self, event: Option<(u64, Event)>) {
        let mut state = self.state();
        (state.operations, state.event, state.stopped) = (0, event, false);
    }

    /// Returns the disk after the loss of power.
    pub fn lose_power(&self, random: &mut Random) -> Self {
        let percent = [0, 10, 50, 90, 100][random.below(5) as usize];
        let state = self.state();
        let mut names = state.durable_names.clone();
        state.namings.iter().filter(|_| random.below(100) < percent).for_each(|naming| rename(&mut names, naming));
        let files = state.files.iter().map(|file| file.survivor(percent, random)).collect();
        let state = State { files, durable_names: names.clone(), names, ..State::default() };
        MemoryDisk(Arc::new(Mutex::new(state)))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap()
    }

    fn open_file(&self, file: usize) -> Box<dyn DiskFile> {
        Box::new(Open(self.clone(), file))
    }
}

impl Disk for MemoryDisk {
    fn lock(&self, path: &Path) -> Result<Box<dyn DiskFile>> {
        let mut state = self.state();
        state.before().map_err(Error::io(path, "create"))?;
        let file = state.names.get(path).copied().unwrap_or_else(|| state.make(path));
        state.after().map_err(Error::io(path, "create"))?;
        Ok(self.open_file(file))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        let mut state = self.state();
        state.before()?;
        let file = state.names.get(path).copied().ok_or(ErrorKind::NotFound)?;
        state.after()?;
        Ok(self.open_file(file))
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        let mut state = self.state();
        state.before()?;
        let file = match state.names.get(path).copied() {
            Some(file) => {
                state.files[file].bytes.clear();
                state.files[file].changes.push(Change::Length(0));
                file
            }
            None => state.make(path),
        };
        state.after()?;
        Ok(self.open_file(file))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.before()?;
        state.name(Naming::Rename(from.to_path_buf(), to.to_path_buf()));
        state.after()
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.before()?;
        state.names.get(path).ok_or(ErrorKind::NotFound)?;
        state.name(Naming::Remove(path.to_path_buf()));
        state.after()
    }

    fn sync_folder(&self, _: &Path) -> io::Result<()> {
        let mut state = self.state();
        let state = &mut *state;
        let failed = state.before();
        if failed.is_ok() {
            state.after()?;
            state.durable_names = state.names.clone();
            state.namings.clear();
        }
        failed
    }
}

impl DiskFile for Open {
    fn length(&self) -> io::Result<u64> {
        let mut state = self.0.state();
        state.before()?;
        state.after()?;
        Ok(state.files[self.1].bytes.len() as u64)
    }

    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        let mut state = self.0.state();
        state.before()?;
        state.after()?;
        let found = state.files[self.1].bytes.get(offset as usize..).and_then(|rest| rest.get(..bytes.len()));
        bytes.copy_from_slice(found.ok_or(ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn write_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let mut state = self.0.state();
        let failed = state.before();
        if state.stopped {
            return failed;
        }
        // A full disk takes the start of the bytes.
        let taken = if failed.is_ok() { bytes } else { &bytes[..bytes.len() / 2] };
        let file = &mut state.files[self.1];
        put(&mut file.bytes, offset, taken);
        file.changes.push(Change::Write(offset, taken.to_vec()));
        failed?;
        state.after()
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        let mut state = self.0.state();
        state.before()?;
        let file = &mut state.files[self.1];
        file.bytes.resize(length as usize, 0);
        file.changes.push(Change::Length(length));
        state.after()
    }

    fn sync(&self) -> io::Result<()> {
        let mut state = self.0.state();
        let failed = state.before();
        if state.stopped {
            return failed;
        }
        if failed.is_err() {
            // The unsynced changes are forgotten, and a later sync will not write them.
            state.files[self.1].changes.clear();
            return failed;
        }
        state.after()?;
        let file = &mut state.files[self.1];
        // Not `bytes`, because changes that a failed sync has forgotten stay lost.
        file.durable = file.survivor(100, &mut Random(0)).durable;
        file.changes.clear();
        Ok(())
    }
}
