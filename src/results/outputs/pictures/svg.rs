//! Picture in SVG. In: shapes and words, in pixels, x to the right and y down. Out: a text that is
//! a file of its own or part of an HTML page, as it has no ids and refers to nothing. Equal
//! drawings give equal bytes.

use super::canvas::{Rgb, Side};
use crate::outputs::markup::escaped;

/// Position on a page, pixels.
pub type At = (f64, f64);

/// Size of the letters of titles, pixels; `LETTERS` is the size of all other words.
const TITLE: f64 = 17.0;
pub const LETTERS: f64 = 14.0;
/// Distance that grid lines reach out of their frame, and the unit of the gap to their words,
/// pixels.
const MARK: f64 = 4.0;
/// Width of a swatch in a legend, pixels.
pub const SWATCH: f64 = 18.0;

pub const BLACK: Rgb = [0; 3];
pub const WHITE: Rgb = [255; 3];
pub const GRID: Rgb = [225, 230, 234];

/// Rectangle on a page, pixels, for the values of a chart or the colours of a legend.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Frame {
    /// Returns the position at a share of the way to the right and a share of the way up.
    pub fn at(&self, across: f64, up: f64) -> At {
        (self.left + (self.right - self.left) * across, self.bottom - (self.bottom - self.top) * up)
    }
}

/// Side of a frame at which an axis stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    Below,
    Left,
}

/// Page that is drawn on.
pub struct Svg {
    size: At,
    text: String,
}

impl Svg {
    /// Returns a white page.
    pub fn new(width: f64, height: f64) -> Self {
        let size = format!("width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"");
        let text = format!("<svg {size} xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\">\n");
        let mut page = Svg { size: (width, height), text };
        page.rectangle([(0.0, 0.0), (width, height)], WHITE);
        page
    }

    /// Returns the picture as SVG.
    pub fn finish(self) -> String {
        self.text + "</svg>\n"
    }

    fn add(&mut self, element: &str) {
        self.text += element;
        self.text.push('\n');
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: &[At], thick: f64, colour: Rgb) {
        let (points, colour) = (path(points), hex(colour));
        self.add(&format!(
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"{thick}\" points=\"{points}\"/>"
        ));
    }

    /// Draws a filled polygon.
    pub fn polygon(&mut self, corners: &[At], fill: Rgb) {
        self.add(&format!("<polygon fill=\"{}\" points=\"{}\"/>", hex(fill), path(corners)));
    }

    /// Draws a filled rectangle between two corners, top left and bottom right.
    pub fn rectangle(&mut self, [(left, top), (right, bottom)]: [At; 2], fill: Rgb) {
        let [x, y, width, height] = [left, top, right - left, bottom - top].map(number);
        let fill = hex(fill);
        self.add(&format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\"/>"));
    }

