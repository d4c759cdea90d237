//! `heliotile energyplus --delete-surroundings`: the model without its surroundings, whose light
//! comes as a series. In: the model, its archive with all surroundings, a weather file. Out: the
//! model, `series.csv`, the report.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;

use super::pages::{left_out, physics_lines};
use super::runs::{self, Engine};
use super::{Files, REPORT, Targets, areas, cover_of, traced, write_document, write_report};
use super::{Physics, Task};
use crate::checks;
use crate::document::{Document, ModelObject};
use crate::erl::Names;
use crate::injection;
use crate::named_files::NamedFiles;
use crate::report::{Block, Report};
use crate::series::deleted::{Deleted, delete};
use crate::series::lights::{DIRECT, REFLECTED, SeriesRequest, SurfaceSeries, surface_series};
use crate::series::objects::{self, Reader, Table};
use crate::series::steps::Steps;
use crate::series::values::StepLight;
use heliotile_builder::settings::{Effect, EffectChoice, Effects};
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::text::{Message, counted, message, with_list};
use heliotile_files::input::weather::read_weather;
use heliotile_results::outputs::sink::Sink;
use heliotile_studies::covering::PlacedReceivers;
use heliotile_studies::covering::cover_site;

/// File name of the series beside the model.
pub const SERIES: &str = "series.csv";

/// Time steps an hour of a model that states none.
const USUAL_STEPS: usize = 6;

/// The model with all its surroundings.
pub struct Full<'a> {
    pub files: &'a Files,
    pub archive: &'a Archive,
    pub covered: &'a PlacedReceivers,
    /// Returns the model with EnergyPlus's own reflections, for comparison.
    pub bare: &'a dyn Fn() -> Result<Document>,
    pub engine: Option<Engine>,
    /// Result of making the model's file names absolute.
    pub named_files: NamedFiles,
}

/// The model without its surroundings.
struct Alone {
    archive: Archive,
    covered: PlacedReceivers,
}

/// Light of a surface with all surroundings, and of the model alone. Direct light is sun and sky.
#[derive(Default)]
struct Lit {
    name: String,
    reflected: SurfaceSeries,
    direct: SurfaceSeries,
    alone: SurfaceSeries,
}

/// Returns the steps of the series, if there is to be one. Refuses a model that cannot get it
/// before anything is traced.
pub fn steps(task: &Task, document: &Document) -> Result<Option<Steps>> {
    if !task.request.delete_surroundings {
        return Ok(None);
    }
    let Some(weather_file) = &task.request.weather else {
        let hint = "give the file that the model is to run with: {weather} x.epw";
        return Err(Error::argument("delete_surroundings", "needs a weather file", hint));
    };
    refuse_taken(document)?;
    let weather = read_weather(weather_file)?;
    weather.report.warnings.iter().for_each(|text| task.warn(text));
    Steps::new(&weather, weather_file, steps_an_hour(document)).map(Some)
}

