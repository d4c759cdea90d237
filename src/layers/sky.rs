//! The adaptive sky texture: one bit a texel, world frame. In: a function that answers for texels. Out: bits of a coarse
//! square and, wherever a texel's neighbourhood is mixed, of its four children, level by level.
//!
//! Which texels are refined follows from the bits alone, so nothing but bits is stored. The surface's own half of the
//! hemisphere is a second bit plane at the base size: texels wholly behind the surface are 0 and never make an edge.

use glam::{DVec2, DVec3};

use crate::hemisphere::{HEMISPHERE_SR, texel_direction};

/// A square of bits, row-major, rows padded to whole words, texel 0 = column 0, row 0 = lowest bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitSquare {
    n: usize,
    stride: usize,
    words: Vec<u64>,
}

impl BitSquare {
    pub fn new(n: usize) -> Self {
        let stride = n.div_ceil(64);
        BitSquare { n, stride, words: vec![0; stride * n] }
    }

    /// Side of the square.
    pub fn side(&self) -> usize {
        self.n
    }

    #[inline]
    pub fn get(&self, column: usize, row: usize) -> bool {
        self.words[row * self.stride + column / 64] >> (column % 64) & 1 == 1
    }

    #[inline]
    pub fn set(&mut self, column: usize, row: usize, value: bool) {
        let word = &mut self.words[row * self.stride + column / 64];
        *word = *word & !(1 << (column % 64)) | (u64::from(value) << (column % 64));
    }

    /// Number of set bits in the `size` x `size` block at block column and row; size divides 64.
    pub fn count_block(&self, size: usize, block_column: usize, block_row: usize) -> u32 {
        let first = block_column * size;
        let mask = if size == 64 { u64::MAX } else { (1 << size) - 1 };
        (block_row * size..(block_row + 1) * size)
            .map(|row| (self.words[row * self.stride + first / 64] >> (first % 64) & mask).count_ones())
            .sum()
    }

    /// Set bits as (column, row), row by row.
    pub fn ones(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.words.iter().enumerate().flat_map(move |(i, &word)| {
            let (row, first) = (i / self.stride, i % self.stride * 64);
            std::iter::successors(Some(word), |w| Some(w & w.wrapping_sub(1)))
                .take_while(|&w| w != 0)
                .map(move |w| (first as u32 + w.trailing_zeros(), row as u32))
        })
    }

    /// The same bits, 4 x 4 block by block: neighbours in the list are neighbours on the sphere.
    pub fn ones_in_blocks(&self) -> Vec<(u32, u32)> {
        let mut found = Vec::new();
        for band in (0..self.n).step_by(4) {
            let rows = band..(band + 4).min(self.n);
            for i in 0..self.stride {
                let words: Vec<u64> = rows.clone().map(|row| self.words[row * self.stride + i]).collect();
                let mut any = words.iter().fold(0, |a, w| a | w);
                while any != 0 {
                    let shift = any.trailing_zeros() & !3;
                    for (word, row) in words.iter().zip(rows.clone()) {
                        let mut bits = word >> shift & 15;
                        while bits != 0 {
                            found.push((i as u32 * 64 + shift + bits.trailing_zeros(), row as u32));
                            bits &= bits - 1;
                        }
                    }
                    any &= !(15 << shift);
                }
            }
        }
        found
    }

    fn map2(&self, other: &Self, f: impl Fn(u64, u64) -> u64) -> Self {
        let words = self.words.iter().zip(&other.words).map(|(&a, &b)| f(a, b)).collect();
        BitSquare { words, ..*self }
    }

    /// Bits that are set in any of the 3 x 3 neighbours.
    fn dilate(&self) -> Self {
        let mut wide = self.clone();
        for (row, out) in self.words.chunks(self.stride).zip(wide.words.chunks_mut(self.stride)) {
            for i in 0..row.len() {
                let left = if i > 0 { row[i - 1] >> 63 } else { 0 };
                let right = row.get(i + 1).map_or(0, |w| w << 63);
                out[i] = row[i] | row[i] << 1 | left | row[i] >> 1 | right;
            }
        }
        let mut out = wide.clone();
        for row in 0..self.n {
            for other in [row.wrapping_sub(1), row + 1] {
                if other < self.n {
                    for i in 0..self.stride {
                        out.words[row * self.stride + i] |= wide.words[other * self.stride + i];
                    }
                }
            }
        }
        out
    }

