//! How exact a build is to be: a named rung of the accuracy ladder, a target in percent, or settings one by one.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use crate::cli::values::choice;
use heliotile_builder::settings::Quality;

#[derive(Args, Debug)]
pub struct AccuracyArgs {
    /// Rung of the accuracy ladder
    #[arg(long, value_parser = choice::<Quality>(), default_value = "standard", conflicts_with = "error")]
    pub quality: Quality,
    /// Largest RMSE of hourly totals, in percent of their mean, such as 2%: settings are chosen by trying some on a sample of the receivers
    #[arg(long, value_name = "PERCENT", conflicts_with = "set")]
    pub error: Option<Percent>,
    /// Weather file to estimate errors under [default: suns from all sides]
    #[arg(long, value_name = "FILE", requires = "error")]
    pub error_weather: Option<PathBuf>,
    /// One of the settings that `info` lists, such as `--set hit=16 --set sky_fine=512`
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
}

/// An error that is allowed, in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Percent(pub f64);

/// What can be asked for: below, 32-bit textures and the sun's disc say more than the weather does.
const LEAST: f64 = 0.1;
const MOST: f64 = 50.0;

/// Below, the judge's chance says more than the light does.
const LEAST_NEGLIGIBLE: f64 = 0.001;

/// `2%`, `0.5 %` or `2`.
impl FromStr for Percent {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        percent(text, LEAST)
            .ok_or_else(|| format!("`{text}` is no error to aim at: give {LEAST} to {MOST} percent, as in 2%"))
    }
}

fn percent(text: &str, least: f64) -> Option<Percent> {
    let number = text.trim().trim_end_matches('%').trim_end().parse().ok()?;
    (least..=MOST).contains(&number).then_some(Percent(number))
}

/// What may be left out, in percent: `0.5%`.
pub fn parse_negligible(text: &str) -> Result<Percent, String> {
    percent(text, LEAST_NEGLIGIBLE).ok_or_else(|| {
        format!("`{text}` is nothing to leave out: give {LEAST_NEGLIGIBLE} to {MOST} percent, as in 0.5%")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `2%`, `0.5 %` and `3` are percents; 5 wrong texts are refused; 0.01 % is no error, but can be left out.
    #[test]
    fn percents() {
        for (text, value) in [("2%", 2.0), ("0.5 %", 0.5), ("3", 3.0)] {
            assert_eq!(text.parse(), Ok(Percent(value)));
        }
        for text in ["", "%", "0%", "two", "80%"] {
            assert!(text.parse::<Percent>().is_err() && parse_negligible(text).is_err(), "{text}");
        }
        assert!("0.01%".parse::<Percent>().is_err());
        assert_eq!(parse_negligible("0.01%"), Ok(Percent(0.01)));
    }
}
