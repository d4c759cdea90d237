//! Decoders of zstd frames. In: a frame whose header was checked, and room for exactly the bytes it
//! declares. Out: the bytes, or an error. The decoder is the C library where it is compiled,
//! otherwise one in Rust; the two give the same bytes.

use std::cell::RefCell;

/// Function that decodes a frame into the room. It returns the number of bytes, at most the length
/// of the room, or the reason why the frame cannot be decoded.
pub type Unpack = fn(&[u8], &mut [u8]) -> Result<usize, String>;

/// The decoder that archives are read with.
#[cfg(feature = "zstd")]
pub const UNPACK: Unpack = by_zstd;

/// The decoder that archives are read with.
#[cfg(not(feature = "zstd"))]
pub const UNPACK: Unpack = by_ruzstd;

/// Decodes with the C library.
#[cfg(feature = "zstd")]
pub fn by_zstd(frame: &[u8], room: &mut [u8]) -> Result<usize, String> {
    thread_local! {
        /// One decoder a thread, because making one takes longer (10 us) than decoding a small
        /// block.
        static DECODER: RefCell<zstd::bulk::Decompressor<'static>> = RefCell::default();
    }
    DECODER.with_borrow_mut(|decoder| decoder.decompress_to_buffer(frame, room)).map_err(|error| error.to_string())
}

/// Decodes with the decoder in Rust. It allocates a window, whose size the frame states, before it
/// copies. A window that is larger than any block is refused before that.
#[cfg(any(test, not(feature = "zstd")))]
pub fn by_ruzstd(frame: &[u8], room: &mut [u8]) -> Result<usize, String> {
    use ruzstd::decoding::FrameDecoder;

    use crate::archive::format::MAX_RAW;

    thread_local! {
        /// One decoder a thread, with its window.
        static DECODER: RefCell<FrameDecoder> = RefCell::new({
            let mut decoder = FrameDecoder::new();
            decoder.set_max_window_size(MAX_RAW as u64);
            decoder
        });
    }
    DECODER.with_borrow_mut(|decoder| decoder.decode_all(frame, room)).map_err(|error| error.to_string())
}

#[cfg(all(test, feature = "zstd"))]
pub mod tests {
    use super::*;
    use crate::archive::format::MAX_RAW;
    use zstd::zstd_safe::CParameter;

