//! Which receivers results are about: all of some archives, or those of a list or a box. In: arguments, a file of ids. Out: the sites, the
//! tiles to compute, and which rows of them count.

use std::path::Path;

use super::sources::{Archives, site_of};
use crate::cli::TableArgs;
use crate::commands::guard_output;
use crate::outputs::tables::writer::files_of;
use heliotile_builder::transfer::{ArchiveReceivers, LayeredReceiver, Layers, Selection, Shown};
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::Result;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::reflectances::Changeable;
use heliotile_core::replay::run::TileResult;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;

/// A choice of receivers.
pub struct Chosen<'a> {
    /// At least one.
    parts: Vec<ChosenPart<'a>>,
    north: North,
}

/// What is chosen of an archive.
pub struct ChosenPart<'a> {
    pub archive: &'a Archive,
    pub site: OpenSite<'a>,
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

impl<'a> Chosen<'a> {
    /// The choice of a command line.
    pub fn of(args: &TableArgs, archives: Archives<'a>) -> Result<Self> {
        let sites: Vec<OpenSite> = archives.iter().map(|archive| site_of(args, archive)).collect::<Result<_>>()?;
        let mut kept = selection(args).map(|selection| {
            let folder =
                if args.output == Path::new("-") { std::env::temp_dir() } else { folder_of(&args.output).into() };
            let budget = MemoryBudget::new(args.memory.0).length(Use::ReceiverList);
            selection.resolve(&sites, &folder, budget).map(Vec::into_iter)
        });
        let mut kept = kept.take().transpose()?;
        let north = sites.first().map(OpenSite::north).unwrap_or_default();
        let part = |(archive, site): (&'a Archive, OpenSite<'a>)| {
            let own = kept.as_mut().map(|kept| kept.by_ref().take(site.receivers() as usize).collect());
            ChosenPart::new(archive, site, own)
        };
        Ok(Chosen { parts: archives.iter().zip(sites).map(part).collect(), north })
    }

    /// What is chosen of each archive.
    pub fn parts(&self) -> &[ChosenPart<'a>] {
        &self.parts
    }

    /// Where true north lies.
    pub fn north(&self) -> North {
        self.north
    }

    /// Number of chosen receivers.
    pub fn count(&self) -> u64 {
        self.parts.iter().map(ChosenPart::count).sum()
    }

    /// The chosen receivers, in the order of results, with some of their layers.
    pub fn rows<L: Layers + 'a>(&'a self) -> impl Iterator<Item = Result<LayeredReceiver<L>>> + 'a {
        self.parts.iter().flat_map(ChosenPart::rows::<L>)
    }

    /// The chosen receivers, in the order of results.
    pub fn receivers(&'a self) -> impl Iterator<Item = Result<Receiver>> + 'a {
        self.rows::<()>().map(|row| Ok(row?.receiver))
    }

    /// The same with their patches.
    pub fn shown(&'a self) -> impl Iterator<Item = Result<Receiver>> + 'a {
        self.rows::<Shown>().map(|row| row.map(|row| Receiver { patch: row.layers.patch, ..row.receiver }))
    }
}

impl<'a> ChosenPart<'a> {
    fn new(archive: &'a Archive, site: OpenSite<'a>, kept: Option<Vec<bool>>) -> Self {
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
        ChosenPart { archive, site, kept, tiles }
    }

    /// What of its light may be changed.
    pub fn changeable(&self) -> Changeable<'_> {
        Changeable::of(&self.site, self.archive.manifest())
    }

    /// Tiles that hold a chosen receiver, in order.
    pub fn tiles(&self) -> &[ChosenTile] {
        &self.tiles
    }

    fn count(&self) -> u64 {
        match &self.kept {
            Some(kept) => kept.iter().filter(|kept| **kept).count() as u64,
            None => self.tiles.iter().map(|tile| tile.count as u64).sum(),
        }
    }

    fn rows<L: Layers + 'a>(&'a self) -> ArchiveReceivers<'a, L> {
        match &self.kept {
            Some(kept) => ArchiveReceivers::chosen(&self.site, self.archive, kept),
            None => ArchiveReceivers::new(&self.site),
        }
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

/// What of the archives is asked for, if not all.
fn selection(args: &TableArgs) -> Option<Selection> {
    let listed = args.receivers.clone().map(Selection::Receivers);
    listed.or(args.bbox.map(Selection::Bounds))
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
