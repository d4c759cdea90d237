//! Receivers from a file. In: `receivers.csv`. Out: checked receivers, in the order of the rows.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use glam::DVec3;

use super::header::{Found, Header, Names, advance_to_header};
use super::rows::{ONE_DIRECTION, PointColumns, PointDefaults, PointHeight, check_length, number};
use crate::text::excerpt;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::north::North;
use heliotile_core::site::patch::PATCH;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::Message;
use heliotile_files::csv_rows::{CsvRows, cell_error};

const NAMES: [Names; 2] = [&["receiver"], &["point"]];
const AREA: Names = &["area_m2", "area"];
const SURFACE: Names = &["surface"];
/// Optional columns of the model part that the receiver stands for.
const PART: [Names; ModelPart::COLUMNS.len()] = {
    const ALL: [&str; ModelPart::COLUMNS.len()] = ModelPart::COLUMNS;
    [&[ALL[0]], &[ALL[1]], &[ALL[2]], &[ALL[3]], &[ALL[4]]]
};
/// Columns of a header, for messages.
const HINT: &str =
    "name the columns receiver,x,y,z and tilt_deg,azimuth_deg or nx,ny,nz; height may stand in place of z";

/// A receiver stands at a height of its own and looks somewhere.
const DEFAULTS: PointDefaults = PointDefaults { needs_turns: true, height_m: None };

/// Table of receivers.
#[derive(Clone, Copy, Debug)]
pub enum ReceiverCsv<'a> {
    /// CSV file.
    File(&'a Path),
    /// Text of a CSV file in memory.
    Text {
        /// Name of the table in messages.
        name: &'a Path,
        /// The text, UTF-8.
        text: &'a [u8],
    },
}

impl<'a> From<&'a Path> for ReceiverCsv<'a> {
    fn from(file: &'a Path) -> Self {
        ReceiverCsv::File(file)
    }
}

impl<'a> ReceiverCsv<'a> {
    /// Returns the file, or the name that messages use.
    pub fn name(self) -> &'a Path {
        match self {
            ReceiverCsv::File(name) | ReceiverCsv::Text { name, .. } => name,
        }
    }
}

/// Reads receivers from columns `receiver,x,y`, one of `z` and `height`, `tilt_deg,azimuth_deg` or
/// `nx,ny,nz`, and optional `area_m2`, `surface`, `patch` and those of [`ModelPart`], in any order.
/// Azimuths count from `north`. Fails without a row. All receivers are held in memory; the
/// builder's `ReceiverTiles` does not need to.
pub fn read_receivers(path: &Path, north: North) -> Result<Vec<Receiver>> {
    read_receivers_with_warnings(path, north, &mut Vec::new())
}

/// Reads receivers as [`read_receivers`] does and adds a warning about the columns that it ignores.
pub fn read_receivers_with_warnings(path: &Path, north: North, warnings: &mut Vec<Message>) -> Result<Vec<Receiver>> {
    collect(ReceiverRows::open(path, north, warnings)?)
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
        .because(Problem::duplicate(id))
}

/// Returns the error for a file without rows.
pub fn no_receivers(file: &Path) -> Error {
    Error::input(file, None, "the file holds a header but no receivers", "add one row per receiver")
        .because(Problem::Empty)
}

/// Height of the first surface below the sky at x and y, metres; `None` where there is none.
pub type SurfaceHeight<'a> = &'a dyn Fn(f64, f64) -> Result<Option<f64>>;

/// Rows of `receivers.csv` one after the other, each checked by itself.
pub struct ReceiverRows<'a> {
    rows: CsvRows<'a>,
    columns: Columns,
    north: North,
    surface: Option<SurfaceHeight<'a>>,
}

/// Columns of the table.
struct Columns {
    point: PointColumns,
    area: Option<Found>,
    surface: Option<Found>,
    part: [Option<Found>; ModelPart::COLUMNS.len()],
    patch: Option<Found>,
}

