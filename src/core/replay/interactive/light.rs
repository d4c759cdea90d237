//! The light of one condition, looked up once for all prepared tiles. In: a condition in the axes
//! of a site, a sky model. Out: suns on the textures, radiances of the sky patches.

use crate::error::Result;
use crate::hemisphere::Frame;
use crate::layers::sides::TextureSides;
use crate::replay::direct::sun_samples::SunSamples;
use crate::replay::interactive::packed::{frames, in_frame};
use crate::replay::sun_sample::SunSample;
use crate::replay::sun_texels::Sources;
use crate::replay::tile::PROJECTION_SAMPLES;
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::sky::skies::Skies;
use crate::sky::sky_field::SkyField;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Sky patches projected on the textures of a site. Each projection has the band at the horizon as
/// its last source, which a sky without such a band leaves out.
pub struct SkyGrids {
    pub patches: Patches,
    pub sky: Projection,
    pub response: Projection,
    /// Frames of the texels of a response.
    pub frames: Vec<Frame>,
}

impl SkyGrids {
    /// Projects `patches` sky patches on textures of the given sides. Returns an error if there is
    /// no division into that many patches.
    pub fn new(patches: usize, sides: TextureSides) -> Result<Self> {
        let patches = Patches::new(patches)?;
        let of = |side| Projection::new(&patches, side, PROJECTION_SAMPLES).under(SkyModel::Perez1990);
        let (sky, response) = (of(sides.sky_base), of(sides.response));
        Ok(SkyGrids { patches, sky, response, frames: frames(sides.response) })
    }
}

/// Light of one condition, looked up for all tiles.
pub struct InteractiveLight {
    pub(super) suns: SunSamples,
    /// Circumsolar light of the sky, as suns at the positions of the sun.
    pub(super) circumsolar: SunSamples,
    /// Suns on responses: number of the response texel, irradiance x direction in its frame.
    pub(super) reflected: Vec<(u32, [f32; 3])>,
    /// `[axis][texel]`: irradiance x direction of the sky, circumsolar light included, in the frame
    /// of each response texel.
    pub(super) reflected_sky: [Vec<f32>; 3],
    /// `[patch]`: radiances, followed by the band at the horizon if the sky has one. Empty without
    /// a sky.
    pub(super) radiances: Vec<f32>,
}

impl InteractiveLight {
    /// Looks up the light of a condition under the given sky model.
    pub(super) fn new(condition: Condition, sky: SkyModel, grids: &SkyGrids, sides: TextureSides) -> Self {
        let (conditions, bins) = ([condition], Bins::each(1));
        let suns = SunSample::of_suns(&conditions, &bins);
        let circumsolar = SunSample::of_circumsolar(&conditions, &bins, sky);
        let skies = Skies::new(&conditions, &[&bins], sky, &grids.patches, &grids.sky.open_horizontal_sr).pop();
        let skies = skies.unwrap_or_default();
        let in_frame_of = |texel: usize, vector: [f64; 3]| in_frame(&grids.frames[texel], vector);
        let mut reflected = Vec::new();
        Sources::new(&suns, sides.response)
            .vectors(|_, texel, vector| reflected.push((texel as u32, in_frame_of(texel, vector))));
        // Responses are linear, so circumsolar light and the rest of the sky share one field.
        let mut field = vec![[0.0_f64; 3]; grids.frames.len()];
        let mut add = |_: usize, texel: usize, vector: [f64; 3]| {
            field[texel].iter_mut().zip(vector).for_each(|(sum, part)| *sum += part);
        };
        Sources::new(&circumsolar, sides.response).vectors(&mut add);
        if let Some(sky) = SkyField::new(&skies, &grids.response) {
            sky.vectors(&grids.response, |bin, texel, vector| add(bin, texel, vector.to_array()));
        }
        let field: Vec<[f32; 3]> = field.into_iter().enumerate().map(|(t, vector)| in_frame_of(t, vector)).collect();
        InteractiveLight {
            suns: SunSamples::new(suns, sides),
            circumsolar: SunSamples::new(circumsolar, sides),
            reflected,
            reflected_sky: [0, 1, 2].map(|part| field.iter().map(|vector| vector[part]).collect()),
            radiances: skies.radiances().next().map_or_else(Vec::new, <[f32]>::to_vec),
        }
    }
}