    /// Each bit becomes 2 x 2 bits.
    fn double(&self) -> Self {
        let mut out = BitSquare::new(self.n * 2);
        for row in 0..self.n {
            let words = &self.words[row * self.stride..(row + 1) * self.stride];
            let start = row * 2 * out.stride;
            for (i, &word) in words.iter().enumerate() {
                for half in 0..2 {
                    if let Some(w) = out.words[start..start + out.stride].get_mut(i * 2 + half) {
                        *w = spread((word >> (32 * half)) as u32);
                    }
                }
            }
            let (upper, lower) = out.words[start..start + 2 * out.stride].split_at_mut(out.stride);
            lower.copy_from_slice(upper);
        }
        out
    }

    /// Rows of whole bytes, lowest bit first.
    fn to_bytes(&self, out: &mut Vec<u8>) {
        let row_bytes = self.n.div_ceil(8);
        for row in self.words.chunks(self.stride) {
            out.extend(row.iter().flat_map(|w| w.to_le_bytes()).take(row_bytes));
        }
    }

    fn from_bytes(n: usize, bytes: &[u8]) -> Self {
        let mut square = BitSquare::new(n);
        let row_bytes = n.div_ceil(8);
        for (row, bytes) in square.words.chunks_mut(square.stride).zip(bytes.chunks(row_bytes)) {
            for (word, bytes) in row.iter_mut().zip(bytes.chunks(8)) {
                let mut padded = [0; 8];
                padded[..bytes.len()].copy_from_slice(bytes);
                *word = u64::from_le_bytes(padded);
            }
        }
        square
    }
}

/// Every bit of `x` twice (Morton spreading).
fn spread(x: u32) -> u64 {
    let mut v = u64::from(x);
    v = (v | v << 16) & 0x0000_ffff_0000_ffff;
    v = (v | v << 8) & 0x00ff_00ff_00ff_00ff;
    v = (v | v << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    v = (v | v << 2) & 0x3333_3333_3333_3333;
    v = (v | v << 1) & 0x5555_5555_5555_5555;
    v | v << 1
}

/// Bits of one receiver, as stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkyTexture {
    /// Texels of the base square that lie at least partly in front of the surface.
    front: BitSquare,
    base: BitSquare,
    /// One byte string a level: four bits for each refined texel of the level before, in its row-major order; children
    /// in the order (0,0), (1,0), (0,1), (1,1); two refined texels to a byte, the first in the low half.
    levels: Vec<Vec<u8>>,
}

impl SkyTexture {
    /// Traces a texture from `base` to `fine` texels a side (powers of two); `visible(n, texels)` answers for the texels
    /// (column, row) of an n x n square. Also gives the square of `fine` x `fine` bits that the texture describes.
    pub fn trace(
        base: usize,
        fine: usize,
        normal: DVec3,
        mut visible: impl FnMut(usize, &[(u32, u32)]) -> Vec<bool>,
    ) -> (Self, BitSquare) {
        let front = front_of(base, normal);
        let mut dense = BitSquare::new(base);
        let texels = front.ones_in_blocks();
        for (&(c, r), sky) in texels.iter().zip(visible(base, &texels)) {
            dense.set(c as usize, r as usize, sky);
        }
        let mut texture = SkyTexture { front, base: dense.clone(), levels: Vec::new() };
        let mut mask = texture.front.clone();
        for n in sides(base, fine) {
            let refined = mixed(&dense, &mask);
            let children: Vec<(u32, u32)> = refined.ones_in_blocks().into_iter().flat_map(children_of).collect();
            dense = dense.double();
            for (&(c, r), sky) in children.iter().zip(visible(n, &children)) {
                dense.set(c as usize, r as usize, sky);
            }
            let nibble = |parent| {
                let child = |&(c, r): &(u32, u32)| u8::from(dense.get(c as usize, r as usize));
                children_of(parent).iter().rev().fold(0, |bits, t| bits << 1 | child(t))
            };
            let nibbles: Vec<u8> = refined.ones().map(nibble).collect();
            texture.levels.push(nibbles.chunks(2).map(|two| two[0] | two.get(1).map_or(0, |n| n << 4)).collect());
            mask = mask.double();
        }
        (texture, dense)
    }

