//! `heliotile run`: from scene files to a year's sun in one go. In: a scene, weather. Out: a folder with receivers, the archive, sums and
//! a map. What is there already and still fits is not traced again.

mod folder;
pub(in crate::commands) mod made_from;
mod maps;
mod periods;

use std::collections::HashMap;
use std::path::Path;

use super::build::{WeighedUnder, about_error_weather};
use super::horizon::nothing_seen;
use super::receivers::cover_site;
use super::terminal::Terminal;
use super::traced::{TraceRequest, WaysOut, up_to_date};
use super::{Outcome, interrupt, invocation, load_scene, remark, say, temporary_files, warn};
use crate::cli::{RunArgs, RunMap};
use crate::covering::Covered;
use crate::files::{hold, read_file, read_weather_as};
use crate::outputs::annual::{AnnualRow, Patch, write_ply, write_table};
use crate::outputs::kinds_and_sides::by_kind_and_side;
use crate::outputs::periods::{ClockReading, Every, Periods};
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::viewer_page::ViewerPage;
use folder::Files;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::observer::Stage;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::transfer::ArchiveReceivers;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::north::North;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::time::years::Years;
use heliotile_scene::covering::cover::Piece;

/// `heliotile run`.
pub fn run(args: &RunArgs) -> Result<Outcome> {
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
    let settings = &archive.manifest().settings;
    let steps = weather.steps_of(settings.steps());
    let rows = annual(&archive, &weather, steps, MemoryBudget::new(args.memory.0))?;
    let about = invocation::provenance()
        .with_archive(&files.archive, &archive)
        .with_weather(&args.weather, &weather)
        .with_option("steps", steps)
        .with_option("patches", settings.patches());
    let north = North::of(archive.manifest().place.as_ref());
    write_table(Sink::file(&files.table)?, &rows, north, &about)?;
    write_map(&files.map, &rows, covered.as_ref(), &about)?;
    maps::write(args, &files, &archive, &rows, &about)?;
    periods::write(args, &files, city_model, &archive, &weather)?;
    write_page(&files, args)?;
    say(&format!(
        "\nIrradiation through {}, kWh/m2 (means by area):\n{}",
        args.weather.display(),
        by_kind_and_side(&rows, north)
    ))?;
    remark(&files.summary(args, covered.is_some()))?;
    Ok(Outcome::Fine)
}

/// Sums over the weather file of all receivers, in the archive's order, with so many positions of the sun in each interval.
fn annual(archive: &Archive, weather: &Weather, steps: usize, memory: MemoryBudget) -> Result<Vec<AnnualRow>> {
    let site = OpenSite::of(archive)?;
    let conditions = weather.conditions(steps);
    let years = Years::of(weather.rows.iter().map(|row| row.interval.date));
    let stamps: Vec<_> = conditions.iter().filter_map(|condition| condition.stamp).collect();
    let bins = Periods::new(Every::Total, years, &stamps, ClockReading::default()).bins();
    let (patches, storage) = (archive.manifest().settings.patches(), temporary_files());
    let settings = ReplaySettings { patches, memory, storage: &storage, ..ReplaySettings::default() };
    let changeable = Changeable::of(&site, archive.manifest());
    // What the model states of its ground, by month; nothing else is asked for.
    let (schedules, _) = Changes::default().over(&changeable, &weather.rows, &read_file)?;
    let replay = Replay::scheduled(&site, &conditions, settings, &bins, &schedules)?;
    let terminal = Terminal::default();
    let progress = Stage::begin(&terminal, "receivers", Some(archive.manifest().receivers.count));
    let mut rows = Vec::new();
    let mut receivers = ArchiveReceivers::<()>::new(&site);
    for result in replay.results(0..replay.tiles()) {
        let values = result?.1;
        for (i, row) in receivers.by_ref().take(values.receivers()).enumerate() {
            let sum = |component: Component| values.row(component, i).first().copied().unwrap_or_default();
            rows.push(AnnualRow { receiver: row?.receiver, kwh_m2: Component::ALL.map(sum) });
        }
        progress.advance(values.receivers() as u64);
    }
    drop(progress);
    Ok(rows)
}

fn write_map(path: &Path, rows: &[AnnualRow], covered: Option<&Covered>, about: &Provenance) -> Result<()> {
    let pieces = pieces_by_name(covered);
    let patches: Vec<Patch> = rows
        .iter()
        .map(|row| Patch {
            triangles: pieces.get(&row.receiver.id).map_or(&[][..], |piece| &piece.triangles),
            middle: row.receiver.position,
            total_kwh_m2: row.total(),
        })
        .collect();
    write_ply(Sink::file(path)?, &patches, about)
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

fn pieces_by_name(covered: Option<&Covered>) -> HashMap<String, &Piece> {
    let rows = covered.into_iter().flat_map(Covered::free);
    rows.map(|(name, piece, ..)| (name, piece)).collect()
}
