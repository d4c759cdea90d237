//! Zip archives with one file inside (PKWARE, "APPNOTE.TXT - .ZIP file format specification"). In: bytes that may be one. Out: the bytes of
//! that file, of a number that is limited, or an error that says what the archive holds.

use std::io::{Cursor, Read};
use std::path::Path;

use flate2::Crc;
use flate2::read::DeflateDecoder;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::excerpt;

pub(super) const MAGIC: [u8; 4] = *b"PK\x03\x04";

const END_MAGIC: [u8; 4] = *b"PK\x05\x06";
const ENTRY_MAGIC: [u8; 4] = *b"PK\x01\x02";

/// Length of the record at the end, without its comment, which is at most 65,535 bytes long.
const END_LENGTH: usize = 22;
const LONGEST_COMMENT: usize = 65_535;
const ENTRY_LENGTH: usize = 46;
const LOCAL_LENGTH: usize = 30;

const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// Stands where a number does not fit into 32 bits.
const IN_ZIP_64: u32 = u32::MAX;

/// Files of an archive that a message names, at most.
const NAMED: usize = 5;

const UNPACK: &str = "unpack it, and give the plain file";

/// What the list of an archive says of a file in it.
struct Entry {
    name: String,
    is_encrypted: bool,
    method: u16,
    crc: u32,
    packed: u32,
    local_at: u32,
}

/// The only file of an archive, unpacked to at most so many bytes; other bytes stay as they are.
pub(super) fn unpack(bytes: Vec<u8>, file: &Path, most: u64) -> Result<Vec<u8>> {
    if !bytes.starts_with(&MAGIC) {
        return Ok(bytes);
    }
    let damaged = |what: &str| {
        let hint = "the file is damaged or cut off: fetch or pack it again";
        Error::input(file, None, format!("the zip archive cannot be unpacked: {what}"), hint)
    };
    let entries = entries(&bytes).ok_or_else(|| damaged("its list of files is not whole"))?;
    let entry = only_file(file, entries)?;
    if entry.is_encrypted || ![STORED, DEFLATED].contains(&entry.method) {
        let what =
            format!("`{}` in the zip archive is encrypted or packed in an unusual way", excerpt(&entry.name, 60));
        return Err(Error::input(file, None, what, UNPACK));
    }
    let packed = packed_bytes(&bytes, &entry).ok_or_else(|| damaged("its file is not whole"))?;
    let mut plain = Vec::new();
    let read = match entry.method {
        STORED => Cursor::new(packed).take(most + 1).read_to_end(&mut plain),
        _ => DeflateDecoder::new(packed).take(most + 1).read_to_end(&mut plain),
    };
    read.map_err(|error| damaged(&error.to_string()))?;
    if plain.len() as u64 > most {
        return Err(Error::input(file, None, format!("unpacks to more than {most} bytes"), UNPACK));
    }
    let mut crc = Crc::new();
    crc.update(&plain);
    if crc.sum() != entry.crc {
        return Err(damaged("its checksum differs"));
    }
    Ok(plain)
}

/// The one file that is no folder and no note of macOS.
fn only_file(file: &Path, entries: Vec<Entry>) -> Result<Entry> {
    let is_note = |name: &str| {
        let last = name.rsplit('/').next().unwrap_or_default();
        name.starts_with("__MACOSX/") || last == ".DS_Store" || last.starts_with("._")
    };
    let is_workbook = entries.iter().any(|entry| entry.name == "[Content_Types].xml");
    let mut files: Vec<Entry> =
        entries.into_iter().filter(|entry| !entry.name.ends_with('/') && !is_note(&entry.name)).collect();
    if is_workbook {
        let what = "is a workbook or document of an office program";
        return Err(Error::input(file, None, what, "save the sheet as CSV, and give that"));
    }
    if files.len() > 1 {
        let names: Vec<String> =
            files.iter().take(NAMED).map(|entry| format!("`{}`", excerpt(&entry.name, 40))).collect();
        let what = format!("is a zip archive of {} files: {}", files.len(), names.join(", "));
        return Err(Error::input(file, None, what, "unpack it, and give the one that is meant"));
    }
    files.pop().ok_or_else(|| Error::input(file, None, "is a zip archive without a file", UNPACK))
}

/// The list at the end of an archive.
fn entries(bytes: &[u8]) -> Option<Vec<Entry>> {
    let last = bytes.len().checked_sub(END_LENGTH)?;
    let first = last.saturating_sub(LONGEST_COMMENT);
    let end = (first..=last).rev().find(|at| bytes.get(*at..at + 4) == Some(&END_MAGIC[..]))?;
    let (count, mut at) = (u16_at(bytes, end + 10)?, u32_at(bytes, end + 16).filter(|at| *at != IN_ZIP_64)? as usize);
    let mut entries = Vec::new();
    for _ in 0..count {
        if bytes.get(at..at + 4)? != ENTRY_MAGIC {
            return None;
        }
        let lengths = [28, 30, 32].map(|place| u16_at(bytes, at + place).map(usize::from));
        let [name_length, extra_length, comment_length] = [lengths[0]?, lengths[1]?, lengths[2]?];
        let name = bytes.get(at + ENTRY_LENGTH..at + ENTRY_LENGTH + name_length)?;
        entries.push(Entry {
            name: String::from_utf8_lossy(name).into_owned(),
            is_encrypted: u16_at(bytes, at + 8)? & 1 == 1,
            method: u16_at(bytes, at + 10)?,
            crc: u32_at(bytes, at + 16)?,
            packed: u32_at(bytes, at + 20)?,
            local_at: u32_at(bytes, at + 42)?,
        });
        at += ENTRY_LENGTH + name_length + extra_length + comment_length;
    }
    Some(entries)
}

