//! Edits of a small town.

use super::*;
use crate::Scene;
use crate::mesh::bounds;
use crate::mesh_objects::MeshObjects;
use heliotile_core::site::material::Class;
use heliotile_core::site::scene_object::{ObjectNote, SceneObject};

/// Returns the walls and the roof of a box of 4 m x 4 m from z to z + h.
fn block(x: f64, z: f64, h: f64) -> Vec<([DVec3; 3], u16)> {
    let at = |i: usize, z: f64| {
        let (dx, dy) = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)][i % 4];
        DVec3::new(x + dx, dy, z)
    };
    let quad = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| [[a, b, c], [a, c, d]];
    let walls = (0..4).flat_map(|i| quad(at(i, z), at(i + 1, z), at(i + 1, z + h), at(i, z + h)));
    let roof = quad(at(0, z + h), at(1, z + h), at(2, z + h), at(3, z + h));
    walls.chain(roof).map(|corners| (corners, 0)).collect()
}

/// Returns a house of two parts, 6 m high with an annex of 3 m, and a shed of 2.5 m.
fn town() -> TracedScene {
    let parts = [block(0.0, 0.0, 6.0), block(4.0, 0.0, 3.0), block(20.0, 1.0, 2.5)];
    let names = [("house-1", "house"), ("house-2", "house"), ("shed", "")];
    let named = |(name, building): (&str, &str)| SceneObject {
        name: name.to_owned(),
        note: ObjectNote { building: building.to_owned(), ..ObjectNote::default() },
    };
    let of_triangle: Vec<u32> = (0..).zip(&parts).flat_map(|(i, part)| vec![i; part.len()]).collect();
    let objects = MeshObjects { list: names.map(named).to_vec(), of_triangle };
    let materials = vec![Material::matt("wall", 0.4, Class::Obstruction)];
    let scene = Scene::from_objects(&parts.concat(), materials, &objects, None).expect("a scene");
    let points = (0..scene.mesh.triangles.len()).map(|triangle| scene.mesh.triangle_points(triangle));
    TracedScene {
        grid: scene.mesh.grid(),
        triangles: points.collect(),
        triangle_material: scene.mesh.triangle_material.clone(),
        materials: scene.materials,
        objects: scene.objects,
    }
}

fn edited(edits: SceneEdits) -> EditedScene {
    edits.apply(&town(), &[], Path::new("town.helio")).expect("an edited scene")
}

/// Returns the lowest and the highest point of an object.
fn heights(scene: &EditedScene, name: &str) -> (f64, f64) {
    let own =
        scene.triangles.iter().zip(&scene.of_triangle).filter(|(_, of)| scene.objects[**of as usize].name == name);
    let (low, high) = bounds(own.flat_map(|((corners, _), _)| corners).copied());
    (low.z, high.z)
}

/// Removing a building removes both its parts, 20 triangles of 30; removing a part removes its own
/// 10.
#[test]
fn objects_go_by_their_name_or_that_of_their_building() {
    for (name, left) in [("house", 10), ("house-2", 20), (" shed ", 20)] {
        let scene = edited(SceneEdits { remove: vec![name.to_owned()], ..SceneEdits::default() });
        assert_eq!((scene.triangles.len(), scene.of_triangle.len()), (left, left), "{name}");
        assert!(scene.changed);
    }
}

/// Adding 3 m to a house lifts both roofs, 6 to 9 m and 3 to 6 m, and leaves the foot. A height of
/// 2 m lowers the shed, whose foot is at z = 1 m, to z = 3 m. A moved object keeps its height.
#[test]
fn a_new_height_moves_roofs_and_not_the_foot() {
    let heights_of = |text: &str| SceneEdits { heights: vec![text.parse().expect(text)], ..SceneEdits::default() };
    let up = edited(heights_of("house=+3m"));
    assert_eq!([heights(&up, "house-1"), heights(&up, "house-2")], [(0.0, 9.0), (0.0, 6.0)]);
    assert_eq!(up.fates, [Fate::Reshaped, Fate::Reshaped, Fate::Stands]);
    assert_eq!(heights(&edited(heights_of("shed=2m")), "shed"), (1.0, 3.0));
    let moves = vec!["shed=1,-2,0.5".parse().expect("a move")];
    let moved = edited(SceneEdits { moves, ..SceneEdits::default() });
    assert_eq!((heights(&moved, "shed"), moved.fates[2]), ((1.5, 4.0), Fate::Moved(DVec3::new(1.0, -2.0, 0.5))));
}

/// Four heights are written as the text that they are read from; 4 texts are refused.
#[test]
fn heights_are_written_as_they_are_read() {
    for text in ["+3m", "-2.5m", "12m", "0.5m"] {
        let height: NewHeight = text.parse().expect(text);
        assert_eq!(serde_json::to_string(&height).expect("JSON"), format!("\"{text}\""));
    }
    for text in ["", "m", "tall", "0m"] {
        assert!(text.parse::<NewHeight>().is_err(), "{text}");
    }
}

/// A removed shed may be added again under its name, with the notes of the file; a shed that stays
/// may not.
#[test]
fn only_a_removed_object_can_be_replaced() {
    let note = ObjectNote { object_type: "Building".to_owned(), ..ObjectNote::default() };
    let objects = MeshObjects {
        list: vec![SceneObject { name: "shed".to_owned(), note: note.clone() }],
        of_triangle: vec![0; 10],
    };
    let wall = vec![Material::matt("wall", 0.4, Class::Obstruction)];
    let shed = Scene::from_objects(&block(20.0, 1.0, 4.0), wall, &objects, None).expect("a scene");
    let mut kept = edited(SceneEdits::default());
    assert!(kept.add(&shed, "shed", Path::new("shed.obj")).is_err());
    let mut scene = edited(SceneEdits { remove: vec!["shed".to_owned()], ..SceneEdits::default() });
    scene.add(&shed, "shed", Path::new("shed.obj")).expect("another shed");
    let after = scene.scene(&town()).expect("a scene");
    let found = after.objects.list.iter().find(|object| object.name == "shed").expect("the shed");
    assert_eq!((&found.note, after.mesh.triangles.len()), (&note, 30));
}

/// A file whose `wall` differs from the scene's adds it as `wall (tower)`; an equal one is the
/// scene's own.
#[test]
fn a_different_material_gets_a_new_name() {
    let objects = MeshObjects {
        list: vec![SceneObject { name: "tower".to_owned(), note: ObjectNote::default() }],
        of_triangle: vec![0; 10],
    };
    for (diffuse, names) in [(0.4, vec!["wall"]), (0.7, vec!["wall", "wall (tower)"])] {
        let materials = vec![Material::matt("wall", diffuse, Class::Obstruction)];
        let tower = Scene::from_objects(&block(9.0, 0.0, 30.0), materials, &objects, None).expect("a scene");
        let mut scene = edited(SceneEdits::default());
        scene.add(&tower, "tower", Path::new("tower.obj")).expect("an object");
        assert_eq!(scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), names);
        assert!(scene.add(&tower, "tower", Path::new("tower.obj")).is_err());
    }
}
