//! `heliotile run`: from scene files to a year's sun in one go. In: a scene, weather. Out: a folder with receivers, the archive, sums and
//! a map. What is there already and still fits is not traced again.

mod folder;
mod made_from;
mod periods;

use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::build::{BuildRequest, plan_and_write, settings_of};
use super::receivers::{self, Covered, cover_site};
use super::terminal::Terminal;
use super::{Outcome, interrupt, load_scene, read_receivers, remark, say, temporary_files, warn, workspace_beside};
use crate::cli::RunArgs;
use crate::files::read_weather;
use crate::outputs::annual::{AnnualRow, Patch, write_ply, write_table};
use crate::outputs::periods::{Every, Periods};
use crate::outputs::sink::Sink;
use folder::{Files, Found, PlannedReceivers};
use heliotile_builder::build::{Build, Output, PreparedScene, Start};
use heliotile_builder::observer::Stage;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::transfer::ArchiveReceivers;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::time::years::Years;
use heliotile_scene::Scene;
use heliotile_scene::covering::cover::Piece;
use heliotile_scene::covering::surfaces::SurfaceKind;

/// `heliotile run`.
pub fn run(args: &RunArgs) -> Result<Outcome> {
    let site = args.scene.site()?;
    let files = Files::of(args);
    files.guard(&site, args)?;
    let weather = read_weather(&args.weather)?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    files.check_weather(&weather, args)?;
    let (scene, covered) = match args.receivers {
        Some(_) => (load_scene(&args.scene)?, None),
        None => cover_site(&site, &args.cover).map(|(scene, covered)| (scene, Some(covered)))?,
    };
    scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| warn(apart));
    let archive = up_to_date(args, &files, &scene, covered.as_ref())?;
    interrupt::stop_if_requested("after site.helio was complete")?;
    files.claim(&archive, &weather, args)?;
    let rows = annual(&archive, &weather, MemoryBudget::new(args.memory.0))?;
    write_table(Sink::file(&files.table)?, &rows)?;
    write_map(&files.map, &rows, covered.as_ref())?;
    periods::write(args, &files, &archive, &weather)?;
    say(&table(&rows, covered.as_ref(), &args.weather))?;
    remark(&files.summary(args, covered.is_some()))?;
    Ok(Outcome::Fine)
}

/// The archive of these inputs: the one that is there, or a new one. What is there of other inputs is kept, unless it is to be replaced.
fn up_to_date(args: &RunArgs, files: &Files, scene: &Scene, covered: Option<&Covered>) -> Result<Archive> {
    fs::create_dir_all(&files.folder).map_err(Error::io(&files.folder, "create"))?;
    let planned = match covered {
        Some(covered) => Some(PlannedReceivers::write(covered, args, files)?),
        None => None,
    };
    let workspace = workspace_beside(&files.archive, args.memory);
    let path = planned.as_ref().map_or(files.receivers.as_path(), PlannedReceivers::path);
    let mut receivers = read_receivers(path, scene, &workspace)?;
    let settings = settings_of(&args.accuracy)?;
    let mut differences = planned.as_ref().map_or(Ok(Vec::new()), |planned| planned.differences(files))?;
    let found = files.archive_of(scene, &mut receivers, &settings, args)?;
    if let Found::Other(others) = &found {
        differences.extend_from_slice(others);
    }
    if !args.replace && !differences.is_empty() {
        return Err(files.refuse(&differences));
    }
    if let (Some(planned), Some(covered)) = (planned, covered) {
        planned.place(files)?;
        remark(&format!("{}: {}", files.receivers.display(), receivers::summary(covered, scene)))?;
    }
    if let Found::Same(archive) = found {
        remark(&format!("{}: up to date, nothing is traced again\n", files.archive.display()))?;
        return Ok(*archive);
    }
    let (prepared, terminal) = (PreparedScene::new(scene)?, Terminal::default());
    let asked = BuildRequest { settings, accuracy: &args.accuracy, effects: EffectChoice::Auto, store: None };
    let mut write = |start: Start| {
        let build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: &terminal };
        plan_and_write(build, &asked, &Output { start, ..Output::new(files.archive.clone()) })
    };
    match write(Start::Resume) {
        Err(Error::Incomplete { .. }) if args.replace => write(Start::Fresh)?,
        done => done.map_err(|error| error.advise(folder::OTHER_INPUTS))?,
    }
    Archive::open_with(&files.archive, Access::Read)
}

