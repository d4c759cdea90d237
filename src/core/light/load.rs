//! From blocks to the values that recombination works on. In: an archive, or blocks read back while one is built. Out: decoded
//! tables and layers, checked against each other.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::archive::manifest::Settings;
use crate::archive::{Archive, Block, Blocks, Manifest, format, tables};
use crate::error::{Error, Result};
use crate::layers::bits::BitSquare;
use crate::layers::canopy::Canopy;
use crate::layers::cells::{Cell, Cells};
use crate::layers::extras;
use crate::layers::extras::Extras;
use crate::layers::hit::HitTile;
use crate::layers::mirror::{Path, ReceiverMirrors, Window};
use crate::layers::mosaic::Mosaic;
use crate::layers::response;
use crate::layers::response::Response;
use crate::layers::sky::SkyTexture;
use crate::light::canopies::{check_cells, tile_canopies};
use crate::light::fresnel::panes_mean;
use crate::light::response::{Reflector, Shape, Viewer};
use crate::replay::specular::{MirrorTable, MirrorView};
use crate::replay::tile::{TextureSides, TileLayers};
use crate::site::cells::{CellKey, level_of, receiver_seed};
use crate::site::chain::Orientation;

/// Receivers of one tile and what they see: enough to derive their response.
#[derive(Clone, Debug)]
pub struct TileView {
    pub ids: Vec<String>,
    pub viewers: Vec<Viewer>,
    pub hits: HitTile,
    /// `[receiver]`: surfaces that are seen in mirrors; empty where no receiver sees any.
    pub mirrored: Vec<Vec<Path>>,
    /// `[receiver]`: what its rays cross; empty where none of the tile's does.
    pub canopies: Vec<Canopy>,
}

impl TileView {
    /// A tile of an archive, or of blocks read back while one is built; `origin` of the scene.
    pub fn of(blocks: &dyn Blocks, tile: u32, origin: DVec3, settings: &Settings) -> Result<Self> {
        let table = tables::Receivers::from_block(&blocks.block(format::RECEIVERS, tile)?)?;
        let hits = blocks.block(format::HIT, tile)?;
        // Format 1.0 jittered hit rays by the place relative to the scene's origin.
        let from = if format::is_older(hits.entry()) { origin } else { DVec3::ZERO };
        let hits = hits_of(&hits, table.rows(), settings.hit as usize)?;
        let mirrored = receiver_mirrors(blocks, tile, table.rows(), settings)?.into_iter().map(|m| m.paths).collect();
        let viewer = |i: usize| {
            let (position, normal) = (DVec3::from(table.position[i]), DVec3::from(table.normal[i]));
            let sky_view = f64::from(table.sky_view[i]);
            Viewer { normal, seed: receiver_seed(position - from, normal), sky_view }
        };
        let viewers = (0..table.ids.len()).map(viewer).collect();
        let canopies = tile_canopies(blocks, settings, tile, table.ids.len())?;
        Ok(TileView { ids: table.ids, viewers, hits, mirrored, canopies })
    }

    /// All cells that its receivers see.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        self.hits.palette.iter().copied().chain(self.mirrored.iter().flatten().map(|path| path.cell))
    }
}

/// Largest sides of textures: of a receiver's sky before refinement and its hits, of the refined sky, of cells' skies.
const MAX_SIDES: [u32; 3] = [1024, 4096, 256];
/// Most bytes of a tile's sky once it is refined, and of what it sees in mirrors: a small block can stand for large textures.
const MAX_SKY: usize = 256 << 20;

/// The settings of an archive, if textures can have their sides.
pub fn settings(archive: &Archive) -> Result<&Settings> {
    let settings = &archive.manifest().settings;
    let [plain, fine, cell] = MAX_SIDES;
    let refuse = |found: String, supported: String| {
        let what = format!("{}: settings in the manifest", archive.path().display());
        Err(Error::Unsupported { what, found, supported })
    };
    for (name, side, most) in [
        ("sky_base", settings.sky_base, plain),
        ("sky_fine", settings.sky_fine, fine),
        ("hit", settings.hit, plain),
        ("probe", settings.probe, cell),
        ("bounce_sky", settings.bounce_sky, cell),
    ] {
        if side == 0 || side > most {
            return refuse(format!("{name} {side}"), format!("1 to {most}"));
        }
    }
    let (base, fine) = (settings.sky_base, settings.sky_fine);
    if fine % base != 0 || !(fine / base).is_power_of_two() {
        return refuse(format!("sky_fine {fine}"), format!("sky_base {base} doubled some times"));
    }
    Ok(settings)
}

