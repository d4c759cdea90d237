//! Directions of the sky's texels at all levels of a texture, made once for all receivers. In:
//! sides of a texture, blocks of its texels. Out: their rays by sixteens, and cones around the rays
//! and all their refinements.

use std::f64::consts::FRAC_PI_4;
use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use crate::trace::kernel::fan::{Cone, Fan};
use crate::trace::kernel::lanes::{F32x16, LANES};
use crate::trace::kernel::scan::Question;
use heliotile_core::hemisphere::{texel_centres, texel_direction};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::sky::front_of;
use heliotile_core::layers::texel_block::TexelBlock;

/// Returns the direction for a texel at the rim of a texture that will be refined: near the
/// horizon, because whatever stands there stands on it. With its centre, 0.9 degrees up in a
/// texture of 64 a side, lower hills and houses would never be seen.
fn low(column: u32, row: u32, n: usize) -> Option<DVec3> {
    let last = n as u32 - 1;
    let at = |i: u32| match i {
        0 => RIM,
        i if i == last => 1.0 - RIM,
        _ => 0.5,
    };
    let rim = [column, row].iter().any(|&i| i == 0 || i == last);
    rim.then(|| texel_direction(column as usize, row as usize, n, DVec2::new(at(column), at(row))))
}

/// Distance from the rim, in texels: 0.1 degrees of the coarsest ones.
const RIM: f64 = 0.06;

/// Rays of textures of one base side and one finest side.
pub struct SkyFans {
    base: usize,
    fine: usize,
    /// Directions of the base texture's texels, row-major.
    centres: Vec<DVec3>,
    /// Cones around the blocks of the base texture with all their refinements, row-major: the parts
    /// of the sky.
    parts: Vec<Cone>,
    levels: Vec<Level>,
}

/// Rays of the blocks of an n x n texture, row-major, made on first use because much of the sky is
/// never refined.
struct Level {
    n: usize,
    stretches: Vec<OnceLock<Vec<Aim>>>,
}

/// Number of blocks that are made at once.
const STRETCH: usize = 16;

/// Rays of a block and the cone around them.
struct Aim {
    fan: Fan,
    cone: Cone,
}

/// Largest side with a table of directions. Tables of larger textures would not fit a core's share
/// of cache and memory, so their directions are computed on use.
const LARGEST_TABLE: usize = 1024;

/// Tolerance of the dot product below which a direction counts as behind a surface: rounding in
/// f32, with a margin.
const BEHIND: f32 = 1e-5;

impl SkyFans {
    /// Creates the rays of textures of `base` texels a side, a multiple of 8, refined to `fine`.
    pub fn new(base: usize, fine: usize) -> Self {
        let blocks = |n: usize| n / TexelBlock::SIDE as usize;
        let side = blocks(base);
        let parts: Vec<Cone> = (0..side * side).map(|i| cone((i % side) as u32, (i / side) as u32, side)).collect();
        let sides = std::iter::successors(Some(base), |n| Some(n * 2))
            .take_while(|&n| n <= fine.min(LARGEST_TABLE) || n == base);
        let stretches = |n| (0..(blocks(n) * blocks(n)).div_ceil(STRETCH)).map(|_| OnceLock::new()).collect();
        let levels = sides.map(|n| Level { n, stretches: stretches(n) }).collect();
        SkyFans { base, fine, centres: texel_centres(base), parts, levels }
    }

    /// Returns the directions of the centres of the base texture's texels, row-major.
    pub fn centres(&self) -> &[DVec3] {
        &self.centres
    }

    /// Returns the texels of the base texture that are not wholly behind a surface.
    pub fn front(&self, normal: DVec3) -> BitSquare {
        front_of(self.base, normal, &self.centres)
    }

    /// Returns the side of the coarsest texture.
    pub fn base(&self) -> usize {
        self.base
    }

    /// Returns the side of the finest texture.
    pub fn fine(&self) -> usize {
        self.fine
    }

    /// Returns the direction of the ray of a texel of an n x n texture, before a surface bends it.
    pub(crate) fn direction(&self, n: usize) -> impl Fn(u32, u32) -> DVec3 + use<> {
        let refined = n < self.fine;
        move |column, row| {
            let centre = || texel_direction(column as usize, row as usize, n, DVec2::splat(0.5));
            if refined { low(column, row, n) } else { None }.unwrap_or_else(centre)
        }
    }

