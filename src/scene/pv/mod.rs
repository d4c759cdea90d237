//! Solar modules: where they are to be put. In: tables of points, files that describe rows of modules, surfaces. Out: checked points,
//! modules as rectangles, and places on the ground among them. Nothing is known here of light.

pub mod ground;
pub mod layout;
pub mod points;
pub mod rows;
