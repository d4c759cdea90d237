//! Units of columns. In: text such as `kW/m²` or `J cm-2`. Out: the conversion of its numbers to
//! the units of the engine.

/// Measure of a column, which decides the units that it can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Irradiance, to W/m2; energies are those of one interval.
    Irradiance,
    /// Temperature, to degrees Celsius.
    Temperature,
    /// Depth, to centimetres.
    Depth,
    /// Share, from 0 to 1.
    Share,
    /// Cover, to tenths of the sky.
    Tenths,
    /// Share, to percent.
    Percent,
    /// Speed, to metres a second.
    Speed,
    /// Angle, in degrees.
    Angle,
}

/// A unit: its number times `factor`, plus `offset`, is in the unit of the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    pub factor: f64,
    pub offset: f64,
    /// True if it is an energy, J/m2 after `factor`, to be divided by the length of an interval.
    pub per_interval: bool,
}

impl Unit {
    /// Unit of the engine.
    pub const PLAIN: Unit = Unit { factor: 1.0, offset: 0.0, per_interval: false };

    const fn times(factor: f64) -> Self {
        Unit { factor, ..Unit::PLAIN }
    }

    pub fn of(self, value: f64) -> f64 {
        // Numbers in the engine's own unit stay, to the bit.
        if self == Unit::PLAIN { value } else { value * self.factor + self.offset }
    }
}

const POWERS_W: [(&str, f64); 8] = [
    ("kilowatts", 1e3),
    ("kilowatt", 1e3),
    ("kw", 1e3),
    ("milliwatt", 1e-3),
    ("mw", 1e-3),
    ("watts", 1.0),
    ("watt", 1.0),
    ("w", 1.0),
];

/// Energies in J. The BTU is that of the international table; the calorie of the langley is the
/// thermochemical one.
const ENERGIES_J: [(&str, f64); 20] = [
    ("kilowatthours", 3.6e6),
    ("kilowatthour", 3.6e6),
    ("kwhr", 3.6e6),
    ("kwh", 3.6e6),
    ("mwhr", 3.6),
    ("mwh", 3.6),
    ("watthours", 3600.0),
    ("watthour", 3600.0),
    ("whr", 3600.0),
    ("wh", 3600.0),
    ("kilojoules", 1e3),
    ("megajoules", 1e6),
    ("joules", 1.0),
    ("kj", 1e3),
    ("mj", 1e6),
    ("j", 1.0),
    ("kbtu", 1_055_055.852_62),
    ("btu", 1_055.055_852_62),
    ("kcal", 4184.0),
    ("cal", 4.184),
];

const AREAS_M2: [(&str, f64); 13] = [
    ("squaremeter", 1.0),
    ("squaremetre", 1.0),
    ("metersquared", 1.0),
    ("metresquared", 1.0),
    ("meter2", 1.0),
    ("metre2", 1.0),
    ("cm2", 1e-4),
    ("sqcm", 1e-4),
    ("sqm", 1.0),
    ("m2", 1.0),
    ("qm", 1.0),
    ("sqft", 0.092_903_04),
    ("ft2", 0.092_903_04),
];

const TIMES_S: [(&str, f64); 10] = [
    ("hours", 3600.0),
    ("hour", 3600.0),
    ("hr", 3600.0),
    ("h", 3600.0),
    ("minute", 60.0),
    ("min", 60.0),
    ("day", 86_400.0),
    ("d", 86_400.0),
    ("sec", 1.0),
    ("s", 1.0),
];

/// Langley in J/m2: a calorie on a square centimetre.
const LANGLEY_J_M2: f64 = 41_840.0;

