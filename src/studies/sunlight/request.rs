//! Request for hours of sun. In: the choices of a user. Out: these choices as one value that was
//! checked; a plan of days and rules.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::calendar::DaySpan;
use super::days::{DayPlan, WeatherDays};
use super::glare::GlareChoice;
use super::places::{DateRows, RowSubject};
use super::rule::RuleMeasure;
use super::rule_files::{own_rules, read_rules};
use super::trees::TreeShade;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::site::place::Place;
use heliotile_core::text::{counted, message};
use heliotile_core::weather::conditions::Stamp;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_core::weather::time::sun::Location;
use heliotile_core::weather::time::years::Years;
use heliotile_requests::{DefaultRequest, InputKind, Request, Role};
use heliotile_results::archives::Archives;
use heliotile_results::files::OutputRequest;
use heliotile_results::outputs::periods::{ClockReading, Every, Periods};
use heliotile_results::receivers::ReceiverSet;
use heliotile_results::request::ReplayRequest;
use heliotile_results::resources::Resources;

/// Request for minutes of possible sun on days, or for the verdicts of rules.
#[derive(Clone, Debug, PartialEq, Request, DefaultRequest)]
#[request(also = rule_files)]
pub struct SunlightRequest {
    /// Days to compute, separated by commas: 03-21, 2026-03-21, 02-19..10-21 or year; with --rule,
    /// the days for rules that state none.
    #[field(metavar = "DAYS", delimiter = ',')]
    pub dates: Vec<DaySpan>,
    /// Year of the dates that state none; results of other years differ by a few minutes.
    #[field(default = Date::NO_YEAR, range = 1..=2998)]
    pub year: i32,
    /// Period of a row, without --rule: a day, or all days of a month, a year or all of them.
    #[field(default = "day")]
    pub every: Every,
    /// Rule to check: a name that `heliotile info --rule all` lists, or a file with rules of your
    /// own (.toml); may be repeated.
    #[field(name = "rule", python = "rules", metavar = "NAME|FILE")]
    pub rules: Vec<String>,
    /// Archive or atlas before a change: adds its results, the minutes that changed, and the rules
    /// that are newly broken.
    #[field(metavar = "BEFORE", input = Archive)]
    pub before: Option<PathBuf>,
    /// Time zone of results: hours ahead of UTC, such as +01:00, or a name such as
    /// Europe/Amsterdam, with its summer time [default: that of the weather file if one is given,
    /// else whole hours by longitude].
    #[field(metavar = "ZONE", hyphen)]
    pub zone: Option<ClockZone>,
    /// Least altitude of the sun that counts, degrees; if a rule states one too, the higher one
    /// applies.
    #[field(metavar = "DEGREES", default = 0.0, range = 0.0..=90.0)]
    pub least_altitude_deg: f64,
    /// Share of a row's area that must be lit for a moment to count, without --rule [default: any
    /// part of it].
    #[field(metavar = "SHARE", default = 0.0, range = 0.0..=1.0)]
    pub lit_share: f64,
    /// Shade of trees and screens, which are materials with a transmittance.
    #[field(default = "ignore")]
    pub trees: TreeShade,
    /// Glare, in place of the sun itself.
    #[field(skip)]
    pub glare: Option<GlareChoice>,
    /// Refine moments at which an edge within a texel decides, by casting rays at the scene in the
    /// archive.
    pub exact: bool,
    /// Weather file, such as .epw: rules of probable sunlight hours count its hours with a DNI of
    /// at least 120 W/m2, and irradiance of glare follows its DNI instead of that of a clear sky.
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, heading = "About the weather file")]
    pub about_weather: WeatherOptions,
}

/// Counts of the results.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SunlightDone {
    /// Number of receivers or groups.
    pub places: u64,
    /// Number of days.
    pub days: u64,
    /// Counts of each rule's verdicts.
    pub rules: Vec<RuleCount>,
}

/// Numbers of places by the verdict of a rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RuleCount {
    /// Name of the rule.
    pub rule: String,
    /// Number of places that meet it.
    pub met: u64,
    /// Number of places that break it.
    pub broken: u64,
    /// Number of places whose distance from the threshold is within their uncertainty.
    pub close: u64,
    /// Number of places to which it does not apply.
    pub not_asked: u64,
    /// Number of places that break it and did not before.
    pub newly_broken: u64,
    /// Number of places among all of these that the site before does not have.
    pub only_after: u64,
}

