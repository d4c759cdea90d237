//! House rules that a machine can check.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crates, each with its folder below `src`.
const CRATES: [&str; 16] = [
    "requests",
    "core",
    "weather",
    "comfort",
    "files",
    "archives",
    "place",
    "scene",
    "builder",
    "remote",
    "results",
    "studies",
    "atlas",
    "energyplus",
    "cases",
    "program",
];

/// Crates whose public types must have unique names.
const ENGINE: [&str; 4] = ["core", "scene", "builder", "remote"];

pub fn sources() -> Vec<(PathBuf, String)> {
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
        walk(&Path::new(crate::ROOT).join(folder), &mut found);
    }
    found.sort();
    found
}

/// Returns the crate and module of a file: `src/core/sky/perez.rs` -> core, [sky, perez]; `None`
/// outside the crates.
fn module_of(path: &Path) -> Option<(String, Vec<String>)> {
    let inside = path.strip_prefix(Path::new(crate::ROOT).join("src")).ok()?;
    let mut parts: Vec<String> = inside.iter().filter_map(|part| Some(part.to_str()?.to_owned())).collect();
    let of_crate = parts.remove(0);
    let file = parts.pop()?;
    let name = file.trim_end_matches(".rs");
    if !["lib", "main", "mod"].contains(&name) {
        parts.push(name.to_owned());
    }
    CRATES.contains(&of_crate.as_str()).then_some((of_crate, parts))
}

/// Returns the shipped part of a file: no tests, no comments.
fn shipped(text: &str) -> String {
    let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    shipped.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

fn is_of_tests(path: &Path) -> bool {
    path.file_stem().is_some_and(|name| name.to_string_lossy().contains("test"))
}

/// Returns the modules that a text names from the module `here`: after `crate::` and after each
/// `super::`, with those in braces.
fn named_modules(text: &str, here: &[String]) -> Vec<Vec<String>> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(at) = ["crate::", "super::"].iter().filter_map(|root| rest.find(root)).min() {
        let is_own = rest[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':');
        let mut base =
            if rest[at..].starts_with("crate::") { Vec::new() } else { here[..here.len().max(1) - 1].to_vec() };
        rest = &rest[at + "crate::".len()..];
        while let Some(further) = rest.strip_prefix("super::") {
            base.pop();
            rest = further;
        }
        if !is_own {
            continue;
        }
        let mut path = rest;
        while let Some(segment) = Some(word(path)).filter(|segment| !segment.is_empty()) {
            path = &path[segment.len()..];
            base.push(segment);
            path = path.strip_prefix("::").unwrap_or("");
        }
        match path.strip_prefix('{').and_then(|braced| braced.split_once('}')) {
            Some((braced, _)) => found.extend(braced.split(',').map(|name| {
                let mut whole = base.clone();
                whole.extend(name.trim().split("::").map(word));
                whole
            })),
            None => found.push(base),
        }
    }
    found
}

/// Between crates the compiler ensures that data flows one way. Inside them no rooms import each
/// other in a circle, and no folders of a folder do, at whatever depth: over 900 imports.
#[test]
fn rooms_have_no_circles() {
    type Folder = (String, Vec<String>);
    let (mut modules, mut folders) = (BTreeSet::<Folder>::new(), BTreeSet::<Folder>::new());
    let files: Vec<(PathBuf, String)> = sources().into_iter().filter(|(path, _)| !is_of_tests(path)).collect();
    for (of_crate, module) in files.iter().filter_map(|(path, _)| module_of(path)) {
        modules.insert((of_crate.clone(), module.clone()));
        folders.extend((1..module.len()).map(|depth| (of_crate.clone(), module[..depth].to_vec())));
    }
    let mut imports = BTreeMap::<Folder, BTreeMap<String, BTreeSet<String>>>::new();
    let mut checked = 0;
    for (path, text) in &files {
        let Some((of_crate, here)) = module_of(path) else { continue };
        for named in named_modules(&shipped(text), &here) {
            checked += 1;
            // The folder in which both modules lie side by side.
            let depth = here.iter().zip(&named).take_while(|(a, b)| a == b).count();
            let (Some(from), Some(to)) = (here.get(depth), named.get(depth)) else { continue };
            if modules.iter().any(|(other, module)| *other == of_crate && module.starts_with(&named[..=depth])) {
                let folder = (of_crate.clone(), here[..depth].to_vec());
                imports.entry(folder).or_default().entry(from.clone()).or_default().insert(to.clone());
            }
        }
    }
    assert!(checked > 900, "only {checked} imports found");
    for (folder, mut arrows) in imports {
        // Modules that import nothing that is left are removed, and so are those that nothing left
        // imports; a circle stays.
        loop {
            let before = arrows.len();
            let left: BTreeSet<String> = arrows.keys().cloned().collect();
            let wanted: BTreeSet<String> = arrows.values().flatten().cloned().collect();
            arrows.retain(|name, others| wanted.contains(name) && others.iter().any(|other| left.contains(other)));
            if arrows.len() == before {
                break;
            }
        }
        // Two files of one folder may know each other, as a type and its maker do.
        let is_folder = |name: &String| {
            let whole = [folder.1.clone(), vec![name.clone()]].concat();
            folder.1.is_empty() || folders.contains(&(folder.0.clone(), whole))
        };
        assert!(!arrows.keys().any(is_folder), "a circle in {folder:?}: {arrows:#?}");
    }
}

