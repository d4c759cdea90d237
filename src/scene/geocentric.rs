//! Coordinates from the Earth's centre, as tiles of 3D Tiles have them (EPSG:4978: x to longitude
//! 0, z to the north pole). In: vertices. Out: true if they are geocentric, and their positions in
//! metres east, north and up of a place on the ellipsoid.

use glam::{DMat3, DVec3};

use heliotile_place::reference::Reference;

/// Range of distances from the Earth's centre to objects on its surface, metres: the poles are at
/// 6,356.8 km, the equator at 6,378.1 km.
const NEAREST_M: f64 = 6.33e6;
const FARTHEST_M: f64 = 6.4e6;

/// Least distance from the plane of the equator, metres. Plane coordinates in the north of Europe
/// may have the same length, but no heights like these. Within 10 km of the equator geocentric
/// coordinates are not recognised.
const NO_HEIGHT_M: f64 = 10_000.0;

/// The WGS 84 ellipsoid (NIMA TR8350.2, 2000, tables 3.1 and 3.3): semi-major axis, and first
/// eccentricity squared.
const HALF_AXIS_M: f64 = 6_378_137.0;
const ECCENTRICITY_2: f64 = 0.006_694_379_990_14;

/// A place on the ellipsoid, with directions east, north and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LocalFrame {
    origin: DVec3,
    /// Rotation whose rows are east, north and up.
    turn: DMat3,
    latitude_deg: f64,
    longitude_deg: f64,
}

/// Returns true if all positions lie near the surface of the Earth, measured from its centre.
pub(crate) fn is_geocentric(positions: &[DVec3]) -> bool {
    let near = |p: &DVec3| (NEAREST_M..FARTHEST_M).contains(&p.length()) && p.z.abs() > NO_HEIGHT_M;
    !positions.is_empty() && positions.iter().all(near)
}

impl LocalFrame {
    /// Returns the frame of the place on the ellipsoid below or above a position.
    fn at(position: DVec3) -> LocalFrame {
        let (x, y, z) = position.into();
        let (across, longitude) = (x.hypot(y), y.atan2(x));
        // Each step converges by a factor of 300; the normal's length to the axis is that of the
        // previous latitude.
        let mut latitude = z.atan2(across * (1.0 - ECCENTRICITY_2));
        for _ in 0..6 {
            let normal = HALF_AXIS_M / (1.0 - ECCENTRICITY_2 * latitude.sin().powi(2)).sqrt();
            latitude = (z + ECCENTRICITY_2 * normal * latitude.sin()).atan2(across);
        }
        let ((sin, cos), (sin_l, cos_l)) = (latitude.sin_cos(), longitude.sin_cos());
        let normal = HALF_AXIS_M / (1.0 - ECCENTRICITY_2 * sin * sin).sqrt();
        let origin = normal * DVec3::new(cos * cos_l, cos * sin_l, (1.0 - ECCENTRICITY_2) * sin);
        let east = DVec3::new(-sin_l, cos_l, 0.0);
        let north = DVec3::new(-sin * cos_l, -sin * sin_l, cos);
        let up = DVec3::new(cos * cos_l, cos * sin_l, sin);
        LocalFrame {
            origin,
            turn: DMat3::from_cols(east, north, up).transpose(),
            latitude_deg: latitude.to_degrees(),
            longitude_deg: longitude.to_degrees(),
        }
    }

    /// Returns the place of the origin as a reference; y points to true north.
    pub(crate) fn reference(&self) -> Reference {
        Reference::Place { latitude_deg: self.latitude_deg, longitude_deg: self.longitude_deg }
    }

    fn local(&self, position: DVec3) -> DVec3 {
        self.turn * (position - self.origin)
    }
}

