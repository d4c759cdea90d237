//! `heliotile replay --honeybee`: an archive and weather -> a folder of hourly results as Honeybee's recipes leave them.

use std::path::Path;

use super::chosen::choose;
use super::{Archives, each_tile, made_from};
use crate::cli::ReplayArgs;
use crate::commands::{Outcome, remark};
use crate::outputs::honeybee::{Grids, LitHours, ResultsFolder};
use crate::outputs::periods::Every;
use crate::recombine::{Series, Streamed};
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::text::counted;

/// Refuses what such a folder cannot hold, before anything is read.
pub fn check(args: &ReplayArgs, folder: &Path) -> Result<()> {
    if args.every != Every::Hour {
        let hint = "leave --every out: sums are made from the folder's hours";
        return Err(Error::argument("--every", "results of Honeybee are hours", hint));
    }
    let known = |component: &Component| COMPONENTS.contains(component);
    if args.common.columns.as_ref().is_some_and(|columns| !columns.as_slice().iter().all(known)) {
        let hint = "give total, sun_direct or both";
        return Err(Error::argument("--columns", "results of Honeybee are `total` and `direct`, the sun alone", hint));
    }
    ResultsFolder::check(folder)
}

/// What the folder has places for.
const COMPONENTS: [Component; 2] = [Component::Total, Component::SunDirect];

/// Writes the folder of a series.
pub fn write(args: &ReplayArgs, archives: Archives, series: &Series, folder: &Path) -> Result<Outcome> {
    let asked = &args.common.table;
    let hours = LitHours::of(&series.conditions)
        .map_err(|(what, hint)| Error::input(&args.weather, None, format!("has {what}, Honeybee has none"), hint))?;
    let chosen = choose(asked, archives)?;
    let grids = Grids::of(chosen.receivers(), asked.by)?;
    let components = args.common.columns.as_ref().map_or(&COMPONENTS[..], |columns| columns.as_slice());
    let about = made_from(series, &args.common, archives);
    let mut receivers = chosen.receivers();
    let streamed = Streamed { chosen: &chosen, components: ComponentSet::of(components) };
    let start = || ResultsFolder::create(folder, grids, hours, components, &about);
    let results = each_tile(&streamed, &args.common, series, start, |results, _, values| {
        let here = receivers.by_ref().take(values.receivers()).collect::<Result<Vec<_>>>()?;
        results.write(&here, values)?;
        Ok(true)
    })?;
    let count = results.finish()?;
    let (grids, receivers) = (counted(count as u64, "grid"), counted(chosen.count(), "receiver"));
    remark(&format!("{}: {receivers} in {grids}\n", folder.display()))?;
    Ok(Outcome::Fine)
}
