//! The list of parts for the page (`view`, `catalogue`). In: parts. Out: a list in JSON, with
//! addresses relative to the page.

use std::path::PathBuf;

use serde_json::json;

use crate::listed::ListedPart;

/// File name of the list.
pub const PARTS: &str = "parts.json";

/// Returns the address of a built part's archive, relative to the folder of the atlas, and the
/// archive's path.
pub fn archive_of(part: &ListedPart) -> Option<(String, &PathBuf)> {
    let path = part.archive()?;
    let file = path.file_name()?.to_string_lossy();
    Some((format!("parts/{}/{file}", part.name), path))
}

/// Returns the list as JSON, one part a line.
pub fn list(parts: &[ListedPart]) -> String {
    let line = |part: &ListedPart| {
        json!({
            "name": part.name, "state": part.state.word(), "low": part.low.to_array(), "high": part.high.to_array(),
            "archive": archive_of(part).map(|(address, _)| address),
        })
        .to_string()
    };
    format!("{{\"parts\": [\n{}\n]}}\n", parts.iter().map(line).collect::<Vec<_>>().join(",\n"))
}
