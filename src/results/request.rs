//! What is asked of archives: irradiance under conditions ([`QueryRequest`]) or through weather ([`ReplayRequest`]). In: the choices of a user,
//! whichever way they come. Out: the same as one value, checked once, and the series of conditions that results are made of.

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
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::formats::weather_file::{ScenePlace, parse_weather_as};
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::{Moment, Span};
use heliotile_core::weather::temperatures::Temperature;

/// Which light counts, and what it is changed by.
#[derive(Clone, Debug)]
pub struct LightChoice {
    /// Columns, in the order of results; none: those that the results usually have.
    pub columns: Option<ComponentList>,
    /// How the sky's radiance is spread.
    pub sky: SkyModel,
    /// Number of sky patches; none: what the archive was built for.
    pub patches: Option<usize>,
    /// Light paths that count.
    pub paths: LightPaths,
    /// Reflectances and transmittances in place of those of the archive.
    pub changes: Changes,
    /// A sky in place of the model's, and clouds; few requests have any.
    pub sky_files: Box<SkyFiles>,
    /// Bands whose columns stand behind the others; few requests have any.
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
    /// The columns: the six components and their total, if none are chosen; behind them those of bands.
    pub fn columns(&self) -> ComponentList {
        self.columns_or(ComponentList::all())
    }

    /// The columns: `usual` ones if none are chosen; behind them those of bands.
    pub fn columns_or(&self, usual: ComponentList) -> ComponentList {
        let columns = self.columns.clone().unwrap_or(usual);
        columns.with(&self.bands.columns, self.bands.own_names())
    }

    /// The columns, if any are chosen, be it by a band.
    pub fn chosen_columns(&self) -> Option<ComponentList> {
        (self.columns.is_some() || !self.bands.columns.is_empty()).then(|| self.columns())
    }

    /// The same light with these columns and no others.
    #[must_use]
    pub fn only(&self, columns: ComponentList) -> Self {
        let bands = Box::new(BandList { columns: Vec::new(), ..*self.bands.clone() });
        LightChoice { columns: Some(columns), bands, ..self.clone() }
    }

    /// Files that reflectances and transmittances follow, and those of skies, clouds and bands.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let bands = self.bands.files.iter().map(PathBuf::as_path);
        followed_files(&self.changes.scheduled, &self.changes.transmittance).chain(self.sky_files.files()).chain(bands)
    }

    /// Tells what is doubtful about archives in the bands that are asked for.
    pub(super) fn tell_bands(&self, archives: Archives, observer: &dyn Observer) -> Result<()> {
        let doubts = self.bands.doubts(archives, self.columns().set())?;
        doubts.iter().for_each(|text| observer.note(text));
        Ok(())
    }

    /// Whether results depend on the dew point of the air.
    fn is_by_humidity(&self) -> bool {
        self.columns().set().contains(Component::Illuminance)
    }

    fn is_longwave(&self) -> bool {
        self.columns.as_ref().is_some_and(|columns| columns.set().contains(Component::Longwave))
    }
}

/// Irradiance under the suns and skies of a table.
#[derive(Clone, Debug)]
pub struct QueryRequest {
    /// Light that counts.
    pub light: LightChoice,
    /// Table of conditions.
    pub conditions: PathBuf,
}

/// Irradiance through a weather file.
#[derive(Clone, Debug)]
pub struct ReplayRequest {
    /// Light that counts.
    pub light: LightChoice,
    /// Weather file.
    pub weather: PathBuf,
    /// What is known of the file that it does not state; whether its air is read follows from the columns.
    pub about_weather: WeatherOptions,
    /// First and last moment that count; none: those of the file.
    pub span: (Option<Moment>, Option<Moment>),
    /// The year that all rows are put into; none: those of the file.
    pub year: Option<i32>,
    /// Positions of the sun in an interval; none: those that the archive was built for.
    pub steps: Option<usize>,
    /// What a row of results stands for.
    pub every: Every,
    /// Which moment of its interval a row of means is labelled with.
    pub stamp: StampedAt,
    /// Temperatures of what longwave radiation comes from.
    pub temperatures: Vec<Temperature>,
}

/// Largest number of sun positions in an interval.
pub const MOST_STEPS: usize = 60;

impl QueryRequest {
    /// Refuses what conditions cannot answer, before any file is read.
    pub fn check(&self) -> Result<()> {
        self.light.sky_files.check(self.light.sky)?;
        self.light.columns.as_ref().map_or(Ok(()), no_longwave)
    }
}

impl ReplayRequest {
    /// A replay of a weather file of which nothing else is said: a row for each of its intervals.
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
            return Err(Error::argument("steps", what, "leave it out for those of the archive"));
        }
        if !self.light.is_longwave() && !self.temperatures.is_empty() {
            let hint = "ask for it with {columns} total,longwave, or leave it out";
            return Err(Error::argument("temperature", "no column depends on it", hint));
        }
        Ok(())
    }

    /// Files that it reads besides archives.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let temperatures = self.temperatures.iter().filter_map(Temperature::file);
        [self.weather.as_path()].into_iter().chain(self.light.files()).chain(temperatures)
    }

    /// Reads the weather; `place` is that of the scene, asked for where the file states none. Tells what is odd about the file.
    pub fn read_weather(&self, resources: &Resources, place: ScenePlace) -> Result<Weather> {
        let with_air = self.light.is_longwave() || self.light.is_by_humidity();
        let options = WeatherOptions { with_air, ..self.about_weather };
        let weather = parse_weather_as(&self.weather, &(resources.files)(&self.weather)?, &options, place)?;
        weather.report.warnings.iter().for_each(|text| resources.observer.warn(text));
        Ok(weather)
    }

    /// The rows that count, with the dates of results; tells what is odd about these.
    pub fn dated(&self, weather: &Weather, observer: &dyn Observer) -> Result<DatedRows> {
        let span = Span::new(self.span.0, self.span.1)?;
        let (dated, years) = dated_rows(weather, &self.weather, &span, self.year, self.every)?;
        dated.warnings.iter().for_each(|text| observer.warn(text));
        years.iter().for_each(|text| observer.note(text));
        Ok(dated)
    }

    /// Tells why this weather and these columns may not fit archives: it is of elsewhere, or lights what they leave out; nothing in them is stated
    /// by band.
    pub fn tell_misfits(&self, archives: Archives, weather: &Weather, observer: &dyn Observer) -> Result<()> {
        let apart = archives.manifest().place.and_then(|place| far_apart(&place, weather));
        let odd = of_archive(archives.first(), Some(&self.weather));
        apart.iter().chain(&odd).for_each(|text| observer.warn(text));
        if self.light.is_by_humidity() && weather.air.iter().all(|air| air.dew_point_c.is_none()) {
            observer.note("the weather states no dew point: lux are those of air with 2 cm of precipitable water");
        }
        self.light.tell_bands(archives, observer)
    }

    /// Temperatures of what longwave radiation comes from, if it is asked for.
    pub(super) fn longwave(&self) -> Option<&[Temperature]> {
        self.light.is_longwave().then_some(&self.temperatures)
    }
}
