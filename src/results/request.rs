//! Requests for irradiance under conditions ([`QueryRequest`]) or through weather
//! ([`ReplayRequest`]). In: the choices of a user, from any front end. Out: these choices as one
//! value, checked once, and the series of conditions that results are computed for.

use std::path::{Path, PathBuf};

use super::archives::Archives;
use super::bands::{BandChoice, BandList};
use super::doubts::{dated_rows, left_out, no_longwave};
use super::own_skies::{SkyChoice, SkyFiles};
use super::resources::Resources;
use crate::outputs::periods::Every;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::reflectances::{Changes, Snow};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::span::{Moment, Span};
use heliotile_requests::{DefaultRequest, Form, Parse, Request};
use heliotile_weather::dated::DatedRows;
use heliotile_weather::distance::far_apart;
use heliotile_weather::formats::weather_file::ScenePlace;
use heliotile_weather::series::Weather;
use heliotile_weather::temperatures::Temperature;

/// Light that counts, and changes of its reflectances and transmittances.
#[derive(Clone, Debug, Request)]
pub struct LightRequest {
    /// Columns to write, in this order, such as total,sun_direct. sun_reflected and sky_reflected
    /// can be split by the kind of surface that the receiver sees, as in sun_reflected_ground and
    /// sun_reflected_obstruction; `replay` also has longwave [default: the six components and their
    /// total].
    #[field(metavar = "NAMES")]
    pub columns: Option<ComponentList>,
    /// Bands whose columns follow the others. Boxed: few requests have any.
    #[field(metavar = "NAMES|FILE", help = BandChoice::described)]
    pub bands: Box<BandList>,
    /// Model of the sky's radiance distribution, or a file of radiances.
    #[field(metavar = "NAME|FILE", default = "perez", help = SkyChoice::described, input = Any)]
    pub sky: SkyChoice,
    /// How a file of the sky is read, and clouds. Boxed: few requests have any.
    #[field(flatten)]
    pub sky_files: Box<SkyFiles>,
    /// Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built].
    pub patches: Option<usize>,
    /// Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only).
    #[field(default = "all")]
    pub bounces: MaxBounces,
    /// Light paths that count besides direct sun and sky, their first diffuse reflection and the
    /// sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse
    /// reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky
    /// in mirrors).
    #[field(metavar = "NAMES", default = "all")]
    pub paths: LightPaths,
    /// Reflectances and transmittances in place of those of the archive.
    #[field(flatten)]
    pub changes: Changes,
}

impl Default for LightRequest {
    fn default() -> Self {
        let (sky, paths, changes) = (SkyChoice::default(), LightPaths::ALL, Changes::default());
        let (sky_files, bands, bounces) = (Box::default(), Box::default(), MaxBounces::All);
        LightRequest { columns: None, bands, sky, sky_files, patches: None, bounces, paths, changes }
    }
}

