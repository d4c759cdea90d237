//! Prose of README and the book. In: pages. Out: sentences that are too long, numbers that differ,
//! links that lead nowhere, commands without a question.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use heliotile::cases::COMMANDS;

use super::page::{Item, Mark, Page};
use super::{pages, root};

/// The most words of a sentence.
const LONGEST: usize = 42;

/// Returns the paragraphs and items of lists of a page, each with the number of its first line.
/// Blocks, tables, headings and comments are left out.
fn paragraphs(page: &Page) -> Vec<(usize, String)> {
    let (mut found, mut inside, mut open) = (Vec::<(usize, String)>::new(), false, false);
    for (at, line) in page.lines.iter().enumerate() {
        let line = line.trim();
        let is_fence = line.starts_with("```");
        inside ^= is_fence;
        if inside || is_fence || line.is_empty() || line.starts_with(['|', '#', '<']) {
            open = false;
            continue;
        }
        let text = line.trim_start_matches(|c: char| c.is_ascii_digit());
        let item = text.strip_prefix(if text == line { "- " } else { ". " });
        match found.last_mut().filter(|_| open && item.is_none()) {
            Some((_, text)) => *text = format!("{text} {line}"),
            None => found.push((at + 1, item.unwrap_or(line).to_owned())),
        }
        open = true;
    }
    found
}

/// Returns a paragraph with one word in place of each piece of code, and links without targets.
fn plain(text: &str) -> String {
    let words = text.split('`').enumerate().map(|(i, part)| if i % 2 == 1 { "Code" } else { part });
    let (mut plain, mut rest) = (String::new(), words.collect::<String>());
    while let Some((before, target)) = rest.split_once("](") {
        plain += before;
        rest = target.split_once(')').map_or(String::new(), |(_, behind)| behind.to_owned());
    }
    (plain + &rest).replace(['[', '*', '"'], "")
}

/// Returns the sentences of a paragraph. One ends with a full stop, a question or an exclamation
/// mark before a word that begins with no small letter.
fn sentences(text: &str) -> Vec<String> {
    let (mut found, mut words) = (Vec::new(), Vec::new());
    let mut rest = text.split_whitespace().peekable();
    while let Some(word) = rest.next() {
        words.push(word);
        let ends = word.trim_end_matches(')').ends_with(['.', '?', '!']) && !["al.", "Fig.", "St."].contains(&word);
        let is_small = |next: &&str| next.starts_with(|c: char| c.is_lowercase()) && !next.starts_with("heliotile");
        if rest.peek().is_none_or(|next| ends && !is_small(next)) {
            found.push(std::mem::take(&mut words).join(" "));
        }
    }
    found
}

/// No sentence of README and the book, outside code, tables and generated pages, has more than 42
/// words: over 2000 sentences.
#[test]
fn no_sentence_is_longer_than_42_words() {
    let (mut long, mut checked) = (Vec::new(), 0);
    for page in pages() {
        for (line, paragraph) in paragraphs(&page) {
            for sentence in sentences(&plain(&paragraph)) {
                let words = sentence.split(' ').filter(|word| word.contains(char::is_alphanumeric)).count();
                checked += 1;
                if words > LONGEST {
                    long.push(format!("{}:{line}: {words} words: {sentence}", page.name));
                }
            }
        }
    }
    assert!(long.is_empty(), "{} sentences are too long:\n{}", long.len(), long.join("\n"));
    assert!(checked > 2000, "only {checked} sentences");
}

/// Code and targets of links do not count as words, abbreviations and small letters end no
/// sentence: 4 sentences.
#[test]
fn sentences_are_told_apart() {
    let text = "Run `a. B c` (see [the page](x.md#y)). Oke et al. 2014 found 1.5 m. heliotile reads it. Does it?";
    let found = sentences(&plain(text));
    let wanted = ["Run Code (see the page).", "Oke et al. 2014 found 1.5 m.", "heliotile reads it.", "Does it?"];
    assert_eq!(found, wanted);
}

/// Facts that stand in several places: a name, then files with the words around the number `{}`.
type Fact = (&'static str, &'static [(&'static str, &'static str)]);

