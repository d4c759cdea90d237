//! InteractiveReplay: receivers under one sun and sky after another, as a page asks for that lets the sun move. In: an archive, one state of its
//! reflectances, later conditions. Out: the components of [`Replay`](crate::replay::run::Replay), but for the rounding of what is kept.
//!
//! A replay reads a tile and forgets it, for the light of many hours. Here a tile is made ready once ([`InteractiveTile`]), as words that a graphics
//! card reads as well, and then costs a few products and look-ups for each condition.

mod card;
mod light;
mod packed;
mod packed_sky;
mod site;
mod tile;

pub use card::{LightTexels, TileTextures};
pub use light::InteractiveLight;
pub use packed::Shape;
pub use site::InteractiveReplay;
pub use tile::InteractiveTile;
