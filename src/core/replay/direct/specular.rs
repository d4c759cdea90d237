//! The sky and the sun that a receiver sees in mirrors. In: the receiver's windows. Out: specular
//! irradiance from suns and sky patches.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use crate::hemisphere::{texel_direction, texel_of};
use crate::layers::mirror::Window;
use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::{BaseTexel, SkyBitmap, Texel};
use crate::light::mirrors::{MirrorTable, Reflection};
use crate::site::chain::Chain;
use crate::sky::horizon::{BandTexel, HorizonBand};
use crate::sky::projection::Projection;

/// Part of the sky that a receiver sees by one chain of mirrors: a window through which the
/// receiver's mirror image looks.
#[derive(Clone, Debug)]
pub struct MirrorView {
    /// Mirrors of the chain, and what they leave of the light.
    pub reflection: Reflection,
    /// Numbers of the mirrors of the chain.
    pub chain: Chain,
    /// Column and row of the window's first base texel.
    column: usize,
    row: usize,
    /// Number of fine texels a side of the whole sky.
    whole: usize,
    sky: SkyBitmap,
}

impl MirrorView {
    /// Decodes a window of a sky of the given sides. Returns `None` if it does not describe a
    /// texture.
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

    /// Returns the approximate size in bytes.
    pub fn bytes(&self) -> usize {
        self.sky.bytes() + 512
    }

    /// Returns the bitmap of the sky that the window shows.
    pub fn sky(&self) -> &SkyBitmap {
        &self.sky
    }

    /// Returns the first base texel of the window in the whole sky.
    pub fn first(&self) -> BaseTexel {
        BaseTexel { column: self.column, row: self.row }
    }

    /// Returns the number of base texels a side of the whole sky.
    pub fn whole_base(&self) -> usize {
        self.whole / self.sky.block().max(1)
    }

    /// Returns the content of a base texel of the whole sky; closed outside the window.
    #[inline]
    pub fn texel(&self, column: usize, row: usize) -> Texel<'_> {
        let (column, row) = (column.wrapping_sub(self.column), row.wrapping_sub(self.row));
        // Places before the window wrap to large numbers, so one comparison serves both ends.
        if column < self.sky.side() && row < self.sky.side() { self.sky.texel(column, row) } else { Texel::Closed }
    }

    /// Returns true if the chain shows a direction of the sky.
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

    /// Splits the window by what `of` tells of the directions in which the middles of its base
    /// texels are seen.
    pub fn split<K: Ord>(&self, of: impl Fn(DVec3) -> K) -> BTreeMap<K, MirrorView> {
        let (side, whole) = (self.sky.side(), self.whole_base());
        let seen = |texel: usize| {
            let (column, row) = (self.column + texel % side, self.row + texel / side);
            of(self.reflection.mirrored(texel_direction(column, row, whole, DVec2::splat(0.5))))
        };
        let parts = self.sky.split(seen).into_iter();
        parts.map(|(key, sky)| (key, MirrorView { sky, reflection: self.reflection.clone(), ..*self })).collect()
    }

    /// Returns the fine texels (column, row) of the whole sky that are seen.
    pub fn visible(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (side, block) = (self.sky.side() * self.sky.block(), self.sky.block());
        let seen =
            (0..side * side).map(move |t| (t % side, t / side)).filter(|&(column, row)| self.sky.get(column, row));
        seen.map(move |(column, row)| (column + self.column * block, row + self.row * block))
    }

    /// Adds the irradiance per unit radiance of each patch, without the solid angle of the texels.
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
    /// Returns the irradiance by way of the mirrors from a band at the horizon that gives an
    /// unobstructed wall 1.
    pub fn horizon(&self, band: &HorizonBand, side: usize, normal: DVec3) -> f64 {
        let image = self.reflection.image(normal);
        let of = |found: &BandTexel| {
            let cos = image.truncate().dot(found.flat);
            let share = if cos > 0.0 { self.share(found.texel % side, found.texel / side) } else { 0.0 };
            if share > 0.0 { cos * share * self.reflection.share(found.direction) } else { 0.0 }
        };
        band.texels().iter().map(of).sum()
    }

    /// Returns the share of a base texel of the whole sky that is seen.
    fn share(&self, column: usize, row: usize) -> f64 {
        let (column, row) = (column.wrapping_sub(self.column), row.wrapping_sub(self.row));
        let side = self.sky.side();
        if column < side && row < side { self.sky.share(row * side + column) } else { 0.0 }
    }
}
