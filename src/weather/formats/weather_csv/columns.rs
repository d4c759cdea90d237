//! Choice of the columns. In: names of columns and their units. Out: indices of the columns that
//! are read, and rows by them.

use std::path::Path;

use crate::formats::weather_csv::cells::{Cells, MISSING_RADIATION, SHOWN, is_code};
use crate::formats::weather_csv::head::Head;
use crate::formats::weather_csv::names::{NameMatch, Quantity, StatedUnit, match_name, squash};
use crate::formats::weather_csv::units::{Unit, looks_like_unit, parse_unit};
use crate::judging::raw_weather::{AIR_C, RawRow, WIND_M_S, irradiance_of};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, excerpt};
use heliotile_core::weather::air::{Air, dew_point_c};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Interval;

/// Name of the direct light on an inclined plane, which is of use only if the plane is horizontal.
const BEAM_INCLINED: &str = "gb(i)";
const DIFFUSE_INCLINED: &str = "gd(i)";
const GLOBAL_INCLINED: &str = "g(i)";

const MISSING_SNOW_CM: f64 = 999.0;

/// Words in names of columns that hold no total or direct light.
const OTHER_THINGS: [&str; 26] = [
    "press", "cloud", "wind", "source", "uncert", "flag", "fill", "azimuth", "etr", "clear", "precip", "rain",
    "station", "quality", "qc", "toa", "extra", "humid", "temp", "type", "visib", "ozone", "aerosol", "water", "cover",
    "unnamed",
];

/// Number of columns that a message names.
const UNREAD_SHOWN: usize = 6;

/// Number of characters of a line of names that a message shows.
const NAMES_SHOWN: usize = 120;

/// Index and unit of a column that is read.
#[derive(Clone, Copy, Debug)]
struct Column {
    place: usize,
    unit: Unit,
}

/// Indices of the columns that are read; `None` where the file lacks one.
pub struct Columns {
    pub count: usize,
    names: Vec<String>,
    ghi: Option<Column>,
    dni: Option<Column>,
    dhi: Option<Column>,
    /// Direct irradiance on the horizontal, where GHI is given only as a sum of two parts.
    beam: Option<Column>,
    albedo: Option<Column>,
    snow: Option<Column>,
    dry_bulb: Option<Column>,
    dew_point: Option<Column>,
    humidity: Option<Column>,
    infrared: Option<Column>,
    opaque_sky: Option<Column>,
    wind: Option<Column>,
    zenith: Option<Column>,
    altitude: Option<Column>,
    /// True if light is given at moments only.
    pub instants: bool,
}

/// Numbers outside their limits, counted by column.
#[derive(Clone, Debug, Default)]
pub struct OutOfRange {
    columns: Vec<OddColumn>,
}

/// A column with numbers outside their limits.
#[derive(Clone, Debug)]
struct OddColumn {
    place: usize,
    rows: usize,
    /// Line of the first of them.
    line: usize,
    /// Text of the first of them.
    text: String,
}

impl OutOfRange {
    fn add(&mut self, place: usize, cells: &Cells) {
        match self.columns.iter_mut().find(|column| column.place == place) {
            Some(column) => column.rows += 1,
            None => {
                self.columns.push(OddColumn { place, rows: 1, line: cells.line, text: cells.text(place).into_owned() })
            }
        }
    }
}

/// A column that may hold a quantity.
struct Candidate<'h> {
    place: usize,
    name: &'h str,
    found: NameMatch,
}

