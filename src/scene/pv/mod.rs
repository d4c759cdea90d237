//! Solar modules: where they are to be put. In: tables of points, files that describe rows of modules, surfaces. Out: checked points, and
//! modules as rectangles. Nothing is known here of light.

pub mod layout;
pub mod points;
pub mod rows;
