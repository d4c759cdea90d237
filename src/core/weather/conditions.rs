//! Conditions: sun and sky of one result row. In: `conditions.csv`. Out: checked [`Condition`]s.
//!
//! A query row is one condition with one sun. A replay hour is one condition with the suns of its
//! sub-steps (see `heliotile_weather::series`). The mean over the interval of the sun on a surface
//! is DNI x sum of weight x cos over the suns.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::dome::series::PatchRow;
use crate::error::{Error, Problem, Result};
use crate::site::bands::SourceScale;
use crate::site::north::North;
use crate::text::{Message, message, separator_hint};
use crate::units::direction_from_degrees;
use crate::weather::air::Air;
use crate::weather::emission::Emission;
use crate::weather::time::calendar::Date;
use crate::weather::time::sun::SOLAR_CONSTANT_W_M2;

/// One position of the sun in a condition. Its axes are true east, true north and up in new
/// conditions, and those of a site after [`Condition::in_axes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Unit vector towards the centre of the sun, above the horizon (z > 0): suns below it are not
    /// listed.
    pub sun: DVec3,
    /// Share of the condition's direct energy that comes from this position; the weights of a
    /// condition sum to 1.
    pub weight: f64,
    /// Share of the light of the sun's disc that clouds let through ([`Condition::clouds`]): 1
    /// without them.
    pub unclouded: f64,
}

impl Instant {
    /// Returns the share of the condition's direct energy that comes from this position and passes
    /// the clouds.
    pub fn lit(&self) -> f64 {
        self.weight * self.unclouded
    }
}

/// Date and interval of a replay condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// Date of the row; months of a typical year come from different years.
    pub date: Date,
    /// Start of the interval, minutes after local midnight.
    pub start_min: f64,
    /// Length of the interval, hours.
    pub hours: f64,
}

/// Sun and sky of one result row.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Name of the row in the results: the `condition` of a query, the start of the interval of a
    /// replay.
    pub label: String,
    /// Positions of the sun; empty when the sun is down the whole time: the sun parts are then
    /// zero.
    pub suns: Vec<Instant>,
    /// Sun position that the sky's radiance distribution is built on: unit, z >= 0. It is the
    /// normalised mean of the suns or, without any, the sun's azimuth at altitude 0.
    pub sky_sun: DVec3,
    /// Direct normal irradiance, W/m2, mean over the interval, also where the sun is up for a part
    /// of it only.
    pub dni_w_m2: f64,
    /// Diffuse irradiance on an open horizontal surface, W/m2, mean over the interval.
    pub dhi_w_m2: f64,
    /// Normal irradiance outside the atmosphere, W/m2, which Perez' sky brightness is relative to:
    /// the solar constant in a query, the value of the day in a replay.
    pub extraterrestrial_w_m2: f64,
    /// Date and interval, in a replay only.
    pub stamp: Option<Stamp>,
    /// Longwave emission, where results need it.
    pub emission: Option<Emission>,
    /// Air of the hour, where the weather was read with it.
    pub air: Option<Air>,
    /// Radiances of the sky's patches where a file gives them in place of a model. They are scaled
    /// to DHI, so only their ratios count.
    pub own_sky: Option<PatchRow>,
    /// Transmittances of clouds before the sky, by patch; the suns' shares are in
    /// [`Instant::unclouded`].
    pub clouds: Option<PatchRow>,
    /// Factors of the light of the sun and of the sky in results: shares of a band, or another
    /// unit. The distribution of the sky's light follows from the irradiances without them.
    pub scale: SourceScale,
}

