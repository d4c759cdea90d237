//! Blocks. In: raw bytes of a layer or table. Out: stored bytes with their directory entry, and back, guarded: nothing is
//! decoded before its checksum is right, and nothing decodes into more than the entry's length, 8 MiB at most.

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

use rkyv::util::AlignedVec;
use zstd::zstd_safe::{self, CParameter};

use crate::archive::format;
use crate::archive::format::{CODEC_RAW, CODEC_ZSTD, Entry, MAX_RAW};
use crate::error::{Error, Result};

/// Compression of finished archives: 295 MB/s on tiles of sky bits; level 19 takes 15 times as long for 10-25 % less.
pub const DEFAULT_LEVEL: i32 = 9;

/// Raw bytes of a block, aligned for the numbers of any table.
pub type AlignedBytes = AlignedVec<16>;

/// A block that is ready to be written; its entry has no offset yet.
#[derive(Clone, Debug)]
pub struct EncodedBlock {
    pub entry: Entry,
    pub stored: Vec<u8>,
}

impl EncodedBlock {
    /// Bytes as they stand in the file.
    pub fn stored(&self) -> &[u8] {
        &self.stored
    }

    /// What the directory will say of it; the offset is set on writing.
    pub fn entry(&self) -> &Entry {
        &self.entry
    }
}

/// Version of the library that compresses: another one may give other bytes.
pub fn compressor_version() -> &'static str {
    zstd_safe::version_string()
}

/// Compresses a block (levels 1 to 22; use [`DEFAULT_LEVEL`]), or keeps it raw where that is no longer. Equal input gives
/// equal bytes, on any thread.
pub fn encode(kind: u32, tile: u32, schema: u16, items: u32, raw: &[u8], level: i32) -> Result<EncodedBlock> {
    let name = || format::block_name(kind, tile);
    let too_long = || Error::Limit {
        what: format!("raw length of block {} in bytes (at least 1)", name()),
        value: raw.len() as u64,
        max: MAX_RAW as u64,
    };
    if raw.is_empty() || raw.len() > MAX_RAW {
        return Err(too_long());
    }
    let packed = compress(raw, level).map_err(|found| Error::Unsupported {
        what: format!("compressing block {}", name()),
        found,
        supported: "zstd levels 1 to 22".to_string(),
    })?;
    let (codec, stored) = if packed.len() < raw.len() { (CODEC_ZSTD, packed) } else { (CODEC_RAW, raw.to_vec()) };
    let entry = Entry {
        kind,
        tile,
        offset: 0,
        stored: u32::try_from(stored.len()).map_err(|_| too_long())?,
        raw: u32::try_from(raw.len()).map_err(|_| too_long())?,
        codec,
        schema,
        items,
        checksum: format::checksum(&stored),
        content: format::content_id(kind, schema, raw),
        reserved: [0; 8],
    };
    Ok(EncodedBlock { entry, stored })
}

/// One frame with its content size, without checksum, dictionary or threads.
fn compress(raw: &[u8], level: i32) -> std::result::Result<Vec<u8>, String> {
    if !(1..=22).contains(&level) {
        return Err(format!("level {level}"));
    }
    let mut packer = zstd::bulk::Compressor::new(level).map_err(|e| e.to_string())?;
    for parameter in [CParameter::ContentSizeFlag(true), CParameter::ChecksumFlag(false), CParameter::DictIdFlag(false)]
    {
        packer.set_parameter(parameter).map_err(|e| e.to_string())?;
    }
    packer.compress(raw).map_err(|e| e.to_string())
}

/// A block as it was given to [`encode`].
#[derive(Clone, Debug)]
pub struct Block {
    path: Arc<Path>,
    entry: Entry,
    bytes: AlignedBytes,
}

impl Block {
    /// Raw bytes; the first one is 16-byte aligned.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Rows of the block.
    pub fn items(&self) -> u32 {
        self.entry.items
    }

    pub fn entry(&self) -> &Entry {
        &self.entry
    }

    /// An error that names this block, for readers of its content.
    pub fn corrupt(&self, got: impl Into<String>, expected: impl Into<String>) -> Error {
        corrupt(&self.path, &self.entry, got, expected)
    }

    /// Refuses a block of another kind, or of a layout that this release does not know.
    pub fn require(&self, kind: u32) -> Result<()> {
        if self.entry.kind != kind {
            return Err(self.corrupt(self.entry.name(), format!("a block of kind {}", format::kind_name(kind))));
        }
        let known = format::schemas_read(kind);
        if known.contains(&self.entry.schema) {
            return Ok(());
        }
        let known: Vec<String> = known.iter().map(u16::to_string).collect();
        Err(Error::Unsupported {
            what: format!("{}: layout of block {}", self.path.display(), self.entry.name()),
            found: format!("schema id {}", self.entry.schema),
            supported: match known.as_slice() {
                [] => "none of this kind".to_string(),
                ids => format!("schema id {}; build the archive again with this release", ids.join(" or ")),
            },
        })
    }

