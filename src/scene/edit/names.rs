//! Names of objects and materials. In: names as a user gives them. Out: the objects of these names,
//! or the most similar names.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::scene_object::SceneObject;
use heliotile_core::text::counted;

use crate::text::excerpt;

/// Largest number of names that a message proposes.
const PROPOSED: usize = 3;

/// Objects by their names: their own, that of the object in the file and that of the building.
pub(super) struct ObjectNames<'a>(HashMap<&'a str, BTreeSet<u32>>);

impl<'a> ObjectNames<'a> {
    pub(super) fn new(objects: &'a [SceneObject]) -> Self {
        let mut names: HashMap<&str, BTreeSet<u32>> = HashMap::new();
        for (number, SceneObject { name, note }) in (0..).zip(objects) {
            for name in [name, &note.object, &note.building].into_iter().filter(|name| !name.is_empty()) {
                names.entry(name).or_default().insert(number);
            }
        }
        ObjectNames(names)
    }

    pub(super) fn find(&self, name: &str, field: &'static str, file: &Path) -> Result<Vec<u32>> {
        let name = name.trim();
        match self.0.get(name) {
            Some(found) => Ok(found.iter().copied().collect()),
            None => {
                let what = format!("{} has no object or building `{}`", file.display(), excerpt(name.as_bytes()));
                let hint = format!("known names: {}", proposed(name, self.0.keys().copied()));
                Err(Error::argument(field, what, hint).because(Problem::unknown(name, self.0.keys().copied())))
            }
        }
    }
}

/// Returns the most similar names, quoted.
pub(super) fn proposed<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let lower = name.to_lowercase();
    let mut near: Vec<(usize, &str)> = known.map(|other| (apart(&lower, other), other)).collect();
    near.sort_unstable();
    near.dedup();
    let words: Vec<String> =
        near.iter().take(PROPOSED).map(|(_, name)| format!("`{}`", excerpt(name.as_bytes()))).collect();
    match near.len() > PROPOSED {
        true => format!("{} and {}", words.join(", "), counted((near.len() - PROPOSED) as u64, "other")),
        false => words.join(", "),
    }
}

/// Returns the edit distance of two names; a name that contains the requested one has a distance of
/// 1.
fn apart(asked: &str, other: &str) -> usize {
    let other = other.to_lowercase();
    if !asked.is_empty() && other.contains(asked) { 1 } else { strsim::osa_distance(asked, &other) }
}
