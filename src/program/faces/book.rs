//! Reference pages of the book, one a command. In: the commands. Out: pages, and the module that
//! names them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use heliotile::cases::{Aim, COMMANDS, Command};
use heliotile::requests::{GroupKind, Many, Row};

use super::{MADE, help};

/// Folder of the pages.
pub const FOLDER: &str = "src/book/reference";

/// Returns all pages by their paths.
pub fn pages() -> BTreeMap<PathBuf, String> {
    let folder = PathBuf::from(FOLDER);
    let mut pages: BTreeMap<PathBuf, String> =
        COMMANDS.iter().map(|command| (folder.join(format!("{}.md", file_of(command))), page(command))).collect();
    pages.insert(folder.join("mod.rs"), module());
    pages.insert(folder.join("commands.md"), list());
    pages
}

fn file_of(command: &Command) -> String {
    command.name.replace(' ', "-")
}

fn module() -> String {
    let line = |command: &Command| format!("    {} = \"{}.md\",\n", command.name.replace(' ', "_"), file_of(command));
    let lines: String = COMMANDS.iter().map(line).collect();
    format!("// {MADE}\n#![doc = include_str!(\"commands.md\")]\n\npages! {{\n{lines}}}\n")
}

fn list() -> String {
    let mut text = format!("<!-- {MADE} -->\n# Commands and their options\n");
    for (aim, heading) in Aim::ALL {
        let _ = write!(text, "\n## {heading}\n\n| command | |\n| --- | --- |\n");
        for command in COMMANDS.iter().filter(|command| command.aim == aim) {
            let (name, about) = (command.name, command.about.replace('|', "\\|"));
            let _ = writeln!(text, "| [`{name}`]({}.md) | {about} |", file_of(command));
        }
    }
    text
}

fn page(command: &Command) -> String {
    let mut text = format!("<!-- {MADE} -->\n# heliotile {}\n\n{}.\n", command.name, command.about);
    let rows = (command.rows)();
    let mut headings: Vec<Option<&str>> = Vec::new();
    for row in &rows {
        if !headings.contains(&row.heading) {
            headings.push(row.heading);
        }
    }
    for heading in headings {
        if let Some(heading) = heading {
            let _ = write!(text, "\n## {heading}\n");
        }
        let _ = write!(text, "\n| option | Python | |\n| --- | --- | --- |\n");
        rows.iter().filter(|row| row.heading == heading).for_each(|row| line(&mut text, row));
    }
    let known = |name: &&&str| rows.iter().any(|row| row.name == **name);
    for group in (command.groups)() {
        let names: Vec<String> = group.names.iter().filter(known).map(|name| option(name)).collect();
        if names.len() > 1 {
            let rule = match group.kind {
                GroupKind::ExactlyOne => "Exactly one of these is given",
                GroupKind::AtMostOne => "At most one of these is given",
                GroupKind::AnyOf => "At least one of these is given",
            };
            let _ = write!(text, "\n{rule}: {}.\n", names.join(", "));
        }
    }
    text
}

fn option(name: &str) -> String {
    format!("`--{}`", name.replace('_', "-"))
}

fn line(text: &mut String, row: &Row) {
    let shown = row.metavar.map_or_else(|| row.name.to_uppercase(), str::to_owned);
    let long = format!("--{}", row.name.replace('_', "-"));
    let typed = match (row.many, row.positional) {
        (Many::Flag, _) => format!("`{long}`"),
        (_, true) => format!("`{shown}`"),
        _ => format!("`{long} {shown}`"),
    };
    let short = row.short.map_or(String::new(), |letter| format!(", `-{letter}`"));
    let mut about = help(row, &|name| format!("`--{name}`"));
    for (name, meaning) in (row.form.choices)() {
        let _ = write!(about, " `{name}`{}", if meaning.is_empty() { ".".into() } else { format!(": {meaning}.") });
    }
    if !row.conflicts.is_empty() && row.conflicts.len() < 8 {
        let names: Vec<String> = row.conflicts.iter().map(|name| option(name)).collect();
        let _ = write!(about, " Not with {}.", names.join(", "));
    }
    if !row.requires.is_empty() {
        let names: Vec<String> = row.requires.iter().map(|name| option(name)).collect();
        let _ = write!(about, " Only with {}.", names.join(" or "));
    }
    let python = row.in_python();
    let _ = writeln!(text, "| {}{short} | `{python}` | {} |", typed.replace('|', "\\|"), about.replace('|', "\\|"));
}
