//! One tile of receivers under a series of conditions. In: the tile's decoded layers and the
//! weather prepared once. Out: six components and their total for every receiver and condition, and
//! longwave irradiance on request.

use std::sync::Arc;

use glam::DVec3;

use crate::layers::bits::BitSquare;
use crate::layers::canopy::Powers;
use crate::layers::response::Response;
use crate::layers::sides::TextureSides;
use crate::layers::sky::half_texel;
use crate::replay::components::Component;
use crate::replay::components::Component::{
    SkyDirect, SkyMirrored, SkyReflected, SunDirect, SunMirrored, SunReflected, Total,
};
use crate::replay::components::ComponentSet;
use crate::replay::direct::sky_masks::{LANES, SkyMasks, TexelPlanes};
use crate::replay::direct::suns::SunLookups;
use crate::replay::longwave::Longwave;
use crate::replay::response_sums::ResponseSums;
use crate::replay::sun_sample::SunSample;
use crate::replay::sun_texels::Sources;
use crate::replay::through_canopy::DirectThroughCanopy;
use crate::replay::tile_layers::TileLayers;
use crate::replay::values::{Spares, TileValues, put};
use crate::site::material::Class;
use crate::site::receiver::TILE;
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::sky::skies::{Skies, mean_positive, response_coefficients, sky_coefficients};
use crate::sky::sky_field::{FEW, SkyField};
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Points a side of a texel at which patches are sampled when they are projected on textures.
pub(super) const PROJECTION_SAMPLES: usize = 8;

/// Weather prepared once for all tiles.
pub(super) struct Forcing {
    /// Number of results.
    bins: usize,
    sides: TextureSides,
    suns: SunLookups,
    skies: Skies,
    /// Skies on the base texels; only for few results.
    sky_field: Option<SkyField>,
    /// Circumsolar light of the skies.
    circumsolar: SunLookups,
    /// `[state]`: light on the response texture.
    reflected: Vec<Reflected>,
    sky_projection: Projection,
    planes: TexelPlanes,
    response_projection: Projection,
    components: ComponentSet,
    /// True if the sky that is seen in mirrors counts.
    mirror_sky: bool,
    /// True if results below 0 stay: those of parts of a sky or of a texture.
    signed: bool,
    longwave: Option<Longwave>,
    /// Direct light of receivers that see the sky through canopies.
    shaded: Option<DirectThroughCanopy>,
    spares: Arc<Spares>,
}

/// Weather of one state of the reflectances.
struct Reflected {
    sources: Sources,
    circumsolar: Sources,
    /// Skies of this state; `None` if all skies belong to it.
    skies: Option<Skies>,
    /// Sums of suns and of skies; only for few results.
    sums: Option<[ResponseSums; 2]>,
}

impl Reflected {
    /// Adds the sums if results are few. `all` are the skies if the state has none of its own.
    fn summed(self, bins: usize, all: &Skies, projection: &Projection) -> Self {
        let field = || SkyField::new(self.skies.as_ref().unwrap_or(all), projection);
        let sums = field().filter(|_| bins <= FEW).map(|field| {
            [(&self.sources, None), (&self.circumsolar, Some(&field))]
                .map(|(suns, skies)| ResponseSums::new(suns, skies, projection))
        });
        Reflected { sums, ..self }
    }
}

impl Forcing {
    /// Looks up suns and skies of all conditions, as far as the components need them. `states` says
    /// how conditions add to the results in each state of the reflectances; it is empty if there is
    /// but one state.
    pub fn new(
        conditions: &[Condition],
        bins: &Bins,
        states: &[Bins],
        model: SkyModel,
        components: ComponentSet,
        patches: &Patches,
        sides: TextureSides,
    ) -> Self {
        let when = |needed: bool| -> &[Condition] { if needed { conditions } else { &[] } };
        let skies_of = when([SkyDirect, SkyReflected, SkyMirrored].iter().any(|&c| components.needs(c)));
        let projection = |side| Projection::new(patches, side, PROJECTION_SAMPLES).under(model);
        let sky_projection = projection(sides.sky_base);
        // The first are the skies of all results; those of the states of the reflectances follow.
        let ways: Vec<&Bins> = std::iter::once(bins).chain(states).collect();
        let mut skies = Skies::new(skies_of, &ways, model, patches, &sky_projection.open_horizontal_sr).into_iter();
        let all = skies.next().unwrap_or_default();
        let state = |bins, skies| Reflected {
            sources: Sources::new(&SunSample::of_suns(when(components.needs(SunReflected)), bins), sides.response),
            circumsolar: Sources::new(
                &SunSample::of_circumsolar(when(components.needs(SkyReflected)), bins, model),
                sides.response,
            ),
            skies,
            sums: None,
        };
        let mut reflected: Vec<Reflected> = states.iter().zip(skies).map(|(bins, s)| state(bins, Some(s))).collect();
        if reflected.is_empty() {
            reflected.push(state(bins, None));
        }
        let response_projection = projection(sides.response);
        let summed = |state: Reflected| state.summed(bins.count, &all, &response_projection);
        let reflected = reflected.into_iter().map(summed).collect();
        let suns = when(components.needs(SunDirect) || components.needs(SunMirrored));
        let glows = when(components.needs(SkyDirect) || components.needs(SkyMirrored));
        Forcing {
            bins: bins.count,
            sides,
            suns: SunLookups::new(SunSample::of_suns(suns, bins), bins.count, sides),
            sky_field: SkyField::new(&all, &sky_projection),
            skies: all,
            circumsolar: SunLookups::new(SunSample::of_circumsolar(glows, bins, model), bins.count, sides),
            reflected,
            response_projection,
            planes: TexelPlanes::new(&sky_projection),
            sky_projection,
            components,
            mirror_sky: true,
            signed: false,
            longwave: None,
            shaded: None,
            spares: Arc::default(),
        }
    }

