//! Maps in a format by the ending of the file name. In: places with their shapes and values. Out: a
//! file, complete or not there.

use std::path::{Path, PathBuf};

use super::columns::MapColumns;
use super::crs::MapCrs;
pub use super::glb::Surroundings;
use super::group_patches::{GroupPatches, polygons};
use super::picture::{self, Drawn};
use super::pvd::Series;
use super::row::MapPolygon;
use super::rows::{MapFacts, MapRows, RowSpool};
use super::stated::StatedColumns;
use super::{flatgeobuf, geojson, geoparquet, glb, ply, pvd, style, vtu};
use crate::outputs::groups::GroupGeometry;
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::sink::Sink;
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::layout::Layout;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;

/// File format of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MapFormat {
    /// Binary glTF 2.0.
    Glb,
    FlatGeobuf,
    GeoJson,
    /// PLY: triangles and points with colours.
    Ply,
    /// Unstructured grid of VTK.
    Vtu,
    /// Time series of VTK grids.
    Pvd,
    /// GeoParquet, `.parquet`, if requested.
    GeoParquet,
    /// Picture, by `--plot`.
    Png,
}

impl MapFormat {
    /// Formats by ending. GeoParquet is missing, as its ending is also that of a table, and so are
    /// pictures, which are no data to process further.
    pub const ENDINGS: [(&'static str, MapFormat); 6] = [
        (MapFormat::Glb.ending(), MapFormat::Glb),
        (MapFormat::FlatGeobuf.ending(), MapFormat::FlatGeobuf),
        (MapFormat::GeoJson.ending(), MapFormat::GeoJson),
        (MapFormat::Ply.ending(), MapFormat::Ply),
        (MapFormat::Vtu.ending(), MapFormat::Vtu),
        (MapFormat::Pvd.ending(), MapFormat::Pvd),
    ];

    /// Refuses coordinates that the format cannot have; `field` is the name of the request's field
    /// with the file.
    pub fn check(self, crs: &MapCrs, field: &str) -> Result<()> {
        if self != MapFormat::GeoJson || crs.has_degrees() {
            return Ok(());
        }
        let what = match crs.epsg() {
            Some(epsg) => {
                format!("GeoJSON needs latitudes, and EPSG:{epsg} is not a known coordinate system")
            }
            None => "GeoJSON needs latitudes, and the coordinate system of the scene is not known".into(),
        };
        let hint = "write .fgb, .glb or .vtu, or build the archive with {crs}, as in {crs} 28992";
        Err(Error::argument(field, what, hint).because(Problem::Lacks("place")))
    }

    /// Returns true if the format draws the scene around the map.
    pub fn shows_surroundings(self) -> bool {
        matches!(self, MapFormat::Glb | MapFormat::Png)
    }

    /// Returns true if the format holds names and numbers beside shapes.
    fn has_columns(self) -> bool {
        !matches!(self, MapFormat::Ply | MapFormat::Png)
    }

    /// Returns true if QGIS opens the format, and takes a style from beside it.
    fn is_for_gis(self) -> bool {
        matches!(self, MapFormat::FlatGeobuf | MapFormat::GeoJson | MapFormat::GeoParquet)
    }

    /// Returns true if the format has marks for places without an extent.
    pub fn shows_points(self) -> bool {
        matches!(self, MapFormat::Png | MapFormat::Ply)
    }

    /// Returns the ending of files.
    pub const fn ending(self) -> &'static str {
        match self {
            MapFormat::Glb => "glb",
            MapFormat::FlatGeobuf => "fgb",
            MapFormat::GeoJson => "geojson",
            MapFormat::Ply => "ply",
            MapFormat::Vtu => "vtu",
            MapFormat::Pvd => "pvd",
            MapFormat::GeoParquet => "parquet",
            MapFormat::Png => "png",
        }
    }
}

/// Shapes of places, in the order of their values.
pub enum PlaceShapes<'a> {
    /// Receivers with their patches.
    Receivers(Box<dyn Iterator<Item = Result<Receiver>> + 'a>),
    Groups(Box<GroupPatches>),
}

/// Contents and resources of a map, without shapes and values.
pub struct MapRequest<'a> {
    pub path: &'a Path,
    pub format: MapFormat,
    pub layout: &'a Layout,
    pub labels: &'a BinLabels,
    /// Period of a row; `None` for a query.
    pub every: Option<Every>,
    pub crs: MapCrs,
    /// North by which normals and pictures are turned.
    pub north: North,
    /// Description of the values in words, for pictures.
    pub called: String,
    /// Scene around the map, which only some formats draw.
    pub around: Option<Surroundings<'a>>,
    pub about: Provenance,
    /// Folder for temporary files that do not fit into memory.
    pub folder: PathBuf,
    pub storage: &'a dyn ScratchSpace,
    pub memory_bytes: usize,
    /// Archives whose objects have attributes.
    pub archives: Vec<&'a Archive>,
}