impl Condition {
    /// Returns an error if the direction of a sun is not a unit vector above the horizon, or an
    /// irradiance is negative, too large or not a number.
    pub fn check(&self) -> Result<()> {
        let refuse = |what: String, hint: &'static str| {
            Err(Error::argument("conditions", format!("condition `{}`: {what}", self.label), hint))
        };
        let unit = |direction: DVec3| (direction.length() - 1.0).abs() < 1e-6;
        if let Some(wrong) = self.suns.iter().find(|instant| !unit(instant.sun) || instant.sun.z <= 0.0) {
            let what = format!("the sun's direction is {}", wrong.sun);
            return refuse(what, "give a unit vector above the horizon, x east, y true north, z up");
        }
        for (name, value) in [("DNI", self.dni_w_m2), ("DHI", self.dhi_w_m2)] {
            if !(0.0..=MAX_IRRADIANCE_W_M2).contains(&value) {
                let what = format!("{name} is {value} W/m2");
                return refuse(what, "give a number from 0 to 1000000");
            }
        }
        if unit(self.sky_sun) { Ok(()) } else { refuse(format!("`sky_sun` is {}", self.sky_sun), "give a unit vector") }
    }

    /// Returns a condition with equally weighted suns (those above the horizon); `below` is the
    /// sun's direction if there is none. Directions are unit vectors, x east, y true north, z up.
    pub fn new(label: String, suns: &[DVec3], below: DVec3, dni_w_m2: f64, dhi_w_m2: f64) -> Self {
        let up: Vec<DVec3> = suns.iter().copied().filter(|s| s.z > 0.0).collect();
        let weight = 1.0 / up.len().max(1) as f64;
        let sky_sun = match up.iter().sum::<DVec3>().try_normalize() {
            Some(mean) if mean.z > 0.0 => mean,
            _ => on_horizon(below),
        };
        Condition {
            label,
            suns: up.into_iter().map(|sun| Instant { sun, weight, unclouded: 1.0 }).collect(),
            sky_sun,
            dni_w_m2,
            dhi_w_m2,
            extraterrestrial_w_m2: SOLAR_CONSTANT_W_M2,
            stamp: None,
            emission: None,
            air: None,
            own_sky: None,
            clouds: None,
            scale: SourceScale::WHOLE,
        }
    }

    /// Returns the condition with its suns and patches turned from true north into the axes of a
    /// site. Nowhere else are they turned.
    pub fn in_axes(mut self, north: North) -> Self {
        self.suns.iter_mut().for_each(|instant| instant.sun = north.to_axes(instant.sun));
        self.sky_sun = north.to_axes(self.sky_sun);
        let turned = |row: PatchRow| row.turned(north.y_deg());
        self.own_sky = self.own_sky.map(turned);
        self.clouds = self.clouds.map(turned);
        self
    }
}

/// Returns conditions, whose suns refer to true north, in the axes of a site.
pub fn in_axes(conditions: &[Condition], north: North) -> Cow<'_, [Condition]> {
    if north.is_y() {
        return Cow::Borrowed(conditions);
    }
    Cow::Owned(conditions.iter().map(|condition| condition.clone().in_axes(north)).collect())
}

/// Returns the direction with its altitude set to 0; north for a vertical one.
fn on_horizon(direction: DVec3) -> DVec3 {
    DVec3::new(direction.x, direction.y, 0.0).try_normalize().unwrap_or(DVec3::Y)
}

/// Conditions of a query, with warnings for the user.
#[derive(Debug)]
pub struct ConditionsFile {
    /// Conditions in the order of the file, at least one.
    pub conditions: Vec<Condition>,
    /// Sentences for the user, each naming file and line.
    pub warnings: Vec<Message>,
}

/// The columns of `conditions.csv`, in any order; further columns are ignored.
const COLUMNS: [&str; 5] = ["condition", "sun_azimuth_deg", "sun_altitude_deg", "dni_w_m2", "dhi_w_m2"];

/// Largest irradiance, W/m2. No irradiance on Earth comes near, so a larger number is a mistake of
/// units or of columns.
const MAX_IRRADIANCE_W_M2: f64 = 1e6;

