//! Pictures: the view of a receiver as images; curves. In: maps of a receiver, series of numbers.
//! Out: bytes of EXR, PNG and SVG files.

pub mod axes;
pub mod bars;
pub mod calendar;
pub mod carpet;
pub mod colours;
pub mod drawing;
pub mod exr;
pub mod fisheye;
pub mod font;
pub mod panel;
pub mod plot;
pub mod png;
pub mod scale;
pub mod svg;