    /// Deterministic numbers: xorshift64*, Vigna 2016.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> u64 {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
        }

        fn below(&mut self, end: usize) -> usize {
            (self.next() % end as u64) as usize
        }
    }

    fn pack(raw: &[u8], level: i32) -> Vec<u8> {
        let mut packer = zstd::bulk::Compressor::new(level).unwrap();
        packer.set_parameter(CParameter::ChecksumFlag(level == 19)).unwrap();
        packer.compress(raw).unwrap()
    }

    /// Returns raw bytes and their frames: runs, noise, counters, bits and repeated pieces of many
    /// lengths, packed at three levels, and one of 8 MiB whose window is smaller.
    pub fn frames() -> Vec<(Vec<u8>, Vec<u8>)> {
        let mut random = Random(7);
        let mut frames = Vec::new();
        for (i, length) in [2, 9, 255, 256, 1000, 4096, 65_535, 65_536, 65_792, 131_073, 400_000].iter().enumerate() {
            let kinds: [Vec<u8>; 5] = [
                vec![i as u8; *length],
                (0..*length).map(|_| random.next() as u8).collect(),
                (0..*length as u32).flat_map(|n| (n / 3).to_le_bytes()).take(*length).collect(),
                (0..*length).map(|_| 1 << random.below(3)).collect(),
                {
                    let mut bytes: Vec<u8> = (0..*length.min(&700)).map(|_| random.next() as u8).collect();
                    while bytes.len() < *length {
                        let start = random.below(bytes.len());
                        let end = (start + 1 + random.below(90)).min(bytes.len());
                        bytes.extend_from_within(start..end);
                        bytes.push(random.next() as u8);
                    }
                    bytes.truncate(*length);
                    bytes
                },
            ];
            let level = [1, 9, 19][i % 3];
            frames.extend(kinds.into_iter().map(|raw| {
                let frame = pack(&raw, level);
                (raw, frame)
            }));
        }
        let large: Vec<u8> = (0..MAX_RAW as u32 / 4).flat_map(|n| (n.wrapping_mul(n) >> 9).to_le_bytes()).collect();
        let frame = pack(&large, 1);
        frames.push((large, frame));
        frames
    }

    /// Iterates over copies of the frame with one to three bytes changed, one byte removed or the
    /// end cut off; most changes lie in the first hundred bytes.
    pub fn mutations(frame: &[u8], count: u64) -> impl Iterator<Item = Vec<u8>> {
        (0..count).map(move |seed| {
            let mut random = Random(0x9e37_79b9 + seed * 77 + frame.len() as u64);
            // Long frames are cut first, because a decoder fails or not in the first bytes.
            let mut bytes = frame[..frame.len().min(6000)].to_vec();
            random.next();
            match random.below(6) {
                0 => bytes.truncate(random.below(bytes.len()) + 1),
                1 => {
                    let at = random.below(bytes.len());
                    bytes.remove(at);
                }
                more => {
                    for _ in 0..more.div_ceil(2) {
                        let end = if random.below(3) == 0 { bytes.len() } else { bytes.len().min(100) };
                        let at = random.below(end);
                        bytes[at] = random.next() as u8;
                    }
                }
            }
            bytes
        })
    }

    /// The two decoders give back the raw bytes of 56 frames.
    #[test]
    fn both_decoders_give_back_the_raw_bytes() {
        let frames = frames();
        for (raw, frame) in &frames {
            for unpack in [by_zstd, by_ruzstd] {
                let mut room = vec![0; raw.len()];
                assert_eq!(unpack(frame, &mut room), Ok(raw.len()));
                assert!(room == *raw, "{} bytes", raw.len());
            }
        }
        assert_eq!(frames.len(), 56);
    }

    /// None of 28,000 changed frames ends the program or writes past its room, with either decoder.
    /// Where both decode one, more than 1000 times, they give the same bytes.
    #[test]
    fn damaged_frames_end_neither_decoder() {
        let (mut both, mut count) = (0, 0);
        for (raw, frame) in frames() {
            for changed in mutations(&frame, 500) {
                let mut rooms = [vec![0; raw.len().min(200_000)], vec![0; raw.len().min(200_000)]];
                let [a, b] = &mut rooms;
                if let (Ok(a_filled), Ok(b_filled)) = (by_zstd(&changed, a), by_ruzstd(&changed, b)) {
                    assert_eq!((a_filled, &a[..a_filled]), (b_filled, &b[..b_filled]));
                    both += 1;
                }
                count += 1;
            }
        }
        assert_eq!(count, 28_000);
        assert!(both > 1000, "only {both} were decoded by both");
    }

    /// A window of 16 MiB that no block needs is refused by the decoder that would allocate it; one
    /// of 8 MiB is not.
    #[test]
    fn a_window_larger_than_blocks_need_is_refused() {
        // Magic, content size of 2 bytes, window, 744 + 256 bytes; one last block that repeats a
        // byte 1000 times.
        let frame =
            |window: u8| [&[0x28, 0xb5, 0x2f, 0xfd, 0x40, window, 0xe8, 0x02][..], &[0x43, 0x1f, 0, 7][..]].concat();
        let mut room = [0; 1000];
        for (exponent, good) in [(13, true), (14, false)] {
            let found = by_ruzstd(&frame(exponent << 3), &mut room);
            assert_eq!(found.is_ok(), good, "{found:?}");
            assert_eq!(by_zstd(&frame(exponent << 3), &mut room), Ok(1000));
        }
        assert_eq!(room, [7; 1000]);
    }
}