impl MapRequest<'_> {
    /// Returns the columns, or an error if the map cannot be written, before any work is done.
    pub fn columns(&self) -> Result<MapColumns> {
        self.format.check(&self.crs, "output")?;
        match self.format {
            MapFormat::Pvd => Ok(MapColumns::of_places(self.layout)),
            _ => MapColumns::new(self.layout, self.labels, self.every),
        }
    }
}

/// Statistics of a map that was written.
#[derive(Clone, Copy, Debug)]
pub struct MapStats {
    pub facts: MapFacts,
    pub bytes: u64,
}

/// Map being written.
pub struct MapWriter<'a> {
    request: MapRequest<'a>,
    shapes: PlaceShapes<'a>,
    columns: MapColumns,
    stated: StatedColumns,
    rows: RowSpool,
    series: Option<Series>,
}

impl<'a> MapWriter<'a> {
    /// Starts a map; has the errors of [`MapRequest::columns`].
    pub fn create(request: MapRequest<'a>, shapes: PlaceShapes<'a>) -> Result<Self> {
        let columns = request.columns()?;
        let archives = request.archives.iter().copied().filter(|_| request.format.has_columns());
        let stated = StatedColumns::new(archives, &columns.names())?;
        let columns = columns.stating(&stated);
        let rows = RowSpool::new(&request.folder, request.memory_bytes, &columns);
        let series = match request.format {
            MapFormat::Pvd => Some(Series::new(request.layout, request.labels, request.storage)?),
            _ => None,
        };
        Ok(MapWriter { request, shapes, columns, stated, rows, series })
    }

    /// Appends some places, as [`crate::outputs::row_maker::RowMaker::write`] does.
    pub fn write_tile(&mut self, names: &[String], values: &PlaceValues, extents: &[GroupGeometry]) -> Result<()> {
        for (i, name) in names.iter().enumerate() {
            let (common, extent, polygons) = match &mut self.shapes {
                PlaceShapes::Groups(groups) => {
                    let (common, polygons) = groups.next_group()?;
                    let Some(extent) = extents.get(i).copied() else {
                        let what = format!("{} extents come with {} values", extents.len(), names.len());
                        return Err(Error::defect(self.request.path, "map", "extents", what));
                    };
                    (common, extent, polygons)
                }
                PlaceShapes::Receivers(receivers) => {
                    let Some(receiver) = receivers.next().transpose()?.filter(|receiver| receiver.id == *name) else {
                        let what = format!("values of {name} come where another receiver's belong");
                        return Err(Error::defect(self.request.path, "map", "rows", what));
                    };
                    let polygons = polygons(&receiver).unwrap_or_else(|| vec![MapPolygon::point(receiver.position)]);
                    let extent = GroupGeometry::new(&receiver, self.request.north);
                    (receiver, extent, polygons)
                }
            };
            let drawn_m2 = || polygons.iter().map(MapPolygon::area_m2).sum();
            let area_m2 = extent.area_m2.unwrap_or_else(drawn_m2);
            let mut row = self.columns.row(name, &common, &extent, area_m2, values, i);
            row.texts.extend(self.stated.row(&common.part));
            row.polygons = polygons;
            self.rows.push(&row)?;
        }
        self.series.as_mut().map_or(Ok(()), |series| series.add(values))
    }

    /// Completes the map; its file appears only now.
    pub fn finish(self) -> Result<MapStats> {
        let MapWriter { request, columns, rows, series, .. } = self;
        let mut rows: MapRows = rows.finish()?;
        let (rows, columns, crs, about) = (&mut rows, &columns, &request.crs, &request.about);
        let sink = || Sink::file(request.path);
        let bytes = match (request.format, &series) {
            (MapFormat::Glb, _) => glb::write(sink()?, rows, columns, crs, request.around.as_ref(), about)?,
            (MapFormat::FlatGeobuf, _) => flatgeobuf::write(sink()?, rows, columns, crs, about)?,
            (MapFormat::GeoJson, _) => geojson::write(sink()?, rows, columns, crs, about)?,
            (MapFormat::GeoParquet, _) => geoparquet::write(sink()?, rows, columns, crs, about)?,
            (MapFormat::Ply, _) => ply::write(sink()?, rows, columns, about)?,
            (MapFormat::Pvd, Some(series)) => pvd::write(request.path, rows, columns, series, about)?,
            (MapFormat::Png, _) => {
                let unit = request.layout.unit_of(request.layout.main_quantity());
                let around = request.around.as_ref();
                let title = request.layout.title();
                let drawn = Drawn { around, north: request.north, title, called: &request.called, unit };
                picture::write(sink()?, rows, columns, &drawn, about)?
            }
            (MapFormat::Vtu | MapFormat::Pvd, _) => vtu::write(sink()?, rows, columns, None, about)?,
        };
        if request.format.is_for_gis() {
            style::write(request.path, rows, columns)?;
        }
        Ok(MapStats { facts: rows.facts, bytes })
    }
}
