//! Whole models: areas and normals agree with honeybee, and units and materials with what the
//! models state.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use crate::formats::building::frame::area_vector;
use crate::formats::building::notes::Notes;
use crate::formats::honeybee::optics::{Layers, of_construction};
use crate::formats::honeybee::properties::Layer;
use crate::formats::honeybee::*;
use crate::polygon::triangulate;
use crate::test_files::load_text;
use heliotile_core::site::bands::Band;
use heliotile_core::site::material::{Class, Glass, Material};

const TWO_ROOMS: &str = include_str!("../../../../tests/data/honeybee/two_rooms.hbjson");
/// Report of honeybee-core 1.64 on the surfaces of that model that face outdoors.
const TWO_ROOMS_CSV: &str = include_str!("../../../../tests/data/honeybee/two_rooms.honeybee.csv");

fn read(text: &str) -> Geometry {
    let asked = ReadOptions { reflectances: true, ..ReadOptions::default() };
    super::parse(text.as_bytes(), Path::new("m.hbjson"), &asked).expect("readable")
}

fn model() -> Value {
    serde_json::from_str(TWO_ROOMS).expect("JSON")
}

/// Returns the area vectors of all faces by the names of their objects, in the order of the file,
/// summed over their triangles.
fn areas(geometry: &Geometry) -> BTreeMap<String, Vec<DVec3>> {
    let cut = triangulate(geometry).expect("cut");
    assert_eq!((cut.degenerate_faces, cut.crossing_faces), (0, None), "{cut:?}");
    let mut rest = cut.triangles.iter().zip(&cut.objects).peekable();
    let mut found: BTreeMap<String, Vec<DVec3>> = BTreeMap::new();
    for face in geometry.faces() {
        let outline: Vec<DVec3> = face.rings().flatten().map(|&i| geometry.vertices[i as usize]).collect();
        // The triangles of a face use only its own vertices.
        let own: Vec<u32> = face.corners().to_vec();
        let mut sum = DVec3::ZERO;
        while let Some((triangle, _)) = rest.next_if(|(triangle, _)| own.contains(&triangle.corners[0])) {
            sum += area_vector(&triangle.corners.map(|corner| geometry.vertices[corner as usize]));
        }
        assert!(outline.len() >= 3);
        found.entry(geometry.objects.as_slice()[face.object as usize].clone()).or_default().push(sum);
    }
    found
}

/// Net areas and normals of all 33 surfaces of two rooms, with holes, shades of every kind and a
/// mesh, agree with honeybee to the sixth digit.
#[test]
fn areas_and_normals_agree_with_honeybee() {
    let geometry = read(TWO_ROOMS);
    let found = areas(&geometry);
    let mut compared = 0;
    let mut at: HashMap<&str, usize> = HashMap::new();
    for line in TWO_ROOMS_CSV.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [name, _, numbers @ ..] = fields.as_slice() else { panic!("{line}") };
        let numbers: Vec<f64> = numbers.iter().map(|text| text.parse().expect("a number")).collect();
        let place = at.entry(name).or_default();
        let ours = found[*name][*place];
        *place += 1;
        assert!((ours.length() - numbers[0]).abs() < 1e-6, "{name}: {} m2, not {}", ours.length(), numbers[0]);
        let normal = DVec3::from_slice(&numbers[1..]);
        assert!((ours.normalize() - normal).abs().max_element() < 1e-6, "{name}: {ours}, not {normal}");
        compared += 1;
    }
    assert_eq!((compared, geometry.face_count()), (33, 33));
    let left: Vec<(&str, usize)> = geometry.left_out.iter().map(|(why, count)| (why.as_str(), *count)).collect();
    assert_eq!(left, [("because they are indoor shades", 3), ("because they lie inside the building", 4)]);
    assert!(geometry.reference.is_none());
}

