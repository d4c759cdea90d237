//! Colours of the rows of a map. In: columns, all rows. Out: the colour and the mark of a row, and
//! the legend.

use super::super::columns::MapColumns;
use super::super::row::MapRow;
use super::super::rows::MapRows;
use crate::outputs::pictures::axes::{Axis, Frame, LETTERS};
use crate::outputs::pictures::colours::{ColourScale, STEPS, between};
use crate::outputs::pictures::drawing::{Drawing, INK, Image, PALE_INK, Rgb, SAMPLES, Side};
use crate::outputs::pictures::scale::{round_range, words};
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::Verdict;
use crate::outputs::tables::layout::CELSIUS;
use heliotile_core::error::Result;

/// Percentile of the distance from zero at which a scale around zero ends: single places would make
/// all others pale.
const PERCENTILE: u64 = 98;
/// Number of classes of distances, by which the percentile is found.
const CLASSES: usize = 4096;

/// Colours of values that break a rule, from those next to the threshold to those far from it, and
/// of values that meet it: `Oranges` and `Blues` of ColorBrewer, which colour-blind people can tell
/// apart. Broken ones are hatched, too, for prints without colours.
const BROKEN: [[f32; 3]; 2] = [[253.0, 190.0, 133.0], [166.0, 54.0, 3.0]];
const MET: [[f32; 3]; 2] = [[198.0, 219.0, 239.0], [8.0, 69.0, 148.0]];
/// Colour of values that are as close to the threshold as they may be off.
const CLOSE: Rgb = [240, 228, 66];

/// Width and height of a swatch, points.
const SWATCH: [usize; 2] = [26, 14];

/// Colour of a surface, and its mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink {
    colour: Rgb,
    verdict: Option<Verdict>,
}

impl Ink {
    /// Returns a colour without a mark.
    pub fn plain(colour: Rgb) -> Self {
        Ink { colour, verdict: None }
    }

    /// Returns the colour of a sample: stripes mark broken rules, dots those that are close.
    pub fn at(self, column: usize, row: usize) -> Rgb {
        let is_marked = match self.verdict {
            Some(Verdict::Broken) => (column + row) % (7 * SAMPLES) < SAMPLES + 1,
            Some(Verdict::Close) => [column, row].iter().all(|at| at % (4 * SAMPLES) < SAMPLES + 2),
            _ => false,
        };
        if is_marked { self.colour.map(|part| part / 2) } else { self.colour }
    }
}

/// Colours of the values of a map.
pub struct Palette {
    column: usize,
    scale: ColourScale,
    ticks: Vec<f64>,
    /// Largest distance from zero, if it lies beyond the ends of the scale.
    beyond: Option<f64>,
    rule: Option<RuleColumns>,
}

/// Class of values, with its colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Swatch {
    /// Lowest value, or the only one.
    pub from: f64,
    /// Highest value, if the class is a range.
    pub to: Option<f64>,
    pub label: String,
    pub colour: Rgb,
}

/// Rule that values meet or break.
struct RuleColumns {
    /// Number column of the verdict.
    verdict: usize,
    /// Value that the rule demands.
    threshold: f64,
    /// True if lower values meet it.
    is_most: bool,
}

impl Palette {
    /// Returns the colours of all rows.
    pub fn new(rows: &mut MapRows, columns: &MapColumns) -> Result<Self> {
        let (column, scale) = (columns.colour, columns.scale);
        let (largest, mut counts) = (f64::from(rows.facts.largest), vec![0_u64; CLASSES]);
        let mut lowest = f64::INFINITY;
        let mut rule = None;
        rows.each(|row| {
            let value = row.numbers.get(column).copied().map_or(f64::NAN, f64::from);
            lowest = lowest.min(value);
            if value.is_finite() && largest > 0.0 {
                counts[((value.abs() / largest * CLASSES as f64) as usize).min(CLASSES - 1)] += 1;
            }
            let thresholds =
                columns.thresholds.map(|column| column.and_then(|column| row.numbers.get(column)).copied());
            if let (None, Some(verdict)) = (&rule, columns.verdict) {
                let found = thresholds.iter().position(|number| number.is_some_and(f32::is_finite));
                let threshold = found.and_then(|number| thresholds[number]);
                rule = threshold.map(|threshold| RuleColumns {
                    verdict,
                    threshold: threshold.into(),
                    is_most: found == Some(1),
                });
            }
            Ok(())
        })?;
        let end = percentile(&counts) * largest;
        let threshold = rule.as_ref().map_or(0.0, |rule| rule.threshold);
        // Zero degrees Celsius mean nothing.
        let ticks = match scale {
            ColourScale::AroundZero => scale.ticks(end),
            ColourScale::FromZero if columns.numbers.get(column).is_some_and(|(_, unit)| *unit == CELSIUS) => {
                round_range(lowest, largest, 5)
            }
            ColourScale::FromZero => scale.ticks(largest.max(threshold)),
        };
        let top = ticks.last().copied().unwrap_or(1.0);
        Ok(Palette { column, scale, beyond: (largest > top).then_some(largest), ticks, rule })
    }

