//! Names of columns. In: a name in a file. Out: the quantity that it stands for, and the unit that
//! it states.

use crate::formats::weather_csv::units::{Measure, Unit, looks_like_unit, parse_unit};

/// Quantity that a column can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Ghi,
    Dni,
    Dhi,
    /// Direct irradiance on the horizontal.
    Beam,
    Albedo,
    Snow,
    DryBulb,
    DewPoint,
    Humidity,
    Infrared,
    OpaqueSky,
    Wind,
    /// Zenith angle of the sun.
    Zenith,
    /// Altitude of the sun.
    Altitude,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Quantity; 14] = [
        Quantity::Ghi,
        Quantity::Dni,
        Quantity::Dhi,
        Quantity::Beam,
        Quantity::Albedo,
        Quantity::Snow,
        Quantity::DryBulb,
        Quantity::DewPoint,
        Quantity::Humidity,
        Quantity::Infrared,
        Quantity::OpaqueSky,
        Quantity::Wind,
        Quantity::Zenith,
        Quantity::Altitude,
    ];

    /// Returns the names of the quantity in lower case, the usual ones first. Case, blanks, hyphens
    /// and underscores do not matter.
    const fn names(self) -> &'static [&'static str] {
        match self {
            Quantity::Ghi => &[
                "ghi",
                "g(h)",
                "global_horizontal_irradiance",
                "global_horizontal_radiation",
                "global_horizontal_irradiation",
                "global_horizontal",
                "shortwave_radiation",
                "allsky_sfc_sw_dwn",
                "globhor",
                "g_gh",
                "global_radiation",
                "global_irradiance",
                "swd",
                "short_wave_downward_(global)_radiation",
                "short_wave_downward_radiation",
                "surface_downwelling_shortwave_flux_in_air",
                "rsds",
                "sis",
                "sw_in",
                "sw_down",
                "global_solar_radiation",
                "globalstrahlung",
            ],
            Quantity::Dni => &[
                "dni",
                "gb(n)",
                "bn",
                "direct_normal_irradiance",
                "direct_normal_radiation",
                "beam_normal_irradiance",
                "direct_normal_irradiation",
                "direct_normal",
                "bni",
                "allsky_sfc_sw_dni",
                "g_bn",
                "dir",
                "direct_n",
                "beam_normal",
                "beam_irradiance",
                "beam",
            ],
            Quantity::Dhi => &[
                "dhi",
                "gd(h)",
                "diffuse_horizontal_irradiance",
                "diffuse_horizontal_radiation",
                "diffuse_irradiance",
                "diffuse_horizontal_irradiation",
                "diffuse_horizontal",
                "diffuse_radiation",
                "dif",
                "allsky_sfc_sw_diff",
                "diffhor",
                "g_dh",
                "swdif",
                "diffusstrahlung",
            ],
            Quantity::Beam => &[
                "bhi",
                "direct_radiation",
                "gb(h)",
                "direct_horizontal_irradiance",
                "beam_horizontal_irradiance",
                "dirhi",
                "sid",
                "direct_horizontal",
                "beam_horizontal",
                "direct_horizontal_radiation",
            ],
            Quantity::Zenith => &[
                "solar_zenith",
                "solar_zenith_angle",
                "zenith",
                "zenith_angle",
                "sza",
                "sun_zenith",
                "apparent_zenith",
            ],
            Quantity::Altitude => &[
                "solar_elevation",
                "solar_altitude",
                "solar_elevation_angle",
                "sun_elevation",
                "sun_altitude",
                "apparent_elevation",
            ],
            Quantity::Albedo => &["albedo", "surface_albedo", "alb", "allsky_srf_alb"],
            Quantity::Snow => &["snow_depth", "snow_height"],
            Quantity::DryBulb => &[
                "temp_air",
                "temperature",
                "air_temperature",
                "dry_bulb",
                "dry_bulb_temperature",
                "drybulb",
                "t2m",
                "temp",
                "tamb",
                "temperature_2m",
                "air_temp",
                "ambient_temperature",
                "tdry",
                "t_amb",
            ],
            Quantity::DewPoint => &[
                "temp_dew",
                "dew_point",
                "dewpoint",
                "dew_point_temperature",
                "temperature_dew_point",
                "dew_point_2m",
                "dewpoint_temp",
                "t2mdew",
                "tdew",
            ],
            Quantity::Humidity => &["relative_humidity", "rh", "humidity", "relative_humidity_2m", "rh2m", "relhum"],
            Quantity::Infrared => &[
                "longwave_down",
                "ir(h)",
                "lwd",
                "dw_ir",
                "lw_in",
                "horizontal_infrared_radiation",
                "infrared",
                "allsky_sfc_lw_dwn",
            ],
            Quantity::OpaqueSky => &["opaque_sky_cover", "opqcld", "opaque_cloud_cover"],
            Quantity::Wind => &[
                "wind_speed",
                "windspeed",
                "ws10m",
                "wind_speed_10m",
                "windspeed_10m",
                "wspd",
                "ws",
                "wind",
                "windvel",
            ],
        }
    }

    /// Returns the number of usual names. Two columns of light with usual names are refused; a
    /// rarer name gives way to a more usual one.
    pub const fn usual_names(self) -> usize {
        match self {
            Quantity::Ghi => 4,
            Quantity::Dni => 6,
            Quantity::Dhi => 5,
            _ => 0,
        }
    }

    /// Returns true if it is read only for longwave irradiance and for comfort.
    pub const fn is_of_air(self) -> bool {
        use Quantity::{DewPoint, DryBulb, Humidity, Infrared, OpaqueSky, Wind};
        matches!(self, DryBulb | DewPoint | Humidity | Infrared | OpaqueSky | Wind)
    }

    /// Returns true if it describes the ground, which few replays take from weather.
    pub const fn is_of_ground(self) -> bool {
        matches!(self, Quantity::Albedo | Quantity::Snow)
    }

    pub const fn measure(self) -> Measure {
        match self {
            Quantity::Ghi | Quantity::Dni | Quantity::Dhi | Quantity::Beam | Quantity::Infrared => Measure::Irradiance,
            Quantity::Albedo => Measure::Share,
            Quantity::Snow => Measure::Depth,
            Quantity::DryBulb | Quantity::DewPoint => Measure::Temperature,
            Quantity::Humidity => Measure::Percent,
            Quantity::OpaqueSky => Measure::Tenths,
            Quantity::Wind => Measure::Speed,
            Quantity::Zenith | Quantity::Altitude => Measure::Angle,
        }
    }

    /// Returns the units that a column of it can have, for messages.
    pub const fn units(self) -> &'static str {
        match self.measure() {
            Measure::Irradiance => "W/m2, kW/m2, Wh/m2, kWh/m2, J/m2, kJ/m2, MJ/m2, J/cm2, cal/cm2, langley or BTU/ft2",
            Measure::Temperature => "C, F or K",
            Measure::Depth => "m, cm, mm or in",
            Measure::Share | Measure::Percent => "% or fraction",
            Measure::Tenths => "tenths, oktas, % or fraction",
            Measure::Speed => "m/s, km/h, knots or mph",
            Measure::Angle => "degrees",
        }
    }

    /// Returns the name of the quantity in messages.
    pub const fn word(self) -> &'static str {
        match self {
            Quantity::Ghi => "GHI",
            Quantity::Dni => "DNI",
            Quantity::Dhi => "DHI",
            Quantity::Beam => "direct horizontal irradiance",
            Quantity::Albedo => "albedo",
            Quantity::Snow => "snow depth",
            Quantity::DryBulb => "air temperature",
            Quantity::DewPoint => "dew point",
            Quantity::Humidity => "relative humidity",
            Quantity::Infrared => "infrared radiation",
            Quantity::OpaqueSky => "opaque sky cover",
            Quantity::Wind => "wind speed",
            Quantity::Zenith => "zenith angle of the sun",
            Quantity::Altitude => "altitude of the sun",
        }
    }
}

