//! Thumbnail of a site from above, without words, for catalogues. In: places with a value each.
//! Out: PNG, true north up and true to scale, in the colours of maps.

use glam::DVec2;

use super::padded;
use super::paint::{draw_row, draw_scene, extend_by_row};
use super::palette::Palette;
use super::raster::Raster;
use super::view::{Panel, View};
use crate::outputs::pictures::drawing::SAMPLES;
use crate::outputs::pictures::png::encoded;
use crate::outputs::pictures::scale::round_steps;
use crate::outputs::provenance::Provenance;
use crate::outputs::shapes::glb::Surroundings;
use crate::outputs::shapes::row::MapRow;
use heliotile_core::error::Result;
use heliotile_core::site::north::North;

/// Longer side of a picture, pixels.
pub const SIDE: f64 = 400.0;

/// Extent and colour range of a thumbnail.
#[derive(Clone, Copy, Debug)]
pub struct ThumbnailFrame {
    view: View,
    /// Lowest and highest metres to the right and up.
    corners: [DVec2; 2],
    /// Largest value; 0 if there is none.
    largest: f32,
}

impl ThumbnailFrame {
    /// Returns the frame of no place.
    pub fn new(north: North) -> Self {
        ThumbnailFrame { view: View::above(north), corners: [DVec2::INFINITY, DVec2::NEG_INFINITY], largest: 0.0 }
    }

    /// Extends the frame by a place, a row with one number.
    pub fn add(&mut self, row: &MapRow) {
        extend_by_row(std::slice::from_mut(&mut self.corners), &[self.view], row);
        self.largest = row.numbers.iter().copied().fold(self.largest, f32::max);
    }

    /// Returns the frame that encloses both; its north is that of the first.
    pub fn union(mut self, other: &Self) -> Self {
        self.corners = [self.corners[0].min(other.corners[0]), self.corners[1].max(other.corners[1])];
        self.largest = self.largest.max(other.largest);
        self
    }

    /// Returns this extent with the colour range of another frame.
    pub fn in_colours_of(mut self, other: &Self) -> Self {
        self.largest = other.largest;
        self
    }

    /// Returns the value of the brightest colour; 0 is the darkest.
    pub fn top(&self) -> f64 {
        round_steps(self.largest.into(), 5).last().copied().unwrap_or(1.0)
    }

    /// Returns the picture, as PNG, of the rows that `draw` passes on.
    pub fn png(
        &self,
        around: Option<&Surroundings>,
        about: &Provenance,
        draw: impl FnOnce(&mut dyn FnMut(&MapRow)) -> Result<()>,
    ) -> Result<Vec<u8>> {
        let [low, high] = padded(self.corners);
        let size_m = high - low;
        let scale = SIDE / size_m.max_element();
        let panel = Panel { view: self.view, low, size_m, scale, corner: DVec2::ZERO };
        let mut raster = Raster::new(panel);
        if let Some(around) = around {
            draw_scene(&mut raster, around, 0.0)?;
        }
        // Places below roofs are shown, too, as on maps.
        raster.forget_depth();
        let palette = Palette::from_zero(self.top());
        draw(&mut |row| palette.ink(row).into_iter().for_each(|ink| draw_row(&mut raster, row, ink)))?;
        encoded(&raster.image(SAMPLES), &palette.stated(about).ascii())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::provenance;
    use crate::outputs::shapes::row::MapPolygon;
    use glam::DVec3;

    /// A site of 30 m x 10 m whose east half has the largest value and whose west half has 0 is a
    /// picture of 400 x 150 pixels, dark left and bright right, on a scale from 0 to 1,500; an
    /// empty one is a white page.
    #[test]
    fn a_thumbnail_is_dark_left_and_bright_right() {
        let half = |x: f64, value: f32| {
            let corner = |dx: f64, dy: f64| DVec3::new(x + dx, dy, 3.0);
            let ring = vec![corner(0.0, 0.0), corner(15.0, 0.0), corner(15.0, 10.0), corner(0.0, 10.0)];
            MapRow { numbers: vec![value], polygons: vec![MapPolygon { rings: vec![ring] }], ..MapRow::default() }
        };
        let (rows, mut frame) = ([half(0.0, 0.0), half(15.0, 1321.0)], ThumbnailFrame::new(North::default()));
        rows.iter().for_each(|row| frame.add(row));
        let decoded = |frame: &ThumbnailFrame, rows: &[MapRow]| {
            let png = frame.png(None, &provenance::tests::example(), |draw| {
                rows.iter().for_each(draw);
                Ok(())
            });
            let mut reader = png::Decoder::new(std::io::Cursor::new(png.expect("a picture"))).read_info().expect("PNG");
            let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
            let info = reader.next_frame(&mut pixels).expect("pixels");
            (info.width, info.height, pixels)
        };
        let (width, height, pixels) = decoded(&frame, &rows);
        assert_eq!((width, height, frame.top()), (400, 150, 1500.0));
        let pixel = |x: usize, y: usize| [0, 1, 2].map(|i| pixels[3 * (400 * y + x) + i]);
        assert_eq!([pixel(2, 74), pixel(100, 74)], [[255; 3], [68, 1, 84]]);
        assert!(pixel(300, 74)[1] > 180, "{:?}", pixel(300, 74));
        let (_, _, blank) = decoded(&ThumbnailFrame::new(North::default()), &[]);
        assert!(blank.iter().all(|byte| *byte == 255));
    }
}