    /// Returns a scale from zero to `top` of the first number of rows.
    pub fn from_zero(top: f64) -> Self {
        Palette { column: 0, scale: ColourScale::FromZero, ticks: vec![0.0, top], beyond: None, rule: None }
    }

    fn top(&self) -> f64 {
        self.ticks.last().copied().unwrap_or(1.0)
    }

    /// Returns the number whose colour is the first of the scale, or the middle one around zero.
    fn origin(&self) -> f64 {
        if self.scale == ColourScale::AroundZero { 0.0 } else { self.ticks.first().copied().unwrap_or(0.0) }
    }

    /// Returns the ink of a row; `None` if it has no value.
    pub fn ink(&self, row: &MapRow) -> Option<Ink> {
        let value = row.numbers.get(self.column).copied().filter(|value| value.is_finite())?;
        let verdict = self.rule.as_ref().and_then(|rule| row.numbers.get(rule.verdict)).copied();
        Some(self.of_value(value.into(), verdict.and_then(Verdict::of)))
    }

    fn of_value(&self, value: f64, verdict: Option<Verdict>) -> Ink {
        let colour = match (&self.rule, verdict) {
            (Some(rule), Some(verdict)) => rule.colour(value, verdict, self.top()),
            _ => self.scale.on_paper(((value - self.origin()) / (self.top() - self.origin())) as f32),
        };
        Ink { colour, verdict }
    }

    /// Returns the number column that classes are of: the verdict of a rule, or the values.
    pub fn classed(&self) -> usize {
        self.rule.as_ref().map_or(self.column, |rule| rule.verdict)
    }

    /// Returns the classes: halves of the steps between the numbers of the legend, with values
    /// beyond it in the outermost ones, or the verdicts of a rule.
    pub fn swatches(&self) -> Vec<Swatch> {
        if let Some(rule) = &self.rule {
            let one = |(verdict, label, number): &(Verdict, &str, f32)| Swatch {
                from: f64::from(*number),
                to: None,
                label: (*label).to_owned(),
                colour: rule.ink(*verdict, self.top()).colour,
            };
            return Verdict::ALL.iter().map(one).collect();
        }
        let middle = |two: &[f64; 2]| [two[0], 0.5 * (two[0] + two[1])];
        let mut ends: Vec<f64> = self.ticks.array_windows().flat_map(middle).chain([self.top()]).collect();
        let own = ends.clone();
        if let (Some(beyond), [first, .., last]) = (self.beyond, ends.as_mut_slice()) {
            *last = beyond;
            if self.scale == ColourScale::AroundZero {
                *first = -beyond;
            }
        }
        let classes = ends.array_windows().zip(own.array_windows());
        classes
            .map(|([from, to], [low, high])| Swatch {
                from: *from,
                to: Some(*to),
                label: match (from == low, to == high) {
                    (false, _) => format!("less than {}", words(*to)),
                    (_, false) => format!("more than {}", words(*from)),
                    _ => format!("{} to {}", words(*from), words(*to)),
                },
                colour: self.of_value(0.5 * (low + high), None).colour,
            })
            .collect()
    }

    /// Returns how much darker surroundings are, so that the pale middle of a scale around zero
    /// stands out.
    pub fn darker(&self) -> f64 {
        if self.scale == ColourScale::AroundZero { 44.0 } else { 0.0 }
    }

    /// Returns the height of the legend's parts beside the scale, points.
    pub fn more_height(&self) -> f64 {
        if self.rule.is_some() || self.beyond.is_some() { 24.0 } else { 0.0 }
    }

