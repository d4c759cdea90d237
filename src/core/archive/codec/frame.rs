//! The outside of a zstd frame (RFC 8878, section 3.1.1). In: stored bytes. Out: how many bytes the frame says it holds, and where it ends,
//! both without decoding. Never: allocation.

/// What the header and the blocks' lengths of one frame say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZstdFrame {
    /// Bytes that it decodes to, where it says so.
    pub content: Option<u64>,
    /// Bytes that it is stored in; `None` if it has no end in the bytes given.
    pub stored: Option<usize>,
}

const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A window of 2^31 bytes is the largest that the reference decoder knows; that is 10 more than the exponent says.
const MAX_WINDOW_EXPONENT: u8 = 21;

impl ZstdFrame {
    /// The frame at the start of `bytes`; `None` if there is none.
    pub fn at_start_of(bytes: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(&MAGIC)?;
        let (&descriptor, mut rest) = rest.split_first()?;
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
        // Bytes of the dictionary's id.
        rest = rest.get([0, 1, 2, 4].into_iter().nth(usize::from(descriptor & 3))?..)?;
        let size = match descriptor >> 6 {
            0 => usize::from(single_segment),
            flag => 1_usize << flag,
        };
        let (number, rest) = rest.split_at_checked(size)?;
        let number = number.iter().rev().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte));
        let content = match size {
            0 => None,
            // The sizes below 256 have one byte.
            2 => Some(number.saturating_add(256)),
            _ => Some(number),
        };
        let checksum = if descriptor & 4 != 0 { 4 } else { 0 };
        let after = after_blocks(rest).and_then(|after| after.get(checksum..));
        Some(ZstdFrame { content, stored: after.and_then(|after| bytes.len().checked_sub(after.len())) })
    }
}

/// What follows the last block.
fn after_blocks(mut bytes: &[u8]) -> Option<&[u8]> {
    loop {
        let (header, rest) = bytes.split_first_chunk::<3>()?;
        let [a, b, c] = header.map(usize::from);
        let header = a | b << 8 | c << 16;
        let length = match header >> 1 & 3 {
            // One byte that is repeated.
            1 => 1,
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

    /// Of 56 frames of three levels and 16,800 changed ones, content size and stored size are those that the reference library
    /// finds; more than 4000 of them have an end.
    #[test]
    fn sizes_are_those_of_the_reference() {
        let frames = frames();
        let (mut count, mut whole) = (0, 0);
        for frame in frames.iter().flat_map(|(_, frame)| std::iter::once(frame.clone()).chain(mutations(frame, 300))) {
            let theirs = zstd_safe::get_frame_content_size(&frame).ok();
            // A frame to be skipped has no content for them, and is none for us.
            let skipped = frame.get(1..4) == Some(&[0x2a, 0x4d, 0x18]);
            let ours = ZstdFrame::at_start_of(&frame);
            // Frames of zstd before 0.8, which the library reads where another crate asks for that.
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
