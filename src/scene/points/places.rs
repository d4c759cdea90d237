//! Points where modules or people may be. In: a table of points. Out: checked points, each with the
//! line that it comes from.

use std::collections::HashMap;
use std::path::Path;

use super::header::{Found, Header, Names, advance_to_header};
pub use super::rows::{Facing, PointDefaults, PointHeight};
use super::rows::{PointColumns, check_length, number};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::Message;
use heliotile_files::csv_rows::CsvRows;

const NAMES: [Names; 2] = [&["point"], &["receiver"]];
const KWP: Names = &["kwp"];
const STRING: Names = &["string"];
/// Columns of a header, for messages.
const HINT: &str = "name the columns point,x,y,height,tilt_deg,azimuth_deg, or z in place of height";

/// A place where a module or a person may be.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacePoint {
    /// Name, unique among the points, because files are named after it.
    pub name: String,
    /// Input coordinate x, metres.
    pub x: f64,
    /// Input coordinate y, metres.
    pub y: f64,
    /// Height of the point.
    pub height: PointHeight,
    /// Direction of the module; `None` if the table does not state it.
    pub facing: Option<Facing>,
    /// Rated power and string of the module there.
    pub rating: Rating,
    /// Line in the file, from 1.
    pub line: usize,
}

/// Rated power of a module, and the string that it is a part of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rating {
    /// Rated power, kW; `None` if it is not stated.
    pub kwp: Option<f64>,
    /// Name of the string; may be empty.
    pub string: String,
}

impl Rating {
    /// Largest rated power, kW: more is a mix-up of watts and kilowatts.
    pub const MAX_KW: f64 = 1e6;
}

/// Longest name of a point, bytes: files are named after it.
const MAX_NAME: usize = 100;

/// Reads points from columns `point,x,y`, one of `z` and `height`, and `tilt_deg,azimuth_deg` or
/// `nx,ny,nz`, and of `kwp` and `string` if there are any, in any order. Fails without a row.
/// `warnings` gets the columns that are ignored.
pub fn read_points(path: &Path, defaults: PointDefaults, warnings: &mut Vec<Message>) -> Result<Vec<PlacePoint>> {
    let mut rows = CsvRows::open(path)?;
    advance_to_header(&mut rows, HINT)?;
    let mut header = Header::new(&rows, HINT);
    let columns = PointColumns::find(&mut header, NAMES, defaults)?;
    let (kwp, string) = (header.find(KWP)?, header.find(STRING)?);
    warnings.extend(header.unused());
    let (mut points, mut line_of): (Vec<PlacePoint>, HashMap<String, usize>) = (Vec::new(), HashMap::new());
    while rows.advance()? {
        let point = columns.row(&rows)?;
        check_name(&rows, columns.name(), point.name)?;
        // File systems may not tell capital letters from small ones.
        if let Some(first) = line_of.insert(point.name.to_lowercase(), rows.line) {
            let why = format!("the name of the point in line {first} too");
            return Err(rows
                .cell_error(columns.name(), point.name, &why, "give every point a name of its own")
                .because(Problem::duplicate(point.name)));
        }
        let (name, line) = (point.name.to_owned(), rows.line);
        let string = string.map_or("", |column| rows.cell(column.place));
        check_length(&rows, "string", string)?;
        let rating =
            Rating { kwp: kwp.map(|column| rated(&rows, column)).transpose()?.flatten(), string: string.to_owned() };
        let (x, y, height, facing) = (point.x, point.y, point.height, point.facing);
        points.push(PlacePoint { name, x, y, height, facing, rating, line });
    }
    match points.is_empty() {
        true => Err(Error::input(path, None, "the file holds a header but no points", "add one row per point")),
        false => Ok(points),
    }
}

/// Returns a rated power, kW; `None` for an empty cell.
fn rated(rows: &CsvRows, column: Found) -> Result<Option<f64>> {
    if rows.cell(column.place).is_empty() {
        return Ok(None);
    }
    match number(rows, column)? {
        kwp if (0.0..=Rating::MAX_KW).contains(&kwp) => Ok(Some(kwp)),
        _ => {
            let (text, why) = (rows.cell(column.place), "not from 0 to 1000000");
            Err(rows.cell_error(column.name, text, why, "give the rated power, kW"))
        }
    }
}

