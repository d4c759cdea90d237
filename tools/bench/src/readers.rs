//! How fast scene files are read: a city of boxes written in every format, and a hill as rasters; `Scene::load`, median of five runs.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::Instant;

use heliotile_scene::Scene;

/// Boxes along each side of the city, and samples along each side of the hill.
const BOXES: usize = 150;
const SAMPLES: usize = 1500;

const QUADS: [[usize; 4]; 5] = [[4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// Corners of all boxes, eight each, mm.
fn corners() -> Vec<[i64; 3]> {
    let mut corners = Vec::new();
    for i in 0..BOXES * BOXES {
        let (x, y, height) = (i % BOXES * 20_000, i / BOXES * 20_000, 5_000 + i * 7919 % 9_000);
        for z in [0, height] {
            for (dx, dy) in [(0, 0), (10_250, 0), (10_250, 9_875), (0, 9_875)] {
                corners.push([(x + dx) as i64, (y + dy) as i64, z as i64]);
            }
        }
    }
    corners
}

/// Metres with three digits.
fn metres(mm: i64) -> String {
    format!("{}.{:03}", mm / 1000, mm % 1000)
}

fn polygons() -> Vec<(&'static str, Vec<u8>)> {
    let corners = corners();
    let faces = || (0..corners.len() / 8).flat_map(|b| QUADS.map(|quad| quad.map(|c| 8 * b + c)));
    let triangles = || faces().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let spelt = |c: &[i64; 3]| c.map(metres).join(" ");
    let float = |i: usize| corners[i].iter().flat_map(|mm| (*mm as f32 / 1e3).to_le_bytes()).collect::<Vec<u8>>();

    let mut obj: String = corners.iter().map(|c| format!("v {}\n", spelt(c))).collect();
    faces().for_each(|f| writeln!(obj, "f {}", f.map(|c| (c + 1).to_string()).join(" ")).expect("a string"));

    let mut stl = vec![0; 80];
    stl.extend((triangles().count() as u32).to_le_bytes());
    for triangle in triangles() {
        stl.extend([0; 12]);
        triangle.iter().for_each(|&corner| stl.extend(float(corner)));
        stl.extend([0; 2]);
    }
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        corners.len(),
        faces().count()
    );
    let mut ply = head.clone().into_bytes();
    (0..corners.len()).for_each(|i| ply.extend(float(i)));
    let mut text = head.replace("binary_little_endian", "ascii");
    corners.iter().for_each(|c| writeln!(text, "{}", spelt(c)).expect("a string"));
    for face in faces() {
        ply.push(4);
        face.iter().for_each(|&corner| ply.extend((corner as u32).to_le_bytes()));
        writeln!(text, "4 {}", face.map(|c| c.to_string()).join(" ")).expect("a string");
    }
    let mut buffer: Vec<u8> = (0..corners.len()).flat_map(float).collect();
    let split = buffer.len();
    triangles().flatten().for_each(|corner| buffer.extend((corner as u32).to_le_bytes()));
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],"buffers":[{{"byteLength":{}}}],"bufferViews":[{{"buffer":0,"byteLength":{split}}},{{"buffer":0,"byteOffset":{split},"byteLength":{}}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3"}},{{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}]}}"#,
        buffer.len(),
        buffer.len() - split,
        corners.len(),
        3 * triangles().count()
    );
    json.extend(std::iter::repeat_n(' ', json.len().next_multiple_of(4) - json.len()));
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let body = [chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", &buffer)].concat();
    let glb = [&b"glTF\x02\0\0\0"[..], &(12 + body.len() as u32).to_le_bytes(), &body].concat();

    let solid = |offset: usize| {
        let shell = QUADS.map(|quad| format!("[{:?}]", quad.map(|c| offset + c))).join(",");
        format!(
            r#"{{"type":"Building","geometry":[{{"type":"MultiSurface","lod":"2","boundaries":[{shell}],"semantics":{{"surfaces":[{{"type":"RoofSurface"}},{{"type":"WallSurface"}}],"values":[0,1,1,1,1]}}}}]}}"#
        )
    };
    let header = r#""type":"CityJSON","version":"2.0","transform":{"scale":[0.001,0.001,0.001],"translate":[0,0,0]}"#;
    let objects: Vec<String> = (0..corners.len() / 8).map(|b| format!("\"b{b}\":{}", solid(8 * b))).collect();
    let city = format!("{{{header},\"CityObjects\":{{{}}},\"vertices\":{corners:?}}}", objects.join(","));
    let mut sequence = format!("{{{header},\"CityObjects\":{{}},\"vertices\":[]}}\n");
    for (b, own) in corners.chunks(8).enumerate() {
        let one = solid(0);
        writeln!(
            sequence,
            "{{\"type\":\"CityJSONFeature\",\"id\":\"b{b}\",\"CityObjects\":{{\"b{b}\":{one}}},\"vertices\":{own:?}}}"
        )
        .expect("a string");
    }
    let (mut idf, mut shades) = (String::from("Version,25.1;\n"), Vec::new());
    for (i, face) in faces().enumerate() {
        let places = face.map(|c| corners[c].map(metres));
        writeln!(
            idf,
            "Shading:Site:Detailed,s{i},,4,{};",
            places.iter().map(|p| p.join(",")).collect::<Vec<_>>().join(",")
        )
        .expect("a string");
        let vertices = places.map(|[x, y, z]| {
            format!("{{\"vertex_x_coordinate\":{x},\"vertex_y_coordinate\":{y},\"vertex_z_coordinate\":{z}}}")
        });
        shades.push(format!("\"s{i}\":{{\"vertices\":[{}]}}", vertices.join(",")));
    }
    let epjson = format!(
        "{{\"Version\":{{\"v\":{{\"version_identifier\":\"25.1\"}}}},\"Shading:Site:Detailed\":{{{}}}}}",
        shades.join(",\n")
    );
    vec![
        ("city.obj", obj.into_bytes()),
        ("city.stl", stl),
        ("city.ply", ply),
        ("text.ply", text.into_bytes()),
        ("city.glb", glb),
        ("town.city.json", city.into_bytes()),
        ("town.city.jsonl", sequence.into_bytes()),
        ("city.idf", idf.into_bytes()),
        ("city.epJSON", epjson.into_bytes()),
    ]
}

fn hill() -> Vec<u8> {
    let mut text = format!("ncols {SAMPLES}\nnrows {SAMPLES}\nxllcorner 0\nyllcorner 0\ncellsize 10\n");
    for i in 0..SAMPLES * SAMPLES {
        let (x, y) = ((i % SAMPLES) as f64 / 90.0, (i / SAMPLES) as f64 / 70.0);
        let height = 500.0 + 200.0 * x.sin() * y.cos() + 20.0 * (3.0 * x + y).sin();
        write!(text, "{height:.2}{}", if i % SAMPLES == SAMPLES - 1 { "\n" } else { " " }).expect("a string");
    }
    text.into_bytes()
}

/// Prints a row for each format, and for further files.
pub fn run(further: &[String]) {
    let folder = tempfile::tempdir().expect("a folder");
    println!("{:28} {:>8} {:>10} {:>8} {:>8}", "file", "MB", "triangles", "s", "MB/s");
    for (name, bytes) in polygons().into_iter().chain([("hill.asc", hill())]) {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("written");
        row(&path);
    }
    further.iter().for_each(|path| row(Path::new(path)));
}

fn row(path: &Path) {
    let mut seconds = Vec::new();
    let mut triangles = 0;
    for _ in 0..5 {
        let start = Instant::now();
        triangles = Scene::load(path, None).unwrap_or_else(|error| panic!("{error}")).mesh.triangles.len();
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let megabytes = fs::metadata(path).expect("a file").len() as f64 / 1e6;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    println!("{name:28} {megabytes:8.1} {triangles:10} {:8.3} {:8.1}", seconds[2], megabytes / seconds[2]);
}
