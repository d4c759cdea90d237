//! Cells of a module as they are wired. In: a table of `rows.toml`. Out: cells of each substring.

use serde::Deserialize;

/// Cells of a module, in substrings with a bypass diode each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellGrid {
    /// Numbers of cells along the row and up the slope.
    pub cells: [usize; 2],
    /// Number of substrings, side by side: each is as long as the longer side of the grid.
    pub substrings: usize,
    /// The halves of each substring are in parallel.
    pub is_half_cut: bool,
    /// Number of modules in series on an input of an inverter; 1: each has its own.
    pub series: usize,
}

/// Entry `cells = { across = 6, up = 10 }` of rows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table, as in { across = 6, up = 10 }")]
pub(super) struct CellsEntry {
    across: usize,
    up: usize,
    #[serde(default = "usual_substrings")]
    substrings: usize,
    #[serde(default)]
    half_cut: bool,
    #[serde(default = "usual_series")]
    series: usize,
}

/// Returns the number of bypass diodes of nearly all modules.
fn usual_substrings() -> usize {
    3
}

fn usual_series() -> usize {
    1
}

/// Largest number of cells of a module: that of shingled ones.
const MAX_CELLS: usize = 1000;
/// Largest number of modules in series: 1500 V, the most that inverters take, over 25 V.
const MAX_SERIES: usize = 60;

impl CellsEntry {
    /// Returns the grid; an error says what is wrong with an entry.
    pub(super) fn checked(self) -> Result<CellGrid, String> {
        let CellsEntry { across, up, substrings, half_cut, series } = self;
        if !(1..=MAX_CELLS).contains(&across.saturating_mul(up)) {
            return Err(format!("`cells` has {across} x {up} cells, not from 1 to {MAX_CELLS}"));
        }
        let (short, long) = (across.min(up), across.max(up));
        if substrings == 0 || short % substrings != 0 {
            return Err(format!(
                "`cells` has {across} x {up} cells, which {substrings} substrings do not share evenly: {short} is no multiple of {substrings}"
            ));
        }
        if half_cut && long % 2 != 0 {
            return Err(format!("`cells` has {long} cells along a substring, which two halves do not share evenly"));
        }
        if !(1..=MAX_SERIES).contains(&series) {
            return Err(format!("`series` is {series}, not from 1 to {MAX_SERIES} modules"));
        }
        Ok(CellGrid { cells: [across, up], substrings, is_half_cut: half_cut, series })
    }
}

impl CellGrid {
    /// Returns the number of cells.
    pub fn count(&self) -> usize {
        self.cells[0] * self.cells[1]
    }

    /// Returns the number of cells of a substring that are in series.
    pub fn in_series(&self) -> usize {
        self.count() / self.substrings / if self.is_half_cut { 2 } else { 1 }
    }

    /// Returns the cells, which count along the row, then up the slope, in the order of substrings
    /// and of their halves.
    pub fn order(&self) -> Vec<usize> {
        let [across, up] = self.cells;
        let place = |cell: &usize| {
            let (at, row) = (cell % across, cell / across);
            let (side, along) = if up >= across { (at, row) } else { (row, at) };
            let half = self.is_half_cut && along >= across.max(up) / 2;
            (side * self.substrings / across.min(up), half, *cell)
        };
        let mut order: Vec<usize> = (0..self.count()).collect();
        order.sort_by_key(place);
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(cells: [usize; 2], is_half_cut: bool) -> CellGrid {
        CellGrid { cells, substrings: 3, is_half_cut, series: 1 }
    }

    /// Substrings of an upright module of 6 x 10 are two columns each, those of one on its side,
    /// 10 x 6, two rows each; of half-cut cells, 3 x 4, the lower two come first.
    #[test]
    fn substrings_lie_along_the_longer_side() {
        let upright = grid([6, 10], false);
        let first: Vec<usize> = (0..10).flat_map(|row| [6 * row, 6 * row + 1]).collect();
        assert_eq!((&upright.order()[..20], upright.in_series()), (&first[..], 20));
        assert_eq!(grid([10, 6], false).order(), (0..60).collect::<Vec<_>>());
        let halves = grid([3, 4], true);
        assert_eq!(halves.order(), [0, 3, 6, 9, 1, 4, 7, 10, 2, 5, 8, 11]);
        assert_eq!(halves.in_series(), 2);
    }

    /// Cells that substrings or halves do not share evenly, none, and 61 modules in series are
    /// refused by name.
    #[test]
    fn uneven_substrings_are_refused() {
        let entry = |text: &str| toml::from_str::<CellsEntry>(text).expect("a table").checked();
        let right = CellGrid { cells: [6, 12], substrings: 2, is_half_cut: true, series: 20 };
        assert_eq!(entry("across = 6\nup = 12\nsubstrings = 2\nhalf_cut = true\nseries = 20"), Ok(right));
        for (text, named) in [
            ("across = 0\nup = 10", "0 x 10"),
            ("across = 5\nup = 10", "5 is no multiple of 3"),
            ("across = 6\nup = 10\nsubstrings = 0", "0 substrings"),
            ("across = 6\nup = 11\nhalf_cut = true", "11 cells along"),
            ("across = 6\nup = 10\nseries = 61", "`series` is 61"),
            ("across = 900\nup = 900", "900 x 900"),
        ] {
            let error = entry(text).expect_err(text);
            assert!(error.contains(named), "{error}");
        }
    }
}