/// Writes the folder: the model, its series and the report.
pub fn run(task: &Task, mut document: Document, steps: &Steps, full: Full) -> Result<()> {
    let stated = injection::ground_of(&document);
    let deleted = delete(&mut document);
    let alone = alone(task, &document, &full)?;
    let ground: Vec<f64> = steps.grounds.iter().map(|(month, snow_cm)| stated.of(*month, *snow_cm)).collect();
    let lit = lit(task, steps, &ground, &full, &alone)?;
    let surfaces_lit: Vec<&str> = lit.iter().map(|lit| lit.name.as_str()).collect();
    let targets = Targets::new(&document, &surfaces_lit, full.covered, false);
    let windows = windows(&document);
    let shaded: BTreeSet<String> =
        document.of("WindowShadingControl").flat_map(ModelObject::texts).map(str::to_lowercase).collect();
    let (mut readers, mut columns) = (Vec::new(), Vec::new());
    for (name, number) in &targets.list {
        let lit = number.and_then(|number| lit.get(number));
        let lights = lights(lit, steps.lit.len());
        let key = name.to_lowercase();
        // Windows with shading controls cannot be multiplied: their sun is added as light of the
        // ground.
        let multiplies = windows.contains(&key) && !shaded.contains(&key);
        let factors: Vec<f64> = lights.iter().map(|light| if multiplies { light.multiplier() } else { 1.0 }).collect();
        let added = lights.iter().zip(&factors).map(|(light, m)| light.added_before(*m)).collect();
        columns.push((format!("{name} W/m2"), 0.0, added));
        let column = columns.len();
        if multiplies {
            columns.push((format!("{name} multiplier"), 1.0, factors));
        }
        let sky_view = lit.map_or(0.0, |lit| lit.direct.sky_view);
        readers.push(Reader { surface: name.clone(), column, multiplier: multiplies.then_some(column + 1), sky_view });
    }
    let mut notes: Vec<Message> =
        injection::switch_distribution(&mut document)?.into_iter().map(Message::from).collect();
    notes.extend(full.named_files.notes.iter().cloned());
    injection::brighten_ground(&mut document, &mut notes)?;
    let names = Names::free(document.objects.iter().map(ModelObject::name));
    let table = Table { file: SERIES, hours: steps.count / steps.an_hour, steps_an_hour: steps.an_hour };
    objects::write(&mut document, &names, &table, &readers)?;
    let injected: BTreeSet<String> = targets.list.iter().map(|(name, _)| name.to_lowercase()).collect();
    let mut warnings = full.named_files.warnings.clone();
    warnings.extend(checks::warnings(&document, task.request.surfaces.assume_version, &injected));
    warnings.extend(of_this_way(&document, &windows, &shaded));
    task.tell(&targets, &notes, &warnings);
    write_series(task, steps, &columns)?;
    write_document(&full.files.model, &document)?;
    task.report(format!(
        "{}: {} removed from the model, {} get light from {}{}; {} lists them\n",
        full.files.model.display(),
        counted(deleted.shades as u64, "shading surface"),
        counted(targets.own() as u64, "surface"),
        SERIES,
        targets.others(),
        full.files.model.with_file_name(REPORT[0]).display(),
    ));
    let mut done = physics_lines(task.request.physics);
    done.extend(told(task, &deleted, steps, full.archive, &alone.archive));
    done.extend(notes);
    let done = task.worded(&done);
    let mut report = Report {
        title: format!(
            "{} without its surroundings",
            task.request.model.file_name().unwrap_or_default().to_string_lossy()
        ),
        sections: vec![
            ("What was done".into(), vec![Block::List(done)]),
            ("Surfaces".into(), surfaces(&lit)),
            ("Not injected".into(), vec![left_out(&targets)]),
            ("What to know".into(), vec![Block::List(task.worded(&warnings))]),
        ],
    };
    if let (Some(engine), Some(weather_file)) = (&full.engine, &task.request.weather) {
        let folder = task.request.folder.join("energyplus");
        let beside = folder.join("injected");
        fs::create_dir_all(&beside).map_err(Error::io(&beside, "create"))?;
        let copy = beside.join(SERIES);
        fs::copy(task.request.folder.join(SERIES), &copy).map_err(Error::io(&copy, "write"))?;
        report.sections.extend(runs::run_all(
            engine,
            full.bare,
            document,
            weather_file,
            &folder,
            &areas(full.covered),
            task.resources.observer,
        )?);
    }
    write_report(task, &report)
}

/// Refuses objects that a model may have only once and that the series needs for itself.
fn refuse_taken(document: &Document) -> Result<()> {
    for class in ["SurfaceProperty:IncidentSolarMultiplier", "SurfaceProperty:LocalEnvironment"] {
        if let Some(object) = document.of(class).next() {
            let line = (object.line > 0).then_some(object.line);
            let what = format!(
                "{} is in the model already, and heliotile has to add its own object of this class",
                object.title()
            );
            return Err(Error::input(
                &document.file,
                line,
                what,
                "remove it from the model, or leave {delete_surroundings} out",
            ));
        }
    }
    Ok(())
}

/// Returns the time steps in an hour.
fn steps_an_hour(document: &Document) -> usize {
    let stated = document.first_text("Timestep", 1, "number_of_timesteps_per_hour").parse::<f64>();
    stated.ok().filter(|steps| (1.0..=60.0).contains(steps)).map_or(USUAL_STEPS, |steps| steps as usize)
}

