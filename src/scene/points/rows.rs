//! Rows of points, as receivers, modules and people have them in common. In: rows of a CSV file.
//! Out: the name, position and direction of each.

use glam::DVec3;

use super::header::{Found, Header, Names};
use crate::coordinate::MAX_COORDINATE_M;
use crate::text::excerpt;
use heliotile_core::error::{Problem, Result};
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::MAX_NAME_BYTES;
use heliotile_files::csv_rows::CsvRows;

const X: Names = &["x"];
const Y: Names = &["y"];
const Z: Names = &["z"];
const HEIGHT: Names = &["height", "height_m"];
const TILT: Names = &["tilt_deg", "tilt"];
const AZIMUTH: Names = &["azimuth_deg", "azimuth"];
const NORMAL: [Names; 3] = [&["nx"], &["ny"], &["nz"]];

/// Largest angle between the two directions of a row that states both, degrees: results round
/// angles to 0.01 degrees.
const SAME_DEG: f64 = 0.02;

/// Height of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointHeight {
    /// Input coordinate z, metres.
    Z(f64),
    /// Height above the first surface below the sky, a roof or the ground, metres.
    Above(f64),
}

/// Direction that a row states: a normal in the axes of the scene, or angles, or both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    normal: Option<DVec3>,
    turn: Option<Orientation>,
}

impl Facing {
    /// Returns the unit normal in the axes of the scene; azimuths count from `azimuths_from`. An
    /// error: the row states two directions.
    pub fn normal(self, azimuths_from: North) -> std::result::Result<DVec3, String> {
        let turned = self.turn.map(|turn| azimuths_from.to_axes(turn.normal()));
        match (self.normal, turned) {
            (Some(normal), Some(turned)) => {
                let off_deg = normal.angle_between(turned).to_degrees();
                let same = off_deg <= SAME_DEG;
                same.then_some(normal)
                    .ok_or_else(|| format!("its normal and its angles differ by {off_deg:.2} degrees"))
            }
            (normal, turned) => Ok(normal.or(turned).unwrap_or(DVec3::Z)),
        }
    }

    /// Returns the orientation by the true north of `site`; azimuths count from `azimuths_from`. An
    /// error: the row states two directions.
    pub fn turn(self, site: North, azimuths_from: North) -> std::result::Result<Orientation, String> {
        let normal = self.normal(azimuths_from)?;
        let stated = self.turn.filter(|_| site == azimuths_from);
        Ok(stated.unwrap_or_else(|| Orientation::new(site.to_true(normal))))
    }
}

/// Remedy for a row that states two directions.
pub const ONE_DIRECTION: &str = "leave out the columns nx,ny,nz or the columns tilt_deg,azimuth_deg";

/// Columns that a table may leave out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointDefaults {
    /// True if each row must state a direction.
    pub needs_turns: bool,
    /// Height above the first surface below the sky, metres, of rows without one; `None`: each row
    /// must have one.
    pub height_m: Option<f64>,
}

/// Columns of points in a table.
pub(super) struct PointColumns {
    name: Found,
    place: [Found; 2],
    z: Option<Found>,
    height: Option<Found>,
    normal: Option<[Found; 3]>,
    angles: Option<[Found; 2]>,
    defaults: PointDefaults,
    count: usize,
}

/// Row of a table of points.
pub(super) struct PointRow<'r> {
    pub name: &'r str,
    pub x: f64,
    pub y: f64,
    pub height: PointHeight,
    pub facing: Option<Facing>,
}

/// Returns all columns of a group, or none of them; some are an error.
fn all_or_none<const N: usize>(header: &mut Header, names: [Names; N]) -> Result<Option<[Found; N]>> {
    let mut found = [None; N];
    for (slot, names) in found.iter_mut().zip(names) {
        *slot = header.find(names)?;
    }
    if found.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut all = [Found { place: 0, name: "" }; N];
    for ((slot, found), names) in all.iter_mut().zip(found).zip(names) {
        *slot = found.ok_or_else(|| header.lacks(names.first().unwrap_or(&"")))?;
    }
    Ok(Some(all))
}

