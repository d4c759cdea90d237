//! One engine: an archive, a weather file, and kept results. In: a request. Out: its answer.

use heliotile_core::error::Result;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_sunlight::DayMinutes;
use serde_json::json;

use crate::Answered;
use crate::answer::{Answer, Numbers};
use crate::asked::{Span, SumAsk, columns};
use crate::clouds::Clouds;
use crate::comfort::{ComfortAsk, PeopleValues, air_of, facts};
use crate::failure::{Failure, Kind};
use crate::interactive::InteractiveTiles;
use crate::light::Every;
use crate::open::Opened;
use crate::people::People;
use crate::recombined::{Key, Recombinations, of_receiver, of_tile};
use crate::request::Request;
use crate::site::{Beside, Site};
use crate::weather::LoadedWeather;
use crate::{fisheye, geometry, light, matching, receivers, textures, weather};

/// Months of a year.
const MONTHS: u32 = 12;

/// State of a worker.
#[derive(Default)]
pub struct Engine {
    opened: Option<Opened>,
    weather: Option<LoadedWeather>,
    recombinations: Recombinations,
    moments: InteractiveTiles,
    clouds: Clouds,
    /// People of the archive, once the page asked for them: `Some(None)` if its receivers are no
    /// people.
    people: Option<Option<People>>,
    /// Comfort in the last moment, and over the last span.
    felt: [Option<PeopleValues>; 2],
    /// Last day of the year for which the page asked for minutes of sun, and its minutes.
    day: Option<(u32, DayMinutes)>,
}

