//! Arguments with facts about a weather file that the file does not state, or states wrongly.

use std::fmt;

use clap::{ArgGroup, Args};

use super::{parse_latitude, parse_longitude};
use crate::cli::values::choice;
use heliotile::{ClockZone, DateOrder, StampedAt, TimeShift, WeatherOptions};

/// Place and clock of a weather file, for commands that know no scene.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "About the weather file")]
pub struct WeatherArgs {
    /// Latitude of the weather, degrees, north positive, in place of that of the file [default if
    /// the file states none: that of the scene]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_latitude)]
    pub latitude: Option<f64>,
    /// Longitude of the weather, degrees, east positive, in place of that of the file
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_longitude)]
    pub longitude: Option<f64>,
    #[command(flatten)]
    pub clock: ClockArgs,
}

/// Clock of a weather file; shared by all commands that read weather. A file without a place gets
/// the place of the scene.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "About the weather file")]
pub struct ClockArgs {
    /// Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC,
    /// such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its
    /// time stamps state an offset, the zone of days and labels in results
    #[arg(long, value_name = "ZONE", allow_hyphen_values = true, value_parser = parse_time_zone)]
    pub time_zone: Option<ClockZone>,
    /// Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the
    /// shift under which GHI, DNI and DHI agree best, if they agree clearly better
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub shift: Option<TimeShift>,
    /// Position of the weather file's time stamps in their intervals; middle for values at one
    /// moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain
    /// CSV]
    #[arg(long, value_parser = choice::<StampedAt>())]
    pub weather_stamp: Option<StampedAt>,
    /// Order of day and month in the weather file's dates of three numbers, such as 01/06/2021
    /// [default: what the whole column shows]
    #[arg(long, value_parser = choice::<DateOrder>())]
    pub date_order: Option<DateOrder>,
}

impl WeatherArgs {
    /// Returns the options for the reader of weather files.
    pub fn options(&self, with_air: bool) -> WeatherOptions {
        WeatherOptions { latitude_deg: self.latitude, longitude_deg: self.longitude, ..self.clock.options(with_air) }
    }
}

impl ClockArgs {
    /// Returns the options for the reader of weather files.
    pub fn options(&self, with_air: bool) -> WeatherOptions {
        WeatherOptions {
            zone: self.time_zone,
            shift: self.shift.unwrap_or_default(),
            stamped_at: self.weather_stamp,
            date_order: self.date_order,
            with_air,
            ..WeatherOptions::default()
        }
    }
}

/// Writes the options as on the command line, each behind a space.
impl fmt::Display for ClockArgs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(zone) = self.time_zone {
            write!(f, " --time-zone {}", zone.option())?;
        }
        match self.shift {
            Some(TimeShift::Auto) => write!(f, " --shift auto")?,
            Some(TimeShift::Minutes(minutes)) => write!(f, " --shift {minutes}min")?,
            None => {}
        }
        if let Some(at) = self.weather_stamp {
            write!(f, " --weather-stamp {}", at.name())?;
        }
        match self.date_order {
            Some(order) => write!(f, " --date-order {}", order.name()),
            None => Ok(()),
        }
    }
}

pub fn parse_time_zone(text: &str) -> Result<ClockZone, String> {
    let hint = "give hours ahead of UTC, -12 to 14, such as +01:00, -7, 5.5 or UTC, or a name such as Europe/Amsterdam";
    text.parse().map_err(|_| hint.into())
}

/// Returns the group of the options of [`ClockArgs`] for commands that need no weather: they
/// require the argument `weather`.
pub fn clock_of(weather: &'static str) -> ArgGroup {
    ArgGroup::new("clock").args(["time_zone", "shift", "weather_stamp", "date_order"]).multiple(true).requires(weather)
}

/// Returns the group of weather files that the options of the clock may describe.
pub fn weather_files() -> ArgGroup {
    ArgGroup::new("weather_files").args(["error_weather", "weather"]).multiple(true)
}
