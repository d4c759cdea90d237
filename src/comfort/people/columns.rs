//! Columns of results of a point in an hour. In: names. Out: columns, and the names of their
//! numbers.

use std::str::FromStr;

use heliotile_core::named::{NamedValues, of_name};

/// Names of the planes, in the order of the values.
pub const PLANES: [&str; 6] = ["up", "down", "north", "east", "south", "west"];

/// A column of results, or six of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComfortColumn {
    /// Air temperature, degrees Celsius.
    Air,
    /// Wind at 10 m, m/s.
    Wind,
    /// Mean radiant temperature, degrees Celsius.
    MeanRadiant,
    /// Universal Thermal Climate Index, degrees Celsius.
    Utci,
    /// Physiological Equivalent Temperature, degrees Celsius.
    Pet,
    /// Shortwave irradiance of the six planes, W/m2.
    Shortwave,
    /// Longwave irradiance of the six planes, W/m2.
    Longwave,
}

impl ComfortColumn {
    /// Default columns of results.
    pub const USUAL: [ComfortColumn; 3] = [ComfortColumn::MeanRadiant, ComfortColumn::Utci, ComfortColumn::Pet];

    /// Returns true if it is an index of comfort, which depends on humidity and wind.
    pub fn is_index(self) -> bool {
        matches!(self, ComfortColumn::Utci | ComfortColumn::Pet)
    }

    /// Returns the number of columns, 1 or 6.
    pub fn width(self) -> usize {
        match self {
            ComfortColumn::Shortwave | ComfortColumn::Longwave => PLANES.len(),
            _ => 1,
        }
    }

    /// Returns the names of its columns, without the unit of irradiances.
    pub fn names(self) -> Vec<String> {
        let six = |kind: &str| PLANES.iter().map(|plane| format!("{kind}_{plane}")).collect();
        match self {
            ComfortColumn::Air => vec!["air_c".into()],
            ComfortColumn::Wind => vec!["wind_m_s".into()],
            ComfortColumn::MeanRadiant => vec!["mrt_c".into()],
            ComfortColumn::Utci => vec!["utci_c".into()],
            ComfortColumn::Pet => vec!["pet_c".into()],
            ComfortColumn::Shortwave => six("shortwave"),
            ComfortColumn::Longwave => six("longwave"),
        }
    }
}

impl FromStr for ComfortColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        of_name(text).map_err(|wrong| wrong.to_string())
    }
}

impl NamedValues for ComfortColumn {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("air", "Air temperature", ComfortColumn::Air),
        ("wind", "Wind at 10 m", ComfortColumn::Wind),
        ("mrt", "Mean radiant temperature", ComfortColumn::MeanRadiant),
        ("utci", "Universal Thermal Climate Index", ComfortColumn::Utci),
        ("pet", "Physiological Equivalent Temperature", ComfortColumn::Pet),
        ("shortwave", "Shortwave irradiance of six planes", ComfortColumn::Shortwave),
        ("longwave", "Longwave irradiance of six planes", ComfortColumn::Longwave),
    ];
}

heliotile_core::serde_by_name!(ComfortColumn);

heliotile_core::parse_by_name!(ComfortColumn);

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of the seven columns has as many names as numbers, 17 different ones together.
    #[test]
    fn each_column_has_as_many_names_as_numbers() {
        let mut names = Vec::new();
        for (_, _, column) in ComfortColumn::VALUES {
            assert_eq!(column.names().len(), column.width(), "{column:?}");
            names.extend(column.names());
        }
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 17);
    }
}
