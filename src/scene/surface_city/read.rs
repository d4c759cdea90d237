//! Files of rasters as a city. In: a part of a site that is a raster of surface heights, already
//! read, and its companions, not yet read. Out: the city in its place, and terrain where the raster
//! of the ground goes on beyond it.

use std::path::Path;

use glam::{DVec2, DVec3};

use crate::formats::{Content, ReadOptions, read};
use crate::geometry::Geometry;
use crate::placing::frame::SiteFrame;
use crate::region_part::RegionPart;
use crate::site::Part;
use crate::surface_city::finer::is_finer;
use crate::surface_city::layers::{Companions, Layer, MAX_CELLS, check_place};
use crate::surface_city::{City, city};
use crate::surface_rasters::SurfaceRasters;
use crate::terrain::raster::{Grid, Raster};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_place::reference::Reference;

/// Depth of terrain below the edge of a city, metres, so that the ground of the city hides it.
const BELOW_EDGE_M: f32 = 0.5;

/// Margin around the halo of a region part that is read from a raster too large for one city,
/// metres: buildings on the edge of the halo stay whole.
const MARGIN_M: f64 = 100.0;

/// Terrain beyond a city, in its place.
pub(crate) struct Beyond {
    pub part: Part,
    pub raster: Raster,
}

/// A city, and the terrain beyond it.
pub(crate) struct SurfaceRead {
    pub city: City,
    pub beyond: Option<Beyond>,
}

/// Kind of the values of a raster.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Values {
    /// Heights above sea level.
    Heights,
    /// Heights above the ground.
    Differences,
    /// Codes of classes.
    Codes,
}

/// Reads the companions of a raster of surface heights and makes a city of all.
pub(crate) fn read_surface(
    part: &Part,
    dsm: Raster,
    options: &SurfaceRasters,
    frame: &SiteFrame,
    system: Option<Reference>,
    within: Option<&RegionPart>,
) -> Result<SurfaceRead> {
    let Rasters { dsm, with, warnings } = placed(part, dsm, options, frame, system)?;
    let dsm = match within {
        Some(within) if cells(&dsm, &with) > MAX_CELLS => around(dsm, within)?,
        _ => dsm,
    };
    let mut city = city(&dsm, &with, options)?;
    city.geometry.warnings.splice(0..0, warnings);
    let beyond = with.dem.and_then(|dem| beyond(part, &dsm.raster, dem));
    Ok(SurfaceRead { city, beyond })
}

/// Returns the objects of a raster of any size, read in windows of `side` cells. An object on the
/// edge of a window is in two of them.
pub(crate) fn windows_of(
    part: &Part,
    dsm: Raster,
    options: &SurfaceRasters,
    frame: &SiteFrame,
    side: usize,
) -> Result<Vec<Geometry>> {
    let Rasters { dsm, with, .. } = placed(part, dsm, options, frame, None)?;
    let Grid { columns, rows, .. } = dsm.raster.grid;
    let mut found = Vec::new();
    for row in (0..rows).step_by(side) {
        for column in (0..columns).step_by(side) {
            // The last line of a window is the first one of the next, so that no line is left
            // alone.
            let window = dsm.raster.cut(column..column + side + 1, row..row + side + 1);
            let known = window.filter(|raster| raster.heights.iter().any(|height| !height.is_nan()));
            if let Some(raster) = known {
                found.push(city(&Layer { file: dsm.file, raster }, &with, options)?.geometry);
            }
        }
    }
    Ok(found)
}

/// Returns the number of cells of the finest grid of a city.
fn cells(dsm: &Layer, with: &Companions) -> u64 {
    let finer = with.canopy.as_ref().filter(|canopy| is_finer(canopy, &dsm.raster.grid));
    [Some(dsm), finer].into_iter().flatten().map(|layer| layer.raster.heights.len() as u64).fold(0, u64::max)
}

/// Returns the part of a surface that receivers in a part of a region may see.
fn around<'a>(dsm: Layer<'a>, within: &RegionPart) -> Result<Layer<'a>> {
    let margin = within.halo_m + MARGIN_M;
    let [columns, rows] = dsm.raster.window(within.low - margin, within.high + margin);
    match dsm.raster.cut(columns, rows) {
        Some(raster) => Ok(Layer { raster, ..dsm }),
        None => Err(Error::input(dsm.file, None, "has no cell around the part of the region", "cut the region again")),
    }
}

