//! `heliotile buildings`: an archive and a year's weather -> what a solar cadastre says of buildings and roof faces.

use std::path::Path;

use super::chosen::choose;
use super::year::year_of;
use super::{Archives, each_tile, made_from, opened, with_series};
use crate::cli::{BuildingsArgs, ReplayArgs};
use crate::commands::voice::remark_aside;
use crate::commands::{Outcome, guard_output, warn};
use crate::files::shown;
use crate::outputs::buildings::{Cadastre, Usable, building_rows, face_rows};
use crate::outputs::tables::csvw;
use crate::outputs::tables::records::Records;
use crate::recombine::{Series, Streamed};
use heliotile_builder::transfer::Shown;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::text::counted;

/// More hours than a year has; of fewer the reader of the weather says so.
const MORE_THAN_A_YEAR_H: f64 = 8800.0;

/// `heliotile buildings`.
pub fn run(args: &BuildingsArgs) -> Result<Outcome> {
    let outputs = || [Some(args.output.as_path()), args.faces.as_deref()].into_iter().flatten();
    for output in outputs().filter(|output| *output != Path::new("-")) {
        guard_output(output, &[&args.year.archive, &args.year.weather])?;
        guard_output(&csvw::beside(output), &[&args.year.archive, &args.year.weather])?;
    }
    outputs().try_for_each(Records::check)?;
    if args.faces.as_deref() == Some(args.output.as_path()) {
        let what = "is the table of buildings too";
        return Err(Error::input(&args.output, None, what, "give --faces a name of its own"));
    }
    let replay = year_of(&args.year)?;
    let (sources, weather, dated) = opened(&replay)?;
    let archives = sources.borrowed();
    with_series(&replay, archives, &weather, &dated, |series| write(args, &replay, archives, series))
}

fn write(args: &BuildingsArgs, replay: &ReplayArgs, archives: Archives, series: &Series) -> Result<Outcome> {
    let hours: f64 = series.conditions.iter().filter_map(|condition| condition.stamp).map(|stamp| stamp.hours).sum();
    if hours > MORE_THAN_A_YEAR_H {
        warn(&format!(
            "{}: sums are over its {hours} hours, and --threshold {} is compared with them: cadastres tell of a year",
            args.year.weather.display(),
            args.threshold
        ));
    }
    let chosen = choose(&replay.common.table, archives)?;
    let usable = Usable { threshold_kwh_m2: args.threshold, least_m2: args.min_area };
    let cadastre = Cadastre::new(chosen.receivers(), usable, chosen.north(), &args.year.archive)?;
    let mut receivers = chosen.rows::<Shown>();
    let components = ComponentSet::of(&[Component::Total]);
    let streamed = Streamed { chosen: &chosen, components };
    let cadastre = each_tile(
        &streamed,
        &replay.common,
        series,
        || Ok(cadastre),
        |cadastre, _, values| {
            for (row, shown) in receivers.by_ref().take(values.receivers()).enumerate() {
                let shown = shown?;
                let sum = values.row(Component::Total, row).first().copied().unwrap_or_default();
                cadastre.add(&shown.receiver, shown.layers.patch, shown.views[0].into(), sum.into());
            }
            Ok(true)
        },
    )?;
    if cadastre.vague() > 0 {
        warn(&format!(
            "{} of {}: nobody says how their receivers touch, each counts as one region (patches come from `heliotile receivers`)",
            counted(cadastre.vague() as u64, "roof face"),
            shown(&args.year.archive).display()
        ));
    }
    let about = made_from(series, &replay.common, archives);
    if let Some(faces) = &args.faces {
        face_rows(&cadastre).write(faces, &about)?;
    }
    building_rows(&cadastre).write(&args.output, &about)?;
    let (buildings, faces) = (cadastre.names.len() as u64, cadastre.faces.len() as u64);
    // Standard output may be the table.
    remark_aside(&format!("{} with {}\n", counted(buildings, "building"), counted(faces, "roof face")));
    Ok(Outcome::Fine)
}
