//! Request for a solar envelope. In: the choices of a user, an open archive. Out: these choices as
//! a value that was checked; the table, the mesh and the counts of the envelope.

use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::choice::{Choice, LitDay, Need, Search};
use super::day_steps::DaySteps;
use super::grid::Grid;
use super::solid::Solid;
use crate::on_ground::{AreaSource, Ground};
use crate::sunlight::days::PlannedRule;
use crate::sunlight::exact::scene_of;
use crate::sunlight::places::{KeptSpells, PlaceQuestions, RowSubject};
use crate::sunlight::rule_files::read_rules;
use crate::sunlight::{DaysTogether, Rule, RuleMeasure, SunlightRequest, SunlightSite, Threshold};
use heliotile_builder::pipeline::PreparedScene;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::text::{counted, message};
use heliotile_core::units::parse_metres;
use heliotile_files::writing::guards::guard_output;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::buildings::check_table;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::tables::column::{Column, Digits};
use heliotile_results::outputs::tables::format::table_help;
use heliotile_results::outputs::tables::table::{Cell, Table};
use heliotile_results::resources::Resources;
use heliotile_sunlight::{Spells, SunDay, SunSeen};

/// Request for the largest building on a plot that leaves places around it their sun.
#[derive(Clone, Debug, PartialEq, Request, DefaultRequest)]
#[request(any_of("hours", "rule"))]
pub struct EnvelopeRequest {
    /// Plot: polygons (.geojson, .gpkg, .shp, .parquet), a CSV file of the corners of areas with
    /// columns x and y, and optionally area (a name), or a box xmin,ymin,xmax,ymax.
    #[field(name = "within", metavar = "FILE|BOX", required, hyphen, input = Any)]
    pub plot: Option<AreaSource>,
    /// Hours of sun that each receiver keeps on each of --dates; one that has fewer keeps them all.
    #[field(metavar = "HOURS", conflicts("rule"), requires("dates"), range = 0.0..=24.0)]
    pub hours: Option<f64>,
    /// Distance between the nodes of the grid, metres.
    #[field(metavar = "LENGTH", default = "1m", parse = parse_metres, range = 0.05..=1000.0, says = "give a length from 5cm to 1km")]
    pub spacing_m: f64,
    /// Greatest height above the ground.
    #[field(metavar = "LENGTH", default = "50m", parse = parse_metres, range = 1.0..=1000.0, says = "give a height from 1m to 1km")]
    pub height_limit_m: f64,
    /// Table of nodes: places in plan, the ground, and the height that a building may have there.
    #[field(short = 'o', default = "-", help = output_help, output = Table)]
    pub output: PathBuf,
    /// Mesh to write of the envelope, a closed body (.obj), which `update` adds to the archive.
    #[field(metavar = "FILE.obj", output = File)]
    pub mesh: Option<PathBuf>,
    /// Days, and what counts as sun.
    #[field(
        flatten,
        without(
            "every",
            "before",
            "lit_share",
            "weather",
            "latitude",
            "longitude",
            "time_zone",
            "shift",
            "weather_stamp",
            "date_order"
        )
    )]
    pub sun: SunlightRequest,
}

/// Largest number of nodes of a grid.
const MAX_NODES: f64 = 1e6;

/// Height above the ground from which something stands on a plot, metres.
const STANDS_M: f64 = 0.5;

/// Size of an envelope, and counts of the places that decide it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EnvelopeDone {
    /// Area of the plot that the grid covers, m2.
    pub plot_m2: f64,
    /// Volume, m3.
    pub volume_m3: f64,
    /// Largest height above the ground, metres.
    pub height_m: f64,
    /// Number of places that were looked at.
    pub places: u64,
    /// Number of them whose sun the envelope had to spare.
    pub bound: u64,
    /// Number of them that have less sun than is asked for, today.
    pub short: u64,
}

impl EnvelopeDone {
    /// Returns the size and the counts as a sentence.
    pub fn text(&self) -> String {
        let EnvelopeDone { plot_m2, volume_m3, height_m, places, bound, short } = self;
        format!(
            "{volume_m3:.0} m3 on {plot_m2:.0} m2, at most {height_m:.1} m high\n{}: {bound} limit it, {short} have less sun than is asked for today",
            counted(*places, "place")
        )
    }
}

