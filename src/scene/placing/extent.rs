//! Extent of a file. In: its polygons in the scene. Out: its bounding box, the heights of its
//! walls, and its stated place.

use std::path::PathBuf;

use glam::DVec3;

use heliotile_place::reference::Reference;

/// Largest upward component of the unit normal of a wall, up or down (sine of the angle; 6
/// degrees).
const UPRIGHT: f64 = 0.1;

/// Bins of lengths from 2^-16 m on, a quarter of an octave each: up to 2^32 m.
const BINS: usize = 192;
const MIN_EXPONENT: f64 = -16.0;
const BINS_AN_OCTAVE: f64 = 4.0;

/// Extent of a file of a scene.
#[derive(Clone, Debug)]
pub struct Extent {
    /// Path of the file.
    pub file: PathBuf,
    /// True if the file is a raster of heights.
    pub raster: bool,
    /// True if its buildings were raised from footprints.
    pub is_raised: bool,
    /// Lowest and highest corner in the scene, finite.
    pub bounds: [DVec3; 2],
    /// Translation of its positions, metres.
    pub shift: DVec3,
    /// Metres a unit, as the file was read.
    pub scale: f64,
    /// True if its coordinates are certainly metres, whatever the unit of its system.
    pub in_metres: bool,
    /// Place that the file states.
    pub own: Option<Reference>,
    /// Place that the user states for the file.
    pub stated: Option<Reference>,
    /// Heights and widths of its walls.
    pub walls: Walls,
}

impl Extent {
    /// Returns the stated place; the user's statement takes precedence.
    pub fn reference(&self) -> Option<Reference> {
        self.stated.or(self.own)
    }

    /// Returns the lowest and the highest corner in the file's own coordinates, as `reference` has
    /// them: in metres, or in the unit of the system if the file was scaled by it.
    pub fn in_system(&self, reference: Reference) -> [DVec3; 2] {
        let unit = self.unit_of(reference);
        self.bounds.map(|corner| (corner - self.shift) / unit)
    }

    /// Returns the metres by which coordinates were scaled from the unit of a system.
    pub fn unit_of(&self, reference: Reference) -> f64 {
        let unit = reference.unit_m();
        // The tolerance covers a foot by any definition.
        if unit != 1.0 && (self.in_metres || (self.scale / unit - 1.0).abs() < 0.01) { unit } else { 1.0 }
    }
}

/// Heights and widths of upright faces, weighted by area.
#[derive(Clone, Debug, Default)]
pub struct Walls {
    heights: Lengths,
    widths: Lengths,
}

/// Histogram of lengths, weighted by area.
#[derive(Clone, Debug)]
struct Lengths {
    area_m2: Vec<f64>,
}

impl Default for Lengths {
    fn default() -> Self {
        Lengths { area_m2: vec![0.0; BINS] }
    }
}

impl Lengths {
    fn add(&mut self, length: f64, area_m2: f64) {
        let bin = ((length.log2() - MIN_EXPONENT) * BINS_AN_OCTAVE).clamp(0.0, (BINS - 1) as f64);
        if let Some(area) = self.area_m2.get_mut(bin as usize) {
            *area += area_m2;
        }
    }

    fn median_m(&self) -> Option<f64> {
        let half = 0.5 * self.area_m2.iter().sum::<f64>();
        let mut sum = 0.0;
        let bin = self.area_m2.iter().position(|area| {
            sum += area;
            sum >= half && half > 0.0
        })?;
        Some((MIN_EXPONENT + (bin as f64 + 0.5) / BINS_AN_OCTAVE).exp2())
    }
}

impl Walls {
    /// Counts a triangle if it is upright.
    pub fn add(&mut self, [a, b, c]: [DVec3; 3]) {
        let normal = (b - a).cross(c - a);
        let twice_m2 = normal.length();
        let height = a.z.max(b.z).max(c.z) - a.z.min(b.z).min(c.z);
        if !(twice_m2 > 0.0 && normal.z.abs() < UPRIGHT * twice_m2 && height > 0.0) {
            return;
        }
        let width = [a - b, b - c, c - a].map(|side| side.truncate().length()).into_iter().fold(0.0, f64::max);
        self.heights.add(height, 0.5 * twice_m2);
        self.widths.add(width, 0.5 * twice_m2);
    }

    /// Returns the median height by area, to 9 %; `None` if no face is upright.
    pub fn median_m(&self) -> Option<f64> {
        self.heights.median_m()
    }

    /// Returns the median width by area, to 9 %; `None` if no face is upright.
    pub fn median_width_m(&self) -> Option<f64> {
        self.widths.median_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls of 3 m (two triangles), a small one of 40 m and a large roof have a median height of 3
    /// m and a median width of 8 m, to 10 %; a roof alone has no median.
    #[test]
    fn small_walls_do_not_change_the_median() {
        let p = DVec3::new;
        let mut walls = Walls::default();
        walls.add([p(0., 0., 0.), p(900., 0., 5.), p(0., 900., 9.)]);
        assert_eq!(walls.median_m(), None);
        walls.add([p(0., 0., 0.), p(8., 0., 0.), p(8., 0., 3.)]);
        walls.add([p(0., 0., 0.), p(8., 0., 3.), p(0., 0., 3.)]);
        walls.add([p(0., 0., 0.), p(0.1, 0., 0.), p(0., 0., 40.)]);
        let median = walls.median_m().expect("walls");
        assert!((median / 3.0 - 1.0).abs() < 0.1, "{median}");
        let width = walls.median_width_m().expect("walls");
        assert!((width / 8.0 - 1.0).abs() < 0.1, "{width}");
    }
}
