//! Materials: what surfaces do with light. In: `materials.toml`, what scene files state, names that nobody describes. Out: one checked
//! material for each name in use.

pub(crate) mod assumed;
pub(crate) mod select;
pub(crate) mod toml_file;

use std::path::Path;

use heliotile_core::error::Result;
use heliotile_core::site::material::Material;

pub use select::MaterialUse;

/// All materials that a `materials.toml` describes, by name.
pub fn materials_of(path: &Path) -> Result<Vec<Material>> {
    toml_file::read_toml(path).map(|(table, _)| table.into_values().collect())
}
