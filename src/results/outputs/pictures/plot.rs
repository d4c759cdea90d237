//! Chart: lines and marks over two axes. In: series of points. Out: SVG.

use super::axes::{self, Frame, LETTERS, MARGIN, SWATCH};
use super::drawing::{At, Drawing, INK, Rgb, Side};
use super::font::Font;
use super::scale::Scale;

/// Chart to be drawn.
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Series; the first is drawn first, below the others.
    pub series: Vec<Series>,
}

/// Axis of a chart; its range follows from the points.
pub struct Axis {
    pub label: String,
    pub log: bool,
}

/// Series of points. Points that an axis cannot hold are left out: not finite, or not positive on a
/// logarithmic axis.
pub struct Series {
    /// Name in the legend; nameless series have no entry there.
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Text beside each point, in the order of points; may be shorter than the points, or empty.
    pub labels: Vec<String>,
    pub style: Style,
}

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    Line,
    Marks,
    Both,
}

/// Colours of the series in turn, by Okabe and Ito, "Color Universal Design", 2008, which
/// colour-blind people can tell apart. Their yellow is left out: it is invisible on white.
pub const COLOURS: [Rgb; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [0; 3], [204, 121, 167], [230, 159, 0], [86, 180, 233]];
/// Colour of lines within decades.
const MINOR: Rgb = [240, 243, 245];

/// Radius of a mark, points.
const MARK: f64 = 4.0;
/// Letters beside points.
const BESIDE: Font = Font::new(12.0);

/// Largest number of ticks of an axis.
const TICKS: usize = 8;

/// Smallest size of a picture, pixels: smaller ones have no room for axes. `MAX` is the largest
/// width or height.
const MIN: (u32, u32) = (240, 160);
const MAX: u32 = 20_000;

impl Plot {
    /// Returns the picture as SVG; `width` and `height` in pixels.
    pub fn svg(&self, width: u32, height: u32) -> String {
        let [width, height] = [width.clamp(MIN.0, MAX), height.clamp(MIN.1, MAX)].map(f64::from);
        let held = |point: &&(f64, f64)| Scale::holds(point.0, self.x.log) && Scale::holds(point.1, self.y.log);
        let all = || self.series.iter().flat_map(|series| &series.points).filter(held);
        let x = Scale::new(all().map(|point| point.0), self.x.log);
        let y = Scale::new(all().map(|point| point.1), self.y.log);
        let mut page = Drawing::new(width, height);
        page.heading(&self.title, "");
        let coloured = || self.series.iter().zip(COLOURS.into_iter().cycle());
        let named = || coloured().filter(|(series, _)| !series.name.is_empty());
        let swatches =
            page.legend((MARGIN, 46.0), &named().map(|(series, _)| series.name.as_str()).collect::<Vec<_>>());
        for ((series, colour), (x, y)) in named().zip(&swatches) {
            series.draw(&mut page, &[(*x, *y), (x + SWATCH, *y)], &[(x + 0.5 * SWATCH, *y)], colour);
        }
        let top = swatches.last().map_or(42.0, |(_, y)| y + 22.0);
        let y_ticks = y.ticks(TICKS);
        let widest = y_ticks.iter().map(|(_, words)| LETTERS.width(words)).fold(0.0, f64::max);
        let frame = Frame { left: 44.0 + widest, right: width - 24.0, top, bottom: height - 54.0 };

        x.minor_ticks().iter().for_each(|at| page.line(&[frame.at(*at, 0.0), frame.at(*at, 1.0)], 1.0, MINOR));
        y.minor_ticks().iter().for_each(|at| page.line(&[frame.at(0.0, *at), frame.at(1.0, *at)], 1.0, MINOR));
        page.axis(&frame, axes::Axis::Below, &x.ticks(TICKS), true);
        page.axis(&frame, axes::Axis::Left, &y_ticks, true);
        page.line(&[frame.at(0.0, 1.0), frame.at(0.0, 0.0), frame.at(1.0, 0.0)], 1.0, INK);
        page.text(&self.x.label, (frame.at(0.5, 0.0).0, height - 16.0), LETTERS, Side::Center, INK);
        page.text_up(&self.y.label, (18.0, frame.at(0.0, 0.5).1), LETTERS, frame.bottom - frame.top + 16.0);

        // Words beside points so far, each as the positions of its left and right end.
        let mut beside = Vec::new();
        for (series, colour) in coloured() {
            let labels = series.labels.iter().map(String::as_str).chain(std::iter::repeat(""));
            let (points, labels): (Vec<&(f64, f64)>, Vec<&str>) =
                series.points.iter().zip(labels).filter(|(p, _)| held(p)).unzip();
            let places: Vec<At> = points.iter().map(|point| frame.at(x.share(point.0), y.share(point.1))).collect();
            series.draw(&mut page, &places, &places, colour);
            for (at, label) in places.iter().zip(labels).filter(|(_, label)| !label.is_empty()) {
                let (side, ends) = room(*at, BESIDE.width(label), &frame, &beside);
                page.text(label, if side == Side::Left { ends[0] } else { ends[1] }, BESIDE, side, INK);
                beside.push(ends);
            }
        }
        page.svg()
    }
}

