//! What is asked of a replay or a query. In: plain values of `heliotile/archive.py`. Out: conditions with their labels, choices of light.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use serde_json::{Map, Value};

use crate::errors::wrong;
use heliotile::atlas::Archives;
use heliotile::files::read_file;
use heliotile::recombine::{
    Every, Provenance, Recombination, Series, WeatherReading, dated_rows, left_out, mean_ground, no_longwave,
};
use heliotile::{Archive, Component, ComponentList, Error, MemoryBudget, Observer, Result, by_name};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::replay::reflectances::{Changes, ConstantOrFile};
use heliotile_core::weather::conditions::parse_conditions;
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::formats::weather_file::parse_weather_as;
use heliotile_core::weather::options::{WeatherOptions, parse_zone};
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::{Moment, Span};
use heliotile_core::weather::temperatures::Temperature;

/// A file, or the bytes that stand in for one of that name.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Source {
    name: PathBuf,
    bytes: Option<PyBackedBytes>,
}

/// A number, or values over time: the bytes of a schedule, or its file.
#[derive(FromPyObject)]
pub enum Follow {
    Values(PyBackedBytes),
    Constant(f64),
    File(PathBuf),
}

/// Choices of both.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LightArgs {
    columns: Option<String>,
    sky: String,
    patches: Option<usize>,
    paths: String,
    bounces: Option<u32>,
    reflectance: Vec<(String, Follow)>,
    transmittance: Vec<(String, Follow)>,
    memory: u64,
}

/// Choices of a replay.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ReplayArgs {
    weather: Source,
    latitude: Option<f64>,
    longitude: Option<f64>,
    time_zone: Option<String>,
    shift: Option<String>,
    weather_stamp: Option<String>,
    date_order: Option<String>,
    every: String,
    stamp: String,
    year: Option<i32>,
    from: Option<String>,
    to: Option<String>,
    steps: Option<usize>,
    snow: Option<String>,
    snow_reflectance: f64,
    temperature: Vec<(String, Follow)>,
}

/// What conditions come from.
pub enum Forcing {
    Weather(Box<ReplayArgs>),
    Conditions(Source),
}

/// All that is asked, checked as far as it can be without the archive.
pub struct Asked {
    forcing: Forcing,
    pub columns: ComponentList,
    light: LightArgs,
    paths: LightPaths,
    changes: Changes,
    temperature: Vec<Temperature>,
    /// The same as on the command line.
    temperatures: Vec<String>,
    /// What stands in for files that messages name.
    given: HashMap<PathBuf, PyBackedBytes>,
}

/// Largest number of diffuse reflections, as on the command line.
const MOST_BOUNCES: u32 = 64;

/// Largest number of sun positions in an interval, as on the command line.
const MOST_STEPS: usize = 60;

impl LightArgs {
    /// Bytes to work in.
    pub fn memory(&self) -> MemoryBudget {
        MemoryBudget::new(self.memory)
    }
}

