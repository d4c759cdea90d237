//! The corpus of the fuzzers: readers return for any bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use heliotile_archives::writing::{Job, Writer};
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format::{BlockKind, TileNumber};
use heliotile_core::archive::manifest::Settings;
use heliotile_core::archive::{Access, Archive, encode, format, verify};
use heliotile_core::hemisphere::mix;
use heliotile_core::layers::canopy::{Canopy, RayLists};
use heliotile_core::layers::extras;
use heliotile_core::layers::mirror::{CellMirrors, ReceiverMirrors};
use heliotile_core::layers::response;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::sky::model::SkyModel;

use heliotile_core::site::cells::CellKey;
use heliotile_core::site::chain::Chain;
use heliotile_scene::Scene;

use crate::scenes::{canyon, many, mirror_town, receiver, scene, site, sun, tilted, v};

#[path = "../../tools/fuzz/src/targets.rs"]
mod targets;

/// Returns every input of a target, by name.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(crate::ROOT).join("tests/data/corpus").join(target);
    let mut inputs: Vec<(String, Vec<u8>)> = fs::read_dir(folder)
        .expect("a corpus")
        .map(|entry| entry.expect("an entry"))
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).expect("read")))
        .collect();
    inputs.sort();
    inputs
}

/// Environment variable of the process that replays the corpus.
const CHILD: &str = "HELIOTILE_TEST_CORPUS_CHILD";

/// Over 100 inputs of 17 targets, valid, mutated and once crashing ones, below 300 kB in total,
/// neither panic nor take more than 1 GB of address space, threads and program included.
#[test]
fn corpus_is_survived() {
    if std::env::var_os(CHILD).is_some() {
        for (name, target) in targets::TARGETS {
            for (input, bytes) in corpus(name) {
                println!("{name}/{input}");
                target(&bytes);
            }
        }
        println!("all of them");
        return;
    }
    let inputs: Vec<(String, Vec<u8>)> = targets::TARGETS.iter().flat_map(|(name, _)| corpus(name)).collect();
    let bytes: usize = inputs.iter().map(|(_, bytes)| bytes.len()).sum();
    assert!(inputs.len() > 100 && bytes < 300_000, "{} inputs, {bytes} bytes", inputs.len());
    // The corpus runs in a process of its own, since a memory limit holds for all tests of a
    // process.
    let test = std::env::current_exe().expect("this program");
    let mut child = if cfg!(unix) { Command::new("sh") } else { Command::new(&test) };
    if cfg!(unix) {
        child.args(["-c", "ulimit -v 1000000 && exec \"$0\" \"$@\""]).arg(&test);
    }
    let output = child
        .args(["hostile::corpus_is_survived", "--exact", "--nocapture", "--test-threads=1"])
        .envs([(CHILD, "1"), ("RAYON_NUM_THREADS", "1"), ("MALLOC_ARENA_MAX", "1")])
        .output()
        .expect("run");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let last = out.lines().rfind(|line| line.contains('/')).unwrap_or_default();
    assert!(output.status.success() && out.contains("all of them"), "at {last}: {}\n{err}", output.status);
}

/// Every valid seed is accepted: an archive is verified without a problem, mended checksums are the
/// original ones, and both rows of canopies are read.
#[test]
fn seeds_are_valid() {
    let seed = |target: &str| {
        let inputs = corpus(target).into_iter().filter(|(name, _)| name == "seed").collect::<Vec<_>>();
        let [(_, bytes)] = inputs.as_slice() else { panic!("{target} has {} seeds", inputs.len()) };
        bytes.clone()
    };
    let (archive, sealed) = (seed("archive"), targets::seal(&seed("sealed")));
    assert!(archive[..512] == sealed[..512] && archive[8192..] == sealed[8192..]);
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("site.helio");
    fs::write(&path, archive).expect("written");
    let report = verify(&path, Access::Read, true).expect("an archive");
    assert_eq!((report.problems.len(), report.blocks), (0, 18));
    let canopies: BTreeMap<String, Vec<u8>> = corpus("canopy").into_iter().collect();
    for (name, side) in [("seed", 8), ("predicted", 32)] {
        let rays = RayLists::of_receiver(side, 16);
        assert!(Canopy::from_bytes(&canopies[name][2..], rays, |material| material < 4).is_some(), "{name}");
    }
}

