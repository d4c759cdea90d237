//! Single trees. In: points of trees that files state, with height and width of the crown, in
//! scene coordinates, and the ground below. Out: closed hulls of leaves.

use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec2;
use heliotile_core::error::Result;
use heliotile_core::site::material::{BROADLEAF_DIFFUSE, LEAF_AREA_DENSITY, Material, NEEDLE_DIFFUSE};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::FaceNote;

use crate::footprints::stated::metres_of;
use crate::geometry::Geometry;
use crate::surface_rasters::SurfaceRasters;
use crate::tree_point::{Crown, LeafKind, SIDES, TreePoint};
use serde_json::{Map, Value};

/// Group of the materials of trees, which schedules of leaves refer to.
pub(crate) const TREES: &str = "trees";

/// Adds the hull of a tree whose trunk stands on the ground at `ground_m`.
pub(crate) fn plant(file: &Path, geometry: &mut Geometry, tree: &TreePoint, ground_m: f64) -> Result<()> {
    let name = tree.leaves.material();
    let material = geometry.materials.id(name);
    if !geometry.stated.contains_key(name) {
        let diffuse = if tree.leaves == LeafKind::Broad { BROADLEAF_DIFFUSE } else { NEEDLE_DIFFUSE };
        let leaves = Material::of_leaves(name, LEAF_AREA_DENSITY, diffuse);
        geometry.stated.insert(name.to_owned(), Material { group: Some(TREES.to_owned()), ..leaves });
        geometry.assumed.insert(name.to_owned());
    }
    let object = geometry.objects.id(&tree.name);
    let note = ObjectNote {
        object: tree.name.clone(),
        object_type: "SolitaryVegetationObject".to_owned(),
        beside: true,
        attributes: tree.attributes.clone(),
        ..ObjectNote::default()
    };
    geometry.object_notes.insert(object, note);
    let rings = tree.crown.rings(tree.leaves);
    // `[ring][side]`: a ring that is one point repeats it, and the first corner ends each ring.
    let mut vertices: Vec<Vec<u32>> = Vec::with_capacity(rings.len());
    for (radius, height) in rings {
        let corner = |side: usize| {
            let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
            (tree.at + radius * DVec2::new(cos, sin)).extend(ground_m + height)
        };
        let count = if radius > 0.0 { SIDES } else { 1 };
        let of_ring = (0..count).map(|side| geometry.push_vertex(file, corner(side)));
        let ring = of_ring.collect::<Result<Vec<u32>>>()?;
        vertices.push(ring.iter().copied().cycle().take(SIDES + 1).collect());
    }
    for [low, high] in vertices.array_windows() {
        for ([a, b], [d, c]) in low.array_windows().zip(high.array_windows()) {
            for half in [[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && a != c) {
                half.into_iter().for_each(|corner| geometry.push_corner(*corner));
                geometry.end_face(material, object, tree.number);
                geometry.note_face(FaceNote::default());
            }
        }
    }
    Ok(())
}

/// Width of a crown as a share of the height of its tree where none is stated: an assumption.
const WIDTH_SHARE: f64 = 0.5;
/// Largest height and width of a tree, metres: the tallest redwoods have 116 m.
const MAX_HEIGHT_M: f64 = 130.0;
const MAX_WIDTH_M: f64 = 60.0;

/// Columns of the height of a tree, of the width and of the base of its crown, metres:
/// OpenStreetMap, and tree registers in English, German, French, Spanish and Dutch.
const HEIGHTS: [&str; 13] = [
    "height",
    "est_height",
    "height_m",
    "tree_height",
    "hoehe",
    "hoehe_m",
    "baumhoehe",
    "hauteur",
    "hauteur_m",
    "hauteurenm",
    "altura",
    "hoogte",
    "boomhoogte",
];
const WIDTHS: [&str; 15] = [
    "diameter_crown",
    "crown_diameter",
    "crown_diam",
    "crown_width",
    "crown_m",
    "spread",
    "spread_m",
    "kronedurch",
    "kronendurchmesser",
    "kronendurchm",
    "kronenbreite",
    "diametre_houppier",
    "diametro_copa",
    "kroondiameter",
    "kroonbreedte",
];
const BASES: [&str; 5] = ["crown_base", "crown_base_m", "canopy_base", "trunk_height", "kronenansatz"];
/// Columns that only trees have.
const OF_TREES: [&str; 8] = ["leaf_type", "genus", "species", "taxon", "baumart", "gattung", "essence", "boomsoort"];
/// Genera of conifers in streets and parks.
const CONIFERS: [&str; 16] = [
    "abies",
    "araucaria",
    "cedrus",
    "chamaecyparis",
    "cryptomeria",
    "cupressus",
    "juniperus",
    "larix",
    "metasequoia",
    "picea",
    "pinus",
    "pseudotsuga",
    "sequoiadendron",
    "taxodium",
    "taxus",
    "thuja",
];

/// Reason for leaving out trees without a height.
pub(crate) const NO_HEIGHT: &str = "as trees without a height";

/// Tree as a feature states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StatedTree {
    pub crown: Crown,
    pub leaves: LeafKind,
    /// True if the width of the crown is assumed.
    pub width_is_assumed: bool,
}

