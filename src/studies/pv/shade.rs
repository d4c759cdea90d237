//! Shade of an array over the sky. In: an archive, places with their fronts. Out: the share of the
//! beam that arrives from each direction, and that of a uniform sky.

use std::collections::HashMap;

use super::spots::Spot;
use glam::DVec3;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::observer::Silent;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::reflectances::Changes;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::conditions::Condition;
use heliotile_results::outputs::pv::shade::{ShadeMap, altitudes_deg, azimuths_deg};
use heliotile_results::own_skies::SkyChoice;
use heliotile_results::{LightRequest, Provenance, ReceiverSet, Resources, Series, TileStream};

/// Irradiance of each sun and of the sky, W/m2.
const LIGHT_W_M2: f64 = 1000.0;
/// Least cosine of an angle of incidence that counts: below, the disc of the sun is partly behind
/// the module.
const GRAZING: f64 = 0.01;

/// Light on the array from a direction, and what would arrive without surroundings.
#[derive(Clone, Copy, Default)]
struct Arrived {
    light: f64,
    open: f64,
}

/// Returns the shade of the fronts of all places, weighted by their rated power, or equally.
pub fn map_of(spots: &[Spot], archive: &Archive, resources: &Resources) -> Result<ShadeMap> {
    let directions: Vec<DVec3> = azimuths_deg()
        .flat_map(|azimuth| altitudes_deg().map(move |altitude| direction_from_degrees(azimuth, altitude)))
        .collect();
    let beam = |sun: &DVec3| Condition::new(String::new(), &[*sun], *sun, LIGHT_W_M2, 0.0);
    let mut conditions: Vec<Condition> = directions.iter().map(beam).collect();
    conditions.push(Condition::new(String::new(), &[], DVec3::Y, 0.0, LIGHT_W_M2));
    let mut fronts: HashMap<&str, (DVec3, f64)> = HashMap::new();
    for spot in spots {
        let Some(front) = spot.sides.first() else { continue };
        let weight = spot.rating.kwp.unwrap_or(1.0) / front.receivers.len() as f64;
        let normal = spot.turn_of(front).normal();
        fronts.extend(front.receivers.iter().map(|(id, _)| (id.as_str(), (normal, weight))));
    }
    let light = LightRequest { sky: SkyChoice::Model(SkyModel::Uniform), ..LightRequest::default() };
    let series = Series::of_conditions(conditions, Changes::default(), Provenance::default());
    let receivers = ReceiverSet::all_of(archive)?;
    let resources = Resources { observer: &Silent, ..*resources };
    let stream = TileStream { receivers: &receivers, light: &light, series: &series, resources };
    let (mut suns, mut sky) = (vec![Arrived::default(); directions.len()], Arrived::default());
    stream.each(ComponentSet::new(&[Component::SunDirect, Component::SkyDirect]), |tile| {
        for (row, id) in tile.ids.iter().enumerate() {
            let Some((normal, weight)) = fronts.get(id.as_str()) else { continue };
            let arrived = tile.values.row(Component::SunDirect, row);
            for ((sum, direction), light) in suns.iter_mut().zip(&directions).zip(arrived) {
                let cos = normal.dot(*direction);
                if cos >= GRAZING {
                    sum.light += weight * f64::from(*light);
                    sum.open += weight * LIGHT_W_M2 * cos;
                }
            }
            let arrived = tile.values.row(Component::SkyDirect, row).last().copied().unwrap_or_default();
            sky.light += weight * f64::from(arrived);
            // A uniform sky on a tilted plane: half of 1 + the cosine of its tilt.
            sky.open += weight * LIGHT_W_M2 * (1.0 + normal.z) / 2.0;
        }
        Ok(true)
    })?;
    let share = |of: &Arrived| (of.open > 0.0).then(|| (of.light / of.open).clamp(0.0, 1.0));
    let columns = suns.chunks(altitudes_deg().count());
    Ok(ShadeMap {
        beam: columns.map(|column| column.iter().map(share).collect()).collect(),
        diffuse: share(&sky).unwrap_or(1.0),
    })
}
