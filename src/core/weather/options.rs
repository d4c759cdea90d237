//! Statements of a user about a weather file, where the file makes none or wrong ones. In: options
//! as text. Out: checked values.

use heliotile_requests::Request;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::named::NamedValues;
use crate::weather::time::clock_zone::ClockZone;
use std::fmt;
use std::str::FromStr;

/// Options for reading a weather file. The default takes the statements of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Request)]
#[serde(default, deny_unknown_fields)]
pub struct WeatherOptions {
    /// Latitude of the weather, degrees, north positive, in place of that of the file [default if
    /// the file states none: that of the scene].
    #[field(metavar = "DEGREES", range = -90.0..=90.0, says = "give degrees from -90 to 90, north positive")]
    pub latitude_deg: Option<f64>,
    /// Longitude of the weather, degrees, east positive, in place of that of the file.
    #[field(metavar = "DEGREES", range = -180.0..=180.0, says = "give degrees from -180 to 180, east positive")]
    pub longitude_deg: Option<f64>,
    /// Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC,
    /// such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its
    /// time stamps state an offset, the zone of days and labels in results.
    #[serde(rename = "zone_hours", deserialize_with = "zone_of", serialize_with = "zone_as_stated")]
    #[field(name = "time_zone", metavar = "ZONE", hyphen, parse = parse_zone)]
    pub zone: Option<ClockZone>,
    /// Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the
    /// shift under which GHI, DNI and DHI agree best, if they agree clearly better.
    #[field(metavar = "TIME", hyphen)]
    pub shift: TimeShift,
    /// Position of the weather file's time stamps in their intervals; middle for values at one
    /// moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain
    /// CSV].
    #[field(name = "weather_stamp")]
    pub stamped_at: Option<StampedAt>,
    /// Order of day and month in the weather file's dates of three numbers, such as 01/06/2021
    /// [default: what the whole column shows].
    pub date_order: Option<DateOrder>,
    /// True if the air of every row is read, too, from which longwave irradiance is computed.
    #[field(skip)]
    pub with_air: bool,
}

/// A zone as requests state it.
#[derive(Deserialize)]
#[serde(untagged)]
enum StatedZone {
    Hours(f64),
    Text(String),
}

fn zone_as_stated<S: Serializer>(zone: &Option<ClockZone>, serializer: S) -> Result<S::Ok, S::Error> {
    match zone {
        None => serializer.serialize_none(),
        Some(ClockZone::Hours(hours)) => hours.serialize(serializer),
        Some(named) => named.serialize(serializer),
    }
}

fn zone_of<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<ClockZone>, D::Error> {
    match Option::<StatedZone>::deserialize(deserializer)? {
        None => Ok(None),
        Some(StatedZone::Hours(hours)) => Ok(Some(ClockZone::Hours(hours))),
        Some(StatedZone::Text(text)) => text.parse().map(Some).map_err(D::Error::custom),
    }
}

/// Place of a row's time stamp in its interval, in weather files and in results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StampedAt {
    /// Start of the interval.
    #[default]
    Start,
    /// Middle of the interval; values at one moment are taken for means around it.
    Middle,
    /// End of the interval.
    End,
}

impl StampedAt {
    /// Returns the name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            StampedAt::Start => "start",
            StampedAt::Middle => "middle",
            StampedAt::End => "end",
        }
    }

    /// Returns the share of the interval that lies before the stamp.
    pub fn share_before(self) -> f64 {
        match self {
            StampedAt::Start => 0.0,
            StampedAt::Middle => 0.5,
            StampedAt::End => 1.0,
        }
    }
}

/// Order of the three numbers of a date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DateOrder {
    /// 2021-06-01: the year first.
    Ymd,
    /// 01/06/2021: the day first.
    Dmy,
    /// 06/01/2021: the month first.
    Mdy,
}

impl DateOrder {
    /// All orders.
    pub const ALL: [DateOrder; 3] = [DateOrder::Ymd, DateOrder::Dmy, DateOrder::Mdy];

    /// Returns the name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            DateOrder::Ymd => "ymd",
            DateOrder::Dmy => "dmy",
            DateOrder::Mdy => "mdy",
        }
    }
}

/// Shift of the time stamps of a file before the sun is computed: `auto`, or minutes as in `41min`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeShift {
    /// A number of minutes, later if positive.
    Minutes(f64),
    /// Shift at which GHI = DHI + DNI cos z fits best, if it fits clearly better there.
    Auto,
}

