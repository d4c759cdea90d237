//! An EnergyPlus model with the sun that its surroundings reflect. In: a model, its surroundings.
//! Out: a folder with the model that an unmodified EnergyPlus runs, the archive, and a report.

mod around;
mod pages;
mod runs;
mod stripped;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::checks;
use crate::document::Document;
use crate::injection::{self, Changed, Injection};
use crate::named_files::{NamedFiles, make_absolute};
use crate::report::Report;
use crate::sun_tables::{GroundRange, ReflectedSky, SurfaceLight, TableRequest, surface_lights};
use around::ModelSurroundings;
use heliotile_builder::planning::AccuracyRequest;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::trace::placement::Placement;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::named::NamedValues;
use heliotile_core::replay::factors::SunGrid;
use heliotile_core::text::{Message, counted};
use heliotile_core::units::parse_metres;
use heliotile_files::input;
use heliotile_files::writing::guards::{guard_archive, guard_output};
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::Resources;
use heliotile_results::outputs::sink::{write_file, write_texts};
use heliotile_scene::Scene;
use heliotile_scene::placing::frame::parse_crs;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;
use heliotile_studies::covering::cover_site;
use heliotile_studies::covering::{CoverRequest, Density, PlacedReceivers};
use heliotile_studies::site_build::{FolderOption, KEEP_OR_REPLACE, ReceiverSource, SiteBuild, SiteFolder};
use runs::Engine;
use stripped::Full;

/// Distance of receivers from their surfaces, metres.
const OFFSET_M: f64 = 0.02;

/// File names of the report.
const REPORT: [&str; 2] = ["report.md", "report.html"];

/// Request for an EnergyPlus model.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct EnergyplusRequest {
    /// EnergyPlus model, .idf or .epJSON, of version 24.1 to 25.2; with --assume-version 25.2 of
    /// any version that EnergyPlus 25.2 runs.
    #[field(positional, metavar = "MODEL", input = Scene)]
    pub model: PathBuf,
    /// Scene files of the surroundings: CityJSON, terrain, meshes, site.toml; in the coordinates of
    /// the model, unless --at is given.
    #[field(metavar = "SCENE", several, input = Scene)]
    pub scene: Vec<PathBuf>,
    /// Position of the model's origin in the coordinates of --scene, metres: east,north or
    /// east,north,up. The model is turned so that its true north is that of their coordinate
    /// system.
    #[field(metavar = "E,N[,Z]", requires("scene"), hyphen, parse = parse_spot)]
    pub at: Option<[f64; 3]>,
    /// Coordinate reference system of --scene, in place of the one that its files state: EPSG:28992
    /// or 28992.
    #[field(metavar = "EPSG", requires("scene"), parse = parse_crs)]
    pub crs: Option<u32>,
    /// Remove the shading objects of the surroundings from the model. Their effect on direct and
    /// diffuse light becomes a time series for --weather, and EnergyPlus computes no shadows of
    /// them.
    #[field(requires("weather"))]
    pub delete_surroundings: bool,
    /// Weather file for --run and --delete-surroundings.
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Folder to write: model.idf or model.epJSON, report.md and .html, receivers.csv and
    /// site.helio; with --delete-surroundings also series.csv, and stripped.idf with an archive of
    /// its own.
    #[field(name = "output", short = 'o', metavar = "FOLDER", output = Folder(&[]), required)]
    pub folder: PathBuf,
    /// Reflected light that the model gets.
    #[field(default = "full")]
    pub physics: Physics,
    /// Run EnergyPlus three times (without reflections, with its own, with the injected light) and
    /// compare the results in the report.
    #[field(requires("weather"))]
    pub run: bool,
    /// Folder of EnergyPlus 25.2 [default: that of `energyplus` on the search path].
    #[field(metavar = "DIR", requires("run"))]
    pub energyplus: Option<PathBuf>,
    /// Distance between receivers on the model's surfaces, such as 1m or 50cm; with
    /// --delete-surroundings the default is 50cm, as shadows depend on it.
    #[field(metavar = "LENGTH", default = "1m", parse = parse_metres)]
    pub spacing_m: Option<f64>,
    /// Options of surfaces; the files are those of the model and of its surroundings.
    #[field(
        flatten,
        without(
            "scene",
            "dsm",
            "dem",
            "canopy",
            "landcover",
            "crs",
            "latitude",
            "longitude",
            "rotate_deg",
            "grid_north",
            "elevation",
            "scale",
            "up"
        )
    )]
    pub surfaces: SceneRequest,
    /// Accuracy of the archive.
    #[field(flatten)]
    pub accuracy: AccuracyRequest,
    /// Replace results in the folder that are of another model, scene, spacing or accuracy; without
    /// this option they are an error.
    #[field(neutral)]
    pub replace: bool,
}

