//! Directions of the sky's texels at all levels of a texture, made once for all receivers. In: sides of a texture, blocks of its texels. Out:
//! their rays by sixteens, and cones around them and all that they are refined to.

use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3};

use crate::trace::kernel::fan::{Cone, Fan};
use crate::trace::kernel::lanes::{F32x16, LANES};
use crate::trace::kernel::scan::Question;
use heliotile_core::hemisphere::{Centres, texel_direction};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::sky::front_of;
use heliotile_core::layers::texel_block::TexelBlock;

/// Where a texel at the rim of a texture that will be refined is looked at: near the horizon, as whatever stands there stands on it. With
/// its centre, 0.9 degrees up in a texture of 64 a side, lower hills and houses would never be seen.
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

/// Texels off the rim: 0.1 degrees of the coarsest ones.
const RIM: f64 = 0.06;

/// Rays of textures of one base and finest side.
pub struct SkyFans {
    centres: Centres,
    base: usize,
    levels: Vec<Level>,
}

/// `[block]`, row-major, of an n x n texture.
struct Level {
    n: usize,
    fans: Vec<Fan>,
    cones: Vec<Cone>,
}

/// What is turned by less than this is not: rounding of a dot product in f32, and more.
const BEHIND: f32 = 1e-5;

impl SkyFans {
    /// Of textures of `base` texels a side, a multiple of 8, refined to `fine`.
    pub fn new(base: usize, fine: usize) -> Self {
        let mut fans = SkyFans { centres: Centres::new(base, fine), base, levels: Vec::new() };
        for n in fans.centres.sides() {
            let side = n / TexelBlock::SIDE as usize;
            let blocks = (0..side * side).map(|block| ((block % side) as u32, (block / side) as u32));
            let level = Level {
                n,
                fans: blocks.clone().map(|block| fans.fan(n, block, |d| d)).collect(),
                cones: blocks.map(|(column, row)| cone(column, row, side)).collect(),
            };
            fans.levels.push(level);
        }
        fans
    }

    /// Directions of texels' centres.
    pub fn centres(&self) -> &Centres {
        &self.centres
    }

    /// Side of the finest texture.
    pub fn fine(&self) -> usize {
        self.centres.finest()
    }

    /// Texels of the base texture that are not wholly behind a surface.
    pub fn front(&self, normal: DVec3) -> BitSquare {
        front_of(self.base, normal, self.centres.base())
    }

