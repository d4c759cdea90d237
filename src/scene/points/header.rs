//! Header of a table. In: the first row of a CSV file, names of columns with their aliases. Out:
//! the places of the columns, and those that no reader asked for.

use crate::text::excerpt;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, separator_hint, with_list};
use heliotile_files::csv_rows::CsvRows;

/// Names that a column may have; messages use the first one.
pub(super) type Names = &'static [&'static str];

/// Columns that `receivers` and `places` write. Readers that need none of them are silent about
/// them, since the tables are made to be read by them.
const WRITTEN: [&str; 15] = [
    "receiver",
    "nx",
    "ny",
    "nz",
    "area_m2",
    "surface",
    "object",
    "building",
    "kind",
    "object_type",
    "face",
    "patch",
    "total_kwh_m2",
    "light_kwh",
    "sky_view",
];

/// Column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    /// Index of its cells.
    pub place: usize,
    /// Name that the table uses.
    pub name: &'static str,
}

/// Columns of a table, with those that were found.
pub(super) struct Header<'h> {
    rows: &'h CsvRows<'h>,
    names: Vec<String>,
    used: Vec<bool>,
    /// Description of the columns that the reader knows.
    hint: &'static str,
}

/// Reads the header. Fails if the file is empty; `hint` describes the columns.
pub(super) fn advance_to_header(rows: &mut CsvRows, hint: &'static str) -> Result<()> {
    match rows.advance()? {
        true => Ok(()),
        false => Err(Error::input(rows.file, None, "the file is empty", hint)),
    }
}

impl<'h> Header<'h> {
    /// Returns the columns of the present row. Capital letters count as small ones.
    pub fn new(rows: &'h CsvRows<'h>, hint: &'static str) -> Self {
        let names: Vec<String> = rows.record.iter().map(str::to_lowercase).collect();
        Header { rows, used: vec![false; names.len()], names, hint }
    }

    /// Returns the number of columns.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Returns the column with one of the names. A second one is an error.
    pub fn find(&mut self, names: Names) -> Result<Option<Found>> {
        let mut found: Option<Found> = None;
        for (place, column) in self.names.iter().enumerate() {
            let Some(name) = names.iter().find(|name| *name == column) else { continue };
            if let Some(first) = found {
                let what = match first.name == *name {
                    true => format!("column `{name}` appears twice"),
                    false => format!("columns `{}` and `{name}` state the same", first.name),
                };
                return Err(self.rows.error(what, "remove one of the two").because(Problem::duplicate(*name)));
            }
            found = Some(Found { place, name });
            self.used.get_mut(place).into_iter().for_each(|used| *used = true);
        }
        Ok(found)
    }

    /// Returns the column with one of the names. Its absence is an error.
    pub fn needed(&mut self, names: Names) -> Result<Found> {
        let found = self.find(names)?;
        found.ok_or_else(|| self.lacks(names.first().unwrap_or(&"")))
    }

    /// Returns the error for a missing column.
    pub fn lacks(&self, column: &str) -> Error {
        self.missing(&format!("column `{column}` is missing")).because(Problem::no_column(column))
    }

    /// Returns the error for what is missing.
    pub fn missing(&self, what: &str) -> Error {
        let header = self.rows.record.iter().collect::<Vec<_>>().join(",");
        let what = format!("{what}; the header is `{}`", excerpt(header.as_bytes()));
        self.rows.error(what, separator_hint(&header).unwrap_or(self.hint))
    }

    /// Returns a warning about the columns that were not asked for; `None` if there are none.
    pub fn unused(&self) -> Option<Message> {
        let names = self.rows.record.iter().zip(&self.used);
        let names = names.filter(|(name, used)| !**used && !WRITTEN.contains(name));
        let names: Vec<String> = names.map(|(name, _)| format!("`{}`", excerpt(name.as_bytes()))).collect();
        let file = self.rows.file.display();
        match names.as_slice() {
            [] => None,
            [only] => Some(format!("{file}: column {only} is not used").into()),
            all => Some(with_list(format!("{file}: {} columns are not used", all.len()), names)),
        }
    }
}
