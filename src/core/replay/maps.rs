//! Maps of one receiver: the content of its layers by direction. In: a [`ReceiverView`], and
//! optionally a sun and a sky. Out: textures with named channels.
//!
//! One rule holds for all maps: the sum over the texels of a channel named like a column of
//! results, times the channel `weight_sr`, is that column, W/m2. Such a channel is therefore a
//! radiance, W/(m2 sr), and `weight_sr` is the weight of the texel. The light of hits is derived
//! anew, while stored responses are rounded, so the two differ by the error that `layers::response`
//! states.

use std::collections::HashSet;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::hemisphere::{HEMISPHERE_SR, azimuth_and_z, bilinear, direction_of, texel_direction};
use crate::layers::canopy::{SEEN, SKY};
use crate::layers::hit::HitTile;
use crate::layers::response::{CLASSES, Response};
use crate::layers::sides::TextureSides;
use crate::light::mirrors::left;
use crate::light::radiosity::MaxBounces;
use crate::light::reflector::Reflector;
use crate::light::response::{Viewer, texel_weights};
use crate::light::response_solver::ResponseSolver;
use crate::light::scratch::ScratchSpace;
use crate::light::tables::Tables;
use crate::light::tile_view::TileView;
use crate::memory::MemoryBudget;
use crate::opened::OpenSite;
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::receiver_view::ReceiverView;
use crate::site::cells::CellKey;
use crate::sky::disc::disc_texels;
use crate::sky::horizon::HorizonBand;
use crate::sky::model::{SkyModel, SkyParts};
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::weather::conditions::Condition;

/// Name of the frame that all receivers share: columns grow to the east, rows to the north, about
/// the zenith.
pub const WORLD: &str = "world";
/// Name of the receiver's own frame: columns grow along its surface, rows up the surface.
pub const SURFACE: &str = "surface";

/// Texture and its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Name of the layer that the map comes from: `sky`, `hit`, `response`, `mirror`.
    pub name: &'static str,
    /// Frame of the map: [`WORLD`] or [`SURFACE`].
    pub frame: &'static str,
    /// Number of texels a side.
    pub side: usize,
    /// Channels of the texels, `weight_sr` among them.
    pub channels: Vec<Channel>,
}

/// One value for each texel, row-major as in the layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the channel, such as `sun_direct`.
    pub name: &'static str,
    /// Unit of the values, or their meaning where they have no unit.
    pub unit: &'static str,
    /// `[texel]`, row-major.
    pub values: Vec<f32>,
}

const RADIANCE: &str = "W/(m2 sr)";

impl Map {
    fn add(&mut self, name: &'static str, unit: &'static str, values: Vec<f32>) {
        self.channels.push(Channel { name, unit, values });
    }
}

/// Points a side of a texel at which patches are sampled, as in a replay's base texels.
const SAMPLES: usize = 8;

/// Sun and sky prepared for the textures of an archive.
pub struct Illumination {
    condition: Condition,
    depth: MaxBounces,
    parts: SkyParts,
    patches: Patches,
    /// `[patch]`, W/(m2 sr).
    radiances: Vec<f64>,
    /// Patches on the response texture, and the radiance of its texels, `[texel]`.
    projection: Projection,
    on_response: Vec<f64>,
}

impl Illumination {
    /// Prepares the light of a condition with a sky of 145, 577 or 2305 `patches` by `model`. The
    /// directions of its suns refer to true north. `depth` is the number of reflections that the
    /// maps hold.
    pub fn new(
        site: &OpenSite,
        condition: Condition,
        model: SkyModel,
        patches: usize,
        depth: MaxBounces,
    ) -> Result<Self> {
        let condition = condition.in_axes(site.north());
        let sides = site.settings().sides();
        let patches = Patches::new(patches)?;
        let open = Projection::new(&patches, sides.sky_base, SAMPLES).open_horizontal_sr;
        let radiances = patches.radiances(model, &condition, &open);
        let parts = model.parts(&condition);
        let projection = Projection::new(&patches, sides.response, SAMPLES).under(model);
        let radiance = |t| projection.of_texel(t).iter().map(|&(p, s)| radiances[usize::from(p)] * f64::from(s)).sum();
        let on_response = (0..sides.response * sides.response).map(radiance).collect();
        Ok(Illumination { condition, depth, parts, patches, radiances, projection, on_response })
    }

