//! Layers that an earlier build of the same scene with the same settings traced. In: its archive,
//! complete or damaged. Out: layers of receivers and cells, so that nothing is traced twice. Every
//! block is checked before it is used. Damaged blocks count as absent: their errors are ignored on
//! purpose.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use heliotile_core::archive::format::{CellKind, TileNumber};
use heliotile_core::archive::tables::ReceiversTable;
use heliotile_core::archive::{Archive, format};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::cells::Cell;
use heliotile_core::layers::extras::ReceiverExtras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::opened::{CellSource, OpenSite, SiteFacts};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::receiver::Receiver;

/// Layers of one receiver.
pub(super) struct KnownReceiver {
    pub sky: SkyTexture,
    /// Bits that `sky` encodes.
    pub dense: BitSquare,
    pub hits: Vec<Option<CellKey>>,
    pub extras: ReceiverExtras,
}

/// The archive to look layers up in, if there is one.
#[derive(Default)]
pub(super) struct LayerCache<'a> {
    earlier: Option<Earlier<'a>>,
}

/// One archive to look layers up in.
pub(super) struct Earlier<'a> {
    /// Site with the materials and mirrors of the present scene, if the scene is the same: the
    /// archive's own tables may be damaged.
    site: OpenSite<'a>,
    /// Tile and row by [`place_hash`].
    receivers: HashMap<u128, (u32, u32)>,
    probes: Option<CellSource<'a>>,
    bounces: Option<CellSource<'a>>,
}

impl<'a> LayerCache<'a> {
    /// Opens an archive, which must be of the scene of `scene` and have the same settings. What is
    /// damaged is skipped, and traced again.
    pub fn new(archive: Option<&'a Archive>, scene: &SiteFacts) -> Self {
        let earlier = |archive: &'a Archive| {
            // Without the table of mirrors, layers of views in mirrors are missing, too, and would
            // count as empty.
            if archive.has(format::MIRRORS, TileNumber::FIRST) == scene.orientations().is_empty() {
                return None;
            }
            let manifest = archive.manifest();
            let (settings, origin) = (&manifest.settings, manifest.scene.origin_m.into());
            let (materials, orientations) = (scene.materials().to_vec(), scene.orientations().to_vec());
            let facts =
                SiteFacts::given(archive.path(), settings, origin, &manifest.receivers, materials, orientations)
                    .ok()?;
            Some(Earlier::open(OpenSite::over(archive, Arc::new(facts))))
        };
        LayerCache { earlier: archive.and_then(earlier) }
    }

    /// Returns the known layers of the receivers of a tile, in their order.
    pub fn receivers(&self, tile: &[Receiver]) -> Vec<Option<KnownReceiver>> {
        let mut found: Vec<Option<KnownReceiver>> = tile.iter().map(|_| None).collect();
        if let Some(earlier) = &self.earlier {
            earlier.fill(tile, &mut found);
        }
        found
    }

    /// Returns the known cells of some keys, sorted by key.
    pub fn cells(&self, kind: CellKind, keys: &[CellKey]) -> Vec<Cell> {
        let source = self.earlier.as_ref().and_then(|earlier| earlier.source(kind));
        source.map_or(Vec::new(), |source| whole_cells(source, keys))
    }
}

impl<'a> Earlier<'a> {
    /// Indexes the receivers of an opened site by place. Damaged tables count as absent.
    pub fn open(site: OpenSite<'a>) -> Self {
        let places = |tile: u32| -> Vec<(u128, (u32, u32))> {
            // A damaged tile holds no known receivers.
            let Ok(table) = site.tile_receivers(tile) else { return Vec::new() };
            let hashes = table.position.iter().zip(&table.normal).map(|(p, n)| place_hash(p, n));
            hashes.zip(0..).map(|(hash, row)| (hash, (tile, row))).collect()
        };
        Earlier {
            receivers: (0..site.tiles()).into_par_iter().flat_map_iter(places).collect(),
            probes: CellSource::probes(&site).ok(),
            bounces: CellSource::bounces(&site).ok(),
            site,
        }
    }

