//! Requests for irradiance under conditions ([`QueryRequest`]) or through weather
//! ([`ReplayRequest`]). In: the choices of a user, from any front end. Out: these choices as one
//! value, checked once, and the series of conditions that results are computed for.

use std::path::{Path, PathBuf};

use super::archives::Archives;
use super::bands::BandList;
use super::doubts::{dated_rows, no_longwave, of_archive};
use super::own_skies::SkyFiles;
use super::resources::Resources;
use crate::outputs::periods::Every;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::reflectances::{Changes, followed_files};
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::formats::weather_file::{ScenePlace, parse_weather_as};
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::{Moment, Span};
use heliotile_core::weather::temperatures::Temperature;

/// Light that counts, and changes of its reflectances and transmittances.
#[derive(Clone, Debug)]
pub struct LightChoice {
    /// Columns, in the order of results; `None`: the usual columns of the results.
    pub columns: Option<ComponentList>,
    /// Model of the sky's radiance distribution.
    pub sky: SkyModel,
    /// Number of sky patches; `None`: the number that the archive was built for.
    pub patches: Option<usize>,
    /// Light paths that count.
    pub paths: LightPaths,
    /// Reflectances and transmittances in place of those of the archive.
    pub changes: Changes,
    /// Skies from files in place of the model's, and clouds. Boxed: few requests have any.
    pub sky_files: Box<SkyFiles>,
    /// Bands whose columns follow the others. Boxed: few requests have any.
    pub bands: Box<BandList>,
}

impl Default for LightChoice {
    fn default() -> Self {
        let (sky, paths, changes) = (SkyModel::default(), LightPaths::ALL, Changes::default());
        let (sky_files, bands) = (Box::default(), Box::default());
        LightChoice { columns: None, sky, patches: None, paths, changes, sky_files, bands }
    }
}

impl LightChoice {
    /// Returns the chosen columns, or the six components and their total if none are chosen,
    /// followed by the columns of bands.
    pub fn columns(&self) -> ComponentList {
        self.columns_or(ComponentList::all())
    }

    /// Returns the chosen columns, or `usual` if none are chosen, followed by the columns of bands.
    pub fn columns_or(&self, usual: ComponentList) -> ComponentList {
        let columns = self.columns.clone().unwrap_or(usual);
        columns.with(&self.bands.columns, self.bands.own_names())
    }

    /// Returns the columns if any are chosen, by name or by a band.
    pub fn chosen_columns(&self) -> Option<ComponentList> {
        (self.columns.is_some() || !self.bands.columns.is_empty()).then(|| self.columns())
    }

    /// Returns this light with `columns` and no others.
    #[must_use]
    pub fn only(&self, columns: ComponentList) -> Self {
        let bands = Box::new(BandList { columns: Vec::new(), ..*self.bands.clone() });
        LightChoice { columns: Some(columns), bands, ..self.clone() }
    }

    /// Returns the files that the light depends on: schedules of reflectances and transmittances,
    /// skies, clouds and bands.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let bands = self.bands.files.iter().map(PathBuf::as_path);
        followed_files(&self.changes.scheduled, &self.changes.transmittance).chain(self.sky_files.files()).chain(bands)
    }

    /// Notes doubts about archives in the requested bands.
    pub(super) fn tell_bands(&self, archives: Archives, observer: &dyn Observer) -> Result<()> {
        let doubts = self.bands.doubts(archives, self.columns().set())?;
        doubts.iter().for_each(|text| observer.note(text));
        Ok(())
    }

    /// Returns true if results depend on the dew point of the air.
    fn is_by_humidity(&self) -> bool {
        self.columns().set().contains(Component::Illuminance)
    }

    fn is_longwave(&self) -> bool {
        self.columns.as_ref().is_some_and(|columns| columns.set().contains(Component::Longwave))
    }
}

/// Request for irradiance under the suns and skies of a table.
#[derive(Clone, Debug)]
pub struct QueryRequest {
    /// Light that counts.
    pub light: LightChoice,
    /// Conditions.
    pub conditions: ConditionSource,
}

/// Conditions of a query.
#[derive(Clone, Debug)]
pub enum ConditionSource {
    /// Table in a file.
    File(PathBuf),
    /// Conditions in memory.
    Rows(Vec<Condition>),
}

impl From<&str> for ConditionSource {
    fn from(file: &str) -> Self {
        ConditionSource::File(file.into())
    }
}

impl From<PathBuf> for ConditionSource {
    fn from(file: PathBuf) -> Self {
        ConditionSource::File(file)
    }
}

impl From<Vec<Condition>> for ConditionSource {
    fn from(rows: Vec<Condition>) -> Self {
        ConditionSource::Rows(rows)
    }
}

