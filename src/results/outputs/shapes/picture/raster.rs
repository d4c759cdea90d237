//! Rasteriser of a panel of a page. In: triangles and edges in scene coordinates, their colours.
//! Out: pixels, each with the surface in front.

use glam::{DVec2, DVec3};

use super::palette::Ink;
use super::view::{Panel, View};
use crate::outputs::pictures::drawing::{Image, Rgb, SAMPLES, WHITE};

/// Samples of a panel with a depth buffer. A sample has the colour of one surface, so surfaces that
/// touch have no crack between them. Their number depends on the page, not on the site.
pub struct Raster {
    panel: Panel,
    /// Number of columns and rows.
    size: [usize; 2],
    /// Colours, `[row][column]`.
    colours: Vec<Rgb>,
    /// Depth towards the viewer, `[row][column]`, metres; f32 resolves a mm on 10 km.
    depth: Vec<f32>,
}

impl Raster {
    /// Returns a white panel.
    pub fn new(panel: Panel) -> Self {
        let size = panel.whole_size().map(|side| side * SAMPLES);
        let count = size[0] * size[1];
        Raster { panel, size, colours: vec![WHITE; count], depth: vec![f32::NEG_INFINITY; count] }
    }

    /// Returns the panel as an image, a pixel for each square of `samples` x `samples`.
    pub fn image(&self, samples: usize) -> Image {
        let [columns, rows] = self.size.map(|side| side / samples);
        Image::sampled([columns, rows], samples, |column, row| self.colours[row * self.size[0] + column])
    }

    /// Returns the view that the panel shows.
    pub fn view(&self) -> View {
        self.panel.view
    }

    /// Clears the depth buffer: whatever is drawn from now on hides earlier drawings.
    pub fn forget_depth(&mut self) {
        self.depth.fill(f32::NEG_INFINITY);
    }

    /// Draws a triangle, brought `nearer_m` metres towards the viewer.
    pub fn triangle(&mut self, corners: [DVec3; 3], nearer_m: f64, ink: Ink) {
        let [a, b, c] = corners.map(|corner| self.sample(corner));
        let twice = (b - a).truncate().perp_dot((c - a).truncate());
        if twice.abs() < 1e-9 || !twice.is_finite() {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Centres of samples are half a sample from their edges.
        let range = |low: f64, high: f64, most: usize| {
            let from = (low - 0.5).ceil().max(0.0) as usize;
            from..((high - 0.5).floor() + 1.0).clamp(from as f64, most.max(from) as f64) as usize
        };
        for row in range(low.y, high.y, self.size[1]) {
            for column in range(low.x, high.x, self.size[0]) {
                let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let share = |from: DVec3, to: DVec3| (to - from).truncate().perp_dot(at - from.truncate()) / twice;
                let [of_c, of_a, of_b] = [share(a, b), share(b, c), share(c, a)];
                if of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 {
                    self.dab(column, row, of_a * a.z + of_b * b.z + of_c * c.z + nearer_m, ink);
                }
            }
        }
    }

    /// Draws a line of five samples' width, for a surface that is seen edge-on.
    pub fn edge(&mut self, from: DVec3, to: DVec3, ink: Ink) {
        let (from, to) = (self.sample(from), self.sample(to));
        let most = (4 * (self.size[0] + self.size[1])) as f64;
        let steps = (to - from).truncate().abs().max_element().ceil().clamp(1.0, most) as usize;
        for step in 0..=steps {
            let at = from.lerp(to, step as f64 / steps as f64);
            self.square(at, 2, ink);
        }
    }

    /// Draws a mark at a point.
    pub fn mark(&mut self, point: DVec3, ink: Ink) {
        let at = self.sample(point);
        self.square(at, SAMPLES, ink);
    }

    fn square(&mut self, at: DVec3, around: usize, ink: Ink) {
        if !at.is_finite() || at.x < 0.0 || at.y < 0.0 {
            return;
        }
        let near = |middle: f64| (middle as usize).saturating_sub(around)..(middle as usize).saturating_add(around + 1);
        for row in near(at.y) {
            near(at.x).for_each(|column| self.dab(column, row, at.z, ink));
        }
    }

    fn dab(&mut self, column: usize, row: usize, towards_m: f64, ink: Ink) {
        if column >= self.size[0] {
            return;
        }
        let sample = row * self.size[0] + column;
        let Some(depth) = self.depth.get_mut(sample) else { return };
        if towards_m as f32 >= *depth {
            *depth = towards_m as f32;
            self.colours[sample] = ink.at(column, row);
        }
    }

    /// Returns samples from the panel's corner, and metres towards the viewer.
    fn sample(&self, point: DVec3) -> DVec3 {
        let place = self.panel.place(point) - self.panel.corner.extend(0.0);
        DVec3::new(place.x * SAMPLES as f64, place.y * SAMPLES as f64, place.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::north::North;

    /// The higher of two squares of 10 m hides the lower in their overlap, in either order of
    /// drawing. A wall is a line on them, and drawings far outside change nothing: 5 of 5 pixels.
    #[test]
    fn what_is_in_front_stays() {
        let square = |x: f64, z: f64| {
            let at = |dx: f64, dy: f64| DVec3::new(x + dx, dy, z);
            [[at(0.0, 0.0), at(10.0, 0.0), at(10.0, 10.0)], [at(0.0, 0.0), at(10.0, 10.0), at(0.0, 10.0)]]
        };
        for swapped in [false, true] {
            let panel = Panel {
                view: View::above(North::default()),
                low: DVec2::ZERO,
                size_m: DVec2::new(20.0, 10.0),
                scale: 2.0,
                corner: DVec2::ZERO,
            };
            let mut raster = Raster::new(panel);
            let mut both = [(square(0.0, 1.0), [10, 0, 0]), (square(5.0, 2.0), [0, 20, 0])];
            if swapped {
                both.reverse();
            }
            both.iter()
                .for_each(|(square, colour)| square.iter().for_each(|t| raster.triangle(*t, 0.0, Ink::plain(*colour))));
            raster.edge(DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 9.0, 9.0), Ink::plain([0, 0, 30]));
            for far in [1e300, -1e300, f64::NAN] {
                raster.triangle([DVec3::splat(far), DVec3::splat(far) + DVec3::X, DVec3::Y], 0.0, Ink::plain([1; 3]));
                raster.edge(DVec3::splat(far), DVec3::X, Ink::plain([1; 3]));
                raster.mark(DVec3::splat(far), Ink::plain([1; 3]));
            }
            let image = raster.image(SAMPLES);
            assert_eq!((image.columns, image.rows()), (40, 20));
            let pixel = |x: usize, y: usize| image.pixels[40 * y + x];
            assert_eq!([pixel(8, 10), pixel(12, 10), pixel(28, 10)], [[10, 0, 0], [0, 20, 0], [0, 20, 0]]);
            // The wall covers three quarters of its pixel.
            assert_eq!([pixel(34, 10), pixel(4, 6)], [[255; 3], [2, 0, 22]]);
        }
    }
}
