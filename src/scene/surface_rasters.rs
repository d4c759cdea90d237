//! Rasters that a city is read from, as they are asked for. In: paths and numbers. Out: one value that can be kept and read again.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// A raster of surface heights, what goes with it, and how buildings and crowns are told from the ground.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRasters {
    /// Heights of roofs and ground above sea level (DSM).
    pub dsm: PathBuf,
    /// Heights of the ground above sea level (DEM, DTM); it goes on beyond the surface as terrain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dem: Option<PathBuf>,
    /// Heights of crowns above the ground (CDSM); 0 where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub canopy: Option<PathBuf>,
    /// Codes of land cover as UMEP has them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landcover: Option<PathBuf>,
    /// Less is no step between roofs, and without a `dem` between roof and ground, metres; none: 2 m, or a slope of 2 where cells are larger
    /// than 1 m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_m: Option<f64>,
    /// Less is no building, m2; none: [`SurfaceRasters::LEAST_BUILDING_M2`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_building_m2: Option<f64>,
    /// Share of a crown's height above the ground that is open below it; none: [`SurfaceRasters::TRUNK_SHARE`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trunk_share: Option<f64>,
    /// Share of the light that goes through a whole crown; none: [`SurfaceRasters::LEAF_ON`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crown_transmittance: Option<f64>,
}

impl SurfaceRasters {
    /// Least area of a building, m2: garages and kiosks are some, cars and stalls are none.
    pub const LEAST_BUILDING_M2: f64 = 10.0;
    /// Open below crowns: the lowest quarter, SOLWEIG's default trunk zone (Lindberg and Grimmond 2011).
    pub const TRUNK_SHARE: f64 = 0.25;
    /// Through a crown with leaves: 3 %, SOLWEIG's default (Lindberg and Grimmond 2011; Konarska et al. 2014 measured 1 to 5 %).
    pub const LEAF_ON: f64 = 0.03;

    /// A raster of surface heights of which nothing else is said.
    pub fn of(dsm: impl Into<PathBuf>) -> Self {
        SurfaceRasters { dsm: dsm.into(), ..SurfaceRasters::default() }
    }

    /// All rasters.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let beside = [&self.dem, &self.canopy, &self.landcover].into_iter().flatten();
        std::iter::once(&self.dsm).chain(beside).map(PathBuf::as_path)
    }

    /// The same with other paths.
    pub fn with_paths<E>(&self, path: impl Fn(&PathBuf) -> Result<PathBuf, E>) -> Result<Self, E> {
        let other = |of: &Option<PathBuf>| of.as_ref().map(&path).transpose();
        Ok(SurfaceRasters {
            dsm: path(&self.dsm)?,
            dem: other(&self.dem)?,
            canopy: other(&self.canopy)?,
            landcover: other(&self.landcover)?,
            ..self.clone()
        })
    }

    /// What is wrong with a number, and its field.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let within = |name: &'static str, value: Option<f64>, low: f64, high: f64| match value {
            Some(value) if !(low..=high).contains(&value) => {
                Err((name, format!("`{name}` is {value}, not from {low} to {high}")))
            }
            _ => Ok(()),
        };
        within("step_m", self.step_m, 0.1, 100.0)?;
        within("least_building_m2", self.least_building_m2, 0.0, 1e6)?;
        within("trunk_share", self.trunk_share, 0.0, 0.95)?;
        within("crown_transmittance", self.crown_transmittance, 0.0, 1.0)
    }

    /// The least step for cells of a width.
    pub(crate) fn step(&self, cell_m: f64) -> f64 {
        self.step_m.unwrap_or(LEAST_STEP_M.max(STEEPEST_ROOF * cell_m))
    }

    pub(crate) fn least_building(&self) -> f64 {
        self.least_building_m2.unwrap_or(SurfaceRasters::LEAST_BUILDING_M2)
    }

    pub(crate) fn trunk(&self) -> f64 {
        self.trunk_share.unwrap_or(SurfaceRasters::TRUNK_SHARE)
    }

    pub(crate) fn crown(&self) -> f64 {
        self.crown_transmittance.unwrap_or(SurfaceRasters::LEAF_ON)
    }
}

/// Lower steps are kerbs, hedges, cars and noise.
pub(crate) const LEAST_STEP_M: f64 = 2.0;
/// Rise a metre that a pitched roof may have from cell to cell: 63 degrees.
const STEEPEST_ROOF: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// A request is read again as it was written, in 2 fields; 4 numbers out of range are named.
    #[test]
    fn requests_are_kept() {
        let request = SurfaceRasters { trunk_share: Some(0.3), ..SurfaceRasters::of("a.tif") };
        let text = serde_json::to_string(&request).expect("JSON");
        assert_eq!(text, "{\"dsm\":\"a.tif\",\"trunk_share\":0.3}");
        assert_eq!(serde_json::from_str::<SurfaceRasters>(&text).expect("a request"), request);
        assert!(request.check().is_ok());
        let of = || SurfaceRasters::of("a.tif");
        for (wrong, name) in [
            (SurfaceRasters { step_m: Some(0.0), ..of() }, "step_m"),
            (SurfaceRasters { least_building_m2: Some(f64::NAN), ..of() }, "least_building_m2"),
            (SurfaceRasters { trunk_share: Some(1.0), ..of() }, "trunk_share"),
            (SurfaceRasters { crown_transmittance: Some(-0.1), ..of() }, "crown_transmittance"),
        ] {
            assert_eq!(wrong.check().expect_err(name).0, name);
        }
    }
}
