//! Which column is what. In: a line of names. Out: places of the columns that are read, and rows by them.

use std::path::Path;

use crate::error::{Error, Result};
use crate::weather::air::{Air, dew_point_c};
use crate::weather::formats::stamp_text::parse_stamp;
use crate::weather::formats::weather_csv::cells::Cells;
use crate::weather::formats::weather_csv::head::{Head, Kind};
use crate::weather::judging::raw_weather::{AIR_C, RawRow};
use crate::weather::time::calendar::Date;
use crate::weather::time::sun::Interval;

/// Names of the columns of each quantity, in lower case, without the unit that may stand behind them.
const GHI: &[&str] = &["ghi", "g(h)", "global_horizontal_irradiance", "global_horizontal_radiation"];
const DNI: &[&str] =
    &["dni", "gb(n)", "bn", "direct_normal_irradiance", "direct_normal_radiation", "beam_normal_irradiance"];
const DHI: &[&str] =
    &["dhi", "gd(h)", "diffuse_horizontal_irradiance", "diffuse_horizontal_radiation", "diffuse_irradiance"];
const ALBEDO: &[&str] = &["albedo", "surface_albedo", "alb"];
const SNOW_CM: &[&str] = &["snow_depth", "snow_depth_cm"];
const DRY_BULB: &[&str] = &[
    "temp_air",
    "temperature",
    "air_temperature",
    "dry_bulb",
    "dry_bulb_temperature",
    "drybulb",
    "t2m",
    "temp",
    "tamb",
];
const DEW_POINT: &[&str] = &["temp_dew", "dew_point", "dewpoint", "dew_point_temperature", "temperature_dew_point"];
const HUMIDITY: &[&str] = &["relative_humidity", "rh", "humidity"];
const INFRARED: &[&str] =
    &["longwave_down", "ir(h)", "lwd", "dw_ir", "lw_in", "horizontal_infrared_radiation", "infrared"];
const OPAQUE_SKY: &[&str] = &["opaque_sky_cover", "opqcld", "opaque_cloud_cover"];
const TIME: &[&str] =
    &["time", "timestamp", "datetime", "date_time", "date", "time(utc)", "time_utc", "timestamp_utc", "datetime_utc"];

/// Light on an inclined plane: of no use unless it lies flat.
const BEAM_INCLINED: &str = "gb(i)";
const DIFFUSE_INCLINED: &str = "gd(i)";
const GLOBAL_INCLINED: &str = "g(i)";

const MISSING_SNOW_CM: f64 = 999.0;

/// Where the time stamp stands.
pub enum StampColumns {
    Text { place: usize, utc: bool },
    Parts { year: usize, month: usize, day: usize, hour: Option<usize>, minute: Option<usize> },
}

/// Places of the columns that are read; `None` where the file has none.
pub struct Columns {
    pub stamp: StampColumns,
    pub count: usize,
    names: Vec<String>,
    ghi: Option<usize>,
    dni: Option<usize>,
    dhi: Option<usize>,
    /// The direct part on the horizontal, where GHI is only given as a sum of two.
    beam: Option<usize>,
    albedo: Option<usize>,
    snow_cm: Option<usize>,
    dry_bulb: Option<usize>,
    dew_point: Option<usize>,
    humidity: Option<usize>,
    infrared: Option<usize>,
    opaque_sky: Option<usize>,
}

/// `Dew Point`, `dew_point`, `Dew-point (C)`, `dew_point_deg_c` are one name; `G(h)` keeps what stands in brackets.
fn plain(name: &str) -> String {
    let lower = name.to_lowercase().replace([' ', '-'], "_");
    let bare = lower.split("_(").next().unwrap_or_default().split('[').next().unwrap_or_default();
    let bare = UNITS.iter().find_map(|unit| bare.strip_suffix(unit)).unwrap_or(bare);
    bare.trim_end_matches('_').to_owned()
}

/// What may stand behind a name.
const UNITS: [&str; 6] = ["_w_m2", "_w/m2", "_wm2", "_deg_c", "_degc", "_percent"];

impl Columns {
    pub fn read(path: &Path, head: &Head) -> Result<Self> {
        let names: Vec<String> = head.names.iter().map(|name| plain(name)).collect();
        let find = |wanted: &[&str]| {
            // Earlier names are the more usual ones.
            wanted.iter().find_map(|name| names.iter().position(|found| found == name))
        };
        let light = |wanted: &[&str], what: &str| -> Result<Option<usize>> {
            let mut found = names.iter().zip(&head.names).filter(|(name, _)| wanted.contains(&name.as_str()));
            let first = find(wanted);
            match (found.next(), found.next()) {
                (Some((_, one)), Some((_, two))) => {
                    let what = format!("columns `{one}` and `{two}` are both {what}");
                    Err(Error::input(path, head.lines, what, "keep one of the two"))
                }
                _ => Ok(first),
            }
        };
        let mut columns = Columns {
            stamp: stamp_columns(path, head, &names)?,
            count: names.len(),
            ghi: light(GHI, "GHI")?,
            dni: light(DNI, "DNI")?,
            dhi: light(DHI, "DHI")?,
            beam: None,
            albedo: find(ALBEDO),
            snow_cm: find(SNOW_CM),
            dry_bulb: find(DRY_BULB),
            dew_point: find(DEW_POINT),
            humidity: find(HUMIDITY),
            infrared: find(INFRARED),
            opaque_sky: find(OPAQUE_SKY),
            names: head.names.clone(),
        };
        if [columns.ghi, columns.dni, columns.dhi].iter().all(Option::is_none) {
            columns.take_inclined(path, head, &names)?;
        }
        Ok(columns)
    }