impl Columns {
    /// Finds the columns. `warnings` gets sentences on columns that are left out; those of air are
    /// mentioned only if `with_air`.
    pub fn read(path: &Path, head: &Head, with_air: bool, warnings: &mut Vec<Message>) -> Result<Self> {
        let mut find = |quantity: Quantity| match find(path, head, quantity) {
            Err(_) if quantity.is_of_air() && !with_air => Ok(None),
            // Few replays need the ground's columns, so a bad one is only left out.
            Err(error) if quantity.is_of_ground() => {
                let told = error.to_string().replace("\n  to fix: ", ", and the column is left out: ");
                warnings.push(told.into());
                Ok(None)
            }
            found => found,
        };
        let mut columns = Columns {
            count: head.names.len(),
            ghi: find(Quantity::Ghi)?,
            dni: find(Quantity::Dni)?,
            dhi: find(Quantity::Dhi)?,
            beam: find(Quantity::Beam)?,
            albedo: find(Quantity::Albedo)?,
            snow: find(Quantity::Snow)?,
            dry_bulb: find(Quantity::DryBulb)?,
            dew_point: find(Quantity::DewPoint)?,
            humidity: find(Quantity::Humidity)?,
            infrared: find(Quantity::Infrared)?,
            opaque_sky: find(Quantity::OpaqueSky)?,
            wind: find(Quantity::Wind)?,
            zenith: find(Quantity::Zenith).unwrap_or_default(),
            altitude: find(Quantity::Altitude).unwrap_or_default(),
            names: head.names.clone(),
            instants: false,
        };
        // Alone, `dir` may be that of the wind and `sid` the number of a station.
        let has =
            |known: &[&str]| head.names.iter().any(|name| known.iter().any(|known| squash(name).starts_with(known)));
        let is = |column: &Column, name: &str| head.names.get(column.place).is_some_and(|found| squash(found) == name);
        columns.dni = columns.dni.filter(|column| !is(column, "dir") || has(&["swd", "dif"]));
        columns.beam = columns.beam.filter(|column| !is(column, "sid") || has(&["sis"]));
        // `Direct radiation [W/m**2]` of BSRN is normal; with other units the name is that of
        // Open-Meteo.
        if columns.dni.is_none() && columns.beam.is_some_and(|beam| columns.name(beam.place).contains("m**2")) {
            columns.dni = columns.beam.take();
        }
        let light = [columns.ghi, columns.dni, columns.dhi];
        if light.iter().all(Option::is_none) {
            columns.take_inclined(path, head)?;
        }
        let is_instant = |column: &Column| columns.name(column.place).to_lowercase().contains("instant");
        columns.instants = light.iter().flatten().all(is_instant) && light.iter().any(Option::is_some);
        Ok(columns)
    }

    /// Takes the irradiances of an inclined plane if the plane is horizontal; any other plane is
    /// refused.
    fn take_inclined(&mut self, path: &Path, head: &Head) -> Result<()> {
        let place = |wanted: &str| {
            let place = head.names.iter().position(|name| squash(name) == wanted);
            place.map(|place| Column { place, unit: Unit::PLAIN })
        };
        let (beam, diffuse, global) = (place(BEAM_INCLINED), place(DIFFUSE_INCLINED), place(GLOBAL_INCLINED));
        let known = "ghi, dni and dhi, or G(h), Gb(n) and Gd(h)";
        if beam.or(diffuse).or(global).is_none() {
            let what = format!("no column of light among `{}`", excerpt(&head.names.join(","), NAMES_SHOWN));
            let hint =
                format!("give an EPW, TMY3 or SURFRAD file, or a CSV with a line of names: a time and some of {known}");
            return Err(Error::input(path, head.line_of_names(), what, hint));
        }
        if head.slope_deg != Some(0.0) {
            let slope =
                head.slope_deg.map_or("an inclined plane".into(), |slope| format!("a plane of slope {slope} degrees"));
            let what =
                format!("the irradiances are those of {slope}, from which those of other planes cannot be computed");
            let hint = "ask PVGIS for hourly data of slope 0 with radiation components (angle=0&components=1), or for a typical year \
                        (TMY)";
            return Err(Error::input(path, head.line_of_names(), what, hint));
        }
        (self.beam, self.dhi, self.ghi) = (beam.filter(|_| diffuse.is_some()), diffuse, global);
        Ok(())
    }

    /// Returns the name of a column in the file.
    pub fn name(&self, place: usize) -> &str {
        self.names.get(place).map_or("", String::as_str)
    }

    /// Returns true if GHI, DNI and DHI are all given, so that the closure check can test the sun's
    /// position.
    pub fn has_all_light(&self) -> bool {
        [self.ghi, self.dni, self.dhi].iter().all(Option::is_some)
    }

    /// Returns true if GHI, or DHI with direct light, is given. Other layouts lack a part of the
    /// light.
    fn has_total(&self) -> bool {
        self.ghi.is_some() || self.dhi.is_some() && self.dni.or(self.beam).is_some()
    }