/// Returns the unit of a text, among those of a measure; `None` for any other.
pub fn parse_unit(text: &str, measure: Measure) -> Option<Unit> {
    let plain = squeezed(text);
    match measure {
        Measure::Irradiance => irradiance(&plain),
        Measure::Temperature => temperature(&plain),
        Measure::Depth => match plain.as_str() {
            "cm" | "centimeter" | "centimetre" | "centimeters" | "centimetres" => Some(Unit::PLAIN),
            "m" | "meter" | "metre" | "meters" | "metres" => Some(Unit::times(100.0)),
            "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" => Some(Unit::times(0.1)),
            "in" | "inch" | "inches" => Some(Unit::times(2.54)),
            "ft" | "foot" | "feet" => Some(Unit::times(30.48)),
            _ => None,
        },
        Measure::Share => share(&plain).map(Unit::times),
        Measure::Angle => ["deg", "degree", "degrees", "\u{b0}"].contains(&plain.as_str()).then_some(Unit::PLAIN),
        Measure::Tenths => match plain.as_str() {
            "tenths" | "tenth" | "10ths" | "1/10" => Some(Unit::PLAIN),
            "oktas" | "okta" | "octas" | "octa" | "eighths" | "1/8" => Some(Unit::times(1.25)),
            _ => share(&plain).map(|share| Unit::times(10.0 * share)),
        },
        Measure::Speed => speed(&plain).map(Unit::times),
        Measure::Percent => share(&plain).map(|share| Unit::times(100.0 * share)).map(exact_percent),
    }
}

/// Returns the metres a second in one unit of speed.
fn speed(plain: &str) -> Option<f64> {
    match plain {
        "ms" | "ms1" | "meterssecond" | "metressecond" | "mps" => Some(1.0),
        "kmh" | "kmh1" | "kph" | "kmhr" => Some(1.0 / 3.6),
        "kn" | "kt" | "kts" | "knot" | "knots" => Some(1852.0 / 3600.0),
        "mph" | "mih" | "mileshour" => Some(0.447_04),
        _ => None,
    }
}

/// Returns percent of percent as exactly 1, without the rounding of a hundredth.
fn exact_percent(unit: Unit) -> Unit {
    if (unit.factor - 1.0).abs() < 1e-12 { Unit::PLAIN } else { unit }
}

/// Returns true if a text is W/m2 in any spelling.
pub fn is_watts(text: &str) -> bool {
    parse_unit(text, Measure::Irradiance) == Some(Unit::PLAIN)
}

/// Returns the value of one unit of shares.
fn share(plain: &str) -> Option<f64> {
    match plain {
        "%" | "percent" | "pct" | "perc" | "procent" | "prozent" => Some(0.01),
        "fraction" | "frac" | "unitless" | "dimensionless" | "ratio" | "1" | "01" | "0to1" | "0..1" | "none" => {
            Some(1.0)
        }
        _ => None,
    }
}

fn temperature(plain: &str) -> Option<Unit> {
    let degrees = plain.strip_prefix("degrees").or_else(|| plain.strip_prefix("degree"));
    let degrees = degrees.or_else(|| plain.strip_prefix("deg")).unwrap_or(plain);
    match degrees {
        "c" | "celsius" | "centigrade" => Some(Unit::PLAIN),
        "f" | "fahrenheit" => Some(Unit { factor: 5.0 / 9.0, offset: -160.0 / 9.0, per_interval: false }),
        "k" | "kelvin" => Some(Unit { factor: 1.0, offset: -273.15, per_interval: false }),
        _ => None,
    }
}

/// Reads a power or an energy over an area, m2 where none is named. An energy may also have a time.
fn irradiance(plain: &str) -> Option<Unit> {
    if let Some(rest) = ["langleys", "langley", "ly"].iter().find_map(|name| plain.strip_prefix(name)) {
        return over_time(LANGLEY_J_M2, rest);
    }
    let of_power = POWERS_W.iter().find_map(|(name, watts)| {
        let area = plain.strip_prefix(name)?;
        Some(Unit::times(watts / if area.is_empty() { bare_area(name)? } else { area_under(name, area)? }))
    });
    let of_energy = || ENERGIES_J.iter().find_map(|(name, joules)| energy(plain.strip_prefix(name)?, *joules, name));
    of_power.or_else(of_energy)
}

