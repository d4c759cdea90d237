//! House rules that a machine can check.

use std::fs;
use std::path::{Path, PathBuf};

/// Stages in the order that data flows; files outside a folder belong to the stage of their name.
const STAGES: [&str; 13] = [
    "units",
    "error",
    "spill",
    "hemisphere",
    "mapping",
    "scene",
    "trace",
    "layers",
    "archive",
    "recombine",
    "outputs",
    "cli",
    "commands",
];

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

/// `src/scene/mesh.rs` -> scene, `src/units.rs` -> units; `None` outside the stages (main.rs, lib.rs, tests).
fn stage_of(path: &Path) -> Option<usize> {
    let inside = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).ok()?;
    let first = inside.iter().next()?.to_str()?.trim_end_matches(".rs");
    STAGES.iter().position(|s| *s == first)
}

/// Data flows one way: no file imports a stage to its right, and recombine never imports trace; over 100 imports are checked.
#[test]
fn imports_go_left() {
    let mut checked = 0;
    for (path, text) in sources() {
        let Some(own) = stage_of(&path) else { continue };
        for part in text.split("crate::").skip(1) {
            let name: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let Some(other) = STAGES.iter().position(|s| *s == name) else { continue };
            checked += 1;
            assert!(other <= own, "{} imports {name}, a stage to its right", path.display());
            let recombines = ["layers", "archive", "recombine", "outputs"].contains(&STAGES[own]);
            assert!(!(recombines && name == "trace"), "{} imports trace", path.display());
        }
    }
    assert!(checked > 100, "only {checked} imports found");
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
    assert!(holders.iter().all(|p| p.ends_with("archive/source.rs")), "{holders:?}");
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
