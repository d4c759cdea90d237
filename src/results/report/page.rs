//! HTML of a statement. In: tables with their summaries and pictures. Out: one text, without
//! scripts, whose every word from a file is escaped.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use heliotile_core::text::counted;
use serde_json::Value;

use super::digest::{ColumnDigest, TableDigest};
use super::facts::{facts, object, question, value, words};
use super::{Picture, Section};
use crate::outputs::markup::escaped;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::csvw::DescribedColumn;

/// Style of the page, on the screen and on paper.
const STYLE: &str = include_str!("report.css");

/// Columns of positions and directions, which a statement leaves out.
const POSITIONS: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

/// Most columns that fit on upright paper, and most of these that name rows.
const COLUMNS: usize = 9;
const KEYS: usize = 2;

/// Rows above those of a table.
const RANGES: [&str; 3] = ["least", "mean", "greatest"];

/// Most letters of a word that lines do not break in.
const LONG_WORD: usize = 16;

/// Appends text to the page.
macro_rules! put {
    // Writing to a string cannot fail.
    ($out:ident, $($part:tt)*) => { let _ = write!($out, $($part)*); };
}

/// Returns the page; `about` states how it was requested.
pub fn html(title: Option<&str>, sections: &[Section], about: &Provenance) -> String {
    let mut out = String::new();
    let first = sections.first().map_or("", |section| question(&section.table, &section.digest));
    let heading = escaped(title.unwrap_or(first));
    put!(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    let allowed = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
    put!(out, "<meta http-equiv=\"Content-Security-Policy\" content=\"{allowed}\">\n");
    put!(out, "<title>{heading}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{heading}</h1>\n");
    for rule in sections.iter().flat_map(|section| &section.digest.rules) {
        put!(out, "<p class=\"verdict\">{}</p>\n", escaped(&rule.text()));
    }
    for (number, section) in sections.iter().enumerate() {
        // The first question is the title, if no other is given.
        put_section(&mut out, section, title.is_some() || number > 0);
    }
    let command = about.entries().into_iter().find(|(name, _)| name.ends_with(".command"));
    let command = command.map_or(String::new(), |(_, command)| escaped(&command));
    let version = env!("CARGO_PKG_VERSION");
    put!(out, "<footer>Page by heliotile {version}: <code>{command}</code></footer>\n</body>\n</html>\n");
    out
}

fn put_section(out: &mut String, section: &Section, has_heading: bool) {
    let Section { table, digest, pictures } = section;
    put!(out, "<section>\n");
    if has_heading {
        put!(out, "<h2>{}</h2>\n", question(table, digest));
    }
    put!(out, "<dl>\n");
    for fact in facts(table, digest) {
        put!(out, "<dt>{}</dt><dd>{}</dd>\n", fact.subject, escaped(&fact.text));
    }
    put!(out, "</dl>\n");
    pictures.iter().for_each(|picture| put_picture(out, picture));
    put_table(out, section);
    put_check(out, section);
    put!(out, "</section>\n");
}

fn put_picture(out: &mut String, picture: &Picture) {
    let hash = blake3::hash(&picture.bytes).to_hex();
    put!(out, "<figure><img alt=\"\" src=\"data:{};base64,", picture.media);
    BASE64_STANDARD.encode_string(&picture.bytes, out);
    let name = escaped(&picture.file.to_string_lossy());
    put!(out, "\"><figcaption>{name}, BLAKE3 <code>{hash}</code></figcaption></figure>\n");
}

/// Column of a table with its summary.
#[derive(Clone, Copy)]
struct PageColumn<'a> {
    /// Place in the table.
    place: usize,
    column: &'a DescribedColumn,
    of: &'a ColumnDigest,
}

