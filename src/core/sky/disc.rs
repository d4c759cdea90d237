//! The sun's disc in a sky texture. In: a sun direction. Out: the fine texels that it covers, and
//! their shares of it. All receivers share them, since sky textures are in the world frame.

use std::f32::consts::FRAC_PI_4;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use pulp::Arch;

use crate::hemisphere::Frame;
use crate::units::SUN_RADIUS_RAD;

/// Points on the disc in textures of up to 1024 texels a side, where it covers some 11 texels.
static POINTS: LazyLock<DiscPoints<64>> = LazyLock::new(DiscPoints::new);

/// Points on the disc in finer textures. 64 points on its 45 or 180 texels err by as much as the
/// bits themselves: 2.8 % of the disc at an edge across it, RMS, where areas err by 2.1 %.
static MORE_POINTS: LazyLock<DiscPoints<256>> = LazyLock::new(DiscPoints::new);

/// Components of `N` points' directions in the frame of the disc's centre.
struct DiscPoints<const N: usize> {
    u: [f32; N],
    v: [f32; N],
    n: [f32; N],
}

impl<const N: usize> DiscPoints<N> {
    /// Returns sunflower points: equal areas of the disc (Vogel 1979) on the plane that touches the
    /// sphere at its centre, projected onto the sphere.
    fn new() -> Self {
        let offset = |i: usize| {
            let radius = SUN_RADIUS_RAD * ((i as f64 + 0.5) / N as f64).sqrt();
            // The golden angle, pi (3 - sqrt(5)), in radians.
            let offset = DVec2::from_angle(i as f64 * 2.399_963_229_728_653) * radius;
            offset.extend(1.0) / (1.0 + offset.length_squared()).sqrt()
        };
        let axis = |axis: usize| std::array::from_fn(|i| offset(i)[axis] as f32);
        DiscPoints { u: axis(0), v: axis(1), n: axis(2) }
    }
}

/// Iterates over directions of points of equal solid angle on the disc around a sun, if they are
/// above the horizon.
pub fn disc_directions(sun: DVec3) -> impl Iterator<Item = DVec3> {
    let frame = Frame::new(sun);
    let DiscPoints { u, v, n } = &*POINTS;
    let points = u.iter().zip(v).zip(n).map(|((u, v), n)| DVec3::new(f64::from(*u), f64::from(*v), f64::from(*n)));
    points.map(move |point| frame.to_world(point)).filter(|direction| direction.z > 0.0)
}

/// Returns the texels (column, row) of a square of `side` texels under the disc, sorted, and their
/// shares of the disc's part above the horizon (sum 1). Returns none for a sun whose centre is at
/// or below the horizon.
pub fn disc_texels(direction: DVec3, side: usize) -> Vec<(u32, u32, f32)> {
    if direction.z <= 0.0 {
        return Vec::new();
    }
    if side > 1024 { texels_of(&MORE_POINTS, direction, side) } else { texels_of(&POINTS, direction, side) }
}

fn texels_of<const N: usize>(points: &DiscPoints<N>, direction: DVec3, side: usize) -> Vec<(u32, u32, f32)> {
    let frame = Frame::new(direction);
    let mut texels = [None; N];
    Arch::new().dispatch(|| place(points, &frame, side, &mut texels));
    let seen = || texels.iter().flatten();
    let Some(&first) = seen().next() else { return Vec::new() };
    let (low, high) = seen()
        .fold((first, first), |(low, high), t| ((low.0.min(t.0), low.1.min(t.1)), (high.0.max(t.0), high.1.max(t.1))));
    // Few texels lie under a disc, so points are counted on the box around them.
    let rows = (high.1 - low.1 + 1) as usize;
    let mut counts = vec![0_u16; (high.0 - low.0 + 1) as usize * rows];
    seen().for_each(|t| counts[(t.0 - low.0) as usize * rows + (t.1 - low.1) as usize] += 1);
    let share = 1.0 / seen().count() as f32;
    let found = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    found.map(|(i, count)| (low.0 + (i / rows) as u32, low.1 + (i % rows) as u32, f32::from(*count) * share)).collect()
}

/// Computes [`crate::hemisphere::texel_of`] for all points at once, in f32, with an error of 1e-4
/// texels of 1024. A point below the horizon gets `None`: that part of the disc sends nothing, and
/// DNI is measured without it.
#[inline(always)]
fn place<const N: usize>(points: &DiscPoints<N>, frame: &Frame, side: usize, texels: &mut [Option<(u32, u32)>; N]) {
    let [u, v, n] = [frame.u, frame.v, frame.n].map(|axis| axis.as_vec3());
    let (mut columns, mut rows, mut heights) = ([0.0_f32; N], [0.0_f32; N], [0.0_f32; N]);
    for i in 0..N {
        let [of_u, of_v, of_n] = [points.u[i], points.v[i], points.n[i]];
        let x = n.x * of_n + u.x * of_u + v.x * of_v;
        let y = n.y * of_n + u.y * of_u + v.y * of_v;
        let z = n.z * of_n + u.z * of_u + v.z * of_v;
        // 1 - z without its rounding error near the zenith.
        let r = ((x * x + y * y) / (1.0 + z.max(0.0))).sqrt();
        let wide = x.abs() >= y.abs();
        let (major, minor) = if wide { (x, y) } else { (y, x) };
        let along = r.copysign(major);
        let across = along * arctangent(if major == 0.0 { 0.0 } else { minor / major }) / FRAC_PI_4;
        let (a, b) = if wide { (along, across) } else { (across, along) };
        columns[i] = (a + 1.0) * 0.5 * side as f32;
        rows[i] = (b + 1.0) * 0.5 * side as f32;
        heights[i] = z;
    }
    let last = side.saturating_sub(1) as u32;
    for (texel, ((column, row), z)) in texels.iter_mut().zip(columns.into_iter().zip(rows).zip(heights)) {
        // The cast turns numbers below 0 into 0.
        *texel = (z > 0.0).then_some(((column as u32).min(last), (row as u32).min(last)));
    }
}

