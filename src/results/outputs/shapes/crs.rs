//! Coordinate reference system of a map. In: the place of an archive. Out: coordinates in the
//! system's own unit, or degrees on WGS 84, and its definition as PROJJSON.

use glam::DVec3;
use serde_json::Value;

use heliotile_core::site::place::Place;
use heliotile_place::reference::PlaneSystem;

/// Definitions of projected systems, a line each: number in the EPSG register, tab, PROJJSON; made
/// by `tools/crs-definitions`.
const DEFINITIONS: &[u8] = include_bytes!("plane-systems.tsv.zst");

/// Coordinate reference system of a scene.
pub struct MapCrs {
    epsg: Option<u32>,
    /// Metres a unit of the system.
    unit_m: f64,
    system: Option<PlaneSystem>,
}

impl MapCrs {
    /// Returns the system of a place. Scenes are in metres. If the system is in feet, coordinates
    /// are converted to feet if that brings the scene nearer to the place that the archive states.
    pub fn new(place: Option<&Place>, middle: DVec3) -> Self {
        let epsg = place.and_then(|place| place.epsg);
        let system = epsg.and_then(|epsg| PlaneSystem::by_epsg(epsg).ok());
        let unit_m = match (&system, place) {
            (Some(system), Some(place)) => {
                let off = |unit: f64| {
                    let at = system.degrees(middle.x / unit, middle.y / unit);
                    at.map_or(f64::INFINITY, |(latitude, longitude)| place.distance_km(latitude, longitude))
                };
                let unit = system.unit_m();
                if off(unit) < off(1.0) { unit } else { 1.0 }
            }
            _ => 1.0,
        };
        MapCrs { epsg, unit_m, system }
    }

    /// Returns the system's number in the EPSG register, if it is known.
    pub fn epsg(&self) -> Option<u32> {
        self.epsg
    }

    /// Returns the coordinates of a point: x and y in the system's unit, height in metres.
    pub fn coordinates(&self, point: DVec3) -> [f64; 3] {
        [point.x / self.unit_m, point.y / self.unit_m, point.z]
    }

    /// Returns true if points can be converted to latitude and longitude.
    pub fn has_degrees(&self) -> bool {
        self.system.is_some()
    }

    /// Returns longitude and latitude on WGS 84, degrees, and the scene's height in metres.
    pub fn degrees(&self, point: DVec3) -> Option<[f64; 3]> {
        let [x, y, height] = self.coordinates(point);
        let (latitude, longitude) = self.system.as_ref()?.degrees(x, y)?;
        Some([longitude, latitude, height])
    }

    /// Returns the definition as PROJJSON, which GeoParquet states.
    pub fn projjson(&self) -> Option<Value> {
        let text = String::from_utf8(zstd::decode_all(DEFINITIONS).ok()?).ok()?;
        let number = format!("{}\t", self.epsg?);
        let line = text.lines().find_map(|line| line.strip_prefix(&number))?;
        serde_json::from_str(line).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(epsg: u32, latitude_deg: f64, longitude_deg: f64) -> Place {
        Place { latitude_deg, longitude_deg, convergence_deg: 0.0, epsg: Some(epsg) }
    }

    /// A point of The Hague in RD New keeps its metres and has the latitude that PROJ gives within
    /// 1e-7 degrees. In New York's feet coordinates are divided by 1200/3937. Both definitions
    /// contain their number.
    #[test]
    fn latitudes_in_the_hague_are_those_of_proj() {
        let point = DVec3::new(80_474.8, 455_194.3, 7.0);
        let hague = MapCrs::new(Some(&place(28992, 52.08, 4.3)), point);
        assert_eq!(hague.coordinates(point), point.to_array());
        let [longitude, latitude, height] = hague.degrees(point).expect("degrees");
        assert!(
            (longitude - 4.300_000_271_4).abs() < 1e-7 && (latitude - 52.080_000_186_6).abs() < 1e-7 && height == 7.0
        );
        let foot = 1200.0 / 3937.0;
        let point = DVec3::new(998_114.0 * foot, 194_309.3 * foot, 7.0);
        let york = MapCrs::new(Some(&place(2263, 40.7, -73.95)), point);
        assert!((york.coordinates(point)[0] - 998_114.0).abs() < 1e-6);
        for (crs, epsg) in [(hague, 28992), (york, 2263)] {
            assert_eq!(crs.projjson().expect("a definition")["id"]["code"], epsg);
        }
        let none = MapCrs::new(None, point);
        assert!(none.projjson().is_none() && none.degrees(point).is_none() && !none.has_degrees());
    }
}
