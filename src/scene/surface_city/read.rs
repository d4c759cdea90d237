//! Files of rasters as a city. In: a part of a site that is a raster of surface heights, which was read, and the rasters that go with it, which are not.
//! Out: the city in its place, and terrain where the raster of the ground goes on beyond it.

use std::path::Path;

use glam::{DVec2, DVec3};

use crate::formats::{Asked, Content, read};
use crate::placing::frame::SiteFrame;
use crate::reference::Reference;
use crate::site::Part;
use crate::surface_city::layers::{Companions, Layer};
use crate::surface_city::options::SurfaceRasters;
use crate::surface_city::{City, city};
use crate::terrain::raster::Raster;
use heliotile_core::error::{Error, Result};

/// Terrain that goes on below the edge of a city lies lower there, so that one ground hides the other, metres.
const BELOW_EDGE_M: f32 = 0.5;

/// Terrain beyond a city, in its place.
pub(crate) struct Beyond {
    pub part: Part,
    pub raster: Raster,
}

/// What was read.
pub(crate) struct SurfaceRead {
    pub city: City,
    pub beyond: Option<Beyond>,
}

/// What the numbers of a raster are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Values {
    /// Above sea level.
    Heights,
    /// Above the ground.
    Differences,
    /// Of classes.
    Codes,
}

/// Reads what goes with a raster of surface heights and makes a city of all.
pub(crate) fn read_surface(
    part: &Part,
    dsm: Raster,
    options: &SurfaceRasters,
    frame: &SiteFrame,
    system: Option<Reference>,
) -> Result<SurfaceRead> {
    let system = part.reference.or(frame.references()[0]).or(system);
    let mut warnings = Vec::new();
    let place = |raster: Raster, file: &Path, values: Values| -> Result<Raster> {
        let level = values == Values::Heights;
        let own = Part {
            file: file.to_owned(),
            offset: if level { part.offset } else { DVec3::new(part.offset.x, part.offset.y, 0.0) },
            elevation_m: part.elevation_m.filter(|_| level),
            ..part.clone()
        };
        let codes = (values == Values::Codes).then(|| raster.heights.clone());
        let mut placed = raster.placed(&own, frame, system)?;
        if let Some(codes) = codes {
            placed.heights = codes;
        }
        Ok(placed)
    };
    let mut layer = |file: &'_ Option<std::path::PathBuf>, values: Values| -> Result<Option<Raster>> {
        let Some(file) = file else { return Ok(None) };
        let Content::Terrain(raster) = read(file, &Asked::default())? else { return Err(no_raster(file)) };
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
        landcover: with_file(&options.landcover, layer(&options.landcover, Values::Codes)?),
    };
    let mut dsm = Layer { file: &part.file, raster: place(dsm, &part.file, Values::Heights)? };
    warnings.append(&mut dsm.raster.warnings);
    let mut city = city(&dsm, &with, options)?;
    warnings.append(&mut city.geometry.warnings);
    city.geometry.warnings = warnings;
    let beyond = with.dem.and_then(|dem| beyond(part, &dsm.raster, dem));
    Ok(SurfaceRead { city, beyond })
}

/// The error of a file that is no raster where one is asked for.
pub(crate) fn no_raster(file: &Path) -> Error {
    Error::input(file, None, "is no raster", "give a GeoTIFF or an Esri ASCII grid")
}

/// The ground without what lies below a city; `None` where nothing else is left.
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
