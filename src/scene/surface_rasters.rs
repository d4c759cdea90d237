//! Request for rasters that a city is read from. In: paths and numbers. Out: one value that can be
//! stored and read again.

use std::path::{Path, PathBuf};

use heliotile_core::site::material::{LEAF_AREA_DENSITY, MAX_LEAF_AREA_DENSITY};
use heliotile_requests::Request;

use serde::{Deserialize, Serialize};

/// A raster of surface heights with its companions, and the limits that tell buildings and crowns
/// from the ground.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Request)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRasters {
    /// Raster of surface heights above sea level (DSM: .tif, .asc): its steps become walls, the
    /// flat and sloping areas between them roofs; no other scene file is needed with it.
    #[field(metavar = "FILE", input = Scene)]
    pub dsm: PathBuf,
    /// Raster of ground heights above sea level (DEM, DTM): parts of --dsm that are at least 2 m
    /// higher are buildings, and it continues beyond --dsm as terrain; with --canopy and without
    /// --dsm, ground with trees alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "FILE", input = Scene)]
    pub dem: Option<PathBuf>,
    /// Raster of the heights of tree crowns above the ground (CDSM), on a grid as fine as it likes:
    /// crowns become volumes of leaves of the group `trees`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "FILE", input = Scene)]
    pub canopy: Option<PathBuf>,
    /// Raster of land cover in UMEP's codes: 1 paved, 2 buildings, 5 grass, 6 bare soil, 7 water.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "FILE", input = Scene)]
    pub landcover: Option<PathBuf>,
    /// Least height of a step between roofs and, without a `dem`, between roof and ground, metres.
    /// `None`: 2 m, or a slope of 2 if cells are larger than 1 m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(skip)]
    pub step_m: Option<f64>,
    /// Least area of a building, m2; `None`: [`SurfaceRasters::MIN_BUILDING_M2`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(skip)]
    pub least_building_m2: Option<f64>,
    /// Share of a crown's height above the ground that is open below it; `None`:
    /// [`SurfaceRasters::TRUNK_SHARE`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(skip)]
    pub trunk_share: Option<f64>,
    /// Raster of the heights of the undersides of crowns above the ground (TDSM), in place of
    /// `trunk_share` where it has a value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(skip)]
    pub trunk_zone: Option<PathBuf>,
    /// Leaf area density of crowns, m2/m3; `None`: [`LEAF_AREA_DENSITY`], or less in a forest
    /// whose leaf area index would be above [`SurfaceRasters::LEAF_AREA_INDEX`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(skip)]
    pub leaf_area_density: Option<f64>,
}

impl SurfaceRasters {
    /// Default least area of a building, m2: some garages and kiosks are as large, cars and stalls
    /// are not.
    pub const MIN_BUILDING_M2: f64 = 10.0;
    /// Default open share below crowns: the lowest quarter, SOLWEIG's trunk zone (Lindberg and
    /// Grimmond 2011).
    pub const TRUNK_SHARE: f64 = 0.25;
    /// Largest open share below a crown.
    pub const HIGHEST_TRUNK_SHARE: f64 = 0.95;
    /// Largest mean leaf area index of a forest where nothing is stated, m2/m2: between the mean of
    /// all vegetation, 4.5, and those of temperate evergreen forests, 5.1 to 6.7 (Asner, Scurlock
    /// and Hicke 2003, abstract). Crowns of street trees are denser.
    pub const LEAF_AREA_INDEX: f64 = 5.0;

    /// Returns a request for a raster of surface heights, with nothing else stated.
    pub fn new(dsm: impl Into<PathBuf>) -> Self {
        SurfaceRasters { dsm: dsm.into(), ..SurfaceRasters::default() }
    }

    /// Rasters without which no other one has a meaning.
    pub const NEEDED: &str = "give the heights of the surface ({dsm}), or those of the ground ({dem}) and of crowns ({canopy}) for trees alone";

    /// Returns true if no raster is given.
    pub fn is_none(&self) -> bool {
        *self == SurfaceRasters::default()
    }

