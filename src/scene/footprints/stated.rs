//! Statements of a feature on its building. In: the feature's attributes. Out: the heights of roof
//! and foot above the base, and true for a part of another building; or the reason why the feature
//! is no building.

use serde_json::{Map, Value};

use crate::attributes::{GONE, is_gone};
use crate::footprint::StatedHeights;
use crate::footprint_options::{FOOT_M, FootprintOptions, HeightAbove, HeightSource, MAX_HEIGHT_M, STOREY_HEIGHT_M};

/// Columns of the height of the roof above the ground, in the order in which they are tried:
/// OpenStreetMap and Overture; exports of city models; BD TOPO of France; INSPIRE.
const HEIGHTS: [&str; 8] = [
    "height",
    "building:height",
    "height_m",
    "building_height",
    "measuredheight",
    "measured_height",
    "hauteur",
    "heightaboveground",
];
/// Columns of the number of storeys above the ground.
const STOREYS: [&str; 10] = [
    "building:levels",
    "num_floors",
    "levels",
    "storeys",
    "stories",
    "floors",
    "storeysaboveground",
    "nombre_d_etages",
    "numberoffloorsaboveground",
    "anzahlderoberirdischengeschosse",
];
/// Columns of the height above the ground at which a part begins, and of the storey at which it
/// does.
const FEET: [&str; 2] = ["min_height", "building:min_height"];
const FIRST_STOREYS: [&str; 3] = ["building:min_level", "min_level", "min_floor"];
/// Columns that name the building that a part belongs to (Overture).
const WHOLES: [&str; 1] = ["building_id"];
/// Columns that name a feature, in the order in which they are tried.
const IDS: [&str; 14] = [
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
    "name",
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
    pub(crate) fn heights(&self) -> Result<Heights, &'static str> {
        let storey_m = self.options.storey_height_m.unwrap_or(STOREY_HEIGHT_M);
        let columns =
            |names: &[&str]| -> Vec<Height> { names.iter().filter_map(|name| self.height(name, None)).collect() };
        let storeys = |names: &[&str]| -> Vec<Height> {
            let counts = names.iter().filter_map(|column| number_of(self.get(column)?));
            counts.map(|count| Height::metres(count * storey_m)).collect()
        };
        let is_absolute = self.options.height_above == Some(HeightAbove::Sea);
        let asked = |source: &HeightSource| match source {
            HeightSource::Metres(metres) => Some(Height::metres(*metres)),
            HeightSource::Column { name, .. } if is_one_of(name, &STOREYS) => {
                number_of(self.get(name)?).map(|count| Height::metres(count * storey_m))
            }
            HeightSource::Column { name, unit_m } => self.height(name, *unit_m),
        };
        let roof = |source: &HeightSource| {
            let is_column = matches!(source, HeightSource::Column { name, .. } if !is_one_of(name, &STOREYS));
            asked(source).map(|roof| Height { is_absolute: is_absolute && is_column, ..roof })
        };
        let roofs: Vec<Height> = match self.options.height.is_empty() {
            true => {
                let columns = columns(&HEIGHTS).into_iter().map(|roof| Height { is_absolute, ..roof });
                columns.chain(storeys(&STOREYS)).collect()
            }
            false => self.options.height.iter().filter_map(roof).collect(),
        };
        // Writers put 0, -1 or -9999 where a height is not known: the next source counts. Roofs may
        // lie below the sea.
        let least = |roof: &Height| if roof.is_absolute { NO_FOOT_TO } else { 0.0 };
        let is_known = |roof: &&Height| roof.value != 0.0 && roof.value > least(roof) && roof.value < NO_HEIGHT_FROM;
        let roof = roofs.iter().find(is_known).copied();
        let roof = match (roof, roofs.is_empty()) {
            (Some(roof), _) => roof,
            (None, true) => return Err(NO_HEIGHT),
            (None, false) => return Err(BEYOND),
        };
        let mut feet = columns(&FEET).into_iter().chain(storeys(&FIRST_STOREYS));
        let foot = feet.find(|foot| foot.value > NO_FOOT_TO);
        let base = self.options.base.as_ref().and_then(asked);
        Ok(Heights { roof, foot, base, is_canopy: self.is_canopy() })
    }

    /// Returns the value of a column in metres a unit, by the unit that the user, the value or the
    /// name of the column states.
    fn height(&self, name: &str, unit_m: Option<f64>) -> Option<Height> {
        let value = self.get(name)?;
        match (number_of(value), unit_m) {
            (Some(number), Some(unit_m)) => Some(Height::metres(number * unit_m)),
            (Some(number), None) => {
                Some(Height { value: number, has_unit: name.to_lowercase().ends_with("_m"), is_absolute: false })
            }
            (None, _) => metres_of(value).map(Height::metres),
        }
    }

    /// Returns true if the feature is a roof without walls (OSM wiki, "Tag:building=roof").
    fn is_canopy(&self) -> bool {
        ["building", "building:part"].iter().any(|key| self.says(key, &["roof", "carport", "canopy"]))
    }

    /// Returns the reason why the feature is no building above the ground, if it states one.
    pub(crate) fn is_other(&self) -> Option<&'static str> {
        let under = self.says("location", &["underground"])
            || self.get("is_underground") == Some(&Value::Bool(true))
            || self.get("layer").and_then(number_of).is_some_and(|layer| layer < 0.0)
                && !self.get("building").is_none_or(Value::is_null);
        if under {
            return Some("as underground");
        }
        if self.says("building", &["no"]) {
            return Some("as no buildings (building=no)");
        }
        if is_gone(self.attributes) {
            return Some(GONE);
        }
        if self.says("building", &NOT_STANDING) {
            return Some("as buildings that do not stand (building=demolished or proposed)");
        }
        let is_open = NOT_BUILDINGS.iter().any(|(key, values)| match values.is_empty() {
            true => self.get(key).is_some_and(is_key),
            false => self.says(key, values),
        });
        (is_open && !self.has_building_key()).then_some("as woods, parks, squares, hedges and other land")
    }

    /// Returns true if the feature has a key of OpenStreetMap for a building or a part of one.
    pub(crate) fn has_building_key(&self) -> bool {
        ["building", "building:part"].iter().any(|key| self.get(key).is_some_and(is_key))
    }

    fn says(&self, column: &str, words: &[&str]) -> bool {
        self.get(column)
            .and_then(Value::as_str)
            .is_some_and(|text| words.contains(&text.trim().to_lowercase().as_str()))
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
/// Reason for leaving out features with heights that no building has.
const BEYOND: &str = "whose height is not from 0 to 1000 m";

/// Number from which a height is no height in any unit: 9999 and more stand for "not known".
const NO_HEIGHT_FROM: f64 = 9000.0;
/// Number to which a height of a foot stands for "not known".
const NO_FOOT_TO: f64 = -90.0;
/// Thickness of a roof without walls, metres.
const CANOPY_M: f64 = 0.1;

/// Values of `building` of what does not stand (OSM wiki, "Key:building").
const NOT_STANDING: [&str; 6] = ["demolished", "razed", "destroyed", "removed", "proposed", "planned"];
/// Keys of OpenStreetMap, and those of their values that are land, not buildings; no values: all.
const NOT_BUILDINGS: [(&str, &[&str]); 8] = [
    ("natural", &[]),
    ("barrier", &[]),
    ("waterway", &[]),
    ("highway", &[]),
    ("place", &["square", "locality", "neighbourhood", "suburb", "island", "islet", "village", "town", "city"]),
    (
        "leisure",
        &["park", "garden", "pitch", "playground", "nature_reserve", "golf_course", "track", "dog_park", "common"],
    ),
    (
        "landuse",
        &[
            "forest",
            "grass",
            "meadow",
            "farmland",
            "cemetery",
            "orchard",
            "vineyard",
            "allotments",
            "village_green",
            "recreation_ground",
            "basin",
            "reservoir",
            "quarry",
            "plant_nursery",
            "flowerbed",
            "greenfield",
        ],
    ),
    ("amenity", &["parking", "grave_yard"]),
];

/// A height as a feature states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Height {
    value: f64,
    /// True if the value is metres; otherwise it is in the unit of the file.
    has_unit: bool,
    /// True if the height is above the sea, not above the base.
    is_absolute: bool,
}

