//! A picture of numbers: lines and marks over two axes. In: series of points. Out: SVG.

use std::ops::Range;

use plotters::coord::ranged1d::Ranged;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, Color, PathElement, RGBColor, Rectangle, ShapeStyle, Text, TextStyle, WHITE,
};
use plotters::style::text_anchor::HPos;

use crate::outputs::pictures::plot_scale::Scale;
use crate::outputs::pictures::sheet::{self, Drawn, FINE, Sheet, clean};
use heliotile_core::error::Result;

/// A picture to be drawn.
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// The first is drawn first, below the others.
    pub series: Vec<Series>,
}

/// An axis; its range follows from the points.
pub struct Axis {
    pub label: String,
    pub log: bool,
}

/// Points that belong together. Those that an axis cannot hold are left out: not finite, or not positive on a logarithmic one.
pub struct Series {
    /// For the legend; nameless series have no line there.
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Text beside each point, in their order; may be shorter than the points, or empty.
    pub labels: Vec<String>,
    pub style: Style,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    Line,
    Marks,
    Both,
}

/// Of the series in turn. Okabe and Ito, "Color Universal Design", 2008, which colour-blind people tell apart, without its yellow,
/// which white swallows.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    BLACK,
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Sizes in pixels: letters, a mark's radius, a line of the legend and the part of it that is drawn.
const LETTERS: i32 = 15;
const MARK: i32 = 4;
const ROW: i32 = 18;
const SWATCH: i32 = 26;

/// Ticks that an axis has at most.
const TICKS: usize = 8;

/// Smaller pictures have no room for their axes.
const LEAST: (u32, u32) = (240, 160);
const MOST: u32 = 20_000;

/// A place of the drawing, top left (0, 0), in fine units.
type At = (i32, i32);

impl Plot {
    /// The picture, of a width and a height in pixels.
    pub fn svg(&self, width: u32, height: u32) -> Result<String> {
        sheet::svg(width.clamp(LEAST.0, MOST), height.clamp(LEAST.1, MOST), |page| self.draw(page))
    }

    fn draw(&self, page: &Sheet) -> Drawn {
        let held: Vec<Held> =
            self.series.iter().zip((0..).map(colour)).map(|(s, colour)| self.held(s, colour)).collect();
        let all = || held.iter().flat_map(|series| &series.points);
        let x = Scale::of(all().map(|point| point.0), self.x.log);
        let y = Scale::of(all().map(|point| point.1), self.y.log);

        let longest = y.ticks(TICKS).iter().map(|tick| y.plain(*tick).len()).max().unwrap_or(1);
        let mut chart = ChartBuilder::on(page)
            .margin(12 * FINE)
            .margin_right(24 * FINE)
            .caption(clean(&self.title), letters(LETTERS + 3, HPos::Left))
            .x_label_area_size(46 * FINE)
            .y_label_area_size((30 + 8 * longest as i32) * FINE)
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .x_labels(TICKS)
            .y_labels(TICKS)
            .x_label_formatter(&|tick| x.plain(*tick))
            .y_label_formatter(&|tick| y.plain(*tick))
            .x_desc(clean(&self.x.label))
            .y_desc(clean(&self.y.label))
            .label_style(letters(LETTERS, HPos::Left))
            .axis_desc_style(letters(LETTERS, HPos::Left))
            .axis_style(thick(BLACK, 1))
            .bold_line_style(thick(RGBColor(204, 204, 204), 1))
            .light_line_style(thick(RGBColor(236, 236, 236), 1))
            .set_all_tick_mark_size(4 * FINE)
            .draw()?;

        let (across, down) = chart.plotting_area().get_pixel_range();
        let place =
            |&(px, py): &(f64, f64)| (x.map(&px, (across.start, across.end)), y.map(&py, (down.end, down.start)));
        let between = Between { page, across: across.clone(), down: down.clone() };
        let placed: Vec<Vec<At>> = held.iter().map(|series| series.points.iter().map(place).collect()).collect();
        for (series, places) in held.iter().zip(&placed) {
            between.series(places, series)?;
        }
        let named: Vec<&Held> = held.iter().filter(|series| !series.name.is_empty()).collect();
        between.legend(&named, &placed)
    }

