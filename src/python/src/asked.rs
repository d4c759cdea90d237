//! Requests of calls. In: keywords, which `heliotile/given.py` turned into texts, and tables in
//! memory. Out: requests of the library, filled and checked as those of the command line.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::work;
use heliotile::cases::{Given, Prepared, prepared, stated};
use heliotile::memory::{SystemTemp, check_memory, parse_memory};
use heliotile::requests::{Many, Request, Row};
use heliotile::scene::input;
use heliotile::{Bytes, Error, MemoryBudget, Provenance, ReceiverCsv, Resources, Result};

/// Memory to work in, at most that of the machine.
#[derive(Clone, Copy)]
pub struct Memory(pub MemoryBudget);

impl<'py> FromPyObject<'_, 'py> for Memory {
    type Error = PyErr;

    fn extract(number: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let Bytes(bytes) = check_memory(Bytes(number.extract()?))
            .map_err(|text| PyValueError::new_err(format!("memory: {text}, in bytes")))?;
        Ok(Memory(MemoryBudget::new(bytes)))
    }
}

/// Keywords of a call.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Keywords {
    /// Function, such as `Archive.replay`.
    function: String,
    /// Texts by keyword.
    texts: Vec<(String, Texts)>,
    /// Tables in memory, by the names that stand for them in texts.
    tables: HashMap<PathBuf, PyBackedBytes>,
}

/// Value of a keyword.
#[derive(FromPyObject)]
enum Texts {
    Flag(bool),
    All(Vec<String>),
}

impl Keywords {
    /// Fills and checks a request. `known` names fields that the call fills in another way.
    pub fn filled<R: Request + Default>(&self, known: &[&str]) -> Result<Prepared<R>> {
        prepared(&self.given(&R::rows())?, known, &|path| self.tables.contains_key(path))
    }

    /// Returns what results state of the call.
    pub fn about<R: Request>(&self) -> Result<Provenance> {
        let rows = R::rows();
        Ok(Provenance::new(format!("heliotile.{}", self.function), stated(&rows, &self.given(&rows)?)))
    }

    /// Returns the table of a name: its file, or its text in memory.
    pub fn table<'a>(&'a self, name: &'a Path) -> ReceiverCsv<'a> {
        self.tables.get(name).map_or(ReceiverCsv::File(name), |text| ReceiverCsv::Text { name, text })
    }

    /// Fills and checks a request, and calls `then` with it, with what results state, and with
    /// resources.
    pub fn run<R: Request + Default, T: Send>(
        &self,
        py: Python<'_>,
        known: &[&str],
        progress: Option<&Bound<'_, PyAny>>,
        then: impl FnOnce(&R, Provenance, &Resources) -> Result<T> + Send,
    ) -> PyResult<T> {
        work::run(py, progress, |watch| {
            let prepared = self.filled::<R>(known)?;
            let bytes = |path: &Path| self.tables.get(path).map(|bytes| Ok(bytes.to_vec()));
            let files = |path: &Path| bytes(path).unwrap_or_else(|| input::read(path));
            let resources = Resources { memory: self.memory()?, storage: &SystemTemp, files: &files, observer: watch };
            then(&prepared.request, prepared.told_in(self.about::<R>()?)?, &resources)
        })
    }

    fn memory(&self) -> Result<MemoryBudget> {
        let text = self.texts.iter().find_map(|(name, texts)| match texts {
            Texts::All(all) if name == "memory" => all.last(),
            _ => None,
        });
        let wrong = |what: String| Error::argument("memory", what, "give bytes, as in 1 << 30, or \"1GiB\"");
        text.map_or(Ok(MemoryBudget::DEFAULT), |text| parse_memory(text).map_err(wrong))
    }

    /// Returns the texts of fields.
    fn given(&self, rows: &[Row]) -> Result<Given> {
        let mut given = Given::new();
        for (name, texts) in &self.texts {
            let Some(row) = rows.iter().find(|row| row.in_python() == name) else {
                return Err(Error::argument(name, "is no keyword of this function", "leave it out"));
            };
            let texts = match (row.many, texts) {
                (Many::Flag, Texts::Flag(is)) => match *is != row.is_off() {
                    true => Vec::new(),
                    false => continue,
                },
                (Many::Flag, Texts::All(all)) => {
                    let what = format!("`{}` is neither True nor False", all.join(", "));
                    return Err(Error::argument(name, what, "give True or False"));
                }
                (_, Texts::Flag(is)) => vec![if *is { "True" } else { "False" }.to_owned()],
                (_, Texts::All(all)) if all.is_empty() => continue,
                (Many::List, Texts::All(all)) => all.iter().flat_map(|text| split(text, row.delimiter)).collect(),
                (_, Texts::All(all)) => vec![all.join(between(row))],
            };
            given.push((row.name.to_owned(), texts));
        }
        Ok(given)
    }
}

fn split(text: &str, delimiter: Option<char>) -> Vec<String> {
    delimiter.map_or_else(|| vec![text.to_owned()], |delimiter| text.split(delimiter).map(str::to_owned).collect())
}

/// Returns the text between the numbers of a field that holds several.
fn between(row: &Row) -> &'static str {
    match row.metavar {
        Some("FROM..TO") => "..",
        Some("WxH") => "x",
        _ => ",",
    }
}
