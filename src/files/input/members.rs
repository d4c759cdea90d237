//! Members of zips and folders. In: a path and endings. Out: the bytes of the file piece by piece,
//! or those of each file of a zip, sorted by name, that has the first of the endings found in the
//! zip.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use zip::{CompressionMethod, ZipArchive};

use super::gzip::Bounded;
use super::{budget, ending, open, refused, zip as single_zip};
use crate::text::{excerpt, utf8};

/// Byte order marks of UTF-16.
const UTF_16: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];

/// Most bytes of a text in UTF-16, which is held as a whole.
const MAX_UTF_16: u64 = 1 << 30;

const UNPACK: &str = "unpack it and give its files, or their folder";

/// Passes the bytes of a file, or of each file of a zip with the wanted ending, to `take`. Of a zip
/// with themes in the folder `udx` those in `themes` are passed, or, if that is empty, those of
/// what stands on the ground. Returns the themes that were left out.
pub fn each(
    path: &Path,
    endings: &[&str],
    themes: &[String],
    take: &mut dyn FnMut(Box<dyn Read + '_>) -> Result<()>,
) -> Result<Vec<String>> {
    let Some(mut zip) = zip_of(path)? else { return take(plain(open(path)?, path)?).map(|()| Vec::new()) };
    let all = meant(&zip, endings, path)?;
    let (names, left_out): (Vec<String>, Vec<String>) = all.into_iter().partition(|name| is_of(name, themes));
    if names.is_empty() && !left_out.is_empty() {
        let what = format!("the zip has none of the themes {}", themes.join(", "));
        let found = themes_of(&left_out).join(", ");
        return Err(Error::input(
            path,
            None,
            what,
            Message::from(format!("its themes are {found}")).and(": name one of them as {layer}"),
        ));
    }
    if names.is_empty() {
        let what = format!("the zip holds no file that ends with .{}", endings.join(" or ."));
        return Err(Error::input(path, None, what, UNPACK));
    }
    for name in names {
        let shown = excerpt(name.as_bytes());
        let damaged = |error: zip::result::ZipError| {
            let what = format!("`{shown}` in the zip cannot be unpacked: {error}");
            Error::input(path, None, what, UNPACK)
        };
        let number = zip.index_for_name(&name).unwrap_or_default();
        let entry = zip.by_index_raw(number).map_err(damaged)?;
        let known = [CompressionMethod::Stored, CompressionMethod::Deflated].contains(&entry.compression());
        let (left, is_encrypted) = (budget::most_streamed(entry.compressed_size()), entry.encrypted());
        drop(entry);
        if is_encrypted || !known {
            let what = format!("`{shown}` in the zip is encrypted or packed by another method than Deflate");
            return Err(Error::input(path, None, what, UNPACK));
        }
        let inner = zip.by_index(number).map_err(damaged)?;
        take(plain(Box::new(Bounded { inner, left }), path)?)?;
    }
    Ok(themes_of(&left_out))
}

/// Folder of the themes of a city of PLATEAU (Japan): `udx/bldg/53394525_bldg_6697_op.gml`.
const THEMES: &str = "udx/";
/// Themes that stand on the ground or are it: buildings, bridges, plants, furniture, terrain.
const STANDING: [&str; 5] = ["bldg", "brid", "veg", "frn", "dem"];

/// Returns the theme of a file: the folder in `udx`.
fn theme_of(name: &str) -> Option<&str> {
    let start = name.find(THEMES).filter(|at| *at == 0 || name.get(..*at).is_some_and(|head| head.ends_with('/')))?;
    name.get(start + THEMES.len()..)?.split_once('/').map(|(theme, _)| theme)
}

/// Returns true for a file of one of the themes, or without a theme. No themes: those of buildings
/// and what stands beside them.
fn is_of(name: &str, themes: &[String]) -> bool {
    let Some(theme) = theme_of(name) else { return true };
    match themes.is_empty() {
        true => STANDING.contains(&theme),
        false => themes.iter().any(|wanted| wanted.eq_ignore_ascii_case(theme)),
    }
}

fn themes_of(names: &[String]) -> Vec<String> {
    let mut themes: Vec<String> =
        names.iter().filter_map(|name| Some(format!("`{}`", excerpt(theme_of(name)?.as_bytes())))).collect();
    themes.sort_unstable();
    themes.dedup();
    themes
}

/// Returns true if a path is a zip whose wanted files have the first of the endings, or a zip of
/// nothing but files with one of the others.
pub fn has(path: &Path, endings: &[&str]) -> bool {
    let Ok(Some(zip)) = zip_of(path) else { return false };
    let Ok(names) = meant(&zip, endings, path) else { return false };
    let all = zip.file_names().flatten().filter(|name| single_zip::is_file(name)).count();
    let is_first = |name: &String| endings.first().is_some_and(|first| ending(Path::new(name)) == *first);
    !names.is_empty() && (names.len() == all || names.iter().all(is_first))
}

/// Returns the files of a folder that have the first of the endings found in it, sorted by name.
pub fn of_folder(folder: &Path, endings: &[&str]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(Error::io(folder, "read"))? {
        let path = entry.map_err(Error::io(folder, "read"))?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort_unstable();
    let with = |wanted: &str| -> Vec<PathBuf> { files.iter().filter(|path| ending(path) == wanted).cloned().collect() };
    Ok(endings.iter().map(|wanted| with(wanted)).find(|found| !found.is_empty()).unwrap_or_default())
}

/// Returns the folders of the themes of a city of PLATEAU that stand on the ground, if `folder` is
/// that of a city or its `udx`.
pub fn theme_folders(folder: &Path) -> Vec<PathBuf> {
    let is_udx = folder.file_name().is_some_and(|name| name == "udx");
    let themes = if is_udx { folder.to_owned() } else { folder.join("udx") };
    STANDING.iter().map(|theme| themes.join(theme)).filter(|theme| theme.is_dir()).collect()
}

/// Opens a file as a zip; `None` if it is none.
fn zip_of(path: &Path) -> Result<Option<ZipArchive<BufReader<File>>>> {
    let mut file = File::open(path).map_err(|source| refused(path, "read", source))?;
    let mut head = Vec::new();
    file.by_ref().take(4).read_to_end(&mut head).map_err(Error::io(path, "read"))?;
    if head != single_zip::MAGIC {
        return Ok(None);
    }
    ZipArchive::new(BufReader::new(file))
        .map(Some)
        .map_err(|error| Error::input(path, None, format!("the zip is damaged or cut off: {error}"), "fetch it again"))
}

/// Returns the names of the files of a zip that have the first of the endings found in it, sorted.
fn meant(zip: &ZipArchive<BufReader<File>>, endings: &[&str], path: &Path) -> Result<Vec<String>> {
    let names: Vec<String> = zip
        .file_names()
        .map(|name| name.map(std::borrow::Cow::into_owned))
        .collect::<std::result::Result<_, _>>()
        .map_err(|error| Error::input(path, None, format!("the zip is damaged or cut off: {error}"), UNPACK))?;
    let files = || names.iter().filter(|name| single_zip::is_file(name));
    let with = |wanted: &str| -> Vec<String> {
        let mut found: Vec<String> = files().filter(|name| ending(Path::new(name)) == wanted).cloned().collect();
        found.sort_unstable();
        found
    };
    Ok(endings.iter().map(|wanted| with(wanted)).find(|found| !found.is_empty()).unwrap_or_default())
}

/// Returns text in UTF-16 as UTF-8; other bytes stay as they are.
fn plain<'r>(mut bytes: Box<dyn Read + 'r>, path: &Path) -> Result<Box<dyn Read + 'r>> {
    let mut head = Vec::new();
    bytes.by_ref().take(2).read_to_end(&mut head).map_err(Error::io(path, "read"))?;
    if !UTF_16.iter().any(|mark| head == mark) {
        return Ok(Box::new(Cursor::new(head).chain(bytes)));
    }
    bytes.take(MAX_UTF_16 + 1).read_to_end(&mut head).map_err(Error::io(path, "read"))?;
    if head.len() as u64 > MAX_UTF_16 {
        let what = format!("is UTF-16 of more than {MAX_UTF_16} bytes");
        return Err(Error::input(path, None, what, "save it as UTF-8"));
    }
    Ok(Box::new(Cursor::new(utf8(head))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::zip::tests::zipped;

    fn texts(path: &Path) -> Result<Vec<String>> {
        let mut found = Vec::new();
        each(path, &["gml", "xml"], &[], &mut |mut bytes| {
            let mut text = String::new();
            bytes.read_to_string(&mut text).map_err(Error::io(path, "read"))?;
            found.push(text);
            Ok(())
        })?;
        Ok(found)
    }

    /// A zip of five files gives its two tiles by name, a zip of two XML files both of them, and a
    /// plain file itself; a zip without such a file is refused. Of three themes of a city the
    /// buildings are read, or the one that is asked for.
    #[test]
    fn tiles_of_a_zip_are_read_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("town.zip");
        let write = |files: &[(&str, &[u8])]| {
            std::fs::write(&path, zipped(files, CompressionMethod::Deflated)).expect("written");
        };
        write(&[
            ("b/2.gml", b"two"),
            ("codes.xml", b"no"),
            ("__MACOSX/._1.gml", b"no"),
            ("a.json", b"no"),
            ("b/1.GML", b"one"),
        ]);
        assert_eq!(texts(&path).expect("readable"), ["one", "two"]);
        assert!(has(&path, &["gml", "xml"]));
        write(&[("2.xml", b"two"), ("1.xml", b"one")]);
        assert_eq!((texts(&path).expect("readable").len(), has(&path, &["gml", "xml"])), (2, true));
        write(&[("c/udx/bldg/1.gml", b"one"), ("c/udx/fld/1.gml", b"flood"), ("c/udx/luse/1.gml", b"field")]);
        assert_eq!(texts(&path).expect("readable"), ["one"]);
        let left_out = each(&path, &["gml"], &["FLD".to_owned()], &mut |_| Ok(())).expect("readable");
        assert_eq!(left_out, ["`bldg`", "`luse`"]);
        write(&[("2.xml", b"two"), ("1.json", b"one")]);
        assert!(!has(&path, &["gml", "xml"]));
        write(&[("1.json", b"one")]);
        assert!(texts(&path).expect_err("no tile").to_string().contains("holds no file that ends with .gml or .xml"));
        std::fs::write(&path, [&[0xff, 0xfe][..], &[b'a', 0, b'b', 0]].concat()).expect("written");
        assert_eq!(texts(&path).expect("readable"), ["ab"]);
        assert!(!has(&path, &["gml", "xml"]));
    }
}
