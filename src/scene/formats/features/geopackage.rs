//! In: a GeoPackage (OGC 12-128r19), which is an SQLite database. Out: the features of its feature
//! tables. SQLite reads the file itself, without writing.

use std::path::Path;

use geozero::GeozeroGeometry;
use geozero::wkb::GpkgWkb;
use heliotile_core::error::{Error, Result};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};
use serde_json::{Map, Value, json};

use super::feature::{Feature, TakeFeature};
use super::shapes::Shapes;
use super::system::FeatureSystem;
use crate::text::excerpt;

/// A table of features.
struct Table {
    name: String,
    /// Name of its geometry column.
    geometry: String,
    system: FeatureSystem,
}

pub(super) fn read(file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let wrong = |error: rusqlite::Error| {
        let text = error.to_string();
        let what = format!("the file cannot be read as a GeoPackage: {}", excerpt(text.as_bytes()));
        Error::input(file, None, what, "unpack or export the file again: it is damaged, packed or not a GeoPackage")
    };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database = Connection::open_with_flags(file, flags).map_err(wrong)?;
    let tables = tables(&database).map_err(wrong)?;
    let Some(first) = tables.first() else {
        let hint = "export a layer of outlines of buildings as GeoPackage";
        return Err(Error::input(file, None, "the GeoPackage has no table of features", hint));
    };
    // The features become one geometry, which has one coordinate system.
    if let Some(other) = tables.iter().find(|table| table.system != first.system) {
        let what = format!(
            "its tables `{}` and `{}` have different coordinate systems",
            excerpt(first.name.as_bytes()),
            excerpt(other.name.as_bytes())
        );
        return Err(Error::input(file, None, what, "export the layer of buildings by itself"));
    }
    for table in &tables {
        read_table(&database, table, file, take, &wrong)?;
    }
    Ok(first.system.clone())
}

fn tables(database: &Connection) -> rusqlite::Result<Vec<Table>> {
    let mut query = database.prepare(
        "SELECT c.table_name, g.column_name, upper(coalesce(s.organization, '')), s.organization_coordsys_id, coalesce(s.definition, '') \
         FROM gpkg_contents c JOIN gpkg_geometry_columns g ON g.table_name = c.table_name \
         LEFT JOIN gpkg_spatial_ref_sys s ON s.srs_id = g.srs_id \
         WHERE c.data_type = 'features' ORDER BY c.table_name",
    )?;
    let rows = query.query_map([], |row| {
        let (organization, code, text): (String, Option<i64>, String) = (row.get(2)?, row.get(3)?, row.get(4)?);
        let number = code.filter(|_| organization == "EPSG").and_then(|code| u32::try_from(code).ok());
        let system = match number.filter(|number| *number > 0) {
            Some(epsg) => FeatureSystem::of_epsg(epsg),
            None => FeatureSystem::of_text(&text),
        };
        Ok(Table { name: row.get(0)?, geometry: row.get(1)?, system })
    })?;
    rows.collect()
}

fn read_table(
    database: &Connection,
    table: &Table,
    file: &Path,
    take: &mut TakeFeature,
    wrong: &dyn Fn(rusqlite::Error) -> Error,
) -> Result<()> {
    // The name comes from the file: quoting keeps it from being read as SQL.
    let quoted = table.name.replace('"', "\"\"");
    let mut query = database.prepare(&format!("SELECT * FROM \"{quoted}\"")).map_err(wrong)?;
    let names: Vec<String> = query.column_names().map(str::to_owned).collect();
    let mut rows = query.query([]).map_err(wrong)?;
    while let Some(row) = rows.next().map_err(wrong)? {
        let mut feature = Feature::default();
        let mut attributes = Map::new();
        for (number, name) in names.iter().enumerate() {
            let value = row.get_ref(number).map_err(wrong)?;
            match value {
                ValueRef::Blob(bytes) if *name == table.geometry => {
                    let mut shapes = Shapes::default();
                    GpkgWkb(bytes).process_geom(&mut shapes).map_err(|error| {
                        let text = error.to_string();
                        let what = format!(
                            "a geometry of table `{}` cannot be read: {}",
                            excerpt(table.name.as_bytes()),
                            excerpt(text.as_bytes())
                        );
                        Error::input(file, None, what, "export the layer again, with polygons of straight sides")
                    })?;
                    shapes.fill(&mut feature);
                }
                ValueRef::Integer(number) => drop(attributes.insert(name.clone(), json!(number))),
                ValueRef::Real(number) => drop(attributes.insert(name.clone(), json!(number))),
                ValueRef::Text(text) => {
                    attributes.insert(name.clone(), Value::String(String::from_utf8_lossy(text).into_owned()));
                }
                ValueRef::Null | ValueRef::Blob(_) => {}
            }
        }
        feature.attributes = attributes;
        take(feature)?;
    }
    Ok(())
}
