//! What a table is made of: an archive, and all of its receivers or those of a list. In: arguments, a file of ids. Out: the archive, the
//! tiles to compute, and which rows of them count.

use std::fs;
use std::path::Path;

use crate::cli::TableArgs;
use crate::commands::guard_output;
use crate::commands::voice::remark_aside;
use crate::files::open_archive;
use crate::outputs::tables::writer::files_of;
use heliotile_builder::transfer::{ArchiveReceivers, Selection, Shown};
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::Result;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::run::TileResult;
use heliotile_core::site::receiver::Receiver;

/// A choice of receivers.
pub struct Chosen {
    /// `[receiver]` of the archive; `None`: all.
    kept: Option<Vec<bool>>,
    tiles: Vec<ChosenTile>,
}

/// A tile with receivers to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChosenTile {
    pub number: u32,
    /// Place of its first receiver in the archive, and the number of its receivers.
    first: usize,
    count: usize,
}

impl Chosen {
    /// The choice of a command line.
    pub fn of(args: &TableArgs, archive: &Archive, site: &OpenSite) -> Result<Self> {
        let Some(file) = &args.receivers else { return Ok(Chosen::new(archive, None)) };
        let folder = if args.output == Path::new("-") { std::env::temp_dir() } else { folder_of(&args.output).into() };
        let budget = MemoryBudget::new(args.memory.0).length(Use::ReceiverList);
        let kept = Selection::Receivers(file.clone()).resolve(site, &folder, budget)?;
        Ok(Chosen::new(archive, Some(kept)))
    }

    fn new(archive: &Archive, kept: Option<Vec<bool>>) -> Self {
        let mut tiles = Vec::new();
        let mut first = 0;
        for entry in archive.entries_of(format::RECEIVERS) {
            let count = entry.items as usize;
            let here = kept.as_ref().map(|kept| kept.get(first..first + count).unwrap_or_default());
            if here.is_none_or(|here| here.contains(&true)) {
                tiles.push(ChosenTile { number: entry.tile, first, count });
            }
            first += count;
        }
        Chosen { kept, tiles }
    }

    /// Tiles that hold a chosen receiver, in order.
    pub fn tiles(&self) -> &[ChosenTile] {
        &self.tiles
    }

    /// Number of chosen receivers.
    pub fn count(&self) -> u64 {
        match &self.kept {
            Some(kept) => kept.iter().filter(|kept| **kept).count() as u64,
            None => self.tiles.iter().map(|tile| tile.count as u64).sum(),
        }
    }

    /// The chosen receivers, in the order of results.
    pub fn receivers<'a>(
        &'a self,
        archive: &'a Archive,
        site: &OpenSite<'a>,
    ) -> impl Iterator<Item = Result<Receiver>> + use<'a> {
        let rows = match &self.kept {
            Some(kept) => ArchiveReceivers::<()>::chosen(site, archive, kept),
            None => ArchiveReceivers::new(site),
        };
        rows.map(|row| Ok(row?.receiver))
    }

    /// The same with their patches.
    pub fn shown<'a>(
        &'a self,
        archive: &'a Archive,
        site: &OpenSite<'a>,
    ) -> impl Iterator<Item = Result<Receiver>> + use<'a> {
        let rows = match &self.kept {
            Some(kept) => ArchiveReceivers::<Shown>::chosen(site, archive, kept),
            None => ArchiveReceivers::new(site),
        };
        rows.map(|row| row.map(|row| Receiver { patch: row.layers.patch, ..row.receiver }))
    }

    /// The results of a tile that are asked for.
    pub fn results(&self, tile: ChosenTile, (ids, values): TileResult) -> TileResult {
        let Some(kept) = &self.kept else { return (ids, values) };
        let kept = kept.get(tile.first..tile.first + tile.count).unwrap_or_default();
        if kept.iter().all(|kept| *kept) {
            return (ids, values);
        }
        let names = ids.into_iter().zip(kept).filter_map(|(id, kept)| kept.then_some(id)).collect();
        (names, values.select(kept))
    }
}

/// Refuses an output that is an input.
pub fn guard(args: &TableArgs, forcing: &[&Path]) -> Result<()> {
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(forcing);
    inputs.extend(args.receivers.as_deref());
    match args.output == Path::new("-") {
        true => Ok(()),
        false => files_of(&args.output).iter().try_for_each(|file| guard_output(file, &inputs)),
    }
}

/// Pages of a mapping count as memory of the program for as long as the system likes: a large archive is read instead.
fn access(args: &TableArgs) -> Access {
    let large = || fs::metadata(&args.archive).is_ok_and(|about| about.len() > args.memory.0 / 4);
    args.io.unwrap_or_else(|| if large() { Access::Read } else { Access::Mapped })
}

/// Opens the archive.
pub fn open(args: &TableArgs) -> Result<Archive> {
    open_archive(&args.archive, access(args))
}

/// Says where true north is, if suns are turned to it.
pub fn say_north(args: &TableArgs, archive: &Archive) {
    let place = archive.manifest().place.filter(|_| !args.grid_north);
    // Standard output may be the table.
    place.and_then(|place| place.note()).iter().for_each(|note| remark_aside(&format!("{note}\n")));
}

/// The site of an archive, with the north that is asked for.
pub fn site_of<'a>(args: &TableArgs, archive: &'a Archive) -> Result<OpenSite<'a>> {
    let site = OpenSite::of(archive)?;
    Ok(if args.grid_north { site.with_y_for_north() } else { site })
}
