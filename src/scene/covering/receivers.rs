//! Receivers from a file. In: `receivers.csv`. Out: checked receivers, in the order of the rows.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use glam::DVec3;

use crate::coordinate::MAX_COORDINATE_M;
use crate::covering::rows::{CsvRows, cell_error};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::receiver::{MAX_NAME_BYTES, Receiver};
use heliotile_core::text::{separator_hint, with_list};

const REQUIRED: [&str; 3] = ["receiver", "x", "y"];
const Z: &str = "z";
/// Column of heights above the first surface below the sky, in place of `z`.
const HEIGHT: &str = "height";
/// Columns of the direction a receiver faces: a vector, or angles in degrees (tilt 0 up and 90
/// level, azimuth clockwise from y).
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const ANGLES: [&str; 2] = ["tilt_deg", "azimuth_deg"];
const HEADER: &str = "receiver,x,y,z,nx,ny,nz";
const OPTIONAL: [&str; 2] = ["area", "surface"];
/// Optional columns of the model part that the receiver stands for.
const PART: [&str; 5] = ModelPart::COLUMNS;
/// Optional column of the part of its surface that the receiver stands for, as in [`Patch`].
pub const PATCH: &str = "patch";

/// Reads receivers from columns `receiver,x,y,z,nx,ny,nz` with optional `area` (m2), `surface`,
/// `patch` and the columns of [`ModelPart`], in any order. Fails without a row. All receivers are
/// held in memory; the builder's `ReceiverTiles` does not need to.
pub fn read_receivers(path: &Path) -> Result<Vec<Receiver>> {
    read_receivers_with_warnings(path, &mut Vec::new())
}

/// Reads receivers as [`read_receivers`] does and adds a warning about the columns that it ignores.
pub fn read_receivers_with_warnings(path: &Path, warnings: &mut Vec<String>) -> Result<Vec<Receiver>> {
    collect(ReceiverRows::open(path, warnings)?)
}

fn collect(mut rows: ReceiverRows) -> Result<Vec<Receiver>> {
    let mut receivers: Vec<Receiver> = Vec::new();
    let mut line_of_id: HashMap<String, usize> = HashMap::new();
    while let Some(receiver) = rows.read()? {
        match line_of_id.entry(receiver.id.clone()) {
            Entry::Vacant(new) => new.insert(rows.line()),
            Entry::Occupied(first) => return Err(duplicate(rows.file(), &receiver.id, *first.get(), rows.line())),
        };
        receivers.push(receiver);
    }
    if receivers.is_empty() { Err(no_receivers(rows.file())) } else { Ok(receivers) }
}

/// Returns the error for a name that two rows have.
pub fn duplicate(file: &Path, id: &str, first_line: usize, line: usize) -> Error {
    let why = format!("the name of the receiver in line {first_line} too");
    cell_error(file, line, "receiver", id, &why, "give every receiver a name of its own")
}

/// Returns the error for a file without rows.
pub fn no_receivers(file: &Path) -> Error {
    Error::input(file, None, "the file holds a header but no receivers", "add one row per receiver")
}

/// Height of the first surface below the sky at x and y, metres; `None` where there is none.
pub type SurfaceHeight<'a> = &'a dyn Fn(f64, f64) -> Result<Option<f64>>;

/// Rows of `receivers.csv` one after the other, each checked by itself.
pub struct ReceiverRows<'a> {
    rows: CsvRows<'a>,
    columns: Columns,
    surface: Option<SurfaceHeight<'a>>,
}

impl<'a> ReceiverRows<'a> {
    /// Opens the file and reads its header. A missing column is an error, an unknown column a
    /// warning.
    pub fn open(file: &'a Path, warnings: &mut Vec<String>) -> Result<Self> {
        ReceiverRows::new(CsvRows::open(file)?, warnings)
    }

    fn new(mut rows: CsvRows<'a>, warnings: &mut Vec<String>) -> Result<Self> {
        if !rows.advance()? {
            let hint = format!("begin with the line {HEADER}");
            return Err(Error::input(rows.file, None, "the file is empty", hint));
        }
        let columns = Columns::find(&rows, warnings)?;
        Ok(ReceiverRows { rows, columns, surface: None })
    }

