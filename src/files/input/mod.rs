//! Files as bytes, for all readers of the program. In: a path. Out: the bytes, unpacked if they are
//! gzip or a zip of one file; for a path that leads nowhere, the part of it that exists and similar
//! names.
//!
//! The first bytes decide whether a file is packed, not its name: programs that fetch files unpack
//! some and keep the name, or the reverse.

pub mod budget;
mod gzip;
pub mod members;
mod missing;
pub mod weather;
mod zip;

use std::fs;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

pub use self::zip::ShapefileParts;
use heliotile_core::error::{Error, Problem, Result};

/// Reads a file. At most 4 GiB are unpacked, and beyond 256 MiB at most 200 times the packed size.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_as(path, "read")
}

/// Reads a file as [`read`] does; `action` names the action in errors, as in [`Error::io`].
pub fn read_as(path: &Path, action: &'static str) -> Result<Vec<u8>> {
    read_named(path, action).map(|named| named.bytes)
}

/// Unpacked bytes of a file, and the name of the file in its zip.
pub struct NamedBytes {
    /// Name in the zip; `None` if the file is no zip.
    pub name: Option<String>,
    /// Unpacked bytes.
    pub bytes: Vec<u8>,
}

/// Reads a file as [`read_as`] does, with the name of the file in a zip.
pub fn read_named(path: &Path, action: &'static str) -> Result<NamedBytes> {
    let bytes = fs::read(path).map_err(|source| refused(path, action, source))?;
    let packed = bytes.len() as u64;
    let bytes = gzip::unpack(bytes, path)?;
    Ok(match zip::single(&bytes, packed, path)? {
        Some(single) => NamedBytes { name: Some(single.name), bytes: single.bytes },
        None => NamedBytes { name: None, bytes },
    })
}

/// Reads the shapefile in a zip; `None` if it holds none.
pub fn zipped_shapefile(path: &Path) -> Result<Option<ShapefileParts>> {
    zip::shapefile(&fs::read(path).map_err(|source| refused(path, "read", source))?, path)
}

/// Opens a file to be read piece by piece, unpacked.
pub fn open(path: &Path) -> Result<Box<dyn Read>> {
    let file = File::open(path).map_err(|source| refused(path, "read", source))?;
    gzip::unpacked(file, path)
}

/// Checks that a path leads somewhere; the error names the part of it that exists and names similar
/// to the missing one.
pub fn check(path: &Path) -> Result<()> {
    fs::metadata(path).map(drop).map_err(|source| refused(path, "read", source))
}

/// Returns the path of a file, or of the `.gz` file beside it if only that exists.
pub fn plain_or_packed(path: PathBuf) -> PathBuf {
    let packed = || {
        let mut name = path.clone().into_os_string();
        name.push(".gz");
        PathBuf::from(name)
    };
    if path.is_file() { path } else { Some(packed()).filter(|packed| packed.is_file()).unwrap_or(path) }
}

/// Returns the ending of a file name in lower case and without `.gz` or `.zip`: `json` for
/// `Town.City.JSON.gz`; empty for a name without a dot.
pub fn ending(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    without_packing(&name).rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_owned())
}

/// Returns a name without the `.gz` or `.zip` at its end.
pub fn without_packing(name: &str) -> &str {
    let packed = [".gz", ".zip"].into_iter().find(|ending| {
        let start = name.len().checked_sub(ending.len());
        start.and_then(|start| name.get(start..)).is_some_and(|end| end.eq_ignore_ascii_case(ending))
    });
    packed.and_then(|ending| name.get(..name.len() - ending.len())).unwrap_or(name)
}

fn refused(path: &Path, action: &'static str, source: std::io::Error) -> Error {
    let source = match source.kind() {
        ErrorKind::IsADirectory => {
            let error = Error::input(path, None, "is a folder, and one file is read here", "give a file in it");
            return error.because(Problem::other_kind("a folder"));
        }
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
    fn packed_names_end_as_their_plain_files() {
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
