//! Hours of sun at a receiver. In: a receiver's layers, the rows of a weather file. Out: hours of
//! each row, by the same lookups of the sun's disc in the receiver's sky as direct irradiance.

use crate::layers::sides::TextureSides;
use crate::replay::direct::sun_samples::SunSamples;
use crate::replay::receiver_view::ReceiverView;
use crate::replay::sun_sample::SunSample;
use crate::site::north::North;
use crate::weather::row::WeatherRow;
use crate::weather::series::Weather;

/// Hours of sun at a receiver without regard to clouds, which DNI accounts for.
#[derive(Clone, Debug, PartialEq)]
pub struct SunHours {
    /// `[row]`: hours in which the sun's centre is above the horizon.
    pub up_h: Vec<f64>,
    /// `[row]`: hours in which the receiver sees the sun. A partly hidden disc counts by its
    /// visible share, and a disc behind canopies by the share that they let through.
    pub seen_h: Vec<f64>,
    /// `[row]`: hours in which the sun stands behind the receiver's own surface.
    pub behind_h: Vec<f64>,
    /// Number of rows with direct irradiance at the receiver: the sun is seen, and the row's DNI is
    /// not 0.
    pub sunny_rows: usize,
}

impl SunHours {
    /// Computes the hours of a weather file's rows with `steps` positions of the sun in each.
    /// `north` is the direction of true north in the receiver's axes.
    pub fn of(view: &ReceiverView, weather: &Weather, steps: usize, north: North) -> Self {
        let (normal, sides, count) = (view.receiver.normal, view.sides, weather.rows.len());
        let (mut up_h, mut behind_h, mut seen_h) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let mut samples = Vec::new();
        for (bin, row) in weather.rows.iter().enumerate() {
            let suns = weather.site.sunlit(&row.interval, weather.known_suns(bin, row), steps);
            if suns.is_empty() {
                continue;
            }
            up_h[bin] = weather.site.sunlit_hours(&row.interval, weather.known_suns(bin, row));
            let hours = up_h[bin] / suns.len() as f64;
            for sun in suns {
                let direction = north.to_axes(sun);
                let cos = normal.dot(direction);
                match cos > 0.0 {
                    // An irradiance is strength x cosine x visible share, so this strength makes it
                    // hours x visible share.
                    true => samples.push(SunSample { bin, strength: hours / cos, direction }),
                    false => behind_h[bin] += hours,
                }
            }
        }
        add_seen(view, samples, sides, &mut seen_h);
        // Shares of a disc are f32 and may add up to a little more than 1.
        seen_h.iter_mut().zip(up_h.iter().zip(&behind_h)).for_each(|(seen, (up, behind))| {
            *seen = seen.min((up - behind).max(0.0));
        });
        let lit = |(row, seen): &(&WeatherRow, &f64)| row.dni_w_m2 > 0.0 && **seen > 0.0;
        let sunny_rows = weather.rows.iter().zip(&seen_h).filter(lit).count();
        SunHours { up_h, seen_h, behind_h, sunny_rows }
    }

    /// Returns sums over all rows: hours in which the sun is up, seen, hidden by surroundings, and
    /// behind the surface. The last three add up to the first.
    pub fn sums(&self) -> [f64; 4] {
        let [up, seen, behind] = [&self.up_h, &self.seen_h, &self.behind_h].map(|hours| hours.iter().sum::<f64>());
        [up, seen, up - seen - behind, behind]
    }
}

fn add_seen(view: &ReceiverView, samples: Vec<SunSample>, sides: TextureSides, seen_h: &mut [f64]) {
    let (normal, suns) = (view.receiver.normal, SunSamples::new(samples, sides));
    match view.veil() {
        None => suns.direct_seen(normal, &mut &view.sky, seen_h),
        Some(veil) => suns.direct_behind(normal, &mut &view.sky, &veil, seen_h),
    }
}
