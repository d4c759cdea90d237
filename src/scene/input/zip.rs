//! Packed files of the zip format (APPNOTE 6.3.10). In: bytes that may be a zip of one file. Out: that file with its name.

use std::io::Read;
use std::path::Path;

use flate2::Crc;
use flate2::read::DeflateDecoder;
use heliotile_core::error::{Error, Result};

use super::gzip::most;
use crate::text::excerpt;

const MAGIC: &[u8] = b"PK\x03\x04";
const ENTRY: &[u8] = b"PK\x01\x02";
const END: &[u8] = b"PK\x05\x06";

/// The end of the directory stands in so many last bytes: 22 and a comment.
const END_WITHIN: usize = 22 + 65_535;

/// The only file of a zip.
pub(super) struct Single {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// An entry of the directory.
struct Entry<'b> {
    name: &'b [u8],
    is_encrypted: bool,
    method: u64,
    crc: u64,
    packed: u64,
    at: u64,
}

/// Unpacks a zip of one file; `None` for what is no zip.
pub(super) fn single(bytes: &[u8], file: &Path) -> Result<Option<Single>> {
    if !bytes.starts_with(MAGIC) {
        return Ok(None);
    }
    let refuse = |what: String| Error::input(file, None, what, "unpack it and give the file that is meant");
    let damaged = || refuse("the zip is damaged, cut off, or larger than 4 GiB".into());
    let entries = entries(bytes).ok_or_else(damaged)?;
    let [entry] = entries.as_slice() else {
        let names: Vec<String> = entries.iter().take(5).map(|entry| format!("`{}`", excerpt(entry.name))).collect();
        let more = if entries.len() > names.len() { ", ..." } else { "" };
        return Err(refuse(format!("the zip holds {} files, not one: {}{more}", entries.len(), names.join(", "))));
    };
    let name = excerpt(entry.name);
    if entry.is_encrypted || ![0, 8].contains(&entry.method) {
        return Err(refuse(format!("`{name}` in the zip is encrypted or packed by another method than Deflate")));
    }
    let packed = data(bytes, entry).ok_or_else(damaged)?;
    let most = most(packed.len() as u64);
    let mut plain = Vec::new();
    let read = match entry.method {
        0 => packed.take(most + 1).read_to_end(&mut plain),
        _ => DeflateDecoder::new(packed).take(most + 1).read_to_end(&mut plain),
    };
    read.map_err(|_| damaged())?;
    if plain.len() as u64 > most {
        return Err(refuse(format!("`{name}` in the zip unpacks to more than {most} bytes")));
    }
    let mut sum = Crc::new();
    sum.update(&plain);
    if u64::from(sum.sum()) != entry.crc {
        return Err(damaged());
    }
    Ok(Some(Single { name: String::from_utf8_lossy(entry.name).into_owned(), bytes: plain }))
}

fn number(bytes: &[u8], at: usize, length: usize) -> Option<u64> {
    let found = bytes.get(at..at.checked_add(length)?)?;
    Some(found.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte)))
}

/// Files of the directory, without folders and what macOS adds.
fn entries(bytes: &[u8]) -> Option<Vec<Entry<'_>>> {
    let tail = bytes.len().saturating_sub(END_WITHIN);
    let end = tail + bytes.get(tail..)?.windows(END.len()).rposition(|window| window == END)?;
    let (count, mut at) = (number(bytes, end + 10, 2)?, number(bytes, end + 16, 4)? as usize);
    let mut found = Vec::new();
    for _ in 0..count {
        if bytes.get(at..)?.get(..4)? != ENTRY {
            return None;
        }
        let length = |place: usize| number(bytes, at + place, 2).map(|length| length as usize);
        let (named, extra, comment) = (length(28)?, length(30)?, length(32)?);
        let name = bytes.get(at + 46..at + 46 + named)?;
        let is_kept = !name.ends_with(b"/") && !name.starts_with(b"__MACOSX/") && !name.ends_with(b".DS_Store");
        if is_kept {
            found.push(Entry {
                name,
                is_encrypted: number(bytes, at + 8, 2)? & 1 == 1,
                method: number(bytes, at + 10, 2)?,
                crc: number(bytes, at + 16, 4)?,
                packed: number(bytes, at + 20, 4)?,
                at: number(bytes, at + 42, 4)?,
            });
        }
        at += 46 + named + extra + comment;
    }
    Some(found)
}

