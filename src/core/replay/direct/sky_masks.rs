//! The skies of a tile's receivers, bit by bit side by side. In: normals and decoded sky textures
//! of the receivers. Out: for each base texel, the receivers that see all of it in front of them,
//! and the receivers whose bits have to be read.

use glam::DVec3;
use pulp::Arch;

use crate::layers::sky::half_texel;
use crate::layers::sky_bitmap::{SkyBitmap, Texel};
use crate::sky::projection::Projection;
use crate::units::SUN_RADIUS_RAD;

/// Number of receivers side by side, which is the number of bits of a mask.
pub const LANES: usize = 64;

/// Largest distance of a texel's corner from its middle, in half texels: 2.17 in the corners of a
/// square with 128 texels a side, 2.04 with 16.
const REACH: f32 = 2.2;

/// Middles of the base texels of a sky, as f32 by axis, so that many texels are compared at a time.
pub struct TexelPlanes {
    side: usize,
    /// `[axis][texel]`: middle of the texel.
    axes: [Vec<f32>; 3],
    /// Largest distance of a texel's middle from a plane through the receiver at which part of the
    /// texel, or the middle of a sun whose disc reaches into the texel, may lie on the other side.
    reach: f32,
}

impl TexelPlanes {
    /// Takes the middles of the texels of a projection.
    pub fn new(projection: &Projection) -> Self {
        let axis = |axis: usize| projection.mean_directions.iter().map(|d| d[axis] as f32).collect();
        let reach = REACH * half_texel(projection.side()) as f32 + SUN_RADIUS_RAD as f32;
        TexelPlanes { side: projection.side(), axes: [axis(0), axis(1), axis(2)], reach }
    }

    /// Returns the bits of texels `first..first + count` that lie wholly in front of a surface, and
    /// of those that lie at least partly in front of it. `count` is at most 64.
    #[inline(always)]
    fn fronts(&self, normal: [f32; 3], first: usize, count: usize) -> (u64, u64) {
        let mut before = [0.0_f32; LANES];
        let [x, y, z] = [0, 1, 2].map(|axis| self.axes[axis].get(first..first + count).unwrap_or_default());
        for (((out, x), y), z) in before.iter_mut().zip(x).zip(y).zip(z) {
            *out = normal[0] * x + normal[1] * y + normal[2] * z;
        }
        let (mut whole, mut part) = (0_u64, 0_u64);
        for (lane, d) in before.iter().enumerate() {
            whole |= u64::from(*d > self.reach) << lane;
            part |= u64::from(*d >= -self.reach) << lane;
        }
        (whole, part)
    }
}

/// Masks of up to 64 receivers and their skies.
pub struct SkyMasks<'t> {
    /// `[texel]`: a bit for each receiver, set if the texel is open and wholly in front of the
    /// receiver.
    whole: Vec<u64>,
    /// `[texel]`: a bit for each receiver, set if the receiver sees the texel, but the texel is
    /// only partly open or the plane of the surface may cut it.
    partial: Vec<u64>,
    skies: &'t [SkyBitmap],
    normals: &'t [DVec3],
    side: usize,
}

impl<'t> SkyMasks<'t> {
    /// Builds the masks of at most [`LANES`] receivers, with one normal for each sky.
    pub fn new(planes: &TexelPlanes, normals: &'t [DVec3], skies: &'t [SkyBitmap]) -> Self {
        let side = planes.side;
        let stride = side.div_ceil(LANES);
        let (mut whole, mut partial) = (vec![0; side * side], vec![0; side * side]);
        Arch::new().dispatch(|| {
            for word in 0..side * stride {
                let (row, column) = (word / stride, word % stride * LANES);
                let count = (side - column).min(LANES);
                // Words of a sky run over texels; those of the masks run over receivers.
                let (mut wholes, mut partials) = ([0_u64; LANES], [0_u64; LANES]);
                for (lane, (normal, sky)) in normals.iter().zip(skies).take(LANES).enumerate() {
                    let (open, mixed) = sky.words_at(word);
                    if open | mixed != 0 {
                        let (front, part) = planes.fronts(normal.as_vec3().to_array(), row * side + column, count);
                        wholes[lane] = open & front;
                        partials[lane] = (open | mixed) & part & !wholes[lane];
                    }
                }
                for (masks, mut bits) in [(&mut whole, wholes), (&mut partial, partials)] {
                    if bits != [0; LANES] {
                        transpose(&mut bits);
                        masks[row * side + column..][..count].copy_from_slice(&bits[..count]);
                    }
                }
            }
        });
        SkyMasks { whole, partial, skies, normals, side }
    }

    /// Returns the number of receivers.
    pub fn receivers(&self) -> usize {
        self.normals.len().min(self.skies.len()).min(LANES)
    }

    /// Returns the normal of a receiver.
    pub fn normal(&self, receiver: usize) -> DVec3 {
        self.normals[receiver]
    }

