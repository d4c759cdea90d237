//! House rules for the messages of the library.

use std::path::Path;

use heliotile::cases::COMMANDS;

use crate::tidy::sources;

/// Rooms whose messages the program, Python and the page show, each in its own words.
const OF_ALL_FACES: [&str; 13] = [
    "src/core",
    "src/weather",
    "src/comfort",
    "src/sunlight",
    "src/files",
    "src/archives",
    "src/scene",
    "src/builder",
    "src/remote",
    "src/results",
    "src/studies",
    "src/atlas",
    "src/energyplus",
];

/// A string literal in the code.
struct Literal<'a> {
    line: usize,
    text: &'a str,
    /// Code in front of the literal.
    before: &'a str,
    /// Code behind the literal.
    behind: &'a str,
}

impl Literal<'_> {
    /// Returns true if braces in the literal are places of values, and doubled ones mean braces.
    fn is_format(&self) -> bool {
        let to = |c: char| c.is_alphanumeric() || "_.&*".contains(c);
        let before = self.before.trim_end();
        let start = before.strip_suffix(',').map_or(before, |written| written.trim_end_matches(to).trim_end());
        start.ends_with("!(")
    }

    /// Returns true if names in the literal are lost: it becomes a `String`, which names nothing.
    fn loses_names(&self) -> bool {
        let behind = self.behind.trim_start();
        let is_owned = [".to_owned()", ".to_string()"].iter().any(|owned| behind.starts_with(owned));
        is_owned || self.is_format() && !self.before.trim_end().ends_with("message!(")
    }

    /// Returns the names in braces, for each face to say in its own words: fields of requests, and
    /// `command:` with the name of one.
    fn named(&self) -> impl Iterator<Item = &str> {
        let (open, close) = if self.is_format() { ("{{", "}}") } else { ("{", "}") };
        let names = self.text.split(open).skip(1).filter_map(move |behind| Some(behind.split_once(close)?.0));
        let is_name = |name: &&str| {
            let (words, other) = name.strip_prefix("command:").map_or((*name, "_"), |words| (words, " -"));
            !words.is_empty() && words.chars().all(|c| c.is_ascii_lowercase() || other.contains(c))
        };
        names.filter(is_name)
    }
}

/// Returns the string literals of a file, without those in comments.
fn literals(code: &str) -> Vec<Literal<'_>> {
    let (mut found, mut at) = (Vec::new(), 0);
    let bytes = code.as_bytes();
    while at < code.len() {
        let rest = &code[at..];
        let hashes = rest.strip_prefix('r').map_or(0, |raw| raw.len() - raw.trim_start_matches('#').len());
        let end = if rest.starts_with("//") {
            rest.find('\n')
        } else if rest.starts_with("/*") {
            rest.find("*/")
        } else if hashes > 0 && rest[1 + hashes..].starts_with('"') {
            rest[2 + hashes..].find(&format!("\"{}", "#".repeat(hashes))).map(|length| 2 + hashes + length + hashes)
        } else if let Some(inside) = rest.strip_prefix('"') {
            let mut escaped = false;
            let ends = |c: char| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            };
            inside.find(ends).map(|length| 1 + length)
        } else if rest.starts_with('\'') && bytes.get(at + 1) == Some(&b'\\') {
            rest[3..].find('\'').map(|length| 3 + length)
        } else if rest.starts_with('\'') && rest.chars().nth(2) == Some('\'') {
            Some(rest.chars().take(2).map(char::len_utf8).sum())
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
            continue;
        };
        let end = at + end.unwrap_or(rest.len() - 1) + 1;
        let text = &code[at..end.min(code.len())];
        if text.starts_with(['"', 'r']) {
            let (before, behind) = (&code[..at], code.get(end..).unwrap_or_default());
            found.push(Literal { line: before.matches('\n').count() + 1, text, before, behind });
        }
        at = end;
    }
    found
}

/// Returns true if a text holds an option, as in `give --every month`.
fn names_option(text: &str) -> bool {
    let starts = text.match_indices("--").filter(|(at, _)| {
        let apart = text[..*at].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '-');
        apart && text[at + 2..].starts_with(|c: char| c.is_ascii_lowercase())
    });
    starts.count() > 0
}

