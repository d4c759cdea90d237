//! Coordinate systems as well-known text. In: the text of a `.prj` file (OGC 01-009, ISO 19162,
//! Esri's dialect, or the keywords of ArcInfo). Out: the EPSG number, and the units of plane
//! coordinates and heights.

use crate::formats::gdal_metadata::metres_of_unit;
use crate::formats::projections::Projection;
use crate::text::excerpt;
use heliotile_place::epsg_numbers::{Axes, axes_of};
use heliotile_place::reference::Reference;

/// Coordinate system that a text describes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TextSystem {
    pub axes: Option<Axes>,
    /// EPSG number of the plane system.
    pub epsg: Option<u32>,
    /// Unit of plane coordinates, metres.
    pub plane_unit_m: Option<f64>,
    /// Unit of heights, metres.
    pub height_unit_m: Option<f64>,
    pub name: String,
}

impl TextSystem {
    /// Returns the EPSG number as a reference.
    pub(super) fn reference(&self) -> Option<Reference> {
        self.epsg.map(Reference::Epsg)
    }

    /// Reads a text; returns `None` if it is not a coordinate system.
    pub(super) fn parse(text: &str) -> Option<TextSystem> {
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.get(..10).is_some_and(|head| head.eq_ignore_ascii_case("projection")) {
            return Some(of_keywords(text));
        }
        let mut roots = Vec::new();
        let mut rest = text;
        // Esri puts the vertical system behind the horizontal one.
        while let Some((node, behind)) = Node::read(rest, 0) {
            roots.push(node);
            rest = behind.trim_start().strip_prefix(',').unwrap_or("");
        }
        let find = |names: &[&str]| roots.iter().find_map(|root| root.find(names));
        let heights = find(&["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"]);
        let height_unit_m = heights.and_then(Node::unit);
        let plane = find(&["PROJCS", "PROJCRS", "PROJECTEDCRS"]);
        let other =
            find(&["GEOCCS", "GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS", "LOCAL_CS", "ENGCRS"]);
        let node = plane.or(other)?;
        let axes = match node.keyword.as_str() {
            "PROJCS" | "PROJCRS" | "PROJECTEDCRS" => Some(Axes::Plane),
            "GEOCCS" => Some(Axes::Geocentric),
            "LOCAL_CS" | "ENGCRS" => None,
            _ => Some(Axes::Degrees),
        };
        let epsg = node.epsg().or_else(|| plane.and_then(of_parameters));
        Some(TextSystem {
            axes: epsg.and_then(axes_of).or(axes),
            epsg,
            plane_unit_m: node.unit().or_else(|| Some(Reference::Epsg(epsg?).unit_m())),
            height_unit_m,
            name: excerpt(node.texts.first().map_or("", String::as_str).as_bytes()),
        })
    }
}

/// Returns the EPSG number of the plane system with the parameters of `node`.
fn of_parameters(node: &Node) -> Option<u32> {
    let name = node.texts.first()?;
    if name.contains("Web_Mercator") || name.contains("Pseudo-Mercator") {
        return Some(3857);
    }
    let method = node.find(&["PROJECTION", "METHOD"])?.texts.first()?;
    let parameters: Vec<(String, f64)> = node
        .all("PARAMETER")
        .into_iter()
        .filter_map(|node| Some((node.texts.first()?.to_lowercase().replace(' ', "_"), *node.numbers.first()?)))
        .collect();
    let spheroid = node.find(&["SPHEROID", "ELLIPSOID"]).and_then(|node| node.numbers.first().copied())?;
    let datum =
        node.find(&["DATUM", "TRF", "ENSEMBLE"]).and_then(|node| node.texts.first()).cloned().unwrap_or_default();
    let geographic = node.find(&["GEOGCS", "BASEGEOGCRS", "BASEGEODCRS"]).and_then(|node| node.texts.first());
    let datum = format!("{datum} {}", geographic.map_or("", String::as_str)).to_uppercase();
    Projection::of_parameters(method, &parameters, node.unit().unwrap_or(1.0), spheroid)?.epsg(&datum)
}

