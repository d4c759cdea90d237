//! File operations of a writer. In: paths and bytes. Out: files on the disk, and errors that name
//! path and action. They are behind a trait so that tests can make any of them fail, and cut the
//! power between any two.

use std::borrow::Borrow;
use std::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;
use std::sync::Arc;

use heliotile_core::archive::read_at::read_exact_at;
use heliotile_core::error::{Error, Problem, Result};

use heliotile_files::writing::file_lock::FileLock;
use heliotile_files::writing::regular::{is_named, open_regular, write_all_at};

/// File system of a writer.
pub trait Disk: Debug + Send + Sync {
    /// Opens a file, or creates an empty one, and locks it for this writer.
    fn lock(&self, path: &Path) -> Result<Box<dyn DiskFile>>;
    /// Opens a file that exists.
    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>>;
    /// Creates an empty file, and truncates one that exists.
    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>>;
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;
    fn remove(&self, path: &Path) -> io::Result<()>;
    /// Syncs the folder of `path`, so that created, renamed and removed names survive a loss of
    /// power.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;
}

/// Open file.
pub trait DiskFile: Debug + Send + Sync {
    fn length(&self) -> io::Result<u64>;
    /// Fills `bytes` from the file.
    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()>;
    /// Writes all `bytes`. After an error some of them may be in the file.
    fn write_at(&self, bytes: &[u8], offset: u64) -> io::Result<()>;
    fn set_len(&self, length: u64) -> io::Result<()>;
    /// Returns when bytes and length would survive the loss of power.
    fn sync(&self) -> io::Result<()>;
}

/// Open file whose errors name the action and the path.
#[derive(Debug)]
pub struct Handle {
    path: Arc<Path>,
    file: Box<dyn DiskFile>,
}

impl Handle {
    pub fn new(path: &Path, file: Box<dyn DiskFile>) -> Self {
        Handle { path: Arc::from(path), file }
    }

    pub fn path(&self) -> &Arc<Path> {
        &self.path
    }

    pub fn length(&self) -> Result<u64> {
        self.file.length().map_err(Error::io(&self.path, "read the length of"))
    }

    /// Reads `length` bytes at `offset`. The caller has compared `length` with a limit.
    pub fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>> {
        let mut bytes = vec![0; length];
        self.file.read_at(&mut bytes, offset).map_err(Error::io(&self.path, "read"))?;
        Ok(bytes)
    }

    pub fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        self.file.write_at(bytes, offset).map_err(Error::io(&self.path, "write"))
    }

    pub fn set_len(&self, length: u64) -> Result<()> {
        self.file.set_len(length).map_err(Error::io(&self.path, "set the length of"))
    }

    pub fn sync(&self) -> Result<()> {
        self.file.sync().map_err(Error::io(&self.path, "sync"))
    }
}

/// File system of the operating system.
#[derive(Debug)]
pub struct SystemDisk;

impl Disk for SystemDisk {
    /// Opens and locks a file. Between the two, the process that held the lock may have renamed or
    /// removed the file, so the name must still refer to the locked file; if not, both are tried
    /// again.
    fn lock(&self, path: &Path) -> Result<Box<dyn DiskFile>> {
        for _ in 0..16 {
            let how = OpenOptions::new().read(true).write(true).create(true).truncate(false).to_owned();
            let file = open_regular(path, how).map_err(Error::io(path, "create"))?;
            match FileLock::try_new(file).map_err(Error::io(path, "lock"))? {
                Some(file) if is_named(file.borrow(), path)? => return Ok(Box::new(file)),
                Some(_) => {}
                None => break,
            }
        }
        let hint = "wait for it to end, or write to another file";
        Err(Error::input(path, None, "is being written by another process", hint).because(Problem::Busy))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        Ok(Box::new(open_regular(path, OpenOptions::new().read(true).write(true).to_owned())?))
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        let how = OpenOptions::new().read(true).write(true).create(true).truncate(true).to_owned();
        Ok(Box::new(open_regular(path, how)?))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        // Windows does not open folders as files.
        if cfg!(unix) {
            let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
            File::open(folder)?.sync_all()?;
        }
        Ok(())
    }
}

/// Plain or locked file.
impl<F: Borrow<File> + Debug + Send + Sync> DiskFile for F {
    fn length(&self) -> io::Result<u64> {
        Ok(self.borrow().metadata()?.len())
    }

    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        read_exact_at(self.borrow(), bytes, offset)
    }

    fn write_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        write_all_at(self.borrow(), bytes, offset)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.borrow().set_len(length)
    }

    fn sync(&self) -> io::Result<()> {
        self.borrow().sync_all()
    }
}
