//! Conversion between directions of a hemisphere and texels of the equal-solid-angle square, and
//! the local frame of a normal.
//!
//! In: texture coordinates or unit directions. Out: the other of the two. Shirley and Chiu, "A low
//! distortion map between disk and square", Journal of Graphics Tools 2(3), 1997, followed by the
//! lift z = 1 - r^2, which keeps areas: every texel of an n x n texture covers 2 pi / n^2 sr.

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// Returns the sine and cosine for |x| <= pi/4 by their Taylor series, error below 1e-16. The
/// functions of the C library differ in the last bit between processors (with and without FMA), and
/// archives must not.
fn sin_cos_octant(x: f64) -> (f64, f64) {
    // Powers of -1 over factorials: x^3, x^5, ... and x^2, x^4, ...
    const SIN: [f64; 8] = [
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
        1.0 / 355_687_428_096_000.0,
    ];
    const COS: [f64; 8] = [
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 20_922_789_888_000.0,
    ];
    let q = x * x;
    let series = |terms: [f64; 8]| 1.0 + q * terms.iter().rev().fold(0.0, |sum, term| sum * q + term);
    (x * series(SIN), series(COS))
}

/// Mixes `value` into `state` by the 64-bit finaliser of splitmix64 (Steele, Lea, Flood 2014). The
/// result seeds jitter.
pub fn mix(state: u64, value: u64) -> u64 {
    let mut z = (state ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Returns a uniform number in [0, 1) made of the upper 53 bits of a mixed value.
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns the point of the unit square that `seed` draws for item `index`.
pub fn jitter(seed: u64, index: u64) -> DVec2 {
    let a = mix(seed, index);
    DVec2::new(unit(a), unit(mix(a, 1)))
}

/// Share of a texel's side within which rays of hit and probe textures are drawn. A value of a
/// texel is interpolated between the middles of texels, so rays near the middle blur less. Error of
/// reflected sunlight and bytes on eight drawn sites at `standard`: 8 to 14 % and 3 % lower than
/// with rays from the whole texel (`tools/accuracy/rungs.py --before`). Rays from the middle alone
/// err in other ways.
const RAY_SPREAD: f64 = 0.5;

/// Returns the direction (hemisphere frame) of the ray through a texel of an n x n hit or probe
/// texture: drawn by `seed` around the middle of the texel.
pub fn ray_direction(texel: usize, n: usize, seed: u64) -> DVec3 {
    let middle = DVec2::splat(0.5);
    texel_direction(texel % n, texel / n, n, middle + RAY_SPREAD * (jitter(seed, texel as u64) - middle))
}

/// Returns point `index` of a sequence that covers the unit square evenly however many points are
/// taken: the plane's analogue of the golden ratio (Roberts 2018, R2).
pub fn r2(index: f64, start: DVec2) -> DVec2 {
    (index * DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3) + start).fract()
}

/// Solid angle of a hemisphere, sr.
pub const HEMISPHERE_SR: f64 = 2.0 * PI;

/// Returns the direction (unit, z >= 0, hemisphere frame) of a point of the unit square. The point
/// (0, 0) is the corner at u = v = -1 (south-west in the world frame), u grows with x (east), v
/// with y (north).
pub fn direction_of(square: DVec2) -> DVec3 {
    let a = 2.0 * square.x - 1.0;
    let b = 2.0 * square.y - 1.0;
    if a == 0.0 && b == 0.0 {
        return DVec3::Z;
    }
    // The angle is measured from the dominant axis, so it stays within an octant and the quotient
    // is at most 1.
    let (r, other, x_dominant) = if a.abs() >= b.abs() { (a, b, true) } else { (b, a, false) };
    let (sin, cos) = sin_cos_octant(FRAC_PI_4 * (other / r));
    let z = 1.0 - r * r;
    // From z = 1 - r^2: 1 - z^2 = r^2 (2 - r^2). The sign of r stays, so the direction falls into
    // the quarter of the dominant axis.
    let horizontal = r * (2.0 - r * r).max(0.0).sqrt();
    if x_dominant {
        DVec3::new(horizontal * cos, horizontal * sin, z.max(0.0))
    } else {
        DVec3::new(horizontal * sin, horizontal * cos, z.max(0.0))
    }
}

/// Returns a cosine-distributed direction about z for a point of the unit square: Malley's method
/// over Shirley and Chiu's disc.
pub fn cosine_direction_of(square: DVec2) -> DVec3 {
    // The equal-solid-angle lift has z = 1 - r^2; the cosine lift of the same disc point has z =
    // sqrt(1 - r^2).
    let d = direction_of(square);
    let r2 = (1.0 - d.z).clamp(0.0, 1.0);
    let stretch = 1.0 / (2.0 - r2).sqrt();
    DVec3::new(d.x * stretch, d.y * stretch, (1.0 - r2).sqrt())
}

/// Returns the azimuth, turns clockwise from north in 0..=1, and z of the direction of a point of
/// the unit square. It needs no trigonometry, because the map is linear in the azimuth within each
/// quarter.
pub fn azimuth_and_z(square: DVec2) -> (f64, f64) {
    let a = 2.0 * square.x - 1.0;
    let b = 2.0 * square.y - 1.0;
    let (r, turns) = if a == 0.0 && b == 0.0 {
        (0.0, 0.0)
    } else if a.abs() >= b.abs() {
        (a, if a > 0.0 { 0.25 } else { 0.75 } - 0.125 * (b / a))
    } else {
        (b, if b > 0.0 { 1.0 } else { 0.5 } + 0.125 * (a / b))
    };
    (if turns > 1.0 { turns - 1.0 } else { turns }, (1.0 - r * r).max(0.0))
}

/// Inverse of [`direction_of`]: returns the point of the unit square of a unit direction. A
/// direction below the horizon (z < 0) is clamped to the rim above it.
pub fn square_of(direction: DVec3) -> DVec2 {
    let r = (1.0 - direction.z.clamp(0.0, 1.0)).max(0.0).sqrt();
    let (x, y) = (direction.x, direction.y);
    if r == 0.0 || (x == 0.0 && y == 0.0) {
        return DVec2::splat(0.5);
    }
    // The octant is picked on the dominant axis, so the quotient below is finite and at most 1.
    let (a, b) = if x.abs() >= y.abs() {
        let a = r.copysign(x);
        (a, a * (y / x).atan() / FRAC_PI_4)
    } else {
        let b = r.copysign(y);
        (b * (x / y).atan() / FRAC_PI_4, b)
    };
    DVec2::new(((a + 1.0) * 0.5).clamp(0.0, 1.0), ((b + 1.0) * 0.5).clamp(0.0, 1.0))
}

/// Returns the texel (column, row) of an n x n texture that a unit direction falls in; row 0 is at
/// v = 0.
pub fn texel_of(direction: DVec3, n: usize) -> (usize, usize) {
    let p = square_of(direction) * n as f64;
    ((p.x as usize).min(n - 1), (p.y as usize).min(n - 1))
}

/// Returns the direction at the position (0..1, 0..1) inside texel (column, row) of an n x n
/// texture.
pub fn texel_direction(column: usize, row: usize, n: usize, inside: DVec2) -> DVec3 {
    direction_of((DVec2::new(column as f64, row as f64) + inside) / n as f64)
}

/// Returns bit `index` of a packed texture; bytes hold their lowest bit first.
#[inline]
pub fn bit(bits: &[u8], index: usize) -> bool {
    bits[index / 8] >> (index % 8) & 1 == 1
}

/// Iterates over the texels (column, row) of an n x n texture in blocks of 4 x 4, so that
/// neighbours in the list are neighbours on the sphere.
pub fn texels_in_blocks(n: usize) -> impl Iterator<Item = (usize, usize)> {
    let blocks = n.div_ceil(4);
    (0..blocks * blocks * 16)
        .map(move |i| {
            let (block, inside) = (i / 16, i % 16);
            (block % blocks * 4 + inside % 4, block / blocks * 4 + inside / 4)
        })
        .filter(move |&(column, row)| column < n && row < n)
}

/// Returns the unit directions of all texel centres of an n x n texture, row-major, texel 0 =
/// (column 0, row 0).
pub fn texel_centres(n: usize) -> Vec<DVec3> {
    (0..n * n).map(|t| texel_direction(t % n, t / n, n, DVec2::splat(0.5))).collect()
}

/// Right-handed frame of a unit normal: `u` horizontal, `v` up the surface, `n` the normal. For a
/// vertical normal u = east, v = north (up) or south (down).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Horizontal, unit: the direction in which columns of a texture grow.
    pub u: DVec3,
    /// Up the surface, unit: the direction in which rows grow.
    pub v: DVec3,
    /// The normal, unit.
    pub n: DVec3,
}

