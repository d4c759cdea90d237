//! Stacked bars: sums of periods by component, or their changes. In: names, values. Out: SVG, a
//! rectangle for each value above zero, and below zero for losses.

use super::axes::{Axis, Frame, LETTERS, MARGIN};
use super::colours::ColourScale;
use super::drawing::{Drawing, INK, Rgb, Side};
use super::scale::{printed, words};
use heliotile_core::error::{Error, Result};

/// Picture of bars.
pub struct Bars {
    pub title: String,
    /// Line below the title.
    pub called: String,
    pub unit: String,
    /// Label of each bar.
    pub labels: Vec<String>,
    /// Parts of the bars, stacked from zero up and down.
    pub stacks: Vec<Stack>,
    /// Colour scale, which says if bars stand on both sides of zero.
    pub scale: ColourScale,
}

/// Part of all bars.
pub struct Stack {
    pub name: String,
    pub colour: Rgb,
    /// Value for each bar; values below zero have no height on a scale from zero.
    pub values: Vec<f64>,
}

/// Size of the page, points.
const SIZE: (f64, f64) = (900.0, 500.0);
/// Largest number of bars: more of them would be thinner than a point.
const MAX_BARS: usize = 800;
/// Frame of the bars below a legend of one row.
const FRAME: Frame = Frame { left: 72.0, right: 880.0, top: 92.0, bottom: 452.0 };

/// Refuses a chart of too many bars.
pub fn check(count: usize) -> Result<()> {
    let what = "the number of bars of a chart (choose fewer with {from} and {to}, or a longer {every})";
    match count > MAX_BARS {
        true => Err(Error::Limit { what: what.into(), value: count as u64, max: MAX_BARS as u64 }),
        false => Ok(()),
    }
}

impl Bars {
    /// Returns the picture.
    pub fn drawing(&self) -> Drawing {
        let count = self.labels.len().max(1) as f64;
        let side = |bar: usize, is_up: bool| {
            let heights = self.stacks.iter().map(|stack| self.height(stack, bar));
            heights.filter(|height| (*height > 0.0) == is_up).sum::<f64>().abs()
        };
        let largest = (0..self.labels.len()).flat_map(|bar| [side(bar, true), side(bar, false)]).fold(0.0, f64::max);
        let ticks = self.scale.ticks(largest);
        let top = ticks.last().copied().unwrap_or(1.0);
        let least = self.scale.least(top);
        let (zero, whole) = (-least / (top - least), top - least);
        let ticks: Vec<(f64, String)> = ticks.into_iter().map(|tick| ((tick - least) / whole, words(tick))).collect();
        let middle = |(bar, label): (usize, &String)| ((bar as f64 + 0.5) / count, label.clone());
        let labels: Vec<(f64, String)> = self.labels.iter().enumerate().map(middle).collect();

        let lower = self.legend(&mut Drawing::new(SIZE.0, SIZE.1));
        let frame = Frame { top: FRAME.top + lower, bottom: FRAME.bottom + lower, ..FRAME };
        let mut page = Drawing::new(SIZE.0, SIZE.1 + lower);
        page.heading(&self.title, &self.called);
        page.axis(&frame, Axis::Left, &ticks, true);
        page.axis(&frame, Axis::Below, &labels, false);
        let gap = if count > 60.0 { 0.0 } else { 0.14 };
        // Bars without a gap touch.
        let draw = if gap > 0.0 { Drawing::rectangle } else { Drawing::cell };
        for bar in 0..self.labels.len() {
            let [from, to] = [bar as f64 + gap, (bar + 1) as f64 - gap].map(|at| at / count);
            let (mut below, mut above) = (zero, zero);
            for stack in &self.stacks {
                let share = self.height(stack, bar) / whole;
                if share > 0.0 {
                    draw(&mut page, [frame.at(from, below + share), frame.at(to, below)], stack.colour);
                    below += share;
                } else if share < 0.0 {
                    draw(&mut page, [frame.at(from, above), frame.at(to, above + share)], stack.colour);
                    above += share;
                }
            }
        }
        page.line(&[frame.at(0.0, zero), frame.at(1.0, zero)], 1.0, INK);
        self.legend(&mut page);
        page
    }

    /// Draws the unit, and the names of the visible parts, in rows above the bars; returns the
    /// height of all rows but the first, points.
    fn legend(&self, page: &mut Drawing) -> f64 {
        let (y, unit) = (FRAME.top - 18.0, printed(&self.unit));
        page.text(&unit, (MARGIN, y), LETTERS, Side::Left, INK);
        let x = MARGIN + 20.0 + LETTERS.width(&unit);
        let bars = 0..self.labels.len();
        let is_there = |stack: &&Stack| bars.clone().any(|bar| self.height(stack, bar) != 0.0);
        let there = self.stacks.iter().filter(is_there);
        page.swatches((x, y), &there.map(|stack| (stack.name.as_str(), stack.colour)).collect::<Vec<_>>())
    }