impl PointColumns {
    /// Finds the columns; `names` are those of the column of names, of which the first one counts.
    pub fn find(header: &mut Header, names: [Names; 2], defaults: PointDefaults) -> Result<Self> {
        let [own, other] = names;
        let name = match header.find(own)? {
            Some(name) => name,
            None => header.find(other)?.map_or_else(|| header.needed(own), Ok)?,
        };
        let place = [header.needed(X)?, header.needed(Y)?];
        let (z, height) = (header.find(Z)?, header.find(HEIGHT)?);
        if z.is_none() && height.is_none() && defaults.height_m.is_none() {
            return Err(header.lacks("z"));
        }
        let (normal, angles) = (all_or_none(header, NORMAL)?, all_or_none(header, [TILT, AZIMUTH])?);
        if defaults.needs_turns && normal.is_none() && angles.is_none() {
            let what = "columns `tilt_deg` and `azimuth_deg`, or `nx`, `ny` and `nz`, are missing";
            return Err(header.missing(what).because(Problem::no_column("tilt_deg")));
        }
        Ok(PointColumns { name, place, z, height, normal, angles, defaults, count: header.count() })
    }

    /// Returns the name of the column of names.
    pub fn name(&self) -> &'static str {
        self.name.name
    }

    /// Returns the point of a row. The number of cells is checked first, so that a shifted row is
    /// not read as wrong numbers.
    pub fn row<'r>(&self, rows: &'r CsvRows) -> Result<PointRow<'r>> {
        self.check_count(rows)?;
        let name = rows.cell(self.name.place);
        if name.is_empty() {
            let hint = format!("give every {} a name", self.name.name);
            return Err(rows.cell_error(self.name.name, name, "an empty name", hint));
        }
        check_length(rows, self.name.name, name)?;
        let [x, y] = self.place.map(|column| coordinate(rows, column));
        let (x, y, height) = (x?, y?, self.height(rows)?);
        Ok(PointRow { name, x, y, height, facing: self.facing(rows)? })
    }

    fn check_count(&self, rows: &CsvRows) -> Result<()> {
        let record = &rows.record;
        if record.len() == self.count {
            return Ok(());
        }
        let hint = match record.get(0) {
            Some(text) if text.starts_with('#') => "remove the line: there are no comments in this format",
            _ if record.len() > self.count => {
                "write one cell per column of the header, and decimals with a point: 1,5 is two cells"
            }
            _ => "write one cell per column of the header, empty ones too",
        };
        let text = excerpt(record.iter().collect::<Vec<_>>().join(",").as_bytes());
        let what = format!("the row `{text}` has {} cells, the header {}", record.len(), self.count);
        Err(rows.error(what, hint).because(Problem::OutOfRange {
            found: record.len() as f64,
            least: self.count as f64,
            most: self.count as f64,
        }))
    }

    fn height(&self, rows: &CsvRows) -> Result<PointHeight> {
        // The only column of heights must be filled, so that an empty cell is told as one.
        let filled = |column: Option<Found>, other: Option<Found>| {
            column.filter(|found| {
                !rows.cell(found.place).is_empty() || other.is_none() && self.defaults.height_m.is_none()
            })
        };
        match (filled(self.z, self.height), filled(self.height, self.z)) {
            (Some(z), None) => coordinate(rows, z).map(PointHeight::Z),
            (None, Some(height)) => match coordinate(rows, height)? {
                above if above >= 0.0 => Ok(PointHeight::Above(above)),
                _ => {
                    let hint = "give metres above the roof or ground below, or a column z with the coordinate";
                    Err(rows.cell_error(height.name, rows.cell(height.place), "below zero", hint))
                }
            },
            (Some(_), Some(_)) => {
                Err(rows.error("the row has both a z and a height", "leave one of the two cells empty"))
            }
            (None, None) => match self.defaults.height_m {
                Some(usual) => Ok(PointHeight::Above(usual)),
                None => Err(rows.error("the row has neither a z nor a height", "fill one of the two cells")),
            },
        }
    }

    fn facing(&self, rows: &CsvRows) -> Result<Option<Facing>> {
        let is_empty = |columns: &[Found]| columns.iter().all(|column| rows.cell(column.place).is_empty());
        // Cells may be empty where another group of columns, or the request, states the direction.
        let may_be_empty = !self.defaults.needs_turns || self.normal.is_some() && self.angles.is_some();
        let normal = self.normal.filter(|columns| !(may_be_empty && is_empty(columns)));
        let angles = self.angles.filter(|columns| !(may_be_empty && is_empty(columns)));
        if normal.is_none() && angles.is_none() {
            if self.defaults.needs_turns {
                return Err(rows.error("the row states no direction", "fill nx,ny,nz or tilt_deg,azimuth_deg"));
            }
            return Ok(None);
        }
        let normal = normal.map(|columns| self::normal(rows, columns)).transpose()?;
        Ok(Some(Facing { normal, turn: angles.map(|columns| turn(rows, columns)).transpose()? }))
    }
}

