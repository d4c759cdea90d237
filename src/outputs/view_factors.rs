//! View factors of receivers as a table: what each one's hemisphere is filled with. In: the shares that the build stored. Out: CSV.

use std::io::Write;
use std::path::Path;

use super::provenance::Provenance;
use super::sink::Sink;
use crate::outputs::tables::csvw::{self, CsvColumn};
use crate::outputs::tables::quoted;
use heliotile_core::error::{Error, Result};

/// The columns; the last four sum to 1.
pub const COLUMNS: &str = "receiver,sky_view,ground_view,obstruction_view,nothing_view";

/// A table being written.
pub struct ViewFactorTable {
    sink: Sink,
    provenance: Provenance,
}

impl ViewFactorTable {
    /// `-` is the standard output; any other name ends in .csv.
    pub fn create(path: &Path, provenance: Provenance) -> Result<Self> {
        let csv = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
        let sink = match path == Path::new("-") {
            true => Sink::stdout(),
            false if csv => Sink::file(path)?,
            false => {
                return Err(Error::Unsupported {
                    what: "ending of the file of view factors".into(),
                    found: format!("`{}`", path.display()),
                    supported: ".csv (or - for the standard output)".into(),
                });
            }
        };
        let mut table = ViewFactorTable { sink, provenance };
        table.write(&format!("{COLUMNS}\n"))?;
        Ok(table)
    }

    /// One row; `views`: cosine-weighted shares of sky, ground and obstructions. What is left meets nothing: below the horizon
    /// where the scene ends.
    pub fn row(&mut self, receiver: &str, views: [f32; 3]) -> Result<()> {
        let [sky, ground, obstruction] = views.map(f64::from);
        let nothing = (1.0 - sky - ground - obstruction).max(0.0);
        self.write(&format!("{},{sky:.7},{ground:.7},{obstruction:.7},{nothing:.7}\n", quoted(receiver)))
    }

    /// Whether nobody reads any more.
    pub fn is_closed(&self) -> bool {
        self.sink.is_closed()
    }

    /// Completes the table; only now does its file appear, and before it the one that says what it holds.
    pub fn finish(self) -> Result<u64> {
        if let Some(path) = self.sink.file_path() {
            let columns: Vec<CsvColumn> = COLUMNS.split(',').map(CsvColumn::named).collect();
            csvw::write(path, &columns, &self.provenance)?;
        }
        self.sink.finish()
    }

    fn write(&mut self, text: &str) -> Result<()> {
        self.sink.write_all(text.as_bytes()).map_err(|e| Error::io(self.sink.path(), "write to")(e))
    }
}
