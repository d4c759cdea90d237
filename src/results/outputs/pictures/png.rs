//! Drawing as PNG. In: a drawing, texts that the file states. Out: bytes with smooth lines and
//! letters, [`SCALE`] pixels a point.

use tiny_skia::{Color, FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};
use ttf_parser::OutlineBuilder;

use super::drawing::{At, Drawing, Image, Rgb, SCALE, SEAM, Shape, Side, Words};
use super::font::BASELINE;
use crate::outputs::provenance::Provenance;
use heliotile_core::error::{Error, Result};

/// Pixels a metre of a page that is printed at its natural size, 96 points an inch.
const PIXELS_PER_M: u32 = (96 * SCALE * 10_000 / 254) as u32;

impl Drawing {
    /// Returns the picture as a PNG file that states its sources.
    pub fn png_file(mut self, about: &Provenance) -> Result<Vec<u8>> {
        self.sources(&about.sources());
        self.png(&about.ascii())
    }

    /// Returns the picture as PNG, with texts by their names.
    pub fn png(&self, texts: &[(String, String)]) -> Result<Vec<u8>> {
        let [columns, rows] = [self.size.0, self.size.1].map(|side| (side * SCALE as f64).ceil() as u32);
        let mut page = Pixmap::new(columns, rows).ok_or_else(|| refusal(format!("{columns} x {rows} pixels")))?;
        page.fill(Color::WHITE);
        self.shapes.iter().for_each(|shape| draw(&mut page, shape));
        let pixels = page.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
        encoded(&Image { columns: columns as usize, pixels }, texts)
    }
}

/// Returns an image as PNG, with texts by their names.
pub fn encoded(image: &Image, texts: &[(String, String)]) -> Result<Vec<u8>> {
    let refuse = |e: png::EncodingError| refusal(e.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.columns as u32, image.rows() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let (xppu, yppu) = (PIXELS_PER_M, PIXELS_PER_M);
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu, yppu, unit: png::Unit::Meter }));
    // Flat areas compress better without a filter.
    encoder.set_filter(png::Filter::NoFilter);
    for (name, text) in texts {
        encoder.add_text_chunk(name.clone(), text.clone()).map_err(refuse)?;
    }
    let mut writer = encoder.write_header().map_err(refuse)?;
    writer.write_image_data(image.pixels.as_flattened()).map_err(refuse)?;
    writer.finish().map_err(refuse)?;
    Ok(bytes)
}

fn refusal(found: String) -> Error {
    Error::Unsupported { what: "writing a picture".into(), found, supported: "what PNG can hold".into() }
}

fn draw(page: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Polygon { rings, fill } => {
            let mut path = PathBuilder::new();
            rings.iter().for_each(|ring| {
                add(&mut path, ring);
                path.close();
            });
            fill_cell(page, path.finish(), *fill, true);
        }
        Shape::Rectangle { corners: [(left, top), (right, bottom)], fill, is_cell } => {
            let [left, top, right, bottom] = [left, top, right, bottom].map(|at| *at as f32);
            let path = Rect::from_ltrb(left, top, right, bottom).map(PathBuilder::from_rect);
            fill_cell(page, path, *fill, *is_cell);
        }
        Shape::Line { points, thick, colour } => {
            let mut path = PathBuilder::new();
            add(&mut path, points);
            stroke(page, path.finish().as_ref(), *thick, *colour);
        }
        Shape::Dot { centre, radius, fill } => {
            let path = PathBuilder::from_circle(centre.0 as f32, centre.1 as f32, *radius as f32);
            fill_cell(page, path, *fill, false);
        }
        Shape::Text(words) => draw_words(page, words),
        Shape::Image { corner, image } => copy(page, *corner, image),
    }
}

