//! What a CSV file holds, in `NAME.csv-metadata.json` beside it. In: its columns and provenance. Out: JSON as programs for CSV on the Web
//! look for it.
//!
//! Format: W3C recommendation "Metadata Vocabulary for Tabular Data", 2015. It has no word for units: they stand as `schema:unitText`, and
//! provenance as a list of `schema:additionalProperty`, both words of schema.org, whose prefix it knows.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::row_labels::{Precision, RowLabels};
use heliotile_core::error::{Error, Result};

/// A column of a CSV file.
pub struct CsvColumn {
    name: String,
    datatype: Value,
    unit: Option<&'static str>,
}

/// Units by the ending of a column's name, or by the whole of it; longer endings first.
const UNITS: [(&str, &str); 13] = [
    ("_kwh_m2", "kWh/m2"),
    ("_kwh", "kWh"),
    ("_w_m2", "W/m2"),
    ("_mwh", "MWh"),
    ("_percent", "%"),
    ("_cpu_s", "s"),
    ("_deg", "deg"),
    ("_m2", "m2"),
    ("_m", "m"),
    ("_view", "1"),
    ("area", "m2"),
    ("bytes", "byte"),
    ("receivers", "1"),
];

/// Places in metres, and normals.
const PLACES: [(&str, &str); 6] = [("x", "m"), ("y", "m"), ("z", "m"), ("nx", "1"), ("ny", "1"), ("nz", "1")];

/// The unit that a column's name says.
pub fn unit_of(name: &str) -> Option<&'static str> {
    let place = PLACES.iter().find(|(place, _)| *place == name);
    place.or_else(|| UNITS.iter().find(|(ending, _)| name.ends_with(ending))).map(|(_, unit)| *unit)
}

impl CsvColumn {
    pub fn text(name: &str) -> Self {
        CsvColumn { name: name.into(), datatype: json!("string"), unit: None }
    }

    /// A number, with the unit that its name says.
    pub fn number(name: &str) -> Self {
        CsvColumn { name: name.into(), datatype: json!("number"), unit: unit_of(name) }
    }

    /// By its name: a number where that has a unit, text where it has none.
    pub fn named(name: &str) -> Self {
        let number = CsvColumn::number(name);
        if number.unit.is_some() { number } else { CsvColumn::text(name) }
    }

    /// The same with a unit that its name does not say.
    pub fn with_unit(self, unit: &'static str) -> Self {
        CsvColumn { unit: Some(unit), ..self }
    }

    /// The columns of a table of results.
    pub fn of_results(layout: &Layout, labels: &RowLabels) -> Vec<Self> {
        let datatype = match labels.instants.as_ref().map(|instants| instants.precision) {
            Some(Precision::Year) => json!("gYear"),
            Some(Precision::Month) => json!("gYearMonth"),
            Some(Precision::Day) => json!("date"),
            Some(Precision::Minute) => json!({"base": "datetime", "format": "yyyy-MM-ddTHH:mmxxx"}),
            Some(Precision::Second) => json!({"base": "datetime", "format": "yyyy-MM-ddTHH:mm:ssxxx"}),
            None => json!("string"),
        };
        let label = CsvColumn { name: layout.label().into(), datatype, unit: None };
        let values = layout.values();
        let values = values.iter().zip(layout.units());
        let values = values.map(|(name, unit)| CsvColumn { unit: Some(unit), ..CsvColumn::number(name) });
        [label, CsvColumn::text(layout.place())].into_iter().chain(values).collect()
    }

    fn json(&self) -> Value {
        let mut column = json!({"titles": self.name, "name": self.name, "datatype": self.datatype});
        if let (Some(unit), Some(column)) = (self.unit, column.as_object_mut()) {
            column.insert("schema:unitText".into(), json!(unit));
        }
        column
    }
}

/// The file beside a CSV file.
pub fn beside(csv: &Path) -> PathBuf {
    let mut name = csv.as_os_str().to_os_string();
    name.push("-metadata.json");
    PathBuf::from(name)
}

/// Writes the file beside a CSV file; gives its size in bytes.
pub fn write(csv: &Path, columns: &[CsvColumn], provenance: &Provenance) -> Result<u64> {
    let path = beside(csv);
    let mut sink = Sink::file(&path)?;
    let name = csv.file_name().unwrap_or_default().to_string_lossy();
    sink.write_all(text(&name, columns, provenance).as_bytes()).map_err(Error::io(&path, "write to"))?;
    sink.finish()
}

/// What stands in the file beside the CSV file of a name.
pub fn text(name: &str, columns: &[CsvColumn], provenance: &Provenance) -> String {
    let property = |(name, value): &(String, String)| json!({"@type": "schema:PropertyValue", "schema:name": name, "schema:value": value});
    let table = json!({
        "@context": "http://www.w3.org/ns/csvw",
        "url": url(name),
        "tableSchema": {"columns": columns.iter().map(CsvColumn::json).collect::<Vec<_>>()},
        "schema:additionalProperty": provenance.entries().iter().map(property).collect::<Vec<_>>(),
    });
    format!("{table:#}\n")
}

/// A file name as a relative URL: what RFC 3986 does not allow there is percent-encoded.
fn url(name: &str) -> String {
    let letter = |byte: u8| match byte {
        b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => char::from(byte).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::provenance;
    use crate::outputs::tables::layout::{By, Labels};
    use heliotile_core::weather::time::calendar::Date;
    use heliotile_core::weather::time::utc_offset::UtcOffset;

    /// Ten names of columns get their units and types.
    #[test]
    fn units_by_name() {
        for (name, unit) in [
            ("total_kwh_m2", Some("kWh/m2")),
            ("dni_w_m2", Some("W/m2")),
            ("error_percent", Some("%")),
            ("area", Some("m2")),
            ("x", Some("m")),
            ("nz", Some("1")),
            ("sky_view", Some("1")),
            ("distance_m", Some("m")),
            ("receiver", None),
            ("index", None),
        ] {
            let column = CsvColumn::named(name);
            assert_eq!((column.unit, column.datatype == json!("number")), (unit, unit.is_some()), "{name}");
        }
    }

    /// The file of a table of hours names it, the format of its times, the unit of its one value, and 4 properties; without instants labels
    /// are strings.
    #[test]
    fn results() {
        let components = "total".parse().expect("a name");
        let layout = Layout { labels: Labels::Times, by: By::Receiver, components, facts: Vec::new() };
        let moment = (Date::new(2019, 3, 1).expect("a date"), 0.0);
        let labels = RowLabels::moments(&[moment], UtcOffset::default(), Precision::Minute);
        let columns = CsvColumn::of_results(&layout, &labels);
        let text = text("a b.csv", &columns, &provenance::tests::example());
        let table: Value = serde_json::from_str(&text).expect("JSON");
        let columns = &table["tableSchema"]["columns"];
        assert_eq!((&table["url"], columns.as_array().map(Vec::len)), (&json!("a%20b.csv"), Some(3)));
        assert_eq!(columns[0]["datatype"]["format"], "yyyy-MM-ddTHH:mmxxx");
        assert_eq!((&columns[1]["datatype"], &columns[2]["schema:unitText"]), (&json!("string"), &json!("W/m2")));
        assert_eq!(table["schema:additionalProperty"].as_array().map(Vec::len), Some(4));
        let words = CsvColumn::of_results(&layout, &RowLabels::words(vec!["total".into()]));
        assert_eq!(words[0].datatype, json!("string"));
        assert_eq!(beside(Path::new("a/b.csv")), Path::new("a/b.csv-metadata.json"));
    }
}
