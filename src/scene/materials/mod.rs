//! Materials: the optics of surfaces. In: `materials.toml`, the statements of scene files, and
//! names without a description. Out: one checked material for each name in use.

pub(crate) mod assumed;
pub mod select;
pub(crate) mod toml_file;

use std::path::Path;

use heliotile_core::error::Result;
use heliotile_core::site::material::Material;

pub use select::MaterialUse;

/// Reads all materials that a `materials.toml` describes, sorted by name.
pub fn materials_of(path: &Path) -> Result<Vec<Material>> {
    toml_file::read_toml(path).map(|(table, _)| table.into_values().collect())
}
