//! The plane of a scene without ground. In: the scene's triangles with their objects. Out: the
//! plane's height, and a warning for the user.

use std::collections::BTreeMap;

use heliotile_core::text::{Message, message};

use glam::{DVec2, DVec3};

use crate::ground::found::{Corners, lies_free};
use crate::ground::model::USUAL;
use crate::mesh::RawTriangle;
use crate::text::excerpt;

/// Depth of the plane below the lowest point, metres, so that rays do not hit floors at that point
/// and the plane at once.
pub(crate) const BELOW_M: f64 = 0.01;
/// Height of objects above the plane beyond which they stand on a slope, metres.
const SLOPE_M: f64 = 5.0;
/// Least height of an object whose foot counts, metres: lower ones are slabs or roofs, whose lowest
/// corner does not show the ground.
const STANDING_M: f64 = 2.0;
/// Share of the objects whose feet are ignored, the highest ones: upper parts of buildings have
/// high feet.
const LEFT_OUT: f64 = 0.1;

/// Returns the least and the greatest height of triangles; `None` without triangles.
pub(crate) fn heights<'t>(
    positions: &[DVec3],
    triangles: impl IntoIterator<Item = &'t RawTriangle>,
) -> Option<[f64; 2]> {
    let corners = triangles.into_iter().flat_map(|triangle| triangle.corners);
    let heights = corners.filter_map(|corner| positions.get(corner as usize)).map(|p| p.z);
    heights.fold(None, |found: Option<[f64; 2]>, z| {
        let [low, high] = found.unwrap_or([z, z]);
        Some([low.min(z), high.max(z)])
    })
}

/// Returns the height of the highest foot of objects above a plane, without the highest tenth of
/// them; `objects` holds the object of each triangle.
fn highest_foot(positions: &[DVec3], triangles: &[RawTriangle], objects: &[u32], plane_m: f64) -> Option<f64> {
    let count = objects.iter().max().map_or(0, |most| *most as usize + 1);
    let mut spans: Vec<Option<[f64; 2]>> = vec![None; count];
    for (triangle, &object) in triangles.iter().zip(objects) {
        if let (Some(span), Some([low, high])) = (spans.get_mut(object as usize), heights(positions, [triangle])) {
            let [least, most] = span.unwrap_or([low, high]);
            *span = Some([least.min(low), most.max(high)]);
        }
    }
    let mut feet: Vec<f64> = spans
        .into_iter()
        .flatten()
        .filter(|[low, high]| high - low > STANDING_M)
        .map(|span| span[0] - plane_m)
        .collect();
    feet.sort_by(f64::total_cmp);
    feet.get(((1.0 - LEFT_OUT) * feet.len() as f64).ceil() as usize - usize::from(!feet.is_empty())).copied()
}

/// Returns the warning about an assumed plane; `partly` if the scene has some ground.
pub(crate) fn warning(
    positions: &[DVec3],
    triangles: &[RawTriangle],
    objects: &[u32],
    plane_m: f64,
    partly: bool,
) -> Message {
    let slope = match highest_foot(positions, triangles, objects, plane_m) {
        Some(foot) if foot > SLOPE_M => {
            format!("; objects stand up to {foot:.1} m above it, so that terrain would be better")
        }
        _ => String::new(),
    };
    let lack = if partly { "the ground of the scene does not surround it" } else { "the scene has no ground" };
    let below = heights(positions, triangles).is_some_and(|[low, _]| low < plane_m);
    let at = if below { "the lowest point of what stands" } else { "its lowest point" };
    message!(
        "{lack}: a plane that reflects {USUAL} is assumed at {at}, {:.2} m{slope} ({{no_ground}}: none; [endless_ground] in \
         {{materials}}: another)",
        plane_m + BELOW_M
    )
}

/// Least share of a material's area that faces up if it is ground by its shape.
const FACES_UP: f64 = 0.9;
/// Least share of the plan that such a material covers.
const COVERS: f64 = 0.5;
/// Depth below ground that feet of what stands may have, metres.
const SAME_LEVEL_M: f64 = 0.5;

/// Returns the materials that count as what stands but are ground by their shape, and their areas,
/// m2: they face up and cover half of the plan with nothing above, and everything else stands on
/// them.
pub(crate) fn ground_by_shape(
    triangles: impl Iterator<Item = (u32, Corners)> + Clone,
    stands: impl Fn(u32) -> bool,
) -> Vec<(u32, f64)> {
    let mut areas: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (material, [a, b, c]) in triangles.clone() {
        let cross = (b - a).cross(c - a) / 2.0;
        let [plan, area] = areas.entry(material).or_default();
        (*plan, *area) = (*plan + cross.z.max(0.0), *area + cross.length());
        for corner in [a, b, c] {
            (low, high) = (low.min(corner.truncate()), high.max(corner.truncate()));
        }
    }
    let extent = high - low;
    let wide = |[plan, area]: [f64; 2]| plan >= FACES_UP * area && plan >= COVERS * extent.x * extent.y;
    let heights = |faces: &mut dyn Iterator<Item = Corners>| {
        let z = faces.flatten().map(|corner| corner.z);
        z.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    };
    let lies_below = |material: u32| {
        let [own, others] = [true, false]
            .map(|own| triangles.clone().filter(move |(of, _)| (*of == material) == own).map(|(_, corners)| corners));
        let ([low, high], [foot, top]) = (heights(&mut own.clone()), heights(&mut others.clone()));
        top > high && foot >= low - SAME_LEVEL_M && lies_free(own, others)
    };
    let found = areas.into_iter().filter(|(material, areas)| wide(*areas) && stands(*material));
    found.filter(|(material, _)| lies_below(*material)).map(|(material, [plan, _])| (material, plan)).collect()
}

/// Returns the warning about such a material.
pub(crate) fn ground_warning(name: &str, area_m2: f64) -> Message {
    message!(
        "material `{}` counts as an obstruction, but its {area_m2:.0} m2 lie below everything else: write class = \"ground\" for it \
         in {{materials}} if it is ground",
        excerpt(name.as_bytes())
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten towers of 9 m stand on a slope that rises 1 m from one to the next: nine of them stand
    /// at most 8.01 m above a plane 1 cm below the lowest, which the warning says. On a slope of
    /// half the rise it does not mention objects. A slab of 1 m at 50 m does not count.
    #[test]
    fn a_slope_below_objects_is_warned_of() {
        let town = |rise: f64| {
            let (mut positions, mut triangles, mut objects) = (Vec::new(), Vec::new(), Vec::new());
            let feet = (0..10).map(|i| (f64::from(i) * rise, 9.0)).chain([(50.0, 1.0)]);
            for (object, (foot, height)) in (0..).zip(feet) {
                let first = positions.len() as u32;
                positions.extend([[0.0, foot], [1.0, foot], [0.0, foot + height]].map(|[x, z]| DVec3::new(x, 0.0, z)));
                triangles.push(RawTriangle { corners: [first, first + 1, first + 2], material: 0, object: 0 });
                objects.push(object);
            }
            warning(&positions, &triangles, &objects, -BELOW_M, false)
        };
        assert!(
            town(1.0).contains("assumed at its lowest point, 0.00 m; objects stand up to 8.0 m above"),
            "{:?}",
            town(1.0)
        );
        assert!(town(0.5).contains("0.00 m (no_ground: none; "), "{:?}", town(0.5));
    }
}
