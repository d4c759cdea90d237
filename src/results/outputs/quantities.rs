//! Numbers that places have in results. In: arrays of values, such as the components of a replay. Out: what each column of a table, a map or a
//! picture holds: an array as it is, or what follows from two of them.
//!
//! A further question to archives is a further list of [`Quantity`]; tables, maps and pictures know nothing of components.

use crate::outputs::pictures::colours::label;
use heliotile_core::replay::components::{Component, ComponentList, LightMeasure};
use heliotile_core::replay::values::TileValues;

/// A number that each place has for each label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name of its column, but for the ending that says the unit: `sun_direct`, `change_total`.
    pub name: String,
    /// The number in words, for pictures: `sun, direct`.
    pub words: String,
    /// Where its values come from.
    pub source: ValueSource,
    /// What they measure.
    pub measure: Measure,
}

/// What a quantity measures: its unit, and how tables show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Light, in its unit for the labels.
    Light(LightMeasure),
    /// A share.
    Percent,
    /// A time.
    Minutes,
    /// Minutes after midnight; tables show a reading of the clock.
    Clock,
    /// A temperature.
    Celsius,
    /// A time.
    Hours,
    /// A number whose unit another value says.
    Number,
    /// Whether a rule is met: a [`Verdict`] as a number; tables show its name.
    Verdict,
}

/// What a rule says of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The rule is broken.
    Broken,
    /// The value is as near to the threshold as it is uncertain.
    Close,
    /// The rule is met.
    Met,
}

impl Verdict {
    /// All of them with their names, and the numbers that stand for them in maps.
    const ALL: [(Verdict, &'static str, f32); 3] =
        [(Verdict::Broken, "broken", 0.0), (Verdict::Close, "close", 0.5), (Verdict::Met, "met", 1.0)];

    /// As a number.
    pub fn number(self) -> f32 {
        Verdict::ALL.iter().find(|(verdict, ..)| *verdict == self).map_or(f32::NAN, |(.., number)| *number)
    }

    /// The name of a number's verdict; empty where there is none.
    fn name_of(number: f32) -> &'static str {
        Verdict::ALL.iter().find(|(.., other)| *other == number).map_or("", |(_, name, _)| name)
    }
}

impl Measure {
    /// What tables show of a value, where that is a text; an empty one where there is no value.
    pub fn text(self, value: f32) -> Option<String> {
        match self {
            Measure::Clock if value.is_finite() => {
                let minutes = f64::from(value).round() as i64;
                Some(format!("{:02}:{:02}", minutes.div_euclid(60), minutes.rem_euclid(60)))
            }
            Measure::Clock => Some(String::new()),
            Measure::Verdict => Some(Verdict::name_of(value).to_owned()),
            _ => None,
        }
    }
}

/// Where the values of a quantity come from: arrays of [`PlaceValues`] by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueSource {
    /// An array as it is.
    Array(usize),
    /// How an array differs from another.
    Change { kind: ChangeKind, from: usize, to: usize },
}

/// How a number changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    /// The new number less the old one.
    Difference,
    /// The difference in percent of the old number.
    Percent,
}

/// Ending of the columns of shares in percent.
const PERCENT: &str = "_percent";

/// What the names of change columns begin with, before the name of the component.
const BEFORE: &str = "before";
const AFTER: &str = "after";
const CHANGE: &str = "change";

/// Which unit the names of light end with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightEnding {
    /// None.
    Bare,
    /// That of means.
    Means,
    /// That of sums.
    Sums,
}

impl LightEnding {
    /// The ending.
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
    /// Name of its column, where that of light has an ending that says the unit.
    pub fn with_ending(&self, of_light: LightEnding) -> String {
        let ending = match self.measure {
            Measure::Light(measure) => of_light.of(measure),
            Measure::Percent => PERCENT,
            _ => "",
        };
        format!("{}{ending}", self.name)
    }

    /// Components of a replay, whose arrays come in the same order.
    pub fn of_components(components: &ComponentList) -> Vec<Quantity> {
        let quantity = |(number, component): (usize, &Component)| Quantity {
            name: components.name_of(*component).to_owned(),
            words: words_of(components, *component),
            source: ValueSource::Array(number),
            measure: Measure::Light(component.measure()),
        };
        components.as_slice().iter().enumerate().map(quantity).collect()
    }

    /// Before, after, change and change in percent of each component; first the arrays of all components before come, then those after.
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

/// A component in words.
fn words_of(components: &ComponentList, component: Component) -> String {
    match Component::OWN.contains(&component) {
        true => components.name_of(component).replace('_', " "),
        false => label(component),
    }
}

impl ValueSource {
    /// The value, from those of all arrays; none where there is none.
    pub fn of(self, array: impl Fn(usize) -> f64) -> Option<f64> {
        match self {
            ValueSource::Array(number) => Some(array(number)),
            ValueSource::Change { kind, from, to } => kind.of(array(from), array(to)),
        }
    }

    /// Whether the value is a share in percent.
    pub fn is_percent(self) -> bool {
        matches!(self, ValueSource::Change { kind: ChangeKind::Percent, .. })
    }
}

impl ChangeKind {
    /// The change from one number to another; there are no percent of 0.
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
    labels: usize,
    /// `[array][place][label]`, row-major.
    arrays: Vec<&'v [f32]>,
}

impl<'v> PlaceValues<'v> {
    /// The components of one archive, or first those of one and then those of another; all have as many receivers and labels as the first.
    pub fn of(sides: &[&'v TileValues], components: &[Component]) -> Self {
        let (places, labels) = sides.first().map_or((0, 0), |first| (first.receivers(), first.labels()));
        let of_side = |side: &&'v TileValues| {
            let side = *side;
            components.iter().map(move |component| side.component(*component))
        };
        PlaceValues { places, labels, arrays: sides.iter().flat_map(of_side).collect() }
    }

    /// Arrays of so many places and labels, `[place][label]`, row-major.
    pub fn of_arrays(places: usize, labels: usize, arrays: &'v [Vec<f32>]) -> Self {
        PlaceValues { places, labels, arrays: arrays.iter().map(Vec::as_slice).collect() }
    }

    /// Number of places, the second axis.
    pub fn places(&self) -> usize {
        self.places
    }

    /// Number of labels, the third axis.
    pub fn labels(&self) -> usize {
        self.labels
    }

    /// `[place][label]` of an array.
    pub fn array(&self, number: usize) -> &'v [f32] {
        self.arrays.get(number).copied().unwrap_or_default()
    }

    /// `[label]` of an array at a place.
    pub fn row(&self, number: usize, place: usize) -> &'v [f32] {
        self.array(number).get(place * self.labels..(place + 1) * self.labels).unwrap_or_default()
    }

    /// The value of a source at a place for a label; NaN where there is none.
    pub fn value(&self, source: ValueSource, place: usize, label: usize) -> f32 {
        if let ValueSource::Array(number) = source {
            return self.row(number, place).get(label).copied().unwrap_or_default();
        }
        let array = |number: usize| self.row(number, place).get(label).copied().map_or(f64::NAN, f64::from);
        source.of(array).map_or(f32::NAN, |value| value as f32)
    }

    /// The value of a source at a place, of the sums over all labels.
    pub fn value_of_sums(&self, source: ValueSource, place: usize) -> f64 {
        let sum = |number: usize| self.row(number, place).iter().map(|value| f64::from(*value)).sum::<f64>();
        source.of(sum).unwrap_or(f64::NAN)
    }
}
