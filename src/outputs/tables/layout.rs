//! The columns of a table: a label, a receiver, and the components that are asked for, with their unit.

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

/// The columns of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    pub labels: Labels,
    pub by: By,
    pub components: ComponentList,
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

    pub fn components(&self) -> &[Component] {
        self.components.as_slice()
    }

    /// Names of the value columns.
    pub fn values(&self) -> Vec<String> {
        let suffix = if self.labels == Labels::Sums { SUM_SUFFIX } else { "" };
        self.components().iter().map(|component| format!("{}{suffix}", component.name())).collect()
    }

    /// Names of all columns.
    pub fn names(&self) -> Vec<String> {
        [self.label().to_string(), self.place().to_string()].into_iter().chain(self.values()).collect()
    }

    /// Unit of the value columns.
    pub fn unit(&self) -> &'static str {
        match self.labels {
            Labels::Sums => "kWh/m2",
            Labels::Conditions | Labels::Times => "W/m2",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All columns of a query are the 9 of the contract; two columns of sums come in the order asked, with their unit's ending.
    #[test]
    fn names() {
        let all = Layout { labels: Labels::Conditions, by: By::Receiver, components: ComponentList::all() };
        let expected =
            "condition,receiver,sun_direct,sky_direct,sun_diffuse,sky_diffuse,sun_specular,sky_specular,total";
        assert_eq!((all.names().join(",").as_str(), all.unit()), (expected, "W/m2"));
        let two =
            Layout { labels: Labels::Sums, by: By::Surface, components: "total,sky_direct".parse().expect("names") };
        assert_eq!(two.names(), ["time", "surface", "total_kwh_m2", "sky_direct_kwh_m2"]);
        assert_eq!(two.unit(), "kWh/m2");
    }
}
