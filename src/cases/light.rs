//! Requests of commands that compute light from archives.

use heliotile_core::text::Message;
use std::path::{Path, PathBuf};

use heliotile_builder::spill::parse_memory;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_requests::Request;
use heliotile_results::outputs::tables::format::table_help;
use heliotile_results::run::folder_beside;
use heliotile_results::{
    BuildingsRequest, ComfortRequest, ComfortSiteRequest, CompareRequest, Every, FactorsRequest, FileRequest,
    GlareChoice, Illumination, LightChoice, PlacesRequest, QueryRequest, ReplayRequest, Resources, SunlightRequest,
};

use super::{SelectionRequest, SiteRequest};
use crate::site::Site;

/// Request of `query`.
#[derive(Clone, Debug, Default, Request)]
pub struct Query {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Files to write.
    #[field(flatten, without("model", "honeybee"))]
    pub files: FileRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Suns and skies, and the light that counts.
    #[field(flatten)]
    pub request: QueryRequest,
}

/// Request of `replay`.
#[derive(Clone, Debug, Default, Request)]
pub struct Replay {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Files to write.
    #[field(flatten)]
    pub files: FileRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather, and the light that counts.
    #[field(flatten)]
    pub request: ReplayRequest,
}

/// Request of `compare`.
#[derive(Clone, Debug, Request)]
#[request(exactly_one("weather", "conditions"))]
pub struct Compare {
    /// Site before the change.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Archives or atlases after the change; for several, only a summary is written.
    #[field(positional, required, input = Archive)]
    pub after: Vec<PathBuf>,
    /// Files to write.
    #[field(flatten, without("model", "honeybee"))]
    pub files: FileRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Weather file, as for `replay`.
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Table of suns and skies in place of weather, as for `query`.
    #[field(short = 'c', input = Conditions, conflicts("every", "stamp", "year", "from", "to", "steps", "snow", "snow_reflectance", "temperature"))]
    pub conditions: Option<PathBuf>,
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
    #[field(flatten, without("model", "honeybee", "positions"))]
    pub files: FileRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Days and rules.
    #[field(flatten)]
    pub request: SunlightRequest,
}

/// Request of `glare`.
#[derive(Clone, Debug, Request)]
pub struct Glare {
    /// Archive that is asked.
    #[field(flatten)]
    pub site: SiteRequest,
    /// Files to write.
    #[field(flatten, without("model", "honeybee", "positions"))]
    pub files: FileRequest,
    /// Receivers that count.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Days and rules.
    #[field(
        flatten,
        without(
            "every",
            "lit_share",
            "weather",
            "latitude",
            "longitude",
            "time_zone",
            "shift",
            "weather_stamp",
            "date_order"
        ),
        defaults("dates", "year")
    )]
    pub request: SunlightRequest,
    /// Period of a row, without --rule: a day, or all days of a month, a year or all of them
    /// [default: total].
    pub every: Option<Every>,
    /// Reflections that count, and further files.
    #[field(flatten)]
    pub glare: GlareChoice,
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
    /// Weather of a year, and the light that counts.
    #[field(flatten, without("columns", "bands", "every", "stamp", "year", "temperature"))]
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
    #[field(flatten, without("by", "positions", "model", "honeybee"))]
    pub files: FileRequest,
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
    #[field(flatten, without("by", "positions", "model", "honeybee"))]
    pub files: FileRequest,
    /// Weather, and what is computed.
    #[field(flatten)]
    pub request: ComfortRequest,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

/// Request of `rules`.
#[derive(Clone, Debug, Default, Request)]
pub struct Rules {
    /// Rule whose file is printed, to be copied and changed [default: list all rules].
    #[field(positional)]
    pub name: Option<String>,
}

fn summary_help() -> Message {
    table_help(
        "Table to write with a row for each AFTER: means, and how many receivers, windows and buildings lose more than 5, 10 and 20 %",
    )
}

fn unmatched_help() -> Message {
    table_help("Table to write of the receivers that only one of the archives holds")
}

impl Default for Compare {
    fn default() -> Self {
        Compare {
            site: SiteRequest::default(),
            after: Vec::new(),
            files: FileRequest::default(),
            receivers: SelectionRequest::default(),
            weather: None,
            conditions: None,
            request: ReplayRequest { every: Every::Total, ..ReplayRequest::default() },
            summary: None,
            unmatched: None,
        }
    }
}

impl Compare {
    /// Returns the request of the library.
    ///
    /// # Errors
    /// Neither weather nor conditions are named.
    pub fn request(&self) -> Result<CompareRequest> {
        let request = self.request.clone();
        let under = match (self.weather.clone(), self.conditions.clone()) {
            (Some(weather), _) => Illumination::Weather(Box::new(ReplayRequest { weather, ..request })),
            (None, Some(conditions)) => {
                Illumination::Conditions(Box::new(QueryRequest { light: request.light, conditions: conditions.into() }))
            }
            (None, None) => {
                return Err(Error::argument("weather, conditions", "none of them is given", "give one of them"));
            }
        };
        let (after, summary, unmatched) = (self.after.clone(), self.summary.clone(), self.unmatched.clone());
        Ok(CompareRequest { after, under, summary, unmatched })
    }
}

impl Default for Glare {
    fn default() -> Self {
        let dates = SunlightRequest::default().dates;
        let year = "year".parse().into_iter().collect();
        let dates = if dates.is_empty() { year } else { dates };
        Glare {
            site: SiteRequest::default(),
            files: FileRequest::default(),
            receivers: SelectionRequest::default(),
            request: SunlightRequest { dates, ..SunlightRequest::default() },
            every: None,
            glare: GlareChoice::default(),
        }
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
    let light = LightChoice { columns: Some(ComponentList::of(Component::Total)), ..replay.light.clone() };
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
            return Err(Error::argument("points, folder, replace", what, hint));
        }
        Ok(place.to_path_buf())
    }

    /// Returns the request for their comfort.
    pub fn request(&self) -> ComfortRequest {
        with_air(&self.request)
    }
}