impl Height {
    fn metres(value: f64) -> Height {
        Height { value, has_unit: true, is_absolute: false }
    }

    fn in_metres(self, unit_m: f64) -> f64 {
        if self.has_unit { self.value } else { self.value * unit_m }
    }
}

/// Heights of a feature, in metres or in the unit of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Heights {
    roof: Height,
    foot: Option<Height>,
    base: Option<Height>,
    is_canopy: bool,
}

impl Heights {
    /// Returns true if a height is in the unit of the file, which is nowhere stated.
    pub(crate) fn lacks_unit(&self) -> bool {
        [Some(self.roof), self.foot, self.base].into_iter().flatten().any(|height| !height.has_unit)
    }

    /// Returns the heights in metres, for a file with a unit of so many metres; or the reason why
    /// they are none of a building.
    pub(crate) fn in_metres(self, unit_m: f64) -> Result<StatedHeights, &'static str> {
        let roof_m = self.roof.in_metres(unit_m);
        let is_roof_absolute = self.roof.is_absolute;
        if !(is_roof_absolute || roof_m > 0.0 && roof_m <= MAX_HEIGHT_M) {
            return Err(BEYOND);
        }
        let is_canopy = self.is_canopy && self.foot.is_none() && !is_roof_absolute;
        let thin_m = if is_canopy { (roof_m - CANOPY_M).max(0.5 * roof_m) } else { 0.0 };
        let foot_m = self.foot.map_or(thin_m, |foot| foot.in_metres(unit_m));
        // Above a base that is not known yet.
        let most_m = if is_roof_absolute { MAX_HEIGHT_M } else { roof_m };
        if !(0.0..most_m).contains(&foot_m) {
            return Err("whose foot (min_height) is below the ground or above their roof");
        }
        let base_m = self.base.map(|base| base.in_metres(unit_m));
        Ok(StatedHeights { roof_m, is_roof_absolute, foot_m, base_m, has_walls: !is_canopy })
    }
}

