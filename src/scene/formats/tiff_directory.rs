//! Checks of the directory of a TIFF file before the decoder sees it. The crate `tiff` allocates
//! what a tag claims, 256 MiB at most, before it finds that the file ends. In: the bytes of a file.
//! Out: patches for the decoder, or an error on a tag whose values lie beyond the file; the place
//! of the image's mask.

/// Bytes of a value by its type number, from type 1 on. Types 1 to 12 stand in TIFF 6.0, section 2,
/// type 13 is a directory, 16 to 18 are those of BigTIFF; 14 and 15 are not assigned.
const SIZES: [u64; 18] = [1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 1, 1, 8, 8, 8];

/// Most directories that are searched for a mask; files with overviews have some twenty.
const MAX_DIRECTORIES: usize = 64;

/// Tags of TIFF 6.0, section 8: NewSubfileType, ImageWidth, ImageLength, Compression and
/// PhotometricInterpretation.
const SUBFILE_TYPE: u64 = 254;
const WIDTH: u64 = 256;
const HEIGHT: u64 = 257;
const COMPRESSION: u64 = 259;
const INTERPRETATION: u64 = 262;
/// Tags of the positions and lengths of strips, and of tiles.
const CHUNKS: [[u64; 2]; 2] = [[273, 279], [324, 325]];

/// Code of LZW in the tag of the compression (TIFF 6.0, section 13).
const LZW: u64 = 5;

/// Bytes added to each LZW strip or tile, and zeros added behind the file. The LZW decoder of the
/// crate asks for more bytes than it needs: where a line ends with the packed bytes, it takes the
/// file for cut.
pub(super) const MORE_FOR_LZW: u64 = 64;

/// Bytes of a TIFF, classic or BigTIFF.
struct Bytes<'b> {
    bytes: &'b [u8],
    little: bool,
    big: bool,
}

/// A tag with its values somewhere in the file.
struct Entry {
    tag: u64,
    count: u64,
    /// Position of its values, and below the bytes of all of them and of one.
    place: u64,
    length: u64,
    size: u64,
}

/// A directory, and the position of the next one, 0 for none.
struct Directory {
    entries: Vec<Entry>,
    next: u64,
}

/// Bytes that replace those of the file from position `at` on.
pub(super) struct Patch {
    pub at: u64,
    pub bytes: Vec<u8>,
}

/// Changes to the file that the decoder needs to read it correctly.
#[derive(Default)]
pub(super) struct Patches {
    pub list: Vec<Patch>,
    /// Number of zeros appended to the file.
    pub zeros: u64,
}