fn output_help() -> heliotile_requests::Message {
    table_help("Table of nodes to write: places in plan, the ground, and the height that a building may have there")
}

/// Returns the error for a request without hours and without a rule.
fn nothing_asked() -> Error {
    let hint = "give {hours} 2 and {dates} 03-21, or {rule} with a name such as tno-light";
    Error::argument("hours, rule", "neither hours nor a rule is given", hint).because(Problem::Missing)
}

/// Need of places by a rule, or by hours.
struct Asked {
    minutes: f64,
    together: DaysTogether,
    choice: Choice,
    former_share: Option<f64>,
}

impl Asked {
    fn of_rule(rule: &Rule) -> Result<Self> {
        let counts = matches!(rule.measure, RuleMeasure::Minutes | RuleMeasure::LongestSpell);
        let (true, Threshold::AtLeast(minutes)) = (counts, rule.threshold) else {
            let what = format!("`{}` asks for no minutes of sun", rule.name);
            let hint = "give one that does, such as en-17037-minimum, or {hours} and {dates}";
            return Err(Error::argument("rule", what, hint));
        };
        let is_in_one = rule.measure == RuleMeasure::LongestSpell || rule.least_spell_min > 0.0;
        let choice = if is_in_one { Choice::OneSpell } else { Choice::Any };
        let minutes = minutes.max(rule.least_spell_min);
        Ok(Asked { minutes, together: rule.days, choice, former_share: rule.former_share })
    }

    /// Adds what a place needs, but for needs that cost nothing. Returns true if the place has less
    /// than is asked for: it then keeps what it has, or the share of it that the rule allows.
    fn add(&self, place: DVec3, lit: Vec<LitDay>, cost: impl Fn(&Need) -> f64, needs: &mut Vec<Need>) -> bool {
        let minutes: Vec<f64> = lit.iter().map(|day| day.minutes(self.choice)).collect();
        let need = |days: Vec<LitDay>, minutes: f64| Need { place, days, minutes, choice: self.choice };
        let enough = |asked: f64, value: f64| {
            let of_former = self.former_share.map_or(value, |share| share * value);
            if self.former_share.is_some() || value < asked { asked.min(of_former) } else { asked }
        };
        let (asked, value) = match self.together {
            DaysTogether::Each => (self.minutes, minutes.iter().copied().fold(f64::INFINITY, f64::min)),
            DaysTogether::Any => (self.minutes, minutes.iter().copied().fold(0.0, f64::max)),
            DaysTogether::Sum => (self.minutes, minutes.iter().sum()),
            DaysTogether::Mean => (self.minutes * minutes.len() as f64, minutes.iter().sum()),
        };
        let is_short = value < asked;
        let bound = |need: Need| {
            let cost = cost(&need);
            (cost > 0.0).then_some((cost, need))
        };
        match self.together {
            DaysTogether::Each => {
                for (day, has) in lit.into_iter().zip(minutes) {
                    let keeps = if self.former_share.is_some() { enough(asked, value) } else { enough(asked, has) };
                    needs.extend(bound(need(vec![day], keeps.min(has))).map(|(_, need)| need));
                }
            }
            DaysTogether::Any => {
                let keeps = enough(asked, value);
                let fits = lit.into_iter().zip(minutes).filter(|(_, has)| *has >= keeps);
                let each: Vec<Option<(f64, Need)>> = fits.map(|(day, _)| bound(need(vec![day], keeps))).collect();
                // A day on which the need costs nothing is enough.
                if each.iter().all(Option::is_some) {
                    let best = each.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
                    needs.extend(best.map(|(_, need)| need));
                }
            }
            DaysTogether::Sum | DaysTogether::Mean => {
                needs.extend(bound(need(lit, enough(asked, value))).map(|(_, need)| need));
            }
        }
        is_short
    }
}

