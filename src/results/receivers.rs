//! Receivers that results are computed for, of one archive or of the parts of an atlas one after
//! the other. In: a choice. Out: the tiles to compute, and the rows of these tiles that count.

use std::path::Path;

use super::archives::Archives;
use heliotile_archives::transfer::{ArchiveReceivers, Bounds, LayeredReceiver, Layers, Selection, Shown};
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::Result;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::reflectances::Changeable;
use heliotile_core::replay::run::TileResult;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;

/// Choice of receivers.
#[derive(Clone, Debug, Default)]
pub struct ReceiverChoice {
    /// Selection of receivers; `None`: all.
    pub selection: Option<Selection>,
    /// True if the y axis counts as north, whatever the place of the archive says.
    pub grid_north: bool,
}

impl ReceiverChoice {
    /// Returns the box that receivers are chosen by, if a box is. Parts of an atlas outside it need
    /// not be read.
    pub fn within(&self) -> Option<Bounds> {
        if let Some(Selection::Bounds(bounds)) = self.selection { Some(bounds) } else { None }
    }

    /// Returns the chosen receivers of `archives`; `folder` holds temporary files that do not fit
    /// into memory.
    pub fn of<'a>(&self, archives: Archives<'a>, folder: &Path, memory: MemoryBudget) -> Result<ReceiverSet<'a>> {
        let site = |archive: &'a Archive| {
            let site = OpenSite::open(archive)?;
            Ok(if self.grid_north { site.with_y_for_north() } else { site })
        };
        let sites: Vec<OpenSite> = archives.iter().map(site).collect::<Result<_>>()?;
        let kept = self.selection.as_ref();
        let kept = kept.map(|some| some.resolve(&sites, folder, memory.length(Use::ReceiverList))).transpose()?;
        Ok(ReceiverSet::new(archives.iter().zip(sites), kept))
    }
}

/// Chosen receivers of one archive or of several.
pub struct ReceiverSet<'a> {
    parts: Vec<PartReceivers<'a>>,
}

/// Chosen receivers of one archive.
pub struct PartReceivers<'a> {
    /// Archive that holds the receivers.
    pub archive: &'a Archive,
    /// Site of that archive, opened.
    pub site: OpenSite<'a>,
    /// `[receiver]` of the archive: true if it is chosen; `None`: all are.
    kept: Option<Vec<bool>>,
    tiles: Vec<TileReceivers>,
}

/// Tile with at least one receiver to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileReceivers {
    /// Number of the tile in the archive.
    pub number: u32,
    /// Index of the tile's first receiver in the archive; `count` is the number of its receivers.
    first: usize,
    count: usize,
}

impl<'a> ReceiverSet<'a> {
    /// Returns the receivers of `archives` for which `kept`, in their order, is true; all of them
    /// if it is `None`.
    pub fn new(archives: impl Iterator<Item = (&'a Archive, OpenSite<'a>)>, kept: Option<Vec<bool>>) -> Self {
        let mut kept = kept.map(Vec::into_iter);
        let part = |(archive, site): (&'a Archive, OpenSite<'a>)| {
            let own = kept.as_mut().map(|kept| kept.by_ref().take(site.receivers() as usize).collect());
            PartReceivers::new(archive, site, own)
        };
        ReceiverSet { parts: archives.map(part).collect() }
    }

    /// Returns all receivers of an archive.
    pub fn all_of(archive: &'a Archive) -> Result<Self> {
        Ok(ReceiverSet::new(std::iter::once((archive, OpenSite::open(archive)?)), None))
    }