impl<'b> Bytes<'b> {
    fn parse(bytes: &'b [u8]) -> Option<Bytes<'b>> {
        let found = Bytes { bytes, little: bytes.starts_with(b"II"), big: false };
        match found.number(2, 2)? {
            42 => Some(found),
            43 => Some(Bytes { big: true, ..found }),
            _ => None,
        }
    }

    fn number(&self, at: u64, length: u64) -> Option<u64> {
        let from = usize::try_from(at).ok()?;
        let found = self.bytes.get(from..from.checked_add(length as usize)?)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(if self.little { found.iter().rev().fold(0, add) } else { found.iter().fold(0, add) })
    }

    fn written(&self, number: u64, length: usize) -> Vec<u8> {
        let mut bytes: Vec<u8> = number.to_le_bytes().into_iter().take(length).collect();
        if !self.little {
            bytes.reverse();
        }
        bytes
    }

    /// Returns the position of the first directory's offset, and the length of that offset in
    /// bytes.
    fn first(&self) -> (u64, u64) {
        if self.big { (8, 8) } else { (4, 4) }
    }

    fn directory(&self, start: u64) -> Option<Directory> {
        // Bytes of a directory's count, of an entry, and of a number in it.
        let (head, tag, wide) = if self.big { (8, 20, 8) } else { (2, 12, 4) };
        let (mut entries, count) = (Vec::new(), self.number(start, head)?);
        for i in 0..count {
            let at = start.checked_add(head)?.checked_add(i.checked_mul(tag)?)?;
            // The first number fails beyond the end of the file, so the sums behind it do not
            // overflow.
            let (name, kind, count) = (self.number(at, 2)?, self.number(at + 2, 2)?, self.number(at + 4, wide)?);
            let size = SIZES.get((kind as usize).wrapping_sub(1)).copied().unwrap_or(8);
            let length = count.saturating_mul(size);
            let value = at + 4 + wide;
            let place = if length <= wide { value } else { self.number(value, wide)? };
            entries.push(Entry { tag: name, count, place, length, size });
        }
        let behind = start.checked_add(head)?.checked_add(count.checked_mul(tag)?)?;
        Some(Directory { entries, next: self.number(behind, wide).unwrap_or(0) })
    }

    /// Returns the first value of a tag.
    fn value(&self, directory: &Directory, tag: u64) -> Option<u64> {
        let entry = directory.entries.iter().find(|entry| entry.tag == tag && entry.count > 0)?;
        self.number(entry.place, entry.size)
    }

    /// Returns the patches that the LZW decoder needs; an error if a strip or tile lies beyond the
    /// end of the file.
    fn for_lzw(&self, directory: &Directory) -> Result<Patches, String> {
        let mut patches = Patches::default();
        if self.value(directory, COMPRESSION) != Some(LZW) {
            return Ok(patches);
        }
        let find = |tag| directory.entries.iter().find(|entry| entry.tag == tag);
        for [offsets, lengths] in CHUNKS {
            let (Some(offsets), Some(lengths)) = (find(offsets), find(lengths)) else { continue };
            let each = |entry: &Entry, i: u64| self.number(entry.place + i * entry.size, entry.size);
            let mut bytes = Vec::new();
            for i in 0..lengths.count {
                let length = each(lengths, i).unwrap_or_default();
                let end = each(offsets, i).filter(|_| i < offsets.count).map(|at| at.saturating_add(length));
                if end.is_some_and(|end| end > self.bytes.len() as u64) {
                    return Err(format!(
                        "strip or tile {i} lies beyond the end of the file, {} bytes",
                        self.bytes.len()
                    ));
                }
                let most = u64::MAX >> (64 - 8 * lengths.size.clamp(1, 8));
                // Length 0 stands for a strip or tile that is left out.
                let more = if length == 0 || length > most - MORE_FOR_LZW { length } else { length + MORE_FOR_LZW };
                bytes.extend(self.written(more, lengths.size as usize));
            }
            patches.list.push(Patch { at: lengths.place, bytes });
            patches.zeros = MORE_FOR_LZW;
        }
        Ok(patches)
    }

    fn check(&self, directory: &Directory) -> Result<(), String> {
        let all = self.bytes.len() as u64;
        match directory.entries.iter().find(|entry| entry.place.saturating_add(entry.length) > all) {
            Some(Entry { tag, count, .. }) => {
                Err(format!("tag {tag} has {count} values that lie beyond the end of the file, {all} bytes"))
            }
            None => Ok(()),
        }
    }
}

/// Checks that the values of every tag of the first directory lie in the file (TIFF 6.0, section 2;
/// BigTIFF), and returns the patches for the decoder. A file that is not TIFF, or ends within its
/// header, is left to the decoder.
pub(super) fn check(bytes: &[u8]) -> Result<Patches, String> {
    let Some(bytes) = Bytes::parse(bytes) else { return Ok(Patches::default()) };
    let (at, length) = bytes.first();
    match bytes.number(at, length).and_then(|start| bytes.directory(start)) {
        Some(directory) => {
            bytes.check(&directory)?;
            bytes.for_lzw(&directory)
        }
        None => Ok(Patches::default()),
    }
}

/// Finds the mask of the image in the first directory: a directory of the same size and of type 4,
/// transparency (masks of overviews have type 5). Returns patches that make the decoder read the
/// mask in place of the image.
pub(super) fn mask(bytes: &[u8]) -> Result<Option<Patches>, String> {
    let Some(bytes) = Bytes::parse(bytes) else { return Ok(None) };
    let (at, length) = bytes.first();
    let Some(first) = bytes.number(at, length).and_then(|start| bytes.directory(start)) else { return Ok(None) };
    let mut start = first.next;
    for _ in 0..MAX_DIRECTORIES {
        let Some(directory) = Some(start).filter(|start| *start != 0).and_then(|start| bytes.directory(start)) else {
            break;
        };
        let same = |tag| bytes.value(&directory, tag) == bytes.value(&first, tag);
        if bytes.value(&directory, SUBFILE_TYPE) == Some(4) && same(WIDTH) && same(HEIGHT) {
            bytes.check(&directory)?;
            let interpretation = directory.entries.iter().find(|entry| entry.tag == INTERPRETATION);
            let Some(entry) = interpretation else { return Ok(None) };
            let size = entry.size as usize;
            // 1 stands for "black is zero".
            let mut patches = bytes.for_lzw(&directory)?;
            patches.list.push(Patch { at, bytes: bytes.written(start, length as usize) });
            patches.list.push(Patch { at: entry.place, bytes: bytes.written(1, size) });
            return Ok(Some(patches));
        }
        start = directory.next;
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a file with one tag whose values stand elsewhere in it, classic or BigTIFF, little
    /// or big endian.
    fn file(big: bool, little: bool, count: u64, place: u64) -> Vec<u8> {
        let n = |value: u64, length: usize| {
            let mut bytes = value.to_le_bytes()[..length].to_vec();
            if !little {
                bytes.reverse();
            }
            bytes
        };
        let mut out = if little { b"II".to_vec() } else { b"MM".to_vec() };
        if big {
            out.extend(
                [n(43, 2), n(8, 2), n(0, 2), n(16, 8), n(1, 8), n(273, 2), n(4, 2), n(count, 8), n(place, 8)].concat(),
            );
        } else {
            out.extend([n(42, 2), n(8, 4), n(1, 2), n(273, 2), n(4, 2), n(count, 4), n(place, 4)].concat());
        }
        out.resize(64, 0);
        out
    }

    /// Values within 64 bytes pass in all 4 kinds of file. A count of 4 billion, or a position
    /// behind the end, is an error that names the tag. A cut file and a file that is not TIFF pass.
    #[test]
    fn values_beyond_the_file_are_refused() {
        for (big, little) in [(false, true), (false, false), (true, true), (true, false)] {
            assert!(check(&file(big, little, 4, 48)).is_ok_and(|patches| patches.list.is_empty()));
            for (count, place) in [(4, 49), (u64::from(u32::MAX), 8), (3, u64::from(u32::MAX))] {
                let what = check(&file(big, little, count, place)).err().expect("beyond the end");
                assert_eq!(what, format!("tag 273 has {count} values that lie beyond the end of the file, 64 bytes"));
            }
            let whole = file(big, little, 4, 48);
            assert!((0..20).all(|length| check(&whole[..length]).is_ok()));
        }
        assert!(check(b"solid house").is_ok());
    }
}
