//! Maps of a receiver as an OpenEXR file: one part a map, with a channel for each quantity, f32,
//! losslessly compressed (ZIP).
//!
//! The first line of a part is the top of its texture (v = side - 1: north, or up the surface), as
//! viewers show it. The attribute `heliotile` of each part explains everything as JSON. It is one
//! attribute because the `exr` crate writes several in the order of a hash map, and equal inputs
//! must give equal bytes.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, Vec2, WritableImage};
use serde_json::{Map as Object, Value, json};

use heliotile_core::error::{Error, Result};
use heliotile_core::replay::maps::{Channel, Map};

/// Name of the attribute that describes the contents of a part.
pub const ATTRIBUTE: &str = "heliotile";

/// Description of the mapping from a direction to a texel.
const MAPPING: &str =
    "Shirley-Chiu square, texels of equal solid angle (schema/layers.md); the first line is v = side - 1";
/// Description of the use of channels and `weight_sr`.
const RULE: &str = "sum over texels of a channel named like a column of results x weight_sr = that column, W/m2";

/// Returns the bytes of an EXR file of `maps`; `about` is written into all parts.
pub fn exr(maps: &[Map], about: &Object<String, Value>) -> Result<Vec<u8>> {
    // The display window is shared by the whole file.
    let widest = maps.iter().map(|map| map.side).max().unwrap_or(1);
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(widest, widest)));
    let layers: Vec<_> = maps.iter().map(|map| layer(map, about)).collect();
    let mut bytes = Cursor::new(Vec::new());
    let refuse = |e: exr::error::Error| Error::Unsupported {
        what: "writing layers".into(),
        found: e.to_string(),
        supported: "what OpenEXR can hold".into(),
    };
    Image::from_layers(attributes, layers).write().to_buffered(&mut bytes).map_err(refuse)?;
    Ok(bytes.into_inner())
}

fn layer(map: &Map, about: &Object<String, Value>) -> Layer<AnyChannels<FlatSamples>> {
    let mut all = about.clone();
    let units: Object<String, Value> = map.channels.iter().map(|c| (c.name.to_string(), json!(c.unit))).collect();
    for (key, value) in [
        ("frame", json!(map.frame)),
        ("mapping", json!(MAPPING)),
        ("rule", json!(RULE)),
        ("units", Value::Object(units)),
    ] {
        all.insert(key.to_string(), value);
    }
    let mut attributes = LayerAttributes::named(map.name);
    let text = Text::from_slice_unchecked(Value::Object(all).to_string().as_bytes());
    attributes.other.insert(Text::from(ATTRIBUTE), AttributeValue::Text(text));
    let channels = map.channels.iter().map(|c| AnyChannel::new(c.name, FlatSamples::F32(upright(c, map.side))));
    let size = Vec2(map.side, map.side);
    Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels.collect()))
}

/// Returns the values line by line, the last row first.
fn upright(channel: &Channel, side: usize) -> Vec<f32> {
    channel.values.chunks(side).rev().flatten().copied().collect()
}