impl fmt::Display for TimeShift {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        match self {
            TimeShift::Minutes(minutes) => write!(to, "{minutes}min"),
            TimeShift::Auto => to.write_str("auto"),
        }
    }
}

impl Default for TimeShift {
    fn default() -> Self {
        TimeShift::Minutes(0.0)
    }
}

/// Largest shift, minutes; a larger one is a mistake.
const LARGEST_SHIFT_MIN: f64 = 1440.0;

/// Parses `41min`, `-30min`, `0.5h` or `auto`.
impl FromStr for TimeShift {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let hint = "give a number with its unit, such as 41min, -30min or 0.5h, or `auto`";
        if text == "auto" {
            return Ok(TimeShift::Auto);
        }
        let units = [("minutes", 1.0), ("min", 1.0), ("h", 60.0), ("s", 1.0 / 60.0)];
        let found = units.iter().find_map(|(unit, minutes)| Some((text.strip_suffix(unit)?, minutes)));
        let (number, minutes) = found.ok_or(hint)?;
        let minutes = number.trim_end().parse::<f64>().map_err(|_| hint)? * minutes;
        match (-LARGEST_SHIFT_MIN..=LARGEST_SHIFT_MIN).contains(&minutes) {
            true => Ok(TimeShift::Minutes(minutes)),
            false => Err("a shift is at most 24h, to either side".into()),
        }
    }
}

impl NamedValues for StampedAt {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        (StampedAt::Start.name(), "Start of the interval", StampedAt::Start),
        (StampedAt::Middle.name(), "Middle of the interval", StampedAt::Middle),
        (StampedAt::End.name(), "End of the interval", StampedAt::End),
    ];
}

impl NamedValues for DateOrder {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        (DateOrder::Dmy.name(), "Day, month, year: 31/12/2021", DateOrder::Dmy),
        (DateOrder::Mdy.name(), "Month, day, year: 12/31/2021", DateOrder::Mdy),
        (DateOrder::Ymd.name(), "Year, month, day: 21/12/31", DateOrder::Ymd),
    ];
}

crate::serde_by_name!(StampedAt, DateOrder);

crate::parse_by_name!(StampedAt, DateOrder);
heliotile_requests::parse_by_text!(TimeShift: heliotile_requests::Form::TEXT);

/// Reads a time zone. An error says what to give.
pub fn parse_zone(text: &str) -> std::result::Result<ClockZone, String> {
    let hint = "give hours ahead of UTC, -12 to 14, such as +01:00, -7, 5.5 or UTC, or a name such as Europe/Amsterdam";
    text.parse().map_err(|_| hint.into())
}

crate::serde_by_text!(TimeShift);

#[cfg(test)]
mod tests {
    use super::*;

    /// Options come back from their JSON, with a zone that is a number, a text, a name or none, 4
    /// of 4. A text that is no zone is refused.
    #[test]
    fn options_come_back_from_json() {
        let read = |zone: &str| serde_json::from_str::<WeatherOptions>(&format!("{{\"zone_hours\": {zone}}}"));
        for (text, hours) in
            [("5.5", Some(5.5)), ("\"-03:30\"", Some(-3.5)), ("null", None), ("\"Asia/Tokyo\"", Some(9.0))]
        {
            let options = read(text).expect(text);
            assert_eq!(options.zone.map(|zone| zone.standard_hours(2021)), hours);
            let again = serde_json::to_string(&options).expect("JSON");
            assert_eq!(serde_json::from_str::<WeatherOptions>(&again).expect("options"), options);
        }
        assert!(read("\"Mars\"").expect_err("no zone").to_string().contains("`Mars` is not a time zone"));
    }

    /// 41min, -30min, 0.5h, 1h and 90s are 41, -30, 30, 60 and 1.5 minutes. Seven other texts are
    /// refused with advice.
    #[test]
    fn shifts_are_read_with_their_units() {
        for (text, minutes) in [("41min", 41.0), ("-30min", -30.0), ("0.5h", 30.0), ("1h", 60.0), ("90s", 1.5)] {
            assert_eq!(text.parse(), Ok(TimeShift::Minutes(minutes)));
        }
        assert_eq!("auto".parse(), Ok(TimeShift::Auto));
        for text in ["", "41", "h", "one h", "nanmin", "25h", "-1e9min"] {
            assert!(text.parse::<TimeShift>().is_err(), "{text}");
        }
    }
}
