//! Where on Earth a scene lies. In: a coordinate reference system by its EPSG number, or the place itself. Out: latitude, longitude
//! and where true north is, good to some 100 m: shifts between datums are taken as far as three or seven parameters give them.

use heliotile_core::site::place::Place;
use proj4rs::Proj;
use proj4rs::transform::transform;

/// What a file says of its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// Number of a coordinate reference system in the EPSG register; a compound one counts by its horizontal part.
    Epsg(u32),
    /// Degrees, north and east positive; coordinates are those of a local system, y to true north.
    Place {
        /// -90..=90.
        latitude_deg: f64,
        /// -180..=180.
        longitude_deg: f64,
    },
}

/// Compound systems and their horizontal parts (EPSG register, 2024); the crate of definitions lists few of them.
const COMPOUND: [(u32, u32); 11] = [
    (5554, 25831),
    (5555, 25832),
    (5556, 25833),
    (5698, 2154),
    (5845, 3006),
    (5971, 25831),
    (5972, 25832),
    (5973, 25833),
    (6190, 31370),
    (7405, 27700),
    (7415, 28992),
];

/// First eccentricity of the WGS 84 ellipsoid, squared (NIMA TR8350.2, 2000, table 3.3).
const ECCENTRICITY_2: f64 = 0.006_694_379_990_14;

/// The horizontal part of a system.
pub fn horizontal(epsg: u32) -> u32 {
    COMPOUND.iter().find(|(compound, _)| *compound == epsg).map_or(epsg, |(_, part)| *part)
}

impl Reference {
    /// The place of a point; `None` for systems that are unknown, geographic or not of this point.
    pub fn place(self, x: f64, y: f64) -> Option<Place> {
        match self {
            Reference::Place { latitude_deg, longitude_deg } => {
                let known = latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0;
                known.then_some(Place { latitude_deg, longitude_deg, convergence_deg: 0.0, epsg: None })
            }
            Reference::Epsg(epsg) => {
                let epsg = horizontal(epsg);
                let definition = crs_definitions::from_code(u16::try_from(epsg).ok()?)?;
                let from = Proj::from_proj_string(definition.proj4).ok()?;
                if from.is_latlong() || from.is_geocent() {
                    return None;
                }
                let to = Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").ok()?;
                let at = |x: f64, y: f64| {
                    let mut point = (x, y, 0.0);
                    transform(&from, &to, &mut point).ok()?;
                    let (longitude, latitude, _) = point;
                    let known =
                        latitude.abs() <= std::f64::consts::FRAC_PI_2 && longitude.abs() <= std::f64::consts::PI;
                    known.then_some((latitude, longitude))
                };
                // Along grid north, with the lengths of a degree of latitude and longitude of the ellipsoid.
                let ((latitude, longitude), (north, beside)) = (at(x, y)?, at(x, y + 100.0)?);
                let sine = latitude.sin();
                let stretch = (1.0 - ECCENTRICITY_2 * sine * sine) / (1.0 - ECCENTRICITY_2);
                let east = (beside - longitude) * latitude.cos() * stretch;
                Some(Place {
                    latitude_deg: latitude.to_degrees(),
                    longitude_deg: longitude.to_degrees(),
                    convergence_deg: east.atan2(north - latitude).to_degrees(),
                    epsg: Some(epsg),
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five points of three countries lie where maps say, to 0.01 degrees, and their convergence is (longitude - that of the middle
    /// meridian) x sin(latitude), to 0.02 degrees.
    #[test]
    fn places() {
        for (epsg, x, y, latitude, longitude, middle) in [
            (7415, 78_000.0, 457_000.0, 52.095, 4.264, 5.3876),
            (28992, 155_000.0, 463_000.0, 52.1551, 5.3872, 5.3876),
            (5555, 500_000.0, 5_538_630.7, 50.0, 9.0, 9.0),
            (32611, 323_394.3, 4_163_000.0, 37.5992, -119.0008, -117.0),
            (26911, 323_394.3, 4_163_000.0, 37.5992, -119.0008, -117.0),
        ] {
            let place = Reference::Epsg(epsg).place(x, y).expect("known");
            let off = (place.latitude_deg - latitude, place.longitude_deg - longitude);
            assert!(off.0.abs() < 0.01 && off.1.abs() < 0.01, "{epsg}: {place:?}");
            let expected = (place.longitude_deg - middle) * place.latitude_deg.to_radians().sin();
            assert!((place.convergence_deg - expected).abs() < 0.02, "{epsg}: {place:?}, {expected}");
        }
        let hague = Reference::Epsg(7415).place(78_000.0, 457_000.0).expect("known");
        assert_eq!(hague.epsg, Some(28992));
        assert!((-0.90..-0.80).contains(&hague.convergence_deg), "{hague:?}");
        assert!(hague.warning().expect("0.9 degrees").contains("degrees west of true north"));
    }

    /// Numbers that are none, geographic systems and hopeless coordinates have no place, 6 of 6; a stated one is itself, without turn.
    #[test]
    fn nowhere() {
        for (epsg, x) in [(0, 0.0), (4326, 5.0), (4979, 5.0), (1, 1.0), (70_000, 0.0), (25832, 1e300)] {
            assert_eq!(Reference::Epsg(epsg).place(x, 50.0), None, "{epsg}");
        }
        let here = Reference::Place { latitude_deg: 52.0, longitude_deg: 4.0 }.place(1e6, 0.0).expect("stated");
        assert_eq!((here.latitude_deg, here.convergence_deg, here.warning()), (52.0, 0.0, None));
        assert_eq!(Reference::Place { latitude_deg: f64::NAN, longitude_deg: 4.0 }.place(0.0, 0.0), None);
    }
}
