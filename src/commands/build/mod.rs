//! Story one: scene -> plan -> archive (`build`, `plan`).

pub mod tables;

use std::time::Duration;

use super::horizon::nothing_seen;
use super::terminal::Terminal;
use super::{
    Outcome, guard_archive, guard_site, interrupt, load_scene, read_receivers, read_suns, remark, say, warn, workspace,
    workspace_beside,
};
use crate::cli::{AccuracyArgs, BuildArgs, ClockArgs, Percent, PlanArgs};
use heliotile_builder::build::{Build, Output, PreparedScene, Start};
use heliotile_builder::planning::{ErrorTarget, PlanReport, PlanRequest};
use heliotile_builder::settings::{BuildSettings, EffectChoice, Rungs};
use heliotile_builder::store::{Folder, Store, StoreKey, open_all};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;

/// `heliotile build`.
pub fn run(args: &BuildArgs) -> Result<Outcome> {
    let inputs = [Some(args.receivers.as_path()), args.accuracy.error_weather.as_deref()];
    guard_site(&args.output, &args.scene.site()?, &inputs)?;
    guard_archive(&args.output)?;
    let scene = load_scene(&args.scene)?;
    let workspace = workspace_beside(&args.output, args.memory);
    let mut receivers = read_receivers(&args.receivers, &scene, &workspace)?;
    let asked = BuildRequest {
        settings: BuildSettings { share: args.share, ..settings_of(&args.accuracy)? },
        accuracy: &args.accuracy,
        about_error_weather: Some(&args.about_weather),
        effects: args.effects,
        store: args.store.as_deref().map(Folder::create).transpose()?,
    };
    let output = Output {
        path: args.output.clone(),
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
    let plan = decide(&mut build, settings, &args.accuracy, Some(&args.about_weather), args.effects)?;
    say(&format!(
        "{}: {} receivers, {} triangles, {}\n{}",
        args.scene.first().display(),
        build.receivers.count(),
        scene.mesh.triangles.len(),
        counted(rayon::current_num_threads() as u64, "thread"),
        tables::forecast(&plan.forecast)
    ))?;
    Ok(Outcome::Fine)
}

/// What is asked of a build.
pub struct BuildRequest<'a> {
    pub settings: BuildSettings,
    pub accuracy: &'a AccuracyArgs,
    /// How the weather that errors are estimated under reads the clock, if more is known than the file says.
    pub about_error_weather: Option<&'a ClockArgs>,
    pub effects: EffectChoice,
    pub store: Option<Folder>,
}

/// Plans, builds, and says what is done.
pub fn plan_and_write(mut build: Build, asked: &BuildRequest, output: &Output) -> Result<()> {
    let _watch = interrupt::watch();
    let planned = decide(&mut build, asked.settings, asked.accuracy, asked.about_error_weather, asked.effects)?;
    remark(&tables::forecast(&planned.forecast))?;
    let plan = &planned.plan;
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
fn decide(
    build: &mut Build,
    settings: BuildSettings,
    accuracy: &AccuracyArgs,
    about_weather: Option<&ClockArgs>,
    effects: EffectChoice,
) -> Result<PlanReport> {
    let scene = build.scene.scene;
    let suns =
        accuracy.error.map(|_| read_suns(accuracy.error_weather.as_deref(), about_weather, scene)).transpose()?;
    let target = |(Percent(percent), suns)| ErrorTarget { percent, suns };
    let target = accuracy.error.zip(suns.as_ref()).map(target);
    let plan = build.plan(&PlanRequest { settings, effects, target }).map_err(|error| match error {
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