    /// Returns the reflected irradiance of a response, W/m2, from the sun and from the sky.
    fn reflected(&self, response: &Response) -> [f64; 2] {
        let g = response.vectors();
        let vector = |t: usize| DVec3::from(g[t].map(f64::from));
        let suns: f64 = self.sun_texels().map(|(t, direction)| direction.dot(vector(t))).sum();
        let texels = self.projection.mean_directions.iter().zip(&self.on_response).enumerate();
        let dome: f64 = texels.map(|(t, (d, radiance))| radiance * d.dot(vector(t))).sum();
        let horizon = self.projection.horizon().map_or(0.0, |band| band.reflected(&g)) * self.parts.horizon_w_m2;
        let sky = dome * self.projection.texel_sr() + suns * self.parts.circumsolar_w_m2 + horizon;
        [suns * self.condition.dni_w_m2, sky]
    }

    /// Returns the texels of the response in which the suns are looked up, and the suns' directions
    /// times the bilinear weights of the texels.
    fn sun_texels(&self) -> impl Iterator<Item = (usize, DVec3)> {
        self.condition.suns.iter().flat_map(|instant| {
            let corners = bilinear(instant.sun, self.projection.side()).into_iter();
            corners.map(|(t, w)| (t, instant.sun * (instant.lit() * w)))
        })
    }

    /// Returns the radiance that circumsolar light and the horizon add to that of the dome on the
    /// texels of the response: the irradiance by each response vector, divided by the texel's
    /// weight.
    fn brightening(&self, response: &[[f32; 3]], weights: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; weights.len()];
        let mut add = |t: usize, direction: DVec3| {
            if let (Some(sum), Some(g)) = (sums.get_mut(t), response.get(t)) {
                *sum += direction.dot(DVec3::from(g.map(f64::from)));
            }
        };
        self.sun_texels().for_each(|(t, direction)| add(t, direction * self.parts.circumsolar_w_m2));
        let band = self.projection.horizon().map_or(&[][..], HorizonBand::texels);
        band.iter().for_each(|found| add(found.texel, (found.flat * self.parts.horizon_w_m2).extend(0.0)));
        sums.iter().zip(weights).map(|(sum, weight)| if *weight != 0.0 { sum / weight } else { 0.0 }).collect()
    }

    /// Returns the texels of a sky texture under the suns' discs: direction of the sun, texel, and
    /// the texel's share of a normal irradiance of 1 W/m2.
    fn discs(&self, side: usize) -> impl Iterator<Item = (DVec3, usize, f64)> {
        self.condition.suns.iter().flat_map(move |instant| {
            let of_disc = move |(column, row, share): (u32, u32, f32)| {
                (instant.sun, row as usize * side + column as usize, f64::from(share) * instant.lit())
            };
            disc_texels(instant.sun, side).into_iter().map(of_disc)
        })
    }
}