/// Traces the model without its surroundings.
fn alone(task: &Task, document: &Document, full: &Full) -> Result<Alone> {
    let model = full.files.model.with_file_name(format!("stripped.{}", document.ending()));
    write_document(&model, document)?;
    let site = task.request.site(std::slice::from_ref(&model))?;
    let (scene, covered) = cover_site(&site, &cover_of(task, Vec::new()), task.resources.observer)?;
    let [receivers, archive] = ["stripped.csv", "stripped.helio"].map(|name| model.with_file_name(name));
    // Only the direct light of this archive is used.
    let direct = EffectChoice::These(Effects::NONE.with(Effect::Canopies));
    let archive = traced(task, &scene, &covered, &receivers, &archive, direct)?;
    Ok(Alone { archive, covered })
}

/// Computes the light of all surfaces, sorted by name.
fn lit(task: &Task, steps: &Steps, ground: &[f64], full: &Full, alone: &Alone) -> Result<Vec<Lit>> {
    let whole_m2 = [full.covered, &alone.covered].map(areas);
    let (paths, reflected_sky) = match task.request.physics {
        Physics::EnergyPlus => (LightPaths::FIRST, SkyModel::Uniform),
        Physics::Full => (LightPaths::ALL, SkyModel::Perez1990),
    };
    // Direct light follows EnergyPlus's sky model, whichever sky is reflected.
    let asked = |number: usize| SeriesRequest {
        steps,
        sky: SkyModel::Perez1990,
        paths,
        sums: DIRECT,
        ground: None,
        whole_m2: &whole_m2[number],
        resources: task.resources,
    };
    let reflected = SeriesRequest { sky: reflected_sky, sums: REFLECTED, ground: Some(ground), ..asked(0) };
    let mut found: BTreeMap<String, Lit> = BTreeMap::new();
    for (name, series) in surface_series(full.archive, &reflected)? {
        found.entry(name).or_default().reflected = series;
    }
    for (name, series) in surface_series(full.archive, &asked(0))? {
        found.entry(name).or_default().direct = series;
    }
    for (name, series) in surface_series(&alone.archive, &asked(1))? {
        found.entry(name).or_default().alone = series;
    }
    let named = |mut lit: Lit| {
        let stated = if lit.alone.name.is_empty() { &lit.direct.name } else { &lit.alone.name };
        lit.name = stated.clone();
        lit
    };
    Ok(found.into_values().map(named).collect())
}

/// Returns the light of a surface in each lit step; a surface without light gets zeros.
fn lights(lit: Option<&Lit>, count: usize) -> Vec<StepLight> {
    let Some(lit) = lit else { return vec![StepLight::default(); count] };
    let at = |series: &SurfaceSeries, sum: usize, step: usize| {
        series.sums.get(sum).and_then(|values| values.get(step)).copied().unwrap_or_default()
    };
    (0..count)
        .map(|step| StepLight {
            reflected: at(&lit.reflected, 0, step),
            sun: at(&lit.direct, 0, step),
            sky: at(&lit.direct, 1, step),
            alone_sun: at(&lit.alone, 0, step),
            alone_sky: at(&lit.alone, 1, step),
        })
        .collect()
}

/// Returns the names of openings with panes, in small letters.
fn windows(document: &Document) -> BTreeSet<String> {
    let is_pane = |object: &&ModelObject| {
        let sort = object.text(2, "surface_type").to_lowercase();
        object.is("Window")
            || object.is("GlazedDoor")
            || object.is("FenestrationSurface:Detailed") && matches!(sort.as_str(), "window" | "glassdoor")
    };
    document.objects.iter().filter(is_pane).map(|object| object.name().to_lowercase()).collect()
}

/// Returns further warnings that hold for a model with a series.
fn of_this_way(document: &Document, windows: &BTreeSet<String>, shaded: &BTreeSet<String>) -> Vec<Message> {
    let mut found = vec![
        "the model is valid for this weather file and time step only: with others it gets the light of the wrong hours"
            .into(),
    ];
    let both: Vec<String> = windows.intersection(shaded).cloned().collect();
    if !both.is_empty() {
        found.push(with_list(
            "windows with shading controls cannot have an incident solar multiplier: EnergyPlus treats their sun as light of the ground, \
             without direction",
            both,
        ));
    }
    if document.objects.iter().any(|object| object.class.to_lowercase().starts_with("sizingperiod:")) {
        found.push(
            "design days use the surroundings' light of the weather file at their date: run the sizing with the original model".into(),
        );
    }
    found
}

