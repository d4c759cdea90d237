//! Photographs of the sky. In: the pixels of a square picture in the equidistant (angular)
//! projection of fisheye lenses. Out: the pixel in a direction, means of patches.
//!
//! The camera faces up: the circle that fits into the square is the horizon, its middle the zenith,
//! and the distance from the middle is proportional to the zenith angle. With north at the top,
//! east is on the left, as in hemispherical photography from below. Radiance's `-vta -vh 180 -vv
//! 180 -vd 0 0 1 -vu 0 1 0` makes the same picture.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};

use crate::dome::grid::PatchGrid;
use crate::dome::series::PatchSeries;

/// Factor of the subdivision that photographs are averaged on: 9217 patches, rows of 1.6 degrees.
const FACTOR: usize = 8;

/// Least number of points across a picture, so that each patch has some.
const POINTS: usize = 1024;

/// Number of sectors that a picture is summed over before its top is turned: each patch has a whole
/// number of them, and a degree has sixteen.
const SECTORS: usize = 5760;

/// A square picture of the sky, one number a pixel. Copies share the pixels.
#[derive(Clone, Debug)]
pub struct DomeImage {
    side: usize,
    /// `[row][column]`: values of the pixels; the first row is the top.
    numbers: Arc<[f32]>,
    /// Sums over sectors, computed at the first use; they do not depend on the azimuth of the top.
    sectors: Arc<OnceLock<Vec<DVec2>>>,
    /// Azimuth of the top, turns clockwise from true north.
    top_turns: f64,
    /// Sine and cosine of the azimuth of the top.
    top: DVec2,
}

impl DomeImage {
    /// Returns a picture of `side` x `side` pixels whose top has this azimuth; `None` if the number
    /// of pixels is another one.
    pub fn new(side: usize, numbers: Vec<f32>, top_azimuth_deg: f64) -> Option<Self> {
        let fits = side > 0 && numbers.len() == side * side;
        let (numbers, sectors) = (numbers.into(), Arc::default());
        let image = DomeImage { side, numbers, sectors, top_turns: 0.0, top: DVec2::Y };
        fits.then(|| image.turned(top_azimuth_deg))
    }

    /// Returns a copy of the picture whose top has the azimuth `top_azimuth_deg`.
    #[must_use]
    pub fn turned(&self, top_azimuth_deg: f64) -> Self {
        let (sin, cos) = top_azimuth_deg.to_radians().sin_cos();
        DomeImage { top_turns: top_azimuth_deg / 360.0, top: DVec2::new(sin, cos), ..self.clone() }
    }

    /// Iterates over the pixels inside the circle: column, row, value.
    pub fn inside(&self) -> impl Iterator<Item = (usize, usize, f32)> {
        let (side, half) = (self.side, 0.5 * self.side as f64);
        self.numbers.iter().enumerate().map(move |(i, number)| (i % side, i / side, *number)).filter(
            move |(column, row, _)| DVec2::new(*column as f64 + 0.5 - half, *row as f64 + 0.5 - half).length() <= half,
        )
    }

    /// Returns the value of the pixel in a direction by true east, true north and up. A direction
    /// below the horizon gets the pixel at the horizon.
    pub fn at(&self, direction: DVec3) -> f32 {
        let radius = direction.z.clamp(0.0, 1.0).acos() / FRAC_PI_2;
        // Sine and cosine of the azimuth counted from the top.
        let (DVec2 { x: sin, y: cos }, top) = (direction.truncate().normalize_or_zero(), self.top);
        self.level(-radius * DVec2::new(sin * top.y - cos * top.x, cos * top.y + sin * top.x))
    }

    /// Returns the value at a point of the unit circle, right and down of its middle. If the middle
    /// of its pixel is outside the circle, the next pixel inwards is taken, because pixels outside
    /// may hold anything.
    fn level(&self, point: DVec2) -> f32 {
        let half = 0.5 * self.side as f64;
        let place = |offset: f64| ((half * (1.0 + offset)).max(0.0) as usize).min(self.side - 1);
        let middle = |offset: f64| (place(offset) as f64 + 0.5) / half - 1.0;
        let is_outside = DVec2::new(middle(point.x), middle(point.y)).length() > 1.0;
        // Moving by half a diagonal of a pixel gives a pixel whose middle is inside.
        let point = if is_outside { point * (1.0 - 1.42 / self.side as f64).max(0.0) } else { point };
        self.numbers.get(place(point.y) * self.side + place(point.x)).copied().unwrap_or_default()
    }

