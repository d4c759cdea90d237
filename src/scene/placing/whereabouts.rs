//! Place of a scene. In: the statements of its files and of the user. Out: its place, with true
//! north, and warnings about contradictions.

use glam::DVec3;
use heliotile_core::text::{Message, message};

use crate::LoadReport;
use crate::mesh::bounds;
use crate::placing::extent::Extent;
use crate::placing::frame::SiteFrame;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::place::Place;
use heliotile_place::reference::Reference;

/// Largest distance between the place that the user states and the one that files state, km: more
/// than a city, less than the distance of a weather station in another climate.
const APART_KM: f64 = 50.0;

/// Largest difference between lengths of a system and lengths on the ground, as a share: areas are
/// then off by 2 %. National grids stay below 0.2 %.
const STRETCH: f64 = 0.01;

/// Returns the place of a scene, if files or the user state it. It is the place of the middle of
/// everything except rasters, or of the rasters if there is nothing else.
pub(crate) fn place_of(extents: &[Extent], frame: &SiteFrame, report: &mut LoadReport) -> Result<Option<Place>> {
    let [system, point] = frame.references();
    let mut place = match system {
        Some(system) => Some(of_system(extents, system, report)?),
        None => of_files(extents, report),
    };
    if let Some(Reference::Place { latitude_deg, longitude_deg }) = point {
        let stated = Place { latitude_deg, longitude_deg, convergence_deg: 0.0, epsg: None };
        let apart_km = place.map(|place| place.distance_km(latitude_deg, longitude_deg));
        if let (Some(other), Some(apart_km)) = (place, apart_km.filter(|km| *km > APART_KM)) {
            report.warnings.push(format!(
                "the stated latitude {latitude_deg:.4} and longitude {longitude_deg:.4} are {apart_km:.0} km from the place of the \
                 coordinates ({other}); the stated place is used, with y to true north"
            ).into());
        }
        // A system knows more than a stated point: the direction of north, and the place of the
        // middle.
        place =
            place.filter(|place| place.epsg.is_some() && apart_km.is_some_and(|km| km <= APART_KM)).or(Some(stated));
    }
    if let Some(turn_deg) = frame.rotate_deg.filter(|turn| *turn != 0.0) {
        let Some(place) = &mut place else {
            let what = format!("the model is turned by {turn_deg} degrees, but its place is not stated");
            let hint = "give {latitude} and {longitude} as well (for example of the weather file), or {crs}";
            return Err(Error::argument("rotate_deg", what, hint)
                .because(Problem::Needs { others: vec!["latitude".to_owned(), "longitude".to_owned()] }));
        };
        let y_deg = place.convergence_deg + turn_deg;
        // Angles beyond 180 degrees are brought into -180..180; others stay exact.
        place.convergence_deg = if y_deg.abs() > 180.0 { (y_deg + 180.0).rem_euclid(360.0) - 180.0 } else { y_deg };
    }
    let turned = |note| Message::from(note).and(" ({crs} or {rotate_deg}: another direction)");
    report.notes.extend(place.and_then(|place| place.note()).map(turned));
    Ok(place)
}

/// Returns the middle of everything except rasters, or else of all extents.
fn middle<'a>(of: impl Iterator<Item = (&'a Extent, [DVec3; 2])> + Clone) -> DVec3 {
    let near = bounds(of.clone().filter(|(extent, _)| !extent.raster).flat_map(|(_, corners)| corners));
    let (low, high) = if near.0.is_finite() { near } else { bounds(of.flat_map(|(_, corners)| corners)) };
    0.5 * (low + high)
}

