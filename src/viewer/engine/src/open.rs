//! An open archive. In: the bytes of the host. Out: the archive, its site and the first receiver of
//! each tile; or the reason why the bytes are no archive.

use std::path::Path;

use heliotile_core::archive::format::{FIRST_BLOCK, MAGIC, RECEIVERS, SLOT_OFFSETS, SLOT_SIZE, Slot};
use heliotile_core::archive::{Archive, ReadAt};
use heliotile_core::error::Error;
use heliotile_core::opened::OpenSite;

use crate::failure::{Failure, Kind};
use crate::host::HostBytes;

/// Open archive. It lives as long as the engine: the memory of both is freed together.
pub struct Opened {
    pub archive: &'static Archive,
    pub site: OpenSite<'static>,
    /// `[tile]`: number of receivers of the tiles before it.
    pub firsts: Vec<u64>,
}

impl Opened {
    /// Opens the archive of the host, `bytes` long; `name` is its name in messages.
    pub fn new(name: &str, bytes: u64) -> Result<Self, Failure> {
        let archive = Archive::new(Path::new(name), HostBytes::new(bytes)).map_err(|error| refused(error, bytes))?;
        let archive: &'static Archive = Box::leak(Box::new(archive));
        let site = OpenSite::open(archive)?;
        let mut before = 0;
        let firsts = archive.entries_of(RECEIVERS).iter().map(|entry| {
            let first = before;
            before += u64::from(entry.items);
            first
        });
        Ok(Opened { archive, site, firsts: firsts.collect() })
    }

    /// Returns the tile if it exists, or else an error.
    pub fn tile(&self, tile: u32) -> Result<u32, Failure> {
        match tile < self.site.tiles() {
            true => Ok(tile),
            false => Err(Failure::new(Kind::Other, format!("there is no tile {tile} of {}", self.site.tiles()), "")),
        }
    }

    /// Returns the number of the first receiver of a tile.
    pub fn first(&self, tile: u32) -> u64 {
        self.firsts.get(tile as usize).copied().unwrap_or_default()
    }
}

/// Returns the failure of bytes that cannot be opened: no archive, a part of one, or one of a later
/// version.
fn refused(error: Error, bytes: u64) -> Failure {
    let kind = match &error {
        Error::Io { .. } => return error.into(),
        Error::Unsupported { .. } => Kind::Version,
        Error::Input { .. } if starts_as_archive(bytes) => Kind::Cut,
        Error::Input { .. } => Kind::NoArchive,
        _ if lacks_bytes(bytes) => Kind::Cut,
        _ => Kind::Damaged,
    };
    let failure = Failure::from(error);
    match kind {
        Kind::Cut => Failure { hint: "get the whole file again".into(), ..failure }.of_kind(kind),
        kind => failure.of_kind(kind),
    }
}

fn starts_as_archive(bytes: u64) -> bool {
    let mut start = [0; MAGIC.len()];
    bytes >= start.len() as u64 && HostBytes::new(bytes).read_at(0, &mut start).is_ok() && start == MAGIC
}

/// Returns true if a slot of the header states more bytes than there are.
fn lacks_bytes(bytes: u64) -> bool {
    let slot = |offset: u64| {
        let mut slot = [0; SLOT_SIZE];
        HostBytes::new(bytes).read_at(offset, &mut slot).ok()?;
        Slot::decode(&slot)
    };
    bytes >= FIRST_BLOCK && SLOT_OFFSETS.into_iter().filter_map(slot).any(|slot| slot.committed > bytes)
}