/// Returns all maps of a receiver. Channels of light exist only where `light` is given.
pub fn maps(
    site: &OpenSite,
    view: &ReceiverView,
    light: Option<&Illumination>,
    memory: MemoryBudget,
    storage: &dyn ScratchSpace,
) -> Result<Vec<Map>> {
    let mut hit = hit_map(view);
    let mut response = None;
    if let Some(light) = light {
        let lit = lit_cells(site, view, light, memory, storage)?;
        let of = |channel: usize| lit.texels.iter().map(|radiances| radiances[channel] as f32).collect();
        hit.add("sun_reflected", RADIANCE, of(0));
        hit.add("sky_reflected", RADIANCE, of(1));
        // The stored response holds all bounces; for fewer, the derived one applies.
        if light.depth != MaxBounces::All {
            response = Some(lit.response);
        }
    }
    let response = match response {
        Some(derived) => derived,
        None => view.response(site)?,
    };
    let sky = SkyTexels::new(view, light);
    let mut maps = vec![sky_map(view, &sky, light, site.settings().sides()), hit, response_map(&response, light)];
    if !view.mirrors.is_empty() {
        maps.push(mirror_map(view, &sky, light));
    }
    Ok(maps)
}

/// Means over the texels of the sky.
struct SkyTexels {
    side: usize,
    texels: Vec<SkyTexel>,
    /// Factor that scales the mean radiances so that an open horizontal receiver gets DHI.
    scale: f64,
    /// Band at the horizon, if the sky has one.
    band: Option<HorizonBand>,
}

impl SkyTexels {
    fn new(view: &ReceiverView, light: Option<&Illumination>) -> Self {
        let side = view.sky.side() * view.sky.block();
        let texel = |t: usize| sky_texel(view.receiver.normal, light, side, t);
        let texels: Vec<SkyTexel> = (0..side * side).into_par_iter().with_min_len(side).map(texel).collect();
        // A replay scales its texels in this way, too: an open horizontal receiver gets DHI
        // exactly.
        let open = texels.iter().map(|t| f64::from(t.horizontal)).sum::<f64>() * texel_sr(side);
        let dome_w_m2 = light.map_or(0.0, |light| light.parts.dome_w_m2);
        let band = light.and_then(|light| light.projection.horizon()).map(|_| HorizonBand::new(side));
        SkyTexels { side, texels, scale: if open != 0.0 { dome_w_m2 / open } else { 0.0 }, band }
    }

    fn radiance(&self, texel: usize) -> f32 {
        (f64::from(self.texels[texel].radiance) * self.scale) as f32
    }
}

/// Returns the solid angle of a texel, sr.
fn texel_sr(side: usize) -> f64 {
    HEMISPHERE_SR / (side * side) as f64
}

/// Returns the map of the visible sky, and with a light the radiances of the sky and the sun in it.
fn sky_map(view: &ReceiverView, sky: &SkyTexels, light: Option<&Illumination>, sides: TextureSides) -> Map {
    let (side, texels, texel_sr) = (sky.side, &sky.texels, texel_sr(sky.side));
    // The sky's bits reach a little behind the surface.
    let visible: Vec<bool> =
        texels.iter().enumerate().map(|(t, texel)| texel.cos > 0.0 && view.sky.get(t % side, t / side)).collect();
    let mut map = Map { name: "sky", frame: WORLD, side, channels: Vec::new() };
    map.add("visible", "1 where sky is seen, else 0", visible.iter().map(|v| f32::from(u8::from(*v))).collect());
    map.add("weight_sr", "sr", texels.iter().map(|t| (f64::from(t.cos) * texel_sr) as f32).collect());
    let veil = view.canopy.through(SKY, &view.powers).map(|shares| CanopyTransmittance::new(&shares, sides));
    let through = |t: usize| veil.as_ref().map_or(1.0, |veil| veil.at_fine(t % side, t / side));
    if veil.is_some() {
        map.add("through", "share of the light that canopies let through", (0..side * side).map(through).collect());
    }
    let Some(light) = light else { return map };
    let seen = |t: usize| if visible[t] { sky.radiance(t) * through(t) } else { 0.0 };
    let mut of_sky: Vec<f32> = (0..side * side).map(seen).collect();
    let mut sun = vec![0.0_f32; side * side];
    let radiance = |t: usize, w_m2: f64| (w_m2 * f64::from(through(t)) / (f64::from(texels[t].cos) * texel_sr)) as f32;
    let normal = view.receiver.normal;
    for (direction, t, share) in light.discs(side).filter(|(_, t, _)| visible[*t]) {
        // A replay takes the cosine at the middle for the whole disc, too.
        let share = share * normal.dot(direction).max(0.0);
        sun[t] += radiance(t, light.condition.dni_w_m2 * share);
        of_sky[t] += radiance(t, light.parts.circumsolar_w_m2 * share);
    }
    if let Some(band) = &sky.band {
        let of_band = band.weights(normal).filter(|(t, _)| visible[*t]);
        of_band.for_each(|(t, weight)| of_sky[t] += radiance(t, light.parts.horizon_w_m2 * weight));
    }
    map.add("sky_direct", RADIANCE, of_sky);
    map.add("sun_direct", RADIANCE, sun);
    map
}