    /// Draws the legend; `frame` is that of the colours.
    pub fn draw_legend(&self, page: &mut Drawing, frame: &Frame, unit: &str) {
        let (left, right) = (frame.at(0.0, 0.5), frame.at(1.0, 0.5));
        let y = frame.bottom + 44.0;
        if let Some(largest) = self.beyond {
            let half = 0.5 * (frame.bottom - frame.top);
            for (at, way, step) in [(left, -1.0, 0), (right, 1.0, STEPS - 1)] {
                let x = at.0 + way * 2.0;
                let arrow = vec![(x, at.1 - half), (x + way * 2.0 * half, at.1), (x, at.1 + half)];
                page.polygon(vec![arrow], self.scale.of_legend(step));
            }
            let text = format!(
                "scale to the {PERCENTILE}th percentile; arrows: places beyond, the farthest {} {unit} from zero",
                words((largest * 10.0).round() / 10.0)
            );
            page.text(&text, (frame.left, y), LETTERS, Side::Left, PALE_INK);
        }
        let Some(rule) = &self.rule else {
            let gap = if self.beyond.is_some() { frame.bottom - frame.top + 2.0 } else { 0.0 };
            return page.colour_scale(frame, self.scale, &self.ticks, unit, gap);
        };
        let top = self.top();
        let of_step = |step: usize| {
            let value = top * (step as f64 + 0.5) / STEPS as f64;
            rule.colour(value, if rule.is_met(value) { Verdict::Met } else { Verdict::Broken }, top)
        };
        page.colours(frame, STEPS, of_step);
        let ticks: Vec<(f64, String)> = self.ticks.iter().map(|tick| (tick / top, words(*tick))).collect();
        page.axis(frame, Axis::Below, &ticks, false);
        page.text(unit, (right.0 + 8.0, right.1), LETTERS, Side::Left, INK);
        let (x, _) = frame.at(rule.threshold / top, 0.0);
        page.line(&[(x, frame.top - 5.0), (x, frame.bottom + 5.0)], 1.6, INK);
        let demand = if rule.is_most { "at most" } else { "at least" };
        let text = format!("rule: {demand} {} {unit}", words(rule.threshold));
        let half = 0.5 * LETTERS.width(&text);
        page.text(&text, (x.max(frame.left + half), frame.top - 13.0), LETTERS, Side::Center, INK);
        let mut x = frame.left;
        for (verdict, name) in
            [(Verdict::Met, "met"), (Verdict::Close, "close: by less than it may be off"), (Verdict::Broken, "broken")]
        {
            let ink = rule.ink(verdict, top);
            let sample = |at: f64| (at * SAMPLES as f64) as usize;
            let swatch = Image::painted(SWATCH, |x, y| ink.at(sample(x), sample(y)));
            page.image((x.round(), y - 7.0), swatch);
            page.text(name, (x.round() + 34.0, y), LETTERS, Side::Left, INK);
            x += 60.0 + LETTERS.width(name);
        }
    }

    /// Adds the colours to the provenance of a picture.
    pub fn stated(&self, about: &Provenance) -> Provenance {
        let (top, name) = (self.top(), self.scale.name_on_paper());
        let name = if self.rule.is_some() { "Oranges, Blues" } else { name };
        let least = self.ticks.first().copied().unwrap_or(0.0);
        let about = about.clone().with("colours", name).with("colours_from", least);
        let about = about.with("colours_to", top);
        match self.beyond {
            Some(_) => about.with("colours_percentile", PERCENTILE),
            None => about,
        }
    }
}

impl RuleColumns {
    fn is_met(&self, value: f64) -> bool {
        if self.is_most { value <= self.threshold } else { value >= self.threshold }
    }

    /// Returns the ink of values halfway between the threshold and the farthest with this verdict.
    fn ink(&self, verdict: Verdict, top: f64) -> Ink {
        let far = if (verdict == Verdict::Met) == self.is_most { 0.0 } else { top };
        Ink { colour: self.colour(0.5 * (far + self.threshold), verdict, top), verdict: Some(verdict) }
    }

