//! Spells of a year by day and time of day. In: spells of some series on days. Out: SVG: days from
//! left to right, hours upwards, a colour for each series.

use super::axes::{Axis, Frame, LETTERS};
use super::drawing::{Drawing, INK, Rgb, Side, WHITE};
use super::plot::COLOURS;
use heliotile_core::weather::time::calendar::Date;
use heliotile_sunlight::Spell;

/// Picture of spells.
pub struct Calendar {
    pub title: String,
    /// Line below the title.
    pub called: String,
    /// Names in the order of colours; series beyond the last colour share one.
    pub series: Vec<String>,
    /// Days from left to right.
    pub days: Vec<CalendarDay>,
}

/// Day of a picture of spells.
pub struct CalendarDay {
    pub date: Date,
    /// Spells with the sun up, by the clock.
    pub up: Vec<Spell>,
    /// Spells of the series. The first series lies on top.
    pub spells: Vec<CalendarSpell>,
}

/// Spell of a series.
pub struct CalendarSpell {
    /// Index into `series`.
    pub series: usize,
    /// Spell by the clock.
    pub spell: Spell,
}

/// Size of the page, points.
const SIZE: (f64, f64) = (900.0, 550.0);
const FRAME: Frame = Frame { left: 72.0, right: 880.0, top: 70.0, bottom: 460.0 };
/// Position at which the legend begins.
const LEGEND: (f64, f64) = (72.0, 506.0);
/// Colour of the night; `OTHERS` is the colour of series beyond the last colour.
const NIGHT: Rgb = [225, 230, 234];
const OTHERS: Rgb = [128, 128, 128];
/// Name in the legend of series beyond the last colour.
const OTHERS_NAME: &str = "others";
/// Name in the legend of a series without a name.
const UNKNOWN: &str = "unknown";

const DAY_MIN: f64 = 1440.0;
const HOUR_MIN: f64 = 60.0;

impl Calendar {
    /// Returns the picture.
    pub fn drawing(&self) -> Drawing {
        let x = |day: usize| day as f64 / self.days.len().max(1) as f64;
        // The axis has whole hours from the first sunrise to the last sunset.
        let up = || self.days.iter().flat_map(|day| &day.up);
        let first = up().map(|spell| spell.start_min).fold(DAY_MIN, f64::min);
        let last = up().map(|spell| spell.end_min).fold(0.0, f64::max);
        let low = (first / HOUR_MIN).floor().clamp(0.0, 23.0);
        let high = (last / HOUR_MIN).ceil().clamp(low + 1.0, 25.0);
        let y = |minutes: f64| ((minutes / HOUR_MIN - low) / (high - low)).clamp(0.0, 1.0);
        let named = self.series.iter().take(COLOURS.len()).map(|name| if name.is_empty() { UNKNOWN } else { name });
        let others = (self.series.len() > COLOURS.len()).then_some(OTHERS_NAME);
        let names = named.chain(others).enumerate().map(|(number, name)| (name, colour_of(number)));
        let names: Vec<(&str, Rgb)> = names.collect();
        let more = Drawing::new(SIZE.0, SIZE.1).swatches(LEGEND, &names);
        let mut page = Drawing::new(SIZE.0, SIZE.1 + more);
        page.heading(&self.title, &self.called);
        let bar = |page: &mut Drawing, day: usize, spell: &Spell, colour: Rgb| {
            let (left, top) = FRAME.at(x(day), y(spell.end_min));
            let (right, bottom) = FRAME.at(x(day + 1), y(spell.start_min));
            page.cell([(left, top), (right, bottom)], colour);
        };
        page.rectangle([(FRAME.left, FRAME.top), (FRAME.right, FRAME.bottom)], NIGHT);
        for (number, day) in self.days.iter().enumerate() {
            day.up.iter().for_each(|spell| bar(&mut page, number, spell, WHITE));
        }
        let hours = (low as usize..=high as usize).step_by(2);
        let hours: Vec<(f64, String)> = hours.map(|hour| (y(hour as f64 * HOUR_MIN), format!("{hour}:00"))).collect();
        page.axis(&FRAME, Axis::Left, &hours, true);
        page.axis(&FRAME, Axis::Below, &self.marks(), true);
        let mut spells: Vec<(usize, &CalendarSpell)> = Vec::new();
        for (number, day) in self.days.iter().enumerate() {
            spells.extend(day.spells.iter().map(|spell| (number, spell)));
        }
        spells.sort_by_key(|(_, one)| std::cmp::Reverse(one.series));
        spells.iter().for_each(|(day, one)| bar(&mut page, *day, &one.spell, colour_of(one.series)));
        page.swatches(LEGEND, &names);
        if names.is_empty() {
            page.text("no sun in mirrors", LEGEND, LETTERS, Side::Left, INK);
        }
        page
    }

    /// Returns the marks of the time axis: first days of months, or all days if there are few.
    fn marks(&self) -> Vec<(f64, String)> {
        let count = self.days.len().max(1) as f64;
        let has_months = self.days.iter().filter(|day| day.date.day == 1).count() > 1;
        let is_marked = |day: &CalendarDay| !has_months || day.date.day == 1;
        let marked = self.days.iter().enumerate().filter(|(_, day)| is_marked(day));
        let name = |date: Date| format!("{:02}-{:02}", date.month, date.day);
        marked.map(|(number, day)| (number as f64 / count, name(day.date))).collect()
    }
}

fn colour_of(series: usize) -> Rgb {
    COLOURS.get(series).copied().unwrap_or(OTHERS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two days have the sun up from 6 to 18 and a spell of one of two series from 12 to 13 each.
    /// The picture has the night, two white bars, two coloured bars and two in the legend; a
    /// coloured bar is a twelfth of the frame high and half as wide as it.
    #[test]
    fn a_spell_of_an_hour_is_a_bar_of_its_length() {
        let spell = |start_min: f64, end_min: f64| Spell { start_min, end_min };
        let day = |number: u32| CalendarDay {
            date: Date { year: 2017, month: 3, day: number },
            up: vec![spell(360.0, 1080.0)],
            spells: vec![CalendarSpell { series: number as usize - 20, spell: spell(720.0, 780.0) }],
        };
        let calendar = Calendar {
            title: "<i>".into(),
            called: "x".into(),
            series: vec!["a".into(), String::new()],
            days: vec![day(20), day(21)],
        };
        let svg = calendar.drawing().svg();
        let rects: Vec<&str> = svg.lines().filter(|line| line.starts_with("<rect")).collect();
        assert_eq!(rects.len(), 1 + 1 + 2 + 2 + 2);
        assert!(rects[4].contains("height=\"32.5\"") && rects[4].contains("width=\"404\""), "{}", rects[4]);
        assert!(svg.contains(">unknown</text>") && svg.contains(">03-20</text>") && !svg.contains("<i>"));
    }
}
