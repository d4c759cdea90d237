//! `heliotile build` and `plan`. In: a scene, receivers. Out: a forecast, or an archive.

use std::path::Path;
use std::time::Duration;

use super::console::terminal::Terminal;
use super::{Outcome, load_scene, say};
use heliotile::atlas::{FILE, PartRequest, build_parts};
use heliotile::cases::{Build, Plan};
use heliotile::text::counted;
use heliotile::tracing::{ErrorConditions, tables};
use heliotile::{
    EffectsUnder, Error, Observer, Output, Provenance, Result, Scene, SiteBuild, Start, WeatherOptions, check_output,
};

/// `heliotile build`.
pub fn run(args: &Build, _: Provenance) -> Result<Outcome> {
    match (&args.part, &args.receivers, &args.output) {
        (Some(part), ..) => parts(args, part),
        (None, Some(receivers), Some(output)) => build(args, receivers, output),
        _ => Err(unnamed(args)),
    }
}

/// Returns the error of a build that names no receivers or no archive.
fn unnamed(args: &Build) -> Error {
    match args.scene.files.as_slice() {
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
fn parts(args: &Build, part: &str) -> Result<Outcome> {
    let [place] = args.scene.files.as_slice() else {
        let what = format!("a part belongs to one atlas, and {} files are given", args.scene.files.len());
        let hint = "give only the folder or the address of the atlas, which lists its scene files";
        return Err(Error::argument("part", what, hint));
    };
    let request = PartRequest { part, fresh: args.fresh, memory: args.memory, from: args.from.as_deref() };
    build_parts(place, &request, &Terminal::watching())?;
    Ok(Outcome::Fine)
}

/// Builds the archive of a scene and its receivers.
fn build(args: &Build, receivers: &Path, output: &Path) -> Result<Outcome> {
    let inputs =
        [Some(receivers), args.accuracy.error_weather.as_deref(), args.weather.as_deref(), args.from.as_deref()];
    // Outputs are checked before minutes of tracing.
    check_output(output, &args.scene.site()?, &inputs)?;
    let (scene, terminal) = (load_scene(&args.scene)?, Terminal::watching());
    let weighed_under = weighed_under(args.weather.as_deref(), &args.about_weather, &scene, &terminal)?;
    let output = Output {
        path: output.to_owned(),
        start: if args.fresh { Start::Fresh } else { Start::Resume },
        checkpoint_every: Duration::from_secs(u64::from(args.checkpoint_s())),
    };
    let accuracy = args.accuracy.beside(args.weather.as_deref(), &args.about_weather);
    let build = SiteBuild {
        share: args.share,
        under: effects_under(weighed_under.as_ref(), args.negligible_percent),
        effects: args.effects,
        with_scene: !args.no_scene,
        store: args.store.as_deref(),
        from: args.from.as_deref(),
        preview_percent: args.preview_percent,
        memory: args.memory,
        ..SiteBuild::new(&scene, receivers, &accuracy)
    };
    build.build(&output, &terminal)?;
    Ok(Outcome::Fine)
}

/// `heliotile plan`.
pub fn plan(args: &Plan, _: Provenance) -> Result<Outcome> {
    let scene = load_scene(&args.scene)?;
    let terminal = Terminal::default();
    let weighed_under = weighed_under(args.weather.as_deref(), &args.about_weather, &scene, &terminal)?;
    let accuracy = args.accuracy.beside(args.weather.as_deref(), &args.about_weather);
    let build = SiteBuild {
        under: effects_under(weighed_under.as_ref(), args.negligible_percent),
        effects: args.effects,
        memory: args.memory,
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
    about: &WeatherOptions,
    scene: &Scene,
    observer: &dyn Observer,
) -> Result<Option<ErrorConditions>> {
    let read = |file| ErrorConditions::read(Some(file), about, scene.place, observer);
    weather.map(read).transpose()
}

fn effects_under(weather: Option<&ErrorConditions>, negligible_percent: Option<f64>) -> Option<EffectsUnder<'_>> {
    weather.map(|weather| EffectsUnder { weather, negligible_percent })
}
