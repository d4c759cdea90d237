//! Drawing that all pictures fill. In: shapes and words on a page, in points, x to the right and y
//! down from the top left corner. Out: shapes in the order of drawing, which `svg` and `png` write
//! as files. Equal drawings give equal bytes.

use rayon::prelude::*;

use super::font::Font;

/// Colour as red, green and blue.
pub type Rgb = [u8; 3];

/// Position on a page, points.
pub type At = (f64, f64);

pub const WHITE: Rgb = [255; 3];
/// Colour of words and of lines that matter.
pub const INK: Rgb = [30, 30, 40];
/// Colour of words that matter less.
pub const PALE_INK: Rgb = [96, 100, 110];

/// Pixels of a PNG along a point.
pub const SCALE: usize = 2;
/// Samples along a pixel of an image.
const FINE: usize = 2;
/// Samples of an image along a point.
pub const SAMPLES: usize = SCALE * FINE;
/// Width of the line in its own colour that closes the crack between a cell and its neighbours.
pub const SEAM: f64 = 1.0;

/// Part of words that stands at their position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Center,
    Right,
}

/// Shape on a page.
pub enum Shape {
    /// Area within rings, without that of rings in rings; its neighbours may touch it.
    Polygon {
        rings: Vec<Vec<At>>,
        fill: Rgb,
    },
    /// Rectangle between its top left and bottom right corner; a cell may touch its neighbours.
    Rectangle {
        corners: [At; 2],
        fill: Rgb,
        is_cell: bool,
    },
    Line {
        points: Vec<At>,
        thick: f64,
        colour: Rgb,
    },
    Dot {
        centre: At,
        radius: f64,
        fill: Rgb,
    },
    Text(Words),
    /// Pixels below and to the right of a corner, [`SCALE`] of them a point.
    Image {
        corner: At,
        image: Image,
    },
}

/// Words on a page.
pub struct Words {
    pub text: String,
    /// Position of their left end, middle or right end, at half the height of capital letters.
    pub at: At,
    pub side: Side,
    pub font: Font,
    pub colour: Rgb,
    /// Rotation clockwise, degrees.
    pub turn_deg: f64,
}

/// Pixels, `[row][column]`.
pub struct Image {
    pub columns: usize,
    pub pixels: Vec<Rgb>,
}

impl Image {
    /// Returns pixels whose colours are the means of `samples` along each side of a pixel.
    /// `paint` returns the colour of a sample by its column and row.
    pub fn sampled(size: [usize; 2], samples: usize, paint: impl Fn(usize, usize) -> Rgb + Sync) -> Self {
        let [columns, rows] = size;
        let pixel = |i: usize| {
            let (column, row) = (i % columns * samples, i / columns * samples);
            let mut sums = [0_u32; 3];
            for k in 0..samples * samples {
                let colour = paint(column + k % samples, row + k / samples);
                sums.iter_mut().zip(colour).for_each(|(sum, part)| *sum += u32::from(part));
            }
            sums.map(|sum| (sum / (samples * samples) as u32) as u8)
        };
        let pixels = (0..columns * rows).into_par_iter().with_min_len(columns.max(1)).map(pixel).collect();
        Image { columns, pixels }
    }

    /// Returns the image of an area of the page, in whole points, of which `paint` returns the
    /// colour at a position.
    pub fn painted(size: [usize; 2], paint: impl Fn(f64, f64) -> Rgb + Sync) -> Self {
        let at = |sample: usize| (sample as f64 + 0.5) / SAMPLES as f64;
        Image::sampled(size.map(|side| side * SCALE), FINE, |column, row| paint(at(column), at(row)))
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.pixels.len() / self.columns.max(1)
    }
}

/// Page that is drawn on.
pub struct Drawing {
    /// Width and height, points.
    pub size: At,
    pub shapes: Vec<Shape>,
}

impl Drawing {
    /// Returns a white page.
    pub fn new(width: f64, height: f64) -> Self {
        let mut page = Drawing { size: (width, height), shapes: Vec::new() };
        page.rectangle([(0.0, 0.0), page.size], WHITE);
        page
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: &[At], thick: f64, colour: Rgb) {
        self.shapes.push(Shape::Line { points: points.to_vec(), thick, colour });
    }

    /// Draws a circle without filling.
    pub fn ring(&mut self, centre: At, radius: f64, thick: f64, colour: Rgb) {
        let point = |step: u32| {
            let (sin, cos) = f64::from(2 * step).to_radians().sin_cos();
            (centre.0 + radius * cos, centre.1 + radius * sin)
        };
        self.line(&(0..=180).map(point).collect::<Vec<_>>(), thick, colour);
    }

    /// Draws a filled polygon that may touch its neighbours.
    pub fn polygon(&mut self, rings: Vec<Vec<At>>, fill: Rgb) {
        self.shapes.push(Shape::Polygon { rings, fill });
    }

    /// Draws a filled rectangle between two corners, top left and bottom right.
    pub fn rectangle(&mut self, corners: [At; 2], fill: Rgb) {
        self.shapes.push(Shape::Rectangle { corners, fill, is_cell: false });
    }

    /// Draws a filled rectangle that may touch its neighbours.
    pub fn cell(&mut self, corners: [At; 2], fill: Rgb) {
        self.shapes.push(Shape::Rectangle { corners, fill, is_cell: true });
    }

    /// Draws a filled circle.
    pub fn dot(&mut self, centre: At, radius: f64, fill: Rgb) {
        self.shapes.push(Shape::Dot { centre, radius, fill });
    }

    /// Draws an image; `corner` is its top left corner.
    pub fn image(&mut self, corner: At, image: Image) {
        self.shapes.push(Shape::Image { corner, image });
    }

    /// Draws words that are vertically centred at a position; `side` says which part of them stands
    /// there. Words that would leave the page are drawn smaller.
    pub fn text(&mut self, text: &str, at: At, font: Font, side: Side, colour: Rgb) {
        let room = match side {
            Side::Left => self.size.0 - at.0,
            Side::Center => 2.0 * at.0.min(self.size.0 - at.0),
            Side::Right => at.0,
        };
        self.words(Words { text: text.into(), at, side, font, colour, turn_deg: 0.0 }, room);
    }

    /// Draws words that run upwards, centred at a position, smaller if they are longer than `room`.
    pub fn text_up(&mut self, text: &str, at: At, font: Font, room: f64) {
        self.words(Words { text: text.into(), at, side: Side::Center, font, colour: INK, turn_deg: -90.0 }, room);
    }

    fn words(&mut self, mut words: Words, room: f64) {
        // Characters that XML cannot hold become blanks.
        let held = |c: char| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c };
        words.text = words.text.chars().map(held).collect();
        let width = words.font.width(&words.text);
        if width > room {
            words.font.size = (words.font.size * room / width).max(1.0);
        }
        if !words.text.is_empty() {
            self.shapes.push(Shape::Text(words));
        }
    }
}