    fn colour(&self, value: f64, verdict: Verdict, top: f64) -> Rgb {
        let whole = if value < self.threshold { self.threshold } else { top - self.threshold };
        let share = ((value - self.threshold).abs() / whole.max(f64::MIN_POSITIVE)) as f32;
        match verdict {
            Verdict::Broken => between(&BROKEN, share),
            Verdict::Close => CLOSE,
            Verdict::Met => between(&MET, share),
        }
    }
}

/// Returns the upper end of the class that the percentile lies in, as a share of the largest.
fn percentile(counts: &[u64]) -> f64 {
    let all: u64 = counts.iter().sum();
    let mut below = 0;
    let found = counts.iter().position(|count| {
        below += count;
        all > 0 && below * 100 >= all * PERCENTILE
    });
    found.map_or(1.0, |class| (class + 1) as f64 / counts.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(value: f32, verdict: Verdict) -> MapRow {
        MapRow { numbers: vec![value, verdict.number()], ..MapRow::default() }
    }

    /// The scale of 100 changes, 98 between 1 and 10, one of 9 and one of 500, ends near 10;
    /// without values it ends at the largest.
    #[test]
    fn one_outlier_does_not_end_the_scale() {
        let mut counts = vec![0; CLASSES];
        let class = |value: f64| ((value / 500.0 * CLASSES as f64) as usize).min(CLASSES - 1);
        (0..98).for_each(|i| counts[class(1.0 + f64::from(i % 10))] += 1);
        [9.0, 500.0].iter().for_each(|value| counts[class(*value)] += 1);
        assert!((10.0..10.5).contains(&(500.0 * percentile(&counts))), "{}", percentile(&counts));
        assert_eq!(percentile(&[0; 4]), 1.0);
    }

    /// A scale from 0 to 200 with a value of 230 has four classes, the last up to 230; that of
    /// changes from -20 to 20 with one of -31 begins at -31; a rule has a class for each verdict.
    #[test]
    fn classes_hold_all_values() {
        let palette = Palette { ticks: vec![0.0, 100.0, 200.0], beyond: Some(230.0), ..Palette::from_zero(200.0) };
        let ends = |palette: &Palette| -> Vec<_> { palette.swatches().iter().map(|one| (one.from, one.to)).collect() };
        let some = [0.0, 50.0, 100.0, 150.0, 230.0].array_windows().map(|[a, b]| (*a, Some(*b))).collect::<Vec<_>>();
        assert_eq!(ends(&palette), some);
        assert_eq!(palette.swatches()[3].label, "more than 150");
        let (scale, ticks) = (ColourScale::AroundZero, vec![-20.0, 0.0, 20.0]);
        let changes = Palette { scale, ticks, beyond: Some(31.0), ..Palette::from_zero(20.0) };
        assert_eq!(ends(&changes).first().copied(), Some((-31.0, Some(-10.0))));
        let rule = Some(RuleColumns { verdict: 1, threshold: 120.0, is_most: false });
        let judged = Palette { rule, ..Palette::from_zero(500.0) };
        assert_eq!(ends(&judged), [(0.0, None), (0.5, None), (1.0, None)]);
        assert_eq!(judged.swatches()[2].label, "met");
    }

    /// With at least 120 minutes demanded, 119 and 0 are orange with stripes, 121 and 500 blue
    /// without, a close value has dots, and the colours are paler next to the threshold; a place
    /// without a value is not drawn.
    #[test]
    fn broken_rules_have_a_colour_and_stripes() {
        let rule = Some(RuleColumns { verdict: 1, threshold: 120.0, is_most: false });
        let palette = Palette { rule, ..Palette::from_zero(500.0) };
        let ink = |value, verdict| palette.ink(&row(value, verdict)).expect("an ink");
        let [nearly, broken] = [119.0, 0.0].map(|value| ink(value, Verdict::Broken));
        let [just, met] = [121.0, 500.0].map(|value| ink(value, Verdict::Met));
        assert!(broken.colour[0] > broken.colour[2] && met.colour[2] > met.colour[0]);
        assert!(nearly.colour[1] > broken.colour[1] && just.colour[1] > met.colour[1]);
        let marked = |ink: Ink| (0..56 * 56).filter(|at| ink.at(at % 56, at / 56) != ink.colour).count();
        assert!(marked(broken) > 300 && marked(ink(120.0, Verdict::Close)) > 300 && marked(met) == 0);
        assert_eq!(palette.ink(&row(f32::NAN, Verdict::Met)), None);
    }
}
