//! A city model with what the sun brings it. In: the text of a CityJSON object or of a sequence of features, sums of receivers by city object
//! and face. Out: the same text, to which attributes, a material theme and provenance are added. Never: geometry; what is not added to stays
//! as it is written, to the byte.

mod fields;
mod rewrite;
mod sums;
mod theme;

use std::path::Path;

pub use rewrite::{CityModelWriter, RewriteError};
pub use sums::ModelSums;

/// Endings of city models.
const ENDINGS: [&str; 2] = [".city.json", ".city.jsonl"];

/// Whether an output is to be a city model, by the ending of its name.
pub fn is_city_model(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}
