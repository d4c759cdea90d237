//! `heliotile pv`: light on solar modules. In: a scene, weather, places. Out: a folder with sums, hours, shading losses, horizons and, if
//! they are asked for, the best turns. What light does stands in core; what becomes of it in a module is pvlib's.

mod folder;
mod light;
mod open_plain;
mod search;
mod spots;
mod summary;

use std::collections::HashMap;
use std::fs;

use super::build::about_error_weather;
use super::console::voice::note;
use super::horizon::nothing_seen;
use super::traced::{TraceRequest, up_to_date};
use super::{Outcome, interrupt, invocation, load_scene, remark, say, warn};
use crate::cli::PvArgs;
use crate::files::read_weather_as;
use crate::outputs::provenance::Provenance;
use crate::outputs::pv::horizon::{self, PointHorizon};
use crate::outputs::pv::hourly::{HourlyTable, ONE_SIDE, SideHours};
use crate::outputs::pv::sums::{SideSums, write_months, write_points};
use crate::outputs::pv::{polar, search as search_tables};
use crate::outputs::sink::write_texts;
use folder::PvFolder;
use heliotile_builder::build::PreparedScene;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::siting::Siting;
use heliotile_builder::transfer::ArchiveReceivers;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::site::north::North;
use heliotile_core::weather::distance::far_apart;
use heliotile_scene::pv::points::read_points;
use light::Light;
use open_plain::OpenPlain;
use spots::Spots;

/// Heights of a horizon.
const HORIZON_DIRECTIONS: usize = 360;

/// `heliotile pv`.
pub fn run(args: &PvArgs) -> Result<Outcome> {
    let site = args.scene.site()?;
    let files = PvFolder::of(args);
    files.guard(&site, args)?;
    let points = match &args.points {
        Some(path) => {
            let mut warnings = Vec::new();
            let points = read_points(path, !args.search, &mut warnings)?;
            warnings.iter().for_each(|w| warn(w));
            points
        }
        None => Vec::new(),
    };
    let mut loaded = None;
    let mut place = || Ok(loaded.insert(load_scene(&args.scene)?).place);
    let weather = read_weather_as(&args.weather, &args.about_weather.options(false), &mut place)?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    files.check_weather(&weather, args)?;
    let scene = loaded.map_or_else(|| load_scene(&args.scene), Ok)?;
    scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| warn(apart));
    let light = Light::new(args, &weather)?;
    let prepared = PreparedScene::new(&scene)?;
    let siting = Siting::new(&prepared);
    let north = North::of(scene.place.as_ref());
    let mut spots = Spots::of_points(args.points.as_deref(), &points, &siting)?;

    fs::create_dir_all(&files.folder).map_err(Error::io(&files.folder, "create"))?;
    let searched = match args.search {
        true => search::run(args, &light, &prepared, &spots)?,
        false => Vec::new(),
    };
    spots.turn_unturned(&searched);

    let beside = spots.write_receivers(&files.folder, north)?;
    let asked = TraceRequest {
        folder: &files.folder,
        receivers: beside.path(),
        archive: &files.archive,
        accuracy: &args.accuracy,
        effects: EffectChoice::Auto,
        offset_m: 0.0,
        replace: args.replace,
        memory: args.memory,
        under: None,
        with_scene: true,
        about_error_weather: about_error_weather(Some(&args.weather), &args.accuracy, &args.about_weather),
    };
    let archive = up_to_date(&asked, &scene, None)?;
    beside.place(&files.receivers)?;
    nothing_seen(&archive)?.iter().for_each(|lost| warn(lost));
    interrupt::stop_if_requested("after site.helio was complete")?;
    files.claim(&archive, &weather, args)?;

    let steps = light.steps(&archive);
    let about = invocation::provenance()
        .with_archive(&files.archive, &archive)
        .with_weather(&args.weather, &weather)
        .with_option("steps", steps)
        .with_option("patches", archive.manifest().settings.patches());
    let horizons = horizons(&spots, &siting, north);
    let sides = sums(&files, &light, &archive, &prepared, &spots)?;
    fs::create_dir_all(&files.horizons).map_err(Error::io(&files.horizons, "create"))?;
    horizon::write_lists(&files.horizons, &horizons)?;
    horizon::write_table(&files.horizon_table, &horizons, &about)?;
    write_points(&files.points, &sides, &about)?;
    write_months(&files.months, &sides, &light.month_labels(), &about)?;
    if !args.no_hourly {
        write_hours(&files, &light, &archive, &spots, &about)?;
    }
    if args.search {
        search_tables::write_all(&files.search, &searched, &about)?;
        search_tables::write_best(&files.best, &searched, &about)?;
        fs::create_dir_all(&files.turns).map_err(Error::io(&files.turns, "create"))?;
        for search in &searched {
            write_texts(&files.turns, &[(&format!("{}.svg", search.point), polar::svg(search, &about)?)])?;
        }
    }
    say(&summary::table(&sides, &searched, &args.weather))?;
    remark(&files.summary(args))?;
    light.notes().iter().for_each(|text| note(text));
    Ok(Outcome::Fine)
}

/// The horizon of every point, from true north.
fn horizons(spots: &Spots, siting: &Siting, north: North) -> Vec<PointHorizon> {
    let of = |spot: &spots::Spot| PointHorizon {
        point: spot.name.clone(),
        altitudes_deg: siting.horizon(spot.position, HORIZON_DIRECTIONS, -north.y_deg()).altitudes_deg,
    };
    spots.list.iter().map(of).collect()
}

/// Sums of every side, beside those of an open plain.
fn sums(
    files: &PvFolder,
    light: &Light,
    archive: &Archive,
    prepared: &PreparedScene,
    spots: &Spots,
) -> Result<Vec<SideSums>> {
    let mut of_receiver = light.monthly(archive)?;
    let site = OpenSite::of(archive)?;
    let mut sky_views: HashMap<String, f64> = HashMap::new();
    for row in ArchiveReceivers::<()>::new(&site) {
        let row = row?;
        sky_views.insert(row.receiver.id, f64::from(row.views[0]));
    }
    let mut plain = OpenPlain::new(prepared.scene, archive, &files.folder);
    let wanted = spots.list.iter().map(|spot| (spot.ground, spot.turn()));
    plain.learn(wanted, light)?;
    let side = |spot: &spots::Spot| -> Result<SideSums> {
        let id = spot.name.clone();
        let months = of_receiver.remove(&id).unwrap_or_default();
        Ok(SideSums {
            side: "",
            position: spot.position,
            turn: spot.turn(),
            open: plain.months(spot.ground, spot.turn()),
            sky_view: sky_views.get(&id).copied().unwrap_or_default(),
            horizon: format!("horizon/{}", horizon::file_of(&id)),
            bifacial_gain_percent: None,
            months,
            point: id,
        })
    };
    spots.list.iter().map(side).collect()
}

/// Hours of every point.
fn write_hours(files: &PvFolder, light: &Light, archive: &Archive, spots: &Spots, about: &Provenance) -> Result<()> {
    let labels = light.hour_labels();
    let about = about.clone().with("stamp", light.stamp().name()).with("interval_minutes", light.interval_minutes());
    let mut table = HourlyTable::create(&files.hours, &ONE_SIDE, &labels, &about)?;
    light.hourly(archive, |id, hours: SideHours| match spots.get(id) {
        Some(spot) => table.write(&spot.name, &hours.one_side()),
        None => Ok(()),
    })?;
    table.finish()
}
