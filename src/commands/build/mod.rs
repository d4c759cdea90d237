//! Story one: scene -> plan -> archive (`build`, `plan`).

pub mod tables;

use std::path::Path;
use std::time::Duration;

use super::horizon::nothing_seen;
use super::terminal::Terminal;
use super::{
    Outcome, atlas, guard_archive, guard_site, interrupt, load_scene, read_receivers, read_suns, remark, same_file,
    say, warn, workspace, workspace_beside,
};
use crate::cli::{AccuracyArgs, BuildArgs, ClockArgs, Percent, PlanArgs};
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::build::{Build, Output, Plan, PreparedScene, Start};
use heliotile_builder::planning::{EffectsUnder, ErrorTarget, PlanReport, PlanRequest};
use heliotile_builder::settings::{BuildSettings, EffectChoice, Rungs};
use heliotile_builder::store::{Folder, Store, StoreKey, open_all};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;
use heliotile_scene::Scene;

/// `heliotile build`.
pub fn run(args: &BuildArgs) -> Result<Outcome> {
    match (&args.part, &args.receivers, &args.output) {
        (Some(part), ..) => atlas::part::build(args, part),
        (None, Some(receivers), Some(output)) => build(args, receivers, output),
        _ => Err(unnamed(args)),
    }
}

/// What a build lacks that names no receivers or no archive.
fn unnamed(args: &BuildArgs) -> Error {
    match args.scene.scene.as_slice() {
        [only] if only.join(atlas::plan::FILE).is_file() => {
            let hint = "--part all, or the name or number of one; what they are built from stands in the atlas";
            Error::argument("--part", format!("{} is an atlas: which parts of it?", only.display()), hint)
        }
        _ => Error::argument(
            "build",
            "receivers and the archive to write have to be named",
            "-r RECEIVERS.csv -o SITE.helio",
        ),
    }
}

/// Of a scene and receivers on it.
fn build(args: &BuildArgs, receivers: &Path, output: &Path) -> Result<Outcome> {
    let inputs = [Some(receivers), args.accuracy.error_weather.as_deref(), args.weather.as_deref()];
    guard_site(output, &args.scene.site()?, &inputs)?;
    guard_archive(output)?;
    let scene = load_scene(&args.scene)?;
    let workspace = workspace_beside(output, args.memory);
    let mut receivers = read_receivers(receivers, &scene, &workspace)?;
    let under = weighed_under((args.weather.as_deref(), args.negligible), &args.about_weather, &scene)?;
    let asked = BuildRequest {
        settings: BuildSettings { share: args.share, ..settings_of(&args.accuracy)? },
        accuracy: &args.accuracy,
        about_error_weather: about_error_weather(args.weather.as_deref(), &args.accuracy, &args.about_weather),
        under: under.as_ref(),
        effects: args.effects,
        with_scene: !args.no_scene,
        store: args.store.as_deref().map(Folder::create).transpose()?,
    };
    let output = Output {
        path: output.to_owned(),
        start: if args.fresh { Start::Fresh } else { Start::Resume },
        checkpoint_every: Duration::from_secs(u64::from(args.checkpoint)),
    };
    let (prepared, terminal) = (PreparedScene::new(&scene)?, Terminal::default());
    let build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: &terminal };
    plan_and_write(build, &asked, &output).map_err(|error| error.advise(OTHER_INPUTS))?;
    nothing_seen(&Archive::open_with(&output.path, Access::Read)?)?.iter().for_each(|lost| warn(lost));
    Ok(Outcome::Fine)
}

/// What can be done where a build of other inputs was interrupted.
const OTHER_INPUTS: &str =
    "give the inputs that it was started with to go on with it, --fresh to discard it, or another name with -o";

/// `heliotile plan`.
pub fn plan(args: &PlanArgs) -> Result<Outcome> {
    let scene = load_scene(&args.scene)?;
    let workspace = workspace(std::env::temp_dir(), args.memory);
    let mut receivers = read_receivers(&args.receivers, &scene, &workspace)?;
    let settings = settings_of(&args.accuracy)?;
    let (prepared, terminal) = (PreparedScene::new(&scene)?, Terminal::default());
    let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: &terminal };
    let under = weighed_under((args.weather.as_deref(), args.negligible), &args.about_weather, &scene)?;
    let asked = BuildRequest {
        settings,
        accuracy: &args.accuracy,
        about_error_weather: about_error_weather(args.weather.as_deref(), &args.accuracy, &args.about_weather),
        under: under.as_ref(),
        effects: args.effects,
        with_scene: true,
        store: None,
    };
    let plan = decide(&mut build, &asked)?;
    say(&format!(
        "{}: {} receivers, {} triangles, {}\n{}",
        args.scene.first().display(),
        build.receivers.count(),
        scene.mesh.triangles.len(),
        counted(rayon::current_num_threads() as u64, "thread"),
        tables::forecast(&plan.forecast)
    ))?;
    plan.losses.iter().try_for_each(|losses| say(&tables::losses(losses)))?;
    Ok(Outcome::Fine)
}

