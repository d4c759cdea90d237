//! One receiver of an archive with its layers. In: an archive and an id. Out: the decoded layers of
//! this receiver.

use glam::DVec3;

use crate::archive::format::{RECEIVERS, RESPONSE, SKY, TileNumber, block_name};
use crate::archive::tables::{NameOf, ReceiversTable};
use crate::error::{Error, Problem, Result};
use crate::hemisphere::texel_of;
use crate::layers::canopy;
use crate::layers::canopy::{Canopy, Powers};
use crate::layers::mirror::MirrorPath;
use crate::layers::response::Response;
use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::light::canopies::stored;
use crate::light::mirrors::MirrorTable;
use crate::light::response::Viewer;
use crate::light::tile_view::TileView;
use crate::opened::{NameIndex, OpenSite};
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::specular::MirrorView;
use crate::replay::tile_layers::{Reads, TileLayers};
use crate::site::cells::CellKey;
use crate::site::material::{Class, Material};
use crate::site::receiver::Receiver;

/// Number of names that an error suggests.
const SUGGESTED: usize = 3;

/// Receiver and its decoded layers.
pub struct ReceiverView {
    /// Id, place and normal of the receiver.
    pub receiver: Receiver,
    /// Shares of the receiver's hemisphere: sky, ground, obstruction.
    pub views: [f32; 3],
    /// Sky that the receiver sees directly, world frame.
    pub sky: SkyBitmap,
    /// Numbers of leaves and screens that the receiver's rays cross.
    pub canopy: Canopy,
    /// Shares of light that come through 0, 1, ... 1023 crossings of each canopy, by the stored
    /// transmittances.
    pub powers: Powers,
    /// Normal of the receiver, seed of its hit rays, and its view of the sky.
    pub viewer: Viewer,
    /// Cells that the receiver's tile sees, sorted.
    pub palette: Vec<CellKey>,
    /// `[texel]` of the hit texture: 0 = nothing met, else palette index + 1.
    pub texels: Vec<u32>,
    /// Surfaces that the receiver sees in mirrors.
    pub paths: Vec<MirrorPath>,
    /// Sky that the receiver sees in mirrors.
    pub(super) mirrors: Vec<MirrorView>,
    /// Materials, by the numbers in cell keys.
    pub materials: Vec<Material>,
    /// Sides of the receiver's textures.
    pub(super) sides: TextureSides,
    /// True if mirrors of the scene were traced.
    has_mirrors: bool,
    tile: u32,
    row: usize,
}

impl ReceiverView {
    /// Reads the receiver with an id. An unknown id is an error that names similar ids.
    pub fn load(site: &OpenSite, id: &str) -> Result<Self> {
        let (tile, row, table) = find(site, id)?;
        ReceiverView::new(site, tile, row, table)
    }

    /// Reads the receiver in a row of a tile without reading other tiles. A row that does not exist
    /// is an error.
    pub fn at(site: &OpenSite, tile: u32, row: usize) -> Result<Self> {
        let table = site.tile_receivers(tile)?;
        if row >= table.rows() {
            let what = format!("tile {tile} has {} receivers, there is no row {row}", table.rows());
            return Err(Error::input(site.path(), None, what, "name a row of the tile, the first is 0"));
        }
        ReceiverView::new(site, tile, row, table)
    }

    fn new(site: &OpenSite, tile: u32, row: usize, table: ReceiversTable) -> Result<Self> {
        let cut_off = |field| {
            Error::defect(site.path(), block_name(RECEIVERS, TileNumber(tile)), field, format!("has no row {row}"))
        };
        let (receiver, views) = (table.receivers().into_iter().nth(row), table.views().nth(row));
        site.expect(&[TileView::KINDS.as_slice(), &[SKY, RESPONSE]].concat(), [tile]);
        let mut view = TileView::new(site, tile, table)?;
        let per_receiver = site.settings().hit * site.settings().hit;
        let texels = view.hits.texels.iter().skip(row * per_receiver).take(per_receiver).copied().collect();
        let (viewer, palette) = (view.viewers.get(row).copied(), std::mem::take(&mut view.hits.palette));
        let paths = view.mirrors.get(row).map(|mirrors| mirrors.paths.clone());
        let mirrors = MirrorTable::new(site);
        let has_mirrors = !mirrors.orientations.is_empty();
        let reads = Reads { sky: true, mirrors: Some(&mirrors).filter(|_| has_mirrors) };
        let (_, layers) = TileLayers::of_view(site, view, reads, Vec::new())?;
        Ok(ReceiverView {
            receiver: receiver.ok_or_else(|| cut_off("position"))?,
            views: views.ok_or_else(|| cut_off("views"))?,
            sky: layers.sky.into_iter().nth(row).ok_or_else(|| cut_off("sky"))?,
            // Layers that a tile does not have are empty.
            canopy: layers.canopies.into_iter().nth(row).unwrap_or_default(),
            powers: stored(site.materials()),
            viewer: viewer.ok_or_else(|| cut_off("normal"))?,
            palette,
            texels,
            paths: paths.unwrap_or_default(),
            mirrors: layers.mirrors.into_iter().nth(row).unwrap_or_default(),
            materials: site.materials().to_vec(),
            sides: site.settings().sides(),
            has_mirrors,
            tile,
            row,
        })
    }

