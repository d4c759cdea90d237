//! The sun's disc in a sky texture. In: a sun direction. Out: which fine texels it covers and by how much. Shared by all
//! receivers: the sky textures are in the world frame.

use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use crate::hemisphere::{Frame, texel_of};
use crate::units::SUN_RADIUS_RAD;

/// Points of the disc.
const DISC_POINTS: usize = 64;

/// Sunflower points: equal areas of the disc (Vogel 1979), on the plane that touches the sphere at its centre.
static OFFSETS: LazyLock<[DVec2; DISC_POINTS]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let radius = SUN_RADIUS_RAD * ((i as f64 + 0.5) / DISC_POINTS as f64).sqrt();
        DVec2::from_angle(i as f64 * 2.399_963_229_728_653) * radius
    })
});

/// Texels (column, row) of a square of `side` texels under the disc, sorted, and their shares of its part above the horizon (sum 1);
/// none for a sun whose centre is at or below the horizon.
pub fn disc_texels(direction: DVec3, side: usize) -> Vec<(u32, u32, f32)> {
    if direction.z <= 0.0 {
        return Vec::new();
    }
    let frame = Frame::of(direction);
    let mut texels: Vec<(u32, u32)> = Vec::with_capacity(DISC_POINTS);
    for offset in OFFSETS.iter() {
        let d = (frame.n + frame.u * offset.x + frame.v * offset.y).normalize();
        // The part of the disc below the horizon sends nothing, and DNI is measured without it.
        if d.z > 0.0 {
            let (column, row) = texel_of(d, side);
            texels.push((column as u32, row as u32));
        }
    }
    texels.sort_unstable();
    let share = 1.0 / texels.len().max(1) as f32;
    texels.chunk_by(|a, b| a == b).map(|g| (g[0].0, g[0].1, g.len() as f32 * share)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// The disc's shares sum to 1 and it covers 8 to 24 texels of a 1024 texture at 2 to 90 degrees of altitude; none at or below 0.
    #[test]
    fn disc() {
        for altitude in [2.0, 20.0, 45.0, 89.0, 90.0] {
            let disc = disc_texels(direction_from_degrees(200.0, altitude), 1024);
            let sum: f32 = disc.iter().map(|t| t.2).sum();
            assert!((sum - 1.0).abs() < 1e-5);
            assert!((8..=24).contains(&disc.len()), "{altitude}: {}", disc.len());
        }
        assert!(disc_texels(direction_from_degrees(200.0, 0.0), 1024).is_empty());
    }
}
