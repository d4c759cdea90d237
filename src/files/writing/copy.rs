//! Copying of files. In: two paths. Out: a complete copy, or none.

use std::fs::File;
use std::io;
use std::path::Path;

use heliotile_core::error::{Error, Result};

/// Copies bytes and permissions. The copy has a temporary name until it is on the disk: a reader of
/// `to` finds the old or the new file, at any time and after a crash.
pub fn copy_whole(from: &Path, to: &Path) -> Result<()> {
    let folder = folder_of(to);
    let partial = tempfile::NamedTempFile::new_in(folder).map_err(Error::io(folder, "create a file in"))?;
    let mut source = File::open(from).map_err(Error::io(from, "open"))?;
    io::copy(&mut source, &mut partial.as_file()).map_err(Error::io(to, "copy to"))?;
    let about = source.metadata().map_err(Error::io(from, "look at"))?;
    partial.as_file().set_permissions(about.permissions()).map_err(Error::io(to, "set the permissions of"))?;
    partial.as_file().sync_all().map_err(Error::io(to, "sync"))?;
    partial.persist(to).map_err(|e| Error::io(to, "rename a copy to")(e.error))?;
    Ok(())
}

/// Returns the folder of a file. A temporary file in that folder can be renamed to the file.
pub fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A copy has the bytes and the permissions of its source, also if it replaces a file of 3
    /// bytes. A missing source leaves that file alone, and 0 other files.
    #[test]
    fn copies_are_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let [from, to] = ["from", "to"].map(|name| folder.path().join(name));
        std::fs::write(&to, b"old").expect("written");
        assert!(copy_whole(&from, &to).is_err());
        assert_eq!(std::fs::read(&to).expect("a file"), b"old");
        std::fs::write(&from, [7; 100_000]).expect("written");
        copy_whole(&from, &to).expect("a copy");
        assert!(std::fs::read(&to).expect("a file") == [7; 100_000]);
        let permissions = [&from, &to].map(|path| std::fs::metadata(path).expect("a file").permissions());
        assert_eq!(permissions[0], permissions[1]);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2);
    }
}
