//! Layout of a table of results: a label, a receiver or group, and the requested quantities, with
//! their units.

use crate::outputs::quantities::{ChangeKind, LightEnding, Measure, Quantity, ValueSource, capital};
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::column::{Column, Digits, Kind, TableColumns};
use heliotile_core::named::NamedValues;
use heliotile_core::replay::components::{Component, ComponentList, LightMeasure};

/// Unit of temperatures.
pub const CELSIUS: &str = "degC";

/// Kind of the bins of a table, which also decides the unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinKind {
    /// Labels `condition`, means in W/m2.
    Conditions,
    /// Labels `time`, means in W/m2.
    Times,
    /// Labels `time` (a period), sums in kWh/m2.
    Sums,
    /// Labels `date`, a day or a period, for values that are no light.
    Dates,
    /// Labels `rule`, for results of rules.
    Rules,
}

/// Subject of the rows of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum By {
    /// Receiver: one row for each.
    #[default]
    Receiver,
    /// Surface: one row for each, with the mean of its receivers, weighted by their areas, or plain
    /// if none has an area.
    Surface,
    /// Window: one row for each surface that is a window, as for surfaces.
    Window,
    /// Object: one row for each, as for surfaces. Objects are city objects, and zones and shades of
    /// a building model.
    Object,
    /// Building: one row for each. A building is what objects of a city model are parts of.
    Building,
    /// Kind of surface: one row for each of roof, wall, window, ground, floor, shade.
    Kind,
    /// Pane: one row for each surface that reflects like a mirror. Panes are no groups of
    /// receivers, and no request can name them.
    Pane,
}

impl By {
    /// Returns the name of the subject's column, in results and in tables of receivers.
    pub fn name(self) -> &'static str {
        match self {
            By::Receiver => "receiver",
            By::Surface => "surface",
            By::Window => "window",
            By::Object => "object",
            By::Building => "building",
            By::Kind => "kind",
            By::Pane => "pane",
        }
    }
}

/// Property of a group of receivers that has a column besides the quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fact {
    /// Area of its receivers.
    Area,
    /// Tilt of its mean normal: 0 up, 90 to the side.
    Tilt,
    /// Azimuth of its mean normal, clockwise from true north.
    Azimuth,
    /// Sum over the group: the main quantity x area.
    Sum,
    /// Coordinate of a receiver: 0 x, 1 y, 2 z.
    Coordinate(usize),
    /// Direction of a receiver: 0 tilt, 1 azimuth, clockwise from true north.
    Direction(usize),
    /// Area that a receiver stands for; none if it is a point.
    Extent,
}

impl Fact {
    /// Facts of receivers, with which a table of results can be read as a table of receivers.
    pub const OF_RECEIVERS: [Fact; 6] = [
        Fact::Coordinate(0),
        Fact::Coordinate(1),
        Fact::Coordinate(2),
        Fact::Direction(0),
        Fact::Direction(1),
        Fact::Extent,
    ];

    /// Returns true if the column keeps all digits.
    fn is_exact(self) -> bool {
        Fact::OF_RECEIVERS.contains(&self)
    }
}

/// Columns of a table of results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Kind of the bins in the first column.
    pub bins: BinKind,
    /// Subject of the second column.
    pub by: By,
    /// Quantities of the value columns, at least one.
    pub quantities: Vec<Quantity>,
    /// Index of the main quantity, which gives colours and sums.
    pub main: usize,
    /// True if the main quantity times an area is an energy with a column of its own, as it is for
    /// the total.
    pub has_energy: bool,
    /// Properties of groups, in columns after the quantities.
    pub facts: Vec<Fact>,
}

impl Layout {
    /// Returns the layout of the components of a replay.
    pub fn of_components(bins: BinKind, by: By, components: &ComponentList) -> Self {
        Layout::new(bins, by, components, Quantity::of_components(components))
    }

    /// Returns the layout of the components of a replay before and after, and their changes.
    pub fn of_changes(bins: BinKind, by: By, components: &ComponentList) -> Self {
        Layout::new(bins, by, components, Quantity::of_changes(components))
    }

    /// Returns the layout of quantities that are no light; the first is the main one.
    pub fn of_quantities(bins: BinKind, by: By, quantities: Vec<Quantity>) -> Self {
        Layout { bins, by, quantities, main: 0, has_energy: false, facts: Vec::new() }
    }

    /// Returns the layout of quantities that follow from components, equally many from each.
    fn new(bins: BinKind, by: By, components: &ComponentList, quantities: Vec<Quantity>) -> Self {
        let of_each = quantities.len() / components.as_slice().len().max(1);
        let first = of_each * components.main_place();
        let here = quantities.iter().skip(first).take(of_each);
        let change = here.clone().position(|one| matches!(one.source, ValueSource::Change { .. }));
        let main = first + change.unwrap_or_default();
        Layout { bins, by, quantities, main, has_energy: components.main() == Component::Total, facts: Vec::new() }
    }