impl Frame {
    /// Returns the frame of a unit normal.
    pub fn new(normal: DVec3) -> Self {
        let horizontal = (normal.x * normal.x + normal.y * normal.y).sqrt();
        // Below this tilt (6e-5 deg) the horizontal direction is rounding noise.
        let u =
            if horizontal < 1e-6 { DVec3::X } else { DVec3::new(-normal.y / horizontal, normal.x / horizontal, 0.0) };
        let v = normal.cross(u).normalize();
        Frame { u: v.cross(normal), v, n: normal }
    }

    /// Returns the world direction of a direction given in this frame.
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.u * local.x + self.v * local.y + self.n * local.z
    }

    /// Returns the direction in this frame of a direction given in the world frame.
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(self.u.dot(world), self.v.dot(world), self.n.dot(world))
    }
}

/// Returns the four texels and weights (sum 1) that a bilinear lookup in an n x n texture reads;
/// the lookup is clamped at the horizon.
pub fn bilinear(direction: DVec3, n: usize) -> [(usize, f64); 4] {
    let p = square_of(direction) * n as f64 - 0.5;
    let last = (n - 1) as f64;
    let (x, y) = (p.x.clamp(0.0, last), p.y.clamp(0.0, last));
    // The last pair of texels starts at n - 2, so the second texel of a pair always exists, unless
    // n is 1.
    let (x0, y0) = (x.floor().min((n.max(2) - 2) as f64), y.floor().min((n.max(2) - 2) as f64));
    let (fx, fy) = (x - x0, y - y0);
    let (c, r) = (x0 as usize, y0 as usize);
    let (c1, r1) = ((c + 1).min(n - 1), (r + 1).min(n - 1));
    [
        (r * n + c, (1.0 - fx) * (1.0 - fy)),
        (r * n + c1, fx * (1.0 - fy)),
        (r1 * n + c, (1.0 - fx) * fy),
        (r1 * n + c1, fx * fy),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square to hemisphere and back is the identity to 1e-7, over the whole square with its
    /// diagonals and axes.
    #[test]
    fn square_to_hemisphere_and_back_is_the_identity() {
        let mut worst = 0.0_f64;
        for i in 0..=64 {
            for j in 0..=64 {
                let p = DVec2::new(f64::from(i) / 64.0, f64::from(j) / 64.0);
                let d = direction_of(p);
                assert!((d.length() - 1.0).abs() < 1e-12);
                worst = worst.max((direction_of(square_of(d)) - d).length());
            }
        }
        assert!(worst < 1e-7, "{worst}");
    }

    /// Texels have equal solid angle: the cosine-weighted mean over the texels of a horizontal
    /// surface is pi within 2e-4.
    #[test]
    fn texels_have_equal_solid_angle() {
        let n = 128;
        let sum: f64 = texel_centres(n).iter().map(|d| d.z).sum();
        let integral = sum * HEMISPHERE_SR / (n * n) as f64;
        assert!((integral - PI).abs() < 2e-4 * PI, "{integral}");
    }

    /// Bilinear weights sum to 1 and reproduce the texel's own value at its centre.
    #[test]
    fn bilinear_weights_sum_to_1() {
        for (t, d) in texel_centres(16).into_iter().enumerate() {
            let corners = bilinear(d, 16);
            let sum: f64 = corners.iter().map(|c| c.1).sum();
            assert!((sum - 1.0).abs() < 1e-12);
            let own: f64 = corners.iter().filter(|c| c.0 == t).map(|c| c.1).sum();
            assert!(own > 1.0 - 1e-9, "texel {t}: {own}");
        }
    }

    /// Frames are right-handed and orthonormal to 1e-12, also for vertical normals. A direction
    /// that goes to the world frame and back is unchanged.
    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for n in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(1e-9, 0.0, 1.0), DVec3::new(0.3, -0.5, 0.81)] {
            let f = Frame::new(n.normalize());
            assert!((f.u.cross(f.v) - f.n).length() < 1e-12);
            assert!(f.u.z.abs() < 2e-9);
            let local = DVec3::new(0.2, -0.3, 0.9);
            assert!((f.to_local(f.to_world(local)) - local).length() < 1e-12);
        }
    }
}
