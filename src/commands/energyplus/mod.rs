//! `heliotile energyplus`: a model of EnergyPlus with the sun that its surroundings reflect. In: a model, what stands around it. Out: a
//! folder with the model that an unmodified EnergyPlus runs, the archive, and a report.

mod around;
mod pages;
mod runs;
mod stripped;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::receivers::cover_site;
use super::traced::{KEEP_OR_REPLACE, TraceRequest, WaysOut, up_to_date};
use super::{Outcome, guard_archive, guard_output, interrupt, remark, temporary_files, warn};
use crate::cli::{CoverArgs, EnergyplusArgs, Metres, Physics, name_of};
use crate::commands::terminal::Terminal;
use crate::covering::Covered;
use crate::energyplus::checks;
use crate::energyplus::document::Document;
use crate::energyplus::injection::{self, Changed, Injection};
use crate::energyplus::named_files::{NamedFiles, make_absolute};
use crate::energyplus::report::Report;
use crate::energyplus::sun_tables::{GroundRange, ReflectedSky, SurfaceLight, TableRequest, surface_lights};
use crate::files::read_file;
use crate::outputs::sink::write_texts;
use crate::results::Resources;
use around::Around;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::trace::placement::Lying;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::replay::factors::SunGrid;
use heliotile_core::text::counted;
use heliotile_scene::Scene;
use heliotile_scene::input;
use heliotile_scene::site::Site;
use runs::Engine;
use stripped::Full;

/// Receivers lie off their surfaces by this, metres.
const OFFSET_M: f64 = 0.02;

/// Names of the report.
const REPORT: [&str; 2] = ["report.md", "report.html"];

/// What a surface is called in the model, and whose light it gets.
pub(super) struct Targets {
    /// Names of EnergyPlus's surfaces, each with the number of its light; hidden ones get none.
    pub list: Vec<(String, Option<usize>)>,
    /// Openings that get what their wall gets.
    pub by_wall: Vec<(String, String)>,
    /// Surfaces all of whose area is hidden.
    pub hidden: Vec<String>,
    /// Surfaces a part of whose area is hidden.
    pub partly: Vec<PartlyHidden>,
}

/// A surface of which some is hidden.
pub(super) struct PartlyHidden {
    pub name: String,
    /// What gets light, m2.
    pub free_m2: f64,
    /// All of it, m2.
    pub whole_m2: f64,
}

/// Hidden parts below this share of a surface are edges.
const HARDLY_HIDDEN: f64 = 0.01;

/// Surfaces that are hidden in part, by name.
pub(super) fn partly_hidden(covered: &Covered) -> Vec<PartlyHidden> {
    let mut areas: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (_, piece, surface, lying) in covered.all() {
        let [free_m2, whole_m2] = areas.entry(covered.part(piece, surface).face).or_default();
        *whole_m2 += piece.area_m2;
        if lying == Lying::Free {
            *free_m2 += piece.area_m2;
        }
    }
    let partly = areas.into_iter().map(|(name, [free_m2, whole_m2])| PartlyHidden { name, free_m2, whole_m2 });
    partly.filter(|p| p.free_m2 > 0.0 && p.free_m2 < (1.0 - HARDLY_HIDDEN) * p.whole_m2).collect()
}

/// Says how many surfaces are hidden in part.
pub(super) fn warn_of_partly_hidden(partly: &[PartlyHidden]) {
    if let Some(first) = partly.first() {
        warn(&format!(
            "{} partly hidden by a neighbour or the ground, where they get no light (first: `{}`, {:.2} of {:.2} m2 get light); the report \
             lists all",
            counted_are(partly.len(), "surface"),
            first.name,
            first.free_m2,
            first.whole_m2
        ));
    }
}

/// "1 surface is", "2 surfaces are".
fn counted_are(count: usize, what: &str) -> String {
    format!("{} {}", counted(count as u64, what), if count == 1 { "is" } else { "are" })
}

/// The model as it is to be written into another folder.
fn read_model(args: &EnergyplusArgs) -> Result<(Document, NamedFiles)> {
    let mut document = Document::read(&args.model, input::read(&args.model)?)?;
    let files = make_absolute(&mut document)?;
    Ok((document, files))
}

