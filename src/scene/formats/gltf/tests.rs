//! In: glTF files made here, valid and damaged. Out: proof that they are read correctly, or refused
//! with a message.

use std::fs;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::formats::gltf::*;
use crate::test_files::{TestFolder, area_and_volume, cube};

fn asked() -> ReadOptions {
    ReadOptions { reflectances: true, ..ReadOptions::default() }
}

fn parse(json: &Value) -> Result<Geometry> {
    crate::formats::gltf::parse(json.to_string().as_bytes(), Path::new("town.gltf"), &asked())
}

/// Returns 8 vertices of f32 (96 bytes), then 36 indices of u16: the cube with y up and z south.
fn cube_bytes() -> Vec<u8> {
    let (vertices, triangles) = cube();
    let numbers = vertices.iter().flat_map(|v| [v.x, v.z, -v.y]).flat_map(|metres| (metres as f32).to_le_bytes());
    let indices = triangles.concat().into_iter().flat_map(|index| (index as u16).to_le_bytes());
    numbers.chain(indices).collect()
}

fn data(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

/// Returns a scene with nodes that may use mesh 0, the cube.
fn scene(nodes: Value) -> Value {
    json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
        "meshes": [{"name": "cube", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 77}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
        "buffers": [{"byteLength": 168, "uri": data(&cube_bytes())}],
    })
}

fn with(mut json: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = json.pointer_mut(parent).expect(pointer);
    match key.parse::<usize>() {
        Ok(place) if parent.is_array() => parent[place] = value,
        _ => parent[key] = value,
    }
    json
}

fn bounds(geometry: &Geometry) -> [[f64; 3]; 2] {
    let rounded = |p: DVec3| ((p * 1e6).round() / 1e6 + 0.0).to_array();
    let all = geometry.vertices.iter();
    let (low, high) = all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    [rounded(low), rounded(high)]
}