    /// Returns these rows over a surface, from which a column `height` in place of `z` counts.
    pub fn over(self, surface: SurfaceHeight<'a>) -> Self {
        ReceiverRows { surface: Some(surface), ..self }
    }

    /// Returns the checked receiver of the next row; `None` after the last row.
    pub fn read(&mut self) -> Result<Option<Receiver>> {
        if !self.rows.advance()? {
            return Ok(None);
        }
        let row = Row { rows: &self.rows, columns: &self.columns };
        let mut receiver = row.receiver()?;
        if self.columns.is_above {
            row.raise(&mut receiver, self.surface)?;
        }
        Ok(Some(receiver))
    }

    /// Returns the path of the file, for messages.
    pub fn file(&self) -> &'a Path {
        self.rows.file
    }

    /// Returns the line of the last row, from 1.
    pub fn line(&self) -> usize {
        self.rows.line
    }
}

/// Places of the columns.
struct Columns {
    required: [usize; 4],
    /// True if the last required column is `height`.
    is_above: bool,
    facing: Facing,
    optional: [Option<usize>; 2],
    part: [Option<usize>; 5],
    patch: Option<usize>,
    count: usize,
}

impl Columns {
    fn find(header: &CsvRows, warnings: &mut Vec<String>) -> Result<Columns> {
        let names: Vec<&str> = header.record.iter().collect();
        let place = |wanted: &str| names.iter().position(|name| *name == wanted);
        let needed = |wanted: &str| {
            place(wanted).ok_or_else(|| {
                let what =
                    format!("column `{wanted}` is missing; the header is `{}`", excerpt(names.join(",").as_bytes()));
                let columns =
                    || format!("name the columns {HEADER}, or {} in place of {}", ANGLES.join(","), NORMAL.join(","));
                let hint = separator_hint(&names.join(",")).map(str::to_owned);
                header.error(what, hint.unwrap_or_else(columns))
            })
        };
        let is_above = place(Z).is_none() && place(HEIGHT).is_some();
        let level = if is_above { HEIGHT } else { Z };
        let mut required = [0; 4];
        for (slot, wanted) in required.iter_mut().zip(REQUIRED.into_iter().chain([level])) {
            *slot = needed(wanted)?;
        }
        let facing = match ANGLES.map(place) {
            [Some(tilt), Some(azimuth)] if !NORMAL.iter().any(|name| names.contains(name)) => {
                Facing::Angles([tilt, azimuth])
            }
            _ => Facing::Normal([needed("nx")?, needed("ny")?, needed("nz")?]),
        };
        let angles = matches!(facing, Facing::Angles(_));
        let mut unused = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let of_facing = if angles { ANGLES.contains(name) } else { NORMAL.contains(name) };
            let known = of_facing
                || REQUIRED.contains(name)
                || *name == level
                || OPTIONAL.contains(name)
                || PART.contains(name)
                || *name == PATCH;
            let shown = excerpt(name.as_bytes());
            if known && place(name) != Some(i) {
                return Err(header.error(format!("column `{shown}` appears twice"), "remove one of the two"));
            }
            if !known {
                unused.push(format!("`{shown}`"));
            }
        }
        let file = header.file.display();
        match unused.len() {
            0 => {}
            1 => warnings.push(format!("{file}: column {} is not used", unused.concat())),
            count => warnings.push(with_list(&format!("{file}: {count} columns are not used"), unused)),
        }
        Ok(Columns {
            required,
            is_above,
            facing,
            optional: OPTIONAL.map(place),
            part: PART.map(place),
            patch: place(PATCH),
            count: names.len(),
        })
    }
}

/// Columns that state the direction a receiver faces.
enum Facing {
    Normal([usize; 3]),
    Angles([usize; 2]),
}

struct Row<'a> {
    rows: &'a CsvRows<'a>,
    columns: &'a Columns,
}