/// Reads and checks the bytes of `conditions.csv` (UTF-8, with or without byte order mark, any line
/// ending); messages call it `path`.
pub fn parse_conditions(path: &Path, bytes: &[u8]) -> Result<ConditionsFile> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(bytes);
    let header = reader.headers().map_err(|e| csv_error(path, &e))?.clone();
    let mut place = [0; COLUMNS.len()];
    for (slot, name) in place.iter_mut().zip(COLUMNS) {
        let mut found = header.iter().enumerate().filter(|(_, cell)| *cell == name);
        *slot = match (found.next(), found.next()) {
            (Some((i, _)), None) => i,
            (None, _) => {
                let what = format!("column `{name}` is missing from the header");
                let hint = separator_hint(&header.iter().collect::<Vec<_>>().join(",")).map(str::to_owned);
                let hint = hint.unwrap_or_else(|| format!("the first line names the columns {}", COLUMNS.join(",")));
                return Err(Error::input(path, 1, what, hint).because(Problem::no_column(name)));
            }
            (Some(_), Some(_)) => {
                let what = format!("column `{name}` appears twice in the header");
                return Err(Error::input(path, 1, what, "keep one of the two").because(Problem::duplicate(name)));
            }
        };
    }
    let mut conditions = Vec::new();
    let mut warnings = Vec::new();
    let mut line_of_name: HashMap<String, usize> = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| csv_error(path, &e))?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        let [name, numbers @ ..] = place.map(|i| record.get(i).unwrap_or_default());
        if name.is_empty() {
            let hint = "give every row a name in the column `condition`";
            return Err(Error::input(path, line, "the condition has no name", hint));
        }
        if let Some(first) = line_of_name.insert(name.to_string(), line) {
            let what = format!("condition `{name}` was already on line {first}");
            return Err(Error::input(path, line, what, "give every row its own name").because(Problem::duplicate(name)));
        }
        let mut values = [0.0; 4];
        let limits = [(-360.0, 360.0), (-90.0, 90.0), (0.0, MAX_IRRADIANCE_W_M2), (0.0, MAX_IRRADIANCE_W_M2)];
        let cells = values.iter_mut().zip(COLUMNS.into_iter().skip(1));
        for (((value, column), text), (low, high)) in cells.zip(numbers).zip(limits) {
            *value = match text.parse::<f64>() {
                Ok(number) if (low..=high).contains(&number) => number,
                _ => {
                    let what = format!("column `{column}` holds `{text}`");
                    let hint = format!("write a number from {low} to {high}");
                    return Err(Error::input(path, line, what, hint).because(Problem::value(column, text)));
                }
            };
        }
        let [azimuth_deg, altitude_deg, dni_w_m2, dhi_w_m2] = values;
        if altitude_deg <= 0.0 && dni_w_m2 > 0.0 {
            warnings.push(message!(
                "{}, line {line}: condition `{name}` has a DNI of {dni_w_m2} W/m2 with the sun at {altitude_deg} deg, not \
                 above the horizon: its components from the sun are zero",
                path.display()
            ));
        }
        let sun = direction_from_degrees(azimuth_deg, altitude_deg);
        // At altitude 0 the sine may round to above 0.
        let suns: &[DVec3] = if altitude_deg > 0.0 { &[sun] } else { &[] };
        conditions.push(Condition::new(name.to_string(), suns, sun, dni_w_m2, dhi_w_m2));
    }
    if conditions.is_empty() {
        let hint = format!("write one line per condition below {}", COLUMNS.join(","));
        return Err(Error::input(path, None, "the file has no conditions", hint).because(Problem::Empty));
    }
    Ok(ConditionsFile { conditions, warnings })
}

