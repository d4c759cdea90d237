//! Solar modules: where they stand. In: tables of points, files that describe rows of modules,
//! surfaces. Out: checked points, modules as rectangles, and places on the ground among them. This
//! module knows nothing of light.

pub mod ground;
pub mod layout;
pub mod points;
pub mod rows;
