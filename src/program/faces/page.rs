//! Options of the page. In: requests that its engine fills. Out: `options.ts`, their types.

use std::fmt::Write as _;

use heliotile::WeatherOptions;
use heliotile::requests::{Request, Row};

use super::{MADE, help};

/// Returns the text of `options.ts`.
pub fn options() -> String {
    let mut text = format!("// {MADE}\n");
    interface(
        &mut text,
        "WeatherOptions",
        "Facts about a weather file that it does not state.",
        WeatherOptions::rows(),
    );
    text
}

fn interface(text: &mut String, name: &str, about: &str, rows: Vec<Row>) {
    let _ = write!(text, "\n/** {about} */\nexport interface {name} {{\n");
    for row in &rows {
        let about = help(row, &|option| format!("`{}`", option.replace('-', "_"))).replace("*/", "* /");
        let names: Vec<String> = (row.form.choices)().iter().map(|(name, _)| format!("\"{name}\"")).collect();
        let kind = if names.is_empty() { "string".to_owned() } else { names.join(" | ") };
        let _ = write!(text, "  /** {about} */\n  {}?: {kind};\n", row.name);
    }
    *text += "}\n";
}
