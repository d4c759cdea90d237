//! One tile as replay reads it: what its receivers are, and those of their layers that the weather needs.

use glam::DVec3;

use crate::layers::canopy::Canopy;
use crate::layers::mosaic::Mosaic;
use crate::layers::response::Response;
use crate::replay::specular::MirrorView;

/// Decoded layers of one tile.
pub struct TileLayers {
    pub normals: Vec<DVec3>,
    /// Shares of each hemisphere: sky, ground, obstructions.
    pub views: Vec<[f32; 3]>,
    /// Empty where a [`Forcing`](crate::replay::tile::Forcing) does not read them.
    pub sky: Vec<Mosaic>,
    /// `[receiver]`: what it sees in mirrors; likewise, and where no receiver sees any.
    pub mirrors: Vec<Vec<MirrorView>>,
    /// What rays to the sky cross; empty where none of the tile's does, likewise.
    pub canopies: Vec<Canopy>,
    /// `[state][receiver]`: one state of the reflectances for each way that a [`Forcing`](crate::replay::tile::Forcing) was made with; likewise.
    pub responses: Vec<Vec<Response>>,
}