/// Unit that a name states behind the quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum StatedUnit {
    Silent,
    Known(Unit),
    /// Text in place of a unit that is no unit of the measure.
    Unknown(String),
}

/// Match of a name with a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct NameMatch {
    /// Index among the quantity's names; 0 is the most usual one.
    pub rank: usize,
    pub unit: StatedUnit,
    /// True if values belong to a moment and are no means.
    pub instant: bool,
}

/// Words behind a name that do not concern its unit.
const QUALIFIERS: [&str; 20] = [
    "avg",
    "mean",
    "average",
    "averaged",
    "measured",
    "modelled",
    "modeled",
    "hourly",
    "interval",
    "satellite",
    "sensor",
    "total",
    "horizontal",
    "ghi",
    "dni",
    "dhi",
    "dif",
    "2m",
    "10m",
    "actual",
];

/// Returns a name without case, blanks, hyphens, underscores and quotes: `Dew Point (C)` becomes
/// `dewpoint(c)`.
pub fn squash(name: &str) -> String {
    let lower = name.to_lowercase();
    lower
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, '(' | ')' | '[' | ']' | '/' | '%' | '+' | '°'))
        .collect()
}

/// Matches a name with a quantity. It takes the longest of the quantity's names that the name
/// starts with, if nothing but a unit and words of [`QUALIFIERS`] follows.
pub fn match_name(name: &str, quantity: Quantity) -> Option<NameMatch> {
    let plain = squash(name);
    let known = quantity.names().iter().enumerate().map(|(rank, name)| (rank, squash(name)));
    let fitting = known.filter_map(|(rank, known)| plain.strip_prefix(&known).map(|rest| (rank, known.len(), rest)));
    let mut all: Vec<(usize, usize, &str)> = fitting.collect();
    all.sort_by_key(|(rank, length, _)| (std::cmp::Reverse(*length), *rank));
    all.into_iter().find_map(|(rank, _, rest)| {
        let mut instant = false;
        let unit = unit_behind(rest, quantity.measure(), &mut instant)?;
        Some(NameMatch { rank, unit, instant })
    })
}