/// The bytes of a file as they lie in the archive.
fn packed_bytes<'b>(bytes: &'b [u8], entry: &Entry) -> Option<&'b [u8]> {
    let at = entry.local_at as usize;
    if bytes.get(at..at.checked_add(4)?)? != MAGIC || entry.packed == IN_ZIP_64 {
        return None;
    }
    let start = at + LOCAL_LENGTH + usize::from(u16_at(bytes, at + 26)?) + usize::from(u16_at(bytes, at + 28)?);
    bytes.get(start..start.checked_add(entry.packed as usize)?)
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at.checked_add(2)?)?.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::DeflateEncoder;

    use super::*;

    /// An archive of these files, deflated or stored.
    pub fn pack(files: &[(&str, &[u8])], method: u16) -> Vec<u8> {
        let (mut bytes, mut list) = (Vec::new(), Vec::new());
        for (name, plain) in files {
            let mut packer = DeflateEncoder::new(Vec::new(), Compression::default());
            packer.write_all(plain).expect("packed");
            let packed = if method == STORED { plain.to_vec() } else { packer.finish().expect("packed") };
            let mut crc = Crc::new();
            crc.update(plain);
            let local_at = bytes.len() as u32;
            let common = [&[20, 0, 0, 0][..], &method.to_le_bytes(), &[0; 4], &crc.sum().to_le_bytes()].concat();
            let sizes = [packed.len() as u32, plain.len() as u32, name.len() as u32].map(u32::to_le_bytes).concat();
            bytes.extend([&MAGIC[..], &common, &sizes, name.as_bytes(), &packed].concat());
            let rest = [&[0; 10][..], &local_at.to_le_bytes(), name.as_bytes()].concat();
            list.extend([&ENTRY_MAGIC[..], &[20, 0], &common, &sizes, &rest].concat());
        }
        let (at, count) = ((bytes.len() as u32).to_le_bytes(), (files.len() as u16).to_le_bytes());
        let end = [&END_MAGIC[..], &[0; 4], &count, &count, &(list.len() as u32).to_le_bytes(), &at, &[0; 2]].concat();
        [bytes, list, end].concat()
    }

    fn refused(bytes: Vec<u8>) -> String {
        unpack(bytes, Path::new("town.zip"), 9000).expect_err("refused").to_string()
    }

    /// One file of 8000 bytes, deflated and stored, with a folder and a note of macOS beside it or not, is unpacked: 4 of 4; plain bytes stay.
    #[test]
    fn one_file_is_unpacked() {
        let text = b"v 0 0 0\n".repeat(1000);
        for method in [STORED, DEFLATED] {
            let alone = pack(&[("town.obj", &text)], method);
            let noted = pack(&[("a/", b""), ("a/town.obj", &text), ("__MACOSX/a/._town.obj", b"x")], method);
            for bytes in [alone, noted] {
                assert!(unpack(bytes, Path::new("town.zip"), 8000).expect("unpacked") == text);
            }
        }
        assert_eq!(unpack(text.clone(), Path::new("town.obj"), 1).expect("plain").len(), 8000);
    }

    /// Archives of two files, of none, of an office program, encrypted, too long, or damaged at any of their bytes are refused in two lines
    /// that name the file; none is a panic.
    #[test]
    fn others_are_refused() {
        let whole = pack(&[("a.csv", b"time,ghi\n2021-06-01,1\n")], DEFLATED);
        for (bytes, said) in [
            (pack(&[("a.csv", b"1"), ("b.csv", b"2")], STORED), "is a zip archive of 2 files: `a.csv`, `b.csv`"),
            (pack(&[("a/", b"")], STORED), "is a zip archive without a file"),
            (pack(&[("[Content_Types].xml", b"1"), ("xl/a.xml", b"2")], STORED), "save the sheet as CSV"),
            (pack(&[("a.csv", b"1")], 99), "encrypted or packed in an unusual way"),
            (pack(&[("a.csv", &[7; 9001])], DEFLATED), "unpacks to more than 9000 bytes"),
            (whole[..40].to_vec(), "its list of files is not whole"),
        ] {
            let message = refused(bytes);
            assert!(message.starts_with("town.zip: ") && message.contains(said), "{message}");
            assert_eq!(message.lines().count(), 2, "{message}");
        }
        let mut refusals = 0;
        for place in 4..whole.len() {
            let mut noisy = whole.clone();
            noisy[place] ^= 0x55;
            refusals += usize::from(unpack(noisy, Path::new("town.zip"), 9000).is_err());
            assert!(unpack(whole[..place].to_vec(), Path::new("town.zip"), 9000).is_err());
        }
        assert!(refusals > 40, "{refusals}");
    }
}