/// No two public types of the engine's crates share a name, so that a word has one meaning
/// everywhere: over 150 types.
#[test]
fn public_types_have_names_of_their_own() {
    let mut homes = BTreeMap::<String, PathBuf>::new();
    for (path, text) in sources() {
        let of_engine = module_of(&path).is_some_and(|(of_crate, _)| ENGINE.contains(&of_crate.as_str()));
        let for_tests = is_of_tests(&path);
        // Names of parts of one format stay in the file of its reader.
        if !of_engine || for_tests || path.components().any(|part| part.as_os_str() == "formats") {
            continue;
        }
        for line in shipped(&text).lines() {
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

/// Splits brackets at the beginning of `text`: the items between commas that lie in no other
/// bracket, and the text behind.
fn bracketed(text: &str) -> Option<(Vec<&str>, &str)> {
    let (mut depth, mut start, mut items, mut before) = (0_usize, 1, Vec::new(), ' ');
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' | '<' => depth += 1,
            '>' if "-=".contains(before) => {}
            ')' | ']' | '}' | '>' => depth = depth.checked_sub(1)?,
            _ => {}
        }
        before = c;
        if depth == 0 || depth == 1 && c == ',' {
            items.push(text.get(start..at)?.trim());
            start = at + 1;
        }
        if depth == 0 {
            items.retain(|item| !item.is_empty());
            return Some((items, &text[start..]));
        }
    }
    None
}

/// Returns the functions of a file, each with its parameters.
fn functions(code: &str) -> Vec<(&str, Vec<&str>)> {
    let is_of_name = |c: char| c.is_alphanumeric() || c == '_';
    let function = |(at, _): (usize, &str)| {
        let behind = &code[at + 3..];
        let (name, behind) = behind.split_at(behind.find(|c| !is_of_name(c))?);
        let behind = if behind.starts_with('<') { bracketed(behind)?.1 } else { behind };
        let is_one = !name.is_empty() && !code[..at].ends_with(is_of_name) && behind.starts_with('(');
        Some((name, bracketed(behind).filter(|_| is_one)?.0))
    };
    code.match_indices("fn ").filter_map(function).collect()
}

/// Returns true if a parameter is a tuple that its function takes apart, or a tuple of unlike
/// things; two numbers that make a point are alike.
fn is_tuple(parameter: &str) -> bool {
    let bare = |text: &str| {
        let words = text.split(' ').skip_while(|word| *word == "mut" || word.starts_with("&'") || *word == "&mut");
        words.collect::<Vec<_>>().join(" ").trim_start_matches('&').to_owned()
    };
    let (pattern, of_type) = parameter.split_once(": ").unwrap_or((parameter, ""));
    let is_unlike = |items: Vec<&str>| items.iter().any(|item| *item != items[0]);
    let of_type = bare(of_type);
    bare(pattern).starts_with('(')
        || of_type.starts_with('(') && bracketed(&of_type).is_some_and(|all| is_unlike(all.0))
}

/// Values that travel together are a struct: of over 5000 functions none takes a tuple apart in its
/// signature, and none takes one of unlike things.
#[test]
fn functions_take_no_tuples() {
    let (root, mut checked) = (Path::new(crate::ROOT), 0);
    for (path, text) in sources() {
        if !path.starts_with(root.join("src")) {
            continue;
        }
        let code: String =
            text.lines().filter(|line| !line.trim_start().starts_with("//")).map(|l| format!("{l}\n")).collect();
        for (name, parameters) in functions(&code) {
            let tuple = parameters.iter().find(|parameter| is_tuple(parameter));
            assert!(tuple.is_none(), "{}: {name} takes {}", path.display(), tuple.unwrap_or(&""));
            checked += 1;
        }
    }
    assert!(checked > 5000, "only {checked} functions");
}

/// Among 9 parameters the 4 that are tuples are found: apart, unlike, by reference, behind
/// generics.
#[test]
fn tuples_are_found() {
    let code = concat!(
        "f",
        "n one<F: Fn(A, B) -> C>((a, mut b): (&A, &B), c: C) {} f",
        "n two(&self, about: &mut (A, B),\n",
        "point: (f64, f64), [a, b]: [A; 2],) {} f",
        "n three<'a>(&(a, _): &'a Shard, d: &'a (Vec<(A, B)>, B), all: &[(A, B)]) {}",
    );
    let found = functions(code);
    let tuples: Vec<(&str, &str)> =
        found.iter().flat_map(|(name, all)| all.iter().filter(|all| is_tuple(all)).map(|one| (*name, *one))).collect();
    assert_eq!(found.iter().map(|(_, all)| all.len()).sum::<usize>(), 9);
    let expected = [
        ("one", "(a, mut b): (&A, &B)"),
        ("two", "about: &mut (A, B)"),
        ("three", "&(a, _): &'a Shard"),
        ("three", "d: &'a (Vec<(A, B)>, B)"),
    ];
    assert_eq!(tuples, expected);
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

/// No doc of the sources begins with words that lean on what stands before it, such as "The same"
/// or "Whether": each names its subject. No comment but a table is wider than 100 columns.
#[test]
fn docs_name_their_subject() {
    const LEANING: [&str; 6] = ["The same", "That of", "Those of", "Of ", "What ", "Whether "];
    let mut found = Vec::new();
    for (path, text) in sources() {
        let mut before = "";
        for (number, line) in text.lines().enumerate() {
            let line_start = line.trim_start();
            let doc = line_start.strip_prefix("/// ").or_else(|| line_start.strip_prefix("//! "));
            let begins =
                !before.starts_with("//") && doc.is_some_and(|doc| LEANING.iter().any(|words| doc.starts_with(words)));
            let is_wide = line_start.starts_with("//") && !line_start.contains('|') && line.chars().count() > 100;
            if begins || is_wide {
                found.push(format!("{}:{}: {line}", path.display(), number + 1));
            }
            before = line_start;
        }
    }
    assert!(found.is_empty(), "{} docs:\n{}", found.len(), found.join("\n"));
}

/// `unsafe` stands in two files, the mapping and the calls of the page's engine to its host: 0
/// others hold it.
#[test]
fn unsafe_stands_in_two_files() {
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

/// Every test opens with the sentence it proves, its name states a fact in three words or more, and
/// none is switched off: over 60 tests, 0 without.
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
            let name = lines[i + 1..].iter().find_map(|line| line.strip_prefix("fn ")).unwrap_or_default();
            let words = name.split('(').next().unwrap_or_default().split('_').count();
            assert!(words > 2, "{}:{}: `{name}` does not state a fact", path.display(), i + 1);
        }
    }
    assert!(count > 60, "only {count} tests");
}

