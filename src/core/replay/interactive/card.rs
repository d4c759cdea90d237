//! Texels for a graphics card. In: a prepared tile, the light of one condition. Out: words and
//! numbers whose products a shader adds up. The texels hold everything that has to be looked up or
//! computed of the sun and the sky.

use crate::replay::direct::sun_samples::DiscPart;
use crate::replay::interactive::light::InteractiveLight;
use crate::replay::interactive::shape::{PATCHES, Shape, WORDS};

/// Receivers of a tile as texels of four 32-bit words.
#[derive(Clone, Copy, Debug, Default)]
pub struct TileTextures<'t> {
    /// Layout of the words.
    pub shape: Shape,
    /// Words of all texels.
    pub words: &'t [u32],
    /// `[receiver]`: number of the receiver's first texel.
    pub starts: &'t [u32],
}

/// Light of one condition as texels of four numbers.
#[derive(Default)]
pub struct LightTexels {
    /// Numbers of all texels. The last texel is filled up with zeros.
    pub numbers: Vec<f32>,
    /// Number of parts of solar discs. The texels start with two for each part: normal irradiance x
    /// direction and 0 (sun) or 1 (circumsolar sky); then base texel, share of the disc, number of
    /// the first of the part's fine texels and their count. One texel for each fine texel follows:
    /// place in the base texel, share of the disc.
    pub parts: usize,
    /// First texel of the suns on responses, and their number. Such a texel holds irradiance x
    /// direction in the frame of a response texel, then the number of that response texel.
    pub reflected: [usize; 2],
    /// First texel of the sky on responses, with one texel for each texel of a response: irradiance
    /// x direction in that texel's frame, then 0.
    pub field: usize,
    /// First texel of the radiances, and the number of coefficient texels that they belong to. The
    /// first texel holds the radiance of the band at the horizon alone; the radiances of the sky
    /// patches follow.
    pub radiances: [usize; 2],
}

impl InteractiveLight {
    /// Returns this light for a graphics card. `side` is the number of base texels a side of the
    /// sky, and `patches` the number of sky patches.
    pub fn texels(&self, side: usize, patches: usize) -> LightTexels {
        let lit = [(&self.suns, 0.0), (&self.circumsolar, 1.0)];
        let parts: Vec<(f32, DiscPart)> =
            lit.into_iter().flat_map(|(suns, component)| suns.parts().map(move |part| (component, part))).collect();
        // A new row of base texels starts a new group of 64.
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