    /// Returns the name of the first column.
    pub fn label(&self) -> &'static str {
        match self.bins {
            BinKind::Conditions => "condition",
            BinKind::Times | BinKind::Sums => "time",
            BinKind::Dates => "date",
            BinKind::Rules => "rule",
        }
    }

    /// Returns the name of the second column.
    pub fn place(&self) -> &'static str {
        self.by.name()
    }

    /// Returns the columns of a table whose rows have these bins.
    pub fn columns(&self, bins: &BinLabels) -> TableColumns {
        let label = Column::of_bins(self.label(), Kind::Category, bins);
        let place = Column::of_places(self.place(), Kind::Category);
        let of_quantity = |quantity: &Quantity| match quantity.measure {
            Measure::Clock | Measure::Date { .. } | Measure::Verdict => {
                Column::text(quantity.with_ending(LightEnding::Bare))
            }
            _ => {
                let name = quantity.with_ending(self.ending());
                Column::float(name, self.digits(quantity)).with_unit(self.unit_of(quantity))
            }
        };
        let quantities = self.quantities.iter().map(of_quantity);
        let facts = self.facts.iter().map(|fact| {
            let (name, unit) = self.fact(*fact);
            match fact.is_exact() {
                true => Column::number_as(name, Digits::Fewest).with_unit(unit),
                false => Column::float(name, Digits::Six).with_unit(unit),
            }
        });
        TableColumns::new([label, place].into_iter().chain(quantities).chain(facts).collect())
    }

    /// Returns the digits of irradiance in text formats.
    pub fn digits_of_irradiance(&self) -> Digits {
        match self.bins {
            BinKind::Sums => Digits::Six,
            BinKind::Conditions | BinKind::Times | BinKind::Dates | BinKind::Rules => Digits::Thousandths,
        }
    }

    fn digits(&self, quantity: &Quantity) -> Digits {
        match (quantity.source, quantity.measure) {
            (_, Measure::Minutes | Measure::Number | Measure::Celsius | Measure::Hours) => Digits::Decimals(2),
            (ValueSource::Array(_), _) => self.digits_of_irradiance(),
            (ValueSource::Change { kind: ChangeKind::Difference, .. }, _) => Digits::Fewest,
            (ValueSource::Change { kind: ChangeKind::Percent, .. }, _) => Digits::Thousandths,
        }
    }

    /// Returns the kind of ending of the names of light columns.
    fn ending(&self) -> LightEnding {
        if self.bins == BinKind::Sums { LightEnding::Sums } else { LightEnding::Bare }
    }

    /// Returns the names of the value columns.
    pub fn values(&self) -> Vec<String> {
        let quantities = self.quantities.iter().map(|quantity| quantity.with_ending(self.ending()));
        quantities.chain(self.facts.iter().map(|fact| self.fact(*fact).0)).collect()
    }

    /// Returns the names of all columns.
    pub fn names(&self) -> Vec<String> {
        [self.label().to_string(), self.place().to_string()].into_iter().chain(self.values()).collect()
    }

    /// Returns the name and unit of a fact.
    fn fact(&self, fact: Fact) -> (String, &'static str) {
        match fact {
            Fact::Coordinate(axis) => (["x", "y", "z"].get(axis).copied().unwrap_or_default().into(), "m"),
            Fact::Area | Fact::Extent => ("area_m2".into(), "m2"),
            Fact::Tilt | Fact::Direction(0) => ("tilt_deg".into(), "deg"),
            Fact::Azimuth | Fact::Direction(_) => ("azimuth_deg".into(), "deg"),
            Fact::Sum => self.energy(),
        }
    }

    /// Returns the name and unit of the main quantity x area.
    pub fn energy(&self) -> (String, &'static str) {
        let name = &self.main_quantity().name;
        match self.bins {
            BinKind::Sums => (format!("{name}_kwh"), "kWh"),
            BinKind::Conditions | BinKind::Times | BinKind::Dates | BinKind::Rules => (format!("{name}_w"), "W"),
        }
    }

    /// Returns the units of the value columns, in the order of [`Layout::values`].
    pub fn units(&self) -> Vec<&'static str> {
        let quantities = self.quantities.iter().map(|quantity| self.unit_of(quantity));
        quantities.chain(self.facts.iter().map(|fact| self.fact(*fact).1)).collect()
    }

    /// Returns the main quantity.
    pub fn main_quantity(&self) -> &Quantity {
        &self.quantities[self.main]
    }

    /// Returns the noun for means or sums of light.
    pub fn light_noun(&self) -> &'static str {
        if self.bins == BinKind::Sums { "irradiation" } else { "irradiance" }
    }

    /// Returns the main quantity in words, for titles of pictures.
    pub fn title(&self) -> String {
        let main = self.main_quantity();
        match main.measure {
            Measure::Light(LightMeasure::Irradiance) if main.words.ends_with("total") => {
                capital(&format!("{} {}", main.words, self.light_noun()))
            }
            Measure::Light(LightMeasure::Irradiance) => format!("{}: {}", capital(self.light_noun()), main.words),
            _ => capital(&main.words),
        }
    }

    /// Returns the unit of a quantity.
    pub fn unit_of(&self, quantity: &Quantity) -> &'static str {
        match quantity.measure {
            Measure::Light(measure) => self.unit_of_light(measure),
            Measure::Percent => "%",
            Measure::Minutes | Measure::Clock => "min",
            Measure::Celsius => CELSIUS,
            Measure::Hours => "h",
            Measure::Date { .. } => "d",
            Measure::Number | Measure::Verdict => "1",
        }
    }

    /// Returns the unit of irradiance.
    pub fn unit(&self) -> &'static str {
        self.unit_of_light(LightMeasure::Irradiance)
    }

    fn unit_of_light(&self, measure: LightMeasure) -> &'static str {
        match (measure, self.bins == BinKind::Sums) {
            (LightMeasure::Irradiance, false) => "W/m2",
            (LightMeasure::Irradiance, true) => "kWh/m2",
            (LightMeasure::PhotonFlux, false) => "umol/(m2 s)",
            (LightMeasure::PhotonFlux, true) => "mol/m2",
            (LightMeasure::Illuminance, false) => "lx",
            (LightMeasure::Illuminance, true) => "klx h",
        }
    }
}

