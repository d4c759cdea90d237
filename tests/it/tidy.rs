//! House rules that a machine can check.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The crates, each with its folder below `src`; what lies in none of them is the program.
const CRATES: [&str; 3] = ["core", "scene", "builder"];

fn sources() -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
        for entry in fs::read_dir(folder).expect("a readable folder").map(|e| e.expect("an entry").path()) {
            if entry.is_dir() {
                walk(&entry, found);
            } else if entry.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&entry).expect("UTF-8");
                found.push((entry, text));
            }
        }
    }
    let mut found = Vec::new();
    for folder in ["src", "tests"] {
        walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut found);
    }
    found.sort();
    found
}

/// Crate and room of a file: `src/core/sky/perez.rs` -> core, sky; `None` outside `src` and for a crate's own `lib.rs`.
fn room_of(path: &Path) -> Option<(String, String)> {
    let inside = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).ok()?;
    let mut parts = inside.iter().filter_map(|part| part.to_str());
    let first = parts.next()?;
    let (of_crate, room) = if CRATES.contains(&first) { (first, parts.next()?) } else { ("program", first) };
    let room = room.trim_end_matches(".rs");
    (!["lib", "main"].contains(&room)).then(|| (of_crate.to_string(), room.to_string()))
}

/// Between crates the compiler sees to it that data flows one way; inside them no rooms import each other in a circle: over 400 imports.
#[test]
fn rooms_have_no_circles() {
    let (mut checked, mut imports) = (0, BTreeMap::<(String, String), BTreeSet<String>>::new());
    for (path, text) in sources() {
        let Some((of_crate, room)) = room_of(&path) else { continue };
        let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        if path.file_name().is_some_and(|name| name.to_string_lossy().ends_with("tests.rs")) {
            continue;
        }
        for part in
            shipped.lines().filter(|line| !line.trim_start().starts_with("//")).flat_map(|l| l.split("crate::").skip(1))
        {
            let name: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            checked += 1;
            if name != room {
                imports.entry((of_crate.clone(), room.clone())).or_default().insert(name);
            }
        }
    }
    assert!(checked > 400, "only {checked} imports found");
    // Rooms that import nothing that is left are taken away; a circle stays.
    loop {
        let rooms: BTreeSet<(String, String)> = imports.keys().cloned().collect();
        let open = |of_crate: &str, names: &BTreeSet<String>| {
            names.iter().any(|name| rooms.contains(&(of_crate.to_string(), name.clone())))
        };
        let before = imports.len();
        imports.retain(|(of_crate, _), names| open(of_crate, names));
        if imports.len() == before {
            break;
        }
    }
    assert!(imports.is_empty(), "circles: {imports:#?}");
}

/// No file is longer than 600 lines, and the median is below 300.
#[test]
fn files_are_short() {
    let mut lengths = Vec::new();
    for (path, text) in sources() {
        let lines = text.lines().count();
        assert!(lines <= 600, "{} has {lines} lines", path.display());
        lengths.push(lines);
    }
    lengths.sort_unstable();
    assert!(lengths[lengths.len() / 2] < 300, "median {}", lengths[lengths.len() / 2]);
}

/// `unsafe` stands in one file: 0 others hold it.
#[test]
fn unsafe_in_one_file() {
    let word = concat!("un", "safe ");
    let holders: Vec<_> = sources()
        .into_iter()
        .filter(|(path, text)| text.contains(word) && !path.ends_with("tidy.rs"))
        .map(|s| s.0)
        .collect();
    assert!(holders.iter().all(|p| p.ends_with("archive/mapping.rs")), "{holders:?}");
    assert!(holders.len() <= 1);
}

/// Every test opens with the sentence it proves, and none is switched off: over 60 tests, 0 without.
#[test]
fn tests_say_what_they_prove() {
    let (attribute, off) = (concat!("#[", "test]"), concat!("#[", "ignore"));
    let mut count = 0;
    for (path, text) in sources() {
        assert!(!text.contains(off), "{} switches a test off", path.display());
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        for (i, _) in lines.iter().enumerate().filter(|(_, l)| **l == attribute) {
            count += 1;
            assert!(i > 0 && lines[i - 1].starts_with("///"), "{}:{} has no sentence", path.display(), i + 1);
        }
    }
    assert!(count > 60, "only {count} tests");
}
