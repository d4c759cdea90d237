//! In: the header of a PLY file. Out: its elements with their properties in order, and the data
//! behind the header.

use std::path::Path;

use crate::text::{Words, excerpt};
use heliotile_core::error::{Error, Result};

/// Encoding of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a number in the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    /// Returns the type by its name of 1994 or its later name.
    fn by_name(name: &[u8]) -> Option<Kind> {
        Some(match name {
            b"char" | b"int8" => Kind::I8,
            b"uchar" | b"uint8" => Kind::U8,
            b"short" | b"int16" => Kind::I16,
            b"ushort" | b"uint16" => Kind::U16,
            b"int" | b"int32" => Kind::I32,
            b"uint" | b"uint32" => Kind::U32,
            b"float" | b"float32" => Kind::F32,
            b"double" | b"float64" => Kind::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    /// Type of the count in front of a list; `None` for a single value.
    pub list: Option<Kind>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    /// Number of items, as the file claims it.
    pub count: u64,
    pub properties: Vec<Property>,
    /// Line of its declaration, counted from 1.
    pub line: usize,
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Number of lines of the header.
    pub lines: usize,
    /// Bytes that end each line of the header.
    pub end_of_line: &'static [u8],
}

impl Header {
    /// Reads the header; returns the bytes behind it too.
    pub(super) fn read<'b>(bytes: &'b [u8], file: &Path) -> Result<(Header, &'b [u8])> {
        let end_of_line: &'static [u8] = match bytes {
            [b'p', b'l', b'y', b'\r', b'\n', ..] => b"\r\n",
            [b'p', b'l', b'y', b'\n', ..] => b"\n",
            [b'p', b'l', b'y', b'\r', ..] => b"\r",
            _ => {
                let what = format!("the first line is `{}`, not `ply`", excerpt(bytes));
                return Err(Error::input(
                    file,
                    1,
                    what,
                    "give a PLY file, or rename the file with the ending of its format",
                ));
            }
        };
        let fail = |line: usize, what: String| Error::input(file, line, what, "export it again");
        let mut rest = bytes;
        let mut encoding = None;
        let mut header = Header { encoding: Encoding::Text, elements: Vec::new(), lines: 0, end_of_line };
        loop {
            let length = rest.windows(end_of_line.len()).position(|window| window == end_of_line);
            let (text, behind) = rest.split_at(length.unwrap_or(rest.len()));
            rest = behind.get(end_of_line.len()..).unwrap_or_default();
            header.lines += 1;
            let line = header.lines;
            let words: Vec<&[u8]> = Words(text).take(5).collect();
            match words.as_slice() {
                [b"end_header"] => break,
                [] | [b"ply" | b"comment" | b"obj_info", ..] => {}
                [b"format", format, ..] => {
                    encoding = Some(match *format {
                        b"ascii" => Encoding::Text,
                        b"binary_little_endian" => Encoding::LittleEndian,
                        b"binary_big_endian" => Encoding::BigEndian,
                        _ => return Err(fail(line, format!("`{}` is not a format of PLY", excerpt(text)))),
                    });
                }
                [b"element", name, count] => {
                    let count = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                    let count =
                        count.ok_or_else(|| fail(line, format!("`{}` has no valid count of items", excerpt(text))))?;
                    let name = String::from_utf8_lossy(name).into_owned();
                    if ["vertex", "face"].contains(&name.as_str()) && header.elements.iter().any(|e| e.name == name) {
                        return Err(fail(line, format!("`element {name}` is declared twice")));
                    }
                    header.elements.push(Element { name, count, properties: Vec::new(), line });
                }
                [b"property", words @ ..] => {
                    let property = match words {
                        [b"list", count, kind, name] => {
                            Kind::by_name(count).zip(Kind::by_name(kind)).map(|(count, kind)| {
                                let name = String::from_utf8_lossy(name).into_owned();
                                Property { name, kind, list: Some(count) }
                            })
                        }
                        [kind, name] => Kind::by_name(kind).map(|kind| {
                            let name = String::from_utf8_lossy(name).into_owned();
                            Property { name, kind, list: None }
                        }),
                        _ => None,
                    };
                    let (Some(property), Some(element)) = (property, header.elements.last_mut()) else {
                        return Err(fail(line, format!("`{}` is not a valid property of an element", excerpt(text))));
                    };
                    element.properties.push(property);
                }
                _ => return Err(fail(line, format!("`{}` is not a statement of a PLY header", excerpt(text)))),
            }
            if length.is_none() {
                return Err(fail(line, "the file ends before `end_header`".into()));
            }
        }
        header.encoding = encoding.ok_or_else(|| fail(header.lines, "the header has no `format` line".into()))?;
        Ok((header, rest))
    }
}
