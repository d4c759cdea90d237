//! Files as bytes, for all readers of the program. In: a path. Out: its bytes, unpacked where they are gzip or a zip of one file, or what of the
//! path is there and what is like it.
//!
//! What is packed shows in the first bytes and not in the name: programs that fetch files unpack some and keep the name, or the reverse.

mod gzip;
pub(crate) mod members;
mod missing;
#[cfg(test)]
mod packed_tests;
pub mod weather;
mod zip;

use std::fs;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

pub(crate) use self::zip::ShapefileParts;
use heliotile_core::error::{Error, Result};

/// The bytes of a file: at most 4 GiB unpacked, and beyond 256 MiB 200 times as many as packed.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_as(path, "read")
}

/// The same for a part of another file; `action` says what is done with it, as in [`Error::io`].
pub(crate) fn read_as(path: &Path, action: &'static str) -> Result<Vec<u8>> {
    read_named(path, action).map(|named| named.bytes)
}

/// The plain bytes of a file, and the name that a zip has for it.
pub(crate) struct NamedBytes {
    /// In a zip.
    pub name: Option<String>,
    pub bytes: Vec<u8>,
}

/// The same as [`read_as`], with the name of what is in a zip.
pub(crate) fn read_named(path: &Path, action: &'static str) -> Result<NamedBytes> {
    let bytes = gzip::unpack(fs::read(path).map_err(|source| refused(path, action, source))?, path)?;
    Ok(match zip::single(&bytes, path)? {
        Some(single) => NamedBytes { name: Some(single.name), bytes: single.bytes },
        None => NamedBytes { name: None, bytes },
    })
}

/// The shapefile in a zip; `None` if it holds none.
pub(crate) fn zipped_shapefile(path: &Path) -> Result<Option<ShapefileParts>> {
    zip::shapefile(&fs::read(path).map_err(|source| refused(path, "read", source))?, path)
}

/// The same, piece by piece.
pub(crate) fn open(path: &Path) -> Result<Box<dyn Read>> {
    let file = File::open(path).map_err(|source| refused(path, "read", source))?;
    gzip::unpacked(file, path)
}

/// Refuses a path that leads nowhere, with what of it is there and names that are like the missing one.
pub fn check(path: &Path) -> Result<()> {
    fs::metadata(path).map(drop).map_err(|source| refused(path, "read", source))
}

/// A file, the packed one where only that is there.
pub(crate) fn plain_or_packed(path: PathBuf) -> PathBuf {
    let packed = || {
        let mut name = path.clone().into_os_string();
        name.push(".gz");
        PathBuf::from(name)
    };
    if path.is_file() { path } else { Some(packed()).filter(|packed| packed.is_file()).unwrap_or(path) }
}

/// What the name of a file ends with, in lower case and without `.gz` or `.zip`: `json` of `Town.City.JSON.gz`; empty for a name without a
/// dot.
pub fn ending(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    without_packing(&name).rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_owned())
}

/// A name without the `.gz` or `.zip` at its end.
pub(crate) fn without_packing(name: &str) -> &str {
    let packed = [".gz", ".zip"].into_iter().find(|ending| {
        let start = name.len().checked_sub(ending.len());
        start.and_then(|start| name.get(start..)).is_some_and(|end| end.eq_ignore_ascii_case(ending))
    });
    packed.and_then(|ending| name.get(..name.len() - ending.len())).unwrap_or(name)
}

fn refused(path: &Path, action: &'static str, source: std::io::Error) -> Error {
    let source = match source.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => std::io::Error::new(source.kind(), missing::explain(path)),
        _ => source,
    };
    Error::io(path, action)(source)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight names end as their plain files do.
    #[test]
    fn endings() {
        for (name, expected) in [
            ("town.city.json", "json"),
            ("Town.City.JSON.GZ", "json"),
            ("a/b.c/hills.tif.gz", "tif"),
            ("b.c/hills", ""),
            ("hills.gz", ""),
            ("town.city.json.zip", "json"),
            ("\u{20ac}.zip", ""),
            ("", ""),
        ] {
            assert_eq!(ending(Path::new(name)), expected, "{name}");
        }
    }
}
