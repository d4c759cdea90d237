//! Reflected light of surfaces as tables over the sun's position. In: an archive of a model's
//! surfaces. Out: the reflected light of each EnergyPlus surface under each sun of a grid, and
//! under a sky, split into a part that depends on the ground's reflectance and a part that does
//! not.

use std::collections::BTreeMap;

use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::light::paths::LightPaths;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::factors::SunGrid;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::conditions::Condition;
use heliotile_results::SkyChoice;
use heliotile_results::{LightRequest, ReceiverSet, Resources, Series, TileStream};

/// DNI that sun tables stand for, and DHI that the sky values stand for, W/m2.
pub const NOMINAL_W_M2: f64 = 1000.0;

/// Sky whose reflected light counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReflectedSky {
    /// A uniform sky, which EnergyPlus uses for reflections.
    Uniform,
    /// The sky of Perez and others (1990), which EnergyPlus uses for direct light: brighter around
    /// the sun and at the horizon.
    Perez1990,
}

/// Range of the ground's reflectance for which tables hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundRange {
    pub low: f64,
    pub high: f64,
}

impl GroundRange {
    /// Range for any ground: with one reflection, light is a straight line over the ground's
    /// reflectance. The range begins above 0, where very small contributions are cut off to 0.
    pub const UNIT: GroundRange = GroundRange { low: 0.1, high: 1.0 };
}

/// Light that depends on the ground's reflectance: `fixed + reflectance x by_ground`, W/m2 under
/// 1000 W/m2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroundLine {
    /// Part that does not depend on the ground, one value a condition.
    pub fixed: Vec<f64>,
    /// Part that a ground of reflectance 1 adds, one value a condition.
    pub by_ground: Vec<f64>,
}

/// A surface of the model with its reflected light.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLight {
    /// Name as the model spells it.
    pub name: String,
    pub kind: String,
    pub class: String,
    pub zone: String,
    pub receivers: usize,
    pub area_m2: f64,
    /// Light that surfaces reflect diffusely: `[azimuth][altitude]` of the grid, altitude fastest.
    pub sun: GroundLine,
    /// Sun in mirrors, whatever the ground: `[azimuth][altitude]` of the fine grid, altitude
    /// fastest.
    pub mirrored: Vec<f64>,
    /// Light reflected under a uniform sky: one value each.
    pub sky: GroundLine,
    /// Light reflected from the sky band at the horizon, where the band adds 1000 W/m2 to an open
    /// wall: one value each; empty for a uniform sky.
    pub horizon: GroundLine,
    /// Largest distance of the light at the middle reflectance of the ground from the line through
    /// both ends, W/m2 under 1000 W/m2.
    pub bend_w_m2: f64,
}

/// Means over the receivers of a surface, weighted by area.
struct Means {
    /// Surface, without light yet.
    light: SurfaceLight,
    /// Sums and then means, `[state][condition]`.
    values: Vec<f64>,
}

/// Settings for making tables.
pub struct TableRequest<'a> {
    pub grid: SunGrid,
    pub paths: LightPaths,
    pub sky: ReflectedSky,
    pub ground: GroundRange,
    pub resources: Resources<'a>,
}

/// Computes the reflected light of all surfaces, sorted by name in small letters.
pub fn surface_lights(archive: &Archive, asked: &TableRequest) -> Result<Vec<SurfaceLight>> {
    let site = OpenSite::open(archive)?;
    // Without reflections or ground, nothing depends on the ground's reflectance.
    let changes = site.settings().diffuse && !site.grounds().is_empty();
    let GroundRange { low, high } = asked.ground;
    let states = if changes { vec![low, high, 0.5 * (low + high)] } else { vec![0.0] };
    let mut one = suns(asked.grid);
    let zenith = direction_from_degrees(0.0, 90.0);
    // Without a sun every sky model here is uniform.
    one.push(Condition::new(String::new(), &[], zenith, 0.0, NOMINAL_W_M2));
    one.extend(asked.sky.low().map(|low| low.condition));
    let conditions: Vec<Condition> = states.iter().flat_map(|_| one.clone()).collect();
    let values: Vec<f64> = states.iter().flat_map(|value| std::iter::repeat_n(*value, one.len())).collect();
    let diffuse = [Component::SunReflected, Component::SkyReflected, Component::SkyMirrored];
    let means = surface_means(archive, conditions, changes.then_some(&values), &diffuse, asked)?;
    let mut lights: Vec<SurfaceLight> = means.into_iter().map(|means| finish(means, one.len(), asked)).collect();
    if site.orientations().is_empty() {
        return Ok(lights);
    }
    let mirrored = surface_means(archive, suns(SunGrid::FINE), None, &[Component::SunMirrored], asked)?;
    // Both lists are sorted by the same names.
    for (light, means) in lights.iter_mut().zip(mirrored) {
        light.mirrored = round_the_circle(means.values, SunGrid::FINE);
    }
    Ok(lights)
}

