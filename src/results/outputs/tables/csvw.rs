//! Metadata of a CSV file, in `NAME.csv-metadata.json` beside it. In: its columns, provenance and
//! hash. Out: JSON where programs for CSV on the Web look for it; and such a file read back.
//!
//! Format: W3C recommendation "Metadata Vocabulary for Tabular Data", 2015. It has no term for
//! units, which are written as `schema:unitText`, nor for provenance, which is a list of
//! `schema:additionalProperty`. Both terms are from schema.org, whose prefix the vocabulary
//! defines.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use blake3::{Hash, Hasher};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::bin_labels::{Instants, Precision};
use crate::outputs::tables::column::{Column, Kind};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::message;

/// Name of the property that holds the BLAKE3 hash of the table.
const TABLE_HASH: &str = "heliotile.table_blake3";

/// Table as its metadata file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DescribedTable {
    /// Path of the table.
    pub file: PathBuf,
    /// Columns in order.
    pub columns: Vec<DescribedColumn>,
    /// Provenance: names with their prefix, and values.
    pub about: Vec<(String, String)>,
    /// BLAKE3 hash of the table, hexadecimal.
    pub hash: String,
}

/// Column as a metadata file describes it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct DescribedColumn {
    /// Name of the column.
    pub name: String,
    /// Unit of its values; empty if they have none.
    #[serde(rename = "schema:unitText", default)]
    pub unit: String,
    /// Type of its values: `number`, `string`, or one of times.
    #[serde(default)]
    pub datatype: Value,
}

#[derive(Deserialize)]
struct Metadata {
    #[serde(rename = "tableSchema")]
    schema: Schema,
    #[serde(rename = "schema:additionalProperty")]
    about: Vec<Property>,
}

#[derive(Deserialize)]
struct Schema {
    columns: Vec<DescribedColumn>,
}

#[derive(Deserialize)]
struct Property {
    #[serde(rename = "schema:name")]
    name: String,
    #[serde(rename = "schema:value")]
    value: String,
}

