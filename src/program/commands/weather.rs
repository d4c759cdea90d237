//! `heliotile info --weather`: a weather file as the reader understood it. In: a weather file. Out:
//! place, clock, span, and irradiation by month.

use std::fmt::Write;
use std::path::Path;

use super::{Outcome, say, warn};
use heliotile::scene::read_weather_as;
use heliotile::text::counted;
use heliotile::weather::WeatherSums;
use heliotile::{Result, WeatherOptions};

/// `heliotile info --weather`. `place` is a latitude and a longitude in place of those of the file.
pub fn info(path: &Path, about: &WeatherOptions, place: Option<(f64, f64)>) -> Result<Outcome> {
    let options = WeatherOptions {
        latitude_deg: place.map(|(latitude, _)| latitude),
        longitude_deg: place.map(|(_, longitude)| longitude),
        ..*about
    };
    let weather = read_weather_as(path, &options, &mut || Ok(None))?;
    weather.report.warnings.iter().for_each(warn);
    let site = &weather.site;
    let mut out = String::new();
    line!(out, "{}", path.display());
    let name = if weather.place.is_empty() { String::new() } else { format!("{}, ", weather.place) };
    line!(
        out,
        "  place       {name}latitude {} longitude {} (UTC{:+})",
        site.latitude_deg,
        site.longitude_deg,
        site.zone_hours
    );
    if let (Some(first), Some(last)) = (weather.rows.first(), weather.rows.last()) {
        let rows = counted(weather.rows.len() as u64, "row");
        let minutes = (weather.interval_hours * 6e4).round() / 1e3;
        let (from, to) = (first.interval.label(), last.interval.label());
        line!(out, "  rows        {rows} of {minutes} minutes, the first starts {from}, the last {to}");
    }
    line!(out, "  kWh/m2        hours        GHI        DNI        DHI");
    for ((year, month), sums) in weather.monthly_sums() {
        line!(out, "  {year}-{month:02}    {}", cells(&sums));
    }
    line!(out, "  all        {}", cells(&weather.sums()));
    say(&out)?;
    Ok(Outcome::Fine)
}

/// Returns the sums as cells of a row; a GHI that the file does not state is a dash.
fn cells(sums: &WeatherSums) -> String {
    let WeatherSums { hours, ghi_kwh_m2, dni_kwh_m2, dhi_kwh_m2 } = sums;
    let ghi = ghi_kwh_m2.map_or("-".to_owned(), |ghi| format!("{ghi:.3}"));
    format!("{hours:>8.0} {ghi:>10} {dni_kwh_m2:>10.3} {dhi_kwh_m2:>10.3}")
}