/// Two rooms in millimetres, centimetres, feet and inches give the same metres, 4 of 4, to a
/// millionth of a metre.
#[test]
fn all_units_give_the_same_metres() {
    fn scale(value: &mut Value, by: f64) {
        match value {
            Value::Array(list) if list.len() == 3 && list.iter().all(Value::is_number) => {
                list.iter_mut().for_each(|number| *number = json!(number.as_f64().expect("a number") * by));
            }
            Value::Array(list) => list.iter_mut().for_each(|item| scale(item, by)),
            Value::Object(map) => {
                let places = ["boundary", "holes", "vertices"];
                for (key, value) in map.iter_mut() {
                    if places.contains(&key.as_str()) || !value.is_array() || key != "faces" || !value[0].is_array() {
                        scale(value, by);
                    }
                }
            }
            _ => {}
        }
    }
    let expected = read(TWO_ROOMS);
    for (units, metres) in [("Millimeters", 1e-3), ("Centimeters", 1e-2), ("Feet", 0.3048), ("Inches", 0.0254)] {
        let mut model = model();
        scale(&mut model, 1.0 / metres);
        model["units"] = json!(units);
        model["tolerance"] = json!(0.01 / metres);
        let found = read(&model.to_string());
        assert_eq!(found.vertices.len(), expected.vertices.len());
        let off = found.vertices.iter().zip(&expected.vertices).map(|(a, b)| (*a - *b).abs().max_element());
        assert!(off.fold(0.0, f64::max) < 1e-6, "{units}");
        assert_eq!(found.face_count(), 33, "{units}");
    }
}

/// Returns the name and optics of the material of each surface.
fn materials(geometry: &Geometry) -> HashMap<String, (String, f64, f64, Option<Glass>, Class)> {
    let of = |face: crate::geometry::Polygon| {
        let material = &geometry.stated[&geometry.materials.as_slice()[face.material as usize]];
        material.check().expect("sound");
        let name = geometry.objects.as_slice()[face.object as usize].clone();
        (name, (material.name.clone(), material.diffuse, material.specular, material.glass, material.class))
    };
    geometry.faces().map(of).collect()
}

/// Twenty surfaces of two rooms have the material that they name, otherwise that of their room's
/// sets, otherwise honeybee's default. A shade that transmits half of the light has that
/// transmittance.
#[test]
fn surfaces_get_the_material_that_they_name() {
    let geometry = read(TWO_ROOMS);
    let found = materials(&geometry);
    let (single, double) = (Some(Glass::Single), Some(Glass::Double));
    for (surface, name, diffuse, specular, glass) in [
        ("hall_roof", "Roof Construction", 0.25, 0.0, None),
        ("hall_west", "Brick Wall", 0.4, 0.0, None),
        ("hall_north", "white_plaster", 0.7, 0.0, None),
        ("hall_floor", "Slab", 0.35, 0.0, None),
        ("shed_south", "red_paint", 0.97 * 0.2 + 0.03, 0.0, None),
        ("shed_roof", "zinc", 0.5, 0.0, None),
        ("shed_north", "white_plaster", 0.7, 0.0, None),
        ("shed_floor", "floor", 0.5, 0.0, None),
        ("skylight", "System", 0.0, 0.0, double),
        ("south_window", "Double", 0.0, 0.0, double),
        ("south_vent", "Single", 0.0, 0.0, single),
        ("north_window", "glass_0.98", 0.0, 0.0, single),
        ("shed_window", "window", 0.0, 0.0, double),
        ("main_door", "Oak Door", 0.45, 0.0, None),
        ("glass_door", "Double", 0.0, 0.0, double),
        ("gate", "red_paint", 0.97 * 0.2 + 0.03, 0.0, None),
        ("fin", "Grey Shade", 0.45, 0.0, None),
        ("porch", "mirror_foil", 0.0, 0.85, None),
        ("neighbour", "context", 0.2, 0.0, None),
        ("garden_wall", "wall", 0.35, 0.0, None),
    ] {
        let (its, matt, mirror, panes, class) = &found[surface];
        assert_eq!((its.as_str(), *panes), (name, glass), "{surface}");
        assert!((matt - diffuse).abs() < 1e-12 && (mirror - specular).abs() < 1e-12, "{surface}: {matt}, {mirror}");
        assert_eq!(*class == Class::Ground, surface.ends_with("_floor"), "{surface}");
    }
    assert_eq!(geometry.stated["shading transmittance 0.5"].transmittance, Some(0.5));
    assert_eq!(found["trellis"].0, "shading transmittance 0.5");
    let said: Vec<_> = geometry.warnings.iter().collect();
    assert!(said.len() == 1 && said[0].contains("surfaces have neither modifier nor construction"), "{said:?}");
}

