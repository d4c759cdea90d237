//! Blocks as they are stored. In: stored bytes and their directory entry. Out: raw bytes of a layer
//! or table, guarded: nothing is decoded before its checksum is right, and nothing decodes into
//! more than the entry's length, 8 MiB at most.

use std::path::Path;
use std::sync::Arc;

use rkyv::util::AlignedVec;

use crate::archive::codec::frame::ZstdFrame;
use crate::archive::codec::unpack::{UNPACK, Unpack};
use crate::archive::format;
use crate::archive::format::{BlockKind, CODEC_RAW, CODEC_ZSTD, Entry, MAX_RAW};
use crate::error::{Error, Result};

/// Raw bytes of a block, aligned for the numbers of any table.
pub type AlignedBytes = AlignedVec<16>;

/// A block that is ready to be written; its entry has no offset yet.
#[derive(Clone, Debug)]
pub struct EncodedBlock {
    /// Directory entry: kind, tile, lengths, checksum and content id. The offset is 0 until a
    /// writer places the block.
    pub entry: Entry,
    /// Bytes as they go into the file, by `entry.codec`.
    pub stored: Vec<u8>,
}

impl EncodedBlock {
    /// Returns the bytes as they stand in the file.
    pub fn stored(&self) -> &[u8] {
        &self.stored
    }

    /// Returns the directory entry; its offset is set on writing.
    pub fn entry(&self) -> &Entry {
        &self.entry
    }
}

/// A decoded block.
#[derive(Clone, Debug)]
pub struct Block {
    path: Arc<Path>,
    entry: Entry,
    bytes: AlignedBytes,
}

impl Block {
    /// Returns the raw bytes; the first one is 16-byte aligned.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the number of rows of the block.
    pub fn items(&self) -> u32 {
        self.entry.items
    }

    /// Returns the directory entry that the block was found by.
    pub fn entry(&self) -> &Entry {
        &self.entry
    }

    /// Returns an error that names this block, for readers of its content.
    pub fn corrupt(&self, got: impl Into<String>, expected: impl Into<String>) -> Error {
        corrupt(&self.path, &self.entry, got, expected)
    }

    /// Refuses a block of other kinds than these, or of a layout that this release does not know.
    pub fn require(&self, kinds: &[BlockKind]) -> Result<()> {
        if !kinds.contains(&self.entry.kind) {
            let names: Vec<String> = kinds.iter().map(|kind| format::kind_name(*kind)).collect();
            return Err(self.corrupt(self.entry.name(), format!("a block of kind {}", names.join(" or "))));
        }
        let known = format::schema_of(self.entry.kind);
        if known == Some(self.entry.schema) {
            return Ok(());
        }
        Err(Error::Unsupported {
            what: format!("{}: layout of block {}", self.path.display(), self.entry.name()).into(),
            found: format!("schema id {}", self.entry.schema),
            supported: match known {
                None => "no layout of this kind".into(),
                Some(id) => format!("schema id {id}: build the archive again with this release").into(),
            },
        })
    }

    /// Checks that the raw bytes are those that the directory names. The checksum of stored bytes,
    /// which every read checks, finds damage. This check also finds a block that was swapped on
    /// purpose.
    pub fn check_content(&self) -> Result<()> {
        let found = format::content_id(self.entry.kind, self.entry.schema, &self.bytes);
        if found == self.entry.content {
            return Ok(());
        }
        Err(self.corrupt(
            format!("content {}", format::hex(&found)),
            format!("content {}", format::hex(&self.entry.content)),
        ))
    }
}

/// Checks and decodes stored bytes. The caller owns them, so they cannot change meanwhile.
pub fn decode(path: &Arc<Path>, entry: &Entry, stored: &[u8]) -> Result<Block> {
    decode_by(UNPACK, path, entry, stored)
}

fn decode_by(unpack: Unpack, path: &Arc<Path>, entry: &Entry, stored: &[u8]) -> Result<Block> {
    let wrong = |got: String, expected: String| corrupt(path, entry, got, expected);
    check_stored(path, entry, stored)?;
    // The reader checked this when it opened the directory. The check is repeated here because
    // memory is allocated by it.
    let length = usize::try_from(entry.raw).unwrap_or(usize::MAX);
    if length == 0 || length > MAX_RAW {
        return Err(wrong(format!("raw length {length}"), format!("1 to {MAX_RAW}")));
    }
    let mut bytes = AlignedBytes::with_capacity(length);
    match entry.codec {
        CODEC_RAW if stored.len() == length => bytes.extend_from_slice(stored),
        CODEC_RAW => return Err(wrong(format!("{} raw bytes", stored.len()), format!("{length} bytes"))),
        CODEC_ZSTD => {
            check_frame(stored, length).map_err(|(got, expected)| wrong(got, expected))?;
            bytes.resize(length, 0);
            match unpack(stored, bytes.as_mut_slice()) {
                Ok(filled) if filled == length => {}
                Ok(filled) => return Err(wrong(format!("{filled} decoded bytes"), format!("{length} bytes"))),
                Err(e) => {
                    return Err(wrong(format!("a zstd frame that fails with \"{e}\""), format!("{length} bytes")));
                }
            }
        }
        other => {
            return Err(Error::Unsupported {
                what: format!("{}: codec of block {}", path.display(), entry.name()).into(),
                found: other.to_string(),
                supported: "0 (raw) and 1 (zstd)".into(),
            });
        }
    }
    Ok(Block { path: Arc::clone(path), entry: *entry, bytes })
}