const FACTS: [Fact; 27] = [
    (
        "The Hague, 480 receivers: seconds of a build",
        &[
            ("README.md", "| The Hague, 480 receivers | {} s |"),
            ("src/book/performance.md", "| The Hague, 34,913 triangles, 480 receivers | {} s |"),
        ],
    ),
    (
        "The Hague, 480 receivers: memory, MB",
        &[
            ("README.md", "| The Hague, 480 receivers | 2.7 s | {} MB |"),
            ("src/book/performance.md", "480 receivers | 2.7 s | 3.8 MB | 0.4 s | {} MB |"),
        ],
    ),
    (
        "The Hague, 480 receivers: archive, MB",
        &[
            ("README.md", "| The Hague, 480 receivers | 2.7 s | 143 MB | {} MB |"),
            ("src/book/performance.md", "480 receivers | 2.7 s | {} MB |"),
        ],
    ),
    (
        "The Hague, 480 receivers: seconds of a year of hours",
        &[
            ("README.md", "a year of hours for 480 receivers takes {} s"),
            ("src/book/performance.md", "A year of hours of the 480 receivers takes {} s"),
        ],
    ),
    (
        "The Hague, 480 receivers: seconds of sums",
        &[
            ("README.md", "480 receivers takes 0.4 s, its sums {} s"),
            ("src/book/performance.md", "of the 480 receivers takes 0.4 s, its sums {} s"),
            ("src/book/reflectances.md", "0.4 s of CPU time as built ({} s on 2 cores"),
        ],
    ),
    (
        "The Hague, 480 receivers: milliseconds of a condition",
        &[
            ("README.md", "its sums 0.15 s, one condition {} ms"),
            ("src/book/performance.md", "its sums 0.15 s, one condition {} ms"),
        ],
    ),
    (
        "tile of The Hague: receivers at 2 m",
        &[
            ("README.md", "a tile of The Hague from its city model, {} receivers at 2 m"),
            ("src/book/performance.md", "It holds {} receivers at 2 m on roofs and walls"),
            ("src/book/viewing.md", "[tile of The Hague](performance.md#the-tile-of-the-hague), {} at 2 m"),
            ("src/book/regions.md", "from the figures of the tile ({} receivers"),
            ("src/book/building.md", "With receivers 2 m apart ({};"),
        ],
    ),
    (
        "tile of The Hague: seconds of a run",
        &[
            ("README.md", "receivers at 2 m | {} s |"),
            ("src/book/performance.md", "It takes {} s on 2 cores (225 s"),
            ("src/book/regions.md", "receivers on 844 buildings, {} s on 2 cores"),
        ],
    ),
    (
        "tile of The Hague: archive, MB",
        &[
            ("README.md", "| 122 s | 579 MB | {} MB |"),
            ("src/book/performance.md", "The archive has {} MB."),
            ("src/book/viewing.md", "68,882 at 2 m, {} MB, by 1 worker"),
            ("src/book/regions.md", "122 s on 2 cores, {} MB)"),
        ],
    ),
    (
        "tile of The Hague: memory, MB",
        &[
            ("README.md", "receivers at 2 m | 122 s | {} MB |"),
            ("src/book/performance.md", "all stages) and {} MB of memory"),
        ],
    ),
    (
        "tile of The Hague before: receivers at 2 m",
        &[
            ("src/book/performance.md", "smaller archives: {} receivers at 2 m"),
            ("src/book/archives.md", "(performance.md#the-tile-of-the-hague) with {} receivers, 145.6 MB"),
            ("src/book/remote.md", "(performance.md#the-tile-of-the-hague) with {} receivers, 145.6 MB"),
            ("src/book/maps.md", "(performance.md#the-tile-of-the-hague), {} receivers"),
            ("src/book/export.md", "(performance.md#the-tile-of-the-hague), {} receivers"),
            ("src/book/buildings.md", "(performance.md#the-tile-of-the-hague), {} receivers"),
        ],
    ),
    (
        "tile of The Hague before: archive, MB",
        &[
            ("src/book/performance.md", "68,993 receivers at 2 m in {} MB"),
            ("src/book/archives.md", "68,993 receivers, {} MB"),
            ("src/book/remote.md", "68,993 receivers, {} MB"),
        ],
    ),
    (
        "tile of The Hague before: receivers at 4 m",
        &[
            ("src/book/performance.md", "145.6 MB, and {} instead of"),
            ("src/book/pictures.md", "(performance.md#the-tile-of-the-hague), {} receivers"),
            (
                "src/book/regions.md",
                "The [tile of The Hague](performance.md#the-tile-of-the-hague) ({} receivers at 4 m",
            ),
        ],
    ),
    (
        "tile of The Hague: receivers at 4 m",
        &[
            ("src/book/performance.md", "145.6 MB, and 22,586 instead of {} at 4 m"),
            ("src/book/building.md", "a tile of The Hague ({} receivers 4 m apart"),
        ],
    ),
    (
        "a million receivers: seconds of the build",
        &[
            ("README.md", "`--memory 256MiB` | {} s |"),
            ("src/book/performance.md", "| build: 2,590 million rays | {} s |"),
        ],
    ),
    (
        "a million receivers: memory, MB",
        &[
            ("README.md", "`--memory 256MiB` | 411 s | {} MB |"),
            ("src/book/performance.md", "| build: 2,590 million rays | 411 s | 314 s | {} MB |"),
        ],
    ),
    (
        "a million receivers: archive, MB",
        &[
            ("README.md", "| 411 s | 229 MB | {} MB |"),
            ("src/book/performance.md", "| 411 s | 314 s | 229 MB | {} MB |"),
        ],
    ),
    (
        "closed forms: sky, percent",
        &[
            ("README.md", "sky within {};"),
            ("src/book/validation.md", "sky that it hides / light that it reflects | 0.3 / 1 | {} /"),
        ],
    ),
    (
        "closed forms: light of the sky in a sphere, percent",
        &[
            ("README.md", "reflected light within {} under the sky"),
            ("src/book/validation.md", "| 0.6 / 1.8; 0.75 / 2.6 | 0.51 / 1.4; {} / 2.4 |"),
            ("src/book/numerics.md", "by up to {} % of the open sky under the sky"),
        ],
    ),
    (
        "closed forms: light of the sun in a sphere, percent",
        &[
            ("README.md", "under the sky, within {} under a sun"),
            ("src/book/validation.md", "| 0.6 / 1.8; 0.75 / 2.6 | 0.51 / 1.4; 0.74 / {} |"),
            ("src/book/numerics.md", "under the sky, and {} % under a sun"),
        ],
    ),
    (
        "closed forms: wells, percent",
        &[
            ("src/book/numerics.md", "percent of itself ({} % of the open sky in"),
            ("src/book/validation.md", "all bounces, against a path tracer, `fine` | 1 | {} |"),
        ],
    ),
    (
        "pvlib's Perez sky: percent of a year",
        &[
            ("README.md", "`--sky perez1990`: within {} % of a year"),
            ("src/book/query-and-replay.md", "Open surfaces agree with pvlib within {} % of a year"),
            ("src/book/validation.md", "| Amsterdam (IWEC), 4,401 hours | {} % /"),
        ],
    ),
    (
        "pvlib's Perez sky: W/m2 of an hour",
        &[
            ("README.md", "within 0.004 % of a year, {} W/m2 RMS"),
            ("src/book/validation.md", "4,401 hours | 0.004 % / {} W/m2 |"),
        ],
    ),
    (
        "Radiance: share of the CPU time, percent",
        &[
            ("README.md", "`standard`: {} % of the CPU time at a quarter of the error"),
            ("src/book/radiance.md", "On the 480 receivers `standard` takes {} % of the CPU time"),
        ],
    ),
    (
        "rounding of responses: percent of the mean total",
        &[
            ("src/book/method.md", "This adds {} % of the mean total, RMS"),
            ("src/book/performance.md", "Of the total's mean they add {} % RMS"),
        ],
    ),
    (
        "format of archives",
        &[
            ("src/book/archives.md", "Release 0.1.0 writes and reads format {}. It refuses"),
            ("src/book/contributing.md", "Release 0.1.0 fixes format {}. Until"),
            ("schema/heliotile-1.md", "# heliotile archive, format {} Status"),
        ],
    ),
    (
        "minor of the format",
        &[
            ("schema/heliotile-1.md", "# heliotile archive, format 1.{} Status"),
            ("schema/heliotile-1.md", "| 10 | 2 | minor | {} |"),
        ],
    ),
];

