//! Lines above the rows of a table. In: the first lines. Out: names of columns, their units, and
//! the place and the clock that the lines above them state.
//!
//! The line of names is the first one with a time and some light among its cells.
//! [`layout`](super::layout) finds which program's layout a file has, and what follows from it.

use std::path::Path;

use csv::{ReaderBuilder, Trim};

use crate::formats::stamp_text::parse_stamp;
use crate::formats::weather_csv::cells::{NumberStyle, is_missing};
use crate::formats::weather_csv::names::{Quantity, match_name, squash};
use crate::formats::weather_csv::time_names::names_a_time;
use crate::formats::weather_csv::units::{Measure, Unit, parse_unit};
use crate::judging::station::Station;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, excerpt};
use heliotile_core::weather::options::{DateOrder, StampedAt};

/// Program or service whose layout a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Plain,
    Nsrdb,
    Pvgis,
    OpenMeteo,
    NasaPower,
    Solargis,
    Pvsyst,
    Cams,
    SolarAnywhere,
    Meteonorm,
    /// Files of Campbell's dataloggers, TOA5.
    Datalogger,
}

/// Facts about a file that are known before its first row.
pub struct Head {
    pub kind: Kind,
    pub station: Station,
    /// Delimiter of cells; a blank stands for any number of blanks.
    pub delimiter: u8,
    /// Names of the columns in the file.
    pub names: Vec<String>,
    /// `[column]`: units that a row below the names or lines above them state; empty where they
    /// state none.
    pub units: Vec<String>,
    /// True if `units` may hold other texts than units.
    pub units_are_loose: bool,
    /// Cells of the first row.
    pub first_row: Vec<String>,
    /// Number of lines above the rows; the last is the line of names.
    pub lines: usize,
    /// Slope of the plane that PVGIS' irradiances are on, degrees.
    pub slope_deg: Option<f64>,
    /// Delay of each row after its stamp, minutes.
    pub late_min: f64,
    /// Place of a stamp in its interval, if the lines above state it.
    pub stamped_at: Option<StampedAt>,
    pub style: NumberStyle,
    /// Sentences for the user, each naming the file.
    pub warnings: Vec<Message>,
    /// Offset of the rows in the file, bytes.
    rows_at: usize,
}

/// Largest number of lines above the rows. NASA POWER and Solargis have some dozens of lines above
/// the names.
const MAX_HEAD_LINES: usize = 200;