    /// Whether the raw bytes are those that the directory names; the checksum of stored bytes, which every read checks,
    /// finds damage, and this finds a block that was swapped with knowledge.
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

thread_local! {
    /// One decoder a thread: making one takes longer (10 us) than decoding a small block.
    static UNPACKER: RefCell<zstd::bulk::Decompressor<'static>> = RefCell::default();
}

/// Checks and decodes stored bytes, which the caller owns: nobody else can change them meanwhile.
pub fn decode(path: &Arc<Path>, entry: &Entry, stored: &[u8]) -> Result<Block> {
    let wrong = |got: String, expected: String| corrupt(path, entry, got, expected);
    check_stored(path, entry, stored)?;
    // The reader asked this when it opened the directory; it stands here too because here it is allocated.
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
            match UNPACKER.with_borrow_mut(|unpacker| unpacker.decompress_to_buffer(stored, bytes.as_mut_slice())) {
                Ok(filled) if filled == length => {}
                Ok(filled) => return Err(wrong(format!("{filled} decoded bytes"), format!("{length} bytes"))),
                Err(e) => {
                    return Err(wrong(format!("a zstd frame that fails with \"{e}\""), format!("{length} bytes")));
                }
            }
        }
        other => {
            return Err(Error::Unsupported {
                what: format!("{}: codec of block {}", path.display(), entry.name()),
                found: other.to_string(),
                supported: "0 (raw) and 1 (zstd)".to_string(),
            });
        }
    }
    Ok(Block { path: Arc::clone(path), entry: *entry, bytes })
}

/// Whether stored bytes are those that were written.
pub fn check_stored(path: &Path, entry: &Entry, stored: &[u8]) -> Result<()> {
    let found = format::checksum(stored);
    if found == entry.checksum {
        return Ok(());
    }
    let [got, expected] = [found, entry.checksum].map(|sum| format!("checksum {}", format::hex(&sum)));
    Err(corrupt(path, entry, got, expected))
}

/// One whole frame that says it holds `length` bytes: a bomb is refused before anything is decoded.
fn check_frame(stored: &[u8], length: usize) -> std::result::Result<(), (String, String)> {
    match zstd_safe::get_frame_content_size(stored) {
        Ok(Some(size)) if size == length as u64 => {}
        Ok(Some(size)) => return Err((format!("a zstd frame of {size} bytes"), format!("{length} bytes"))),
        Ok(None) => return Err(("a zstd frame without a size".to_string(), format!("{length} bytes"))),
        Err(_) => return Err(("no zstd frame".to_string(), format!("a zstd frame of {length} bytes"))),
    }
    match zstd_safe::find_frame_compressed_size(stored) {
        Ok(size) if size == stored.len() => Ok(()),
        Ok(size) => Err((format!("a zstd frame stored in {size} bytes"), format!("{} bytes", stored.len()))),
        Err(_) => Err(("a broken zstd frame".to_string(), format!("one of {} stored bytes", stored.len()))),
    }
}

/// Damage of one block.
pub fn corrupt(path: &Path, entry: &Entry, got: impl Into<String>, expected: impl Into<String>) -> Error {
    Error::Corrupt {
        path: path.to_path_buf(),
        block: entry.name(),
        offset: entry.offset,
        got: got.into(),
        expected: expected.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path() -> Arc<Path> {
        Arc::from(Path::new("site.helio"))
    }

    /// Bytes come back as they were, 16-byte aligned: 4000 equal ones in fewer than 40, 256 different ones raw.
    #[test]
    fn blocks_round_trip() {
        for (raw, codec) in [(vec![7_u8; 4000], CODEC_ZSTD), ((0..=255).collect(), CODEC_RAW)] {
            let block = encode(2, 5, 1, 64, &raw, DEFAULT_LEVEL).unwrap();
            assert_eq!(block.entry.codec, codec);
            assert!(block.stored.len() < 40 || codec == CODEC_RAW);
            let back = decode(&path(), &block.entry, &block.stored).unwrap();
            assert_eq!((back.bytes(), back.items()), (&raw[..], 64));
            assert_eq!(back.bytes().as_ptr() as usize % 16, 0);
            back.check_content().unwrap();
        }
    }

    /// Lengths 0 and 8 MiB + 1 are refused, 8 MiB is not.
    #[test]
    fn raw_lengths_are_limited() {
        let raw = vec![0; MAX_RAW + 1];
        for (length, good) in [(0, false), (MAX_RAW, true), (MAX_RAW + 1, false)] {
            assert_eq!(encode(2, 0, 1, 1, &raw[..length], 1).is_ok(), good, "{length}");
        }
        assert!(encode(2, 0, 1, 1, b"a", 23).is_err());
    }

    /// A frame of 1 GiB in 33 kB, a frame without a size, two frames and a truncated frame are errors, each with a right
    /// checksum: 4 of 4 are refused, none allocates more than the 1000 bytes that the entry states.
    #[test]
    fn bombs_are_refused() {
        let good = encode(2, 0, 1, 1, &[0; 1000], 9).unwrap();
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
            let error = decode(&path(), &entry, &stored).unwrap_err();
            assert!(matches!(&error, Error::Corrupt { block, .. } if block == "sky/0"), "{error}");
        }
    }

    /// Eight threads compress one block to the same bytes as the first.
    #[test]
    fn threads_agree() {
        let raw: Vec<u8> = (0..200_000_u32).map(|i| (i.wrapping_mul(i) >> 9) as u8).collect();
        let first = encode(3, 1, 1, 64, &raw, 9).unwrap().stored;
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..8).map(|_| scope.spawn(|| encode(3, 1, 1, 64, &raw, 9).unwrap().stored)).collect();
            assert_eq!(all.into_iter().map(|t| t.join().unwrap()).filter(|s| *s == first).count(), 8);
        });
    }
}
