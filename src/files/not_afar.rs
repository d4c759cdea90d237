//! In place of stores, where the program is built without the feature `remote`: addresses are refused with what to do.

use std::path::Path;

use super::archives::{Copied, is_address, shown};
use heliotile_builder::observer::Observer;
use heliotile_core::error::{Error, Result};

fn refuse<T>(place: &Path) -> Result<T> {
    let what = "is an address, and this heliotile was built without them";
    Err(Error::input(&shown(place), None, what, "build it with them: cargo build --locked --release --features remote"))
}

/// The archive is not opened.
pub fn hold(place: &Path, _: bool) -> Result<Vec<u8>> {
    refuse(place)
}

/// Nothing is copied.
pub fn copy(from: &Path, to: &Path, _: bool, _: &dyn Observer) -> Result<Copied> {
    refuse(if is_address(from) { from } else { to })
}

/// Nothing was asked of others.
pub fn traffic() -> Option<String> {
    None
}
