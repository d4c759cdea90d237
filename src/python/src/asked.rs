//! Requests for a replay or a query. In: plain values of `heliotile/archive.py`. Out: the requests
//! that the library runs, and the bytes that stand in for files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use serde_json::{Map, Value};

use crate::errors::wrong;
use heliotile::memory::{SystemTemp, check_memory};
use heliotile::names::by_name;
use heliotile::scene::input;
use heliotile::{
    BandChoice, BandList, Bytes, Changes, ClockZone, ComfortChoice, ComfortRequest, ComponentList, ConstantOrFile,
    Error, Illumination, LightChoice, LightPaths, MaxBounces, MemoryBudget, Moment, Observer, Provenance, QueryRequest,
    ReplayRequest, Resources, Result, Site, SkyChoice, SkyFiles, Temperature, WeatherOptions,
};

/// Memory to work in, at most that of the machine.
#[derive(Clone, Copy)]
pub struct Memory(pub MemoryBudget);

impl<'py> FromPyObject<'_, 'py> for Memory {
    type Error = PyErr;

    fn extract(number: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let Bytes(bytes) = check_memory(Bytes(number.extract()?))
            .map_err(|text| PyValueError::new_err(format!("memory: {text}, in bytes")))?;
        Ok(Memory(MemoryBudget::new(bytes)))
    }
}

/// A file, or the bytes of a file and its name.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Source {
    name: PathBuf,
    bytes: Option<PyBackedBytes>,
}

/// A constant, or values over time: the bytes of a schedule, or its file.
#[derive(FromPyObject)]
pub enum Follow {
    Values(PyBackedBytes),
    Constant(f64),
    File(PathBuf),
}

/// Options that `replay` and `query` share.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LightArgs {
    columns: Option<String>,
    bands: Option<String>,
    sky: String,
    sky_scale: Option<String>,
    sky_white: Option<f64>,
    clouds: Option<PathBuf>,
    image_top: Option<f64>,
    patches: Option<usize>,
    paths: String,
    bounces: Option<u32>,
    reflectance: Vec<(String, Follow)>,
    transmittance: Vec<(String, Follow)>,
    memory: Memory,
}

/// Options of `replay`.
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

/// Source of the conditions: weather with the options of a replay, or a table of conditions.
pub enum Forcing {
    Weather(Box<ReplayArgs>),
    Conditions(Source),
}

impl Forcing {
    /// Reads the options of a replay, or else a table of conditions.
    pub fn of(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        match given.extract::<ReplayArgs>() {
            Ok(replay) => Ok(Forcing::Weather(Box::new(replay))),
            Err(_) => given.extract().map(Forcing::Conditions),
        }
    }
}

/// A request, and the bytes that stand in for files that it names.
pub struct Filled {
    /// Name of the Python method.
    method: &'static str,
    /// Request for the suns and skies, and for the light that counts.
    pub request: Illumination,
    given: Given,
    /// Memory for the work, bytes.
    pub memory: MemoryBudget,
    /// All options that may change values, by the names of the command line, for the provenance of
    /// results.
    options: Map<String, Value>,
}

/// Bytes, keyed by the names that messages use for them.
#[derive(Default)]
struct Given(HashMap<PathBuf, PyBackedBytes>);

impl Given {
    /// Keeps bytes that stand in for a file. Returns the name of this file.
    fn stand_in(&mut self, what: &str, name: &str, bytes: PyBackedBytes) -> PathBuf {
        let file = PathBuf::from(format!("{what}[{name:?}]"));
        self.0.insert(file.clone(), bytes);
        file
    }

    fn source(&mut self, source: Source) -> PathBuf {
        if let Some(bytes) = source.bytes {
            self.0.insert(source.name.clone(), bytes);
        }
        source.name
    }
}

impl LightArgs {
    /// Returns the memory for the work, bytes.
    fn memory(&self) -> MemoryBudget {
        self.memory.0
    }

