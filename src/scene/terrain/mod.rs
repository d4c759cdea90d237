//! Terrain: heights on a grid and their surface. In: samples of a file. Out: triangles. They are
//! all of the raster's or, for a horizon around other geometry, so few that no skyline moves by
//! more than a stated angle.

pub(super) mod focus;
pub(super) mod mosaic;
pub(super) mod raster;
pub(super) mod surface;
#[cfg(test)]
mod tests;
pub(super) mod thinning;