    /// Refuses a layout that gives no total light beside columns that are not read: one of them may
    /// hold the rest. Returns a sentence on these columns if a part of the light must be estimated.
    pub fn check_unread(&self, path: &Path, head: &Head, is_time: impl Fn(usize) -> bool) -> Result<Option<String>> {
        let light = [self.ghi, self.dni, self.dhi, self.beam];
        let is_known = |name: &String| Quantity::ALL.iter().any(|quantity| match_name(name, *quantity).is_some());
        let lower = |name: &String| name.to_lowercase();
        let is_other = |name: &String| OTHER_THINGS.iter().any(|word| lower(name).contains(word));
        let unread: Vec<String> = self
            .names
            .iter()
            .enumerate()
            .filter(|(place, name)| !name.is_empty() && !is_time(*place) && !is_known(name) && !is_other(name))
            .map(|(_, name)| format!("`{}`", excerpt(name, SHOWN)))
            .collect();
        let read: Vec<String> =
            light.iter().flatten().map(|column| format!("`{}`", excerpt(self.name(column.place), SHOWN))).collect();
        let shown = |all: &[String]| {
            let more = all.len().saturating_sub(UNREAD_SHOWN);
            let first = all.get(..UNREAD_SHOWN).unwrap_or(all).join(", ");
            if more > 0 { format!("{first} and {more} more") } else { first }
        };
        if unread.is_empty() {
            return Ok(None);
        }
        if !self.has_total() {
            let what = format!(
                "the columns of light that are read, {}, give no total, and {} are not read",
                shown(&read),
                shown(&unread)
            );
            let hint = "name columns of light ghi, dni (direct normal), dhi or bhi (direct horizontal), or take columns \
                        without light out of the file";
            return Err(Error::input(path, head.line_of_names(), what, hint));
        }
        let is_split = self.dni.is_none() && self.dhi.is_none() && self.beam.is_none();
        Ok(is_split.then(|| {
            format!(
                "{}: only {} is read of the light; columns that are not read: {}; name them dni, dhi or bhi if they \
                 hold light",
                path.display(),
                shown(&read),
                shown(&unread)
            )
        }))
    }

    /// Returns the zenith angle of the sun in a row, degrees.
    pub fn zenith_deg(&self, cells: &Cells) -> Option<f64> {
        let of = |column: Option<Column>| column.and_then(|column| cells.number(column.place));
        of(self.zenith).or_else(|| of(self.altitude).map(|altitude| 90.0 - altitude))
    }

    /// Returns the name of the column of direct horizontal irradiance.
    pub fn beam_name(&self) -> Option<&str> {
        self.beam.map(|column| self.name(column.place))
    }

    /// Returns true if a column gives the height of the sun.
    pub fn has_zenith(&self) -> bool {
        self.zenith.or(self.altitude).is_some()
    }

    /// Returns direct horizontal irradiance and GHI of a row if DHI is their difference.
    pub fn beam_and_ghi(&self, cells: &Cells) -> Option<(f64, f64)> {
        let (ghi, beam) = self.ghi.zip(self.beam).filter(|_| self.dhi.is_none() && alike(self.ghi, self.beam))?;
        let number = |column: Column| cells.number(column.place).map(|value| column.unit.of(value));
        Some((number(beam)?, number(ghi)?))
    }

    /// Returns true if light is given as energy of an interval, so that [`Columns::to_watts`] is
    /// needed.
    pub fn has_energies(&self) -> bool {
        let all = [self.ghi, self.dni, self.dhi, self.beam, self.infrared];
        all.iter().flatten().any(|column| column.unit.per_interval)
    }

    /// Returns light and ground of a row; its interval is set later. Energies are in J/m2 until
    /// [`Columns::to_watts`].
    pub fn row(&self, cells: &Cells, odd: &mut OutOfRange) -> Result<RawRow> {
        let mut negative = false;
        let mut light = |column: Option<Column>| self.light(cells, column, &mut negative);
        let (ghi, dni, dhi) = (light(self.ghi)?, light(self.dni)?, light(self.dhi)?);
        let beam = light(self.beam)?;
        let sum = beam.zip(dhi).filter(|_| alike(self.beam, self.dhi)).map(|(beam, dhi)| beam + dhi);
        let rest = || ghi.zip(beam).filter(|_| alike(self.ghi, self.beam)).map(|(ghi, beam)| (ghi - beam).max(0.0));
        let rest = || self.dhi.is_none().then(rest).flatten();
        let albedo = self.number(cells, self.albedo, [0.0, 1.0], odd).filter(|albedo| *albedo > 0.0);
        let snow_depth_cm = self.number(cells, self.snow, [0.0, MISSING_SNOW_CM - 0.5], odd);
        Ok(RawRow {
            line: cells.line,
            interval: NO_INTERVAL,
            ghi: ghi.or(sum),
            dni,
            dhi: dhi.or_else(rest),
            negative,
            albedo,
            snow_depth_cm,
        })
    }

