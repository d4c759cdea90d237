//! Hours of sun at a receiver. In: a receiver's layers, the suns of the rows of a weather file.
//! Out: hours of each row, by the same lookups of the sun's disc in the receiver's sky as direct
//! irradiance.

use glam::DVec3;

use crate::layers::sides::TextureSides;
use crate::replay::direct::sun_samples::SunSamples;
use crate::replay::receiver_view::ReceiverView;
use crate::replay::sun_sample::SunSample;
use crate::site::north::North;

/// Suns of a row of a weather file.
#[derive(Clone, Debug, PartialEq)]
pub struct RowSuns {
    /// Directions of the sun within the interval, above the horizon; y points to true north.
    pub suns: Vec<DVec3>,
    /// Hours of the interval in which the sun's centre is above the horizon.
    pub up_h: f64,
    /// Direct normal irradiance, W/m2.
    pub dni_w_m2: f64,
}

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
    /// Computes the hours of the rows of a weather file. `north` is the direction of true north in
    /// the receiver's axes.
    pub fn new(view: &ReceiverView, rows: &[RowSuns], north: North) -> Self {
        let (normal, sides, count) = (view.receiver.normal, view.sides, rows.len());
        let (mut up_h, mut behind_h, mut seen_h) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let mut samples = Vec::new();
        for (bin, row) in rows.iter().enumerate().filter(|(_, row)| !row.suns.is_empty()) {
            up_h[bin] = row.up_h;
            let hours = row.up_h / row.suns.len() as f64;
            for sun in &row.suns {
                let direction = north.to_axes(*sun);
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
        let lit = |(row, seen): &(&RowSuns, &f64)| row.dni_w_m2 > 0.0 && **seen > 0.0;
        let sunny_rows = rows.iter().zip(&seen_h).filter(lit).count();
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
