//! In: a .gltf or .glb file, and the buffers that its JSON names. Out: their bytes, and accessors
//! whose values are all known to exist.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use glam::{DVec3, DVec4};
use percent_encoding::percent_decode_str;

use crate::formats::gltf::json::{Accessor, Root, Sparse, SparsePart, unreadable};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_files::input;

const HINT: &str = "export it again, or check it with a glTF validator";

/// Splits a .glb file into its JSON and its first buffer; a .gltf file is all JSON (specification,
/// section 4.4).
pub(super) fn split<'b>(bytes: &'b [u8], file: &Path) -> Result<(&'b [u8], Option<&'b [u8]>)> {
    let Some(behind) = bytes.strip_prefix(b"glTF") else {
        return Ok((crate::text::without_byte_order_mark(bytes), None));
    };
    let refuse = |what: String| Error::input(file, None, what, HINT);
    let cut = || refuse(format!("the file ends after {} bytes, within its first chunks", bytes.len()));
    let (version, behind) = word(behind).ok_or_else(cut)?;
    if version != 2 {
        return Err(Error::Unsupported {
            what: format!("the scene {}", file.display()).into(),
            found: format!("binary glTF {version}"),
            supported: "glTF 2.0".into(),
        });
    }
    let (total, mut rest) = word(behind).ok_or_else(cut)?;
    if total as usize > bytes.len() {
        return Err(refuse(format!("the file has {} of the {total} bytes that its header states", bytes.len())));
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
    let json = next(b"JSON").ok_or_else(|| refuse("the first chunk is not a complete JSON chunk".into()))?;
    Ok((json, next(b"BIN\0")))
}

fn word(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (head, rest) = bytes.split_first_chunk()?;
    Some((u32::from_le_bytes(*head), rest))
}

pub(super) struct Buffers<'r> {
    root: &'r Root,
    file: &'r Path,
    /// Bytes of each buffer; `None` for a buffer without bytes of its own.
    bytes: Vec<Option<Bytes<'r>>>,
}

enum Bytes<'r> {
    Chunk(&'r [u8]),
    Read(Rc<Vec<u8>>),
}

impl<'r> Buffers<'r> {
    /// Returns the number of bytes of all buffers, each file once.
    pub(super) fn length(&self) -> u64 {
        let mut files: Vec<*const Vec<u8>> = Vec::new();
        let each = self.bytes.iter().flatten().map(|bytes| match bytes {
            Bytes::Chunk(chunk) => chunk.len() as u64,
            Bytes::Read(read) if files.contains(&Rc::as_ptr(read)) => 0,
            Bytes::Read(read) => {
                files.push(Rc::as_ptr(read));
                read.len() as u64
            }
        });
        each.sum()
    }

    /// Reads all buffers, every file once.
    pub(super) fn read(root: &'r Root, chunk: Option<&'r [u8]>, file: &'r Path) -> Result<Self> {
        let mut files: HashMap<PathBuf, Rc<Vec<u8>>> = HashMap::new();
        let mut bytes = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let refuse =
                |what: String, hint: &'static str| Error::input(file, None, format!("buffer {i} {what}"), hint);
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
                        let what = format!("is `{}`, not a file in the folder of the scene", excerpt(uri.as_bytes()));
                        refuse(what, "copy it beside the scene, or export one .glb file")
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

    /// Returns the values of an accessor, after checking that all of them exist.
    pub(super) fn values(&self, index: usize) -> Result<Values<'_>> {
        let refuse = |what: String| Error::input(self.file, None, format!("accessor {index} {what}"), HINT);
        let accessor = self.root.accessors.get(index).ok_or_else(|| refuse("does not exist".into()))?;
        let Accessor { count, byte_offset, .. } = *accessor;
        let kind = Kind::by_code(accessor.component_type).ok_or_else(|| {
            refuse(format!("is of component type {}, which glTF 2.0 does not have", accessor.component_type))
        })?;
        let width = match accessor.shape.as_str() {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            other => return Err(refuse(format!("is `{}`, not SCALAR or VEC3", excerpt(other.as_bytes())))),
        };
        let size = (width * kind.size()) as u64;
        let (mut bytes, mut stride) = (None, size);
        if let Some(number) = accessor.buffer_view {
            let view = self.view(index, number)?;
            stride = view.stride.filter(|stride| *stride > 0).unwrap_or(size);
            if stride < size {
                return Err(refuse(format!("has values of {size} bytes every {stride} bytes, which overlap")));
            }
            let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
            let found = needed.and_then(|needed| part(view.bytes, byte_offset, needed));
            bytes = Some(found.ok_or_else(|| {
                let all = view.bytes.len();
                refuse(format!("has {count} values every {stride} bytes, more than its buffer view of {all} bytes"))
            })?);
        } else if accessor.sparse.is_none() {
            return Err(refuse("has no buffer view, all its values are 0".into()));
        } else if count > MAX_ZEROS {
            return Err(refuse(format!("has {count} values and no buffer view, more than {MAX_ZEROS}")));
        }
        let replaced = accessor.sparse.as_ref().map(|sparse| self.replaced(index, sparse, count, size)).transpose()?;
        // The values exist in memory, so that a usize counts them.
        let normalized = accessor.normalized && kind != Kind::F32;
        Ok(Values { bytes, count: count as usize, width, stride: stride as usize, kind, normalized, replaced })
    }

