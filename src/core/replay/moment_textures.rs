//! Moments for a graphics card: what a tile makes of light, and the light of one condition, as texels. In: a tile made ready, a light. Out:
//! words and numbers whose products a shader adds up. All that is looked up or computed of sun and sky is in them.
//!
//! A texel of a tile is 4 words of 32 bits. A receiver has, one after another:
//! - f32: its normal and the step of its response; the steps of its two lists of coefficients, and of both the band at the horizon;
//! - coefficients of the sky seen directly, then by way of surfaces: `[patch]`, signed bytes in steps, 16 a texel, see [`Shape::patches`];
//! - its response: `[texel]`, 10 signed bits for each axis in steps, x lowest, 4 a texel, see [`Shape::response`];
//! - its sky: `[group]`, 64 base texels each: bits of those that are sky throughout, of those that are in part, see [`Shape::groups`];
//! - `[group]`, 4 a texel: how many are in part in the groups before; then `[base texel in part]`: the fine bits, [`Shape::block`] words each.

use crate::replay::direct::each_sun::DiscPart;
use crate::replay::moment_light::MomentLight;
use crate::replay::moment_tile::{MomentTile, ReadyReceiver};

/// Words of a texel.
const WORDS: usize = 4;
/// Patches in a texel of coefficients.
const PATCHES: usize = 16;
/// Largest values of signed bytes and of 10 signed bits.
const BYTE: f32 = 127.0;
const TEN_BITS: f32 = 511.0;

/// Texels of the parts of receivers; the same in all tiles of an archive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    /// Of one list of coefficients.
    pub patches: usize,
    /// Of the response.
    pub response: usize,
    /// Of the sky's base texels, 64 each.
    pub groups: usize,
    /// Words of a base texel's fine bits.
    pub block: usize,
}

/// The receivers of a tile as texels.
#[derive(Default)]
pub struct TileTextures {
    /// Where what is in them.
    pub shape: Shape,
    /// All texels.
    pub words: Vec<u32>,
    /// `[receiver]`: its first texel.
    pub starts: Vec<u32>,
}

/// One light; a texel is 4 numbers.
#[derive(Default)]
pub struct LightTexels {
    /// All texels, the last of zeros where radiances do not fill them.
    pub numbers: Vec<f32>,
    /// Parts of discs, with which the texels start, two each: normal irradiance x direction, 0 of the sun or 1 of the sky; base texel, share of
    /// the disc, first of its fine texels and their count. Then the fine ones: place in the base texel, share of the disc.
    pub parts: usize,
    /// First of the texels of the response: irradiance x direction, the response's texel; how many are of the sun, and then of the sky.
    pub reflected: [usize; 3],
    /// First of the texels of radiances, in which the band at the horizon stands alone before the patches, and texels of their coefficients.
    pub radiances: [usize; 2],
}

impl MomentTile {
    /// Its receivers for a card; none where mirrors or canopies take part, whose light is not in textures, or words would not do.
    pub fn textures(&self, of_response: usize) -> Option<TileTextures> {
        let first = self.receivers.first()?;
        let (open, ..) = first.sky.bits();
        let shape = Shape {
            patches: first.of_sky[0].len().saturating_sub(1).div_ceil(PATCHES),
            response: (of_response * of_response).div_ceil(WORDS),
            groups: open.len(),
            block: 2 * (first.sky.block() * first.sky.block()).div_ceil(64),
        };
        let mut found = TileTextures { shape, ..TileTextures::default() };
        for receiver in &self.receivers {
            if receiver.veil.is_some() || !receiver.mirrors.is_empty() {
                return None;
            }
            found.starts.push(u32::try_from(found.words.len() / WORDS).ok()?);
            receiver.pack(shape, &mut found.words);
        }
        Some(found)
    }
}

impl ReadyReceiver {
    fn pack(&self, shape: Shape, words: &mut Vec<u32>) {
        let [direct, _, diffuse] = &self.of_sky;
        let [(direct, direct_band), (diffuse, diffuse_band)] = [direct, diffuse].map(|all| apart(all));
        let response_step = step(self.response.as_flattened(), TEN_BITS);
        let steps = [step(direct, BYTE), step(diffuse, BYTE)];
        words.extend(self.normal.as_vec3().to_array().map(f32::to_bits));
        words.extend([response_step, steps[0], steps[1], direct_band, diffuse_band].map(f32::to_bits));
        for (coefficients, step) in [direct, diffuse].into_iter().zip(steps) {
            let word = |four: &[f32]| fields(four, step, 8);
            padded(words, shape.patches, coefficients.chunks(4).map(word));
        }
        padded(words, shape.response, self.response.iter().map(|axes| fields(axes, response_step, 10)));
        let (open, mixed, ranks, blocks) = self.sky.bits();
        words.extend(open.iter().zip(mixed).flat_map(|(&open, &mixed)| halves(open).into_iter().chain(halves(mixed))));
        padded(words, shape.groups.div_ceil(WORDS), ranks.iter().copied());
        padded(words, (2 * blocks.len()).div_ceil(WORDS), blocks.iter().flat_map(|&word| halves(word)));
    }
}

impl MomentLight {
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
        let mut reflected = [numbers.len() / WORDS, 0, 0];
        for (sources, count) in self.reflected.iter().zip([1, 2]) {
            sources.vectors(|_, texel, [x, y, z]| {
                numbers.extend([x as f32, y as f32, z as f32, texel as f32]);
                reflected[count] += 1;
            });
        }
        let (of_patches, band) = self.radiances.split_at(patches.min(self.radiances.len()));
        let radiances = [numbers.len() / WORDS, of_patches.len().div_ceil(PATCHES)];
        numbers.extend([band.first().copied().unwrap_or_default(), 0.0, 0.0, 0.0]);
        numbers.extend(of_patches);
        numbers.resize((radiances[0] + 1) * WORDS + radiances[1] * PATCHES, 0.0);
        LightTexels { numbers, parts: parts.len(), reflected, radiances }
    }
}

/// Coefficients of patches, and that of the band at the horizon, which is many times as large.
fn apart(all: &[f32]) -> (&[f32], f32) {
    all.split_last().map_or((&[], 0.0), |(band, patches)| (patches, *band))
}

/// What the largest value is so many of; 0 where all are 0.
fn step(values: &[f32], largest: f32) -> f32 {
    values.iter().fold(0.0, |most: f32, value| most.max(value.abs())) / largest
}

/// Signed fields of so many bits, the first lowest.
fn fields(values: &[f32], step: f32, bits: u32) -> u32 {
    let of = |value: &f32| if step > 0.0 { (value / step).round() as i32 as u32 & ((1 << bits) - 1) } else { 0 };
    values.iter().zip(0..).fold(0, |word, (value, place)| word | of(value) << (place * bits))
}

/// Low half first, as bits are counted.
fn halves(word: u64) -> [u32; 2] {
    [word as u32, (word >> 32) as u32]
}

/// Appends words, filled up with 0 to so many texels.
fn padded(words: &mut Vec<u32>, texels: usize, of: impl Iterator<Item = u32>) {
    let end = words.len() + texels * WORDS;
    words.extend(of.take(texels * WORDS));
    words.resize(end, 0);
}