impl EnvelopeRequest {
    /// Refuses numbers out of range, rules that are not about minutes of sun, and files that would
    /// replace an input or have a wrong ending.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        let Some(plot) = &self.plot else {
            let hint = "give {within} a file of polygons or a box";
            return Err(Error::argument("within", "no plot is given", hint).because(Problem::Missing));
        };
        plot.check()?;
        let rules = read_rules(&self.sun.rules)?;
        match (self.hours, rules.as_slice()) {
            (None, []) => return Err(nothing_asked()),
            (Some(_), [_, ..]) => {
                return Err(Error::argument("hours", "is given, and a rule too", "leave one of them out")
                    .because(Problem::excludes("rule")));
            }
            (Some(_), []) if self.sun.dates.is_empty() => {
                return Err(Error::argument("dates", "none are given", "give {dates} 03-21, or 02-19..10-21")
                    .because(Problem::Missing));
            }
            (_, rules) => rules.iter().try_for_each(|rule| Asked::of_rule(rule).map(drop))?,
        }
        let plot_file = if let AreaSource::File(file) = plot { Some(file.as_path()) } else { None };
        let inputs: Vec<&Path> = inputs.iter().copied().chain(self.sun.files()).chain(plot_file).collect();
        if let Some(mesh) = &self.mesh {
            if !mesh.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj")) {
                let what = format!("`{}` does not end with .obj", mesh.display());
                return Err(Error::argument("mesh", what, "give a name that ends with .obj").because(Problem::Ending));
            }
            guard_output(mesh, &inputs)?;
        }
        check_table(&self.output, &inputs)
    }

    /// Writes the files. Errors: an atlas of several archives, an archive without its scene, a plot
    /// without ground below it.
    pub fn write(&self, site: &SunlightSite, about: Provenance, resources: &Resources) -> Result<EnvelopeDone> {
        let archive = site.archives.first();
        if site.archives.iter().count() > 1 {
            let hint = "give one of its parts, or `archive merge` them";
            return Err(Error::input(site.place, None, "is an atlas of several archives", hint));
        }
        let (plan, asked) = self.sun.plan(site.archives, resources)?;
        self.sun.tell(site.archives, resources);
        let scene = scene_of(archive)?;
        let prepared = PreparedScene::new(&scene)?;
        let (grid, names) = self.grid(&Ground::new(&prepared), site, resources)?;
        let Some(part) = site.receivers.parts().first() else { return Ok(EnvelopeDone::default()) };
        let suns = plan.suns(part.site.north(), part.site.settings().sides());
        // `[rule]`: what it asks for, and its days: numbers of `suns`, and their steps of a minute.
        let mut days: Vec<DaySteps> = Vec::new();
        let mut steps = |number: usize, counts: Option<&Spells>| {
            let of_day = |day: &SunDay| DaySteps::new(day, counts.unwrap_or(&day.up));
            days.push(suns.days.get(number).map_or_else(DaySteps::default, of_day));
            days.len() - 1
        };
        let asks: Vec<(Asked, Vec<usize>)> = match &asked {
            RowSubject::Dates(_) => {
                let all = (0..plan.dates.len()).map(|number| steps(number, None)).collect();
                let minutes = 60.0 * self.hours.ok_or_else(nothing_asked)?;
                vec![(Asked { minutes, together: DaysTogether::Each, choice: Choice::Any, former_share: None }, all)]
            }
            RowSubject::Rules(rules) => {
                let of = |planned: &PlannedRule| {
                    let all = planned.days.iter().map(|day| steps(day.number, Some(&day.counts))).collect();
                    Ok((Asked::of_rule(&planned.rule)?, all))
                };
                rules.iter().map(of).collect::<Result<_>>()?
            }
        };
        let questions = PlaceQuestions {
            receivers: site.receivers,
            plan: &plan,
            asked: &asked,
            least_altitude_deg: self.sun.least_altitude_deg,
            trees: self.sun.trees,
            glare: None,
            panes: None,
            exact: self.sun.exact,
            kept: KeptSpells::All,
        };
        // `[place]`: where it is, and its sure spells, `[rule][day]`; none for a rule that does not
        // apply.
        let mut places: Vec<(DVec3, Vec<Vec<Spells>>)> = Vec::new();
        questions.each(resources, |answer| {
            let sure = |day: SunSeen| day.sure;
            let items = answer.items.into_iter().map(|item| item.map(|item| item.days).unwrap_or_default());
            let spells: Vec<Vec<Spells>> = match &asked {
                RowSubject::Dates(_) => vec![items.flatten().map(sure).collect()],
                RowSubject::Rules(_) => items.map(|days| days.into_iter().map(sure).collect()).collect(),
            };
            places.push((answer.position, spells));
            Ok(true)
        })?;
        let limits_m: Vec<f64> = grid.nodes.iter().map(|node| node.ground_m + self.height_limit_m).collect();
        let found: Vec<(Vec<Need>, bool)> = places
            .par_iter()
            .map(|(place, spells)| {
                let (mut needs, mut is_short) = (Vec::new(), false);
                for ((asked, numbers), spells) in asks.iter().zip(spells).filter(|(_, spells)| !spells.is_empty()) {
                    let lit =
                        |(day, spells): (&usize, &Spells)| LitDay { day: *day, minutes: days[*day].within(spells) };
                    let lit = numbers.iter().zip(spells).map(lit).collect();
                    is_short |= asked.add(*place, lit, |need| need.cost_m3(&days, &grid, &limits_m), &mut needs);
                }
                (needs, is_short)
            })
            .collect();
        let bound = found.iter().filter(|(needs, _)| !needs.is_empty()).count() as u64;
        let short = found.iter().filter(|(_, is_short)| *is_short).count() as u64;
        if bound == 0 {
            resources.observer.warn(
                "no receiver loses sun that it needs to the plot, which is filled up to {height_limit}: are its coordinates those of the \
                 scene, and are there receivers around it?",
            );
        }
        let needs: Vec<Need> = found.into_iter().flat_map(|(needs, _)| needs).collect();
        let tops_m = Search::new(needs, &days, &grid, limits_m).tops(resources.observer)?;
        let solid = Solid::new(&grid, &tops_m);
        let about = site.archives.told_in(about, site.place);
        self.table(&grid, &names, &solid, &tops_m, &about)?;
        if let Some(mesh) = &self.mesh {
            solid.write(mesh, &about)?;
        }
        let (volume_m3, height_m) = solid.volume_m3_and_height_m();
        Ok(EnvelopeDone { plot_m2: grid.area_m2(), volume_m3, height_m, places: places.len() as u64, bound, short })
    }

    /// Returns the grid on the plot.
    fn grid(&self, ground: &Ground, site: &SunlightSite, resources: &Resources) -> Result<(Grid, Vec<String>)> {
        let epsg = site.archives.manifest().place.and_then(|place| place.epsg);
        let areas = match &self.plot {
            Some(plot) => plot.read(epsg, resources.observer)?,
            None => Vec::new(),
        };
        let count: f64 = areas.iter().map(|area| area.most_places(self.spacing_m)).sum();
        if count > MAX_NODES {
            let what = format!("{} m would give {:.1} million nodes", self.spacing_m, count / 1e6);
            return Err(Error::argument("spacing", what, "give a wider spacing, or a smaller plot"));
        }
        let grid = Grid::new(&areas, self.spacing_m, |at| ground.height_m(at));
        if grid.squares.is_empty() {
            let hint = "give a plot on the ground of the scene, in its coordinates, or a smaller spacing";
            return Err(Error::argument("within", "no square of the grid lies on it", hint).because(Problem::Misplaced));
        }
        let built = grid.nodes.iter().filter(|node| ground.built_m(node.at, node.ground_m) > STANDS_M).count() as u64;
        if built > 0 {
            resources.observer.warn(message!(
                "something stands on {} of {} of the plot: sun that it takes today is not kept (clear the plot first, with \
                 {{command:update}} and {{remove}})",
                built,
                counted(grid.nodes.len() as u64, "node")
            ));
        }
        Ok((grid, areas.into_iter().map(|area| area.name).collect()))
    }

    /// Writes the table of nodes.
    fn table(&self, grid: &Grid, names: &[String], solid: &Solid, tops_m: &[f64], about: &Provenance) -> Result<()> {
        let metres = |name: &str| Column::number_as(name, Digits::Thousandths);
        let columns = vec![
            Column::text("area"),
            metres("x"),
            metres("y"),
            metres("ground_z_m"),
            metres("height_m"),
            Column::number_as("area_m2", Digits::Six),
        ];
        let mut table = Table::of_rows(&self.output, columns, grid.nodes.len() as u64, Some(about))?;
        for ((node, top_m), is_built) in grid.nodes.iter().zip(tops_m).zip(solid.nodes()) {
            if table.is_closed() {
                break;
            }
            let height_m = if is_built { top_m - node.ground_m } else { 0.0 };
            let name = names.get(node.plot).map_or("", String::as_str);
            let numbers = [node.at.x, node.at.y, node.ground_m, height_m, node.area_m2].map(Cell::from);
            table.row(std::iter::once(Cell::from(name)).chain(numbers))?;
        }
        table.finish().map(drop)
    }
}
