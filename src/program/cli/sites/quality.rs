//! Accuracy of a build. In: options. Out: a named rung of the accuracy ladder, a target in percent,
//! or settings one by one.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;

use super::ClockArgs;
use crate::cli::values::choice;
use heliotile::output::same_place;
use heliotile::tracing::PREVIEWS;
use heliotile::{AccuracyRequest, Quality, WeatherOptions};

#[derive(Args, Debug)]
pub struct AccuracyArgs {
    /// Accuracy level: a named set of settings, from fast to accurate
    #[arg(long, value_parser = choice::<Quality>(), default_value = "standard", conflicts_with = "error")]
    pub quality: Quality,
    /// Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%:
    /// settings are tried on some of the receivers, and the cheapest that keep it are used
    #[arg(long, value_name = "PERCENT", conflicts_with = "set")]
    pub error: Option<Percent>,
    /// Weather file under which the errors of --error are estimated [default: suns from all sides]
    #[arg(long, value_name = "FILE", requires = "error")]
    pub error_weather: Option<PathBuf>,
    /// Change one setting of the accuracy level, such as `--set hit=16 --set sky_fine=512`; `info`
    /// of an archive lists the settings; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
}

impl AccuracyArgs {
    /// Returns the accuracy request, with default options of the weather file for errors.
    pub fn request(&self) -> AccuracyRequest {
        AccuracyRequest {
            quality: self.quality,
            set: self.set.clone(),
            error_percent: self.error.map(|Percent(percent)| percent),
            error_weather: self.error_weather.clone(),
            weather_options: WeatherOptions::default(),
        }
    }

    /// Returns the accuracy request of a command that also reads `weather`. Options of the clock
    /// describe `weather`. They apply to the weather file for errors only if that is the same file,
    /// or if the command reads no other.
    pub fn request_beside(&self, weather: Option<&Path>, clock: &ClockArgs) -> AccuracyRequest {
        let of_errors = self.error_weather.as_deref();
        let is_same = |weather: &Path| of_errors.is_some_and(|of_errors| same_place(of_errors, weather));
        let weather_options = match weather.is_none_or(is_same) {
            true => clock.options(false),
            false => WeatherOptions::default(),
        };
        AccuracyRequest { weather_options, ..self.request() }
    }
}

/// An error that is allowed, percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Percent(pub f64);

/// Smallest share that may be left out, percent: below, noise of the reference path tracer exceeds
/// the light.
const LEAST_NEGLIGIBLE: f64 = 0.001;

/// Parses `2%`, `0.5 %` or `2`.
impl FromStr for Percent {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (least, most) = (AccuracyRequest::ERRORS.start(), AccuracyRequest::ERRORS.end());
        percent(text, *least).ok_or_else(|| {
            format!("`{text}` is not a possible largest error: give {least} to {most} percent, as in 2%")
        })
    }
}

fn percent(text: &str, least: f64) -> Option<Percent> {
    let number = text.trim().trim_end_matches('%').trim_end().parse().ok()?;
    (least..=*AccuracyRequest::ERRORS.end()).contains(&number).then_some(Percent(number))
}

/// Parses the share of light that may be left out, percent: `0.5%`.
pub fn parse_negligible(text: &str) -> Result<Percent, String> {
    let most = AccuracyRequest::ERRORS.end();
    percent(text, LEAST_NEGLIGIBLE).ok_or_else(|| {
        format!("`{text}` is not a share that can be left out: give {LEAST_NEGLIGIBLE} to {most} percent, as in 0.5%")
    })
}

/// Parses the bound of a preview, percent: `1%`.
pub fn parse_preview(text: &str) -> Result<Percent, String> {
    let (least, most) = (PREVIEWS.start(), PREVIEWS.end());
    percent(text, *least).filter(|Percent(bound)| bound <= most).ok_or_else(|| {
        format!("`{text}` is not a possible bound of a preview: give {least} to {most} percent, as in 1%")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `2%`, `0.5 %` and `3` are percents; 5 wrong texts are refused. 0.01 % is too small for an
    /// error, but can be left out, and be the bound of a preview; 30 % cannot be a bound.
    #[test]
    fn percents_have_a_range_for_each_use() {
        for (text, value) in [("2%", 2.0), ("0.5 %", 0.5), ("3", 3.0)] {
            assert_eq!(text.parse(), Ok(Percent(value)));
        }
        for text in ["", "%", "0%", "two", "80%"] {
            assert!(text.parse::<Percent>().is_err() && parse_negligible(text).is_err(), "{text}");
            assert!(parse_preview(text).is_err(), "{text}");
        }
        assert_eq!(parse_preview("0.01%"), Ok(Percent(0.01)));
        assert!(parse_preview("30%").is_err());
        assert!("0.01%".parse::<Percent>().is_err());
        assert_eq!(parse_negligible("0.01%"), Ok(Percent(0.01)));
    }
}
