//! Two readers, one text: `tools/reader.py`, written from `schema/` alone, and this library decode
//! the same values, from golden archives that stay and from one that is built here.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format::{SLOT_OFFSETS, SLOT_SIZE, Slot};
use heliotile_core::archive::manifest::Settings;
use heliotile_core::archive::tables::{
    BandsTable, CellsTable, ExtentsTable, GeometryTable, IndexTable, MaterialsTable, MirrorsTable, NamesTable,
    ObjectsTable, OpticsTable, OverviewTable, PartsTable, ReceiversTable,
};
use heliotile_core::archive::{Archive, Block, format};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::canopy::{Canopy, RayLists, SKY, sky_side};
use heliotile_core::layers::extras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::mirror::{CellMirrors, ReceiverMirrors};
use heliotile_core::layers::response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::chain::{Chain, MirrorStep};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;

use crate::cli::failure;
use crate::scenes::*;

/// Canonical bytes of the arrays of a block, under their names: see `tools/reader.py`.
type Arrays = Vec<(&'static str, Vec<u8>)>;

/// The golden archives, which together hold blocks of all kinds: their names, and the number of
/// arrays of each.
const GOLDEN: [(&str, usize); 3] = [("v1.7-box", 99), ("v1.7-mirrors", 79), ("v1.7-bands", 62)];

/// Returns the path of a file of a golden archive: `.helio`, the outputs of `reader.py` and of
/// `query`, and the conditions.
fn golden(version: &str, extension: &str) -> PathBuf {
    let name = format!("tests/data/archives/{version}.{extension}");
    Path::new(crate::ROOT).join(name)
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).expect("a readable file")
}

/// Returns numbers without gaps, little-endian.
fn le<T: Copy, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&value| bytes(value)).collect()
}

/// Returns each string after its length as u32.
fn strings(values: &[String]) -> Vec<u8> {
    values.iter().flat_map(|s| [&(s.len() as u32).to_le_bytes(), s.as_bytes()].concat()).collect()
}

/// Returns bits row-major, lowest first, filled up to a byte.
fn bits(square: &BitSquare) -> Vec<u8> {
    let n = square.side();
    let texels: Vec<bool> = (0..n * n).map(|i| square.get(i % n, i / n)).collect();
    texels.chunks(8).map(|eight| eight.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit))).collect()
}

fn receivers(t: &ReceiversTable) -> Arrays {
    vec![
        ("ids", strings(&t.ids)),
        ("position", le(&t.position.concat(), f64::to_le_bytes)),
        ("normal", le(&t.normal.concat(), f64::to_le_bytes)),
        ("area", le(&t.area, f64::to_le_bytes)),
        ("surface", strings(&t.surface)),
        ("sky_view", le(&t.sky_view, f32::to_le_bytes)),
        ("ground_view", le(&t.ground_view, f32::to_le_bytes)),
        ("obstruction_view", le(&t.obstruction_view, f32::to_le_bytes)),
    ]
}

fn parts(t: &PartsTable) -> Arrays {
    vec![
        ("object", strings(&t.object)),
        ("building", strings(&t.building)),
        ("kind", strings(&t.kind)),
        ("object_type", strings(&t.object_type)),
        ("face", strings(&t.face)),
    ]
}

fn materials(block: &Block) -> Arrays {
    let t = MaterialsTable::from_block(block).expect("materials");
    vec![
        ("name", strings(&t.name)),
        ("diffuse", le(&t.diffuse, f64::to_le_bytes)),
        ("specular", le(&t.specular, f64::to_le_bytes)),
        ("class", t.class),
        ("group", strings(&t.group)),
    ]
}

fn index(t: &IndexTable) -> Arrays {
    vec![
        ("voxel", le(&t.voxel.concat(), i32::to_le_bytes)),
        ("tag", le(&t.tag, u32::to_le_bytes)),
        ("material", le(&t.material, u16::to_le_bytes)),
    ]
}

