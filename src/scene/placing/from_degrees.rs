//! Conversion of latitude and longitude to metres. In: a geographic system, and the plane system of
//! the scene if it has one. Out: positions in a plane system, which is UTM of the place if the
//! scene has none yet.

use glam::DVec2;
use proj4rs::Proj;
use proj4rs::transform::transform;

use heliotile_place::epsg_numbers::{Axes, axes_of, horizontal_part};
use heliotile_place::reference::{PlaneSystem, Reference, Unplaced};

/// Geographic system that is assumed where none is known: the shifts of those in use today against
/// WGS 84 are below a metre.
const WGS84: &str = "+proj=longlat +datum=WGS84 +no_defs";

/// Conversion from degrees to metres.
pub(crate) struct FromDegrees {
    from: Proj,
    to: PlaneSystem,
    epsg: u32,
}

impl FromDegrees {
    /// Returns the conversion from a geographic system by its number (`None`: WGS 84) to the system
    /// `asked`, or to UTM of a place.
    pub(crate) fn new(
        geographic: Option<u32>,
        asked: Option<u32>,
        latitude_deg: f64,
        longitude_deg: f64,
    ) -> Result<FromDegrees, Unplaced> {
        let epsg = match asked {
            Some(epsg) => epsg,
            None => utm_of(latitude_deg, longitude_deg).ok_or(Unplaced::Outside)?,
        };
        let to = PlaneSystem::by_epsg(epsg)?;
        let number = geographic.filter(|epsg| axes_of(*epsg) == Some(Axes::Degrees)).map(horizontal_part);
        let known = number.and_then(|number| crs_definitions::from_code(u16::try_from(number).ok()?));
        let known = known.map(|definition| definition.proj4).filter(|definition| definition.contains("longlat"));
        let from = Proj::from_proj_string(known.unwrap_or(WGS84)).or_else(|_| Proj::from_proj_string(WGS84));
        Ok(FromDegrees { from: from.map_err(|_| Unplaced::Unknown)?, to, epsg })
    }

    /// Returns the plane system.
    pub(crate) fn reference(&self) -> Reference {
        Reference::Epsg(self.epsg)
    }

    /// Returns metres east and north in the plane system; `None` if it has no such point.
    pub(crate) fn plane(&self, latitude_deg: f64, longitude_deg: f64) -> Option<DVec2> {
        if !(latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 360.0) {
            return None;
        }
        let mut point = (longitude_deg.to_radians(), latitude_deg.to_radians(), 0.0);
        transform(&self.from, self.to.proj(), &mut point).ok()?;
        let plane = DVec2::new(point.0, point.1) * self.to.unit_m();
        plane.is_finite().then_some(plane)
    }
}

/// Returns the UTM zone of a place by its number in the EPSG register; `None` beyond 84 north and
/// 80 south, where UTM ends.
fn utm_of(latitude_deg: f64, longitude_deg: f64) -> Option<u32> {
    if !(-80.0..=84.0).contains(&latitude_deg) || !longitude_deg.is_finite() {
        return None;
    }
    // Zones are 6 degrees wide; the first one begins at 180 W.
    let zone = ((longitude_deg + 180.0).rem_euclid(360.0) / 6.0).floor() as u32;
    Some(if latitude_deg < 0.0 { 32_701 } else { 32_601 } + zone.min(59))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six places in five systems and in UTM lie within 0.1 m of where PROJ puts them (pyproj
    /// 3.7.2); feet become metres.
    #[test]
    fn degrees_become_metres_as_in_proj() {
        for (geographic, asked, latitude, longitude, epsg, x, y) in [
            (None, None, 54.0, 6.2, 32632, 316_483.821, 5_987_150.638),
            (Some(4326), Some(25832), 53.9999996547, 6.1999996954, 25832, 316_483.8, 5_987_150.6),
            (Some(4326), Some(28992), 52.0800001866, 4.3000002714, 28992, 80_474.8, 455_194.3),
            (Some(4326), None, -34.0000003209, 150.0999998961, 32756, 232_148.1, 6_234_051.5),
            (
                Some(4326),
                Some(2263),
                40.7000000119,
                -73.9500001466,
                2263,
                998_114.0 * 0.3048006096,
                194_309.3 * 0.3048006096,
            ),
            (Some(6697), Some(6677), 35.25, 139.7, 6677, -12_133.41, -83_197.583),
        ] {
            let system = FromDegrees::new(geographic, asked, latitude, longitude).expect("known");
            assert_eq!(system.reference(), Reference::Epsg(epsg));
            let found = system.plane(latitude, longitude).expect("a place");
            assert!(found.distance(DVec2::new(x, y)) < 0.1, "{epsg}: {found}");
        }
        let zones = [(0.0, -180.0), (52.0, 4.3), (-33.9, 151.2), (10.0, 180.0)].map(|(lat, lon)| utm_of(lat, lon));
        assert_eq!(zones, [Some(32601), Some(32631), Some(32756), Some(32601)]);
        assert!(
            FromDegrees::new(None, None, 89.0, 0.0).is_err() && FromDegrees::new(None, Some(4326), 1.0, 1.0).is_err()
        );
        let utm = FromDegrees::new(None, None, 52.0, 4.0).expect("known");
        assert_eq!([utm.plane(91.0, 4.0), utm.plane(f64::NAN, 4.0)], [None, None]);
    }
}