    /// Raw block of a tile: all front planes, all base planes, then level after level, receiver by receiver.
    pub fn pack(tile: &[SkyTexture]) -> Vec<u8> {
        let mut raw = Vec::new();
        tile.iter().for_each(|t| t.front.to_bytes(&mut raw));
        tile.iter().for_each(|t| t.base.to_bytes(&mut raw));
        let depth = tile.first().map_or(0, |t| t.levels.len());
        for level in 0..depth {
            tile.iter().for_each(|t| raw.extend(&t.levels[level]));
        }
        raw
    }

    /// Inverse of [`SkyTexture::pack`]: the `fine` x `fine` bits of each receiver; `None` if the bytes do not describe
    /// `count` textures exactly.
    pub fn unpack(raw: &[u8], count: usize, base: usize, fine: usize) -> Option<Vec<BitSquare>> {
        Some(SkyTexture::split(raw, count, base, fine)?.into_iter().map(|t| t.1).collect())
    }

    /// The textures that were packed, each with the bits that it describes; `None` as for [`SkyTexture::unpack`].
    pub fn split(raw: &[u8], count: usize, base: usize, fine: usize) -> Option<Vec<(SkyTexture, BitSquare)>> {
        // Zero doubled stays zero.
        if base == 0 {
            return None;
        }
        let plane = base.div_ceil(8) * base;
        let (planes, mut rest) = raw.split_at_checked(plane.checked_mul(count)?.checked_mul(2)?)?;
        let squares: Vec<BitSquare> = planes.chunks(plane.max(1)).map(|p| BitSquare::from_bytes(base, p)).collect();
        let (masks, bits) = squares.split_at_checked(count)?;
        let mut masks = masks.to_vec();
        let texture = |(front, base): (&BitSquare, &BitSquare)| {
            (SkyTexture { front: front.clone(), base: base.clone(), levels: Vec::new() }, base.clone())
        };
        let mut textures: Vec<(SkyTexture, BitSquare)> = masks.iter().zip(bits).map(texture).collect();
        for _ in sides(base, fine) {
            for ((texture, bits), mask) in textures.iter_mut().zip(&mut masks) {
                let refined = mixed(bits, mask);
                let (level, tail) = rest.split_at_checked(refined.ones().count().div_ceil(2))?;
                rest = tail;
                *bits = bits.double();
                for (i, parent) in refined.ones().enumerate() {
                    let nibble = level.get(i / 2)? >> (i % 2 * 4);
                    for (k, (c, r)) in children_of(parent).into_iter().enumerate() {
                        bits.set(c as usize, r as usize, nibble >> k & 1 == 1);
                    }
                }
                texture.levels.push(level.to_vec());
                *mask = mask.double();
            }
        }
        rest.is_empty().then_some(textures)
    }
}

/// Sides of the refined levels: twice the base, four times, ... up to `fine`.
fn sides(base: usize, fine: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(base * 2), |n| Some(n * 2)).take_while(move |&n| n <= fine)
}

fn children_of((c, r): (u32, u32)) -> [(u32, u32); 4] {
    [(2 * c, 2 * r), (2 * c + 1, 2 * r), (2 * c, 2 * r + 1), (2 * c + 1, 2 * r + 1)]
}

/// Texels in front of the surface whose 3 x 3 neighbourhood there holds both values.
fn mixed(bits: &BitSquare, front: &BitSquare) -> BitSquare {
    let ones = bits.map2(front, |b, f| b & f).dilate();
    let zeros = bits.map2(front, |b, f| !b & f).dilate();
    ones.map2(&zeros, |a, b| a & b).map2(front, |m, f| m & f)
}

