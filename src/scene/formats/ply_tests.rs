//! In: PLY files, most of them damaged. Out: proof that they are read correctly, or refused with a
//! message.

use super::*;
use crate::polygon::triangulate;
use crate::test_files::{area_and_volume, cube};

fn parse(bytes: &[u8]) -> Result<Geometry> {
    super::parse(bytes, Path::new("town.ply"))
}

const QUADS: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn head(format: &str, float: &str, count: &str, index: &str, name: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nobj_info num_cols 512\nelement camera 1\nproperty int id\n\
         property list uchar short tags\nelement vertex 8\nproperty uchar red\nproperty {float} x\nproperty {float} y\n\
         property list int float weights\nproperty {float} z\nelement face 6\nproperty list {count} {index} {name}\n\
         property uchar red\nelement edge 1\nproperty int a\nend_header\n"
    )
}

/// The data of the cube in either byte order; `float` is 4 or 8 bytes, `index` 1, 2 or 4.
fn binary(big: bool, float: usize, count: usize, index: usize) -> Vec<u8> {
    let mut bytes = vec![];
    let mut put = |mut little: Vec<u8>| {
        if big {
            little.reverse();
        }
        bytes.extend(little);
    };
    let whole = |value: u32, size: usize| value.to_le_bytes()[..size].to_vec();
    [whole(7, 4), whole(2, 1), whole(5, 2), whole(6, 2)].into_iter().for_each(&mut put);
    for vertex in cube().0 {
        let real = |value: f64| match float {
            4 => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        [whole(200, 1), real(vertex.x), real(vertex.y), whole(1, 4), whole(9, 4), real(vertex.z)]
            .into_iter()
            .for_each(&mut put);
    }
    for quad in QUADS {
        put(whole(4, count));
        quad.into_iter().for_each(|corner| put(whole(corner, index)));
        put(whole(255, 1));
    }
    put(whole(0, 4));
    bytes
}

/// A cube of 6 quadrangles has 6 m2 and 1 m3 as text and in both byte orders, with other properties
/// and elements in between.
#[test]
fn three_encodings_give_the_same_cube() {
    let mut files = vec![];
    for (big, order) in [(false, "binary_little_endian"), (true, "binary_big_endian")] {
        for (float, real) in [(4, "float"), (8, "float64")] {
            for (index, whole) in [(1, "int8"), (2, "ushort"), (4, "int"), (4, "uint32")] {
                let short = head(order, real, "uchar", whole, "vertex_index");
                files.push([short.into_bytes(), binary(big, float, 1, index)].concat());
                let long = head(order, real, "uint", whole, "vertex_indices");
                files.push([long.replace('\n', "\r\n").into_bytes(), binary(big, float, 4, index)].concat());
            }
        }
    }
    let vertices = cube().0.map(|v| format!("9 {} {:e}\t1 .5 {}\n", v.x, v.y, v.z)).concat();
    let faces = QUADS.map(|[a, b, c, d]| format!(" 4 {a} {b} {c} {d} 255 0\n")).concat();
    let text =
        head("ascii", "double", "uchar", "int", "vertex_indices") + &format!("1 2 5 6\n{vertices}\n{faces}0\n\n");
    files.extend([text.replace('\n', "\r\n").into_bytes(), text.replace('\n', "\r").into_bytes(), text.into_bytes()]);
    assert_eq!(files.len(), 35);
    for file in files {
        let geometry = parse(&file).expect("readable");
        assert_eq!((geometry.face_count(), geometry.vertices.len()), (6, 8));
        let (area, volume) = area_and_volume(&geometry);
        assert!((area - 6.0).abs() < 1e-12 && (volume - 1.0).abs() < 1e-12, "{area} {volume}");
        assert_eq!(geometry.objects.as_slice(), ["town"]);
        assert_eq!((geometry.materials.as_slice(), geometry.warnings.len()), (&["default".to_owned()][..], 0));
    }
}

fn small(vertices: &str, faces: &str, body: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list int int vertex_indices\nend_header\n{body}"
    )
    .into_bytes()
}

const POINTS: &str = "0 0 0\n1 0 0\n0 1 0\n";

