//! The blocks of one tile of receivers.

use crate::pack::COMPRESSION;
use heliotile_core::archive::{EncodedBlock, encode, format, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::extras;
use heliotile_core::layers::extras::Extras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::response;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;

/// What is known of a tile before its cells are, in the order of writing.
pub fn tile(
    number: u32,
    receivers: &tables::Receivers,
    sky: &[SkyTexture],
    hits: &HitTile,
    extras: &[Extras],
) -> Result<Vec<EncodedBlock>> {
    let mut blocks = vec![
        receivers.encode(format::RECEIVERS, number, COMPRESSION)?,
        layer(format::SKY, number, receivers.rows(), &SkyTexture::pack(sky))?,
        layer(format::HIT, number, receivers.rows(), &hits.pack())?,
    ];
    for (i, kind) in format::RECEIVER_EXTRAS.into_iter().enumerate() {
        blocks.extend(crate::pack::tile::extras(kind, number, extras.iter().map(|of| of[i].as_slice()))?);
    }
    Ok(blocks)
}

/// The block of a layer that only some scenes call for, if anything is in it.
pub fn extras<'a>(
    kind: u32,
    number: u32,
    rows: impl ExactSizeIterator<Item = &'a [u8]> + Clone,
) -> Result<Option<EncodedBlock>> {
    let items = rows.len();
    extras::pack(rows).map(|raw| layer(kind, number, items, &raw)).transpose()
}

/// The responses of a tile.
pub fn responses(number: u32, responses: &[Response]) -> Result<EncodedBlock> {
    layer(format::RESPONSE, number, responses.len(), &response::pack(responses))
}

fn layer(kind: u32, number: u32, items: usize, raw: &[u8]) -> Result<EncodedBlock> {
    let items = u32::try_from(items).map_err(|_| Error::Limit {
        what: "items of one block".into(),
        value: items as u64,
        max: u64::from(u32::MAX),
    })?;
    encode(kind, number, format::schema_of(kind).unwrap_or(0), items, raw, COMPRESSION)
}
