//! Arguments of `sunlight`, `glare` and `rules`.

use std::path::PathBuf;

use clap::Args;

use super::recombine::TableArgs;
use crate::cli::WeatherArgs;
use crate::cli::values::choice;
use heliotile::{ClockZone, DaySpan, Every, FileRequest, GlareChoice, SunlightRequest};

/// Days, rules and the format of maps.
#[derive(Args, Debug)]
pub struct DayArgs {
    /// Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and
    /// so on
    #[arg(long)]
    pub geo: bool,
    /// Year of the dates that state none; results of other years differ by a few minutes
    #[arg(long, default_value_t = SunlightRequest::default().year, value_parser = clap::value_parser!(i32).range(1..=2998))]
    pub year: i32,
    /// Rule to check: a name that `heliotile rules` lists, or a file with rules of your own
    /// (.toml); may be repeated
    #[arg(long, value_name = "NAME|FILE")]
    pub rule: Vec<String>,
    /// Archive or atlas before a change: adds its results, the minutes that changed, and the rules
    /// that are newly broken
    #[arg(long, value_name = "BEFORE")]
    pub before: Option<PathBuf>,
    /// Time zone of results: hours ahead of UTC, such as +01:00, or a name such as
    /// Europe/Amsterdam, with its summer time [default: that of the weather file if one is given,
    /// else whole hours by longitude]
    #[arg(long, value_name = "ZONE", allow_hyphen_values = true)]
    pub zone: Option<ClockZone>,
    /// Least altitude of the sun that counts, degrees; if a rule states one too, the higher one
    /// applies
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0)]
    pub least_altitude: f64,
    /// Refine moments at which an edge within a texel decides, by casting rays at the scene in the
    /// archive
    #[arg(long)]
    pub exact: bool,
}

impl DayArgs {
    /// Returns the output files.
    pub fn files(&self, table: &TableArgs, plots: &[PathBuf]) -> FileRequest {
        FileRequest { geo: self.geo, plots: plots.to_vec(), ..table.files() }
    }

    /// Returns the part of the request that `sunlight` and `glare` share.
    fn request(&self) -> SunlightRequest {
        SunlightRequest {
            year: self.year,
            rules: self.rule.clone(),
            before: self.before.clone(),
            zone: self.zone,
            least_altitude_deg: self.least_altitude,
            exact: self.exact,
            ..SunlightRequest::default()
        }
    }
}

#[derive(Args, Debug)]
pub struct SunlightArgs {
    #[command(flatten)]
    pub table: TableArgs,
    /// Draw a map of the first date or rule (.png), from above and from the south-west; may be
    /// repeated. A table is then written only if --output names one
    #[arg(long, value_name = "FILE")]
    pub plot: Vec<PathBuf>,
    /// Days to compute, separated by commas: 03-21, 2026-03-21, 02-19..10-21 or year; with --rule,
    /// the days for rules that state none
    #[arg(long, value_name = "DAYS", value_delimiter = ',')]
    pub dates: Vec<DaySpan>,
    /// Period of a row, without --rule: a day, or all days of a month, a year or all of them
    #[arg(long, value_parser = choice::<Every>(), default_value = "day")]
    pub every: Every,
    #[command(flatten)]
    pub days: DayArgs,
    /// Share of a row's area that must be lit for a moment to count, without --rule [default: any
    /// part of it]
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, hide_default_value = true)]
    pub lit_share: f64,
    /// Weather file for rules of probable sunlight hours: hours with a DNI of at least 120 W/m2
    /// count as sunny
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    #[command(flatten)]
    pub about_weather: WeatherArgs,
}

impl SunlightArgs {
    /// Returns the request of `sunlight`.
    pub fn request(&self) -> SunlightRequest {
        SunlightRequest {
            dates: self.dates.clone(),
            every: self.every,
            lit_share: self.lit_share,
            weather: self.weather.clone(),
            about_weather: self.about_weather.options(false),
            ..self.days.request()
        }
    }
}

#[derive(Args, Debug)]
pub struct GlareArgs {
    #[command(flatten)]
    pub table: TableArgs,
    /// Draw a calendar, days by time of day, coloured by pane (.svg), or a map of the first row or
    /// rule (.png); may be repeated. A table is then written only if --output names one
    #[arg(long, value_name = "FILE")]
    pub plot: Vec<PathBuf>,
    /// Table to write with a row for each spell, a time of unbroken reflected sun: receiver, day,
    /// start, end, pane, irradiance, angles
    #[arg(long, value_name = "FILE")]
    pub spells: Option<PathBuf>,
    /// Table or map to write of the panes, with the minutes in which each reflects the sun to
    /// receivers
    #[arg(long, value_name = "FILE")]
    pub panes: Option<PathBuf>,
    /// Days to compute, separated by commas: 03-21, 2026-03-21, 02-19..10-21 or year; with --rule,
    /// the days for rules that state none
    #[arg(long, value_name = "DAYS", value_delimiter = ',', default_value = "year")]
    pub dates: Vec<DaySpan>,
    /// Period of a row, without --rule: a day, or all days of a month, a year or all of them
    /// [default: total]
    #[arg(long, value_parser = choice::<Every>())]
    pub every: Option<Every>,
    #[command(flatten)]
    pub days: DayArgs,
    /// Least angle between the sun and its image in a mirror that counts, degrees; if a rule states
    /// one too, the larger one applies
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0)]
    pub least_deflection: f64,
    /// Largest angle between the direction of view of a receiver, its normal, and an image of the
    /// sun in a mirror that counts, degrees: 30 for a driver; if a rule states one too, the smaller
    /// one applies
    #[arg(long, value_name = "DEGREES", default_value_t = 90.0)]
    pub view_angle: f64,
}

impl GlareArgs {
    /// Returns the request of `glare`.
    pub fn request(&self) -> SunlightRequest {
        let glare = GlareChoice {
            least_deflection_deg: self.least_deflection,
            view_angle_deg: self.view_angle,
            spells: self.spells.clone(),
            panes: self.panes.clone(),
        };
        let usual = if self.days.rule.is_empty() { Every::Total } else { Every::Day };
        let every = self.every.unwrap_or(usual);
        SunlightRequest { dates: self.dates.clone(), every, glare: Some(glare), ..self.days.request() }
    }
}

#[derive(Args, Debug)]
pub struct RulesArgs {
    /// Rule whose file is printed, to be copied and changed [default: list all rules]
    pub name: Option<String>,
}