impl LightRequest {
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
        LightRequest { columns: Some(columns), bands, ..self.clone() }
    }

    /// Returns the files that the light depends on: schedules of reflectances and transmittances,
    /// skies, clouds and bands.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let bands = self.bands.files.iter().map(PathBuf::as_path);
        let skies = self.sky.file().into_iter().chain(self.sky_files.clouds.as_deref());
        self.changes.files().chain(skies).chain(bands)
    }

    /// Returns how skies and clouds are read from files.
    pub fn skies(&self) -> SkyFiles {
        SkyFiles { sky: self.sky.file().map(Path::to_path_buf), ..(*self.sky_files).clone() }
    }

    /// Returns the light paths that count. An error: more than one reflection, where only the first
    /// one counts.
    pub fn light_paths(&self) -> Result<LightPaths> {
        let hint = "name `bounces` among the paths, or leave it out";
        self.paths.with_depth(self.bounces).map_err(|what| Error::argument("bounces", what, hint))
    }

    /// Refuses choices that exclude each other, before any file is read.
    pub fn check(&self) -> Result<()> {
        self.light_paths()?;
        self.skies().check(self.sky.model())
    }

    /// Notes doubts about archives in the requested bands.
    pub fn tell_bands(&self, archives: Archives, observer: &dyn Observer) -> Result<()> {
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
#[derive(Clone, Debug, Default, Request)]
pub struct QueryRequest {
    /// Light that counts.
    #[field(flatten)]
    pub light: LightRequest,
    /// Table of suns and skies, CSV: condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2;
    /// azimuths are clockwise from true north.
    #[field(short = 'c', input = Conditions, required)]
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
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct ReplayRequest {
    /// Light that counts.
    #[field(flatten)]
    pub light: LightRequest,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip);
    /// or a folder of EPW files, one for each year.
    #[field(short = 'w', input = Weather, required)]
    pub weather: PathBuf,
    /// Facts about the file that it does not state itself. Air is read if the columns need it,
    /// whatever stands here.
    #[field(flatten, heading = "About the weather file", needs("weather"))]
    pub about_weather: WeatherOptions,
    /// Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods.
    #[field(default = "hour")]
    pub every: Every,
    /// Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30
    /// or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the
    /// next); sums are labelled with the start of their period.
    #[field(default = "start")]
    pub stamp: StampedAt,
    /// Year of all dates in results, such as 2019, for example for a typical year, whose months
    /// come from different ones. Sun positions stay those of the file's dates; 29 February is left
    /// out if the year has none. --from and --to then refer to this year.
    #[field(range = 1..=2999)]
    pub year: Option<i32>,
    /// First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and
    /// winters), or a time such as 03-01T06:00.
    #[field(metavar = "DAY", python = "start")]
    pub from: Option<Moment>,
    /// Last day that counts, up to its end; if it is before --from, that day of the next year, as
    /// in --from 11-01 --to 02-28.
    #[field(metavar = "DAY", python = "end")]
    pub to: Option<Moment>,
    /// Number of sun positions within each interval of the weather file, 1 to 60 [default: the
    /// number per hour for which the archive was built].
    #[field(range = 1..=60)]
    pub steps: Option<usize>,
    /// Change the reflectance of all ground by the weather file: its snow depth (--snow-reflectance
    /// from 1 cm on) or its albedo.
    pub snow: Option<Snow>,
    /// Diffuse reflectance of snow.
    #[field(default = 0.6, requires("snow"), range = 0.0..=1.0, says = "give a number from 0 to 1")]
    pub snow_reflectance: f64,
    /// Temperature of `ground` or `obstruction` surfaces for the column `longwave`: degrees
    /// Celsius, or a CSV as for --schedule with a column `temperature_c`; may be repeated, the last
    /// one counts [default: the weather file's dry bulb temperature].
    #[field(name = "temperature", metavar = "CLASS=CELSIUS|FILE", input = Any)]
    pub temperatures: Vec<Temperature>,
}

/// Largest number of sun positions in an interval.
pub const MAX_STEPS: usize = 60;

impl QueryRequest {
    /// Returns a query with the usual light: a table of conditions, or conditions in memory.
    pub fn new(conditions: impl Into<ConditionSource>) -> Self {
        QueryRequest { light: LightRequest::default(), conditions: conditions.into() }
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
        self.light.check()?;
        self.light.columns.as_ref().map_or(Ok(()), no_longwave)
    }
}

impl ReplayRequest {
    /// Returns a replay of a weather file with defaults for all else: a row for each of its
    /// intervals.
    pub fn new(weather: impl Into<PathBuf>) -> Self {
        ReplayRequest { weather: weather.into(), ..ReplayRequest::default() }
    }

    /// Returns the changes of reflectances and transmittances, with the snow of the weather file.
    pub fn changes(&self) -> Changes {
        Changes { snow: self.snow.map(|snow| (snow, self.snow_reflectance)), ..self.light.changes.clone() }
    }

    /// Refuses choices that exclude each other, before any file is read.
    pub fn check(&self) -> Result<()> {
        check_ranges(self)?;
        self.light.check()?;
        if !self.light.is_longwave() && !self.temperatures.is_empty() {
            let hint = "give {columns} total,longwave, or leave it out";
            return Err(Error::argument("temperature", "no column depends on temperatures", hint)
                .because(Problem::needs("columns")));
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
        resources.weather(&self.weather, &options, place)
    }

    /// Returns the rows that count, with the dates of results, and reports what is odd about these
    /// dates.
    pub fn dated(&self, weather: &Weather, observer: &dyn Observer) -> Result<DatedRows> {
        let span = Span::new(self.from, self.to)?;
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
        let odd = left_out(archives.first(), Some(&self.weather));
        apart.iter().for_each(|apart| observer.warn(apart));
        odd.iter().for_each(|text| observer.warn(text));
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

impl Default for ConditionSource {
    fn default() -> Self {
        ConditionSource::File(PathBuf::new())
    }
}

impl Parse for ConditionSource {
    fn form() -> Form {
        Form::PATH
    }

    fn parse(text: &str) -> std::result::Result<Self, heliotile_requests::Wrong> {
        PathBuf::parse(text).map(ConditionSource::File)
    }

    fn path(&self) -> Option<&Path> {
        if let ConditionSource::File(file) = self { Some(file) } else { None }
    }
}
