//! Receivers of one tile and the cells they see: enough to derive their response. In: a site that
//! was opened. Out: its layers, each read once.

use glam::DVec3;

use crate::archive::format::{BlockKind, TileNumber};
use crate::archive::{format, tables};
use crate::error::Result;
use crate::layers::canopy::Canopy;
use crate::layers::hit::HitTile;
use crate::layers::mirror::ReceiverMirrors;
use crate::light::response::Viewer;
use crate::opened::OpenSite;
use crate::site::cells::{CellKey, receiver_seed};

/// A tile of receivers.
#[derive(Clone, Debug)]
pub struct TileView {
    /// Number of the tile in the archive.
    pub number: u32,
    /// Table of the tile's receivers; all lists here have its order.
    pub receivers: tables::ReceiversTable,
    /// `[receiver]`: normal, seed and view of the sky.
    pub viewers: Vec<Viewer>,
    /// `[receiver][texel]`: the cells that rays met.
    pub hits: HitTile,
    /// `[receiver]`: the cells seen in mirrors; empty where no receiver of the tile sees any.
    pub mirrors: Vec<ReceiverMirrors>,
    /// `[receiver]`: the canopies that its rays cross; empty where no ray of the tile crosses any.
    pub canopies: Vec<Canopy>,
}

impl TileView {
    /// Kinds of blocks that are read of a tile.
    pub const KINDS: [BlockKind; 4] = [format::RECEIVERS, format::HIT, format::MIRROR, format::CANOPY];

    /// Reads a tile.
    pub fn read(site: &OpenSite, number: u32) -> Result<Self> {
        TileView::new(site, number, site.tile_receivers(number)?)
    }

    /// Returns the view of a tile whose table of receivers is read already.
    pub fn new(site: &OpenSite, number: u32, receivers: tables::ReceiversTable) -> Result<Self> {
        let rows = receivers.rows();
        let viewer = |i: usize| {
            let (position, normal) = (DVec3::from(receivers.position[i]), DVec3::from(receivers.normal[i]));
            let sky_view = f64::from(receivers.sky_view[i]);
            Viewer { normal, seed: receiver_seed(position, normal), sky_view }
        };
        Ok(TileView {
            number,
            viewers: (0..rows).map(viewer).collect(),
            hits: site.tile_hits(number, rows)?,
            mirrors: site.tile_mirrors(number, rows)?,
            canopies: site.tile_canopies(number, rows)?,
            receivers,
        })
    }

    /// Iterates over all cells that its receivers see, some more than once.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        let besides = self.mirrors.iter().flat_map(ReceiverMirrors::cells);
        self.hits.palette.iter().copied().chain(besides).chain(self.canopies.iter().flat_map(Canopy::cells))
    }

    /// Returns the name of the block by which its receivers see a cell.
    pub fn block_that_sees(&self, key: &CellKey) -> String {
        let kind = match () {
            () if self.hits.palette.contains(key) => format::HIT,
            () if key.is_leaf() => format::CANOPY,
            () => format::MIRROR,
        };
        format::block_name(kind, TileNumber(self.number))
    }
}