/// Light paths that are injected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Physics {
    /// All light paths.
    #[default]
    Full,
    /// Light paths that EnergyPlus has, too.
    EnergyPlus,
}

impl NamedValues for Physics {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("full", "All reflections, mirrors included, and the sky of Perez 1990", Physics::Full),
        (
            "energyplus",
            "One diffuse reflection and the mirrored sun, as EnergyPlus computes them, for comparison",
            Physics::EnergyPlus,
        ),
    ];
}

heliotile_core::serde_by_name!(Physics);

/// A request, and its resources.
pub(super) struct Task<'a> {
    pub request: &'a EnergyplusRequest,
    pub resources: Resources<'a>,
}

/// Surfaces of the model, and whose light each gets.
pub(super) struct Targets {
    /// Names of EnergyPlus's surfaces, each with the number of its light; hidden ones get none.
    pub list: Vec<(String, Option<usize>)>,
    /// Openings that get the light of their wall: name of the opening, name of the wall.
    pub by_wall: Vec<(String, String)>,
    /// Surfaces whose whole area is hidden.
    pub hidden: Vec<String>,
    /// Surfaces a part of whose area is hidden.
    pub partly: Vec<PartlyHidden>,
}

impl Targets {
    /// Assigns light to surfaces: their own, which is that of `lit` in order, their wall's, or none
    /// to hidden ones; openings in hidden walls are listed if `with_hidden_walls`.
    fn new(document: &Document, lit: &[&str], covered: &PlacedReceivers, with_hidden_walls: bool) -> Targets {
        let number: BTreeMap<String, usize> = lit.iter().zip(0..).map(|(name, i)| (name.to_lowercase(), i)).collect();
        let all = covered.all().map(|(_, piece, surface, _)| covered.part(piece, surface).face);
        let hidden: BTreeSet<String> = all.filter(|name| !number.contains_key(&name.to_lowercase())).collect();
        let walls = hidden.iter().filter(|_| with_hidden_walls).map(|name| name.to_lowercase());
        let by_wall = checks::openings_left_out(document, &number.keys().cloned().chain(walls).collect());
        let mut list: Vec<(String, Option<usize>)> =
            lit.iter().zip(0..).map(|(name, i)| ((*name).to_owned(), Some(i))).collect();
        list.extend(by_wall.iter().map(|(name, wall)| (name.clone(), number.get(wall).copied())));
        list.extend(hidden.iter().map(|name| (name.clone(), None)));
        Targets { list, by_wall, hidden: hidden.into_iter().collect(), partly: partly_hidden(covered) }
    }

    /// Returns the number of surfaces with light of their own: those of the report's table.
    pub(super) fn own(&self) -> usize {
        let numbers: BTreeSet<usize> = self.list.iter().filter_map(|(_, number)| *number).collect();
        numbers.len()
    }

    /// Words the other surfaces, for a sentence on the first ones.
    pub(super) fn others(&self) -> String {
        let words = |count: usize, what: &str| match count {
            0 => String::new(),
            count => format!(", {} {what}", counted(count as u64, "surface")),
        };
        [words(self.by_wall.len(), "that of their wall"), words(self.hidden.len(), "none (hidden)")].concat()
    }
}

/// A surface a part of which is hidden.
pub(super) struct PartlyHidden {
    pub name: String,
    /// Area that gets light, m2.
    pub free_m2: f64,
    /// Whole area, m2.
    pub whole_m2: f64,
}

/// Hidden share of a surface up to which it is an edge effect and not reported.
const HARDLY_HIDDEN: f64 = 0.01;

/// Returns the surfaces that are hidden in part, by name.
pub(super) fn partly_hidden(covered: &PlacedReceivers) -> Vec<PartlyHidden> {
    let mut areas: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (_, piece, surface, placement) in covered.all() {
        let [free_m2, whole_m2] = areas.entry(covered.part(piece, surface).face).or_default();
        *whole_m2 += piece.area_m2;
        if placement == Placement::Free {
            *free_m2 += piece.area_m2;
        }
    }
    let partly = areas.into_iter().map(|(name, [free_m2, whole_m2])| PartlyHidden { name, free_m2, whole_m2 });
    partly.filter(|p| p.free_m2 > 0.0 && p.free_m2 < (1.0 - HARDLY_HIDDEN) * p.whole_m2).collect()
}

