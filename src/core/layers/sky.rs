//! The adaptive sky texture: one bit a texel, world frame. In: a function that answers for texels.
//! Out: bits of a coarse square and, where a texel's neighbourhood is mixed, of the texel's four
//! children, level by level.
//!
//! The bits alone decide which texels are refined, so only bits are stored. The surface's own half
//! of the hemisphere is a second bit plane at the base size. Texels wholly behind the surface are 0
//! and never make an edge.

use glam::DVec3;

use crate::hemisphere::HEMISPHERE_SR;
use crate::layers::bits::BitSquare;
use crate::layers::texel_block::{Answers, TexelBlock};

/// Sky texture of one receiver, as stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkyTexture {
    /// Texels of the base square that lie at least partly in front of the surface.
    front: BitSquare,
    base: BitSquare,
    /// One byte string a level: four bits for each refined texel of the level before, in that
    /// level's row-major order. Children come in the order (0,0), (1,0), (0,1), (1,1); two refined
    /// texels share a byte, the first in the low half.
    levels: Vec<Vec<u8>>,
}

impl SkyTexture {
    /// Traces the texels of a base square that are set in `front`, and refines them to `fine`
    /// texels a side, the base doubled some times. All other texels are 0 and make no edges.
    /// `visible(n, blocks)` answers for texels of an n x n square. Returns the texture and the
    /// square of `fine` x `fine` bits that it describes.
    pub fn trace(
        front: BitSquare,
        fine: usize,
        mut visible: impl FnMut(usize, &mut [TexelBlock]),
    ) -> (Self, BitSquare) {
        let base = front.side();
        let mut dense = BitSquare::new(base);
        let mut blocks = Vec::new();
        front.blocks(&mut blocks);
        visible(base, &mut blocks);
        blocks.iter().for_each(|block| dense.put(block));
        let mut texture = SkyTexture { front, base: dense.clone(), levels: Vec::new() };
        let mut mask = texture.front.clone();
        for n in sides(base, fine) {
            let refined = dense.mixed(&mask);
            refined.child_blocks(&mut blocks);
            visible(n, &mut blocks);
            dense = dense.double();
            blocks.iter().for_each(|block| dense.put(block));
            texture.levels.push(dense.nibbles(&refined));
            if n < fine {
                mask = mask.double();
            }
        }
        (texture, dense)
    }

    /// Returns the questions and answers that made this texture, level by level, the base first. It
    /// is the inverse of [`SkyTexture::trace`].
    pub fn answers(&self) -> Vec<Answers> {
        let mut all = vec![Answers { asked: self.front.clone(), bits: self.base.clone() }];
        let (mut mask, mut bits) = (self.front.clone(), self.base.clone());
        for level in &self.levels {
            let refined = bits.mixed(&mask);
            bits = bits.refine(&refined, level);
            all.push(Answers { asked: refined.double(), bits: bits.clone() });
            mask = mask.double();
        }
        all
    }

    /// Packs the textures of a tile into a raw block: all front planes, all base planes, then level
    /// after level, receiver by receiver.
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

    /// Unpacks the `fine` x `fine` bits of each receiver from the bytes of [`SkyTexture::pack`].
    /// Returns `None` if the bytes do not describe `count` textures exactly.
    pub fn unpack(raw: &[u8], count: usize, base: usize, fine: usize) -> Option<Vec<BitSquare>> {
        decode(raw, count, base, fine, |texture| texture.dense())
    }

    /// Unpacks textures as they were packed, each with the bits that it describes. Returns `None`
    /// as [`SkyTexture::unpack`] does.
    pub fn split(raw: &[u8], count: usize, base: usize, fine: usize) -> Option<Vec<(SkyTexture, BitSquare)>> {
        let texture = |d: &Decoded| {
            let levels = d.levels.iter().map(|level| level.to_vec()).collect();
            (SkyTexture { front: d.front.clone(), base: d.base.clone(), levels }, d.dense())
        };
        decode(raw, count, base, fine, texture)
    }
}

/// One texture of a raw block, followed down to its last refinement.
pub(super) struct Decoded<'a> {
    front: BitSquare,
    base: BitSquare,
    levels: Vec<&'a [u8]>,
    /// Bits before the last refinement, half as many a side as the finest; the base bits if nothing
    /// is refined.
    pub half: BitSquare,
    /// The surface's half of the hemisphere, at the size of `half`.
    mask: BitSquare,
    /// Texels of `half` that are refined once more, and their four bits each, two to a byte; `None`
    /// if nothing is refined.
    pub last: Option<(BitSquare, &'a [u8])>,
}

impl<'a> Decoded<'a> {
    /// Returns the finest square.
    pub fn dense(&self) -> BitSquare {
        match &self.last {
            Some((refined, nibbles)) => self.half.refine(refined, nibbles),
            None => self.half.clone(),
        }
    }

    /// Follows one more refinement, whose bits come first in `rest`. Returns `None` if they are
    /// missing.
    fn follow(&mut self, rest: &mut &'a [u8]) -> Option<()> {
        if let Some((refined, nibbles)) = self.last.take() {
            self.half = self.half.refine(&refined, nibbles);
            self.mask = self.mask.double();
        }
        let refined = self.half.mixed(&self.mask);
        let (level, tail) = rest.split_at_checked((refined.count() as usize).div_ceil(2))?;
        *rest = tail;
        self.levels.push(level);
        self.last = Some((refined, level));
        Some(())
    }
}

