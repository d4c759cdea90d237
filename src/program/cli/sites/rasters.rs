//! Arguments for rasters that a city is read from.

use std::path::PathBuf;

use clap::Args;
use heliotile_scene::SurfaceRasters;

#[derive(Args, Clone, Debug, Default)]
pub struct RasterArgs {
    /// Raster of surface heights above the sea (DSM: .tif, .asc): its steps become walls, the
    /// plateaus and slopes between them roofs; with it no other scene file is needed
    #[arg(long, value_name = "FILE")]
    pub dsm: Option<PathBuf>,
    /// Raster of ground heights above the sea (DEM, DTM): surfaces 2 m above it are buildings, and
    /// it continues beyond --dsm as terrain
    #[arg(long, value_name = "FILE", requires = "dsm")]
    pub dem: Option<PathBuf>,
    /// Raster of heights of tree crowns above the ground (CDSM), which become canopies: group
    /// `trees`, 3 % of the light through a crown
    #[arg(long, value_name = "FILE", requires = "dsm")]
    pub canopy: Option<PathBuf>,
    /// Raster of land cover in UMEP's codes: 1 paved, 2 buildings, 5 grass, 6 bare soil, 7 water
    #[arg(long, value_name = "FILE", requires = "dsm")]
    pub landcover: Option<PathBuf>,
}

impl RasterArgs {
    /// Returns the rasters, if they are given.
    pub fn request(&self) -> Option<SurfaceRasters> {
        let dsm = self.dsm.clone()?;
        let RasterArgs { dem, canopy, landcover, .. } = self.clone();
        Some(SurfaceRasters { dem, canopy, landcover, ..SurfaceRasters::of(dsm) })
    }

    /// Returns all raster files.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.dsm, &self.dem, &self.canopy, &self.landcover].into_iter().flatten()
    }
}