/// Returns the arctangent for |x| <= 1, error 2e-8: Abramowitz and Stegun, "Handbook of
/// mathematical functions", 1964, 4.4.49.
#[inline(always)]
fn arctangent(x: f32) -> f32 {
    const SERIES: [f32; 8] = [
        -0.333_331_45,
        0.199_935_51,
        -0.142_089,
        0.106_562_64,
        -0.075_289_64,
        0.042_909_614,
        -0.016_165_737,
        0.002_866_225_7,
    ];
    let square = x * x;
    x * (1.0 + square * SERIES.iter().rev().fold(0.0, |sum, term| sum * square + term))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::hemisphere::{texel_direction, texel_of};
    use crate::units::direction_from_degrees;

    /// The disc's shares sum to 1 and it covers 8 to 24 texels of a 1024 texture at 2 to 90 degrees
    /// of altitude, none at 0.
    #[test]
    fn the_disc_covers_8_to_24_texels() {
        for altitude in [2.0, 20.0, 45.0, 89.0, 90.0] {
            let disc = disc_texels(direction_from_degrees(200.0, altitude), 1024);
            let sum: f32 = disc.iter().map(|t| t.2).sum();
            assert!((sum - 1.0).abs() < 1e-5);
            assert!((8..=24).contains(&disc.len()), "{altitude}: {}", disc.len());
        }
        assert!(disc_texels(direction_from_degrees(200.0, 0.0), 1024).is_empty());
    }

    /// All but 1 in 2,000 points of 3,000 discs lie in the texels of their directions in f64. The
    /// discs include some at the zenith, on the creases of the map and on the horizon.
    #[test]
    fn points_lie_where_their_directions_do() {
        let (mut points, mut wrong) = (0, 0);
        for i in 0..3000_u32 {
            let altitude = if i % 10 == 0 { 90.0 - f64::from(i) * 1e-4 } else { 0.1 + f64::from(i) * 0.029 };
            let sun = direction_from_degrees(f64::from(i % 16) * 22.5 + f64::from(i % 3) * 7.0, altitude);
            let frame = Frame::new(sun);
            let mut texels = [None; 64];
            place(&POINTS, &frame, 1024, &mut texels);
            for (i, texel) in texels.into_iter().enumerate() {
                let [u, v, n] = [POINTS.u[i], POINTS.v[i], POINTS.n[i]].map(f64::from);
                let d = (frame.n * n + frame.u * u + frame.v * v).normalize();
                let (column, row) = texel_of(d, 1024);
                points += 1;
                wrong += usize::from(texel != (d.z > 0.0).then_some((column as u32, row as u32)));
            }
        }
        assert!(points == 192_000 && wrong < points / 2000, "{wrong} of {points}");
    }

    /// The share of a disc that an edge lets pass is off by at most 6.1, 2.4 and 1.2 % RMS in
    /// textures of 1024, 2048 and 4096. Edges are planes through the viewer that cross discs
    /// anywhere, at any angle; the closed form is the segment of a circle.
    #[test]
    fn edges_across_the_disc_hide_segments_of_a_circle() {
        for (side, most) in [(1024, 0.061), (2048, 0.024), (4096, 0.012)] {
            let (mut squares, discs) = (0.0, 4000);
            for i in 0..discs {
                let share = |golden: f64| (f64::from(i) * golden + 0.37).fract();
                let sun = direction_from_degrees(360.0 * share(0.618_034), 5.0 + 80.0 * share(0.754_878));
                let frame = Frame::new(sun);
                let (turn, offset) = (DVec2::from_angle(TAU * share(0.569_840)), 2.0 * share(0.414_214) - 1.0);
                let edge = frame.u * turn.x + frame.v * turn.y - frame.n * (offset * SUN_RADIUS_RAD);
                let seen = disc_texels(sun, side).into_iter();
                let middle = |t: &(u32, u32, f32)| texel_direction(t.0 as usize, t.1 as usize, side, DVec2::splat(0.5));
                let lit = |t: &(u32, u32, f32)| middle(t).dot(edge) > 0.0;
                let visible: f64 = seen.filter(lit).map(|t| f64::from(t.2)).sum();
                let segment = (offset.acos() - offset * (1.0 - offset * offset).sqrt()) / PI;
                squares += (visible - segment).powi(2);
            }
            let rms = (squares / f64::from(discs)).sqrt();
            assert!(rms < most && rms > most / 2.0, "{side}: {rms}");
        }
    }
}