/// Reads the text behind an energy: an area and a time, in either order, each once at most.
fn energy(rest: &str, joules: f64, name: &str) -> Option<Unit> {
    let split = |at: usize| rest.split_at_checked(at);
    (0..=rest.len()).rev().filter_map(split).find_map(|(first, second)| {
        let (area, time) = match (area_under(name, first), first.is_empty()) {
            (Some(area), _) => (area, second),
            (None, true) => (bare_area(name)?, second),
            (None, false) => (area_under(name, second)?, first),
        };
        over_time(joules / area, time)
    })
}

/// Returns a named area. Thousandths of watts are usual on square centimetres only: `MW/m2` would
/// be a million watts, which is no light.
fn area_under(unit: &str, text: &str) -> Option<f64> {
    let (_, area) = AREAS_M2.iter().find(|(name, _)| *name == text)?;
    (!is_milli(unit) || *area < 1e-3).then_some(*area)
}

fn is_milli(unit: &str) -> bool {
    unit.starts_with("mw") || unit.starts_with("milli")
}

/// Returns the square metre for a unit without an area. Calories, BTU and thousandths of watts are
/// not usual on it.
fn bare_area(name: &str) -> Option<f64> {
    (!name.contains("cal") && !name.contains("btu") && !is_milli(name)).then_some(1.0)
}

/// Returns the unit of an energy in J/m2 over a time such as `h`, `day` or `15min`, or over an
/// interval where none is named.
fn over_time(joules_m2: f64, time: &str) -> Option<Unit> {
    if time.is_empty() {
        return Some(Unit { factor: joules_m2, offset: 0.0, per_interval: true });
    }
    let end = time.find(|c: char| !c.is_ascii_digit()).unwrap_or(time.len());
    let (number, unit) = time.split_at_checked(end)?;
    let (_, seconds) = TIMES_S.iter().find(|(name, _)| *name == unit)?;
    let number: f64 = if number.is_empty() { 1.0 } else { number.parse().ok().filter(|number| *number > 0.0)? };
    Some(Unit::times(joules_m2 / (number * seconds)))
}

/// Returns a text in lower case, with superscripts as digits and without punctuation: `W·m⁻²`, `W /
/// m^2` and `W_m2` become `wm2`.
fn squeezed(text: &str) -> String {
    let mut plain = String::new();
    for c in text.to_lowercase().chars() {
        match c {
            '²' => plain.push('2'),
            '\u{b9}' => plain.push('1'),
            'a'..='z' | '0'..='9' | '%' => plain.push(c),
            _ => {}
        }
    }
    // In `m-2 h-1` the hour is a divisor, as in `/h`.
    let plain = plain
        .replace("wattsper", "watt")
        .replace("per", if plain == "percent" || plain == "perc" { "per" } else { "" });
    ["h1", "hr1", "d1", "day1", "s1", "min1"]
        .iter()
        .find_map(|end| plain.strip_suffix(end).map(|start| format!("{start}{}", end.trim_end_matches('1'))))
        .unwrap_or(plain)
}