    /// Returns the height of a part of a bar; a value that is no number has none.
    fn height(&self, stack: &Stack, bar: usize) -> f64 {
        let height = stack.values.get(bar).copied().filter(|value| value.is_finite()).unwrap_or_default();
        if self.scale == ColourScale::FromZero { height.max(0.0) } else { height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With 2 stacks of 3 bars, one value below zero and one that is no number, 4 rectangles are
    /// stacked, as high as their values to 0.1 %; names with `<` are escaped in 6 of 6 places.
    #[test]
    fn bars_are_as_high_as_their_values() {
        let bad = "a<script>";
        let stack = |values: [f64; 3]| Stack { name: bad.into(), colour: [1, 2, 3], values: values.into() };
        let bars = Bars {
            title: bad.into(),
            called: bad.into(),
            unit: bad.into(),
            labels: vec![bad.into(), "b".into(), "c".into()],
            stacks: vec![stack([30.0, -5.0, 50.0]), stack([12.5, 40.0, f64::NAN])],
            scale: ColourScale::FromZero,
        };
        let svg = bars.drawing().svg();
        assert!(!svg.contains("<script") && svg.matches("a&lt;script&gt;").count() == 6, "{svg}");
        let number = |line: &str, name: &str| -> f64 {
            let rest = line.split_once(&format!(" {name}=\"")).expect("an attribute").1;
            rest.split('"').next().and_then(|n| n.parse().ok()).expect("a number")
        };
        // The rectangles of the bars come before those of the legend.
        let rects: Vec<&str> =
            svg.lines().filter(|line| line.starts_with("<rect") && line.contains("#010203")).collect();
        assert_eq!(rects.len(), 4 + 2);
        // The axis ends at 50, 360 pixels above its foot.
        let heights: Vec<f64> = rects.iter().take(4).map(|line| number(line, "height") / 360.0 * 50.0).collect();
        for (height, value) in heights.iter().zip([30.0, 12.5, 40.0, 50.0]) {
            assert!((height - value).abs() < 0.05, "{heights:?}");
        }
        assert_eq!(number(rects[0], "y"), number(rects[1], "y") + number(rects[1], "height"));
    }

    /// Names of many parts take several rows, and the bars begin below them.
    #[test]
    fn bars_stand_below_the_legend() {
        let stack =
            |i: u8| Stack { name: "a rather long name of a house".into(), colour: [i, 7, 7], values: vec![1.0] };
        let bars = Bars {
            title: String::new(),
            called: String::new(),
            unit: String::new(),
            labels: vec!["a".into()],
            stacks: (1..=8).map(stack).collect(),
            scale: ColourScale::FromZero,
        };
        let svg = bars.drawing().svg();
        let ys = |of: &str| -> Vec<f64> {
            let lines = svg.lines().filter(|line| line.starts_with(of));
            let y = |line: &str| line.split_once(" y=\"").and_then(|rest| rest.1.split('"').next()?.parse().ok());
            lines.filter_map(y).collect()
        };
        // The last rectangles are the swatches of the legend.
        let rects = ys("<rect");
        let (drawn, swatches) = rects.split_at(rects.len() - 8);
        let lowest = swatches.iter().copied().fold(0.0, f64::max) + 12.0;
        let highest = drawn[drawn.len() - 8..].iter().copied().fold(f64::INFINITY, f64::min);
        assert!(swatches[0] < swatches[7] && highest > lowest, "{highest} {lowest}");
    }

    /// A gain of 40 stands above the zero line and a loss of 10 hangs below it, on an axis from -40
    /// to 40: 180 and 45 pixels.
    #[test]
    fn losses_hang_below() {
        let stack = |values: [f64; 2], colour| Stack { name: String::new(), colour, values: values.into() };
        let bars = Bars {
            title: String::new(),
            called: String::new(),
            unit: String::new(),
            labels: vec!["a".into(), "b".into()],
            stacks: vec![stack([40.0, 0.0], [1, 2, 3]), stack([0.0, -10.0], [3, 2, 1])],
            scale: ColourScale::AroundZero,
        };
        let svg = bars.drawing().svg();
        let of = |colour: &str| {
            let line = svg.lines().find(|line| line.starts_with("<rect") && line.contains(colour)).expect("a bar");
            ["y", "height"].map(|name| {
                let rest = line.split_once(&format!(" {name}=\"")).expect("an attribute").1;
                rest.split('"').next().and_then(|n| n.parse::<f64>().ok()).expect("a number")
            })
        };
        assert_eq!((of("#010203"), of("#030201")), ([92.0, 180.0], [272.0, 45.0]));
    }
}