/// Warns of surfaces that are hidden in part.
pub(super) fn warn_of_partly_hidden(partly: &[PartlyHidden], task: &Task) {
    if let Some(first) = partly.first() {
        task.warn(format!(
            "{} partly hidden by a neighbour or the ground, where they get no light (first: `{}`, {:.2} of {:.2} m2 get light); the report \
             lists all",
            counted_are(partly.len(), "surface"),
            first.name,
            first.free_m2,
            first.whole_m2
        ));
    }
}

/// Words a count with its verb: "1 surface is", "2 surfaces are".
fn counted_are(count: usize, what: &str) -> String {
    format!("{} {}", counted(count as u64, what), if count == 1 { "is" } else { "are" })
}

/// Reads the model with absolute file names, ready to be written into another folder.
fn read_model(task: &Task) -> Result<(Document, NamedFiles)> {
    let mut document = Document::read(&task.request.model, input::read(&task.request.model)?)?;
    let files = make_absolute(&mut document)?;
    Ok((document, files))
}

/// Usual distances between receivers, metres: shadows of deleted surroundings depend on it.
const SPACINGS_M: [f64; 2] = [1.0, 0.5];

impl EnergyplusRequest {
    /// Returns the distance between receivers on the model's surfaces, metres.
    fn spacing_m(&self) -> f64 {
        self.spacing_m.unwrap_or(SPACINGS_M[usize::from(self.delete_surroundings)])
    }

    /// Returns a request for a model by itself, with all reflections.
    pub fn new(model: impl Into<PathBuf>, folder: impl Into<PathBuf>) -> Self {
        EnergyplusRequest { model: model.into(), folder: folder.into(), ..EnergyplusRequest::default() }
    }

    /// Writes the folder: the model with its light, the archive, a report.
    pub fn write(&self, resources: &Resources) -> Result<()> {
        check_ranges(self)?;
        run(&Task { request: self, resources: *resources })
    }

    /// Returns a site of files, with the options of surfaces.
    fn site(&self, files: &[PathBuf]) -> Result<SceneFiles> {
        SceneRequest { files: files.to_vec(), ..self.surfaces.clone() }.site()
    }
}

impl Task<'_> {
    fn warn(&self, text: impl Into<Message>) {
        self.resources.observer.warn(text);
    }

    /// Tells what is hidden, what was changed and what to know.
    fn tell(&self, targets: &Targets, notes: &[Message], warnings: &[Message]) {
        warn_of_partly_hidden(&targets.partly, self);
        notes.iter().for_each(|note| self.report(note.clone().and("\n")));
        warnings.iter().for_each(|text| self.warn(text));
    }

    /// Words sentences of a report for the user interface.
    fn worded(&self, sentences: &[Message]) -> Vec<String> {
        sentences.iter().map(|text| self.resources.observer.in_words(text)).collect()
    }

    fn report(&self, text: impl Into<Message>) {
        self.resources.observer.report(text);
    }
}

fn run(task: &Task) -> Result<()> {
    let (mut document, named_files) = read_model(task)?;
    checks::check(&document, task.request.surfaces.assume_version)?;
    // A missing EnergyPlus is reported before minutes of tracing.
    let engine = task.request.run.then(|| Engine::find(task.request.energyplus.as_deref())).transpose()?;
    let steps = stripped::steps(task, &document)?;
    let ModelSurroundings { site, neighbours, materials, types } = ModelSurroundings::read(task)?;
    let files = Files::new(task, &document);
    files.guard(task, &site)?;
    let (scene, covered) =
        cover_site(&site, &cover_of(task, types), task.resources.observer).map_err(|error| no_surface(task, error))?;
    let archive = traced(task, &scene, &covered, &files.receivers, &files.archive, EffectChoice::Auto)?;
    let bare = || {
        let (mut model, _) = read_model(task)?;
        neighbours.add(&mut model, &materials, true);
        Ok(model)
    };
    if let Some(steps) = steps {
        let full = Full { files: &files, archive: &archive, covered: &covered, bare: &bare, engine, named_files };
        return stripped::run(task, document, &steps, full);
    }
    let ground = match task.request.physics {
        Physics::EnergyPlus => GroundRange::UNIT,
        Physics::Full => ground_range(&document),
    };
    let lights = lights(task, ground, &archive, &covered)?;
    let names: Vec<&str> = lights.iter().map(|light| light.name.as_str()).collect();
    let targets = Targets::new(&document, &names, &covered, true);
    let injection =
        Injection { grid: SunGrid::USUAL, sky: sky_of(task.request.physics), lights: &lights, targets: &targets.list };
    let mut changed = injection::write(&mut document, &injection)?;
    changed.notes.extend(named_files.notes);
    neighbours.add(&mut document, &materials, false);
    let injected: BTreeSet<String> = targets.list.iter().map(|(name, _)| name.to_lowercase()).collect();
    let mut warnings = named_files.warnings;
    warnings.extend(checks::warnings(&document, task.request.surfaces.assume_version, &injected));
    task.tell(&targets, &changed.notes, &warnings);
    let told = pages::ReportContents {
        task,
        archive: &archive,
        lights: &lights,
        ground,
        targets: &targets,
        changed: &changed,
        warnings: &warnings,
    };
    let mut report = pages::report(&told);
    write_document(&files.model, &document)?;
    task.report(summary(&files, &targets, &changed));
    if let (Some(engine), Some(weather)) = (engine, &task.request.weather) {
        report.sections.extend(runs::run_all(
            &engine,
            &bare,
            document,
            weather,
            &task.request.folder.join("energyplus"),
            &areas(&covered),
            task.resources.observer,
        )?);
    }
    write_report(task, &report)
}

