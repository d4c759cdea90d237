//! Regular files. In: a path. Out: the open file, never a link, a pipe or a device; bytes at a
//! position; whether a name still is that of an open file.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;

use heliotile_core::error::{Error, Result};

/// Opens a regular file. A link at the name is not followed, and a pipe or a device is refused.
#[cfg(unix)]
pub fn open_regular(path: &Path, mut how: OpenOptions) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let file = how.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK).open(path).map_err(|source| {
        match source.raw_os_error() == Some(libc::ELOOP) {
            true => io::Error::other("it is a link, which is not followed"),
            false => source,
        }
    })?;
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::other("it is a pipe or a device")),
    }
}

/// Opens a regular file.
#[cfg(not(unix))]
pub fn open_regular(path: &Path, how: OpenOptions) -> io::Result<File> {
    how.open(path)
}

/// Writes all `bytes` at a position of the file.
#[cfg(unix)]
pub fn write_all_at(file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, offset)
}

/// Writes all `bytes` at a position of the file.
#[cfg(windows)]
pub fn write_all_at(file: &File, mut bytes: &[u8], mut offset: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_write(file, bytes, offset)?;
        match bytes.split_at_checked(count) {
            Some((_, rest)) if count > 0 => bytes = rest,
            _ => return Err(io::ErrorKind::WriteZero.into()),
        }
        offset = offset.saturating_add(count as u64);
    }
    Ok(())
}

/// Returns true if `path` still names this open file.
#[cfg(unix)]
pub fn is_named(file: &File, path: &Path) -> Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let ours = file.metadata().map_err(Error::io(path, "look at"))?;
    match fs::metadata(path) {
        Ok(named) => Ok((named.dev(), named.ino()) == (ours.dev(), ours.ino())),
        Err(source) if source.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(source) => Err(Error::io(path, "look at")(source)),
    }
}

/// Returns true if `path` exists. Systems other than Unix cannot compare files.
#[cfg(not(unix))]
pub fn is_named(_: &File, path: &Path) -> Result<bool> {
    path.try_exists().map_err(Error::io(path, "look at"))
}