    fn choice(self, given: &mut Given) -> Result<LightChoice> {
        let columns = self.columns.as_deref().map(str::parse::<ComponentList>).transpose();
        let columns = columns.map_err(wrong("columns", "give names of columns, as in [\"total\", \"sun_direct\"]"))?;
        let paths = self.paths.parse::<LightPaths>().map_err(wrong("paths", "give \"all\", \"none\" or some names"))?;
        let hint = "give a number of reflections from 1 to 64, or leave it out for all";
        let depth = MaxBounces::try_from(self.bounces).map_err(wrong("bounces", hint))?;
        paths.with_depth(depth).map_err(wrong("bounces", "add `bounces` to paths, or leave bounces out"))?;
        let mut changes = Changes::default();
        for (name, follow) in self.reflectance {
            match follow {
                Follow::Constant(value) => changes.constant.push((name, share("reflectance", value)?)),
                Follow::File(file) => changes.scheduled.push((name, file)),
                Follow::Values(bytes) => {
                    let file = given.stand_in("reflectance", &name, bytes);
                    changes.scheduled.push((name, file));
                }
            }
        }
        for (name, follow) in self.transmittance {
            let follow = match follow {
                Follow::Constant(value) => ConstantOrFile::Value(share("transmittance", value)?),
                Follow::File(file) => ConstantOrFile::File(file),
                Follow::Values(bytes) => ConstantOrFile::File(given.stand_in("transmittance", &name, bytes)),
            };
            changes.transmittance.push((name, follow));
        }
        let sky = self.sky.parse::<SkyChoice>();
        let hint = "give one of these names, or the path of a file";
        let sky = sky.map_err(|what| Error::argument("sky", what.to_string(), hint))?;
        let sky_files = Box::new(SkyFiles {
            sky: None,
            scale: self.sky_scale.as_ref().map(|name| by_name("sky_scale", name)).transpose()?,
            white_w_m2_sr: self.sky_white.map(|white| above_0("sky_white", white)).transpose()?,
            clouds: self.clouds,
            image_top_deg: self.image_top.map(|top| azimuth("image_top", top)).transpose()?,
        });
        let choice = self.bands.as_deref().map(str::parse::<BandChoice>).transpose();
        let choice =
            choice.map_err(wrong("bands", "give names, as in [\"visible\", \"par\"], or the path of a file"))?;
        let bands = Box::new(choice.map_or(Ok(BandList::default()), |choice| choice.read(&input::read))?);
        Ok(LightChoice { columns, bands, sky, sky_files, patches: self.patches, bounces: depth, paths, changes })
    }
}

impl ReplayArgs {
    fn request(self, light: LightChoice, given: &mut Given) -> Result<ReplayRequest> {
        let moment = |argument, text: &Option<String>| {
            text.as_deref()
                .map(str::parse::<Moment>)
                .transpose()
                .map_err(wrong(argument, "give a day, as in 2019-03-01 or 03-01"))
        };
        let zone = |text: &String| {
            let hint = "give hours ahead of UTC, -12 to 14, such as \"+01:00\", -7, 5.5 or \"UTC\", or a name such as \
                        \"Europe/Amsterdam\"";
            text.parse::<ClockZone>()
                .map_err(|_| Error::argument("time_zone", format!("`{text}` is not a time zone"), hint))
        };
        let about_weather = WeatherOptions {
            latitude_deg: self.latitude,
            longitude_deg: self.longitude,
            zone: self.time_zone.as_ref().map(zone).transpose()?,
            shift: match &self.shift {
                Some(text) => text.parse().map_err(wrong("shift", "give a time, as in \"41min\""))?,
                None => Default::default(),
            },
            stamped_at: self.weather_stamp.as_ref().map(|name| by_name("weather_stamp", name)).transpose()?,
            date_order: self.date_order.as_ref().map(|name| by_name("date_order", name)).transpose()?,
            with_air: false,
        };
        let mut temperatures = Vec::new();
        for (name, follow) in self.temperature {
            let of = match follow {
                Follow::Constant(value) => value.to_string(),
                Follow::File(file) => file.display().to_string(),
                Follow::Values(bytes) => given.stand_in("temperature", &name, bytes).display().to_string(),
            };
            let hint = "give {\"ground\": 15.0} or {\"obstruction\": values}";
            let temperature: Temperature = format!("{name}={of}").parse().map_err(wrong("temperature", hint))?;
            temperatures.push(temperature);
        }
        Ok(ReplayRequest {
            light,
            weather: given.source(self.weather),
            about_weather,
            from: moment("start", &self.from)?,
            to: moment("end", &self.to)?,
            snow: self.snow.as_ref().map(|name| by_name("snow", name)).transpose()?,
            snow_reflectance: share("snow_reflectance", self.snow_reflectance)?,
            year: self.year,
            steps: self.steps,
            every: by_name("every", &self.every)?,
            stamp: by_name("stamp", &self.stamp)?,
            temperatures,
        })
    }
}

impl Filled {
    /// Builds the request from arguments. Fails if a name is unknown or a share is not from 0 to 1.
    pub fn new(light: LightArgs, forcing: Forcing) -> Result<Self> {
        let (memory, mut given) = (light.memory(), Given::default());
        let mut options = light.options();
        let light = light.choice(&mut given)?;
        let (method, request) = match forcing {
            Forcing::Conditions(source) => {
                let request = QueryRequest { light, conditions: given.source(source).into() };
                request.check()?;
                ("query", Illumination::Conditions(Box::new(request)))
            }
            Forcing::Weather(replay) => {
                options.extend(replay.options());
                let request = replay.request(light, &mut given)?;
                request.check()?;
                ("replay", Illumination::Weather(Box::new(request)))
            }
        };
        Ok(Filled::with(method, request, given, memory, options))
    }

    /// Builds the replay of a year.
    pub fn replay(light: LightArgs, replay: ReplayArgs) -> Result<(Self, ReplayRequest)> {
        let filled = Filled::new(light, Forcing::Weather(Box::new(replay)))?;
        let Illumination::Weather(year) = &filled.request else {
            let hint = "give a weather file";
            return Err(Error::argument("weather", "is a table of conditions", hint));
        };
        let year = year.as_ref().clone();
        Ok((filled, year))
    }

