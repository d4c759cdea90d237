//! A tile made ready for moments. In: its decoded layers, once. Out: irradiance of its receivers in the light of one condition.

use glam::DVec3;
use pulp::Arch;

use crate::layers::canopy::{Powers, SKY};
use crate::layers::mosaic::Mosaic;
use crate::layers::response::Response;
use crate::layers::sides::TextureSides;
use crate::replay::components::Component;
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::each_sun::EachSun;
use crate::replay::direct::specular::MirrorView;
use crate::replay::direct::through_canopy::coefficients_behind;
use crate::replay::moment_light::{MomentLight, SkyGrids};
use crate::replay::response_sums::product;
use crate::replay::sources::Sources;
use crate::replay::tile_layers::TileLayers;
use crate::replay::values::TileValues;
use crate::sky::projection::Projection;
use crate::sky::skies::{response_coefficients, sky_coefficients};

/// A tile whose receivers are asked for one moment after another.
pub struct MomentTile {
    pub(super) receivers: Vec<ReadyReceiver>,
}

/// What a receiver makes of light.
pub(super) struct ReadyReceiver {
    pub(super) normal: DVec3,
    pub(super) sky: Mosaic,
    /// What canopies let through, if they stand before its sky.
    pub(super) veil: Option<CanopyTransmittance>,
    pub(super) mirrors: Vec<MirrorView>,
    /// `[patch]`, then the band at the horizon, of the sky seen directly, in mirrors and by way of surfaces: irradiance per unit of each
    /// source. Empty where nothing is seen.
    pub(super) of_sky: [Vec<f32>; 3],
    /// `[texel][axis]`; empty where nothing reflects.
    pub(super) response: Vec<[f32; 3]>,
}

impl MomentTile {
    /// Of layers with the responses of one state.
    pub(super) fn new(layers: TileLayers, powers: &Powers, grids: &SkyGrids, sides: TextureSides) -> Self {
        let TileLayers { normals, sky, mirrors, canopies, responses, .. } = layers;
        let (mut mirrors, mut canopies) = (mirrors.into_iter(), canopies.into_iter());
        let mut responses = responses.into_iter().next().unwrap_or_default().into_iter();
        let receivers = normals.into_iter().zip(sky).map(|(normal, sky)| {
            // Layers that a tile does not have are empty.
            let (mirrors, canopy) = (mirrors.next().unwrap_or_default(), canopies.next().unwrap_or_default());
            let veil = canopy.through(SKY, powers).map(|shares| CanopyTransmittance::new(shares, sides));
            let mut direct = Vec::with_capacity(grids.sky.patches() + 1);
            match &veil {
                None => sky_coefficients(&grids.sky, normal, &sky, &mut direct),
                Some(veil) => coefficients_behind(&grids.sky, normal, &sky, veil, &mut direct),
            }
            let response = responses.next().as_ref().map_or_else(Vec::new, Response::vectors);
            let mut diffuse = Vec::new();
            if !response.is_empty() {
                response_coefficients(&grids.response, &response, &mut diffuse);
            }
            let of_sky = [direct, specular(&grids.sky, normal, &mirrors), diffuse];
            ReadyReceiver { normal, sky, veil, mirrors, of_sky, response }
        });
        MomentTile { receivers: receivers.collect() }
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        let of = |receiver: &ReadyReceiver| {
            let mirrors: usize = receiver.mirrors.iter().map(MirrorView::bytes).sum();
            let floats = receiver.of_sky.iter().map(Vec::len).sum::<usize>() + 3 * receiver.response.len();
            let veil = receiver.veil.as_ref().map_or(0, CanopyTransmittance::bytes);
            size_of::<ReadyReceiver>() + receiver.sky.bytes() + mirrors + veil + floats * size_of::<f32>()
        };
        self.receivers.iter().map(of).sum()
    }

    /// Irradiance of every receiver, W/m2, one result: the six components and their total.
    pub fn irradiance(&self, light: &MomentLight) -> TileValues {
        let mut out = TileValues::new(self.receivers.len(), 1);
        for (row, receiver) in self.receivers.iter().enumerate() {
            let parts = receiver.irradiance(light);
            for (component, value) in Component::ALL.into_iter().zip(parts) {
                out.row_mut(component, row).fill(value);
            }
            out.row_mut(Component::Total, row).fill(parts.iter().sum());
        }
        out
    }
}

impl ReadyReceiver {
    /// The six components, in their order. A texture may be below 0 by its error, and so may parts of a sky.
    fn irradiance(&self, light: &MomentLight) -> [f32; 6] {
        let MomentLight { suns, circumsolar, reflected: [sun_reflected, sky_reflected], radiances } = light;
        let [direct, specular, diffuse] = &self.of_sky;
        let of_sky = |coefficients: &[f32]| dot(coefficients, radiances);
        [
            self.of_suns(suns),
            of_sky(direct) + self.of_suns(circumsolar),
            self.of_response(sun_reflected),
            of_sky(diffuse) + self.of_response(sky_reflected),
            self.in_mirrors(suns),
            of_sky(specular) + self.in_mirrors(circumsolar),
        ]
        .map(|value| value.max(0.0))
    }

    fn of_suns(&self, suns: &EachSun) -> f32 {
        let mut sum = [0.0_f64];
        match &self.veil {
            None => suns.direct_seen(self.normal, &self.sky, &mut sum),
            Some(veil) => suns.direct_behind(self.normal, &self.sky, veil, &mut sum),
        }
        sum[0] as f32
    }

    fn in_mirrors(&self, suns: &EachSun) -> f32 {
        let mut sum = [0.0_f64];
        self.mirrors.iter().for_each(|view| suns.by_mirrors(self.normal, view, &mut sum));
        sum[0] as f32
    }

    fn of_response(&self, sources: &Sources) -> f32 {
        let mut sum = [0.0_f32];
        if !self.response.is_empty() {
            sources.irradiance(&self.response, &mut sum);
        }
        sum[0]
    }
}

/// The sum of products; sources that a sky does not have are the last, and there may be no sky.
fn dot(coefficients: &[f32], radiances: &[f32]) -> f32 {
    let count = coefficients.len().min(radiances.len());
    Arch::new().dispatch(|| product(&coefficients[..count], &radiances[..count]))
}

/// The coefficients of the sky in mirrors.
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