/// Sums over the weather file of all receivers, in the archive's order.
fn annual(archive: &Archive, weather: &Weather, memory: MemoryBudget) -> Result<Vec<AnnualRow>> {
    let site = OpenSite::of(archive)?;
    let conditions = weather.conditions(usize::from(archive.manifest().settings.steps()));
    let years = Years::of(weather.rows.iter().map(|row| row.interval.date));
    let stamped: Vec<_> = conditions.iter().filter_map(|c| Some((c.label.clone(), c.stamp?))).collect();
    let bins = Periods::new(Every::Total, years, &stamped).bins();
    let (patches, storage) = (archive.manifest().settings.patches(), temporary_files());
    let settings = ReplaySettings { patches, memory, storage: &storage, ..ReplaySettings::default() };
    let replay = Replay::summed(&site, &conditions, settings, &bins)?;
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

fn write_map(path: &Path, rows: &[AnnualRow], covered: Option<&Covered>) -> Result<()> {
    let pieces = pieces_by_name(covered);
    let patches: Vec<Patch> = rows
        .iter()
        .map(|row| Patch {
            triangles: pieces.get(&row.receiver.id).map_or(&[][..], |(piece, _)| &piece.triangles),
            middle: row.receiver.position,
            total_kwh_m2: row.total(),
        })
        .collect();
    write_ply(Sink::file(path)?, &patches)
}

fn pieces_by_name(covered: Option<&Covered>) -> HashMap<String, (&Piece, SurfaceKind)> {
    let rows = covered.into_iter().flat_map(Covered::free);
    rows.map(|(name, piece, surface, _)| (name, (piece, surface.kind))).collect()
}

/// Sums by kind of surface and side.
fn table(rows: &[AnnualRow], covered: Option<&Covered>, weather: &Path) -> String {
    let pieces = pieces_by_name(covered);
    // Receivers, area, sums by area of the components.
    let mut groups: Vec<(String, usize, f64, [f64; 7])> = Vec::new();
    for row in rows {
        let kind = pieces.get(&row.receiver.id).map(|found| found.1);
        let area = row.receiver.area.unwrap_or(1.0);
        for name in group_of(kind, row.receiver.normal) {
            let at = groups.iter().position(|group| group.0 == name).unwrap_or_else(|| {
                groups.push((name, 0, 0.0, [0.0; 7]));
                groups.len() - 1
            });
            let group = &mut groups[at];
            group.1 += 1;
            group.2 += area;
            group.3.iter_mut().zip(row.kwh_m2).for_each(|(sum, value)| *sum += area * f64::from(value));
        }
    }
    groups.sort_by(|a, b| a.0.cmp(&b.0));
    let mut out = format!("\nIrradiation through {}, kWh/m2 (means by area):\n", weather.display());
    let _ = writeln!(
        out,
        "{:14} {:>9} {:>11} {:>10} {:>9} {:>9} {:>9} {:>9} {:>11}",
        "surfaces", "receivers", "area m2", "sun_direct", "sky_direct", "reflected", "mirrored", "total", "sum, MWh"
    );
    for (name, count, area, sums) in groups {
        let mean = |components: &[Component]| -> f64 {
            components.iter().map(|component| sums[*component as usize]).sum::<f64>() / area
        };
        let total = mean(&[Component::Total]);
        let _ = writeln!(
            out,
            "{name:14} {count:>9} {area:>11.1} {:>10.1} {:>10.1} {:>9.1} {:>9.1} {total:>9.1} {:>11.1}",
            mean(&[Component::SunDirect]),
            mean(&[Component::SkyDirect]),
            mean(&[Component::SunDiffuse, Component::SkyDiffuse]),
            mean(&[Component::SunSpecular, Component::SkySpecular]),
            total * area / 1e3
        );
    }
    out
}

/// Groups of the table that a receiver counts in: its kind, and for what stands upright the side that it looks to.
fn group_of(kind: Option<SurfaceKind>, normal: glam::DVec3) -> Vec<String> {
    let kind = match kind {
        Some(kind) => kind.name(),
        None if normal.z > 0.5 => "looking up",
        None if normal.z < -0.5 => "looking down",
        None => "upright",
    };
    let side = match normal {
        n if n.z.abs() > 0.5 => return vec![kind.to_owned()],
        n if n.y.abs() >= n.x.abs() => ["south", "north"][usize::from(n.y > 0.0)],
        n => ["west", "east"][usize::from(n.x > 0.0)],
    };
    vec![kind.to_owned(), format!("{kind}, {side}")]
}
