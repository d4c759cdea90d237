//! A file in an object store. In: bytes, an address. Out: an object that is whole, where nothing was, or where what is replaced had not
//! changed meanwhile.
//!
//! Small objects are written at once, on that condition. Large ones cannot be: an archive goes in parts to a name with its root, and the
//! pointer that makes it visible is written last, on the condition ([`Pointer`]).

use heliotile_core::archive::ReadAt;
use heliotile_core::archive::pointer::Pointer;
use heliotile_core::error::{Error, Result};
use object_store::{MultipartUpload, ObjectStoreExt, PutMode, PutOptions, PutPayload, UpdateVersion, WriteMultipart};

use crate::stores::address::{Address, Scheme};
use crate::stores::failure::{Cause, Failure};
use crate::stores::object::look;
use crate::stores::remote_file::RemoteFile;
use crate::stores::store::{Connection, Locator, runtime};
use crate::stores::traffic;

/// Larger archives go in parts.
const AT_ONCE: u64 = 16 << 20;
/// Largest file that is no archive: it is written at once.
pub const LARGEST_FILE: u64 = 256 << 20;
/// Bytes of a part, unless there would be too many.
const PART: u64 = 8 << 20;
/// Most parts of an object: S3 takes 10,000.
const MOST_PARTS: u64 = 9_000;
/// Times that an object is opened again that changes while it is opened.
const LOOKS: usize = 5;
/// Parts under way.
const UNDER_WAY: usize = 4;

/// What is published.
pub struct Upload<'s> {
    /// All of it.
    pub bytes: &'s dyn ReadAt,
    /// The root of an archive; none for another file.
    pub root: Option<[u8; 32]>,
    /// What messages call it.
    pub name: &'s std::path::Path,
}

/// What was done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Published {
    /// Where the bytes are, if a pointer leads to them.
    pub beside: Option<Address>,
    /// Whether the same was there already, and nothing was written.
    pub was_there: bool,
}

/// Refuses addresses that nothing can be written to, before there is something to write.
pub fn check_target(to: &Address) -> Result<()> {
    if to.scheme() == Scheme::Web {
        let hint = "give s3://BUCKET/NAME, gs://BUCKET/NAME or az://CONTAINER/NAME";
        return Err(Error::input(to.shown(), None, "is a web server's, to which nothing is written", hint));
    }
    Ok(())
}

/// Writes an object and looks at it again, unless the same is there; `sent` is told of bytes. An error: something else is there, unless `replace`, or was written by
/// others meanwhile; a store that cannot write on conditions.
pub fn publish(
    source: &Upload,
    to: &Address,
    connection: Connection,
    replace: bool,
    sent: impl Fn(u64),
) -> Result<Published> {
    check_target(to)?;
    let length = source.bytes.length();
    if source.root.is_none() && length > LARGEST_FILE {
        let what = format!("{}: bytes of a file that is no archive", source.name.display());
        return Err(Error::Limit { what, value: length, max: LARGEST_FILE });
    }
    let place = Locator::connect(to, connection)?;
    let failed = |failure: Failure| failure.at(to);
    let before = runtime()?.block_on(look(&place)).map_err(failed)?;
    let mode = match before {
        // The same may be there, and damaged.
        Some(meta) if replace => PutMode::Update(UpdateVersion { e_tag: meta.e_tag, version: meta.version }),
        Some(_) => match was_there(source, to, connection)? {
            Some(published) => return Ok(published),
            None => return Err(Failure::new(Cause::Exists, "is there already").at(to)),
        },
        None => PutMode::Create,
    };
    match source.root {
        Some(root) if length > AT_ONCE => {
            let pointer = Pointer::new(to.name(), &root, length);
            let beside = to.beside(&pointer.name);
            upload(source, &root, &beside, connection, replace, sent)?;
            let found = put(&place, pointer.to_bytes(), mode);
            if let Err(failure) = found {
                if let Some(published) = was_there(source, to, connection)? {
                    return Ok(published);
                }
                return Err(lost(failure, &beside).at(to));
            }
            check(source, to, connection)?;
            Ok(Published { beside: Some(beside), was_there: false })
        }
        _ => {
            let bytes = read(source, 0, length)?;
            if let Err(failure) = put(&place, bytes, mode) {
                return match was_there(source, to, connection)? {
                    Some(published) => Ok(published),
                    None => Err(meanwhile(failure).at(to)),
                };
            }
            sent(length);
            check(source, to, connection)?;
            Ok(Published { beside: None, was_there: false })
        }
    }
}

/// Writes a small object on a condition.
fn put(place: &Locator, bytes: Vec<u8>, mode: PutMode) -> std::result::Result<(), Failure> {
    let Ok(runtime) = runtime() else { return Err(Failure::new(Cause::Passing, "no thread can be started")) };
    traffic::asked();
    let options = PutOptions { mode, ..PutOptions::default() };
    let written = runtime.block_on(place.store.put_opts(&place.path, PutPayload::from(bytes), options));
    written.map(drop).map_err(|error| Failure::of(&error))
}