impl Head {
    /// Returns a head that knows only the file.
    pub fn empty(path: &Path) -> Self {
        Head {
            kind: Kind::Plain,
            station: Station {
                name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                latitude_deg: None,
                longitude_deg: None,
                zone_hours: None,
                zone_is_certain: false,
                elevation_m: 0.0,
            },
            delimiter: b',',
            names: Vec::new(),
            units: Vec::new(),
            units_are_loose: false,
            first_row: Vec::new(),
            lines: 0,
            slope_deg: None,
            late_min: 0.0,
            stamped_at: None,
            style: NumberStyle::default(),
            warnings: Vec::new(),
            rows_at: 0,
        }
    }

    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self> {
        let mut head = Head::empty(path);
        let mut lines = Lines { bytes, at: if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }, count: 0 };
        let above = head.find_names(path, &mut lines)?;
        head.take_layout(path, &above)?;
        let before = head.style.no_data;
        head.take_rows_below(path, &mut lines)?;
        head.style.no_data = before;
        head.style.decimal_comma = head.delimiter != b',';
        Ok(head)
    }

    /// Finds the line of names, and returns the lines above it.
    fn find_names(&mut self, path: &Path, lines: &mut Lines) -> Result<Vec<HeadLine>> {
        let start = *lines;
        let mut above = Vec::new();
        while let Some(line) = lines.next_line() {
            if above.len() >= MAX_HEAD_LINES {
                break;
            }
            if self.take_names(&line) && names_are_here(self, lines) {
                (self.lines, self.rows_at) = (lines.count, lines.at);
                return Ok(above);
            }
            above.push(HeadLine { line: lines.count, text: line });
        }
        // Without a line of names, the first line that is no comment is taken for it, so that
        // messages show it.
        *lines = start;
        let Some(first) = lines.next_plain() else {
            let hint = "give a weather file, EPW, TMY3, SURFRAD or CSV";
            return Err(Error::input(path, None, "the file is empty", hint));
        };
        self.refuse_unfinished(path, &above)?;
        self.take_names(&first);
        (self.lines, self.rows_at) = (lines.count, lines.at);
        Ok(Vec::new())
    }

    /// Takes a line's cells for names. Returns true if some of them name light.
    fn take_names(&mut self, line: &str) -> bool {
        let plain = line.strip_prefix('#').map_or(line, str::trim_start);
        let of = |delimiter: &u8| plain.bytes().filter(|byte| byte == delimiter).count();
        // The first of equally frequent delimiters is taken.
        self.delimiter = [b'\t', b';', b','].into_iter().max_by_key(of).unwrap_or(b',');
        if of(&self.delimiter) == 0 && plain.split_whitespace().count() > 2 {
            self.delimiter = b' ';
        }
        self.names = split(plain, self.delimiter);
        if line.starts_with('#') {
            while self.names.last().is_some_and(String::is_empty) {
                self.names.pop();
            }
        }
        let light = [Quantity::Ghi, Quantity::Dni, Quantity::Dhi, Quantity::Beam];
        self.take_clear_sky(&light);
        let is_light = |name: &String| {
            light.iter().any(|quantity| match_name(name, *quantity).is_some())
                || ["gb(i)", "gd(i)", "g(i)"].contains(&squash(name).as_str())
        };
        self.names.len() > 1 && self.names.iter().any(is_light)
    }

    /// Names the columns of CAMS McClear, `Clear sky GHI` and so on, as those of the radiation
    /// service, which has both kinds.
    fn take_clear_sky(&mut self, light: &[Quantity]) {
        let is_light = |name: &String| light.iter().any(|quantity| match_name(name, *quantity).is_some());
        let is_cams = self.names.first().is_some_and(|name| squash(name) == "observationperiod");
        if !is_cams || self.names.iter().any(is_light) {
            return;
        }
        for name in &mut self.names {
            if let Some((start, rest)) = name.split_at_checked(10)
                && start.eq_ignore_ascii_case("clear sky ")
            {
                *name = rest.to_owned();
            }
        }
    }

    /// Takes rows of units and of words below the names, and the first row.
    fn take_rows_below(&mut self, path: &Path, lines: &mut Lines) -> Result<()> {
        loop {
            let mut ahead = *lines;
            let Some(line) = ahead.next_plain() else { return Ok(()) };
            let cells = split(&line, self.delimiter);
            // TOA5 has rows of units and of kinds of values below its names.
            let has_units = self.kind == Kind::Datalogger && self.lines < 4;
            if !(has_units || self.is_row_of_units(&cells)) {
                self.first_row = cells;
                return Ok(());
            }
            if self.units.iter().all(String::is_empty) {
                self.units = cells.iter().map(|cell| cell.trim_matches(['(', ')', '[', ']', ' ']).to_owned()).collect();
                self.units.iter_mut().filter(|unit| is_missing(unit)).for_each(String::clear);
            }
            *lines = ahead;
            (self.lines, self.rows_at) = (lines.count, lines.at);
            if self.lines > MAX_HEAD_LINES {
                return Err(Error::input(
                    path,
                    self.lines,
                    "no row of numbers below the names",
                    "save the file as CSV",
                ));
            }
        }
    }

    /// Returns true if the cells below the names are units: none of them is a number or a stamp,
    /// and a cell below light is a unit or a word.
    fn is_row_of_units(&self, cells: &[String]) -> bool {
        let number = |cell: &String| {
            let text = cell.replace(',', ".");
            text.parse::<f64>().is_ok() || parse_stamp(cell, Some(DateOrder::Dmy)).is_some()
        };
        if cells.iter().any(number) {
            return false;
        }
        let below_light = |(name, cell): (&String, &String)| {
            let light = [Quantity::Ghi, Quantity::Dni, Quantity::Dhi, Quantity::Beam];
            let is_light = light.iter().any(|quantity| match_name(name, *quantity).is_some());
            let unit = cell.trim_matches(['(', ')', '[', ']', ' ']);
            is_light && (parse_unit(unit, Measure::Irradiance).is_some() || !is_missing(unit) && cells.len() > 1)
        };
        let dated = cells.first().is_some_and(|cell| cell.chars().filter(char::is_ascii_digit).count() > 3);
        !dated && self.names.iter().zip(cells).any(below_light)
    }

    /// Returns the line of names; `None` in JSON, whose names stand in no line of their own.
    pub fn line_of_names(&self) -> Option<usize> {
        Some(self.lines).filter(|line| *line > 0)
    }

    /// Returns a cell of the first row.
    pub fn first(&self, place: usize) -> &str {
        self.first_row.get(place).map_or("", String::as_str)
    }

    /// Returns the unit of a column whose name and lines state none.
    pub fn usual_unit(&self, quantity: Quantity) -> Unit {
        let stated = match (self.kind, quantity.measure()) {
            (Kind::Cams, Measure::Irradiance) => parse_unit("Wh/m2", Measure::Irradiance),
            (Kind::OpenMeteo, Measure::Depth) => parse_unit("m", Measure::Depth),
            _ => None,
        };
        stated.unwrap_or(Unit::PLAIN)
    }

    /// Returns the bytes below the names.
    pub fn rows_of<'b>(&self, bytes: &'b [u8]) -> &'b [u8] {
        bytes.get(self.rows_at..).unwrap_or_default()
    }
}

