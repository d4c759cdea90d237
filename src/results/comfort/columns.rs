//! Columns of comfort results. In: a request, the values of a point in each hour. Out: the numbers
//! of its rows.

use crate::outputs::periods::Every;
use crate::outputs::quantities::{Measure, Quantity, ValueSource};
use heliotile_comfort::people::columns::{ComfortColumn, PLANES};
use heliotile_comfort::people::periods::PeriodSum;
use heliotile_core::replay::components::LightMeasure;
use heliotile_core::weather::time::bins::Bins;

/// Number that is computed for each hour: an entry of the table of all numbers.
pub(super) struct HourNumber {
    column: ComfortColumn,
    name: String,
    words: String,
    measure: Measure,
}

/// Columns of the results.
pub(super) struct ComfortColumns {
    /// Numbers of an hour, `[number]`.
    numbers: Vec<HourNumber>,
    /// Index of the number behind each output array, `[array]`, and the statistic over periods;
    /// `None`: rows are hours.
    arrays: Vec<(usize, Option<PeriodSum>)>,
}

/// Returns the numbers of a column.
fn numbers_of(column: ComfortColumn) -> Vec<HourNumber> {
    let (words, measure) = match column {
        ComfortColumn::Air => ("air temperature", Measure::Celsius),
        ComfortColumn::Wind => ("wind at 10 m", Measure::Number),
        ComfortColumn::MeanRadiant => ("mean radiant temperature", Measure::Celsius),
        ComfortColumn::Utci => ("UTCI", Measure::Celsius),
        ComfortColumn::Pet => ("PET", Measure::Celsius),
        ComfortColumn::Shortwave => ("shortwave", Measure::Light(LightMeasure::Irradiance)),
        ComfortColumn::Longwave => ("longwave", Measure::Light(LightMeasure::Irradiance)),
    };
    let is_one = column.width() == 1;
    let number = |(name, plane): (String, &&str)| {
        let words =
            if is_one { words.to_owned() } else { format!("{words} irradiance of the plane that looks {plane}") };
        HourNumber { column, name, words, measure }
    };
    column.names().into_iter().zip(&PLANES).map(number).collect()
}

impl ComfortColumns {
    /// Returns the requested columns, in rows of hours or of longer periods.
    pub(super) fn new(asked: &[ComfortColumn], every: Every, above_c: &[f64]) -> Self {
        let asked = if asked.is_empty() { &ComfortColumn::USUAL } else { asked };
        // A column that is named twice stands where it is named first.
        let first = |(i, column): &(usize, &ComfortColumn)| asked.iter().position(|other| other == *column) == Some(*i);
        let asked = asked.iter().enumerate().filter(first).map(|(_, column)| *column);
        let numbers: Vec<HourNumber> = asked.flat_map(numbers_of).collect();
        let sums = |number: &HourNumber| match every {
            Every::Hour => vec![None],
            _ => PeriodSum::of_column(number.column, above_c).into_iter().map(Some).collect(),
        };
        let arrays =
            numbers.iter().enumerate().flat_map(|(i, number)| sums(number).into_iter().map(move |sum| (i, sum)));
        let arrays = arrays.collect();
        ComfortColumns { numbers, arrays }
    }

    /// Returns the requested columns, each once, in the order of the numbers.
    pub(super) fn asked(&self) -> impl Iterator<Item = ComfortColumn> + '_ {
        let mut last = None;
        self.numbers.iter().map(|number| number.column).filter(move |column| last.replace(*column) != Some(*column))
    }

    /// Returns the number of arrays of a point.
    pub(super) fn count(&self) -> usize {
        self.arrays.len()
    }

    /// Returns the columns as quantities for tables and maps.
    pub(super) fn quantities(&self) -> Vec<Quantity> {
        let quantity = |(array, (number, sum)): (usize, &(usize, Option<PeriodSum>))| {
            let number = self.numbers.get(*number)?;
            let name = sum.map_or_else(|| number.name.clone(), |sum| sum.name(&number.name));
            let (words, measure) = match sum {
                None => (number.words.clone(), number.measure),
                Some(PeriodSum::Mean) => (format!("{}, mean", number.words), number.measure),
                Some(PeriodSum::Most) => (format!("{}, highest", number.words), number.measure),
                Some(PeriodSum::Above(above)) => (format!("hours of {} above {above} C", number.words), Measure::Hours),
            };
            Some(Quantity { name, words, source: ValueSource::Array(array), measure })
        };
        self.arrays.iter().enumerate().filter_map(quantity).collect()
    }

    /// Returns the arrays of a point, `[array][label]`, from the numbers of its hours,
    /// `[number][hour]`. `hours` are the lengths of the hours; NaN means no value.
    pub(super) fn rows(&self, values: &[Vec<f32>], bins: &Bins, hours: &[f64]) -> Vec<Vec<f32>> {
        let of_array = |(number, sum): &(usize, Option<PeriodSum>)| {
            let values = values.get(*number).map(Vec::as_slice).unwrap_or_default();
            sum.map_or_else(|| values.to_vec(), |sum| sum.of_hours(values, bins, hours))
        };
        self.arrays.iter().map(of_array).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of days have three arrays of the UTCI, in this order; rows of hours have one for each
    /// of the six planes, and a column is returned once.
    #[test]
    fn hours_have_one_array_for_each_plane() {
        let columns = ComfortColumns::new(&[ComfortColumn::Utci], Every::Day, &[26.0]);
        let names: Vec<String> = columns.quantities().into_iter().map(|one| one.name).collect();
        assert_eq!(names, ["utci_mean_c", "utci_max_c", "utci_above_26_h"]);
        let bins = Bins { count: 1, of_condition: vec![(0, 1.0), (0, 1.0)] };
        assert_eq!(columns.rows(&[vec![20.0, 30.0]], &bins, &[1.0, 1.0]), [vec![25.0], vec![30.0], vec![1.0]]);
        let hours = ComfortColumns::new(&[ComfortColumn::Shortwave], Every::Hour, &[]);
        assert_eq!((hours.count(), hours.asked().count()), (6, 1));
    }
}
