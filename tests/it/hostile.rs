//! The corpus of the fuzzers: whatever bytes come, readers come back.

use std::fs;
use std::path::Path;
use std::process::Command;

use heliotile::archive::manifest::Settings;
use heliotile::archive::{Archive, Job, Writer, encode, format};
use heliotile::commands::build::BuildSettings;
use heliotile::recombine::bounces::Depth;
use heliotile::recombine::components::ComponentSet;
use heliotile::recombine::replay::{Replay, ReplaySettings};
use heliotile::recombine::sky::SkyModel;

use crate::scenes::{canyon, receiver, scene, site, sun, tilted, v};

#[path = "../../tools/fuzz/src/targets.rs"]
mod targets;

/// Every input of a target, by name.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/corpus").join(target);
    let mut inputs: Vec<(String, Vec<u8>)> = fs::read_dir(folder)
        .expect("a corpus")
        .map(|entry| entry.expect("an entry"))
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).expect("read")))
        .collect();
    inputs.sort();
    inputs
}

/// Set for the process that replays the corpus.
const CHILD: &str = "HELIOTILE_TEST_CORPUS_CHILD";

/// Over 100 inputs of 17 targets, valid, mutated and once crashing ones, neither panic nor take more than 1 GB of addresses,
/// threads and program included; so small they are below 300 kB in total.
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
    // A process of its own, since a limit of memory holds for all tests of one.
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

/// Every valid seed is accepted: an archive is verified without a problem, checksums that were mended are those it had.
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
    let report = heliotile::archive::verify(&path, heliotile::archive::Access::Read, true).expect("an archive");
    assert_eq!((report.problems.len(), report.blocks), (0, 9));
}

/// Eight manifests that lie about the sides of textures, and a tile with fewer responses than receivers, are refused by both
/// ways of replay where the lie matters; the honest copy of the archive is replayed.
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
    let refusal = |change: &dyn Fn(&mut Settings), rows: usize, depth: Depth| {
        let mut writer =
            Writer::create(&path, &Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] }).expect("created");
        for entry in archive.entries() {
            let block = archive.block(entry.kind, entry.tile).expect("a block");
            let (mut items, mut raw) = (entry.items as usize, block.bytes().to_vec());
            if entry.kind == format::RESPONSE && rows < items {
                raw = vec![0; raw.len() / items * rows];
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
            depth,
            components: ComponentSet::ALL,
            memory_bytes: 1 << 28,
        };
        let replay = Replay::new(&copy, &[sun(90.0, 60.0, 800.0, 100.0)], settings);
        replay.and_then(|replay| replay.run(0..1).map(drop)).err().map_or(String::new(), |error| error.to_string())
    };
    let depths = [Depth::All, Depth::Count(1)];
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
    let found = refusal(&|_| {}, 1, Depth::All);
    assert!(found.contains("found 2 receivers, expected 1, one per response"), "{found}");
}