/// Returns true if the text below a line can be rows. Otherwise the line is no line of names but a
/// text that mentions light.
fn names_are_here(head: &Head, lines: &Lines) -> bool {
    let mut ahead = *lines;
    let Some(next) = ahead.next_line() else { return true };
    if next.starts_with('#') && !names_a_time(&head.names) {
        return false;
    }
    let cells = split(next.strip_prefix('#').unwrap_or(&next), head.delimiter);
    let first = cells.first().map_or("", String::as_str);
    let dated = parse_stamp(first, Some(DateOrder::Dmy)).is_some();
    names_a_time(&head.names) && cells.len() > 1 || dated
}

/// A line above the names.
pub struct HeadLine {
    pub line: usize,
    pub text: String,
}

/// Reads a number from a line above the names.
pub fn checked(path: &Path, line: usize, name: &str, text: &str) -> Result<f64> {
    text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
        let what = format!("`{name}` holds `{}`", excerpt(text, 60));
        Error::input(path, line, what, "write a number, as in the file that was downloaded")
    })
}

/// Splits one line into cells.
pub fn split(line: &str, delimiter: u8) -> Vec<String> {
    if delimiter == b' ' {
        return line.split_whitespace().map(str::to_owned).collect();
    }
    let mut reader =
        ReaderBuilder::new().has_headers(false).trim(Trim::All).delimiter(delimiter).from_reader(line.as_bytes());
    let record = reader.records().next().and_then(std::result::Result::ok).unwrap_or_default();
    record.iter().map(str::to_owned).collect()
}

/// Reader of the lines of a file that are not empty.
#[derive(Clone, Copy)]
struct Lines<'b> {
    bytes: &'b [u8],
    /// Offset of the next line.
    at: usize,
    /// Number of lines read, empty ones and comments included.
    count: usize,
}

impl Lines<'_> {
    /// Returns the next line that is not empty.
    fn next_line(&mut self) -> Option<String> {
        loop {
            let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
            let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
            self.at += (end + 1).min(rest.len());
            self.count += 1;
            let line = latin_or_utf8(rest.get(..end).unwrap_or_default());
            let line = line.trim_end_matches('\r');
            if !line.trim().is_empty() {
                return Some(line.to_owned());
            }
        }
    }

    /// Returns the next line that is no comment.
    fn next_plain(&mut self) -> Option<String> {
        loop {
            let line = self.next_line()?;
            if !line.starts_with('#') {
                return Some(line);
            }
        }
    }
}

/// Returns the text of bytes: UTF-8, or else Latin 1, in which some programs write `W/m²`.
fn latin_or_utf8(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}