fn cells(t: &CellsTable) -> Arrays {
    vec![
        ("voxel", le(&t.voxel.concat(), i32::to_le_bytes)),
        ("tag", le(&t.tag, u32::to_le_bytes)),
        ("material", le(&t.material, u16::to_le_bytes)),
        ("normal", le(&t.normal.concat(), f32::to_le_bytes)),
        ("bits", t.bits.clone()),
        ("seen_voxel", le(&t.seen_voxel.concat(), i32::to_le_bytes)),
        ("seen_tag", le(&t.seen_tag, u32::to_le_bytes)),
        ("seen_material", le(&t.seen_material, u16::to_le_bytes)),
        ("hits", le(&t.hits, u16::to_le_bytes)),
        ("doubtful", t.doubtful.clone()),
    ]
}

fn hit(t: &HitTile) -> Arrays {
    vec![
        ("level", t.palette.iter().flat_map(|k| k.level.to_le_bytes()).collect()),
        ("facing", t.palette.iter().map(|k| k.facing).collect()),
        ("material", t.palette.iter().flat_map(|k| k.material.to_le_bytes()).collect()),
        ("voxel", t.palette.iter().flat_map(|k| le(&k.voxel, i32::to_le_bytes)).collect()),
        ("texels", le(&t.texels, u32::to_le_bytes)),
    ]
}

fn chain(row: usize, chain: Chain) -> Vec<u8> {
    let numbers = chain.numbers().flat_map(u16::to_le_bytes);
    (row as u32).to_le_bytes().into_iter().chain([chain.len() as u8]).chain(numbers).collect()
}

fn seen(cell: &CellKey, steps: &[MirrorStep]) -> Vec<u8> {
    let mut out = [cell.level.to_le_bytes()[0], cell.facing].to_vec();
    out.extend(cell.material.to_le_bytes());
    out.extend(le(&cell.voxel, i32::to_le_bytes));
    out.push(steps.len() as u8);
    steps.iter().for_each(|(material, cosine)| out.extend(material.to_le_bytes().into_iter().chain([*cosine])));
    out
}

fn receiver_mirrors(rows: &[Vec<u8>], s: &Settings) -> Arrays {
    let (mut windows, mut texels, mut paths) = (Vec::new(), Vec::new(), Vec::new());
    for (i, row) in rows.iter().enumerate() {
        let found = ReceiverMirrors::from_bytes(row, s.sky_base as usize, s.hit as usize).expect("mirrors");
        for window in found.windows {
            windows.extend(chain(i, window.chain));
            windows.extend(le(&[window.column, window.row, window.side], u16::to_le_bytes));
            let (side, block) = (usize::from(window.side), (s.sky_fine / s.sky_base) as usize);
            let squares = SkyTexture::unpack(&window.texture, 1, side, side * block).expect("a window");
            texels.extend(squares.iter().flat_map(bits));
        }
        for path in found.paths {
            paths.extend(le(&[i as u32, path.texel], u32::to_le_bytes));
            paths.extend(seen(&path.cell, &path.steps));
        }
    }
    vec![("windows", windows), ("bits", texels), ("paths", paths)]
}

fn cell_mirrors(rows: &[Vec<u8>], side: u32) -> Arrays {
    let (mut windows, mut texels, mut paths) = (Vec::new(), Vec::new(), Vec::new());
    for (i, row) in rows.iter().enumerate() {
        let found = CellMirrors::from_bytes(row, (side * side).div_ceil(8) as usize).expect("mirrors");
        for window in found.windows {
            windows.extend(chain(i, window.chain));
            texels.extend((window.texels.len() as u32).to_le_bytes());
            texels.extend(le(&window.texels, u16::to_le_bytes));
        }
        for path in found.paths {
            paths.extend((i as u32).to_le_bytes().into_iter().chain([u8::from(path.up)]));
            paths.extend(seen(&path.cell, &path.steps));
        }
    }
    vec![("windows", windows), ("bits", texels), ("paths", paths)]
}

/// Returns the rays of receivers to the sky that cross canopies, with material and count.
fn crossings(rows: &[Vec<u8>], s: &Settings) -> Vec<u8> {
    let side = sky_side(s.sky_base as usize, s.sky_fine as usize);
    let mut out = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let rays = RayLists::of_receiver(side, (s.hit * s.hit) as usize);
        let found = Canopy::from_bytes(row, rays, |_| true).expect("crossings");
        for (ray, crossed) in found.crossings(SKY) {
            for (material, count) in crossed {
                out.extend(le(&[i as u32, ray as u32], u32::to_le_bytes));
                out.extend(le(&[material, count], u16::to_le_bytes));
            }
        }
    }
    out
}

