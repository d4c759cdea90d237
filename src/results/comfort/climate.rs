//! Climate of each hour, which all points share. In: conditions with their air, or a weather file,
//! and properties of surfaces. Out: radiation on a person and the comfort indices of the hour; or
//! an error that names what the file lacks.

use super::columns::ComfortColumns;
use super::request::{ComfortRequest, WindChoice};
use crate::resources::Resources;
use rayon::prelude::*;

use heliotile_comfort::people::climate::{HourAir, HourClimate, MissingAir};
use heliotile_comfort::people::columns::ComfortColumn;
use heliotile_comfort::people::model::ComfortModel;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Silent;
use heliotile_core::replay::schedule_csv::{Column, Rows, parse_schedule};
use heliotile_core::weather::air::Air;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::emission::Emission;
use heliotile_core::weather::time::calendar::Date;
use heliotile_weather::formats::weather_file::ScenePlace;
use heliotile_weather::temperatures::emissions;

/// Column of wind speeds in a schedule.
const WIND: Column = Column { name: "wind_m_s", low: 0.0, high: 60.0 };

/// Returns the climates of conditions; their air must be known.
pub(super) fn climates(
    request: &ComfortRequest,
    conditions: &[Condition],
    model: &ComfortModel,
    asked: &[ComfortColumn],
    resources: &Resources,
) -> Result<Vec<HourClimate>> {
    let dates: Vec<_> = conditions.iter().filter_map(|condition| Some(condition.stamp?.date)).collect();
    let winds = winds(request, &dates, resources)?;
    let of_hour = |(i, condition): (usize, &Condition)| {
        let air = Hour { air: condition.air.unwrap_or_default(), emission: condition.emission, wind: winds.get(i) };
        let hour = HourAir { hours: condition.stamp.map_or(1.0, |stamp| stamp.hours), ..air.known_to(request) };
        hour.climate(model, asked).map_err(|missing| refused(request, missing, &condition.label))
    };
    conditions.par_iter().enumerate().map(of_hour).collect()
}

impl ComfortRequest {
    /// Refuses weather that comfort cannot be computed from, before anything is traced: a file that
    /// cannot be read, or hours without values that columns depend on. `place` is the place of the
    /// scene, used if the file states none. The observer gets no messages here; it gets them when
    /// the archive is replayed.
    pub fn check_weather(&self, resources: &Resources, place: ScenePlace) -> Result<()> {
        let resources = Resources { observer: &Silent, ..*resources };
        let stream = self.stream();
        let weather = stream.read_weather(&resources, place)?;
        let chosen = stream.dated(&weather, &Silent)?.chosen;
        let file = &self.replay.weather;
        let emissions = emissions(&weather, file, &chosen, &self.replay.temperatures, resources.files)?;
        let rows: Vec<_> = weather.rows.iter().zip(&weather.air).zip(&chosen).filter(|(_, chosen)| **chosen).collect();
        let dates: Vec<_> = rows.iter().map(|((row, _), _)| row.interval.date).collect();
        let winds = winds(self, &dates, &resources)?;
        let columns = ComfortColumns::new(&self.choice.columns, self.replay.every, &self.choice.above_c);
        let asked: Vec<ComfortColumn> = columns.asked().collect();
        for (i, (((row, air), _), emission)) in rows.into_iter().zip(emissions).enumerate() {
            let hour = Hour { air: *air, emission: Some(emission), wind: winds.get(i) }.known_to(self);
            hour.check(&asked).map_err(|missing| refused(self, missing, &row.interval.label()))?;
        }
        Ok(())
    }
}

/// Weather data of an hour.
struct Hour<'w> {
    air: Air,
    emission: Option<Emission>,
    /// Wind from a schedule, if there is one.
    wind: Option<&'w f64>,
}

impl Hour<'_> {
    /// Returns the air of the hour, with the wind that the request chooses.
    fn known_to(&self, request: &ComfortRequest) -> HourAir {
        let wind_m_s = match (&request.choice.wind, self.wind) {
            (WindChoice::Factor(factor), None) => self.air.wind_m_s.map(|wind| factor * wind),
            (_, wind) => wind.copied(),
        };
        HourAir { air: self.air, emission: self.emission, wind_m_s, hours: 1.0 }
    }
}

/// Reads winds from the request's schedule, one a date; empty if it names none.
fn winds(request: &ComfortRequest, dates: &[Date], resources: &Resources) -> Result<Vec<f64>> {
    let WindChoice::File(file) = &request.choice.wind else { return Ok(Vec::new()) };
    parse_schedule(file, &(resources.files)(file)?, WIND, Rows::Dated(dates))
}

/// Returns the error for an hour without a required value.
fn refused(request: &ComfortRequest, missing: MissingAir, label: &str) -> Error {
    let hint = "fill in the column, leave such rows out with {from} and {to}, or choose columns that do not need it, such as {columns} \
                mrt; {wind} gives a wind";
    Error::input(&request.replay.weather, None, missing.in_hour(label), hint).because(Problem::Lacks(missing.0))
}
