//! Columns of results about comfort. In: what is asked, the values of a place in each hour. Out: the numbers of its rows.

use std::str::FromStr;

use crate::outputs::periods::Every;
use crate::outputs::quantities::{Measure, Quantity, ValueSource};
use heliotile_core::named::{NamedValues, of_name};
use heliotile_core::replay::components::LightMeasure;
use heliotile_core::weather::time::bins::Bins;

/// What a column says, or six of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComfortColumn {
    /// Air temperature.
    Air,
    /// Wind at 10 m.
    Wind,
    /// Mean radiant temperature.
    MeanRadiant,
    /// Universal Thermal Climate Index.
    Utci,
    /// Physiological Equivalent Temperature.
    Pet,
    /// Shortwave irradiance of the six planes.
    Shortwave,
    /// Longwave irradiance of the six planes.
    Longwave,
}

/// Names of the planes, in the order of values.
pub(super) const PLANES: [&str; 6] = ["up", "down", "north", "east", "south", "west"];

/// What a number of an hour is: a row of the table of all numbers.
pub(super) struct HourNumber {
    column: ComfortColumn,
    name: String,
    words: String,
    measure: Measure,
}

/// How a row of a period follows from its hours.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sum {
    /// The hour itself.
    Hour,
    Mean,
    Most,
    /// Hours above a threshold.
    Above(f64),
}

/// The columns of results.
pub(super) struct ComfortColumns {
    /// `[number]`: of an hour.
    numbers: Vec<HourNumber>,
    /// `[array]`: a number, and what rows say of it.
    arrays: Vec<(usize, Sum)>,
}

impl ComfortColumn {
    /// The columns of results, if none are asked for.
    pub const USUAL: [ComfortColumn; 3] = [ComfortColumn::MeanRadiant, ComfortColumn::Utci, ComfortColumn::Pet];

    fn is_index(self) -> bool {
        matches!(self, ComfortColumn::Utci | ComfortColumn::Pet)
    }

    fn numbers(self) -> Vec<HourNumber> {
        let one = |name: &str, words: &str, measure| {
            vec![HourNumber { column: self, name: name.to_owned(), words: words.to_owned(), measure }]
        };
        let six = |kind: &str| {
            let of_plane = |plane: &&str| HourNumber {
                column: self,
                name: format!("{kind}_{plane}"),
                words: format!("{kind} irradiance of the plane that looks {plane}"),
                measure: Measure::Light(LightMeasure::Irradiance),
            };
            PLANES.iter().map(of_plane).collect()
        };
        match self {
            ComfortColumn::Air => one("air_c", "air temperature", Measure::Celsius),
            ComfortColumn::Wind => one("wind_m_s", "wind at 10 m", Measure::Number),
            ComfortColumn::MeanRadiant => one("mrt_c", "mean radiant temperature", Measure::Celsius),
            ComfortColumn::Utci => one("utci_c", "UTCI", Measure::Celsius),
            ComfortColumn::Pet => one("pet_c", "PET", Measure::Celsius),
            ComfortColumn::Shortwave => six("shortwave"),
            ComfortColumn::Longwave => six("longwave"),
        }
    }
}

impl ComfortColumns {
    /// Of what is asked, in rows of hours or of longer periods.
    pub(super) fn new(asked: &[ComfortColumn], every: Every, above_c: &[f64]) -> Self {
        let asked = if asked.is_empty() { &ComfortColumn::USUAL } else { asked };
        let numbers: Vec<HourNumber> = asked.iter().flat_map(|column| column.numbers()).collect();
        let sums = |number: &HourNumber| match number.column {
            _ if every == Every::Hour => vec![Sum::Hour],
            ComfortColumn::Utci => {
                [Sum::Mean, Sum::Most].into_iter().chain(above_c.iter().map(|above| Sum::Above(*above))).collect()
            }
            column if column.is_index() => vec![Sum::Mean, Sum::Most],
            _ => vec![Sum::Mean],
        };
        let arrays =
            numbers.iter().enumerate().flat_map(|(i, number)| sums(number).into_iter().map(move |sum| (i, sum)));
        let arrays = arrays.collect();
        ComfortColumns { numbers, arrays }
    }