    /// Returns means by solid angle of 9217 patches (Reinhart's subdivision by 8), as a series of
    /// one row.
    pub fn on_patches(&self) -> Option<PatchSeries> {
        let grid = PatchGrid::of_factor(FACTOR);
        let sectors = self.sectors.get_or_init(|| self.sector_sums(&grid));
        let turned = (self.top_turns * SECTORS as f64).rem_euclid(SECTORS as f64);
        // Two sectors share a sector that is turned across a border of sectors.
        let (whole, part) = (turned as usize, turned.fract());
        let mut sums = vec![DVec2::ZERO; grid.len()];
        for (row, of_row) in sectors.chunks_exact(SECTORS).enumerate() {
            for (i, sum) in of_row.iter().enumerate().filter(|(_, sum)| sum.y > 0.0) {
                for (place, share) in [(i + whole, 1.0 - part), (i + whole + 1, part)] {
                    let turns = ((place % SECTORS) as f64 + 0.5) / SECTORS as f64;
                    if let Some(total) = grid.patch_in(row, turns).and_then(|patch| sums.get_mut(patch)) {
                        *total += share * *sum;
                    }
                }
            }
        }
        PatchSeries::new(grid, sums.iter().map(|sum| (sum.x / sum.y.max(f64::MIN_POSITIVE)) as f32).collect())
    }