    /// Returns the rasters, or `None` if none is given. Without a surface the ground below crowns
    /// is one; [`SurfaceRasters::check`] refuses any other lack of it.
    pub fn settled(&self) -> Option<Self> {
        let ground = self.dem.clone().filter(|_| self.canopy.is_some() && self.dsm.as_os_str().is_empty());
        let dsm = ground.unwrap_or_else(|| self.dsm.clone());
        (!self.is_none()).then(|| SurfaceRasters { dsm, ..self.clone() })
    }

    /// Returns the settled rasters of these files, or `None` if none is given.
    pub fn of_files(
        dsm: Option<PathBuf>,
        dem: Option<PathBuf>,
        canopy: Option<PathBuf>,
        landcover: Option<PathBuf>,
    ) -> Option<Self> {
        let dsm = dsm.unwrap_or_default();
        SurfaceRasters { dem, canopy, landcover, ..SurfaceRasters::new(dsm) }.settled()
    }

    /// Returns the paths that are given, `dsm` first.
    pub fn all(&self) -> impl Iterator<Item = &Path> {
        let given = [Some(&self.dsm), self.dem.as_ref()];
        given
            .into_iter()
            .chain(self.of_cells())
            .flatten()
            .map(PathBuf::as_path)
            .filter(|path| !path.as_os_str().is_empty())
    }

    /// Returns the paths of all rasters, `dsm` first.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let beside = [self.dem.as_ref()].into_iter().chain(self.of_cells()).flatten();
        let beside = beside.filter(|path| **path != self.dsm);
        std::iter::once(&self.dsm).chain(beside).map(PathBuf::as_path)
    }

    /// Returns the paths of rasters of crowns, trunks and land cover.
    fn of_cells(&self) -> [Option<&PathBuf>; 3] {
        [self.canopy.as_ref(), self.trunk_zone.as_ref(), self.landcover.as_ref()]
    }

    /// Returns this request with each path replaced by what `path` gives for it.
    pub fn with_paths<E>(&self, path: impl Fn(&PathBuf) -> Result<PathBuf, E>) -> Result<Self, E> {
        let other = |of: &Option<PathBuf>| of.as_ref().map(&path).transpose();
        Ok(SurfaceRasters {
            dsm: path(&self.dsm)?,
            dem: other(&self.dem)?,
            canopy: other(&self.canopy)?,
            trunk_zone: other(&self.trunk_zone)?,
            landcover: other(&self.landcover)?,
            ..self.clone()
        })
    }

    /// Checks that numbers are within range; an error names the field and the fault.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let within = |name: &'static str, value: Option<f64>, low: f64, high: f64| match value {
            Some(value) if !(low..=high).contains(&value) => {
                Err((name, format!("`{name}` is {value}, not from {low} to {high}")))
            }
            _ => Ok(()),
        };
        if self.dsm.as_os_str().is_empty() {
            return Err(("dsm", "is missing beside other rasters".to_owned()));
        }
        if self.trunk_zone.is_some() && self.canopy.is_none() {
            return Err(("trunk_zone", "`trunk_zone` is the lower part of a `canopy`, which is missing".to_owned()));
        }
        within("step_m", self.step_m, 0.1, 100.0)?;
        within("least_building_m2", self.least_building_m2, 0.0, 1e6)?;
        within("trunk_share", self.trunk_share, 0.0, SurfaceRasters::HIGHEST_TRUNK_SHARE)?;
        within("leaf_area_density", self.leaf_area_density, 0.0, MAX_LEAF_AREA_DENSITY)
    }

    /// Returns the least step for cells of width `cell_m`, metres.
    pub(crate) fn step(&self, cell_m: f64) -> f64 {
        self.step_m.unwrap_or(MIN_STEP_M.max(STEEPEST_ROOF * cell_m))
    }

    pub(crate) fn least_building(&self) -> f64 {
        self.least_building_m2.unwrap_or(SurfaceRasters::MIN_BUILDING_M2)
    }

    pub(crate) fn trunk(&self) -> f64 {
        self.trunk_share.unwrap_or(SurfaceRasters::TRUNK_SHARE)
    }

    /// Returns true if the surface is the ground itself: nothing stands on it but trees.
    pub(crate) fn is_bare(&self) -> bool {
        self.dem.as_ref() == Some(&self.dsm) && self.canopy.is_some()
    }

    /// Returns the leaf area density of crowns whose mean height above the ground is `height_m`,
    /// m2/m3: that of a forest in steps of 0.01.
    pub(crate) fn density(&self, height_m: f64) -> f64 {
        let of_forest = SurfaceRasters::LEAF_AREA_INDEX / (height_m * (1.0 - self.trunk()));
        let in_steps = (of_forest.min(LEAF_AREA_DENSITY) * 100.0).round().max(1.0) / 100.0;
        self.leaf_area_density.unwrap_or(if self.is_bare() { in_steps } else { LEAF_AREA_DENSITY })
    }
}