/// Returns true for words that are a unit of light which cannot be converted, so that a name with
/// one of them is not ignored.
pub fn looks_like_unit(text: &str) -> bool {
    let plain = squeezed(text);
    let of_light = ["lux", "klux", "lx", "klx", "umol", "ppfd", "einstein", "mv", "counts", "erg", "hp"];
    let named = of_light.iter().any(|word| plain.starts_with(word)) || text.contains('µ') || text.contains('μ');
    let energies = ENERGIES_J.iter().any(|(name, _)| name.len() > 2 && plain == *name);
    // `cm21` is a pyranometer.
    let on_area = AREAS_M2.iter().any(|(area, _)| {
        plain
            .rsplit_once(area)
            .is_some_and(|(_, time)| time.is_empty() || TIMES_S.iter().any(|(name, _)| time == *name))
    });
    named || energies || on_area
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thirty-eight spellings of units of light give the value of one of them in W/m2, energies
    /// over an hour. Nine texts that are no unit are refused.
    #[test]
    fn units_of_light_become_watts() {
        let hour = |text: &str| {
            parse_unit(text, Measure::Irradiance)
                .map(|unit| if unit.per_interval { unit.factor / 3600.0 } else { unit.factor })
        };
        for (text, expected) in [
            ("W/m2", 1.0),
            ("W/m²", 1.0),
            ("W/m^2", 1.0),
            ("W m-2", 1.0),
            ("W·m⁻²", 1.0),
            ("W*m**-2", 1.0),
            ("w_m2", 1.0),
            ("Wm2", 1.0),
            ("W", 1.0),
            ("Watts/m2", 1.0),
            ("WattsPerMeterSquared", 1.0),
            ("watts per square meter", 1.0),
            ("W/sq.m", 1.0),
            ("kW/m2", 1000.0),
            ("kw", 1000.0),
            ("mW/cm2", 10.0),
            ("Wh/m2", 1.0),
            ("W-hr/m^2", 1.0),
            ("Wh/m2/h", 1.0),
            ("kWh/m2", 1000.0),
            ("kwh_m2", 1000.0),
            ("kWh", 1000.0),
            ("kWh/m2/day", 1000.0 / 24.0),
            ("kW-hr/m^2/day", 1000.0 / 24.0),
            ("J/m2", 1.0 / 3600.0),
            ("J m**-2", 1.0 / 3600.0),
            ("J/cm2", 1e4 / 3600.0),
            ("J/cm²", 1e4 / 3600.0),
            ("kJ/m2", 1e3 / 3600.0),
            ("kJ/m2/h", 1e3 / 3600.0),
            ("MJ/m2", 1e6 / 3600.0),
            ("MJ/hr", 1e6 / 3600.0),
            ("MJ m-2 h-1", 1e6 / 3600.0),
            ("cal/cm2", 41_840.0 / 3600.0),
            ("Langley", 41_840.0 / 3600.0),
            ("ly/min", 41_840.0 / 60.0),
            ("BTU/ft2", 3.154_590_7),
            ("Btu/(h·ft²)", 3.154_590_7),
        ] {
            let found = hour(text).unwrap_or_else(|| panic!("{text}"));
            assert!((found / expected - 1.0).abs() < 1e-6, "{text}: {found}");
        }
        for text in ["", "foo", "lux", "umol/m2/s", "W/m3", "MW/m2", "cal", "kWh/m2/month", "W/m2/h"] {
            assert_eq!(hour(text), None, "{text}");
        }
    }

    /// Twenty-one units of speed, temperature, depth and shares convert the number 10 to the
    /// expected value. Four texts are no unit of the measure.
    #[test]
    fn other_units_are_converted() {
        for (text, measure, expected) in [
            ("°C", Measure::Temperature, 10.0),
            ("deg C", Measure::Temperature, 10.0),
            ("degrees_celsius", Measure::Temperature, 10.0),
            ("F", Measure::Temperature, -12.222_222),
            ("K", Measure::Temperature, -263.15),
            ("m", Measure::Depth, 1000.0),
            ("cm", Measure::Depth, 10.0),
            ("mm", Measure::Depth, 1.0),
            ("in", Measure::Depth, 25.4),
            ("%", Measure::Share, 0.1),
            ("fraction", Measure::Share, 10.0),
            ("oktas", Measure::Tenths, 12.5),
            ("m/s", Measure::Speed, 10.0),
            ("m s-1", Measure::Speed, 10.0),
            ("km/h", Measure::Speed, 2.777_778),
            ("kn", Measure::Speed, 5.144_444),
            ("mp/h", Measure::Speed, 4.4704),
            ("tenths", Measure::Tenths, 10.0),
            ("percent", Measure::Tenths, 1.0),
            ("%", Measure::Percent, 10.0),
            ("0-1", Measure::Percent, 1000.0),
        ] {
            let found = parse_unit(text, measure).unwrap_or_else(|| panic!("{text}")).of(10.0);
            assert!((found - expected).abs() < 1e-5, "{text}: {found}");
        }
        for (text, measure) in [
            ("rankine", Measure::Temperature),
            ("W/m2", Measure::Depth),
            ("cm", Measure::Share),
            ("hPa", Measure::Percent),
        ] {
            assert_eq!(parse_unit(text, measure), None, "{text}");
        }
    }
}