/// The seeds of all 16 formats of scenes are scenes of 1 to 110 triangles.
#[test]
fn scene_seeds_are_valid() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let mut read = 0;
    for (target, name) in [
        ("obj", "a.obj"),
        ("citygml", "a.gml"),
        ("cityjson", "a.city.json"),
        ("cityjson_seq", "a.city.jsonl"),
        ("geojson", "a.geojson"),
        ("geoparquet", "a.parquet"),
        ("shapefile", "a.zip"),
        ("geotiff", "a.tif"),
        ("ascii_grid", "a.asc"),
        ("epjson", "a.epJSON"),
        ("idf", "a.idf"),
        ("honeybee", "a.hbjson"),
        ("gltf", "a.gltf"),
        ("glb", "a.glb"),
        ("stl", "a.stl"),
        ("ply", "a.ply"),
    ] {
        let seed = corpus(target).into_iter().find(|(name, _)| name == "seed").expect(target).1;
        let path = folder.path().join(name);
        fs::write(&path, seed).expect("written");
        let scene = Scene::load(&path, None).unwrap_or_else(|error| panic!("{target}: {error}"));
        assert!((1..=110).contains(&scene.mesh.triangles.len()), "{target}: {}", scene.mesh.triangles.len());
        read += 1;
    }
    assert_eq!(read, 16);
}

/// Eight manifests that lie about the sides of textures, and a tile with fewer responses than
/// receivers, are refused by both ways of replay where the lie matters; the honest copy of the
/// archive is replayed.
#[test]
fn lying_settings_are_refused() {
    let site = site(
        &scene(&canyon(10.0, 14.0, 400.0), &[0.5, 0.5]),
        &[receiver("a", v(0.1, 0.2, 0.0), tilted(0.0, 0.0)), receiver("b", v(0.4, 3.0, 0.0), tilted(0.0, 0.0))],
        &BuildSettings { sky_base: 16, sky_fine: 64, hit: 8, probe: 8, ..BuildSettings::default() },
    );
    let archive = Archive::open(&site.path).expect("an archive");
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("copy.helio");
    let refusal = |change: &dyn Fn(&mut Settings), rows: usize, depth: MaxBounces| {
        let mut writer =
            Writer::create(&path, &Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] }).expect("created");
        for entry in archive.entries() {
            let block = archive.block(entry.kind, entry.tile).expect("a block");
            let (mut items, mut raw) = (entry.items as usize, block.bytes().to_vec());
            if entry.kind == format::RESPONSE && rows < items {
                let side = archive.manifest().settings.probe as usize;
                let tile = response::unpack(&raw, items, side).expect("responses");
                raw = response::pack(&tile[..rows]).expect("a side of eights");
                items = rows;
            }
            let copy = encode(entry.kind, entry.tile, entry.schema, items as u32, &raw, 9).expect("packed");
            writer.append(copy).expect("written");
        }
        let mut manifest = archive.manifest().clone();
        manifest.layers = writer.layers();
        change(&mut manifest.settings);
        writer.finish(&manifest).expect("finished");
        let copy = Archive::open(&path).expect("a copy");
        let settings = ReplaySettings {
            sky: SkyModel::Perez,
            patches: 145,
            paths: depth.into(),
            components: ComponentSet::ALL,
            memory: MemoryBudget::new(1 << 28),
            storage: &InMemory,
        };
        let conditions = [sun(90.0, 60.0, 800.0, 100.0)];
        let replay = OpenSite::open(&copy).and_then(|site| Replay::new(&site, &conditions, settings));
        replay.and_then(|replay| replay.run(0..1).map(drop)).err().map_or(String::new(), |error| error.to_string())
    };
    let depths = [MaxBounces::All, MaxBounces::Count(1)];
    type Lie = (&'static str, fn(&mut Settings));
    let lies: [Lie; 8] = [
        ("sky_base 0", |s| s.sky_base = 0),
        ("sky_base 1025", |s| s.sky_base = 1025),
        ("sky_fine 2147483648", |s| s.sky_fine = 1 << 31),
        ("sky_fine 8,", |s| s.sky_fine = 8),
        ("sky_fine 48,", |s| s.sky_fine = 48),
        ("hit 0", |s| s.hit = 0),
        ("probe 4294967295", |s| s.probe = u32::MAX),
        ("bounce_sky 0", |s| s.bounce_sky = 0),
    ];
    for depth in depths {
        assert_eq!(refusal(&|_| {}, 2, depth), "");
        for (named, lie) in lies {
            let found = refusal(&lie, 2, depth);
            assert!(found.contains(named) && found.contains("copy.helio"), "{named}: {found}");
        }
    }
    let found = refusal(&|_| {}, 1, MaxBounces::All);
    assert!(found.contains("found 2 receivers, expected 1, one per response"), "{found}");
}