    fn light(&self, cells: &Cells, column: Option<Column>, negative: &mut bool) -> Result<Option<f64>> {
        let Some(Column { place, unit }) = column else { return Ok(None) };
        let in_watts = unit == Unit::PLAIN;
        let Some(value) = cells.light(place, self.name(place), in_watts)? else { return Ok(None) };
        if unit.per_interval {
            return Ok(Some(unit.of(value)));
        }
        let hint = "write W/m2 from 0 up, with a decimal point; leave the cell empty where missing";
        irradiance_of(unit.of(value), negative).ok_or_else(|| cells.bad(place, self.name(place), hint)).map(Some)
    }

    /// Converts energies to W/m2, once the length of an interval is known.
    pub fn to_watts(&self, path: &Path, row: &mut RawRow, step_s: f64) -> Result<()> {
        let line = row.line;
        for (value, column) in [(&mut row.ghi, self.ghi), (&mut row.dni, self.dni), (&mut row.dhi, self.dhi)] {
            // A sum of two parts has the unit of the parts.
            let column = column.or(self.beam);
            let Some(Column { place, .. }) = column.filter(|column| column.unit.per_interval) else { continue };
            let Some(joules) = *value else { continue };
            let watts = irradiance_of(joules / step_s, &mut row.negative).ok_or_else(|| {
                let what = format!("column `{}` holds {} W/m2", excerpt(self.name(place), SHOWN), joules / step_s);
                Error::input(path, line, what, "write energies from 0 up; leave the cell empty where missing")
            })?;
            *value = Some(watts).filter(|watts| *watts < MISSING_RADIATION);
        }
        Ok(())
    }

    /// Converts the energy of infrared radiation to W/m2, once the length of an interval is known.
    pub fn air_to_watts(&self, air: &mut Air, step_s: f64) {
        if self.infrared.is_some_and(|column| column.unit.per_interval) {
            let watts = air.infrared_w_m2.map(|joules| joules / step_s);
            air.infrared_w_m2 = watts.filter(|watts| (1.0..=MAX_INFRARED_W_M2).contains(watts));
        }
    }

    /// Returns the air of a row.
    pub fn air(&self, cells: &Cells, odd: &mut OutOfRange) -> Air {
        let dry_bulb_c = self.number(cells, self.dry_bulb, AIR_C, odd);
        let dew_c = self.number(cells, self.dew_point, AIR_C, odd);
        let humidity = self.number(cells, self.humidity, [0.1, 100.0], &mut OutOfRange::default());
        let infrared = match self.infrared.is_some_and(|column| column.unit.per_interval) {
            true => [0.0, f64::MAX],
            false => [1.0, MAX_INFRARED_W_M2],
        };
        let nothing = &mut OutOfRange::default();
        Air {
            dry_bulb_c,
            dew_point_c: dew_c
                .or_else(|| Some(dew_point_c(dry_bulb_c?, humidity?)))
                .filter(|dew| (AIR_C[0]..=AIR_C[1]).contains(dew)),
            infrared_w_m2: self.number(cells, self.infrared, infrared, nothing),
            opaque_sky_tenths: self.number(cells, self.opaque_sky, [0.0, 10.0], nothing),
            wind_m_s: self.number(cells, self.wind, WIND_M_S, nothing),
        }
    }

    /// Returns a number of a column within limits. A number outside that is no code for missing is
    /// counted.
    fn number(&self, cells: &Cells, column: Option<Column>, limits: [f64; 2], odd: &mut OutOfRange) -> Option<f64> {
        let Column { place, unit } = column?;
        let number = cells.number(place)?;
        let value = unit.of(number);
        let inside = (limits[0]..=limits[1]).contains(&value);
        // EPW files write 99, 99.9 and 999 for missing; -1 is in use, too.
        let code =
            is_code(&cells.text(place)) || number < -90.0 || number == -1.0 || [99.0, 99.9, 999.0].contains(&number);
        if !inside && !code && number.is_finite() {
            odd.add(place, cells);
        }
        Some(value).filter(|_| inside)
    }

