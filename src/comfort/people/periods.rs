//! Values of days and longer periods from the hours of a point. In: values of hours. Out: means,
//! the highest, hours above thresholds.

use super::columns::ComfortColumn;
use crate::utci::StressCategory;
use heliotile_core::weather::time::bins::Bins;

/// Way in which a value of a period follows from its hours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PeriodSum {
    /// Mean, weighted by time.
    Mean,
    /// Highest value.
    Most,
    /// Hours above a threshold, degrees Celsius.
    Above(f64),
}

impl PeriodSum {
    /// Returns the UTCI at which moderate, strong, very strong and extreme heat stress begin,
    /// degrees Celsius.
    pub fn usual_thresholds_c() -> [f64; 4] {
        let [_, _, _, _, _, none, moderate, strong, very_strong, _] = StressCategory::ALL;
        [none, moderate, strong, very_strong].map(|below| below.upper_limit_c)
    }

    /// Returns the values of a column that rows of periods have.
    pub fn of_column(column: ComfortColumn, above_c: &[f64]) -> Vec<PeriodSum> {
        let above = above_c.iter().map(|above| PeriodSum::Above(*above)).filter(|_| column == ComfortColumn::Utci);
        let most = column.is_index().then_some(PeriodSum::Most);
        [PeriodSum::Mean].into_iter().chain(most).chain(above).collect()
    }

    /// Returns the name of this value of a period; `number` is the name of the hourly value.
    pub fn name(self, number: &str) -> String {
        let stem = number.trim_end_matches("_c");
        match self {
            PeriodSum::Mean => number.replacen(stem, &format!("{stem}_mean"), 1),
            PeriodSum::Most => number.replacen(stem, &format!("{stem}_max"), 1),
            PeriodSum::Above(above) => format!("{stem}_above_{above}_h"),
        }
    }

    /// Returns the values of periods, `[period]`, from those of hours; `hours` are lengths, NaN is
    /// no value.
    pub fn of_hours(self, values: &[f32], bins: &Bins, hours: &[f64]) -> Vec<f32> {
        let mut sums = vec![(0.0_f64, 0.0_f64); bins.count];
        let mut most = vec![f64::NAN; bins.count];
        for ((value, (label, _)), hours) in values.iter().zip(&bins.of_condition).zip(hours) {
            let value = f64::from(*value);
            let (Some(sum_of), Some(most)) = (sums.get_mut(*label), most.get_mut(*label)) else { continue };
            if value.is_nan() {
                continue;
            }
            *most = most.max(value);
            let counted = if let PeriodSum::Above(above) = self { f64::from(u8::from(value > above)) } else { value };
            sum_of.0 += counted * hours;
            sum_of.1 += hours;
        }
        let of_label = |((sum_of, hours), most): (&(f64, f64), &f64)| match self {
            PeriodSum::Above(_) if *hours > 0.0 => *sum_of as f32,
            PeriodSum::Most => *most as f32,
            _ if *hours > 0.0 => (sum_of / hours) as f32,
            _ => f32::NAN,
        };
        sums.iter().zip(&most).map(of_label).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means, the highest and hours above 26 of four hours in two periods, one hour without a
    /// value, are those computed by hand.
    #[test]
    fn periods_have_means_maxima_and_hours_by_hand() {
        let sums = PeriodSum::of_column(ComfortColumn::Utci, &[26.0]);
        let names: Vec<String> = sums.iter().map(|sum| sum.name("utci_c")).collect();
        assert_eq!(names, ["utci_mean_c", "utci_max_c", "utci_above_26_h"]);
        let bins = Bins { count: 2, of_condition: vec![(0, 1.0), (0, 1.0), (1, 1.0), (1, 1.0)] };
        let values = [20.0, 30.0, f32::NAN, 27.0];
        let rows: Vec<Vec<f32>> = sums.iter().map(|sum| sum.of_hours(&values, &bins, &[1.0, 1.0, 1.0, 0.5])).collect();
        assert_eq!(rows, [vec![25.0, 27.0], vec![30.0, 27.0], vec![1.0, 0.5]]);
    }

    /// Heat stress begins at 26, 32, 38 and 46 degrees. Irradiances have means only, and their
    /// names keep no unit.
    #[test]
    fn heat_stress_begins_at_its_four_limits() {
        assert_eq!(PeriodSum::usual_thresholds_c(), [26.0, 32.0, 38.0, 46.0]);
        let sums = PeriodSum::of_column(ComfortColumn::Longwave, &[26.0]);
        assert_eq!(
            (sums.as_slice(), PeriodSum::Mean.name("longwave_up")),
            (&[PeriodSum::Mean][..], "longwave_up_mean".into())
        );
    }
}