    /// Where the ray of a texel of an n x n texture goes, if nothing turns it.
    pub(crate) fn direction(&self, n: usize) -> impl Fn(u32, u32) -> DVec3 + '_ {
        let (centre, refined) = (self.centres.of(n), n < self.fine());
        move |column, row| if refined { low(column, row, n) } else { None }.unwrap_or_else(|| centre(column, row))
    }

    /// The rays of a block, each after `turn`.
    fn fan(&self, n: usize, (column, row): (u32, u32), turn: impl Fn(DVec3) -> DVec3) -> Fan {
        let direction = self.direction(n);
        let block = TexelBlock { column, row, wanted: u16::MAX, ones: 0 };
        let mut fan = Fan([F32x16([0.0; LANES]); 3]);
        for bit in block.bits() {
            let (column, row) = block.texel(bit);
            for (axis, x) in fan.0.iter_mut().zip(turn(direction(column, row)).as_vec3().to_array()) {
                axis.0[bit as usize] = x;
            }
        }
        fan
    }

    /// The table of an n x n texture, if there is one.
    fn level(&self, n: usize) -> Option<&Level> {
        self.levels.iter().find(|level| level.n == n)
    }

    /// The cone around a block of an n x n texture and all that it is refined to; where there is no table, around more.
    fn cone(&self, n: usize, block: &TexelBlock) -> Cone {
        let Some(level) = self.level(n).or(self.levels.last()) else { return Cone::default() };
        let (shift, side) = ((n / level.n).ilog2(), level.n / TexelBlock::SIDE as usize);
        level.cones[(block.row >> shift) as usize * side + (block.column >> shift) as usize]
    }

    /// Blocks of the base texture with all that they are refined to, before a surface.
    pub(crate) fn parts(&self, normal: DVec3) -> Vec<Part> {
        let cones = self.levels.first().map(|level| level.cones.as_slice()).unwrap_or_default();
        let part = |cone: &Cone| match way(cone, normal) {
            None => Part { whole: *cone, front: true },
            Some(way) => Part { whole: cone.moved(way), front: false },
        };
        cones.iter().map(part).collect()
    }

    /// Number of the part that a block of an n x n texture belongs to.
    fn part(&self, n: usize, block: &TexelBlock) -> usize {
        let (shift, side) = ((n / self.base).ilog2(), self.base / TexelBlock::SIDE as usize);
        (block.row >> shift) as usize * side + (block.column >> shift) as usize
    }

    /// Rays of those blocks of an n x n texture that the table does not hold, by place in the list: some go along the surface, since their
    /// texel's centre is behind it, or they are too many to be held.
    pub(crate) fn bent(&self, n: usize, blocks: &[TexelBlock], normal: DVec3, parts: &[Part]) -> Vec<(usize, Fan)> {
        let tabled = self.level(n).is_some();
        let front =
            |block: &TexelBlock| parts[self.part(n, block)].front || way(&self.cone(n, block), normal).is_none();
        let bent = blocks.iter().enumerate().filter(|(_, block)| !tabled || !front(block));
        bent.map(|(place, block)| (place, self.fan(n, (block.column, block.row), |d| before(d, normal)))).collect()
    }

    /// Questions for blocks, given those rays.
    pub(crate) fn questions<'a>(
        &'a self,
        n: usize,
        blocks: &[TexelBlock],
        normal: DVec3,
        parts: &'a [Part],
        bent: &'a [(usize, Fan)],
    ) -> Vec<Question<'a>> {
        let mut bent = bent.iter().peekable();
        let table = self.level(n).map(|level| level.fans.as_slice()).unwrap_or_default();
        let side = n / TexelBlock::SIDE as usize;
        let question = |(place, block): (usize, &TexelBlock)| {
            let (number, cone) = (self.part(n, block), self.cone(n, block));
            let part = &parts[number];
            let turned = if part.front { None } else { way(&cone, normal) };
            let own = bent.next_if(|of| of.0 == place).map(|of| &of.1);
            Question {
                part: number as u32,
                whole: &part.whole,
                fan: own.unwrap_or_else(|| &table[block.row as usize * side + block.column as usize]),
                cone: turned.map_or(cone, |way| cone.moved(way)),
                wanted: block.wanted,
                met: None,
            }
        };
        blocks.iter().enumerate().map(question).collect()
    }
}

/// A part of the sky.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Around all its rays, those along the surface among them.
    whole: Cone,
    /// Whether none goes along the surface.
    front: bool,
}

/// A direction in front of a surface, or along it.
pub(crate) fn before(d: DVec3, normal: DVec3) -> DVec3 {
    let behind = normal.dot(d);
    if behind > 0.0 { d } else { d - normal * (behind - 1e-4) }
}

/// How far rays of a cone are turned from behind a surface, at most; `None` if none lies there.
fn way(cone: &Cone, normal: DVec3) -> Option<[f32; 3]> {
    let normal = normal.as_vec3();
    let [low, _] = cone.dot(normal.to_array());
    (low <= BEHIND).then(|| (normal * (1e-4 - low + BEHIND)).to_array())
}

/// The cone around all directions of a block of a square of `side` x `side` blocks, an even number.
fn cone(column: u32, row: u32, side: usize) -> Cone {
    // Sizes of the square's coordinates from its middle, -1 to 1, and on which side of it.
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

    /// Cones hold the directions of all 16 rays of a block, and of all that it is refined to, straight and along 5 surfaces: over 100,000
    /// directions.
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
                    .filter(|block| fans.cone(n, block).dot(normal.as_vec3().to_array())[1] > 0.0)
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
