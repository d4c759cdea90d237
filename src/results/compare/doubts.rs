//! Whether two archives can be compared. In: what both state. Out: a refusal where they are of other places, and what a user should know
//! before changes are believed.

use std::path::Path;

use crate::archives::Archives;
use crate::files::name_of;
use heliotile_builder::transfer::differences;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;
use heliotile_core::site::place::Place;

/// Scenes of one site have their middles this near, degrees of latitude and longitude.
const SAME_SITE_DEG: f64 = 0.1;

/// Axes of one coordinate system differ by less between the middles of two scenes of a site, degrees.
const SAME_NORTH_DEG: f64 = 0.5;

/// What differs between the settings of archives is named up to so many times.
const NAMED: usize = 6;

/// Refuses archives of another place than those before, and tells what else may change the light besides the scene.
pub fn tell(
    before: Archives,
    before_place: &Path,
    after: Archives,
    place: &Path,
    observer: &dyn Observer,
) -> Result<()> {
    let [first, second] = [before, after].map(|side| side.manifest().place);
    if !is_one_site(first.as_ref(), second.as_ref()) {
        let words = |place: Option<Place>| place.map_or("no place on Earth".to_owned(), |place| place.to_string());
        let what = format!("lies at {}, {} at {}", words(second), name_of(before_place), words(first));
        return Err(Error::input(place, None, what, "compare archives of one site in one coordinate system"));
    }
    let names = [before_place, place].map(name_of);
    if before.iter().count() == after.iter().count()
        && before.iter().zip(after.iter()).all(|(a, b)| a.root() == b.root())
    {
        observer.note(&format!("{} and {}: the archives are equal", names[0], names[1]));
        return Ok(());
    }
    let found = differences(before.first(), after.first())?;
    let settings = found.iter().filter(|one| one.item.starts_with("settings."));
    let named: Vec<String> = settings
        .map(|one| {
            let item = one.item.trim_start_matches("settings.");
            format!("{item} {} and {}", one.values[0], one.values[1])
        })
        .collect();
    if !named.is_empty() {
        let more = if named.len() > NAMED { ", ..." } else { "" };
        observer.warn(&format!(
            "{} and {} were built with other settings ({}{more}): changes hold what these make of them, too",
            names[0],
            names[1],
            named.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ")
        ));
    }
    Ok(())
}

/// Whether two scenes may be of one site.
fn is_one_site(before: Option<&Place>, after: Option<&Place>) -> bool {
    match (before, after) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let near = |a: f64, b: f64, most: f64| (a - b).abs() <= most;
            a.epsg == b.epsg
                && near(a.latitude_deg, b.latitude_deg, SAME_SITE_DEG)
                && near(a.longitude_deg, b.longitude_deg, SAME_SITE_DEG)
                && near(a.convergence_deg, b.convergence_deg, SAME_NORTH_DEG)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene that grew by a kilometre is of the site; another system, another town, another north and no place are not: 1 of 5.
    #[test]
    fn places() {
        let here = Place { latitude_deg: 52.07, longitude_deg: 4.3, convergence_deg: 0.4, epsg: Some(28992) };
        let same = |other: Option<Place>| is_one_site(Some(&here), other.as_ref());
        assert!(same(Some(Place { latitude_deg: 52.08, convergence_deg: 0.41, ..here })));
        assert!(!same(Some(Place { epsg: Some(7415), ..here })) && !same(Some(Place { latitude_deg: 52.37, ..here })));
        assert!(!same(Some(Place { convergence_deg: 10.0, ..here })) && !same(None) && is_one_site(None, None));
    }
}