/// In the global sets, which honeybee writes into every model, constructions come before modifiers,
/// and both come after what a room or an object names: 5 of 5.
#[test]
fn global_constructions_precede_global_modifiers() {
    let with = |radiance: bool, energy: bool| {
        let mut model = model();
        if radiance {
            model["properties"]["radiance"]["global_modifier_set"] = json!({"type": "GlobalModifierSet",
                "roof_ceiling_set": {"exterior_modifier": "ceiling"}, "floor_set": {"interior_modifier": "boards"},
                "context_modifier": "far", "modifiers": [
                    {"type": "Plastic", "identifier": "ceiling", "r_reflectance": 0.8, "g_reflectance": 0.8, "b_reflectance": 0.8},
                    {"type": "Plastic", "identifier": "far", "r_reflectance": 0.1, "g_reflectance": 0.1, "b_reflectance": 0.1},
                    {"type": "Plastic", "identifier": "boards", "r_reflectance": 0.2, "g_reflectance": 0.2, "b_reflectance": 0.2}]});
        }
        if energy {
            model["properties"]["energy"]["global_construction_set"] = json!({"type": "GlobalConstructionSet",
                "floor_set": {"ground_construction": "Generic Slab"}, "context_construction": "Generic Context",
                "constructions": [{"type": "OpaqueConstructionAbridged", "identifier": "Generic Slab", "materials": ["Foam"]},
                    {"type": "ShadeConstruction", "identifier": "Generic Context"}],
                "materials": [{"type": "EnergyMaterialNoMass", "identifier": "Foam", "r_value": 1}]});
        }
        materials(&read(&model.to_string()))
    };
    for (radiance, energy, surface, name, diffuse) in [
        (true, false, "neighbour", "far", 0.1),
        (true, true, "neighbour", "Generic Context", 0.2),
        (true, false, "shed_floor", "boards", 0.2),
        (true, true, "shed_floor", "Generic Slab", 0.3),
        (true, true, "hall_roof", "Roof Construction", 0.25),
    ] {
        let found = &with(radiance, energy)[surface];
        assert_eq!(found.0, name, "{surface}");
        assert!((found.1 - diffuse).abs() < 1e-12, "{surface}: {}", found.1);
    }
}

/// A layer that absorbs 0.8 of visible light and a shade that reflects 0.1 of it have 0.2 and 0.1
/// in the visible band. A shade with equal values has no value by band, and a specular shade has
/// the value of its mirror: 4 of 4.
#[test]
fn visible_absorptances_become_visible_reflectances() {
    let shade = |more: Value| {
        let mut shade = json!({"type": "ShadeConstruction", "identifier": "s", "solar_reflectance": 0.3});
        shade.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        let shade = serde_json::from_value(shade).expect("a construction");
        of_construction(&shade, &Layers(&HashMap::new()), &mut Notes::default()).expect("a material")
    };
    let seen = |material: &Material| material.bands.diffuse.stated(Band::Visible);
    assert_eq!(seen(&shade(json!({"visible_reflectance": 0.1}))), Some(0.1));
    assert!(shade(json!({"visible_reflectance": 0.3})).bands.is_empty());
    let mirror = shade(json!({"visible_reflectance": 0.1, "is_specular": true}));
    assert_eq!((mirror.bands.specular.stated(Band::Visible), mirror.check()), (Some(0.1), Ok(())));
    let layer: Layer = serde_json::from_value(
        json!({"type": "EnergyMaterial", "identifier": "Brick", "solar_absorptance": 0.6, "visible_absorptance": 0.8}),
    )
    .expect("a layer");
    let wall =
        serde_json::from_value(json!({"type": "OpaqueConstruction", "identifier": "Wall", "materials": ["Brick"]}));
    let wall =
        of_construction(&wall.expect("a wall"), &Layers(&HashMap::from([("Brick", &layer)])), &mut Notes::default());
    let seen = wall.as_ref().and_then(seen).expect("stated");
    assert!((seen - 0.2).abs() < 1e-12, "{seen}");
}