/// Returns true if a text holds a command, as in `see heliotile info`; names of formats begin with
/// the program's name.
fn names_command(text: &str) -> bool {
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_ascii_lowercase());
    let is_named = |behind: &str| COMMANDS.iter().any(|command| behind.strip_prefix(command.name).is_some_and(ends));
    text.match_indices("heliotile ").any(|(at, found)| at > 1 && is_named(&text[at + found.len()..]))
}

/// Returns true for a command of the program as it is typed, with or without an option of it.
fn is_command(words: &str) -> bool {
    let (name, option) = words.split_once(" --").map_or((words, None), |(name, option)| (name, Some(option)));
    let command = COMMANDS.iter().find(|command| command.name == name);
    command.is_some_and(|command| {
        option.is_none_or(|option| (command.rows)().iter().any(|row| row.name.replace('_', "-") == option))
    })
}

/// Messages of the library name fields of requests, and each face names its own options: of over
/// 3000 texts none holds an option or a command of the program, over 100 names in braces are those
/// of options or commands, and over 10 refused arguments are fields.
#[test]
fn the_library_names_no_option() {
    let (mut checked, mut names, mut arguments) = (0, 0, 0);
    let root = Path::new(crate::ROOT);
    for (path, text) in sources() {
        let of_tests = path.file_stem().is_some_and(|name| name.to_string_lossy().contains("test"));
        if of_tests || !OF_ALL_FACES.iter().any(|room| path.starts_with(root.join(room))) {
            continue;
        }
        let shipped = text.split("mod tests {").next().unwrap_or_default();
        for literal in literals(shipped) {
            let at = || format!("{}:{}: {}", path.display(), literal.line, literal.text);
            // Command lines of other programs are allowed.
            let of_others =
                ["cargo build", "`aws ", "\"--version\""].iter().any(|program| literal.text.contains(program));
            let own: String =
                literal.text.split("{command:").map(|part| part.split_once('}').map_or(part, |rest| rest.1)).collect();
            assert!(of_others || !names_option(&own), "an option, name the field in braces: {}", at());
            assert!(!names_command(literal.text), "a command, write {{command:name}}: {}", at());
            for name in literal.named() {
                let known = match name.strip_prefix("command:") {
                    Some(command) => is_command(command),
                    None => heliotile_program::option_of(name).is_some(),
                };
                assert!(known, "no option and no command is {name}: {}", at());
                assert!(!literal.loses_names(), "names are lost, use message! or a `&'static str`: {}", at());
                names += 1;
            }
            if literal.before.trim_end().ends_with("Error::argument(") {
                let fields = literal.text.trim_matches('"').split(", ");
                fields.for_each(|field| {
                    assert!(heliotile_program::option_of(field).is_some(), "no option fills {field}: {}", at())
                });
                arguments += 1;
            }
            checked += 1;
        }
    }
    assert!((checked, names, arguments) > (3000, 0, 0), "{checked} texts");
    assert!(names > 100 && arguments > 10, "{names} names, {arguments} arguments");
}

/// The scanner of texts finds 4 of 4 among comments, quotes and letters, and tells an option and a
/// command from similar texts.
#[test]
fn texts_are_found() {
    let code = "// \"no\"\nlet c = '\"'; /* \"no\" */ f('\\'', \"a \\\" b\");\nformat!(\"{a} {{every}}\");\nwrite!(f, \"{{on}}\"); &'a r#\"{year} \"x\"#";
    let found = literals(code);
    assert_eq!(found.iter().map(Literal::loses_names).collect::<Vec<_>>(), [false, true, true, false]);
    let texts: Vec<(usize, &str)> = found.iter().map(|literal| (literal.line, literal.text)).collect();
    assert_eq!(texts, [(2, "\"a \\\" b\""), (3, "\"{a} {{every}}\""), (4, "\"{{on}}\""), (4, "r#\"{year} \"x\"#")]);
    assert_eq!(found.iter().flat_map(Literal::named).collect::<Vec<_>>(), ["every", "on", "year"]);
    assert!(names_option("\"give --every month\"") && names_option("\"--set\"") && !names_option("\"a -- b---c\""));
    assert!(names_command("\"see `heliotile info`\"") && !names_command("\"heliotile receivers 1\""));
}