/// Returns the map of the sky seen in mirrors, on the texels of the sky that the light comes from.
fn mirror_map(view: &ReceiverView, sky: &SkyTexels, light: Option<&Illumination>) -> Map {
    let side = sky.side;
    let mut weights = vec![0.0_f64; side * side];
    let mut sun = vec![0.0_f64; side * side];
    let mut brightening = vec![0.0_f64; side * side];
    for window in &view.mirrors {
        let image = window.reflection.image(view.receiver.normal);
        let mut visible = HashSet::new();
        for (column, row) in window.visible() {
            let d = texel_direction(column, row, side, DVec2::splat(0.5));
            let cos = image.dot(d);
            if cos > 0.0 {
                weights[row * side + column] += cos * window.reflection.share(d) * texel_sr(side);
                visible.insert((column, row));
            }
        }
        let Some(light) = light else { continue };
        for (direction, t, of_disc) in light.discs(side).filter(|(_, t, _)| visible.contains(&(t % side, t / side))) {
            // A replay takes the direction of the middle for the whole disc, too.
            let share = of_disc * window.reflection.share(direction) * image.dot(direction).max(0.0);
            sun[t] += light.condition.dni_w_m2 * share;
            brightening[t] += light.parts.circumsolar_w_m2 * share;
        }
        let band = sky.band.as_ref().map_or(&[][..], HorizonBand::texels);
        for found in band.iter().filter(|found| visible.contains(&(found.texel % side, found.texel / side))) {
            let share = window.reflection.share(found.direction) * image.truncate().dot(found.flat).max(0.0);
            brightening[found.texel] += light.parts.horizon_w_m2 * share;
        }
    }
    let mut map = Map { name: "mirror", frame: WORLD, side, channels: Vec::new() };
    map.add("weight_sr", "sr", weights.iter().map(|&w| w as f32).collect());
    if light.is_some() {
        let radiance = |(e, &weight): (f64, &f64)| if weight > 0.0 { (e / weight) as f32 } else { 0.0 };
        let dome = |(t, &weight): (usize, &f64)| if weight > 0.0 { sky.radiance(t) } else { 0.0 };
        let of_sky = weights.iter().enumerate().map(dome).zip(brightening.into_iter().zip(&weights).map(radiance));
        map.add("sky_mirrored", RADIANCE, of_sky.map(|(dome, brightening)| dome + brightening).collect());
        map.add("sun_mirrored", RADIANCE, sun.into_iter().zip(&weights).map(radiance).collect());
    }
    map
}

/// Means over one texel of the sky.
struct SkyTexel {
    /// Cosine of the angle of incidence on the receiver.
    cos: f32,
    /// Radiance by the patches, and radiance times the cosine on a horizontal surface.
    radiance: f32,
    horizontal: f32,
}

