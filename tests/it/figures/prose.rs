//! Prose of README and the book. In: pages. Out: sentences that are too long, numbers that disagree,
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

/// Of over 3000 sentences of README and the book, outside code, tables and generated pages, 0 have
/// more than 42 words.
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
    assert!(checked > 3000, "only {checked} sentences");
}

/// Code and targets of links do not count as words, abbreviations and small letters end no
/// sentence: 4 sentences.
#[test]
fn sentences_are_told_apart() {
    let text = "Run `a. B c` (see [the page](x.md#y)). Oke et al. 2014 found 1.5 m. heliotile reads it. Does it?";
    let found = sentences(&plain(text));
    let wanted =
        ["Run Code (see the page).", "Oke et al. 2014 found 1.5 m.", "heliotile reads it.", "Does it?"];
    assert_eq!(found, wanted);
}

/// Facts that stand in several places: a name, then files with the words around the number `{}`.
type Fact = (&'static str, &'static [(&'static str, &'static str)]);

const FACTS: [Fact; 0] = [];

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

/// Links of README, the book and its reference lead to files and headings that exist: over 700
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
    assert!(checked > 700, "only {checked} links");
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
