//! Statement for a person who decides. In: tables that heliotile wrote, pictures. Out: one HTML
//! file that prints well: site, question, rule, results, uncertainty, and how to check all of it.
//!
//! Nothing is computed here that a table does not hold: numbers are those of its cells, counts of
//! them, and their least, mean and greatest. The page holds no script and needs no other file.

mod digest;
mod facts;
mod page;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::csvw::{self, DescribedTable};
use digest::TableDigest;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::observer::Observer;
use heliotile_core::text::counted;
use heliotile_requests::{DefaultRequest, InputKind, Request, Role};

/// Request for a statement about tables of results.
#[derive(Clone, Debug, Request, DefaultRequest)]
#[request(also = files_beside)]
pub struct ReportRequest {
    /// Tables of results that heliotile wrote, CSV, each with its .csv-metadata.json beside it.
    #[field(metavar = "TABLE", positional, required, input = Any)]
    pub tables: Vec<PathBuf>,
    /// HTML file to write, which needs no other file and no network.
    #[field(short = 'o', metavar = "PAGE.html", output = File, required)]
    pub output: PathBuf,
    /// Title of the page [default: the question that the first table answers].
    pub title: Option<String>,
    /// Most rows of each table that are shown; newly broken and broken rules come first, and the
    /// page states how many rows it leaves out.
    #[field(default = 100, range = 1..=100_000)]
    pub rows: usize,
    /// Picture to show, .svg or .png; may be repeated. A picture beside a table that has its name,
    /// such as a.svg beside a.csv, is shown without this option.
    #[field(name = "picture", python = "pictures", metavar = "FILE", input = Any)]
    pub pictures: Vec<PathBuf>,
}

/// Counts of what a statement holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportDone {
    /// Number of tables.
    pub tables: usize,
    /// Number of rows of all tables.
    pub rows: u64,
    /// Verdicts on each rule, in words.
    pub verdicts: Vec<String>,
}

/// Table with the summary of its rows and its pictures.
struct Section {
    table: DescribedTable,
    digest: TableDigest,
    pictures: Vec<Picture>,
}

/// Picture to embed.
struct Picture {
    file: PathBuf,
    /// Type of its bytes, such as `image/png`.
    media: &'static str,
    bytes: Vec<u8>,
}

impl ReportDone {
    /// Returns the counts as a sentence.
    pub fn text(&self) -> String {
        let first = format!("{}, {}", counted(self.tables as u64, "table"), counted(self.rows, "row"));
        [vec![first], self.verdicts.clone()].concat().join("; ")
    }
}

impl ReportRequest {
    /// Writes the page; `about` states how it was requested.
    ///
    /// # Errors
    /// A table has no metadata file, or was changed since heliotile wrote it.
    pub fn write(&self, about: &Provenance, observer: &dyn Observer) -> Result<ReportDone> {
        check_ranges(self)?;
        let mut sections = self.tables.iter().map(|table| self.section(table, observer)).collect::<Result<Vec<_>>>()?;
        let given = self.pictures.iter().map(|file| Picture::read(file)).collect::<Result<Vec<_>>>()?;
        if let Some(first) = sections.first_mut() {
            first.pictures.extend(given);
        }
        let html = page::html(self.title.as_deref(), &sections, about);
        let is_stdout = self.output == Path::new("-");
        let mut sink = if is_stdout { Sink::stdout() } else { Sink::file(&self.output)? };
        sink.write_all(html.as_bytes()).map_err(Error::io(&self.output, "write to"))?;
        sink.finish()?;
        Ok(ReportDone {
            tables: sections.len(),
            rows: sections.iter().map(|section| section.digest.rows).sum(),
            verdicts: sections.iter().flat_map(|section| &section.digest.rules).map(|rule| rule.text()).collect(),
        })
    }

    fn section(&self, file: &Path, observer: &dyn Observer) -> Result<Section> {
        if !file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
            let hint = "write the table as CSV: give its command an output whose name ends with .csv";
            return Err(Error::input(file, None, "is no CSV table", hint).because(Problem::Ending));
        }
        let table = csvw::read(file)?;
        let digest = TableDigest::of(&table, self.rows)?;
        let root = facts::value(&table, "archive_root").or(facts::value(&table, "parts_root"));
        let mut pictures = Vec::new();
        for path in pictures_beside(file).filter(|path| !self.pictures.contains(path)) {
            let picture = Picture::read(&path)?;
            if root.is_some_and(|root| picture.names(root)) {
                pictures.push(picture);
            } else {
                observer.note(format!(
                    "{} is left out: it is not of the archive of {}",
                    path.display(),
                    file.display()
                ));
            }
        }
        Ok(Section { table, digest, pictures })
    }
}

/// Hands on the files beside tables that are read.
fn files_beside(request: &ReportRequest, each: &mut dyn FnMut(&'static str, Role, &Path)) {
    for table in &request.tables {
        let metadata = Some(csvw::beside(table)).filter(|path| path.is_file());
        metadata.into_iter().chain(pictures_beside(table)).for_each(|path| {
            each("tables", Role::Input(InputKind::Any), &path);
        });
    }
}

/// Returns the pictures that have the name of a table.
fn pictures_beside(table: &Path) -> impl Iterator<Item = PathBuf> {
    ["svg", "png"].map(|ending| table.with_extension(ending)).into_iter().filter(|path| path.is_file())
}

impl Picture {
    fn read(file: &Path) -> Result<Self> {
        let bytes = fs::read(file).map_err(Error::io(file, "read"))?;
        let media = match bytes.as_slice() {
            [0x89, b'P', b'N', b'G', ..] => "image/png",
            [b'<', ..] if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg")) => "image/svg+xml",
            _ => {
                let hint = "give a picture that a {plot} of heliotile wrote";
                return Err(Error::input(file, None, "is no picture as SVG or PNG", hint).because(Problem::Ending));
            }
        };
        Ok(Picture { file: file.to_path_buf(), media, bytes })
    }

    /// Returns true if the picture names the root of an archive, as pictures of heliotile do.
    fn names(&self, root: &str) -> bool {
        self.bytes.windows(root.len().max(1)).any(|bytes| bytes == root.as_bytes())
    }
}
