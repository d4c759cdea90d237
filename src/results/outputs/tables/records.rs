//! A few thousand rows in memory. In: columns, cells. Out: a table.

use std::path::Path;

use super::column::Column;
use super::table::{Cell, Table};
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;

/// Rows with their columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    pub columns: Vec<Column>,
    pub rows: Vec<Vec<Cell>>,
}

impl Records {
    /// Writes the table and returns its size in bytes.
    pub fn write(self, path: &Path, about: &Provenance) -> Result<u64> {
        let mut table = Table::of_rows(path, self.columns, self.rows.len() as u64, Some(about))?;
        self.rows.into_iter().try_for_each(|row| table.row(row))?;
        Ok(table.finish()?.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell of another kind, one cell too many and one too few are defects: 3 of 3, and no file
    /// is left.
    #[test]
    fn rows_that_do_not_fit_the_columns_are_defects() {
        let folder = tempfile::tempdir().expect("a folder");
        let columns = || vec![Column::text("face"), Column::count("regions"), Column::number("area_m2", 3)];
        let rows: [Vec<Cell>; 3] = [
            vec!["a".into(), 1.0.into(), None.into()],
            vec!["a".into(), Cell::Count(1), None.into(), 2.0.into()],
            vec!["a".into(), Cell::Count(1)],
        ];
        for row in rows {
            let error = Records { columns: columns(), rows: vec![row] }
                .write(&folder.path().join("t.csv"), &Provenance::default())
                .expect_err("a defect");
            assert!(matches!(error, heliotile_core::error::Error::Defect { .. }), "{error}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }
}
