//! Bars that are stacked: sums of periods by component. In: names, values. Out: SVG, a rectangle for each value above zero.

use plotters::prelude::{BLACK, Color, PathElement, RGBColor, Rectangle, Text};
use plotters::style::text_anchor::HPos;

use super::canvas::Rgb;
use super::plot_scale::round_steps;
use super::sheet::{Drawn, Sheet, clean, heading, letters, place, rgb, svg};
use heliotile_core::error::Result;

/// A picture of bars.
pub struct Bars {
    pub title: String,
    /// Below the title.
    pub called: String,
    pub unit: String,
    /// One a bar.
    pub labels: Vec<String>,
    /// From the bottom up.
    pub stacks: Vec<Stack>,
}

/// A part of all bars.
pub struct Stack {
    pub name: String,
    pub colour: Rgb,
    /// One a bar; what is below zero has no height.
    pub values: Vec<f64>,
}

/// Of the page, pixels.
const SIZE: (u32, u32) = (900, 500);
/// Where bars stand: left, right, top, bottom.
const AREA: (f64, f64, f64, f64) = (72.0, 880.0, 92.0, 452.0);
const GRID: RGBColor = RGBColor(225, 230, 234);
/// Labels that have room below the bars.
const MOST_LABELS: usize = 16;

impl Bars {
    /// The picture.
    pub fn svg(&self) -> Result<String> {
        svg(SIZE.0, SIZE.1, |page| self.draw(page))
    }

    /// Value at the top of the axis.
    fn ticks(&self) -> Vec<f64> {
        let sum = |bar: usize| self.stacks.iter().map(|stack| stack.height(bar)).sum::<f64>();
        round_steps((0..self.labels.len()).map(sum).fold(0.0, f64::max), 5)
    }

    fn draw(&self, page: &Sheet) -> Drawn {
        let (left, right, upper, lower) = AREA;
        heading(page, &self.title, &self.called)?;
        let ticks = self.ticks();
        let top = ticks.last().copied().unwrap_or(1.0);
        let y = |value: f64| lower - (lower - upper) * value / top;
        for tick in &ticks {
            let line = vec![place((left, y(*tick))), place((right, y(*tick)))];
            page.draw(&PathElement::new(line, GRID.stroke_width(8)))?;
            page.draw(&Text::new(tick.to_string(), place((left - 8.0, y(*tick))), letters(13, BLACK, HPos::Right)))?;
        }
        page.draw(&Text::new(clean(&self.unit), place((16.0, upper - 18.0)), letters(13, BLACK, HPos::Left)))?;
        let count = self.labels.len().max(1);
        let wide = (right - left) / count as f64;
        let gap = if count > 60 { 0.0 } else { 0.14 * wide };
        let every = count.div_ceil(MOST_LABELS);
        for (bar, label) in self.labels.iter().enumerate() {
            let (from, to) = (left + wide * bar as f64 + gap, left + wide * (bar + 1) as f64 - gap);
            let mut below = 0.0;
            for stack in &self.stacks {
                let value = stack.height(bar);
                if value > 0.0 {
                    let corners = [place((from, y(below + value))), place((to, y(below)))];
                    page.draw(&Rectangle::new(corners, rgb(stack.colour).filled()))?;
                    below += value;
                }
            }
            if bar % every == 0 {
                let at = place((0.5 * (from + to), lower + 18.0));
                page.draw(&Text::new(clean(label), at, letters(13, BLACK, HPos::Center)))?;
            }
        }
        let floor = vec![place((left, lower)), place((right, lower))];
        page.draw(&PathElement::new(floor, BLACK.stroke_width(8)))?;
        self.legend(page)
    }

    /// Names of the parts that are there, in a row above the bars.
    fn legend(&self, page: &Sheet) -> Drawn {
        let there = self.stacks.iter().filter(|stack| stack.values.iter().any(|value| *value > 0.0));
        let mut x = AREA.0 + 60.0;
        for stack in there {
            let y = AREA.2 - 18.0;
            let swatch = [place((x, y - 6.0)), place((x + 12.0, y + 6.0))];
            page.draw(&Rectangle::new(swatch, rgb(stack.colour).filled()))?;
            page.draw(&Text::new(clean(&stack.name), place((x + 18.0, y)), letters(13, BLACK, HPos::Left)))?;
            x += 34.0 + 7.0 * stack.name.chars().count() as f64;
        }
        Ok(())
    }
}

impl Stack {
    /// Of a bar; what is no number above zero has none.
    fn height(&self, bar: usize) -> f64 {
        self.values.get(bar).copied().filter(|value| value.is_finite()).unwrap_or_default().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 2 stacks of 3 bars, one value below zero and one no number, 4 rectangles stand above each other, as high as their values to
    /// 0.1 %; names with `<` are text in 6 of 6 places.
    #[test]
    fn heights() {
        let bad = "a<script>";
        let stack = |values: [f64; 3]| Stack { name: bad.into(), colour: [1, 2, 3], values: values.into() };
        let bars = Bars {
            title: bad.into(),
            called: bad.into(),
            unit: bad.into(),
            labels: vec![bad.into(), "b".into(), "c".into()],
            stacks: vec![stack([30.0, -5.0, 50.0]), stack([12.5, 40.0, f64::NAN])],
        };
        let svg = bars.svg().expect("drawn");
        assert!(!svg.contains("<script") && svg.matches("a&lt;script&gt;").count() == 6, "{svg}");
        let number = |line: &str, name: &str| -> f64 {
            let rest = line.split_once(&format!(" {name}=\"")).expect("an attribute").1;
            rest.split('"').next().and_then(|n| n.parse().ok()).expect("a number")
        };
        // Behind those of the bars come two of the legend.
        let rects: Vec<&str> =
            svg.lines().filter(|line| line.starts_with("<rect") && line.contains("#010203")).collect();
        assert_eq!(rects.len(), 4 + 2);
        // The axis ends at 50, 2880 units above its foot.
        let heights: Vec<f64> = rects.iter().take(4).map(|line| number(line, "height") / 2880.0 * 50.0).collect();
        for (height, value) in heights.iter().zip([30.0, 12.5, 40.0, 50.0]) {
            assert!((height - value).abs() < 0.05, "{heights:?}");
        }
        assert_eq!(number(rects[0], "y"), number(rects[1], "y") + number(rects[1], "height"));
    }
}
