//! The sun's disc in the textures. In: a sun direction. Out: which texels of the sky texture it covers and by how much, and
//! where the response texture is read. Shared by all receivers: the sky textures are in the world frame.

use glam::DVec3;

use crate::hemisphere::{Frame, bilinear, texel_of};
use crate::units::SUN_RADIUS_RAD;

/// Points of the disc.
const DISC_POINTS: usize = 64;

/// One sun position, looked up once for all receivers.
#[derive(Clone, Debug)]
pub struct SunLookup {
    pub direction: DVec3,
    /// Texels (column, row) of the fine sky texture under the disc and their share of the visible disc (sum 1).
    pub disc: Vec<(u32, u32, f32)>,
    /// Corners of the bilinear lookup in the response texture.
    pub response: [(usize, f64); 4],
}

impl SunLookup {
    /// `None` for a sun whose centre is at or below the horizon.
    pub fn new(direction: DVec3, sky: usize, response: usize) -> Option<Self> {
        if direction.z <= 0.0 {
            return None;
        }
        let frame = Frame::of(direction);
        let mut texels: Vec<(u32, u32)> = Vec::with_capacity(DISC_POINTS);
        for i in 0..DISC_POINTS {
            // Sunflower points: equal areas of the disc (Vogel 1979).
            let radius = SUN_RADIUS_RAD * ((i as f64 + 0.5) / DISC_POINTS as f64).sqrt();
            let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
            let d = (frame.n + frame.u * (radius * cos) + frame.v * (radius * sin)).normalize();
            // The part of the disc below the horizon sends nothing, and DNI is measured without it.
            if d.z > 0.0 {
                let (column, row) = texel_of(d, sky);
                texels.push((column as u32, row as u32));
            }
        }
        texels.sort_unstable();
        let share = 1.0 / texels.len().max(1) as f32;
        let disc = texels.chunk_by(|a, b| a == b).map(|g| (g[0].0, g[0].1, g.len() as f32 * share)).collect();
        Some(SunLookup { direction, disc, response: bilinear(direction, response) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// The disc's shares sum to 1 and it covers 8 to 24 texels of a 1024 texture at 2 to 90 degrees of altitude; none at or below 0.
    #[test]
    fn disc() {
        for altitude in [2.0, 20.0, 45.0, 89.0, 90.0] {
            let sun = SunLookup::new(direction_from_degrees(200.0, altitude), 1024, 32);
            let disc = sun.map(|s| s.disc).unwrap_or_default();
            let sum: f32 = disc.iter().map(|t| t.2).sum();
            assert!((sum - 1.0).abs() < 1e-5);
            assert!((8..=24).contains(&disc.len()), "{altitude}: {}", disc.len());
        }
        assert!(SunLookup::new(direction_from_degrees(200.0, 0.0), 1024, 32).is_none());
    }
}
