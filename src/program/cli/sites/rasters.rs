//! Rasters that a city is read from, as commands take them.

use std::path::PathBuf;

use clap::Args;
use heliotile_scene::SurfaceRasters;

#[derive(Args, Clone, Debug, Default)]
pub struct RasterArgs {
    /// Raster of surface heights above the sea (DSM: .tif, .asc), whose steps become walls and whose plateaus and slopes between them roofs; with
    /// it no other scene file is needed
    #[arg(long, value_name = "FILE")]
    pub dsm: Option<PathBuf>,
    /// Raster of ground heights above the sea (DEM, DTM): what stands 2 m above it is a building, and it goes on beyond --dsm as terrain
    #[arg(long, value_name = "FILE", requires = "dsm")]
    pub dem: Option<PathBuf>,
    /// Raster of heights of tree crowns above the ground (CDSM), which become canopies: group `trees`, 3 % of the light through a crown
    #[arg(long, value_name = "FILE", requires = "dsm")]
    pub canopy: Option<PathBuf>,
    /// Raster of land cover in UMEP's codes: 1 paved, 2 buildings, 5 grass, 6 bare soil, 7 water
    #[arg(long, value_name = "FILE", requires = "dsm")]
    pub landcover: Option<PathBuf>,
}

impl RasterArgs {
    /// The rasters that are asked for.
    pub fn request(&self) -> Option<SurfaceRasters> {
        let dsm = self.dsm.clone()?;
        let RasterArgs { dem, canopy, landcover, .. } = self.clone();
        Some(SurfaceRasters { dem, canopy, landcover, ..SurfaceRasters::of(dsm) })
    }

    /// All files.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.dsm, &self.dem, &self.canopy, &self.landcover].into_iter().flatten()
    }
}
