//! Place of time stamps by a column of the sun's zenith. In: rows with the zenith angles of a file.
//! Out: the place in the interval at which each angle is that of the row's light.

use crate::judging::raw_weather::RawRow;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::time::sun::Location;

/// Largest zenith angle that is compared, degrees: refraction matters beyond it.
const LARGEST_ZENITH_DEG: f64 = 85.0;

/// Least number of rows that are compared.
const FEWEST_ROWS: usize = 6;

/// Largest RMS of the differences at the place that is taken, degrees.
const LARGEST_RMS_DEG: f64 = 1.0;

/// Least ratio of the next larger RMS to the one that is taken.
const MIN_RATIO: f64 = 3.0;

/// Returns the place of time stamps in their intervals. An angle of the moment of the stamp belongs
/// to values of this moment, which stand for the interval around it; an angle of half a step later
/// or earlier belongs to means after or before the stamp. `None` if no place fits clearly.
pub fn place_by_zenith(
    rows: &[RawRow],
    zenith_deg: &[Option<f64>],
    site: &Location,
    stamped_at: StampedAt,
) -> Option<StampedAt> {
    let places = [(StampedAt::Start, 0.5), (StampedAt::Middle, 0.0), (StampedAt::End, -0.5)];
    let pairs = || rows.iter().zip(zenith_deg).filter_map(|(row, zenith)| Some((row, (*zenith)?)));
    let high = || pairs().filter(|(_, zenith)| (0.0..LARGEST_ZENITH_DEG).contains(zenith));
    let count = high().count();
    if count < FEWEST_ROWS {
        return None;
    }
    let rms = |share_after: f64| {
        let sum: f64 = high()
            .map(|(row, zenith)| {
                let step_min = row.interval.end_min - row.interval.start_min;
                let at_min = row.interval.start_min + (stamped_at.share_before() + share_after) * step_min;
                let sun = site.sun(row.interval.date, at_min);
                (sun.z.clamp(-1.0, 1.0).acos().to_degrees() - zenith).powi(2)
            })
            .sum();
        (sum / count as f64).sqrt()
    };
    let mut all = places.map(|(place, share)| (rms(share), place));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(best, place), (next, _), _] = all;
    (best <= LARGEST_RMS_DEG && next > MIN_RATIO * best).then_some(place)
}
