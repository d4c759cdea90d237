//! The one entry to archives that are read. In: a path, or the address of an object. Out: the
//! archive there, or the archive that a pointer there leads to.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::naming::{is_address, shown};
use super::stored;
use heliotile_core::archive::pointer::{MAX_POINTER, Pointer};
use heliotile_core::archive::read_at::OpenFile;
use heliotile_core::archive::{self, Access, Archive, ReadAt, VerifyReport, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::Message;

/// Name of the plan in the folder of an atlas.
pub const ATLAS: &str = "atlas.json";

/// Opens the archive at a place: a path, which is read as `access` says, or an address (with the
/// feature `remote`). Errors are those of [`Archive::open`] and those of stores: not there, not
/// allowed, not reached, changed meanwhile.
pub fn open_archive(place: &Path, access: Access) -> Result<Archive> {
    if is_address(place) {
        return Archive::new(shown(place), stored::hold(place, true)?);
    }
    if place.join(ATLAS).is_file() {
        let hint = "give the site.helio of one part; queries, replays, factors, buildings, places and checks accept a whole atlas, and \
                    `{command:atlas catalogue}` writes its page";
        return Err(Error::input(place, None, "is an atlas, but a single archive is needed here", hint)
            .because(Problem::other_kind("atlas")));
    }
    let Some(pointer) = pointer_at(place) else { return Archive::open_with(place, access) };
    let archive = Archive::open_with(&place.with_file_name(&pointer.name), access)?;
    if format::hex(&archive.root()) != pointer.root {
        let what = format!("is not the archive that {} points to: that has root {}", place.display(), pointer.root);
        return Err(Error::input(archive.path(), None, what, "copy both again"));
    }
    Ok(archive)
}

/// Opens the archive at a place, or returns `None` if nothing is there.
pub fn find_archive(place: &Path, access: Access) -> Result<Option<Archive>> {
    match is_address(place) {
        true => stored::find(place, true, true)?.map(|file| Archive::new(shown(place), file)).transpose(),
        false => place.is_file().then(|| open_archive(place, access)).transpose(),
    }
}

/// Checks every block of the archive at a place. For an address it checks what the store holds, not
/// this machine's cache. See [`archive::verify()`].
pub fn verify_archive(place: &Path, access: Access, deep: bool) -> Result<VerifyReport> {
    match (is_address(place), pointer_at(place)) {
        (true, _) => archive::verify_bytes(shown(place), stored::hold(place, false)?, deep),
        (false, Some(pointer)) => {
            open_archive(place, access)?;
            archive::verify(&place.with_file_name(&pointer.name), access, deep)
        }
        (false, None) => archive::verify(place, access, deep),
    }
}

/// Opens the bytes at a place, whatever they are, or the bytes of the archive that a pointer there
/// leads to.
pub fn hold(place: &Path) -> Result<Box<dyn ReadAt>> {
    if is_address(place) {
        return Ok(Box::new(stored::hold(place, true)?));
    }
    let led = pointer_at(place).map(|pointer| place.with_file_name(&pointer.name));
    let place = led.as_deref().unwrap_or(place);
    let file = File::open(place).map_err(Error::io(place, "open"))?;
    Ok(Box::new(OpenFile::new(file).map_err(Error::io(place, "read the length of"))?))
}

/// Refuses an address where only a file will do; `why` says why in the error.
pub fn require_file(place: &Path, why: &str) -> Result<()> {
    if !is_address(place) {
        return Ok(());
    }
    let hint = Message::from("fetch it first: {command:archive copy} ").and(format!("{} FILE", shown(place).display()));
    Err(Error::input(&shown(place), None, format!("is an address: {why}"), hint))
}

/// Reads the pointer in a file, or returns `None` if the file is no pointer.
fn pointer_at(path: &Path) -> Option<Pointer> {
    let mut bytes = Vec::new();
    // Only regular files are read: a pipe would lose the bytes that are read here.
    let file = File::open(path).ok().filter(|file| file.metadata().is_ok_and(|about| about.is_file()))?;
    file.take(MAX_POINTER as u64 + 1).read_to_end(&mut bytes).ok()?;
    Pointer::from_bytes(&bytes)
}
