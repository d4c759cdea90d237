//! Hours that are too hot for an index. In: such hours, point by point. Out: warnings that count
//! them.

use std::collections::BTreeSet;

use heliotile_comfort::people::columns::ComfortColumn;
use heliotile_comfort::people::light::PersonNumbers;
use heliotile_comfort::utci::MAX_RADIANT_EXCESS_K;
use heliotile_core::text::counted;

/// Counts of hours without a UTCI or a PET for heat.
#[derive(Clone, Debug, Default)]
pub(super) struct HoursBeyond {
    utci: Tally,
    pet: Tally,
}

#[derive(Clone, Debug, Default)]
struct Tally {
    points: BTreeSet<usize>,
    /// Lower bound and length of each hour, degrees Celsius and hours.
    hours: Vec<(f64, f64)>,
}

impl HoursBeyond {
    /// Counts the hours of a point; `hours` are their lengths.
    pub(super) fn add(&mut self, point: usize, numbers: &PersonNumbers, hours: &[f64]) {
        for beyond in &numbers.beyond {
            let tally = if beyond.column == ComfortColumn::Utci { &mut self.utci } else { &mut self.pet };
            tally.points.insert(point);
            tally.hours.push((beyond.least_c, hours.get(beyond.hour).copied().unwrap_or_default()));
        }
    }

    /// Returns a warning for each index that lacks hours; `above_c` are the thresholds of the UTCI.
    pub(super) fn warnings(&self, above_c: &[f64], is_hourly: bool) -> Vec<String> {
        let cause = format!("the mean radiant temperature is more than {MAX_RADIANT_EXCESS_K} K above the air there");
        let utci = self.utci.warning("UTCI", &cause, above_c, is_hourly);
        let pet = self.pet.warning("PET", "the mean radiant temperature is too high there", &[], is_hourly);
        utci.into_iter().chain(pet).collect()
    }
}

impl Tally {
    fn warning(&self, index: &str, cause: &str, above_c: &[f64], is_hourly: bool) -> Option<String> {
        if self.hours.is_empty() {
            return None;
        }
        let sum = |least_c: f64| self.hours.iter().filter(|hour| hour.0 > least_c).map(|hour| hour.1).sum::<f64>();
        let all = rounded(sum(f64::NEG_INFINITY));
        let above: Vec<String> =
            above_c.iter().map(|above| format!("{} h above {above} C", rounded(sum(*above)))).collect();
        let at_least = match above.is_empty() {
            true => String::new(),
            false => format!("; of these hours at least {}", above.join(", ")),
        };
        let taken = match is_hourly {
            true => "their cells are empty",
            false => "means, maxima and sums take its highest value in range for them, a lower bound",
        };
        let points = counted(self.points.len() as u64, "point");
        Some(format!("the {index} has no value in {all} h at {points}: {cause}; {taken}{at_least}"))
    }
}

/// Returns hours to a tenth.
fn rounded(hours: f64) -> f64 {
    (10.0 * hours).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_comfort::people::light::BeyondIndex;

    /// Three intervals lie beyond the UTCI at two points, one of half an hour: 2.5 h are
    /// counted and 2 of them lie above 32 C; the missing value becomes its bound.
    #[test]
    fn hot_hours_are_counted_with_their_bounds() {
        let beyond = |hour, least_c| BeyondIndex { column: ComfortColumn::Utci, number: 0, hour, least_c };
        let values = vec![vec![f32::NAN, 20.0, f32::NAN]];
        let mut one = PersonNumbers { values, beyond: vec![beyond(0, 40.0), beyond(2, 30.0)] };
        let other = PersonNumbers { values: vec![vec![f32::NAN]], beyond: vec![beyond(0, 33.0)] };
        let (mut found, hours) = (HoursBeyond::default(), [1.0, 1.0, 0.5]);
        found.add(0, &one, &hours);
        found.add(1, &other, &hours);
        let warnings = found.warnings(&[26.0, 32.0], false);
        assert_eq!(warnings.len(), 1);
        let first = warnings.concat();
        assert!(first.starts_with("the UTCI has no value in 2.5 h at 2 points: "), "{first}");
        assert!(first.ends_with("of these hours at least 2.5 h above 26 C, 2 h above 32 C"), "{first}");
        one.bound();
        assert_eq!(one.values, [[40.0, 20.0, 30.0]]);
        assert!(HoursBeyond::default().warnings(&[26.0], true).is_empty());
    }
}
