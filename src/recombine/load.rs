//! From blocks to the values that recombination works on. In: an archive, or blocks read back while one is built. Out: decoded
//! tables and layers, checked against each other.

use glam::DVec3;

use super::response::{Reflector, Shape, Viewer};
use super::tile::{TextureSides, TileLayers};
use crate::archive::{Archive, Block, Manifest, format, tables};
use crate::error::{Error, Result};
use crate::layers::hit::HitTile;
use crate::layers::probes::{Bounces, DOWN, MISS, Probes};
use crate::layers::response::{self, Response};
use crate::layers::sky::SkyTexture;
use crate::scene::cells::{CellKey, level_of, receiver_seed};
use crate::scene::materials::Class;

/// Receivers of one tile and what they see: enough to derive their response.
#[derive(Clone, Debug)]
pub struct TileView {
    pub ids: Vec<String>,
    pub viewers: Vec<Viewer>,
    pub hits: HitTile,
}

impl TileView {
    /// From a tile's `receivers` and `hit` blocks; `origin` of the scene, `side` of the hit texture.
    pub fn new(receivers: &Block, hit: &Block, origin: DVec3, side: usize) -> Result<Self> {
        let table = tables::Receivers::from_block(receivers)?;
        let texels = table.ids.len().saturating_mul(side * side);
        let hits = HitTile::unpack(hit.bytes(), texels)
            .ok_or_else(|| hit.corrupt("hits of another shape", "hits of the manifest's shape"))?;
        let viewer = |i: usize| {
            let (position, normal) = (DVec3::from(table.position[i]), DVec3::from(table.normal[i]));
            let sky_view = f64::from(table.sky_view[i]);
            Viewer { normal, seed: receiver_seed(position - origin, normal), sky_view }
        };
        let viewers = (0..table.ids.len()).map(viewer).collect();
        Ok(TileView { ids: table.ids, viewers, hits })
    }
}

/// Shape of the response tables of an archive.
pub fn shape(manifest: &Manifest) -> Shape {
    let settings = &manifest.settings;
    Shape {
        hit: settings.hit as usize,
        probe: settings.probe as usize,
        bounce_sky: settings.bounce_sky as usize,
        closed_level: level_of(settings.closed_m),
    }
}

/// Sides of the textures that weather is looked up in.
pub fn sides(manifest: &Manifest) -> TextureSides {
    let settings = &manifest.settings;
    TextureSides {
        sky_base: settings.sky_base as usize,
        sky_fine: settings.sky_fine as usize,
        response: settings.probe as usize,
    }
}

/// Scene origin of an archive.
pub fn origin(manifest: &Manifest) -> DVec3 {
    DVec3::from(manifest.scene.origin_m)
}

/// Receivers and hits of a tile.
pub fn tile_view(archive: &Archive, tile: u32) -> Result<TileView> {
    let manifest = archive.manifest();
    let receivers = archive.block(format::RECEIVERS, tile)?;
    let hit = archive.block(format::HIT, tile)?;
    TileView::new(&receivers, &hit, origin(manifest), shape(manifest).hit)
}

/// Ids, normals and sky bits of a tile, with the responses to use.
pub fn tile_layers(archive: &Archive, tile: u32, responses: Vec<Response>) -> Result<(Vec<String>, TileLayers)> {
    let table = tables::Receivers::from_block(&archive.block(format::RECEIVERS, tile)?)?;
    let sides = sides(archive.manifest());
    let block = archive.block(format::SKY, tile)?;
    let sky = SkyTexture::unpack(block.bytes(), table.ids.len(), sides.sky_base, sides.sky_fine)
        .ok_or_else(|| block.corrupt("sky bits of another shape", "sky bits of the manifest's shape"))?;
    let normals = table.normal.iter().map(|&n| DVec3::from(n)).collect();
    Ok((table.ids, TileLayers { normals, sky, responses }))
}

/// The responses that the build derived: its reflectances, all bounces.
pub fn cached_responses(archive: &Archive, tile: u32) -> Result<Vec<Response>> {
    let block = archive.block(format::RESPONSE, tile)?;
    response::unpack(block.bytes(), block.items() as usize, sides(archive.manifest()).response)
        .ok_or_else(|| block.corrupt("responses of another shape", "responses of the manifest's shape"))
}