    /// Returns the response that the build derived.
    pub fn response(&self, site: &OpenSite) -> Result<Response> {
        let found = site.tile_responses(self.tile)?.into_iter().nth(self.row);
        let what = || format!("receiver `{}` has no response", self.receiver.id);
        found.ok_or_else(|| Error::input(site.path(), None, what(), "build the archive again"))
    }

    /// Returns the shares of light that canopies before the sky let through, by the stored
    /// transmittances, or `None` if no canopy stands before the sky.
    pub(super) fn veil(&self) -> Option<CanopyTransmittance> {
        let shares = self.canopy.through(canopy::SKY, &self.powers);
        shares.map(|shares| CanopyTransmittance::new(&shares, self.sides))
    }

    /// Returns the direction in the sky from which the light comes that a mirror shows in direction
    /// `seen`, and the share of it that is left. Returns `None` if no mirror shows the sky there.
    pub fn in_mirrors(&self, seen: DVec3) -> Option<(DVec3, f64)> {
        self.mirrors.iter().find_map(|mirror| {
            let sky = mirror.reflection.unmirrored(seen);
            mirror.shows(sky).then(|| (sky, mirror.reflection.share(sky)))
        })
    }

    /// Returns the directions in which a sun is seen in mirrors.
    pub fn mirror_images(&self, sun: DVec3) -> impl Iterator<Item = DVec3> {
        let shown = self.mirrors.iter().filter(move |mirror| mirror.shows(sun));
        shown.map(move |mirror| mirror.reflection.mirrored(sun))
    }

    /// Returns the cell that a texel of the hit texture meets.
    pub fn cell(&self, texel: usize) -> Option<&CellKey> {
        self.palette.get((*self.texels.get(texel)? as usize).checked_sub(1)?)
    }

    /// Returns true if there are mirrors in the scene.
    pub fn has_mirrors(&self) -> bool {
        self.has_mirrors
    }

    /// Returns the material of the surface that a texel of the hit texture meets.
    fn material(&self, texel: usize) -> Option<&Material> {
        self.materials.get(usize::from(self.cell(texel)?.material))
    }

    /// Returns true if a texel of the hit texture meets a mirror or glass.
    pub fn is_mirror(&self, texel: usize) -> bool {
        self.has_mirrors && self.material(texel).is_some_and(Material::mirrors)
    }

    /// Returns the class of the surface that a texel of the hit texture meets.
    pub fn class(&self, texel: usize) -> Option<Class> {
        self.material(texel).map(|material| material.class)
    }

    /// Returns the texel of the hit texture that holds the surface seen in a direction that is not
    /// sky; `local` is in the surface's axes. The texture is coarse, so a texel at the edge of the
    /// sky may hold the sky. The nearest texel that holds a surface is taken then.
    pub fn nearest_seen(&self, local: DVec3) -> Option<usize> {
        let n = self.texels.len().isqrt();
        let (column, row) = texel_of(local, n);
        let around = |far: usize| {
            let near = |at: usize| at.saturating_sub(far)..(at + far + 1).min(n);
            let mut texels = near(row).flat_map(|r| near(column).map(move |c| r * n + c));
            texels.find(|texel| self.class(*texel).is_some())
        };
        (0..n).find_map(around)
    }
}

/// Returns tile and row of a receiver, and the table of that tile.
fn find(site: &OpenSite, id: &str) -> Result<(u32, usize, ReceiversTable)> {
    for tile in NameIndex::new(site)?.tiles(NameOf::Receiver, id)? {
        let table = site.tile_receivers(tile)?;
        if let Some(row) = table.ids.iter().position(|held| held == id) {
            return Ok((tile, row, table));
        }
    }
    // The name index does not know the id. All tables are read, for the id and for similar ids to
    // suggest.
    let mut near: Vec<(usize, String)> = Vec::new();
    site.expect(&[RECEIVERS], 0..site.tiles());
    for tile in 0..site.tiles() {
        let table = site.tile_receivers(tile)?;
        if let Some(row) = table.ids.iter().position(|other| other == id) {
            return Ok((tile, row, table));
        }
        let wanted = id.to_lowercase();
        near.extend(table.ids.into_iter().map(|other| (strsim::osa_distance(&wanted, &other.to_lowercase()), other)));
        near.sort_unstable();
        near.truncate(SUGGESTED);
    }
    let names: Vec<&str> = near.iter().map(|(_, name)| name.as_str()).collect();
    let hint = format!("name a receiver of the archive, such as {}", names.join(", "));
    Err(Error::input(site.path(), None, format!("holds no receiver `{id}`"), hint).because(Problem::unknown(id, [])))
}