fn add(path: &mut PathBuilder, points: &[At]) {
    for (number, (x, y)) in points.iter().map(|(x, y)| (*x as f32, *y as f32)).enumerate() {
        if number == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
}

/// Fills a path; a path without an area, or with a coordinate that is no number, is left out.
fn fill_cell(page: &mut Pixmap, path: Option<Path>, colour: Rgb, has_seam: bool) {
    let Some(path) = path else { return };
    page.fill_path(&path, &paint(colour), FillRule::EvenOdd, to_pixels(), None);
    if has_seam {
        stroke(page, Some(&path), SEAM, colour);
    }
}

fn stroke(page: &mut Pixmap, path: Option<&Path>, thick: f64, colour: Rgb) {
    let stroke = Stroke { width: thick as f32, ..Stroke::default() };
    path.iter().for_each(|path| page.stroke_path(path, &paint(colour), &stroke, to_pixels(), None));
}

fn to_pixels() -> Transform {
    Transform::from_scale(SCALE as f32, SCALE as f32)
}

fn paint([r, g, b]: Rgb) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

/// Copies an image to the page, without the part outside.
fn copy(page: &mut Pixmap, corner: At, image: &Image) {
    let columns = page.width() as usize;
    let [left, top] = [corner.0, corner.1].map(|side| (side * SCALE as f64).round() as usize);
    let left = left.min(columns);
    let width = image.columns.min(columns - left);
    let rows = page.data_mut().chunks_exact_mut(4 * columns).skip(top);
    for (to, from) in rows.zip(image.pixels.chunks(image.columns.max(1))) {
        for (to, from) in to[4 * left..].as_chunks_mut::<4>().0.iter_mut().zip(&from[..width]) {
            to[..3].copy_from_slice(from);
        }
    }
}

/// Outlines of words, in units of their font.
struct Pen {
    path: PathBuilder,
    /// Distance of the letter from the first.
    along: f32,
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.along + x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.along + x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.path.quad_to(self.along + x1, y1, self.along + x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.path.cubic_to(self.along + x1, y1, self.along + x2, y2, self.along + x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

fn draw_words(page: &mut Pixmap, words: &Words) {
    let mut pen = Pen { path: PathBuilder::new(), along: 0.0 };
    words.font.outline(&words.text, &mut pen, |pen, along| pen.along = along);
    let Some(path) = pen.path.finish() else { return };
    let before = match words.side {
        Side::Left => 0.0,
        Side::Center => 0.5,
        Side::Right => 1.0,
    };
    // Outlines have y up, pages y down.
    let (sin, cos) = words.turn_deg.to_radians().sin_cos();
    let (left, down) = (-before * words.font.width(&words.text), BASELINE * words.font.size);
    let at = (words.at.0 + left * cos - down * sin, words.at.1 + left * sin + down * cos);
    let [sin, cos] = [sin, cos].map(|part| (part * words.font.scale()) as f32);
    let turned = Transform::from_row(cos, sin, sin, -cos, at.0 as f32, at.1 as f32);
    page.fill_path(&path, &paint(words.colour), FillRule::Winding, turned.post_concat(to_pixels()), None);
}

#[cfg(test)]
mod tests {
    use super::super::drawing::{INK, WHITE};
    use super::super::font::Font;
    use super::*;

    /// Returns the columns and the pixels of a PNG.
    fn decoded(bytes: &[u8]) -> (usize, Vec<Rgb>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut pixels).expect("pixels");
        (info.width as usize, pixels.as_chunks().0.to_vec())
    }

    /// Both files of a drawing hold its 6 shapes: a polygon with a hole, a rectangle, a line, a
    /// dot, words and an image, whose pixels are exact. Words are as wide as measured within a
    /// pixel, and equal drawings give equal bytes.
    #[test]
    fn both_files_hold_all_shapes() {
        let draw = || {
            let mut page = Drawing::new(200.0, 100.0);
            let square = |low: f64, high: f64| vec![(low, low), (high, low), (high, high), (low, high)];
            page.polygon(vec![square(5.0, 35.0), square(15.0, 25.0)], [200, 0, 0]);
            page.rectangle([(40.0, 5.0), (60.0, 35.0)], [0, 200, 0]);
            page.line(&[(70.0, 5.0), (70.0, 35.0)], 4.0, [0, 0, 200]);
            page.dot((90.0, 20.0), 8.0, [9, 9, 9]);
            page.text("Irradiation, kWh/m\u{b2}", (20.0, 70.0), Font::new(13.0), Side::Left, INK);
            page.image((110.0, 5.0), Image { columns: 2, pixels: vec![[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]] });
            page
        };
        let bytes = draw().png(&[]).expect("a picture");
        assert_eq!(bytes, draw().png(&[]).expect("a picture"));
        let (columns, pixels) = decoded(&bytes);
        assert_eq!((columns, pixels.len()), (400, 400 * 200));
        let pixel = |x: usize, y: usize| pixels[y * columns + x];
        let found = [pixel(20, 20), pixel(40, 40), pixel(100, 40), pixel(140, 40), pixel(180, 40)];
        assert_eq!(found, [[200, 0, 0], WHITE, [0, 200, 0], [0, 0, 200], [9, 9, 9]]);
        let found = [pixel(220, 10), pixel(221, 10), pixel(220, 11), pixel(221, 11), pixel(222, 11)];
        assert_eq!(found, [[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12], WHITE]);
        let is_dark = |x: &usize| (120..160).any(|y| pixel(*x, y)[0] < 200);
        let last = (0..columns).rfind(is_dark).expect("words");
        let end = 2.0 * (20.0 + Font::new(13.0).width("Irradiation, kWh/m\u{b2}"));
        assert!(
            (last as f64 - end).abs() < 3.0 && (0..columns).find(is_dark).is_some_and(|x| x.abs_diff(42) < 4),
            "{last} {end}"
        );
        let svg = draw().svg();
        for (element, count) in [("path", 1), ("rect", 2), ("polyline", 1), ("circle", 1), ("text", 1), ("image", 1)] {
            assert_eq!(svg.matches(&format!("<{element} ")).count(), count, "{element}: {svg}");
        }
        let data = svg.split_once("base64,").and_then(|(_, rest)| rest.split_once('"')).expect("an image").0;
        let data = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, data).expect("base64");
        assert_eq!(decoded(&data), (2, vec![[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]]));
    }

    /// Abutting cells leave no crack: all pixels of 30 cells of one colour, none on a whole pixel,
    /// are that colour within 2 of 255.
    #[test]
    fn cells_that_touch_have_no_crack() {
        let mut page = Drawing::new(100.0, 20.0);
        let x = |cell: u32| 10.0 + f64::from(cell) * 2.77;
        (0..30).for_each(|cell| page.cell([(x(cell), 5.0), (x(cell + 1), 15.0)], [68, 1, 84]));
        let (columns, pixels) = decoded(&page.png(&[]).expect("a picture"));
        let worst = (22..180).map(|x| pixels[20 * columns + x][0].abs_diff(68)).max();
        assert!(worst.is_some_and(|worst| worst <= 2), "{worst:?}");
    }

    /// Coordinates that are no numbers or far outside, and empty words, leave the page white.
    #[test]
    fn what_is_outside_changes_nothing() {
        let mut page = Drawing::new(20.0, 20.0);
        for odd in [f64::NAN, f64::INFINITY, 1e300, -1e300, 1e9] {
            page.line(&[(odd, 1.0), (odd, 2.0)], 1.0, INK);
            page.polygon(vec![vec![(odd, 0.0), (odd, 1.0), (odd, 2.0)]], INK);
            page.rectangle([(odd, 0.0), (odd, 1.0)], INK);
            page.dot((odd, odd), 1.0, INK);
            page.image((odd.abs(), 0.0), Image { columns: 1, pixels: vec![INK] });
        }
        page.text("", (5.0, 5.0), Font::new(13.0), Side::Left, INK);
        assert!(decoded(&page.png(&[]).expect("a picture")).1.iter().skip(1).all(|pixel| *pixel == WHITE));
    }
}
