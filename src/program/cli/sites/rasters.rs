//! Arguments for rasters that a city is read from.

use std::path::PathBuf;

use clap::Args;
use heliotile::SurfaceRasters;

#[derive(Args, Clone, Debug, Default)]
pub struct RasterArgs {
    /// Raster of surface heights above sea level (DSM: .tif, .asc): its steps become walls, the
    /// flat and sloping areas between them roofs; no other scene file is needed with it
    #[arg(long, value_name = "FILE")]
    pub dsm: Option<PathBuf>,
    /// Raster of ground heights above sea level (DEM, DTM): parts of --dsm that are at least 2 m
    /// higher are buildings, and it continues beyond --dsm as terrain; with --canopy and without
    /// --dsm, ground with trees alone
    #[arg(long, value_name = "FILE")]
    pub dem: Option<PathBuf>,
    /// Raster of the heights of tree crowns above the ground (CDSM): crowns become canopies of the
    /// group `trees` that let 3 % of the light through
    #[arg(long, value_name = "FILE")]
    pub canopy: Option<PathBuf>,
    /// Raster of land cover in UMEP's codes: 1 paved, 2 buildings, 5 grass, 6 bare soil, 7 water
    #[arg(long, value_name = "FILE")]
    pub landcover: Option<PathBuf>,
}

impl RasterArgs {
    /// Returns the rasters, if they are given.
    pub fn request(&self) -> Option<SurfaceRasters> {
        let RasterArgs { dsm, dem, canopy, landcover } = self.clone();
        SurfaceRasters::of_files(dsm, dem, canopy, landcover)
    }

    /// Returns all raster files.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.dsm, &self.dem, &self.canopy, &self.landcover].into_iter().flatten()
    }
}