/// A cube keeps 6 m2 and +1 m3, outsides out, however its node places it: moved, turned, mirrored,
/// in a child, by TRS or by matrix.
#[test]
fn a_placed_cube_keeps_its_area_and_volume() {
    let half = 0.5_f64.sqrt();
    for (nodes, low, high) in [
        (json!([{"mesh": 0}]), [0., 0., 0.], [1., 1., 1.]),
        // 10 east, 20 up, 30 south.
        (json!([{"mesh": 0, "translation": [10, 20, 30]}]), [10., -30., 20.], [11., -29., 21.]),
        // A quarter turn to the left about the upright axis.
        (json!([{"mesh": 0, "rotation": [0, half, 0, half]}]), [-1., 0., 0.], [0., 1., 1.]),
        (json!([{"mesh": 0, "scale": [-1, 1, 1]}]), [-1., 0., 0.], [0., 1., 1.]),
        (json!([{"mesh": 0, "scale": [-1, -1, -1]}]), [-1., -1., -1.], [0., 0., 0.]),
        (json!([{"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,-1,0, 5,6,7,1]}]), [5., -8., 6.], [6., -7., 7.]),
        // The child moves first, and then turns with its parent.
        (
            json!([{"children": [1], "rotation": [0, half, 0, half]}, {"mesh": 0, "translation": [3, 0, 0]}]),
            [-1., 3., 0.],
            [0., 4., 1.],
        ),
        (
            json!([{"children": [1], "translation": [500000.3, 0, -5700000.7]}, {"mesh": 0}]),
            [500_000.3, 5_700_000.7, 0.],
            [500_001.3, 5_700_001.7, 1.],
        ),
    ] {
        let geometry = parse(&scene(nodes.clone())).expect("readable");
        assert_eq!((geometry.face_count(), geometry.vertices.len()), (12, 8));
        assert_eq!(bounds(&geometry), [low, high], "{nodes}");
        // Volume does not depend on position, but its sum loses digits far from the origin.
        let volume = area_and_volume(&geometry).1;
        assert!((volume - 1.0).abs() < if high[1] > 1e3 { 0.01 } else { 1e-9 }, "{nodes}: {volume}");
        assert!((area_and_volume(&geometry).0 - 6.0).abs() < 1e-6);
    }
}

/// Two instances give 24 triangles and two objects, named after the node or, without a node name,
/// after the mesh. Nodes outside the scene are not read.
#[test]
fn two_nodes_of_a_mesh_are_two_objects() {
    let nodes =
        json!([{"children": [1, 2]}, {"mesh": 0, "name": "house"}, {"mesh": 0}, {"mesh": 0, "name": "elsewhere"}]);
    let geometry = parse(&scene(nodes.clone())).expect("readable");
    assert_eq!(geometry.face_count(), 24);
    assert_eq!(geometry.objects.as_slice(), ["house", "cube"]);
    let mut all = scene(nodes);
    all.as_object_mut().expect("an object").retain(|key, _| !key.starts_with("scene"));
    let geometry = parse(&with(all, "/meshes/0/name", Value::Null)).expect("readable");
    assert_eq!(geometry.objects.as_slice(), ["house", "node_2", "elsewhere"]);
}

/// A .glb, a buffer in a file with a blank in its name, and embedded base64 without padding give
/// the same cube of 1 m3.
#[test]
fn all_containers_give_the_same_cube() {
    let folder = TestFolder::new();
    let write = |name: &str, bytes: &[u8]| folder.write(name, bytes);
    let read = |name: &str| {
        let path = folder.at(name);
        crate::formats::gltf::parse(&fs::read(&path).expect("written"), &path, &asked()).expect("readable")
    };
    let plain = scene(json!([{"mesh": 0}]));
    write("my cube.bin", &cube_bytes());
    write("beside.gltf", with(plain.clone(), "/buffers/0/uri", json!("./my%20cube.bin")).to_string().as_bytes());
    let unpadded = data(&cube_bytes()).trim_end_matches('=').to_owned();
    write("inside.gltf", with(plain.clone(), "/buffers/0/uri", json!(unpadded)).to_string().as_bytes());
    write("cube.glb", &glb(&with(plain, "/buffers/0/uri", Value::Null), &cube_bytes()));
    for name in ["beside.gltf", "inside.gltf", "cube.glb"] {
        assert!((area_and_volume(&read(name)).1 - 1.0).abs() < 1e-9, "{name}");
    }
}

fn glb(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = (28 + text.len() + buffer.len()) as u32;
    let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
    let head = [*b"glTF", 2_u32.to_le_bytes(), total.to_le_bytes(), length(&text), *b"JSON"].concat();
    [head, text.clone(), [length(buffer), *b"BIN\0"].concat(), buffer.to_vec()].concat()
}

/// A quadrangle gives 2 triangles of 1 m2, upwards, as a list, a strip, a fan, without indices,
/// interleaved and quantized; lines are counted.
#[test]
fn all_triangle_modes_give_the_same_square() {
    let square = [[0., 0., 0.], [1., 0., 0.], [0., 0., -1.], [1., 0., -1.]];
    let floats = |places: &[usize], gap: usize| -> Vec<u8> {
        let one = |place: &usize| {
            let mut bytes: Vec<u8> = square[*place].iter().flat_map(|x: &f32| x.to_le_bytes()).collect();
            bytes.resize(12 + gap, 255);
            bytes
        };
        places.iter().flat_map(one).collect()
    };
    let bytes_of = |scale: i8| square.iter().flat_map(|p| p.map(|x| (x as i8 * scale) as u8)).collect::<Vec<u8>>();
    for (mode, kind, normalized, stride, bytes) in [
        (4, 5126, false, 0, floats(&[0, 1, 2, 2, 1, 3], 0)),
        (4, 5126, false, 20, floats(&[0, 1, 2, 2, 1, 3], 8)),
        (5, 5126, false, 0, floats(&[0, 1, 2, 3], 0)),
        (5, 5126, false, 0, floats(&[0, 1, 2, 3, 3, 3], 0)),
        (6, 5126, false, 16, floats(&[0, 1, 3, 2], 4)),
        (5, 5120, false, 0, bytes_of(1)),
        (5, 5120, true, 0, bytes_of(127)),
    ] {
        let size = if kind == 5120 { 3 } else { 12 };
        let count = bytes.len() / if stride == 0 { size } else { stride };
        let json = json!({
            "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0}, "mode": mode}, {"attributes": {"POSITION": 0}, "mode": 1}]}],
            "accessors": [{"bufferView": 0, "componentType": kind, "normalized": normalized, "count": count, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": bytes.len(), "byteStride": stride}],
            "buffers": [{"byteLength": bytes.len(), "uri": data(&bytes)}],
        });
        let geometry = parse(&json).expect("readable");
        let mut area = DVec3::ZERO;
        for face in geometry.faces() {
            let [a, b, c] = [0, 1, 2].map(|i| geometry.vertices[face.corners()[i] as usize]);
            area += 0.5 * (b - a).cross(c - a);
        }
        let kept = if count == 6 && mode == 5 { 4 } else { 2 };
        assert!(geometry.face_count() <= kept, "{mode} {kind}");
        assert!((area - DVec3::Z).length() < 1e-12, "{mode} {kind} {stride}: {area}");
        assert_eq!(geometry.left_out.values().sum::<usize>(), 1);
    }
}

/// Three of seven materials are described: 0.4 for (0.3, 0.4, 0.5), half of it for one that is half
/// metal, and a second one of the same name.
#[test]
fn materials_with_a_stated_colour_are_described() {
    let color = |name: &str, metal: f64| json!({"name": name, "pbrMetallicRoughness": {"baseColorFactor": [0.3, 0.4, 0.5, 1], "metallicFactor": metal}});
    let textured =
        json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}, "alphaMode": "MASK"});
    let list = json!([color("roof", 0.0), color("half", 0.5), color("roof", 0.5), textured, {"name": "bare"}]);
    let used = [json!(0), json!(1), json!(2), json!(3), json!(4), Value::Null, json!(0)];
    let primitives = used.map(|material| json!({"attributes": {"POSITION": 0}, "indices": 1, "material": material}));
    let json = with(scene(json!([{"mesh": 0, "skin": 0}])), "/meshes/0/primitives", json!(primitives));
    let json =
        with(with(json, "/materials", list), "/extensionsUsed", json!(["KHR_materials_ior", "EXT_texture_webp"]));
    let geometry = parse(&json).expect("readable");
    assert_eq!(geometry.materials.as_slice(), ["roof", "half", "roof_2", "material_3", "bare", "default"]);
    let stated: Vec<(&str, f64)> = geometry.stated.values().map(|m| (m.name.as_str(), m.diffuse)).collect();
    let near = |found: f64, expected: f64| (found - expected).abs() < 1e-12;
    assert_eq!(stated.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["half", "roof", "roof_2"]);
    assert!(stated.iter().zip([0.2, 0.4, 0.2]).all(|((_, found), expected)| near(*found, expected)), "{stated:?}");
    let expected = [
        "town.gltf: extensions not read: KHR_materials_ior",
        "town.gltf: 1 materials (`material_3` is the first) have a texture",
        "town.gltf: 1 materials (`material_3` is the first) are transparent",
        "town.gltf: 2 materials (`half` is the first) are metallic",
        "town.gltf: 1 nodes have skins",
    ];
    assert_eq!(geometry.warnings.len(), expected.len(), "{:?}", geometry.warnings);
    assert!(
        geometry.warnings.iter().zip(expected).all(|(found, begin)| found.plain().starts_with(begin)),
        "{:?}",
        geometry.warnings
    );
    let plain = ReadOptions::default();
    let named =
        crate::formats::gltf::parse(json.to_string().as_bytes(), Path::new("town.gltf"), &plain).expect("readable");
    assert_eq!(named.materials.as_slice(), ["roof", "half", "material_3", "bare", "default"]);
    assert_eq!((named.stated.len(), named.warnings.len()), (0, 2));
}

/// 45 damaged files are refused with a message of what was found; billions of values without bytes
/// take no memory.
#[test]
fn damaged_files_are_refused_with_a_reason() {
    let plain = || scene(json!([{"mesh": 0}]));
    let nodes = |nodes: Value| scene(nodes);
    let mut nan = cube_bytes();
    nan[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut beyond = cube_bytes();
    beyond[96] = 8;
    let required = |name: &str| with(plain(), "/extensionsRequired", json!([name]));
    for (json, said) in [
        (json!(null), "the JSON is not valid glTF"),
        (json!({"asset": {"version": "1.0"}, "meshes": {}}), "found glTF 1.0, this release supports glTF 2.0"),
        (json!({"asset": {"version": "2.0"}}), "holds no triangles (0 nodes"),
        (with(plain(), "/nodes/0/mesh", Value::Null), "holds no triangles (1 nodes, 0 meshes of other kinds)"),
        (
            with(plain(), "/meshes/0/primitives/0/mode", json!(0)),
            "holds no triangles (1 nodes, 1 meshes of other kinds)",
        ),
        (with(plain(), "/scene", json!(3)), "the default scene is number 3, but the file has 1,"),
        (with(plain(), "/scene", json!(-1)), "invalid value: integer `-1`"),
        (with(plain(), "/nodes/0/mesh", json!(4_000_000_000_u32)), "mesh 4000000000, which does not exist"),
        (nodes(json!([{"children": [0]}])), "node 0 has two parents or is one of its own children"),
        (nodes(json!([{"children": [1]}, {"children": [2]}, {"children": [1]}])), "node 1 has two parents"),
        (nodes(json!([{"children": [7]}])), "node 7 does not exist, there are 1"),
        (nodes(json!([{"mesh": 0, "rotation": [0, 0, 0, 0]}])), "node 0 has a rotation that is not a unit quaternion"),
        (nodes(json!([{"mesh": 0, "matrix": [0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,0]}])), "matrix that is not a placement"),
        (nodes(json!([{"mesh": 0, "matrix": [1, 2]}])), "the JSON is not valid glTF"),
        (nodes(json!([{"mesh": 0, "translation": [1e300, 0, 0]}])), "vertex 0 of `cube` lies at [1"),
        (nodes(json!([{"mesh": 0, "scale": [1e300, 1e300, 1]}, {}])), "beyond all positions on Earth"),
        (with(plain(), "/buffers/0/uri", json!(data(&nan))), "vertex 0 of `cube` lies at [NaN, "),
        (
            with(plain(), "/buffers/0/uri", json!(data(&beyond))),
            "triangle of vertex 8, but vertices are numbered 0 to 7",
        ),
        (with(plain(), "/buffers/0/uri", json!("data:;base64,AA*A")), "buffer 0 is not valid base64"),
        (with(plain(), "/buffers/0/uri", json!("data:text/plain,hello")), "which is not written in base64"),
        (with(plain(), "/buffers/0/uri", json!("../cube.bin")), "`../cube.bin`, not a file in the folder"),
        (with(plain(), "/buffers/0/uri", json!("a/%2e%2e/%2E%2E/cube.bin")), "not a file in the folder"),
        (with(plain(), "/buffers/0/uri", json!("/etc/passwd")), "`/etc/passwd`, not a file in the folder"),
        (with(plain(), "/buffers/0/uri", json!("https://example.org/a.bin")), "not a file in the folder"),
        (with(plain(), "/buffers/0/uri", json!("gone.bin")), "cannot read the buffer gone.bin: "),
        (with(plain(), "/buffers/0/uri", Value::Null), "is in buffer 0, which does not exist or has no bytes"),
        (with(plain(), "/buffers/0/byteLength", json!(u64::MAX)), "buffer 0 has 168 of its 18446744073709551615 bytes"),
        (with(plain(), "/bufferViews/1/byteLength", json!(73)), "accessor 1 is in buffer view 1, which reaches beyond"),
        (with(plain(), "/bufferViews/1/byteOffset", json!(u64::MAX)), "buffer view 1, which reaches beyond its buffer"),
        (with(plain(), "/bufferViews/1/buffer", json!(9)), "accessor 1 is in buffer 9, which does not exist"),
        (with(plain(), "/bufferViews/0/byteStride", json!(1)), "accessor 0 has values of 12 bytes every 1 bytes"),
        (
            with(plain(), "/accessors/0/count", json!(9)),
            "accessor 0 has 9 values every 12 bytes, more than its buffer view",
        ),
        (with(plain(), "/accessors/0/count", json!(u64::MAX)), "accessor 0 has 18446744073709551615 values"),
        (with(plain(), "/accessors/0/byteOffset", json!(u64::MAX)), "more than its buffer view of 96 bytes"),
        (with(plain(), "/accessors/0/bufferView", json!(5)), "accessor 0 is in buffer view 5, which does not exist"),
        (with(plain(), "/accessors/0/bufferView", Value::Null), "accessor 0 has no buffer view"),
        (with(plain(), "/accessors/0/componentType", json!(5130)), "component type 5130"),
        (with(plain(), "/accessors/0/type", json!("VEC9")), "accessor 0 is `VEC9`"),
        (with(plain(), "/accessors/1/componentType", json!(5122)), "`cube` has positions or indices of a type"),
        (with(plain(), "/accessors/0/sparse", json!({"count": 1})), "the JSON is not valid glTF"),
        (
            with(plain(), "/meshes/0/primitives/0/material", json!(2)),
            "material 2 is used but does not exist; the file has 0",
        ),
        (with(plain(), "/meshes/0/primitives/0/indices", json!(2)), "accessor 2 does not exist"),
        (
            required("KHR_draco_mesh_compression"),
            "KHR_draco_mesh_compression, without which geometry is missing, this release supports meshes without",
        ),
        (required("EXT_meshopt_compression"), "EXT_meshopt_compression, without which geometry is missing"),
        (required("ACME_\u{1b}thing"), "the required extension ACME_\u{fffd}thing"),
    ] {
        let message = parse(&json).map(drop).expect_err(said).to_string();
        let names_file = message.contains("town.gltf") || message.contains("gone.bin");
        assert!(names_file && message.contains(said), "{said}: {message}");
    }
}

/// Appends numbers to the bytes of the cube, with accessors from 2 on: each has a shape, a
/// component type and a count.
fn with_accessors(mut json: Value, accessors: &[(&str, u32, &[u8], usize)]) -> Value {
    let mut bytes = cube_bytes();
    for (shape, kind, data, count) in accessors {
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let view = json["bufferViews"].as_array().expect("views").len();
        let normalized = *kind != 5126 && *shape == "VEC4";
        json["bufferViews"]
            .as_array_mut()
            .expect("views")
            .push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
        json["accessors"].as_array_mut().expect("accessors").push(
            json!({"bufferView": view, "componentType": kind, "count": count, "type": shape, "normalized": normalized}),
        );
        bytes.extend_from_slice(data);
    }
    json["buffers"] = json!([{"byteLength": bytes.len(), "uri": data(&bytes)}]);
    json
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn instanced(attributes: Value) -> Value {
    scene(json!([{"mesh": 0, "name": "house", "translation": [100, 0, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]))
}

/// Three instances by TRANSLATION are three cubes at 100, 130 and 160 m with their own names. A
/// ROTATION about the upright axis and a SCALE of 2 turn and stretch the cube alike as floats,
/// bytes and shorts. A single instance keeps the name.
#[test]
fn gpu_instances_are_placed_cubes() {
    let three = floats(&[0., 0., 0., 30., 0., 0., 60., 0., 0.]);
    let geometry = parse(&with_accessors(instanced(json!({"TRANSLATION": 2, "_ID": 9})), &[("VEC3", 5126, &three, 3)]));
    let geometry = geometry.expect("readable");
    assert_eq!((geometry.face_count(), geometry.vertices.len()), (36, 24));
    assert_eq!(geometry.objects.as_slice(), ["house_1", "house_2", "house_3"]);
    assert_eq!(bounds(&geometry), [[100., 0., 0.], [161., 1., 1.]]);
    assert!((area_and_volume(&geometry).1 - 3.0).abs() < 1e-6);
    // A quarter turn about y, from x to north in scene coordinates.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let (bytes, shorts) =
        ([0_i8, 90, 0, 90].map(|x| x as u8), [0_i16, 23_170, 0, 23_170].map(i16::to_le_bytes).concat());
    let size = floats(&[2., 2., 2.]);
    for (kind, turn) in [(5126, floats(&[0., half, 0., half])), (5120, bytes.to_vec()), (5122, shorts)] {
        let json = instanced(json!({"ROTATION": 2, "SCALE": 3}));
        let geometry =
            parse(&with_accessors(json, &[("VEC4", kind, &turn, 1), ("VEC3", 5126, &size, 1)])).expect("readable");
        assert_eq!(geometry.objects.as_slice(), ["house"]);
        let [low, high] = bounds(&geometry).map(|corner| corner.map(|x| (x * 1000.0).round() / 1000.0));
        assert_eq!([low, high], [[98., 0., 0.], [100., 2., 2.]], "{kind}");
    }
    let two = floats(&[0., 0., 0., 1., 1., 1.]);
    for (attributes, said) in [
        (json!({}), "have neither TRANSLATION nor ROTATION nor SCALE"),
        (json!({"TRANSLATION": 2, "SCALE": 3}), "have attributes of [3, 2] values"),
        (json!({"ROTATION": 2}), "of a type that the extension does not allow"),
        (json!({"TRANSLATION": 7}), "accessor 7 does not exist"),
        (json!({"SCALE": 4}), "have an invalid placement, number 0"),
    ] {
        let bad = floats(&[f32::NAN, 1., 1.]);
        let accessors: [(&str, u32, &[u8], usize); 3] =
            [("VEC3", 5126, &three, 3), ("VEC3", 5126, &two, 2), ("VEC3", 5126, &bad, 1)];
        let message = parse(&with_accessors(instanced(attributes), &accessors)).map(drop).expect_err(said).to_string();
        assert!(message.contains(said), "{said}: {message}");
    }
}

/// A sparse accessor lifts one corner of the cube by 1 m (volume 1.1667 m3 or 1.3333, by its
/// diagonals), over a buffer view or over zeros. Indices that do not increase or exceed the values
/// are refused.
#[test]
fn sparse_values_replace_stored_ones() {
    let sparse = |base: bool, places: &[u8], count: u64, values: &[f32]| {
        let moved = floats(values);
        let json = with_accessors(
            scene(json!([{"mesh": 0}])),
            &[("SCALAR", 5121, places, places.len()), ("VEC3", 5126, &moved, 1)],
        );
        let part = |view: u64| json!({"bufferView": view, "componentType": 5121});
        let json =
            with(json, "/accessors/0/sparse", json!({"count": count, "indices": part(2), "values": {"bufferView": 3}}));
        if base { json } else { with(json, "/accessors/0/bufferView", Value::Null) }
    };
    let (corners, _) = cube();
    let stored = |v: &DVec3| [v.x as f32, v.z as f32, -v.y as f32];
    let top = corners.iter().position(|v| v.z == 1.0).expect("a corner of the roof");
    let lifted = stored(&(corners[top] + DVec3::Z));
    let geometry = parse(&sparse(true, &[top as u8], 1, &lifted)).expect("readable");
    let high = geometry.vertices.iter().fold(0.0_f64, |most, vertex| most.max(vertex.z));
    assert_eq!(high, 2.0);
    let volume = area_and_volume(&geometry).1;
    assert!((volume - 7.0 / 6.0).abs() < 1e-9 || (volume - 4.0 / 3.0).abs() < 1e-9, "{volume}");
    let all: Vec<f32> = corners.iter().flat_map(stored).collect();
    let geometry = parse(&sparse(false, &[0, 1, 2, 3, 4, 5, 6, 7], 8, &all)).expect("readable");
    assert!((area_and_volume(&geometry).1 - 1.0).abs() < 1e-9);
    for (places, said) in
        [(&[3, 3][..], "do not increase"), (&[4, 8], "go beyond its 8 values"), (&[1, 2, 3], "more than")]
    {
        let message =
            parse(&sparse(true, places, places.len() as u64, &all[..6])).map(drop).expect_err(said).to_string();
        assert!(message.contains(said), "{said}: {message}");
    }
}

/// Geometry that only an extension holds is refused, 4 of 4, with the extension's name and the word
/// "missing", even if the extension is not required. A compressed mesh that also has plain numbers
/// is read, with a warning.
#[test]
fn geometry_only_in_an_extension_is_refused() {
    let primitive = "/meshes/0/primitives/0";
    let draco =
        |json| with(json, &format!("{primitive}/extensions"), json!({"KHR_draco_mesh_compression": {"bufferView": 0}}));
    let plain = || scene(json!([{"mesh": 0}]));
    let used = with(draco(plain()), "/extensionsUsed", json!(["KHR_draco_mesh_compression"]));
    let geometry = parse(&used).expect("readable");
    assert_eq!(geometry.face_count(), 12);
    assert!(
        geometry
            .warnings
            .iter()
            .map(|said| said.plain())
            .collect::<String>()
            .contains("geometry is missing if KHR_draco_mesh_compression holds any")
    );
    let unfilled = with(draco(plain()), "/accessors/0/bufferView", Value::Null);
    let no_indices = with(draco(plain()), "/accessors/1/bufferView", Value::Null);
    let shape = with(plain(), primitive, json!({"attributes": {}, "extensions": {"ACME_shape": {}}}));
    let mut packed = with(plain(), "/bufferViews/0/extensions", json!({"EXT_meshopt_compression": {"buffer": 0}}));
    packed["bufferViews"][0]["buffer"] = json!(1);
    packed["buffers"].as_array_mut().expect("buffers").push(json!({"byteLength": 96}));
    for (json, name) in [
        (unfilled, "KHR_draco_mesh_compression"),
        (no_indices, "KHR_draco_mesh_compression"),
        (shape, "ACME_shape"),
        (packed, "EXT_meshopt_compression"),
    ] {
        let message = parse(&json).map(drop).expect_err(name).to_string();
        assert!(message.contains(name) && message.contains("without which geometry is missing"), "{message}");
    }
}

/// A scene relative to a CESIUM_RTC centre is placed about it, z up: the cube from (7, 8, 9) to (8,
/// 9, 10).
#[test]
fn a_cesium_rtc_centre_moves_the_scene() {
    let mut json = scene(json!([{"mesh": 0}]));
    json["extensions"] = json!({"CESIUM_RTC": {"center": [7, 8, 9]}});
    assert_eq!(bounds(&parse(&json).expect("readable")), [[7., 8., 9.], [8., 9., 10.]]);
}

/// White factors, stated or left out, and nearly white ones give no reflectance: 3 materials in one
/// warning, none described.
#[test]
fn white_factors_state_no_reflectance() {
    let plain = json!({"name": "wall", "pbrMetallicRoughness": {"metallicFactor": 0}});
    let stated =
        json!({"name": "roof", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0.0}});
    let near = json!({"name": "near", "pbrMetallicRoughness": {"baseColorFactor": [0.98, 0.99, 0.985, 1], "metallicFactor": 1}});
    let primitives =
        [0, 1, 2].map(|material| json!({"attributes": {"POSITION": 0}, "indices": 1, "material": material}));
    let json = with(scene(json!([{"mesh": 0}])), "/meshes/0/primitives", json!(primitives));
    let geometry = parse(&with(json, "/materials", json!([plain, stated, near]))).expect("readable");
    assert_eq!((geometry.stated.len(), geometry.warnings.len()), (0, 1));
    assert!(
        geometry.warnings[0].plain().starts_with("town.gltf: 3 materials (first: `wall`) of white"),
        "{:?}",
        geometry.warnings
    );
}

/// 8 .glb files that are cut or have a wrong length are refused, and so are 9,000 instances of 12
/// triangles, beyond the limit.
#[test]
fn cut_or_oversized_files_are_refused() {
    let whole = glb(&with(scene(json!([{"mesh": 0}])), "/buffers/0/uri", Value::Null), &cube_bytes());
    let parse = |bytes: &[u8]| crate::formats::gltf::parse(bytes, Path::new("town.glb"), &asked()).map(drop);
    parse(&whole).expect("readable");
    for length in [4, 8, 12, 19, 20, 200, whole.len() - 1] {
        let message = parse(&whole[..length]).expect_err("cut").to_string();
        assert!(message.starts_with("town.glb: the file "), "{length}: {message}");
    }
    let mut long = whole.clone();
    long[12..16].fill(255);
    assert!(parse(&long).expect_err("long").to_string().contains("not a complete JSON chunk"));
    let mut old = whole.clone();
    old[4] = 1;
    assert!(parse(&old).expect_err("old").to_string().contains("found binary glTF 1"));

    // The limit in tests is 100,000 triangles.
    let nodes: Vec<Value> = std::iter::once(json!({"children": (1..=9_000).collect::<Vec<u32>>()}))
        .chain(std::iter::repeat_n(json!({"mesh": 0}), 9_000))
        .collect();
    let message = parse(scene(json!(nodes)).to_string().as_bytes()).expect_err("too many").to_string();
    assert_eq!(message, "the number of triangles of all instances in town.glb is 100008, the limit is 100000");
}