/// Reads the keywords of ArcInfo: `Projection UTM`, `Zone 32`, `Datum WGS84`, `Zunits METERS`, one
/// a line.
fn of_keywords(text: &str) -> TextSystem {
    let value = |key: &str| {
        let mut lines = text.lines().map(str::trim);
        lines.find_map(|line| {
            let (word, rest) = line.split_once(char::is_whitespace)?;
            word.eq_ignore_ascii_case(key).then(|| rest.trim().to_uppercase())
        })
    };
    // A number means units a metre.
    let unit = |key: &str| {
        let text = value(key)?;
        metres_of_unit(&text).or_else(|| text.parse::<f64>().ok().filter(|many| *many > 0.0).map(|many| 1.0 / many))
    };
    let name = value("projection").unwrap_or_default();
    let zone = value("zone").and_then(|text| text.parse::<i32>().ok()).filter(|zone| (1..=60).contains(&zone.abs()));
    let datum = value("datum").unwrap_or_default();
    let epsg = match (name.as_str(), zone, datum.as_str()) {
        // EPSG:32601 to 32660 north and 32701 to 32760 south of the equator; below, NAD83 / UTM and
        // ETRS89 / UTM.
        ("UTM", Some(zone), "WGS84" | "WGS_1984") => Some(if zone < 0 { 32_700 - zone } else { 32_600 + zone }),
        ("UTM", Some(zone @ 1..=23), "NAD83") => Some(26_900 + zone),
        ("UTM", Some(zone @ 28..=38), "ETRS89" | "ETRS_1989") => Some(25_800 + zone),
        _ => None,
    };
    TextSystem {
        axes: Some(if name == "GEOGRAPHIC" { Axes::Degrees } else { Axes::Plane }),
        epsg: epsg.and_then(|epsg| u32::try_from(epsg).ok()),
        plane_unit_m: unit("units"),
        height_unit_m: unit("zunits"),
        name: excerpt(name.as_bytes()),
    }
}

/// A keyword and the content of its brackets.
#[derive(Debug, Default)]
struct Node {
    /// Keyword in upper case.
    keyword: String,
    texts: Vec<String>,
    numbers: Vec<f64>,
    nodes: Vec<Node>,
}

/// Deepest nesting of brackets that is read: real texts have six, hostile ones thousands.
const DEEPEST: usize = 20;

impl Node {
    /// Reads one node; returns the text behind it too.
    fn read(text: &str, depth: usize) -> Option<(Node, &str)> {
        let text = text.trim_start();
        let length = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|length| *length > 0)?;
        let (keyword, rest) = text.split_at(length);
        let mut rest = rest.trim_start().strip_prefix(['[', '('])?;
        if depth > DEEPEST {
            return None;
        }
        let mut node = Node { keyword: keyword.to_uppercase(), ..Node::default() };
        loop {
            rest = rest.trim_start();
            if let Some(quoted) = rest.strip_prefix('"') {
                let (text, behind) = quoted.split_once('"')?;
                node.texts.push(text.to_owned());
                rest = behind;
            } else if let Some((inner, behind)) = Node::read(rest, depth + 1) {
                node.nodes.push(inner);
                rest = behind;
            } else {
                let end = rest.find([',', ']', ')'])?;
                let (word, behind) = rest.split_at(end);
                if let Ok(number) = word.trim().parse::<f64>() {
                    node.numbers.push(number);
                }
                rest = behind;
            }
            rest = rest.trim_start();
            if let Some(behind) = rest.strip_prefix([']', ')']) {
                return Some((node, behind));
            }
            rest = rest.strip_prefix(',')?;
        }
    }

    /// Returns the first node with one of the keywords `names`: this node or one within it.
    fn find(&self, names: &[&str]) -> Option<&Node> {
        if names.contains(&self.keyword.as_str()) {
            return Some(self);
        }
        self.nodes.iter().find_map(|node| node.find(names))
    }

    fn all(&self, name: &str) -> Vec<&Node> {
        let within = self.nodes.iter().flat_map(|node| node.all(name));
        if self.keyword == name { vec![self] } else { within.collect() }
    }

    /// Returns the node's own EPSG number.
    fn epsg(&self) -> Option<u32> {
        let own = self.nodes.iter().filter(|node| ["AUTHORITY", "ID"].contains(&node.keyword.as_str()));
        own.filter(|node| node.texts.first().is_some_and(|name| name.eq_ignore_ascii_case("EPSG"))).find_map(|node| {
            let by_text = node.texts.get(1).and_then(|text| text.parse().ok());
            by_text.or_else(|| node.numbers.first().map(|number| *number as u32))
        })
    }

    /// Returns the node's unit of length, metres.
    fn unit(&self) -> Option<f64> {
        let in_axes = || self.nodes.iter().filter(|node| node.keyword == "AXIS").flat_map(|node| &node.nodes);
        let unit =
            self.nodes.iter().chain(in_axes()).find(|node| ["UNIT", "LENGTHUNIT"].contains(&node.keyword.as_str()))?;
        unit.numbers.first().copied().filter(|metres| *metres > 0.0 && metres.is_finite())
    }
}

#[cfg(test)]
#[path = "wkt_tests.rs"]
mod tests;
