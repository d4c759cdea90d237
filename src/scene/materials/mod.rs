//! Materials: what surfaces do with light. In: `materials.toml`, what scene files state, names that nobody describes. Out: one checked
//! material for each name in use.

pub(crate) mod assumed;
pub(crate) mod select;
pub(crate) mod toml_file;

pub use select::MaterialUse;
