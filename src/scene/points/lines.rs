//! Lines that people move along: roads, paths, tracks. In: a CSV file of their corners. Out: lines,
//! and points on them with the direction of travel.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::header::{Header, advance_to_header};
use super::rows::number;
use heliotile_core::error::{Error, Result};
use heliotile_files::csv_rows::CsvRows;

/// A line in the order of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct TravelLine {
    /// Name of the line: the cell of the column `line`, or the name of the file.
    pub name: String,
    /// Corners of the line, input coordinates, metres.
    pub corners: Vec<TravelCorner>,
}

/// A corner of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravelCorner {
    /// Position in plan.
    pub at: DVec2,
    /// Height of the road, if the file states it.
    pub z: Option<f64>,
}

/// A point on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravelPoint {
    /// Position of the point.
    pub at: TravelCorner,
    /// Direction of travel, level, unit length.
    pub ahead: DVec3,
}

/// Columns of a file of lines, as messages describe them.
const HINT: &str = "give columns x and y in metres; z (height of the road, metres) and line (a name) are optional";

/// Reads lines from a CSV file with columns `x,y` and optional `z` and `line`, in any order. Each
/// row is a corner, in the order of travel; consecutive rows of one name are a line. Fails if a
/// cell is not a number or a line has no length.
pub fn read_lines(file: &Path) -> Result<Vec<TravelLine>> {
    let named = named_corners(file, &["line"], HINT)?.into_iter();
    let lines: Vec<TravelLine> = named.map(|(name, corners)| TravelLine { name, corners }).collect();
    match lines.iter().find(|line| line.length_m() <= 0.0) {
        Some(line) => {
            let what = format!("line `{}` has no length", line.name);
            Err(Error::input(file, None, what, "give at least two corners, in the order of travel"))
        }
        None => Ok(lines),
    }
}

/// Reads corners from a CSV file with columns `x,y`, optional `z`, and an optional column of names,
/// which is `called`. Consecutive rows of one name belong together; without a name they have that
/// of the file. Fails if a cell is not a number, there is no row, or names are mixed.
pub(super) fn named_corners(
    file: &Path,
    called: &'static [&'static str],
    hint: &'static str,
) -> Result<Vec<(String, Vec<TravelCorner>)>> {
    let mut rows = CsvRows::open(file)?;
    advance_to_header(&mut rows, hint)?;
    let mut header = Header::new(&rows, hint);
    let (x, y) = (header.needed(&["x"])?, header.needed(&["y"])?);
    let (z, name) = (header.find(&["z"])?, header.find(called)?);
    let usual = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut found: Vec<(String, Vec<TravelCorner>)> = Vec::new();
    while rows.advance()? {
        let z = z.filter(|z| !rows.cell(z.place).is_empty()).map(|z| number(&rows, z)).transpose()?;
        let corner = TravelCorner { at: DVec2::new(number(&rows, x)?, number(&rows, y)?), z };
        let name = name.map(|name| rows.cell(name.place)).filter(|name| !name.is_empty()).unwrap_or(&usual);
        match found.iter().position(|(known, _)| known == name) {
            None => found.push((name.to_owned(), vec![corner])),
            Some(number) if number + 1 == found.len() => {
                found.last_mut().into_iter().for_each(|(_, corners)| corners.push(corner));
            }
            Some(_) => {
                let what = format!("the corners of {} `{name}` do not follow each other", called.concat());
                return Err(rows.error(what, "put them one after the other"));
            }
        }
    }
    if found.is_empty() {
        return Err(Error::input(file, None, "the file holds a header but no corners", hint));
    }
    Ok(found)
}

impl TravelLine {
    /// Returns the length in plan, metres.
    pub fn length_m(&self) -> f64 {
        self.corners.array_windows().map(|[from, to]| from.at.distance(to.at)).sum()
    }

    /// Returns the line in the other direction of travel.
    #[must_use]
    pub fn back(&self, name: String) -> Self {
        TravelLine { name, corners: self.corners.iter().rev().copied().collect() }
    }

    /// Returns points at a spacing, the first one half a spacing from the start.
    pub fn points(&self, spacing_m: f64) -> Vec<TravelPoint> {
        let (mut points, mut done_m, mut next_m) = (Vec::new(), 0.0, 0.5 * spacing_m.min(self.length_m()));
        for [from, to] in self.corners.array_windows() {
            let length_m = from.at.distance(to.at);
            while length_m > 0.0 && next_m <= done_m + length_m {
                let share = (next_m - done_m) / length_m;
                let z = from.z.zip(to.z).map(|(a, b)| a + share * (b - a));
                let ahead = ((to.at - from.at) / length_m).extend(0.0);
                points.push(TravelPoint { at: TravelCorner { at: from.at.lerp(to.at, share), z }, ahead });
                next_m += spacing_m;
            }
            done_m += length_m;
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::TestFolder;

    fn read(text: &str) -> Result<Vec<TravelLine>> {
        let folder = TestFolder::new();
        read_lines(&folder.write("road.csv", text))
    }

    /// A road of 10 and 6 m around a corner with a point every 4 m has four points, from 2 to 14 m
    /// along it, with heights interpolated between corners; only the last one heads north.
    /// Backwards the points are at the same distances from the road's end. A second line has its
    /// name, and a short one a point in its middle.
    #[test]
    fn points_follow_a_line_at_equal_distances() {
        let lines = read("line,x,y,z\na,0,0,0\na,10,0,10\na,10,6,4\nb,0,1,\nb,1,1,\n").expect("lines");
        let [a, b] = lines.as_slice() else { panic!("{lines:?}") };
        let points = a.points(4.0);
        let places: Vec<(f64, f64, Option<f64>)> = points.iter().map(|p| (p.at.at.x, p.at.at.y, p.at.z)).collect();
        assert_eq!(
            places,
            [(2.0, 0.0, Some(2.0)), (6.0, 0.0, Some(6.0)), (10.0, 0.0, Some(10.0)), (10.0, 4.0, Some(6.0))]
        );
        assert_eq!((points[0].ahead, points[3].ahead), (DVec3::X, DVec3::Y));
        let back = a.back("back".into()).points(4.0);
        assert_eq!((back.len(), back[0].at.at, back[0].ahead), (4, DVec2::new(10.0, 4.0), DVec3::NEG_Y));
        assert_eq!((b.name.as_str(), b.points(4.0)[0].at), ("b", TravelCorner { at: DVec2::new(0.5, 1.0), z: None }));
    }

    /// Five malformed files are refused, each with what is wrong.
    #[test]
    fn malformed_lines_are_refused() {
        for (text, says) in [
            ("", "empty"),
            ("x,z\n1,2\n", "column `y` is missing"),
            ("x,y\n1,2\n1,two\n", "line 3"),
            ("x,y\n1,2\n1,2\n", "no length"),
            ("line,x,y\na,0,0\na,1,0\nb,0,0\nb,1,1\na,2,2\n", "do not follow each other"),
        ] {
            assert!(read(text).is_err_and(|error| error.to_string().contains(says)), "{says}");
        }
    }
}
