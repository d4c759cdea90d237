//! Hours of the day by month or day, as a heat map. In: a value for each hour of each column. Out:
//! SVG in the page's colours.

use super::axes::{Axis, Frame};
use super::colours::ColourScale;
use super::drawing::Drawing;

/// Number of hours in a day.
pub const HOURS: usize = 24;

/// Picture of hours.
pub struct Carpet {
    pub title: String,
    /// Line below the title.
    pub called: String,
    /// Label of each column.
    pub labels: Vec<String>,
    /// `[column][hour of the day]`; unknown hours stay white.
    pub columns: Vec<[Option<f64>; HOURS]>,
    /// Colour scale of the values.
    pub scale: ColourScale,
}

/// Size of the page, points.
const SIZE: (f64, f64) = (900.0, 540.0);
/// Frame of the hours.
const FRAME: Frame = Frame { left: 72.0, right: 880.0, top: 70.0, bottom: 430.0 };
const LEGEND: Frame = Frame { left: 72.0, right: 584.0, top: 478.0, bottom: 494.0 };

impl Carpet {
    /// Returns the picture.
    pub fn drawing(&self) -> Drawing {
        let values = self.columns.iter().flatten().flatten().copied().filter(|value| value.is_finite());
        let ends = self.scale.ticks(values.map(|value| self.scale.reach(value as f32).into()).fold(0.0, f64::max));
        let top = ends.last().copied().unwrap_or(1.0);
        let x = |column: f64| column / self.columns.len().max(1) as f64;
        let y = |hour: usize| hour as f64 / HOURS as f64;
        let hours: Vec<(f64, String)> = (0..=HOURS).step_by(6).map(|hour| (y(hour), format!("{hour}:00"))).collect();
        let middle = |(column, label): (usize, &String)| (x(column as f64 + 0.5), label.clone());
        let labels: Vec<(f64, String)> = self.labels.iter().enumerate().map(middle).collect();

        let mut page = Drawing::new(SIZE.0, SIZE.1);
        page.heading(&self.title, &self.called);
        page.axis(&FRAME, Axis::Left, &hours, true);
        page.axis(&FRAME, Axis::Below, &labels, false);
        for (column, hours) in self.columns.iter().enumerate() {
            for (hour, value) in hours.iter().enumerate() {
                let Some(value) = value else { continue };
                let colour = self.scale.on_paper((value / top) as f32);
                let (left, right) = (x(column as f64), x((column + 1) as f64));
                page.cell([FRAME.at(left, y(hour + 1)), FRAME.at(right, y(hour))], colour);
            }
        }
        page.colour_scale(&LEGEND, self.scale, &ends, "W/m\u{b2}", 0.0);
        page
    }
}

#[cfg(test)]
mod tests {
    use super::super::colours::{STEPS, viridis};
    use super::*;

    /// With 2 columns and 3 known hours, 3 rectangles stand beside the page's and the legend's 256,
    /// in the colours of 0, a half and all of the scale's end, 500.
    #[test]
    fn only_known_hours_are_coloured() {
        let mut columns = vec![[None; HOURS]; 2];
        (columns[0][3], columns[1][12], columns[1][13]) = (Some(0.0), Some(250.0), Some(500.0));
        let carpet = Carpet {
            title: "<i>".into(),
            called: "x".into(),
            labels: vec!["a".into(), "b".into()],
            columns,
            scale: ColourScale::FromZero,
        };
        let svg = carpet.drawing().svg();
        assert!(svg.contains(">500</text>") && !svg.contains(">600</text>"), "{svg}");
        let rects: Vec<&str> = svg.lines().filter(|line| line.starts_with("<rect")).collect();
        assert_eq!(rects.len(), 1 + 3 + STEPS);
        for (line, step) in rects[1..4].iter().zip([0, 128, 255]) {
            let [r, g, b] = viridis(step);
            assert!(line.contains(&format!("#{r:02X}{g:02X}{b:02X}")), "{line}");
        }
        assert!(!svg.contains("<i>"));
    }
}