fn sky_texel(normal: DVec3, light: Option<&Illumination>, side: usize, t: usize) -> SkyTexel {
    // The points lie 1/2048 of the square apart: 4 in a texel of the usual 1024 a side. Fewer would
    // make texels that the surface's plane cuts count by halves.
    let samples = (2048 / side).max(2);
    let (mut cos, mut radiance, mut horizontal) = (0.0, 0.0, 0.0);
    for i in 0..samples * samples {
        let inside = (DVec2::new((i % samples) as f64, (i / samples) as f64) + 0.5) / samples as f64;
        let square = (DVec2::new((t % side) as f64, (t / side) as f64) + inside) / side as f64;
        cos += normal.dot(direction_of(square)).max(0.0);
        if let Some(light) = light {
            let (turns, z) = azimuth_and_z(square);
            let of_patch = light.radiances[light.patches.patch_at(turns, z)];
            radiance += of_patch;
            horizontal += of_patch * z;
        }
    }
    let mean = |sum: f64| (sum / (samples * samples) as f64) as f32;
    SkyTexel { cos: mean(cos), radiance: mean(radiance), horizontal: mean(horizontal) }
}

/// Returns the map of the cells that the receiver sees, with their weights.
fn hit_map(view: &ReceiverView) -> Map {
    let side = view.texels.len().isqrt();
    let mut map = Map { name: "hit", frame: SURFACE, side, channels: Vec::new() };
    let class = |t| view.class(t).map_or(0.0, |class| 1.0 + f32::from(class.code()));
    let material = |t| view.cell(t).map_or(0.0, |cell| 1.0 + f32::from(cell.material));
    let texels = 0..view.texels.len();
    map.add("class", "0 nothing, 1 ground, 2 obstruction", texels.clone().map(class).collect());
    map.add("material", "0 nothing, else place in `materials`, from 1", texels.map(material).collect());
    let cells = view.texels.iter().map(|&t| t as f32).collect();
    map.add("cell", "0 nothing, else place among the cells that the tile sees, from 1", cells);
    let mut mirrors = vec![0.0_f32; view.texels.len()];
    for path in &view.paths {
        if let Some(most) = mirrors.get_mut(path.texel as usize) {
            *most = most.max(path.steps.len() as f32);
        }
    }
    map.add("mirrors", "mirrors passed to the last surface that is seen, 0 for none", mirrors);
    // Texel weights are shares of the hemisphere, and the whole has the weight pi.
    let weights = texel_weights(&view.texels, &view.viewer);
    map.add("weight_sr", "sr", weights.iter().map(|w| (w * HEMISPHERE_SR / 2.0) as f32).collect());
    map
}

/// Returns the map of the response: irradiance by reflections for each direction of the sky.
fn response_map(response: &Response, light: Option<&Illumination>) -> Map {
    const NAMES: [&str; CLASSES * 3] =
        ["ground.x", "ground.y", "ground.z", "obstruction.x", "obstruction.y", "obstruction.z"];
    let texels = response.values.len() / NAMES.len();
    let side = texels.isqrt();
    let mut map = Map { name: "response", frame: WORLD, side, channels: Vec::new() };
    for (name, values) in NAMES.into_iter().zip(response.values.chunks(texels.max(1))) {
        map.add(name, "W/m2 for 1 W/m2 at normal incidence", values.to_vec());
    }
    if let Some(light) = light {
        let g = response.vectors();
        let worth = |(d, g): (&DVec3, &[f32; 3])| d.dot(DVec3::from(g.map(f64::from))) * light.projection.texel_sr();
        let weights: Vec<f64> = light.projection.mean_directions.iter().zip(&g).map(worth).collect();
        let radiances =
            light.on_response.iter().zip(light.brightening(&g, &weights)).map(|(l, more)| (l + more) as f32);
        map.add("weight_sr", "sr", weights.iter().map(|&w| w as f32).collect());
        map.add("sky_reflected", RADIANCE, radiances.collect());
    }
    map
}

/// Light from the cells around a receiver.
struct Lit {
    /// `[texel]` of the hit texture: radiance by the sun, radiance by the sky.
    texels: Vec<[f64; 2]>,
    /// Response of the receiver: the sum over all cells.
    response: Response,
}

