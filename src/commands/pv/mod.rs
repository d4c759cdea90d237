//! `heliotile pv`: light on solar modules. In: a scene, weather, places. Out: a folder with sums, hours, shading losses, horizons and, if
//! they are asked for, the best turns. What light does stands in core; what becomes of it in a module is pvlib's.

mod folder;
mod light;
mod modules;
mod open_plain;
mod results;
mod search;
mod spots;
mod summary;

use std::fs;

use super::build::about_error_weather;
use super::console::voice::note;
use super::horizon::nothing_seen;
use super::traced::{TraceRequest, WaysOut, up_to_date};
use super::{Outcome, interrupt, remark, say, say_report, warn};
use crate::cli::PvArgs;
use crate::files::read_weather_as;
use crate::outputs::provenance::Provenance;
use folder::PvFolder;
use heliotile_builder::build::PreparedScene;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::north::North;
use heliotile_core::weather::distance::far_apart;
use heliotile_scene::Scene;
use heliotile_scene::covering::surfaces::Surfaces;
use heliotile_scene::load::Soup;
use heliotile_scene::pv::points::{PvPoint, read_points};
use heliotile_scene::pv::rows::{RowsOfModules, read_rows};
use heliotile_scene::site::Site;
use light::Light;
use modules::{GEOMETRY, LaidRows, MATERIALS};
use results::Results;
use spots::Spots;

/// What is to be placed.
enum Wanted {
    Points(Vec<PvPoint>),
    Rows(Vec<RowsOfModules>),
}

/// `heliotile pv`.
pub fn run(args: &PvArgs, about: Provenance) -> Result<Outcome> {
    let mut site = args.scene.site()?;
    let files = PvFolder::of(args);
    files.guard(&site, args)?;
    let wanted = read_wanted(args)?;
    // Before the scene, which takes longer: a wrong weather file is found at once.
    let mut loaded = None;
    let mut place = || Ok(loaded.insert(load(&site, &wanted)?).0.place);
    let weather = read_weather_as(&args.weather, &args.about_weather.options(false), &mut place)?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    files.check_weather(&weather, args)?;
    let (scene, soup) = loaded.map_or_else(|| load(&site, &wanted), Ok)?;
    scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| warn(apart));
    let dated = light::rows_of(args, &weather)?;
    let light = Light::new(args, &weather, &dated);
    let north = North::of(scene.place.as_ref());

    let prepared = PreparedScene::new(&scene)?;
    let siting = Siting::new(&prepared);
    let laid = match &wanted {
        Wanted::Points(_) => None,
        Wanted::Rows(rows) => {
            let surfaces = Surfaces::find(&soup, &scene.materials);
            Some(LaidRows::lay(args.rows_file(), rows.clone(), &surfaces, &siting, north)?)
        }
    };
    let mut spots = match (&wanted, &laid) {
        (Wanted::Points(points), _) => Spots::of_points(args.points_file(), points, &siting)?,
        (_, laid) => Spots::of_modules(laid.iter().flat_map(LaidRows::modules), &siting),
    };
    fs::create_dir_all(&files.folder).map_err(Error::io(&files.folder, "create"))?;
    let beside = tempfile::Builder::new().prefix(".pv").tempdir_in(&files.folder);
    let beside = beside.map_err(Error::io(&files.folder, "make a folder in"))?;
    let searched = match args.search {
        true => search::run(args, &light, &prepared, &spots)?,
        false => Vec::new(),
    };
    spots.turn_unturned(&searched);
    // Modules are a part of what is traced.
    let with_modules = match &laid {
        Some(laid) => {
            laid.add_to(&mut site, beside.path())?;
            Some(Scene::load_site(&site)?)
        }
        None => None,
    };
    let traced = with_modules.as_ref().unwrap_or(&scene);
    let receivers = spots.write_receivers(beside.path(), north)?;
    let asked = TraceRequest {
        folder: &files.folder,
        receivers: &receivers,
        archive: &files.archive,
        accuracy: &args.accuracy,
        effects: EffectChoice::Auto,
        offset_m: 0.0,
        replace: args.replace,
        ways_out: WaysOut::USUAL,
        memory: args.memory,
        under: None,
        with_scene: true,
        about_error_weather: about_error_weather(Some(&args.weather), &args.accuracy, &args.about_weather),
    };
    let archive = up_to_date(&asked, traced, None)?;
    let parts: &[&str] = if laid.is_some() { &["receivers.csv", GEOMETRY, MATERIALS] } else { &["receivers.csv"] };
    for name in parts {
        let to = files.folder.join(name);
        fs::rename(beside.path().join(name), &to).map_err(Error::io(&to, "rename to"))?;
    }
    nothing_seen(&archive)?.iter().for_each(|lost| warn(lost));
    interrupt::stop_if_requested("after site.helio was complete")?;
    files.claim(&archive, &weather, args, &spots)?;

    let about = about
        .with_archive(&files.archive, &archive)
        .with_weather(&args.weather, &weather)
        .with_option("steps", light.steps(&archive))
        .with_option("patches", archive.manifest().settings.patches());
    let results = Results { args, files: &files, light: &light, archive: &archive, spots: &spots, about: &about };
    let sides = results.write(&scene, &siting, north)?;
    if args.search {
        results.write_search(&searched)?;
    }
    say(&summary::table(&sides, &searched, &args.weather))?;
    remark(&files.summary(args))?;
    light.notes(args).iter().for_each(|text| note(text));
    Ok(Outcome::Fine)
}

fn read_wanted(args: &PvArgs) -> Result<Wanted> {
    match (&args.points, &args.rows) {
        (Some(file), _) => {
            let mut warnings = Vec::new();
            let points = read_points(file, !args.search, &mut warnings)?;
            warnings.iter().for_each(|w| warn(w));
            Ok(Wanted::Points(points))
        }
        (None, _) => read_rows(args.rows_file()).map(Wanted::Rows),
    }
}

/// The scene, with what its triangles are parts of where rows ask for surfaces.
fn load(site: &Site, wanted: &Wanted) -> Result<(Scene, Soup)> {
    let loaded = match wanted {
        Wanted::Points(_) => (Scene::load_site(site)?, Soup::default()),
        Wanted::Rows(_) => Scene::load_with_objects(site)?,
    };
    say_report(&loaded.0)?;
    Ok(loaded)
}