/// Turns geocentric coordinates into metres about a place and returns the frame of that place. The
/// frame is `of_scene`, from the scene's first such file, or else that of the middle of these
/// vertices. Vertices that are not geocentric stay as they are.
pub(crate) fn to_local(vertices: &mut [DVec3], of_scene: Option<LocalFrame>) -> Option<LocalFrame> {
    if !is_geocentric(vertices) {
        return None;
    }
    let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let frame = of_scene.unwrap_or_else(|| LocalFrame::at(0.5 * (low + high)));
    vertices.iter_mut().for_each(|vertex| *vertex = frame.local(*vertex) + 0.0);
    Some(frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::site::SceneFiles;

    const POINT: [f64; 3] = [3_923_453.927_6, 301_066.748_5, 5_002_838.806_0];

    /// A point of The Hague, 45 m above the ellipsoid, that pyproj 3.7.2 puts at (3923453.9276,
    /// 301066.7485, 5002838.8060) is 45 m above the origin of its frame within 0.1 mm, at 52.0 N
    /// and 4.388 E within 1e-8 degrees. A shift of 100 m towards the pole points north and up.
    #[test]
    fn geocentric_coordinates_have_their_place() {
        let point = DVec3::new(POINT[0], POINT[1], POINT[2]);
        let frame = LocalFrame::at(point);
        let local = frame.local(point);
        assert!((local - DVec3::new(0.0, 0.0, 45.0)).length() < 1e-4, "{local}");
        assert!((frame.latitude_deg - 52.0).abs() < 1e-8 && (frame.longitude_deg - 4.388).abs() < 1e-8, "{frame:?}");
        let (sin, cos) = f64::to_radians(52.0).sin_cos();
        let north = frame.local(point + DVec3::new(0.0, 0.0, 100.0)) - local;
        assert!((north - DVec3::new(0.0, 100.0 * cos, 100.0 * sin)).length() < 1e-4, "{north}");
    }

    /// One of five positions is geocentric: UTM coordinates of Denmark and of Gothenburg have the
    /// same length and are not, and neither is a house.
    #[test]
    fn coordinates_of_a_plane_are_not_geocentric() {
        for (position, expected) in [
            (POINT, true),
            ([500_000.0, 6_350_000.0, 20.0], false),
            ([319_000.0, 6_399_000.0, 8_000.0], false),
            ([10.0, 20.0, 30.0], false),
            ([2.0 * POINT[0], POINT[1], POINT[2]], false),
        ] {
            assert_eq!(is_geocentric(&[DVec3::from(position)]), expected, "{position:?}");
        }
        assert!(!is_geocentric(&[]));
        assert!(!is_geocentric(&[DVec3::from(POINT), DVec3::ZERO]));
    }

    /// Two houses of 10 m that stand 100 m apart from east to west, in geocentric coordinates of
    /// two files, span 110 x 10 x 8 m in one frame of 52 N. A city model in such coordinates is
    /// refused.
    #[test]
    fn two_geocentric_files_share_one_frame() {
        let frame = LocalFrame::at(DVec3::from(POINT));
        let folder = tempfile::tempdir().expect("a folder");
        let house = |east: f64| {
            let mut text = String::new();
            for (x, y, z) in
                [(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0), (0, 0, 8), (10, 0, 8), (10, 10, 8), (0, 10, 8)]
            {
                let local = DVec3::new(east + f64::from(x), f64::from(y), 45.0 + f64::from(z));
                let p = frame.origin + frame.turn.transpose() * local;
                text += &format!("v {} {} {}\n", p.x, p.y, p.z);
            }
            text + "f 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
        };
        let files = ["a.obj", "b.obj"].map(|name| folder.path().join(name));
        for (file, east) in files.iter().zip([0.0, 100.0]) {
            std::fs::write(file, house(east)).expect("written");
        }
        let scene = Scene::load_site(&SceneFiles::new(&files, None).expect("a site")).expect("a scene");
        let (low, high) = scene.mesh.bounds();
        assert!((high - low - DVec3::new(110.0, 10.0, 8.0)).abs().max_element() < 0.01, "{}", high - low);
        assert!((low.z + scene.mesh.origin.z - 45.0).abs() < 0.01);
        let place = scene.place.expect("a place");
        assert!((place.latitude_deg - 52.0).abs() < 1e-3 && (place.longitude_deg - 4.388).abs() < 1e-3, "{place}");
        let said = scene.report.warnings.iter().filter(|said| said.contains("geocentric (EPSG:4978)")).count();
        assert_eq!(said, 2);
        let city = folder.path().join("c.city.json");
        let corners = [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]];
        let text = format!(
            r#"{{"type":"CityJSON","version":"2.0","transform":{{"scale":[1,1,1],"translate":{POINT:?}}},"CityObjects":{{"b":{{"type":"Building",
            "geometry":[{{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]]}}]}}}},"vertices":{corners:?}}}"#
        );
        std::fs::write(&city, text).expect("written");
        let message = Scene::load(&city, None).expect_err("geocentric").to_string();
        assert!(message.contains("its coordinates are geocentric"), "{message}");
    }
}
