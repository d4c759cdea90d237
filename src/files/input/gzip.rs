//! Packed files. In: bytes that may be gzip (RFC 1952), of one member or several. Out: the plain
//! bytes up to a limit, because one packed byte may stand for a thousand.

use std::fs::File;
use std::io;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use heliotile_core::error::{Error, Problem, Result};

use super::budget::{MAX_STREAMED, most};
use super::zip;

const MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Returns the plain bytes of a file.
pub(super) fn unpack(bytes: Vec<u8>, file: &Path) -> Result<Vec<u8>> {
    unpack_up_to(most(bytes.len() as u64), bytes, file)
}

fn unpack_up_to(most: u64, bytes: Vec<u8>, file: &Path) -> Result<Vec<u8>> {
    if !bytes.starts_with(&MAGIC) {
        return Ok(bytes);
    }
    let mut plain = Vec::new();
    // One byte beyond the limit tells a file that is too long from one that just fits.
    let read = MultiGzDecoder::new(bytes.as_slice()).take(most + 1).read_to_end(&mut plain);
    read.map_err(|error| {
        let what = format!("the gzip data cannot be unpacked beyond byte {}: {error}", plain.len());
        Error::input(file, None, what, "the file is damaged or cut off: fetch or pack it again")
            .because(Problem::Damaged)
    })?;
    if plain.len() as u64 > most {
        let hint = "if the file is meant to be that large, unpack it with gunzip and give the plain file";
        return Err(Error::input(file, None, format!("unpacks to more than {most} bytes"), hint)
            .because(Problem::OutOfRange { found: plain.len() as f64, least: 0.0, most: most as f64 }));
    }
    Ok(plain)
}

/// Returns the plain bytes of a file piece by piece. A zip is unpacked as a whole, because its
/// directory stands at its end.
pub(super) fn unpacked(mut file: File, path: &Path) -> Result<Box<dyn Read>> {
    let mut head = Vec::new();
    file.by_ref().take(zip::MAGIC.len() as u64).read_to_end(&mut head).map_err(Error::io(path, "read"))?;
    let packed = head.starts_with(&MAGIC);
    if head == zip::MAGIC {
        file.read_to_end(&mut head).map_err(Error::io(path, "read"))?;
        if let Some(single) = zip::single(&head, head.len() as u64, path)? {
            return Ok(Box::new(Cursor::new(single.bytes)));
        }
    }
    let whole = Cursor::new(head).chain(file);
    Ok(if packed {
        Box::new(Bounded { inner: MultiGzDecoder::new(BufReader::new(whole)), left: MAX_STREAMED })
    } else {
        Box::new(whole)
    })
}

/// Reader that fails after `left` bytes.
pub(super) struct Bounded<R> {
    pub inner: R,
    pub left: u64,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.left = self.left.checked_sub(count as u64).ok_or_else(|| {
            io::Error::other(format!("it unpacks to more than {MAX_STREAMED} bytes; unpack it with gunzip"))
        })?;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn pack(plain: &[u8]) -> Vec<u8> {
        let mut packer = GzEncoder::new(Vec::new(), Compression::default());
        packer.write_all(plain).expect("packed");
        packer.finish().expect("packed")
    }

    /// Plain bytes stay; packed ones and two packed members in a row are unpacked, as a whole and
    /// piece by piece: 3 of 3 alike.
    #[test]
    fn packed_members_are_unpacked_in_a_row() {
        let text = b"v 0 0 0\n".repeat(1000);
        let folder = tempfile::tempdir().expect("a scratch folder");
        let path = folder.path().join("a");
        for bytes in [text.clone(), pack(&text), [pack(&text[..100]), pack(&text[100..])].concat()] {
            std::fs::write(&path, &bytes).expect("written");
            let mut streamed = Vec::new();
            unpacked(File::open(&path).expect("there"), &path).expect("read").read_to_end(&mut streamed).expect("read");
            assert_eq!((unpack(bytes, &path).expect("unpacked").len(), streamed.len()), (8000, 8000));
            assert!(streamed == text);
        }
    }

    /// A bomb is refused at a limit of 1000 bytes and passes at its own size of 1001. Cut at any
    /// byte after the first two it is refused, too, and the message names the file.
    #[test]
    fn bombs_and_cut_files_are_refused() {
        let file = Path::new("town.obj.gz");
        let packed = pack(&[b'7'; 1001]);
        let message = unpack_up_to(1000, packed.clone(), file).expect_err("too long").to_string();
        assert!(message.starts_with("town.obj.gz: unpacks to more than 1000 bytes\n  to fix: "), "{message}");
        assert_eq!(unpack_up_to(1001, packed.clone(), file).expect("short enough").len(), 1001);
        for end in 2..packed.len() {
            let message = unpack(packed[..end].to_vec(), file).expect_err("cut").to_string();
            assert!(message.starts_with("town.obj.gz: the gzip data cannot be unpacked beyond byte"), "{message}");
        }
        let limits = [1 << 10, 2 << 20, 1 << 30].map(most);
        assert_eq!(limits, [256 << 20, 400 << 20, 4 << 30]);
        let mut bounded = Bounded { inner: &packed[..], left: 9 };
        let found = bounded.read(&mut [0; 20]).expect_err("too long").to_string();
        assert!(found.contains("unpacks to more than 68719476736 bytes"), "{found}");
    }
}
