//! Maps of one receiver: what its layers say of each direction. In: a [`ReceiverView`], and
//! optionally a sun and a sky. Out: textures with named channels.
//!
//! One rule holds for all of them: the sum over the texels of a channel named like a column of
//! results, times the channel `weight_sr`, is that column, W/m2. So such a channel is a radiance,
//! W/(m2 sr), and `weight_sr` says what it is worth. The light of hits is derived anew, and stored
//! responses are rounded: there both differ by what `layers::response` says.

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

/// The frame of all receivers: columns grow to the east, rows to the north, about the zenith.
pub const WORLD: &str = "world";
/// The receiver's own frame: columns grow along its surface, rows up the surface.
pub const SURFACE: &str = "surface";

/// A texture and its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Name of the layer that it comes from: `sky`, `hit`, `response`, `mirror`.
    pub name: &'static str,
    /// [`WORLD`] or [`SURFACE`].
    pub frame: &'static str,
    /// Texels a side.
    pub side: usize,
    /// What is said of each texel, `weight_sr` among it.
    pub channels: Vec<Channel>,
}

/// One value for each texel, row-major as in the layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the channel, such as `sun_direct`.
    pub name: &'static str,
    /// Unit of its values, or what they mean where they have none.
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

/// Points a side of a texel in which patches are sampled, as replay does for its base texels.
const SAMPLES: usize = 8;

/// Sun and sky ready for the textures of an archive.
pub struct Illumination {
    condition: Condition,
    depth: MaxBounces,
    parts: SkyParts,
    patches: Patches,
    /// `[patch]`, W/(m2 sr).
    radiances: Vec<f64>,
    /// Patches on the response texture, and its radiance, `[texel]`.
    projection: Projection,
    on_response: Vec<f64>,
}

impl Illumination {
    /// The light of a condition, whose suns go by true north, with a sky of 145, 577 or 2305
    /// `patches` by `model`; `depth` says how many reflections maps hold.
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

    /// What a response makes of it, W/m2: sun and sky.
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

    /// Texels of the response that the suns are looked up in, and their directions times the
    /// texels' weights.
    fn sun_texels(&self) -> impl Iterator<Item = (usize, DVec3)> {
        self.condition.suns.iter().flat_map(|instant| {
            let corners = bilinear(instant.sun, self.projection.side()).into_iter();
            corners.map(|(t, w)| (t, instant.sun * (instant.lit() * w)))
        })
    }

    /// Radiance that adds to that of the dome on the texels of the response: what circumsolar light
    /// and the horizon make of each vector, over what it is worth.
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

    /// Texels of a sky texture under the suns' discs, and how much normal irradiance of 1 W/m2 in
    /// all each holds, with its sun.
    fn discs(&self, side: usize) -> impl Iterator<Item = (DVec3, usize, f64)> {
        self.condition.suns.iter().flat_map(move |instant| {
            let of_disc = move |(column, row, share): (u32, u32, f32)| {
                (instant.sun, row as usize * side + column as usize, f64::from(share) * instant.lit())
            };
            disc_texels(instant.sun, side).into_iter().map(of_disc)
        })
    }
}

/// All maps of a receiver; those of `light` only where there is one.
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
        hit.add("sun_diffuse", RADIANCE, of(0));
        hit.add("sky_diffuse", RADIANCE, of(1));
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
    /// Of their radiance.
    scale: f64,
    /// Of skies that have one.
    band: Option<HorizonBand>,
}

impl SkyTexels {
    fn new(view: &ReceiverView, light: Option<&Illumination>) -> Self {
        let side = view.sky.side() * view.sky.block();
        let texel = |t: usize| sky_texel(view.receiver.normal, light, side, t);
        let texels: Vec<SkyTexel> = (0..side * side).into_par_iter().with_min_len(side).map(texel).collect();
        // As replay does on its texels: an open horizontal receiver gets DHI exactly.
        let open = texels.iter().map(|t| f64::from(t.horizontal)).sum::<f64>() * texel_sr(side);
        let dome_w_m2 = light.map_or(0.0, |light| light.parts.dome_w_m2);
        let band = light.and_then(|light| light.projection.horizon()).map(|_| HorizonBand::new(side));
        SkyTexels { side, texels, scale: if open != 0.0 { dome_w_m2 / open } else { 0.0 }, band }
    }

    fn radiance(&self, texel: usize) -> f32 {
        (f64::from(self.texels[texel].radiance) * self.scale) as f32
    }
}

/// Solid angle of a texel, sr.
fn texel_sr(side: usize) -> f64 {
    HEMISPHERE_SR / (side * side) as f64
}