    /// Irradiances of a plane that lies flat; of any other they are refused.
    fn take_inclined(&mut self, path: &Path, head: &Head, names: &[String]) -> Result<()> {
        let place = |wanted: &str| names.iter().position(|name| name == wanted);
        let (beam, diffuse, global) = (place(BEAM_INCLINED), place(DIFFUSE_INCLINED), place(GLOBAL_INCLINED));
        let known = "ghi, dni and dhi, or G(h), Gb(n) and Gd(h)";
        if beam.or(diffuse).or(global).is_none() {
            let what = format!("no column of light among `{}`", head.names.join(","));
            let hint =
                format!("give an EPW, TMY3 or SURFRAD file, or a CSV with a line of names: a time and some of {known}");
            return Err(Error::input(path, head.lines, what, hint));
        }
        if head.slope_deg != Some(0.0) {
            let slope =
                head.slope_deg.map_or("an inclined plane".into(), |slope| format!("a plane of slope {slope} degrees"));
            let what = format!("the irradiances are those of {slope}, from which those of others cannot be told");
            let hint = "ask PVGIS for hourly data of slope 0 with radiation components (angle=0&components=1), or for a typical year \
                        (TMY)";
            return Err(Error::input(path, head.lines, what, hint));
        }
        (self.beam, self.dhi, self.ghi) = (beam.filter(|_| diffuse.is_some()), diffuse, global);
        Ok(())
    }

    /// The name of a column as it stands in the file.
    pub fn name(&self, place: usize) -> &str {
        self.names.get(place).map_or("", String::as_str)
    }

    /// Light and ground of a row, its interval still to come.
    pub fn row(&self, cells: &Cells) -> Result<RawRow> {
        let mut negative = false;
        let mut light = |place: Option<usize>| match place {
            Some(place) => cells.light(place, self.name(place), &mut negative),
            None => Ok(None),
        };
        let (ghi, dni, dhi) = (light(self.ghi)?, light(self.dni)?, light(self.dhi)?);
        let beam = light(self.beam)?;
        let sum = beam.zip(dhi).map(|(beam, dhi)| beam + dhi);
        Ok(RawRow {
            line: cells.line,
            interval: NO_INTERVAL,
            ghi: ghi.or(sum),
            dni,
            dhi,
            negative,
            albedo: cells.number(self.albedo, [0.0, 1.0]).filter(|albedo| *albedo > 0.0),
            snow_depth_cm: cells.number(self.snow_cm, [0.0, MISSING_SNOW_CM - 0.5]),
        })
    }

    /// The air of a row.
    pub fn air(&self, cells: &Cells) -> Air {
        let dry_bulb_c = cells.number(self.dry_bulb, AIR_C);
        let humidity = || cells.number(self.humidity, [0.1, 100.0]);
        Air {
            dry_bulb_c,
            dew_point_c: cells
                .number(self.dew_point, AIR_C)
                .or_else(|| Some(dew_point_c(dry_bulb_c?, humidity()?)))
                .filter(|dew| (AIR_C[0]..=AIR_C[1]).contains(dew)),
            infrared_w_m2: cells.number(self.infrared, [1.0, MOST_INFRARED_W_M2]),
            opaque_sky_tenths: cells.number(self.opaque_sky, [0.0, 10.0]),
        }
    }
}

/// A sky as warm as the hottest air sends 786 W/m2.
const MOST_INFRARED_W_M2: f64 = 800.0;

/// Stands where the step is not yet known.
const NO_INTERVAL: Interval = Interval { date: Date::OF_DAY_0, start_min: 0.0, end_min: 0.0 };

/// A column with a name for it, else the first one if it holds time stamps, else year, month, day, hour and minute.
fn stamp_columns(path: &Path, head: &Head, names: &[String]) -> Result<StampColumns> {
    let place = |wanted: &str| names.iter().position(|name| name == wanted);
    if let Some(place) = TIME.iter().find_map(|name| place(name)) {
        let utc =
            head.kind == Kind::Pvgis || head.names.get(place).is_some_and(|name| name.to_lowercase().contains("utc"));
        return Ok(StampColumns::Text { place, utc });
    }
    if parse_stamp(&head.first_cell).is_some() {
        return Ok(StampColumns::Text { place: 0, utc: false });
    }
    if let (Some(year), Some(month), Some(day)) = (place("year"), place("month"), place("day")) {
        return Ok(StampColumns::Parts { year, month, day, hour: place("hour"), minute: place("minute") });
    }
    let what = format!("no column of time among `{}`", head.names.join(","));
    let hint = "name one `time`, such as 2021-06-01T12:30+01:00, or give year, month, day, hour and minute";
    Err(Error::input(path, head.lines, what, hint))
}
