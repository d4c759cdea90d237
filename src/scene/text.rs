//! Lines and words of text files. In: bytes of a text file. Out: numbered lines, words, numbers.

use std::path::Path;

use serde::de::DeserializeOwned;

use heliotile_core::error::{Error, Result};
pub(super) use heliotile_files::text::line_of_offset;
pub(super) use heliotile_files::text::{excerpt, utf8, without_byte_order_mark};

/// Reads a file of TOML; `keys` is the hint that says what it may hold.
pub fn read_toml<T: DeserializeOwned>(path: &Path, text: &str, keys: &'static str) -> Result<T> {
    toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| line_of_offset(text.as_bytes(), span.start));
        Error::input(path, line, error.message().to_owned(), keys)
    })
}

/// Logical lines of a Wavefront file (OBJ, MTL): continuations joined, comment lines left out,
/// numbered from 1.
///
/// LF, CRLF and bare CR all end a line; a byte order mark is skipped. A backslash at the end of a
/// comment joins nothing: exporters write folder names there.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    end_of_line: u8,
    number: usize,
    joined: Vec<u8>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Lines {
            rest: without_byte_order_mark(bytes),
            // Only files of the old Macintosh hold no LF at all.
            end_of_line: if bytes.contains(&b'\n') { b'\n' } else { b'\r' },
            number: 0,
            joined: Vec::new(),
        }
    }

    /// Returns the next line that is neither empty nor a comment, trimmed, with the number of its
    /// first physical line.
    pub(super) fn next(&mut self) -> Option<(usize, &[u8])> {
        loop {
            let line = self.physical_line()?;
            let number = self.number;
            match line {
                [] | [b'#', ..] => continue,
                [head @ .., b'\\'] => {
                    self.joined.clear();
                    self.joined.extend_from_slice(head);
                    self.join_following();
                    return Some((number, self.joined.trim_ascii()));
                }
                _ => return Some((number, line)),
            }
        }
    }

    fn join_following(&mut self) {
        while let Some(line) = self.physical_line() {
            self.joined.push(b' ');
            match line {
                [head @ .., b'\\'] => self.joined.extend_from_slice(head),
                _ => {
                    self.joined.extend_from_slice(line);
                    return;
                }
            }
        }
    }

    fn physical_line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end_of_line = self.end_of_line;
        let (line, rest) = match self.rest.iter().position(|&byte| byte == end_of_line) {
            Some(end) => {
                let (line, rest) = self.rest.split_at(end);
                (line, rest.get(1..).unwrap_or_default())
            }
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        Some(line.trim_ascii())
    }
}

/// Words between blanks, up to a word that starts with `#`.
pub(super) struct Words<'a>(pub(super) &'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let line = self.0.trim_ascii_start();
        let length = line.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = line.split_at(length.unwrap_or(line.len()));
        self.0 = rest;
        match word {
            [] | [b'#', ..] => None,
            _ => Some(word),
        }
    }
}

/// Splits a line into its first word and the trimmed remainder, which may be a name with blanks.
pub(super) fn keyword_and_rest(line: &[u8]) -> (&[u8], &[u8]) {
    let length = line.iter().position(u8::is_ascii_whitespace);
    let (keyword, rest) = line.split_at(length.unwrap_or(line.len()));
    (keyword, rest.trim_ascii())
}

/// Returns the number that a word spells, which may be infinite or NaN.
#[inline]
pub(super) fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Returns the integer before the first `/`; `None` if there is none or it exceeds 64 bits.
#[inline]
pub(super) fn leading_index(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    let mut index = 0_i64;
    let mut any = false;
    for &byte in digits {
        match byte {
            b'0'..=b'9' => index = index.checked_mul(10)?.checked_add(i64::from(byte - b'0'))?,
            b'/' => break,
            _ => return None,
        }
        any = true;
    }
    any.then_some(if negative { -index } else { index })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Vec<(usize, String)> {
        let mut lines = Lines::new(bytes);
        let mut found = Vec::new();
        while let Some((number, line)) = lines.next() {
            found.push((number, String::from_utf8_lossy(line).into_owned()));
        }
        found
    }

    /// LF, CRLF and CR files give the same lines with the same numbers.
    #[test]
    fn all_line_ends_give_the_same_lines() {
        let lf = all(b"\xef\xbb\xbfv 1\n\n  f 2 \nusemtl a b");
        assert_eq!(lf, [(1, "v 1".into()), (3, "f 2".into()), (4, "usemtl a b".into())]);
        assert_eq!(all(b"v 1\r\n\r\n  f 2 \r\nusemtl a b\r\n"), lf);
        assert_eq!(all(b"v 1\r\r  f 2 \rusemtl a b"), lf);
    }

    /// A backslash joins lines under the first one's number, but not out of a comment.
    #[test]
    fn a_backslash_joins_lines() {
        let lines = all(b"# C:\\data\\\nf 1 2\\\r\n 3 \\\n4\nv 5\\");
        assert_eq!(lines, [(2, "f 1 2 3  4".into()), (5, "v 5".into())]);
    }

    /// Words end at a comment that stands after the data.
    #[test]
    fn words_end_at_a_comment() {
        let found: Vec<&[u8]> = Words(b"v\t1  2 # 3").collect();
        assert_eq!(found, [&b"v"[..], b"1", b"2"]);
    }
}
