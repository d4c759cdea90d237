//! In: a .gltf or .glb file and what its JSON says of buffers. Out: their bytes, and values in them of which all were checked to exist.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use glam::DVec3;
use percent_encoding::percent_decode_str;

use crate::formats::gltf::json::{Accessor, Root};
use crate::input;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

const HINT: &str = "export it again, or check it with a glTF validator";

/// Splits a .glb file into its JSON and its first buffer; a .gltf file is all JSON (specification, section 4.4).
pub(super) fn split<'b>(bytes: &'b [u8], file: &Path) -> Result<(&'b [u8], Option<&'b [u8]>)> {
    let Some(behind) = bytes.strip_prefix(b"glTF") else {
        return Ok((crate::text::without_byte_order_mark(bytes), None));
    };
    let refuse = |what: String| Error::input(file, None, what, HINT);
    let cut = || refuse(format!("the file ends after {} bytes, within its first chunks", bytes.len()));
    let (version, behind) = word(behind).ok_or_else(cut)?;
    if version != 2 {
        return Err(Error::Unsupported {
            what: format!("the scene {}", file.display()),
            found: format!("binary glTF {version}"),
            supported: "glTF 2.0".into(),
        });
    }
    let (total, mut rest) = word(behind).ok_or_else(cut)?;
    if total as usize > bytes.len() {
        return Err(refuse(format!("the file has {} bytes of the {total} that it announces", bytes.len())));
    }
    let mut next = |kind: &[u8; 4]| {
        let (length, behind) = word(rest)?;
        let (found, behind) = behind.split_at_checked(4)?;
        let (chunk, behind) = behind.split_at_checked(length as usize)?;
        (found == kind).then(|| {
            rest = behind;
            chunk
        })
    };
    let json = next(b"JSON").ok_or_else(|| refuse("the first chunk is no whole JSON chunk".into()))?;
    Ok((json, next(b"BIN\0")))
}

fn word(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (head, rest) = bytes.split_first_chunk()?;
    Some((u32::from_le_bytes(*head), rest))
}

pub(super) struct Buffers<'r> {
    root: &'r Root,
    file: &'r Path,
    /// `None` for one that has no bytes of its own.
    bytes: Vec<Option<Bytes<'r>>>,
}

enum Bytes<'r> {
    Chunk(&'r [u8]),
    Read(Rc<Vec<u8>>),
}

impl<'r> Buffers<'r> {
    /// Reads all of them, every file once.
    pub(super) fn read(root: &'r Root, chunk: Option<&'r [u8]>, file: &'r Path) -> Result<Self> {
        let mut files: HashMap<PathBuf, Rc<Vec<u8>>> = HashMap::new();
        let mut bytes = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let refuse = |what: String, hint: &str| Error::input(file, None, format!("buffer {i} {what}"), hint);
            let found = match (&buffer.uri, chunk) {
                (None, Some(chunk)) if i == 0 => Bytes::Chunk(chunk),
                (None, _) => {
                    bytes.push(None);
                    continue;
                }
                (Some(uri), _) if uri.starts_with("data:") => {
                    let decoded = decode(uri).map_err(|what| refuse(what, HINT))?;
                    Bytes::Read(Rc::new(decoded))
                }
                (Some(uri), _) => {
                    let path = beside(file, uri).ok_or_else(|| {
                        let what = format!("is `{}`, not a file in the folder of this one", excerpt(uri.as_bytes()));
                        refuse(what, "copy it beside this file, or export one .glb file")
                    })?;
                    let path = input::plain_or_packed(path);
                    match files.get(&path) {
                        Some(known) => Bytes::Read(known.clone()),
                        None => {
                            let read = Rc::new(input::read_as(&path, "read the buffer")?);
                            files.insert(path, read.clone());
                            Bytes::Read(read)
                        }
                    }
                }
            };
            if (found.all().len() as u64) < buffer.byte_length {
                let what = format!("has {} of its {} bytes", found.all().len(), buffer.byte_length);
                return Err(refuse(what, "copy or export it again"));
            }
            bytes.push(Some(found));
        }
        Ok(Buffers { root, file, bytes })
    }

    /// The values of an accessor, all of which exist.
    pub(super) fn values(&self, index: usize) -> Result<Values<'_>> {
        let refuse = |what: String| Error::input(self.file, None, format!("accessor {index} {what}"), HINT);
        let accessor = self.root.accessors.get(index).ok_or_else(|| refuse("does not exist".into()))?;
        let Accessor { count, byte_offset, .. } = *accessor;
        if accessor.sparse.is_some() {
            return Err(Error::Unsupported {
                what: format!("accessor {index} of {}", self.file.display()),
                found: "a sparse one".into(),
                supported: "plain accessors: export it again without".into(),
            });
        }
        let kind = Kind::of(accessor.component_type).ok_or_else(|| {
            refuse(format!("is of component type {}, which glTF 2.0 does not have", accessor.component_type))
        })?;
        let number = accessor.buffer_view.ok_or_else(|| refuse("has no buffer view, all its values are 0".into()))?;
        let missing = || refuse(format!("is in buffer view {number}, which does not exist"));
        let view = self.root.buffer_views.get(number).ok_or_else(missing)?;
        let buffer = self.bytes.get(view.buffer).and_then(Option::as_ref).ok_or_else(|| {
            refuse(format!("is in buffer {}, which does not exist or has no bytes of its own", view.buffer))
        })?;
        let announced = self.root.buffers.get(view.buffer).map_or(0, |buffer| buffer.byte_length);
        let bytes = part(buffer.all(), 0, announced).and_then(|all| part(all, view.byte_offset, view.byte_length));
        let bytes =
            bytes.ok_or_else(|| refuse(format!("is in buffer view {number}, which reaches beyond its buffer")))?;
        let width = match accessor.shape.as_str() {
            "SCALAR" => 1,
            "VEC3" => 3,
            other => return Err(refuse(format!("is `{}`, not SCALAR or VEC3", excerpt(other.as_bytes())))),
        };
        let size = (width * kind.size()) as u64;
        let stride = view.byte_stride.filter(|stride| *stride > 0).unwrap_or(size);
        if stride < size {
            return Err(refuse(format!("has values of {size} bytes every {stride} bytes")));
        }
        let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
        let bytes = needed.and_then(|needed| part(bytes, byte_offset, needed)).ok_or_else(|| {
            refuse(format!(
                "has {count} values every {stride} bytes, more than its buffer view of {} bytes",
                view.byte_length
            ))
        })?;
        // What exists in memory is counted by a usize.
        let normalized = accessor.normalized && kind != Kind::F32;
        Ok(Values { bytes, count: count as usize, width, stride: stride as usize, kind, normalized })
    }
}