    /// Returns the wanted rays of a block, each after `turn`. The other lanes repeat one of them.
    fn fan(&self, n: usize, block: &TexelBlock, turn: impl Fn(DVec3) -> DVec3) -> Fan {
        let direction = self.direction(n);
        let ray = |bit: u32| {
            let (column, row) = block.texel(bit);
            turn(direction(column, row)).as_vec3().to_array()
        };
        let mut fan = Fan(ray(block.wanted.trailing_zeros() % 16).map(|x| F32x16([x; LANES])));
        for bit in block.bits().skip(1) {
            for (axis, x) in fan.0.iter_mut().zip(ray(bit)) {
                axis.0[bit as usize] = x;
            }
        }
        fan
    }

    /// Returns true if there is a table for an n x n texture.
    fn tabled(&self, n: usize) -> bool {
        self.levels.iter().any(|level| level.n == n)
    }

    /// Returns the rays of blocks of an n x n texture. Without a table for it, returns those of the
    /// coarser blocks in the finest table.
    fn aims<'a>(&'a self, n: usize) -> impl Fn(&TexelBlock) -> &'a Aim {
        let level = &self.levels[((n / self.base).ilog2() as usize).min(self.levels.len() - 1)];
        let (shift, side) = ((n / level.n).ilog2(), level.n / TexelBlock::SIDE as usize);
        let make = move |place: usize| {
            let (column, row) = ((place % side) as u32, (place / side) as u32);
            let block = TexelBlock { column, row, wanted: u16::MAX, ones: 0 };
            Aim { fan: self.fan(level.n, &block, |d| d), cone: cone(column, row, side) }
        };
        move |block| {
            let place = (block.row >> shift) as usize * side + (block.column >> shift) as usize;
            let stretch = level.stretches[place / STRETCH].get_or_init(|| {
                let first = place - place % STRETCH;
                (first..(first + STRETCH).min(side * side)).map(make).collect()
            });
            &stretch[place % STRETCH]
        }
    }

    /// Returns the parts of the sky as a surface sees them.
    pub(crate) fn parts(&self, normal: DVec3) -> Vec<Part> {
        let part = |cone: &Cone| match way(cone, normal) {
            None => Part { whole: *cone, front: true },
            Some(way) => Part { whole: cone.moved(way), front: false },
        };
        self.parts.iter().map(part).collect()
    }

    /// Returns the number of the part that a block of an n x n texture belongs to.
    pub(crate) fn part(&self, n: usize) -> impl Fn(&TexelBlock) -> usize + use<> {
        let (shift, side) = ((n / self.base).ilog2(), self.base / TexelBlock::SIDE as usize);
        move |block| (block.row >> shift) as usize * side + (block.column >> shift) as usize
    }

    /// Returns the rays of those blocks that the table does not hold, by place in the list: rays
    /// that go along the surface because the centre of their texel is behind it, and rays of
    /// textures too large for a table.
    pub(crate) fn bent(&self, n: usize, blocks: &[TexelBlock], normal: DVec3, parts: &[Part]) -> Vec<(usize, Fan)> {
        let (tabled, part, aim) = (self.tabled(n), self.part(n), self.aims(n));
        let front = |block: &TexelBlock| parts[part(block)].front || way(&aim(block).cone, normal).is_none();
        let bent = blocks.iter().enumerate().filter(|(_, block)| !tabled || !front(block));
        bent.map(|(place, block)| (place, self.fan(n, block, |d| before(d, normal)))).collect()
    }

    /// Returns the occlusion queries for blocks, with the rays of [`SkyFans::bent`].
    pub(crate) fn questions<'a>(
        &'a self,
        n: usize,
        blocks: &[TexelBlock],
        normal: DVec3,
        parts: &'a [Part],
        bent: &'a [(usize, Fan)],
    ) -> Vec<Question<'a>> {
        let mut bent = bent.iter().peekable();
        let (number_of, aim) = (self.part(n), self.aims(n));
        let question = |(place, block): (usize, &TexelBlock)| {
            let number = number_of(block);
            let part = &parts[number];
            let Aim { fan, cone } = aim(block);
            let turned = if part.front { None } else { way(cone, normal) };
            let own = bent.next_if(|of| of.0 == place).map(|of| &of.1);
            Question {
                part: number as u32,
                whole: &part.whole,
                fan: own.unwrap_or(fan),
                cone: turned.map_or(*cone, |way| cone.moved(way)),
                wanted: block.wanted,
                met: None,
            }
        };
        blocks.iter().enumerate().map(question).collect()
    }
}

