//! Statements of a feature on its building. In: the feature's attributes. Out: the heights of roof
//! and foot above the base, and true for a part of another building; or the reason why the feature
//! is no building.

use serde_json::{Map, Value};

use crate::footprint::StatedHeights;
use crate::footprint_options::{FOOT_M, FootprintOptions, HeightSource, MAX_HEIGHT_M, STOREY_HEIGHT_M};

/// Columns of the height of the roof above the ground, in the order in which they are tried:
/// OpenStreetMap and Overture; exports of city models; BD TOPO of France.
const HEIGHTS: [&str; 7] =
    ["height", "building:height", "height_m", "building_height", "measuredheight", "measured_height", "hauteur"];
/// Columns of the number of storeys above the ground.
const STOREYS: [&str; 8] = [
    "building:levels",
    "num_floors",
    "levels",
    "storeys",
    "stories",
    "floors",
    "storeysaboveground",
    "nombre_d_etages",
];
/// Columns of the height above the ground at which a part begins, and of the storey at which it
/// does.
const FEET: [&str; 2] = ["min_height", "building:min_height"];
const FIRST_STOREYS: [&str; 3] = ["building:min_level", "min_level", "min_floor"];
/// Columns that name the building that a part belongs to (Overture).
const WHOLES: [&str; 1] = ["building_id"];
/// Columns that name a feature, in the order in which they are tried.
const IDS: [&str; 13] = [
    "id",
    "@id",
    "full_id",
    "osm_id",
    "osm_way_id",
    "gml_id",
    "gmlid",
    "identificatie",
    "building_id",
    "uuid",
    "objectid",
    "fid",
    "cleabs",
];

/// Attributes of a feature, read under some options.
pub(crate) struct Stated<'a> {
    attributes: &'a Map<String, Value>,
    options: &'a FootprintOptions,
}

impl<'a> Stated<'a> {
    pub(crate) fn new(attributes: &'a Map<String, Value>, options: &'a FootprintOptions) -> Self {
        Stated { attributes, options }
    }

    /// Returns the heights, or the reason why there are none in words that complete "3 left out
    /// ...".
    pub(crate) fn heights(&self) -> Result<StatedHeights, &'static str> {
        let storey_m = self.options.storey_height_m.unwrap_or(STOREY_HEIGHT_M);
        let metres = |columns: &[&str]| columns.iter().find_map(|column| metres_of(self.get(column)?));
        let storeys = |columns: &[&str]| columns.iter().find_map(|column| number_of(self.get(column)?));
        let asked = |source: &HeightSource| match source {
            HeightSource::Metres(metres) => Some(*metres),
            HeightSource::Column { name, .. } if is_one_of(name, &STOREYS) => {
                number_of(self.get(name)?).map(|count| count * storey_m)
            }
            HeightSource::Column { name, unit_m } => metres_of(self.get(name)?).map(|height| height * unit_m),
        };
        let roof_m = match self.options.height.is_empty() {
            true => metres(&HEIGHTS).or_else(|| storeys(&STOREYS).map(|count| count * storey_m)),
            false => self.options.height.iter().find_map(asked),
        };
        let Some(roof_m) = roof_m else { return Err(NO_HEIGHT) };
        let foot_m =
            metres(&FEET).or_else(|| storeys(&FIRST_STOREYS).map(|count| count * storey_m)).unwrap_or_default();
        if !(roof_m > 0.0 && roof_m <= MAX_HEIGHT_M) {
            return Err("whose height is not from 0 to 1000 m");
        }
        if !(0.0..roof_m).contains(&foot_m) {
            return Err("whose foot (min_height) is below the ground or above their roof");
        }
        let base_m = self.options.base.as_ref().and_then(asked);
        Ok(StatedHeights { roof_m, foot_m, base_m })
    }

    /// Returns the reason why the feature is no building above the ground, if it states one.
    pub(crate) fn is_other(&self) -> Option<&'static str> {
        let says = |column: &str, words: &[&str]| {
            self.get(column).and_then(Value::as_str).is_some_and(|text| words.contains(&text.to_lowercase().as_str()))
        };
        let under = says("location", &["underground"])
            || self.get("is_underground") == Some(&Value::Bool(true))
            || self.get("layer").and_then(number_of).is_some_and(|layer| layer < 0.0)
                && !self.get("building").is_none_or(Value::is_null);
        if under {
            return Some("as underground");
        }
        says("building", &["no"]).then_some("as no buildings (building=no)")
    }

    /// Returns true if the feature is a part of a building, whose whole is another feature.
    pub(crate) fn is_part(&self) -> bool {
        let part = self.get("building:part").or_else(|| self.get("building_part"));
        let part = part.is_some_and(|value| {
            !value.is_null() && value.as_str().is_none_or(|text| !text.is_empty() && text != "no")
        });
        part || self.whole().is_some()
    }

    /// Returns the name of the building that the feature states as its whole.
    pub(crate) fn whole(&self) -> Option<String> {
        let own = self.id();
        WHOLES.iter().find_map(|column| text_of(self.get(column)?)).filter(|whole| own.as_ref() != Some(whole))
    }

    /// Returns the name of the feature by its columns.
    pub(crate) fn id(&self) -> Option<String> {
        IDS.iter().find_map(|column| text_of(self.get(column)?))
    }

    /// Returns the value of a column by its name, in any case of letters.
    fn get(&self, column: &str) -> Option<&'a Value> {
        let alike =
            || self.attributes.iter().find(|(name, _)| name.eq_ignore_ascii_case(column)).map(|(_, value)| value);
        self.attributes.get(column).or_else(alike)
    }
}

