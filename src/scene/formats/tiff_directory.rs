//! The directory of a TIFF file, looked through before the decoder sees it: the crate allocates what a tag claims, 256 MiB at most, before
//! it finds that the file ends. In: the bytes of a file. Out: nothing, or a sentence on the tag whose values cannot be there.

/// Checks that the values of every tag of the first directory lie in the file (TIFF 6.0, section 2; BigTIFF). What is no TIFF at all, or
/// ends within its header, is left to the decoder.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    // Bytes of a value by its type, from 1 on.
    const SIZES: [u64; 18] = [1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 1, 1, 8, 8, 8];
    let little = bytes.starts_with(b"II");
    let number = |at: u64, length: u64| -> Option<u64> {
        let from = usize::try_from(at).ok()?;
        let found = bytes.get(from..from.checked_add(length as usize)?)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(if little { found.iter().rev().fold(0, add) } else { found.iter().fold(0, add) })
    };
    let walk = || -> Option<Result<(), String>> {
        // Lengths of a directory's count, of a tag, of a number in it.
        let (start, head, tag, wide) = match number(2, 2)? {
            42 => (number(4, 4)?, 2, 12, 4),
            43 => (number(8, 8)?, 8, 20, 8),
            _ => return None,
        };
        for i in 0..number(start, head)? {
            let at = start.checked_add(head)?.checked_add(i.checked_mul(tag)?)?;
            let (name, kind, count) = (number(at, 2)?, number(at + 2, 2)?, number(at + 4, wide)?);
            let size = SIZES.get((kind as usize).wrapping_sub(1)).copied().unwrap_or(8);
            let needed = count.saturating_mul(size);
            let value = at + 4 + wide;
            let place = if needed <= wide { value } else { number(value, wide)? };
            if place.saturating_add(needed) > bytes.len() as u64 {
                return Some(Err(format!(
                    "tag {name} claims {count} values that lie beyond its {} bytes",
                    bytes.len()
                )));
            }
        }
        Some(Ok(()))
    };
    walk().unwrap_or(Ok(()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with one tag whose values stand at a place of its own, classic or big, little or big endian.
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

    /// Values within 64 bytes pass in all 4 kinds of file; 4 billion, or a place behind the end, are named; what is cut or none is let through.
    #[test]
    fn claims() {
        for (big, little) in [(false, true), (false, false), (true, true), (true, false)] {
            assert_eq!(check(&file(big, little, 4, 48)), Ok(()));
            for (count, place) in [(4, 49), (u64::from(u32::MAX), 8), (3, u64::from(u32::MAX))] {
                let what = check(&file(big, little, count, place)).expect_err("beyond the end");
                assert_eq!(what, format!("tag 273 claims {count} values that lie beyond its 64 bytes"));
            }
            let whole = file(big, little, 4, 48);
            assert!((0..20).all(|length| check(&whole[..length]).is_ok()));
        }
        assert_eq!(check(b"solid house"), Ok(()));
    }
}