/// Returns the arrays of a block of any kind that this release knows, decoded by the library.
fn arrays(block: &Block, s: &Settings) -> Arrays {
    let rows = block.items() as usize;
    let raw = block.bytes();
    match block.entry().kind {
        format::RECEIVERS => receivers(&ReceiversTable::from_block(block).expect("receivers")),
        format::SKY => {
            let squares = SkyTexture::unpack(raw, rows, s.sky_base as usize, s.sky_fine as usize).expect("sky");
            vec![("sky", squares.iter().flat_map(bits).collect())]
        }
        format::HIT => hit(&HitTile::unpack(raw, rows * (s.hit * s.hit) as usize).expect("hits")),
        format::RESPONSE => {
            let tile = response::unpack(raw, rows, s.probe as usize).expect("responses");
            vec![("g", tile.iter().flat_map(|r| le(&r.values, f32::to_le_bytes)).collect())]
        }
        format::PROBES | format::BOUNCE => cells(&CellsTable::from_block(block).expect("cells")),
        format::PARTS => parts(&PartsTable::from_block(block).expect("parts")),
        format::OPTICS => {
            let t = OpticsTable::from_block(block).expect("optics");
            vec![("panes", t.panes), ("canopy", t.canopy), ("transmittance", le(&t.transmittance, f64::to_le_bytes))]
        }
        format::BANDS => {
            let t = BandsTable::from_block(block).expect("bands");
            let (material, value) = (le(&t.material, u16::to_le_bytes), le(&t.value, f64::to_le_bytes));
            vec![("material", material), ("property", t.property), ("band", t.band), ("value", value)]
        }
        format::MIRRORS => {
            let t = MirrorsTable::from_block(block).expect("mirrors");
            let normal = le(&t.normal.concat(), f64::to_le_bytes);
            vec![("normal", normal), ("material", le(&t.material, u16::to_le_bytes))]
        }
        format::OVERVIEW => {
            let t = OverviewTable::from_block(block).expect("an overview");
            vec![
                ("position", le(&t.position.concat(), f32::to_le_bytes)),
                ("normal", le(&t.normal.concat(), i16::to_le_bytes)),
                ("area", le(&t.area, f32::to_le_bytes)),
                ("sky_view", t.sky_view),
                ("clear_year", le(&t.clear_year, f32::to_le_bytes)),
                ("polygons", t.polygons),
                ("corners", t.corners),
                ("offset", le(&t.offset.concat(), i32::to_le_bytes)),
            ]
        }
        format::EXTENTS => {
            let t = ExtentsTable::from_block(block).expect("boxes");
            vec![("low", le(&t.low.concat(), f64::to_le_bytes)), ("high", le(&t.high.concat(), f64::to_le_bytes))]
        }
        format::NAMES => {
            let t = NamesTable::from_block(block).expect("names");
            vec![
                ("of", t.of),
                ("shared", le(&t.shared, u16::to_le_bytes)),
                ("own", le(&t.own, u16::to_le_bytes)),
                ("text", t.text),
                ("tile", le(&t.tile, u32::to_le_bytes)),
            ]
        }
        format::SCENE => {
            let t = GeometryTable::from_block(block).expect("triangles");
            let (vertex, corner) = (le(&t.vertex.concat(), f32::to_le_bytes), le(&t.corner.concat(), u32::to_le_bytes));
            vec![("vertex", vertex), ("corner", corner), ("material", le(&t.material, u16::to_le_bytes))]
        }
        format::OBJECTS => {
            let t = ObjectsTable::from_block(block).expect("objects");
            vec![
                ("name", strings(&t.name)),
                ("object", strings(&t.object)),
                ("building", strings(&t.building)),
                ("object_type", strings(&t.object_type)),
                ("beside", t.beside),
                ("row", le(&t.row, u16::to_le_bytes)),
                ("attributes", strings(&t.attributes)),
            ]
        }
        format::MIRROR => receiver_mirrors(&extras::unpack(raw, rows).expect("rows of bytes"), s),
        format::PROBE_MIRROR => cell_mirrors(&extras::unpack(raw, rows).expect("rows of bytes"), s.probe),
        format::BOUNCE_MIRROR => cell_mirrors(&extras::unpack(raw, rows).expect("rows of bytes"), s.bounce_sky),
        format::CANOPY | format::PROBE_CANOPY | format::BOUNCE_CANOPY => {
            let found = extras::unpack(raw, rows).expect("rows of bytes");
            let lengths: Vec<u32> = found.iter().map(|row| row.len() as u32).collect();
            let mut arrays = vec![("lengths", le(&lengths, u32::to_le_bytes)), ("bytes", found.concat())];
            if block.entry().kind == format::CANOPY {
                arrays.push(("crossings", crossings(&found, s)));
            }
            arrays
        }
        format::INDEX => index(&IndexTable::from_block(block).expect("an index")),
        format::MATERIALS => materials(block),
        other => panic!("{other:?} has no canonical bytes"),
    }
}