impl<'a> ReceiverRows<'a> {
    /// Opens the table and reads its header. A missing column is an error, an unknown column a
    /// warning. Azimuths count from `north`.
    pub fn open(table: impl Into<ReceiverCsv<'a>>, north: North, warnings: &mut Vec<Message>) -> Result<Self> {
        let rows = match table.into() {
            ReceiverCsv::File(file) => CsvRows::open(file)?,
            ReceiverCsv::Text { name, text } => CsvRows::new(Box::new(text), name)?,
        };
        ReceiverRows::new(rows, north, warnings)
    }

    fn new(mut rows: CsvRows<'a>, north: North, warnings: &mut Vec<Message>) -> Result<Self> {
        advance_to_header(&mut rows, HINT)?;
        let mut header = Header::new(&rows, HINT);
        let columns = Columns::find(&mut header)?;
        warnings.extend(header.unused());
        Ok(ReceiverRows { rows, columns, north, surface: None })
    }

    /// Returns these rows over a surface, from which a column `height` in place of `z` counts.
    pub fn over(self, surface: SurfaceHeight<'a>) -> Self {
        ReceiverRows { surface: Some(surface), ..self }
    }

    /// Returns the checked receiver of the next row; `None` after the last row.
    pub fn read(&mut self) -> Result<Option<Receiver>> {
        if self.rows.advance()? { self.receiver().map(Some) } else { Ok(None) }
    }

    /// Returns the path of the file, for messages.
    pub fn file(&self) -> &'a Path {
        self.rows.file
    }

    /// Returns the line of the last row, from 1.
    pub fn line(&self) -> usize {
        self.rows.line
    }

    fn receiver(&self) -> Result<Receiver> {
        let (rows, columns) = (&self.rows, &self.columns);
        let point = columns.point.row(rows)?;
        let normal = point.facing.map_or(Ok(DVec3::Z), |facing| facing.normal(self.north));
        let normal = normal.map_err(|what| rows.error(what, ONE_DIRECTION))?;
        let z = match point.height {
            PointHeight::Z(z) => z,
            PointHeight::Above(height) => self.surface_below(point.name, [point.x, point.y])? + height,
        };
        let cell = |column: Option<Found>| column.map_or("", |column| rows.cell(column.place));
        let surface = cell(columns.surface);
        check_length(rows, "surface", surface)?;
        let part = columns.part.map(cell);
        ModelPart::COLUMNS.into_iter().zip(part).try_for_each(|(column, text)| check_length(rows, column, text))?;
        let area = columns.area.filter(|column| !rows.cell(column.place).is_empty());
        let patch = cell(columns.patch).parse();
        let hint = "leave the cell empty, or the column out";
        Ok(Receiver {
            id: point.name.to_owned(),
            position: DVec3::new(point.x, point.y, z),
            normal,
            area: area.map(|column| self.area(column)).transpose()?,
            surface: Some(surface).filter(|name| !name.is_empty()).map(str::to_owned),
            part: ModelPart::of_texts(part.map(str::to_owned)),
            patch: patch.map_err(|why: String| rows.cell_error(PATCH, cell(columns.patch), &why, hint))?,
        })
    }

    /// Returns the z of the surface below a receiver whose height counts from it.
    fn surface_below(&self, name: &str, [x, y]: [f64; 2]) -> Result<f64> {
        let Some(surface) = self.surface else {
            let what = "column `z` is missing, and heights above a surface need a scene";
            return Err(self.rows.error(what, "give z, the coordinate").because(Problem::no_column("z")));
        };
        surface(x, y)?.ok_or_else(|| {
            let name = excerpt(name.as_bytes());
            let what = format!("below receiver `{name}` ({x}, {y}) the scene has neither roof nor ground");
            self.rows.error(what, "check the coordinates, or give its z in place of a height")
        })
    }

    fn area(&self, column: Found) -> Result<f64> {
        match number(&self.rows, column)? {
            area if area > 0.0 => Ok(area),
            _ => {
                let (text, why) = (self.rows.cell(column.place), "not above zero");
                Err(self.rows.cell_error(column.name, text, why, "give m2, or leave the cell empty"))
            }
        }
    }
}

