//! Buildings from their footprints. In: outlines with heights, as files of footprints state them,
//! and the ground below. Out: flat roofs and vertical walls, without the walls between buildings
//! that touch.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `stated` | height, foot and base of a building, from the attributes of its feature |
//! | `region` | areas in plan: repaired, cut out of each other, measured |
//! | `ground_below` | the height of terrain at a place |
//! | `overlaps` | parts of buildings that stand on, in or under other parts |
//! | `nodes` | merges corners of neighbours that lie in one place |
//! | `shared_walls` | the part of a wall that its neighbour leaves free |
//! | `raised` | faces: roofs, walls, undersides |
//!
//! # What never happens
//!
//! - A wall is never kept where buildings stand on both of its sides.
//! - The order of features never decides where faces are.

pub(crate) mod ground_below;
mod nodes;
mod overlaps;
pub(crate) mod raised;
pub(crate) mod region;
mod shared_walls;
pub(crate) mod stated;
#[cfg(test)]
mod tests;
