//! Polygons of geometries. In: what the crate `geozero` finds in well-known binary (OGC 06-103r4).
//! Out: the polygons of a feature.

use geozero::error::{GeozeroError, Result};
use geozero::{CoordDimensions, GeomProcessor};
use glam::DVec3;

use super::feature::{Feature, FeaturePolygon};

/// Most corners of one geometry: the coast of a country has fewer.
const MOST_CORNERS: usize = 1 << 24;

/// Collector of the polygons of one geometry.
#[derive(Default)]
pub(super) struct Shapes {
    polygons: Vec<FeaturePolygon>,
    polygon: FeaturePolygon,
    ring: Vec<DVec3>,
    corners: usize,
    /// True if the lines that come are rings of a polygon or triangle.
    in_polygon: bool,
    is_body: bool,
    has_others: bool,
}

impl Shapes {
    /// Moves the polygons that were found into a feature.
    pub(super) fn fill(self, feature: &mut Feature) {
        feature.polygons = self.polygons;
        feature.is_body = self.is_body;
        feature.has_others = self.has_others;
    }

    fn end(&mut self) -> Result<()> {
        self.in_polygon = false;
        self.polygons.push(std::mem::take(&mut self.polygon));
        Ok(())
    }
}

impl GeomProcessor for Shapes {
    fn dimensions(&self) -> CoordDimensions {
        CoordDimensions::xyz()
    }

    fn xy(&mut self, x: f64, y: f64, _: usize) -> Result<()> {
        self.coordinate(x, y, None, None, None, None, 0)
    }

    fn coordinate(
        &mut self,
        x: f64,
        y: f64,
        z: Option<f64>,
        _: Option<f64>,
        _: Option<f64>,
        _: Option<u64>,
        _: usize,
    ) -> Result<()> {
        self.corners += 1;
        if self.corners > MOST_CORNERS {
            return Err(GeozeroError::Geometry("a geometry has more than 16 million corners".to_owned()));
        }
        // Some files write missing heights as NaN.
        let z = z.filter(|z| z.is_finite()).unwrap_or_default();
        self.ring.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn point_begin(&mut self, _: usize) -> Result<()> {
        self.has_others = true;
        Ok(())
    }

    fn polygon_begin(&mut self, _: bool, _: usize, _: usize) -> Result<()> {
        self.in_polygon = true;
        self.polygon.clear();
        self.ring.clear();
        Ok(())
    }

    fn polygon_end(&mut self, _: bool, _: usize) -> Result<()> {
        self.end()
    }

    fn triangle_begin(&mut self, _: bool, _: usize, _: usize) -> Result<()> {
        self.polygon_begin(true, 0, 0)
    }

    fn triangle_end(&mut self, _: bool, _: usize) -> Result<()> {
        self.end()
    }

    fn polyhedralsurface_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.is_body = true;
        Ok(())
    }

    fn tin_begin(&mut self, _: usize, _: usize) -> Result<()> {
        self.is_body = true;
        Ok(())
    }

    fn linestring_begin(&mut self, _: bool, _: usize, _: usize) -> Result<()> {
        self.ring.clear();
        Ok(())
    }

    fn linestring_end(&mut self, _: bool, _: usize) -> Result<()> {
        match self.in_polygon {
            true => self.polygon.push(std::mem::take(&mut self.ring)),
            false => self.has_others = true,
        }
        Ok(())
    }

    fn curvepolygon_begin(&mut self, _: usize, _: usize) -> Result<()> {
        Err(GeozeroError::Geometry(
            "a polygon has curved sides, which are not read: write it with straight sides".to_owned(),
        ))
    }
}