/// Six modifiers reflect as in Radiance: a rough one is matt, metal colours its mirror image,
/// plastic does not.
#[test]
fn modifiers_reflect_as_in_radiance() {
    for (modifier, diffuse, specular) in [
        (
            json!({"type": "Plastic", "r_reflectance": 0.2, "g_reflectance": 0.4, "b_reflectance": 0.6, "specularity": 0.05}),
            0.38,
            0.05,
        ),
        (
            json!({"type": "Metal", "r_reflectance": 0.5, "g_reflectance": 0.5, "b_reflectance": 0.5, "specularity": 0.8}),
            0.1,
            0.4,
        ),
        (
            json!({"type": "Metal", "r_reflectance": 0.5, "g_reflectance": 0.5, "b_reflectance": 0.5, "specularity": 0.8, "roughness": 0.1}),
            0.5,
            0.0,
        ),
        (json!({"type": "Mirror"}), 0.0, 1.0),
        (
            json!({"type": "Trans", "r_reflectance": 0.8, "g_reflectance": 0.8, "b_reflectance": 0.8, "transmitted_diff": 0.5}),
            0.4,
            0.0,
        ),
        (json!({"type": "BSDF", "front_diffuse_reflectance": [0.1, 0.2, 0.3], "bsdf_data": ""}), 0.2, 0.0),
    ] {
        let mut model = model();
        // The modifier stands in place of its name, as in full properties.
        let mut modifier = modifier;
        modifier["identifier"] = json!("m");
        model["orphaned_shades"][0]["properties"] = json!({"radiance": {"modifier": modifier}});
        let found = &materials(&read(&model.to_string()))["neighbour"];
        assert!(found.0 == "m" && (found.1 - diffuse).abs() < 1e-12 && (found.2 - specular).abs() < 1e-12, "{found:?}");
    }
}

/// A window in a wall with a hole leaves 12 - 1 - 2 m2; a window over that hole is left out.
/// Adiabatic walls back to back are left out, a single one stays, and so does the window of a wall
/// without corners.
#[test]
fn walls_between_rooms_are_left_out() {
    let wall = |name: &str, x: f64, back: bool, condition: &str, windows: Value| {
        let mut boundary = vec![[0.0, x, 0.0], [4.0, x, 0.0], [4.0, x, 3.0], [0.0, x, 3.0]];
        if back {
            boundary.reverse();
        }
        let hole = json!([[0.5, x, 1.0], [1.5, x, 1.0], [1.5, x, 2.0], [0.5, x, 2.0]]);
        json!({"type": "Face", "identifier": name, "geometry": {"boundary": boundary, "holes": [hole]}, "face_type": "Wall",
            "boundary_condition": {"type": condition}, "apertures": windows})
    };
    let window = |name: &str, x0: f64, x1: f64| {
        json!({"type": "Aperture", "identifier": name, "boundary_condition": {"type": "Outdoors"},
            "geometry": {"boundary": [[x0, 0.0, 1.0], [x1, 0.0, 1.0], [x1, 0.0, 2.0], [x0, 0.0, 2.0]]}})
    };
    let faces = json!([
        wall("a", 0.0, false, "Outdoors", json!([window("w", 2.0, 4.0), window("over", 1.0, 1.8)])),
        wall("b", 5.0, false, "Adiabatic", Value::Null),
        wall("c", 5.0, true, "Adiabatic", Value::Null),
        wall("d", 9.0, false, "Adiabatic", Value::Null),
        {"identifier": "no wall", "face_type": "Wall", "boundary_condition": {"type": "Outdoors"}, "geometry": {"boundary": []},
            "apertures": [window("z", 0.0, 1.0)]},
    ]);
    let geometry = read(&json!({"type": "Model", "orphaned_faces": faces}).to_string());
    let found = areas(&geometry);
    assert_eq!(found.keys().map(String::as_str).collect::<Vec<_>>(), ["a", "d", "w", "z"]);
    assert!((found["a"][0].length() - 9.0).abs() < 1e-9 && (found["d"][0].length() - 11.0).abs() < 1e-9);
    assert_eq!(geometry.left_out.values().sum::<usize>(), 3);
    assert!(
        geometry
            .warnings
            .iter()
            .any(|said| said.contains("1 windows or doors are left out") && said.contains("`over`"))
    );
}

