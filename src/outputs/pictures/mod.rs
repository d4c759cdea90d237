//! Pictures: what a receiver sees, as images; curves. In: maps of a receiver, series of numbers. Out: bytes of EXR, PNG and SVG files.

mod canvas;
pub mod colours;
pub mod exr;
pub mod fisheye;
pub mod panel;
pub mod plot;
mod plot_scale;
