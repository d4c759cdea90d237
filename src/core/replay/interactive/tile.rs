//! A tile prepared for interactive replay. In: its decoded layers, once. Out: irradiance of its
//! receivers in the light of one condition.

use glam::DVec3;
use pulp::Arch;

use crate::layers::canopy::{Powers, SKY};
use crate::layers::response::Response;
use crate::layers::sides::TextureSides;
use crate::replay::components::Component;
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::specular::MirrorView;
use crate::replay::direct::sun_samples::SunSamples;
use crate::replay::interactive::card::TileTextures;
use crate::replay::interactive::light::{InteractiveLight, SkyGrids};
use crate::replay::interactive::packed::{Packed, Unpacked};
use crate::replay::interactive::packed_sky::SkyWords;
use crate::replay::interactive::shape::{Shape, WORDS};
use crate::replay::response_sums::product;
use crate::replay::through_canopy::coefficients_behind;
use crate::replay::tile_layers::TileLayers;
use crate::replay::values::TileValues;
use crate::sky::projection::Projection;
use crate::sky::skies::sky_coefficients;

/// Tile prepared for one condition after another.
pub struct InteractiveTile {
    shape: Shape,
    /// Number of sky patches.
    patches: usize,
    /// Words of all receivers.
    words: Vec<u32>,
    /// `[receiver]`: number of the receiver's first texel.
    starts: Vec<u32>,
    /// `[receiver]`: canopies and mirrors; empty if the tile has neither.
    besides: Vec<Besides>,
}

/// Data of a receiver that its words do not hold.
struct Besides {
    /// Share of light that canopies let through, if they stand before the receiver's sky.
    veil: Option<CanopyTransmittance>,
    mirrors: Vec<MirrorView>,
    /// `[patch]`, then the band at the horizon: irradiance per radiance of the sky seen in mirrors;
    /// empty without mirrors.
    of_sky: Vec<f32>,
}

impl InteractiveTile {
    /// Packs the layers of a tile with the responses of one state.
    pub(super) fn new(layers: TileLayers, powers: &Powers, grids: &SkyGrids, sides: TextureSides) -> Self {
        let TileLayers { normals, sky, mirrors, canopies, responses, .. } = layers;
        let (mut mirrors, mut canopies) = (mirrors.into_iter(), canopies.into_iter());
        let responses = responses.into_iter().next().unwrap_or_default();
        let patches = grids.sky.patches();
        let side = if responses.is_empty() { 0 } else { sides.response };
        let shape = sky.first().map_or_else(Shape::default, |sky| Shape::new(patches, side, sky));
        let mut responses = responses.iter();
        let mut made = InteractiveTile { shape, patches, words: Vec::new(), starts: Vec::new(), besides: Vec::new() };
        let mut coefficients = Vec::new();
        for (normal, sky) in normals.into_iter().zip(&sky) {
            // Layers that a tile does not have are empty.
            let (mirrors, canopy) = (mirrors.next().unwrap_or_default(), canopies.next().unwrap_or_default());
            let veil = canopy.through(SKY, powers).map(|shares| CanopyTransmittance::new(&shares, sides));
            coefficients.clear();
            match &veil {
                None => sky_coefficients(&grids.sky, normal, sky, &mut coefficients),
                Some(veil) => coefficients_behind(&grids.sky, normal, sky, veil, &mut coefficients),
            }
            let response = responses.next().map_or_else(Vec::new, Response::vectors);
            made.starts.push((made.words.len() / WORDS) as u32);
            let unpacked = Unpacked { normal, coefficients: &coefficients, response: &response, sky };
            unpacked.pack(shape, &grids.frames, &mut made.words);
            let of_sky = specular(&grids.sky, normal, &mirrors);
            made.besides.push(Besides { veil, mirrors, of_sky });
        }
        if made.besides.iter().all(Besides::is_nothing) {
            made.besides = Vec::new();
        }
        made.words.shrink_to_fit();
        made
    }

    /// Returns the approximate size in bytes.
    pub fn bytes(&self) -> usize {
        let words = self.words.len() + self.starts.len();
        size_of::<InteractiveTile>() + words * size_of::<u32>() + self.besides.iter().map(Besides::bytes).sum::<usize>()
    }

