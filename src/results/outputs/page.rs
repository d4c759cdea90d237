//! A report for people. In: a title, words, pictures, tables. Out: a folder with one HTML file that needs no other, and with the tables and pictures
//! as files.

use super::markup::escaped;
use std::path::{Path, PathBuf};

use super::provenance::Provenance;
use super::sink::write_texts;
use super::tables::{column::Column, csvw};
use heliotile_core::error::{Error, Result};

/// The page that shows everything.
const PAGE: &str = "index.html";

/// Width and height of a picture, pixels.
pub const PICTURE_PX: (u32, u32) = (760, 460);

/// What a folder tells a person.
pub struct ReportFolder {
    /// Title of the page.
    pub title: String,
    /// What a person should know, as HTML.
    pub words: String,
    /// Table for the terminal and the page.
    pub table: String,
    /// Tables for programs.
    pub csv: Vec<CsvTable>,
    /// SVG by the names of its files.
    pub pictures: Vec<(&'static str, String)>,
}

/// A table for programs.
pub struct CsvTable {
    /// Name of its file.
    pub name: &'static str,
    /// Its header and rows.
    pub text: String,
    /// Columns that hold no numbers.
    pub labels: &'static [&'static str],
}

impl CsvTable {
    /// What its columns are, for the file beside it.
    fn described(&self, about: &Provenance) -> String {
        let header = self.text.lines().next().unwrap_or_default().split(',');
        let column = |name: &str| match self.labels.contains(&name) {
            true => Column::text(name),
            false => Column::number(name, 4),
        };
        csvw::text(self.name, &header.map(column).collect::<Vec<_>>(), about)
    }
}

impl ReportFolder {
    /// Writes the folder, and gives the path of its page; `about` is what files say of how they were made.
    pub fn write(mut self, folder: &Path, about: &Provenance) -> Result<PathBuf> {
        std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
        self.pictures.iter_mut().for_each(|(_, svg)| *svg = about.in_svg(svg));
        let mut files: Vec<(String, String)> = Vec::new();
        for csv in &self.csv {
            files.push((format!("{}-metadata.json", csv.name), csv.described(about)));
            files.push((csv.name.to_owned(), csv.text.clone()));
        }
        files.push((PAGE.to_owned(), self.page()));
        files.extend(self.pictures.into_iter().map(|(name, svg)| (name.to_owned(), svg)));
        write_texts(folder, &files)?;
        Ok(folder.join(PAGE))
    }

    /// The page.
    fn page(&self) -> String {
        let drawn: String = self.pictures.iter().map(|(_, svg)| format!("<figure>{svg}</figure>\n")).collect();
        let (title, words, table) = (escaped(&self.title), &self.words, escaped(&self.table));
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n\
             body {{ font-family: sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em; line-height: 1.5 }}\n\
             pre {{ font-size: 85%; overflow-x: auto }} figure {{ margin: 1.5em 0 }} svg {{ max-width: 100%; height: auto }}\n\
             </style>\n</head>\n<body>\n<h1>{title}</h1>\n<p>{words}</p>\n{drawn}<pre>{table}</pre>\n</body>\n</html>\n"
        )
    }
}