/// Writes the series: one line of names, then one line a step.
fn write_series(task: &Task, steps: &Steps, columns: &[(String, f64, Vec<f64>)]) -> Result<()> {
    let path = task.request.folder.join(SERIES);
    let mut sink = Sink::file(&path)?;
    let quoted = |name: &str| format!("\"{}\"", name.replace(['"', ',', '\n'], "_"));
    let names: Vec<String> = columns.iter().map(|(name, ..)| quoted(name)).collect();
    let dark: Vec<String> = columns.iter().map(|(_, dark, _)| dark.to_string()).collect();
    let (names, dark) = (names.join(","), dark.join(","));
    let mut put = |line: &str| sink.write_all(format!("{line}\n").as_bytes()).map_err(Error::io(&path, "write to"));
    put(&names)?;
    let mut lit = steps.lit.iter().enumerate().peekable();
    for step in 0..steps.count {
        match lit.next_if(|(_, number)| **number == step) {
            None => put(&dark)?,
            Some((row, _)) => {
                let cell = |values: &[f64]| format!("{:.4}", values.get(row).copied().unwrap_or_default());
                put(&columns.iter().map(|(.., values)| cell(values)).collect::<Vec<_>>().join(","))?;
            }
        }
    }
    sink.finish().map(|_| ())
}

/// Returns the sentences of the report on what was done.
fn told(task: &Task, deleted: &Deleted, steps: &Steps, archive: &Archive, alone: &Archive) -> Vec<Message> {
    let weather =
        task.request.weather.as_deref().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
    let mut list = vec![
        message!(
            "{} of the surroundings removed from the model; the files of {{scene}} were traced, but not added",
            counted(deleted.shades as u64, "shading surface")
        ),
        format!(
            "{SERIES}: reflected light, and the direct sun and sky that the surroundings block, for {weather}, {} steps an hour: the \
             model is valid for this weather file only",
            steps.an_hour
        ).into(),
        "all light of a window is multiplied by the share of the sun that the surroundings leave; each window has its own schedule"
            .into(),
        "shadows of the model itself are EnergyPlus's own, at each time step".into(),
        "longwave radiation: surfaces see the share of the sky that the surroundings leave; the rest is at air temperature"
            .into(),
        format!("archive root {}, of the model alone {}", format::hex(&archive.root()), format::hex(&alone.root())).into(),
        format!("heliotile {}, for EnergyPlus 25.2", env!("CARGO_PKG_VERSION")).into(),
    ];
    if !deleted.kept.is_empty() {
        list.push(with_list("shades kept because other objects refer to them", deleted.kept.clone()));
    }
    list
}

/// Returns the table of surfaces, one row a surface.
fn surfaces(lit: &[Lit]) -> Vec<Block> {
    let head = ["surface", "area m2", "receivers", "sky view", "reflected", "sun", "sky", "sun, alone", "sky, alone"];
    let row = |lit: &Lit| {
        let mean = |series: &SurfaceSeries, sum: usize| {
            let values = series.sums.get(sum).map_or(&[][..], Vec::as_slice);
            format!("{:.2}", values.iter().sum::<f64>() / values.len().max(1) as f64)
        };
        vec![
            lit.name.clone(),
            format!("{:.2}", lit.direct.area_m2),
            lit.direct.receivers.to_string(),
            format!("{:.3}", lit.direct.sky_view),
            mean(&lit.reflected, 0),
            mean(&lit.direct, 0),
            mean(&lit.direct, 1),
            mean(&lit.alone, 0),
            mean(&lit.alone, 1),
        ]
    };
    let note = "Means over all steps by day, W/m2, with all surroundings. Alone: direct light of the model without its surroundings, \
                which EnergyPlus computes itself.";
    vec![Block::Text(note.into()), Block::Table(head.map(str::to_owned).to_vec(), lit.iter().map(row).collect())]
}