    /// Returns the receivers that see all of a texel in front of them.
    #[inline]
    pub fn whole(&self, texel: usize) -> impl Iterator<Item = usize> {
        ones(self.whole[texel])
    }

    /// Returns the receivers that see part of a texel, or a texel that the plane of their surface
    /// may cut, each with its texel.
    #[inline]
    pub fn partial(&self, texel: usize) -> impl Iterator<Item = (usize, Texel<'t>)> {
        let (column, row) = (texel % self.side, texel / self.side);
        ones(self.partial[texel]).map(move |receiver| (receiver, self.skies[receiver].texel(column, row)))
    }
}

/// Returns the places of the set bits of a word, lowest first.
#[inline]
fn ones(word: u64) -> impl Iterator<Item = usize> {
    let next = |w: &u64| Some(w & w.wrapping_sub(1));
    std::iter::successors(Some(word), next).take_while(|w| *w != 0).map(|w| w.trailing_zeros() as usize)
}

/// Transposes 64 words of 64 bits: Warren, "Hacker's delight", 2012, section 7-3.
#[inline(always)]
fn transpose(bits: &mut [u64; LANES]) {
    let (mut half, mut mask) = (32, 0x0000_0000_ffff_ffff_u64);
    while half != 0 {
        for first in (0..LANES).filter(|i| i & half == 0) {
            let swap = (bits[first] >> half ^ bits[first + half]) & mask;
            bits[first] ^= swap << half;
            bits[first + half] ^= swap;
        }
        half /= 2;
        mask ^= mask << half;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{HEMISPHERE_SR, jitter};
    use crate::layers::bits::BitSquare;
    use crate::sky::patches::Patches;
    use glam::DVec2;

    /// After the transposition of 64 random words, bit j of word i is the former bit i of word j:
    /// 4,096 of 4,096.
    #[test]
    fn transposed_words_swap_rows_and_columns() {
        let words: [u64; LANES] = std::array::from_fn(|i| crate::hemisphere::mix(7, i as u64));
        let mut turned = words;
        transpose(&mut turned);
        let same = |(i, j): (usize, usize)| words[i] >> j & 1 == turned[j] >> i & 1;
        assert_eq!((0..LANES * LANES).filter(|k| same((k / LANES, k % LANES))).count(), 4096);
    }

    /// For 64 receivers of random normals and skies on 32, 64 and 128 base texels a side, a whole
    /// texel is open and 16 of its 16 sampled points lie in front of the surface. A texel that is
    /// neither whole nor partial is closed or has none of them in front.
    #[test]
    fn whole_texels_are_open_and_in_front() {
        for side in [32_usize, 64, 128] {
            let projection = Projection::new(&Patches::new(145).expect("patches"), side, 1);
            let planes = TexelPlanes::new(&projection);
            let normals: Vec<DVec3> = (0..LANES as u64)
                .map(|i| (jitter(1, i) - 0.5).extend(jitter(2, i).x - 0.3).normalize_or(DVec3::Z))
                .collect();
            let sky = |i: u64| {
                let mut dense = BitSquare::new(side * 2);
                for texel in 0..side * side {
                    let kind = (jitter(3 + i, (texel / 7) as u64).x * 3.0) as usize;
                    (0..kind * 2).for_each(|k| dense.set(texel % side * 2 + k % 2, texel / side * 2 + k / 2, true));
                }
                SkyBitmap::new(&dense, side)
            };
            let skies: Vec<SkyBitmap> = (0..LANES as u64).map(sky).collect();
            let masks = SkyMasks::new(&planes, &normals, &skies);
            let (mut wholes, mut partials) = (0, 0);
            for texel in 0..side * side {
                for (receiver, normal) in normals.iter().enumerate() {
                    let [whole, partial] =
                        [&masks.whole, &masks.partial].map(|masks| masks[texel] >> receiver & 1 == 1);
                    let at = |i: usize| DVec2::new((i % 4) as f64 / 3.0, (i / 4) as f64 / 3.0);
                    let corner = DVec2::new((texel % side) as f64, (texel / side) as f64);
                    let before = (0..16).filter(|i| {
                        let point = (corner + at(*i)) / side as f64;
                        crate::hemisphere::direction_of(point).dot(*normal) > 0.0
                    });
                    let (before, seen) = (before.count(), skies[receiver].texel(texel % side, texel / side));
                    assert!(!whole || seen == Texel::Open && before == 16 && !partial);
                    assert!(whole || partial || seen == Texel::Closed || before == 0);
                    wholes += usize::from(whole);
                    partials += usize::from(partial && seen == Texel::Open);
                }
            }
            // Open texels that are partial lie in a belt of four halves about the plane.
            let belt = 4.0 * (half_texel(side) + SUN_RADIUS_RAD) / (HEMISPHERE_SR / std::f64::consts::PI) * 2.0;
            let share = partials as f64 / (partials + wholes) as f64;
            assert!(wholes > side * side && share < 2.0 * belt, "{share} {belt}");
        }
    }
}