/// The engine alone, with weather and comfort but without default features, depends on at most 65
/// crates: 0 of the 14 that draw, print, write tables, parse command lines, map files, make
/// temporary files, start threads by themselves or are C.
#[test]
fn the_engine_is_small() {
    let mut tree = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
    tree.current_dir(crate::ROOT).args(["tree", "--locked", "--offline"]);
    tree.args(["core", "weather", "comfort"].iter().flat_map(|name| ["-p".to_owned(), format!("heliotile-{name}")]));
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
        "tiny-skia",
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
    assert!(crates.len() <= 65, "{} crates: {crates:?}", crates.len());
}

/// The package of the library holds the rooms that it is made of: 3 folders and its first file.
#[test]
fn the_package_holds_its_rooms() {
    let root = Path::new(crate::ROOT);
    let manifest = fs::read_to_string(root.join("Cargo.toml")).expect("the manifest");
    let included = manifest.lines().find(|line| line.starts_with("include = ")).expect("a list of files");
    let library = fs::read_to_string(root.join("src/lib.rs")).expect("the library");
    let rooms =
        library.lines().filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'));
    let rooms: Vec<&str> = rooms.collect();
    assert_eq!(rooms, ["book", "cases", "site"]);
    for room in rooms {
        assert!(included.contains(&format!("\"/src/{room}/")), "{room} is not in: {included}");
    }
}

/// Without its default features the engine opens no file by itself: outside tests and the three
/// files that read files, 0 of its files name one, the system's temporary folder, the environment,
/// a clock or a thread, and none prints.
#[test]
fn the_engine_opens_nothing_by_itself() {
    let core = Path::new(crate::ROOT).join("src/core");
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

/// Every path in `code` on the page of recipes is an existing file or folder, or a `NAME` in an
/// existing folder: over 60 paths.
#[test]
fn recipes_name_files_that_exist() {
    let root = Path::new(crate::ROOT);
    let text = fs::read_to_string(root.join("src/book/contributing.md")).expect("a page");
    let is_path = |word: &&str| ["src/", "tests/", "tools/", "schema/"].iter().any(|folder| word.starts_with(folder));
    let paths: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_path).collect();
    for path in &paths {
        let known = match path.rsplit_once('/') {
            Some((folder, file)) if file.starts_with("NAME") => folder,
            _ => path,
        };
        assert!(root.join(known).exists(), "src/book/contributing.md names {path}, which is not there");
    }
    assert!(paths.len() > 60, "only {} paths", paths.len());
}