impl Bytes<'_> {
    fn all(&self) -> &[u8] {
        match self {
            Bytes::Chunk(bytes) => bytes,
            Bytes::Read(bytes) => bytes,
        }
    }
}

fn part(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(offset).ok()?..end)
}

/// The bytes of a `data:` URI (RFC 2397), with or without padding at its end.
fn decode(uri: &str) -> std::result::Result<Vec<u8>, String> {
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let (head, text) = uri.split_once(',').unwrap_or_default();
    if !head.ends_with(";base64") {
        return Err(format!("is `{}`, which is not written in base64", excerpt(uri.as_bytes())));
    }
    GeneralPurpose::new(&STANDARD, config).decode(text).map_err(|error| format!("is no base64: {error}"))
}

/// A file beside another one or in a folder below; names elsewhere could read what was not meant to be read.
fn beside(file: &Path, uri: &str) -> Option<PathBuf> {
    let decoded = percent_decode_str(uri).decode_utf8().ok()?;
    let relative = Path::new(decoded.as_ref());
    let stays = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    if !relative.components().all(stays) || decoded.contains([':', '\\', '\0']) || decoded.is_empty() {
        return None;
    }
    Some(file.parent().unwrap_or(Path::new("")).join(relative))
}

/// How a number is written (specification, section 3.6.2.2).
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Kind {
    fn of(component_type: u32) -> Option<Kind> {
        Some(match component_type {
            5120 => Kind::I8,
            5121 => Kind::U8,
            5122 => Kind::I16,
            5123 => Kind::U16,
            5125 => Kind::U32,
            5126 => Kind::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::U32 | Kind::F32 => 4,
        }
    }

    /// What the largest whole number stands for if 1 is meant by it.
    fn one(self) -> f64 {
        match self {
            Kind::I8 => f64::from(i8::MAX),
            Kind::U8 => f64::from(u8::MAX),
            Kind::I16 => f64::from(i16::MAX),
            Kind::U16 => f64::from(u16::MAX),
            Kind::U32 => f64::from(u32::MAX),
            Kind::F32 => 1.0,
        }
    }

    fn read(self, bytes: &[u8]) -> Option<f64> {
        Some(match self {
            Kind::I8 => f64::from(i8::from_le_bytes(*bytes.first_chunk()?)),
            Kind::U8 => f64::from(u8::from_le_bytes(*bytes.first_chunk()?)),
            Kind::I16 => f64::from(i16::from_le_bytes(*bytes.first_chunk()?)),
            Kind::U16 => f64::from(u16::from_le_bytes(*bytes.first_chunk()?)),
            Kind::U32 => f64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
            Kind::F32 => f64::from(f32::from_le_bytes(*bytes.first_chunk()?)),
        })
    }
}

/// Values of an accessor.
pub(super) struct Values<'b> {
    bytes: &'b [u8],
    pub count: usize,
    width: usize,
    stride: usize,
    kind: Kind,
    normalized: bool,
}

impl Values<'_> {
    pub(super) fn is_indices(&self) -> bool {
        self.width == 1 && [Kind::U8, Kind::U16, Kind::U32].contains(&self.kind)
    }

    pub(super) fn is_positions(&self) -> bool {
        self.width == 3 && self.kind != Kind::U32
    }

    /// A whole number; `None` beyond the last one.
    #[inline]
    pub(super) fn index(&self, i: usize) -> Option<u32> {
        let bytes = self.bytes.get(i.checked_mul(self.stride)?..)?;
        self.kind.read(bytes).filter(|_| i < self.count).map(|index| index as u32)
    }

    /// Three numbers, of `KHR_mesh_quantization` too; maybe not finite.
    #[inline]
    pub(super) fn vector(&self, i: usize) -> Option<DVec3> {
        let bytes = self.bytes.get(i.checked_mul(self.stride)?..)?;
        let mut three = bytes.chunks_exact(self.kind.size()).map(|bytes| self.kind.read(bytes));
        let mut next = || three.next().flatten();
        let vector = DVec3::new(next()?, next()?, next()?);
        // The smallest signed number is as far from 0 as the largest.
        Some(if self.normalized { (vector / self.kind.one()).max(DVec3::NEG_ONE) } else { vector })
    }
}