    /// Keeps results below 0, so that parts of a receiver add up to the whole.
    pub fn signed(&mut self) {
        self.signed = true;
    }

    /// Sets values below 0, by the error of a texture or by parts of a sky, to 0.
    fn clamp(&self, values: &mut [f32]) {
        if !self.signed {
            values.iter_mut().for_each(|v| *v = v.max(0.0));
        }
    }

    /// Returns the number of results.
    pub fn results(&self) -> usize {
        self.bins
    }

    /// Adds longwave irradiance.
    pub fn with_longwave(self, longwave: Longwave) -> Self {
        Forcing { longwave: Some(longwave), ..self }
    }

    /// Leaves out the sky that is seen in mirrors.
    pub fn without_mirror_sky(self) -> Self {
        Forcing { mirror_sky: false, ..self }
    }

    /// Returns true if the components need the sky seen in mirrors, and there is a sky.
    fn mirrors_sky(&self) -> bool {
        self.mirror_sky && self.components.needs(SkyMirrored) && !self.skies.is_empty()
    }

    /// Adds direct light through canopies. `leafages` says how conditions add to the results with
    /// each set of transmittances.
    pub fn behind(
        self,
        conditions: &[Condition],
        leafages: Vec<(Powers, Bins)>,
        model: SkyModel,
        patches: &Patches,
    ) -> Self {
        let (components, projection) = (self.components, &self.sky_projection);
        let shaded = DirectThroughCanopy::new(conditions, leafages, model, components, patches, projection, self.sides);
        Forcing { shaded: Some(shaded), ..self }
    }

    /// Returns the bytes that a full tile takes while it is computed: its results, and beside them
    /// those of a product and of a class of first hits.
    pub fn working_bytes(&self) -> usize {
        self.tile_bytes() + 2 * TILE * self.bins * size_of::<f32>()
    }

    /// Returns the bytes of the results of a full tile, and of the responses that they are computed
    /// from.
    pub fn tile_bytes(&self) -> usize {
        let responses = self.reflected.len() * Response::len(self.response_projection.side());
        TILE * (self.components.places() * self.bins + responses) * size_of::<f32>()
    }

    /// Returns true if the components need the receivers' sky textures.
    pub fn reads_sky(&self) -> bool {
        self.components.needs(SunDirect) && !self.suns.is_empty()
            || self.components.needs(SkyDirect) && !self.skies.is_empty()
    }

    /// Returns true if the components need the sky that the receivers see in mirrors.
    pub fn reads_mirrors(&self) -> bool {
        self.components.needs(SunMirrored) && !self.suns.is_empty() || self.mirrors_sky()
    }

    /// Returns true if the components need the receivers' responses.
    pub fn reads_responses(&self) -> bool {
        self.reflected.iter().any(|state| !state.sources.is_empty())
            || self.components.needs(SkyReflected) && !self.skies.is_empty()
    }

    /// Returns the irradiance of every receiver of a tile.
    pub fn replay(&self, tile: &TileLayers) -> TileValues {
        let mut out = TileValues::from_spares(&self.spares, tile.normals.len(), self.bins);
        self.add_direct(tile, &mut out);
        self.add_specular(tile, &mut out);
        self.add_diffuse(tile, &mut out);
        if self.components.contains(Total) {
            let mut total = vec![0.0_f32; self.bins];
            for receiver in 0..tile.normals.len() {
                total.fill(0.0);
                for part in Component::ALL.into_iter().filter(|part| *part != Total) {
                    total.iter_mut().zip(out.row(part, receiver)).for_each(|(total, v)| *total += v);
                }
                out.row_mut(Total, receiver).copy_from_slice(&total);
            }
        }
        if let Some(longwave) = &self.longwave {
            for (receiver, views) in tile.views.iter().enumerate() {
                longwave.irradiance(*views, out.row_mut(Component::Longwave, receiver));
            }
        }
        out
    }