/// Traces receivers on a scene, or reuses their archive. Writes the archive to `archive`, and the
/// table of receivers to `receivers`.
fn traced(
    task: &Task,
    scene: &Scene,
    covered: &PlacedReceivers,
    receivers: &Path,
    archive: &Path,
    effects: EffectChoice,
) -> Result<Archive> {
    let accuracy = &task.request.accuracy;
    let memory = task.resources.memory;
    let receivers = ReceiverSource::Placed { placed: covered, offset_m: OFFSET_M, table: receivers };
    let build = SiteBuild { effects, memory, ..SiteBuild::new(scene, receivers, accuracy) };
    let folder = SiteFolder {
        folder: &task.request.folder,
        archive,
        replace: task.request.replace,
        named_by: FolderOption::Output,
    };
    let found = build.ensure(&folder, task.resources.observer)?;
    let name = archive.file_name().unwrap_or_default().to_string_lossy();
    task.resources.observer.stop_if_cancelled(&format!("after {name} was complete"))?;
    Ok(found)
}

fn write_report(task: &Task, report: &Report) -> Result<()> {
    let mut texts = vec![(REPORT[0], report.markdown()), (REPORT[1], report.html())];
    texts.extend(report.pictures().map(|(name, svg)| (name, svg.to_owned())));
    write_texts(&task.request.folder, &texts)
}

/// Returns the areas of surfaces with their hidden parts, by name in small letters, m2.
fn areas(covered: &PlacedReceivers) -> BTreeMap<String, f64> {
    let mut whole_m2: BTreeMap<String, f64> = BTreeMap::new();
    for (_, piece, surface, _) in covered.all() {
        *whole_m2.entry(covered.part(piece, surface).face.to_lowercase()).or_default() += piece.area_m2;
    }
    whole_m2
}

/// Paths of the files in the folder.
struct Files {
    receivers: PathBuf,
    archive: PathBuf,
    model: PathBuf,
}

impl Files {
    fn new(task: &Task, document: &Document) -> Files {
        let name = |name: &str| task.request.folder.join(name);
        Files {
            receivers: name("receivers.csv"),
            archive: name("site.helio"),
            model: name(&format!("model.{}", document.ending())),
        }
    }

    /// Returns the further files of a model without its surroundings: the model, its receivers, its
    /// archive, the series.
    fn of_stripped(&self) -> Vec<PathBuf> {
        let ending = self.model.extension().unwrap_or_default().to_string_lossy();
        let names = [&format!("stripped.{ending}"), "stripped.csv", "stripped.helio", stripped::SERIES];
        names.map(|name| self.model.with_file_name(name)).to_vec()
    }

    /// Refuses to replace an input, or results of something else.
    fn guard(&self, task: &Task, site: &SceneFiles) -> Result<()> {
        let inputs: Vec<&Path> = site.files().chain(task.request.weather.as_deref()).collect();
        let more = if task.request.delete_surroundings { self.of_stripped() } else { Vec::new() };
        for output in [&self.receivers, &self.archive, &self.model].into_iter().chain(&more) {
            guard_output(output, &inputs)?;
        }
        guard_archive(&self.archive)?;
        // A model without the archive that it was made from may be the user's own file.
        let there = std::iter::once(&self.model).chain(&more).find(|path| path.exists());
        if let Some(path) = there.filter(|_| !self.archive.exists() && !task.request.replace) {
            let what = "is there already, without the site.helio that heliotile writes beside it";
            return Err(Error::input(path, None, what, KEEP_OR_REPLACE));
        }
        Ok(())
    }
}

