//! Light and reflectances of a query. In: a sun or rows of weather, changes. Out: conditions, the
//! bins that they add to, and schedules of reflectances, as `heliotile
//! replay` makes them.

use std::path::Path;

use heliotile_core::error::{Error, Result};
use heliotile_core::light::states::Schedule;
use heliotile_core::replay::reflectances::Changeable;
use heliotile_core::units::{direction_from_degrees, kwh_from_w};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::bins::Bins;

use crate::asked::{Changes, Light, Span};
use crate::open::Opened;
use crate::weather::LoadedWeather;

/// Months of a year.
const MONTHS: usize = 12;

/// Input of a replay.
pub struct Forced {
    pub conditions: Vec<Condition>,
    pub bins: Bins,
    pub schedules: Vec<Schedule>,
}

/// Bins that conditions add to.
#[derive(Clone, Copy, Debug)]
pub enum Every {
    /// One mean for each hour, W/m2.
    Hour,
    /// Twelve sums, one a month, kWh/m2.
    Month,
    /// One sum, kWh/m2.
    Total,
}

/// Refuses a file in place of a value: the page has no files but those of its requests.
fn no_files(path: &Path) -> Result<Vec<u8>> {
    Err(Error::argument("changes", format!("`{}` is a file", path.display()), "give a number from 0 to 1"))
}

/// Returns the light of one moment.
pub fn moment(opened: &Opened, weather: Option<&LoadedWeather>, light: Light, changes: &Changes) -> Result<Forced> {
    match light {
        Light::Weather { hour } => {
            let (row, condition) = loaded(weather)?.condition(hour)?;
            let schedules = over(opened, &[row], changes)?;
            Ok(Forced { conditions: vec![condition], bins: Bins::each(1), schedules })
        }
        Light::Sun { azimuth, altitude, dni, dhi } => {
            let all = [azimuth, altitude, dni, dhi];
            if all.iter().any(|value| !value.is_finite()) || dni < 0.0 || dhi < 0.0 {
                let what = format!("{azimuth} and {altitude} degrees, DNI {dni}, DHI {dhi} W/m2");
                return Err(Error::argument("light", what, "give finite angles, and irradiances of 0 or more"));
            }
            let sun = direction_from_degrees(azimuth, altitude);
            // At altitude 0 the sine may round to above 0.
            let suns = if altitude > 0.0 { &[sun][..] } else { &[] };
            let condition = Condition::new("moment".into(), suns, sun, dni, dhi);
            Ok(Forced { conditions: vec![condition], bins: Bins::each(1), schedules: changed(opened, changes)? })
        }
    }
}

/// Returns the schedules of changes where no weather file gives dates.
pub fn changed(opened: &Opened, changes: &Changes) -> Result<Vec<Schedule>> {
    let changeable = Changeable::new(&opened.site, opened.archive.manifest());
    changes.checked()?.undated(&changeable, 1, &no_files)
}

/// Returns the light of a span of the weather file.
pub fn span(
    opened: &Opened,
    weather: Option<&mut LoadedWeather>,
    span: Span,
    every: Every,
    changes: &Changes,
) -> Result<Forced> {
    let loaded = loaded(weather)?;
    let (conditions, chosen) = loaded.conditions(span);
    let rows = loaded.weather.rows.iter().zip(&chosen).filter_map(|(row, chosen)| chosen.then_some(*row));
    let rows: Vec<WeatherRow> = rows.collect();
    let schedules = over(opened, &rows, changes)?;
    let weight = kwh_from_w(1.0, loaded.weather.interval_hours);
    let bins = match every {
        Every::Hour => Bins::each(conditions.len()),
        Every::Total => Bins { count: 1, of_condition: vec![(0, weight); conditions.len()] },
        Every::Month => {
            let month = |row: &WeatherRow| (row.interval.date.month as usize).saturating_sub(1).min(MONTHS - 1);
            Bins { count: MONTHS, of_condition: rows.iter().map(|row| (month(row), weight)).collect() }
        }
    };
    Ok(Forced { conditions, bins, schedules })
}

/// Returns the schedules over rows of the weather file: the ground by month where the archive
/// states it, then the changes.
fn over(opened: &Opened, rows: &[WeatherRow], changes: &Changes) -> Result<Vec<Schedule>> {
    let changeable = Changeable::new(&opened.site, opened.archive.manifest());
    Ok(changes.checked()?.over(&changeable, rows, &no_files)?.0)
}

/// Returns the weather, or an error if none is loaded.
fn loaded<W>(weather: Option<W>) -> Result<W> {
    weather.ok_or_else(|| Error::argument("weather", "there is none", "load a weather file"))
}
