//! Surroundings of a model. In: files, the place of the model among them. Out: one site of all, and
//! the surroundings as shading surfaces in the model's coordinates.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::Task;
use crate::neighbours::{Neighbours, Spot, convergence_deg};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::text::{Message, counted, message};
use heliotile_scene::Scene;
use heliotile_scene::covering::surfaces::Surfaces;
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::site::{MissingGround, Part, SceneFiles};

/// A model with its surroundings.
pub struct ModelSurroundings {
    pub site: SceneFiles,
    pub neighbours: Neighbours,
    pub materials: Vec<Material>,
    /// Object types of the model's surfaces, which receivers go on; empty if there are no
    /// surroundings.
    pub types: Vec<String>,
}

/// Number of shading surfaces above which EnergyPlus's own shadows are slow: 500 cost a model of 86
/// surfaces 80 s a year, 2000 some 470 s (measured).
const MANY: usize = 500;

/// Distance between a model and its surroundings above which they are taken to be in different
/// coordinates, metres.
const APART_M: f64 = 20_000.0;

impl ModelSurroundings {
    /// Reads the surroundings that `--scene` names, apart from the model, and puts the model among
    /// them.
    pub fn read(task: &Task) -> Result<ModelSurroundings> {
        let model = task.request.site(std::slice::from_ref(&task.request.model))?;
        if task.request.scene.is_empty() {
            return Ok(ModelSurroundings {
                site: model,
                neighbours: Neighbours::default(),
                materials: Vec::new(),
                types: Vec::new(),
            });
        }
        let (alone, own) = Scene::load_with_objects(&model)?;
        let objects = Surfaces::find(&own, &alone.materials).objects;
        let types: BTreeSet<String> = objects.into_iter().map(|(_, note)| note.object_type).collect();
        let types = types.into_iter().filter(|name| !name.is_empty()).collect();
        let mut others = task.request.site(&task.request.scene)?;
        others.frame.epsg = task.request.crs.or(others.frame.epsg);
        let alone = SceneFiles { missing_ground: MissingGround::LeaveOut, ..others.clone() };
        let (scene, soup) = Scene::load_with_objects(&alone)?;
        let spot = match task.request.at {
            Some(origin) => Spot::at(origin.into(), convergence_deg(scene.place.as_ref())),
            None => refuse_far(task, &scene).map(|()| Spot::default())?,
        };
        how_it_stands(spot.origin, &soup, &scene.materials).iter().for_each(|text| task.warn(text));
        let neighbours = Neighbours::new(&soup, &scene.materials, spot);
        let mut site = SceneFiles { parts: Vec::new(), ..others };
        // Surroundings in a coordinate reference system know true north better than the model does.
        let knows = scene.place.is_some_and(|place| place.epsg.is_some());
        let placed = |part: Part| Part {
            offset: part.offset + spot.origin,
            rotate_deg: part.rotate_deg + spot.north_deg,
            is_moved: knows,
            ..part
        };
        site.parts.extend(model.parts.into_iter().map(placed));
        site.parts.extend(others.parts);
        tell(&neighbours, task);
        Ok(ModelSurroundings { site, neighbours, materials: scene.materials, types })
    }
}

/// Refuses surroundings far from the origin: they are in coordinates that the model does not share.
fn refuse_far(task: &Task, scene: &Scene) -> Result<()> {
    let first = task.request.scene.first().cloned().unwrap_or_default();
    let hint = "give the place of the model's origin in these coordinates, metres: {at} E,N or {at} E,N,Z";
    let middle = scene.mesh.origin;
    if let Some(place) = scene.place.filter(|place| place.epsg.is_some()) {
        let epsg = place.epsg.unwrap_or_default();
        let what = format!(
            "has coordinates of EPSG:{epsg}, about {:.0} {:.0}, but the model has local coordinates",
            middle.x, middle.y
        );
        return Err(Error::input(&first, None, what, hint));
    }
    if middle.truncate().length() > APART_M {
        let what = format!("lies about {:.0} {:.0}, far from the model's origin", middle.x, middle.y);
        return Err(Error::input(&first, None, what, hint).because(Problem::Misplaced));
    }
    Ok(())
}

