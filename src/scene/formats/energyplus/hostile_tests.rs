//! Damaged models. In: models with errors of many kinds. Out: proof that each gets a message or a
//! warning, and that none panics.

use std::path::Path;

use crate::formats::energyplus::*;
use crate::test_files::{assert_said, assert_too_many_corners};

fn read_bytes(bytes: &[u8], name: &str) -> Result<Geometry> {
    parse(bytes, Path::new(name), &ReadOptions { reflectances: true, ..ReadOptions::default() })
}

const HEAD: &str =
    "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World; Zone,Z; Construction,W,B; Material,B;\n";
const WALL: &str = "BuildingSurface:Detailed,Wall,Wall,W,Z,,Outdoors,,,,,4, 0,0,3, 0,0,0, 4,0,0, 4,0,3;\n";
const JSON_HEAD: &str = r#"{"Version":{"v":{"version_identifier":"25.2"}},"Zone":{"Z":{}},"Material":{"B":{}},"Construction":{"W":{"outside_layer":"B"}},
    "GlobalGeometryRules":{"g":{"starting_vertex_position":"UpperLeftCorner","vertex_entry_direction":"Counterclockwise","coordinate_system":"World"}}"#;

/// Twenty-nine unreadable files are refused with the place and the words at fault.
#[test]
fn unreadable_models_are_refused_with_a_reason() {
    let surface = |vertices: &str| {
        format!(
            r#"{JSON_HEAD},"BuildingSurface:Detailed":{{"S":{{"construction_name":"W","zone_name":"Z","surface_type":"Wall","outside_boundary_condition":"Outdoors","vertices":{vertices}}}}}}}"#
        )
    };
    let vertex = |x: &str| {
        let at = |x: &str, z: i32| {
            format!(r#"{{"vertex_x_coordinate":{x},"vertex_y_coordinate":0,"vertex_z_coordinate":{z}}}"#)
        };
        surface(&format!("[{},{},{}]", at("0", 0), at(x, 0), at("1", 1)))
    };
    let cases: Vec<(&str, String, &str)> = vec![
        ("m.epJSON", String::new(), "line 1: not a model in epJSON: EOF"),
        ("m.epJSON", "Version,25.2;".into(), "line 1: not a model in epJSON: expected value"),
        ("m.epJSON", "[1,2]".into(), "invalid type: sequence, expected an object of classes"),
        ("m.epJSON", "{}".into(), "no surface of the 0 objects"),
        ("m.epJSON", r#"{"Zone":7}"#.into(), "expected the Zone objects by name"),
        ("m.epJSON", r#"{"Zone":{"Z":[]}}"#.into(), "expected the fields of Zone `Z`"),
        ("m.epJSON", format!("{}{}", "[".repeat(200_000), "]".repeat(200_000)), "not a model"),
        ("m.epJSON", format!(r#"{{"a":{}"#, "[".repeat(200_000)), "EOF while parsing a list"),
        (
            "m.epJSON",
            format!(r#"{{"Building":{{"B":{{"north_axis":{}"#, "[".repeat(200_000)),
            "recursion limit exceeded",
        ),
        (
            "m.epJSON",
            vertex("\"abc\""),
            "vertex 2 of BuildingSurface:Detailed `S`: invalid type: string \"abc\", expected f64",
        ),
        ("m.epJSON", vertex("null"), "invalid type: null, expected f64"),
        ("m.epJSON", vertex("NaN"), "vertex 2 of BuildingSurface:Detailed `S`: expected"),
        ("m.epJSON", vertex("1e999"), "number out of range"),
        ("m.epJSON", vertex("1e30"), "beyond 1e9 metres"),
        (
            "m.epJSON",
            surface("[{\"vertex_x_coordinate\":1}]"),
            "vertex 1 of BuildingSurface:Detailed `S`: missing field `vertex_y_coordinate`",
        ),
        ("m.epJSON", surface("7"), "expected the vertices of BuildingSurface:Detailed `S`"),
        ("m.epJSON", surface("[]"), "no surface of the"),
        (
            "m.epJSON",
            format!(r#"{JSON_HEAD},"Building":{{"B":{{"north_axis":"NaN"}}}}}}"#),
            "Building `B`: `north_axis` is `NaN`",
        ),
        ("m.epJSON", format!(r#"{JSON_HEAD},"Building":{{"B":{{"north_axis":[1]}}}}}}"#), "`north_axis` is `a list`"),
        ("m.idf", String::new(), "no surface of the 0 objects"),
        ("m.idf", "! nothing\n! at all\n".into(), "no surface of the 0 objects"),
        (
            "m.idf",
            format!("{HEAD}{}", WALL.trim_end().trim_end_matches(';')),
            "line 2: the object that begins here does not end",
        ),
        ("m.idf", format!("{HEAD}Wall"), "line 2: the object that begins here does not end"),
        ("m.idf", format!("{HEAD}, 1, 2;"), "line 2: an object without a class begins here"),
        ("m.idf", format!("{HEAD}##include other.idf\n"), "line 2: found the macro `##include other.idf`"),
        (
            "m.idf",
            format!("{HEAD}{}", WALL.replace("4,0,0", "4,abc,0")),
            "line 2: BuildingSurface:Detailed `Wall`: a coordinate is `abc`",
        ),
        ("m.idf", format!("{HEAD}{}", WALL.replace("4,0,0", "4,inf,0")), "a coordinate is `inf`"),
        (
            "m.idf",
            format!("{HEAD}{}", WALL.replace(", 4,0,3;", ", 4,0;")),
            "line 2: BuildingSurface:Detailed `Wall`: 2 coordinates are left over after 3",
        ),
        ("m.idf", format!("{HEAD}Building,B,1e999;{WALL}"), "`north_axis` is `1e999`"),
    ];
    for (name, text, words) in &cases {
        let message = read_bytes(text.as_bytes(), name).map(drop).expect_err(words).to_string();
        assert!(message.contains(words) && message.starts_with(name), "{words}: {message}");
    }
    assert_eq!(cases.len(), 29);
}

/// Sixteen files with an oddity are read, and one warning or count says how it was handled.
#[test]
fn odd_models_are_read_with_one_warning() {
    let window = "FenestrationSurface:Detailed,Pane,Window,W,Wall,,,,1,4, 1,0,2, 1,0,1, 2,0,1, 2,0,2;\n";
    for (text, faces, words) in [
        (format!("{HEAD}{WALL}{WALL}"), 2, "1 surfaces have the name of another surface (first: `Wall`)"),
        (format!("{HEAD}{}", WALL.replace(",Z,,", ",Y,,")), 1, "1 surfaces belong to a zone that is not in the file"),
        (format!("{HEAD}{}", WALL.replace(",W,Z,", ",X,Z,")), 1, "1 constructions are not in the file"),
        (format!("{HEAD}{}", WALL.replace(",4, 0,0,3", ",3, 0,0,3")), 1, "1 surfaces state a wrong number of vertices"),
        (
            format!("{HEAD}{}", WALL.replace(",4, 0,0,3", ",1e9, 0,0,3")),
            1,
            "1 surfaces state a wrong number of vertices",
        ),
        (format!("{HEAD}{}", WALL.replace(",4, 0,0,3", ",autoCalculate, 0,0,3")), 1, ""),
        (format!("{HEAD}{WALL}{}", window.replace(",Wall,", ",Hall,")), 1, "LEFT 1 because the surface that they name"),
        (format!("{HEAD}{WALL}{}", window.replace("1,4,", "3,4,")), 2, "1 windows or doors have a multiplier"),
        (
            format!("{HEAD}{WALL}BuildingSurface:Detailed,Two,Wall,W,Z,,Outdoors,,,,,, 0,0,3, 0,0,0;"),
            1,
            "LEFT 1 with fewer",
        ),
        (format!("{HEAD}{WALL}Wall:Exterior,Less,W,Z,,180,90,0,0,0,-3,2;"), 1, "LEFT 1 with a length"),
        (format!("{HEAD}{WALL}Shading:Overhang,O,Nothing,1,90,0,0,1;"), 1, "LEFT 1 because the window"),
        (format!("{HEAD}{WALL}Shading:Zone:Detailed,S,Nothing,,3,0,0,1,0,0,2,1,0,1;"), 2, "1 shades name a surface"),
        (format!("{HEAD}{WALL}GeometryTransform,XY,1,2;"), 1, "1 GeometryTransform"),
        (format!("{HEAD}{WALL}Site:Location,S,91,0;"), 1, "1 locations have no valid latitude"),
        (format!("{HEAD}{WALL}Zone,Y,0,0,0,0,1,10;"), 1, "1 zones have a multiplier"),
        (format!("{HEAD}{}", WALL.replace(",Wall,W", ",Floor,W").replace("4,0,0, 4,0,3", "4,3,3, 4,3,3.5")), 1, ""),
    ] {
        let geometry = read_bytes(text.as_bytes(), "m.idf").expect(words);
        assert_said(&geometry, faces, words);
    }
}

/// CRLF, tabs, comments, bytes that are not UTF-8, fields over several lines and other case give
/// the same single face as plain text.
#[test]
fn line_ends_and_comments_change_nothing() {
    let wild = b"\xef\xbb\xbf!- caf\xe9 \r\nVERSION,\r\n\t25.2 ; !- Version Identifier\r\n zone,Z;Globalgeometryrules , upperleftcorner,\r\n\
        COUNTERCLOCKWISE,\tWORLD;\r\nUnknown:Class,1,2,\xff;\r\nbuildingsurface:DETAILED, W\xe4nd, ! name\r\n wall, W, z,\r\n ,outdoors,,,\r\n,,\
        4,!- Number of Vertices\r\n0,0,3, !- X,Y,Z ==> Vertex 1 {m}\r\n0,0,0,\r\n4,0,0,4,0,\r\n3\r\n;\r\n";
    let geometry = read_bytes(wild, "m.IDF").expect("readable");
    assert_eq!((geometry.face_count(), geometry.vertices.len()), (1, 4));
    assert_eq!(geometry.objects.as_slice(), ["W\u{fffd}nd"]);
    assert_eq!(geometry.faces().next().map(|face| face.line), Some(7));
    let bare: Vec<u8> = wild.iter().map(|&byte| if byte == b'\n' { b' ' } else { byte }).collect();
    assert_eq!(read_bytes(&bare, "m.idf").expect("readable").face_count(), 1);
}

/// A polygon of a million corners is read unchanged, and triangulation refuses it at the limit of
/// 65,536 corners.
#[test]
fn a_polygon_of_a_million_corners_is_refused() {
    let zigzag: String = (0..1_000_000).map(|i| format!(",{},{},5", i % 1000, i / 1000)).collect();
    let text = format!("{HEAD}Shading:Site:Detailed,Round,,{zigzag};");
    let geometry = read_bytes(text.as_bytes(), "m.idf").expect("readable");
    assert_too_many_corners(&geometry);
}

/// Six texts are told apart: a model is recognised by its classes, not by words that other formats
/// have too.
#[test]
fn a_model_is_recognised_by_its_classes() {
    for (text, is) in [
        (r#"{"AirLoopHVAC":{"a":{"b":[1]}},"Building":{"x":{"north_axis":1}}}"#, true),
        (r#"{"Version":{"v":{}}, broken"#, true),
        (r#"{"type":"CityJSON","version":"2.0","CityObjects":{}}"#, false),
        (r#"{"asset":{"version":"2.0"},"Building":"no"}"#, false),
        (r#"[{"Building":{}}]"#, false),
        ("", false),
    ] {
        assert_eq!(epjson::looks_like(text.as_bytes()), is, "{text}");
    }
}
