//! Paths that lead nowhere. In: the path. Out: the part of it that exists, and names there that are
//! similar to the missing one.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use crate::text::excerpt;

/// Most names of a folder that are compared.
const MAX_NAMES: usize = 10_000;
/// Most names that are shown.
const MAX_SHOWN: usize = 3;

/// Returns the part of a path that exists and similar names, in words that continue "cannot read
/// PATH: ".
pub(super) fn explain(path: &Path) -> String {
    let steps: Vec<&Path> = path.ancestors().filter(|step| !step.as_os_str().is_empty()).collect();
    // Steps run from the whole path to its first part.
    let first_missing = steps.iter().take_while(|step| !step.exists()).last().copied().unwrap_or(path);
    let parent = first_missing.parent().unwrap_or(Path::new(""));
    let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let name = first_missing.file_name().unwrap_or_default();
    if folder.exists() && !folder.is_dir() {
        return format!("No such file: {} is a file, not a folder", folder.display());
    }
    let is_last = first_missing == path;
    let mut text = if is_last {
        "No such file".to_owned()
    } else {
        format!("No such file: there is no folder `{}` in {}", excerpt(name.as_encoded_bytes()), folder.display())
    };
    let near: Vec<String> =
        alike(name, folder, is_last).iter().map(|name| parent.join(name).display().to_string()).collect();
    if let [others @ .., last] = near.as_slice() {
        let or = if others.is_empty() { String::new() } else { format!("{} or ", others.join(", ")) };
        text += &format!("\n  to fix: did you mean {or}{last}?");
    }
    text
}

/// Returns the names in a folder that differ little from one, the most similar first.
fn alike(wanted: &OsStr, folder: &Path, file: bool) -> Vec<String> {
    let wanted = wanted.to_string_lossy().to_lowercase();
    let stem = |name: &str| name.split('.').next().unwrap_or_default().to_owned();
    let most = (wanted.chars().count() / 3).max(2);
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut near: Vec<(usize, String)> = entries
        .take(MAX_NAMES)
        .flatten()
        // Only a folder can stand for a missing folder; anything may stand for a missing file.
        .filter(|entry| file || entry.path().is_dir())
        .filter_map(|entry| {
            let name = excerpt(entry.file_name().to_string_lossy().as_bytes());
            let lower = name.to_lowercase();
            // Another ending counts little, whatever its length.
            let other_ending = stem(&lower) == stem(&wanted) && !stem(&wanted).is_empty();
            let apart = if other_ending { 1 } else { strsim::osa_distance(&wanted, &lower) };
            (apart <= most).then_some((apart, name))
        })
        .collect();
    near.sort_unstable();
    near.truncate(MAX_SHOWN);
    near.into_iter().map(|(_, name)| name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six paths that lead nowhere are explained by the part that exists, with the 0 to 3 names
    /// similar to the missing one.
    #[test]
    fn a_missing_path_names_similar_ones() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("hague")).expect("created");
        for name in ["town.city.json", "hague/scene.obj", "hague/scenes.obj", "hague/Zcene.obj", "hague/materials.toml"]
        {
            fs::write(at(name), "").expect("written");
        }
        let shown = |name: &str| explain(&at(name)).replace(&folder.path().display().to_string(), "F");
        for (name, expected) in [
            ("nothing.stl", "No such file"),
            ("town.json", "No such file\n  to fix: did you mean F/town.city.json?"),
            (
                "hague/scne.obj",
                "No such file\n  to fix: did you mean F/hague/scene.obj, F/hague/Zcene.obj or F/hague/scenes.obj?",
            ),
            ("hauge/scene.obj", "No such file: there is no folder `hauge` in F\n  to fix: did you mean F/hague?"),
            ("a/b/c.obj", "No such file: there is no folder `a` in F"),
            ("town.city.json/b.obj", "No such file: F/town.city.json is a file, not a folder"),
        ] {
            assert_eq!(shown(name), expected, "{name}");
        }
    }
}