/// Least step at cells of up to 1 m, metres: lower steps are kerbs, hedges, cars and noise.
pub(crate) const MIN_STEP_M: f64 = 2.0;
/// Steepest rise of a pitched roof from cell to cell, metres a metre: 63 degrees.
const STEEPEST_ROOF: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// Ground with crowns is a forest, whose file counts once and whose leaves are less dense where
    /// it is high; ground, crowns or land cover alone are refused for want of a surface.
    #[test]
    fn ground_with_crowns_needs_no_surface() {
        let [a, b, c] = ["a.tif", "b.tif", "c.tif"].map(|name| Some(PathBuf::from(name)));
        let forest = SurfaceRasters::of_files(None, a.clone(), b.clone(), c.clone()).expect("a request");
        assert!(forest.is_bare() && forest.check().is_ok());
        // A forest of 20 m has a leaf area index of 5, one of 4 m a density of 1, as in a city.
        assert_eq!([20.0, 4.0, 0.0].map(|height| forest.density(height)), [0.33, 1.0, 1.0]);
        assert_eq!(forest.files().collect::<Vec<_>>(), ["a.tif", "b.tif", "c.tif"].map(Path::new));
        let city = SurfaceRasters::of_files(a.clone(), b.clone(), c.clone(), None).expect("a request");
        assert!(!city.is_bare() && city.density(20.0) == 1.0);
        for [dem, canopy, landcover] in [[a, None, None], [None, b, None], [None, None, c]] {
            let found = SurfaceRasters::of_files(None, dem, canopy, landcover).expect("a request");
            assert_eq!(found.check().expect_err("no surface").0, "dsm");
        }
        assert_eq!(SurfaceRasters::of_files(None, None, None, None), None);
    }

    /// A request of 2 fields is read back as it was written; 4 numbers out of range are refused
    /// with their field.
    #[test]
    fn a_request_is_read_as_it_was_written() {
        let request = SurfaceRasters { trunk_share: Some(0.3), ..SurfaceRasters::new("a.tif") };
        let text = serde_json::to_string(&request).expect("JSON");
        assert_eq!(text, "{\"dsm\":\"a.tif\",\"trunk_share\":0.3}");
        assert_eq!(serde_json::from_str::<SurfaceRasters>(&text).expect("a request"), request);
        assert!(request.check().is_ok());
        let of = || SurfaceRasters::new("a.tif");
        for (wrong, name) in [
            (SurfaceRasters { step_m: Some(0.0), ..of() }, "step_m"),
            (SurfaceRasters { least_building_m2: Some(f64::NAN), ..of() }, "least_building_m2"),
            (SurfaceRasters { trunk_share: Some(1.0), ..of() }, "trunk_share"),
            (SurfaceRasters { trunk_zone: Some("t.tif".into()), ..of() }, "trunk_zone"),
            (SurfaceRasters { leaf_area_density: Some(-0.1), ..of() }, "leaf_area_density"),
        ] {
            assert_eq!(wrong.check().expect_err(name).0, name);
        }
    }
}