/// Returns the unit in the text behind a name; `None` if the text makes it another name.
fn unit_behind(rest: &str, measure: Measure, instant: &mut bool) -> Option<StatedUnit> {
    let mut unit = StatedUnit::Silent;
    let mut left = rest;
    while !left.is_empty() {
        // `DNI (W/m^2))` of SolarAnywhere has a bracket too many.
        left = left.trim_start_matches([')', ']']);
        let bracketed = left.starts_with(['(', '[']);
        let (part, behind) = if bracketed {
            let end = left.rfind([')', ']']).unwrap_or(left.len());
            let first_end = left.find([')', ']']).unwrap_or(end);
            // `(BTU/(h ft2))` has brackets inside.
            let nested = left.get(1..first_end).is_some_and(|inside| inside.contains('('));
            let end = if nested { end } else { first_end };
            (left.get(1..end)?, left.get(end + 1..).unwrap_or_default())
        } else {
            let end = left.find(['(', '[']).unwrap_or(left.len());
            // `W/(m2)`, `BTU/(h ft2)` are units with brackets.
            let end = if left.get(..end).is_some_and(|part| part.ends_with('/')) { left.len() } else { end };
            left.split_at_checked(end)?
        };
        left = behind;
        let part = part.strip_prefix("in").filter(|unit| parse_unit(unit, measure).is_some()).unwrap_or(part);
        let plain = part.trim_matches(['/', '%']);
        if part.is_empty() || QUALIFIERS.contains(&plain) && parse_unit(part, measure).is_none() {
            continue;
        }
        if let Some(start) = part.strip_prefix("avg").or_else(|| part.strip_prefix("mean"))
            && let Some(found) = parse_unit(start, measure)
        {
            unit = StatedUnit::Known(found);
            continue;
        }
        if part == "instant" {
            *instant = true;
            continue;
        }
        match parse_unit(part, measure) {
            Some(found) => unit = StatedUnit::Known(found),
            None if bracketed => unit = StatedUnit::Unknown(part.to_owned()),
            None if measure == Measure::Irradiance && looks_like_unit(part) => {
                unit = StatedUnit::Unknown(part.to_owned());
            }
            None => return None,
        }
    }
    Some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thirty spellings of GHI are recognised, with the value of one of their units in W/m2 over an
    /// hour. The units of two other names are reported as unknown.
    #[test]
    fn thirty_spellings_of_ghi_are_recognised() {
        for (name, expected) in [
            ("ghi", 1.0),
            ("GHI", 1.0),
            ("GHI (W/m2)", 1.0),
            ("GHI (W/m^2)", 1.0),
            ("GHI [W/m²]", 1.0),
            ("ghi_w_m2", 1.0),
            ("GHI_Wm2", 1.0),
            ("ghi W/m²", 1.0),
            ("GHI, W/m2", 1.0),
            ("GHI in W/m2", 1.0),
            ("GHI_Avg", 1.0),
            ("ghi (measured) [kW/m2]", 1000.0),
            ("ghi_kw", 1000.0),
            ("ghi_kw_m2", 1000.0),
            ("GHI (kW/m2)", 1000.0),
            ("ghi_kwh_m2", 1000.0),
            ("GHI (kWh/m²)", 1000.0),
            ("GHI [Wh/m2]", 1.0),
            ("ghi_wh", 1.0),
            ("GHI [J/cm²]", 1e4 / 3600.0),
            ("ghi_j_cm2", 1e4 / 3600.0),
            ("ghi_kj_m2", 1e3 / 3600.0),
            ("ghi (MJ/m2)", 1e6 / 3600.0),
            ("G(h)", 1.0),
            ("G(h) (kW/m2)", 1000.0),
            ("Global Horizontal Irradiance (GHI) W/m2", 1.0),
            ("GlobalHorizontalIrradiance_WattsPerMeterSquared", 1.0),
            ("shortwave_radiation (W/m²)", 1.0),
            ("ALLSKY_SFC_SW_DWN", 1.0),
            ("GHI (BTU/(h ft2))", 3.154_590_7),
        ] {
            let found = match_name(name, Quantity::Ghi).unwrap_or_else(|| panic!("{name}"));
            let factor = match found.unit {
                StatedUnit::Silent => 1.0,
                StatedUnit::Known(unit) if unit.per_interval => unit.factor / 3600.0,
                StatedUnit::Known(unit) => unit.factor,
                StatedUnit::Unknown(text) => panic!("{name}: {text}"),
            };
            assert!((factor / expected - 1.0).abs() < 1e-6, "{name}: {factor}");
        }
        for name in ["GHI (lux)", "ghi_umol_m2_s"] {
            let found = match_name(name, Quantity::Ghi).expect(name);
            assert!(matches!(found.unit, StatedUnit::Unknown(_)), "{name}");
        }
    }

    /// Twelve names that start with a quantity's name and go on otherwise do not match. Five names
    /// of air and ground state their units.
    #[test]
    fn longer_names_of_other_things_do_not_match() {
        for (name, quantity) in [
            ("ghi_clear", Quantity::Ghi),
            ("GHI_C", Quantity::Ghi),
            ("Clear sky GHI", Quantity::Ghi),
            ("ghi_max", Quantity::Ghi),
            ("ghi_flag", Quantity::Ghi),
            ("dni_extra", Quantity::Dni),
            ("diffuse", Quantity::Dhi),
            ("temp_cell", Quantity::DryBulb),
            ("temperature_dew_point", Quantity::DryBulb),
            ("T2M_MAX", Quantity::DryBulb),
            ("albedo_source", Quantity::Albedo),
            ("rh_min", Quantity::Humidity),
        ] {
            assert_eq!(match_name(name, quantity), None, "{name}");
        }
        for (name, quantity, of_ten) in [
            ("temp_air_k", Quantity::DryBulb, -263.15),
            ("Dew-point (C)", Quantity::DewPoint, 10.0),
            ("snow_depth (m)", Quantity::Snow, 1000.0),
            ("Albedo [%]", Quantity::Albedo, 0.1),
            ("rh_percent", Quantity::Humidity, 10.0),
        ] {
            let found = match_name(name, quantity).map(|found| found.unit);
            let Some(StatedUnit::Known(unit)) = found else { panic!("{name}: {found:?}") };
            assert!((unit.of(10.0) - of_ten).abs() < 1e-9, "{name}");
        }
    }
}