impl NamedValues for By {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("receiver", "One row for each receiver", By::Receiver),
        (
            "surface",
            "One row for each surface: the mean of its receivers, weighted by their areas, or plain if none has an area",
            By::Surface,
        ),
        ("window", "One row for each surface that is a window", By::Window),
        ("object", "One row for each object of the model: city objects, zones and shades", By::Object),
        ("building", "One row for each building, with all of its parts", By::Building),
        ("kind", "One row for each kind of surface: roof, wall, window, ground, floor, shade", By::Kind),
    ];
}

heliotile_core::serde_by_name!(By);

heliotile_core::parse_by_name!(By);

/// Subject of the columns of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Irradiance of places.
    Irradiance,
    /// Irradiance before and after, and its change.
    Change,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A query with all columns has the 9 of the contract; two columns of sums come in the
    /// requested order, with their unit's ending.
    #[test]
    fn columns_come_in_the_requested_order() {
        let all = Layout::of_components(BinKind::Conditions, By::Receiver, &ComponentList::all());
        let expected =
            "condition,receiver,sun_direct,sky_direct,sun_reflected,sky_reflected,sun_mirrored,sky_mirrored,total";
        assert_eq!((all.names().join(",").as_str(), all.unit(), all.main), (expected, "W/m2", 6));
        let list = "total,sky_direct".parse().expect("names");
        let two = Layout::of_components(BinKind::Sums, By::Surface, &list);
        assert_eq!(two.names(), ["time", "surface", "total_kwh_m2", "sky_direct_kwh_m2"]);
        assert_eq!((two.unit(), two.energy()), ("kWh/m2", ("total_kwh".to_owned(), "kWh")));
    }

    /// A comparison has four columns a component, in its unit or in percent; the change of the
    /// total is the main one.
    #[test]
    fn a_comparison_has_four_columns_a_component() {
        let layout = Layout::of_changes(BinKind::Sums, By::Receiver, &"sky_direct,total".parse().expect("names"));
        let of = |name: &str| ["before", "after", "change"].map(|side| format!("{side}_{name}_kwh_m2"));
        let names = [of("sky_direct").as_slice(), &["change_sky_direct_percent".into()], &of("total")].concat();
        assert_eq!(layout.values()[..7], names);
        assert_eq!((layout.values()[7].as_str(), layout.units()[7]), ("change_total_percent", "%"));
        assert_eq!((layout.main_quantity().words.as_str(), layout.has_energy), ("change of total", true));
        let hours = Layout::of_changes(BinKind::Times, By::Receiver, &"sun_direct".parse().expect("a name"));
        let expected = ["before_sun_direct", "after_sun_direct", "change_sun_direct", "change_sun_direct_percent"];
        assert_eq!((hours.values(), hours.main, hours.has_energy), (expected.map(String::from).to_vec(), 2, false));
    }
}
