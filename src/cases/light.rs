//! Requests of commands that compute light from archives.

use std::path::{Path, PathBuf};

use heliotile_atlas::{ExportRequest, SunPosition};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::text::Message;
use heliotile_core::weather::conditions::Condition;
use heliotile_files::spill::parse_memory;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::tables::format::table_help;
use heliotile_results::{
    BuildingsRequest, ComfortRequest, CompareRequest, ConditionSource, Every, FactorsRequest, LightRequest,
    LightSource, OutputRequest, PlacesRequest, QueryRequest, ReplayRequest, Resources, ShadingRequest,
};
use heliotile_studies::run::folder_beside;
use heliotile_studies::{ComfortSiteRequest, EnvelopeRequest, GlareChoice, SunlightRequest};

use super::{SelectionRequest, SiteRequest};
use crate::site::Site;

/// Light under which a site is seen: a weather file, a table of suns and skies, or one of them.
#[derive(Clone, Debug, Default, Request)]
#[request(exactly_one("weather", "conditions", "sun"))]
pub struct UnderRequest {
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip);
    /// or a folder of EPW files, one for each year.
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Table of suns and skies in place of weather, CSV:
    /// condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2; azimuths are clockwise from
    /// true north.
    #[field(short = 'c', input = Conditions, conflicts("every", "stamp", "year", "from", "to", "steps", "snow", "snow_reflectance", "temperature"))]
    pub conditions: Option<PathBuf>,
    /// Azimuth (clockwise from true north) and altitude of one sun in place of weather, degrees.
    #[field(
        metavar = "AZIMUTH,ALTITUDE",
        hyphen,
        conflicts("every", "stamp", "year", "from", "to", "steps", "snow", "snow_reflectance", "temperature")
    )]
    pub sun: Option<SunPosition>,
    /// Direct normal irradiance of that sun, W/m2.
    #[field(metavar = "W/M2", default = 0.0, requires("sun"), range = 0.0..=ExportRequest::MAX_W_M2, says = "give a number from 0 to 1000000, W/m2")]
    pub dni_w_m2: f64,
    /// Diffuse horizontal irradiance of the sky around it, W/m2.
    #[field(metavar = "W/M2", default = 0.0, requires("sun"), range = 0.0..=ExportRequest::MAX_W_M2, says = "give a number from 0 to 1000000, W/m2")]
    pub dhi_w_m2: f64,
}

impl UnderRequest {
    /// Returns the light, with the choices of a replay.
    ///
    /// # Errors
    /// No light is given, or a sun and a sky without irradiance.
    pub fn illumination(&self, replay: &ReplayRequest) -> Result<LightSource> {
        let query = |conditions: ConditionSource| QueryRequest { light: replay.light.clone(), conditions }.into();
        match (&self.weather, &self.conditions, self.sun) {
            (Some(weather), ..) => {
                let replay = ReplayRequest { weather: weather.clone(), ..replay.clone() };
                Ok(replay.into())
            }
            (None, Some(conditions), _) => Ok(query(conditions.clone().into())),
            (None, None, Some(sun)) => {
                let (dni, dhi, toward) = (self.dni_w_m2, self.dhi_w_m2, sun.direction());
                if dni + dhi <= 0.0 {
                    return Err(Error::argument(
                        "dni, dhi",
                        "are 0: the sun and the sky give no light",
                        "give one of them",
                    ));
                }
                Ok(query(vec![Condition::new("sun".to_owned(), &[toward], toward, dni, dhi)].into()))
            }
            (None, None, None) => {
                Err(Error::argument("weather, conditions, sun", "none of them is given", "give one of them"))
            }
        }
    }
}

/// Request of `replay`.
#[derive(Clone, Debug, Default, Request)]
pub struct Replay {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Files to write.
    #[field(flatten)]
    pub files: OutputRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather, or suns and skies.
    #[field(flatten)]
    pub under: UnderRequest,
    /// Hours, and the light that counts.
    #[field(flatten, without("weather"))]
    pub request: ReplayRequest,
}

impl Replay {
    /// Returns the light under which the site is seen.
    pub fn under(&self) -> Result<LightSource> {
        self.under.illumination(&self.request)
    }
}