    /// Draws a filled circle.
    pub fn circle(&mut self, centre: At, radius: f64, fill: Rgb) {
        let (x, y, fill) = (number(centre.0), number(centre.1), hex(fill));
        self.add(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{fill}\"/>"));
    }

    /// Draws words that are vertically centred at a position; `side` says which part of them stands
    /// there. Words that would leave the page are drawn smaller.
    pub fn text(&mut self, words: &str, at: At, size: f64, side: Side, colour: Rgb) {
        let (x, y) = at;
        let room = match side {
            Side::Left => self.size.0 - x,
            Side::Center => 2.0 * x.min(self.size.0 - x),
            Side::Right => x,
        };
        self.write(words, &format!("x=\"{}\"", number(x)), y, size.min(room / wide(words)), side, colour);
    }

    /// Draws black words that run upwards, centred at a position, smaller if they are longer than
    /// `room`.
    pub fn text_up(&mut self, words: &str, at: At, room: f64) {
        let size = LETTERS.min(room / wide(words));
        let turned = format!("transform=\"translate({} {}) rotate(-90)\"", number(at.0), number(at.1));
        self.write(words, &turned, 0.0, size, Side::Center, BLACK);
    }

    fn write(&mut self, words: &str, place: &str, y: f64, size: f64, side: Side, colour: Rgb) {
        if words.is_empty() {
            return;
        }
        // Characters that XML cannot hold become blanks.
        let held = |c: char| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c };
        let words = escaped(&words.chars().map(held).collect::<String>());
        let anchor = match side {
            Side::Left => "start",
            Side::Center => "middle",
            Side::Right => "end",
        };
        // Offset of the baseline: half of a capital letter's height.
        let [y, size] = [y + 0.36 * size, size.max(1.0)].map(number);
        let colour = hex(colour);
        self.add(&format!(
            "<text {place} y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{words}</text>"
        ));
    }

    /// Draws a title and the line below it.
    pub fn heading(&mut self, title: &str, called: &str) {
        self.text(title, (16.0, 22.0), TITLE, Side::Left, BLACK);
        self.text(called, (16.0, 45.0), LETTERS, Side::Left, BLACK);
    }

    /// Draws the words of an axis, each at its share of the way along the frame, and leaves out
    /// those without room. With a grid, each tick has a line through the frame.
    pub fn axis(&mut self, frame: &Frame, axis: Axis, ticks: &[(f64, String)], has_grid: bool) {
        let mut last_end = f64::NEG_INFINITY;
        for (share, words) in ticks {
            let (x, y) = if axis == Axis::Below { frame.at(*share, 0.0) } else { frame.at(0.0, *share) };
            let (line, at, side, along, half) = match axis {
                Axis::Below => {
                    let half = 0.5 * LETTERS * wide(words);
                    ([(x, y + MARK), (x, frame.top)], (x, y + 4.0 * MARK), Side::Center, x, half)
                }
                Axis::Left => ([(x - MARK, y), (frame.right, y)], (x - 2.0 * MARK, y), Side::Right, -y, 0.5 * LETTERS),
            };
            if has_grid {
                self.line(&line, 1.0, GRID);
            }
            if along - half >= last_end {
                self.text(words, at, LETTERS, side, BLACK);
                last_end = along + half + 2.0 * MARK;
            }
        }
    }

    /// Draws names from a position on, in as many rows as they need, and returns the positions of
    /// their swatches.
    pub fn legend(&mut self, from: At, names: &[&str]) -> Vec<At> {
        let (mut x, mut y) = from;
        let mut place = |name: &&str| {
            let width = SWATCH + 6.0 + LETTERS * wide(name);
            if x > from.0 && x + width > self.size.0 {
                (x, y) = (from.0, y + 20.0);
            }
            self.text(name, (x + SWATCH + 6.0, y), LETTERS, Side::Left, BLACK);
            x += width + 12.0;
            (x - width - 12.0, y)
        };
        names.iter().map(&mut place).collect()
    }

    /// Draws colours from left to right, of equal widths.
    pub fn colours(&mut self, frame: &Frame, count: usize, colour: impl Fn(usize) -> Rgb) {
        let share = |step: usize| step as f64 / count as f64;
        for step in 0..count {
            self.rectangle([frame.at(share(step), 1.0), frame.at(share(step + 1), 0.0)], colour(step));
        }
    }
}

/// Returns the approximate width of words in a wide font, as a multiple of the size of their
/// letters.
pub fn wide(words: &str) -> f64 {
    let letter = |letter: char| match letter {
        ' ' | '!'..='/' | ':' | ';' | 'f' | 'i' | 'j' | 'l' | 'r' | 't' if letter != '%' => 0.41,
        'm' | 'w' | 'M' | 'W' | '%' => 0.98,
        _ => 0.65,
    };
    words.chars().map(letter).sum()
}

/// Formats a coordinate to a hundredth of a pixel; NaN and infinity become 0.
fn number(value: f64) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    // Adding 0.0 turns -0 into 0.
    ((100.0 * value).round() / 100.0 + 0.0).to_string()
}

fn path(points: &[At]) -> String {
    let point = |(x, y): &At| format!("{},{}", number(*x), number(*y));
    points.iter().map(point).collect::<Vec<_>>().join(" ")
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}