fn csv_error(path: &Path, error: &csv::Error) -> Error {
    let line = error.position().map(|p| p.line() as usize);
    Error::input(path, line, error.to_string(), "save the file as CSV in UTF-8")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::place::Place;
    use crate::weather::time::sun::Location;

    fn read(text: &str) -> Result<ConditionsFile> {
        parse_conditions(Path::new("c.csv"), text.as_bytes())
    }

    /// Columns in another order, a byte order mark, CRLF and an extra column give one and the same
    /// condition: sun in the south at 30 deg, weight 1, E0 1367 W/m2.
    #[test]
    fn conditions_of_any_layout_read_alike() {
        let file = read(
            "\u{feff}dhi_w_m2, dni_w_m2,condition,sun_altitude_deg,sun_azimuth_deg,note\r\n100, 800,a,30,180,x\r\n\r\n",
        )
        .expect("valid");
        assert!(file.warnings.is_empty());
        let c = &file.conditions[0];
        assert_eq!((c.label.as_str(), c.suns.len(), c.suns[0].weight), ("a", 1, 1.0));
        assert!((c.suns[0].sun - DVec3::new(0.0, -(0.75_f64.sqrt()), 0.5)).length() < 1e-12);
        assert_eq!((c.dni_w_m2, c.dhi_w_m2), (800.0, 100.0));
        assert_eq!(c.extraterrestrial_w_m2, 1367.0);
    }

    /// Each broken line is an error that names file, line, column and cell: 12 cases.
    #[test]
    fn errors_name_the_cell() {
        let header = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n";
        for (rows, expected) in [
            ("a,180,91,0,0", "line 2: column `sun_altitude_deg` holds `91`"),
            ("a,180,-90.5,0,0", "column `sun_altitude_deg` holds `-90.5`"),
            ("a,NaN,9,0,0", "column `sun_azimuth_deg` holds `NaN`"),
            ("a,inf,9,0,0", "column `sun_azimuth_deg` holds `inf`"),
            ("a,180,9,-1,0", "column `dni_w_m2` holds `-1`"),
            ("a,180,9,1,-0.1", "column `dhi_w_m2` holds `-0.1`"),
            ("a,180,9,1,1e9", "column `dhi_w_m2` holds `1e9`"),
            ("a,180,9,1,", "column `dhi_w_m2` holds ``"),
            ("a,180,9,1", "column `dhi_w_m2` holds ``"),
            ("a,180,9,x,0", "column `dni_w_m2` holds `x`"),
            ("a,1,1,1,1\nb,1,1,1,1\na,1,1,1,1", "line 4: condition `a` was already on line 2"),
            (",1,1,1,1", "the condition has no name"),
        ] {
            let text = read(&format!("{header}{rows}\n")).expect_err(rows).to_string();
            assert!(text.starts_with("c.csv, line"), "{text}");
            assert!(text.contains(expected), "{text}");
        }
        let text = read("condition,dni_w_m2\n").expect_err("header").to_string();
        assert!(text.contains("line 1: column `sun_azimuth_deg` is missing"), "{text}");
        let text = read("condition,condition,dni_w_m2\n").expect_err("twice").to_string();
        assert!(text.contains("column `condition` appears twice"), "{text}");
        for empty in ["", header] {
            assert!(read(empty).is_err());
        }
        let bytes = [header.as_bytes(), b"\xff\xfe,1,1,1,1\n"].concat();
        assert!(parse_conditions(Path::new("c.csv"), &bytes).is_err());
    }

    /// DNI with the sun at or below the horizon is accepted with one warning a row. There are no
    /// suns, and the sky's sun has that azimuth at altitude 0 (exactly z = 0), also at the nadir.
    #[test]
    fn a_sun_below_the_horizon_gives_no_suns() {
        let rows = "a,90,-5,300,20\nb,90,0,300,20\nc,0,-90,0,20\n";
        let file = read(&format!("{}\n{rows}", COLUMNS.join(","))).expect("valid");
        assert_eq!(file.warnings.len(), 2);
        assert!(file.warnings[0].contains("DNI of 300 W/m2"), "{:?}", file.warnings[0]);
        for c in &file.conditions {
            assert!(c.suns.is_empty() && c.sky_sun.z == 0.0);
            assert!((c.sky_sun.length() - 1.0).abs() < 1e-12);
        }
        assert!((file.conditions[0].sky_sun - DVec3::X).length() < 1e-12);
    }

    /// At 54 N 6.2 E, grid north of UTM zone 32 lies 2.26587 degrees west of true north (PROJ by
    /// pyproj 3.7.2). The sun and the sky's sun of 2024-06-21 07:30, 12:00 and 17:15 UT stand in
    /// the grid where NREL's SPA (pvlib 0.16.1) and that convergence put them, to 0.001 degrees.
    /// Without a place they stay, to the bit.
    #[test]
    fn suns_in_a_grid_agree_with_pvlib_and_proj() {
        let place = Place { latitude_deg: 54.0, longitude_deg: 6.2, convergence_deg: -2.26587, epsg: Some(25832) };
        let site = Location::new(54.0, 6.2, 0.0, 0.0).expect("a site");
        let date = Date::new(2024, 6, 21).expect("a date");
        for (minutes, azimuth_deg, altitude_deg) in
            [(450.0, 98.25690, 35.22898), (720.0, 190.26712, 59.13444), (1035.0, 280.06449, 21.95088)]
        {
            let sun = site.sun(date, minutes);
            let condition = [Condition::new("c".into(), &[sun], sun, 800.0, 100.0)];
            assert_eq!(*in_axes(&condition, North::new(None)), condition);
            let turned = in_axes(&condition, North::new(Some(&place)));
            let expected = direction_from_degrees(azimuth_deg + 2.26587, altitude_deg);
            for found in [turned[0].suns[0].sun, turned[0].sky_sun] {
                let off_deg = found.angle_between(expected).to_degrees();
                assert!(off_deg < 0.001, "{minutes}: {off_deg}");
            }
        }
    }

    /// Weights of several suns sum to 1 and suns that are down are dropped.
    #[test]
    fn weights_of_suns_sum_to_1() {
        let suns = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::NEG_Z];
        let c = Condition::new("h".into(), &suns, DVec3::Z, 1.0, 1.0);
        assert_eq!(c.suns.len(), 2);
        assert!((c.suns.iter().map(|i| i.weight).sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