/// Rows of a block of mirrors, as bytes.
type Rows = Vec<Vec<u8>>;

/// Writes an archive again, with other rows in the first block of a kind.
fn forged(archive: &Archive, kind: BlockKind, path: &Path, change: &dyn Fn(&mut Rows)) {
    let job = Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] };
    let mut writer = Writer::create(path, &job).expect("created");
    for entry in archive.entries() {
        let block = archive.block(entry.kind, entry.tile).expect("a block");
        let (mut items, mut raw) = (entry.items as usize, block.bytes().to_vec());
        if entry.key() == (kind, TileNumber::FIRST) {
            let mut rows = extras::unpack(&raw, items).expect("rows");
            change(&mut rows);
            items = rows.len();
            raw = extras::pack(rows.iter().map(Vec::as_slice)).expect("bytes");
        }
        writer
            .append(encode(entry.kind, entry.tile, entry.schema, items as u32, &raw, 9).expect("packed"))
            .expect("written");
    }
    let mut manifest = archive.manifest().clone();
    manifest.layers = writer.layers();
    writer.finish(&manifest).expect("finished");
}

/// Returns the error of a replay of an archive, or `None` if it succeeds.
fn refusal_of(path: &Path, depth: MaxBounces) -> Option<String> {
    let copy = Archive::open(path).expect("an archive");
    let settings = ReplaySettings {
        patches: 145,
        paths: depth.into(),
        memory: MemoryBudget::new(1 << 28),
        ..ReplaySettings::default()
    };
    let conditions = [sun(90.0, 60.0, 800.0, 100.0)];
    let replay = OpenSite::open(&copy).and_then(|site| Replay::new(&site, &conditions, settings));
    replay.and_then(|replay| replay.run(0..replay.tiles()).map(drop)).err().map(|error| error.to_string())
}

/// Changes the first row of receivers that holds a window and a path.
fn in_receivers(change: impl Fn(&mut ReceiverMirrors)) -> impl Fn(&mut Rows) {
    move |rows| {
        let mirrors = |row: &Vec<u8>| ReceiverMirrors::from_bytes(row, 16, 8).expect("mirrors");
        let full = |row: &Vec<u8>| !mirrors(row).windows.is_empty() && !mirrors(row).paths.is_empty();
        let row = rows.iter_mut().find(|row| full(row)).expect("a row");
        let mut found = mirrors(row);
        change(&mut found);
        *row = found.to_bytes();
    }
}

/// Changes the first row of cells that holds a window and a path.
fn in_cells(change: impl Fn(&mut CellMirrors)) -> impl Fn(&mut Rows) {
    move |rows| {
        let mirrors = |row: &Vec<u8>| CellMirrors::from_bytes(row, 8).expect("mirrors");
        let full = |row: &Vec<u8>| !mirrors(row).windows.is_empty() && !mirrors(row).paths.is_empty();
        let row = rows.iter_mut().find(|row| full(row)).expect("a row");
        let mut found = mirrors(row);
        change(&mut found);
        *row = found.to_bytes(8);
    }
}

