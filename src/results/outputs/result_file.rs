//! Results as a table or a map, by the ending of the file name. In: values of places. Out: a file,
//! complete or not there.

use std::path::Path;

use crate::outputs::groups::GroupGeometry;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::row_maker::RowMaker;
use crate::outputs::shapes::writer::{MapFormat, MapStats, MapWriter};
use crate::outputs::tables::format::Format;
use crate::outputs::tables::table::Table;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::message;

/// File format of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultFormat {
    /// Table.
    Table(Format),
    /// Map.
    Map(MapFormat),
}

impl ResultFormat {
    /// Returns the format by the ending of a name; `geo` makes Parquet a map.
    pub fn by_ending(path: &Path, geo: bool) -> Result<Self> {
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let map = MapFormat::ENDINGS.iter().find(|(name, _)| ending.as_deref() == Some(name));
        match (map, Format::known(path)) {
            (Some((_, format)), _) => Ok(ResultFormat::Map(*format)),
            (None, Some(Format::Parquet)) if geo => Ok(ResultFormat::Map(MapFormat::GeoParquet)),
            (None, Some(format)) if !geo => Ok(ResultFormat::Table(format)),
            (None, Some(_)) => Err(Error::argument(
                "geo",
                format!("`{}` does not end with .parquet", path.display()),
                "leave it out, or give a name that ends with .parquet",
            )
            .because(Problem::Ending)),
            (None, None) => {
                let maps: Vec<String> = MapFormat::ENDINGS.iter().map(|(ending, _)| format!(".{ending}")).collect();
                Err(Error::Unsupported {
                    what: "ending of the output file".into(),
                    found: format!("`{}`", path.display()),
                    supported: message!(
                        "tables: {}; maps: {} and, with {{geo}}, .parquet; pictures, with {{plot}}: .png, .svg",
                        Format::listed(),
                        maps.join(", ")
                    ),
                })
            }
        }
    }
}

/// Results being written.
pub enum ResultFile<'a> {
    Table(&'a RowMaker, Table),
    Map(Box<MapWriter<'a>>),
}

impl ResultFile<'_> {
    /// Appends the rows of some places; `extents` has one entry for each group and is empty for
    /// receivers.
    pub fn write_tile(&mut self, names: &[String], values: &PlaceValues, extents: &[GroupGeometry]) -> Result<()> {
        match self {
            ResultFile::Table(rows, table) => rows.write(table, names, values, extents),
            ResultFile::Map(map) => map.write_tile(names, values, extents),
        }
    }

    /// Returns true if the reader of the output has gone away: the caller may stop.
    pub fn is_closed(&self) -> bool {
        matches!(self, ResultFile::Table(_, table) if table.is_closed())
    }

    /// Completes the file, which appears only now. Returns the statistics of a map.
    pub fn finish(self) -> Result<Option<MapStats>> {
        match self {
            ResultFile::Table(_, table) => table.finish().map(|_| None),
            ResultFile::Map(map) => map.finish().map(Some),
        }
    }
}