/// Reason for leaving out features without a height.
pub(crate) const NO_HEIGHT: &str = "without a height or a number of storeys";

fn is_one_of(name: &str, columns: &[&str]) -> bool {
    columns.iter().any(|column| column.eq_ignore_ascii_case(name))
}

/// Returns a value that is not empty as text.
fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::String(text) if !text.trim().is_empty() => Some(text.trim().to_owned()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// Returns a number that is stated as a number or as text.
fn number_of(value: &Value) -> Option<f64> {
    let number = match value {
        Value::Number(number) => number.as_f64(),
        Value::String(text) => text.trim().replace(',', ".").parse().ok(),
        _ => None,
    };
    number.filter(|number| number.is_finite())
}

/// Returns a length in metres: `12`, `12.5`, `12,5 m`, `40 ft`, `40'`, `40'6"` (OSM wiki, "Map
/// features/Units").
fn metres_of(value: &Value) -> Option<f64> {
    if let Some(number) = number_of(value) {
        return Some(number);
    }
    let text = value.as_str()?.trim().replace(',', ".");
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    if let Some((feet, inches)) = text.split_once('\'') {
        let inches = inches.trim().trim_end_matches('"').trim_end_matches('\'');
        let inches = if inches.is_empty() { 0.0 } else { number(inches)? };
        return Some((number(feet)? + inches / 12.0) * FOOT_M);
    }
    let lower = text.to_lowercase();
    for (unit, metres) in [("ft", FOOT_M), ("feet", FOOT_M), ("metres", 1.0), ("meters", 1.0), ("m", 1.0)] {
        if let Some(rest) = lower.strip_suffix(unit) {
            return number(rest).map(|number| number * metres);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn heights(attributes: Value, options: &FootprintOptions) -> Result<StatedHeights, &'static str> {
        Stated::new(attributes.as_object().expect("an object"), options).heights()
    }

    /// Sixteen ways to state a height of 12 m, by column, storeys, unit and letters, give 12 m
    /// within 1 mm.
    #[test]
    fn sixteen_ways_to_state_12_m_give_12_m() {
        let usual = FootprintOptions::default();
        for attributes in [
            json!({"height": 12}),
            json!({"height": "12"}),
            json!({"height": "12 m"}),
            json!({"height": "12,0"}),
            json!({"HEIGHT": 12.0}),
            json!({"height": "39.37 ft"}),
            json!({"height": "39'4.44\""}),
            json!({"height": null, "building:levels": "4"}),
            json!({"height": "tall", "num_floors": 4}),
            json!({"building:height": 12, "building:levels": 9}),
            json!({"measuredHeight": 12}),
        ] {
            let found = heights(attributes.clone(), &usual).expect("a height");
            assert!((found.roof_m - 12.0).abs() < 1e-3, "{attributes}: {found:?}");
        }
        let asked = |height: &str, storey_height_m| FootprintOptions {
            height: height.split(',').map(|part| part.parse().expect("a source")).collect(),
            storey_height_m,
            base: None,
        };
        for (attributes, options) in [
            (json!({"h": 12, "height": 3}), asked("h", None)),
            (json!({"HEIGHTROOF": 39.370_078_740_157_48}), asked("HEIGHTROOF[ft]", None)),
            (json!({"height": 3}), asked("12m", None)),
            (json!({"height": 3}), asked("h,12m", None)),
            (json!({"levels": 3}), asked("levels", Some(4.0))),
        ] {
            let found = heights(attributes, &options).expect("a height");
            assert!((found.roof_m - 12.0).abs() < 1e-9, "{found:?}");
        }
    }

    /// One feature stands from 9 to 12 m, one has no height, and 4 have impossible heights; 3 are
    /// no buildings above the ground. A part of Overture and one of OpenStreetMap are parts.
    #[test]
    fn impossible_heights_are_no_buildings() {
        let usual = FootprintOptions::default();
        let found = heights(json!({"height": 12, "building:min_level": 3}), &usual).expect("a part");
        assert_eq!((found.roof_m, found.foot_m), (12.0, 9.0));
        assert_eq!(heights(json!({"name": "x"}), &usual), Err(NO_HEIGHT));
        for attributes in [
            json!({"height": 0}),
            json!({"height": 1e9}),
            json!({"height": 5, "min_height": 5}),
            json!({"height": 5, "min_height": -1}),
        ] {
            assert!(heights(attributes, &usual).is_err_and(|why| why != NO_HEIGHT));
        }
        let stated = |value: Value| {
            let map = value.as_object().expect("an object").clone();
            let stated = Stated::new(&map, &usual);
            (stated.is_other().is_some(), stated.is_part(), stated.whole(), stated.id())
        };
        assert!(stated(json!({"is_underground": true})).0 && stated(json!({"building": "no"})).0);
        assert!(
            !stated(json!({"building": "yes", "layer": "1"})).0 && stated(json!({"building": "yes", "layer": "-1"})).0
        );
        assert_eq!(stated(json!({"id": "b", "building_id": "a"})), (false, true, Some("a".into()), Some("b".into())));
        assert_eq!(stated(json!({"building:part": "yes", "osm_id": 7})), (false, true, None, Some("7".into())));
        assert_eq!(stated(json!({"building_id": 7})), (false, false, None, Some("7".into())));
    }
}
