//! Direct light behind canopies. In: suns and skies for each set of transmittances, sky bits and
//! crossings of receivers. Out: `sun_direct` and `sky_direct` of the receivers that see the sky
//! through canopies.

use glam::DVec3;

use crate::layers::canopy::{Powers, SKY};
use crate::layers::sides::TextureSides;
use crate::layers::sky::half_texel;
use crate::layers::sky_bitmap::{SkyBitmap, Texel};
use crate::replay::components::Component::{SkyDirect, SunDirect};
use crate::replay::components::ComponentSet;
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::suns::SunLookups;
use crate::replay::sun_sample::SunSample;
use crate::replay::tile_layers::TileLayers;
use crate::replay::values::{TileValues, put};
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::sky::skies::{Skies, mean_positive};
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Weather of each set of transmittances.
pub struct DirectThroughCanopy {
    ways: Vec<Way>,
    sides: TextureSides,
}

/// Suns and skies of the conditions in which canopies let the same shares through.
struct Way {
    powers: Powers,
    suns: SunLookups,
    skies: Skies,
    /// Circumsolar light of the sky.
    circumsolar: SunLookups,
}

impl DirectThroughCanopy {
    /// Looks up suns and skies for each set of transmittances. The bins of a set say how conditions
    /// add to the results with it. `projection` is that of the base texels.
    pub fn new(
        conditions: &[Condition],
        leafages: Vec<(Powers, Bins)>,
        model: SkyModel,
        components: ComponentSet,
        patches: &Patches,
        projection: &Projection,
        sides: TextureSides,
    ) -> Self {
        let when = |needed: bool| -> &[Condition] { if needed { conditions } else { &[] } };
        let (of_sun, of_sky) = (when(components.needs(SunDirect)), when(components.needs(SkyDirect)));
        let ways: Vec<&Bins> = leafages.iter().map(|(_, bins)| bins).collect();
        let open_sr = &projection.open_horizontal_sr;
        let skies = Skies::new(of_sky, &ways, model, patches, open_sr);
        let looked_up = |suns, bins: &Bins| SunLookups::new(suns, bins.count, sides);
        let way = |((powers, bins), skies): ((Powers, Bins), Skies)| Way {
            powers,
            suns: looked_up(SunSample::of_suns(of_sun, &bins), &bins),
            skies,
            circumsolar: looked_up(SunSample::of_circumsolar(of_sky, &bins, model), &bins),
        };
        let ways = leafages.into_iter().zip(skies).map(way);
        DirectThroughCanopy { ways: ways.collect(), sides }
    }

    /// Replaces the direct light of a tile's receivers that see the sky through canopies.
    pub fn replace(&self, tile: &TileLayers, projection: &Projection, out: &mut TileValues) {
        // Transmittances do not decide if a ray crosses a canopy, so the first set tells for all.
        let Some(first) = self.ways.first() else { return };
        let crosses = |receiver: &usize| tile.canopies[*receiver].through(SKY, &first.powers).is_some();
        let behind: Vec<usize> = (0..tile.canopies.len()).filter(crosses).collect();
        let veil = |receiver: usize, way: &Way| match tile.canopies[receiver].through(SKY, &way.powers) {
            Some(shares) => CanopyTransmittance::new(&shares, self.sides),
            None => CanopyTransmittance::clear(self.sides),
        };
        let bins = out.bins();
        let mut coefficients = vec![Vec::new(); self.ways.len()];
        let mut glows = vec![0.0_f64; behind.len() * bins];
        for (&receiver, glow) in behind.iter().zip(glows.chunks_mut(bins.max(1))) {
            let (normal, sky) = (tile.normals[receiver], &tile.sky[receiver]);
            let mut sums = vec![0.0_f64; bins];
            for (way, coefficients) in self.ways.iter().zip(&mut coefficients) {
                let veil = veil(receiver, way);
                way.suns.direct_behind(normal, sky, &veil, &mut sums);
                way.circumsolar.direct_behind(normal, sky, &veil, glow);
                if !way.skies.is_empty() {
                    coefficients_behind(projection, normal, sky, &veil, coefficients);
                }
            }
            put(&sums, out.row_mut(SunDirect, receiver));
        }
        let mut sums = vec![0.0_f32; behind.len() * bins];
        for (way, coefficients) in self.ways.iter().zip(&coefficients).filter(|(way, _)| !way.skies.is_empty()) {
            way.skies.irradiance(coefficients, |i, bin, v| sums[i * bins + bin] += v);
        }
        let of_receivers = sums.chunks(bins.max(1)).zip(glows.chunks(bins.max(1)));
        for (&receiver, (sums, glow)) in behind.iter().zip(of_receivers) {
            let row = out.row_mut(SkyDirect, receiver);
            row.iter_mut().zip(sums).zip(glow).for_each(|((out, sum), glow)| *out = (sum + *glow as f32).max(0.0));
        }
    }
}

/// Computes [`crate::sky::skies::sky_coefficients`] behind canopies.
pub fn coefficients_behind(
    projection: &Projection,
    normal: DVec3,
    sky: &SkyBitmap,
    veil: &CanopyTransmittance,
    out: &mut Vec<f32>,
) {
    let (base, block) = (projection.side(), sky.block());
    let half = half_texel(base);
    let mut sums = vec![0.0_f64; projection.patches()];
    let through = |texel: usize| -> Option<f64> {
        let (column, row) = (texel % base, texel / base);
        let all = 0..block * block;
        let seen = |bits: &[u64], i: usize| bits[i / 64] >> (i % 64) & 1 == 1;
        let share = |i: usize| f64::from(veil.at(column, row, i));
        match sky.texel(column, row) {
            Texel::Closed => None,
            Texel::Open => Some(veil.sum(column, row)),
            Texel::Mixed(bits) => Some(match veil.even(column, row) {
                Some(share) => f64::from(share) * f64::from(bits.iter().map(|word| word.count_ones()).sum::<u32>()),
                None => all.filter(|&i| seen(bits, i)).map(share).sum(),
            }),
        }
    };
    for texel in 0..base * base {
        let cos = mean_positive(normal.dot(projection.mean_directions[texel]), half);
        if cos != 0.0
            && let Some(sum) = through(texel)
        {
            projection.add(texel, cos * sum / (block * block) as f64, &mut sums);
        }
    }
    out.extend(sums.into_iter().map(|sum| (sum * projection.texel_sr()) as f32));
    let share = |texel| through(texel).unwrap_or(0.0) / (block * block) as f64;
    out.extend(projection.horizon().map(|band| band.seen(normal, share) as f32));
}
