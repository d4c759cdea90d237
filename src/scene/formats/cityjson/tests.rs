//! In: small city models written for the tests, valid and damaged. Out: proof of what is read,
//! chosen, left out and refused.

use std::path::Path;

use glam::DVec3;

use crate::formats::ReadOptions;
use crate::formats::cityjson::parse;
use crate::geometry::Geometry;
use crate::polygon::triangulate;
use crate::test_files::faces;
use heliotile_core::error::Result;
use heliotile_place::reference::Reference;

/// A box of 10 x 10 x 5 units as a Solid, its six faces turned outward: floor, roof and four walls.
const BOX: &str = "[[[[0,3,2,1]],[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],[[3,0,4,7]]]]";
const VERTICES: &str = "[0,0,0],[10,0,0],[10,10,0],[0,10,0],[0,0,5],[10,0,5],[10,10,5],[0,10,5]";
const TRANSFORM: &str = r#""transform":{"scale":[1,1,1],"translate":[100,200,3]}"#;

/// Returns a document of version 2.0 with the objects.
fn model(objects: &str) -> String {
    format!(r#"{{"type":"CityJSON","version":"2.0",{TRANSFORM},"CityObjects":{{{objects}}},"vertices":[{VERTICES}]}}"#)
}

/// Returns a document with a Building `b` that has the geometries.
fn building(geometry: &str) -> String {
    model(&format!(r#""b":{{"type":"Building","geometry":[{geometry}]}}"#))
}

fn solid(lod: &str) -> String {
    format!(r#"{{"type":"Solid","lod":"{lod}","boundaries":{BOX}}}"#)
}

fn read_as(text: &str, name: &str, lod: Option<&str>) -> Result<Geometry> {
    parse(
        text.as_bytes(),
        Path::new(name),
        &ReadOptions { reflectances: true, lod: lod.map(str::to_owned), ..ReadOptions::default() },
    )
}

fn read(text: &str) -> Geometry {
    read_as(text, "town.city.json", None).expect(text)
}

fn materials(geometry: &Geometry) -> Vec<&str> {
    faces(geometry).into_iter().map(|face| face.1).collect()
}

fn left_out(geometry: &Geometry) -> usize {
    geometry.left_out.values().sum()
}

/// The six faces of a box without semantics are named by tilt, moved by the transform, and belong
/// to the object.
#[test]
fn a_box_without_semantics_is_named_by_tilt() {
    let geometry = read(&building(&solid("2")));
    let names = ["GroundSurface", "RoofSurface", "WallSurface", "WallSurface", "WallSurface", "WallSurface"];
    assert_eq!(materials(&geometry), names);
    assert!(faces(&geometry).iter().all(|face| face.0 == "b"));
    assert_eq!((geometry.vertices[0], geometry.vertices[6]), (DVec3::new(100., 200., 3.), DVec3::new(110., 210., 8.)));
    assert_eq!((geometry.reference, geometry.warnings.len(), left_out(&geometry)), (None, 0, 0));
}

/// Semantics name 4 of 6 faces. A null, or a null for a whole shell, leaves faces to the object's
/// type. The closure surface is left out and counted.
#[test]
fn semantics_name_faces_before_the_object_type() {
    let shape = |values: &str| {
        format!(
            r#"{{"type":"Solid","lod":2,"boundaries":{BOX},"semantics":{{"values":{values},"surfaces":[
            {{"type":"GroundSurface"}},{{"type":"+ThermalRoof"}},{{"type":"ClosureSurface"}},{{"type":"Window","parent":2}}]}}}}"#
        )
    };
    let bridge = |values: &str| read(&model(&format!(r#""b":{{"type":"Bridge","geometry":[{}]}}"#, shape(values))));
    let geometry = bridge("[[0,1,2,3,null,null]]");
    assert_eq!(materials(&geometry), ["GroundSurface", "ThermalRoof", "Window", "Bridge", "Bridge"]);
    assert_eq!(left_out(&geometry), 1);
    assert_eq!(materials(&bridge("[null]")), ["Bridge"; 6]);
    assert_eq!(materials(&bridge("null")), ["Bridge"; 6]);
    // A building's faces without a value are named by tilt.
    assert_eq!(materials(&read(&building(&shape("[[3,3,3,3,3,null]]"))))[5], "WallSurface");
}

/// The finest of three levels of detail is read, 2.10 before 2.2; or the one asked for, or the
/// finest below it, or none.
#[test]
fn the_finest_or_requested_level_is_read() {
    let wall = |lod: &str| format!(r#"{{"type":"MultiSurface","lod":"{lod}","boundaries":[[[0,1,5,4]]]}}"#);
    let text = building(&[solid("2.2"), wall("2.10"), solid("1"), wall("2.10")].join(","));
    for (asked, faces, others) in
        [(None, 2, 2), (Some("2.2"), 6, 3), (Some("2"), 6, 3), (Some("2.10"), 2, 2), (Some("3"), 2, 2)]
    {
        let geometry = read_as(&text, "town.json", asked).expect("readable");
        assert_eq!((geometry.face_count(), left_out(&geometry)), (faces, others), "{asked:?}");
    }
    let message = read_as(&text, "town.json", Some("0.3")).expect_err("nothing so coarse").to_string();
    assert!(message.contains("that the file holds: 1, 2.2, 2.10 (requested: 0.3)"), "{message}");
    let message = read_as(&text, "town.json", Some("fine")).expect_err("no level").to_string();
    assert!(message.contains("level of detail `fine` is not a number"), "{message}");
    // Points do not count as finer geometry.
    let points = building(&[solid("1"), r#"{"type":"MultiPoint","lod":"3","boundaries":[1,2]}"#.into()].join(","));
    assert_eq!((read(&points).face_count(), left_out(&read(&points))), (6, 1));
}

/// A building's coarser geometry is left out where its parts are finer. A main part of equal
/// detail, an installation and a finer parent stay.
#[test]
fn geometry_coarser_than_the_parts_is_left_out() {
    for (parent, kind, child, faces, relation) in [
        ("1", "BuildingPart", "2.2", 6, r#""parents":["b"],"#),
        ("1", "BuildingPart", "2.2", 6, ""),
        ("2", "BuildingPart", "2", 12, r#""parents":["b"],"#),
        ("2.2", "BuildingPart", "1", 12, r#""parents":["b"],"#),
        ("1", "BuildingInstallation", "3", 12, r#""parents":["b"],"#),
        ("1", "BridgePart", "2", 6, r#""parents":["b","b","nobody"],"#),
    ] {
        let [low, high] = [parent, child].map(solid);
        let child = format!(r#""c":{{"type":"{kind}",{relation}"geometry":[{high}]}}"#);
        let text = model(&format!(r#"{child},"b":{{"type":"Building","children":["c","c"],"geometry":[{low}]}}"#));
        assert_eq!(read(&text).face_count(), faces, "{parent} {kind} {child}");
    }
    let cycle = format!(r#""b":{{"type":"BuildingPart","parents":["b"],"geometry":[{}]}}"#, solid("2"));
    assert_eq!(read(&model(&cycle)).face_count(), 6);
}

/// An outline with a hole has 100 - 4 = 96 m2, a solid with an inner shell 400 + 32 m2, two solids
/// twice that.
#[test]
fn holes_and_shells_have_the_right_area() {
    let area = |geometry: &Geometry| -> f64 {
        let cut = triangulate(geometry).expect("within limits");
        let corner = |corner: u32| geometry.vertices[corner as usize];
        cut.triangles
            .iter()
            .map(|t| {
                0.5 * (corner(t.corners[1]) - corner(t.corners[0]))
                    .cross(corner(t.corners[2]) - corner(t.corners[0]))
                    .length()
            })
            .sum()
    };
    let inner = "[2,2,0],[4,2,0],[4,4,0],[2,4,0],[2,2,3],[4,2,3],[4,4,3],[2,4,3]";
    let shell = BOX.trim_start_matches('[').trim_end_matches(']');
    let shell = format!("[[[{shell}]]]");
    let cavity = "[[[8,9,10,11]],[[12,15,14,13]],[[8,12,13,9]],[[9,13,14,10]],[[10,14,15,11]],[[11,15,12,8]]]";
    for (kind, boundaries, expected) in [
        ("MultiSurface", "[[[0,1,2,3],[8,11,10,9]]]".to_owned(), 96.0),
        ("CompositeSurface", "[[[0,1,2,3],[8,11],[8,11,10,9]]]".into(), 96.0),
        ("Solid", format!("[{shell},{cavity}]"), 400.0 + 32.0),
        ("MultiSolid", format!("[[{shell},{cavity}],[{shell}]]"), 800.0 + 32.0),
        ("CompositeSolid", format!("[[{cavity}],[{cavity}]]"), 64.0),
    ] {
        let shape = format!(r#"{{"type":"{kind}","lod":"2","boundaries":{boundaries}}}"#);
        let text = building(&shape).replace(VERTICES, &format!("{VERTICES},{inner}"));
        assert!((area(&read(&text)) - expected).abs() < 1e-9, "{kind}: {}", area(&read(&text)));
    }
}

/// A template stands twice, turned, stretched and mirrored by its matrix; the transform does not
/// apply to its 4 vertices.
#[test]
fn templates_are_placed_by_their_matrix() {
    let instance = |matrix: &str| {
        let place =
            format!(r#"{{"type":"GeometryInstance","template":0,"boundaries":[6],"transformationMatrix":[{matrix}]}}"#);
        let text = model(&format!(r#""t":{{"type":"SolitaryVegetationObject","geometry":[{place},{place}]}}"#));
        let template = r#""geometry-templates":{"templates":[{"type":"MultiSurface","lod":"3","boundaries":[[[9,1,2,3]]]}],
            "vertices-templates":[[9e9,0,0],[1,0,0],[1,2,0],[0,2,0],[5,5,5],[5,5,5],[5,5,5],[5,5,5],[5,5,5],[0,0,0]]},"#;
        text.replacen(r#""CityObjects""#, &format!("{template}\"CityObjects\""), 1)
    };
    let at = DVec3::new(110., 210., 8.);
    let offset = |matrix: &str| if matrix.contains("0.5") { DVec3::new(0.5, 0.0, -1.0) } else { DVec3::ZERO };
    for (matrix, second, mirrored) in [
        ("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1", [1., 0., 0.], false),
        ("0,-2,0,0.5, 2,0,0,0, 0,0,2,-1, 0,0,0,1", [0.5, 2., -1.], false),
        ("-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1", [-1., 0., 0.], true),
    ] {
        let geometry = read(&instance(matrix));
        assert_eq!((geometry.face_count(), geometry.vertices.len()), (2, 8 + 2 * 4));
        assert_eq!(materials(&geometry), ["SolitaryVegetationObject"; 2]);
        let corners = geometry.faces().next().expect("a face").corners().to_vec();
        assert!(geometry.vertices.contains(&(at + DVec3::from(second))), "{matrix}: {:?}", geometry.vertices);
        // Mirroring reverses the ring: the first corner in the file is the last one.
        assert_eq!(geometry.vertices[corners[if mirrored { 3 } else { 0 }] as usize], at + offset(matrix));
        let at = |i: usize| geometry.vertices[corners[i] as usize];
        assert!((at(1) - at(0)).cross(at(2) - at(1)).z > 0.0, "still faces up: {matrix}");
    }
    for (from, to, said) in [
        ("\"template\":0", "\"template\":1", "object `t`: its `template` is 1, but the 1 templates"),
        ("\"template\":0", "\"template\":-1", "object `t`: invalid value"),
        ("\"template\":0,", "", "object `t`: its instance of a template has no `template`"),
        ("0,0,0,1]", "0,0,1]", "object `t`: its `transformationMatrix` has 15 numbers, not 16"),
        ("0,0,0,1]", "0,0,1,1]", "the last row of its `transformationMatrix` is [0.0, 0.0, 1.0, 1.0]"),
        ("[1,0,0,0,", "[1e300,0,0,0,", "object `t`: its template would have a vertex at"),
        ("[1,0,0,0,", "[1e999,0,0,0,", "object `t`: number out of range"),
        ("\"boundaries\":[6]", "\"boundaries\":[8]", "object `t`: its boundaries name vertex 8 of 8"),
        ("\"boundaries\":[6]", "\"boundaries\":[[6]]", "not one vertex number"),
        ("[[[9,1,2,3]]]", "[[[10,1,2,3]]]", "template 0: its boundaries name vertex 10 of 10"),
        ("[[[9,1,2,3]]]", "[[9,1,2,3]]", "object `t`: boundaries hold vertex numbers 2 arrays deep in place of 3"),
        ("\"MultiSurface\"", "\"GeometryInstance\"", "template 0: it is an instance"),
        ("[9e9,0,0]", "[9e9,0]", "geometry-templates: vertex 0: invalid length 2"),
    ] {
        let text = instance("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1");
        let broken = text.replace(from, to);
        assert_ne!(text, broken);
        let message = read_as(&broken, "town.city.json", None).expect_err(to).to_string();
        assert!(message.contains(said), "{to}: {message}");
    }
}

/// A file of 0.7 MB that repeats a template of 100,000 corners 1400 times is refused: it expands to
/// more than it may.
#[test]
fn a_template_bomb_ends_at_the_limit() {
    let ring = (0..100_000).map(|i| (i % 8).to_string()).collect::<Vec<_>>().join(",");
    let place = r#"{"type":"GeometryInstance","template":0,"boundaries":[0],"transformationMatrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}"#;
    let places = vec![place; 1400].join(",");
    let template = format!(
        r#""geometry-templates":{{"templates":[{{"type":"MultiPoint","lod":"3","boundaries":[{ring}]}},
        {{"type":"MultiSurface","lod":"3","boundaries":[[[{ring}]]]}}],"vertices-templates":[{VERTICES}]}},"#
    );
    let text = building(&places.replace("\"template\":0", "\"template\":1"));
    let text = text.replacen(r#""CityObjects""#, &format!("{template}\"CityObjects\""), 1);
    let message = read_as(&text, "town.city.json", None).expect_err("too much").to_string();
    assert!(message.contains("town.city.json: its instances of templates expand to more than 512 MiB"), "{message}");
}

/// A sequence gives each of 2 features its own vertices and line; empty lines and a byte order mark
/// are ignored.
#[test]
fn features_of_a_sequence_have_their_own_vertices() {
    let header = format!(
        r#"{{"type":"CityJSON","version":"1.1",{TRANSFORM},"metadata":{{"referenceSystem":"urn:ogc:def:crs:EPSG::7415"}},"CityObjects":{{}},"vertices":[]}}"#
    );
    let feature = |id: &str| {
        let shape = solid("1.2");
        format!(
            r#"{{"type":"CityJSONFeature","id":"{id}","CityObjects":{{"{id}":{{"type":"Building","geometry":[{shape}]}}}},"vertices":[{VERTICES}]}}"#
        )
    };
    let text = format!("\u{feff}{header}\r\n\r\n{}\n{}\n", feature("a"), feature("b"));
    let geometry = read_as(&text, "town.city.jsonl", None).expect("readable");
    assert_eq!((geometry.face_count(), geometry.vertices.len()), (12, 16));
    assert_eq!(geometry.reference, Some(Reference::Epsg(7415)));
    assert_eq!(geometry.objects.as_slice(), ["a", "b"]);
    assert_eq!(geometry.faces().map(|face| face.line).collect::<Vec<_>>(), [vec![3; 6], vec![4; 6]].concat());
    assert_eq!(geometry.faces().last().expect("a face").corners(), [11, 8, 12, 15]);
    // A single object in a file named like a sequence is its own header.
    assert_eq!(read_as(&building(&solid("1")), "town.JSONL", None).expect("readable").face_count(), 6);
    for (text, line, said) in [
        (feature("a"), Some(1), "the first line is a CityJSONFeature"),
        (format!("{header}\n{}\n{header}\n", feature("a")), Some(3), "`type` is `CityJSON`, not CityJSONFeature"),
        (format!("{header}\n{}\n{}", feature("a"), &feature("b")[..150]), Some(3), "ends too early"),
        (
            format!("{header}\n{}\n", feature("a").replace("[0,3,2,1]", "[0,3,2,8]")),
            Some(2),
            "object `a`: its boundaries name vertex 8 of 8",
        ),
        (
            format!("{header}\n{}\n", feature("a").replace("[10,0,0]", "[10,null,0]")),
            Some(2),
            "vertex 1: invalid type: null",
        ),
        (format!("{header}\n{}\n", feature("a").replace("[10,0,0]", "[2e9,0,0]")), Some(2), "vertex 1 lies at"),
        (format!("{header}\n{}\n", feature("a").replace(BOX, "[[[0,1,2]]]")), Some(2), "3 arrays deep in place of 4"),
        (format!("{header}\nnull\n"), Some(2), "invalid type: null"),
        (header.clone(), None, "holds no city objects"),
        ("\n \n".into(), None, "the file is empty"),
    ] {
        let message = read_as(&text, "town.city.jsonl", None).expect_err(said).to_string();
        let place = line.map_or("town.city.jsonl: ".to_owned(), |line| format!("town.city.jsonl, line {line}: "));
        assert!(message.starts_with(&place) && message.contains(said), "{said}: {message}");
    }
}

/// Version 1.0 needs no transform and writes levels as numbers; metres stay exact.
#[test]
fn version_1_0_needs_no_transform() {
    let text =
        building(&solid("2")).replace(&format!("{TRANSFORM},"), "").replace("\"2.0\"", "\"1.0\"").replace("\"2\"", "2");
    assert!(text.contains("\"lod\":2,"));
    let geometry = read(&text.replace("[10,10,5]", "[10.125,1e1,5.0]"));
    assert_eq!(geometry.vertices[6], DVec3::new(10.125, 10.0, 5.0));
}

/// Odd pieces are left out and counted by reason, 4 reasons here, and the rest of the object stays.
#[test]
fn odd_pieces_are_left_out_by_reason() {
    let group = format!(r#""g":{{"type":"CityObjectGroup","geometry":[{}]}},"#, solid("0"));
    let odd = r#"{"type":"MultiSurface","lod":"2","boundaries":[[[0,1]],[],[[]],[[0,1,2,3],[1]],[[0,1,0,1]]]}"#;
    let text = building(&[odd, r#"{"type":"Blob","lod":"2","boundaries":[]}"#].join(","));
    let geometry = read(&text.replacen("\"b\":", &format!("{group}\"b\":"), 1));
    assert_eq!((geometry.face_count(), geometry.left_out.len(), left_out(&geometry)), (2, 4, 6));
    assert_eq!(geometry.objects.as_slice(), ["b"]);
    assert_eq!(triangulate(&geometry).expect("within limits").degenerate_faces, 1);
}

/// A face of a million corners is read, and triangulation refuses it by its object's name. A ring
/// that touches itself is cut into its 2 triangles.
#[test]
fn long_rings_are_refused_and_touching_ones_cut() {
    let ring = vec!["0,1,2,3"; 250_000].join(",");
    let geometry = read(&building(&format!(r#"{{"type":"MultiSurface","lod":"2","boundaries":[[[{ring}]]]}}"#)));
    let message = triangulate(&geometry).expect_err("too long").to_string();
    assert!(message.contains("corners of a face of `b` is 1000000, the limit is 65536"), "{message}");
    let shape = r#"{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,8,2,3,8]]]}"#;
    let geometry = read(&building(shape).replace(VERTICES, &format!("{VERTICES},[5,5,0]")));
    let cut = triangulate(&geometry).expect("within limits");
    assert_eq!((cut.triangles.len(), cut.degenerate_faces), (2, 0));
}

/// One of three objects, whose semantics name too few surfaces, is left out by name, and the 12
/// faces of the others stay. Two wrong objects are counted, and both are named.
#[test]
fn a_wrong_object_costs_no_other() {
    let object = |name: &str, values: &str| {
        let semantics = format!(r#""semantics":{{"surfaces":[{{"type":"RoofSurface"}}],"values":{values}}}"#);
        format!(
            r#""{name}":{{"type":"Building","geometry":[{{"type":"Solid","lod":"2","boundaries":{BOX},{semantics}}}]}}"#
        )
    };
    let (good, short, far) = ("[[0,0,0,0,0,0]]", "[[0]]", "[[0,0,0,0,0,7]]");
    let geometry = read(&model(&[object("a", good), object("b", short), object("c", good)].join(",")));
    assert_eq!(geometry.face_count(), 12);
    let [said] = geometry.warnings.as_slice() else { panic!("{:?}", geometry.warnings) };
    assert!(said.contains("1 city object left out") && said.contains("object `b`: the values"), "{said:?}");
    let geometry = read(&model(&[object("a", far), object("b", short), object("c", good)].join(",")));
    let said = geometry.warnings.iter().map(|said| said.plain()).collect::<String>();
    assert!(said.contains("2 city objects left out") && said.contains("`a`") && said.contains("`b`"), "{said}");
    assert_eq!(faces(&geometry).iter().filter(|face| face.0 == "c").count(), 6);
}

/// A service's answer is read as its feature or features: 6 faces of one, 12 of two, with one
/// header for each or one for all. The metadata state the place.
#[test]
fn answers_of_services_are_read_as_features() {
    let metadata = format!(
        r#"{{"type":"CityJSON","version":"2.0",{TRANSFORM},"metadata":{{"referenceSystem":"EPSG:7415"}},"CityObjects":{{}},"vertices":[]}}"#
    );
    let feature = |name: &str| {
        let objects = format!(r#""{name}":{{"type":"Building","geometry":[{}]}}"#, solid("2"));
        format!(r#"{{"type":"CityJSONFeature","id":"{name}","CityObjects":{{{objects}}},"vertices":[{VERTICES}]}}"#)
    };
    let item =
        |name: &str| format!(r#"{{"id":"{name}","feature":{},"metadata":{metadata},"links":[]}}"#, feature(name));
    for (text, found) in [
        (item("a"), 6),
        (format!(r#"{{"type":"Feature","feature":{},"metadata":{metadata}}}"#, feature("a")), 6),
        (
            format!(
                r#"{{"type":"FeatureCollection","features":[{},{}],"metadata":{metadata}}}"#,
                feature("a"),
                feature("b")
            ),
            12,
        ),
        (format!(r#"{{"type":"FeatureCollection","features":[{},{}]}}"#, item("a"), item("b")), 12),
    ] {
        let geometry = read_as(&text, "a.json", None).expect(&text);
        assert_eq!((geometry.face_count(), geometry.reference), (found, Some(Reference::Epsg(7415))));
        assert_eq!(geometry.vertices[6], DVec3::new(110., 210., 8.));
    }
}

/// Each of more than 30 refusals names the file, the line where there is one, and what is wrong.
#[test]
fn refusals_name_file_line_and_fault() {
    let sound = building(&solid("2"));
    let with = |from: &str, to: &str| {
        let broken = sound.replacen(from, to, 1);
        assert_ne!(broken, sound, "{from}");
        broken
    };
    let shape = |kind: &str, boundaries: &str, more: &str| {
        building(&format!(r#"{{"type":"{kind}","lod":"2","boundaries":{boundaries}{more}}}"#))
    };
    let values = |values: &str| {
        shape("Solid", BOX, &format!(r#","semantics":{{"surfaces":[{{"type":"RoofSurface"}}],"values":{values}}}"#))
    };
    for (text, line, said) in [
        (String::new(), None, "the file is empty"),
        ("{\"type\":\n\"CityJSON\",\n oops}".into(), Some(3), "key must be a string"),
        (sound[..sound.len() - 9].to_owned(), Some(1), "ends too early"),
        (format!("{sound}\n{sound}"), Some(2), "`type` is `CityJSON`, not CityJSONFeature"),
        ("[]".into(), None, "a JSON list"),
        ("{}".into(), None, "holds nothing"),
        ("7".into(), Some(1), "expected a CityJSON object"),
        (r#"{"Version":{},"Building":{"B":{}},"Zone":{}}"#.into(), None, "EnergyPlus model (epJSON)"),
        (r#"{"type":"FeatureCollection","features":[]}"#.into(), None, "GeoJSON"),
        (r#"{"asset":{"version":"2.0"},"meshes":[]}"#.into(), None, "glTF"),
        (r#"{"metadata":"x","vertices":{}}"#.into(), None, "begins with `metadata`, `vertices`"),
        (with("\"CityJSON\"", "\"CityGML\""), None, "`type` is `CityGML`"),
        (with("\"CityJSON\"", "3"), None, "`type` is ``"),
        (with("\"2.0\"", "\"0.8\""), None, "found `0.8`, this release supports 1.0"),
        (with(&format!("{TRANSFORM},"), ""), None, "`transform` is missing, which CityJSON 2.0 requires"),
        (with("[1,1,1]", "[1,0,1]"), None, "`transform` has the scale [1, 0, 1]"),
        (with("[1,1,1]", "[1,1]"), Some(1), "transform: invalid length 2"),
        (with("[1,1,1]", "[1,1e999,1]"), Some(1), "transform: number out of range"),
        (with("[1,1,1]", "[1e9,1e9,1e9]"), None, "vertex 1 lies at"),
        (with("[10,0,0]", "[10,0]"), Some(1), "vertex 1: invalid length 2"),
        (with("[10,0,0]", "[10,0,0,0]"), Some(1), "vertex 1: "),
        (with("[10,0,0]", "[1e999,0,0]"), Some(1), "vertex 1: number out of range"),
        (with("[10,0,0]", "[\"10\",0,0]"), Some(1), "vertex 1: invalid type: string"),
        (with("[10,0,0]", "[NaN,0,0]"), Some(1), "vertex 1: expected"),
        (with("[0,3,2,1]", "[0,3,2,8]"), None, "object `b`: its boundaries name vertex 8 of 8 vertices"),
        (with("[0,3,2,1]", "[0,3,2,-1]"), Some(1), "object `b`: invalid type: integer `-1`"),
        (with("[0,3,2,1]", "[0,3,2,1.5]"), Some(1), "object `b`: invalid type: floating point `1.5`"),
        (with("[0,3,2,1]", "[[[0,3,2,1]]]"), Some(1), "object `b`: arrays are nested more than 5 deep"),
        (shape("MultiSurface", BOX, ""), None, "object `b`: boundaries are nested more than 3 arrays deep"),
        (shape("MultiSolid", BOX, ""), None, "object `b`: boundaries hold vertex numbers 4 arrays deep in place of 5"),
        (building(r#"{"type":"Solid","lod":"2"}"#), None, "object `b`: its Solid has no `boundaries`"),
        (values("[0,0,0,0,0,0]"), None, "object `b`: the values of its semantics are not one for each surface"),
        (values("[[0,0,0,0,0]]"), None, "object `b`: the values of its semantics are not one for each surface"),
        (values("[[0,0,0,0,0,1]]"), None, "object `b`: the values of its semantics name surface 1 of 1"),
        (model(""), None, "holds no city objects"),
        (building(""), None, "none of the 1 city objects has a surface"),
        (with("\"Building\"", "null"), Some(1), "object `b`: invalid type: null"),
        (with("\"lod\":\"2\"", "\"lod\":\"two\""), Some(1), "object `b`: invalid value: string \"two\""),
        (format!("{}1{}", "[".repeat(200), "]".repeat(200)), None, "a JSON list"),
        (
            with("\"CityObjects\"", r#""metadata":{"referenceSystem":"EPSG:4326"},"CityObjects""#),
            None,
            "coordinates are degrees",
        ),
    ] {
        let message = read_as(&text, "town.city.json", None).expect_err(said).to_string();
        let place = line.map_or("town.city.json".to_owned(), |line| format!("town.city.json, line {line}: "));
        assert!(message.contains(&place) && message.contains(said), "{said}: {message}");
        assert!(line.is_some() || !message.contains("town.city.json, line"), "{message}");
    } // Members that no reader needs are skipped, however deep they are.
    let deep =
        with("\"CityObjects\"", &format!("\"x\":{}1{},\"CityObjects\"", "[".repeat(100_000), "]".repeat(100_000)));
    assert_eq!(read(&deep).face_count(), 6);
}

/// A roof of level 2 beside a solid of level 1 gives way to the solid with its 6 faces and a
/// warning, unless level 2 is asked for. With one wall level 2 is read.
#[test]
fn a_roof_without_walls_gives_way_to_a_solid() {
    let surfaces = |faces: &str| format!(r#"{{"type":"MultiSurface","lod":"2","boundaries":[{faces}]}}"#);
    let both = |faces: &str| building(&format!("{},{}", solid("1"), surfaces(faces)));
    let roof = both("[[4,5,6,7]]");
    let geometry = read(&roof);
    assert_eq!((geometry.face_count(), left_out(&geometry)), (6, 1));
    let [doubt] = geometry.doubts.as_slice() else { panic!("{:?}", geometry.doubts) };
    assert!(doubt.plain().starts_with("1 building (`b`) read in a coarser level of detail"), "{doubt:?}");
    let asked = read_as(&roof, "town.city.json", Some("2")).expect("readable");
    assert_eq!((asked.face_count(), asked.doubts.len()), (1, 0));
    let walled = read(&both("[[4,5,6,7]],[[0,1,5,4]]"));
    assert_eq!((walled.face_count(), walled.doubts.len()), (2, 0));
    assert_eq!(read(&building(&surfaces("[[4,5,6,7]]"))).face_count(), 1);
}

/// A house that was torn down in 2018 and its part are left out; the one built in its place stays.
#[test]
fn buildings_that_no_longer_stand_are_left_out() {
    let house =
        |id: &str, kind: &str, more: &str| format!(r#""{id}":{{"type":"{kind}",{more}"geometry":[{}]}}"#, solid("1"));
    let gone = r#""attributes":{"yearOfDemolition":2018},"children":["c"],"#;
    let objects =
        [house("a", "Building", gone), house("c", "BuildingPart", r#""parents":["a"],"#), house("b", "Building", "")]
            .join(",");
    let geometry = read(&model(&objects));
    assert_eq!(
        (geometry.objects.as_slice(), left_out(&geometry)),
        (&["b".to_owned()][..], 2),
        "{:?}",
        geometry.left_out
    );
}