impl Asked {
    /// Of arguments. An error: a name that is not known, a share that is none.
    pub fn new(mut light: LightArgs, mut forcing: Forcing) -> Result<Self> {
        let columns = light.columns.as_deref().map(str::parse::<ComponentList>).transpose();
        let columns = columns.map_err(wrong("columns", "name some of them, as in [\"total\", \"sun_direct\"]"))?;
        let columns = columns.unwrap_or_else(ComponentList::all);
        let paths =
            light.paths.parse::<LightPaths>().map_err(wrong("paths", "give \"all\", \"none\" or some names"))?;
        let depth = match light.bounces {
            None => MaxBounces::All,
            Some(count @ 1..=MOST_BOUNCES) => MaxBounces::Count(count),
            Some(count) => {
                let hint = "give a number of reflections from 1 to 64, or leave it out for all";
                return Err(Error::argument("bounces", format!("is {count}"), hint));
            }
        };
        let paths = paths.with_depth(depth).map_err(wrong("bounces", "name `bounces` among paths, or leave it out"))?;
        let mut given = HashMap::new();
        let mut changes = Changes::default();
        for (name, follow) in std::mem::take(&mut light.reflectance) {
            match follow {
                Follow::Constant(value) => changes.constant.push((name, share("reflectance", value)?)),
                Follow::File(file) => changes.scheduled.push((name, file)),
                Follow::Values(bytes) => {
                    let file = stand_in(&mut given, "reflectance", &name, bytes);
                    changes.scheduled.push((name, file));
                }
            }
        }
        for (name, follow) in std::mem::take(&mut light.transmittance) {
            let follow = match follow {
                Follow::Constant(value) => ConstantOrFile::Value(share("transmittance", value)?),
                Follow::File(file) => ConstantOrFile::File(file),
                Follow::Values(bytes) => ConstantOrFile::File(stand_in(&mut given, "transmittance", &name, bytes)),
            };
            changes.transmittance.push((name, follow));
        }
        let (mut temperature, mut temperatures) = (Vec::new(), Vec::new());
        match &mut forcing {
            Forcing::Conditions(_) => no_longwave(&columns)?,
            Forcing::Weather(replay) => {
                if let Some(snow) = &replay.snow {
                    changes.snow = Some((by_name("snow", snow)?, share("snow_reflectance", replay.snow_reflectance)?));
                }
                if replay.steps.is_some_and(|steps| !(1..=MOST_STEPS).contains(&steps)) {
                    return Err(Error::argument(
                        "steps",
                        "is not from 1 to 60",
                        "leave it out for those of the archive",
                    ));
                }
                for (name, follow) in std::mem::take(&mut replay.temperature) {
                    let of = match follow {
                        Follow::Constant(value) => value.to_string(),
                        Follow::File(file) => file.display().to_string(),
                        Follow::Values(bytes) => {
                            stand_in(&mut given, "temperature", &name, bytes).display().to_string()
                        }
                    };
                    let hint = "give {\"ground\": 15.0} or {\"obstruction\": values}";
                    let text = format!("{name}={of}");
                    temperature.push(text.parse().map_err(wrong("temperature", hint))?);
                    temperatures.push(text);
                }
            }
        }
        let asked = Asked { forcing, columns, light, paths, changes, temperature, temperatures, given };
        if !asked.temperature.is_empty() && !asked.is_longwave() {
            let (what, hint) = ("no column depends on it", "ask for columns=[\"total\", \"longwave\"]");
            return Err(Error::argument("temperature", what, hint));
        }
        Ok(asked)
    }

    fn is_longwave(&self) -> bool {
        self.columns.set().contains(Component::Longwave)
    }

    /// The bytes of a file, or of what stands in for one.
    fn read(&self, path: &Path) -> Result<Vec<u8>> {
        self.given.get(path).map_or_else(|| read_file(path), |bytes| Ok(bytes.to_vec()))
    }

    /// Conditions of what is open with their labels and choices of light; what is odd is told.
    pub fn with_series<T>(
        &self,
        archives: Archives,
        storage: &dyn ScratchSpace,
        observer: &dyn Observer,
        then: impl FnOnce(&Series, &Recombination) -> Result<T>,
    ) -> Result<T> {
        let files = |path: &Path| self.read(path);
        let recombination = Recombination {
            sky: self.light.sky.parse().map_err(wrong("sky", "give perez, perez1990, uniform, or cie:1 to cie:15"))?,
            patches: self.light.patches,
            paths: self.paths,
            memory: self.light.memory(),
            storage,
            files: &files,
        };
        let archive = archives.first();
        let class = if archives.only().is_some() { "Archive" } else { "Atlas" };
        match &self.forcing {
            Forcing::Conditions(source) => {
                let file = parse_conditions(&source.name, &source.read()?)?;
                file.warnings.iter().for_each(|w| observer.warn(w));
                mean_ground(archive, &self.changes)?.iter().for_each(|w| observer.warn(w));
                left_out(archive, None).iter().for_each(|w| observer.warn(w));
                let about = Provenance::new(format!("heliotile.{class}.query"), self.options())
                    .with("conditions", source.name.display());
                let series = Series::of_conditions(file.conditions, self.changes.clone(), about);
                then(&series, &recombination)
            }
            Forcing::Weather(replay) => {
                let (weather, dated) = replay.read(archive, self.is_longwave(), observer)?;
                let reading = WeatherReading {
                    file: &replay.weather.name,
                    every: by_name("every", &replay.every)?,
                    stamp: by_name("stamp", &replay.stamp)?,
                    steps: replay.steps,
                    longwave: self.is_longwave().then_some(&self.temperature),
                    files: &files,
                };
                let about = Provenance::new(format!("heliotile.{class}.replay"), self.options());
                let read = (&weather, &dated);
                let series = Series::of_weather(archive, read, &reading, self.changes.clone(), about)?;
                then(&series, &recombination)
            }
        }
    }

