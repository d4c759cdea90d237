//! Tables as NumPy arrays: the numbers of all rows in one array, `[place][step][column]` or, in
//! tables without steps, `[place][column]`, C order. The entries of the axes are described
//! separately. In: columns, batches. Out: shapes, bytes.
//!
//! Numbers have 32 bits if all of their columns do, otherwise 64, in which counts are exact up to
//! 2^53. An empty cell is NaN.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::batch::{Batch, Values};
use super::column::{Column, Kind, TableColumns};
use super::writer::rows_defect;
use heliotile_core::error::Error;

/// Alignment of the values, as NumPy writes them, so that they can be memory-mapped.
const ALIGNMENT: usize = 64;

/// Name of the axis of columns.
pub(super) const COLUMN_AXIS: &str = "column";

/// Name of the axis of steps if several columns describe them; `PLACE_AXIS` is the name of the axis
/// of places if no column names them.
const STEP_AXIS: &str = "step";
const PLACE_AXIS: &str = "row";

/// Returns the header of an array; `kind` is NumPy's `dtype.str`.
///
/// Format: NumPy enhancement proposal 1 (Kern 2007), version 1.0: magic, length of the header, a
/// Python dictionary, values.
pub fn header(kind: &str, shape: &[u64]) -> Vec<u8> {
    let sizes = match shape {
        [one] => format!("{one},"),
        more => more.iter().map(u64::to_string).collect::<Vec<_>>().join(", "),
    };
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sizes}), }}");
    // Ten bytes stand before the text, and a line end behind it.
    let length = (10 + text.len() + 1).next_multiple_of(ALIGNMENT);
    text.extend(std::iter::repeat_n(' ', length - 11 - text.len()));
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(((length - 10) as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes.push(b'\n');
    bytes
}

/// Units of the value columns.
pub(super) enum Units {
    /// Unit of all columns.
    One(String),
    /// Unit of each column; empty if it has none.
    Each(Vec<String>),
}

/// Table as an array.
pub(super) struct NumpyArray {
    columns: Arc<TableColumns>,
    /// Number of announced places; `done` is the number of those that were written.
    announced: u64,
    done: u64,
    has_floats_only: bool,
}

impl NumpyArray {
    pub fn new(columns: &Arc<TableColumns>, announced: u64) -> Self {
        let values = columns.all().iter().filter(|column| column.is_value());
        let has_floats_only = values.clone().all(|column| matches!(column.kind, Kind::Float(_)));
        NumpyArray { columns: Arc::clone(columns), announced, done: 0, has_floats_only }
    }

    /// Returns the columns of texts along places or rows.
    pub fn texts(&self) -> impl Iterator<Item = &Column> {
        self.columns.in_batches().filter(|column| column.is_text())
    }

    /// Returns the columns along steps.
    pub fn steps(&self) -> impl Iterator<Item = &Column> {
        self.columns.all().iter().filter(|column| column.is_of_bins())
    }

    /// Returns the names of the columns of numbers.
    pub fn values(&self) -> Vec<String> {
        self.value_columns().map(|column| column.name.clone()).collect()
    }

    fn value_columns(&self) -> impl Iterator<Item = &Column> {
        self.columns.all().iter().filter(|column| column.is_value())
    }

    /// Returns the names of the axes.
    pub fn axes(&self) -> Vec<&str> {
        let place = self.columns.of_places().map_or(PLACE_AXIS, |column| column.name.as_str());
        let mut steps = self.steps().map(|column| column.name.as_str());
        let step = match (steps.next(), steps.next()) {
            (Some(_), Some(_)) => Some(STEP_AXIS),
            (one, _) => one,
        };
        [Some(place), step, Some(COLUMN_AXIS)].into_iter().flatten().collect()
    }

    /// Returns the units of the value columns.
    pub fn units(&self) -> Units {
        let all: Vec<String> = self.value_columns().map(|column| column.unit.unwrap_or_default().to_owned()).collect();
        match all.as_slice() {
            [first, rest @ ..] if rest.iter().all(|unit| unit == first) => Units::One(first.clone()),
            _ => Units::Each(all),
        }
    }

    /// Returns the header of the array.
    pub fn header(&self) -> Vec<u8> {
        let steps = self.columns.has_steps().then(|| self.columns.rows_of_place() as u64);
        let columns = self.value_columns().count() as u64;
        let shape: Vec<u64> = [Some(self.announced), steps, Some(columns)].into_iter().flatten().collect();
        header(if self.has_floats_only { "<f4" } else { "<f8" }, &shape)
    }

    /// Returns the values of a batch in the order of the array.
    pub fn bytes(&mut self, batch: &Batch) -> Vec<u8> {
        self.done += batch.places as u64;
        let pairs = self.columns.in_batches().zip(&batch.values).filter(|(column, _)| column.is_value());
        let values = pairs.map(|(_, values)| values);
        let steps = self.columns.rows_of_place();
        if self.has_floats_only {
            let columns: Vec<Cow<[f32]>> = values.map(Values::floats).collect();
            return interleaved(&columns, batch.places, steps, f32::to_le_bytes);
        }
        let columns: Vec<Cow<[f64]>> = values.map(|values| Cow::Owned(doubles(values))).collect();
        interleaved(&columns, batch.places, steps, f64::to_le_bytes)
    }

    /// Fails if the table got fewer or more places than its shape states.
    pub fn check(&self, path: &Path) -> Result<(), Error> {
        if self.done == self.announced {
            return Ok(());
        }
        Err(rows_defect(path, format!("{} places came, {} were announced", self.done, self.announced)))
    }
}

/// Converts columns, `[column][place][step]`, to bytes in the order `[place][step][column]`.
fn interleaved<T: Copy + Default + Sync, const N: usize>(
    columns: &[Cow<[T]>],
    places: usize,
    steps: usize,
    bytes_of: fn(T) -> [u8; N],
) -> Vec<u8>
where
    [T]: ToOwned<Owned: Sync>,
{
    let row = columns.len() * N;
    let mut bytes = vec![0; places * steps * row];
    bytes.par_chunks_mut((steps * row).max(1)).enumerate().for_each(|(place, out)| {
        let range = place * steps..(place + 1) * steps;
        let columns: Vec<&[T]> = columns.iter().map(|column| column.get(range.clone()).unwrap_or_default()).collect();
        for (step, out) in out.chunks_exact_mut(row.max(1)).enumerate() {
            for (column, out) in columns.iter().zip(out.chunks_exact_mut(N)) {
                out.copy_from_slice(&bytes_of(column.get(step).copied().unwrap_or_default()));
            }
        }
    });
    bytes
}

/// Returns the values as numbers of 64 bits; NaN for an empty cell, nothing for texts.
fn doubles(values: &Values) -> Vec<f64> {
    match values {
        Values::Floats(floats) => floats.iter().map(|value| f64::from(*value)).collect(),
        Values::Numbers(numbers) => numbers.iter().map(|number| number.unwrap_or(f64::NAN)).collect(),
        Values::Counts(counts) => counts.iter().map(|count| *count as f64).collect(),
        Values::Texts(_) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header equals the one NumPy 2.4 writes for the same array: 128 bytes, of which 118 follow
    /// the length.
    #[test]
    fn the_header_equals_that_of_numpy() {
        let bytes = header("<f4", &[3, 2, 7]);
        let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 7), }";
        assert_eq!((bytes.len(), &bytes[..10]), (128, &b"\x93NUMPY\x01\x00\x76\x00"[..]));
        assert!(bytes[10..].starts_with(text.as_bytes()) && bytes.ends_with(b" \n"));
        assert_eq!(header("<U9", &[1]).len() % 64, 0);
    }

    /// A record of a count and a missing number is a row of 64 bits, 2 and NaN; its text column
    /// names the first axis.
    #[test]
    fn records_have_64_bits() {
        let columns = vec![Column::text("face"), Column::count("regions"), Column::number("area_m2", 3)];
        let mut array = NumpyArray::new(&Arc::new(TableColumns::new(columns)), 1);
        let values =
            vec![Values::Texts(vec!["a".to_owned()].into()), Values::Counts(vec![2]), Values::Numbers(vec![None])];
        let bytes = array.bytes(&Batch { places: 1, values });
        assert_eq!((bytes.len(), &bytes[..8]), (16, &2.0_f64.to_le_bytes()[..]));
        assert_eq!(array.axes(), ["face", "column"]);
        assert!(f64::from_le_bytes(bytes[8..].try_into().expect("8 bytes")).is_nan());
        assert!(
            String::from_utf8_lossy(&array.header())
                .contains("'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }")
        );
    }
}