impl SunlightDone {
    /// Returns the counts, in lines of text.
    pub fn text(&self) -> String {
        let (places, days) = (counted(self.places, "place"), counted(self.days, "day"));
        let rule = |count: &RuleCount| {
            let counts = [
                (count.met, "met"),
                (count.broken, "broken"),
                (count.close, "close"),
                (count.not_asked, "not applicable"),
                (count.newly_broken, "newly broken"),
                (count.only_after, "of all these only after the change"),
            ];
            let counts: Vec<String> =
                counts.iter().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}")).collect();
            format!("{}: {}\n", count.rule, counts.join(", "))
        };
        format!("{places}, {days}\n{}", self.rules.iter().map(rule).collect::<String>())
    }
}

/// Returns true if two paths name the same file; links are not resolved.
fn is_same_name(a: &Path, b: &Path) -> bool {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    whole(a) == whole(b)
}

/// Hands on the files of the user's own rules.
fn rule_files(request: &SunlightRequest, each: &mut dyn FnMut(&'static str, Role, &Path)) {
    own_rules(&request.rules).for_each(|file| each("rule", Role::Input(InputKind::Any), file));
}

impl SunlightRequest {
    /// Refuses numbers out of range, choices that exclude each other, unknown rules, and files that
    /// cannot hold such results, before an archive is opened.
    pub fn check(&self, files: &OutputRequest, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        if self.dates.is_empty() && self.rules.is_empty() {
            let hint = "give {dates} 03-21, or {rule} with a name such as tno-light";
            return Err(
                Error::argument("dates, rule", "neither dates nor a rule is given", hint).because(Problem::Missing)
            );
        }
        if self.every == Every::Hour {
            return Err(Error::argument(
                "every",
                "sun is summed over days or longer, not over hours",
                "give day, month, year or total",
            )
            .because(Problem::unknown("hour", [])));
        }
        if !self.rules.is_empty() && self.every != Every::Day {
            let hint = "leave it out: rules define their own days";
            return Err(Error::argument("every", "applies to days, and rules are given", hint));
        }
        if self.exact && self.trees != TreeShade::Ignore {
            let what = "is decided by texels, and rays that refine edges meet no leaves";
            return Err(Error::argument("trees", what, "leave out {exact}").because(Problem::excludes("exact")));
        }
        if files.model.is_some() || files.honeybee.is_some() {
            return Err(Error::argument(
                "model, honeybee",
                "hold irradiance only",
                "write a table or a map of sunlight",
            ));
        }
        if let Some(chart) = self.calendars(files).next().filter(|_| self.glare.is_none()) {
            let what = format!("`{}` does not end with .png, and sunlight is drawn only as a map", chart.display());
            return Err(Error::argument("plot", what, "give a name that ends with .png").because(Problem::Ending));
        }
        read_rules(&self.rules)?;
        let inputs: Vec<&Path> = inputs.iter().copied().chain(self.files()).collect();
        if let Some(glare) = &self.glare {
            glare.check(&inputs)?;
            let wants_spells = glare.files().next().is_some() || self.calendars(files).next().is_some();
            if wants_spells && !self.rules.is_empty() {
                let what = "show all sun in mirrors, and rules count only their own hours and angles";
                let hint = "leave out {rule}, and give {dates}, {least_deflection} and {view_angle}";
                return Err(Error::argument("spells, panes, plot", what, hint).because(Problem::excludes("rule")));
            }
            let mut others: Vec<&Path> =
                files.plots.iter().map(PathBuf::as_path).chain([files.output.as_path()]).collect();
            for path in glare.files() {
                if others.iter().any(|other| is_same_name(other, path)) {
                    let what = format!("`{}` is written twice", path.display());
                    return Err(Error::argument("spells, panes", what, "give each output a name of its own"));
                }
                others.push(path);
            }
        }
        files.check(None, None, &inputs)
    }

    /// Returns the pictures that are calendars.
    pub(super) fn calendars<'f>(&self, files: &'f OutputRequest) -> impl Iterator<Item = &'f Path> {
        let is_calendar = |plot: &&Path| plot.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg"));
        files.plots.iter().map(PathBuf::as_path).filter(is_calendar)
    }

    /// Returns the files that are read besides archives.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        own_rules(&self.rules).chain(self.weather.as_deref()).chain(self.before.as_deref())
    }

    /// Returns the days, and rules or labels of rows. Reads rules and weather, and warns of what is
    /// odd about them.
    pub(crate) fn plan(&self, archives: Archives, resources: &Resources) -> Result<(DayPlan, RowSubject)> {
        let rules = read_rules(&self.rules)?;
        let place = archives.manifest().place;
        let weather = match &self.weather {
            None => None,
            Some(path) => {
                let request = ReplayRequest { about_weather: self.about_weather, ..ReplayRequest::new(path) };
                let weather = request.read_weather(resources, &mut || Ok(place))?;
                request.tell_misfits(archives, &weather, resources.observer)?;
                Some(weather)
            }
        };
        let place = place.or(weather.as_ref().map(|weather| Place {
            latitude_deg: weather.site.latitude_deg,
            longitude_deg: weather.site.longitude_deg,
            convergence_deg: 0.0,
            epsg: None,
        }));
        let Some(place) = place else {
            let what = "has no place on Earth, so the position of the sun is unknown";
            let hint = "build it with {latitude} and {longitude}, or with {crs}; or give {weather}";
            return Err(Error::input(archives.first().path(), None, what, hint).because(Problem::Lacks("place")));
        };
        if archives.manifest().place.is_none() {
            resources.observer.note(format!(
                "the archive has no place: the sun is calculated for the place of the weather file, {place}"
            ));
        }
        let of_weather = weather.as_ref().map(|weather| ClockZone::Hours(weather.site.zone_hours));
        let zone = self.zone.or(of_weather).unwrap_or_else(|| {
            let zone = ClockZone::of_longitude(place.longitude_deg);
            resources
                .observer
                .note(message!("times are in the zone {zone}, from the longitude; {{zone}} sets another"));
            zone
        });
        let offset = zone.standard(self.year);
        let offset_h = f64::from(offset.minutes()) / 60.0;
        let site = Location::new(place.latitude_deg, place.longitude_deg, offset_h, 0.0);
        let site = site.map_err(|what| Error::input(archives.first().path(), None, what, "give another place"))?;
        // Requested days are used only by rules without days of their own.
        let are_used = rules.is_empty() || rules.iter().any(|rule| rule.needs_days() && rule.dates.is_empty());
        let asked = are_used.then_some(self.dates.as_slice());
        let spans: Vec<&[DaySpan]> = rules.iter().map(|rule| rule.dates.as_slice()).chain(asked).collect();
        let mut plan = DayPlan::new(site, zone, self.year, &spans);
        plan.weather = weather.as_ref().map(|weather| WeatherDays::new(weather, offset));
        let file = weather.as_ref().zip(self.weather.as_deref());
        if self.rules.is_empty() {
            if let Some((weather, path)) = file.filter(|_| self.glare.is_some()) {
                WeatherDays::check(weather, plan.dates.iter(), path)?;
            }
            let rows = self.rows(&plan);
            return Ok((plan, RowSubject::Dates(rows)));
        }
        for rule in rules.iter().filter(|rule| !rule.unconfirmed.is_empty()) {
            resources.observer.note(format!("{}: not confirmed: {}", rule.name, rule.unconfirmed));
        }
        let rules = plan.rules(rules, &self.dates, self.least_altitude_deg)?;
        if let Some((weather, path)) = file {
            let counting = rules.iter().filter(|planned| planned.rule.measure == RuleMeasure::ProbablePercent);
            let dates = counting.flat_map(|planned| &planned.days);
            WeatherDays::check(weather, dates.filter_map(|day| plan.dates.get(day.number)), path)?;
        }
        Ok((plan, RowSubject::Rules(rules)))
    }

    /// Returns the rows of days.
    fn rows(&self, plan: &DayPlan) -> DateRows {
        let years = if plan.names_years { Years::Several } else { Years::Typical };
        let stamps: Vec<Stamp> =
            plan.dates.iter().map(|date| Stamp { date: *date, start_min: 0.0, hours: 24.0 }).collect();
        let reading = ClockReading { offset: plan.zone.standard(self.year), ..ClockReading::default() };
        let Periods { labels, index_of_condition, .. } = Periods::new(self.every, years, &stamps, reading);
        DateRows { labels, bin_of_date: index_of_condition, is_by_day: self.every == Every::Day }
    }
}

/// Open archives of a site, and the receivers of the request.
#[derive(Clone, Copy)]
pub struct SunlightSite<'a> {
    /// Archives of the site.
    pub archives: Archives<'a>,
    /// Receivers of the request.
    pub receivers: &'a ReceiverSet<'a>,
    /// Path of the archive or of the atlas.
    pub place: &'a Path,
    /// Folder for temporary files that do not fit into memory.
    pub folder: &'a Path,
}
