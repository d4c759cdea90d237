//! Arrays for the graphics card. In: tiles and lights as texels that the core makes. Out: their
//! arrays, and where each part of them stands.

use heliotile_core::replay::interactive::{LightTexels, TileTextures};
use serde_json::json;

use crate::answer::{Answer, Numbers};

/// Answers the receivers of a tile, whose first is number `first` of the archive. `served` is false
/// if the core has to compute them.
pub fn tile(first: u64, made: Option<TileTextures<'_>>) -> Answer {
    let served = made.is_some();
    let TileTextures { shape, words, starts } = made.unwrap_or_default();
    let shape = [shape.patches, shape.response, shape.groups, shape.block, shape.steps];
    Answer::of(json!({ "first": first, "served": served, "shape": shape }))
        .with("words", Numbers::U32(words))
        .with("starts", Numbers::U32(starts))
}

/// Answers a light.
pub fn light(light: &LightTexels) -> Answer {
    let LightTexels { numbers, parts, reflected, field, radiances } = light;
    Answer::of(json!({ "parts": parts, "reflected": reflected, "field": field, "radiances": radiances }))
        .with("numbers", Numbers::F32(numbers))
}
