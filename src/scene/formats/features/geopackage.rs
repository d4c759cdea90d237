//! In: a GeoPackage (OGC 12-128r19), which is an SQLite database. Out: the features of its feature
//! tables. SQLite reads the file itself, without writing anything beside it.
//!
//! A database may hold SQL, which the file's author wrote. Only stored columns of real tables are
//! read, which runs none of it; limits of length, memory and steps hold against damaged files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use geozero::GeozeroGeometry;
use geozero::wkb::GpkgWkb;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::with_list;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};
use serde_json::{Map, Value, json};

use super::feature::{Feature, TakeFeature};
use super::layers;
use super::shapes::{Shapes, unreadable};
use super::system::FeatureSystem;
use crate::formats::ReadOptions;
use crate::text::excerpt;

/// Longest text, geometry or row, bytes: a geometry of 5 million corners.
const LONGEST: i32 = 128 << 20;
/// Most bytes that SQLite may hold.
const MAX_HELD: u64 = 512 << 20;
/// Most steps of SQLite's virtual machine, in thousands, before the next row: a row takes three
/// steps and one a column.
const MAX_KILOSTEPS: u64 = 20_000;

/// Longest head of a write-ahead log that holds no change, bytes.
const EMPTY_LOG: u64 = 32;

/// Bytes of a path that a URI of SQLite may hold as they are.
const PLAIN: AsciiSet = NON_ALPHANUMERIC.remove(b'/').remove(b'.').remove(b'-').remove(b'_').remove(b'~');

const EXPORT: &str = "export a layer of outlines of buildings as GeoPackage";

/// A table of features.
struct Table {
    name: String,
    /// Name of its geometry column.
    geometry: String,
    system: FeatureSystem,
}

/// A database of a stranger, opened so that it cannot write, compute or grow.
struct Database {
    connection: Connection,
    /// Thousands of steps since the last row.
    kilosteps: Arc<AtomicU64>,
}

impl Database {
    fn open(file: &Path) -> rusqlite::Result<Self> {
        // `immutable`: SQLite takes no lock and makes no files beside the database.
        let whole = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        let path = percent_encode(whole.as_os_str().as_encoded_bytes(), &PLAIN).to_string();
        let path = if cfg!(windows) { format!("/{}", path.replace("%5C", "/").replace("%3A", ":")) } else { path };
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
        let mut connection = Connection::open_with_flags(format!("file://{path}?mode=ro&immutable=1"), flags)?;
        connection.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
        connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
        connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, LONGEST)?;
        connection.set_limit(Limit::SQLITE_LIMIT_ATTACHED, 0)?;
        connection.query_row(&format!("PRAGMA hard_heap_limit = {MAX_HELD}"), [], |_| Ok(()))?;
        let kilosteps = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&kilosteps);
        let is_too_long = move || counted.fetch_add(1, Ordering::Relaxed) >= MAX_KILOSTEPS;
        connection.progress_handler(1000, Some(is_too_long))?;
        Ok(Database { connection, kilosteps })
    }

    /// Returns true if `name` is a table whose rows are stored: neither a view nor a virtual table,
    /// which have no page.
    fn is_stored(&self, name: &str) -> rusqlite::Result<bool> {
        let query = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND rootpage > 0 \
                     AND name = ?1 COLLATE NOCASE";
        self.connection.query_row(query, [name], |row| row.get(0)).map(|count: u32| count > 0)
    }

    /// Returns the names of the columns of a table, and whether the values of each are stored.
    fn columns(&self, table: &str) -> rusqlite::Result<Vec<(String, bool)>> {
        // Values of virtual generated columns (2) are computed when they are read.
        let mut query = self.connection.prepare("SELECT name, hidden <> 2 FROM pragma_table_xinfo(?1)")?;
        let rows = query.query_map([table], |row| Ok((row.get(0)?, row.get(1)?)))?;
        rows.collect()
    }
}

