//! Validation against published tables: FedericoTartarini/validation-data-comfort-models at 038795d
//! (MIT licence), with which pythermalcomfort, jsthermalcomfort and the R package comf are tested.
//! In: files of `tests/data/comfort`. Every row counts, also those that are kept from R.

use crate::pet::{PetClimate, PetPerson, SEA_LEVEL_HPA, pet_c};
use crate::utci::{StressCategory, UtciInput, utci_c};
use serde_json::Value;

/// A table: rows with `inputs` and `outputs`, and the tolerance of each output.
struct Table(Value);

impl Table {
    fn read(text: &str) -> Self {
        Table(serde_json::from_str(text).expect("JSON"))
    }

    fn rows(&self) -> impl Iterator<Item = (&Value, &Value)> {
        let rows = self.0.get("data").and_then(Value::as_array).expect("rows");
        rows.iter().map(|row| (row.get("inputs").expect("inputs"), row.get("outputs").expect("outputs")))
    }

    fn assert_close(&self, name: &str, expected: &Value, got: Option<f64>, row: &Value) {
        let tolerance = self.0.get("tolerance").and_then(|all| all.get(name)?.as_f64()).expect("a tolerance");
        let is_close = |expected: f64| got.is_some_and(|got| (got - expected).abs() <= tolerance);
        let is_met = expected.as_f64().map_or(expected.is_null() && got.is_none(), is_close);
        assert!(is_met, "{row}: {got:?} instead of {expected}");
    }
}

/// Returns a value, or one of an array of values; null where there is none.
fn one_of(value: Option<&Value>, place: usize) -> Value {
    let value = value.unwrap_or(&Value::Null);
    let one = if value.is_array() { value.get(place) } else { Some(value) };
    one.cloned().unwrap_or_default()
}

/// Returns a number, or one of an array of numbers.
fn number(row: &Value, name: &str, place: usize) -> f64 {
    one_of(row.get(name), place).as_f64().expect("a number")
}

/// All 21 UTCI of the 13 rows, of which two hold arrays and one is in Fahrenheit and feet per
/// second, are met within 0.1 K. The four that are null are `None`, and the four categories are
/// equal.
#[test]
fn all_utci_of_the_table_are_met() {
    let table =
        Table::read(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/comfort/ts_utci.json")));
    let (mut values, mut nulls, mut categories) = (0, 0, 0);
    for (inputs, outputs) in table.rows() {
        let is_imperial = inputs["units"] == "ip";
        for place in 0..inputs["tdb"].as_array().map_or(1, Vec::len) {
            let celsius = |name| match number(inputs, name, place) {
                value if is_imperial => (value - 32.0) / 1.8,
                value => value,
            };
            let input = UtciInput {
                air_temperature_c: celsius("tdb"),
                mean_radiant_temperature_c: celsius("tr"),
                wind_10m_m_s: number(inputs, "v", place) * if is_imperial { 0.3048 } else { 1.0 },
                relative_humidity_percent: number(inputs, "rh", place),
            };
            let got = utci_c(&input);
            let shown = got.map(|celsius| if is_imperial { 1.8 * celsius + 32.0 } else { celsius });
            table.assert_close("utci", &one_of(outputs.get("utci"), place), shown, inputs);
            if let Some(name) = one_of(outputs.get("stress_category"), place).as_str() {
                let category = StressCategory::ALL
                    .iter()
                    .find(|category| got.is_some_and(|celsius| celsius <= category.upper_limit_c));
                assert_eq!(category.map(|category| category.name), Some(name), "{inputs}");
                categories += 1;
            }
            values += 1;
            nulls += i32::from(got.is_none());
        }
    }
    assert_eq!((table.rows().count(), values, nulls, categories), (13, 21, 4, 4));
}

/// All 9 PET are met within 0.1 K, and within 0.006 K, the rounding of the table.
#[test]
fn all_pet_of_the_table_are_met() {
    let table =
        Table::read(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/comfort/ts_pet_steady.json")));
    for (inputs, outputs) in table.rows() {
        let climate = PetClimate {
            air_temperature_c: number(inputs, "tdb", 0),
            mean_radiant_temperature_c: number(inputs, "tr", 0),
            wind_m_s: number(inputs, "v", 0),
            relative_humidity_percent: number(inputs, "rh", 0),
            pressure_hpa: SEA_LEVEL_HPA,
        };
        let person = PetPerson {
            activity_met: number(inputs, "met", 0),
            clothing_clo: number(inputs, "clo", 0),
            ..PetPerson::default()
        };
        let got = pet_c(&climate, &person);
        table.assert_close("pet", &outputs["pet"], got, inputs);
        assert!(got.is_some_and(|got| (got - number(outputs, "pet", 0)).abs() < 0.006), "{inputs}: {got:?}");
    }
    assert_eq!(table.rows().count(), 9);
}
