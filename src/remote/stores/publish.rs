//! Publishing a file in an object store. In: bytes, an address. Out: a whole object, written only
//! if nothing was there or if the object that it replaces had not changed meanwhile.
//!
//! Small objects are written in one conditional request. Large ones cannot be: an archive is
//! uploaded in parts to a name with its root, and the pointer that makes it visible ([`Pointer`])
//! is written last, in a conditional request.

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

/// Largest archive that is written in one request, bytes; larger ones are uploaded in parts.
const AT_ONCE: u64 = 16 << 20;
/// Largest file that is no archive, bytes: it is written in one request.
pub const LARGEST_FILE: u64 = 256 << 20;
/// Bytes of a part, unless the object would have more than [`MAX_PARTS`] parts.
const PART: u64 = 8 << 20;
/// Most parts of an object: S3 takes 10,000.
const MAX_PARTS: u64 = 9_000;
/// Times that an object is opened again if it changes while it is opened.
const LOOKS: usize = 5;
/// Most parts under way.
const UNDER_WAY: usize = 4;

/// A file to publish.
pub struct Upload<'s> {
    /// Bytes of the file.
    pub bytes: &'s dyn ReadAt,
    /// Root of an archive; `None` for another file.
    pub root: Option<[u8; 32]>,
    /// Name of the file for messages.
    pub name: &'s std::path::Path,
}

/// Result of publishing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Published {
    /// Address of the bytes, if a pointer leads to them.
    pub beside: Option<Address>,
    /// True if the same bytes were there already and nothing was written.
    pub was_there: bool,
}

/// Refuses addresses that cannot be written to, before there is something to write.
pub fn check_target(to: &Address) -> Result<()> {
    if to.scheme() == Scheme::Web {
        let hint = "give s3://BUCKET/NAME, gs://BUCKET/NAME or az://CONTAINER/NAME";
        return Err(Error::input(
            to.shown(),
            None,
            "is on a web server, but heliotile writes to object stores only",
            hint,
        ));
    }
    Ok(())
}

/// Writes an object and reads it again to check it, unless the same is there; calls `sent` with the
/// number of bytes of each step. Errors: something else is there, unless `replace`; others wrote
/// there meanwhile; the store has no conditional requests.
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
        return Err(Error::Limit { what: what.into(), value: length, max: LARGEST_FILE });
    }
    let place = Locator::connect(to, connection)?;
    let failed = |failure: Failure| failure.at(to);
    let before = runtime()?.block_on(look(&place)).map_err(failed)?;
    let mode = match before {
        // With `replace` the object is written even if it has the same root: its blocks may be
        // damaged.
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

/// Writes a small object in a conditional request.
fn put(place: &Locator, bytes: Vec<u8>, mode: PutMode) -> std::result::Result<(), Failure> {
    let Ok(runtime) = runtime() else { return Err(Failure::new(Cause::Passing, "no thread can be started")) };
    traffic::asked();
    let options = PutOptions { mode, ..PutOptions::default() };
    let written = runtime.block_on(place.store.put_opts(&place.path, PutPayload::from(bytes), options));
    written.map(drop).map_err(|error| Failure::from_store(&error))
}

/// Words the failure of a conditional request: another program wrote first.
fn meanwhile(failure: Failure) -> Failure {
    match failure.cause {
        Cause::Exists | Cause::Changed => {
            Failure::new(Cause::Exists, "was written by another program meanwhile, and is kept")
        }
        _ => failure,
    }
}

/// Words the failure of a conditional request after an archive was uploaded beside, which stays.
fn lost(failure: Failure, beside: &Address) -> Failure {
    let Failure { cause, what } = meanwhile(failure);
    Failure::new(
        cause,
        format!(
            "{what}; nothing points to the uploaded archive {}: remove it if it is not needed",
            beside.shown().display()
        ),
    )
}

/// Returns the result if the object at `to` is already the one to publish.
fn was_there(source: &Upload, to: &Address, connection: Connection) -> Result<Option<Published>> {
    // An object that cannot be opened counts as a different one.
    let Ok(there) = settled(to, connection) else { return Ok(None) };
    let same = is_same(source, &there)?;
    let beside = Some(Address::parse(there.name())?).filter(|address| address.name() != to.name());
    Ok(same.then_some(Published { beside, was_there: true }))
}

/// Returns true if an object holds the bytes to publish. Archives are compared by their roots,
/// other files byte by byte.
fn is_same(source: &Upload, there: &RemoteFile) -> Result<bool> {
    let length = source.bytes.length();
    if there.length() != length || source.root.is_some() {
        return Ok(there.length() == length && there.root() == source.root);
    }
    let held = there.copy_at(0, usize::try_from(length).unwrap_or(usize::MAX));
    Ok(held.map_err(Error::unread(there.name()))? == read(source, 0, length)?)
}

/// Opens an object, and opens it again if it changes meanwhile: another program may be writing the
/// same archive.
fn settled(to: &Address, connection: Connection) -> Result<RemoteFile> {
    for _ in 0..LOOKS {
        match RemoteFile::open(to, connection, None) {
            Err(Error::SourceChanged { .. }) => {}
            opened => return opened,
        }
    }
    RemoteFile::open(to, connection, None)
}

/// Checks the object that was written: its length, and the root of an archive.
fn check(source: &Upload, to: &Address, connection: Connection) -> Result<()> {
    let there = settled(to, connection)?;
    let (found, expected) = (there.length(), source.bytes.length());
    if found == expected && (source.root.is_none() || there.root() == source.root) {
        return Ok(());
    }
    let what = format!("does not hold what was just written: {found} bytes instead of {expected}, or another root");
    Err(Failure::new(Cause::Refused, what).at(to))
}

/// Uploads an archive in parts, unless it is there and is to stay. Its name holds its root.
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
        return Err(failed(Failure::new(Cause::Exists, "holds another archive than its name states")));
    }
    let begun = runtime.block_on(place.store.put_multipart(&place.path));
    let upload: Box<dyn MultipartUpload> = begun.map_err(|error| failed(Failure::from_store(&error)))?;
    let part = PART.max(length.div_ceil(MAX_PARTS));
    let mut writer = WriteMultipart::new_with_chunk_size(upload, usize::try_from(part).unwrap_or(usize::MAX));
    let mut at = 0;
    while at < length {
        let step = part.min(length - at);
        let bytes = match read(source, at, step) {
            Ok(bytes) => bytes,
            Err(error) => {
                // The parts that were sent are given up; a store that cannot be reached drops them
                // by its own rules.
                let _ = runtime.block_on(writer.abort());
                return Err(error);
            }
        };
        if let Err(error) = runtime.block_on(writer.wait_for_capacity(UNDER_WAY)) {
            let _ = runtime.block_on(writer.abort());
            return Err(failed(Failure::from_store(&error)));
        }
        let _entered = runtime.enter();
        traffic::asked();
        writer.put(bytes.into());
        at += step;
        sent(step);
    }
    runtime.block_on(writer.finish()).map_err(|error| failed(Failure::from_store(&error)))?;
    check(source, to, connection)
}

fn read(source: &Upload, at: u64, length: u64) -> Result<Vec<u8>> {
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    source.bytes.copy_at(at, length).map_err(Error::unread(source.name))
}
