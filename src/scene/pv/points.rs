//! Points for modules. In: `points.csv`, places where modules may stand. Out: checked points, each
//! with the line that it comes from.

use std::collections::HashMap;
use std::path::Path;

use crate::coordinate::MAX_COORDINATE_M;
use crate::covering::rows::CsvRows;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::receiver::MAX_NAME_BYTES;
use heliotile_core::text::{separator_hint, with_list};

const NAME: &str = "point";
const PLACE: [&str; 2] = ["x", "y"];
const HEIGHTS: [&str; 2] = ["z", "height"];
const ANGLES: [&str; 2] = ["tilt", "azimuth"];
const HEADER: &str = "point,x,y,height,tilt,azimuth";

/// A place where a module may stand.
#[derive(Clone, Debug, PartialEq)]
pub struct PvPoint {
    /// Name, unique among the points, because files are named after it.
    pub name: String,
    /// Input coordinate x, metres.
    pub x: f64,
    /// Input coordinate y, metres.
    pub y: f64,
    /// Height of the point.
    pub height: PointHeight,
    /// Orientation of the module; `None` if the table does not state it.
    pub turn: Option<Orientation>,
    /// Line in the file, from 1.
    pub line: usize,
}

/// Height of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointHeight {
    /// Input coordinate z, metres.
    Z(f64),
    /// Height above the first surface below the sky, a roof or the ground, metres.
    Above(f64),
}

/// Values that a table of points may leave out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointDefaults {
    /// True if each row must state an orientation.
    pub needs_turns: bool,
    /// Height above the first surface below the sky, metres, for a table without a column of
    /// heights; `None`: the table must have one.
    pub height_m: Option<f64>,
}

/// Reads points from columns `point,x,y`, one of `z` and `height`, and `tilt,azimuth`, in any
/// order. Fails without a row. `warnings` gets the columns that are ignored.
pub fn read_points(path: &Path, defaults: PointDefaults, warnings: &mut Vec<String>) -> Result<Vec<PvPoint>> {
    let mut rows = CsvRows::open(path)?;
    if !rows.advance()? {
        return Err(Error::input(path, None, "the file is empty", format!("begin with the line {HEADER}")));
    }
    let columns = Columns::find(&rows, defaults, warnings)?;
    let (mut points, mut line_of): (Vec<PvPoint>, HashMap<String, usize>) = (Vec::new(), HashMap::new());
    while rows.advance()? {
        let point = (Row { rows: &rows, columns: &columns }).point(defaults)?;
        // File systems may not tell capital letters from small ones.
        if let Some(first) = line_of.insert(point.name.to_lowercase(), point.line) {
            let why = format!("the name of the point in line {first} too");
            return Err(rows.cell_error(NAME, &point.name, &why, "give every point a name of its own"));
        }
        points.push(point);
    }
    match points.is_empty() {
        true => Err(Error::input(path, None, "the file holds a header but no points", "add one row per point")),
        false => Ok(points),
    }
}

/// Places of the columns.
struct Columns {
    name: usize,
    place: [usize; 2],
    heights: [Option<usize>; 2],
    angles: Option<[usize; 2]>,
    count: usize,
}