    /// Returns the cells of a kind.
    pub fn source(&self, kind: CellKind) -> Option<&CellSource<'a>> {
        match kind {
            CellKind::Probes => self.probes.as_ref(),
            CellKind::Bounces => self.bounces.as_ref(),
        }
    }

    /// Returns the tile that holds exactly these receivers in this order, and its table; `None` if
    /// there is none or it is damaged.
    pub fn tile_of(&self, receivers: &[Receiver]) -> Option<(u32, ReceiversTable)> {
        let first = receivers.first()?;
        let hash = place_hash(&first.position.to_array(), &first.normal.to_array());
        let &(tile, row) = self.receivers.get(&hash)?;
        let table = self.site.tile_receivers(tile).ok().filter(|_| row == 0)?;
        let places = table.position.iter().zip(&table.normal).map(|(p, n)| (DVec3::from(*p), DVec3::from(*n)));
        places.eq(receivers.iter().map(|receiver| (receiver.position, receiver.normal))).then_some((tile, table))
    }

    /// Returns the hits of `receivers` receivers of a tile; `None` if they are damaged.
    pub fn hits(&self, tile: u32, receivers: usize) -> Option<HitTile> {
        self.site.tile_hits(tile, receivers).ok()
    }

    /// Adds the known layers of those receivers of a tile that have none yet.
    pub fn fill(&self, tile: &[Receiver], found: &mut [Option<KnownReceiver>]) {
        // Grouped by tile of the archive, since a tile is decoded as a whole.
        let mut wanted: HashMap<u32, Vec<(usize, u32)>> = HashMap::new();
        for (i, receiver) in tile.iter().enumerate().filter(|(i, _)| found[*i].is_none()) {
            let hash = place_hash(&receiver.position.to_array(), &receiver.normal.to_array());
            if let Some(&(from, row)) = self.receivers.get(&hash) {
                wanted.entry(from).or_default().push((i, row));
            }
        }
        for (from, rows) in wanted {
            let Some(mut layers) = self.tile(from) else { continue };
            for (i, row) in rows {
                found[i] = layers.get_mut(row as usize).and_then(Option::take);
            }
        }
    }

    /// Returns the layers of a tile; `None` if they are damaged.
    pub fn tile(&self, tile: u32) -> Option<Vec<Option<KnownReceiver>>> {
        let count = self.site.block(format::HIT, TileNumber(tile)).ok()?.items() as usize;
        let hits = self.site.tile_hits(tile, count).ok()?;
        let textures = self.site.tile_sky_textures(tile, count).ok()?;
        let extras = self.site.tile_extras(tile, count).ok()?;
        let layers = textures.into_iter().zip(hits.split(count)).zip(extras);
        Some(layers.map(|(((sky, dense), hits), extras)| Some(KnownReceiver { sky, dense, hits, extras })).collect())
    }
}

/// Returns the cells of some keys, sorted by key, whose chunks are intact. Damaged chunks are
/// skipped.
pub(super) fn whole_cells(source: &CellSource, keys: &[CellKey]) -> Vec<Cell> {
    let parts: Vec<&[CellKey]> = keys.chunk_by(|a, b| source.chunk_of(a) == source.chunk_of(b)).collect();
    let found = |part: &[CellKey]| -> Vec<Cell> {
        let Some(Ok(cells)) = part.first().and_then(|key| source.chunk_of(key)).map(|chunk| source.chunk(chunk)) else {
            return Vec::new();
        };
        part.iter().filter_map(|key| cells.keys.binary_search(key).ok()).map(|row| cells.cell(row)).collect()
    };
    parts.into_par_iter().flat_map_iter(found).collect()
}

/// Returns the hash of a receiver's position and normal, bit by bit. Its layers depend on nothing
/// else besides scene and settings.
fn place_hash(position: &[f64; 3], normal: &[f64; 3]) -> u128 {
    let mut hasher = blake3::Hasher::new();
    for x in position.iter().chain(normal) {
        hasher.update(&x.to_le_bytes());
    }
    let mut head = [0; 16];
    head.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
    u128::from_le_bytes(head)
}