    /// Returns those of the chosen receivers for which `wanted`, in their order, is true.
    #[must_use]
    pub fn some(&self, wanted: &[bool]) -> ReceiverSet<'a> {
        let mut wanted = wanted.iter();
        let part = |part: &PartReceivers<'a>| {
            let is_kept = |row: usize| part.kept.as_ref().is_none_or(|kept| kept.get(row) == Some(&true));
            let kept = (0..part.site.receivers() as usize).map(|row| is_kept(row) && wanted.next() == Some(&true));
            PartReceivers::new(part.archive, part.site.clone(), Some(kept.collect()))
        };
        ReceiverSet { parts: self.parts.iter().map(part).collect() }
    }

    /// Returns the chosen receivers of each archive.
    pub fn parts(&self) -> &[PartReceivers<'a>] {
        &self.parts
    }

    /// Returns the direction of true north, by the first archive.
    pub fn north(&self) -> North {
        self.parts.first().map(|part| part.site.north()).unwrap_or_default()
    }

    /// Returns the number of chosen receivers.
    pub fn count(&self) -> u64 {
        self.parts.iter().map(PartReceivers::count).sum()
    }

    /// Returns the chosen receivers, in the order of results, with the layers `L`.
    pub fn rows<L: Layers + 'a>(&'a self) -> impl Iterator<Item = Result<LayeredReceiver<L>>> + 'a {
        self.parts.iter().flat_map(PartReceivers::rows::<L>)
    }

    /// Returns the chosen receivers, in the order of results.
    pub fn receivers(&'a self) -> impl Iterator<Item = Result<Receiver>> + 'a {
        self.rows::<()>().map(|row| Ok(row?.receiver))
    }

    /// Returns the names of the chosen receivers.
    pub fn names(&'a self) -> Result<Vec<String>> {
        self.receivers().map(|receiver| Ok(receiver?.id)).collect()
    }

    /// Returns the chosen receivers with their patches, in the order of results.
    pub fn shown(&'a self) -> impl Iterator<Item = Result<Receiver>> + 'a {
        self.rows::<Shown>().map(|row| row.map(|row| Receiver { patch: row.layers.patch, ..row.receiver }))
    }
}

impl<'a> PartReceivers<'a> {
    fn new(archive: &'a Archive, site: OpenSite<'a>, kept: Option<Vec<bool>>) -> Self {
        let mut tiles = Vec::new();
        let mut first = 0;
        for entry in archive.entries_of(format::RECEIVERS) {
            let count = entry.items as usize;
            let here = kept.as_ref().map(|kept| kept.get(first..first + count).unwrap_or_default());
            if here.is_none_or(|here| here.contains(&true)) {
                tiles.push(TileReceivers { number: entry.tile.0, first, count });
            }
            first += count;
        }
        PartReceivers { archive, site, kept, tiles }
    }

    /// Returns the parts of this archive's light that may be changed.
    pub fn changeable(&self) -> Changeable<'_> {
        Changeable::new(&self.site, self.archive.manifest())
    }

    /// Returns the tiles that hold a chosen receiver, in order.
    pub fn tiles(&self) -> &[TileReceivers] {
        &self.tiles
    }

    /// Returns the number of chosen receivers.
    pub fn count(&self) -> u64 {
        match &self.kept {
            Some(kept) => kept.iter().filter(|kept| **kept).count() as u64,
            None => self.tiles.iter().map(|tile| tile.count as u64).sum(),
        }
    }

    /// Returns the chosen receivers, with the layers `L`.
    pub fn rows<L: Layers + 'a>(&'a self) -> ArchiveReceivers<'a, L> {
        match &self.kept {
            Some(kept) => ArchiveReceivers::chosen(&self.site, self.archive, kept),
            None => ArchiveReceivers::new(&self.site),
        }
    }

    /// Returns true if a row of a tile is among the chosen receivers.
    pub fn is_chosen(&self, tile: TileReceivers, row: usize) -> bool {
        self.kept.as_ref().is_none_or(|kept| kept.get(tile.first + row) == Some(&true))
    }

    /// Returns the results of a tile, limited to the chosen receivers.
    pub fn results(&self, tile: TileReceivers, ids: Vec<String>, values: TileValues) -> TileResult {
        let Some(kept) = &self.kept else { return (ids, values) };
        let kept = kept.get(tile.first..tile.first + tile.count).unwrap_or_default();
        if kept.iter().all(|kept| *kept) {
            return (ids, values);
        }
        let names = ids.into_iter().zip(kept).filter_map(|(id, kept)| kept.then_some(id)).collect();
        (names, values.select(kept))
    }
}