    /// Returns `[row of patches][sector clockwise from the top]`: value x solid angle, and solid
    /// angle.
    fn sector_sums(&self, grid: &PatchGrid) -> Vec<DVec2> {
        let mut sums = vec![DVec2::ZERO; grid.bands().len() * SECTORS];
        let fine = POINTS.div_ceil(self.side).max(1);
        let half = 0.5 * self.side as f64;
        let inside: Vec<f64> = (0..fine).map(|i| (i as f64 + 0.5) / fine as f64).collect();
        for i in 0..self.numbers.len() {
            let (column, row) = ((i % self.side) as f64, (i / self.side) as f64);
            for down in &inside {
                for right in &inside {
                    let point = DVec2::new(column + right, row + down) / half - 1.0;
                    let radius = point.length();
                    if radius > 1.0 {
                        continue;
                    }
                    let zenith = radius * FRAC_PI_2;
                    // Solid angle over area: sine over angle.
                    let sr = if zenith > 0.0 { zenith.sin() / zenith } else { 1.0 };
                    let turns = ((-point.x).atan2(-point.y) / TAU).rem_euclid(1.0);
                    let sector = ((turns * SECTORS as f64) as usize).min(SECTORS - 1);
                    if let Some(sum) = sums.get_mut(grid.row_at(zenith.cos()) * SECTORS + sector) {
                        *sum += DVec2::new(sr * f64::from(self.level(point)), sr);
                    }
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// A bright pixel left of the middle lies in the east, one at the top in the north. With a top
    /// of 90 degrees the top is the east. The patch of the pixel is bright, too.
    #[test]
    fn east_lies_left_in_a_picture() {
        let side = 65;
        let picture = |column: usize, row: usize, top_deg: f64| {
            let mut numbers = vec![0.0; side * side];
            numbers[row * side + column] = 1.0;
            DomeImage::new(side, numbers, top_deg).expect("a picture")
        };
        for (column, row, top_deg, azimuth_deg) in
            [(16, 32, 0.0, 90.0), (32, 16, 0.0, 0.0), (48, 32, 0.0, 270.0), (32, 16, 90.0, 90.0), (16, 32, 90.0, 180.0)]
        {
            let image = picture(column, row, top_deg);
            let direction = direction_from_degrees(azimuth_deg, 90.0 - 16.0 / 32.5 * 90.0);
            assert_eq!(image.at(direction), 1.0, "{column} {row} {top_deg}");
            let patches = image.on_patches().expect("patches");
            let patch = patches.grid().patch_of(direction);
            assert!(patches.row(0)[patch] > 0.3, "{column} {row} {top_deg}: {}", patches.row(0)[patch]);
        }
    }

    /// A picture of squares has the patches of direct sums over its pixels (1e-6), at tops of 0, 1,
    /// 37, 180 and 359 degrees, and so has a copy that is turned there. At 12.34 degrees, which is
    /// no border of sectors, no patch is off by more than 0.02.
    #[test]
    fn turned_pictures_have_the_sums_of_their_pixels() {
        let side = 1024;
        let numbers: Vec<f32> =
            (0..side * side).map(|i| if ((i % side) / 90 + i / side / 70) % 2 == 0 { 1.0 } else { 0.25 }).collect();
        let first = DomeImage::new(side, numbers.clone(), 77.0).expect("a picture");
        let grid = PatchGrid::of_factor(FACTOR);
        for (top_deg, within) in [(0.0, 1e-6), (1.0, 1e-6), (37.0, 1e-6), (180.0, 1e-6), (359.0, 1e-6), (12.34, 0.02)] {
            let mut sums = vec![DVec2::ZERO; grid.len()];
            for i in 0..side * side {
                let point = DVec2::new((i % side) as f64 + 0.5, (i / side) as f64 + 0.5) / 512.0 - 1.0;
                let zenith = point.length() * FRAC_PI_2;
                if zenith <= FRAC_PI_2 {
                    let turns = ((-point.x).atan2(-point.y) / TAU + top_deg / 360.0).rem_euclid(1.0);
                    let sr = zenith.sin() / zenith;
                    sums[grid.patch_at(turns, zenith.cos())] += DVec2::new(sr * f64::from(first.level(point)), sr);
                }
            }
            let anew = DomeImage::new(side, numbers.clone(), top_deg).expect("a picture");
            for image in [anew, first.turned(top_deg)] {
                let patches = image.on_patches().expect("patches");
                let off = patches.row(0).iter().zip(&sums).map(|(l, sum)| (f64::from(*l) - sum.x / sum.y).abs());
                let most = off.fold(0.0, f64::max);
                assert!(most < within, "{top_deg}: {most}");
            }
        }
    }

    /// A picture of one level, with NaN outside of the circle, gives that level to all 9217 patches
    /// and to the horizon, at 3, 65 and 1500 pixels a side. A picture of the cosine of the zenith
    /// angle gives 2 pi / 3 on the horizontal within 2e-4, the error of constant patches.
    #[test]
    fn a_picture_of_one_level_fills_all_patches() {
        for side in [3, 65, 1500] {
            let half = 0.5 * side as f64;
            let is_inside =
                |i: usize| DVec2::new((i % side) as f64 + 0.5 - half, (i / side) as f64 + 0.5 - half).length() <= half;
            let numbers = (0..side * side).map(|i| if is_inside(i) { 2.5 } else { f32::NAN }).collect();
            let image = DomeImage::new(side, numbers, 10.0).expect("a picture");
            assert!((0..360).all(|azimuth| image.at(direction_from_degrees(f64::from(azimuth), 0.0)) == 2.5));
            let patches = image.on_patches().expect("patches");
            assert!(patches.row(0).iter().all(|l| (l - 2.5).abs() < 1e-5));
        }
        let side = 1024;
        let zenith = |i: usize| {
            let point = DVec2::new((i % side) as f64 + 0.5, (i / side) as f64 + 0.5) / 512.0 - 1.0;
            (point.length() * FRAC_PI_2).min(FRAC_PI_2)
        };
        let numbers = (0..side * side).map(|i| zenith(i).cos() as f32).collect();
        let patches = DomeImage::new(side, numbers, 0.0).and_then(|image| image.on_patches()).expect("patches");
        assert!((patches.horizontal_w_m2(0) / (TAU / 3.0) - 1.0).abs() < 2e-4, "{}", patches.horizontal_w_m2(0));
        assert!(DomeImage::new(3, vec![0.0; 8], 0.0).is_none());
    }
}