impl Columns {
    fn find(header: &CsvRows, defaults: PointDefaults, warnings: &mut Vec<String>) -> Result<Columns> {
        let names: Vec<&str> = header.record.iter().collect();
        let place = |wanted: &str| names.iter().position(|name| *name == wanted);
        let missing = |what: String| {
            let what = format!("{what}; the header is `{}`", excerpt(names.join(",").as_bytes()));
            let hint = separator_hint(&names.join(",")).map(str::to_owned);
            header.error(what, hint.unwrap_or_else(|| format!("name the columns {HEADER}, or z in place of height")))
        };
        let needed = |wanted: &str| place(wanted).ok_or_else(|| missing(format!("column `{wanted}` is missing")));
        for (i, name) in names.iter().enumerate() {
            if place(name) != Some(i) {
                let shown = excerpt(name.as_bytes());
                return Err(header.error(format!("column `{shown}` appears twice"), "remove one of the two"));
            }
        }
        let (name, [x, y]) = (needed(NAME)?, PLACE);
        let angles = match ANGLES.map(place) {
            [Some(tilt), Some(azimuth)] => Some([tilt, azimuth]),
            [None, None] if !defaults.needs_turns => None,
            [None, _] => return Err(missing("column `tilt` is missing".into())),
            _ => return Err(missing("column `azimuth` is missing".into())),
        };
        let heights = HEIGHTS.map(place);
        if heights == [None, None] && defaults.height_m.is_none() {
            return Err(missing("columns `z` and `height` are both missing".into()));
        }
        let known =
            |name: &&&str| ![NAME].iter().chain(&PLACE).chain(&HEIGHTS).chain(&ANGLES).any(|other| other == *name);
        let unused: Vec<String> =
            names.iter().filter(known).map(|name| format!("`{}`", excerpt(name.as_bytes()))).collect();
        if !unused.is_empty() {
            warnings.push(with_list(&format!("{}: columns that are not used", header.file.display()), unused));
        }
        Ok(Columns { name, place: [needed(x)?, needed(y)?], heights, angles, count: names.len() })
    }
}

struct Row<'a> {
    rows: &'a CsvRows<'a>,
    columns: &'a Columns,
}

