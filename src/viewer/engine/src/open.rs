//! An archive that was opened. In: the bytes of the host. Out: the archive, its site, where each
//! tile starts; or which of the ways to be no archive it is.

use std::path::Path;

use heliotile_core::archive::format::{FIRST_BLOCK, MAGIC, RECEIVERS, SLOT_OFFSETS, SLOT_SIZE, Slot};
use heliotile_core::archive::{Archive, ReadAt};
use heliotile_core::error::Error;
use heliotile_core::opened::OpenSite;

use crate::failure::{Failure, Kind};
use crate::host::HostBytes;

/// An archive for as long as the engine lives: the memory of both is given back together.
pub struct Opened {
    pub archive: &'static Archive,
    pub site: OpenSite<'static>,
    /// `[tile]`: receivers of the tiles before it.
    pub firsts: Vec<u64>,
}

impl Opened {
    /// The archive of the host; `name` is what messages call it.
    pub fn of(name: &str, bytes: u64) -> Result<Self, Failure> {
        let archive = Archive::of(Path::new(name), HostBytes::new(bytes)).map_err(|error| refused(error, bytes))?;
        let archive: &'static Archive = Box::leak(Box::new(archive));
        let site = OpenSite::of(archive)?;
        let mut before = 0;
        let firsts = archive.entries_of(RECEIVERS).iter().map(|entry| {
            let first = before;
            before += u64::from(entry.items);
            first
        });
        Ok(Opened { archive, site, firsts: firsts.collect() })
    }

    /// A tile that exists.
    pub fn tile(&self, tile: u32) -> Result<u32, Failure> {
        match tile < self.site.tiles() {
            true => Ok(tile),
            false => Err(Failure::new(Kind::Other, format!("there is no tile {tile} of {}", self.site.tiles()), "")),
        }
    }

    /// Number of its first receiver.
    pub fn first(&self, tile: u32) -> u64 {
        self.firsts.get(tile as usize).copied().unwrap_or_default()
    }
}

/// Whether bytes are of no archive, of a part of one, or of a later one.
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

/// Whether a slot of the header tells of more bytes than there are.
fn lacks_bytes(bytes: u64) -> bool {
    let slot = |offset: u64| {
        let mut slot = [0; SLOT_SIZE];
        HostBytes::new(bytes).read_at(offset, &mut slot).ok()?;
        Slot::decode(&slot)
    };
    bytes >= FIRST_BLOCK && SLOT_OFFSETS.into_iter().filter_map(slot).any(|slot| slot.committed > bytes)
}