/// A model is recognised in a file named `.json` too, wherever its type stands; four other kinds of
/// JSON are not models.
#[test]
fn a_model_is_recognised_by_its_type() {
    for (text, is) in [
        (TWO_ROOMS, true),
        (r#"{"rooms":[{"type":"Room"}],"type":"Model"}"#, true),
        (r#"{"type":"Model", broken"#, true),
        (r#"{"type":"CityJSON","version":"2.0"}"#, false),
        (r#"{"type":7}"#, false),
        (r#"[{"type":"Model"}]"#, false),
        ("", false),
    ] {
        assert_eq!(is_model(text.as_bytes()), is, "{text:.50}");
    }
    let load = |name: &str| load_text(name, TWO_ROOMS).expect("a scene").0;
    let scene = load("a.hbjson");
    assert_eq!((load("b.json").content_hash(), scene.report.faces_read), (scene.content_hash(), 33));
}

/// The ground of four models lies at z = 0, as in honeybee's translation to EnergyPlus, or as low
/// as a shade or wall reaches: 3 cm, 30 cm and 3 m below it.
#[test]
fn the_ground_lies_at_zero() {
    let wall = |low: f64| json!([[0.0, 0.0, low], [4.0, 0.0, low], [4.0, 0.0, 9.0]]);
    let outdoors = json!({"type": "Outdoors"});
    let of = |wall_low: f64, shade_low: f64| {
        json!({"type": "Model",
            "orphaned_faces": [{"identifier": "w", "face_type": "Wall", "boundary_condition": outdoors, "geometry": {"boundary": wall(wall_low)}}],
            "orphaned_shades": [{"identifier": "s", "geometry": {"boundary": wall(shade_low)}}]})
    };
    for (model, elevation_m) in
        [(of(8.0, 5.0), 0.0), (of(-0.03, 2.0), -0.03), (of(0.0, -0.3), -0.3), (of(-3.0, 1.0), -3.0)]
    {
        let geometry = read(&model.to_string());
        assert_eq!(geometry.ground, Some(ModelGround::usual(elevation_m)));
        let said =
            geometry.warnings.iter().filter(|said| said.contains("surfaces in the sun reach below z = 0")).count();
        assert_eq!(said, usize::from(elevation_m < 0.0), "{:?}", geometry.warnings);
    }
}

/// A window of 4 m2 with a hole of 1 m2 in a wall of 80 m2 leaves 77 m2 of wall, 1 m2 of which lies
/// in the hole, beside a window of 0.25 m2 there that is listed first. The areas of wall, frame and
/// window are 76.75, 3 and 0.25 m2.
#[test]
fn what_stands_in_the_hole_of_a_window_is_wall() {
    let square = |low: f64, high: f64| json!([[low, 0.0, low], [high, 0.0, low], [high, 0.0, high], [low, 0.0, high]]);
    let window = |name: &str, boundary: Value, holes: Value| json!({"identifier": name, "boundary_condition": {"type": "Outdoors"}, "geometry": {"boundary": boundary, "holes": holes}});
    let wall = json!([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 0.0, 8.0], [0.0, 0.0, 8.0]]);
    for (is_clockwise, inner) in [(false, true), (true, true), (false, false)] {
        let mut hole = square(3.5, 4.5);
        if is_clockwise {
            hole.as_array_mut().expect("a ring").reverse();
        }
        let mut windows = vec![window("pane", square(3.0, 5.0), json!([hole]))];
        if inner {
            windows.insert(0, window("inner", square(3.75, 4.25), Value::Null));
        }
        let face = json!({"identifier": "wall", "face_type": "Wall", "boundary_condition": {"type": "Outdoors"},
            "geometry": {"boundary": wall}, "apertures": windows});
        let geometry = read(&json!({"type": "Model", "orphaned_faces": [face]}).to_string());
        let found = areas(&geometry);
        let area = |name: &str| found.get(name).map_or(0.0, |faces| faces.iter().copied().sum::<DVec3>().length());
        let inner_m2 = if inner { 0.25 } else { 0.0 };
        for (name, area_m2) in [("wall", 77.0 - inner_m2), ("pane", 3.0), ("inner", inner_m2)] {
            assert!((area(name) - area_m2).abs() < 1e-9, "{name}: {}", area(name));
        }
        assert_eq!(geometry.warnings.iter().filter(|said| said.contains("windows or doors are left out")).count(), 0);
    }
}

/// A room whose 6 faces look inwards, with its window or without, a room whose roof does, and one
/// whose window does become equal to the correct room, with 1 warning that counts them. A room
/// without its roof and floor stays unchanged.
#[test]
fn faces_of_a_closed_room_look_outwards() {
    let text = include_str!("../../../../tests/data/honeybee/room_inwards.hbjson");
    let flipped: Value = serde_json::from_str(text).expect("JSON");
    let turn = |boundary: &mut Value| boundary["geometry"]["boundary"].as_array_mut().expect("a ring").reverse();
    let mut right = flipped.clone();
    right["rooms"][0]["faces"].as_array_mut().expect("faces").iter_mut().for_each(turn);
    let mut whole = flipped.clone();
    turn(&mut whole["rooms"][0]["faces"][0]["apertures"][0]);
    let normals = |model: &Value| -> BTreeMap<String, Vec<DVec3>> { areas(&read(&model.to_string())) };
    let expected = normals(&right);
    assert!((expected["R"][0] - DVec3::new(0.0, 0.0, 80.0)).length() < 1e-9);
    let (mut roof, mut window) = (right.clone(), right.clone());
    turn(&mut roof["rooms"][0]["faces"][4]);
    turn(&mut window["rooms"][0]["faces"][0]["apertures"][0]);
    for (model, said) in [
        (&whole, "6 faces of closed rooms look inwards and are turned"),
        (&flipped, "6 faces of closed rooms look inwards and are turned"),
        (&roof, "1 faces of closed rooms look inwards and are turned"),
        (&window, "1 windows or doors face against their wall and are turned round"),
    ] {
        let geometry = read(&model.to_string());
        let turned: Vec<_> = geometry.warnings.iter().filter(|warning| warning.contains("turned")).collect();
        assert!(turned.len() == 1 && turned[0].contains(said), "{said}: {turned:?}");
        for (name, faces) in normals(model) {
            assert!((faces[0] - expected[&name][0]).length() < 1e-9, "{name}");
        }
    }
    let mut open = flipped.clone();
    open["rooms"][0]["faces"].as_array_mut().expect("faces").truncate(4);
    assert!((normals(&open)["N"][0].y + 30.0).abs() < 1e-9);
}