/// Decodes the textures of a raw block and returns the results of `each`. Returns `None` if the
/// bytes do not describe `count` textures exactly.
pub(super) fn decode<'a, T>(
    raw: &'a [u8],
    count: usize,
    base: usize,
    fine: usize,
    each: impl Fn(&Decoded<'a>) -> T,
) -> Option<Vec<T>> {
    let (fronts, bits, mut rest) = planes(raw, count, base)?;
    let texture = |(front, base): (BitSquare, BitSquare)| Decoded {
        front: front.clone(),
        base: base.clone(),
        levels: Vec::new(),
        half: base,
        mask: front,
        last: None,
    };
    let mut textures: Vec<Decoded<'a>> = fronts.into_iter().zip(bits).map(texture).collect();
    let levels = sides(base, fine).count();
    for _ in 1..levels {
        textures.iter_mut().try_for_each(|texture| texture.follow(&mut rest))?;
    }
    // The last refinement is the largest, so only one texture holds it at a time.
    let finish = |mut texture: Decoded<'a>| {
        if levels > 0 {
            texture.follow(&mut rest)?;
        }
        Some(each(&texture))
    };
    let found = textures.into_iter().map(finish).collect::<Option<Vec<T>>>()?;
    rest.is_empty().then_some(found)
}

/// Splits a raw block of `count` textures into its front planes, its base planes and the bytes
/// behind them. Returns `None` if the block is too short or `base` is 0.
pub(super) fn planes(raw: &[u8], count: usize, base: usize) -> Option<(Vec<BitSquare>, Vec<BitSquare>, &[u8])> {
    // A side of zero would never reach `fine` by doubling.
    if base == 0 {
        return None;
    }
    let plane = base.div_ceil(8) * base;
    let (planes, rest) = raw.split_at_checked(plane.checked_mul(count)?.checked_mul(2)?)?;
    let (fronts, bases) = planes.split_at(planes.len() / 2);
    let squares = |bytes: &[u8]| bytes.chunks(plane).map(|p| BitSquare::from_bytes(base, p)).collect();
    Some((squares(fronts), squares(bases), rest))
}

/// Returns the sides of the refined levels: twice the base, four times, ... up to `fine`.
pub(super) fn sides(base: usize, fine: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(base * 2), |n| Some(n * 2)).take_while(move |&n| n <= fine)
}

/// Returns the texels of an n x n square that are not wholly behind a surface: their centre is less
/// than half a texel's reach behind it. `centres` holds the directions of the texels' centres,
/// row-major.
pub fn front_of(n: usize, normal: DVec3, centres: &[DVec3]) -> BitSquare {
    let mut front = BitSquare::new(n);
    let reach = half_texel(n) * 1.6;
    let in_front = |centre: &DVec3| u64::from(normal.dot(*centre) > -reach);
    for (words, centres) in front.words.chunks_mut(front.stride.max(1)).zip(centres.chunks(n.max(1))) {
        for (word, centres) in words.iter_mut().zip(centres.chunks(64)) {
            *word = centres.iter().enumerate().fold(0, |word, (bit, centre)| word | in_front(centre) << bit);
        }
    }
    front
}

/// Returns half the side, in radians, of a square with a texel's solid angle.
pub fn half_texel(n: usize) -> f64 {
    0.5 * (HEMISPHERE_SR / (n * n) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::{texel_centres, texel_direction};
    use glam::DVec2;

    /// Returns true if direction `d` lies above a bumpy horizon.
    fn skyline(d: DVec3) -> bool {
        let azimuth = d.y.atan2(d.x);
        d.z > 0.3 + 0.2 * (3.0 * azimuth).sin() + 0.05 * (11.0 * azimuth).cos()
    }

    /// The answers of 3 textures hold every question that made them, 15,000 texels in all, with its
    /// answer, and nothing else.
    #[test]
    fn answers_hold_every_question_with_its_answer() {
        let mut given = 0;
        for normal in [DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, -0.8)] {
            let front = front_of(32, normal, &texel_centres(32));
            let mut told: Vec<(usize, TexelBlock)> = Vec::new();
            let (texture, _) = SkyTexture::trace(front, 256, |n, blocks| {
                let answer = TexelBlock::by_texels(|n, texels| {
                    let at = |&(c, r): &(u32, u32)| texel_direction(c as usize, r as usize, n, DVec2::splat(0.5));
                    texels.iter().map(|t| skyline(at(t))).collect()
                });
                let mut answer = answer;
                answer(n, blocks);
                told.extend(blocks.iter().map(|block| (n, *block)));
            });
            let answers = texture.answers();
            let asked: u32 = answers.iter().map(|level| level.asked.count()).sum();
            assert_eq!(asked, told.iter().map(|(_, block)| block.wanted.count_ones()).sum::<u32>());
            for (n, block) in told {
                assert_eq!(answers[(n / 32).ilog2() as usize].of(&block), (block.wanted, block.ones));
                given += block.wanted.count_ones();
            }
        }
        assert!(given > 15_000, "{given}");
    }

    fn traced(base: usize, fine: usize, normal: DVec3) -> (SkyTexture, BitSquare, usize) {
        let mut rays = 0;
        let front = front_of(base, normal, &texel_centres(base));
        let (texture, dense) = SkyTexture::trace(
            front,
            fine,
            TexelBlock::by_texels(|n, texels| {
                rays += texels.len();
                let at = |&(c, r): &(u32, u32)| texel_direction(c as usize, r as usize, n, DVec2::splat(0.5));
                texels.iter().map(|t| skyline(at(t))).collect()
            }),
        );
        (texture, dense, rays)
    }

    /// A smooth skyline refined from 128 to 1024 equals the flat 1024 texture in all but 0.02 % of
    /// its bits, for under 8 % of its rays.
    #[test]
    fn a_refined_skyline_equals_the_flat_texture() {
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

    /// 5 textures of different normals come back from packing, unpacking and splitting, and every
    /// truncated block is refused.
    #[test]
    fn textures_come_back_and_cut_blocks_are_refused() {
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
}