/// Reads the features of the layers that `asked` names, or that hold buildings.
pub(super) fn read(file: &Path, asked: &ReadOptions, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let wrong = |error: rusqlite::Error| {
        let text = error.to_string();
        let what = format!("the file cannot be read as a GeoPackage: {}", excerpt(text.as_bytes()));
        Error::input(file, None, what, "unpack or export the file again: it is damaged, packed or not a GeoPackage")
    };
    refuse_log(file)?;
    let database = Database::open(file).map_err(wrong)?;
    for name in ["gpkg_contents", "gpkg_geometry_columns", "gpkg_spatial_ref_sys"] {
        let is_plain = |(_, is_stored): &(String, bool)| *is_stored;
        if !database.is_stored(name).map_err(wrong)? || !database.columns(name).map_err(wrong)?.iter().all(is_plain) {
            return Err(Error::input(file, None, format!("the GeoPackage has no plain table `{name}`"), EXPORT));
        }
    }
    let (mut stored, mut unread) = (Vec::new(), Vec::new());
    for table in tables(&database).map_err(wrong)? {
        match database.is_stored(&table.name).map_err(wrong)? {
            true => stored.push(table),
            false => unread.push(table.name),
        }
    }
    let names: Vec<String> = stored.iter().map(|table| table.name.clone()).collect();
    let chosen = layers::chosen(&names, &asked.footprints.layer, asked.lod.as_deref())
        .map_err(|what| Error::input(file, None, what, "give the name of one of its layers as {layer}"))?;
    stored.retain(|table| chosen.read.contains(&table.name));
    let Some(first) = stored.first() else {
        let Some(view) = unread.first() else {
            return Err(Error::input(file, None, "the GeoPackage has no table of features", EXPORT));
        };
        let what = format!("its layer `{}` is a view, whose SQL is not run", excerpt(view.as_bytes()));
        return Err(Error::input(file, None, what, "export the layer as a table of a new GeoPackage"));
    };
    // The features become one geometry, which has one coordinate system.
    if let Some(other) = stored.iter().find(|table| table.system != first.system) {
        let what = format!(
            "its tables `{}` and `{}` have different coordinate systems",
            excerpt(first.name.as_bytes()),
            excerpt(other.name.as_bytes())
        );
        return Err(Error::input(file, None, what, "export the layer of buildings by itself"));
    }
    let mut computed = Vec::new();
    for table in &stored {
        computed.extend(read_table(&database, table, take, &wrong)?);
    }
    let list = |things: &str, names: Vec<String>| {
        let quoted = names.iter().map(|name| format!("`{}`", excerpt(name.as_bytes())));
        (!names.is_empty())
            .then(|| with_list(format!("{things} are left out, because SQL of a file is not run"), quoted))
    };
    let views = list("layers that are views", unread);
    let computed = list("computed columns", computed);
    let doubts = chosen.said().into_iter().chain(views).chain(computed).collect();
    Ok(FeatureSystem { doubts, ..first.system.clone() })
}

/// Refuses a database whose newest changes lie in another file: SQLite would have to write to read
/// them.
fn refuse_log(file: &Path) -> Result<()> {
    let mut name = file.as_os_str().to_owned();
    name.push("-wal");
    let log = PathBuf::from(name);
    if std::fs::metadata(&log).is_ok_and(|found| found.len() > EMPTY_LOG) {
        let what = format!("its newest changes lie beside it in {}", log.display());
        let hint = "close the program that has it open, which moves them into the file, or export the layer again";
        return Err(Error::input(file, None, what, hint));
    }
    Ok(())
}