/// Request of `compare`.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct Compare {
    /// Site before the change.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Archives or atlases after the change; for several, only a summary is written.
    #[field(positional, required, input = Archive)]
    pub after: Vec<PathBuf>,
    /// Files to write.
    #[field(flatten, without("percentiles", "model", "honeybee"))]
    pub files: OutputRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather, or suns and skies.
    #[field(flatten)]
    pub under: UnderRequest,
    /// Hours, and the light that counts.
    #[field(flatten, without("weather"), defaults("every", "total"))]
    pub request: ReplayRequest,
    /// .
    #[field(metavar = "FILE", help = summary_help, output = Table)]
    pub summary: Option<PathBuf>,
    /// .
    #[field(metavar = "FILE", help = unmatched_help, output = Table)]
    pub unmatched: Option<PathBuf>,
}

/// Request of `sunlight`.
#[derive(Clone, Debug, Default, Request)]
pub struct Sunlight {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Files to write.
    #[field(flatten, without("percentiles", "model", "honeybee", "positions"))]
    pub files: OutputRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Days and rules.
    #[field(flatten)]
    pub request: SunlightRequest,
}

/// Request of `glare`.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct Glare {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Files to write.
    #[field(flatten, without("percentiles", "model", "honeybee", "positions"))]
    pub files: OutputRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Days and rules.
    #[field(flatten, without("every", "lit_share", "trees"), defaults("dates", "year"))]
    pub request: SunlightRequest,
    /// Period of a row, without --rule: a day, or all days of a month, a year or all of them
    /// [default: total].
    pub every: Option<Every>,
    /// Reflections that count, and further files.
    #[field(flatten)]
    pub glare: GlareChoice,
}

/// Request of `envelope`.
#[derive(Clone, Debug, Default, Request)]
pub struct Envelope {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Plot, hours of sun, and files to write.
    #[field(flatten)]
    pub request: EnvelopeRequest,
    /// Receivers that keep their sun.
    #[field(flatten)]
    pub receivers: SelectionRequest,
}

/// Request of `factors`.
#[derive(Clone, Debug, Default, Request)]
pub struct Factors {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Suns, and the table to write.
    #[field(flatten)]
    pub request: FactorsRequest,
}

/// Request of `buildings`.
#[derive(Clone, Debug, Default, Request)]
pub struct Buildings {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Limits of what counts, and the tables to write.
    #[field(flatten)]
    pub request: BuildingsRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather of a year, and the light that counts.
    #[field(flatten, without("columns", "bands", "every", "stamp", "year", "temperature"))]
    pub replay: ReplayRequest,
}

/// Request of `places`.
#[derive(Clone, Debug, Default, Request)]
pub struct Places {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Modules and surfaces, and the table to write.
    #[field(flatten)]
    pub request: PlacesRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather of a year, and the light that counts.
    #[field(flatten, without("columns", "bands", "every", "stamp", "year", "temperature"))]
    pub replay: ReplayRequest,
}

/// Request of `shading`.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct Shading {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Rows, and the table to write.
    #[field(flatten)]
    pub request: ShadingRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather, and the light that counts.
    #[field(flatten, without("columns", "bands", "temperature"), defaults("every", "year"))]
    pub replay: ReplayRequest,
}

