//! Rows of a table, some places at a time, column by column. In: values. Out: a batch that every
//! format can append.

use std::borrow::Cow;

use super::column::{Along, Kind, TableColumns};

/// Values of some columns at some places.
pub struct Batch<'v> {
    pub places: usize,
    /// Values of the columns of [`TableColumns::in_batches`], in their order.
    pub values: Vec<Values<'v>>,
}

/// Values of a column: one a place, or one a row, `[place][step]`, row-major.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<'v> {
    Texts(Cow<'v, [String]>),
    Counts(Vec<u64>),
    /// Numbers of 64 bits, or of 32-bit columns, which keep an empty cell as NaN.
    Numbers(Vec<Option<f64>>),
    Floats(Cow<'v, [f32]>),
}

impl Values<'_> {
    /// Returns the number of values.
    pub fn count(&self) -> usize {
        match self {
            Values::Texts(texts) => texts.len(),
            Values::Counts(counts) => counts.len(),
            Values::Numbers(numbers) => numbers.len(),
            Values::Floats(floats) => floats.len(),
        }
    }

    /// Returns the texts; empty for numbers.
    pub fn texts(&self) -> &[String] {
        match self {
            Values::Texts(texts) => texts,
            _ => &[],
        }
    }

    /// Returns the values as 32-bit numbers; NaN for an empty cell, nothing for texts.
    pub fn floats(&self) -> Cow<'_, [f32]> {
        match self {
            Values::Floats(floats) => Cow::Borrowed(floats),
            Values::Numbers(numbers) => {
                Cow::Owned(numbers.iter().map(|number| number.map_or(f32::NAN, |number| number as f32)).collect())
            }
            Values::Counts(counts) => Cow::Owned(counts.iter().map(|count| *count as f32).collect()),
            Values::Texts(_) => Cow::Borrowed(&[]),
        }
    }

    fn is_of(&self, kind: Kind) -> bool {
        match kind {
            Kind::Text | Kind::Category => matches!(self, Values::Texts(_)),
            Kind::Count => matches!(self, Values::Counts(_)),
            Kind::Number(_) => matches!(self, Values::Numbers(_)),
            Kind::Float(_) => matches!(self, Values::Floats(_) | Values::Numbers(_)),
        }
    }
}

impl Batch<'_> {
    /// Returns a message if the values do not fit the columns of a table.
    pub fn misfit(&self, columns: &TableColumns) -> Option<String> {
        let expected = columns.in_batches().count();
        if self.values.len() != expected {
            return Some(format!("{} columns came where there are {expected}", self.values.len()));
        }
        for (column, values) in columns.in_batches().zip(&self.values) {
            let expected = match column.along {
                Along::Places => self.places,
                Along::Rows | Along::Bins(_) => self.places * columns.rows_of_place(),
            };
            if values.count() != expected {
                return Some(format!("column `{}` got {} values for {expected}", column.name, values.count()));
            }
            if !values.is_of(column.kind) {
                return Some(format!("column `{}` got values of another kind", column.name));
            }
        }
        None
    }
}