/// Shape of the response tables of an archive.
pub fn shape(settings: &Settings) -> Shape {
    Shape {
        hit: settings.hit as usize,
        probe: settings.probe as usize,
        bounce_sky: settings.bounce_sky as usize,
        closed_level: level_of(settings.closed_m),
    }
}

/// Sides of the textures that weather is looked up in.
pub fn sides(archive: &Archive) -> Result<TextureSides> {
    let settings = settings(archive)?;
    Ok(TextureSides {
        sky_base: settings.sky_base as usize,
        sky_fine: settings.sky_fine as usize,
        response: settings.probe as usize,
    })
}

/// Scene origin of an archive.
pub fn origin(manifest: &Manifest) -> DVec3 {
    DVec3::from(manifest.scene.origin_m)
}

/// The materials of an archive, glass with what it reflects like a mirror of light that comes from everywhere alike.
pub fn materials(archive: &Archive) -> Result<tables::Materials> {
    let mut materials = tables::Materials::from_block(&archive.block(format::MATERIALS, 0)?)?;
    if let Some(optics) = optics(archive, materials.rows())? {
        for (specular, &panes) in materials.specular.iter_mut().zip(&optics.panes).filter(|(_, panes)| **panes > 0) {
            *specular = panes_mean(panes);
        }
    }
    Ok(materials)
}

/// What materials do besides reflecting diffusely, if some do.
pub(super) fn optics(blocks: &dyn Blocks, materials: usize) -> Result<Option<tables::Optics>> {
    if !blocks.has(format::OPTICS, 0) {
        return Ok(None);
    }
    let block = blocks.block(format::OPTICS, 0)?;
    let optics = tables::Optics::from_block(&block)?;
    if optics.rows() != materials {
        return Err(block.corrupt(format!("{} rows", optics.rows()), format!("{materials}, one per material")));
    }
    Ok(Some(optics))
}

/// Orientations of the mirrors, if there are any.
pub fn orientations(blocks: &dyn Blocks, materials: usize) -> Result<Vec<Orientation>> {
    if !blocks.has(format::MIRRORS, 0) {
        return Ok(Vec::new());
    }
    let block = blocks.block(format::MIRRORS, 0)?;
    let table = tables::Mirrors::from_block(&block)?;
    if table.material.iter().any(|&material| usize::from(material) >= materials) {
        return Err(block.corrupt("an unknown material", "rows of the materials table"));
    }
    let rows = table.normal.into_iter().zip(table.material);
    Ok(rows.map(|(normal, material)| Orientation { normal: DVec3::from(normal), material }).collect())
}

/// Which of so many materials are canopies.
pub fn lets_through(blocks: &dyn Blocks, materials: usize) -> Result<Vec<bool>> {
    let canopy = optics(blocks, materials)?.map(|optics| optics.canopy).unwrap_or_default();
    Ok(canopy.into_iter().map(|canopy| canopy == 1).collect())
}

/// Receivers and hits of a tile.
pub fn tile_view(archive: &Archive, tile: u32) -> Result<TileView> {
    TileView::of(archive, tile, origin(archive.manifest()), settings(archive)?)
}

/// What the receivers of a tile of so many rows see in mirrors; empty where none sees any.
pub fn receiver_mirrors(
    blocks: &dyn Blocks,
    tile: u32,
    rows: usize,
    settings: &Settings,
) -> Result<Vec<ReceiverMirrors>> {
    if !blocks.has(format::MIRROR, tile) {
        return Ok(Vec::new());
    }
    let block = blocks.block(format::MIRROR, tile)?;
    let (base, hit) = (settings.sky_base as usize, settings.hit as usize);
    let found = extras::unpack(block.bytes(), rows)
        .and_then(|rows| rows.iter().map(|row| ReceiverMirrors::from_bytes(row, base, hit)).collect());
    found.ok_or_else(|| block.corrupt("mirrors of another shape", format!("those of {rows} receivers")))
}