/// Request of `comfort`.
#[derive(Clone, Debug, Default, Request)]
#[request(skips = Comfort::skipped)]
pub struct Comfort {
    /// Scene and its people, or an archive of them.
    #[field(flatten)]
    pub people: ComfortSiteRequest,
    /// Files to write.
    #[field(flatten, without("by", "percentiles", "positions", "model", "honeybee"))]
    pub files: OutputRequest,
    /// Weather, and what is computed.
    #[field(flatten, without("latitude", "longitude"))]
    pub request: ComfortRequest,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

/// Request for the comfort of the people of an archive that is open.
#[derive(Clone, Debug, Default, Request)]
pub struct PeopleOfSite {
    /// Files to write.
    #[field(flatten, without("by", "percentiles", "positions", "model", "honeybee"))]
    pub files: OutputRequest,
    /// Weather, and what is computed.
    #[field(flatten)]
    pub request: ComfortRequest,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

fn summary_help() -> Message {
    table_help(
        "Table to write with a row for each AFTER: means, and how many receivers, windows and buildings lose more than 5, 10 and 20 %",
    )
}

fn unmatched_help() -> Message {
    table_help("Table to write of the receivers that only one of the archives holds")
}

impl Compare {
    /// Returns the request of the library.
    ///
    /// # Errors
    /// No light is given.
    pub fn request(&self) -> Result<CompareRequest> {
        let under = self.under.illumination(&self.request)?;
        let (after, summary, unmatched) = (self.after.clone(), self.summary.clone(), self.unmatched.clone());
        Ok(CompareRequest { after, under, summary, unmatched })
    }
}

impl Glare {
    /// Returns the request of the library.
    pub fn request(&self) -> SunlightRequest {
        let usual = if self.request.rules.is_empty() { Every::Total } else { Every::Day };
        let every = self.every.unwrap_or(usual);
        SunlightRequest { every, glare: Some(self.glare.clone()), ..self.request.clone() }
    }
}

/// Returns a request that reads the air of the weather file, too.
fn with_air(request: &ComfortRequest) -> ComfortRequest {
    let mut request = request.clone();
    request.replay.about_weather.with_air = true;
    request
}

impl PeopleOfSite {
    /// Returns the request for their comfort.
    pub fn request(&self) -> ComfortRequest {
        with_air(&self.request)
    }
}

/// Returns a replay of the totals over all hours.
fn totals(replay: &ReplayRequest) -> ReplayRequest {
    let light = LightRequest { columns: Some(ComponentList::new(Component::Total)), ..replay.light.clone() };
    ReplayRequest { light, every: Every::Total, ..replay.clone() }
}

impl Buildings {
    /// Returns the replay of the totals over the weather file.
    pub fn year(&self) -> ReplayRequest {
        totals(&self.replay)
    }
}

impl Places {
    /// Returns the replay of the totals over the weather file.
    pub fn year(&self) -> ReplayRequest {
        totals(&self.replay)
    }
}

impl Comfort {
    /// Returns the archive or atlas of people, if one is named.
    pub fn place(&self) -> Option<&Path> {
        let [only] = self.people.scene.files.as_slice() else { return None };
        Site::is_at(only).then_some(only)
    }

    fn skipped(&self) -> Vec<&'static str> {
        if self.place().is_some() { vec!["scene"] } else { Vec::new() }
    }

    /// Returns the request for the archive of people.
    pub fn site(&self) -> ComfortSiteRequest {
        let people = &self.people;
        let replay = &self.request.replay;
        let folder = match people.folder.as_os_str().is_empty() {
            true => folder_beside(people.scene.first(), "people"),
            false => people.folder.clone(),
        };
        let accuracy = people.accuracy.beside(Some(&replay.weather), &replay.about_weather);
        ComfortSiteRequest { folder, accuracy, ..people.clone() }
    }

    /// Returns the archive of people: the one that is named, or that of the scene, which is built
    /// if it is not there. `request` is the later replay, whose faults are found before any ray is
    /// traced.
    pub fn archive(&self, request: Option<&ComfortRequest>, resources: &Resources) -> Result<PathBuf> {
        let people = &self.people;
        let Some(place) = self.place() else {
            let site = self.site();
            if let Some(request) = request {
                let files: Vec<&Path> = site.scene.files.iter().map(PathBuf::as_path).collect();
                request.check(&self.files, &files)?;
            }
            return site.build(request, resources);
        };
        if people.points.is_some() || !people.folder.as_os_str().is_empty() || people.replace {
            let what = "apply to scene files only: an archive states where people stand";
            let hint = "leave them out, or give the scene files in place of the archive";
            return Err(Error::argument("points, folder, replace", what, hint).because(Problem::other_kind("archive")));
        }
        Ok(place.to_path_buf())
    }

    /// Returns the request for their comfort.
    pub fn request(&self) -> ComfortRequest {
        with_air(&self.request)
    }
}
