//! Tests of scene files, their parts, materials and receivers, plain and packed: both give the same
//! scene.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::Scene;
use crate::points::receivers::read_receivers;
use crate::site::SceneFiles;
use heliotile_core::site::north::North;

fn pack(plain: &[u8]) -> Vec<u8> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(plain).expect("packed");
    packer.finish().expect("packed")
}

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/corpus")
}

fn hash(path: &Path) -> [u8; 32] {
    Scene::load(path, None).unwrap_or_else(|error| panic!("{}: {error}", path.display())).content_hash()
}

/// Returns a zip of files, packed or stored.
fn zipped(files: &[(&str, &[u8])], method: zip::CompressionMethod) -> Vec<u8> {
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, plain) in files {
        writer.start_file(*name, options).expect("a name");
        writer.write_all(plain).expect("packed");
    }
    writer.finish().expect("a zip").into_inner()
}

/// Sixteen files with `.gz` added to their names give the scenes of the plain files, and so do
/// packed files under plain names.
#[test]
fn every_packed_format_gives_the_plain_scene() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let mut read = 0;
    for (seed, name) in [
        ("obj", "a.obj"),
        ("cityjson", "a.city.json"),
        ("cityjson_seq", "a.city.jsonl"),
        ("geotiff", "a.tif"),
        ("geotiff", "a.tiff"),
        ("ascii_grid", "a.asc"),
        ("ascii_grid", "a.dem"),
        ("epjson", "a.epJSON"),
        ("epjson", "b.json"),
        ("idf", "a.IDF"),
        ("honeybee", "a.hbjson"),
        ("honeybee", "c.json"),
        ("gltf", "a.gltf"),
        ("glb", "a.glb"),
        ("stl", "a.stl"),
        ("ply", "a.ply"),
    ] {
        let bytes = fs::read(corpus().join(seed).join("seed")).expect(seed);
        let (plain, packed) = (folder.path().join(name), folder.path().join(format!("{name}.gz")));
        fs::write(&plain, &bytes).expect("written");
        fs::write(&packed, pack(&bytes)).expect("written");
        let expected = hash(&plain);
        assert_eq!(hash(&packed), expected, "{name}");
        fs::write(&plain, pack(&bytes)).expect("written");
        assert_eq!(hash(&plain), expected, "{name}");
        read += 1;
    }
    assert_eq!(read, 16);
}

/// Four files that other files name are found packed: a buffer of glTF, a library of OBJ, a
/// `materials.toml` and a `site.toml`.
#[test]
fn files_that_files_name_are_found_packed() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, bytes: &[u8]| fs::write(at(name), bytes).expect("written");
    let corners = [[0.0_f32, 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    let buffer: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    write("b.bin.gz", &pack(&buffer));
    for (name, uri) in [("plain.gltf", "b.bin"), ("packed.gltf", "b.bin.gz")] {
        let text = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"URI"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
        write(name, text.replace("URI", uri).as_bytes());
        assert_eq!(Scene::load(&at(name), None).expect(name).mesh.triangles.len(), 1);
    }
    write("a.mtl.gz", &pack(b"newmtl wall\nKd 0.25 0.25 0.25\n"));
    write("a.obj.gz", &pack(b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wall\nf 1 2 3\n"));
    let scene = Scene::load(&at("a.obj.gz"), None).expect("a scene");
    assert_eq!((scene.materials[0].diffuse, scene.report.warnings.len()), (0.25, 0));
    write("m.toml.gz", &pack(b"[wall]\ndiffuse = 0.75\n"));
    assert_eq!(Scene::load(&at("a.obj.gz"), Some(&at("m.toml.gz"))).expect("a scene").materials[0].diffuse, 0.75);
    write("site.toml.gz", &pack(b"[[scene]]\nfile = \"a.obj.gz\"\nmaterials = \"m.toml.gz\"\n"));
    for name in ["", "site.toml.gz"] {
        assert_eq!(SceneFiles::new(&[at(name)], None).expect("a site").parts.len(), 1, "{name}");
    }
}

/// Receivers are read from a packed table as from a plain one, 2 of 2; messages name the packed
/// file and the line of the plain one.
#[test]
fn packed_receivers_are_read_as_plain_ones() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("receivers.csv.gz");
    let text = "receiver,x,y,z,nx,ny,nz\na,0,0,1,0,0,1\nb,1,0,1,0,0,1\n";
    fs::write(&path, pack(text.as_bytes())).expect("written");
    assert_eq!(read_receivers(&path, North::default()).expect("receivers").len(), 2);
    fs::write(&path, pack(text.replace("b,1,", "b,x,").as_bytes())).expect("written");
    let found = read_receivers(&path, North::default()).expect_err("no number").to_string();
    assert!(found.contains("receivers.csv.gz, line 3: column `x` is `x`"), "{found}");
    let cut = pack(&text.repeat(50).into_bytes());
    fs::write(&path, &cut[..cut.len() - 9]).expect("written");
    let found = read_receivers(&path, North::default()).expect_err("cut").to_string();
    assert!(found.contains("receivers.csv.gz"), "{found}");
}

/// A zip of one file is read by the name of the file in it or by its own name: as OBJ in UTF-16, or
/// as the features of a city model. A zip of two files and one of an unknown format are refused.
#[test]
fn a_zip_of_one_file_is_read_by_its_name() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let at = |name: &str| folder.path().join(name);
    let zip = |name: &str, files: &[(&str, &[u8])]| {
        fs::write(at(name), zipped(files, zip::CompressionMethod::Deflated)).expect("written")
    };
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let wide: Vec<u8> = obj.iter().flat_map(|byte| [*byte, 0]).collect();
    let features = fs::read(corpus().join("cityjson_seq/seed")).expect("a seed");
    fs::write(at("plain.city.jsonl"), &features).expect("written");
    zip("a.zip", &[("folder/", b""), ("folder/a.obj", obj)]);
    zip("b.obj.zip", &[("whatever", &wide)]);
    zip("c.zip", &[("c.city.jsonl", &features)]);
    assert_eq!(hash(&at("a.zip")), hash(&at("b.obj.zip")));
    assert_eq!(hash(&at("c.zip")), hash(&at("plain.city.jsonl")));
    zip("two.zip", &[("a.obj", obj), ("b.obj", obj)]);
    zip("other.zip", &[("a.abc", b"x")]);
    for (name, expected) in [("two.zip", "holds 2 files, not one"), ("other.zip", "found a name that ends with .abc")] {
        let found = Scene::load(&at(name), None).expect_err(name).to_string();
        assert!(found.contains(expected), "{found}");
    }
}

/// Five paths are refused with a hint: a folder without a list, a missing folder, a missing file,
/// an unknown ending and a name without one.
#[test]
fn paths_that_cannot_be_read_get_a_hint() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    fs::write(folder.path().join("town.obj"), "").expect("written");
    fs::write(folder.path().join("town.abc.gz"), "").expect("written");
    fs::write(folder.path().join("town"), "").expect("written");
    for (name, expected) in [
        ("", "is a folder without a site.toml or tiles of CityGML (.gml)\n  to fix: name the scene files in it"),
        ("a/town.obj", ": No such file: there is no folder `a` in "),
        ("twon.obj", "town.obj?"),
        ("town.abc.gz", "found a name that ends with .abc, this release supports .json, .jsonl, .cityjson"),
        ("town", "found a name without ending, this release supports .json"),
    ] {
        let found = SceneFiles::new(&[folder.path().join(name)], None).and_then(|site| Scene::load_site(&site));
        let found = found.map(drop).expect_err(name).to_string();
        assert!(found.contains(expected), "{found}");
    }
}
