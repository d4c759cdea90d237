//! Doubts that a user should know before results are used. In: an archive, weather, a request. Out:
//! sentences, or a refusal.

use std::path::Path;

use crate::outputs::periods::Every;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::site::material::rounded;
use heliotile_core::site::place::Place;
use heliotile_core::text::{Message, message};
use heliotile_core::weather::span::Span;
use heliotile_core::weather::time::years::Years;
use heliotile_weather::dated::DatedRows;
use heliotile_weather::series::Weather;

/// Refuses a query for longwave irradiance: conditions state no temperatures and no infrared
/// radiation.
pub fn no_longwave(columns: &ComponentList) -> Result<()> {
    if !columns.set().contains(Component::Longwave) {
        return Ok(());
    }
    Err(Error::Unsupported {
        what: "column `longwave`".into(),
        found: "conditions, which have no infrared radiation and no temperatures".into(),
        supported: "it from a weather file".into(),
    })
}

/// Returns a warning if the archive leaves out effects that are negligible under a weather other
/// than `weather`.
pub fn left_out(archive: &Archive, weather: Option<&Path>) -> Option<String> {
    let known = archive.manifest().negligible.as_ref()?;
    let other = weather.and_then(Path::file_name).is_none_or(|name| *name != *known.weather);
    other.then(|| {
        format!("{} leaves out {known}; in this calculation they may contribute more", archive.path().display())
    })
}

/// Returns a note about a query of an archive that states its ground's reflectance by month: the
/// mean of the year counts. Returns `None` if `changes` sets another reflectance.
pub fn mean_ground(archive: &Archive, changes: &Changes) -> Result<Option<Message>> {
    // Few archives state such a ground; the site of the others is not opened a second time.
    let Some(ground) = &archive.manifest().ground else { return Ok(None) };
    let site = OpenSite::open(archive)?;
    if Changeable::new(&site, archive.manifest()).ground.is_none() {
        return Ok(None);
    }
    let material = site.materials().iter().find(|material| material.name == ground.material);
    let group = material.and_then(|material| material.group.as_deref());
    let constant = changes.constant.iter().map(|(name, _)| name.as_str());
    let mut changed = constant.chain(changes.scheduled.iter().map(|(name, _)| name.as_str()));
    if changed.any(|name| *name == ground.material || Some(name) == group || name == "ground") {
        return Ok(None);
    }
    Ok(Some(message!(
        "`{}` has monthly reflectances, and conditions have no date: the mean of the year is used, {} ({{reflectance}} ground=... sets another)",
        ground.material,
        rounded(ground.mean())
    )))
}

/// Returns the requested rows of weather with the dates that results give them, and a note if these
/// dates come from different years.
pub fn dated_rows(
    weather: &Weather,
    file: &Path,
    span: &Span,
    year: Option<i32>,
    every: Every,
) -> Result<(DatedRows, Option<Message>)> {
    let intervals = weather.rows.iter().map(|row| row.interval).collect::<Vec<_>>();
    let dated = match year {
        Some(year) => DatedRows::in_year(&intervals, file, span, year)?,
        None => DatedRows::of_file(&intervals, file, span)?,
    };
    let labels = match every {
        Every::Hour => "times show these years",
        Every::Day | Every::Month => "days and months show no year",
        Every::Year | Every::Total => return Ok((dated, None)),
    };
    if dated.years != Years::Typical {
        return Ok((dated, None));
    }
    let years = || dated.dates.iter().map(|date| date.year);
    let (first, last) = (years().min().unwrap_or_default(), years().max().unwrap_or_default());
    let note = message!(
        "{}: its months come from different years, {first} to {last}, and {labels}; {{year}} 2019 would date all of them in 2019",
        file.display()
    );
    Ok((dated, Some(note)))
}

/// Refuses `after` if its site or coordinate system differs from that of `before`.
pub fn check_one_site(before: &Archive, after: &Archive) -> Result<()> {
    let [here, there] = [before, after].map(|archive| archive.manifest().place);
    if Place::is_one_site(here.as_ref(), there.as_ref()) {
        return Ok(());
    }
    let words = |place: Option<Place>| place.map_or("no known place".to_owned(), |place| place.to_string());
    let (here, there, first) = (words(here), words(there), before.path().display());
    let what = format!("lies at {there}, and {first} at {here}: they are not of one site and coordinate system");
    Err(Error::input(after.path(), None, what, "name archives of one site, built in one coordinate system")
        .because(Problem::OtherSite))
}