    /// What both axes hold of a series.
    fn held(&self, series: &Series, colour: RGBColor) -> Held {
        let labels = series.labels.iter().map(|label| clean(label)).chain(std::iter::repeat(String::new()));
        let holds = |point: &(f64, f64)| Scale::holds(point.0, self.x.log) && Scale::holds(point.1, self.y.log);
        let (points, labels) = series.points.iter().zip(labels).filter(|(point, _)| holds(point)).unzip();
        Held { name: clean(&series.name), points, labels, style: series.style, colour }
    }
}

/// A series as it is drawn.
struct Held {
    name: String,
    points: Vec<(f64, f64)>,
    /// One a point.
    labels: Vec<String>,
    style: Style,
    colour: RGBColor,
}

/// The drawing, and the part of it between the axes.
struct Between<'p, 'a> {
    page: &'p Sheet<'a>,
    across: Range<i32>,
    down: Range<i32>,
}

impl Between<'_, '_> {
    fn series(&self, places: &[At], series: &Held) -> Drawn {
        self.line(places, places, series)?;
        let far_right = self.across.start + (self.across.end - self.across.start) * 3 / 4;
        for (at, label) in places.iter().zip(&series.labels).filter(|(_, label)| !label.is_empty()) {
            // Words do not leave the picture on the right.
            let (side, shift) = if at.0 > far_right { (HPos::Right, -6) } else { (HPos::Left, 6) };
            let at = (at.0 + shift * FINE, at.1 - 9 * FINE);
            self.page.draw(&Text::new(label.as_str(), at, letters(LETTERS - 2, side)))?;
        }
        Ok(())
    }

    /// Line and marks of a series, or of its line in the legend.
    fn line(&self, path: &[At], marks: &[At], series: &Held) -> Drawn {
        let style = thick(series.colour, 2);
        match series.style {
            Style::Line | Style::Both => self.page.draw(&PathElement::new(path, style))?,
            Style::Marks => {}
        }
        // A line of one point would not be seen.
        if matches!(series.style, Style::Marks | Style::Both) || path.len() == 1 {
            for at in marks {
                self.page.draw(&Circle::new(*at, MARK * FINE, series.colour.filled()))?;
            }
        }
        Ok(())
    }

    /// Names in the corner that lines cross least.
    fn legend(&self, named: &[&Held], placed: &[Vec<At>]) -> Drawn {
        let longest = named.iter().map(|series| series.name.chars().count()).max().unwrap_or(0);
        if longest == 0 {
            return Ok(());
        }
        let (width, height) = ((SWATCH + 18 + 8 * longest as i32) * FINE, (ROW * named.len() as i32 + 8) * FINE);
        let (left, right) = (self.across.start + 8 * FINE, self.across.end - 8 * FINE - width);
        let (top, bottom) = (self.down.start + 8 * FINE, self.down.end - 8 * FINE - height);
        let covered = |&(x, y): &At| {
            let inside = |at: &At| (x..x + width).contains(&at.0) && (y..y + height).contains(&at.1);
            placed.iter().flat_map(|places| along(places)).filter(inside).count()
        };
        let corners = [(right, top), (right, bottom), (left, top), (left, bottom)];
        let Some((x, y)) = corners.into_iter().min_by_key(covered) else { return Ok(()) };
        self.page.draw(&Rectangle::new([(x, y), (x + width, y + height)], WHITE.mix(0.85).filled()))?;
        for (series, row) in named.iter().zip(0..) {
            let middle = y + (4 + ROW * row + ROW / 2) * FINE;
            let (from, to) = (x + 4 * FINE, x + (4 + SWATCH) * FINE);
            self.line(&[(from, middle), (to, middle)], &[((from + to) / 2, middle)], series)?;
            let at = (to + 8 * FINE, middle);
            self.page.draw(&Text::new(series.name.as_str(), at, letters(LETTERS, HPos::Left)))?;
        }
        Ok(())
    }
}

/// Places, and 15 between each two.
fn along(places: &[At]) -> impl Iterator<Item = At> {
    let between = |(a, b): (&At, &At)| {
        let (a, b) = (*a, *b);
        (0..16).map(move |k| (a.0 + (b.0 - a.0) * k / 16, a.1 + (b.1 - a.1) * k / 16))
    };
    places.iter().zip(&places[1.min(places.len())..]).flat_map(between).chain(places.last().copied())
}

fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

fn thick(colour: RGBColor, pixels: u32) -> ShapeStyle {
    colour.stroke_width(pixels * FINE as u32)
}

/// Black letters of a size in pixels.
fn letters(pixels: i32, side: HPos) -> TextStyle<'static> {
    sheet::letters(pixels, BLACK, side)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(points: &[(f64, f64)], style: Style) -> Series {
        Series { name: "north".into(), points: points.to_vec(), labels: Vec::new(), style }
    }

    fn plot(series: Vec<Series>, log: bool) -> Plot {
        let axis = |label: &str| Axis { label: label.into(), log };
        Plot { title: "Walls".into(), x: axis("rays"), y: axis("error, %"), series }
    }

    fn count(svg: &str, tag: &str) -> usize {
        svg.matches(&format!("<{tag} ")).count()
    }

    const FIVE: [(f64, f64); 5] = [(1.0, 2.0), (f64::NAN, 3.0), (3.0, f64::INFINITY), (-4.0, 5.0), (10.0, 0.0)];

    /// Of five points, a linear picture holds the three finite ones and a logarithmic one the single positive one: so many marks,
    /// and one more in the legend.
    #[test]
    fn bad_points_are_dropped() {
        for (log, kept) in [(false, 3), (true, 1)] {
            let svg = plot(vec![series(&FIVE, Style::Marks)], log).svg(640, 400).expect("drawn");
            assert_eq!(count(&svg, "circle"), kept + 1, "{svg}");
        }
    }

    /// Two calls give equal bytes, 640 x 400 as asked, closed once and without references.
    #[test]
    fn equal_bytes() {
        let three = || vec![series(&FIVE, Style::Both), series(&FIVE, Style::Marks), series(&FIVE, Style::Line)];
        let svg = plot(three(), false).svg(640, 400).expect("drawn");
        assert_eq!(svg, plot(three(), false).svg(640, 400).expect("drawn"));
        assert!(svg.starts_with("<svg width=\"640\" height=\"400\" viewBox=\"0 0 5120 3200\""), "{svg}");
        assert!(svg.ends_with("</svg>\n") && svg.matches("</svg>").count() == 1);
        assert!(!svg.contains("href") && !svg.contains(" id="));
    }

    /// No series, one without points and one of a single point are pictures with 0, 0 and 1 marks, in every style and down to 0 x 0.
    #[test]
    fn few_points() {
        for style in [Style::Line, Style::Both, Style::Marks] {
            for (points, marks) in [(&[][..], 0), (&[(2.0, 3.0)][..], 1)] {
                let nameless = Series { name: String::new(), ..series(points, style) };
                let svg = plot(vec![nameless], true).svg(0, 0).expect("drawn");
                assert_eq!(count(&svg, "circle"), marks, "{style:?}");
            }
        }
        assert_eq!(count(&plot(Vec::new(), false).svg(300, 200).expect("drawn"), "circle"), 0);
    }

    /// Words are escaped: of 5 places with `<&">`, none is there as it was, and signs that XML forbids are blanks.
    #[test]
    fn words_are_escaped() {
        let bad = "a<b>&\"c\u{1}";
        let mut plot = plot(vec![series(&[(1.0, 2.0)], Style::Marks)], false);
        plot.title = bad.into();
        (plot.x.label, plot.y.label) = (bad.into(), bad.into());
        plot.series[0].name = bad.into();
        plot.series[0].labels = vec![bad.into()];
        let svg = plot.svg(640, 400).expect("drawn");
        assert_eq!(svg.matches("a&lt;b&gt;&amp;&quot;c ").count(), 5, "{svg}");
        assert!(!svg.contains("a<b") && !svg.contains('\u{1}'));
    }

    /// A logarithmic axis from 0.02 to 150 says 0.1, 1, 10 and 100 in plain figures.
    #[test]
    fn plain_ticks() {
        let svg = plot(vec![series(&[(0.02, 0.02), (150.0, 150.0)], Style::Line)], true).svg(640, 400).expect("drawn");
        for tick in ["0.1", "1", "10", "100"] {
            assert_eq!(svg.lines().filter(|line| *line == tick).count(), 2, "{tick}");
        }
    }
}
