//! Text of unknown origin. In: bytes of a text file. Out: text in UTF-8, and short quotations for
//! messages.

/// Returns a quotation for a message: at most 60 characters, without control characters.
pub fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 60;
    // Four bytes a character at most, so this is never short of what is shown.
    let head = bytes.get(..4 * LONGEST + 4).unwrap_or(bytes);
    let text = String::from_utf8_lossy(head);
    let mut shown: String = text.chars().take(LONGEST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push_str("...");
    }
    shown
}

/// Returns the 1-based number of the line that holds the byte at `offset`.
pub fn line_of_offset(bytes: &[u8], offset: usize) -> usize {
    let before = bytes.get(..offset).unwrap_or(bytes);
    before.iter().filter(|&&byte| byte == b'\n').count() + 1
}

/// Returns text as UTF-8. UTF-16, known by its byte order mark or by the zeros of its first
/// letters, is converted; everything else stays as it is.
pub fn utf8(bytes: Vec<u8>) -> Vec<u8> {
    const LOOKED_AT: usize = 64;
    let zeros = |odd: usize| {
        let head = bytes.get(..bytes.len().min(LOOKED_AT) / 2 * 2).unwrap_or_default();
        // In UTF-16 of plain letters every other byte is a zero, and no other byte is.
        head.len() >= 4 && head.iter().enumerate().all(|(i, byte)| (*byte == 0) == (i % 2 == odd))
    };
    let little = match bytes.as_slice() {
        [0xff, 0xfe, ..] => true,
        [0xfe, 0xff, ..] => false,
        _ if zeros(1) => true,
        _ if zeros(0) => false,
        _ => return bytes,
    };
    let unit = |pair: &[u8; 2]| if little { u16::from_le_bytes(*pair) } else { u16::from_be_bytes(*pair) };
    let units = bytes.as_chunks::<2>().0.iter().map(unit);
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or('\u{fffd}')).collect();
    text.trim_start_matches('\u{feff}').to_owned().into_bytes()
}

/// Returns a text without its byte order mark.
pub fn without_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four spellings of a text in UTF-16 become UTF-8; five texts that are not UTF-16 stay as they
    /// are.
    #[test]
    fn utf_16_becomes_utf_8() {
        let text = "v 1 \u{e9}\nf";
        for little in [true, false] {
            let pair = |unit: u16| if little { unit.to_le_bytes() } else { unit.to_be_bytes() };
            let plain: Vec<u8> = "v 1 0\nf".encode_utf16().flat_map(pair).collect();
            assert_eq!(utf8(plain), b"v 1 0\nf");
            let marked: Vec<u8> = std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(pair).collect();
            assert_eq!(utf8(marked), text.as_bytes());
        }
        for bytes in [&b"v 1\0 0"[..], b"\0\0\0\0\0\0", b"v\0f", b"", "\u{feff}v".as_bytes()] {
            assert_eq!(utf8(bytes.to_vec()), bytes);
        }
    }

    /// A quotation is at most 60 characters and free of control codes.
    #[test]
    fn a_quotation_is_short_and_printable() {
        assert_eq!(excerpt(b"a\x1b[31m\xff"), "a\u{fffd}[31m\u{fffd}");
        assert_eq!(excerpt(&[b'x'; 100_000]).chars().count(), 63);
        assert_eq!(excerpt("\u{20ac}".repeat(60).as_bytes()).chars().count(), 60);
    }
}
