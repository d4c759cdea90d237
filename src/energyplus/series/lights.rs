//! Light of surfaces step by step. In: an archive, steps. Out: means over each surface of some
//! components of light.

use std::collections::BTreeMap;

use super::steps::Steps;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::light::paths::LightPaths;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::sky::model::SkyModel;
use heliotile_results::SkyChoice;
use heliotile_results::{LightRequest, ReceiverSet, Resources, Series, TileStream};

/// Components of reflected light, summed to one result.
pub const REFLECTED: &[&[Component]] =
    &[&[Component::SunReflected, Component::SkyReflected, Component::SunMirrored, Component::SkyMirrored]];

/// Components of direct light: the sun and the sky, one result each.
pub const DIRECT: &[&[Component]] = &[&[Component::SunDirect], &[Component::SkyDirect]];

/// Request for series of light.
pub struct SeriesRequest<'a> {
    pub steps: &'a Steps,
    pub sky: SkyModel,
    pub paths: LightPaths,
    /// Components that are added up, for each result.
    pub sums: &'a [&'a [Component]],
    /// Reflectance of the ground, `[lit]`; `None` where it does not matter.
    pub ground: Option<&'a [f64]>,
    /// Areas of surfaces with their hidden parts, by name in small letters, m2.
    pub whole_m2: &'a BTreeMap<String, f64>,
    pub resources: Resources<'a>,
}

/// Light of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceSeries {
    /// Name as the model spells it.
    pub name: String,
    pub receivers: usize,
    /// Area that is not hidden, m2.
    pub area_m2: f64,
    /// Share of the hemisphere that is sky.
    pub sky_view: f64,
    /// Irradiance, `[sum][lit]`, W/m2.
    pub sums: Vec<Vec<f64>>,
}

/// Computes the means over all surfaces, by name in small letters; hidden parts of surfaces get no
/// light.
pub fn surface_series(archive: &Archive, asked: &SeriesRequest) -> Result<BTreeMap<String, SurfaceSeries>> {
    let count = asked.steps.conditions.len();
    let components: Vec<Component> = asked.sums.iter().copied().flatten().copied().collect();
    let receivers = ReceiverSet::all_of(archive)?;
    let series = Series::over_ground(asked.steps.conditions.clone(), asked.ground);
    let light = LightRequest { sky: SkyChoice::Model(asked.sky), paths: asked.paths, ..LightRequest::default() };
    let stream = TileStream { receivers: &receivers, light: &light, series: &series, resources: asked.resources };
    let mut found: BTreeMap<String, SurfaceSeries> = BTreeMap::new();
    let mut rows = receivers.rows::<()>();
    stream.each(ComponentSet::new(&components), |tile| {
        for (row, receiver) in rows.by_ref().take(tile.ids.len()).enumerate() {
            let receiver = receiver?;
            let (views, receiver) = (receiver.views, receiver.receiver);
            let area_m2 = receiver.area.unwrap_or(1.0);
            let mean = found.entry(receiver.part.face.to_lowercase()).or_insert_with(|| SurfaceSeries {
                name: receiver.part.face.clone(),
                sums: vec![vec![0.0; count]; asked.sums.len()],
                ..SurfaceSeries::default()
            });
            mean.receivers += 1;
            mean.area_m2 += area_m2;
            mean.sky_view += area_m2 * f64::from(views[0]);
            for (sum, components) in mean.sums.iter_mut().zip(asked.sums) {
                for component in *components {
                    let row = tile.values.row(*component, row);
                    sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += area_m2 * f64::from(*value));
                }
            }
        }
        Ok(true)
    })?;
    for (name, mean) in &mut found {
        // Hidden parts get no light, so sums are divided by the whole area.
        let whole_m2 = asked.whole_m2.get(name).copied().unwrap_or_default().max(mean.area_m2);
        let share = if whole_m2 > 0.0 { 1.0 / whole_m2 } else { 0.0 };
        mean.sky_view *= share;
        mean.sums.iter_mut().flatten().for_each(|value| *value *= share);
    }
    Ok(found)
}
