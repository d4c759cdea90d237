//! One receiver of an archive with its layers. In: an archive and an id. Out: what this receiver sees, decoded.

use crate::archive::tables::{Materials, Receivers};
use crate::archive::{Archive, format};
use crate::error::{Error, Result};
use crate::layers::canopy::{Canopy, Powers};
use crate::layers::mirror::Path;
use crate::layers::mosaic::Mosaic;
use crate::layers::response::Response;
use crate::light::canopies::stored;
use crate::light::load::{cached_responses, mirror_table, tile_layers, tile_view};
use crate::light::response::{Reflector, Viewer};
use crate::replay::specular::MirrorView;
use crate::site::cells::CellKey;
use crate::site::material::Class;
use crate::site::receiver::Receiver;

/// Names that an error suggests.
const SUGGESTED: usize = 3;

/// A receiver and what it sees.
pub struct ReceiverView {
    pub receiver: Receiver,
    /// Shares of its hemisphere: sky, ground, obstruction.
    pub views: [f32; 3],
    pub sky: Mosaic,
    /// What its rays cross, and what that leaves by the stored transmittances.
    pub canopy: Canopy,
    pub powers: Powers,
    pub viewer: Viewer,
    /// Cells that its tile sees, sorted.
    pub palette: Vec<CellKey>,
    /// `[texel]` of the hit texture: 0 = nothing met, else palette index + 1.
    pub texels: Vec<u32>,
    /// Surfaces that it sees in mirrors.
    pub paths: Vec<Path>,
    /// The sky that it sees in mirrors.
    pub mirrors: Vec<MirrorView>,
    pub materials: Materials,
    /// `[material]`: whether it is a mirror or glass; empty in a scene without any.
    mirroring: Vec<bool>,
    tile: u32,
    row: usize,
}

impl ReceiverView {
    /// Reads the receiver of a name; an unknown one is an error that names those like it.
    pub fn load(archive: &Archive, id: &str) -> Result<Self> {
        let (tile, row, table) = find(archive, id)?;
        let mut view = tile_view(archive, tile)?;
        let mirrors = mirror_table(archive)?;
        let (_, layers) = tile_layers(archive, tile, (true, mirrors.as_ref()), Vec::new())?;
        let per_receiver = view.hits.texels.len() / table.rows().max(1);
        let texels = view.hits.texels.iter().skip(row * per_receiver).take(per_receiver).copied().collect();
        let defect = || Error::input(archive.path(), None, format!("receiver `{id}` is cut off"), "report this defect");
        Ok(ReceiverView {
            receiver: table.receivers().into_iter().nth(row).ok_or_else(defect)?,
            views: table.views().nth(row).ok_or_else(defect)?,
            sky: layers.sky.into_iter().nth(row).ok_or_else(defect)?,
            canopy: layers.canopies.into_iter().nth(row).unwrap_or_default(),
            powers: stored(archive)?,
            viewer: view.viewers.get(row).copied().ok_or_else(defect)?,
            palette: view.hits.palette,
            texels,
            paths: view.mirrored.get_mut(row).map(std::mem::take).unwrap_or_default(),
            mirrors: layers.mirrors.into_iter().nth(row).unwrap_or_default(),
            materials: Materials::from_block(&archive.block(format::MATERIALS, 0)?)?,
            mirroring: mirrors.map_or(Vec::new(), |table| table.reflectors.iter().map(Reflector::mirrors).collect()),
            tile,
            row,
        })
    }

    /// The response that the build derived.
    pub fn response(&self, archive: &Archive) -> Result<Response> {
        let found = cached_responses(archive, self.tile)?.into_iter().nth(self.row);
        let what = || format!("receiver `{}` has no response", self.receiver.id);
        found.ok_or_else(|| Error::input(archive.path(), None, what(), "build the archive again"))
    }

    /// The cell that a texel of the hit texture meets.
    pub fn cell(&self, texel: usize) -> Option<&CellKey> {
        self.palette.get((*self.texels.get(texel)? as usize).checked_sub(1)?)
    }

    /// Whether there are mirrors in the scene.
    pub fn has_mirrors(&self) -> bool {
        !self.mirroring.is_empty()
    }

    /// Whether what it meets is a mirror or glass.
    pub fn is_mirror(&self, texel: usize) -> bool {
        let material = self.cell(texel).map(|cell| usize::from(cell.material));
        material.and_then(|material| self.mirroring.get(material).copied()).unwrap_or(false)
    }

    /// The class of what it meets.
    pub fn class(&self, texel: usize) -> Option<Class> {
        let material = usize::from(self.cell(texel)?.material);
        (material < self.materials.rows()).then(|| self.materials.class_of(material))
    }
}

/// Tile and row of a receiver, and the table that it stands in.
fn find(archive: &Archive, id: &str) -> Result<(u32, usize, Receivers)> {
    let mut near: Vec<(usize, String)> = Vec::new();
    for block in archive.scan(format::RECEIVERS) {
        let block = block?;
        let table = Receivers::from_block(&block)?;
        if let Some(row) = table.ids.iter().position(|other| other == id) {
            return Ok((block.entry().tile, row, table));
        }
        let wanted = id.to_lowercase();
        near.extend(table.ids.into_iter().map(|other| (strsim::osa_distance(&wanted, &other.to_lowercase()), other)));
        near.sort_unstable();
        near.truncate(SUGGESTED);
    }
    let names: Vec<&str> = near.iter().map(|(_, name)| name.as_str()).collect();
    let hint = format!("name a receiver of the archive, such as {}", names.join(", "));
    Err(Error::input(archive.path(), None, format!("holds no receiver `{id}`"), hint))
}