impl Columns {
    fn find(header: &mut Header) -> Result<Columns> {
        let point = PointColumns::find(header, NAMES, DEFAULTS)?;
        let mut part = [None; ModelPart::COLUMNS.len()];
        for (slot, name) in part.iter_mut().zip(PART) {
            *slot = header.find(name)?;
        }
        Ok(Columns {
            point,
            area: header.find(AREA)?,
            surface: header.find(SURFACE)?,
            part,
            patch: header.find(&[PATCH])?,
        })
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
        Ok((
            collect(ReceiverRows::new(rows, North::default(), &mut warnings)?)?,
            warnings.iter().map(|said| said.plain()).collect(),
        ))
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
        assert!(message.contains("column `azimuth_deg` is missing"), "{message}");
        let message = read("receiver,x,y,z\nr,0,0,0").expect_err("no direction").to_string();
        assert!(message.contains("`tilt_deg` and `azimuth_deg`, or `nx`, `ny` and `nz`, are missing"), "{message}");
    }

    /// Names of columns that results, tables of modules and other programs use are read, 7 of 7;
    /// a row may state its direction twice if both agree. Two names of one column, and rows with
    /// two directions or two heights, are refused: 4 of 4.
    #[test]
    fn other_names_of_columns_are_read() {
        let text = "Point,X,Y,height_m,z,tilt,azimuth,nx,ny,nz,area\na,1,2,,3,30,180,0,-0.5,0.8660254,4\n";
        let (receivers, warnings) = read(text).expect("a receiver");
        let a = &receivers[0];
        assert_eq!((a.id.as_str(), a.position, a.area), ("a", DVec3::new(1.0, 2.0, 3.0), Some(4.0)));
        assert!((a.normal - DVec3::new(0.0, -0.5, 0.75_f64.sqrt())).length() < 1e-7 && warnings.is_empty());
        for (text, quoted) in [
            ("receiver,x,y,height,height_m,nx,ny,nz\n", "columns `height` and `height_m` state the same"),
            ("receiver,x,y,z,tilt,tilt_deg,azimuth\n", "columns `tilt` and `tilt_deg` state the same"),
            (
                "receiver,x,y,z,nx,ny,nz,tilt,azimuth\na,0,0,0,0,0,1,30,0",
                "line 2: its normal and its angles differ by 30.00",
            ),
            ("receiver,x,y,z,height,tilt,azimuth\na,0,0,0,1,30,0", "line 2: the row has both a z and a height"),
        ] {
            let message = read(text).expect_err(text).to_string();
            assert!(message.contains(quoted), "{message}");
        }
    }

    /// Heights of 1.5 m over ground that rises to the east become coordinates, 2 of 2. A place
    /// without a surface, a height below zero and a table without a scene are refused in line 2.
    #[test]
    fn heights_count_from_the_surface_below() {
        let slope = |x: f64, _: f64| Ok((x < 100.0).then_some(10.0 + 0.1 * x));
        let over = |rows: &str| {
            let text = format!("receiver,x,y,height,tilt_deg,azimuth_deg\n{rows}");
            let rows = CsvRows::new(Box::new(std::io::Cursor::new(text)), Path::new("receivers.csv"))?;
            collect(ReceiverRows::new(rows, North::default(), &mut Vec::new())?.over(&slope))
        };
        let found = over("a,0,0,1.5,0,0\nb,50,0,1.5,0,0").expect("heights");
        assert_eq!([found[0].position.z, found[1].position.z], [11.5, 16.5]);
        for (rows, quoted) in [("a,200,0,1.5,0,0", "neither roof nor ground"), ("a,0,0,-1,0,0", "`height` is `-1`")] {
            let message = over(rows).expect_err(rows).to_string();
            assert!(message.starts_with("receivers.csv, line 2: ") && message.contains(quoted), "{message}");
        }
        let message = read("receiver,x,y,height,tilt_deg,azimuth_deg\na,0,0,1,0,0").expect_err("no scene").to_string();
        assert!(message.contains("need a scene"), "{message}");
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
        let message = collect(ReceiverRows::new(rows, North::default(), &mut Vec::new()).expect("a header"))
            .expect_err("endless");
        let expected = "receivers.csv, line 4: the row is longer than 16 MiB";
        assert!(message.to_string().starts_with(expected), "{message}");
    }
}
