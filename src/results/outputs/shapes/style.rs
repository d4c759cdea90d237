//! Styles of maps for QGIS, which applies a `.qml` file that stands beside a map of the same name.
//! In: the colours of a map. Out: a file with a class for each range of values, or for each verdict
//! of a rule.

use std::path::Path;

use super::columns::MapColumns;
use super::picture::palette::{Palette, Swatch};
use super::rows::MapRows;
use crate::outputs::markup::escaped;
use crate::outputs::sink::write_file;
use heliotile_core::error::Result;

/// Comment of a style that no person has changed: QGIS drops it when it saves one.
const OURS: &str = "<!-- Written by heliotile beside its map, and anew with it. -->";

/// Width of lines around polygons, in their own colour, millimetres: without any the ground shines
/// through between neighbours.
const LINE_MM: f64 = 0.1;

/// Writes the style of a map beside it. A style that QGIS has saved there stays.
pub fn write(map: &Path, rows: &mut MapRows, columns: &MapColumns) -> Result<()> {
    let path = map.with_extension("qml");
    if !may_write(&path) {
        return Ok(());
    }
    let palette = Palette::new(rows, columns)?;
    let column = columns.numbers.get(palette.classed()).map_or("", |(name, _)| name.as_str());
    write_file(&path, style(column, &palette.swatches()).as_bytes())
}

/// Returns true if nothing stands at a path but a style of ours.
fn may_write(path: &Path) -> bool {
    match std::fs::read_to_string(path) {
        Ok(text) => text.contains(OURS),
        Err(error) => error.kind() == std::io::ErrorKind::NotFound,
    }
}

/// Returns the style of a column by its swatches.
fn style(column: &str, swatches: &[Swatch]) -> String {
    let (kind, group) = match swatches.iter().any(|one| one.to.is_some()) {
        true => ("graduatedSymbol", "ranges"),
        false => ("categorizedSymbol", "categories"),
    };
    let entry = |(number, one): (usize, &Swatch)| {
        let (from, label) = (one.from, escaped(&one.label));
        match one.to {
            Some(to) => format!(
                "<range symbol=\"{number}\" lower=\"{from}\" upper=\"{to}\" label=\"{label}\" render=\"true\"/>\n"
            ),
            None => format!(
                "<category symbol=\"{number}\" value=\"{from}\" type=\"double\" label=\"{label}\" render=\"true\"/>\n"
            ),
        }
    };
    let symbol = |(number, one): (usize, &Swatch)| {
        let [red, green, blue] = one.colour;
        format!(
            "<symbol name=\"{number}\" type=\"fill\" alpha=\"1\"><layer class=\"SimpleFill\" enabled=\"1\" pass=\"0\" locked=\"0\">\
             <Option type=\"Map\"><Option name=\"color\" type=\"QString\" value=\"{red},{green},{blue},255\"/>\
             <Option name=\"style\" type=\"QString\" value=\"solid\"/>\
             <Option name=\"outline_color\" type=\"QString\" value=\"{red},{green},{blue},255\"/>\
             <Option name=\"outline_width\" type=\"QString\" value=\"{LINE_MM}\"/></Option></layer></symbol>\n"
        )
    };
    let entries: String = swatches.iter().enumerate().map(entry).collect();
    let symbols: String = swatches.iter().enumerate().map(symbol).collect();
    let attribute = escaped(column);
    format!(
        "{OURS}\n<qgis version=\"3.22\" styleCategories=\"Symbology\">\n\
         <renderer-v2 type=\"{kind}\" attr=\"{attribute}\" graduatedMethod=\"GraduatedColor\" symbollevels=\"0\" forceraster=\"0\" enableorderby=\"0\">\n\
         <{group}>\n{entries}</{group}>\n<symbols>\n{symbols}</symbols>\n</renderer-v2>\n</qgis>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A class of a range and one of a verdict name their values and colours, and a column's name
    /// is escaped.
    #[test]
    fn classes_become_symbols() {
        let swatch = |to, label: &str| Swatch { from: 0.5, to, label: label.to_owned(), colour: [1, 2, 3] };
        let of_ranges = style("a<b", &[swatch(Some(0.75), "0.5 to 0.75")]);
        assert!(of_ranges.contains("<range symbol=\"0\" lower=\"0.5\" upper=\"0.75\" label=\"0.5 to 0.75\""));
        assert!(of_ranges.contains("attr=\"a&lt;b\"") && of_ranges.contains("value=\"1,2,3,255\""));
        let of_verdicts = style("verdict", &[swatch(None, "close")]);
        assert!(of_verdicts.contains("<category symbol=\"0\" value=\"0.5\" type=\"double\" label=\"close\""));
    }

    /// A style that QGIS saved stays; ours is written anew.
    #[test]
    fn a_saved_style_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.qml");
        assert!(may_write(&path));
        std::fs::write(&path, style("a", &[])).expect("a style");
        assert!(may_write(&path));
        std::fs::write(&path, "<qgis/>").expect("a style");
        assert!(!may_write(&path) && !may_write(folder.path()));
    }
}