/// Cell that a texel shows, directly or in mirrors.
struct Shown {
    cell: CellKey,
    texel: usize,
    /// Share of the cell's light that reaches the receiver.
    left: f64,
    /// Class of the first surface seen.
    class: usize,
}

/// Number of cells whose responses are derived at a time: some 25 MB.
const CELLS_AT_ONCE: usize = 1024;

fn lit_cells(
    site: &OpenSite,
    view: &ReceiverView,
    light: &Illumination,
    memory: MemoryBudget,
    storage: &dyn ScratchSpace,
) -> Result<Lit> {
    let tables = Tables::new(site)?;
    // Each cell fills the view of a receiver that looks up and has one texel. The response of that
    // receiver is pi times the cell's radiance.
    let viewer = Viewer { normal: DVec3::Z, seed: 0, sky_view: 0.0 };
    let responder = ResponseSolver::new(&tables, light.depth, memory, storage)?;
    let shown = shown(view, &tables.mirrors.reflectors);
    let weights = texel_weights(&view.texels, &view.viewer);
    let mut lit = Lit {
        texels: vec![[0.0; 2]; view.texels.len()],
        response: Response { values: vec![0.0; Response::len(tables.settings.probe)] },
    };
    let cells: Vec<&[Shown]> = shown.chunk_by(|a, b| a.cell == b.cell).collect();
    for part in cells.chunks(CELLS_AT_ONCE) {
        let palette: Vec<CellKey> = part.iter().map(|places| places[0].cell).collect();
        let hits = HitTile { palette, texels: (1..=part.len() as u32).collect() };
        let tile = TileView {
            number: 0,
            receivers: Default::default(),
            viewers: vec![viewer; part.len()],
            hits,
            mirrors: Vec::new(),
            canopies: Vec::new(),
        };
        let responses = responder.derive(&tables, &[tile])?;
        for (response, places) in responses.into_iter().flatten().flatten().zip(part) {
            let radiances = light.reflected(&response).map(|e| e / (HEMISPHERE_SR / 2.0));
            let mut shares = [0.0_f64; CLASSES];
            for place in *places {
                shares[place.class] += weights[place.texel] * place.left;
                let texel = lit.texels[place.texel].iter_mut().zip(radiances);
                texel.for_each(|(sum, radiance)| *sum += radiance * place.left);
            }
            // The response of a cell holds all light in the cell's own class. A cell in a mirror
            // counts for the mirror's class, so the classes are added up first.
            let of_class = response.values.len() / CLASSES;
            let all = response.values.chunks(of_class).fold(vec![0.0_f32; of_class], |mut sum, values| {
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
                sum
            });
            for (sums, share) in lit.response.values.chunks_mut(of_class).zip(shares) {
                sums.iter_mut().zip(&all).for_each(|(sum, value)| *sum += share as f32 * value);
            }
        }
    }
    Ok(lit)
}

/// Returns all cells that texels show, ordered by cell.
fn shown(view: &ReceiverView, reflectors: &[Reflector]) -> Vec<Shown> {
    let class_of = |material: u16| reflectors[usize::from(material)].class.index();
    let through = view.canopy.through(SEEN, &view.powers);
    let direct = (0..view.texels.len()).filter_map(|texel| {
        let cell = *view.cell(texel)?;
        let left = through.as_ref().map_or(1.0, |shares| f64::from(shares[texel]));
        Some(Shown { cell, texel, left, class: class_of(cell.material) })
    });
    // A path has at least one mirror, which is the first surface seen.
    let in_mirrors = view.paths.iter().map(|path| {
        let (class, left) = (class_of(path.steps[0].0), left(&path.steps, reflectors));
        Shown { cell: path.cell, texel: path.texel as usize, left, class }
    });
    let mut all: Vec<Shown> = direct.chain(in_mirrors).collect();
    all.sort_by_key(|shown| (shown.cell, shown.texel));
    all
}
