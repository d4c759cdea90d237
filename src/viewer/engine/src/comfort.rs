//! Comfort of people in a moment, or over a span of the weather. In: light, air, the people of the
//! archive. Out: numbers of each receiver's point, tile by tile. The formulas are the core's, as in
//! `heliotile comfort`.

use std::collections::HashMap;

use heliotile_comfort::people::climate::{HourAir, HourClimate};
use heliotile_comfort::people::columns::ComfortColumn;
use heliotile_comfort::people::light::PersonLight;
use heliotile_comfort::people::model::ComfortModel;
use heliotile_comfort::people::periods::PeriodSum;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::weather::air::Air;
use heliotile_core::weather::time::bins::Bins;
use serde::Deserialize;
use serde_json::json;

use crate::Answered;
use crate::answer::{Answer, Numbers};
use crate::asked::{AirAsk, Changes, Light, MomentAsk, Span};
use crate::failure::Failure;
use crate::open::Opened;
use crate::people::People;
use crate::weather::LoadedWeather;

/// Columns of a moment.
pub const MOMENT: [ComfortColumn; 5] = [
    ComfortColumn::Utci,
    ComfortColumn::MeanRadiant,
    ComfortColumn::Pet,
    ComfortColumn::Shortwave,
    ComfortColumn::Longwave,
];

/// Columns of a span. The PET is left out: an hour of it costs over ten times one of the UTCI.
const SUMS: [ComfortColumn; 2] = [ComfortColumn::MeanRadiant, ComfortColumn::Utci];

/// Returns the names of the numbers of a span.
pub fn sum_names() -> Vec<String> {
    of_span().map(|(column, sum)| column.names().iter().map(|name| sum.name(name)).collect()).collect()
}

/// Returns the columns of a span, each with every sum that is made of it.
fn of_span() -> impl Iterator<Item = (ComfortColumn, PeriodSum)> {
    let above_c = PeriodSum::usual_thresholds_c();
    SUMS.into_iter()
        .flat_map(move |column| PeriodSum::of_column(column, &above_c).into_iter().map(move |sum| (column, sum)))
}

/// Query for comfort in a moment or over a span.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase", tag = "of")]
pub enum ComfortAsk {
    Moment { light: Light, sky: String, changes: Changes, air: AirAsk },
    Span { span: Span, sky: String, changes: Changes },
}

impl ComfortAsk {
    /// Returns the query for the light of a moment, or `None` for a span.
    pub fn light(&self) -> Option<MomentAsk> {
        let ComfortAsk::Moment { light, sky, changes, .. } = self else { return None };
        Some(MomentAsk { light: *light, sky: sky.clone(), changes: changes.clone(), components: Vec::new() })
    }

    fn columns(&self) -> &'static [ComfortColumn] {
        match self {
            ComfortAsk::Moment { .. } => &MOMENT,
            ComfortAsk::Span { .. } => &SUMS,
        }
    }

    fn names(&self) -> Vec<String> {
        match self {
            ComfortAsk::Moment { .. } => MOMENT.iter().flat_map(|column| column.names()).collect(),
            ComfortAsk::Span { .. } => sum_names(),
        }
    }

    /// Returns the air of the query's hours, with their labels.
    fn hours(&self, weather: Option<&LoadedWeather>) -> Result<Vec<(HourAir, String)>> {
        match self {
            ComfortAsk::Moment { air, .. } => Ok(vec![(HourAir::new(air_of(*air, weather)?), air.label(weather))]),
            ComfortAsk::Span { span, .. } => {
                let loaded = weather.ok_or_else(no_weather)?;
                loaded.expect_air()?;
                Ok(loaded.airs(*span).into_iter().zip(loaded.labels(*span)).collect())
            }
        }
    }
}

/// Returns the air of a moment: of a row of the weather, or by numbers.
pub fn air_of(ask: AirAsk, weather: Option<&LoadedWeather>) -> Result<Air> {
    match ask {
        AirAsk::Weather { hour } => weather.ok_or_else(no_weather)?.air(hour),
        AirAsk::Own { temperature, humidity, wind, cover } => {
            let ranges = [
                ("air temperature", temperature, -60.0..=60.0),
                ("humidity", humidity, 1.0..=100.0),
                ("wind", wind, 0.0..=60.0),
                ("cloud cover", cover, 0.0..=10.0),
            ];
            if let Some((name, value, range)) = ranges.iter().find(|(_, value, range)| !range.contains(value)) {
                let hint = format!("give {} to {}", range.start(), range.end());
                return Err(Error::argument("weather", format!("the {name} is {value}"), hint));
            }
            let air = Air::of_humidity(temperature, humidity);
            Ok(Air { wind_m_s: Some(wind), opaque_sky_tenths: Some(cover), ..air })
        }
    }
}

fn no_weather() -> Error {
    Error::argument("weather", "there is none", "load a weather file")
}

/// Bits of the six planes of a point.
const ALL_PLANES: u8 = 0b11_1111;

