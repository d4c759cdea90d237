//! A file copied whole or not at all.

use std::fs::File;
use std::io;
use std::path::Path;

use heliotile_core::error::{Error, Result};

/// Copies bytes and permissions, under a name of its own until all is on the disk: whoever reads `to` meanwhile, or after a crash,
/// finds what was there or what was copied.
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

/// The folder of a file: temporary ones beside it can be renamed to it.
pub fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A copy has the bytes and the permissions of its source, also where 3 bytes were; a source that is not there leaves those alone
    /// and 0 other files.
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
