//! `heliotile places`: an archive and a year's weather -> the best places of modules on its surfaces, as points that `pv` takes.

use std::path::Path;

use super::chosen::choose;
use super::year::year_of;
use super::{Archives, each_tile, made_from, opened, with_series};
use crate::cli::{ModuleSize, PlaceOn, PlacesArgs, ReplayArgs};
use crate::commands::voice::remark_aside;
use crate::commands::{Outcome, guard_output, warn};
use crate::outputs::buildings::{Envelope, building_of, face_of};
use crate::outputs::pv::places::{PlaceCandidate, best_places};
use crate::outputs::tables::csvw;
use crate::outputs::tables::records::{Cell, Records};
use crate::recombine::{Series, Streamed};
use heliotile_builder::transfer::Shown;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::north::North;
use heliotile_core::text::counted;
use heliotile_core::units::tilt_and_azimuth;

const COLUMNS: [&str; 12] = [
    "point",
    "x",
    "y",
    "z",
    "tilt",
    "azimuth",
    "total_kwh_m2",
    "module_kwh",
    "sky_view",
    "receiver",
    "surface",
    "building",
];

/// `heliotile places`.
pub fn run(args: &PlacesArgs) -> Result<Outcome> {
    if args.output != Path::new("-") {
        guard_output(&args.output, &[&args.year.archive, &args.year.weather])?;
        guard_output(&csvw::beside(&args.output), &[&args.year.archive, &args.year.weather])?;
    }
    Records::check(&args.output)?;
    let replay = year_of(&args.year)?;
    let (sources, weather, dated) = opened(&replay)?;
    let archives = sources.borrowed();
    with_series(&replay, archives, &weather, &dated, |series| write(args, &replay, archives, series))
}

fn write(args: &PlacesArgs, replay: &ReplayArgs, archives: Archives, series: &Series) -> Result<Outcome> {
    let chosen = choose(&replay.common.table, archives)?;
    let mut receivers = chosen.rows::<Shown>();
    let components = ComponentSet::of(&[Component::Total]);
    let streamed = Streamed { chosen: &chosen, components };
    let candidates = each_tile(
        &streamed,
        &replay.common,
        series,
        || Ok(Vec::new()),
        |candidates, _, values| {
            for (row, shown) in receivers.by_ref().take(values.receivers()).enumerate() {
                let shown = shown?;
                let receiver = &shown.receiver;
                let is_asked = match Envelope::of(receiver) {
                    Envelope::Roof => args.on != PlaceOn::Facades,
                    Envelope::Facade => args.on != PlaceOn::Roofs,
                    Envelope::Neither => false,
                };
                if is_asked && !shown.layers.patch.is_empty() {
                    let sum = values.row(Component::Total, row).first().copied().unwrap_or_default();
                    candidates.push(PlaceCandidate {
                        position: receiver.position,
                        normal: receiver.normal,
                        kwh_m2: sum.into(),
                        sky_view: shown.views[0].into(),
                        receiver: receiver.id.clone(),
                        face: face_of(receiver).to_owned(),
                        building: building_of(receiver).unwrap_or_default().to_owned(),
                        patch: shown.layers.patch,
                    });
                }
            }
            Ok(true)
        },
    )?;
    if candidates.is_empty() {
        let what = "holds no receiver with a patch on the surfaces that are asked for";
        let hint = "build it with receivers of `heliotile receivers` or `heliotile run`, or ask for others with --on";
        return Err(Error::input(&args.year.archive, None, what, hint));
    }
    let ModuleSize(size) = args.module;
    let best = best_places(&candidates, size, args.best as usize);
    if best.len() < args.best as usize {
        warn(&format!(
            "{} of {} x {} m found, where {} were asked for: middles are places of receivers, which may be too far apart (--spacing)",
            counted(best.len() as u64, "place"),
            size[0],
            size[1],
            args.best
        ));
    }
    let places = best.iter().map(|&i| &candidates[i]);
    let rows = (1..).zip(places).map(|(number, place)| row(number, place, args, chosen.north())).collect();
    let about = made_from(series, &replay.common, archives);
    Records { columns: COLUMNS.map(str::to_owned).into(), rows }.write(&args.output, &about)?;
    remark_aside(&format!(
        "{} of {}\n",
        counted(best.len() as u64, "place"),
        counted(candidates.len() as u64, "receiver")
    ));
    Ok(Outcome::Fine)
}

fn row(number: u64, place: &PlaceCandidate, args: &PlacesArgs, north: North) -> Vec<Cell> {
    let ModuleSize([width, height]) = args.module;
    let at = place.position + place.normal * args.clearance;
    let (tilt, azimuth) = tilt_and_azimuth(north.to_true(place.normal));
    let number_of = |value: f64| Cell::Number(Some(value));
    let mut row = vec![Cell::Text(format!("best{number}"))];
    row.extend(
        [at.x, at.y, at.z, tilt, azimuth, place.kwh_m2, place.kwh_m2 * width * height, place.sky_view].map(number_of),
    );
    row.extend([&place.receiver, &place.face, &place.building].map(|name| Cell::Text(name.clone())));
    row
}
