//! In: a register of trees as CSV, one tree a row, with columns for its place. Out: points with the
//! other columns as attributes.

use std::path::Path;

use glam::DVec3;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_files::csv_rows::CsvRows;
use serde_json::{Map, Value};

use super::feature::{Feature, TakeFeature};
use super::system::FeatureSystem;

/// Columns of the place: east and north in metres, or longitude and latitude.
const PLANE: [[&str; 2]; 5] =
    [["x", "y"], ["easting", "northing"], ["east", "north"], ["rechtswert", "hochwert"], ["x_coord", "y_coord"]];
const DEGREES: [[&str; 2]; 3] = [["longitude", "latitude"], ["lon", "lat"], ["lng", "lat"]];

/// Reads the trees; returns the coordinate system that the columns tell.
pub(super) fn read(bytes: &[u8], file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let head = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let count = |mark: u8| head.iter().filter(|byte| **byte == mark).count();
    let delimiter = [b',', b';', b'\t'].into_iter().max_by_key(|mark| (count(*mark), *mark == b',')).unwrap_or(b',');
    let mut rows = CsvRows::delimited(Box::new(bytes), file, delimiter)?;
    rows.advance()?;
    let names: Vec<String> = rows.record.iter().map(str::to_owned).collect();
    let place = |pair: &[&str; 2]| {
        let of = |wanted: &str| names.iter().position(|name| name.eq_ignore_ascii_case(wanted));
        Some([of(pair[0])?, of(pair[1])?])
    };
    let (degrees, plane) = (DEGREES.iter().find_map(place), PLANE.iter().find_map(place));
    let Some(columns) = degrees.or(plane) else {
        let what = "the table has no columns of places: x and y, or longitude and latitude";
        let hint = "a CSV in a scene is a register of trees; give weather as {weather} and receivers as {receivers}";
        return Err(Error::input(file, 1, what, hint).because(Problem::Lacks("columns of places")));
    };
    while rows.advance()? {
        let coordinate = |place: usize| {
            let text = rows.cell(place);
            let number = if delimiter == b',' { text.parse() } else { text.replace(',', ".").parse() };
            let number = number.ok().filter(|number: &f64| number.is_finite());
            let name = names.get(place).map_or("", String::as_str);
            number.ok_or_else(|| rows.cell_error(name, text, "not a number", "state the place of the tree"))
        };
        let at = DVec3::new(coordinate(columns[0])?, coordinate(columns[1])?, 0.0);
        let stated = names.iter().zip(rows.record.iter()).filter(|(_, text)| !text.is_empty());
        let mut attributes: Map<String, Value> =
            stated.map(|(name, text)| (name.clone(), Value::String(text.to_owned()))).collect();
        attributes.entry("natural").or_insert_with(|| "tree".into());
        take(Feature { attributes, points: vec![at], ..Feature::default() })?;
    }
    Ok(if degrees.is_some() { FeatureSystem::WGS84 } else { FeatureSystem::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trees(text: &str) -> Result<(Vec<Feature>, FeatureSystem)> {
        let mut found = Vec::new();
        let system = read(text.as_bytes(), Path::new("trees.csv"), &mut |feature| {
            found.push(feature);
            Ok(())
        })?;
        Ok((found, system))
    }

    /// A register with semicolons and decimal commas, and one in degrees with commas, are read with
    /// the attributes that are stated. A place that is no number is refused with its line, and so
    /// is a table without places.
    #[test]
    fn registers_are_read() {
        let (found, system) = trees("Nr;x;y;hoehe\n1;10,5;20;12\n2;-3;4,25;\n").expect("a register");
        assert_eq!(
            found.iter().map(|tree| tree.points[0]).collect::<Vec<_>>(),
            [DVec3::new(10.5, 20.0, 0.0), DVec3::new(-3.0, 4.25, 0.0)]
        );
        assert_eq!((found[0].attributes["hoehe"].as_str(), found[1].attributes.get("hoehe")), (Some("12"), None));
        assert_eq!((found[1].attributes["natural"].as_str(), system.epsg), (Some("tree"), None));
        let (found, system) = trees("id,Longitude,Latitude,height\n7,4.3,52.1,9 m\n").expect("a register");
        assert_eq!((found[0].points[0].y, system.epsg), (52.1, Some(4326)));
        let wrong = trees("x,y\n1,2\n3,NaN\n").expect_err("no number");
        assert!(wrong.to_string().starts_with("trees.csv, line 3: column `y` is `NaN`"), "{wrong}");
        assert_eq!(trees("a,b\n1,2\n").expect_err("no places").problem(), Some(&Problem::Lacks("columns of places")));
    }
}
