//! Percentiles of years. In: values of the years of a series. Out: P90, P50 and P10: the values
//! that are exceeded in 90, 50 and 10 % of the years.

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::values::TileValues;
use heliotile_core::text::{counted, message};

use super::series::Series;
use crate::outputs::tables::bin_labels::BinLabels;

/// Percentiles with the share of years below each.
const PERCENTILES: [(&str, f64); 3] = [("P90", 0.1), ("P50", 0.5), ("P10", 0.9)];

/// Least number of complete years, and the least that give ends which are not mere extremes.
const MIN_YEARS: usize = 3;
const ENOUGH_YEARS: usize = 10;

/// Share of the hours of the longest year that a complete year has at least: 29 February and lost
/// days may be missing.
const COMPLETE: f64 = 0.99;

/// Percentiles of the complete years of a series.
#[derive(Clone, Debug, PartialEq)]
pub struct Percentiles {
    /// Labels that are complete years.
    years: Vec<usize>,
}

impl Percentiles {
    /// Returns percentiles of the years of a series, and says how many years they are of. Fails if
    /// there are too few.
    pub fn new(series: &Series, observer: &dyn Observer) -> Result<Self> {
        Self::of_complete(series, observer).map_err(|count| {
            let what = message!("{} has {}", series.source.display(), counted(count as u64, "complete year"));
            let hint = format!(
                "give a file of at least {MIN_YEARS}, better {ENOUGH_YEARS} years, such as an hourly series of PVGIS, or a folder of EPW files; a typical year is one"
            );
            Error::argument("percentiles", what, hint).because(Problem::Lacks("years"))
        })
    }

    /// Returns percentiles of the complete years of a series, and says how many they are; an error
    /// is their number if it is too small.
    pub fn of_complete(series: &Series, observer: &dyn Observer) -> std::result::Result<Self, usize> {
        let mut hours = vec![0.0; series.labels.len()];
        for (label, weight) in &series.bins.of_condition {
            hours.get_mut(*label).into_iter().for_each(|sum| *sum += weight);
        }
        let longest = hours.iter().copied().fold(0.0, f64::max);
        let years: Vec<usize> = (0..hours.len()).filter(|year| hours[*year] >= COMPLETE * longest).collect();
        let (count, file) = (years.len(), series.source.display());
        if count < MIN_YEARS {
            return Err(count);
        }
        let name = |year: &usize| series.labels.text.get(*year).map_or("", String::as_str);
        let (first, last) = (years.first().map_or("", name), years.last().map_or("", name));
        let left_out = match hours.len() - count {
            0 => String::new(),
            left => format!("; {} left out", counted(left as u64, "incomplete year")),
        };
        let few = if count < ENOUGH_YEARS { ", too few for P90 and P10 to be more than a hint" } else { "" };
        let text = message!("{file}: percentiles of {count} years, {first} to {last}{left_out}{few}");
        if few.is_empty() {
            observer.note(text)
        } else {
            observer.warn(text)
        }
        Ok(Percentiles { years })
    }

    /// Returns the labels of rows.
    pub fn labels() -> BinLabels {
        BinLabels::words(PERCENTILES.iter().map(|(name, _)| (*name).to_owned()).collect())
    }

    /// Returns the number of complete years.
    pub fn years(&self) -> usize {
        self.years.len()
    }

    /// Returns P90, P50 and P10 of the values of all years, linear between the years beside one
    /// (Hyndman and Fan 1996, definition 7).
    pub fn of_years(&self, values: &[f64]) -> [f64; PERCENTILES.len()] {
        let mut sorted: Vec<f64> = self.years.iter().filter_map(|year| values.get(*year)).copied().collect();
        sorted.sort_by(f64::total_cmp);
        PERCENTILES.map(|(_, below)| quantile(&sorted, below))
    }

    /// Returns the percentiles of each component of a tile by itself.
    pub fn of(&self, values: &TileValues, components: ComponentSet) -> TileValues {
        let mut found = TileValues::new(values.receivers(), PERCENTILES.len());
        for component in components.iter() {
            for receiver in 0..values.receivers() {
                let years = values.row(component, receiver).iter().copied().map(f64::from);
                let of_row = self.of_years(&years.collect::<Vec<f64>>());
                let to = found.row_mut(component, receiver).iter_mut();
                to.zip(of_row).for_each(|(to, value)| *to = value as f32);
            }
        }
        found
    }
}

/// Returns the value that a share of sorted values lies below; NaN without values.
fn quantile(sorted: &[f64], below: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = below * last as f64;
    let low = (place as usize).min(last);
    let [a, b] = [low, (low + 1).min(last)].map(|at| sorted.get(at).copied().unwrap_or(f64::NAN));
    a + (place - low as f64) * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares of 0.1, 0.5 and 0.9 of 11 values from 0 to 100 lie below 10, 50 and 90; those of 4
    /// values lie between two, as NumPy's do; one value is all of its percentiles.
    #[test]
    fn quantiles_are_those_of_numpy() {
        let eleven: Vec<f64> = (0..11).map(|i| 10.0 * f64::from(i)).collect();
        assert_eq!([0.1, 0.5, 0.9].map(|below| quantile(&eleven, below)), [10.0, 50.0, 90.0]);
        let four = [1.0, 2.0, 4.0, 8.0].as_slice();
        for (below, right) in [(0.1, 1.3), (0.5, 3.0), (0.9, 6.8), (1.0, 8.0)] {
            assert!((quantile(four, below) - right).abs() < 1e-12, "{below}");
        }
        assert_eq!(quantile(&[5.0], 0.9), 5.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
