//! Pixels of a picture, whatever its format. In: sides and levels. Out: the same, of sides that are
//! read.

use std::path::Path;

use heliotile_core::error::{Error, Result};

/// Pixels of a picture, one number each.
pub(super) struct Pixels {
    pub width: usize,
    pub height: usize,
    /// Levels, `[row][column]`, from the top left.
    pub levels: Vec<f64>,
    /// True if levels come from a display encoding, from 0 to 1.
    pub are_coded: bool,
}

/// Largest side of a picture, pixels.
const MAX_SIDE: usize = 8192;

/// Refuses sides beyond what memory is planned for.
pub(super) fn check_sides(path: &Path, width: usize, height: usize) -> Result<()> {
    if width.max(height) <= MAX_SIDE {
        return Ok(());
    }
    let what = format!("the picture has {width} x {height} pixels, and at most {MAX_SIDE} a side are supported");
    Err(Error::input(path, None, what, "scale the picture down"))
}