/// Reads the metadata file beside a CSV file, and compares the hash in it with the table.
pub fn read(csv: &Path) -> Result<DescribedTable> {
    let path = beside(csv);
    if !path.is_file() {
        let what = format!("has no {} beside it, so nothing says how it was made", name_of(&path));
        let hint = "give a CSV table that heliotile wrote, with the metadata file that it wrote beside it";
        return Err(Error::input(csv, None, what, hint).because(Problem::Lacks("metadata")));
    }
    let text = fs::read_to_string(&path).map_err(Error::io(&path, "read"))?;
    let unknown = |what: String| {
        Error::input(&path, None, what, "write the table again with heliotile").because(Problem::Lacks("metadata"))
    };
    let Metadata { schema, about } =
        serde_json::from_str(&text).map_err(|error| unknown(format!("is no metadata of heliotile: {error}")))?;
    let about: Vec<(String, String)> = about.into_iter().map(|one| (one.name, one.value)).collect();
    let stated = about.iter().find(|(name, _)| name == TABLE_HASH).map(|(_, hash)| hash.clone());
    let stated = stated.ok_or_else(|| unknown("states no hash of the table".into()))?;
    let file = File::open(csv).map_err(Error::io(csv, "read"))?;
    let hash = Hasher::new().update_reader(file).map_err(Error::io(csv, "read"))?.finalize().to_hex().to_string();
    if hash != stated {
        let command = about.iter().find(|(name, _)| name == "heliotile.command").map(|(_, command)| command.as_str());
        let what = message!("was changed since heliotile wrote it: its hash is not that in {}", name_of(&path));
        let hint = format!("write it again: {}", command.unwrap_or("with heliotile"));
        return Err(Error::input(csv, None, what, hint).because(Problem::Damaged));
    }
    Ok(DescribedTable { file: csv.to_path_buf(), columns: schema.columns, about, hash })
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the description of a column.
fn described(column: &Column) -> Value {
    let datatype = match (column.instants(), column.kind) {
        (Some(instants), _) => datatype_of(instants),
        (None, Kind::Text | Kind::Category) => json!("string"),
        (None, Kind::Count | Kind::Number(_) | Kind::Float(_)) => json!("number"),
    };
    let mut said = json!({"titles": column.name, "name": column.name, "datatype": datatype});
    if let (Some(unit), Some(said)) = (column.unit, said.as_object_mut()) {
        said.insert("schema:unitText".into(), json!(unit));
    }
    said
}

/// Returns the data type of times, by the precision of their text.
fn datatype_of(instants: &Instants) -> Value {
    match instants.precision {
        Precision::Year => json!("gYear"),
        Precision::Month => json!("gYearMonth"),
        Precision::Day => json!("date"),
        Precision::Minute => json!({"base": "datetime", "format": "yyyy-MM-ddTHH:mmxxx"}),
        Precision::Second => json!({"base": "datetime", "format": "yyyy-MM-ddTHH:mm:ssxxx"}),
    }
}

/// Returns the path of the metadata file beside a CSV file.
pub fn beside(csv: &Path) -> PathBuf {
    let mut name = csv.as_os_str().to_os_string();
    name.push("-metadata.json");
    PathBuf::from(name)
}

/// Writes the metadata file beside a CSV file and returns its size in bytes.
pub fn write(csv: &Path, columns: &[Column], provenance: &Provenance, hash: Hash) -> Result<u64> {
    let path = beside(csv);
    let mut sink = Sink::file(&path)?;
    sink.write_all(text(&name_of(csv), columns, provenance, hash).as_bytes()).map_err(Error::io(&path, "write to"))?;
    sink.finish()
}

/// Returns the contents of the metadata file of a CSV file with this name and hash.
pub fn text(name: &str, columns: &[Column], provenance: &Provenance, hash: Hash) -> String {
    let property = |(name, value): &(String, String)| json!({"@type": "schema:PropertyValue", "schema:name": name, "schema:value": value});
    let mut about = provenance.entries();
    about.push((TABLE_HASH.into(), hash.to_hex().to_string()));
    let table = json!({
        "@context": "http://www.w3.org/ns/csvw",
        "url": url(name),
        "tableSchema": {"columns": columns.iter().map(described).collect::<Vec<_>>()},
        "schema:additionalProperty": about.iter().map(property).collect::<Vec<_>>(),
    });
    format!("{table:#}\n")
}

/// Returns a file name as a relative URL, with characters that RFC 3986 does not allow
/// percent-encoded.
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
    use crate::outputs::tables::bin_labels::BinLabels;
    use crate::outputs::tables::layout::{BinKind, By, Layout};
    use heliotile_core::weather::time::calendar::Date;
    use heliotile_core::weather::time::utc_offset::UtcOffset;

    /// The metadata file of a table of hours has the table's name, the format of its times, the
    /// unit of its one value, and 5 properties. Labels without instants are strings.
    #[test]
    fn metadata_describe_columns_and_units() {
        let layout = Layout::of_components(BinKind::Times, By::Receiver, &"total".parse().expect("a name"));
        let moment = (Date::new(2019, 3, 1).expect("a date"), 0.0);
        let labels = BinLabels::moments(&[moment], UtcOffset::default(), Precision::Minute);
        let columns = layout.columns(&labels);
        let text = text("a b.csv", columns.all(), &provenance::tests::example(), blake3::hash(b""));
        let table: Value = serde_json::from_str(&text).expect("JSON");
        let columns = &table["tableSchema"]["columns"];
        assert_eq!((&table["url"], columns.as_array().map(Vec::len)), (&json!("a%20b.csv"), Some(3)));
        assert_eq!(columns[0]["datatype"]["format"], "yyyy-MM-ddTHH:mmxxx");
        assert_eq!((&columns[1]["datatype"], &columns[2]["schema:unitText"]), (&json!("string"), &json!("W/m2")));
        assert_eq!(table["schema:additionalProperty"].as_array().map(Vec::len), Some(5));
        let words = layout.columns(&BinLabels::words(vec!["total".into()]));
        assert_eq!(described(&words.all()[0])["datatype"], json!("string"));
        assert_eq!(beside(Path::new("a/b.csv")), Path::new("a/b.csv-metadata.json"));
    }
}