/// Somebody else was faster.
fn meanwhile(failure: Failure) -> Failure {
    match failure.cause {
        Cause::Exists | Cause::Changed => {
            Failure::new(Cause::Exists, "was written by somebody else meanwhile; that stays")
        }
        _ => failure,
    }
}

/// The same, where bytes were sent before.
fn lost(failure: Failure, beside: &Address) -> Failure {
    let Failure { cause, what } = meanwhile(failure);
    Failure::new(
        cause,
        format!("{what}; nothing points to what was sent, {}: remove it if nobody wants it", beside.shown().display()),
    )
}

/// Whether what is there is what is published.
fn was_there(source: &Upload, to: &Address, connection: Connection) -> Result<Option<Published>> {
    // What cannot be opened is something else.
    let Ok(there) = settled(to, connection) else { return Ok(None) };
    let same = is_same(source, &there)?;
    let beside = Some(Address::parse(there.name())?).filter(|address| address.name() != to.name());
    Ok(same.then_some(Published { beside, was_there: true }))
}

/// Whether an object holds what is published: an archive of the same root does, of other files all bytes count.
fn is_same(source: &Upload, there: &RemoteFile) -> Result<bool> {
    let length = source.bytes.length();
    if there.length() != length || source.root.is_some() {
        return Ok(there.length() == length && there.root() == source.root);
    }
    let held = there.copy_at(0, usize::try_from(length).unwrap_or(usize::MAX));
    Ok(held.map_err(Error::unread(there.name()))? == read(source, 0, length)?)
}

/// Opens what is there; again where others write it at that very moment, who may send the same archive.
fn settled(to: &Address, connection: Connection) -> Result<RemoteFile> {
    for _ in 0..LOOKS {
        match RemoteFile::open(to, connection, None) {
            Err(Error::SourceChanged { .. }) => {}
            opened => return opened,
        }
    }
    RemoteFile::open(to, connection, None)
}

/// Looks at what was written: its length, and the root of an archive.
fn check(source: &Upload, to: &Address, connection: Connection) -> Result<()> {
    let there = settled(to, connection)?;
    let (found, expected) = (there.length(), source.bytes.length());
    if found == expected && (source.root.is_none() || there.root() == source.root) {
        return Ok(());
    }
    let what = format!("holds something else than was written just now: {found} bytes of {expected}, or another root");
    Err(Failure::new(Cause::Refused, what).at(to))
}

/// Writes an archive in parts, unless it is there and stays: its name says what it is.
fn upload(
    source: &Upload,
    root: &[u8; 32],
    to: &Address,
    connection: Connection,
    replace: bool,
    sent: impl Fn(u64),
) -> Result<()> {
    let (place, runtime, length) = (Locator::connect(to, connection)?, runtime()?, source.bytes.length());
    let failed = |failure: Failure| failure.at(to);
    if !replace && runtime.block_on(look(&place)).map_err(failed)?.is_some() {
        let there = settled(to, connection)?;
        if there.length() == length && there.root() == Some(*root) {
            sent(length);
            return Ok(());
        }
        return Err(failed(Failure::new(Cause::Exists, "has the name of an archive that it is not")));
    }
    let begun = runtime.block_on(place.store.put_multipart(&place.path));
    let upload: Box<dyn MultipartUpload> = begun.map_err(|error| failed(Failure::of(&error)))?;
    let part = PART.max(length.div_ceil(MOST_PARTS));
    let mut writer = WriteMultipart::new_with_chunk_size(upload, usize::try_from(part).unwrap_or(usize::MAX));
    let mut at = 0;
    while at < length {
        let step = part.min(length - at);
        let bytes = match read(source, at, step) {
            Ok(bytes) => bytes,
            Err(error) => {
                // What was sent is not kept; a store that cannot be told forgets it by its own rules.
                let _ = runtime.block_on(writer.abort());
                return Err(error);
            }
        };
        if let Err(error) = runtime.block_on(writer.wait_for_capacity(UNDER_WAY)) {
            let _ = runtime.block_on(writer.abort());
            return Err(failed(Failure::of(&error)));
        }
        let _entered = runtime.enter();
        traffic::asked();
        writer.put(bytes.into());
        at += step;
        sent(step);
    }
    runtime.block_on(writer.finish()).map_err(|error| failed(Failure::of(&error)))?;
    check(source, to, connection)
}

fn read(source: &Upload, at: u64, length: u64) -> Result<Vec<u8>> {
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    source.bytes.copy_at(at, length).map_err(Error::unread(source.name))
}
