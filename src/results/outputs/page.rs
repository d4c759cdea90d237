//! Report for people. In: a title, words, pictures, tables. Out: a folder with the tables and
//! pictures as files, and an HTML file that shows all of them and needs no other file.

use super::markup::escaped;
use std::path::{Path, PathBuf};

use super::provenance::Provenance;
use super::sink::write_texts;
use super::tables::{column::Column, csvw};
use heliotile_core::error::{Error, Result};

/// Name of the page that shows everything.
const PAGE: &str = "index.html";

/// Width and height of a picture, pixels.
pub const PICTURE_PX: (u32, u32) = (760, 460);

/// Contents of a report.
pub struct ReportFolder {
    /// Title of the page.
    pub title: String,
    /// Summary for people, as HTML.
    pub words: String,
    /// Table for the terminal and the page.
    pub table: String,
    /// Tables for programs.
    pub csv: Vec<CsvTable>,
    /// Pictures as SVG, by file name.
    pub pictures: Vec<(&'static str, String)>,
}

/// Table for programs.
pub struct CsvTable {
    /// Name of its file.
    pub name: &'static str,
    /// Header and rows of the table.
    pub text: String,
    /// Names of columns that hold text, not numbers.
    pub labels: &'static [&'static str],
}

impl CsvTable {
    /// Returns the description of the columns, for the metadata file beside the table.
    fn described(&self, about: &Provenance) -> String {
        let header = self.text.lines().next().unwrap_or_default().split(',');
        let column = |name: &str| match self.labels.contains(&name) {
            true => Column::text(name),
            false => Column::number(name, 4),
        };
        csvw::text(self.name, &header.map(column).collect::<Vec<_>>(), about, blake3::hash(self.text.as_bytes()))
    }
}

impl ReportFolder {
    /// Writes the folder and returns the path of its page; `about` is the provenance that files
    /// state.
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

    /// Returns the page as HTML.
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
