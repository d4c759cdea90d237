//! City model with sums of irradiation. In: the text of a CityJSON object or of a sequence of
//! features, sums of receivers by city object and face. Out: that text with added attributes, a
//! material theme and provenance. Never: geometry; parts without additions stay as they are, to the
//! byte.

mod fields;
mod rewrite;
mod sums;
mod theme;

use std::path::Path;

pub use rewrite::{CityModelWriter, RewriteError};
pub use sums::ModelSums;

/// Endings of city models.
const ENDINGS: [&str; 2] = [".city.json", ".city.jsonl"];

/// Returns true if the ending of an output's name is that of a city model.
pub fn is_city_model(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}
