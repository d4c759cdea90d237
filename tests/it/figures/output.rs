//! Comparison of lines of a page with printed lines. In: the lines of the page, the lines that a
//! command printed. Out: the first line that differs, and the lines as they should be.
//!
//! `...` alone stands for any lines, at the end of a line for the rest of it. Lines printed before
//! the first line and after the last one do not count, nor do spaces and times: see [`words`].

/// Result of a comparison.
pub struct Compared {
    /// The first line that differs, and the printed line.
    pub wrong: Option<String>,
    /// The lines, with the printed line in place of each line that differs.
    pub now: Vec<String>,
}

/// Stands for a time, which is not compared.
const TIME: &str = "#";

/// Returns the words of a line without its times: numbers before `s`, `ms` and `threads`, the
/// stages of a build, cells below `seconds`.
fn words(line: &str, seconds: Option<usize>) -> Vec<String> {
    if line.contains(" s: tree ") {
        return vec![TIME.into()];
    }
    let mut found: Vec<(usize, &str)> = Vec::new();
    let mut at = 0;
    for part in line.split_whitespace() {
        let start = line[at..].find(part).map_or(at, |offset| at + offset);
        at = start + part.len();
        found.push((at, part));
    }
    let is_number = |word: &str| word.trim_matches(|c| "(),;".contains(c)).parse::<f64>().is_ok();
    let is_time = |i: usize| {
        let next = found.get(i + 1).map_or("", |next| next.1.trim_end_matches(|c| ":,;.)".contains(c)));
        is_number(found[i].1) && (["s", "ms", "threads", "thread"].contains(&next) || seconds == Some(found[i].0))
    };
    (0..found.len()).map(|i| if is_time(i) { TIME.into() } else { found[i].1.to_string() }).collect()
}

/// Returns where the word `seconds` ends, if a line is the head of a table with this column.
fn seconds_of(line: &str) -> Option<usize> {
    line.find("  seconds  ").map(|start| start + "  seconds".len())
}

/// Returns the part of a line that is compared, and true if more may follow.
fn shown(line: &str) -> (&str, bool) {
    match line.trim_end().strip_suffix("...") {
        Some(rest) => (rest.trim_end(), true),
        None => (line, false),
    }
}

fn agree(wanted: &str, printed: &str, seconds: Option<usize>) -> bool {
    let (shown, more) = shown(wanted);
    let (wanted, printed) = (words(shown, seconds), words(printed, seconds));
    if !more {
        return wanted == printed;
    }
    let joined = |words: &[String]| words.join(" ");
    joined(&printed).starts_with(&joined(&wanted))
}

/// Returns the likeness of two lines: the number of words in common, where those without digits
/// count more.
fn likeness(a: &str, b: &str) -> usize {
    let (a, b) = (words(a, None), words(b, None));
    let weight = |word: &String| if word.contains(|c: char| c.is_ascii_digit()) { 1 } else { 4 };
    a.iter().zip(&b).filter(|(a, b)| a == b).map(|(a, _)| weight(a)).sum()
}

/// Compares the lines of a block with printed lines.
pub fn compare(block: &[String], printed: &str) -> Compared {
    let warns = |line: &str| line.starts_with("warning: ");
    // Warnings, on the other stream, are compared where a page shows them.
    let shows_warnings = block.iter().any(|line| warns(line));
    let is_shown = |line: &&str| !line.trim().is_empty() && (shows_warnings || !warns(line));
    let printed: Vec<&str> = printed.lines().filter(is_shown).collect();
    let (mut next, mut gap, mut seconds) = (0, true, None);
    let mut compared = Compared { wrong: None, now: Vec::new() };
    for line in block {
        if line.trim() == "..." || line.trim().is_empty() {
            gap |= line.trim() == "...";
            compared.now.push(line.clone());
            continue;
        }
        seconds = seconds_of(line).or(seconds);
        let rest = &printed[next.min(printed.len())..];
        let reach = if gap { rest.len() } else { rest.len().min(1) };
        let place = rest[..reach].iter().position(|printed| agree(line, printed, seconds));
        // If no line agrees, the line that is most like it is taken for the one that should stand
        // here.
        let like = || (0..reach).max_by_key(|&i| (likeness(line, rest[i]), usize::MAX - i));
        let Some(at) = place.or_else(like) else {
            compared.wrong.get_or_insert_with(|| format!("`{line}` is not printed"));
            compared.now.push(line.clone());
            continue;
        };
        if place.is_none() {
            compared.wrong.get_or_insert_with(|| format!("`{line}`\n  printed: `{}`", rest[at]));
            compared.now.push(cut(rest[at], line));
        } else {
            compared.now.push(line.clone());
        }
        (next, gap) = (next + at + 1, false);
    }
    compared
}

/// Cuts a printed line behind as many fields or words as are shown of the line that it replaces.
fn cut(printed: &str, before: &str) -> String {
    let (shown, more) = shown(before);
    let fields = shown.matches(',').count();
    match more {
        false => printed.into(),
        true if shown.ends_with(',') => {
            printed.split(',').take(fields).map(|field| format!("{field},")).collect::<String>() + "..."
        }
        true => {
            let words: Vec<&str> = printed.split_whitespace().take(shown.split_whitespace().count()).collect();
            format!("{} ...", words.join(" "))
        }
    }
}

fn block(text: &str) -> Vec<String> {
    text.lines().map(String::from).collect()
}

/// Spaces, lines that are left out and times do not count; a number that differs does, and the new
/// block holds it: 4 cases.
#[test]
fn lines_are_compared_without_times() {
    let printed = "noise\n  1.5 s: tree 0.1, cells 2\nroof  12  0.31 s\nwall  13\n\nall,1,2,3\nend\n";
    let same = |text: &str| compare(&block(text), printed).wrong.is_none();
    assert!(same("9.9 s: tree 7\nroof 12 0.5 s\n...\nall,1,..."));
    assert!(same("wall 13\nall,1,2,3"));
    assert!(!same("roof 12 0.5 s\nall,1,2,3"));
    let other = compare(&block("wall    14\n...\nall,1,9,..."), printed);
    assert_eq!((other.now.join("\n").as_str(), other.wrong.is_some()), ("wall  13\n...\nall,1,2,...", true));
}

/// Cells below `seconds` do not count, cells beside it do.
#[test]
fn columns_of_seconds_do_not_count() {
    let table = |rays: &str, seconds: &str| format!("effect  rays  seconds  why\nsun      {rays}      {seconds}  -\n");
    let differs = |a: &str, b: &str| compare(&block(a), b).wrong.is_some();
    assert!(!differs(&table("1.5", "0.2"), &table("1.5", "0.7")));
    assert!(differs(&table("1.5", "0.2"), &table("1.6", "0.2")));
}