/// Returns the request for receivers on all surfaces of the model that the sun may reach.
fn cover_of(task: &Task, types: Vec<String>) -> CoverRequest {
    let density = Density::Spacing(task.request.spacing_m());
    CoverRequest { on: Vec::new(), types, density, offset_m: OFFSET_M, min_area_m2: 0.0, ..CoverRequest::default() }
}

/// Words the error of a model without surfaces outdoors.
fn no_surface(task: &Task, error: Error) -> Error {
    match error {
        Error::Argument { argument, .. } if argument == "on" => {
            let what = "has no wall, roof or window that the sun may reach";
            let hint = "give a model with surfaces that are `Outdoors` and `SunExposed`";
            Error::input(&task.request.model, None, what, hint).because(Problem::Empty)
        }
        error => error,
    }
}

fn sky_of(physics: Physics) -> ReflectedSky {
    match physics {
        Physics::EnergyPlus => ReflectedSky::Uniform,
        Physics::Full => ReflectedSky::Perez1990,
    }
}

/// Computes the light of surfaces; their hidden parts get none.
fn lights(task: &Task, ground: GroundRange, archive: &Archive, covered: &PlacedReceivers) -> Result<Vec<SurfaceLight>> {
    let paths = match task.request.physics {
        Physics::EnergyPlus => LightPaths::FIRST,
        Physics::Full => LightPaths::ALL,
    };
    let sky = sky_of(task.request.physics);
    let asked = TableRequest { grid: SunGrid::USUAL, paths, sky, ground, resources: task.resources };
    let whole_m2 = areas(covered);
    let mut lights = surface_lights(archive, &asked)?;
    for light in &mut lights {
        light.spread_over(whole_m2.get(&light.name.to_lowercase()).copied().unwrap_or_default());
    }
    Ok(lights)
}

/// Returns the range of the ground's reflectance over the months of a model, with and without snow.
fn ground_range(document: &Document) -> GroundRange {
    let ground = injection::ground_of(document);
    let all = || (1..=12).flat_map(|month| [None, Some(1.0)].map(|snow_cm| ground.of(month, snow_cm)));
    let (low, high) = (all().fold(1.0, f64::min), all().fold(0.0, f64::max));
    if low < high {
        GroundRange { low, high }
    } else {
        let high = high.max(injection::MIN_GROUND);
        GroundRange { low: 0.5 * high, high }
    }
}

fn write_document(path: &Path, document: &Document) -> Result<()> {
    write_file(path, &document.bytes())
}

fn summary(files: &Files, targets: &Targets, changed: &Changed) -> String {
    format!(
        "{}: {} get reflected light from {}{}; {} lists them\nenergyplus -w WEATHER.epw -d results {}\n",
        files.model.display(),
        counted(targets.own() as u64, "surface"),
        counted(changed.tables as u64, "table"),
        targets.others(),
        files.model.with_file_name(REPORT[0]).display(),
        files.model.display()
    )
}

heliotile_core::parse_by_name!(Physics);

/// Reads a position: `78500,457800` or `78500,457800,1.5`.
fn parse_spot(text: &str) -> std::result::Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse::<f64>().ok()).collect();
    match numbers.as_deref() {
        Some([x, y]) if x.abs() <= MAX_M && y.abs() <= MAX_M => Ok([*x, *y, 0.0]),
        Some([x, y, z]) if [x, y, z].iter().all(|m| m.abs() <= MAX_M) => Ok([*x, *y, *z]),
        _ => Err("give two or three numbers of metres, such as 78500,457800 or 78500,457800,1.5".into()),
    }
}

/// Largest coordinate, metres: no plane system has larger ones.
const MAX_M: f64 = 1e8;

#[cfg(test)]
mod tests {
    use super::*;

    /// Two positions are read, 4 texts are refused.
    #[test]
    fn positions_have_two_or_three_numbers() {
        assert_eq!(parse_spot("78500, -45.5"), Ok([78500.0, -45.5, 0.0]));
        assert_eq!(parse_spot("1,2,3"), Ok([1.0, 2.0, 3.0]));
        for text in ["", "1", "1,nan", "1,2,3,4"] {
            assert!(parse_spot(text).is_err(), "{text}");
        }
    }
}
