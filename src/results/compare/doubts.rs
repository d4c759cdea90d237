//! Whether two archives can be compared. In: what both state. Out: a refusal where they are of other places, and what a user should know
//! before changes are believed.

use std::path::Path;

use crate::archives::Archives;
use crate::doubts::{check_one_site, preview};
use crate::files::name_of;
use heliotile_builder::transfer::differences;
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;

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
    check_one_site(before.first(), after.first())?;
    let names = [before_place, place].map(name_of);
    if before.iter().count() == after.iter().count()
        && before.iter().zip(after.iter()).all(|(a, b)| a.root() == b.root())
    {
        observer.note(&format!("{} and {}: the archives are equal", names[0], names[1]));
        return Ok(());
    }
    after.iter().filter_map(preview).for_each(|text| observer.warn(&text));
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
