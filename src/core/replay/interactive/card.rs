//! InteractiveReplay for a graphics card: the words of a tile, and the light of one condition as texels. In: a tile made ready, a light. Out: words and
//! numbers whose products a shader adds up. All that is looked up or computed of sun and sky is in them.

use crate::replay::direct::sun_samples::DiscPart;
use crate::replay::interactive::light::InteractiveLight;
use crate::replay::interactive::packed::{PATCHES, Shape, WORDS};

/// The receivers of a tile as texels of four words of 32 bits.
#[derive(Clone, Copy, Debug, Default)]
pub struct TileTextures<'t> {
    /// Where what is in them.
    pub shape: Shape,
    /// All texels.
    pub words: &'t [u32],
    /// `[receiver]`: its first texel.
    pub starts: &'t [u32],
}

/// One light; a texel is 4 numbers.
#[derive(Default)]
pub struct LightTexels {
    /// All texels, the last of zeros where radiances do not fill them.
    pub numbers: Vec<f32>,
    /// Parts of discs, with which the texels start, two each: normal irradiance x direction, 0 of the sun or 1 of the sky; base texel, share of
    /// the disc, first of its fine texels and their count. Then the fine ones: place in the base texel, share of the disc.
    pub parts: usize,
    /// First of the texels of suns on responses, and how many: irradiance x direction in the frame of a texel, which is the fourth number.
    pub reflected: [usize; 2],
    /// First of the texels of the sky on responses, likewise, one for each texel of a response.
    pub field: usize,
    /// First of the texels of radiances, in which the band at the horizon stands alone before the patches, and texels of their coefficients.
    pub radiances: [usize; 2],
}

impl InteractiveLight {
    /// The same light for a card; `side` of the sky before it is refined, number of its patches.
    pub fn texels(&self, side: usize, patches: usize) -> LightTexels {
        let lit = [(&self.suns, 0.0), (&self.circumsolar, 1.0)];
        let parts: Vec<(f32, DiscPart)> =
            lit.into_iter().flat_map(|(suns, component)| suns.parts().map(move |part| (component, part))).collect();
        // Rows of base texels start new groups.
        let stride = side.div_ceil(64) * 64;
        let mut numbers = Vec::new();
        let mut first = 2 * parts.len();
        for (component, DiscPart { light, column, row, share, fine }) in &parts {
            numbers.extend(light.as_vec3().to_array().into_iter().chain([*component]));
            let texel = *row as usize * stride + *column as usize;
            numbers.extend([texel as f32, *share, first as f32, fine.len() as f32]);
            first += fine.len();
        }
        for (place, share) in parts.iter().flat_map(|(_, part)| part.fine) {
            numbers.extend([*place as f32, *share, 0.0, 0.0]);
        }
        let reflected = [numbers.len() / WORDS, self.reflected.len()];
        numbers.extend(self.reflected.iter().flat_map(|&(texel, [a, u, v])| [a, u, v, texel as f32]));
        let field = numbers.len() / WORDS;
        let [a, u, v] = &self.reflected_sky;
        numbers.extend(a.iter().zip(u).zip(v).flat_map(|((a, u), v)| [*a, *u, *v, 0.0]));
        let (of_patches, band) = self.radiances.split_at(patches.min(self.radiances.len()));
        let radiances = [numbers.len() / WORDS, of_patches.len().div_ceil(PATCHES)];
        numbers.extend([band.first().copied().unwrap_or_default(), 0.0, 0.0, 0.0]);
        numbers.extend(of_patches);
        numbers.resize((radiances[0] + 1) * WORDS + radiances[1] * PATCHES, 0.0);
        LightTexels { numbers, parts: parts.len(), reflected, field, radiances }
    }
}