    /// All that may change values, by the names of the command line, for those who ask how results were made.
    fn options(&self) -> Map<String, Value> {
        let (light, changes) = (&self.light, &self.changes);
        let named = |(name, value): (&String, String)| Value::from(format!("{name}={value}"));
        let follow = |follow: &ConstantOrFile| match follow {
            ConstantOrFile::Value(value) => value.to_string(),
            ConstantOrFile::File(file) => file.display().to_string(),
        };
        let columns: Vec<&str> = self.columns.as_slice().iter().map(|column| column.name()).collect();
        let constant = changes.constant.iter().map(|(name, value)| named((name, value.to_string())));
        let scheduled = changes.scheduled.iter().map(|(name, file)| named((name, file.display().to_string())));
        let transmittance = changes.transmittance.iter().map(|(name, value)| named((name, follow(value))));
        let mut options = vec![
            ("columns", columns.join(",").into()),
            ("sky", light.sky.as_str().into()),
            ("paths", light.paths.as_str().into()),
            ("bounces", light.bounces.map_or("all".into(), Value::from)),
            ("reflectance", constant.collect()),
            ("schedule", scheduled.collect()),
            ("transmittance", transmittance.collect()),
        ];
        if let Forcing::Weather(replay) = &self.forcing {
            options.extend([
                ("every", replay.every.as_str().into()),
                ("stamp", replay.stamp.as_str().into()),
                ("year", replay.year.into()),
                ("from", replay.from.as_deref().into()),
                ("to", replay.to.as_deref().into()),
                ("snow", replay.snow.as_deref().into()),
                ("snow_reflectance", replay.snow_reflectance.into()),
                ("temperature", self.temperatures.iter().map(String::as_str).collect()),
                ("shift", replay.shift.as_deref().unwrap_or("0min").into()),
            ]);
        }
        // As on the command line: what was not said is not there.
        let said =
            options.into_iter().filter(|(_, value)| !value.is_null() && value.as_array().is_none_or(|a| !a.is_empty()));
        said.map(|(name, value)| (name.to_owned(), value)).collect()
    }
}

impl Source {
    fn read(&self) -> Result<Vec<u8>> {
        self.bytes.as_ref().map_or_else(|| read_file(&self.name), |bytes| Ok(bytes.to_vec()))
    }
}

impl ReplayArgs {
    /// The weather with the rows that are asked for.
    fn read(&self, archive: &Archive, with_air: bool, observer: &dyn Observer) -> Result<(Weather, DatedRows)> {
        let moment = |argument, text: &Option<String>| {
            text.as_deref().map(str::parse::<Moment>).transpose().map_err(wrong(argument, "2019-03-01 or 03-01"))
        };
        let span = Span::new(moment("start", &self.from)?, moment("end", &self.to)?)?;
        let zone = |text: &String| {
            let hint = "give hours ahead of UTC, -12 to 14, such as \"+01:00\", -7, 5.5 or \"UTC\"";
            parse_zone(text).ok_or_else(|| Error::argument("time_zone", format!("`{text}` is none"), hint))
        };
        let options = WeatherOptions {
            latitude_deg: self.latitude,
            longitude_deg: self.longitude,
            zone_hours: self.time_zone.as_ref().map(zone).transpose()?,
            shift: match &self.shift {
                Some(text) => text.parse().map_err(wrong("shift", "as in \"41min\""))?,
                None => Default::default(),
            },
            stamped_at: self.weather_stamp.as_ref().map(|name| by_name("weather_stamp", name)).transpose()?,
            date_order: self.date_order.as_ref().map(|name| by_name("date_order", name)).transpose()?,
            with_air,
        };
        let file = &self.weather.name;
        let mut place = || Ok(archive.manifest().place);
        let weather = parse_weather_as(file, &self.weather.read()?, &options, &mut place)?;
        let every: Every = by_name("every", &self.every)?;
        let (dated, odd) = dated_rows((&weather, file), &span, self.year, every)?;
        let apart = archive.manifest().place.and_then(|place| far_apart(&place, &weather));
        let left_out = left_out(archive, Some(file));
        let said = weather.report.warnings.iter().chain(&dated.warnings).chain(&odd).chain(&apart).chain(&left_out);
        said.for_each(|w| observer.warn(w));
        Ok((weather, dated))
    }
}

/// The name of values that were given as such.
fn stand_in(given: &mut HashMap<PathBuf, PyBackedBytes>, what: &str, name: &str, bytes: PyBackedBytes) -> PathBuf {
    let file = PathBuf::from(format!("{what}[{name:?}]"));
    given.insert(file.clone(), bytes);
    file
}

fn share(argument: &'static str, value: f64) -> Result<f64> {
    match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(Error::argument(argument, format!("is from 0 to 1, not {value}"), "give a share of the light")),
    }
}