    /// Returns one sentence for each column with numbers outside their limits.
    pub fn odd_numbers(&self, path: &Path, odd: &OutOfRange) -> Vec<String> {
        odd.columns.iter().map(|column| self.odd_column(path, column)).collect()
    }

    fn odd_column(&self, path: &Path, odd: &OddColumn) -> String {
        let OddColumn { place, rows, line, text } = odd;
        let name = excerpt(self.name(*place), SHOWN);
        let [quantity, range, example] = if self.albedo.is_some_and(|column| column.place == *place) {
            ["albedo", "0 to 1", "(%)"]
        } else if self.snow.is_some_and(|column| column.place == *place) {
            ["snow depth", "0 to 998 cm", "(mm)"]
        } else {
            ["air", "-90 to 70 degrees Celsius", "(K)"]
        };
        format!(
            "{}, line {line} and on: {rows} values of `{name}`, the first `{}`, lie outside {range} and are left \
             out; state the unit in the name, such as `{quantity} {example}`",
            path.display(),
            excerpt(text, SHOWN)
        )
    }
}

/// Returns true if the two are powers or the two are energies, so that they can be added.
fn alike(one: Option<Column>, two: Option<Column>) -> bool {
    one.map(|column| column.unit.per_interval) == two.map(|column| column.unit.per_interval)
}

/// Largest infrared radiation, W/m2. A sky as warm as the hottest air sends 786 W/m2.
const MAX_INFRARED_W_M2: f64 = 800.0;

/// Placeholder for an interval while the step is not yet known.
const NO_INTERVAL: Interval = Interval { date: Date::OF_DAY_0, start_min: 0.0, end_min: 0.0 };

/// Returns the column of a quantity, by the most usual of its names. For light, two columns of
/// usual names are refused.
fn find(path: &Path, head: &Head, quantity: Quantity) -> Result<Option<Column>> {
    let named = head.names.iter().enumerate();
    let mut all: Vec<Candidate> =
        named.filter_map(|(place, name)| Some(Candidate { place, name, found: match_name(name, quantity)? })).collect();
    // Means come before values at a moment, then the more usual name, then the first column.
    all.sort_by_key(|candidate| (candidate.found.instant, candidate.found.rank, candidate.place));
    let usual = |candidate: &&Candidate| candidate.found.rank < quantity.usual_names() && !candidate.found.instant;
    let mut twins: Vec<&Candidate> = all.iter().filter(usual).collect();
    twins.sort_by_key(|candidate| candidate.place);
    if let [one, two, ..] = twins.as_slice() {
        let what = format!(
            "columns `{}` and `{}` are both {}",
            excerpt(one.name, SHOWN),
            excerpt(two.name, SHOWN),
            quantity.word()
        );
        return Err(Error::input(path, head.line_of_names(), what, "keep one of the two"));
    }
    let Some(Candidate { place, name, found }) = all.into_iter().next() else { return Ok(None) };
    let stated = head.units.get(place).map(String::as_str).unwrap_or_default();
    let unit = match found.unit {
        StatedUnit::Known(unit) => unit,
        StatedUnit::Unknown(text) => return Err(unknown_unit(path, head, quantity, name, &text)),
        StatedUnit::Silent if stated.is_empty() => head.usual_unit(quantity),
        StatedUnit::Silent => match parse_unit(stated, quantity.measure()) {
            Some(unit) => unit,
            None if !looks_like_unit(stated) && head.units_are_loose => head.usual_unit(quantity),
            None => return Err(unknown_unit(path, head, quantity, name, stated)),
        },
    };
    Ok(Some(Column { place, unit }))
}

fn unknown_unit(path: &Path, head: &Head, quantity: Quantity, name: &str, unit: &str) -> Error {
    let what = format!("the unit `{}` of column `{}` is not known", excerpt(unit, SHOWN), excerpt(name, SHOWN));
    Error::input(path, head.line_of_names(), what, format!("give {} in {}", quantity.word(), quantity.units()))
}