/// Request for irradiance through a weather file.
#[derive(Clone, Debug)]
pub struct ReplayRequest {
    /// Light that counts.
    pub light: LightChoice,
    /// Weather file.
    pub weather: PathBuf,
    /// Facts about the file that it does not state itself. Air is read if the columns need it,
    /// whatever stands here.
    pub about_weather: WeatherOptions,
    /// First and last moment that count; `None`: the first or last of the file.
    pub span: (Option<Moment>, Option<Moment>),
    /// Year that all rows are put into; `None`: the years of the file.
    pub year: Option<i32>,
    /// Positions of the sun in an interval; `None`: the number that the archive was built for.
    pub steps: Option<usize>,
    /// Period of a row of results.
    pub every: Every,
    /// Moment of its interval that labels a row of means.
    pub stamp: StampedAt,
    /// Temperatures of the surfaces that emit longwave radiation.
    pub temperatures: Vec<Temperature>,
}

/// Largest number of sun positions in an interval.
pub const MOST_STEPS: usize = 60;

impl QueryRequest {
    /// Returns a query with the usual light: a table of conditions, or conditions in memory.
    pub fn of(conditions: impl Into<ConditionSource>) -> Self {
        QueryRequest { light: LightChoice::default(), conditions: conditions.into() }
    }

    /// Returns the files that the request reads besides archives.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let table = match &self.conditions {
            ConditionSource::File(file) => Some(file.as_path()),
            ConditionSource::Rows(_) => None,
        };
        self.light.files().chain(table)
    }

    /// Refuses columns and skies that conditions cannot give, before any file is read.
    pub fn check(&self) -> Result<()> {
        self.light.sky_files.check(self.light.sky)?;
        self.light.columns.as_ref().map_or(Ok(()), no_longwave)
    }
}

impl ReplayRequest {
    /// Returns a replay of a weather file with defaults for all else: a row for each of its
    /// intervals.
    pub fn of(weather: impl Into<PathBuf>) -> Self {
        ReplayRequest {
            light: LightChoice::default(),
            weather: weather.into(),
            about_weather: WeatherOptions::default(),
            span: (None, None),
            year: None,
            steps: None,
            every: Every::Hour,
            stamp: StampedAt::Start,
            temperatures: Vec::new(),
        }
    }

    /// Refuses choices that exclude each other, before any file is read.
    pub fn check(&self) -> Result<()> {
        self.light.sky_files.check(self.light.sky)?;
        if self.steps.is_some_and(|steps| !(1..=MOST_STEPS).contains(&steps)) {
            let what = format!("is not from 1 to {MOST_STEPS}");
            return Err(Error::argument("steps", what, "leave it out to use the value of the archive"));
        }
        if !self.light.is_longwave() && !self.temperatures.is_empty() {
            let hint = "give {columns} total,longwave, or leave it out";
            return Err(Error::argument("temperature", "no column depends on temperatures", hint));
        }
        Ok(())
    }

    /// Returns the files that the request reads besides archives.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let temperatures = self.temperatures.iter().filter_map(Temperature::file);
        [self.weather.as_path()].into_iter().chain(self.light.files()).chain(temperatures)
    }

    /// Reads the weather and warns of what is odd about the file. `place` is the place of the
    /// scene, used if the file states none.
    pub fn read_weather(&self, resources: &Resources, place: ScenePlace) -> Result<Weather> {
        let with_air = self.light.is_longwave() || self.light.is_by_humidity();
        let options = WeatherOptions { with_air, ..self.about_weather };
        let weather = parse_weather_as(&self.weather, &(resources.files)(&self.weather)?, &options, place)?;
        weather.report.warnings.iter().for_each(|text| resources.observer.warn(text));
        Ok(weather)
    }

    /// Returns the rows that count, with the dates of results, and reports what is odd about these
    /// dates.
    pub fn dated(&self, weather: &Weather, observer: &dyn Observer) -> Result<DatedRows> {
        let span = Span::new(self.span.0, self.span.1)?;
        let (dated, years) = dated_rows(weather, &self.weather, &span, self.year, self.every)?;
        dated.warnings.iter().for_each(|text| observer.warn(text));
        years.iter().for_each(|text| observer.note(text));
        Ok(dated)
    }

    /// Warns if this weather and these columns may not fit the archives: the weather is from far
    /// away, the archive leaves out effects that matter under it, or no material states values by
    /// band.
    pub fn tell_misfits(&self, archives: Archives, weather: &Weather, observer: &dyn Observer) -> Result<()> {
        let apart = archives.manifest().place.and_then(|place| far_apart(&place, weather));
        let odd = of_archive(archives.first(), Some(&self.weather));
        apart.iter().chain(&odd).for_each(|text| observer.warn(text));
        if self.light.is_by_humidity() && weather.air.iter().all(|air| air.dew_point_c.is_none()) {
            observer.note("the weather has no dew point: lux are calculated for air with 2 cm of precipitable water");
        }
        self.light.tell_bands(archives, observer)
    }

    /// Returns the temperatures of the surfaces that emit longwave radiation, if the longwave
    /// column is requested.
    pub(super) fn longwave(&self) -> Option<&[Temperature]> {
        self.light.is_longwave().then_some(&self.temperatures)
    }
}