impl PageColumn<'_> {
    fn is_number(&self) -> bool {
        self.column.datatype == "number"
    }

    /// Returns true for positions, and for names that begin the name of the place.
    fn is_hidden(&self) -> bool {
        POSITIONS.contains(&self.column.name.as_str()) || self.of.varies && self.of.is_in_name
    }

    fn class(&self) -> &'static str {
        match self.column.datatype.as_str() {
            Some("number") => " class=\"n\"",
            Some("string") => "",
            _ => " class=\"time\"",
        }
    }

    /// Returns true if the column has a least and a greatest number. A mean of directions means
    /// nothing.
    fn has_range(&self) -> bool {
        self.of.varies && self.of.range.is_some() && self.column.unit != "deg"
    }

    /// Returns the number in row `which` of [`RANGES`].
    fn range(&self, which: usize) -> Option<String> {
        let [least, greatest] = self.of.range.as_ref().filter(|_| self.has_range())?;
        [Some(least.clone()), self.of.mean(), Some(greatest.clone())].into_iter().nth(which).flatten()
    }
}

/// Writes the columns whose values differ among rows; the others are stated above them.
fn put_table(out: &mut String, section: &Section) {
    let Section { table, digest, .. } = section;
    let all = table.columns.iter().zip(&digest.columns).enumerate();
    let all: Vec<PageColumn> = all.map(|(place, (column, of))| PageColumn { place, column, of }).collect();
    let is_same = |one: &PageColumn| digest.rows > 1 && !one.of.varies && one.column.name != "verdict";
    let (hidden, rest): (Vec<_>, Vec<_>) = all.iter().copied().partition(PageColumn::is_hidden);
    let (same, mut shown): (Vec<_>, Vec<_>) = rest.iter().copied().partition(is_same);
    if shown.is_empty() {
        shown.extend(all.first());
    }
    let (empty, same): (Vec<_>, Vec<_>) = same.into_iter().partition(|one| one.of.first.is_empty());
    let with_value = |one: &PageColumn| format!("{} {} {}", one.column.name, one.of.first, one.column.unit);
    let same: Vec<String> = same.iter().map(|one| with_value(one).trim_end().to_owned()).collect();
    let hidden: Vec<&str> = hidden.iter().chain(&empty).map(|one| one.column.name.as_str()).collect();
    let lines = [("The same in all rows that have a value", same.join("; ")), ("Not shown", hidden.join(", "))];
    for (words, names) in lines.iter().filter(|(_, names)| !names.is_empty()) {
        put!(out, "<p class=\"note\">{words}: {}.</p>\n", escaped(names));
    }
    let left_out = digest.rows - digest.shown.len() as u64;
    if left_out > 0 {
        let (rows, all) = (counted(digest.shown.len() as u64, "row"), digest.rows);
        put!(out, "<p class=\"note\"><strong>{rows} of {all} are shown, {left_out} are left out.</strong></p>\n");
    }
    // Each part of a wide table begins with the columns that name its rows.
    let keys = shown.iter().take_while(|one| !one.is_number()).count().clamp(1, KEYS);
    let (keys, values) = shown.split_at(keys.min(shown.len()));
    let count = values.len().div_ceil(COLUMNS - keys.len()).max(1);
    let parts: Vec<&[PageColumn]> = match values.chunks(values.len().div_ceil(count).max(1)).collect::<Vec<_>>() {
        none if none.is_empty() => vec![&[]],
        parts => parts,
    };
    for (number, part) in parts.iter().enumerate() {
        if parts.len() > 1 {
            put!(out, "<p class=\"note\">Columns, part {} of {}:</p>\n", number + 1, parts.len());
        }
        put_part(out, digest, keys, part);
    }
}

