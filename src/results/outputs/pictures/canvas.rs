//! Bitmap that lines and words are drawn on. In: shapes, in points of a page. Out: PNG bytes with
//! smooth lines.

use std::convert::Infallible;

use embedded_graphics::mono_font::iso_8859_1::{FONT_7X13, FONT_9X15_BOLD};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, Polyline, PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Baseline, Text, TextStyleBuilder};
use rayon::prelude::*;

use heliotile_core::error::{Error, Result};

/// Colour as red, green and blue.
pub type Rgb = [u8; 3];

/// Pixels of the drawing along a side of a pixel of the picture.
pub const FINE: usize = 3;

/// Page of a size in points; (0, 0) is the top left corner, x is to the right and y down.
pub struct Canvas {
    width: usize,
    height: usize,
    /// Fine pixels, `[row][column]`.
    pixels: Vec<Rgb>,
    /// Words, which are drawn last at the final size: bitmap letters would only blur.
    words: Vec<Word>,
}

struct Word {
    text: String,
    at: (f64, f64),
    colour: Rgb,
    large: bool,
    side: Side,
}

/// Alignment of a word at its point.
pub use embedded_graphics::text::Alignment as Side;

impl Canvas {
    /// Returns a page in which `paint` colours every fine pixel by the position of its centre.
    pub fn painted(width: usize, height: usize, paint: impl Fn(f64, f64) -> Rgb + Sync) -> Self {
        let columns = width * FINE;
        let at = |i: usize| (i as f64 + 0.5) / FINE as f64;
        let pixel = |i: usize| paint(at(i % columns), at(i / columns));
        let pixels = (0..columns * height * FINE).into_par_iter().with_min_len(columns).map(pixel).collect();
        Canvas { width, height, pixels, words: Vec::new() }
    }

    /// Returns the fine pixels as a target of drawing.
    fn target(&mut self) -> Target<'_> {
        Target { width: self.width * FINE, height: self.height * FINE, pixels: &mut self.pixels }
    }

    /// Colours one fine pixel, if it exists.
    pub fn dab(&mut self, column: usize, row: usize, colour: Rgb) {
        let columns = self.width * FINE;
        if let Some(pixel) = self.pixels.get_mut(row * columns + column).filter(|_| column < columns) {
            *pixel = colour;
        }
    }

    /// Draws a line through points, `thick` points wide.
    pub fn line(&mut self, points: &[(f64, f64)], thick: f64, colour: Rgb) {
        let points: Vec<Point> = points.iter().map(|&p| fine(p)).collect();
        let style = stroke(thick, colour);
        // Drawing into memory cannot fail.
        let _ = Polyline::new(&points).into_styled(style).draw(&mut self.target());
    }

    /// Draws a circle without filling.
    pub fn ring(&mut self, centre: (f64, f64), radius: f64, thick: f64, colour: Rgb) {
        let style = stroke(thick, colour);
        let diameter = (2.0 * radius * FINE as f64).round() as u32;
        let _ = Circle::with_center(fine(centre), diameter).into_styled(style).draw(&mut self.target());
    }

    /// Draws a filled circle.
    pub fn dot(&mut self, centre: (f64, f64), radius: f64, colour: Rgb) {
        let diameter = (2.0 * radius * FINE as f64).round() as u32;
        let style = PrimitiveStyle::with_fill(rgb(colour));
        let _ = Circle::with_center(fine(centre), diameter).into_styled(style).draw(&mut self.target());
    }

    /// Draws a filled square; `corner` is its top left corner and `side` its length in points.
    pub fn square(&mut self, corner: (f64, f64), side: f64, colour: Rgb) {
        let size = Size::new_equal((side * FINE as f64).round() as u32);
        let style = PrimitiveStyle::with_fill(rgb(colour));
        let _ = Rectangle::new(fine(corner), size).into_styled(style).draw(&mut self.target());
    }

    /// Draws a word that is centred vertically at `at`; characters outside Latin-1 become question
    /// marks.
    pub fn word(&mut self, text: &str, at: (f64, f64), side: Side, colour: Rgb) {
        self.words.push(Word { text: text.to_string(), at, colour, large: false, side });
    }

    /// Draws a word in large letters.
    pub fn headline(&mut self, text: &str, at: (f64, f64), side: Side, colour: Rgb) {
        self.words.push(Word { text: text.to_string(), at, colour, large: true, side });
    }

    /// Returns the picture as PNG, with texts by their names.
    pub fn png(self, texts: Vec<(String, String)>) -> Result<Vec<u8>> {
        let mut pixels = self.means();
        let mut page = Target { width: self.width, height: self.height, pixels: &mut pixels };
        for word in &self.words {
            let font: &MonoFont = if word.large { &FONT_9X15_BOLD } else { &FONT_7X13 };
            let style = TextStyleBuilder::new().alignment(word.side).baseline(Baseline::Middle).build();
            let at = Point::new(word.at.0.round() as i32, word.at.1.round() as i32);
            let letters = MonoTextStyle::new(font, rgb(word.colour));
            let _ = Text::with_text_style(&word.text, at, letters, style).draw(&mut page);
        }
        let refuse = |e: png::EncodingError| Error::Unsupported {
            what: "writing a picture".into(),
            found: e.to_string(),
            supported: "what PNG can hold".into(),
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // Flat areas compress better without a filter.
        encoder.set_filter(png::Filter::NoFilter);
        for (name, text) in texts {
            encoder.add_text_chunk(name, text).map_err(refuse)?;
        }
        let mut writer = encoder.write_header().map_err(refuse)?;
        writer.write_image_data(pixels.as_flattened()).map_err(refuse)?;
        writer.finish().map_err(refuse)?;
        Ok(bytes)
    }

    /// Returns the mean of the fine pixels of each pixel.
    fn means(&self) -> Vec<Rgb> {
        let pixel = |i: usize| {
            let (column, row) = (i % self.width * FINE, i / self.width * FINE);
            let mut sums = [0_u32; 3];
            for k in 0..FINE * FINE {
                let pixel = self.pixels[(row + k / FINE) * self.width * FINE + column + k % FINE];
                sums.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += u32::from(value));
            }
            sums.map(|sum| (sum / (FINE * FINE) as u32) as u8)
        };
        (0..self.width * self.height).into_par_iter().map(pixel).collect()
    }
}

fn stroke(thick: f64, colour: Rgb) -> PrimitiveStyle<Rgb888> {
    PrimitiveStyle::with_stroke(rgb(colour), (thick * FINE as f64).round().max(1.0) as u32)
}

fn rgb([r, g, b]: Rgb) -> Rgb888 {
    Rgb888::new(r, g, b)
}

/// Converts a point of the page to fine pixels.
fn fine(at: (f64, f64)) -> Point {
    let (x, y) = at;
    Point::new((x * FINE as f64).round() as i32, (y * FINE as f64).round() as i32)
}

/// Pixels that shapes and words are drawn on, clipped to the picture.
struct Target<'a> {
    width: usize,
    height: usize,
    pixels: &'a mut [Rgb],
}

impl OriginDimensions for Target<'_> {
    fn size(&self) -> Size {
        Size::new(self.width as u32, self.height as u32)
    }
}

impl DrawTarget for Target<'_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, drawn: I) -> std::result::Result<(), Infallible> {
        for Pixel(at, colour) in drawn {
            if let (Ok(x), Ok(y)) = (usize::try_from(at.x), usize::try_from(at.y))
                && x < self.width
                && let Some(pixel) = self.pixels.get_mut(y * self.width + x)
            {
                *pixel = [colour.r(), colour.g(), colour.b()];
            }
        }
        Ok(())
    }
}
