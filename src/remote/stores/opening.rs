//! The first requests for an object. In: an address. Out: an object of a fixed version, with its
//! first bytes and the bytes from the directory on. This takes two requests at once, and one more
//! where the directory is long.

use bytes::{Bytes, BytesMut};
use heliotile_core::archive::format::{COMPLETE, MAGIC, SLOT_OFFSETS, Slot};
use heliotile_core::archive::pointer::Pointer;
use object_store::GetRange;

use crate::stores::cache::{Cache, has_root};
use crate::stores::failure::{Cause, Failure};
use crate::stores::object::Object;
use crate::stores::store::Locator;

/// Bytes of the first request: header and first blocks.
const HEAD: u64 = 16 << 10;
/// Bytes of the request for the end, made at the same time: manifest and a short directory.
const TAIL: u64 = 64 << 10;
/// Largest directory that is read at opening, bytes; a longer one is read when it is needed.
const LONGEST: u64 = 256 << 20;

/// An object that was opened.
#[derive(Debug)]
pub struct Opened {
    /// Object for further requests; `None` if all its bytes are in `head`.
    pub object: Option<Object>,
    /// Length of the object, bytes.
    pub length: u64,
    /// First bytes of the object.
    pub head: Bytes,
    /// Offset of the last bytes, and the last bytes.
    pub end: (u64, Bytes),
}

impl Opened {
    /// Opens the object at an address: an archive, a pointer or any other file.
    pub async fn open(place: &Locator, cache: Option<&Cache>) -> Result<Opened, Failure> {
        let first = Object::open(place, GetRange::Bounded(0..HEAD));
        // The end of the object is requested together with its head where the store allows that.
        let (first, tail) = match place.has_suffixes() {
            true => tokio::join!(first, async { Object::open(place, GetRange::Suffix(TAIL)).await.ok() }),
            false => (first.await, None),
        };
        let (object, head) = match first {
            Err(failure) if failure.cause == Cause::NoRanges => return Ok(Opened::whole(Object::whole(place).await?)),
            opened => opened?,
        };
        let length = object.version().length;
        // A small object arrives whole with the first answer.
        if head.len() as u64 == length {
            return Ok(Opened::whole(head));
        }
        let mut end = (length, Bytes::new());
        if let Some((other, bytes)) = tail {
            object.same(&other)?;
            end = (length.saturating_sub(bytes.len() as u64), bytes);
        }
        let slot = slot_of(&head).filter(|slot| slot.directory_offset < end.0 && slot.committed <= length);
        if let Some(slot) = slot.filter(|slot| length.saturating_sub(slot.directory_offset) <= LONGEST) {
            end = match cache.and_then(|cache| cache.directory(&slot)) {
                Some(bytes) => (slot.directory_offset, bytes.into()),
                None => {
                    let mut bytes = BytesMut::from(object.parts(slot.directory_offset..end.0).await?);
                    bytes.extend_from_slice(&end.1);
                    let bytes = bytes.freeze();
                    let known = usize::try_from(slot.committed.saturating_sub(slot.directory_offset)).ok();
                    if let Some((cache, known)) = cache.zip(known.and_then(|known| bytes.get(..known))) {
                        cache.keep_directory(&slot, known);
                    }
                    (slot.directory_offset, bytes)
                }
            };
        }
        Ok(Opened { object: Some(object), length, head, end })
    }

    /// Opens the object at an address, and opens it once more if header and directory do not match,
    /// which may be damage on the way.
    pub async fn open_sound(place: &Locator, cache: Option<&Cache>) -> Result<Opened, Failure> {
        let opened = Opened::open(place, cache).await?;
        if opened.is_sound() { Ok(opened) } else { Opened::open(place, cache).await }
    }

    /// Returns true if header and directory match. Objects that are no archives pass.
    fn is_sound(&self) -> bool {
        match self.slot() {
            Some(slot) if self.end.0 == slot.directory_offset => has_root(&self.end.1, &slot),
            Some(slot) if self.end.0 < slot.directory_offset => {
                let start = usize::try_from(slot.directory_offset - self.end.0).unwrap_or(usize::MAX);
                has_root(self.end.1.get(start..).unwrap_or_default(), &slot)
            }
            Some(_) => true,
            None => !self.head.starts_with(&MAGIC),
        }
    }

    fn whole(head: Bytes) -> Self {
        let length = head.len() as u64;
        Opened { object: None, length, end: (length, Bytes::new()), head }
    }

    /// Returns the pointer that the object is, or `None` if it is no pointer. An error: a pointer
    /// that this release does not understand.
    pub fn pointer(&self) -> Result<Option<Pointer>, Failure> {
        if !Pointer::begins(&self.head) {
            return Ok(None);
        }
        let wrong = || Failure::new(Cause::Refused, "is a pointer to an archive that this release cannot read");
        let whole = self.object.is_none().then_some(&self.head);
        whole.and_then(|bytes| Pointer::from_bytes(bytes)).map(Some).ok_or_else(wrong)
    }

    /// Returns the valid slot of an archive, or `None` if the object is no archive or an incomplete
    /// one.
    pub fn slot(&self) -> Option<Slot> {
        slot_of(&self.head)
    }
}

/// Returns the newest complete slot in the header. It is used to read ahead only: the reader of the
/// archive checks the header itself.
fn slot_of(head: &[u8]) -> Option<Slot> {
    let slots = SLOT_OFFSETS.iter().filter_map(|offset| Slot::decode(head.get(usize::try_from(*offset).ok()?..)?));
    slots.filter(|slot| slot.state == COMPLETE).max_by_key(|slot| slot.generation)
}