    /// Returns the values of a sparse accessor (specification, section 3.6.2.3), `size` bytes each,
    /// and the indices of the values that they replace, below `count`.
    fn replaced(&self, index: usize, sparse: &Sparse, count: u64, size: u64) -> Result<Replaced<'_>> {
        let refuse = |what: String| Error::input(self.file, None, format!("accessor {index} {what}"), HINT);
        let kind = sparse.indices.component_type.and_then(Kind::by_code);
        let Some(kind @ (Kind::U8 | Kind::U16 | Kind::U32)) = kind else {
            return Err(refuse("has sparse indices of a type that glTF 2.0 does not allow".into()));
        };
        let of = |of: &SparsePart, each: u64| {
            let length = sparse.count.checked_mul(each);
            let view = self.view(index, of.buffer_view)?;
            let found = length.and_then(|length| part(view.bytes, of.byte_offset, length));
            found
                .ok_or_else(|| refuse(format!("has {} sparse values, more than their buffer view holds", sparse.count)))
        };
        let found = Replaced {
            places: of(&sparse.indices, kind.size() as u64)?,
            values: of(&sparse.values, size)?,
            kind,
            count: sparse.count as usize,
            size: size as usize,
        };
        // Values are looked up by binary search, which needs increasing indices.
        let mut places = (0..found.count).filter_map(|i| found.place(i));
        if !places.clone().is_sorted_by(|a, b| a < b) || places.next_back().is_some_and(|last| u64::from(last) >= count)
        {
            return Err(refuse(format!("has sparse indices that do not increase, or go beyond its {count} values")));
        }
        Ok(found)
    }

    /// Returns the bytes of a buffer view.
    fn view(&self, index: usize, number: usize) -> Result<ViewBytes<'_>> {
        let refuse = |what: String| Error::input(self.file, None, format!("accessor {index} {what}"), HINT);
        let missing = || refuse(format!("is in buffer view {number}, which does not exist"));
        let view = self.root.buffer_views.get(number).ok_or_else(missing)?;
        let buffer = self.bytes.get(view.buffer).and_then(Option::as_ref).ok_or_else(|| {
            match view.extensions.keys().next() {
                Some(name) => {
                    let found =
                        format!("accessor {index}, whose values only the extension {} holds", excerpt(name.as_bytes()));
                    unreadable(self.file, &found, name)
                }
                None => {
                    refuse(format!("is in buffer {}, which does not exist or has no bytes of its own", view.buffer))
                }
            }
        })?;
        // Bytes beyond the stated length, such as padding of a .glb chunk, are not part of the
        // buffer.
        let announced = self.root.buffers.get(view.buffer).map_or(0, |buffer| buffer.byte_length);
        let bytes = part(buffer.all(), 0, announced).and_then(|all| part(all, view.byte_offset, view.byte_length));
        let bytes =
            bytes.ok_or_else(|| refuse(format!("is in buffer view {number}, which reaches beyond its buffer")))?;
        Ok(ViewBytes { bytes, stride: view.byte_stride })
    }
}

/// Bytes of a buffer view, and the distance of its values in bytes, if stated.
struct ViewBytes<'b> {
    bytes: &'b [u8],
    stride: Option<u64>,
}

/// Most values of a sparse accessor without a buffer view: a short file could otherwise ask for all
/// memory.
const MAX_ZEROS: u64 = 10_000_000;

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

/// Returns the bytes of a `data:` URI (RFC 2397), with or without padding at its end.
fn decode(uri: &str) -> std::result::Result<Vec<u8>, String> {
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let (head, text) = uri.split_once(',').unwrap_or_default();
    if !head.ends_with(";base64") {
        return Err(format!("is `{}`, which is not written in base64", excerpt(uri.as_bytes())));
    }
    GeneralPurpose::new(&STANDARD, config).decode(text).map_err(|error| format!("is not valid base64: {error}"))
}

