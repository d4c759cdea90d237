//! `heliotile build` and `plan`. In: a scene, receivers. Out: a forecast, or an archive.

use std::path::Path;
use std::time::Duration;

use super::console::terminal::Terminal;
use super::{Outcome, load_scene, say};
use crate::cli::{BuildArgs, ClockArgs, Percent, PlanArgs};
use heliotile::atlas::{FILE, PartRequest, build_parts};
use heliotile::text::counted;
use heliotile::tracing::{ErrorConditions, tables};
use heliotile::{EffectsUnder, Error, Observer, Output, Result, Scene, SiteBuild, Start, check_output};

/// `heliotile build`.
pub fn run(args: &BuildArgs) -> Result<Outcome> {
    match (&args.part, &args.receivers, &args.output) {
        (Some(part), ..) => parts(args, part),
        (None, Some(receivers), Some(output)) => build(args, receivers, output),
        _ => Err(unnamed(args)),
    }
}

/// Returns the error of a build that names no receivers or no archive.
fn unnamed(args: &BuildArgs) -> Error {
    match args.scene.scene.as_slice() {
        [only] if only.join(FILE).is_file() => {
            let hint = "give --part all, or the name or number of a part; the atlas states its inputs";
            Error::argument(
                "--part",
                format!("{} is an atlas, and the part to build is not given", only.display()),
                hint,
            )
        }
        _ => Error::argument(
            "build",
            "the receivers and the archive to write are not given",
            "give -r RECEIVERS.csv -o SITE.helio",
        ),
    }
}

/// Builds parts of an atlas.
fn parts(args: &BuildArgs, part: &str) -> Result<Outcome> {
    let [place] = args.scene.scene.as_slice() else {
        let what = format!("a part belongs to one atlas, and {} files are given", args.scene.scene.len());
        let hint = "give only the folder or the address of the atlas, which lists its scene files";
        return Err(Error::argument("part", what, hint));
    };
    let request = PartRequest { part, fresh: args.fresh, memory: args.memory.into(), from: args.from.as_deref() };
    build_parts(place, &request, &Terminal::watching())?;
    Ok(Outcome::Fine)
}

/// Builds the archive of a scene and its receivers.
fn build(args: &BuildArgs, receivers: &Path, output: &Path) -> Result<Outcome> {
    let inputs =
        [Some(receivers), args.accuracy.error_weather.as_deref(), args.weather.as_deref(), args.from.as_deref()];
    // Outputs are checked before minutes of tracing.
    let scene = args.scene.request_by(&args.table_north);
    check_output(output, &scene.site()?, &inputs)?;
    let (scene, terminal) = (load_scene(&scene)?, Terminal::watching());
    let weighed_under = weighed_under(args.weather.as_deref(), &args.about_weather, &scene, &terminal)?;
    let output = Output {
        path: output.to_owned(),
        start: if args.fresh { Start::Fresh } else { Start::Resume },
        checkpoint_every: Duration::from_secs(u64::from(args.checkpoint)),
    };
    let accuracy = args.accuracy.request_beside(args.weather.as_deref(), &args.about_weather);
    let build = SiteBuild {
        share: args.share,
        under: effects_under(weighed_under.as_ref(), args.negligible),
        effects: args.effects,
        with_scene: !args.no_scene,
        store: args.store.as_deref(),
        from: args.from.as_deref(),
        preview_percent: args.preview.map(|Percent(percent)| percent),
        memory: args.memory.into(),
        ..SiteBuild::new(&scene, receivers, &accuracy)
    };
    build.build(&output, &terminal)?;
    Ok(Outcome::Fine)
}

/// `heliotile plan`.
pub fn plan(args: &PlanArgs) -> Result<Outcome> {
    let scene = load_scene(&args.scene.request_by(&args.table_north))?;
    let terminal = Terminal::default();
    let weighed_under = weighed_under(args.weather.as_deref(), &args.about_weather, &scene, &terminal)?;
    let accuracy = args.accuracy.request_beside(args.weather.as_deref(), &args.about_weather);
    let build = SiteBuild {
        under: effects_under(weighed_under.as_ref(), args.negligible),
        effects: args.effects,
        memory: args.memory.into(),
        ..SiteBuild::new(&scene, &args.receivers, &accuracy)
    };
    let (plan, receivers) = build.plan(&terminal)?;
    say(&format!(
        "{}: {} receivers, {} triangles, {}\n{}",
        args.scene.first().display(),
        receivers,
        scene.mesh.triangles.len(),
        counted(rayon::current_num_threads() as u64, "thread"),
        tables::forecast(&plan.forecast)
    ))?;
    plan.losses.iter().try_for_each(|losses| say(&tables::losses(losses)))?;
    Ok(Outcome::Fine)
}

/// Returns the weather under which effects are weighed, if a file is given.
fn weighed_under(
    weather: Option<&Path>,
    clock: &ClockArgs,
    scene: &Scene,
    observer: &dyn Observer,
) -> Result<Option<ErrorConditions>> {
    let read = |file| ErrorConditions::read(Some(file), &clock.options(false), scene.place, observer);
    weather.map(read).transpose()
}

fn effects_under(weather: Option<&ErrorConditions>, negligible: Option<Percent>) -> Option<EffectsUnder<'_>> {
    let negligible_percent = negligible.map(|Percent(percent)| percent);
    weather.map(|weather| EffectsUnder { weather, negligible_percent })
}
