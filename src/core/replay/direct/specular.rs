//! The sky and the sun that a receiver sees in mirrors. In: its windows. Out: specular irradiance of suns and patches.

use glam::DVec3;

use crate::hemisphere::texel_of;
use crate::layers::mirror::Window;
use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::{BaseTexel, SkyBitmap, Texel};
use crate::light::mirrors::{MirrorTable, Reflection};
use crate::site::chain::Chain;
use crate::sky::horizon::{BandTexel, HorizonBand};
use crate::sky::projection::Projection;

/// The part of the sky that is seen by one chain of mirrors: a window through which the receiver's image looks.
#[derive(Clone, Debug)]
pub struct MirrorView {
    pub reflection: Reflection,
    /// The chain by the numbers of its mirrors.
    pub chain: Chain,
    /// First base texel of the window.
    column: usize,
    row: usize,
    /// Fine texels a side of the whole sky.
    whole: usize,
    sky: SkyBitmap,
}

impl MirrorView {
    /// A decoded window of a sky of these sides. `None` if it does not describe a texture.
    pub fn new(window: &Window, table: &MirrorTable, sides: TextureSides) -> Option<Self> {
        let (side, block) = (usize::from(window.side), sides.sky_fine / sides.sky_base);
        let mut sky = SkyBitmap::unpack(&window.texture, 1, side, side * block)?;
        Some(MirrorView {
            reflection: Reflection::new(window.chain, table)?,
            chain: window.chain,
            column: usize::from(window.column),
            row: usize::from(window.row),
            whole: sides.sky_fine,
            sky: sky.pop()?,
        })
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.sky.bytes() + 512
    }

    /// What it shows of the sky.
    pub fn sky(&self) -> &SkyBitmap {
        &self.sky
    }

    /// Its first base texel in the whole sky.
    pub fn first(&self) -> BaseTexel {
        BaseTexel { column: self.column, row: self.row }
    }

    /// Base texels a side of the whole sky.
    pub fn whole_base(&self) -> usize {
        self.whole / self.sky.block().max(1)
    }

    /// What a base texel of the whole sky holds.
    #[inline]
    pub fn texel(&self, column: usize, row: usize) -> Texel<'_> {
        let (column, row) = (column.wrapping_sub(self.column), row.wrapping_sub(self.row));
        if column < self.sky.side() && row < self.sky.side() { self.sky.texel(column, row) } else { Texel::Closed }
    }

    /// Whether a direction of the sky is seen by the chain.
    pub fn shows(&self, sky: DVec3) -> bool {
        let block = self.sky.block();
        if sky.z <= 0.0 {
            return false;
        }
        let (column, row) = texel_of(sky, self.whole);
        let (column, row) = (column.wrapping_sub(self.column * block), row.wrapping_sub(self.row * block));
        let side = self.sky.side() * block;
        column < side && row < side && self.sky.get(column, row)
    }

    /// Fine texels (column, row) of the whole sky that are seen.
    pub fn visible(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (side, block) = (self.sky.side() * self.sky.block(), self.sky.block());
        let seen =
            (0..side * side).map(move |t| (t % side, t / side)).filter(|&(column, row)| self.sky.get(column, row));
        seen.map(move |(column, row)| (column + self.column * block, row + self.row * block))
    }

    /// Adds the irradiance per unit radiance of each patch, without the texels' solid angle.
    pub fn add_patches(&self, projection: &Projection, normal: DVec3, sums: &mut [f64]) {
        let (side, image) = (self.sky.side(), self.reflection.image(normal));
        self.sky.for_visible(|texel, share| {
            let whole = (self.row + texel / side) * projection.side() + self.column + texel % side;
            let direction = projection.mean_directions[whole];
            let cos = image.dot(direction);
            if cos > 0.0 {
                projection.add(whole, cos * share * self.reflection.share(direction.normalize_or_zero()), sums);
            }
        });
    }
    /// Irradiance by way of the mirrors of a band at the horizon that gives an open wall 1.
    pub fn horizon(&self, band: &HorizonBand, side: usize, normal: DVec3) -> f64 {
        let image = self.reflection.image(normal);
        let of = |found: &BandTexel| {
            let cos = image.truncate().dot(found.flat);
            let share = if cos > 0.0 { self.share(found.texel % side, found.texel / side) } else { 0.0 };
            if share > 0.0 { cos * share * self.reflection.share(found.direction) } else { 0.0 }
        };
        band.texels().iter().map(of).sum()
    }

    /// Share of a base texel of the whole sky that is seen.
    fn share(&self, column: usize, row: usize) -> f64 {
        let (column, row) = (column.wrapping_sub(self.column), row.wrapping_sub(self.row));
        let side = self.sky.side();
        if column < side && row < side { self.sky.share(row * side + column) } else { 0.0 }
    }
}