/// Writes some columns of a table, behind those that name its rows.
fn put_part(out: &mut String, digest: &TableDigest, keys: &[PageColumn], part: &[PageColumn]) {
    let shown = || keys.iter().chain(part);
    put!(out, "<div class=\"scroll\"><table>\n<thead><tr>");
    for one in shown() {
        let name = escaped(&one.column.name).replace('_', "_<wbr>");
        let unit = Some(escaped(&one.column.unit)).filter(|unit| !unit.is_empty());
        let unit = unit.map_or(String::new(), |unit| format!("<br><small>{unit}</small>"));
        put!(out, "<th{}>{name}{unit}</th>", one.class());
    }
    put!(out, "</tr></thead>\n");
    if digest.rows > 1 && part.iter().any(PageColumn::has_range) {
        put!(out, "<tbody class=\"ranges\">\n");
        for (which, name) in RANGES.into_iter().enumerate() {
            put!(out, "<tr><th colspan=\"{}\">{name} of {} rows</th>", keys.len(), digest.rows);
            for one in part {
                put!(out, "<td class=\"n\">{}</td>", escaped(&one.range(which).unwrap_or_default()));
            }
            put!(out, "</tr>\n");
        }
        put!(out, "</tbody>\n");
    }
    put!(out, "<tbody>\n");
    for row in &digest.shown {
        put!(out, "<tr>");
        for (one, cell) in shown().filter_map(|one| Some((one, row.get(one.place)?))) {
            let is_broken = one.column.name == "verdict" && cell == "broken";
            let class = if is_broken { " class=\"broken\"" } else { one.class() };
            let text = if one.is_number() { escaped(cell) } else { breakable(cell) };
            put!(out, "<td{class}>{text}</td>");
        }
        put!(out, "</tr>\n");
    }
    put!(out, "</tbody>\n</table></div>\n");
}

/// Returns an escaped text that lines may break in: behind signs, and within long words.
fn breakable(text: &str) -> String {
    let (mut out, mut length) = (String::new(), 0);
    for c in text.chars() {
        if length == LONG_WORD {
            out += "<wbr>";
            length = 0;
        }
        out += &escaped(c.encode_utf8(&mut [0; 4]));
        length += 1;
        if "_/#:,;".contains(c) {
            out += "<wbr>";
            length = 0;
        }
    }
    out
}

/// Writes what another person needs to compute the table again.
fn put_check(out: &mut String, section: &Section) {
    let table = &section.table;
    let said = |name: &str| value(table, name).map(escaped);
    let file = escaped(&table.file.to_string_lossy());
    put!(out, "<div class=\"check\"><h3>How to check this</h3>\n<dl>\n");
    put!(out, "<dt>Table</dt><dd>{file}, BLAKE3 <code>{}</code> (<code>b3sum</code> prints it)</dd>\n", table.hash);
    if let Some((archive, root)) = said("archive").zip(said("archive_root")) {
        put!(
            out,
            "<dt>Archive</dt><dd>{archive}, root <code>{root}</code> (the root that <code>info</code> prints)</dd>\n"
        );
    }
    if let Some((atlas, root)) = said("atlas").zip(said("parts_root")) {
        put!(out, "<dt>Atlas</dt><dd>{atlas}, root of its parts <code>{root}</code></dd>\n");
    }
    if let Some(root) = said("root_before") {
        put!(out, "<dt>Before</dt><dd>root of the archive before <code>{root}</code></dd>\n");
    }
    for (name, hash) in object(table, "inputs") {
        put!(out, "<dt>Input</dt><dd>{}, BLAKE3 <code>{}</code></dd>\n", escaped(&name), escaped(&words(&hash)));
    }
    let (version, command) = (said("version").unwrap_or_default(), said("command").unwrap_or_default());
    put!(out, "<dt>Version</dt><dd>heliotile {version}</dd>\n");
    let verb = if command.starts_with("heliotile.") { "Call in Python" } else { "Command" };
    // Lines break between words only: `--zone` stays whole when it is copied from paper.
    let spans: Vec<String> = command.split(' ').map(|word| format!("<span>{word}</span>")).collect();
    put!(out, "<dt>{verb}</dt><dd><code>{}</code></dd>\n", spans.join(" "));
    let options = object(table, "options");
    let options = options.iter().filter(|(_, value)| **value != Value::Null);
    let options: Vec<String> = options.map(|(name, value)| format!("{name} = {}", words(value))).collect();
    put!(out, "<dt>Options</dt><dd>{}</dd>\n</dl>\n", escaped(&options.join("; ")));
    put!(
        out,
        "<p>With the same version, archive and inputs this writes the table again, byte for byte, whatever the name of \
         its output: equal hashes mean equal results. The manual of heliotile says what the columns mean and how \
         exact they are.</p></div>\n"
    );
}