/// Part of the sky.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Cone around all its rays, including those along the surface.
    whole: Cone,
    /// True if no ray goes along the surface.
    front: bool,
}

impl Part {
    /// Returns the cone around the part.
    pub fn whole(&self) -> &Cone {
        &self.whole
    }
}

/// Returns the direction if it is in front of a surface, else one along the surface.
pub(crate) fn before(d: DVec3, normal: DVec3) -> DVec3 {
    let behind = normal.dot(d);
    // 1e-4 in front of the surface, because rounding to f32 must not put the direction behind it
    // again.
    if behind > 0.0 { d } else { d - normal * (behind - 1e-4) }
}

/// Returns the largest shift of a cone's rays from behind a surface; `None` if none lies there.
fn way(cone: &Cone, normal: DVec3) -> Option<[f32; 3]> {
    let normal = normal.as_vec3();
    let [low, _] = cone.dot(normal.to_array());
    (low <= BEHIND).then(|| (normal * (1e-4 - low + BEHIND)).to_array())
}

/// Returns the cone around all directions of a block of a square of `side` x `side` blocks, an even
/// number.
fn cone(column: u32, row: u32, side: usize) -> Cone {
    // Distances of the square's coordinates from its middle, 0 to 1, and on which side of it they
    // lie. A border of blocks runs through the middle of an even side, so each block lies within
    // one quarter. There the map is monotone, so the bounds are at corners of the block.
    let ends = |at: u32| {
        let [a, b] = [at, at + 1].map(|x| 2.0 * f64::from(x) / side as f64 - 1.0);
        (a.abs().min(b.abs()), a.abs().max(b.abs()), a < 0.0)
    };
    let ((x0, x1, west), (y0, y1, south)) = (ends(column), ends(row));
    let angle = |x: f64, y: f64| FRAC_PI_4 * if x >= y { y / x } else { 2.0 - x / y };
    let [flat, steep] = [angle(x1, y0), angle(x0, y1)];
    let [inner, outer] = [x0.max(y0), x1.max(y1)];
    let level = |r: f64| r * (2.0 - r * r).sqrt();
    let [least, most] = [level(inner), level(outer)];
    let mut low = [least * steep.cos(), least * flat.sin(), 1.0 - outer * outer];
    let mut high = [most * flat.cos(), most * steep.sin(), 1.0 - inner * inner];
    for (axis, turned) in [(0, west), (1, south)] {
        if turned {
            (low[axis], high[axis]) = (-high[axis], -low[axis]);
        }
    }
    Cone::between(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cones hold the directions of all 16 rays of a block and of all its refinements, straight and
    /// along 5 surfaces: over 100,000 directions.
    #[test]
    fn cones_hold_rays() {
        let (base, fine) = (16, 128);
        let fans = SkyFans::new(base, fine);
        let normals = [DVec3::Z, DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.36, 0.48, -0.8)];
        let mut asked = 0;
        for normal in normals {
            let parts = fans.parts(normal);
            for n in [16, 32, 64, 128] {
                let side = n as u32 / TexelBlock::SIDE;
                let blocks: Vec<TexelBlock> = (0..side * side)
                    .map(|i| TexelBlock { column: i % side, row: i / side, wanted: u16::MAX, ones: 0 })
                    .filter(|block| fans.aims(n)(block).cone.dot(normal.as_vec3().to_array())[1] > 0.0)
                    .collect();
                let bent = fans.bent(n, &blocks, normal, &parts);
                for question in fans.questions(n, &blocks, normal, &parts, &bent) {
                    for (lane, cone) in (0..LANES).flat_map(|lane| [(lane, question.cone), (lane, *question.whole)]) {
                        let d = question.fan.direction(lane);
                        let inside = |i: usize| (d[i] - cone.centre[i]).abs() <= cone.half[i];
                        assert!((0..3).all(inside), "{d:?} {cone:?} {normal}");
                        let along = |i: usize| cone.crosses[i] || (d[i] < 0.0) == cone.backwards[i];
                        assert!((0..3).all(along), "{d:?} {cone:?}");
                        asked += 1;
                    }
                }
            }
        }
        assert!(asked > 100_000, "{asked}");
    }
}
