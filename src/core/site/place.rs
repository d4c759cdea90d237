//! Where on Earth a site lies.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Smaller angles between grid and true north are not worth a word: the sun's disc is 0.5 degrees wide.
const NOTED_CONVERGENCE_DEG: f64 = 0.1;

/// Where a scene lies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// -90..=90, north positive.
    pub latitude_deg: f64,
    /// -180..=180, east positive.
    pub longitude_deg: f64,
    /// Direction of grid north (y) clockwise from true north.
    pub convergence_deg: f64,
    /// Horizontal coordinate reference system, if that is how the place is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epsg: Option<u32>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { latitude_deg, longitude_deg, convergence_deg, epsg } = self;
        write!(
            f,
            "latitude {latitude_deg:.4}, longitude {longitude_deg:.4}, grid north {convergence_deg:.2} degrees east of true north"
        )?;
        epsg.map_or(Ok(()), |epsg| write!(f, ", EPSG:{epsg}"))
    }
}

impl Place {
    /// Says how far y is from true north, by which the sun is placed.
    pub fn warning(&self) -> Option<String> {
        let (size, side) = (self.convergence_deg.abs(), if self.convergence_deg < 0.0 { "west" } else { "east" });
        (size > NOTED_CONVERGENCE_DEG).then(|| {
            format!("grid north lies {size:.2} degrees {side} of true north; y is taken for north, so the sun is off by that")
        })
    }

    /// Great-circle distance to another place, km (haversine formula, on a sphere of 6371 km; good to 0.5 %).
    pub fn distance_km(&self, latitude_deg: f64, longitude_deg: f64) -> f64 {
        let (a, b) = (self.latitude_deg.to_radians(), latitude_deg.to_radians());
        let half = |angle: f64| (0.5 * angle).sin().powi(2);
        let h = half(b - a) + a.cos() * b.cos() * half((longitude_deg - self.longitude_deg).to_radians());
        2.0 * 6371.0 * h.clamp(0.0, 1.0).sqrt().asin()
    }
}