fn normal(rows: &CsvRows, columns: [Found; 3]) -> Result<DVec3> {
    let [x, y, z] = columns.map(|column| number(rows, column));
    let normal = DVec3::new(x?, y?, z?);
    // Division by the largest component keeps squares from under- or overflowing.
    let largest = normal.abs().max_element();
    if largest == 0.0 {
        let text = columns.map(|column| rows.cell(column.place)).join(",");
        let (why, hint) = ("a normal of length zero", "give the direction the receiver faces");
        return Err(rows.cell_error("nx,ny,nz", &text, why, hint));
    }
    Ok((normal / largest).normalize())
}

fn turn(rows: &CsvRows, [tilt, azimuth]: [Found; 2]) -> Result<Orientation> {
    let within = |column: Found, [least, most]: [f64; 2], hint: &'static str| match number(rows, column)? {
        angle if (least..=most).contains(&angle) => Ok(angle),
        _ => {
            let why = format!("not from {least} to {most}");
            Err(rows.cell_error(column.name, rows.cell(column.place), &why, hint))
        }
    };
    let tilt_deg = within(tilt, [0.0, 180.0], "0 looks up, 90 to the side, 180 down")?;
    let hint = "degrees clockwise from true north: 90 is east, 180 south";
    let azimuth_deg = within(azimuth, [-360.0, 360.0], hint)?.rem_euclid(360.0);
    Ok(Orientation { tilt_deg, azimuth_deg })
}

/// Returns the finite number of a cell.
pub(super) fn number(rows: &CsvRows, column: Found) -> Result<f64> {
    let (text, hint) = (rows.cell(column.place), "write a decimal number with a point");
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(rows.cell_error(column.name, text, "not a finite number", hint)),
        Err(_) => Err(rows.cell_error(column.name, text, "not a number", hint)),
    }
}

/// Returns the coordinate of a cell, metres.
fn coordinate(rows: &CsvRows, column: Found) -> Result<f64> {
    let value = number(rows, column)?;
    if value.abs() > MAX_COORDINATE_M {
        let (why, hint) = ("beyond all positions on Earth", "give metres, at most 1e9 in size");
        return Err(rows.cell_error(column.name, rows.cell(column.place), why, hint));
    }
    Ok(value)
}

/// Checks that a text is no longer than archives hold.
pub(super) fn check_length(rows: &CsvRows, column: &str, name: &str) -> Result<()> {
    if name.len() <= MAX_NAME_BYTES {
        return Ok(());
    }
    let start: String = name.chars().take(40).collect();
    let what = format!("a name of {} bytes", name.len());
    Err(rows.cell_error(column, &start, &what, "names have at most 1024 bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::place::Place;

    fn facing(normal: Option<DVec3>, turn: Option<[f64; 2]>) -> Facing {
        Facing { normal, turn: turn.map(|[tilt_deg, azimuth_deg]| Orientation { tilt_deg, azimuth_deg }) }
    }

    /// With y 0.8 degrees clockwise of true north, a wall to the true south has azimuth 180, and
    /// its normal lies 0.8 degrees beside -y; angles from y give -y. The angles come back to 1e-12.
    /// A normal and angles that agree to 0.01 degrees are one direction, others are refused with
    /// 0.81.
    #[test]
    fn azimuths_count_from_true_north() {
        let place = Place { latitude_deg: 47.0, longitude_deg: 8.6, convergence_deg: 0.8, epsg: Some(2056) };
        let (north, grid) = (North::new(Some(&place)), North::default());
        let south = facing(None, Some([90.0, 180.0]));
        let normal = south.normal(north).expect("one direction");
        assert!((normal.angle_between(DVec3::NEG_Y).to_degrees() - 0.8).abs() < 1e-9 && normal.x > 0.0, "{normal}");
        assert!((south.normal(grid).expect("one") - DVec3::NEG_Y).length() < 1e-15);
        assert!((south.turn(north, grid).expect("one").azimuth_deg - 180.8).abs() < 1e-12);
        assert_eq!(south.turn(north, north).expect("one").azimuth_deg, 180.0);
        let back = facing(Some(normal), None).turn(north, north).expect("one");
        assert!((back.azimuth_deg - 180.0).abs() < 1e-12 && (back.tilt_deg - 90.0).abs() < 1e-12);
        assert_eq!(facing(Some(normal), Some([90.0, 180.01])).normal(north), Ok(normal));
        let two = facing(Some(DVec3::NEG_Y), Some([90.0, 180.01])).normal(north).expect_err("two directions");
        assert!(two.contains("differ by 0.79 degrees"), "{two}");
    }
}