/// Returns the lines of `reader.py --digests`, by the library: kind, tile, array, BLAKE3 of its
/// canonical bytes.
fn digests(path: &Path) -> String {
    let archive = Archive::open(path).expect("an archive");
    let mut lines = String::new();
    for entry in archive.entries() {
        let block = archive.block(entry.kind, entry.tile).expect("a block");
        block.check_content().expect("its content");
        for (name, bytes) in arrays(&block, &archive.manifest().settings) {
            let kind = format::kind_name(entry.kind);
            writeln!(lines, "{kind} {} {name} {}", entry.tile, blake3::hash(&bytes).to_hex()).expect("a line");
        }
    }
    lines
}

/// Returns the exit code, output and messages of `reader.py`.
fn python(program: &str, path: &Path) -> (Option<i32>, String, String) {
    let script = Path::new(crate::ROOT).join("tools/reader.py");
    let output = Command::new(program).arg(script).arg(path).arg("--digests").output().expect("HELIOTILE_PYTHON");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// Builds two tiles, several chunks of each kind of cells, long and short names, groups and areas;
/// small textures.
fn small_site(path: &Path) {
    let mut triangles = ground(40.0, 0.0, 0);
    triangles.extend(block(v(0.0, 0.0, 0.0), v(10.0, 10.0, 10.0), 1));
    triangles.extend(block(v(18.0, 2.0, 0.0), v(26.0, 14.0, 6.0), 2));
    let material = |name: &str, diffuse, class, group: Option<&str>| Material {
        specular: 0.1,
        group: group.map(Into::into),
        ..Material::matt(name, diffuse, class)
    };
    let materials = vec![
        material("grass", 0.25, Class::Ground, Some("snow cover")),
        material("wall", 0.4, Class::Obstruction, None),
        material("curtain wall", 0.1, Class::Obstruction, Some("glass")),
    ];
    let scene = Scene::from_triangles(&triangles, materials).expect("a valid scene");
    let receivers: Vec<Receiver> = (0..70)
        .map(|i| Receiver {
            area: (i % 2 == 0).then_some(1.5),
            surface: (i % 3 == 0).then(|| format!("surface number {i}")),
            ..receiver(
                &if i % 5 == 0 { format!("a receiver with a long name {i}") } else { format!("r{i}") },
                v(f64::from(i % 10) * 3.1 - 8.05, f64::from(i / 10) * 3.7 - 8.03, 10.5),
                tilted(f64::from(i % 7) * 25.0, f64::from(i) * 11.0),
            )
        })
        .collect();
    let settings = BuildSettings {
        sky_base: 32,
        sky_fine: 256,
        hit: 16,
        probe: 16,
        probe_hits: 450,
        bounce_sky: 8,
        bounce_hits: 450,
        ..fine()
    };
    build(&scene, &mut tiles(&receivers, &scene), &plan(&settings, path)).expect("a build");
}

/// All 99, 79 and 62 arrays of the golden archives' blocks have the digests that `reader.py`
/// printed; the blocks are of all 23 kinds.
#[test]
fn golden_values_are_those_of_the_second_reader() {
    let mut kinds = BTreeSet::new();
    for (version, arrays) in GOLDEN {
        let found = digests(&golden(version, "helio"));
        assert_eq!(found.lines().count(), arrays, "{version}");
        assert_eq!(found, text(&golden(version, "digests")));
        kinds.extend(found.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned));
    }
    assert_eq!(kinds.len(), format::KINDS.len());
}

