//! Tables of values of sky patches. In: the bytes of a CSV file. Out: a checked [`PatchFile`].
//!
//! The first line names the columns: `time` or `condition`, if rows have names, then one a patch.
//! The names of patches do not matter, but their order does ([`heliotile_core::sky::patches`]).
//! There are 145, 577 or 2305 of them, or one more in front for the ground, which is not used.

use std::path::Path;

use crate::skies::{PatchFile, PatchQuantity, grid_of};
use heliotile_core::dome::series::PatchSeries;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{excerpt, separator_hint};

/// Headings of a first column that names rows.
const LABELS: [&str; 2] = ["time", "condition"];

/// Reads a table.
pub(super) fn parse_table(path: &Path, bytes: &[u8], quantity: PatchQuantity) -> Result<PatchFile> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(bytes);
    let broken = |error: csv::Error| {
        let line = error.position().map(|p| p.line() as usize);
        Error::input(path, line, error.to_string(), "save the table as CSV in UTF-8")
    };
    let header = reader.headers().map_err(broken)?.clone();
    let has_labels = header.get(0).is_some_and(|first| LABELS.contains(&first));
    let before = usize::from(has_labels);
    let columns = header.len();
    let Some((grid, has_ground)) = grid_of(columns - before.min(columns)) else {
        let what = format!("{} columns of patches, not 145, 577 or 2305", columns - before.min(columns));
        let hint = separator_hint(&excerpt(&header.iter().collect::<Vec<_>>().join(","), 80)).unwrap_or(
            "give a first column `time` or `condition`, then a column for each patch: Tregenza's 145, or Reinhart's \
             577 (MF:2) or 2305 (MF:4); one more column before them is the ground and is ignored",
        );
        return Err(Error::input(path, 1, what, hint));
    };
    let first = before + usize::from(has_ground);
    let (mut labels, mut numbers) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        if record.len() != columns {
            let what = format!("the row has {} cells, the header has {columns}", record.len());
            return Err(Error::input(path, line, what, "give every patch a number in every row"));
        }
        labels.extend(record.get(0).filter(|_| has_labels).map(str::to_owned));
        for (patch, text) in record.iter().skip(first).enumerate() {
            match text.parse::<f64>() {
                Ok(number) if quantity.holds(number) => numbers.push(number as f32),
                _ => {
                    let what = format!("patch {} is `{}`", patch + 1, excerpt(text, 40));
                    return Err(Error::input(path, line, what, format!("{}: correct the cell", quantity.range()))
                        .because(Problem::value(format!("patch {}", patch + 1), excerpt(text, 40))));
                }
            }
        }
    }
    let none = || {
        Error::input(path, None, "the table has no rows", "write a line for each sky below the names of the columns")
    };
    let series = PatchSeries::new(grid, numbers).ok_or_else(none)?;
    Ok(PatchFile { series, labels: has_labels.then_some(labels), is_matrix: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<PatchFile> {
        parse_table(Path::new("p.csv"), text.as_bytes(), PatchQuantity::Radiance)
    }

    fn names(count: usize) -> String {
        (0..count).map(|i| format!(",p{i}")).collect()
    }

    /// A table with times and the ground, and one without either, are read row by row, with 145 and
    /// 577 patches. Six broken ones are errors that say what is wrong and where.
    #[test]
    fn tables_are_read_and_broken_ones_refused() {
        let row = |first: &str, count: usize| format!("{first}{}\n", ",2.5".repeat(count));
        let timed = read(&format!("time{}\n{}{}", names(146), row("01-01T00:00", 146), row("01-01T01:00", 146)));
        let timed = timed.expect("a table");
        assert_eq!((timed.series.rows(), timed.series.row(1).len(), timed.series.row(2).len()), (2, 145, 0));
        assert_eq!(timed.labels.expect("times"), ["01-01T00:00", "01-01T01:00"]);
        let plain = read(&format!("p{}\n{}", names(576), row("1e3", 576))).expect("a table");
        assert_eq!((plain.series.row(0)[0], plain.series.row(0)[576], plain.labels), (1000.0, 2.5, None));
        for (text, expected) in [
            (format!("time{}\n", names(145)), "the table has no rows"),
            (format!("time{}\n{}", names(144), row("a", 144)), "line 1: 144 columns of patches"),
            (format!("time{}\n{}", names(145), row("a", 144)), "line 2: the row has 145 cells"),
            (format!("time{}\na,NaN{}", names(145), row("", 144)), "line 2: patch 1 is `NaN`"),
            (format!("time{}\na,1,-0.1{}", names(145), row("", 143)), "line 2: patch 2 is `-0.1`"),
            ("time;a;b\n1;2;3\n".to_owned(), "separate the columns by commas"),
        ] {
            let found = read(&text).expect_err(expected).to_string();
            assert!(found.contains(expected), "{found}");
        }
        let share = |text: &str| {
            let text = format!("time{}\na,{text}{}", names(145), row("", 144)).replace("2.5", "0.5");
            parse_table(Path::new("p.csv"), text.as_bytes(), PatchQuantity::Transmittance).is_ok()
        };
        assert!(share("1") && !share("1.01"));
    }
}