/// The packed bytes of an entry, which stand behind a head of their own.
fn data<'b>(bytes: &'b [u8], entry: &Entry) -> Option<&'b [u8]> {
    let head = usize::try_from(entry.at).ok()?;
    if bytes.get(head..)?.get(..4)? != MAGIC {
        return None;
    }
    let start = head + 30 + number(bytes, head + 26, 2)? as usize + number(bytes, head + 28, 2)? as usize;
    bytes.get(start..start.checked_add(usize::try_from(entry.packed).ok()?)?)
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::DeflateEncoder;

    use super::*;

    /// A zip of files, packed or as they stand.
    pub(crate) fn zipped(files: &[(&str, &[u8])], method: u16) -> Vec<u8> {
        let (mut out, mut directory) = (Vec::new(), Vec::new());
        for (name, plain) in files {
            let packed = if method == 8 {
                let mut packer = DeflateEncoder::new(Vec::new(), Compression::default());
                packer.write_all(plain).expect("packed");
                packer.finish().expect("packed")
            } else {
                plain.to_vec()
            };
            let mut sum = Crc::new();
            sum.update(plain);
            let mut about = vec![20, 0, 0, 0];
            about.extend([method.to_le_bytes(), [0; 2], [0; 2]].concat());
            about.extend([sum.sum(), packed.len() as u32, plain.len() as u32].map(u32::to_le_bytes).concat());
            about.extend([(name.len() as u16).to_le_bytes(), [0; 2]].concat());
            let at = out.len() as u32;
            directory.extend([ENTRY, &[20, 0], &about, &[0; 10], &at.to_le_bytes(), name.as_bytes()].concat());
            out.extend([MAGIC, &about, name.as_bytes(), &packed].concat());
        }
        let count = (files.len() as u16).to_le_bytes();
        let (at, length) = (out.len() as u32, directory.len() as u32);
        out.extend(
            [&directory, END, &[0; 4], &count, &count, &length.to_le_bytes(), &at.to_le_bytes(), &[0; 2]].concat(),
        );
        out
    }

    /// One file comes out, packed or not, beside a folder and what macOS adds; two files are refused with both names.
    #[test]
    fn a_zip_of_one_file_is_read() {
        let (file, text) = (Path::new("a.zip"), b"v 0 0 0\n".repeat(100));
        for method in [0, 8] {
            let zip = zipped(&[("in/", b""), ("in/a.obj", &text), ("__MACOSX/in/._a.obj", b"x")], method);
            let found = single(&zip, file).expect("readable").expect("a zip");
            assert_eq!((found.name.as_str(), found.bytes.len()), ("in/a.obj", 800));
        }
        let message = single(&zipped(&[("a.obj", b"1"), ("b.obj", b"2")], 8), file).err().expect("two").to_string();
        assert!(
            message.contains("holds 2 files, not one: `a.obj`, `b.obj`") && message.contains("unpack it"),
            "{message}"
        );
        assert!(single(b"v 0 0 0", file).expect("plain").is_none());
    }

    /// Cut off after any of its bytes, or with any of them inverted, a zip is refused or is still the same 800 bytes.
    #[test]
    fn damaged_zips() {
        let text = b"v 0 0 0\n".repeat(100);
        let whole = zipped(&[("a.obj", &text)], 8);
        let mut refused = 0;
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            for bytes in [&whole[..at], &bytes] {
                match single(bytes, Path::new("a.zip")) {
                    Ok(Some(found)) => assert_eq!(found.bytes.len(), 800),
                    Ok(None) => {}
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > whole.len(), "{refused}");
    }
}
