//! Pictures: the view of a receiver as images; curves. In: maps of a receiver, series of numbers.
//! Out: bytes of EXR, PNG and SVG files.

pub mod bars;
pub mod calendar;
pub mod canvas;
pub mod carpet;
pub mod colours;
pub mod exr;
pub mod fisheye;
pub mod panel;
pub mod plot;
pub mod scale;
pub mod svg;