/// Returns the place in a system that the user states for the coordinates of the whole scene.
fn of_system(extents: &[Extent], system: Reference, report: &mut LoadReport) -> Result<Place> {
    // Coordinates in metres cannot be those of a system in feet: such files lie at their own place.
    let contrary =
        |extent: &&Extent| extent.in_metres && extent.reference().is_some_and(|own| own.unit_m() != system.unit_m());
    let of_system = || extents.iter().filter(|extent| !contrary(extent));
    let mut others = of_system().filter_map(|e| Some((e, e.reference()?))).filter(|(_, own)| !own.is_same(&system));
    if let Some((extent, other)) = others.next() {
        let more = others.count();
        let files = if more == 0 { String::new() } else { format!(" (and {more} files more)") };
        let file = extent.file.display();
        report.warnings.push(format!("{file} states {other}{files}, but the requested {system} is used").into());
    }
    let Some(first) = of_system().find(|extent| !extent.raster).or_else(|| of_system().next()) else {
        if let Some(place) = of_files(extents, report) {
            report.warnings.push(format!(
                "the coordinates are metres, but the unit of {system} is {:.7} m: the place of the files is used ({place})",
                system.unit_m()
            ).into());
            return Ok(place);
        }
        let what = format!("the coordinates are metres, but the unit of {system} is {:.7} m", system.unit_m());
        return Err(Error::argument("crs", what, "give the system that the coordinates of the scene are in"));
    };
    let unit = first.unit_of(system);
    let in_system = |extent: &Extent| extent.bounds.map(|corner| corner / extent.unit_of(system));
    let at = middle(of_system().map(|extent| (extent, in_system(extent))));
    match system.locate(at.x, at.y) {
        Ok((place, length)) => {
            report.warnings.extend(stretched(system, unit, length, &place));
            Ok(place)
        }
        Err(_) => {
            let what = format!("{system} does not cover {:.1} {:.1}, the middle of the scene", at.x, at.y);
            Err(Error::argument(
                "crs",
                what,
                "give the system that the coordinates of the scene are in, and their unit",
            ))
        }
    }
}

/// Returns the place of the middle of all files with the first one's reference; warns of files with
/// another one.
fn of_files(extents: &[Extent], report: &mut LoadReport) -> Option<Place> {
    for extent in extents {
        if let (Some(own), Some(stated)) = (extent.own, extent.stated)
            && !own.is_same(&stated)
        {
            let file = extent.file.display();
            report.warnings.push(format!("{file} states {own}, but the requested {stated} is used").into());
        }
    }
    let known = || extents.iter().filter_map(|extent| Some((extent, extent.reference()?)));
    let (first, reference) = known().next()?;
    let first_file = first.file.display();
    if let Some((extent, other)) = known().find(|(_, other)| !other.is_same(&reference)) {
        report.warnings.push(format!(
            "{first_file} is in {reference}, but {} is in {other}; coordinates are not converted, and those of the first file give the place",
            extent.file.display()
        ).into());
    }
    let united = known().filter(|(_, other)| other.is_same(&reference)).map(|(e, _)| (e, e.in_system(reference)));
    let at = middle(united);
    match reference.locate(at.x, at.y) {
        Ok((place, length)) => {
            report.warnings.extend(stretched(reference, first.unit_of(reference), length, &place));
            Some(place)
        }
        Err(_) => {
            report.warnings.push(message!(
                "{first_file}: the place of {reference} is not known, so y is taken for north and the place of weather is not checked: \
                 give {{crs}} with a system in metres, or {{latitude}} and {{longitude}}"
            ));
            None
        }
    }
}

/// Returns a warning if lengths of the scene differ from those on the ground: `unit` is the metres
/// of the scene for a unit of the system, `length` those on the ground.
fn stretched(system: Reference, unit: f64, length: f64, place: &Place) -> Option<Message> {
    let metres = length / unit;
    if (metres - 1.0).abs() <= STRETCH {
        return None;
    }
    let foot = system.unit_m();
    if foot != 1.0 && unit == 1.0 {
        return Some(message!(
            "coordinates of {system} are in units of {foot:.7} m, but scenes are read in metres: give {{scale}} {foot:.7} (in site.toml \
             scale = {foot:.7})"
        ));
    }
    // Zones of UTM are 6 degrees wide; the first one begins at 180 W.
    let zone = (((place.longitude_deg + 180.0) / 6.0).floor() as i64).clamp(0, 59) + 1;
    let utm = if place.latitude_deg < 0.0 { 32700 + zone } else { 32600 + zone };
    Some(format!(
        "a metre of {system} is {metres:.3} m on the ground at {:.2} {:.2}, so areas do not match heights: reproject the files, for \
         instance to EPSG:{utm}",
        place.latitude_deg, place.longitude_deg
    ).into())
}