/// Sixteen lies about mirrors under right checksums (mirrors, materials and cells that do not
/// exist, a texture cut short, a row less) are each named by a deep `verify`. A replay ends with a
/// result or an error that names a block, and so it does with 60 changed bits.
#[test]
fn lying_mirrors_are_refused() {
    let settings = BuildSettings {
        sky_base: 16,
        sky_fine: 64,
        hit: 8,
        probe: 8,
        bounce_sky: 8,
        cell_floor_m: 4.0,
        ..BuildSettings::default()
    };
    let site = site(&mirror_town(), &many()[..70], &settings);
    let archive = Archive::open(&site.path).expect("an archive");
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("copy.helio");
    let nowhere = |key: &mut CellKey| key.voxel[0] = 1 << 20;
    type Lie<'l> = (BlockKind, &'l str, Box<dyn Fn(&mut Rows) + 'l>);
    let mut lies: Vec<Lie> = vec![
        (format::MIRROR, "mirror 9999", Box::new(in_receivers(|m| m.windows[0].chain = Chain::new(&[0, 9999])))),
        (format::MIRROR, "malformed", Box::new(in_receivers(|m| m.windows[0].texture.truncate(9)))),
        (format::MIRROR, "material 999", Box::new(in_receivers(|m| m.paths[0].steps[0].0 = 999))),
        (format::MIRROR, "does not exist", Box::new(in_receivers(|m| nowhere(&mut m.paths[0].cell)))),
        (format::MIRROR, "malformed", Box::new(in_receivers(|m| m.paths[0].texel = 64))),
        (format::MIRROR, "rows", Box::new(|rows| drop(rows.pop()))),
    ];
    for kind in [format::PROBE_MIRROR, format::BOUNCE_MIRROR] {
        lies.push((kind, "mirror 9999", Box::new(in_cells(|m| m.windows[0].chain = Chain::new(&[9999])))));
        lies.push((kind, "material 999", Box::new(in_cells(|m| m.paths[0].steps[0].0 = 999))));
        lies.push((kind, "does not exist", Box::new(in_cells(|m| nowhere(&mut m.paths[0].cell)))));
        lies.push((kind, "rows", Box::new(|rows| drop(rows.pop()))));
    }
    // A last path of one step ends with its key, their number and the step: the region is changed,
    // not the voxel.
    let region = |rows: &mut Rows| {
        let row = rows.iter_mut().find(|row| row.len() > 28 && row[row.len() - 4] == 1).expect("a row");
        let place = row.len() - 21;
        row[place] ^= 1;
    };
    lies.push((format::MIRROR, "malformed", Box::new(region)));
    lies.push((format::PROBE_MIRROR, "malformed", Box::new(|rows| rows.iter_mut().for_each(|row| row.truncate(6)))));
    assert_eq!(lies.len(), 16);
    let depths = [MaxBounces::All, MaxBounces::Count(1), MaxBounces::Count(2)];
    let (mut refused, mut done) = (0, 0);
    let mut replayed = |what: &str| {
        for depth in depths {
            match refusal_of(&path, depth) {
                None => done += 1,
                Some(said) => {
                    assert!(said.contains("copy.helio"), "{what}: {said}");
                    refused += 1;
                }
            }
        }
    };
    for (kind, says, lie) in &lies {
        forged(&archive, *kind, &path, lie);
        let report = verify(&path, Access::Read, true).expect("an archive");
        let name = format::block_name(*kind, TileNumber::FIRST);
        let found: Vec<_> = report.problems.iter().filter(|p| p.part == name && p.reason.contains(says)).collect();
        assert!(found.len() == 1 && report.problems.len() == 1, "{name}, {says}: {:?}", report.problems);
        replayed(&name);
    }
    for case in 0..60 {
        let kind = [format::MIRROR, format::PROBE_MIRROR, format::BOUNCE_MIRROR][case as usize % 3];
        forged(&archive, kind, &path, &|rows| {
            let full: Vec<&mut Vec<u8>> = rows.iter_mut().filter(|row| !row.is_empty()).collect();
            let (row, bit) = (mix(case, 1) % full.len() as u64, mix(case, 2));
            if let Some(row) = full.into_iter().nth(row as usize) {
                let place = (bit >> 3) as usize % row.len();
                row[place] ^= 1 << (bit & 7);
            }
        });
        verify(&path, Access::Read, true).expect("a report");
        replayed(&format!("case {case}"));
    }
    println!("{refused} replays refused, {done} done");
    assert!(refused + done == 228 && refused > 30 && done > 50, "{refused} refused, {done} done");
}
