//! One tile as a replay reads it. In: an open archive, the number of a tile. Out: its receivers,
//! and those of their layers that the weather needs.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::archive::format::{BlockKind, TileNumber};
use crate::archive::{format, tables};
use crate::error::Result;
use crate::layers::canopy::Canopy;
use crate::layers::mirror::{ReceiverMirrors, Window};
use crate::layers::response::Response;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::light::mirrors::MirrorTable;
use crate::light::tile_view::TileView;
use crate::opened::OpenSite;
use crate::opened::receiver_layers::MAX_SKY;
use crate::replay::direct::specular::MirrorView;

/// Decoded layers of one tile.
pub struct TileLayers {
    pub normals: Vec<DVec3>,
    /// Shares of each receiver's hemisphere: sky, ground, obstructions.
    pub views: Vec<[f32; 3]>,
    /// `[receiver]`: sky bitmap; empty if a [`Forcing`](crate::replay::tile::Forcing) does not read
    /// them.
    pub sky: Vec<SkyBitmap>,
    /// `[receiver]`: sky seen in mirrors; empty if it is not read or no receiver sees any.
    pub mirrors: Vec<Vec<MirrorView>>,
    /// `[receiver]`: canopies that rays to the sky cross; empty if they are not read or no ray of
    /// the tile crosses any.
    pub canopies: Vec<Canopy>,
    /// `[state][receiver]`: responses in each state of the reflectances of a
    /// [`Forcing`](crate::replay::tile::Forcing); empty if they are not read.
    pub responses: Vec<Vec<Response>>,
}

/// Layers that are read.
#[derive(Clone, Copy)]
pub struct Reads<'m> {
    pub sky: bool,
    /// Mirrors of the site; `None` if it has none or they are not read.
    pub mirrors: Option<&'m MirrorTable>,
}

impl Reads<'_> {
    /// Announces tiles that will be read soon. `besides` are further kinds of blocks:
    /// [`format::RESPONSE`], or the kinds from which responses are derived.
    pub fn expect(self, site: &OpenSite, tiles: &[u32], besides: &[BlockKind]) {
        let mut kinds = [&[format::RECEIVERS], besides].concat();
        if self.sky {
            kinds.extend([format::SKY, format::CANOPY]);
        }
        if self.mirrors.is_some() {
            kinds.push(format::MIRROR);
        }
        site.expect(&kinds, tiles.iter().copied());
    }
}

impl TileLayers {
    /// Reads a tile, with the names of its receivers. `responses` are the responses to use,
    /// `[state][receiver]`.
    pub fn read(
        site: &OpenSite,
        tile: u32,
        reads: Reads,
        responses: Vec<Vec<Response>>,
    ) -> Result<(Vec<String>, TileLayers)> {
        let receivers = site.tile_receivers(tile)?;
        let rows = receivers.rows();
        let mirrors = if reads.mirrors.is_some() { site.tile_mirrors(tile, rows)? } else { Vec::new() };
        let canopies = if reads.sky { site.tile_canopies(tile, rows)? } else { Vec::new() };
        TileLayers::new(site, tile, reads, receivers, mirrors, canopies, responses)
    }

    /// Reads the layers of a tile whose responses were derived. Blocks that the derivation read are
    /// not read again.
    pub fn of_view(
        site: &OpenSite,
        view: TileView,
        reads: Reads,
        responses: Vec<Vec<Response>>,
    ) -> Result<(Vec<String>, TileLayers)> {
        let mirrors = if reads.mirrors.is_some() { view.mirrors } else { Vec::new() };
        let canopies = if reads.sky { view.canopies } else { Vec::new() };
        TileLayers::new(site, view.number, reads, view.receivers, mirrors, canopies, responses)
    }

    fn new(
        site: &OpenSite,
        tile: u32,
        reads: Reads,
        receivers: tables::ReceiversTable,
        mirrors: Vec<ReceiverMirrors>,
        canopies: Vec<Canopy>,
        responses: Vec<Vec<Response>>,
    ) -> Result<(Vec<String>, TileLayers)> {
        let rows = receivers.rows();
        if let Some(other) = responses.iter().find(|of_state| of_state.len() != rows) {
            let block = site.block(format::RECEIVERS, TileNumber(tile))?;
            return Err(block.corrupt(format!("{rows} receivers"), format!("{}, one per response", other.len())));
        }
        let layers = TileLayers {
            normals: receivers.normal.iter().map(|&n| DVec3::from(n)).collect(),
            views: receivers.views().collect(),
            sky: if reads.sky { site.tile_sky(tile, rows)? } else { Vec::new() },
            mirrors: reads.mirrors.map_or(Ok(Vec::new()), |table| mirror_views(site, tile, &mirrors, table))?,
            canopies,
            responses,
        };
        Ok((receivers.ids, layers))
    }
}

/// Returns the windows of sky that the receivers of a tile see in mirrors, ready for look-ups.
pub fn mirror_views(
    site: &OpenSite,
    tile: u32,
    mirrors: &[ReceiverMirrors],
    table: &MirrorTable,
) -> Result<Vec<Vec<MirrorView>>> {
    let sides = site.settings().sides();
    let taken = AtomicUsize::new(0);
    let view = |window: &Window| {
        let view = MirrorView::new(window, table, sides)?;
        let before = taken.fetch_add(view.bytes(), Ordering::Relaxed);
        (before.saturating_add(view.bytes()) <= MAX_SKY).then_some(view)
    };
    let views = |of: &ReceiverMirrors| of.windows.iter().map(view).collect();
    match mirrors.par_iter().map(views).collect::<Option<_>>() {
        Some(found) => Ok(found),
        None => Err(site.block(format::MIRROR, TileNumber(tile))?.corrupt(
            "malformed mirror windows, or windows of missing mirrors",
            "windows that match the manifest, of mirrors that exist",
        )),
    }
}