/// Returns the tree that the attributes of a point state, or the reason why it is left out; `None`
/// if the point is no tree.
pub(crate) fn stated_tree(attributes: &Map<String, Value>) -> Option<std::result::Result<StatedTree, &'static str>> {
    let get = |column: &str| {
        let alike = || attributes.iter().find(|(name, _)| name.eq_ignore_ascii_case(column)).map(|(_, value)| value);
        attributes.get(column).or_else(alike).filter(|value| !value.is_null())
    };
    let word = |column: &str| get(column).and_then(Value::as_str).map(|text| text.trim().to_lowercase());
    let length =
        |columns: &[&str]| columns.iter().filter_map(|column| metres_of(get(column)?)).find(|metres| *metres > 0.0);
    let is_tree = match word("natural") {
        Some(kind) => kind == "tree",
        None => WIDTHS.iter().chain(&OF_TREES).any(|column| get(column).is_some()),
    };
    if !is_tree {
        return None;
    }
    let genus = ["genus", "species", "taxon", "gattung"].into_iter().find_map(word);
    let genus = genus.as_deref().and_then(|name| name.split([' ', ',']).next()).unwrap_or_default().to_owned();
    let is_conifer = word("leaf_type").map_or(CONIFERS.contains(&genus.as_str()), |leaves| leaves == "needleleaved");
    let Some(top_m) = length(&HEIGHTS) else { return Some(Err(NO_HEIGHT)) };
    let width = length(&WIDTHS);
    let crown = Crown {
        top_m,
        base_m: length(&BASES).unwrap_or(SurfaceRasters::TRUNK_SHARE * top_m),
        width_m: width.unwrap_or(WIDTH_SHARE * top_m),
    };
    if top_m > MAX_HEIGHT_M || crown.width_m > MAX_WIDTH_M {
        return Some(Err("as trees higher than 130 m or wider than 60 m"));
    }
    if crown.base_m >= top_m {
        return Some(Err("as trees whose crown begins above their top"));
    }
    let leaves = if is_conifer { LeafKind::Needle } else { LeafKind::Broad };
    Some(Ok(StatedTree { crown, leaves, width_is_assumed: width.is_none() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use serde_json::json;
    use std::f64::consts::PI;

    fn stated(value: Value) -> Option<std::result::Result<StatedTree, &'static str>> {
        stated_tree(value.as_object().expect("an object"))
    }

    /// A lime of OpenStreetMap, a spruce of a register and a tree without a width are read; one
    /// without a height and one that begins above its top are left out; a mast and a building are
    /// no trees.
    #[test]
    fn registers_and_maps_state_trees() {
        let lime = stated(json!({"natural": "tree", "height": "12 m", "diameter_crown": "8", "genus": "Tilia"}));
        let crown = Crown { top_m: 12.0, base_m: 3.0, width_m: 8.0 };
        let lime = lime.expect("a tree").expect("a height");
        assert_eq!(lime, StatedTree { crown, leaves: LeafKind::Broad, width_is_assumed: false });
        let spruce = stated(json!({"Baumhoehe": 20, "KRONEDURCH": 6.0, "species": "Picea abies", "crown_base": 1}));
        let crown = Crown { top_m: 20.0, base_m: 1.0, width_m: 6.0 };
        let spruce = spruce.expect("a tree").expect("a height");
        assert_eq!(spruce, StatedTree { crown, leaves: LeafKind::Needle, width_is_assumed: false });
        let plain = stated(json!({"natural": "tree", "height": 10})).expect("a tree").expect("a height");
        assert!(plain.width_is_assumed && plain.crown.width_m == 5.0);
        assert_eq!(stated(json!({"natural": "tree", "species": "Tilia"})), Some(Err(NO_HEIGHT)));
        assert!(stated(json!({"natural": "tree", "height": 5, "crown_base": 6})).is_some_and(|tree| tree.is_err()));
        assert_eq!([json!({"man_made": "mast", "height": 30}), json!({"natural": "peak"})].map(stated), [None, None]);
    }

    /// Hulls are closed, with the volume of ellipsoid and cone to 1e-9: 80 and 16 triangles.
    #[test]
    fn hulls_have_the_volume_of_their_crowns() {
        for (leaves, triangles, share) in [(LeafKind::Broad, 80, 6.0), (LeafKind::Needle, 16, 12.0)] {
            let crown = Crown { top_m: 12.0, base_m: 3.0, width_m: 8.0 };
            let tree = TreePoint {
                name: "t".into(),
                number: 1,
                at: DVec2::new(5.0, -7.0),
                crown,
                leaves,
                attributes: "{}".into(),
            };
            let mut geometry = Geometry::default();
            plant(Path::new("trees.geojson"), &mut geometry, &tree, 100.0).expect("a tree");
            let corner = |number: &u32| geometry.vertices[*number as usize] - DVec3::new(5.0, -7.0, 100.0);
            let (mut volume, mut sides, mut count) = (0.0, std::collections::HashMap::new(), 0);
            for face in geometry.faces() {
                let [a, b, c] = face.corners() else { panic!("no triangle") };
                volume += corner(a).dot(corner(b).cross(corner(c))) / 6.0;
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *sides.entry((*from.min(to), *from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
                }
                count += 1;
            }
            let wanted = PI / share * 64.0 * 9.0;
            assert!((volume / wanted - 1.0).abs() < 1e-9, "{volume} {wanted}");
            assert_eq!((count, sides.values().filter(|sum| **sum != 0).count()), (triangles, 0));
        }
    }
}
