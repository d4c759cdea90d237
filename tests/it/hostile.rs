//! Archives that lie: readers come back with an error.

use heliotile::archive::manifest::Settings;
use heliotile::archive::{Archive, Job, Writer, encode, format};
use heliotile::commands::build::BuildSettings;
use heliotile::recombine::bounces::Depth;
use heliotile::recombine::replay::{Replay, ReplaySettings};
use heliotile::recombine::sky::SkyModel;

use crate::scenes::{canyon, receiver, scene, site, sun, tilted, v};

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
        let mut writer = Writer::create(&path, &Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] }).expect("created");
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
        let settings = ReplaySettings { sky: SkyModel::Perez, patches: 145, depth, memory_bytes: 1 << 28 };
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
