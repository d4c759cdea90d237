//! Generated files of the other faces, compared with the committed ones. With
//! `HELIOTILE_WRITE_FACES=1`, as `tools/faces` calls it, they are written.

mod book;
mod page;
mod python;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, fs};

use heliotile::requests::Row;
use heliotile::text::Named;

/// First line of a generated file.
const MADE: &str = "Made by tools/faces from the requests. Do not edit.";

/// Returns the help of a field, with the names that `named` gives to options in it. A command line
/// in backticks stays as it is.
fn help(row: &Row, named: &dyn Fn(&str) -> String) -> String {
    let mut text = String::new();
    let of_field = |field: Named| if let Named::Field(field) = field { Some(format!("--{field}")) } else { None };
    let fields = row.help.in_words(&of_field);
    let mut rest = fields.as_str();
    while let Some(at) = rest.find("--") {
        let (before, option) = rest.split_at(at);
        let end = option[2..].find(|c: char| !(c.is_ascii_lowercase() || c == '-')).map_or(option.len(), |end| end + 2);
        let name = option[2..end].trim_end_matches('-');
        text += before;
        if name.is_empty() || text.matches('`').count() % 2 == 1 {
            text += &option[..end];
        } else {
            text += &named(name);
            text += &option[2 + name.len()..end];
        }
        rest = &option[end..];
    }
    text += rest;
    let ends = text.ends_with(['.', ']']);
    match &row.default {
        Some(default) => format!("{text}{} Default: `{default}`.", if ends { "" } else { "." }),
        None if ends => text,
        None => text + ".",
    }
}

/// Committed files that differ from the generated ones: none, of 34 files. They are written where
/// `HELIOTILE_WRITE_FACES` is set.
#[test]
fn generated_files_are_those_of_the_requests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files: BTreeMap<PathBuf, String> = book::pages();
    files.insert("src/python/heliotile/options.py".into(), python::options());
    files.insert("src/viewer/source/engine/options.ts".into(), page::options());
    let is_other =
        |(path, text): &(&PathBuf, &String)| fs::read_to_string(root.join(path)).ok().as_ref() != Some(*text);
    let mut differ: Vec<PathBuf> = files.iter().filter(is_other).map(|(path, _)| path.clone()).collect();
    // Pages of commands that have gone.
    let pages = fs::read_dir(root.join(book::FOLDER)).expect("the pages");
    let pages = pages.map(|page| Path::new(book::FOLDER).join(page.expect("a page").file_name()));
    differ.extend(pages.filter(|page| !files.contains_key(page)));
    if env::var_os("HELIOTILE_WRITE_FACES").is_some() {
        for path in &differ {
            let to = root.join(path);
            match files.get(path) {
                Some(text) => fs::write(to, text).expect("a file"),
                None => fs::remove_file(to).expect("a page that has gone"),
            }
        }
        return;
    }
    assert!(differ.is_empty(), "not as the requests say: {differ:?}; to fix: tools/faces");
}