/// Checks that stored bytes are those that were written.
pub fn check_stored(path: &Path, entry: &Entry, stored: &[u8]) -> Result<()> {
    let found = format::checksum(stored);
    if found == entry.checksum {
        return Ok(());
    }
    let [got, expected] = [found, entry.checksum].map(|sum| format!("checksum {}", format::hex(&sum)));
    Err(corrupt(path, entry, got, expected))
}

/// Checks that the bytes are one whole frame that declares `length` bytes, so that a decompression
/// bomb is refused before anything is decoded.
fn check_frame(stored: &[u8], length: usize) -> std::result::Result<(), (String, String)> {
    let frame = ZstdFrame::at_start_of(stored);
    let frame =
        frame.ok_or_else(|| ("bytes that are no zstd frame".to_string(), format!("a zstd frame of {length} bytes")))?;
    match frame.content {
        Some(size) if size == length as u64 => {}
        Some(size) => return Err((format!("a zstd frame of {size} bytes"), format!("{length} bytes"))),
        None => return Err(("a zstd frame without a size".to_string(), format!("{length} bytes"))),
    }
    match frame.stored {
        Some(size) if size == stored.len() => Ok(()),
        Some(size) => Err((format!("a zstd frame stored in {size} bytes"), format!("{} bytes", stored.len()))),
        None => Err(("a broken zstd frame".to_string(), format!("a zstd frame of {} stored bytes", stored.len()))),
    }
}

/// Returns the error of a damaged block.
pub fn corrupt(path: &Path, entry: &Entry, got: impl Into<String>, expected: impl Into<String>) -> Error {
    Error::corrupt(path, entry.name(), entry.offset, got, expected)
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::codec::pack::{DEFAULT_LEVEL, encode};
    use crate::archive::codec::unpack::{by_ruzstd, by_zstd};

    fn path() -> Arc<Path> {
        Arc::from(Path::new("site.helio"))
    }

    /// Bytes come back unchanged from the two decoders, 16-byte aligned: 4000 equal ones are stored
    /// in fewer than 40, 256 different ones raw.
    #[test]
    fn blocks_round_trip() {
        for (raw, codec) in [(vec![7_u8; 4000], CODEC_ZSTD), ((0..=255).collect(), CODEC_RAW)] {
            let block = encode(format::SKY, format::TileNumber(5), 1, 64, &raw, DEFAULT_LEVEL).unwrap();
            assert_eq!(block.entry.codec, codec);
            assert!(block.stored.len() < 40 || codec == CODEC_RAW);
            for unpack in [by_zstd, by_ruzstd] {
                let back = decode_by(unpack, &path(), &block.entry, &block.stored).unwrap();
                assert_eq!((back.bytes(), back.items()), (&raw[..], 64));
                assert_eq!(back.bytes().as_ptr() as usize % 16, 0);
                back.check_content().unwrap();
            }
        }
    }

    /// A frame of 1 GiB in 33 kB, a frame without a size, two frames and a truncated frame are
    /// errors, each with a right checksum: 4 of 4 are refused by the two decoders, and none
    /// allocates more than the 1000 bytes that the entry states.
    #[test]
    fn decompression_bombs_are_refused() {
        let good = encode(format::SKY, format::TileNumber::FIRST, 1, 1, &[0; 1000], 9).unwrap();
        let gibibyte = zstd::stream::encode_all(std::io::Read::take(std::io::repeat(0), 1 << 30), 1).unwrap();
        let bomb = {
            let mut encoder = zstd::stream::Encoder::new(Vec::new(), 1).unwrap();
            encoder.set_pledged_src_size(Some(1 << 30)).unwrap();
            std::io::copy(&mut std::io::Read::take(std::io::repeat(0), 1 << 30), &mut encoder).unwrap();
            encoder.finish().unwrap()
        };
        let twice = [good.stored.clone(), good.stored.clone()].concat();
        let short = good.stored[..good.stored.len() - 1].to_vec();
        for stored in [gibibyte, bomb, twice, short] {
            let entry = Entry {
                checksum: format::checksum(&stored),
                stored: stored.len() as u32,
                codec: CODEC_ZSTD,
                ..good.entry
            };
            for unpack in [by_zstd, by_ruzstd] {
                let error = decode_by(unpack, &path(), &entry, &stored).unwrap_err();
                assert!(matches!(&error, Error::Corrupt { block, .. } if block == "sky/0"), "{error}");
            }
        }
    }
}