    /// Returns the receivers for a graphics card, or `None` if the tile has mirrors or canopies,
    /// whose light the words do not hold.
    pub fn textures(&self) -> Option<TileTextures<'_>> {
        let all = TileTextures { shape: self.shape, words: &self.words, starts: &self.starts };
        self.besides.is_empty().then_some(all)
    }

    /// Returns the irradiance of every receiver, W/m2, for one result: the six components and their
    /// total.
    pub fn irradiance(&self, light: &InteractiveLight) -> TileValues {
        let mut out = TileValues::new(self.starts.len(), 1);
        for (row, start) in self.starts.iter().enumerate() {
            let receiver = Packed::new(&self.words[*start as usize * WORDS..], self.shape);
            let sky = SkyWords::new(receiver.sky, self.shape);
            let parts = irradiance(receiver, sky, self.patches, self.besides.get(row), light);
            for (component, value) in Component::ALL.into_iter().zip(parts) {
                out.row_mut(component, row).fill(value);
            }
            out.row_mut(Component::Total, row).fill(parts.iter().sum());
        }
        out
    }
}

impl Besides {
    fn is_nothing(&self) -> bool {
        self.veil.is_none() && self.mirrors.is_empty()
    }

    fn bytes(&self) -> usize {
        let mirrors: usize = self.mirrors.iter().map(MirrorView::bytes).sum();
        let veil = self.veil.as_ref().map_or(0, CanopyTransmittance::bytes);
        size_of::<Besides>() + mirrors + veil + self.of_sky.len() * size_of::<f32>()
    }

    fn in_mirrors(&self, normal: DVec3, suns: &SunSamples) -> f32 {
        let mut sum = [0.0_f64];
        self.mirrors.iter().for_each(|view| suns.by_mirrors(normal, view, &mut sum));
        sum[0] as f32
    }
}

/// Returns the six components in the order of `Component::ALL`. Negative sums, which rounding of
/// the textures or parts of a sky may cause, become 0.
fn irradiance(
    receiver: Packed,
    mut sky: SkyWords,
    patches: usize,
    besides: Option<&Besides>,
    light: &InteractiveLight,
) -> [f32; 6] {
    let InteractiveLight { suns, circumsolar, reflected, reflected_sky, radiances } = light;
    let normal = receiver.normal();
    let mut direct = |suns: &SunSamples| {
        let mut sum = [0.0_f64];
        match besides.and_then(|besides| besides.veil.as_ref()) {
            None => suns.direct_seen(normal, &mut sky, &mut sum),
            Some(veil) => suns.direct_behind(normal, &mut sky, veil, &mut sum),
        }
        sum[0] as f32
    };
    let [sun_direct, glow_direct] = [suns, circumsolar].map(&mut direct);
    let [sun_mirrored, glow_specular] =
        [suns, circumsolar].map(|suns| besides.map_or(0.0, |besides| besides.in_mirrors(normal, suns)));
    [
        sun_direct,
        receiver.of_sky(radiances, patches) + glow_direct,
        receiver.of_sources(reflected),
        receiver.of_field(reflected_sky),
        sun_mirrored,
        besides.map_or(0.0, |besides| dot(&besides.of_sky, radiances)) + glow_specular,
    ]
    .map(|value| value.max(0.0))
}

/// Returns the sum of products over the sources that both have. A sky may lack the last source, and
/// there may be no sky.
fn dot(coefficients: &[f32], radiances: &[f32]) -> f32 {
    let count = coefficients.len().min(radiances.len());
    Arch::new().dispatch(|| product(&coefficients[..count], &radiances[..count]))
}

/// Returns the coefficients of the sky seen in mirrors.
fn specular(projection: &Projection, normal: DVec3, views: &[MirrorView]) -> Vec<f32> {
    if views.is_empty() {
        return Vec::new();
    }
    let mut patches = vec![0.0_f64; projection.patches()];
    views.iter().for_each(|view| view.add_patches(projection, normal, &mut patches));
    let of_band =
        projection.horizon().map(|band| views.iter().map(|v| v.horizon(band, projection.side(), normal)).sum::<f64>());
    patches.into_iter().map(|sum| (sum * projection.texel_sr()) as f32).chain(of_band.map(|sum| sum as f32)).collect()
}