/// Comfort numbers of one query, found tile by tile. Points whose planes lie in two tiles wait for
/// both.
pub struct PeopleValues {
    ask: ComfortAsk,
    model: ComfortModel,
    climates: Vec<HourClimate>,
    /// `[tile]`: true if the light of the tile was taken.
    taken: Vec<bool>,
    /// Points that lack planes: a bit for each plane whose light is there, and that light.
    waiting: HashMap<usize, (u8, PersonLight)>,
    /// `[point]`: comfort numbers of the point, `None` until they are found.
    found: Vec<Option<Box<[f32]>>>,
}

impl PeopleValues {
    /// Starts the numbers of a query. Returns an error if the air of one of its hours is not known.
    pub fn new(
        opened: &Opened,
        weather: Option<&LoadedWeather>,
        ask: &ComfortAsk,
    ) -> std::result::Result<Self, Failure> {
        let model = ComfortModel::usual(opened.site.materials());
        let climate = |(hour, label): (HourAir, String)| {
            hour.climate(&model, ask.columns()).map_err(|missing| {
                let hint = "fill it in there, or set the sun and the air by numbers";
                Error::argument("weather", missing.in_hour(&label), hint)
            })
        };
        let climates = ask.hours(weather)?.into_iter().map(climate).collect::<Result<_>>()?;
        let taken = vec![false; opened.site.tiles() as usize];
        let ask = ask.clone();
        Ok(PeopleValues { ask, model, climates, taken, waiting: HashMap::new(), found: Vec::new() })
    }

    /// Returns true if the numbers belong to this query.
    pub fn is_of(&self, ask: &ComfortAsk) -> bool {
        self.ask == *ask
    }

    /// Returns the numbers of a tile's receivers, each those of its point. `light` returns the
    /// light of a tile in all hours.
    pub fn tile(
        &mut self,
        opened: &Opened,
        people: &mut People,
        tile: u32,
        mut light: impl FnMut(u32) -> std::result::Result<TileValues, Failure>,
    ) -> Answered {
        let points = people.in_tile(opened, tile)?;
        for &point in &points {
            for plane in people.planes(opened, point)? {
                if self.taken.get(plane.tile as usize) == Some(&false) {
                    self.take(opened, people, plane.tile, &light(plane.tile)?)?;
                }
            }
        }
        let names = self.ask.names();
        let mut columns = vec![Vec::with_capacity(points.len()); names.len()];
        for point in points {
            let numbers = self.found.get(point).and_then(Option::as_ref);
            for (number, column) in columns.iter_mut().enumerate() {
                column.push(numbers.and_then(|numbers| numbers.get(number)).copied().unwrap_or(f32::NAN));
            }
        }
        let answer = Answer::of(json!({ "tile": tile, "first": opened.first(tile) }));
        let all = names.iter().zip(&columns);
        Ok(all.fold(answer, |answer, (name, column)| answer.with(name, Numbers::F32(column))))
    }

    /// Takes the light of a tile, and finds the numbers of the points that it completes.
    fn take(
        &mut self,
        opened: &Opened,
        people: &mut People,
        tile: u32,
        values: &TileValues,
    ) -> std::result::Result<(), Failure> {
        for (row, point) in people.in_tile(opened, tile)?.into_iter().enumerate() {
            let planes = people.planes(opened, point)?;
            let Some(plane) = planes.iter().position(|plane| plane.tile == tile && plane.row == row) else { continue };
            let (there, light) = self.waiting.entry(point).or_default();
            light.put(plane, values.row(Component::Total, row), values.row(Component::SunDirect, row));
            *there |= 1_u8 << plane;
            if *there != ALL_PLANES {
                continue;
            }
            let Some((_, light)) = self.waiting.remove(&point) else { continue };
            let views = people.views(opened, point)?;
            let mut hours = light.numbers(&views, &self.climates, self.ask.columns(), &self.model);
            let numbers = match &self.ask {
                ComfortAsk::Moment { .. } => hours.values.iter().filter_map(|hours| hours.first().copied()).collect(),
                ComfortAsk::Span { .. } => {
                    hours.bound();
                    self.over(&hours.values)
                }
            };
            if self.found.len() <= point {
                self.found.resize(point + 1, None);
            }
            if let Some(found) = self.found.get_mut(point) {
                *found = Some(numbers);
            }
        }
        if let Some(taken) = self.taken.get_mut(tile as usize) {
            *taken = true;
        }
        Ok(())
    }

    /// Returns the numbers of the whole span from those of its hours.
    fn over(&self, hours: &[Vec<f32>]) -> Box<[f32]> {
        let lengths: Vec<f64> = self.climates.iter().map(|climate| climate.hours).collect();
        let bins = Bins { count: 1, of_condition: vec![(0, 1.0); lengths.len()] };
        let of = |(column, sum): (ComfortColumn, PeriodSum)| {
            let values = SUMS.iter().position(|other| *other == column).and_then(|place| hours.get(place));
            values.and_then(|values| sum.of_hours(values, &bins, &lengths).pop()).unwrap_or(f32::NAN)
        };
        of_span().map(of).collect()
    }
}

/// Returns the known values of the air of a moment, for display; unknown values are null.
pub fn facts(air: &Air) -> Answer {
    Answer::of(json!({
        "temperature": air.dry_bulb_c,
        "humidity": HourAir::new(*air).humidity_percent(),
        "wind": air.wind_m_s,
        "sky": air.sky_w_m2(),
    }))
}