impl Row<'_> {
    // The number of cells is checked first, so that a shifted row is not read as wrong numbers.
    fn receiver(&self) -> Result<Receiver> {
        let record = &self.rows.record;
        if record.len() != self.columns.count {
            let hint = match record.get(0) {
                Some(text) if text.starts_with('#') => "remove the line: there are no comments in this format",
                _ if record.len() > self.columns.count => {
                    "write one cell per column of the header, and decimals with a point: 1,5 is two cells"
                }
                _ => "write one cell per column of the header, empty ones too",
            };
            let text = excerpt(record.iter().collect::<Vec<_>>().join(",").as_bytes());
            let what = format!("the row `{text}` has {} cells, the header {}", record.len(), self.columns.count);
            return Err(self.rows.error(what, hint));
        }
        let [id, x, y, z] = self.columns.required.map(|column| self.cell(column));
        if id.is_empty() {
            return Err(self.rows.cell_error("receiver", id, "an empty name", "give every receiver a name"));
        }
        self.short("receiver", id)?;
        let position =
            DVec3::new(self.coordinate("x", x)?, self.coordinate("y", y)?, self.coordinate(self.level(), z)?);
        let normal = match self.columns.facing {
            Facing::Normal(columns) => self.normal(columns.map(|column| self.cell(column)))?,
            Facing::Angles([tilt, azimuth]) => self.direction(self.cell(tilt), self.cell(azimuth))?,
        };
        let [area, surface] =
            self.columns.optional.map(|column| column.map(|column| self.cell(column)).filter(|text| !text.is_empty()));
        self.short("surface", surface.unwrap_or_default())?;
        let part = self.columns.part.map(|column| column.map_or("", |column| self.cell(column)));
        PART.into_iter().zip(part).try_for_each(|(column, text)| self.short(column, text))?;
        Ok(Receiver {
            id: id.to_owned(),
            position,
            normal,
            area: area.map(|text| self.area(text)).transpose()?,
            surface: surface.map(str::to_owned),
            part: ModelPart::of_texts(part.map(str::to_owned)),
            patch: self.columns.patch.map_or_else(|| Ok(Patch::default()), |column| self.patch(self.cell(column)))?,
        })
    }

    /// Returns the name of the column of heights.
    fn level(&self) -> &'static str {
        if self.columns.is_above { HEIGHT } else { Z }
    }

    /// Raises a receiver whose z is a height above the surface below.
    fn raise(&self, receiver: &mut Receiver, surface: Option<SurfaceHeight>) -> Result<()> {
        let (position, [.., height]) = (&mut receiver.position, self.columns.required);
        let Some(surface) = surface else {
            let what = format!("column `{Z}` is missing, and heights above a surface need a scene");
            return Err(self.rows.error(what, "give z, the coordinate"));
        };
        if position.z < 0.0 {
            let hint = "give metres above the roof or ground below, or a column z with the coordinate";
            return Err(self.rows.cell_error(HEIGHT, self.cell(height), "below zero", hint));
        }
        let Some(z) = surface(position.x, position.y)? else {
            let what = format!(
                "below receiver `{}` ({}, {}) the scene has neither roof nor ground",
                excerpt(receiver.id.as_bytes()),
                position.x,
                position.y
            );
            return Err(self.rows.error(what, "check the coordinates, or give its z in place of a height"));
        };
        position.z += z;
        Ok(())
    }

    fn normal(&self, [nx, ny, nz]: [&str; 3]) -> Result<DVec3> {
        let normal = DVec3::new(self.number("nx", nx)?, self.number("ny", ny)?, self.number("nz", nz)?);
        // Division by the largest component keeps squares from under- or overflowing.
        let largest = normal.abs().max_element();
        if largest == 0.0 {
            let text = format!("{nx},{ny},{nz}");
            let why = "a normal of length zero";
            return Err(self.rows.cell_error("nx,ny,nz", &text, why, "give the direction the receiver faces"));
        }
        Ok((normal / largest).normalize())
    }

    fn direction(&self, tilt: &str, azimuth: &str) -> Result<DVec3> {
        let [tilt_name, azimuth_name] = ANGLES;
        let tilt_deg = self.number(tilt_name, tilt)?;
        if !(0.0..=180.0).contains(&tilt_deg) {
            let why = "not from 0 to 180";
            return Err(self.rows.cell_error(tilt_name, tilt, why, "0 looks up, 90 to the side, 180 down"));
        }
        let azimuth_deg = self.number(azimuth_name, azimuth)?;
        if !(-360.0..=360.0).contains(&azimuth_deg) {
            let why = "not from -360 to 360";
            return Err(self.rows.cell_error(azimuth_name, azimuth, why, "degrees clockwise from y, 180 is south"));
        }
        // A tilt of 0 gives exactly up, whatever the azimuth.
        let level = if tilt_deg == 0.0 || tilt_deg == 180.0 { 0.0 } else { tilt_deg.to_radians().sin() };
        let (east, north) = azimuth_deg.to_radians().sin_cos();
        Ok(DVec3::new(level * east, level * north, tilt_deg.to_radians().cos()).normalize())
    }

    fn cell(&self, column: usize) -> &str {
        self.rows.record.get(column).unwrap_or_default()
    }

    fn short(&self, column: &str, name: &str) -> Result<()> {
        if name.len() <= MAX_NAME_BYTES {
            return Ok(());
        }
        let start: String = name.chars().take(40).collect();
        let what = format!("a name of {} bytes", name.len());
        Err(self.rows.cell_error(column, &start, &what, "names have at most 1024 bytes"))
    }

    fn number(&self, column: &str, text: &str) -> Result<f64> {
        let hint = "write a decimal number with a point";
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self.rows.cell_error(column, text, "not a finite number", hint)),
            Err(_) => Err(self.rows.cell_error(column, text, "not a number", hint)),
        }
    }

    fn coordinate(&self, column: &str, text: &str) -> Result<f64> {
        let value = self.number(column, text)?;
        if value.abs() > MAX_COORDINATE_M {
            let why = "beyond all positions on Earth";
            return Err(self.rows.cell_error(column, text, why, "give metres, at most 1e9 in size"));
        }
        Ok(value)
    }

    fn patch(&self, text: &str) -> Result<Patch> {
        let hint = "leave the cell empty, or the column out";
        text.parse().map_err(|why: String| self.rows.cell_error(PATCH, text, &why, hint))
    }

    fn area(&self, text: &str) -> Result<f64> {
        let value = self.number("area", text)?;
        if value <= 0.0 {
            let why = "not above zero";
            return Err(self.rows.cell_error("area", text, why, "give m2, or leave the cell empty"));
        }
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{self, Read};

    use super::*;

    const HEADER: &str = "receiver,x,y,z,nx,ny,nz\n";

    /// Reads the bytes one at a time, so that nothing depends on where a read ends.
    fn read_bytes(mut bytes: &[u8]) -> Result<(Vec<Receiver>, Vec<String>)> {
        let dribble = std::iter::from_fn(move || bytes.split_off_first());
        let mut warnings = Vec::new();
        let rows = CsvRows::new(Box::new(Dribble(dribble)), Path::new("receivers.csv"))?;
        Ok((collect(ReceiverRows::new(rows, &mut warnings)?)?, warnings))
    }

    struct Dribble<I>(I);

    impl<'a, I: Iterator<Item = &'a u8>> Read for Dribble<I> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            Ok(buffer.iter_mut().take(1).zip(&mut self.0).map(|(slot, byte)| *slot = *byte).count())
        }
    }

    fn read(text: &str) -> Result<(Vec<Receiver>, Vec<String>)> {
        read_bytes(text.as_bytes())
    }

    /// Columns in any order, CRLF, blanks, quotes and unknown columns are read; normals come out
    /// with length 1.
    #[test]
    fn columns_are_read_in_any_order() {
        let text = "nz,surface , receiver,x,y,z,nx,ny,area,note\r\n 4 ,\"a, b\", r1 ,78000.25,457000.5,-1e1,3,0,2.5,hm\r\n\
                    -1e-310,,r2,0,0,0,0,-0,,\r\n";
        let (receivers, warnings) = read(text).expect("readable");
        assert_eq!(receivers.len(), 2);
        let first = &receivers[0];
        assert_eq!((first.id.as_str(), first.surface.as_deref(), first.area), ("r1", Some("a, b"), Some(2.5)));
        assert_eq!(first.position, DVec3::new(78000.25, 457000.5, -10.0));
        assert!((first.normal - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert_eq!(receivers[1].normal, DVec3::NEG_Z);
        assert_eq!((receivers[1].area, &receivers[1].surface), (None, &None));
        assert_eq!(warnings, ["receivers.csv: column `note` is not used"]);
    }

    /// Tilt and azimuth give normals within 1e-15, 5 of 5; four angles that are out of range or no
    /// number are refused, and so is a tilt without an azimuth.
    #[test]
    fn tilt_and_azimuth_become_normals() {
        let file = |tilt: &str, azimuth: &str| {
            read(&format!("receiver,x,y,z,tilt_deg,azimuth_deg\nr,0,0,0,{tilt},{azimuth}")).map(|read| read.0[0].normal)
        };
        let (half, third) = (0.5, 0.75_f64.sqrt());
        for (tilt, azimuth, normal) in [
            ("0", "77", DVec3::Z),
            ("90", "180", DVec3::NEG_Y),
            ("30", "180", DVec3::new(0.0, -half, third)),
            ("90", "-90", DVec3::NEG_X),
            ("180", "0", DVec3::NEG_Z),
        ] {
            let got = file(tilt, azimuth).expect("angles");
            assert!((got - normal).length() < 1e-15, "{tilt} {azimuth}: {got}");
        }
        for (tilt, azimuth) in [("-1", "0"), ("181", "0"), ("30", "361"), ("x", "0")] {
            assert!(file(tilt, azimuth).is_err(), "{tilt} {azimuth}");
        }
        let message = read("receiver,x,y,z,tilt_deg\nr,0,0,0,30").expect_err("no azimuth").to_string();
        assert!(message.contains("column `nx` is missing") && message.contains("tilt_deg,azimuth_deg"), "{message}");
    }

    /// Heights of 1.5 m over ground that rises to the east become coordinates, 2 of 2. A place
    /// without a surface, a height below zero and a table without a scene are refused in line 2;
    /// beside a z a height is not used.
    #[test]
    fn heights_count_from_the_surface_below() {
        let slope = |x: f64, _: f64| Ok((x < 100.0).then_some(10.0 + 0.1 * x));
        let over = |rows: &str| {
            let text = format!("receiver,x,y,height,tilt_deg,azimuth_deg\n{rows}");
            let rows = CsvRows::new(Box::new(std::io::Cursor::new(text)), Path::new("receivers.csv"))?;
            collect(ReceiverRows::new(rows, &mut Vec::new())?.over(&slope))
        };
        let found = over("a,0,0,1.5,0,0\nb,50,0,1.5,0,0").expect("heights");
        assert_eq!([found[0].position.z, found[1].position.z], [11.5, 16.5]);
        for (rows, quoted) in [("a,200,0,1.5,0,0", "neither roof nor ground"), ("a,0,0,-1,0,0", "`height` is `-1`")] {
            let message = over(rows).expect_err(rows).to_string();
            assert!(message.starts_with("receivers.csv, line 2: ") && message.contains(quoted), "{message}");
        }
        let message = read("receiver,x,y,height,tilt_deg,azimuth_deg\na,0,0,1,0,0").expect_err("no scene").to_string();
        assert!(message.contains("need a scene"), "{message}");
        let (both, warnings) = read(&format!("{},height\na,0,0,3,0,0,1,9", HEADER.trim())).expect("a z");
        assert_eq!((both[0].position.z, warnings.len()), (3.0, 1));
    }

    /// Every refusal names the file, the line, the column and the cell's text.
    #[test]
    fn a_refused_row_names_its_line_and_column() {
        for (rows, line, quoted) in [
            ("a,0,1.2.3,0,0,0,1", 2, "column `y` is `1.2.3`, not a number"),
            ("a,0,,0,0,0,1", 2, "column `y` is ``, not a number"),
            ("a,0,0,0,0,0,1\n\n\nb,nan,0,0,0,0,1", 5, "column `x` is `nan`, not a finite"),
            ("a,0,0,1e999,0,0,1", 2, "column `z` is `1e999`, not a finite"),
            ("a,0,0,2e9,0,0,1", 2, "column `z` is `2e9`, beyond"),
            ("a,0,0,0,inf,0,1", 2, "column `nx` is `inf`"),
            ("a,0,0,0,0,-0.0,0", 2, "column `nx,ny,nz` is `0,-0.0,0`, a normal of length zero"),
            ("\r\n ,0,0,0,0,0,1", 3, "column `receiver` is ``"),
            ("a,0,0,0,0,0,1\r\na,1,0,0,0,0,1", 3, "`a`, the name of the receiver in line 2"),
            ("a,0,0,0,0,0", 2, "the row `a,0,0,0,0,0` has 6 cells, the header 7"),
            ("a,0,0,0,0,0,1\n\"b\nc\",0,0,0,0,0,1\nd,0,0,0,0,0,1,5", 5, "has 8 cells"),
            ("# comment", 2, "no comments"),
            ("a,0,0,0,0,0,\u{1}x", 2, "column `nz`"),
        ] {
            let message = read(&format!("{HEADER}{rows}")).expect_err(rows).to_string();
            assert!(message.starts_with(&format!("receivers.csv, line {line}: ")), "{rows:?}: {message}");
            assert!(message.contains(quoted), "{rows:?}: {message}");
        }
    }

    /// Areas that are not above zero, headers without a column or with one twice, and files without
    /// rows are refused.
    #[test]
    fn wrong_headers_areas_and_texts_are_refused() {
        for (text, quoted) in [
            ("receiver,x,y,z,nx,ny,nz,area\na,0,0,0,0,0,1,0", "line 2: column `area` is `0`, not above zero"),
            ("receiver,x,y,z,nx,ny,nz,area\na,0,0,0,0,0,1,-5", "column `area` is `-5`"),
            (
                "receiver,x,y,nx,ny,nz\na,0,0,0,0,1",
                "line 1: column `z` is missing; the header is `receiver,x,y,nx,ny,nz`",
            ),
            ("receiver,x,y,z,nx,ny,nz,x\n", "line 1: column `x` appears twice"),
            (HEADER, "no receivers"),
            ("", "the file is empty"),
        ] {
            let message = read(text).expect_err(text).to_string();
            assert!(message.starts_with("receivers.csv") && message.contains(quoted), "{text:?}: {message}");
        }
        let broken = [HEADER.as_bytes(), b"a,0,0,0,0,0,1\n\xff,0,0,0,0,0,1\n"].concat();
        let message = read_bytes(&broken).expect_err("not UTF-8").to_string();
        assert!(message.starts_with("receivers.csv, line 3: the row is not UTF-8"), "{message}");
    }

    /// Names of 1024 bytes are read, longer ones of receivers and of surfaces refused in their
    /// line: 2 of 2.
    #[test]
    fn names_beyond_1024_bytes_are_refused() {
        let file = |id: usize, surface: usize| {
            let (id, surface) = ("i".repeat(id), "s".repeat(surface));
            read(&format!("receiver,x,y,z,nx,ny,nz,surface\n{id},0,0,0,0,0,1,{surface}"))
        };
        assert_eq!(file(1024, 1024).expect("readable").0.len(), 1);
        for (refused, column) in [(file(1025, 9), "receiver"), (file(9, 1025), "surface")] {
            let message = refused.expect_err(column).to_string();
            assert!(message.starts_with(&format!("receivers.csv, line 2: column `{column}` is `")), "{message}");
            assert!(message.contains("a name of 1025 bytes"), "{message}");
        }
    }

    /// A row of more than 16 MiB, as after a quote that is never closed, is refused with the line
    /// that it begins in.
    #[test]
    fn a_row_beyond_16_mib_is_refused() {
        let text = [HEADER, "a,0,0,0,0,0,1\n\n\"b", &"x\n".repeat(9 << 20)].concat();
        let rows = CsvRows::new(Box::new(text.as_bytes()), Path::new("receivers.csv")).expect("readable");
        let message = collect(ReceiverRows::new(rows, &mut Vec::new()).expect("a header")).expect_err("endless");
        let expected = "receivers.csv, line 4: the row is longer than 16 MiB";
        assert!(message.to_string().starts_with(expected), "{message}");
    }
}
