//! Names of places. In: a path, or the address of an object. Out: which of both it is, and what messages call it.

use std::path::{Path, PathBuf};

use heliotile_core::text;

/// Whether a place is an address, such as `s3://bucket/site.helio`, and not a path.
pub fn is_address(place: &Path) -> bool {
    text::is_address(&place.to_string_lossy())
}

/// What messages call a place: of an address, no password and no signature.
pub fn shown(place: &Path) -> PathBuf {
    match is_address(place) {
        true => text::without_secrets(&place.to_string_lossy()).into(),
        false => place.to_path_buf(),
    }
}

/// What a copy did.
#[derive(Debug)]
pub struct Copied {
    /// Length of what is copied.
    pub bytes: u64,
    /// Where the bytes are, if a pointer leads to them.
    pub beside: Option<PathBuf>,
    /// Whether the same was there already, and nothing was written.
    pub was_there: bool,
}
