//! Solar modules: where they stand. In: files that describe rows of modules, surfaces. Out: modules
//! as rectangles, and places on the ground among them. This module knows nothing of light.

pub mod cells;
pub mod ground;
pub mod layout;
pub mod overlap;
pub mod row_shade;
pub mod rows;
pub mod tracker;