/// Texels that are not wholly behind a surface: their centre is less than half a texel's reach behind it.
fn front_of(n: usize, normal: DVec3) -> BitSquare {
    let mut front = BitSquare::new(n);
    let reach = half_texel(n) * 1.6;
    for row in 0..n {
        for column in 0..n {
            let d = texel_direction(column, row, n, DVec2::splat(0.5));
            front.set(column, row, normal.dot(d) > -reach);
        }
    }
    front
}

/// Half the side of a square of a texel's solid angle, in radians.
pub fn half_texel(n: usize) -> f64 {
    0.5 * (HEMISPHERE_SR / (n * n) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{jitter, mix};

    /// A random skyline at direction d: visible above a bumpy horizon.
    fn skyline(d: DVec3) -> bool {
        let azimuth = d.y.atan2(d.x);
        d.z > 0.3 + 0.2 * (3.0 * azimuth).sin() + 0.05 * (11.0 * azimuth).cos()
    }

    fn traced(base: usize, fine: usize, normal: DVec3) -> (SkyTexture, BitSquare, usize) {
        let mut rays = 0;
        let (texture, dense) = SkyTexture::trace(base, fine, normal, |n, texels| {
            rays += texels.len();
            let at = |&(c, r): &(u32, u32)| texel_direction(c as usize, r as usize, n, DVec2::splat(0.5));
            texels.iter().map(|t| skyline(at(t))).collect()
        });
        (texture, dense, rays)
    }

    /// A smooth skyline refined from 128 to 1024 equals the flat 1024 texture in all but 0.02 % of its bits, for under 8 % of its rays.
    #[test]
    fn refined_equals_flat() {
        let (_, dense, rays) = traced(128, 1024, DVec3::Z);
        let mut wrong = 0;
        for row in 0..1024 {
            for column in 0..1024 {
                let d = texel_direction(column, row, 1024, DVec2::splat(0.5));
                wrong += u32::from(dense.get(column, row) != skyline(d));
            }
        }
        assert!(wrong < 210, "{wrong} bits of 1,048,576");
        assert!(rays < 84_000, "{rays} rays");
    }

    /// Packing 5 textures of different normals, unpacking and splitting give them back, and every truncation is refused.
    #[test]
    fn pack_round_trip() {
        let normals = [DVec3::Z, DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8), DVec3::NEG_Y];
        let traces = normals.map(|n| traced(64, 256, n));
        let raw = SkyTexture::pack(&traces.clone().map(|t| t.0));
        let back = SkyTexture::unpack(&raw, 5, 64, 256);
        assert_eq!(back.as_ref().map(Vec::len), Some(5));
        assert_eq!(back, Some(traces.clone().map(|t| t.1).to_vec()));
        assert_eq!(SkyTexture::split(&raw, 5, 64, 256), Some(traces.map(|t| (t.0, t.1)).to_vec()));
        let refused = (0..raw.len()).filter(|&cut| SkyTexture::unpack(&raw[..cut], 5, 64, 256).is_none()).count();
        assert_eq!(refused, raw.len());
    }

    /// Doubling and dilation of 64 random bits of a 96-wide square agree with the plain definition.
    #[test]
    fn bit_operations() {
        let mut square = BitSquare::new(96);
        for i in 0..64 {
            let p = jitter(mix(1, 2), i) * 96.0;
            square.set(p.x as usize, p.y as usize, true);
        }
        let (dilated, doubled) = (square.dilate(), square.double());
        for row in 0..96_usize {
            for column in 0..96_usize {
                let near = |v: usize| v.saturating_sub(1)..(v + 2).min(96);
                let any = near(row).any(|r| near(column).any(|c| square.get(c, r)));
                assert_eq!(dilated.get(column, row), any, "{column} {row}");
                let own = square.get(column, row);
                assert!(
                    [(0, 0), (1, 0), (0, 1), (1, 1)]
                        .iter()
                        .all(|(i, j)| doubled.get(2 * column + i, 2 * row + j) == own)
                );
            }
        }
        assert_eq!(
            square.ones().count() as u32,
            (0..12).flat_map(|r| (0..12).map(move |c| (c, r))).map(|(c, r)| square.count_block(8, c, r)).sum::<u32>()
        );
    }
}