fn tables(database: &Database) -> rusqlite::Result<Vec<Table>> {
    let mut query = database.connection.prepare(
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

/// Reads the features of a table; returns the names of its columns that are computed.
fn read_table(
    database: &Database,
    table: &Table,
    take: &mut TakeFeature,
    wrong: &dyn Fn(rusqlite::Error) -> Error,
) -> Result<Vec<String>> {
    let (stored, computed): (Vec<_>, Vec<_>) =
        database.columns(&table.name).map_err(wrong)?.into_iter().partition(|(_, is_stored)| *is_stored);
    let [names, computed] = [stored, computed].map(|list| list.into_iter().map(|(name, _)| name).collect::<Vec<_>>());
    // Names come from the file: quoting keeps them from being read as SQL.
    let quoted = |name: &String| format!("\"{}\"", name.replace('"', "\"\""));
    let columns = names.iter().map(quoted).collect::<Vec<_>>().join(", ");
    let query = format!("SELECT {columns} FROM {} NOT INDEXED", quoted(&table.name));
    let mut query = database.connection.prepare(&query).map_err(wrong)?;
    let mut rows = query.query([]).map_err(wrong)?;
    while let Some(row) = rows.next().map_err(wrong)? {
        database.kilosteps.store(0, Ordering::Relaxed);
        let mut feature = Feature::default();
        let mut attributes = Map::new();
        for (number, name) in names.iter().enumerate() {
            let value = row.get_ref(number).map_err(wrong)?;
            match value {
                ValueRef::Blob(bytes) if *name == table.geometry => {
                    let mut shapes = Shapes::default();
                    match GpkgWkb(bytes).process_geom(&mut shapes) {
                        Ok(()) => shapes.fill(&mut feature),
                        Err(error) => feature.unreadable = Some(unreadable(&error)),
                    }
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
    Ok(computed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polygon of 10 x 10 m with GeoPackage's header, as SQL writes it.
    const HOUSE: &str = "X'47500001407100000103000000010000000500000000000000000000000000000000000000000000000000244000000000000000000000000000002440000000000000244000000000000000000000000000002440000000000000000000000000000000\
                         00'";

    /// Writes a GeoPackage whose only layer `t` is what `sql` makes; returns its folder and path.
    fn written(sql: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t #1%.gpkg");
        let database = Connection::open(&path).expect("made");
        let catalogue = "CREATE TABLE gpkg_spatial_ref_sys(srs_name, srs_id PRIMARY KEY, organization, organization_coordsys_id, definition);
             CREATE TABLE gpkg_contents(table_name, data_type);
             CREATE TABLE gpkg_geometry_columns(table_name, column_name, srs_id);
             INSERT INTO gpkg_contents VALUES('t', 'features'); INSERT INTO gpkg_geometry_columns VALUES('t', 'geom', 1);";
        database.execute_batch(&format!("{catalogue}{sql}")).expect("written");
        (folder, path)
    }

    /// Number of corners of a feature, and its attributes as JSON.
    type Read = (usize, String);

    /// Reads a GeoPackage; returns the corners and attributes of its features, and what was not
    /// read.
    fn read_all(path: &Path) -> Result<(Vec<Read>, Vec<String>)> {
        let mut found = Vec::new();
        let system = read(path, &ReadOptions::default(), &mut |feature: Feature| {
            let corners = feature.polygons.iter().flatten().map(Vec::len).sum();
            found.push((corners, Value::Object(feature.attributes).to_string()));
            Ok(())
        })?;
        Ok((found, system.doubts.iter().map(|said| said.plain()).collect()))
    }

    /// Three layers that are SQL, an endless query, 900 MB of zeros and a search by letters, are
    /// refused by name; a table beside a view is read, and so are the stored columns beside one
    /// that is computed.
    #[test]
    fn sql_of_strangers_does_not_run() {
        let endless = format!(
            "CREATE VIEW t AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x AS fid, {HOUSE} AS geom FROM c"
        );
        let zeros = "CREATE VIEW t AS SELECT 1 AS fid, zeroblob(900000000) AS geom, 9.0 AS height".to_owned();
        let search = "CREATE VIRTUAL TABLE t USING fts3(geom)".to_owned();
        for sql in [endless, zeros, search] {
            let (_folder, path) = written(&sql);
            let message = read_all(&path).expect_err("no table").to_string();
            assert!(message.contains("its layer `t` is a view, whose SQL is not run"), "{message}");
        }
        let table = format!(
            "CREATE TABLE t(fid INTEGER PRIMARY KEY, geom, height, zeros AS (zeroblob(900000000)));
             INSERT INTO t(geom, height) VALUES({HOUSE}, 9.5);
             CREATE VIEW v AS SELECT * FROM t; INSERT INTO gpkg_contents VALUES('v', 'features');
             INSERT INTO gpkg_geometry_columns VALUES('v', 'geom', 1);"
        );
        let (_folder, path) = written(&table);
        let (found, unread) = read_all(&path).expect("a table");
        assert_eq!(found, [(5, "{\"fid\":1,\"height\":9.5}".to_owned())]);
        assert!(unread.len() == 2 && unread[0].contains("layers that are views") && unread[1].contains("`zeros`"));
    }

    /// A database in WAL mode is read with 1 file in its folder before and after; one whose changes
    /// lie in its log is refused.
    #[test]
    fn nothing_is_written_beside_a_geopackage() {
        let table = format!("CREATE TABLE t(geom, height); INSERT INTO t VALUES({HOUSE}, 9);");
        let (folder, path) = written(&format!("PRAGMA journal_mode = WAL; {table}"));
        let files = || std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(files(), 1);
        assert_eq!(read_all(&path).expect("readable").0.len(), 1);
        assert_eq!(files(), 1);
        let editor = Connection::open(&path).expect("open");
        editor.execute_batch("INSERT INTO t SELECT * FROM t").expect("a change");
        let message = read_all(&path).expect_err("a log").to_string();
        assert!(message.contains("newest changes lie beside it") && message.contains("-wal"), "{message}");
        drop(editor);
        assert_eq!((read_all(&path).expect("closed").0.len(), files()), (2, 1));
    }
}