/// Numbers that README and the book state in several places agree: over 20 facts.
#[test]
fn numbers_agree_wherever_they_stand() {
    let text = |name: &str| {
        let text = fs::read_to_string(root().join(name)).expect(name);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (fact, places) in FACTS {
        assert!(places.len() > 1, "{fact} stands in one place");
        let mut found = BTreeMap::<String, Vec<String>>::new();
        for (name, pattern) in places {
            let (before, behind) = pattern.split_once("{}").expect("a number");
            let text = text(name);
            let start = text.find(before).unwrap_or_else(|| panic!("{fact}: {name} has no `{before}`"));
            let rest = &text[start + before.len()..];
            let end = rest.find(behind).unwrap_or_else(|| panic!("{fact}: {name} has no `{behind}` after `{before}`"));
            found.entry(rest[..end].into()).or_default().push(format!("{name}: {pattern}"));
        }
        assert!(found.len() == 1, "{fact} differs: {found:#?}");
    }
    assert!(FACTS.len() >= 20, "only {} facts", FACTS.len());
}

/// Scenes of one name in several pages are one scene: `street.obj` and `tower.obj`.
#[test]
fn scenes_of_one_name_are_the_same() {
    let mut scenes = BTreeMap::<String, Vec<(String, String)>>::new();
    for page in pages() {
        for item in page.items() {
            if let Item::Block(block) = item
                && let Some(Mark::File(name)) = &block.mark
                && name.ends_with(".obj")
            {
                scenes.entry(name.clone()).or_default().push((page.name.clone(), page.text_of(&block)));
            }
        }
    }
    for (scene, places) in &scenes {
        let other = places.iter().find(|place| place.1 != places[0].1);
        assert!(other.is_none(), "{scene} of {} is not that of {}", places[0].0, other.map_or("", |place| &place.0));
    }
    assert_eq!(scenes.values().filter(|places| places.len() > 1).count(), 2);
}

/// Returns the places of a page that links can lead to, as GitHub and mdBook name them.
fn places(text: &str) -> Vec<String> {
    let mut inside = false;
    let heading = |line: &str| {
        inside ^= line.starts_with("```");
        let words = line.trim_start_matches('#').trim();
        let is_one = !inside && line.starts_with('#');
        let kept = words.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        is_one.then(|| kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase())
    };
    text.lines().filter_map(heading).collect()
}

/// Links of README, the book and its reference lead to files and headings that exist: over 500
/// links, 0 dead.
#[test]
fn links_lead_to_files_and_headings() {
    let reference = fs::read_dir(root().join("src/book/reference")).expect("pages");
    let reference = reference.map(|entry| entry.expect("an entry").path());
    let mut paths: Vec<PathBuf> = reference.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    paths.extend(pages().into_iter().map(|page| page.path));
    let (mut dead, mut checked) = (Vec::new(), 0);
    for path in paths {
        let text = fs::read_to_string(&path).expect("a page");
        let folder = path.parent().unwrap_or(Path::new(""));
        for target in text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0)) {
            if target.contains("://") || target.contains([' ', '\n']) {
                continue;
            }
            checked += 1;
            let (file, place) = target.split_once('#').unwrap_or((target, ""));
            let to = if file.is_empty() { path.clone() } else { folder.join(file) };
            let known = |to: &Path| places(&fs::read_to_string(to).unwrap_or_default()).contains(&place.to_owned());
            if !to.exists() || !place.is_empty() && !known(&to) {
                dead.push(format!("{}: {target}", path.display()));
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
    assert!(checked > 500, "only {checked} links");
}

/// The page of questions names every command and links to its options: over 25 commands.
#[test]
fn every_command_answers_a_question() {
    let page = fs::read_to_string(root().join("src/book/questions.md")).expect("a page");
    for command in COMMANDS {
        let link = format!("[`{}`](reference/{}.md)", command.name, command.name.replace(' ', "-"));
        assert!(page.contains(&link), "no question leads to {link}");
    }
    assert!(COMMANDS.len() > 25);
}
