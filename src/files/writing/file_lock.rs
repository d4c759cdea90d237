//! Lock of a file that one process writes. In: an open file. Out: the file, locked until it is
//! dropped.

use std::borrow::Borrow;
use std::fs::{File, TryLockError};
use std::io;

/// Open file that no other process can lock before it is dropped.
///
/// Closing a file only ends its lock when every copy of the handle is closed, and a child process
/// that is starting holds copies of all handles for a moment. The lock is therefore released before
/// the file is closed.
#[derive(Debug)]
pub struct FileLock(File);

impl FileLock {
    /// Locks `file`, or returns `None` if another process holds its lock.
    pub fn try_new(file: File) -> io::Result<Option<FileLock>> {
        match file.try_lock() {
            Ok(()) => Ok(Some(FileLock(file))),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(source)) => Err(source),
        }
    }
}

impl Borrow<File> for FileLock {
    fn borrow(&self) -> &File {
        &self.0
    }
}

impl Drop for FileLock {
    /// Unlocks the file. After an error, closing still unlocks it.
    fn drop(&mut self) {
        let _ = self.0.unlock();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lock ends with its owner, also while a copy of the handle is open, as in a child process
    /// that is starting.
    #[test]
    fn a_lock_ends_while_copies_of_the_handle_are_open() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let path = folder.path().join("lock");
        let lock = || FileLock::try_new(File::create(&path).expect("a file")).expect("a lock or none");
        let held = lock().expect("a lock");
        let copy = held.0.try_clone().expect("a copy");
        assert!(lock().is_none(), "locked twice");
        drop(held);
        assert!(lock().is_some(), "still locked by a copy");
        drop(copy);
    }
}