impl Row<'_> {
    fn point(&self, defaults: PointDefaults) -> Result<PvPoint> {
        let (record, columns) = (&self.rows.record, self.columns);
        if record.len() != columns.count {
            let what = format!("the row has {} cells, the header {}", record.len(), columns.count);
            return Err(self.rows.error(what, "write one cell per column of the header, and decimals with a point"));
        }
        let name = self.cell(columns.name);
        self.check_name(name)?;
        let [x, y] =
            [(PLACE[0], columns.place[0]), (PLACE[1], columns.place[1])].map(|(column, i)| self.metres(column, i));
        let height = match columns.heights.map(|column| column.filter(|i| !self.cell(*i).is_empty())) {
            [Some(z), None] => PointHeight::Z(self.metres("z", z)?),
            [None, Some(height)] => match self.metres("height", height)? {
                above if above >= 0.0 => PointHeight::Above(above),
                _ => {
                    let hint = "give metres above the roof or ground below, or a column z with the coordinate";
                    return Err(self.rows.cell_error("height", self.cell(height), "below zero", hint));
                }
            },
            [Some(_), Some(_)] => {
                return Err(self.rows.error("the row has both a z and a height", "leave one of the two cells empty"));
            }
            [None, None] => match defaults.height_m {
                Some(usual) => PointHeight::Above(usual),
                None => {
                    return Err(self.rows.error("the row has neither a z nor a height", "fill one of the two cells"));
                }
            },
        };
        Ok(PvPoint {
            name: name.to_owned(),
            x: x?,
            y: y?,
            height,
            turn: self.turn(defaults.needs_turns)?,
            line: self.rows.line,
        })
    }

    /// Checks that a name can be the name of a file.
    fn check_name(&self, name: &str) -> Result<()> {
        let bad = |c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c);
        let why = match name {
            "" => "an empty name",
            _ if name.len() > MAX_NAME_BYTES.min(100) => "longer than 100 bytes",
            _ if name.starts_with('.') || name.contains(bad) => "and its files could not be named after it",
            _ => return Ok(()),
        };
        Err(self.rows.cell_error(
            NAME,
            name,
            why,
            r#"give every point a name without / \ : * ? " < > | and no dot at its start"#,
        ))
    }

    fn turn(&self, needed: bool) -> Result<Option<Orientation>> {
        let Some([tilt, azimuth]) = self.columns.angles else { return Ok(None) };
        if !needed && self.cell(tilt).is_empty() && self.cell(azimuth).is_empty() {
            return Ok(None);
        }
        let tilt_deg = self.angle("tilt", tilt, [0.0, 180.0], "0 looks up, 90 to the side, 180 down")?;
        let hint = "degrees clockwise from true north: 90 is east, 180 south";
        let azimuth_deg = self.angle("azimuth", azimuth, [-360.0, 360.0], hint)?.rem_euclid(360.0);
        Ok(Some(Orientation { tilt_deg, azimuth_deg }))
    }

    fn angle(&self, column: &str, place: usize, [least, most]: [f64; 2], hint: &str) -> Result<f64> {
        let text = self.cell(place);
        match text.parse::<f64>() {
            Ok(angle) if (least..=most).contains(&angle) => Ok(angle),
            Ok(_) => Err(self.rows.cell_error(column, text, &format!("not from {least} to {most}"), hint)),
            Err(_) => Err(self.rows.cell_error(column, text, "not a number", hint)),
        }
    }

    fn metres(&self, column: &str, place: usize) -> Result<f64> {
        let text = self.cell(place);
        match text.parse::<f64>() {
            Ok(number) if number.abs() <= MAX_COORDINATE_M => Ok(number),
            _ => Err(self.rows.cell_error(column, text, "not a number of metres", "write metres, such as 4.25")),
        }
    }

    fn cell(&self, column: usize) -> &str {
        self.rows.record.get(column).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, needs_turns: bool) -> Result<Vec<PvPoint>> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("points.csv");
        std::fs::write(&path, text).expect("written");
        read_points(&path, PointDefaults { needs_turns, height_m: None }, &mut Vec::new())
    }

    /// Three points by z and by height, in any order of columns and with azimuths of both signs,
    /// are read as written.
    #[test]
    fn points_are_read_by_z_and_by_height() {
        let text = "tilt,point,azimuth,y,x,z,height\n30,a,-90,2,1,5,\n\n180,b c,360,2,1,,0.5\n0,c,0,0,0,,0\n";
        let points = read(text, true).expect("points");
        let turns: Vec<_> = points.iter().map(|p| p.turn.map(|t| (t.tilt_deg, t.azimuth_deg))).collect();
        assert_eq!(turns, [Some((30.0, 270.0)), Some((180.0, 0.0)), Some((0.0, 0.0))]);
        let heights: Vec<_> = points.iter().map(|p| p.height).collect();
        assert_eq!(heights, [PointHeight::Z(5.0), PointHeight::Above(0.5), PointHeight::Above(0.0)]);
        assert_eq!((points[1].name.as_str(), points[1].line, points[0].x), ("b c", 4, 1.0));
    }

    /// Two tables without angles give points without orientation if none is needed, and are refused
    /// if one is.
    #[test]
    fn points_need_angles_only_if_asked() {
        assert_eq!(read("point,x,y,z\na,0,0,1\n", false).expect("points")[0].turn, None);
        assert_eq!(read("point,x,y,z,tilt,azimuth\na,0,0,1,,\n", false).expect("points")[0].turn, None);
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
            ("a,0,0,,30,180", "neither a z nor a height"),
            ("a,0,0,1,30,180\nA,0,0,1,30,180", "line 3: column `point` is `A`, the name of the point in line 2 too"),
            (",0,0,1,30,180", "an empty name"),
            ("../a,0,0,1,30,180", "could not be named after it"),
            ("a,0,0,1,30", "the row has 5 cells, the header 6"),
            ("", "a header but no points"),
        ] {
            let message = read(&format!("{head}{rows}\n"), true).expect_err(rows).to_string();
            assert!(message.contains("points.csv") && message.contains(expected), "{rows}: {message}");
        }
        for (text, expected) in [
            ("", "the file is empty"),
            ("point,x,y,tilt,azimuth\na,0,0,0,0\n", "columns `z` and `height` are both missing"),
            ("point;x;y\n", "column `point` is missing"),
        ] {
            let message = read(text, true).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