/// Computes the sum of some components under conditions, as means over surfaces, sorted by name in
/// small letters. `ground` is the ground's reflectance under each condition.
fn surface_means(
    archive: &Archive,
    conditions: Vec<Condition>,
    ground: Option<&[f64]>,
    components: &[Component],
    asked: &TableRequest,
) -> Result<Vec<Means>> {
    let count = conditions.len();
    let (receivers, series) = (ReceiverSet::all_of(archive)?, Series::over_ground(conditions, ground));
    let light =
        LightRequest { sky: SkyChoice::Model(asked.sky.model()), paths: asked.paths, ..LightRequest::default() };
    let stream = TileStream { receivers: &receivers, light: &light, series: &series, resources: asked.resources };
    let mut found: BTreeMap<String, Means> = BTreeMap::new();
    let mut rows = receivers.receivers();
    stream.each(ComponentSet::new(components), |tile| {
        for (row, receiver) in rows.by_ref().take(tile.ids.len()).enumerate() {
            let receiver = receiver?;
            let part = receiver.part;
            let sum = found
                .entry(part.face.to_lowercase())
                .or_insert_with(|| Means { light: SurfaceLight::dark(part), values: vec![0.0; count] });
            let area_m2 = receiver.area.unwrap_or(1.0);
            sum.light.receivers += 1;
            sum.light.area_m2 += area_m2;
            for component in components {
                let row = tile.values.row(*component, row);
                sum.values.iter_mut().zip(row).for_each(|(sum, value)| *sum += area_m2 * f64::from(*value));
            }
        }
        Ok(true)
    })?;
    let mean = |mut means: Means| {
        let area_m2 = if means.light.area_m2 > 0.0 { means.light.area_m2 } else { 1.0 };
        means.values.iter_mut().for_each(|value| *value /= area_m2);
        means
    };
    Ok(found.into_values().map(mean).collect())
}

/// An overcast sky whose horizon is darker than its dome, without circumsolar light.
struct LowSky {
    condition: Condition,
    /// Irradiance of the dome, as a share of 1000 W/m2.
    dome: f64,
    horizon: f64,
}

impl ReflectedSky {
    fn model(self) -> SkyModel {
        match self {
            ReflectedSky::Uniform => SkyModel::Uniform,
            ReflectedSky::Perez1990 => SkyModel::Perez1990,
        }
    }

    /// Returns a sky from which the contribution of the horizon band can be computed, if the model
    /// has such a band.
    fn low(self) -> Option<LowSky> {
        let sun = direction_from_degrees(180.0, LOW_SUN_DEG);
        let mut condition = Condition::new(String::new(), &[sun], sun, 0.0, NOMINAL_W_M2);
        // A huge extraterrestrial irradiance makes the sky dull: no light comes from around the
        // sun.
        condition.extraterrestrial_w_m2 = DULL_W_M2;
        let parts = self.model().parts(&condition);
        let (dome, horizon) = (parts.dome_w_m2 / NOMINAL_W_M2, parts.horizon_w_m2 / NOMINAL_W_M2);
        (horizon != 0.0 && parts.circumsolar_w_m2 == 0.0).then_some(LowSky { condition, dome, horizon })
    }
}

/// Altitude of the sun of an overcast sky, degrees: the lower the sun, the darker the horizon.
const LOW_SUN_DEG: f64 = 5.0;

/// Extraterrestrial irradiance beside which 1000 W/m2 are nothing, W/m2.
const DULL_W_M2: f64 = 1e9;

/// Returns the conditions of all suns of the grid but those at 360 degrees, without sky.
fn suns(grid: SunGrid) -> Vec<Condition> {
    let mut all = grid.conditions(NOMINAL_W_M2);
    all.truncate(all.len().saturating_sub(grid.altitudes_deg().len()));
    all
}

/// Appends the values of north again, for 360 degrees.
fn round_the_circle(mut values: Vec<f64>, grid: SunGrid) -> Vec<f64> {
    let north: Vec<f64> = values.iter().copied().take(grid.altitudes_deg().len()).collect();
    values.extend(north);
    values
}