/// Returns the path of a file beside `file` or in a folder below it; `None` for other places, which
/// could expose files that were not meant to be read.
fn beside(file: &Path, uri: &str) -> Option<PathBuf> {
    let decoded = percent_decode_str(uri).decode_utf8().ok()?;
    let relative = Path::new(decoded.as_ref());
    let stays = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    if !relative.components().all(stays) || decoded.contains([':', '\\', '\0']) || decoded.is_empty() {
        return None;
    }
    Some(file.parent().unwrap_or(Path::new("")).join(relative))
}

/// Type of a number (specification, section 3.6.2.2).
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
    fn by_code(component_type: u32) -> Option<Kind> {
        Some(match component_type {
            // The numbers are those of OpenGL's types (glTF 2.0, accessor.componentType).
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

    /// Returns the stored number that stands for 1 in normalized values.
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
    /// Bytes of the values; `None` if all values are 0 that are not replaced.
    bytes: Option<&'b [u8]>,
    pub count: usize,
    width: usize,
    stride: usize,
    kind: Kind,
    normalized: bool,
    replaced: Option<Replaced<'b>>,
}

/// Values of a sparse accessor that replace others.
struct Replaced<'b> {
    /// Indices of the replaced values, increasing.
    places: &'b [u8],
    values: &'b [u8],
    kind: Kind,
    count: usize,
    size: usize,
}

impl<'b> Replaced<'b> {
    fn place(&self, i: usize) -> Option<u32> {
        let bytes = self.places.get(i.checked_mul(self.kind.size())?..)?;
        self.kind.read(bytes).map(|place| place as u32)
    }

    /// Returns the bytes of a value, if it is replaced.
    fn of(&self, index: usize) -> Option<&'b [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match (self.place(middle)? as usize).cmp(&index) {
                Ordering::Less => low = middle + 1,
                Ordering::Greater => high = middle,
                Ordering::Equal => return self.values.get(middle.checked_mul(self.size)?..),
            }
        }
        None
    }
}

impl<'b> Values<'b> {
    pub(super) fn is_indices(&self) -> bool {
        self.width == 1 && [Kind::U8, Kind::U16, Kind::U32].contains(&self.kind)
    }

    pub(super) fn is_positions(&self) -> bool {
        self.width == 3 && self.kind != Kind::U32
    }

    /// Returns true if the values may be rotations: x, y, z, w.
    pub(super) fn is_rotations(&self) -> bool {
        self.width == 4 && self.kind != Kind::U32
    }

    /// Returns the bytes from a value on.
    #[inline]
    fn at(&self, i: usize) -> Option<&'b [u8]> {
        const ZEROS: &[u8] = &[0; 16];
        if let Some(bytes) = self.replaced.as_ref().and_then(|replaced| replaced.of(i)) {
            return Some(bytes);
        }
        match self.bytes {
            Some(bytes) => bytes.get(i.checked_mul(self.stride)?..),
            None => Some(ZEROS),
        }
    }

    /// Returns a value as an index; `None` beyond the last value.
    #[inline]
    pub(super) fn index(&self, i: usize) -> Option<u32> {
        self.kind.read(self.at(i)?).filter(|_| i < self.count).map(|index| index as u32)
    }

    /// Returns a value as three numbers, quantized ones (`KHR_mesh_quantization`) too. They need
    /// not be finite.
    #[inline]
    pub(super) fn vector(&self, i: usize) -> Option<DVec3> {
        let mut three = self.at(i)?.chunks_exact(self.kind.size()).map(|bytes| self.kind.read(bytes));
        let mut next = || three.next().flatten();
        let vector = DVec3::new(next()?, next()?, next()?);
        // The smallest signed number is clamped, so that it is as far from 0 as the largest.
        Some(if self.normalized { (vector / self.kind.one()).max(DVec3::NEG_ONE) } else { vector })
    }

    /// Returns a value as four numbers, which need not be finite.
    pub(super) fn four(&self, i: usize) -> Option<DVec4> {
        let mut four = self.at(i)?.chunks_exact(self.kind.size()).map(|bytes| self.kind.read(bytes));
        let mut next = || four.next().flatten();
        let vector = DVec4::new(next()?, next()?, next()?, next()?);
        Some(if self.normalized { (vector / self.kind.one()).max(DVec4::NEG_ONE) } else { vector })
    }
}