/// Checks that a name can be the name of a file.
fn check_name(rows: &CsvRows, column: &str, name: &str) -> Result<()> {
    let bad = |c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c);
    let why = match name {
        _ if name.len() > MAX_NAME => "longer than 100 bytes",
        _ if name.starts_with('.') || name.contains(bad) => "and its files could not be named after it",
        _ => return Ok(()),
    };
    let hint = r#"give every point a name without / \ : * ? " < > | and no dot at its start"#;
    Err(rows.cell_error(column, name, why, hint))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::TestFolder;
    use heliotile_core::site::north::North;

    fn read(text: &str, needs_turns: bool) -> Result<Vec<PlacePoint>> {
        let folder = TestFolder::new();
        read_points(&folder.write("points.csv", text), PointDefaults { needs_turns, height_m: None }, &mut Vec::new())
    }

    /// Three points by z and by height, in any order of columns and with azimuths of both signs,
    /// are read as written.
    #[test]
    fn points_are_read_by_z_and_by_height() {
        let text = "tilt,point,azimuth,y,x,z,height\n30,a,-90,2,1,5,\n\n180,b c,360,2,1,,0.5\n0,c,0,0,0,,0\n";
        let points = read(text, true).expect("points");
        let turn = |p: &PlacePoint| p.facing.map(|facing| facing.turn(North::default(), North::default()));
        let turns: Vec<_> = points.iter().filter_map(turn).flatten().map(|t| (t.tilt_deg, t.azimuth_deg)).collect();
        assert_eq!(turns, [(30.0, 270.0), (180.0, 0.0), (0.0, 0.0)]);
        let heights: Vec<_> = points.iter().map(|p| p.height).collect();
        assert_eq!(heights, [PointHeight::Z(5.0), PointHeight::Above(0.5), PointHeight::Above(0.0)]);
        assert_eq!((points[1].name.as_str(), points[1].line, points[0].x), ("b c", 4, 1.0));
    }

    /// Two tables without angles give points without orientation if none is needed, and are refused
    /// if one is.
    #[test]
    fn points_need_angles_only_if_asked() {
        assert_eq!(read("point,x,y,z\na,0,0,1\n", false).expect("points")[0].facing, None);
        assert_eq!(read("point,x,y,z,tilt,azimuth\na,0,0,1,,\n", false).expect("points")[0].facing, None);
        assert!(read("point,x,y,z\na,0,0,1\n", true).is_err());
        assert!(read("point,x,y,z,tilt,azimuth\na,0,0,1,,\n", true).is_err());
    }

    /// Sixteen wrong files are refused, each with what is wrong and where.
    #[test]
    fn wrong_points_are_refused_with_their_line() {
        let head = "point,x,y,height,tilt,azimuth\n";
        for (rows, expected) in [
            ("a,0,0,1,200,180", "line 2: column `tilt` is `200`, not from 0 to 180"),
            ("a,0,0,1,-1,180", "column `tilt` is `-1`"),
            ("a,0,0,1,30,south", "column `azimuth` is `south`, not a number"),
            ("a,0,0,1,30,400", "column `azimuth` is `400`, not from -360 to 360"),
            ("a,0,0,-1,30,180", "column `height` is `-1`, below zero"),
            ("a,0,nan,1,30,180", "column `y` is `nan`"),
            ("a,1e12,0,1,30,180", "column `x` is `1e12`"),
            ("a,0,0,,30,180", "column `height` is ``, not a number"),
            ("a,0,0,1,30,180\nA,0,0,1,30,180", "line 3: column `point` is `A`, the name of the point in line 2 too"),
            (",0,0,1,30,180", "an empty name"),
            ("../a,0,0,1,30,180", "could not be named after it"),
            ("a,0,0,1,30", "has 5 cells, the header 6"),
            ("", "a header but no points"),
        ] {
            let message = read(&format!("{head}{rows}\n"), true).expect_err(rows).to_string();
            assert!(message.contains("points.csv") && message.contains(expected), "{rows}: {message}");
        }
        for (text, expected) in [
            ("", "the file is empty"),
            ("point,x,y,tilt,azimuth\na,0,0,0,0\n", "column `z` is missing"),
            ("point;x;y\n", "column `point` is missing"),
        ] {
            let message = read(text, true).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
