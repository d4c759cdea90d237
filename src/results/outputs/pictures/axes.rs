//! Axes, legends and colour scales of pictures. In: a drawing, the frame that they belong to, words
//! and their places. Out: shapes of the drawing.

use super::colours::{ColourScale, STEPS};
use super::drawing::{At, Drawing, INK, PALE_INK, Rgb, Side};
use super::font::Font;
use super::scale::words;

/// Letters of titles; `LETTERS` are those of all other words.
pub const TITLE: Font = Font::bold(17.0);
pub const LETTERS: Font = Font::new(13.0);
/// Letters of notes at the foot of a page.
const NOTE: Font = Font::new(10.0);
/// Distance that grid lines reach out of their frame, and the unit of the gap to their words,
/// points.
const MARK: f64 = 4.0;
/// Width of a swatch in a legend, points; `HALF_SWATCH` is half its height.
pub const SWATCH: f64 = 18.0;
const HALF_SWATCH: f64 = 5.5;
/// Distance of the rows of a legend, points.
const ROW: f64 = 20.0;
/// Distance of words from the sides of a page, points.
pub const MARGIN: f64 = 16.0;

pub const GRID: Rgb = [225, 230, 234];

/// Rectangle on a page, points, for the values of a chart or the colours of a legend.
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

impl Drawing {
    /// Draws a title and the line below it.
    pub fn heading(&mut self, title: &str, called: &str) {
        self.text(title, (MARGIN, 22.0), TITLE, Side::Left, INK);
        self.text(called, (MARGIN, 45.0), LETTERS, Side::Left, PALE_INK);
    }

    /// Draws the sources of a picture at the foot of its page.
    pub fn sources(&mut self, sources: &str) {
        self.text(sources, (MARGIN, self.size.1 - 10.0), NOTE, Side::Left, PALE_INK);
    }

    /// Draws the words of an axis, each at its share of the way along the frame, and leaves out
    /// those without room. With a grid, each tick has a line through the frame.
    pub fn axis(&mut self, frame: &Frame, axis: Axis, ticks: &[(f64, String)], has_grid: bool) {
        let mut last_end = f64::NEG_INFINITY;
        for (share, words) in ticks {
            let (x, y) = if axis == Axis::Below { frame.at(*share, 0.0) } else { frame.at(0.0, *share) };
            let (line, at, side, along, half) = match axis {
                Axis::Below => {
                    let half = 0.5 * LETTERS.width(words);
                    ([(x, y + MARK), (x, frame.top)], (x, y + 4.0 * MARK), Side::Center, x, half)
                }
                Axis::Left => {
                    let half = 0.5 * LETTERS.size;
                    ([(x - MARK, y), (frame.right, y)], (x - 2.0 * MARK, y), Side::Right, -y, half)
                }
            };
            if has_grid {
                self.line(&line, 1.0, GRID);
            }
            if along - half >= last_end {
                self.text(words, at, LETTERS, side, INK);
                last_end = along + half + 2.0 * MARK;
            }
        }
    }

    /// Draws names from a position on, in as many rows as they need, and returns the positions of
    /// their swatches. Names that are longer than a row are cut.
    pub fn legend(&mut self, from: At, names: &[&str]) -> Vec<At> {
        let ((mut x, mut y), right) = (from, self.size.0 - MARGIN);
        let mut place = |name: &&str| {
            let name = LETTERS.fitted(name, right - from.0 - SWATCH - 6.0);
            let width = SWATCH + 6.0 + LETTERS.width(&name);
            if x > from.0 && x + width > right {
                (x, y) = (from.0, y + ROW);
            }
            self.text(&name, (x + SWATCH + 6.0, y), LETTERS, Side::Left, INK);
            x += width + 16.0;
            (x - width - 16.0, y)
        };
        names.iter().map(&mut place).collect()
    }

    /// Draws a legend with its swatches, and returns the height of all of its rows but the first.
    pub fn swatches(&mut self, from: At, entries: &[(&str, Rgb)]) -> f64 {
        let places = self.legend(from, &entries.iter().map(|(name, _)| *name).collect::<Vec<_>>());
        for ((x, y), (_, colour)) in places.iter().zip(entries) {
            let [(left, top), (right, bottom)] = [(*x, y - HALF_SWATCH), (x + SWATCH, y + HALF_SWATCH)];
            self.rectangle([(left, top), (right, bottom)], *colour);
            let rim = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
            self.line(&rim, 0.5, PALE_INK);
        }
        places.last().map_or(0.0, |last| last.1 - from.1)
    }

    /// Draws `count` colours from left to right, of equal widths.
    pub fn colours(&mut self, frame: &Frame, count: usize, colour: impl Fn(usize) -> Rgb) {
        let share = |step: usize| step as f64 / count as f64;
        for step in 0..count {
            self.cell([frame.at(share(step), 1.0), frame.at(share(step + 1), 0.0)], colour(step));
        }
    }

    /// Draws the colours of a scale with round numbers from its least to its largest, and the unit
    /// beside, after a gap.
    pub fn colour_scale(&mut self, frame: &Frame, scale: ColourScale, ticks: &[f64], unit: &str, gap: f64) {
        let (least, top) = ticks.first().zip(ticks.last()).unwrap_or((&0.0, &1.0));
        let tick = |tick: &f64| ((tick - least) / (top - least), words(*tick));
        self.colours(frame, STEPS, |step| scale.of_legend(step));
        self.axis(frame, Axis::Below, &ticks.iter().map(tick).collect::<Vec<_>>(), false);
        if let Some([low, high]) = scale.ends() {
            self.text(low, (frame.left, frame.top - 10.0), LETTERS, Side::Left, INK);
            self.text(high, (frame.right, frame.top - 10.0), LETTERS, Side::Right, INK);
        }
        let (right, y) = frame.at(1.0, 0.5);
        self.text(unit, (right + MARK * 2.0 + gap, y), LETTERS, Side::Left, INK);
    }
}