/// Distance between a model's origin and the ground there above which a warning is given, metres.
const OFF_THE_GROUND_M: f64 = 1.0;

/// Describes an odd place of a model's origin among its surroundings: outside of them, or off the
/// ground.
fn how_it_stands(origin: DVec3, soup: &ObjectTriangles, materials: &[Material]) -> Option<Message> {
    let (low, high) = soup.bounds();
    let (at, hint) = (
        format!("the model's origin, {:.1} {:.1}", origin.x, origin.y),
        Message::from("; set its place with {at} E,N,Z"),
    );
    let place = origin.truncate();
    if place.cmplt(low.truncate()).any() || place.cmpgt(high.truncate()).any() {
        let around = format!("{:.1} {:.1} to {:.1} {:.1}", low.x, low.y, high.x, high.y);
        return Some(message!("{at}, lies outside its surroundings ({around}), with no ground below it").and(hint));
    }
    let is_ground = |material: u16| materials.get(usize::from(material)).is_some_and(|m| m.class == Class::Ground);
    let ground = soup.triangles.iter().zip(&soup.materials).filter(|(_, material)| is_ground(**material));
    let heights = ground.filter_map(|(corners, _)| {
        let corners = corners.map(|corner| soup.positions.get(corner as usize).copied());
        let [Some(a), Some(b), Some(c)] = corners else { return None };
        height_of([a, b, c], place)
    });
    let nearest = heights.min_by(|a, b| (a - origin.z).abs().total_cmp(&(b - origin.z).abs()))?;
    let off = origin.z - nearest;
    (off.abs() > OFF_THE_GROUND_M).then(|| {
        let side = if off > 0.0 { "above" } else { "below" };
        message!(
            "{at}, stands {:.1} m {side} the ground of its surroundings, which lies at {nearest:.2} m there",
            off.abs()
        )
        .and(hint)
    })
}

/// Returns the height of a triangle over a place; `None` beside it and where it is upright.
fn height_of([a, b, c]: [DVec3; 3], at: DVec2) -> Option<f64> {
    let (ab, ac, ap) = ((b - a).truncate(), (c - a).truncate(), at - a.truncate());
    let whole = ab.perp_dot(ac);
    let (v, w) = (ap.perp_dot(ac) / whole, ab.perp_dot(ap) / whole);
    // The comparisons are false for NaN.
    (v >= 0.0 && w >= 0.0 && v + w <= 1.0).then_some(a.z + v * (b.z - a.z) + w * (c.z - a.z))
}

fn tell(neighbours: &Neighbours, task: &Task) {
    let count = neighbours.polygons.len();
    if task.request.delete_surroundings {
        return task.report(format!(
            "surroundings: {} traced, but not added to the model\n",
            counted(count as u64, "polygon")
        ));
    }
    task.report(format!(
        "surroundings: {} as Shading:Site:Detailed, so that EnergyPlus shades direct light\n",
        counted(count as u64, "polygon")
    ));
    if neighbours.ground > 0 {
        task.report(format!(
            "surroundings: {} of ground, traced but not added: ground shades nothing in EnergyPlus\n",
            counted(neighbours.ground as u64, "triangle")
        ));
    }
    if count > MANY {
        task.warn(format!(
            "EnergyPlus computes shadows of {count} polygons slowly: in a model of 86 surfaces, 500 polygons cost 80 s for a year and \
             2000 about 470 s"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slope of 10 m over 100 m is 2.5 m high a quarter up; beside it and on an upright triangle
    /// there is no height: 3 of 3.
    #[test]
    fn a_slope_has_a_height_only_over_itself() {
        let slope = [DVec3::ZERO, DVec3::new(100.0, 0.0, 10.0), DVec3::new(0.0, 100.0, 0.0)];
        assert_eq!(height_of(slope, DVec2::new(25.0, 10.0)), Some(2.5));
        assert_eq!(height_of(slope, DVec2::new(80.0, 30.0)), None);
        let upright = [DVec3::ZERO, DVec3::new(100.0, 0.0, 0.0), DVec3::new(50.0, 0.0, 10.0)];
        assert_eq!(height_of(upright, DVec2::new(50.0, 0.0)), None);
    }
}
