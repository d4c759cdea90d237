//! The columns of a table: a label, a receiver, and the components that are asked for, with their unit.

use crate::outputs::tables::column::{Column, Digits, Kind, TableColumns};
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_core::named::NamedValues;
use heliotile_core::replay::components::{Component, ComponentList, SUM_SUFFIX};

/// What the labels of a table are, and with them the unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Labels {
    /// `condition`, means in W/m2.
    Conditions,
    /// `time`, means in W/m2.
    Times,
    /// `time` (a period), sums in kWh/m2.
    Sums,
}

/// What the rows of a table are about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum By {
    /// One row for each receiver
    #[default]
    Receiver,
    /// One for each surface: the mean of its receivers, weighted by their areas, or plain if none has an area
    Surface,
    /// One for each object, as for surfaces: city objects, zones and shades of a model of a building
    Object,
    /// One for each building: what the objects of a city model are parts of
    Building,
    /// One for each kind of surface: roof, wall, window, ground, floor, shade
    Kind,
}

impl By {
    /// Name of the column that says it, in results and in tables of receivers.
    pub fn name(self) -> &'static str {
        match self {
            By::Receiver => "receiver",
            By::Surface => "surface",
            By::Object => "object",
            By::Building => "building",
            By::Kind => "kind",
        }
    }
}

/// What a group of receivers is besides the irradiance that it gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fact {
    /// Area of its receivers.
    Area,
    /// Where it looks in the mean: 0 up, 90 to the side.
    Tilt,
    /// ... clockwise from true north.
    Azimuth,
    /// What all of it gets: total x area.
    Sum,
}

/// The columns of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// What the first column is.
    pub labels: Labels,
    /// What the second is.
    pub by: By,
    /// The value columns,
    pub components: ComponentList,
    /// Of groups; behind the components.
    pub facts: Vec<Fact>,
}

impl Layout {
    /// Name of the first column.
    pub fn label(&self) -> &'static str {
        match self.labels {
            Labels::Conditions => "condition",
            Labels::Times | Labels::Sums => "time",
        }
    }

    /// Name of the second column.
    pub fn place(&self) -> &'static str {
        self.by.name()
    }

    /// The columns of a table whose rows have these labels.
    pub fn columns(&self, labels: &RowLabels) -> TableColumns {
        let of_components = match self.labels {
            Labels::Sums => Digits::Six,
            Labels::Conditions | Labels::Times => Digits::Thousandths,
        };
        let label = Column::of_steps(self.label(), Kind::Category, labels);
        let place = Column::of_places(self.place(), Kind::Category);
        let values = self.values().into_iter().zip(self.units()).enumerate().map(|(i, (name, unit))| {
            let digits = if i < self.components().len() { of_components } else { Digits::Six };
            Column::float(name, digits).with_unit(unit)
        });
        TableColumns::new([label, place].into_iter().chain(values).collect())
    }

    /// The value columns but for facts of groups.
    pub fn components(&self) -> &[Component] {
        self.components.as_slice()
    }

    /// Names of the value columns.
    pub fn values(&self) -> Vec<String> {
        let suffix = if self.labels == Labels::Sums { SUM_SUFFIX } else { "" };
        let components = self.components().iter().map(|component| format!("{}{suffix}", component.name()));
        components.chain(self.facts.iter().map(|fact| self.fact(*fact).0.to_owned())).collect()
    }

    /// Names of all columns.
    pub fn names(&self) -> Vec<String> {
        [self.label().to_string(), self.place().to_string()].into_iter().chain(self.values()).collect()
    }

    /// Name and unit of a fact.
    fn fact(&self, fact: Fact) -> (&'static str, &'static str) {
        match (fact, self.labels) {
            (Fact::Area, _) => ("area_m2", "m2"),
            (Fact::Tilt, _) => ("tilt_deg", "deg"),
            (Fact::Azimuth, _) => ("azimuth_deg", "deg"),
            (Fact::Sum, Labels::Sums) => ("total_kwh", "kWh"),
            (Fact::Sum, Labels::Conditions | Labels::Times) => ("total_w", "W"),
        }
    }

    /// Units of the value columns, in the order of [`Layout::values`].
    pub fn units(&self) -> Vec<&'static str> {
        let components = self.components().iter().map(|_| self.unit());
        components.chain(self.facts.iter().map(|fact| self.fact(*fact).1)).collect()
    }

    /// The component that stands for all: the total, or else the first.
    pub fn main(&self) -> Component {
        let all = self.components();
        all.iter().find(|one| **one == Component::Total).or(all.first()).copied().unwrap_or(Component::Total)
    }

    /// Unit of the components.
    pub fn unit(&self) -> &'static str {
        match self.labels {
            Labels::Sums => "kWh/m2",
            Labels::Conditions | Labels::Times => "W/m2",
        }
    }
}

impl NamedValues for By {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("receiver", "One row for each receiver", By::Receiver),
        (
            "surface",
            "One for each surface: the mean of its receivers, weighted by their areas, or plain if none has an area",
            By::Surface,
        ),
        ("object", "One for each object of the model: city objects, zones and shades", By::Object),
        ("building", "One for each building, with all of its parts", By::Building),
        ("kind", "One for each kind of surface: roof, wall, window, ground, floor, shade", By::Kind),
    ];
}

heliotile_core::serde_by_name!(By);

#[cfg(test)]
mod tests {
    use super::*;

    /// All columns of a query are the 9 of the contract; two columns of sums come in the order asked, with their unit's ending.
    #[test]
    fn names() {
        let all = Layout {
            labels: Labels::Conditions,
            by: By::Receiver,
            components: ComponentList::all(),
            facts: Vec::new(),
        };
        let expected =
            "condition,receiver,sun_direct,sky_direct,sun_diffuse,sky_diffuse,sun_specular,sky_specular,total";
        assert_eq!((all.names().join(",").as_str(), all.unit()), (expected, "W/m2"));
        let two = Layout {
            labels: Labels::Sums,
            by: By::Surface,
            components: "total,sky_direct".parse().expect("names"),
            facts: Vec::new(),
        };
        assert_eq!(two.names(), ["time", "surface", "total_kwh_m2", "sky_direct_kwh_m2"]);
        assert_eq!(two.unit(), "kWh/m2");
    }
}
