//! Findings about the rows of a weather file. In: rows of each kind. Out: counts, and one sentence
//! a kind.

use heliotile_core::text::{Message, message};
use heliotile_core::units::kwh_from_w;

/// Kinds of findings. The first four are gaps: the values that a row lacks among GHI, DNI and DHI
/// decide how it is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Finding {
    /// DNI is missing and is computed from GHI and DHI.
    ComputedDni,
    /// DHI is missing and is computed from GHI and DNI.
    ComputedDhi,
    /// DNI and DHI are both missing, and GHI is split.
    SplitGhi,
    /// DNI or DHI is missing and so is GHI; the row is set to 0.
    Zeroed,
    /// Small negative irradiances are taken as 0.
    Negative,
    /// DNI with the sun below the horizon throughout is left out.
    BelowHorizon,
    /// DHI of at most [`DARK_GHI_W_M2`] after the end of civil twilight is left out.
    NightOffset,
    /// GHI above [`DARK_GHI_W_M2`] with the sun below the horizon throughout is used unchanged.
    GhiBelowHorizon,
    /// DNI is above the irradiance outside the atmosphere and is used unchanged.
    AboveExtraterrestrial,
    /// DHI is above GHI by more than 10 % and is used unchanged.
    DhiAboveGhi,
    /// Infrared radiation is missing and is computed from temperature, dew point and clouds.
    ComputedInfrared,
}

/// Largest GHI of an interval without sun that is no finding, W/m2: twilight gives less.
pub const DARK_GHI_W_M2: f64 = 20.0;

const KINDS: [Finding; 11] = [
    Finding::ComputedDni,
    Finding::ComputedDhi,
    Finding::SplitGhi,
    Finding::Zeroed,
    Finding::Negative,
    Finding::BelowHorizon,
    Finding::NightOffset,
    Finding::GhiBelowHorizon,
    Finding::AboveExtraterrestrial,
    Finding::DhiAboveGhi,
    Finding::ComputedInfrared,
];

/// Count of the rows of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Number of rows.
    pub rows: usize,
    /// Total length of the rows, hours.
    pub hours: f64,
    /// Energy of the DNI of these rows, of [`Finding::NightOffset`] of the DHI, kWh/m2.
    pub kwh_m2: f64,
    /// Line of the first row, counted from 1.
    pub first_line: usize,
}

impl Tally {
    /// Returns the hours, rounded to remove the noise of adding minutes.
    pub fn tidy_hours(&self) -> f64 {
        (self.hours * 1e3).round() / 1e3
    }
}

/// Counts of all kinds.
#[derive(Clone, Debug, Default)]
pub struct Findings([Tally; KINDS.len()]);

impl Findings {
    /// Counts a row of `hours`; lines come in rising order.
    pub fn add(&mut self, kind: Finding, line: usize, hours: f64, w_m2: f64) {
        if let Some(tally) = self.0.get_mut(kind as usize) {
            if tally.rows == 0 {
                tally.first_line = line;
            }
            tally.rows += 1;
            tally.hours += hours;
            tally.kwh_m2 += kwh_from_w(w_m2, hours);
        }
    }

    /// Returns the count of one kind; zeros where it does not occur.
    pub fn of(&self, kind: Finding) -> Tally {
        self.0.get(kind as usize).copied().unwrap_or_default()
    }

    /// Iterates over a sentence for each kind that occurs, with the line of its first row.
    pub fn sentences(&self) -> impl Iterator<Item = (usize, Message)> {
        KINDS.into_iter().map(|kind| (kind, self.of(kind))).filter(|(_, tally)| tally.rows > 0).map(|(kind, tally)| {
            let Tally { kwh_m2, first_line, .. } = tally;
            let hours = tally.tidy_hours();
            let sentence = match kind {
                Finding::ComputedDni => message!("missing DNI of {hours} hours computed from GHI = DHI + DNI cos(z)"),
                Finding::ComputedDhi => message!("missing DHI of {hours} hours computed from GHI = DHI + DNI cos(z)"),
                Finding::SplitGhi => message!(
                    "missing DNI and DHI of {hours} hours estimated from GHI (Erbs 1982; single hours may be off by 100 \
                     W/m2 and more)"
                ),
                Finding::Zeroed => {
                    message!("DNI or DHI of {hours} hours is missing and so is GHI: set to 0, sums are too low")
                }
                Finding::Negative => message!("small negative irradiances of {hours} hours set to 0"),
                Finding::BelowHorizon => {
                    message!("DNI with the sun below the horizon in {hours} hours, {kwh_m2:.3} kWh/m2, is left out")
                }
                Finding::NightOffset => message!(
                    "light of {hours} hours with the sun more than 6 degrees below the horizon, {kwh_m2:.3} kWh/m2, is \
                     an offset of the instrument and is left out"
                ),
                Finding::GhiBelowHorizon => message!(
                    "GHI above {DARK_GHI_W_M2} W/m2 with the sun below the horizon in {hours} hours: check the time zone \
                     and the time stamps ({{time_zone}}, {{weather_stamp}}, {{shift}})"
                ),
                Finding::AboveExtraterrestrial => message!(
                    "DNI above what arrives outside the atmosphere in {hours} hours, {kwh_m2:.3} kWh/m2, is \
                     used unchanged; check these rows"
                ),
                Finding::DhiAboveGhi => message!(
                    "DHI above GHI by more than 10 % in {hours} hours; DNI and DHI are used unchanged; check these \
                     rows"
                ),
                Finding::ComputedInfrared => message!(
                    "missing infrared radiation of {hours} hours computed from dry bulb, dew point and opaque sky cover \
                     (Clark and Allen 1978, Walton 1983)"
                ),
            };
            (first_line, sentence)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kinds stand in the list in the order of their numbers, 11 of 11, so that each is counted in
    /// its own place. The first line is kept, hours and energy add up to 1.5 h and 1.6 kWh/m2.
    #[test]
    fn findings_are_counted_by_kind() {
        assert!(KINDS.iter().enumerate().all(|(i, kind)| *kind as usize == i));
        let mut findings = Findings::default();
        findings.add(Finding::BelowHorizon, 12, 1.0, 800.0);
        findings.add(Finding::BelowHorizon, 14, 0.5, 1600.0);
        let expected = Tally { rows: 2, hours: 1.5, kwh_m2: 1.6, first_line: 12 };
        assert_eq!(findings.of(Finding::BelowHorizon), expected);
        let told: Vec<_> = findings.sentences().collect();
        assert_eq!(told.len(), 1);
        assert!(told[0].0 == 12 && told[0].1.contains("in 1.5 hours, 1.600 kWh/m2"), "{told:?}");
    }
}