    /// Builds the comfort request and the replay that it needs.
    pub fn for_people(light: LightArgs, replay: ReplayArgs, choice: ComfortChoice) -> Result<(Self, ComfortRequest)> {
        let (memory, mut given) = (light.memory(), Given::default());
        let mut options = light.options();
        options.extend(replay.options());
        let replay = replay.request(light.choice(&mut given)?, &mut given)?;
        let request = ComfortRequest { replay, choice };
        let stream = Illumination::Weather(Box::new(request.stream()));
        Ok((Filled::with("comfort", stream, given, memory, options), request))
    }

    fn with(
        method: &'static str,
        request: Illumination,
        given: Given,
        memory: MemoryBudget,
        mut options: Map<String, Value>,
    ) -> Self {
        options.insert("columns".to_owned(), names(&request.light().columns()).into());
        // As on the command line, options without a value are left out.
        options.retain(|_, value| !value.is_null() && value.as_array().is_none_or(|all| !all.is_empty()));
        Filled { method, request, given, memory, options }
    }

    /// Calls `then` with the site, whose results state the options, and the resources.
    pub fn ask<T>(
        &self,
        site: &Site,
        observer: &dyn Observer,
        then: impl FnOnce(&Site, &Resources) -> Result<T>,
    ) -> Result<T> {
        let files = |path: &Path| self.given.0.get(path).map_or_else(|| input::read(path), |bytes| Ok(bytes.to_vec()));
        let resources = Resources { memory: self.memory, storage: &SystemTemp, files: &files, observer };
        let class = if site.archives().only().is_some() { "Archive" } else { "Atlas" };
        let about = Provenance::new(format!("heliotile.{class}.{}", self.method), self.options.clone());
        then(&site.stating(about), &resources)
    }
}

fn names(columns: &ComponentList) -> String {
    columns.as_slice().iter().map(|column| columns.name_of(*column)).collect::<Vec<_>>().join(",")
}

impl Follow {
    /// Returns the value as the command line writes it; `stand_in` names values that were given as
    /// bytes.
    fn text(&self, stand_in: impl FnOnce() -> String) -> String {
        match self {
            Follow::Constant(value) => value.to_string(),
            Follow::File(file) => file.display().to_string(),
            Follow::Values(_) => stand_in(),
        }
    }
}

/// Returns `name=value` of each entry, as on the command line.
fn named<'a>(what: &str, all: impl Iterator<Item = &'a (String, Follow)>) -> Value {
    all.map(|(name, follow)| format!("{name}={}", follow.text(|| format!("{what}[{name:?}]")))).collect()
}

impl LightArgs {
    fn options(&self) -> Map<String, Value> {
        let is_constant = |entry: &&(String, Follow)| matches!(entry.1, Follow::Constant(_));
        let options = [
            ("bands", self.bands.as_deref().into()),
            ("sky", self.sky.as_str().into()),
            ("sky_scale", self.sky_scale.as_deref().into()),
            ("sky_white", self.sky_white.into()),
            ("clouds", self.clouds.as_ref().map(|file| file.display().to_string()).into()),
            ("image_top", self.image_top.into()),
            ("paths", self.paths.as_str().into()),
            ("bounces", self.bounces.map_or("all".into(), Value::from)),
            ("reflectance", named("reflectance", self.reflectance.iter().filter(is_constant))),
            ("schedule", named("reflectance", self.reflectance.iter().filter(|entry| !is_constant(entry)))),
            ("transmittance", named("transmittance", self.transmittance.iter())),
        ];
        options.map(|(name, value)| (name.to_owned(), value)).into_iter().collect()
    }
}

impl ReplayArgs {
    fn options(&self) -> Map<String, Value> {
        let options = [
            ("every", self.every.as_str().into()),
            ("stamp", self.stamp.as_str().into()),
            ("year", self.year.into()),
            ("from", self.from.as_deref().into()),
            ("to", self.to.as_deref().into()),
            ("snow", self.snow.as_deref().into()),
            ("snow_reflectance", self.snow_reflectance.into()),
            ("temperature", named("temperature", self.temperature.iter())),
            ("shift", self.shift.as_deref().unwrap_or("0min").into()),
        ];
        options.map(|(name, value)| (name.to_owned(), value)).into_iter().collect()
    }
}

fn share(argument: &'static str, value: f64) -> Result<f64> {
    match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(Error::argument(argument, format!("is {value}, not from 0 to 1"), "give a share of the light")),
    }
}

fn above_0(argument: &'static str, value: f64) -> Result<f64> {
    match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(Error::argument(argument, format!("is {value}, not above 0"), "give W/m2/sr")),
    }
}

fn azimuth(argument: &'static str, value: f64) -> Result<f64> {
    match (-360.0..=360.0).contains(&value) {
        true => Ok(value),
        false => Err(Error::argument(argument, format!("is {value}, not from -360 to 360"), "give degrees")),
    }
}
