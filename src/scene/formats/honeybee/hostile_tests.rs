//! Damaged models. In: models with errors of many kinds. Out: proof that each gets a message or a
//! warning, and that none panics.

use std::path::Path;

use serde_json::{Value, json};

use crate::formats::honeybee::*;
use crate::test_files::{assert_said, assert_too_many_corners};

const TWO_ROOMS: &str = include_str!("../../../../tests/data/honeybee/two_rooms.hbjson");

fn read_bytes(bytes: &[u8]) -> Result<Geometry> {
    super::parse(bytes, Path::new("m.hbjson"), &ReadOptions { reflectances: true, ..ReadOptions::default() })
}

/// Returns a model of one shade with any text as its boundary.
fn shade(boundary: &str) -> String {
    format!(r#"{{"type":"Model","orphaned_shades":[{{"identifier":"s","geometry":{{"boundary":{boundary}}}}}]}}"#)
}

/// Twenty-five unreadable files are refused with the place and the words at fault.
#[test]
fn unreadable_models_are_refused_with_a_reason() {
    let with = |pointer: &str, value: Value| {
        let mut model: Value = serde_json::from_str(TWO_ROOMS).expect("JSON");
        *model.pointer_mut(pointer).expect(pointer) = value;
        model.to_string()
    };
    let deep = "[".repeat(200_000);
    let cases: Vec<(String, &str)> = vec![
        (String::new(), "line 1: not a Honeybee model: EOF while parsing a value (column 0)"),
        ("[1,2]".into(), "[0]: invalid type: integer `1`, expected a string"),
        ("{}".into(), "missing field `type`"),
        (r#"{"type":"Model"}"#.into(), "no surface of the 0 rooms faces outdoors"),
        (r#"{"type":"Room"}"#.into(), "`type` is `Room`, not Model"),
        (r#"{"type":"Model","buildings":[]}"#.into(), "a Dragonfly model"),
        (r#"{"type":"Model"} more"#.into(), "trailing characters"),
        (
            r#"{"type":"Model","units":"Furlongs"}"#.into(),
            "units: unknown variant `Furlongs`, expected one of `Meters`",
        ),
        (format!(r#"{{"type":"Model","rooms":{deep}"#), "rooms[0][0]: invalid type: sequence, expected a string"),
        (format!(r#"{{"type":"Model","user_data":{deep}"#), "EOF while parsing"),
        (shade(&deep), "orphaned_shades[0].geometry.boundary[0][0]: invalid type: sequence, expected f64"),
        (
            format!(
                r#"{{"type":"Model","properties":{{"energy":{{"constructions":[{}"#,
                r#"{"type":"W","window_construction":"#.repeat(200)
            ),
            "recursion limit exceeded",
        ),
        (shade("7"), "orphaned_shades[0].geometry.boundary: invalid type: integer `7`, expected a sequence"),
        (shade(r#"[[0,0,0],[1,"abc",0],[0,1,0]]"#), "boundary[1][1]: invalid type: string \"abc\", expected f64"),
        (shade("[[0,0,0],[1,0],[0,1,0]]"), "boundary[1]: invalid length 2, expected an array of length 3"),
        (shade("[[0,0,0],[1,0,0,0],[0,1,0]]"), "boundary[1]: trailing characters"),
        (shade("[[0,0,0],[1,NaN,0],[0,1,0]]"), "boundary[1][1]: expected value"),
        (shade("[[0,0,0],[1,1e400,0],[0,1,0]]"), "boundary[1][1]: number out of range"),
        (shade("[[0,0,0],[1,null,0],[0,1,0]]"), "boundary[1][1]: invalid type: null, expected f64"),
        (with("/rooms/0/faces/1/geometry", json!({})), "rooms[0].faces[1].geometry: missing field `boundary`"),
        (with("/rooms/1/faces/0/identifier", json!(7)), "rooms[1].faces[0].identifier: invalid type: integer `7`"),
        (with("/rooms/0/faces/2/face_type", json!("Dome")), "rooms[0].faces[2].face_type: unknown variant `Dome`"),
        (
            with("/shade_meshes/0/geometry/faces/1", json!([0, 1])),
            "shade mesh `hill`: face 1 has 2 corners, not 3 or 4",
        ),
        (
            with("/shade_meshes/0/geometry/faces/1", json!([0, 1, 5])),
            "shade mesh `hill`: face 1 names vertex 5, but the 5 vertices",
        ),
        (
            with("/shade_meshes/0/geometry/faces/1", json!([0, 1, -1])),
            "geometry.faces[1][2]: invalid value: integer `-1`",
        ),
    ];
    let said = |text: &str| read_bytes(text.as_bytes()).map(drop).expect_err("refused").to_string();
    let other: Vec<(&str, String)> = cases
        .iter()
        .map(|(text, words)| (*words, said(text)))
        .filter(|(words, said)| !said.contains(words) || !said.starts_with("m.hbjson") || said.len() > 800)
        .collect();
    assert!(other.is_empty(), "{other:#?}");
    assert_eq!(cases.len(), 25);
}

/// A model cut at every 37th byte is refused as cut off, more than 400 times.
#[test]
fn a_model_cut_anywhere_is_refused_as_cut_off() {
    let mut refused = 0;
    for end in (0..TWO_ROOMS.len()).step_by(37) {
        let message = read_bytes(&TWO_ROOMS.as_bytes()[..end]).map(drop).expect_err("cut").to_string();
        assert!(
            message.contains("not a Honeybee model") && message.contains("the file was cut off"),
            "{end}: {message}"
        );
        refused += 1;
    }
    assert!(refused > 400, "{refused}");
}

/// Nine files with an oddity are read, and one warning or count says how it was handled.
#[test]
fn odd_models_are_read_with_one_warning() {
    let shade = |name: &str, boundary: Value, properties: Value| json!({"identifier": name, "geometry": {"boundary": boundary}, "properties": properties});
    let square = json!([[0, 0, 0], [1, 0, 0], [1, 1, 0]]);
    let modifier = |modifier: Value| json!({"radiance": {"modifier": modifier}});
    for (odd, faces, words) in [
        (shade("odd", json!([[0, 0, 0], [1, 0, 0]]), modifier(json!("m"))), 1, "LEFT 1 with fewer than three"),
        (shade("odd", json!([]), modifier(json!("m"))), 1, "LEFT 1 with fewer than three"),
        (
            shade("odd", json!([[0, 0, 0], [1, 0, 0], [0, 0, 1e10]]), modifier(json!("m"))),
            1,
            "LEFT 1 because they lie more",
        ),
        (shade("odd", square.clone(), json!({})), 2, "1 surfaces have neither modifier nor construction"),
        (
            shade("odd", square.clone(), json!({"radiance": null, "energy": {"construction": null}})),
            2,
            "1 surfaces have neither",
        ),
        (
            shade(
                "odd",
                square.clone(),
                modifier(json!({"type": "Plastic", "identifier": "bright", "r_reflectance": 3})),
            ),
            2,
            "1 reflectances or other optical properties lie outside 0 to 1; the nearest limit is used (first: `bright`)",
        ),
        (
            shade("odd", square.clone(), modifier(json!({"type": "Trans", "identifier": "t"}))),
            2,
            "1 modifiers transmit light",
        ),
        (
            shade(
                "odd",
                square.clone(),
                json!({"radiance": {"modifier": "m"}, "energy": {"transmittance_schedule": "gone"}}),
            ),
            2,
            "1 shades transmit light by a schedule that is not constant",
        ),
        (shade("odd", square.clone(), modifier(json!("m"))), 2, ""),
    ] {
        let model = json!({"type": "Model", "orphaned_shades": [odd, shade("plain", square.clone(), modifier(json!("m")))],
            "properties": {"radiance": {"modifiers": [{"type": "Plastic", "identifier": "m", "modifier": null}]}}});
        let geometry = read_bytes(model.to_string().as_bytes()).expect(words);
        assert_said(&geometry, faces, words);
    }
}

/// An outline of a million corners is read unchanged, and triangulation refuses it at the limit of
/// 65,536 corners.
#[test]
fn a_polygon_of_a_million_corners_is_refused() {
    let zigzag: Vec<String> = (0..1_000_000).map(|i| format!("[{},{},5]", i % 1000, i / 1000)).collect();
    let geometry = read_bytes(shade(&format!("[{}]", zigzag.join(","))).as_bytes()).expect("readable");
    assert_too_many_corners(&geometry);
}