/// Returns true if a key of OpenStreetMap has a value.
fn is_key(value: &Value) -> bool {
    !value.is_null() && value.as_str().is_none_or(|text| !text.trim().is_empty())
}

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
pub(crate) fn metres_of(value: &Value) -> Option<f64> {
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
        Stated::new(attributes.as_object().expect("an object"), options).heights()?.in_metres(1.0)
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
            ..FootprintOptions::default()
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

    /// Where a column holds 0, -1, -9999 or 9999, the next source counts: 12 m by four storeys, 9 m
    /// by three, 15 m as asked; without another source there is no height. 30.48 m are 100 of a
    /// file in feet, and 100 of a column in metres stay 100 m.
    #[test]
    fn a_height_that_is_not_known_falls_through_to_the_next_source() {
        let usual = FootprintOptions::default();
        for (attributes, expected) in [
            (json!({"height": -1.0, "num_floors": 4}), 12.0),
            (json!({"height": 0, "building:levels": "3"}), 9.0),
            (json!({"height": 9999, "building:height": 7, "min_height": -9999}), 7.0),
        ] {
            assert_eq!(heights(attributes, &usual).map(|found| (found.roof_m, found.foot_m)), Ok((expected, 0.0)));
        }
        assert_eq!(heights(json!({"height": -9999}), &usual), Err(BEYOND));
        let asked = FootprintOptions {
            height: ["h", "15m"].map(|text| text.parse().expect("a source")).to_vec(),
            ..FootprintOptions::default()
        };
        assert_eq!(heights(json!({"h": -9999}), &asked).map(|found| found.roof_m), Ok(15.0));
        for (text, expected) in [("h", 30.48), ("h[ft]", 30.48), ("h[m]", 100.0)] {
            let options = FootprintOptions { height: vec![text.parse().expect("a column")], ..usual.clone() };
            let map = json!({"h": 100}).as_object().expect("an object").clone();
            let found = Stated::new(&map, &options).heights().and_then(|found| found.in_metres(0.3048));
            assert!((found.expect("a height").roof_m - expected).abs() < 1e-9, "{text}");
        }
    }

    /// Among six features of OpenStreetMap one is a building and one a roof from 4.9 to 5 m without
    /// walls; a wood, a hedge, a park and a demolished house are none. A shop whose land use is
    /// stated stays a building.
    #[test]
    fn woods_hedges_and_parks_are_no_buildings() {
        let usual = FootprintOptions::default();
        let is_other = |value: Value| {
            let map = value.as_object().expect("an object").clone();
            Stated::new(&map, &usual).is_other().is_some()
        };
        for other in [
            json!({"natural": "wood", "height": "15"}),
            json!({"barrier": "hedge", "height": "2"}),
            json!({"leisure": "park", "levels": "2"}),
            json!({"place": "square"}),
            json!({"building": "demolished", "height": "9"}),
        ] {
            assert!(is_other(other.clone()), "{other}");
        }
        assert!(!is_other(json!({"building": "yes", "natural": "rock"})));
        assert!(!is_other(json!({"landuse": "commercial", "height": 5})));
        let roof = heights(json!({"building": "roof", "height": 5}), &usual).expect("a roof");
        assert!((roof.foot_m - 4.9).abs() < 1e-9 && !roof.has_walls);
    }
}
