//! Interactive replay: receivers under one sun and sky after another, as a page needs it that lets
//! a user move the sun. In: an archive, one state of its reflectances, conditions one at a time.
//! Out: the components of [`Replay`](crate::replay::run::Replay), except for the rounding of what
//! is kept.
//!
//! A replay reads a tile, computes the light of many hours and forgets the tile. Here a tile is
//! prepared once ([`InteractiveTile`]) as words that a graphics card reads as well. After that,
//! each condition costs a few products and look-ups.

mod card;
mod light;
mod packed;
mod packed_sky;
mod shape;
mod site;
mod tile;

pub use card::{LightTexels, TileTextures};
pub use light::InteractiveLight;
pub use shape::Shape;
pub use site::InteractiveReplay;
pub use tile::InteractiveTile;
