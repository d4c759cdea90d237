//! The light of one condition, looked up once for all tiles of moments. In: a condition in the axes of a site, a sky. Out: suns on the textures,
//! radiances of patches.

use crate::error::Result;
use crate::layers::sides::TextureSides;
use crate::replay::direct::each_sun::EachSun;
use crate::replay::shine::Shine;
use crate::replay::sources::Sources;
use crate::replay::tile::PROJECTION_SAMPLES;
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::sky::skies::Skies;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Patches on the textures of a site, each with the band at the horizon behind them: skies without one leave that source out.
pub struct SkyGrids {
    pub patches: Patches,
    pub sky: Projection,
    pub response: Projection,
}

impl SkyGrids {
    /// Of so many patches; an error if they are not offered.
    pub fn new(patches: usize, sides: TextureSides) -> Result<Self> {
        let patches = Patches::new(patches)?;
        let of = |side| Projection::new(&patches, side, PROJECTION_SAMPLES).under(SkyModel::Perez1990);
        let (sky, response) = (of(sides.sky_base), of(sides.response));
        Ok(SkyGrids { patches, sky, response })
    }
}

/// One condition, looked up for all tiles.
pub struct MomentLight {
    pub(super) suns: EachSun,
    /// Light of the sky from where the suns are.
    pub(super) circumsolar: EachSun,
    /// The same of both, on responses.
    pub(super) reflected: [Sources; 2],
    /// `[patch]`, then the band at the horizon, if the sky has one; empty without a sky.
    pub(super) radiances: Vec<f32>,
}

impl MomentLight {
    /// Of a condition, and the model of its sky.
    pub(super) fn new(condition: Condition, sky: SkyModel, grids: &SkyGrids, sides: TextureSides) -> Self {
        let (conditions, bins) = ([condition], Bins::each(1));
        let suns = Shine::of_suns(&conditions, &bins);
        let circumsolar = Shine::of_circumsolar(&conditions, &bins, sky);
        let reflected = [&suns, &circumsolar].map(|suns| Sources::new(suns, sides.response));
        let skies = Skies::new(&conditions, &[&bins], sky, &grids.patches, &grids.sky.open_horizontal_sr);
        let radiances = skies.first().and_then(|skies| skies.radiances().next());
        MomentLight {
            suns: EachSun::new(suns, sides),
            circumsolar: EachSun::new(circumsolar, sides),
            reflected,
            radiances: radiances.map_or_else(Vec::new, <[f32]>::to_vec),
        }
    }
}
