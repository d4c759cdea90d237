//! Names of places. In: a path, or the address of an object. Out: which of the two it is, and the
//! name that messages give it.

use std::path::{Path, PathBuf};

use heliotile_core::text;

/// Returns true if a place is an address, such as `s3://bucket/site.helio`, and not a path.
pub fn is_address(place: &Path) -> bool {
    text::is_address(&place.to_string_lossy())
}

/// Returns the name of a place for messages: an address without password and signature.
pub fn shown(place: &Path) -> PathBuf {
    match is_address(place) {
        true => text::without_secrets(&place.to_string_lossy()).into(),
        false => place.to_path_buf(),
    }
}

/// Result of a copy.
#[derive(Debug)]
pub struct Copied {
    /// Length of the copy, bytes.
    pub bytes: u64,
    /// Place of the bytes, if a pointer leads to them.
    pub beside: Option<PathBuf>,
    /// True if the same bytes were there already and nothing was written.
    pub was_there: bool,
}