/// Rasters in their places.
struct Rasters<'a> {
    dsm: Layer<'a>,
    with: Companions<'a>,
    warnings: Vec<Message>,
}

/// Reads the companions of a raster of surface heights and brings all to their places.
fn placed<'a>(
    part: &'a Part,
    dsm: Raster,
    options: &'a SurfaceRasters,
    frame: &SiteFrame,
    system: Option<Reference>,
) -> Result<Rasters<'a>> {
    let system = part.reference.or(frame.references()[0]).or(system);
    let mut warnings = Vec::new();
    let place = |raster: Raster, file: &Path, values: Values| -> Result<Raster> {
        // Differences and codes are no heights above sea level: vertical offsets do not apply to
        // them.
        let level = values == Values::Heights;
        let own = Part {
            file: file.to_owned(),
            offset: if level { part.offset } else { DVec3::new(part.offset.x, part.offset.y, 0.0) },
            elevation_m: part.elevation_m.filter(|_| level),
            ..part.clone()
        };
        // Placing a raster scales its values, which codes must keep.
        let codes = (values == Values::Codes).then(|| raster.heights.clone());
        let mut placed = raster.placed(&own, frame, system)?;
        if let Some(codes) = codes {
            placed.heights = codes;
        }
        Ok(placed)
    };
    let mut layer = |file: &'_ Option<std::path::PathBuf>, values: Values| -> Result<Option<Raster>> {
        let Some(file) = file else { return Ok(None) };
        let Content::Terrain(raster) = read(file, &ReadOptions::default())? else { return Err(no_raster(file)) };
        let mut placed = place(raster, file, values)?;
        warnings.append(&mut placed.warnings);
        Ok(Some(placed))
    };
    fn with_file<'a>(file: &'a Option<std::path::PathBuf>, raster: Option<Raster>) -> Option<Layer<'a>> {
        Some(Layer { file: file.as_deref()?, raster: raster? })
    }
    let with = Companions {
        dem: with_file(&options.dem, layer(&options.dem, Values::Heights)?),
        canopy: with_file(&options.canopy, layer(&options.canopy, Values::Differences)?),
        trunk_zone: with_file(&options.trunk_zone, layer(&options.trunk_zone, Values::Differences)?),
        landcover: with_file(&options.landcover, layer(&options.landcover, Values::Codes)?),
    };
    let mut dsm = Layer { file: &part.file, raster: place(dsm, &part.file, Values::Heights)? };
    warnings.append(&mut dsm.raster.warnings);
    for other in [&with.dem, &with.canopy, &with.trunk_zone, &with.landcover].into_iter().flatten() {
        check_place(&dsm, other)?;
    }
    Ok(Rasters { dsm, with, warnings })
}

/// Returns the error for a file that should be a raster and is none.
pub(crate) fn no_raster(file: &Path) -> Error {
    Error::input(file, None, "is no raster", "give a GeoTIFF or an Esri ASCII grid")
}

/// Returns the raster of the ground without the part below a city; `None` if nothing else is left.
fn beyond(part: &Part, dsm: &Raster, dem: Layer) -> Option<Beyond> {
    let Layer { file, mut raster } = dem;
    let half = 0.5 * dsm.grid.step;
    let (low, high) = dsm.bounds();
    let (low, high) = (low - half, high + half);
    let (columns, step) = (raster.grid.columns, raster.grid.step);
    let mut is_left = false;
    for i in 0..raster.heights.len() {
        let place = raster.plan((i % columns) as i64, (i / columns) as i64);
        let within = |by: DVec2| place.cmpge(low + by).all() && place.cmple(high - by).all();
        let height = raster.heights.get_mut(i)?;
        if within(step) {
            *height = f32::NAN;
        } else if within(DVec2::ZERO) {
            *height -= BELOW_EDGE_M;
        } else {
            is_left |= !height.is_nan();
        }
    }
    let part = Part { file: file.to_owned(), surface: None, ..part.clone() };
    is_left.then_some(Beyond { part, raster })
}