/// Weather that effects are weighed under.
pub struct WeighedUnder {
    pub weather: ErrorConditions,
    /// What may be left out, if anything.
    pub negligible: Option<Percent>,
}

fn weighed_under(
    (weather, negligible): (Option<&Path>, Option<Percent>),
    about: &ClockArgs,
    scene: &Scene,
) -> Result<Option<WeighedUnder>> {
    let read = |file| Ok(WeighedUnder { weather: read_suns(Some(file), Some(about), scene)?, negligible });
    weather.map(read).transpose()
}

/// What is said of the clock is said of `--weather`, if there is one, whatever errors are estimated under.
pub fn about_error_weather<'a>(
    weather: Option<&Path>,
    accuracy: &AccuracyArgs,
    about: &'a ClockArgs,
) -> Option<&'a ClockArgs> {
    let of_errors = accuracy.error_weather.as_deref();
    let is_same = |weather: &Path| of_errors.is_some_and(|of_errors| same_file(of_errors, weather));
    weather.is_none_or(is_same).then_some(about)
}

/// What is asked of a build.
pub struct BuildRequest<'a> {
    pub settings: BuildSettings,
    pub accuracy: &'a AccuracyArgs,
    /// How the weather that errors are estimated under reads the clock, if more is known than the file says.
    pub about_error_weather: Option<&'a ClockArgs>,
    pub effects: EffectChoice,
    /// Decides about effects where the scene does.
    pub under: Option<&'a WeighedUnder>,
    /// Whether the archive holds the scene's triangles.
    pub with_scene: bool,
    pub store: Option<Folder>,
}

/// Plans, builds, and says what is done.
pub fn plan_and_write(mut build: Build, asked: &BuildRequest, output: &Output) -> Result<()> {
    let _watch = interrupt::watch();
    let planned = decide(&mut build, asked)?;
    remark(&tables::forecast(&planned.forecast))?;
    planned.losses.iter().try_for_each(|losses| remark(&tables::losses(losses)))?;
    let plan = &Plan { with_scene: asked.with_scene, ..planned.plan.clone() };
    let scene = build.scene.scene;
    let key = StoreKey { scene: scene.content_hash(), settings: plan.settings.hash()? };
    let earlier = asked.store.as_ref().map_or(Ok(Vec::new()), |store| open_all(store, &key, build.observer))?;
    let report = build.write(plan, output, &earlier)?;
    if let Some(store) = &asked.store {
        store.add(&key, &output.path, &report.root)?;
    }
    report.warnings.iter().for_each(|w| warn(w));
    remark(&tables::summary(&report, scene, &output.path))?;
    if let Some(choice) = &planned.choice {
        let taken = report.seconds.iter().map(|stage| stage.1).sum();
        remark(&tables::outcome(choice, planned.forecast.seconds(), taken))?;
    }
    Ok(())
}

/// The plan of a build; says which settings were chosen, if an error is to be kept within.
fn decide(build: &mut Build, asked: &BuildRequest) -> Result<PlanReport> {
    let (scene, accuracy) = (build.scene.scene, asked.accuracy);
    let read = |_| read_suns(accuracy.error_weather.as_deref(), asked.about_error_weather, scene);
    let suns = accuracy.error.map(read).transpose()?;
    let target = |(Percent(percent), suns)| ErrorTarget { percent, suns };
    let target = accuracy.error.zip(suns.as_ref()).map(target);
    let under = asked.under.map(|under| EffectsUnder {
        weather: &under.weather,
        negligible_percent: under.negligible.map(|Percent(percent)| percent),
    });
    let plan = PlanRequest { settings: asked.settings, effects: asked.effects, under, target };
    let plan = build.plan(&plan).map_err(|error| match error {
        // What a trial had written is gone.
        Error::Stopped { .. } => Error::Stopped { what: "while settings were tried".into() },
        error => error,
    })?;
    if let Some(choice) = &plan.choice {
        remark(&tables::choice(choice))?;
    }
    Ok(plan)
}

/// Settings of a quality with some set by name.
pub fn settings_of(accuracy: &AccuracyArgs) -> Result<BuildSettings> {
    let mut settings = Rungs::of(accuracy.quality).settings();
    accuracy.set.iter().try_for_each(|text| settings.set(text))?;
    settings.check()?;
    Ok(settings)
}