    /// What is asked for, a value an hour each, in the order of numbers.
    pub(super) fn asked(&self) -> impl Iterator<Item = ComfortColumn> + '_ {
        let mut last = None;
        self.numbers.iter().map(|number| number.column).filter(move |column| last.replace(*column) != Some(*column))
    }

    /// How many arrays a place has.
    pub(super) fn count(&self) -> usize {
        self.arrays.len()
    }

    /// The columns as tables and maps take them.
    pub(super) fn quantities(&self) -> Vec<Quantity> {
        let quantity = |(array, (number, sum)): (usize, &(usize, Sum))| {
            let number = self.numbers.get(*number)?;
            let stem = number.name.trim_end_matches("_c");
            let (name, words, measure) = match sum {
                Sum::Hour => (number.name.clone(), number.words.clone(), number.measure),
                Sum::Mean => (
                    number.name.replacen(stem, &format!("{stem}_mean"), 1),
                    format!("{}, mean", number.words),
                    number.measure,
                ),
                Sum::Most => (
                    number.name.replacen(stem, &format!("{stem}_max"), 1),
                    format!("{}, highest", number.words),
                    number.measure,
                ),
                Sum::Above(above) => (
                    format!("{stem}_above_{above}_h"),
                    format!("hours of {} above {above} C", number.words),
                    Measure::Hours,
                ),
            };
            Some(Quantity { name, words, source: ValueSource::Array(array), measure })
        };
        self.arrays.iter().enumerate().filter_map(quantity).collect()
    }

    /// The numbers of a place, `[array][label]`, from those of its hours, `[number][hour]`; `hours` are lengths, NaN is no value.
    pub(super) fn rows(&self, values: &[Vec<f32>], bins: &Bins, hours: &[f64]) -> Vec<Vec<f32>> {
        let of_array = |(number, sum): &(usize, Sum)| {
            let values = values.get(*number).map(Vec::as_slice).unwrap_or_default();
            if *sum == Sum::Hour {
                return values.to_vec();
            }
            let mut sums = vec![(0.0_f64, 0.0_f64); bins.count];
            let mut most = vec![f64::NAN; bins.count];
            for ((value, (label, _)), hours) in values.iter().zip(&bins.of_condition).zip(hours) {
                let value = f64::from(*value);
                let (Some(sum_of), Some(most)) = (sums.get_mut(*label), most.get_mut(*label)) else { continue };
                if value.is_nan() {
                    continue;
                }
                *most = most.max(value);
                let counted = if let Sum::Above(above) = sum { f64::from(u8::from(value > *above)) } else { value };
                sum_of.0 += counted * hours;
                sum_of.1 += hours;
            }
            let of_label = |((sum_of, hours), most): (&(f64, f64), &f64)| match sum {
                Sum::Above(_) if *hours > 0.0 => *sum_of as f32,
                Sum::Most => *most as f32,
                _ if *hours > 0.0 => (sum_of / hours) as f32,
                _ => f32::NAN,
            };
            sums.iter().zip(&most).map(of_label).collect()
        };
        self.arrays.iter().map(of_array).collect()
    }
}

impl FromStr for ComfortColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        of_name(text)
    }
}

impl NamedValues for ComfortColumn {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("air", "Air temperature", ComfortColumn::Air),
        ("wind", "Wind at 10 m", ComfortColumn::Wind),
        ("mrt", "Mean radiant temperature", ComfortColumn::MeanRadiant),
        ("utci", "Universal Thermal Climate Index", ComfortColumn::Utci),
        ("pet", "Physiological Equivalent Temperature", ComfortColumn::Pet),
        ("shortwave", "Shortwave irradiance of six planes", ComfortColumn::Shortwave),
        ("longwave", "Longwave irradiance of six planes", ComfortColumn::Longwave),
    ];
}

heliotile_core::serde_by_name!(ComfortColumn);

#[cfg(test)]
mod tests {
    use super::*;

    /// Of four hours in two periods, one without a value, means, the highest and hours above 26 are those by hand.
    #[test]
    fn periods() {
        let columns = ComfortColumns::new(&[ComfortColumn::Utci], Every::Day, &[26.0]);
        let names: Vec<String> = columns.quantities().into_iter().map(|one| one.name).collect();
        assert_eq!(names, ["utci_mean_c", "utci_max_c", "utci_above_26_h"]);
        let bins = Bins { count: 2, of_condition: vec![(0, 1.0), (0, 1.0), (1, 1.0), (1, 1.0)] };
        let values = [vec![20.0, 30.0, f32::NAN, 27.0]];
        let rows = columns.rows(&values, &bins, &[1.0, 1.0, 1.0, 0.5]);
        assert_eq!(rows, [vec![25.0, 27.0], vec![30.0, 27.0], vec![1.0, 0.5]]);
        let hours = ComfortColumns::new(&[ComfortColumn::Shortwave], Every::Hour, &[]);
        assert_eq!((hours.count(), hours.asked().count()), (6, 1));
    }
}
