//! Options for footprints. In: texts of command-line options and of `site.toml`. Out: where heights
//! of buildings come from.

use std::fmt::{self, Display};
use std::str::FromStr;

use heliotile_core::named::NamedValues;
use heliotile_core::units::parse_metres;
use heliotile_requests::Request;
use serde::{Deserialize, Serialize};

/// Default height of a storey, metres from floor to floor: what OSM's page "Simple 3D Buildings"
/// and 3D viewers of its data assume.
pub const STOREY_HEIGHT_M: f64 = 3.0;

/// Tallest building that is accepted, metres: the tallest one today has 828 m.
pub const MAX_HEIGHT_M: f64 = 1000.0;

/// International foot, metres.
pub(crate) const FOOT_M: f64 = 0.3048;

/// Source of a height.
#[derive(Clone, Debug, PartialEq)]
pub enum HeightSource {
    /// A column (attribute) of the features.
    Column {
        /// Name of the column.
        name: String,
        /// Metres a unit of the column's numbers; `None`: the unit of the file's coordinates.
        unit_m: Option<f64>,
    },
    /// One height for all features, metres.
    Metres(f64),
}

/// Level from which columns of heights count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightAbove {
    /// Heights are above the base of the building.
    Base,
    /// Heights are those of roofs above the sea.
    Sea,
}

impl NamedValues for HeightAbove {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("base", "above the base of the building", HeightAbove::Base),
        ("sea", "roofs above the sea, less the terrain below them or `base`", HeightAbove::Sea),
    ];
}

heliotile_core::serde_by_name!(HeightAbove);

/// Sources of the heights of footprints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Request)]
#[serde(deny_unknown_fields)]
pub struct FootprintOptions {
    /// Height of buildings above their base, for files of footprints: a column, or metres for all
    /// buildings, or several, of which the first with a value counts, as in HGT,9m [default:
    /// columns such as height and building:height, then storeys].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[field(delimiter = ',', metavar = "COLUMN|METRES")]
    pub height: Vec<HeightSource>,
    /// Height of a storey, for footprints that state storeys and no height [default: 3m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "LENGTH", parse = parse_metres)]
    pub storey_height_m: Option<f64>,
    /// Base of buildings from footprints: a column, or metres [default: the lowest terrain below
    /// the outline, 0 without terrain].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "COLUMN|METRES")]
    pub base: Option<HeightSource>,
    /// Level from which columns of heights count: the base, or the sea for absolute heights of
    /// roofs, from which the terrain below or --base is taken [default: base].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "LEVEL")]
    pub height_above: Option<HeightAbove>,
    /// Layer to read of a GeoPackage with several; may be given more than once [default: the layers
    /// of buildings by their names, else all].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[field(metavar = "NAME")]
    pub layer: Vec<String>,
}

impl FootprintOptions {
    /// Returns these options, with those of `other` where nothing is stated here.
    pub(crate) fn or(&self, other: &FootprintOptions) -> FootprintOptions {
        FootprintOptions {
            height: if self.height.is_empty() { other.height.clone() } else { self.height.clone() },
            storey_height_m: self.storey_height_m.or(other.storey_height_m),
            base: self.base.clone().or_else(|| other.base.clone()),
            height_above: self.height_above.or(other.height_above),
            layer: if self.layer.is_empty() { other.layer.clone() } else { self.layer.clone() },
        }
    }

    /// Returns true if no option is stated.
    pub fn is_default(&self) -> bool {
        *self == FootprintOptions::default()
    }

    /// Checks that numbers are within range; an error names the field.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let tall = self.height.iter().find(
            |source| matches!(source, HeightSource::Metres(metres) if !(*metres > 0.0 && *metres <= MAX_HEIGHT_M)),
        );
        if let Some(source) = tall {
            return Err(("height", format!("the height is {source}, not from 0 to {MAX_HEIGHT_M} m")));
        }
        match self.storey_height_m {
            Some(metres) if !(1.0..=20.0).contains(&metres) => {
                Err(("storey_height", format!("a storey is {metres} m high, not from 1 to 20 m")))
            }
            _ => Ok(()),
        }
    }
}

impl FromStr for HeightSource {
    type Err = String;

    /// Reads `9.5m` or `9.5` as metres and anything else as the name of a column; `HEIGHTROOF[ft]`
    /// is a column in feet, `HEIGHT[m]` one in metres, `HEIGHT[cm]` one in centimetres.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let number = text.strip_suffix('m').unwrap_or(text).trim_end();
        match number.parse::<f64>() {
            Ok(metres) if metres.is_finite() && metres.abs() <= 9000.0 => Ok(HeightSource::Metres(metres)),
            Ok(metres) => Err(format!("{metres} m is no height on Earth")),
            Err(_) if text.is_empty() => Err("give the name of a column, or metres such as 9.5m".to_owned()),
            Err(_) => {
                let units = [("[ft]", FOOT_M), ("[cm]", 0.01), ("[m]", 1.0)];
                let found = units.iter().find_map(|(unit, metres)| Some((text.strip_suffix(unit)?, Some(*metres))));
                let (name, unit_m) = found.unwrap_or((text, None));
                Ok(HeightSource::Column { name: name.trim_end().to_owned(), unit_m })
            }
        }
    }
}

impl Display for HeightSource {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        match self {
            HeightSource::Column { name, unit_m: None } => to.write_str(name),
            HeightSource::Column { name, unit_m: Some(1.0) } => write!(to, "{name}[m]"),
            HeightSource::Column { name, unit_m: Some(0.01) } => write!(to, "{name}[cm]"),
            HeightSource::Column { name, .. } => write!(to, "{name}[ft]"),
            HeightSource::Metres(metres) => write!(to, "{metres}m"),
        }
    }
}

heliotile_core::parse_by_name!(HeightAbove);
heliotile_requests::parse_by_text!(HeightSource: heliotile_requests::Form::TEXT);

heliotile_core::serde_by_text!(HeightSource);

#[cfg(test)]
mod tests {
    use super::*;

    /// Three texts are metres, five are columns, three of them in feet, metres and centimetres, and
    /// two are refused; each source is read back from its own text.
    #[test]
    fn a_source_of_heights_is_read_from_its_text() {
        let of = |text: &str| text.parse::<HeightSource>();
        for (text, expected) in [
            ("9.5m", HeightSource::Metres(9.5)),
            ("9.5 m", HeightSource::Metres(9.5)),
            ("12", HeightSource::Metres(12.0)),
            ("building:height", HeightSource::Column { name: "building:height".into(), unit_m: None }),
            ("h_m", HeightSource::Column { name: "h_m".into(), unit_m: None }),
            ("HEIGHTROOF[ft]", HeightSource::Column { name: "HEIGHTROOF".into(), unit_m: Some(0.3048) }),
            ("HGT[cm]", HeightSource::Column { name: "HGT".into(), unit_m: Some(0.01) }),
            ("HGT[m]", HeightSource::Column { name: "HGT".into(), unit_m: Some(1.0) }),
        ] {
            assert_eq!(of(text), Ok(expected.clone()), "{text}");
            assert_eq!(of(&expected.to_string()), Ok(expected));
        }
        assert!(of(" ").is_err() && of("1e9").is_err());
        let tall = FootprintOptions { height: vec![HeightSource::Metres(-1.0)], ..FootprintOptions::default() };
        assert!(tall.check().is_err_and(|(field, _)| field == "height"));
    }
}
