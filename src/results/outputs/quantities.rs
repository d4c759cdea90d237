//! Numbers that places have in results. In: arrays of values, such as the components of a replay.
//! Out: the content of each column of a table, a map or a picture: an array as it is, or a number
//! computed from two arrays.
//!
//! Each kind of query has its own list of [`Quantity`]; tables, maps and pictures do not depend on
//! components.

use crate::outputs::pictures::colours::label;
use heliotile_core::replay::components::{Component, ComponentList, LightMeasure};
use heliotile_core::replay::values::TileValues;
use heliotile_core::weather::time::calendar::Date;

/// Number that each place has for each bin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name of its column without the ending that states the unit: `sun_direct`, `change_total`.
    pub name: String,
    /// Description in words, for pictures: `sun, direct`.
    pub words: String,
    /// Source of its values.
    pub source: ValueSource,
    /// Measure of its values.
    pub measure: Measure,
}

/// Measure of a quantity: its unit, and its form in tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Light, in the unit for the bins.
    Light(LightMeasure),
    /// Percentage.
    Percent,
    /// Duration in minutes.
    Minutes,
    /// Minutes after midnight; tables show a reading of the clock.
    Clock,
    /// Days since 1970-01-01; tables show a date, with its year if results name years.
    Date { names_year: bool },
    /// Temperature, degrees Celsius.
    Celsius,
    /// Duration in hours.
    Hours,
    /// Number whose unit another value states.
    Number,
    /// Result of a rule: a [`Verdict`] as a number; tables show its name.
    Verdict,
}

/// Result of a rule at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Rule is broken.
    Broken,
    /// Distance of the value from the threshold is within its uncertainty.
    Close,
    /// Rule is met.
    Met,
}

impl Verdict {
    /// Name of the quantity with the verdict of a rule; `THRESHOLDS` are those of the least and the
    /// most that meet it.
    pub const COLUMN: &str = "verdict";
    pub const THRESHOLDS: [&str; 2] = ["at_least", "at_most"];

    /// All verdicts with their names, and the numbers that stand for them in maps.
    pub const ALL: [(Verdict, &'static str, f32); 3] =
        [(Verdict::Broken, "broken", 0.0), (Verdict::Close, "close", 0.5), (Verdict::Met, "met", 1.0)];

    /// Returns the number that stands for the verdict.
    pub fn number(self) -> f32 {
        Verdict::ALL.iter().find(|(verdict, ..)| *verdict == self).map_or(f32::NAN, |(.., number)| *number)
    }

    /// Returns the verdict that a number stands for.
    pub fn of(number: f32) -> Option<Self> {
        Verdict::ALL.iter().find(|(.., other)| *other == number).map(|(verdict, ..)| *verdict)
    }

    /// Returns the name of a number's verdict; empty if there is none.
    fn name_of(number: f32) -> &'static str {
        Verdict::ALL.iter().find(|(.., other)| *other == number).map_or("", |(_, name, _)| name)
    }
}

impl Measure {
    /// Returns the text that tables show for a value of this measure; `None` if tables show the
    /// number. The text is empty if there is no value.
    pub fn text(self, value: f32) -> Option<String> {
        match self {
            Measure::Clock if value.is_finite() => {
                let minutes = f64::from(value).round() as i64;
                Some(format!("{:02}:{:02}", minutes.div_euclid(60), minutes.rem_euclid(60)))
            }
            Measure::Date { names_year } if value.is_finite() => {
                Some(Date::of_day_number(value as i32).map_or_else(String::new, |date| date.day_label(names_year)))
            }
            Measure::Clock | Measure::Date { .. } => Some(String::new()),
            Measure::Verdict => Some(Verdict::name_of(value).to_owned()),
            _ => None,
        }
    }
}

/// Source of a quantity's values: arrays of [`PlaceValues`] by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueSource {
    /// Array as it is.
    Array(usize),
    /// Change from an array to another.
    Change { kind: ChangeKind, from: usize, to: usize },
}

/// Form of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    /// New number minus the old one.
    Difference,
    /// Difference in percent of the old number.
    Percent,
}

/// Ending of the names of columns in percent.
const PERCENT: &str = "_percent";

/// Prefixes of the names of change columns, before the name of the component.
const BEFORE: &str = "before";
const AFTER: &str = "after";
const CHANGE: &str = "change";

/// Unit that the names of light columns end with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightEnding {
    /// Name without a unit.
    Bare,
    /// Unit of means.
    Means,
    /// Unit of sums.
    Sums,
}

impl LightEnding {
    /// Returns the ending for a measure of light.
    pub fn of(self, measure: LightMeasure) -> &'static str {
        match (self, measure) {
            (LightEnding::Bare, _) => "",
            (LightEnding::Sums, measure) => measure.sum_suffix(),
            (LightEnding::Means, LightMeasure::Irradiance) => "_w_m2",
            (LightEnding::Means, LightMeasure::PhotonFlux) => "_umol_m2_s",
            (LightEnding::Means, LightMeasure::Illuminance) => "_lx",
        }
    }
}

impl Quantity {
    /// Returns the name of the column; `of_light` selects the ending of a light column.
    pub fn with_ending(&self, of_light: LightEnding) -> String {
        let ending = match self.measure {
            Measure::Light(measure) => of_light.of(measure),
            Measure::Percent => PERCENT,
            _ => "",
        };
        format!("{}{ending}", self.name)
    }