/// Fits the lines through the states of the ground.
fn finish(Means { mut light, values }: Means, conditions: usize, asked: &TableRequest) -> SurfaceLight {
    let GroundRange { low, high } = asked.ground;
    let mut states = values.chunks(conditions.max(1));
    let first = states.next().unwrap_or_default();
    let second = states.next().unwrap_or(first);
    let width = if high > low { high - low } else { 1.0 };
    let by_ground: Vec<f64> = first.iter().zip(second).map(|(low, high)| (high - low) / width).collect();
    let fixed: Vec<f64> = first.iter().zip(&by_ground).map(|(value, slope)| value - low * slope).collect();
    for (middle, line) in states.next().unwrap_or_default().iter().zip(fixed.iter().zip(&by_ground)) {
        light.bend_w_m2 = light.bend_w_m2.max((middle - line.0 - 0.5 * (low + high) * line.1).abs());
    }
    let low = asked.sky.low();
    let split = |mut all: Vec<f64>| {
        let lower = low.as_ref().and_then(|_| all.pop());
        let sky = all.pop().unwrap_or_default();
        // Light that does not come from the dome comes from the horizon.
        let horizon = low.as_ref().zip(lower).map(|(low, light)| (light - low.dome * sky) / low.horizon);
        [round_the_circle(all, asked.grid), vec![sky], horizon.into_iter().collect()]
    };
    let ([sun, sky, horizon], [sun_slope, sky_slope, horizon_slope]) = (split(fixed), split(by_ground));
    light.sun = GroundLine { fixed: sun, by_ground: sun_slope };
    light.sky = GroundLine { fixed: sky, by_ground: sky_slope };
    light.horizon = GroundLine { fixed: horizon, by_ground: horizon_slope };
    light
}

impl SurfaceLight {
    /// Returns a surface without light.
    fn dark(part: ModelPart) -> SurfaceLight {
        SurfaceLight {
            name: part.face,
            kind: part.kind,
            class: part.object_type,
            zone: part.object,
            receivers: 0,
            area_m2: 0.0,
            sun: GroundLine::default(),
            mirrored: Vec::new(),
            sky: GroundLine::default(),
            horizon: GroundLine::default(),
            bend_w_m2: 0.0,
        }
    }

    /// Spreads the light over a larger area, the rest of which gets no light.
    pub fn spread_over(&mut self, whole_m2: f64) {
        if whole_m2 > self.area_m2 && self.area_m2 > 0.0 {
            let share = self.area_m2 / whole_m2;
            let lines = [&mut self.sun, &mut self.sky, &mut self.horizon];
            lines
                .into_iter()
                .flat_map(|line| line.fixed.iter_mut().chain(&mut line.by_ground))
                .chain(&mut self.mirrored)
                .for_each(|v| *v *= share);
        }
    }
}

impl GroundLine {
    /// Returns the means of the fixed part and of the part by ground.
    pub fn mean(&self) -> [f64; 2] {
        [&self.fixed, &self.by_ground].map(|values| values.iter().sum::<f64>() / values.len().max(1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The usual grid has 37 azimuths and 19 altitudes, 703 suns, the lowest at 0.5 degrees; north
    /// is in each azimuth axis twice. An overcast sky of Perez 1990 with the sun at 5 degrees has
    /// F1 = 0 and F2 = -0.060 - 0.022 x 1.4835 = -0.0926.
    #[test]
    fn the_usual_grid_has_703_suns() {
        let (azimuths, altitudes) = (SunGrid::USUAL.azimuths_deg(), SunGrid::USUAL.altitudes_deg());
        assert_eq!((azimuths.len(), altitudes.len()), (37, 19));
        assert_eq!(
            (azimuths[0], azimuths[36], altitudes[0], altitudes[1], altitudes[18]),
            (0.0, 360.0, 0.5, 5.0, 90.0)
        );
        assert_eq!(ReflectedSky::Uniform.low().map(|low| low.horizon), None);
        let low = ReflectedSky::Perez1990.low().expect("a sky with a horizon");
        assert!(low.dome == 1.0 && (low.horizon + 0.0926).abs() < 1e-4, "{} {}", low.dome, low.horizon);
        assert_eq!((suns(SunGrid::USUAL).len(), suns(SunGrid::FINE).len()), (36 * 19, 72 * 37));
    }
}
