//! Zip files. In: bytes that may be a zip of one file. Out: that file with its name.

use std::fmt::Display;
use std::io::{Cursor, Read};
use std::path::Path;

use heliotile_core::error::{Error, Result};
use heliotile_core::text::listed;
use zip::{CompressionMethod, ZipArchive};

use super::budget::most;
use crate::text::excerpt;

pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// Most files of a zip that a message names.
const NAMED: usize = 5;

const UNPACK: &str = "unpack it and give one of its files";

/// The only file of a zip.
pub(super) struct Single {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// Unpacks a zip of one file; `None` if the bytes are no zip. Folders and files that macOS adds do
/// not count. `packed` is the length of the file on disk, which the limit is taken from: a zip in a
/// gzip must not multiply the limits of both.
pub(super) fn single(bytes: &[u8], packed: u64, file: &Path) -> Result<Option<Single>> {
    if !bytes.starts_with(MAGIC) {
        return Ok(None);
    }
    let refuse = |what: String| Error::input(file, None, what, UNPACK);
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(damage_of(file))?;
    let all: Vec<(usize, String)> = (0..)
        .zip(zip.file_names())
        .map(|(number, name)| name.map(|name| (number, name.into_owned())))
        .collect::<std::result::Result<_, _>>()
        .map_err(damage_of(file))?;
    if all.iter().any(|(_, name)| name == "[Content_Types].xml") {
        let what = "is a workbook or document of an office program";
        return Err(Error::input(file, None, what, "save the sheet as CSV, and give that"));
    }
    let files: Vec<(usize, String)> = all.into_iter().filter(|(_, name)| is_file(name)).collect();
    let [(number, name)] = files.as_slice() else {
        let some = files.iter().take(NAMED).map(|(_, name)| format!("`{}`", excerpt(name.as_bytes())));
        return Err(refuse(format!("the zip holds {} files, not one: {}", files.len(), listed(some, files.len()))));
    };
    let shown = excerpt(name.as_bytes());
    // The raw entry shows the packing method before anything is unpacked.
    let entry = zip.by_index_raw(*number).map_err(damage_of(file))?;
    let known = [CompressionMethod::Stored, CompressionMethod::Deflated].contains(&entry.compression());
    let (most, encrypted) = (most(entry.compressed_size().min(packed)), entry.encrypted());
    drop(entry);
    if encrypted || !known {
        return Err(refuse(format!("`{shown}` in the zip is encrypted or packed by another method than Deflate")));
    }
    let entry = zip.by_index(*number).map_err(damage_of(file))?;
    Ok(Some(Single { name: name.clone(), bytes: unpacked(entry, name, most, file)? }))
}

/// Returns a function from an error of the library to that of a damaged zip.
fn damage_of<E: Display>(file: &Path) -> impl Fn(E) -> Error {
    move |error| Error::input(file, None, format!("the zip is damaged or cut off: {error}"), UNPACK)
}

/// Returns the bytes of an entry; more than `most` are refused.
fn unpacked(entry: impl Read, name: &str, most: u64, file: &Path) -> Result<Vec<u8>> {
    let mut plain = Vec::new();
    entry.take(most + 1).read_to_end(&mut plain).map_err(damage_of(file))?;
    if plain.len() as u64 > most {
        let what = format!("`{}` in the zip unpacks to more than {most} bytes", excerpt(name.as_bytes()));
        return Err(Error::input(file, None, what, UNPACK));
    }
    Ok(plain)
}

/// Parts of a shapefile.
pub struct ShapefileParts {
    /// Bytes of the `.shp`.
    pub shapes: Vec<u8>,
    /// Bytes of the `.dbf`.
    pub table: Option<Vec<u8>>,
    /// Bytes of the `.prj`.
    pub system: Option<Vec<u8>>,
    /// Bytes of the `.shx`.
    pub index: Option<Vec<u8>>,
    /// Bytes of the `.cpg`.
    pub encoding: Option<Vec<u8>>,
}

/// Returns the one shapefile in a zip; `None` if the bytes are no zip or hold no shapefile.
pub fn shapefile(bytes: &[u8], file: &Path) -> Result<Option<ShapefileParts>> {
    if !bytes.starts_with(MAGIC) {
        return Ok(None);
    }
    let refuse = |what: String| Error::input(file, None, what, UNPACK);
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(damage_of(file))?;
    let names: Vec<String> =
        zip.file_names().filter_map(|name| Some(name.ok()?.into_owned())).filter(|name| is_file(name)).collect();
    let ends = |name: &&String, ending: &str| name.to_lowercase().ends_with(ending);
    let shapes: Vec<&String> = names.iter().filter(|name| ends(name, ".shp")).collect();
    let (first, others) = match shapes.as_slice() {
        [] => return Ok(None),
        [first, others @ ..] => (*first, others),
    };
    if let Some(other) = others.first() {
        let [first, other] = [first, *other].map(|name| excerpt(name.as_bytes()));
        return Err(refuse(format!("the zip holds several shapefiles: `{first}`, `{other}`")));
    }
    let stem = first.get(..first.len() - 4).unwrap_or_default();
    let mut part = |ending: &str| -> Result<Option<Vec<u8>>> {
        let wanted = names.iter().find(|name| {
            name.get(..stem.len()) == Some(stem)
                && name.get(stem.len()..).is_some_and(|end| end.eq_ignore_ascii_case(ending))
        });
        let Some(name) = wanted else { return Ok(None) };
        let entry = zip.by_name(name).map_err(damage_of(file))?;
        let most = most(entry.compressed_size().min(bytes.len() as u64));
        unpacked(entry, name, most, file).map(Some)
    };
    let shapes = part(".shp")?.unwrap_or_default();
    let (table, system) = (part(".dbf")?, part(".prj")?);
    Ok(Some(ShapefileParts { shapes, table, system, index: part(".shx")?, encoding: part(".cpg")? }))
}

/// Returns true if a name is that of a file that macOS did not add.
pub(super) fn is_file(name: &str) -> bool {
    let last = name.rsplit('/').next().unwrap_or_default();
    !name.ends_with('/') && !name.starts_with("__MACOSX/") && last != ".DS_Store" && !last.starts_with("._")
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;

    /// Returns a zip of files, packed or stored.
    pub fn zipped(files: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, plain) in files {
            writer.start_file(*name, SimpleFileOptions::default().compression_method(method)).expect("a name");
            writer.write_all(plain).expect("packed");
        }
        writer.finish().expect("a zip").into_inner()
    }