    fn add_direct(&self, tile: &TileLayers, out: &mut TileValues) {
        let sky_direct = self.components.needs(SkyDirect) && !self.skies.is_empty();
        if self.components.needs(SunDirect) && !self.suns.is_empty() {
            self.add_suns(SunDirect, &self.suns, tile, out);
            self.clamp(out.component_mut(SunDirect));
        }
        if sky_direct && let Some(field) = &self.sky_field {
            for (receiver, (&normal, sky)) in tile.normals.iter().zip(&tile.sky).enumerate() {
                let row = out.row_mut(SkyDirect, receiver);
                field.irradiance(&self.sky_projection, normal, sky, |bin, v| row[bin] = v as f32);
            }
        } else if sky_direct {
            let mut coefficients = Vec::new();
            for (&normal, sky) in tile.normals.iter().zip(&tile.sky) {
                sky_coefficients(&self.sky_projection, normal, sky, &mut coefficients);
            }
            let column = out.component_mut(SkyDirect);
            self.skies.irradiance(&coefficients, |receiver, bin, v| column[receiver * self.bins + bin] = v);
        }
        if sky_direct {
            self.add_suns(SkyDirect, &self.circumsolar, tile, out);
            self.clamp(out.component_mut(SkyDirect));
        }
        if let Some(shaded) = &self.shaded {
            shaded.replace(tile, &self.sky_projection, out);
        }
    }

    /// Adds the direct light of suns to a column.
    fn add_suns(&self, column: Component, suns: &SunLookups, tile: &TileLayers, out: &mut TileValues) {
        if suns.is_empty() {
            return;
        }
        let bins = out.bins();
        for (group, (normals, skies)) in tile.normals.chunks(LANES).zip(tile.sky.chunks(LANES)).enumerate() {
            let masks = SkyMasks::new(&self.planes, normals, skies);
            let rows = &mut out.component_mut(column)[group * LANES * bins..];
            suns.direct(&masks, |receiver, bin, v| rows[receiver * bins + bin] += v as f32);
        }
    }

    fn add_specular(&self, tile: &TileLayers, out: &mut TileValues) {
        if tile.mirrors.is_empty() {
            return;
        }
        let projection = &self.sky_projection;
        let (sky, sun) = (self.mirrors_sky(), self.components.needs(SunMirrored));
        let mut sums = vec![0.0_f64; self.bins];
        let mut coefficients = Vec::new();
        for (receiver, (&normal, views)) in tile.normals.iter().zip(&tile.mirrors).enumerate() {
            if sun && !views.is_empty() {
                sums.fill(0.0);
                views.iter().for_each(|view| self.suns.by_mirrors(normal, view, &mut sums));
                put(&sums, out.row_mut(SunMirrored, receiver));
            }
            if sky {
                let mut patches = vec![0.0_f64; projection.patches()];
                views.iter().for_each(|view| view.add_patches(projection, normal, &mut patches));
                coefficients.extend(patches.into_iter().map(|sum| (sum * projection.texel_sr()) as f32));
                let horizon =
                    |band| views.iter().map(|view| view.horizon(band, projection.side(), normal)).sum::<f64>();
                coefficients.extend(projection.horizon().map(|band| horizon(band) as f32));
            }
        }
        let column = out.component_mut(SkyMirrored);
        self.skies.irradiance(&coefficients, |receiver, bin, v| column[receiver * self.bins + bin] = v);
        let glow = |receiver: usize, sums: &mut [f64]| {
            let views = tile.mirrors.get(receiver).into_iter().flatten();
            views.for_each(|view| self.circumsolar.by_mirrors(tile.normals[receiver], view, sums));
        };
        if sky {
            self.add_circumsolar(SkyMirrored, glow, out);
        }
    }

    /// Adds the circumsolar light of the skies, as `glow(receiver, sums)` gives it, to the light of
    /// their patches.
    fn add_circumsolar(&self, column: Component, glow: impl Fn(usize, &mut [f64]), out: &mut TileValues) {
        let mut sums = vec![0.0_f64; self.bins];
        for receiver in 0..out.receivers() {
            if !self.circumsolar.is_empty() {
                sums.fill(0.0);
                glow(receiver, &mut sums);
            }
            let row = out.row_mut(column, receiver).iter_mut();
            row.zip(&sums).for_each(|(out, sum)| *out += *sum as f32);
        }
        self.clamp(out.component_mut(column));
    }