/// `heliotile energyplus`.
pub fn run(args: &EnergyplusArgs) -> Result<Outcome> {
    let (mut document, named_files) = read_model(args)?;
    checks::check(&document, args.surfaces.assume_version)?;
    // Before minutes of work.
    let engine = args.run.then(|| Engine::find(args.energyplus.as_deref())).transpose()?;
    let steps = stripped::steps(args, &document)?;
    let Around { site, neighbours, materials, types } = Around::read(args)?;
    let files = Files::of(args, &document);
    files.guard(args, &site)?;
    let (scene, covered) = cover_site(&site, &cover_of(args, types)).map_err(|error| no_surface(args, error))?;
    let archive = traced(args, (&scene, &covered), [&files.receivers, &files.archive], EffectChoice::Auto)?;
    let bare = || {
        let (mut model, _) = read_model(args)?;
        neighbours.add(&mut model, &materials, true);
        Ok(model)
    };
    if let Some(steps) = steps {
        let full = Full { files: &files, archive: &archive, covered: &covered, bare: &bare, engine, named_files };
        return stripped::run(args, document, &steps, full);
    }
    let ground = match args.physics {
        Physics::EnergyPlus => GroundRange::UNIT,
        Physics::Full => ground_range(&document),
    };
    let lights = lights(args, ground, &archive, &covered)?;
    let targets = targets(&document, &lights, &covered);
    let injection =
        Injection { grid: SunGrid::USUAL, sky: sky_of(args.physics), lights: &lights, targets: &targets.list };
    let mut changed = injection::write(&mut document, &injection)?;
    changed.notes.extend(named_files.notes);
    neighbours.add(&mut document, &materials, false);
    let injected: BTreeSet<String> = targets.list.iter().map(|(name, _)| name.to_lowercase()).collect();
    let mut warnings = named_files.warnings;
    warnings.extend(checks::warnings(&document, args.surfaces.assume_version, &injected));
    warn_of_partly_hidden(&targets.partly);
    changed.notes.iter().try_for_each(|note| remark(&format!("{note}\n")))?;
    warnings.iter().for_each(|text| warn(text));
    let told = pages::Told {
        args,
        archive: &archive,
        lights: &lights,
        ground,
        targets: &targets,
        changed: &changed,
        warnings: &warnings,
    };
    let mut report = pages::report(&told);
    write_document(&files.model, &document)?;
    remark(&summary(&files, &targets, &changed))?;
    if let (Some(engine), Some(weather)) = (engine, &args.weather) {
        report.sections.extend(runs::run_all(&engine, &bare, document, weather, &args.output.join("energyplus"))?);
    }
    write_report(args, &report)?;
    Ok(Outcome::Fine)
}

/// The archive of receivers on a scene: table and archive to write.
fn traced(
    args: &EnergyplusArgs,
    (scene, covered): (&Scene, &Covered),
    [receivers, archive]: [&Path; 2],
    effects: EffectChoice,
) -> Result<Archive> {
    let asked = TraceRequest {
        folder: &args.output,
        receivers,
        archive,
        accuracy: &args.accuracy,
        effects,
        offset_m: OFFSET_M,
        replace: args.replace,
        ways_out: WaysOut::USUAL,
        memory: args.memory,
        under: None,
        with_scene: true,
        about_error_weather: None,
    };
    let found = up_to_date(&asked, scene, Some(covered))?;
    let name = archive.file_name().unwrap_or_default().to_string_lossy();
    interrupt::stop_if_requested(&format!("after {name} was complete"))?;
    Ok(found)
}

fn write_report(args: &EnergyplusArgs, report: &Report) -> Result<()> {
    let mut texts = vec![(REPORT[0], report.markdown()), (REPORT[1], report.html())];
    texts.extend(report.pictures().map(|(name, svg)| (name, svg.to_owned())));
    write_texts(&args.output, &texts)
}

/// Areas of surfaces with their hidden parts, by name in small letters, m2.
fn areas(covered: &Covered) -> BTreeMap<String, f64> {
    let mut whole_m2: BTreeMap<String, f64> = BTreeMap::new();
    for (_, piece, surface, _) in covered.all() {
        *whole_m2.entry(covered.part(piece, surface).face.to_lowercase()).or_default() += piece.area_m2;
    }
    whole_m2
}

/// Files of the folder.
struct Files {
    receivers: PathBuf,
    archive: PathBuf,
    model: PathBuf,
}

impl Files {
    fn of(args: &EnergyplusArgs, document: &Document) -> Files {
        let name = |name: &str| args.output.join(name);
        Files {
            receivers: name("receivers.csv"),
            archive: name("site.helio"),
            model: name(&format!("model.{}", document.ending())),
        }
    }

    /// What a model without its surroundings has besides: itself, its receivers, its archive, the series.
    fn of_stripped(&self) -> Vec<PathBuf> {
        let ending = self.model.extension().unwrap_or_default().to_string_lossy();
        let names = [&format!("stripped.{ending}"), "stripped.csv", "stripped.helio", stripped::SERIES];
        names.map(|name| self.model.with_file_name(name)).to_vec()
    }

