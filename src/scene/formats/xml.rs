//! XML, piece by piece. In: bytes of unknown origin. Out: elements one after the other, each with
//! its local name, a few attributes and its line. Nothing is kept of what was read before.
//!
//! Entities that a file declares are refused, not expanded. An element of more than [`LONGEST`]
//! bytes of text is refused, and so are elements more than [`DEEPEST`] deep, so that readers of
//! nested elements need little stack.

use std::io;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use quick_xml::events::{BytesRef, BytesStart, Event};

use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

/// Deepest nesting of elements; a polygon of a window of a wall of a building part is 25 deep.
const DEEPEST: usize = 100;

/// Most bytes of one tag, text or comment: a ring of a million corners.
const LONGEST: usize = 64 << 20;

/// Attributes that are kept, by their local names.
const KEPT: [&str; 10] =
    ["id", "href", "srsName", "srsDimension", "orientation", "name", "uom", "band", "sample", "role"];

const CUT_OFF: &str = "copy or export the file again: it is damaged or cut off";

/// A start tag.
pub(super) struct Element {
    /// Name without prefix.
    pub name: String,
    /// Line on which the tag ends, counted from 1.
    pub line: usize,
    attributes: Vec<(&'static str, String)>,
}

impl Element {
    /// Returns the value of an attribute by its local name; only attributes of [`KEPT`] are known.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| *known == name).map(|(_, value)| value.as_str())
    }
}

/// Next piece of the file.
enum Piece {
    Open(Element),
    Close,
    Text,
    End,
}

/// Reader of a file, element by element. A caller that gets an element must read to its end: by
/// [`Xml::child`] until there is none, by [`Xml::text`] or by [`Xml::skip`].
pub(super) struct Xml<'f> {
    reader: quick_xml::Reader<Metered<'f>>,
    buffer: Vec<u8>,
    /// Text that was read last.
    text: Vec<u8>,
    file: &'f Path,
    line: usize,
    depth: usize,
}

impl<'f> Xml<'f> {
    pub(super) fn new(bytes: Box<dyn Read + 'f>, file: &'f Path) -> Xml<'f> {
        let mut reader = quick_xml::Reader::from_reader(Metered {
            inner: BufReader::with_capacity(256 << 10, bytes),
            left: LONGEST,
        });
        reader.config_mut().expand_empty_elements = true;
        reader.config_mut().allow_dangling_amp = true;
        Xml { reader, buffer: Vec::new(), text: Vec::new(), file, line: 1, depth: 0 }
    }

    pub(super) fn file(&self) -> &'f Path {
        self.file
    }

    /// Returns the next child of the current element, or reads the element's end and returns
    /// `None`.
    pub(super) fn child(&mut self) -> Result<Option<Element>> {
        loop {
            match self.step(false)? {
                Piece::Open(element) => return Ok(Some(element)),
                Piece::Close => return Ok(None),
                Piece::Text => {}
                Piece::End if self.depth == 0 => return Ok(None),
                Piece::End => return Err(self.cut_off()),
            }
        }
    }

    /// Returns the next child of the current element; or `None` at the element's end, with the text
    /// behind its last child.
    pub(super) fn child_or_words(&mut self) -> Result<(Option<Element>, String)> {
        self.text.clear();
        loop {
            match self.step(self.text.len() < LONGEST)? {
                Piece::Open(element) => return Ok((Some(element), String::new())),
                Piece::Close => return Ok((None, String::from_utf8_lossy(self.text.trim_ascii()).into_owned())),
                Piece::Text => {}
                Piece::End => return Err(self.cut_off()),
            }
        }
    }

    /// Reads to the end of the current element.
    pub(super) fn skip(&mut self) -> Result<()> {
        let around = self.depth.saturating_sub(1);
        while self.depth > around {
            if matches!(self.step(false)?, Piece::End) {
                return Err(self.cut_off());
            }
        }
        Ok(())
    }

    /// Reads to the end of the current element and returns its text, without the text of elements
    /// within it.
    pub(super) fn text(&mut self) -> Result<&[u8]> {
        let around = self.depth.saturating_sub(1);
        self.text.clear();
        while self.depth > around {
            let own = self.depth == around + 1;
            if matches!(self.step(own)?, Piece::End) {
                return Err(self.cut_off());
            }
            if self.text.len() > LONGEST {
                let what = format!("an element holds more than {LONGEST} bytes of text");
                return Err(Error::input(self.file, self.line, what, "the file is damaged: export it again"));
            }
        }
        Ok(self.text.trim_ascii())
    }

    /// Returns the text of the current element as a string; bytes that are not UTF-8 are replaced.
    pub(super) fn words(&mut self) -> Result<String> {
        self.text().map(|text| String::from_utf8_lossy(text).into_owned())
    }

    /// Reads the next piece, and keeps its text if `keep` is true.
    fn step(&mut self, keep: bool) -> Result<Piece> {
        let Xml { reader, buffer, text, file, line, depth } = self;
        buffer.clear();
        // The limit holds for each piece, so that none can fill the memory.
        reader.get_mut().left = LONGEST;
        let event = reader.read_event_into(buffer).map_err(|error| broken(&error, file, *line))?;
        let mut pass = |bytes: &[u8]| *line += bytes.iter().filter(|byte| **byte == b'\n').count();
        Ok(match event {
            Event::Start(tag) | Event::Empty(tag) => {
                pass(&tag);
                *depth += 1;
                if *depth > DEEPEST {
                    let what = format!("elements are nested more than {DEEPEST} deep");
                    return Err(Error::input(file, *line, what, "export the file again: it is not valid"));
                }
                Piece::Open(element(&tag, *line))
            }
            Event::End(tag) => {
                pass(&tag);
                *depth = depth.saturating_sub(1);
                Piece::Close
            }
            Event::Text(part) => {
                pass(&part);
                if keep {
                    text.extend_from_slice(&part);
                }
                Piece::Text
            }
            Event::CData(part) => {
                pass(&part);
                if keep {
                    text.extend_from_slice(&part);
                }
                Piece::Text
            }
            Event::GeneralRef(name) => {
                if let Some(letter) = letter_of(&name).filter(|_| keep) {
                    text.extend_from_slice(letter.encode_utf8(&mut [0; 4]).as_bytes());
                }
                Piece::Text
            }
            Event::DocType(declaration) => {
                if declaration.contains(&b'[') {
                    let what = "its DOCTYPE declares entities or elements, which are not read";
                    return Err(Error::input(file, *line, what, "remove the declaration: CityGML needs none"));
                }
                pass(&declaration);
                Piece::Text
            }
            Event::Comment(part) => {
                pass(&part);
                Piece::Text
            }
            Event::PI(part) => {
                pass(&part);
                Piece::Text
            }
            Event::Decl(part) => {
                pass(&part);
                Piece::Text
            }
            Event::Eof => Piece::End,
        })
    }

    fn cut_off(&self) -> Error {
        let what = format!("the file ends within {} open elements", self.depth);
        Error::input(self.file, self.line, what, CUT_OFF)
    }
}

