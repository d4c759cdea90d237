//! `heliotile run`: from scene files to a year's sun in one go. In: a scene, weather. Out: a folder with receivers, the archive, sums and
//! a map. What is there already and still fits is not traced again.

mod folder;
pub(in crate::commands) mod made_from;
mod maps;
mod results;

use super::build::{WeighedUnder, about_error_weather};
use super::horizon::nothing_seen;
use super::receivers::cover_site;
use super::traced::{TraceRequest, WaysOut, up_to_date};
use super::{Outcome, interrupt, load_scene, remark, say, warn};
use crate::cli::{RunArgs, RunMap};
use crate::files::{hold, read_file, read_weather_as};
use crate::outputs::provenance::Provenance;
use crate::outputs::viewer_page::ViewerPage;
use folder::Files;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::settings::EffectChoice;
use heliotile_core::error::Result;
use heliotile_core::weather::distance::far_apart;
use results::RunResults;

/// `heliotile run`.
pub fn run(args: &RunArgs, about: Provenance) -> Result<Outcome> {
    let site = args.scene.site()?;
    let files = Files::of(args, &site);
    files.guard(&site, args)?;
    let city_model = args.map.contains(&RunMap::CityModel).then(|| maps::city_model_of(&site)).transpose()?;
    let load = || match args.receivers {
        Some(_) => load_scene(&args.scene).map(|scene| (scene, None)),
        None => cover_site(&site, &args.cover).map(|(scene, covered)| (scene, Some(covered))),
    };
    // Before the scene, which takes longer: a wrong weather file is found at once.
    let mut loaded = None;
    let mut place = || Ok(loaded.insert(load()?).0.place);
    let weather = read_weather_as(&args.weather, &args.about_weather.options(false), &mut place)?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    files.check_weather(&weather, args)?;
    let (scene, covered) = loaded.map_or_else(load, Ok)?;
    scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| warn(apart));
    maps::check(args, scene.place.as_ref())?;
    let under = match args.negligible {
        Some(percent) => Some(WeighedUnder {
            weather: ErrorConditions::of_weather(&args.weather, weather.clone())?,
            negligible: Some(percent),
        }),
        None => None,
    };
    let asked = TraceRequest {
        folder: &files.folder,
        receivers: &files.receivers,
        archive: &files.archive,
        accuracy: &args.accuracy,
        effects: EffectChoice::Auto,
        offset_m: args.cover.offset.0,
        replace: args.replace,
        ways_out: WaysOut::USUAL,
        memory: args.memory,
        under: under.as_ref(),
        with_scene: !args.no_scene,
        about_error_weather: about_error_weather(Some(&args.weather), &args.accuracy, &args.about_weather),
    };
    let archive = up_to_date(&asked, &scene, covered.as_ref())?;
    nothing_seen(&archive)?.iter().for_each(|lost| warn(lost));
    interrupt::stop_if_requested("after site.helio was complete")?;
    files.claim(&archive, &weather, args)?;
    let results = RunResults {
        args,
        files: &files,
        city_model,
        covered: covered.as_ref(),
        archive: &archive,
        weather: &weather,
        about,
    };
    let table = results.write()?;
    write_page(&files, args)?;
    say(&format!("\nIrradiation through {}, kWh/m2 (means by area):\n{}", args.weather.display(), table))?;
    remark(&files.summary(args, covered.is_some()))?;
    Ok(Outcome::Fine)
}

/// The page that shows the archive under this weather; a large one it reads from beside it.
fn write_page(files: &Files, args: &RunArgs) -> Result<()> {
    let page = ViewerPage::default()
        .with_archive(&files.archive, hold(&files.archive)?.as_ref())?
        .with_weather(&args.weather, &read_file(&args.weather)?)?;
    let page = page.with_option("clock", args.about_weather.json());
    let page = if page.holds_archive() { page } else { page.with_option("archive", "../site.helio") };
    page.write(&files.page)
}