    /// Refuses to replace an input, or results of something else.
    fn guard(&self, args: &EnergyplusArgs, site: &Site) -> Result<()> {
        let inputs: Vec<&Path> = site.files().chain(args.weather.as_deref()).collect();
        let more = if args.delete_surroundings { self.of_stripped() } else { Vec::new() };
        for output in [&self.receivers, &self.archive, &self.model].into_iter().chain(&more) {
            guard_output(output, &inputs)?;
        }
        guard_archive(&self.archive)?;
        // A model without the archive that it was made with is none of ours.
        let there = std::iter::once(&self.model).chain(&more).find(|path| path.exists());
        if let Some(path) = there.filter(|_| !self.archive.exists() && !args.replace) {
            let what = "is there, and no site.helio that it was made from";
            return Err(Error::input(path, None, what, KEEP_OR_REPLACE));
        }
        Ok(())
    }
}

/// All that the sun may reach of the model.
fn cover_of(args: &EnergyplusArgs, types: Vec<String>) -> CoverArgs {
    CoverArgs {
        on: Vec::new(),
        types,
        spacing: args.spacing,
        per_surface: None,
        offset: Metres(OFFSET_M),
        min_area: 0.0,
    }
}

/// A model without surfaces outdoors is said to be one.
fn no_surface(args: &EnergyplusArgs, error: Error) -> Error {
    match error {
        Error::Argument { argument, .. } if argument == "--on" => {
            let what = "has no wall, roof or window that the sun may reach";
            let hint = "give a model with surfaces that are `Outdoors` and `SunExposed`";
            Error::input(&args.model, None, what, hint)
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

/// What surfaces get, hidden parts of them nothing.
fn lights(
    args: &EnergyplusArgs,
    ground: GroundRange,
    archive: &Archive,
    covered: &Covered,
) -> Result<Vec<SurfaceLight>> {
    let (storage, terminal) = (temporary_files(), Terminal::default());
    let paths = match args.physics {
        Physics::EnergyPlus => LightPaths::FIRST,
        Physics::Full => LightPaths::ALL,
    };
    let sky = sky_of(args.physics);
    let asked = TableRequest {
        grid: SunGrid::USUAL,
        paths,
        sky,
        ground,
        resources: Resources {
            memory: MemoryBudget::new(args.memory.0),
            storage: &storage,
            files: &read_file,
            observer: &terminal,
        },
    };
    let whole_m2 = areas(covered);
    let mut lights = surface_lights(archive, &asked)?;
    for light in &mut lights {
        light.spread_over(whole_m2.get(&light.name.to_lowercase()).copied().unwrap_or_default());
    }
    Ok(lights)
}

/// Between what reflectances the ground of a model goes, with snow.
fn ground_range(document: &Document) -> GroundRange {
    let ground = injection::ground_of(document);
    let all = || (1..=12).flat_map(|month| [None, Some(1.0)].map(|snow_cm| ground.of(month, snow_cm)));
    let (low, high) = (all().fold(1.0, f64::min), all().fold(0.0, f64::max));
    if low < high {
        GroundRange { low, high }
    } else {
        let high = high.max(injection::LEAST_GROUND);
        GroundRange { low: 0.5 * high, high }
    }
}

/// Which surface gets what.
fn targets(document: &Document, lights: &[SurfaceLight], covered: &Covered) -> Targets {
    let number: BTreeMap<String, usize> = lights.iter().enumerate().map(|(i, l)| (l.name.to_lowercase(), i)).collect();
    let mut list: Vec<(String, Option<usize>)> =
        lights.iter().enumerate().map(|(i, light)| (light.name.clone(), Some(i))).collect();
    let all = covered.all().map(|(_, piece, surface, _)| covered.part(piece, surface).face);
    let hidden: BTreeSet<String> = all.filter(|name| !number.contains_key(&name.to_lowercase())).collect();
    let known = number.keys().cloned().chain(hidden.iter().map(|name| name.to_lowercase()));
    let by_wall = checks::openings_left_out(document, &known.collect());
    list.extend(by_wall.iter().map(|(name, wall)| (name.clone(), number.get(wall).copied())));
    list.extend(hidden.iter().map(|name| (name.clone(), None)));
    Targets { list, by_wall, hidden: hidden.into_iter().collect(), partly: partly_hidden(covered) }
}

fn write_document(path: &Path, document: &Document) -> Result<()> {
    let mut name = path.as_os_str().to_os_string();
    name.push(".partial");
    let partial = PathBuf::from(name);
    fs::write(&partial, document.bytes()).map_err(Error::io(&partial, "write"))?;
    fs::rename(&partial, path).map_err(Error::io(path, "rename to"))
}

fn summary(files: &Files, targets: &Targets, changed: &Changed) -> String {
    format!(
        "{}: {} get reflected light by {}; {} says which and how\nenergyplus -w WEATHER.epw -d results {}\n",
        files.model.display(),
        counted(targets.list.len() as u64, "surface"),
        counted(changed.tables as u64, "table"),
        files.model.with_file_name(REPORT[0]).display(),
        files.model.display()
    )
}

/// As the report calls it.
pub(super) fn physics_name(physics: Physics) -> &'static str {
    name_of(&physics)
}