/// 31 damaged files are refused with a message of what was found; counts of billions without data
/// take no memory.
#[test]
fn damaged_files_are_refused_with_a_reason() {
    let swap = |from: &str, to: &str| {
        let text = String::from_utf8(small("3", "1", &format!("{POINTS}3 0 1 2\n"))).expect("text");
        assert!(text.contains(from), "{from}");
        text.replace(from, to).into_bytes()
    };
    let binary = |vertices: &str, faces: &str, body: &[u8]| {
        let head = String::from_utf8(small(vertices, faces, "")).expect("text");
        [head.replace("ascii", "binary_little_endian").as_bytes(), body].concat()
    };
    let corners =
        |count: i32, corner: i32| [vec![0; 36], count.to_le_bytes().into(), corner.to_le_bytes().into()].concat();
    let nan = [[0; 4], [0; 4], f32::NAN.to_le_bytes()].concat();
    for (bytes, said) in [
        (vec![], "line 1: the first line is ``, not `ply`"),
        (b"plywood\n".to_vec(), "line 1: the first line is `plywood"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "ends before `end_header`"),
        (b"ply\nend_header\n".to_vec(), "line 2: the header has no `format` line"),
        (swap("ascii", "morse"), "line 2: `format morse 1.0` is not a format"),
        (swap("vertex 3", "vertex -3"), "line 3: `element vertex -3` has no valid count"),
        (swap("vertex 3", "vertex 99999999999999999999"), "line 3: `element vertex 9999"),
        (swap("float z", "real z"), "line 6: `property real z` is not a valid property"),
        (swap("float z", "float w"), "line 3: `element vertex` has no property `z`"),
        (swap("float z", "list uchar float z"), "has no property `z` that is a number"),
        (swap("vertex_indices", "edges"), "line 7: `element face` has no list `vertex_indices`"),
        (swap("element face", "element vertex"), "line 7: `element vertex` is declared twice"),
        (swap("element face", "elephant"), "line 7: `elephant 1` is not a statement"),
        (swap("element face", "element tristrips"), "found triangle strips"),
        (swap("face 1", "face 0"), "holds no faces (3 vertices were read)"),
        (swap("face 1", "face 4294967295"), "face 1 of 4294967295 is missing or incomplete"),
        (swap("vertex 3", "vertex 4000000000"), "vertex 4 of 4000000000 is missing or incomplete"),
        (swap("0 1 0\n", "0 nan 0\n"), "line 12: vertex 2 of 3 lies at [0, NaN, 0]"),
        (swap("0 1 0\n", "0 1,5 0\n"), "line 12: vertex 2 of 3 holds `1,5`"),
        (swap("0 1 0\n", "0 1e10 0\n"), "vertex 2 of 3 lies at [0, 10000000000, 0]"),
        (swap("3 0 1 2", "3 0 1 3"), "line 13: face 0 of 1 names vertex 3, but vertices are numbered 0 to 2"),
        (swap("3 0 1 2", "3 0 1 -1"), "names vertex -1,"),
        (swap("3 0 1 2", "3 0 1 0.5"), "names vertex 0.5,"),
        (swap("3 0 1 2", "-3 0 1 2"), "face 0 of 1 has a list `vertex_indices` of -3 values"),
        (swap("3 0 1 2", "4 0 1 2"), "line 13: face 0 of 1 has too few numbers"),
        (binary("4000000000", "1", &[0; 30]), "vertex 2 of 4000000000 is missing or incomplete"),
        (binary("3", "1", &corners(-1, 0)), "face 0 of 1 has a list `vertex_indices` of -1 values"),
        (binary("3", "1", &corners(i32::MAX, 0)), "face 0 of 1 is missing or incomplete"),
        (binary("3", "4294967295", &corners(1, 2)), "face 1 of 4294967295 is missing or incomplete"),
        (binary("3", "1", &corners(1, -2)), "names vertex -2,"),
        (binary("1", "1", &nan), "vertex 0 of 1 lies at [0, 0, NaN]"),
    ] {
        let message = parse(&bytes).map(drop).expect_err(said).to_string();
        assert!(message.contains("town.ply") && message.contains(said), "{said}: {message}");
    }
}

/// An element of 2^64 - 1 items without properties takes no time, and 3 extra bytes are a warning.
#[test]
fn items_without_properties_take_no_time() {
    let head = "ply\nformat binary_big_endian 1.0\nelement air 18446744073709551615\nelement vertex 1\nproperty char x\n\
                property char y\nproperty char z\nelement face 1\nproperty list uchar uchar vertex_index\nend_header\n";
    let geometry = parse(&[head.as_bytes(), &[0, 0, 255, 3, 0, 0, 0, 1, 2, 3]].concat()).expect("readable");
    assert_eq!(geometry.vertices[0], DVec3::new(0.0, 0.0, -1.0));
    assert_eq!(geometry.warnings.len(), 1);
    assert!(geometry.warnings[0].contains("town.ply: 3 bytes after the last element are ignored"));
}

/// A polygon of 1,000,000 corners is read, and triangulation refuses it by its size before spending
/// any time on it.
#[test]
fn a_polygon_of_a_million_corners_is_refused() {
    let corners = "0 1 2 ".repeat(333_333);
    let geometry = parse(&small("3", "1", &format!("{POINTS}1000000 {corners}0\n"))).expect("readable");
    let message = triangulate(&geometry).map(drop).expect_err("too large").to_string();
    assert_eq!(message, "the number of corners of the face in line 13 is 1000000, the limit is 65536");
}