impl Engine {
    /// Answers a request in JSON, with the bytes that go with it.
    pub fn answer(&mut self, request: &[u8], bytes: Vec<u8>) -> Answered {
        let request: Request = serde_json::from_slice(request)
            .map_err(|error| Failure::new(Kind::Other, format!("the request cannot be read: {error}"), ""))?;
        if let Request::Open { name, bytes, beside } = request {
            return self.open(&name, bytes, beside.as_ref());
        }
        let Engine { opened, weather, recombinations, moments, clouds, people, felt, day } = self;
        let opened = opened.as_ref().ok_or_else(|| Failure::new(Kind::Other, "no archive is open", "open one"))?;
        let manifest = opened.archive.manifest();
        match request {
            Request::Open { .. } => Err(Failure::new(Kind::Other, "an archive is open", "")),
            Request::Share { workers } => {
                moments.share(workers);
                Ok(Answer::of(json!({})))
            }
            Request::Match { before, after } => Ok(matching::matched(before, after)),
            Request::Scene { chunk } => geometry::scene(opened, chunk),
            Request::Overview { tile } => geometry::overview(opened, tile),
            Request::Receivers { tile } => receivers::receivers(opened, tile),
            Request::LoadWeather { name, options } => {
                // Only archives of people need the air. A column of it that cannot be read must not
                // make the file useless to other archives.
                let read = |with_air| {
                    let options = WeatherOptions { with_air, ..options.options()? };
                    LoadedWeather::read(&name, &bytes, &options, manifest)
                };
                let with_air = People::are_likely(opened).unwrap_or(false);
                let loaded = match read(with_air) {
                    Err(error) if with_air => read(false)?.without_air(error),
                    other => other?,
                };
                recombinations.clear();
                *felt = [None, None];
                *day = None;
                moments.clear();
                Ok(weather.insert(loaded).info(&name))
            }
            Request::Clouds { side, map } => {
                recombinations.clear();
                *felt = [None, None];
                moments.clear();
                clouds.take(side, &bytes, map)
            }
            Request::TurnClouds { top } => {
                recombinations.clear();
                *felt = [None, None];
                moments.clear();
                clouds.turn(top);
                Ok(Answer::of(json!({})))
            }
            Request::Sun { day_of_year, minutes } => {
                Ok(weather::sun(weather.as_ref(), manifest.place, day_of_year, minutes)?)
            }
            Request::Clear { day_of_year, minutes } => {
                Ok(weather::clear(weather.as_ref(), manifest.place, day_of_year, minutes)?)
            }
            Request::Moment { ask, tile, next } => {
                let columns = columns(&ask.components)?;
                let force = || clouds.over(&ask.sky, light::moment(opened, weather.as_ref(), ask.light, &ask.changes)?);
                let values = moments.values(opened, &ask, tile, &next, force)?;
                of_tile(opened, tile, &columns, &values)
            }
            Request::Light { ask } => {
                let force = || clouds.over(&ask.sky, light::moment(opened, weather.as_ref(), ask.light, &ask.changes)?);
                let light = moments.light(opened, &ask, force)?;
                Ok(textures::light(&light.texels(opened.site.settings().sky_base, manifest.settings.patches())))
            }
            Request::Textures { changes, tile, next } => {
                let schedules = light::changed(opened, &changes)?;
                moments.textures(opened, schedules, tile, &next, |made| textures::tile(opened.first(tile), made))
            }
            Request::Sums { ask, tile } => {
                let SumAsk { span, sky, changes, .. } = ask.clone();
                let force = || clouds.over(&sky, light::span(opened, weather.as_mut(), span, Every::Total, &changes)?);
                let key = Key::Sums(ask);
                let values = recombinations.values(opened, &key, tile, force)?;
                of_tile(opened, tile, &key.columns()?, &values)
            }
            Request::SunMinutes { ask, tile } => {
                let tile = opened.tile(tile)?;
                if day.as_ref().is_none_or(|(of, _)| *of != ask.day_of_year) {
                    let location = weather::location(weather.as_ref(), manifest.place)?;
                    let date = weather::date(weather.as_ref(), ask.day_of_year)?;
                    *day = Some((ask.day_of_year, DayMinutes::new(&opened.site, &location, date)));
                }
                let none = || Failure::new(Kind::Other, "there is no day", "");
                let (_, day) = day.as_ref().ok_or_else(none)?;
                let of = if ask.in_mirrors { DayMinutes::glare } else { DayMinutes::sun };
                let answer = Answer::of(json!({ "tile": tile, "first": opened.first(tile) }));
                Ok(answer.with("minutes", Numbers::F32(&of(day, &opened.site, tile)?)))
            }
            Request::People => Ok(People::answer(found(people, opened)?.as_ref())),
            Request::Air { air } => Ok(facts(&air_of(air, weather.as_ref())?)),
            Request::Comfort { ask, tile, next } => {
                let none = || Failure::new(Kind::Other, "the receivers are no people", "");
                let people = found(people, opened)?.as_mut().ok_or_else(none)?;
                let [moment, span] = felt;
                let kept = if ask.light().is_some() { moment } else { span };
                let felt = match kept.take().filter(|kept| kept.is_of(&ask)) {
                    Some(felt) => kept.insert(felt),
                    None => kept.insert(PeopleValues::new(opened, weather.as_ref(), &ask)?),
                };
                felt.tile(opened, people, tile, |tile| match (ask.light(), &ask) {
                    (Some(light), _) => {
                        let of = || light::moment(opened, weather.as_ref(), light.light, &light.changes);
                        moments.values(opened, &light, tile, &next, || clouds.over(&light.sky, of()?))
                    }
                    (None, ComfortAsk::Span { span, sky, changes }) => {
                        let key = Key::Hours { span: *span, sky: sky.clone(), changes: changes.clone() };
                        let mut of = || light::span(opened, weather.as_mut(), *span, Every::Hour, changes);
                        recombinations.values(opened, &key, tile, || clouds.over(sky, of()?))
                    }
                    (None, ComfortAsk::Moment { .. }) => Err(Failure::new(Kind::Other, "there is no light", "")),
                })
            }
            Request::Months { tile, row, sky, changes } => {
                let key = Key::Months { sky: sky.clone(), changes: changes.clone() };
                let force =
                    || clouds.over(&sky, light::span(opened, weather.as_mut(), Span::Year, Every::Month, &changes)?);
                let values = recombinations.values(opened, &key, tile, force)?;
                let labels: Vec<String> = (1..=MONTHS).map(|month| format!("{month:02}")).collect();
                of_receiver(&labels, row, &values)
            }
            Request::Day { tile, row, day_of_year, sky, changes } => {
                let span = Span::Day { day_of_year };
                let labels = weather.as_ref().map_or_else(Vec::new, |loaded| loaded.labels(span));
                let key = Key::Day { day_of_year, sky: sky.clone(), changes: changes.clone() };
                let force = || clouds.over(&sky, light::span(opened, weather.as_mut(), span, Every::Hour, &changes)?);
                let values = recombinations.values(opened, &key, tile, force)?;
                of_receiver(&labels, row, &values)
            }
            Request::Fisheye { tile, row, side } => fisheye::fisheye(opened, weather.as_ref(), tile, row, side),
        }
    }

    fn open(&mut self, name: &str, bytes: u64, beside: Option<&Beside>) -> Answered {
        if self.opened.is_some() {
            return Err(Failure::new(Kind::Other, "this engine has an archive", "start another one"));
        }
        let opened = Opened::new(name, bytes)?;
        let place = opened.archive.manifest().place;
        if beside.is_some_and(|beside| !beside.is_of(place.as_ref())) {
            let what =
                place.map_or("the archive states no place".into(), |place| format!("the archive lies at {place}"));
            return Err(Failure::new(Kind::OtherPlace, what, ""));
        }
        let site = Site::new(&opened, bytes);
        self.opened = Some(opened);
        Ok(Answer::of(site))
    }
}

/// Returns the people of the archive, and looks for them at the first call only.
fn found<'p>(people: &'p mut Option<Option<People>>, opened: &Opened) -> Result<&'p mut Option<People>> {
    match people.take() {
        Some(known) => Ok(people.insert(known)),
        None => Ok(people.insert(People::new(opened)?)),
    }
}