/// Layers of a tile of so many receivers that only some scenes call for.
pub fn tile_extras(archive: &Archive, tile: u32, rows: usize) -> Result<Vec<Extras>> {
    let [mut mirror, mut canopy] = extras_of(archive, format::RECEIVER_EXTRAS, tile, rows)?;
    let row = |layer: &mut Vec<Vec<u8>>, i: usize| layer.get_mut(i).map(std::mem::take).unwrap_or_default();
    Ok((0..rows).map(|i| [row(&mut mirror, i), row(&mut canopy, i)]).collect())
}

/// `[layer][row]` of the blocks of some kinds; no rows where there is no block.
fn extras_of(blocks: &dyn Blocks, kinds: [u32; 2], tile: u32, rows: usize) -> Result<[Vec<Vec<u8>>; 2]> {
    let mut found: [Vec<Vec<u8>>; 2] = Default::default();
    for (layer, kind) in found.iter_mut().zip(kinds) {
        if blocks.has(kind, tile) {
            let block = blocks.block(kind, tile)?;
            *layer = extras::unpack(block.bytes(), rows)
                .ok_or_else(|| block.corrupt("a layer of another shape", format!("{rows} rows")))?;
        }
    }
    Ok(found)
}

/// The cells of a chunk, whose block is read, with all their layers.
pub fn cells_of(blocks: &dyn Blocks, block: &Block) -> Result<Cells> {
    let mut cells = tables::Cells::from_block(block)?.into_cells();
    let entry = block.entry();
    cells.extras = extras_of(blocks, format::cell_extras(entry.kind), entry.tile, cells.rows())?;
    if cells.mirrors_are_whole() { Ok(cells) } else { Err(block.corrupt("mirrors of another shape", "those of cells")) }
}

/// The mirrors of an archive, if it has any.
pub fn mirror_table(archive: &Archive) -> Result<Option<MirrorTable>> {
    let materials = tables::Materials::from_block(&archive.block(format::MATERIALS, 0)?)?;
    let orientations = orientations(archive, materials.rows())?;
    if orientations.is_empty() {
        return Ok(None);
    }
    let reflectors = Reflector::of_tables(&materials, optics(archive, materials.rows())?.as_ref());
    Ok(Some(MirrorTable { orientations, reflectors }))
}

/// What the receivers of a tile of so many rows see in mirrors; empty where none sees any.
fn mirror_views(archive: &Archive, tile: u32, rows: usize, table: &MirrorTable) -> Result<Vec<Vec<MirrorView>>> {
    let (settings, sides) = (settings(archive)?, sides(archive)?);
    let block = sides.sky_fine / sides.sky_base;
    let taken = AtomicUsize::new(0);
    let view = |window: &Window| {
        let view = MirrorView::new(window, table, block)?;
        let before = taken.fetch_add(view.bytes(), Ordering::Relaxed);
        (before.saturating_add(view.bytes()) <= MAX_SKY).then_some(view)
    };
    let views = |of: &ReceiverMirrors| of.windows.iter().map(view).collect();
    let found = receiver_mirrors(archive, tile, rows, settings)?.par_iter().map(views).collect::<Option<_>>();
    match found {
        Some(found) => Ok(found),
        None => Err(archive
            .block(format::MIRROR, tile)?
            .corrupt("windows of another shape, or of too much", "the manifest's, and mirrors that exist")),
    }
}

/// Ids, normals and view factors of a tile, its sky bits and mirrors if they are read, and the responses to use, `[state][receiver]`.
pub fn tile_layers(
    archive: &Archive,
    tile: u32,
    (reads_sky, mirrors): (bool, Option<&MirrorTable>),
    responses: Vec<Vec<Response>>,
) -> Result<(Vec<String>, TileLayers)> {
    let receivers = archive.block(format::RECEIVERS, tile)?;
    let table = tables::Receivers::from_block(&receivers)?;
    let rows = table.ids.len();
    if let Some(other) = responses.iter().find(|of_state| of_state.len() != rows) {
        return Err(receivers.corrupt(format!("{rows} receivers"), format!("{}, one per response", other.len())));
    }
    let sky = if reads_sky {
        let (block, sides) = sky_block(archive, tile, rows)?;
        Mosaic::unpack(block.bytes(), rows, sides.sky_base, sides.sky_fine).ok_or_else(|| other_sky(&block))?
    } else {
        Vec::new()
    };
    let normals = table.normal.iter().map(|&n| DVec3::from(n)).collect();
    let views = table.views().collect();
    let mirrors = mirrors.map_or(Ok(Vec::new()), |mirrors| mirror_views(archive, tile, rows, mirrors))?;
    let canopies = if reads_sky { tile_canopies(archive, settings(archive)?, tile, rows)? } else { Vec::new() };
    Ok((table.ids, TileLayers { normals, views, sky, mirrors, canopies, responses }))
}

