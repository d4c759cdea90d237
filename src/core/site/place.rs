//! Place of a site on Earth. In: latitude, longitude and the direction of y. Out: comparisons of
//! places, words and distances.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Smallest angle between y and true north that is reported, degrees. The sun's disc is 0.5 degrees
/// wide.
const NOTED_DEG: f64 = 0.1;

/// Difference of angles below which they are equal, degrees: a tenth of a millimetre on the ground.
const SAME_DEG: f64 = 1e-9;

/// Largest difference between the middles of two scenes of one site, degrees of latitude and
/// longitude.
const SAME_SITE_DEG: f64 = 0.1;

/// Largest difference between the axes of one coordinate system at the middles of two scenes of a
/// site, degrees.
const SAME_NORTH_DEG: f64 = 0.5;

/// Place of a scene on Earth and the direction of its y axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Latitude, -90..=90, north positive.
    pub latitude_deg: f64,
    /// Longitude, -180..=180, east positive.
    pub longitude_deg: f64,
    /// Direction of y clockwise from true north: the convergence of the grid plus the rotation of
    /// the model.
    pub convergence_deg: f64,
    /// Horizontal coordinate reference system, if the place follows from one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epsg: Option<u32>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { latitude_deg, longitude_deg, epsg, .. } = self;
        write!(f, "latitude {latitude_deg:.4}, longitude {longitude_deg:.4}, y {}", self.y())?;
        epsg.map_or(Ok(()), |epsg| write!(f, ", EPSG:{epsg}"))
    }
}

impl Place {
    /// Returns the direction of y in words: `0.73 degrees west of true north`.
    fn y(&self) -> String {
        let (size, side) = (self.convergence_deg.abs(), if self.convergence_deg < 0.0 { "west" } else { "east" });
        match format!("{size:.2}") {
            none if none == "0.00" => "to true north".into(),
            size => format!("{size} degrees {side} of true north"),
        }
    }

    /// Returns a sentence on the angle by which suns are turned, if it is above 0.1 degrees.
    pub fn note(&self) -> Option<String> {
        let grid = self.epsg.map_or(String::new(), |epsg| format!(" in EPSG:{epsg}"));
        let noted = self.convergence_deg.abs() > NOTED_DEG;
        noted.then(|| format!("the y axis points {}{grid}: suns are turned by this angle", self.y()))
    }

    /// Returns true if two places are equal but for the last digits that are lost when they are
    /// written down.
    pub fn is_same(&self, other: &Place) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() < SAME_DEG;
        near(self.latitude_deg, other.latitude_deg)
            && near(self.longitude_deg, other.longitude_deg)
            && near(self.convergence_deg, other.convergence_deg)
            && self.epsg == other.epsg
    }

    /// Returns true if two scenes may belong to one site, in coordinates of one system; `None` is a
    /// scene without a place.
    pub fn is_one_site(before: Option<&Place>, after: Option<&Place>) -> bool {
        let near = |a: f64, b: f64, most: f64| (a - b).abs() <= most;
        match (before, after) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                a.epsg == b.epsg
                    && near(a.latitude_deg, b.latitude_deg, SAME_SITE_DEG)
                    && near(a.longitude_deg, b.longitude_deg, SAME_SITE_DEG)
                    && near(a.convergence_deg, b.convergence_deg, SAME_NORTH_DEG)
            }
            _ => false,
        }
    }

    /// Returns the great-circle distance to another place, km (haversine formula, on a sphere of
    /// 6371 km; good to 0.5 %).
    pub fn distance_km(&self, latitude_deg: f64, longitude_deg: f64) -> f64 {
        let (a, b) = (self.latitude_deg.to_radians(), latitude_deg.to_radians());
        let half = |angle: f64| (0.5 * angle).sin().powi(2);
        let h = half(b - a) + a.cos() * b.cos() * half((longitude_deg - self.longitude_deg).to_radians());
        2.0 * 6371.0 * h.clamp(0.0, 1.0).sqrt().asin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Convergences of -0.73, -0.004 and 30 degrees are put in words with their side. An angle of
    /// 0.1 degrees is not noted. Of 3 changed places, 1 is the same.
    #[test]
    fn convergences_are_put_in_words() {
        let place = |convergence_deg, epsg| Place { latitude_deg: 52.0, longitude_deg: 4.0, convergence_deg, epsg };
        let grid = place(-0.73, Some(28992));
        assert_eq!(
            grid.to_string(),
            "latitude 52.0000, longitude 4.0000, y 0.73 degrees west of true north, EPSG:28992"
        );
        assert!(
            grid.note().expect("noted").starts_with("the y axis points 0.73 degrees west of true north in EPSG:28992")
        );
        assert!(
            place(30.0, None)
                .note()
                .expect("noted")
                .contains("the y axis points 30.00 degrees east of true north: suns")
        );
        assert!(place(-0.004, None).to_string().ends_with("y to true north"));
        assert_eq!(place(0.1, None).note(), None);
        let same = [place(-0.73 + 1e-12, Some(28992)), place(-0.7301, Some(28992)), place(-0.73, None)];
        assert_eq!(same.iter().filter(|other| grid.is_same(other)).count(), 1);
    }

    /// A scene that grew by a kilometre belongs to the site. One with another system, another town,
    /// another north, no number or no place does not: 1 of 6 belongs. Two scenes without a place
    /// may belong together.
    #[test]
    fn only_scenes_of_one_place_belong_to_a_site() {
        let here = Place { latitude_deg: 52.07, longitude_deg: 4.3, convergence_deg: 0.4, epsg: Some(28992) };
        let grown = Place { latitude_deg: 52.08, convergence_deg: 0.41, ..here };
        let others = [
            Some(grown),
            Some(Place { epsg: Some(7415), ..here }),
            Some(Place { latitude_deg: 52.37, ..here }),
            Some(Place { convergence_deg: 10.0, ..here }),
            Some(Place { longitude_deg: f64::NAN, ..here }),
            None,
        ];
        let one = others.map(|other| Place::is_one_site(Some(&here), other.as_ref()));
        assert_eq!(one, [true, false, false, false, false, false]);
        assert!(Place::is_one_site(None, None));
    }
}
