//! Packing of blocks. In: raw bytes of a layer or table. Out: stored bytes with their directory
//! entry.

use zstd::zstd_safe::{self, CParameter};

use crate::archive::codec::block::EncodedBlock;
use crate::archive::format;
use crate::archive::format::{BlockKind, CODEC_RAW, CODEC_ZSTD, Entry, MAX_RAW, TileNumber};
use crate::error::{Error, Result};

/// Compression level of finished archives: 295 MB/s on tiles of sky bits. Level 19 takes 15 times
/// as long for 10-25 % less.
pub const DEFAULT_LEVEL: i32 = 9;

/// Returns the version of the library that compresses; another version may give other bytes.
pub fn compressor_version() -> &'static str {
    zstd_safe::version_string()
}

/// Compresses a block (levels 1 to 22; use [`DEFAULT_LEVEL`]), or keeps it raw where that is not
/// longer. Equal input gives equal bytes, on any thread.
pub fn encode(
    kind: BlockKind,
    tile: TileNumber,
    schema: u16,
    items: u32,
    raw: &[u8],
    level: i32,
) -> Result<EncodedBlock> {
    let name = || format::block_name(kind, tile);
    let too_long = || Error::Limit {
        what: format!("raw length of block {} in bytes (at least 1)", name()).into(),
        value: raw.len() as u64,
        max: MAX_RAW as u64,
    };
    if raw.is_empty() || raw.len() > MAX_RAW {
        return Err(too_long());
    }
    let packed = compress(raw, level).map_err(|found| Error::Unsupported {
        what: format!("compressing block {}", name()).into(),
        found,
        supported: "zstd levels 1 to 22".into(),
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

/// Returns one frame with its content size, without checksum, dictionary or threads.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths 0 and 8 MiB + 1 are refused, 8 MiB is not.
    #[test]
    fn raw_lengths_beyond_the_limits_are_refused() {
        let raw = vec![0; MAX_RAW + 1];
        for (length, good) in [(0, false), (MAX_RAW, true), (MAX_RAW + 1, false)] {
            assert_eq!(
                encode(format::SKY, format::TileNumber::FIRST, 1, 1, &raw[..length], 1).is_ok(),
                good,
                "{length}"
            );
        }
        assert!(encode(format::SKY, format::TileNumber::FIRST, 1, 1, b"a", 23).is_err());
    }

    /// Eight threads compress one block to the same bytes as a first run.
    #[test]
    fn threads_compress_a_block_to_equal_bytes() {
        let raw: Vec<u8> = (0..200_000_u32).map(|i| (i.wrapping_mul(i) >> 9) as u8).collect();
        let first = encode(format::HIT, format::TileNumber(1), 1, 64, &raw, 9).unwrap().stored;
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..8)
                .map(|_| scope.spawn(|| encode(format::HIT, format::TileNumber(1), 1, 64, &raw, 9).unwrap().stored))
                .collect();
            assert_eq!(all.into_iter().map(|t| t.join().unwrap()).filter(|s| *s == first).count(), 8);
        });
    }
}
