//! Formats of tables, in the only list of formats and endings. In: a name. Out: its format, and a
//! writer of it.

use std::path::{Path, PathBuf};

use crate::outputs::sink::Sink;
use crate::outputs::tables::arrow::{ArrowTable, Packing};
use crate::outputs::tables::csv::CsvTable;
use crate::outputs::tables::csvw;
use crate::outputs::tables::npy::NpyTable;
use crate::outputs::tables::npz::NpzTable;
use crate::outputs::tables::parquet::ParquetTable;
use crate::outputs::tables::writer::{FormatWriter, TableRequest};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;

/// File format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    Csv,
    Parquet,
    /// Arrow IPC without compression.
    Arrow,
    /// Arrow IPC with compression.
    Feather,
    Npy,
    Npz,
}

impl Format {
    /// Endings of names, a remark for users about each, and the format.
    pub const ENDINGS: [(&'static str, &'static str, Format); 6] = [
        ("csv", "with .csv-metadata.json beside it, which describes its columns", Format::Csv),
        ("parquet", "", Format::Parquet),
        ("arrow", "", Format::Arrow),
        ("feather", "compressed Arrow", Format::Feather),
        ("npy", "with .axes.json beside it", Format::Npy),
        ("npz", "", Format::Npz),
    ];

    /// Returns the format of a name: `-` is CSV on standard output, otherwise the ending decides.
    /// Fails for an unknown ending.
    pub fn by_ending(path: &Path) -> Result<Self> {
        Format::known(path).ok_or_else(|| Error::Unsupported {
            what: "ending of the output file".into(),
            found: format!("`{}`", path.display()),
            supported: Format::listed().into(),
        })
    }

    /// Returns the format of a name, if its ending is that of a table.
    pub fn known(path: &Path) -> Option<Self> {
        if path == Path::new("-") {
            return Some(Format::Csv);
        }
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Format::ENDINGS.iter().find(|(name, ..)| *name == ending).map(|(.., format)| *format)
    }

    /// Returns all endings in words.
    pub fn listed() -> String {
        let all: Vec<String> = Format::ENDINGS.iter().map(|(ending, ..)| format!(".{ending}")).collect();
        let text = all.join(", ");
        let text = text.rsplit_once(", ").map_or(text.clone(), |(most, last)| format!("{most} and {last}"));
        format!("{text} (or - for CSV on the standard output)")
    }

    /// Returns all endings with remarks for users, for help texts.
    pub fn described() -> String {
        let one = |(ending, remark, _): &(&str, &str, Format)| match *remark {
            "" => format!(".{ending}"),
            remark => format!(".{ending} ({remark})"),
        };
        let all: Vec<String> = Format::ENDINGS.iter().map(one).collect();
        format!("{}, or - for CSV on standard output", all.join(", "))
    }

    /// Returns the path of the metadata file beside a table, if the format has one.
    fn beside(self, path: &Path) -> Option<PathBuf> {
        match self {
            Format::Npy => Some(NpyTable::axes_of(path)),
            Format::Csv if path != Path::new("-") => Some(csvw::beside(path)),
            Format::Csv | Format::Parquet | Format::Arrow | Format::Feather | Format::Npz => None,
        }
    }

    /// Starts a table.
    pub fn start(self, request: &TableRequest) -> Result<Box<dyn FormatWriter>> {
        let path = request.path;
        let sink = if path == Path::new("-") { Sink::stdout() } else { Sink::file(path)? };
        Ok(match self {
            Format::Csv => Box::new(CsvTable::new(sink, request)?),
            Format::Parquet => Box::new(ParquetTable::new(sink, request)?),
            Format::Arrow => Box::new(ArrowTable::new(sink, request, Packing::Plain)?),
            Format::Feather => Box::new(ArrowTable::new(sink, request, Packing::Zstd)?),
            Format::Npy => Box::new(NpyTable::new(sink, request)?),
            Format::Npz => Box::new(NpzTable::new(sink, request)?),
        })
    }
}

/// Returns the files that a table of this name consists of.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let beside = Format::known(path).and_then(|format| format.beside(path));
    [Some(path.to_path_buf()), beside].into_iter().flatten().collect()
}

/// Returns the endings of tables and their formats, for help.
pub fn table_endings() -> Vec<(&'static str, &'static str)> {
    Format::ENDINGS.iter().map(|(ending, ..)| (*ending, "")).collect()
}

/// Returns the help of an option that names a table to write: its subject, and the endings.
pub fn table_help(table: &'static str) -> Message {
    Message::from(table).and(": ").and(Format::described())
}
