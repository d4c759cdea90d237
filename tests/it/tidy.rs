//! House rules that a machine can check.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crates, each with its folder below `src`; what lies in none of them is the program.
const CRATES: [&str; 4] = ["core", "scene", "builder", "remote"];

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

/// No two public types of the engine's crates share a name, so that a word means one thing wherever it is met: over 150 types.
#[test]
fn public_types_have_names_of_their_own() {
    let mut homes = BTreeMap::<String, PathBuf>::new();
    for (path, text) in sources() {
        let of_engine = room_of(&path).is_some_and(|(of_crate, _)| of_crate != "program");
        let for_tests = path.file_stem().is_some_and(|name| name.to_string_lossy().contains("test"));
        // What a reader of one format calls its parts stays in its file.
        if !of_engine || for_tests || path.components().any(|part| part.as_os_str() == "formats") {
            continue;
        }
        let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for line in shipped.lines() {
            let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
            let (first, kind) = (words.next(), words.next());
            let is_type = line.starts_with("pub ") && matches!(kind, Some("struct" | "enum" | "trait" | "type"));
            if let (Some("pub"), true, Some(name)) = (first, is_type, words.next()) {
                let other = homes.insert(name.to_string(), path.clone());
                assert!(other.is_none(), "{name} in {} and {}", path.display(), other.unwrap_or_default().display());
            }
        }
    }
    assert!(homes.len() > 150, "only {} types found", homes.len());
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

/// `unsafe` stands in two files, the mapping and what the engine of the page asks its host: 0 others hold it.
#[test]
fn unsafe_in_two_files() {
    let word = concat!("un", "safe ");
    let holders: Vec<_> = sources()
        .into_iter()
        .filter(|(path, text)| text.contains(word) && !path.ends_with("tidy.rs"))
        .map(|s| s.0)
        .collect();
    let known = ["archive/mapping.rs", "viewer/engine/src/host.rs"];
    assert!(holders.iter().all(|path| known.iter().any(|file| path.ends_with(file))), "{holders:?}");
    assert!(holders.len() <= known.len());
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

/// The engine alone, without its default features, rests on at most 64 crates: 0 of the 14 that draw, print, write tables, take command
/// lines, map files, make temporary files, start threads by themselves or are C.
#[test]
fn the_engine_is_small() {
    let mut tree = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
    tree.current_dir(env!("CARGO_MANIFEST_DIR")).args(["tree", "--locked", "--offline", "-p", "heliotile-core"]);
    let found = tree.args(["--no-default-features", "-e", "normal", "--prefix", "none"]).output().expect("cargo runs");
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    let text = String::from_utf8(found.stdout).expect("UTF-8");
    let crates: BTreeSet<(&str, &str)> = text
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(name, rest)| (name, rest.split(' ').next().unwrap_or_default()))
        .collect();
    let names: BTreeSet<&str> = crates.iter().map(|(name, _)| *name).collect();
    assert!(names.contains("heliotile-core") && names.contains("ruzstd"), "{names:?}");
    let barred = [
        "clap",
        "parquet",
        "plotters",
        "tiff",
        "exr",
        "png",
        "indicatif",
        "ctrlc",
        "memmap2",
        "zstd",
        "zstd-sys",
        "tempfile",
        "libc",
        "cc",
    ];
    let there: Vec<&&str> = names.iter().filter(|name| barred.contains(name) || name.starts_with("arrow")).collect();
    assert!(there.is_empty(), "{there:?}");
    assert!(crates.len() <= 64, "{} crates: {crates:?}", crates.len());
}

/// Without its default features the engine opens no file by itself: outside tests and the three files that read files, 0 of its files name
/// one, the system's temporary folder, the environment, a clock or a thread, and none prints.
#[test]
fn the_engine_asks_nobody() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/core");
    let of_files = ["archive/read_at.rs", "archive/source.rs", "archive/mapping.rs"];
    let barred = ["std::fs", "std::env", "std::thread", "std::time", "tempfile", "println!", "print!(", "dbg!("];
    let mut checked = 0;
    for (path, text) in sources().into_iter().filter(|(path, _)| path.starts_with(&core)) {
        let of_tests = path.file_name().is_some_and(|name| name.to_string_lossy().ends_with("tests.rs"));
        if of_tests || of_files.iter().any(|file| path.ends_with(file)) {
            continue;
        }
        let shipped =
            text.lines().take_while(|line| !line.starts_with("mod tests {") && !line.starts_with("pub mod tests {"));
        for line in shipped.filter(|line| !line.trim_start().starts_with("//")) {
            let named = barred.iter().find(|word| line.contains(**word));
            assert!(named.is_none(), "{} names {}: {line}", path.display(), named.unwrap_or(&""));
        }
        checked += 1;
    }
    assert!(checked > 80, "only {checked} files");
}