/// What is sky, and with a light the sky and the sun that are seen in it.
fn sky_map(view: &ReceiverView, sky: &SkyTexels, light: Option<&Illumination>, sides: TextureSides) -> Map {
    let (side, texels, texel_sr) = (sky.side, &sky.texels, texel_sr(sky.side));
    // Bits reach a little behind the surface.
    let visible: Vec<bool> =
        texels.iter().enumerate().map(|(t, texel)| texel.cos > 0.0 && view.sky.get(t % side, t / side)).collect();
    let mut map = Map { name: "sky", frame: WORLD, side, channels: Vec::new() };
    map.add("visible", "1 where sky is seen, else 0", visible.iter().map(|v| f32::from(u8::from(*v))).collect());
    map.add("weight_sr", "sr", texels.iter().map(|t| (f64::from(t.cos) * texel_sr) as f32).collect());
    let veil = view.canopy.through(SKY, &view.powers).map(|shares| CanopyTransmittance::new(shares, sides));
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
        // Replay takes the cosine of the middle for the whole disc.
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

/// What is sky by way of mirrors, on the texels of the sky that light comes from.
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
            // Replay takes the middle for the whole disc.
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
        map.add("sky_specular", RADIANCE, of_sky.map(|(dome, brightening)| dome + brightening).collect());
        map.add("sun_specular", RADIANCE, sun.into_iter().zip(&weights).map(radiance).collect());
    }
    map
}

/// Means over a texel of the sky.
struct SkyTexel {
    /// Cosine on the receiver.
    cos: f32,
    /// Radiance by its patches, and that times the cosine on a horizontal surface.
    radiance: f32,
    horizontal: f32,
}

fn sky_texel(normal: DVec3, light: Option<&Illumination>, side: usize, t: usize) -> SkyTexel {
    // Points 1/2048 of the square apart, 4 in a texel of the usual 1024; no fewer, or texels that
    // the surface's plane cuts would count by halves.
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

/// Which cells are met, and what they are worth.
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
    // Shares of the hemisphere, whose weight is pi.
    let weights = texel_weights(&view.texels, &view.viewer);
    map.add("weight_sr", "sr", weights.iter().map(|w| (w * HEMISPHERE_SR / 2.0) as f32).collect());
    map
}

/// What each direction of the sky is worth by way of reflections.
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
        map.add("sky_diffuse", RADIANCE, radiances.collect());
    }
    map
}

/// Light that the cells around a receiver send.
struct Lit {
    /// `[texel]` of the hit texture: radiance by the sun, by the sky.
    texels: Vec<[f64; 2]>,
    /// Of the receiver, as the sum of all.
    response: Response,
}

/// A cell that a texel shows, in mirrors or not.
struct Shown {
    cell: CellKey,
    texel: usize,
    /// Share of its light that is left.
    left: f64,
    /// Of what is seen first.
    class: usize,
}

/// Cells that responses are derived for at a time: some 25 MB.
const CELLS_AT_ONCE: usize = 1024;

fn lit_cells(
    site: &OpenSite,
    view: &ReceiverView,
    light: &Illumination,
    memory: MemoryBudget,
    storage: &dyn ScratchSpace,
) -> Result<Lit> {
    let mut tables = Tables::of(site)?;
    // Each cell fills the view of a receiver that looks up and has one texel: its response is pi
    // times the cell's radiance.
    tables.settings.hit = 1;
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
            // The cell's own class holds all of it; in a mirror it counts for the mirror's.
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

/// All cells that texels show, by cell.
fn shown(view: &ReceiverView, reflectors: &[Reflector]) -> Vec<Shown> {
    let class_of = |material: u16| reflectors[usize::from(material)].class.index();
    let through = view.canopy.through(SEEN, &view.powers);
    let direct = (0..view.texels.len()).filter_map(|texel| {
        let cell = *view.cell(texel)?;
        let left = through.as_ref().map_or(1.0, |shares| f64::from(shares[texel]));
        Some(Shown { cell, texel, left, class: class_of(cell.material) })
    });
    // A way has at least one mirror: what is seen first.
    let in_mirrors = view.paths.iter().map(|path| {
        let (class, left) = (class_of(path.steps[0].0), left(&path.steps, reflectors));
        Shown { cell: path.cell, texel: path.texel as usize, left, class }
    });
    let mut all: Vec<Shown> = direct.chain(in_mirrors).collect();
    all.sort_by_key(|shown| (shown.cell, shown.texel));
    all
}
