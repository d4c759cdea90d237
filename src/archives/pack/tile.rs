//! Blocks of one tile of receivers. In: tables and layers of a tile. Out: encoded blocks.

use glam::DVec3;

use heliotile_core::archive::format::{BlockKind, TileNumber};
use heliotile_core::archive::tables::{NORMAL_STEPS, OverviewTable};
use heliotile_core::archive::{EncodedBlock, encode, format, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::extras::ReceiverExtras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::layers::{extras, response};
use heliotile_core::site::receiver::Receiver;

/// Level of the block compressor, high because textures are written once and read for years.
pub const COMPRESSION: i32 = heliotile_core::archive::codec::pack::DEFAULT_LEVEL;

/// Encodes the blocks of a tile that are known before its cells, in the order of writing. An
/// archive for replay only has no hits.
pub fn tile(
    number: TileNumber,
    receivers: &tables::ReceiversTable,
    parts: Option<&tables::PartsTable>,
    sky: &[SkyTexture],
    hits: Option<&HitTile>,
    extras: &[ReceiverExtras],
) -> Result<Vec<EncodedBlock>> {
    let mut blocks = vec![
        receivers.encode(format::RECEIVERS, number, COMPRESSION)?,
        layer(format::SKY, number, receivers.rows(), &SkyTexture::pack(sky))?,
    ];
    blocks.extend(hits.map(|hits| self::hits(number, receivers.rows(), hits)).transpose()?);
    blocks.extend(parts.map(|parts| parts.encode(format::PARTS, number, COMPRESSION)).transpose()?);
    let (mirrors, canopies) = extras.iter().map(|of| (of.mirrors.to_bytes(), of.canopy.to_bytes())).unzip();
    blocks.extend(extra(format::MIRROR, number, mirrors)?);
    blocks.extend(extra(format::CANOPY, number, canopies)?);
    Ok(blocks)
}

/// Encodes the hits of a tile.
pub fn hits(number: TileNumber, receivers: usize, hits: &HitTile) -> Result<EncodedBlock> {
    layer(format::HIT, number, receivers, &hits.pack())
}

/// Encodes a layer that only some scenes need, or returns `None` if all its rows are empty.
pub fn extra(kind: BlockKind, number: TileNumber, rows: Vec<Vec<u8>>) -> Result<Option<EncodedBlock>> {
    let raw = extras::pack(rows.iter().map(Vec::as_slice));
    raw.map(|raw| layer(kind, number, rows.len(), &raw)).transpose()
}

/// Encodes the responses of a tile.
pub fn responses(number: TileNumber, responses: &[Response]) -> Result<EncodedBlock> {
    let raw = response::pack(responses).ok_or_else(|| Error::Unsupported {
        what: "writing responses".into(),
        found: "textures whose side is not a multiple of 8".into(),
        supported: "sides of 8, 16, ... texels: {set} probe=16".into(),
    })?;
    layer(format::RESPONSE, number, responses.len(), &raw)
}

fn layer(kind: BlockKind, number: TileNumber, items: usize, raw: &[u8]) -> Result<EncodedBlock> {
    let items = u32::try_from(items).map_err(|_| Error::Limit {
        what: "items of one block".into(),
        value: items as u64,
        max: u64::from(u32::MAX),
    })?;
    encode(kind, number, format::schema_of(kind).unwrap_or(0), items, raw, COMPRESSION)
}

/// Row of the overview of a tile. The patch is in [`Receiver::patch`].
pub struct OverviewRow<'a> {
    /// Receiver, of which position, normal, area and patch are stored.
    pub receiver: &'a Receiver,
    /// Sky view: cosine-weighted share of the hemisphere that sees sky.
    pub sky_view: f32,
    /// Irradiation of a clear year, kWh/m2; `None` if the place is unknown.
    pub clear_year: Option<f32>,
}

/// Encodes the overview of a tile, with positions relative to `origin`.
pub fn overview<'a>(
    tile: TileNumber,
    origin: DVec3,
    rows: impl IntoIterator<Item = OverviewRow<'a>>,
) -> Result<EncodedBlock> {
    let mut table = OverviewTable::default();
    for OverviewRow { receiver, sky_view, clear_year } in rows {
        table.position.push((receiver.position - origin).as_vec3().to_array());
        table.normal.push((receiver.normal * NORMAL_STEPS).round().to_array().map(|x| x as i16));
        table.area.push(receiver.area.unwrap_or_default() as f32);
        table.sky_view.push((sky_view * 255.0).round() as u8);
        table.clear_year.extend(clear_year);
        // A patch has at most 255 polygons of at most 255 corners.
        let polygons = receiver.patch.polygons();
        table.polygons.push(polygons.len() as u8);
        for polygon in polygons {
            table.corners.push(polygon.len() as u8);
            table.offset.extend_from_slice(polygon);
        }
    }
    table.encode(format::OVERVIEW, tile, COMPRESSION)
}
