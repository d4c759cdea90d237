//! In: the data of a PLY file, text or binary. Out: its numbers, one after the other; nothing is
//! kept.

use std::path::Path;

use crate::formats::ply_header::{Element, Encoding, Header, Kind, Property};
use crate::text::{Words, excerpt, number};
use heliotile_core::error::{Error, Result};

pub(super) struct Body<'b> {
    pub file: &'b Path,
    encoding: Encoding,
    rest: &'b [u8],
    /// Rest of the current line, with its number below; text files only.
    words: Words<'b>,
    line: usize,
    end_of_line: u8,
    /// Element and item being read, for messages.
    element: &'b str,
    item: u64,
    items: u64,
}

impl<'b> Body<'b> {
    pub(super) fn new(header: &'b Header, rest: &'b [u8], file: &'b Path) -> Self {
        Body {
            file,
            encoding: header.encoding,
            rest,
            words: Words(&[]),
            line: header.lines,
            end_of_line: header.end_of_line.last().copied().unwrap_or(b'\n'),
            element: "",
            item: 0,
            items: 0,
        }
    }

    pub(super) fn is_binary(&self) -> bool {
        self.encoding != Encoding::Text
    }

    /// Returns the current line of a text file, 0 for a binary one.
    pub(super) fn line(&self) -> usize {
        if self.is_binary() { 0 } else { self.line }
    }

    /// Goes on to the next item of an element: in a text file, to the next line that is not empty.
    pub(super) fn begin(&mut self, element: &'b Element, item: u64) -> Result<()> {
        (self.element, self.item, self.items) = (&element.name, item, element.count);
        if self.is_binary() {
            return Ok(());
        }
        loop {
            if self.rest.is_empty() {
                return Err(self.ends());
            }
            let end = self.rest.iter().position(|&byte| byte == self.end_of_line).unwrap_or(self.rest.len());
            let (line, behind) = self.rest.split_at(end);
            self.rest = behind.get(1..).unwrap_or_default();
            self.line += 1;
            if !line.trim_ascii().is_empty() {
                self.words = Words(line);
                return Ok(());
            }
        }
    }

    /// Reads the next number. In a text file it may be infinite, NaN or a fraction, whatever its
    /// type.
    #[inline]
    pub(super) fn number(&mut self, kind: Kind) -> Result<f64> {
        if self.is_binary() {
            return self.binary(kind);
        }
        let word = self.words.next().ok_or_else(|| self.error("has too few numbers"))?;
        number(word).ok_or_else(|| self.error(&format!("holds `{}`, not a number", excerpt(word))))
    }

    #[inline]
    fn binary(&mut self, kind: Kind) -> Result<f64> {
        let Some((head, rest)) = self.rest.split_at_checked(kind.size()) else {
            return Err(self.ends());
        };
        self.rest = rest;
        let mut bytes = [0; 8];
        // `bytes` hold the least significant byte first from here on.
        bytes.iter_mut().zip(head).for_each(|(to, from)| *to = *from);
        if self.encoding == Encoding::BigEndian {
            bytes.iter_mut().zip(head.iter().rev()).for_each(|(to, from)| *to = *from);
        }
        let bits = u64::from_le_bytes(bytes);
        Ok(match kind {
            Kind::I8 => f64::from(bits as i8),
            Kind::U8 => f64::from(bits as u8),
            Kind::I16 => f64::from(bits as i16),
            Kind::U16 => f64::from(bits as u16),
            Kind::I32 => f64::from(bits as i32),
            Kind::U32 => f64::from(bits as u32),
            Kind::F32 => f64::from(f32::from_bits(bits as u32)),
            Kind::F64 => f64::from_bits(bits),
        })
    }

    /// Reads the length of a list, as the file claims it; its values may be missing.
    pub(super) fn count(&mut self, property: &Property) -> Result<u64> {
        let count = self.number(property.list.unwrap_or(Kind::U8))?;
        if !(0.0..=f64::from(u32::MAX)).contains(&count) || count.fract() != 0.0 {
            return Err(self.error(&format!(
                "has a list `{}` of {count} values, which is not a valid count",
                excerpt(property.name.as_bytes())
            )));
        }
        Ok(count as u64)
    }

    /// Skips `count` values.
    pub(super) fn skip(&mut self, kind: Kind, count: u64) -> Result<()> {
        if !self.is_binary() {
            for _ in 0..count {
                self.words.next().ok_or_else(|| self.error("has too few numbers"))?;
            }
            return Ok(());
        }
        let bytes = usize::try_from(count).ok().and_then(|count| count.checked_mul(kind.size()));
        match bytes.and_then(|bytes| self.rest.get(bytes..)) {
            Some(rest) => self.rest = rest,
            None => return Err(self.ends()),
        }
        Ok(())
    }

    /// Returns the number of bytes after the last item, without the blanks around them in a text
    /// file.
    pub(super) fn left(&self) -> usize {
        if self.is_binary() { self.rest.len() } else { self.rest.trim_ascii().len() }
    }

    fn ends(&self) -> Error {
        self.error("is missing or incomplete: the file ends here")
    }

    /// Returns an error about the item being read.
    #[cold]
    pub(super) fn error(&self, what: &str) -> Error {
        let (item, element) = (self.item, excerpt(self.element.as_bytes()));
        let what = format!("{element} {item} of {} {what}", self.items);
        let line = Some(self.line).filter(|_| !self.is_binary());
        Error::input(self.file, line, what, "export or copy the file again (items are counted from 0)")
    }
}