/// Sky textures of a tile of so many receivers, each with the bits that it describes.
pub fn tile_sky(archive: &Archive, tile: u32, rows: usize) -> Result<Vec<(SkyTexture, BitSquare)>> {
    let (block, sides) = sky_block(archive, tile, rows)?;
    SkyTexture::split(block.bytes(), rows, sides.sky_base, sides.sky_fine).ok_or_else(|| other_sky(&block))
}

/// The sky of a tile of so many receivers, not larger than can be decoded.
fn sky_block(archive: &Archive, tile: u32, rows: usize) -> Result<(Block, TextureSides)> {
    let sides = sides(archive)?;
    let block = archive.block(format::SKY, tile)?;
    let bytes = rows.saturating_mul(sides.sky_fine * sides.sky_fine / 8);
    if bytes > MAX_SKY {
        return Err(block.corrupt(format!("sky of {bytes} bytes"), format!("at most {MAX_SKY}")));
    }
    Ok((block, sides))
}

fn other_sky(block: &Block) -> Error {
    block.corrupt("sky bits of another shape", "sky bits of the manifest's shape")
}

/// The hits in a block of a tile of so many receivers, `side` of the hit texture.
pub fn hits_of(block: &Block, rows: usize, side: usize) -> Result<HitTile> {
    HitTile::unpack(block.bytes(), rows.saturating_mul(side * side))
        .ok_or_else(|| block.corrupt("hits of another shape", "hits of the settings' shape"))
}

/// The responses that the build derived: its reflectances, all bounces.
pub fn cached_responses(archive: &Archive, tile: u32) -> Result<Vec<Response>> {
    let block = archive.block(format::RESPONSE, tile)?;
    response::unpack(block.bytes(), block.items() as usize, sides(archive)?.response)
        .ok_or_else(|| block.corrupt("responses of another shape", "responses of the manifest's shape"))
}

/// Settings, materials and cells: all that responses are derived from. Cells stay in their blocks until they are asked for.
pub struct Tables<'a> {
    pub shape: Shape,
    pub reflectors: Vec<Reflector>,
    /// Of the mirrors.
    pub orientations: Vec<Orientation>,
    pub probes: CellSource<'a>,
    pub bounces: CellSource<'a>,
}

impl<'a> Tables<'a> {
    /// The tables of an archive.
    pub fn load(archive: &'a Archive) -> Result<Self> {
        Tables::of(archive, settings(archive)?.clone())
    }

    /// The tables among some blocks, made with some settings.
    pub fn of(blocks: &'a dyn Blocks, settings: Settings) -> Result<Self> {
        let materials = tables::Materials::from_block(&blocks.block(format::MATERIALS, 0)?)?;
        let optics = optics(blocks, materials.rows())?;
        let reflectors = Reflector::of_tables(&materials, optics.as_ref());
        let shape = shape(&settings);
        let probes = CellSource::probes(blocks, &settings, reflectors.len())?;
        let bounces = CellSource::bounces(blocks, &settings, reflectors.len())?;
        let orientations = orientations(blocks, reflectors.len())?;
        Ok(Tables { shape, reflectors, orientations, probes, bounces })
    }
}

/// What all chunks of one kind of cells have in common.
#[derive(Clone, Copy, Debug)]
struct Form {
    /// Texels of the sky, and hit rays, of a cell.
    texels: usize,
    rays: usize,
    materials: usize,
}

/// Cells of one kind, read chunk by chunk.
pub struct CellSource<'a> {
    blocks: &'a dyn Blocks,
    kind: u32,
    form: Form,
    /// First key of every chunk.
    firsts: Vec<CellKey>,
}

impl<'a> CellSource<'a> {
    /// The probes among some blocks, for a number of materials.
    pub fn probes(blocks: &'a dyn Blocks, settings: &Settings, materials: usize) -> Result<Self> {
        let (side, rays) = (settings.probe as usize, settings.probe_hits as usize);
        let form = Form { texels: side * side, rays, materials };
        CellSource::open(blocks, format::PROBES, tables::Index::PROBES, form)
    }