/// With `HELIOTILE_PYTHON` (.ci/run sets it) the second reader itself prints these 240 lines,
/// agrees on every array of a new site of 2 tiles and more than 2 chunks of each kind of cells,
/// names the one block whose byte was changed (exit code 1) and refuses a cut file (2). Without it
/// only the golden digests are compared, by the test above.
#[test]
fn the_second_reader_agrees() {
    let Some(program) = std::env::var("HELIOTILE_PYTHON").ok().filter(|p| !p.is_empty()) else {
        eprintln!(
            "HELIOTILE_PYTHON is not set: tools/reader.py was NOT run, only its digests in tests/data/archives are used"
        );
        let lines: usize = GOLDEN.iter().map(|(version, _)| text(&golden(version, "digests")).lines().count()).sum();
        assert_eq!(lines, 240);
        return;
    };
    for (version, _) in GOLDEN {
        let expected = (Some(0), text(&golden(version, "digests")), String::new());
        assert_eq!(python(&program, &golden(version, "helio")), expected);
    }

    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("site.helio");
    small_site(&path);
    let archive = Archive::open(&path).expect("an archive");
    let blocks = |kind| archive.entries_of(kind).len();
    assert_eq!([format::RECEIVERS, format::SKY, format::HIT, format::RESPONSE].map(blocks), [2; 4]);
    assert!([format::PROBES, format::BOUNCE].iter().all(|&kind| blocks(kind) > 2));
    assert!([format::PROBE_MIRROR, format::BOUNCE_MIRROR].iter().all(|&kind| blocks(kind) > 0));
    assert!(blocks(format::MIRROR) > 0);
    let found = digests(&path);
    assert!(found.lines().count() > 44 + 4 * 9);
    assert_eq!(python(&program, &path), (Some(0), found, String::new()));

    let whole = fs::read(&path).expect("the archive");
    let mut bytes = whole.clone();
    let entry = archive.entries_of(format::HIT)[1];
    bytes[entry.offset as usize] ^= 1;
    let bad = folder.path().join("bad.helio");
    fs::write(&bad, &bytes).expect("a writable folder");
    let (code, _, message) = python(&program, &bad);
    assert!(code == Some(1) && message.contains("hit/1") && message.lines().count() == 1, "{code:?} {message}");
    fs::write(&bad, &whole[..whole.len() - 1]).expect("a writable folder");
    let (code, _, message) = python(&program, &bad);
    assert!(code == Some(2) && message.contains("truncated"), "{code:?} {message}");
}

/// The golden archives give the rows of the release that made them, 6 receivers x 3 conditions
/// each, to 0.002 W/m2 (sky patches may be integrated better since): with the stored responses (all
/// bounces) and with responses derived from hits and cells (1 bounce).
#[test]
fn golden_rows_stay() {
    for ((version, _), (bounces, extension)) in
        GOLDEN.into_iter().flat_map(|golden| [("all", "csv"), ("1", "bounces-1.csv")].map(|way| (golden, way)))
    {
        let output = Command::new(env!("CARGO_BIN_EXE_heliotile"))
            .args(["replay", "--bounces", bounces, "--conditions"])
            .args([golden(version, "conditions.csv"), golden(version, "helio")])
            .output()
            .expect("the program");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let rows = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(rows.lines().count(), 1 + 3 * 6);
        for (row, expected) in rows.lines().zip(text(&golden(version, extension)).lines()) {
            for (cell, expected) in row.split(',').zip(expected.split(',')) {
                let same = match (cell.parse::<f64>(), expected.parse::<f64>()) {
                    (Ok(cell), Ok(expected)) => (cell - expected).abs() < 0.002,
                    _ => cell == expected,
                };
                assert!(same, "{version} --bounces {bounces}: {row} for {expected}");
            }
            assert_eq!(row.split(',').count(), 9);
        }
    }
}