    /// Returns the quantities of a replay's components; the arrays must come in the same order.
    pub fn of_components(components: &ComponentList) -> Vec<Quantity> {
        let quantity = |(number, component): (usize, &Component)| Quantity {
            name: components.name_of(*component).to_owned(),
            words: words_of(components, *component),
            source: ValueSource::Array(number),
            measure: Measure::Light(component.measure()),
        };
        components.as_slice().iter().enumerate().map(quantity).collect()
    }

    /// Returns before, after, change and change in percent of each component. The arrays of all
    /// components before must come first, then those after.
    pub fn of_changes(components: &ComponentList) -> Vec<Quantity> {
        let count = components.as_slice().len();
        let of_component = |(from, component): (usize, &Component)| {
            let to = count + from;
            let words = words_of(components, *component);
            let named = |side: &str, words: String, source: ValueSource| {
                let name = format!("{side}_{}", components.name_of(*component));
                let measure = if source.is_percent() { Measure::Percent } else { Measure::Light(component.measure()) };
                Quantity { name, words, source, measure }
            };
            let change = |kind| ValueSource::Change { kind, from, to };
            [
                named(BEFORE, format!("{words} before"), ValueSource::Array(from)),
                named(AFTER, format!("{words} after"), ValueSource::Array(to)),
                named(CHANGE, format!("change of {words}"), change(ChangeKind::Difference)),
                named(CHANGE, format!("change of {words}"), change(ChangeKind::Percent)),
            ]
        };
        components.as_slice().iter().enumerate().flat_map(of_component).collect()
    }
}

/// Returns `words` with a capital first letter.
pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect()
}

/// Returns the words for a component.
fn words_of(components: &ComponentList, component: Component) -> String {
    match Component::OWN.contains(&component) {
        true => components.name_of(component).replace('_', " "),
        false => label(component),
    }
}

impl ValueSource {
    /// Returns the value, computed from arrays; `None` if there is none.
    pub fn of(self, array: impl Fn(usize) -> f64) -> Option<f64> {
        match self {
            ValueSource::Array(number) => Some(array(number)),
            ValueSource::Change { kind, from, to } => kind.of(array(from), array(to)),
        }
    }

    /// Returns true if the value is a percentage.
    pub fn is_percent(self) -> bool {
        matches!(self, ValueSource::Change { kind: ChangeKind::Percent, .. })
    }
}

impl ChangeKind {
    /// Returns the change from one number to another; `None` for percent of 0.
    pub fn of(self, from: f64, to: f64) -> Option<f64> {
        match self {
            ChangeKind::Difference => Some(to - from),
            ChangeKind::Percent => (from != 0.0).then(|| 100.0 * (to - from) / from),
        }
    }
}

/// Values of some places.
#[derive(Clone, Debug)]
pub struct PlaceValues<'v> {
    places: usize,
    bins: usize,
    /// `[array][place][bin]`, row-major.
    arrays: Vec<&'v [f32]>,
}

impl<'v> PlaceValues<'v> {
    /// Returns the components of one archive, or of one and then of another. All must have as many
    /// receivers and bins as the first.
    pub fn new(sides: &[&'v TileValues], components: &[Component]) -> Self {
        let (places, bins) = sides.first().map_or((0, 0), |first| (first.receivers(), first.bins()));
        let of_side = |side: &&'v TileValues| {
            let side = *side;
            components.iter().map(move |component| side.component(*component))
        };
        PlaceValues { places, bins, arrays: sides.iter().flat_map(of_side).collect() }
    }

    /// Returns the values of `places` places and `bins` bins from arrays `[place][bin]`,
    /// row-major.
    pub fn of_arrays(places: usize, bins: usize, arrays: &'v [Vec<f32>]) -> Self {
        PlaceValues { places, bins, arrays: arrays.iter().map(Vec::as_slice).collect() }
    }

    /// Returns the number of places, the second axis.
    pub fn places(&self) -> usize {
        self.places
    }

    /// Returns the number of bins, the third axis.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Returns the array `number`, `[place][bin]`.
    pub fn array(&self, number: usize) -> &'v [f32] {
        self.arrays.get(number).copied().unwrap_or_default()
    }

    /// Returns the values `[bin]` of an array at a place.
    pub fn row(&self, number: usize, place: usize) -> &'v [f32] {
        self.array(number).get(place * self.bins..(place + 1) * self.bins).unwrap_or_default()
    }

    /// Returns the value of a source at a place for a bin; NaN if there is none.
    pub fn value(&self, source: ValueSource, place: usize, bin: usize) -> f32 {
        if let ValueSource::Array(number) = source {
            return self.row(number, place).get(bin).copied().unwrap_or_default();
        }
        let array = |number: usize| self.row(number, place).get(bin).copied().map_or(f64::NAN, f64::from);
        source.of(array).map_or(f32::NAN, |value| value as f32)
    }

    /// Returns the value of a source at a place, computed from the sums over all bins.
    pub fn value_of_sums(&self, source: ValueSource, place: usize) -> f64 {
        let sum = |number: usize| self.row(number, place).iter().map(|value| f64::from(*value)).sum::<f64>();
        source.of(sum).unwrap_or(f64::NAN)
    }
}