    /// The bounce cells among some blocks.
    pub fn bounces(blocks: &'a dyn Blocks, settings: &Settings, materials: usize) -> Result<Self> {
        let (side, rays) = (settings.bounce_sky as usize, settings.bounce_hits as usize);
        let form = Form { texels: side * side, rays, materials };
        CellSource::open(blocks, format::BOUNCE, tables::Index::BOUNCE, form)
    }

    fn open(blocks: &'a dyn Blocks, kind: u32, index: u32, form: Form) -> Result<Self> {
        // A site where no ray meets anything has no cells and no index.
        let firsts = match blocks.has(format::INDEX, index) {
            true => tables::Index::from_block(&blocks.block(format::INDEX, index)?)?.firsts(),
            false => Vec::new(),
        };
        Ok(CellSource { blocks, kind, form, firsts })
    }

    /// Number of chunks.
    pub fn chunks(&self) -> usize {
        self.firsts.len()
    }

    /// The only chunk that can hold a cell.
    pub fn chunk_of(&self, key: &CellKey) -> Option<usize> {
        self.firsts.partition_point(|first| first <= key).checked_sub(1)
    }

    /// All cells of a chunk.
    pub fn chunk(&self, chunk: usize) -> Result<Cells> {
        let block = self.blocks.block(self.kind, chunk as u32)?;
        let cells = cells_of(self.blocks, &block)?;
        let (rows, form) = (cells.keys.len(), self.form);
        if cells.keys.first() != self.firsts.get(chunk) {
            return Err(block.corrupt("another first cell", "the one of the index"));
        }
        if cells.keys.last().zip(self.firsts.get(chunk + 1)).is_some_and(|(last, next)| last >= next) {
            return Err(block.corrupt("cells of the chunk after it", "keys that rise from chunk to chunk"));
        }
        if cells.bits.len() != rows * form.texels.div_ceil(8) || cells.hits.len() != rows * form.rays {
            return Err(block.corrupt("cells of another shape", "textures and rays as in the manifest"));
        }
        let unknown = |key: CellKey| usize::from(key.material) >= form.materials;
        if cells.keys.iter().copied().any(unknown) || cells.reached().any(unknown) {
            return Err(block.corrupt("an unknown material", "rows of the materials table"));
        }
        check_cells(&block, &cells, [form.texels, form.rays], form.materials)?;
        Ok(cells)
    }

    /// The cells of these keys, which are sorted; one that does not exist is an error.
    pub fn fetch(&self, keys: &[CellKey]) -> Result<Cells> {
        let parts: Vec<&[CellKey]> = keys.chunk_by(|a, b| self.chunk_of(a) == self.chunk_of(b)).collect();
        let found: Vec<Cells> = parts
            .into_par_iter()
            .map(|part| {
                let cells = self.chunk(self.chunk_of(&part[0]).ok_or_else(|| self.missing(&part[0]))?)?;
                let row = |key: &CellKey| cells.keys.binary_search(key).map_err(|_| self.missing(key));
                Ok(cells.select(&part.iter().map(row).collect::<Result<Vec<usize>>>()?))
            })
            .collect::<Result<_>>()?;
        Ok(Cells::join(&found))
    }

    /// Those of some cells, sorted by key, that are there and whole.
    pub fn find(&self, keys: &[CellKey]) -> Vec<Cell> {
        let parts: Vec<&[CellKey]> = keys.chunk_by(|a, b| self.chunk_of(a) == self.chunk_of(b)).collect();
        let found = |part: &[CellKey]| -> Vec<Cell> {
            let Some(Ok(cells)) = part.first().and_then(|key| self.chunk_of(key)).map(|chunk| self.chunk(chunk)) else {
                return Vec::new();
            };
            part.iter().filter_map(|key| cells.keys.binary_search(key).ok()).map(|row| cells.cell(row)).collect()
        };
        parts.into_par_iter().flat_map_iter(found).collect()
    }

    /// The error of a reference to a cell that does not exist.
    pub fn missing(&self, key: &CellKey) -> Error {
        Error::Corrupt {
            path: self.blocks.path().to_path_buf(),
            block: format::kind_name(self.kind),
            offset: 0,
            got: format!("no cell {key:?}"),
            expected: "every cell that is referred to".into(),
        }
    }
}
