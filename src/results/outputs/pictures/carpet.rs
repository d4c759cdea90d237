//! Hours of the day by month or day, as a carpet of colours. In: a value for each hour of each column. Out: SVG in the page's colours.

use plotters::prelude::{BLACK, Color, PathElement, Rectangle, Text};
use plotters::style::text_anchor::HPos;

use super::colours::{STEPS, viridis, viridis_step};
use super::plot_scale::round_steps;
use super::sheet::{Drawn, Sheet, clean, heading, letters, place, rgb, svg};
use heliotile_core::error::Result;

/// Hours of a day.
pub const HOURS: usize = 24;

/// A picture of hours.
pub struct Carpet {
    pub title: String,
    /// Below the title.
    pub called: String,
    /// One a column.
    pub labels: Vec<String>,
    /// `[column][hour of the day]`; hours that nobody knows stay white.
    pub columns: Vec<[Option<f64>; HOURS]>,
}

/// Of the page, pixels.
const SIZE: (u32, u32) = (900, 540);
/// Where hours stand: left, right, top, bottom.
const AREA: (f64, f64, f64, f64) = (72.0, 880.0, 70.0, 430.0);
/// Of the legend: left, right, top, bottom.
const LEGEND: (f64, f64, f64, f64) = (72.0, 584.0, 478.0, 494.0);
/// Labels that have room below the columns.
const MOST_LABELS: usize = 16;

impl Carpet {
    /// The picture.
    pub fn svg(&self) -> Result<String> {
        svg(SIZE.0, SIZE.1, |page| self.draw(page))
    }

    /// Round values from 0 to the end of the colours.
    pub fn ticks(&self) -> Vec<f64> {
        let values = self.columns.iter().flatten().flatten();
        round_steps(values.copied().filter(|value| value.is_finite()).fold(0.0, f64::max), 5)
    }

    fn draw(&self, page: &Sheet) -> Drawn {
        let (left, right, upper, lower) = AREA;
        heading(page, &self.title, &self.called)?;
        let ticks = self.ticks();
        let top = ticks.last().copied().unwrap_or(1.0);
        let count = self.columns.len().max(1);
        let x = |column: usize| left + (right - left) * column as f64 / count as f64;
        let y = |hour: usize| lower - (lower - upper) * hour as f64 / HOURS as f64;
        for (column, hours) in self.columns.iter().enumerate() {
            for (hour, value) in hours.iter().enumerate() {
                let Some(value) = value else { continue };
                let corners = [place((x(column), y(hour + 1))), place((x(column + 1), y(hour)))];
                let colour = rgb(viridis(viridis_step((value / top) as f32)));
                page.draw(&Rectangle::new(corners, colour.filled()))?;
            }
        }
        for hour in (0..=HOURS).step_by(6) {
            let tick = vec![place((left - 5.0, y(hour))), place((left, y(hour)))];
            page.draw(&PathElement::new(tick, BLACK.stroke_width(8)))?;
            let words = format!("{hour}:00");
            page.draw(&Text::new(words, place((left - 9.0, y(hour))), letters(13, BLACK, HPos::Right)))?;
        }
        let every = count.div_ceil(MOST_LABELS);
        for (column, label) in self.labels.iter().enumerate().step_by(every) {
            let at = place((0.5 * (x(column) + x(column + 1)), lower + 18.0));
            page.draw(&Text::new(clean(label), at, letters(13, BLACK, HPos::Center)))?;
        }
        legend(page, &ticks, top)
    }
}

fn legend(page: &Sheet, ticks: &[f64], top: f64) -> Drawn {
    let (left, right, upper, lower) = LEGEND;
    let x = |share: f64| left + (right - left) * share;
    for step in 0..STEPS {
        let share = |step: usize| step as f64 / STEPS as f64;
        let corners = [place((x(share(step)), upper)), place((x(share(step + 1)), lower))];
        page.draw(&Rectangle::new(corners, rgb(viridis(step as u8)).filled()))?;
    }
    for tick in ticks {
        let at = place((x(tick / top), lower + 14.0));
        page.draw(&Text::new(tick.to_string(), at, letters(13, BLACK, HPos::Center)))?;
    }
    page.draw(&Text::new("W/m2", place((right + 40.0, 0.5 * (upper + lower))), letters(13, BLACK, HPos::Left)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 2 columns, 3 hours known, 3 rectangles stand beside those of the page and of 256 steps, in the colours of 0, a half and all of
    /// the scale's end, 500.
    #[test]
    fn colours_of_hours() {
        let mut columns = vec![[None; HOURS]; 2];
        (columns[0][3], columns[1][12], columns[1][13]) = (Some(0.0), Some(250.0), Some(500.0));
        let carpet = Carpet { title: "<i>".into(), called: "x".into(), labels: vec!["a".into(), "b".into()], columns };
        assert_eq!(carpet.ticks().last(), Some(&500.0));
        let svg = carpet.svg().expect("drawn");
        let rects: Vec<&str> = svg.lines().filter(|line| line.starts_with("<rect")).collect();
        assert_eq!(rects.len(), 1 + 3 + STEPS);
        for (line, step) in rects[1..4].iter().zip([0, 128, 255]) {
            let [r, g, b] = viridis(step);
            assert!(line.contains(&format!("#{r:02X}{g:02X}{b:02X}")), "{line}");
        }
        assert!(!svg.contains("<i>"));
    }
}