    /// One file is unpacked, compressed or not, beside a folder and a file that macOS adds; two
    /// files are refused with both names, and so is a workbook.
    #[test]
    fn a_zip_of_one_file_is_read() {
        let (file, text) = (Path::new("a.zip"), b"v 0 0 0\n".repeat(100));
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            let zip = zipped(&[("in/", b""), ("in/a.obj", &text), ("__MACOSX/in/._a.obj", b"x")], method);
            let found = single(&zip, zip.len() as u64, file).expect("readable").expect("a zip");
            assert_eq!((found.name.as_str(), found.bytes.len()), ("in/a.obj", 800));
        }
        for (names, said) in [
            (["a.obj", "b.obj"], "holds 2 files, not one: `a.obj`, `b.obj`"),
            (["[Content_Types].xml", "xl/workbook.xml"], "is a workbook or document of an office program"),
        ] {
            let zip = zipped(&names.map(|name| (name, &b"1"[..])), CompressionMethod::Deflated);
            let message = single(&zip, zip.len() as u64, file).err().expect("no single file").to_string();
            assert!(message.contains(said), "{message}");
        }
        assert!(single(b"v 0 0 0", 7, file).expect("plain").is_none());
    }

    /// A zip that is cut off after any of its bytes, or has any byte inverted, is refused or still
    /// gives 800 bytes.
    #[test]
    fn damaged_zips_are_refused() {
        let text = b"v 0 0 0\n".repeat(100);
        let whole = zipped(&[("a.obj", &text)], CompressionMethod::Deflated);
        let mut refused = 0;
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            for bytes in [&whole[..at], &bytes] {
                match single(bytes, bytes.len() as u64, Path::new("a.zip")) {
                    Ok(Some(found)) => assert_eq!(found.bytes.len(), 800),
                    Ok(None) => {}
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > whole.len(), "{refused}");
    }
}