/// An archive for replay only, taken from each of the three golden ones, is good for
/// `verify --deep` and for the second reader and gives the same rows in less than 0.7 of the bytes.
/// Four questions that need hits and cells end with an error that says so, and a build makes it
/// whole again.
#[test]
fn archives_for_replay_only_replay_the_same() {
    let folder = crate::cli::Folder::new();
    let asked = |arguments: &str| {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    for (version, _) in GOLDEN {
        let (whole, conditions) = (golden(version, "helio"), golden(version, "conditions.csv"));
        fs::copy(&whole, folder.path("whole.helio")).expect("a copy");
        asked("archive extract whole.helio --replay-only -o light.helio");
        asked("archive verify light.helio --deep");
        let length = |name: &str| fs::metadata(folder.path(name)).expect("a file").len();
        assert!(length("light.helio") * 10 < length("whole.helio") * 7, "{version}");
        let rows = |name: &str| asked(&format!("replay {name} --conditions {}", conditions.display()));
        assert_eq!(rows("light.helio"), rows("whole.helio"), "{version}");
        if let Ok(program) = std::env::var("HELIOTILE_PYTHON") {
            let (code, _, said) = python(&program, &folder.path("light.helio"));
            assert_eq!(code, Some(0), "{version}: {said}");
        }
        for question in [
            &format!("replay light.helio --conditions {} --bounces 1", conditions.display()),
            "energyplus factors light.helio -o factors.csv",
            "archive diff light.helio whole.helio",
            "archive merge light.helio light.helio -o both.helio",
        ] {
            folder.fails(question, "input lacks light.helio hits and cells");
        }
    }
    let build = "build scene.obj -m materials.toml -r receivers.csv -o light.helio";
    fs::remove_file(folder.path("light.helio")).expect("removed");
    asked(build);
    fs::rename(folder.path("light.helio"), folder.path("built.helio")).expect("renamed");
    asked("archive extract built.helio --replay-only -o light.helio");
    asked(build);
    asked("archive diff light.helio built.helio");
}

/// An archive whose header says format 1.6 is refused by 8 of 8 commands with exit code 2 and the
/// format, and no file is written.
#[test]
fn archives_of_other_formats_are_refused_by_all_commands() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let [old, part, map] = ["old.helio", "part.helio", "roof.exr"].map(|name| folder.path().join(name));
    let mut bytes = fs::read(golden("v1.7-mirrors", "helio")).expect("an archive");
    for start in SLOT_OFFSETS.map(|offset| offset as usize) {
        let slot = bytes.get_mut(start..start + SLOT_SIZE).expect("a slot");
        let of_then = Slot { minor: 6, ..Slot::decode(slot).expect("a whole slot") };
        slot.copy_from_slice(&of_then.encode());
    }
    fs::write(&old, &bytes).expect("a writable folder");
    let conditions = golden("v1.7-mirrors", "conditions.csv");
    for arguments in [
        vec!["info".as_ref(), old.as_os_str()],
        vec!["archive".as_ref(), "verify".as_ref(), old.as_ref()],
        vec!["replay".as_ref(), old.as_ref(), "--conditions".as_ref(), conditions.as_ref()],
        vec!["energyplus".as_ref(), "factors".as_ref(), old.as_ref()],
        vec![
            "archive".as_ref(),
            "extract".as_ref(),
            old.as_ref(),
            "--bbox=-9,-9,9,9".as_ref(),
            "-o".as_ref(),
            part.as_ref(),
        ],
        vec!["archive".as_ref(), "merge".as_ref(), old.as_ref(), old.as_ref(), "-o".as_ref(), part.as_ref()],
        vec!["archive".as_ref(), "diff".as_ref(), old.as_ref(), old.as_ref()],
        vec!["export".as_ref(), old.as_ref(), "--receiver".as_ref(), "roof".as_ref(), "-o".as_ref(), map.as_ref()],
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        assert_eq!(failure(command.args(&arguments)), "unsupported format 1.6", "{arguments:?}");
    }
    assert!(!part.exists() && !map.exists());
}