fn element(tag: &BytesStart, line: usize) -> Element {
    let name = String::from_utf8_lossy(tag.local_name().as_ref()).into_owned();
    let mut attributes = Vec::new();
    // Checking for repeated attributes would take the square of their number.
    for attribute in tag.attributes().with_checks(false).flatten() {
        let local = attribute.key.local_name();
        if let Some(known) = KEPT.into_iter().find(|known| known.as_bytes() == local.as_ref()) {
            let raw = String::from_utf8_lossy(&attribute.value);
            let value = quick_xml::escape::unescape(&raw).unwrap_or_else(|_| raw.as_ref().into()).into_owned();
            attributes.push((known, value));
        }
    }
    Element { name, line, attributes }
}

/// Returns the character of an entity `&...;`; `None` for an entity that XML itself does not
/// define.
fn letter_of(name: &BytesRef) -> Option<char> {
    let name_bytes: &[u8] = name;
    match name_bytes {
        b"amp" => Some('&'),
        b"lt" => Some('<'),
        b"gt" => Some('>'),
        b"quot" => Some('"'),
        b"apos" => Some('\''),
        _ => name.resolve_char_ref().ok().flatten(),
    }
}

#[cold]
fn broken(error: &quick_xml::Error, file: &Path, line: usize) -> Error {
    let what = match error {
        quick_xml::Error::Io(cause) => format!("the file cannot be read further: {cause}"),
        other => format!("its XML is broken: {}", excerpt(other.to_string().as_bytes())),
    };
    Error::input(file, line, what, CUT_OFF)
}

/// Bytes of a file with a limit for one piece.
struct Metered<'f> {
    inner: BufReader<Box<dyn Read + 'f>>,
    left: usize,
}

impl Read for Metered<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.inner.read(buffer)
    }
}

impl BufRead for Metered<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.left == 0 {
            return Err(io::Error::other(format!("a tag or a text is longer than {LONGEST} bytes")));
        }
        self.inner.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.left = self.left.saturating_sub(count);
        self.inner.consume(count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xml(text: &str) -> Xml<'_> {
        Xml::new(Box::new(text.as_bytes()), Path::new("a.gml"))
    }

    /// Names lose their prefix, 2 attributes of 3 are kept, and lines are counted across comments
    /// and tags of several lines.
    #[test]
    fn elements_have_names_attributes_and_lines() {
        let text = "<?xml version=\"1.0\"?>\n<!-- a\n -->\n<a:b\n gml:id=\"x&amp;y\" c=\"2\" uom='m'>\n <d/>t &lt;&#65;<e>no</e></a:b>";
        let mut xml = xml(text);
        let root = xml.child().expect("sound").expect("a root");
        assert_eq!((root.name.as_str(), root.line, root.attributes.len()), ("b", 5, 2));
        assert_eq!((root.attribute("id"), root.attribute("uom"), root.attribute("c")), (Some("x&y"), Some("m"), None));
        assert_eq!(xml.child().expect("sound").expect("a child").line, 6);
        assert!(xml.child().expect("sound").is_none());
        assert_eq!(xml.text().expect("sound"), b"t <A");
        assert!(xml.child().expect("sound").is_none());
    }

    /// Six broken texts are refused with a message: an entity, too deep a nesting, two cut texts, a
    /// wrong end tag and a text of more than 64 MiB.
    #[test]
    fn broken_texts_are_refused() {
        let deep = "<a>".repeat(101);
        let long = format!("<a>{}</a>", " ".repeat(65 << 20));
        for (text, said) in [
            ("<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>", "DOCTYPE declares"),
            (deep.as_str(), "more than 100 deep"),
            ("<a><b></b>", "ends within 1 open elements"),
            ("<a><b at", "XML is broken"),
            ("<a></b>", "XML is broken"),
            (long.as_str(), "longer than 67108864 bytes"),
        ] {
            let mut xml = xml(text);
            let message = loop {
                if let Err(error) = xml.child() {
                    break error.to_string();
                }
            };
            assert!(message.contains("a.gml, line 1") && message.contains(said), "{message}");
        }
    }
}
