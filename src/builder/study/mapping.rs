//! Hemisphere maps for a study: texels of a square -> rays and their weights. In: a texel of n x n.
//! Out: its direction about the normal z, its solid angle, and its form factor weight, solid angle
//! x cosine / pi.
//!
//! Archives only hold the map of equal solid angles, [`heliotile_core::hemisphere`]. The other maps
//! are for comparison.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3};

use heliotile_core::hemisphere::{HEMISPHERE_SR, texel_direction};

/// Map from the texels of a square to the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HemisphereMapping {
    /// Columns of equal longitude about the normal, rows of equal angle from it.
    LongitudeLatitude,
    /// Texels of equal solid angle.
    SolidAngle,
    /// Texels of equal solid angle x cosine: their rays have equal weights.
    Cosine,
}

/// Ray of a hemisphere map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedRay {
    /// Unit vector, z >= 0 along the normal.
    pub direction: DVec3,
    /// Solid angle x cosine / pi: the form factor of a surface that only this ray hits.
    pub weight: f64,
}

impl HemisphereMapping {
    /// All mappings, in the order of their numbers.
    pub const ALL: [HemisphereMapping; 3] =
        [HemisphereMapping::LongitudeLatitude, HemisphereMapping::SolidAngle, HemisphereMapping::Cosine];

    /// Returns the name of the map in options and tables.
    pub fn name(self) -> &'static str {
        match self {
            HemisphereMapping::LongitudeLatitude => "longitude-latitude",
            HemisphereMapping::SolidAngle => "solid-angle",
            HemisphereMapping::Cosine => "cosine",
        }
    }

    /// Returns the direction of the centre of a texel.
    pub fn direction(self, column: usize, row: usize, n: usize) -> DVec3 {
        let equal_solid_angle = || texel_direction(column, row, n, DVec2::splat(0.5));
        match self {
            HemisphereMapping::LongitudeLatitude => {
                let (longitude, angle) = (2.0 * PI * (column as f64 + 0.5) / n as f64, ring(row as f64 + 0.5, n));
                DVec3::new(angle.sin() * longitude.cos(), angle.sin() * longitude.sin(), angle.cos())
            }
            HemisphereMapping::SolidAngle => equal_solid_angle(),
            HemisphereMapping::Cosine => {
                // The same point of the unit disc, of radius sqrt(1 - z), lifted straight up to the
                // sphere in place of Shirley's and Chiu's lift. By Nusselt's analogue equal areas
                // of the disc are equal form factors.
                let d = equal_solid_angle();
                let flat = d.truncate().normalize_or_zero() * (1.0 - d.z).max(0.0).sqrt();
                flat.extend(d.z.sqrt())
            }
        }
    }

    /// Returns the solid angle of a texel, sr.
    pub fn solid_angle_sr(self, column: usize, row: usize, n: usize) -> f64 {
        match self {
            HemisphereMapping::LongitudeLatitude => {
                2.0 * PI / n as f64 * (ring(row as f64, n).cos() - ring(row as f64 + 1.0, n).cos())
            }
            HemisphereMapping::SolidAngle => HEMISPHERE_SR / (n * n) as f64,
            HemisphereMapping::Cosine => PI / (n * n) as f64 / self.direction(column, row, n).z,
        }
    }

    /// Returns all rays of n x n texels, row-major. Their weights sum to 1; for the first two maps
    /// only within the error of a sum over centres.
    pub fn rays(self, n: usize) -> Vec<MappedRay> {
        let ray = |(column, row)| {
            let direction = self.direction(column, row, n);
            MappedRay { direction, weight: self.solid_angle_sr(column, row, n) * direction.z / PI }
        };
        (0..n * n).map(|texel| ray((texel % n, texel / n))).collect()
    }
}

/// Returns the angle between the normal and the edge between two rows, radians.
fn ring(row: f64, n: usize) -> f64 {
    FRAC_PI_2 * row / n as f64
}

impl fmt::Display for HemisphereMapping {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for HemisphereMapping {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || {
            let names = HemisphereMapping::ALL.map(HemisphereMapping::name).join(", ");
            format!("there is no map `{}`: give some of {names}, with commas between them", text.trim())
        };
        HemisphereMapping::ALL.into_iter().find(|mapping| mapping.name() == text.trim()).ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights sum to 1 in 3 maps of N = 16 to 64 squared texels: within 1e-12 in the cosine map,
    /// whose weights are all 1 / N, within 0.32 / N by longitude and latitude and within 2.1 / N by
    /// solid angle (cosines at centres). In the last two, solid angles sum to 2 pi within 1e-12.
    #[test]
    fn weights_sum_to_1_in_every_map() {
        for (mapping, n) in HemisphereMapping::ALL.into_iter().flat_map(|m| [16, 32, 64].map(|n| (m, n))) {
            let rays = mapping.rays(n);
            let (sum, texels) = (rays.iter().map(|ray| ray.weight).sum::<f64>(), (n * n) as f64);
            assert!(rays.iter().all(|ray| (ray.direction.length() - 1.0).abs() < 1e-12 && ray.direction.z > 0.0));
            let bound = match mapping {
                HemisphereMapping::LongitudeLatitude => 0.32 / texels,
                HemisphereMapping::SolidAngle => 2.1 / texels,
                HemisphereMapping::Cosine => 1e-12,
            };
            assert!((sum - 1.0).abs() < bound, "{mapping} {n}: {sum}");
            if mapping == HemisphereMapping::Cosine {
                assert!(rays.iter().all(|ray| (ray.weight * texels - 1.0).abs() < 1e-12));
            } else {
                let whole: f64 = (0..n * n).map(|t| mapping.solid_angle_sr(t % n, t / n, n)).sum();
                assert!((whole / HEMISPHERE_SR - 1.0).abs() < 1e-12, "{mapping} {n}: {whole}");
            }
        }
    }

    /// Names come back as they were written, 3 of 3. An unknown one is refused with all three
    /// names.
    #[test]
    fn names_of_maps_come_back_as_written() {
        for mapping in HemisphereMapping::ALL {
            assert_eq!(mapping.to_string().parse(), Ok(mapping));
        }
        let message = "fisheye".parse::<HemisphereMapping>().expect_err("unknown");
        assert!(HemisphereMapping::ALL.into_iter().all(|mapping| message.contains(mapping.name())), "{message}");
    }
}