impl Series {
    /// Returns a series without words beside its points.
    pub fn new(name: &str, points: Vec<(f64, f64)>, style: Style) -> Self {
        Series { name: name.into(), points, labels: Vec::new(), style }
    }

    /// Draws the line and the marks, in the chart or in the legend.
    fn draw(&self, page: &mut Drawing, path: &[At], marks: &[At], colour: Rgb) {
        if self.style != Style::Marks && path.len() > 1 {
            page.line(path, 2.0, colour);
        }
        // A line of one point would be invisible, so it gets a mark.
        if self.style != Style::Line || path.len() == 1 {
            marks.iter().for_each(|at| page.dot(*at, MARK, colour));
        }
    }
}

/// Returns the position of words beside a point: within the frame and off other words if possible.
fn room(at: At, width: f64, frame: &Frame, others: &[[At; 2]]) -> (Side, [At; 2]) {
    let ends = |side, down| {
        let (left, y) = (if side == Side::Left { at.0 + 6.0 } else { at.0 - 6.0 - width }, at.1 + down);
        (side, [(left, y), (left + width, y)])
    };
    let is_free = |(_, [left, right]): &(Side, [At; 2])| {
        let meets =
            |other: &[At; 2]| (other[0].1 - left.1).abs() < LETTERS.size && other[0].0 < right.0 && left.0 < other[1].0;
        left.0 > frame.left && right.0 < frame.right && !others.iter().any(meets)
    };
    let mut all =
        [-9.0, 9.0, -23.0, 23.0].into_iter().flat_map(|down| [Side::Left, Side::Right].map(|side| ends(side, down)));
    all.find(is_free).unwrap_or(ends(Side::Left, -9.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(points: &[(f64, f64)], style: Style) -> Series {
        Series::new("north", points.to_vec(), style)
    }

    fn plot(series: Vec<Series>, log: bool) -> Plot {
        let axis = |label: &str| Axis { label: label.into(), log };
        Plot { title: "Walls".into(), x: axis("rays"), y: axis("error, %"), series }
    }

    fn count(svg: &str, tag: &str) -> usize {
        svg.matches(&format!("<{tag} ")).count()
    }

    const FIVE: [(f64, f64); 5] = [(1.0, 2.0), (f64::NAN, 3.0), (3.0, f64::INFINITY), (-4.0, 5.0), (10.0, 0.0)];

    /// A linear chart of five points holds the three finite ones and a logarithmic chart the single
    /// positive one: as many marks, and one more in the legend.
    #[test]
    fn bad_points_are_dropped() {
        for (log, kept) in [(false, 3), (true, 1)] {
            let svg = plot(vec![series(&FIVE, Style::Marks)], log).svg(640, 400);
            assert_eq!(count(&svg, "circle"), kept + 1, "{svg}");
        }
    }

    /// Two calls give equal bytes, 640 x 400 as requested, closed once and without references.
    #[test]
    fn equal_charts_have_equal_bytes() {
        let three = || vec![series(&FIVE, Style::Both), series(&FIVE, Style::Marks), series(&FIVE, Style::Line)];
        let svg = plot(three(), false).svg(640, 400);
        assert_eq!(svg, plot(three(), false).svg(640, 400));
        assert!(svg.starts_with("<svg width=\"640\" height=\"400\" viewBox=\"0 0 640 400\""), "{svg}");
        assert!(svg.ends_with("</svg>\n") && svg.matches("</svg>").count() == 1);
        assert!(!svg.contains("href") && !svg.contains(" id="));
    }

    /// Charts without series, with an empty series and with a single point have 0, 0 and 1 marks,
    /// in every style and down to a size of 0 x 0.
    #[test]
    fn charts_with_at_most_one_point_are_drawn() {
        for style in [Style::Line, Style::Both, Style::Marks] {
            for (points, marks) in [(&[][..], 0), (&[(2.0, 3.0)][..], 1)] {
                let nameless = Series { name: String::new(), ..series(points, style) };
                let svg = plot(vec![nameless], true).svg(0, 0);
                assert_eq!(count(&svg, "circle"), marks, "{style:?}");
            }
        }
        assert_eq!(count(&plot(Vec::new(), false).svg(300, 200), "circle"), 0);
    }

    /// Words are escaped: in 5 places with `<&>` none is unescaped, and characters that XML forbids
    /// become blanks.
    #[test]
    fn words_are_escaped() {
        let bad = "a<b>&\"c\u{1}";
        let mut plot = plot(vec![series(&[(1.0, 2.0)], Style::Marks)], false);
        plot.title = bad.into();
        (plot.x.label, plot.y.label) = (bad.into(), bad.into());
        plot.series[0].name = bad.into();
        plot.series[0].labels = vec![bad.into()];
        let svg = plot.svg(640, 400);
        assert_eq!(svg.matches(">a&lt;b&gt;&amp;\"c </text>").count(), 5, "{svg}");
        assert!(!svg.contains("a<b") && !svg.contains('\u{1}'));
    }
}
