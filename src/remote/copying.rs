//! Copies to and from stores. In: two places. Out: the bytes of the first place at the second one,
//! whole or not at all.

use std::path::Path;

use crate::naming::{Copied, is_address, shown};
use crate::places::{hold as hold_any, open_archive};
use crate::stored::{connection, hold};
use crate::stores::download::download;
use crate::stores::publish::{Upload, publish};
use crate::stores::{Address, RemoteFile};
use heliotile_core::archive::{ReadAt, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::{Observer, Stage};

/// Copies the file or object at `from` to `to`; at least one of them is an address. A file that is
/// already at `to` is kept if it is the same.
pub fn copy(from: &Path, to: &Path, replace: bool, observer: &dyn Observer) -> Result<Copied> {
    if !is_address(to) {
        let file = hold(from, false)?;
        if !replace && to.is_file() && is_copy(&file, to)? {
            return Ok(Copied { bytes: file.length(), beside: None, was_there: true });
        }
        if to.exists() && !replace {
            let hint = "give it another name, or replace it with {replace}";
            return Err(Error::input(to, None, "is there already", hint));
        }
        let stage = Stage::begin(observer, "copy", Some(file.length()));
        download(&file, to, replace, |bytes| stage.advance(bytes))?;
        return Ok(Copied { bytes: file.length(), beside: None, was_there: false });
    }
    let address = Address::parse(to)?;
    let bytes = if is_address(from) { Box::new(hold(from, false)?) } else { hold_any(from)? };
    let name = shown(from);
    let starts = bytes.length() >= format::MAGIC.len() as u64
        && bytes.copy_at(0, format::MAGIC.len()).map_err(Error::unread(&name))? == format::MAGIC;
    // An archive that cannot be opened is not uploaded: readers could not use it.
    let root = if starts { Some(open_archive(from, Default::default())?.root()) } else { None };
    let stage = Stage::begin(observer, "copy", Some(bytes.length()));
    let source = Upload { bytes: bytes.as_ref(), root, name: &name };
    let published = publish(&source, &address, connection()?, replace, |bytes| stage.advance(bytes))?;
    let beside = published.beside.map(|beside| beside.shown().to_path_buf());
    Ok(Copied { bytes: bytes.length(), beside, was_there: published.was_there })
}

/// Returns true if the file at `path` holds what `object` holds. Archives are compared by their
/// roots, other files byte by byte.
fn is_copy(object: &RemoteFile, path: &Path) -> Result<bool> {
    let file = hold_any(path)?;
    if file.length() != object.length() {
        return Ok(false);
    }
    if object.is_archive() {
        return Ok(open_archive(path, Default::default()).is_ok_and(|held| Some(held.root()) == object.root()));
    }
    let length = usize::try_from(file.length()).unwrap_or(usize::MAX);
    Ok(file.copy_at(0, length).map_err(Error::unread(path))?
        == object.copy_at(0, length).map_err(Error::unread(object.name()))?)
}