/// All that responses are derived from.
#[derive(Clone, Debug)]
pub struct Tables {
    pub shape: Shape,
    pub probes: Probes,
    pub bounces: Bounces,
    pub reflectors: Vec<Reflector>,
}

impl Tables {
    /// Reads probes, bounce cells and materials.
    pub fn load(archive: &Archive) -> Result<Self> {
        let materials = tables::Materials::from_block(&archive.block(format::MATERIALS, 0)?)?;
        let reflectors = materials
            .diffuse
            .iter()
            .zip(&materials.class)
            .map(|(&diffuse, &class)| {
                let class = if class == 1 { Class::Ground } else { Class::Obstruction };
                Reflector { diffuse, class }
            })
            .collect();
        let mut probes = Probes::default();
        for block in archive.scan(format::PROBES) {
            let table = tables::Probes::from_block(&block?)?;
            probes.keys.extend(table.keys().map(cell_key));
            probes.normals.extend(table.normal);
            probes.bits.extend(table.bits);
            probes.hits.extend(table.hits);
        }
        let mut bounces = Bounces::default();
        for block in archive.scan(format::BOUNCE) {
            let table = tables::Bounce::from_block(&block?)?;
            bounces.keys.extend(table.keys().map(cell_key));
            bounces.normals.extend(table.normal);
            bounces.bits.extend(table.bits);
            bounces.hits.extend(table.hits);
        }
        let tables = Tables { shape: shape(archive.manifest()), probes, bounces, reflectors };
        let settings = &archive.manifest().settings;
        match tables.flaw(settings.probe_hits as usize, settings.bounce_hits as usize) {
            None => Ok(tables),
            Some((kind, got, expected)) => Err(Error::Corrupt {
                path: archive.path().to_path_buf(),
                block: format::kind_name(kind),
                offset: archive.entries_of(kind).first().map_or(0, |entry| entry.offset),
                got: got.into(),
                expected: expected.into(),
            }),
        }
    }

    /// What one block cannot know: how the chunks fit each other and the manifest.
    fn flaw(&self, probe_rays: usize, rays: usize) -> Option<(u32, &'static str, &'static str)> {
        let (probes, bounces) = (&self.probes, &self.bounces);
        let row = |side: usize| (side * side).div_ceil(8);
        let cells = bounces.keys.len();
        let sorted = |keys: &[CellKey]| keys.windows(2).all(|pair| pair[0] < pair[1]);
        let known = |keys: &[CellKey]| keys.iter().all(|k| usize::from(k.material) < self.reflectors.len());
        let met = |hit: &u32| hit & !DOWN == MISS || ((hit & !DOWN) as usize) < cells;
        let checks = [
            (format::PROBES, sorted(&probes.keys), "chunks out of order", "keys that rise from chunk to chunk"),
            (format::PROBES, known(&probes.keys), "an unknown material", "rows of the materials table"),
            (
                format::PROBES,
                probes.bits.len() == probes.keys.len() * row(self.shape.probe),
                "other textures",
                "the manifest's side",
            ),
            (format::BOUNCE, sorted(&bounces.keys), "chunks out of order", "keys that rise from chunk to chunk"),
            (format::BOUNCE, known(&bounces.keys), "an unknown material", "rows of the materials table"),
            (
                format::BOUNCE,
                bounces.bits.len() == cells * row(self.shape.bounce_sky),
                "other textures",
                "the manifest's side",
            ),
            (format::BOUNCE, bounces.hits.len() == cells * rays, "another number of rays", "the manifest's number"),
            (format::BOUNCE, bounces.hits.iter().all(met), "a cell that does not exist", "cells of the table"),
            (
                format::PROBES,
                probes.hits.len() == probes.keys.len() * probe_rays,
                "another number of rays",
                "the manifest's number",
            ),
            (format::PROBES, probes.hits.iter().all(met), "a cell that does not exist", "cells of the bounce table"),
        ];
        checks.into_iter().find(|check| !check.1).map(|(kind, _, got, expected)| (kind, got, expected))
    }
}

/// Facing codes beyond the known ones name nothing that any hit refers to.
fn cell_key((tag, material, voxel): (u32, u16, [i32; 3])) -> CellKey {
    let (level, facing) = tables::unpack_tag(tag).unwrap_or_default();
    CellKey { level, facing, material, voxel }
}
