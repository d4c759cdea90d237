//! The outside of a zstd frame (RFC 8878, section 3.1.1). In: stored bytes. Out: the number of
//! bytes that the frame declares, and its end, found without decoding. Never: allocation.

/// Sizes of one frame, from its header and the lengths of its blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZstdFrame {
    /// Bytes that the frame decodes to, if the header declares them.
    pub content: Option<u64>,
    /// Bytes that the frame is stored in; `None` if it has no end in the bytes given.
    pub stored: Option<usize>,
}

const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Largest window exponent in a header. It stands for a window of 2^31 bytes, the largest that the
/// reference decoder knows; the header states 10 less.
const MAX_WINDOW_EXPONENT: u8 = 21;

impl ZstdFrame {
    /// Returns the frame at the start of `bytes`; `None` if there is none.
    pub fn at_start_of(bytes: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(&MAGIC)?;
        let (&descriptor, mut rest) = rest.split_first()?;
        // The reserved bit: a decoder must refuse what it may come to mean (section 3.1.1.1.1.4).
        if descriptor & 8 != 0 {
            return None;
        }
        let single_segment = descriptor & 32 != 0;
        if !single_segment {
            let (&window, after) = rest.split_first()?;
            if window >> 3 > MAX_WINDOW_EXPONENT {
                return None;
            }
            rest = after;
        }
        // The dictionary's id takes 0, 1, 2 or 4 bytes (3.1.1.1.3). The size does not depend on it.
        rest = rest.get([0, 1, 2, 4].into_iter().nth(usize::from(descriptor & 3))?..)?;
        let size = match descriptor >> 6 {
            // Flag 0 has no size, except in a single segment, which always states one (3.1.1.1.4).
            0 => usize::from(single_segment),
            flag => 1_usize << flag,
        };
        let (number, rest) = rest.split_at_checked(size)?;
        let number = number.iter().rev().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte));
        let content = match size {
            0 => None,
            // Sizes below 256 take one byte, so two bytes count from 256.
            2 => Some(number.saturating_add(256)),
            _ => Some(number),
        };
        let checksum = if descriptor & 4 != 0 { 4 } else { 0 };
        let after = after_blocks(rest).and_then(|after| after.get(checksum..));
        Some(ZstdFrame { content, stored: after.and_then(|after| bytes.len().checked_sub(after.len())) })
    }
}

/// Returns the bytes behind the last block.
fn after_blocks(mut bytes: &[u8]) -> Option<&[u8]> {
    loop {
        let (header, rest) = bytes.split_first_chunk::<3>()?;
        let [a, b, c] = header.map(usize::from);
        let header = a | b << 8 | c << 16;
        let length = match header >> 1 & 3 {
            // A byte that is repeated is stored once.
            1 => 1,
            // The reserved type (3.1.1.2.2).
            3 => return None,
            _ => header >> 3,
        };
        bytes = rest.get(length..)?;
        if header & 1 == 1 {
            return Some(bytes);
        }
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::codec::unpack::tests::{frames, mutations};
    use zstd::zstd_safe;

    /// For 56 frames of three levels and 16,800 changed ones, content size and stored size are
    /// those that the reference library finds. More than 4000 of them have an end.
    #[test]
    fn frame_sizes_equal_those_of_the_reference_library() {
        let frames = frames();
        let (mut count, mut whole) = (0, 0);
        for frame in frames.iter().flat_map(|(_, frame)| std::iter::once(frame.clone()).chain(mutations(frame, 300))) {
            let theirs = zstd_safe::get_frame_content_size(&frame).ok();
            // The reference library finds no content in a skippable frame; this reader takes it for
            // no frame.
            let skipped = frame.get(1..4) == Some(&[0x2a, 0x4d, 0x18]);
            let ours = ZstdFrame::at_start_of(&frame);
            // Frames of zstd before 0.8: the library reads them if another crate enables that.
            let legacy = matches!(frame.get(..4), Some([0x1e | 0x22..=0x27, 0xb5, 0x2f, 0xfd]));
            assert!(skipped || legacy || ours.map(|f| f.content) == theirs, "{ours:?} {theirs:?}");
            if let Some(ours) = ours {
                assert_eq!(ours.stored, zstd_safe::find_frame_compressed_size(&frame).ok(), "{ours:?}");
                whole += usize::from(ours.stored.is_some());
            }
            count += 1;
        }
        assert_eq!((frames.len(), count), (56, 16_856));
        assert!(whole > 4000, "only {whole} whole frames");
    }
}