    fn add_diffuse(&self, tile: &TileLayers, out: &mut TileValues) {
        if self.components.needs(SunReflected) {
            self.reflected_suns(tile, None, out.component_mut(SunReflected));
        }
        if self.components.needs(SkyReflected) {
            self.reflected_skies(tile, None, out.component_mut(SkyReflected));
        }
        for whole in [SunReflected, SkyReflected] {
            let Some([ground, obstruction]) = whole.parts().filter(|_| self.components.needs_parts(whole)) else {
                continue;
            };
            let mut grounds = vec![0.0; out.component(whole).len()];
            match whole {
                SunReflected => self.reflected_suns(tile, Some(Class::Ground), &mut grounds),
                _ => self.reflected_skies(tile, Some(Class::Ground), &mut grounds),
            }
            for (place, value) in grounds.into_iter().enumerate() {
                // The error of a texture may lie below 0. Clamped, no part is negative and the two
                // add up to the whole.
                let all = out.component(whole)[place];
                let of_ground = value.clamp(0.0, all);
                out.component_mut(ground)[place] = of_ground;
                out.component_mut(obstruction)[place] = all - of_ground;
            }
        }
    }

    /// Adds the sun's light by responses, or by one class of surfaces in them, to
    /// `[receiver][result]`.
    fn reflected_suns(&self, tile: &TileLayers, class: Option<Class>, out: &mut [f32]) {
        for (state, responses) in self.reflected.iter().zip(&tile.responses) {
            match &state.sums {
                Some([suns, _]) => self.add_sums(suns, responses, class, out),
                None => self.add_sources(&state.sources, responses, class, out),
            }
        }
        self.clamp(out);
    }

    /// Adds the sky's light by responses, or by one class of surfaces in them, to
    /// `[receiver][result]`.
    fn reflected_skies(&self, tile: &TileLayers, class: Option<Class>, out: &mut [f32]) {
        for (state, responses) in self.reflected.iter().zip(&tile.responses) {
            if let Some([_, skies]) = &state.sums {
                self.add_sums(skies, responses, class, out);
                continue;
            }
            self.add_sources(&state.circumsolar, responses, class, out);
            let of_state = state.skies.as_ref().unwrap_or(&self.skies);
            let mut coefficients = Vec::new();
            for response in responses.iter().filter(|_| !of_state.is_empty()) {
                response_coefficients(&self.response_projection, &vectors(response, class), &mut coefficients);
            }
            of_state.irradiance(&coefficients, |receiver, bin, v| out[receiver * self.bins + bin] += v);
        }
        self.clamp(out);
    }

    fn add_sums(&self, sources: &ResponseSums, responses: &[Response], class: Option<Class>, out: &mut [f32]) {
        let mut sums = vec![0.0_f64; self.bins];
        for (response, out) in responses.iter().zip(out.chunks_mut(self.bins.max(1))) {
            sums.fill(0.0);
            sources.irradiance(response, class, &mut sums);
            out.iter_mut().zip(&sums).for_each(|(out, sum)| *out += *sum as f32);
        }
    }

    fn add_sources(&self, sources: &Sources, responses: &[Response], class: Option<Class>, out: &mut [f32]) {
        for (response, out) in responses.iter().zip(out.chunks_mut(self.bins.max(1))).filter(|_| !sources.is_empty()) {
            sources.irradiance(&vectors(response, class), out);
        }
    }
}

/// Returns `[texel][axis]` of a response, or of one class of surfaces in it.
fn vectors(response: &Response, class: Option<Class>) -> Vec<[f32; 3]> {
    class.map_or_else(|| response.vectors(), |class| response.vectors_of(class))
}

/// Returns the visible share x mean cosine of the part in front of the surface for each base texel.
/// `directions` are those of the base texels.
pub fn visible_cosines(normal: DVec3, sky: &BitSquare, directions: &[DVec3]) -> Vec<f64> {
    let n = directions.len().isqrt();
    let block = sky.side() / n;
    let half = half_texel(n);
    directions
        .iter()
        .enumerate()
        .map(|(t, d)| {
            let cos = mean_positive(normal.dot(*d), half);
            if cos == 0.0 {
                return 0.0;
            }
            let visible = sky.count_block(block, t % n, t / n);
            cos * f64::from(visible) / (block * block) as f64
        })
        .collect()
}

/// Returns the cosine-weighted share of a receiver's hemisphere that is sky.
pub fn sky_view_factor(normal: DVec3, sky: &BitSquare, directions: &[DVec3]) -> f64 {
    visible_cosines(normal, sky, directions).iter().sum::<f64>() * 2.0 / directions.len() as f64
}
