//! Checks of two archives before they are compared. In: the statements of both. Out: a refusal if
//! they lie at different places, and warnings that a user should know before changes are believed.

use std::path::Path;

use crate::archives::Archives;
use crate::doubts::{check_one_site, preview};
use crate::files::name_of;
use heliotile_archives::transfer::differences;
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;

/// Largest number of differing settings that a warning names.
const NAMED: usize = 6;

/// Refuses archives of another place than those before. Warns of differences other than the scene
/// that may change the light.
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
        observer.note(format!("{} and {}: the archives are equal", names[0], names[1]));
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
        observer.warn(format!(
            "{} and {} were built with different settings ({}{more}): changes include the effect of the settings",
            names[0],
            names[1],
            named.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ")
        ));
    }
    Ok(())
}
