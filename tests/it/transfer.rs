//! Archives from archives: parts of a site and the whole are the same to the byte, whichever way
//! they were made.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use heliotile_archives::Workspace;
use heliotile_archives::transfer::{Differences, ExtractContent, Selection, diff, extract, merge};
use heliotile_archives::writing::{Job, Writer};
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format::{BlockKind, TileNumber};
use heliotile_core::archive::{Archive, Block, Blocks, EncodedBlock, Manifest, encode, format, tables};
use heliotile_core::hemisphere::mix;
use heliotile_core::layers::response::{self, Response};
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::observer::Silent;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use serde_json::json;
use tempfile::TempDir;

use crate::scenes::*;

/// Returns settings for tests of bytes, not of accuracy.
fn coarse() -> BuildSettings {
    BuildSettings {
        sky_base: 16,
        sky_fine: 32,
        hit: 8,
        cell_floor_m: 4.0,
        probe: 8,
        probe_hits: 4,
        bounce_sky: 8,
        bounce_hits: 8,
        ..BuildSettings::default()
    }
}

/// A scratch folder of archives.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().expect("a scratch folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("an archive")
    }

    /// Builds the town, whose blocks reflect a share of the light, for some receivers.
    fn build(&self, name: &str, receivers: &[Receiver], settings: &BuildSettings, diffuse: f64) {
        let scene = scene(&town(), &[0.2, diffuse]);
        build(&scene, &mut tiles(receivers, &scene), &plan(settings, &self.path(name))).expect("a build");
    }

    /// Builds the town with one more block of mirrors and one more of glass, for some receivers.
    fn build_mirrors(&self, name: &str, receivers: &[Receiver]) {
        let scene = mirror_town();
        build(&scene, &mut tiles(receivers, &scene), &plan(&coarse(), &self.path(name))).expect("a build");
    }

    fn merge(&self, first: &str, second: &str, output: &str) -> heliotile_core::error::Result<[u64; 2]> {
        let [first, second] = [first, second].map(|name| self.open(name));
        let merged = merge([&first?, &second?], &self.path(output), &self.workspace(), &Silent)?;
        Ok([merged.written.receivers, merged.shared])
    }

    /// Checks that a merge is refused and leaves no file; returns its message.
    fn refused(&self, first: &str, second: &str) -> String {
        let message = self.merge(first, second, "refused.helio").expect_err("a refusal").to_string();
        assert!(!self.path("refused.helio").exists() && !self.path("refused.helio.partial").exists());
        message
    }

    fn extract(&self, from: &str, output: &str, ids: &[&str]) -> heliotile_core::error::Result<u64> {
        let list = self.path("ids.csv");
        fs::write(&list, format!("receiver\n{}\n", ids.join("\n"))).expect("a writable folder");
        let (archive, list) = (self.open(from)?, Selection::Receivers(list));
        let content = ExtractContent { scene: true, replay_only: false };
        Ok(extract(&archive, Some(&list), content, &self.path(output), &self.workspace(), &Silent)?.written.receivers)
    }

    fn diff(&self, first: &str, second: &str) -> Differences {
        self.try_diff(first, second).expect("a comparison")
    }

    fn try_diff(&self, first: &str, second: &str) -> heliotile_core::error::Result<Differences> {
        diff(&self.open(first)?, &self.open(second)?, &self.workspace())
    }

    fn open(&self, name: &str) -> heliotile_core::error::Result<Archive> {
        Archive::open(&self.path(name))
    }

    fn workspace(&self) -> Workspace {
        workspace(self.0.path(), 64 << 20)
    }

    /// Writes an archive again, with other or more blocks, and another manifest.
    fn forge(
        &self,
        from: &str,
        output: &str,
        change: impl Fn(&Block) -> Option<EncodedBlock>,
        more: Vec<EncodedBlock>,
        state: impl Fn(&mut Manifest),
    ) {
        let archive = Archive::open(&self.path(from)).expect("an archive");
        let job = Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] };
        let mut writer = Writer::create(&self.path(output), &job).expect("a writer");
        let mut entries = archive.entries().to_vec();
        entries.sort_by_key(|entry| entry.offset);
        for entry in entries {
            let changed = change(&archive.block(entry.kind, entry.tile).expect("a block"));
            writer.append(changed.unwrap_or_else(|| archive.copy(&entry).expect("a block"))).expect("written");
        }
        more.into_iter().for_each(|block| writer.append(block).expect("written"));
        let mut manifest = archive.manifest().clone();
        manifest.layers = writer.layers();
        state(&mut manifest);
        writer.finish(&manifest).expect("an archive");
    }
}

fn ids(receivers: &[Receiver]) -> Vec<&str> {
    receivers.iter().map(|receiver| receiver.id.as_str()).collect()
}

/// Parts of a town of 150 receivers built apart merge to the bytes of the whole: halves apart,
/// halves that share 20 receivers, odd and even ones, one and all; 4 pairs, each in both orders,
/// and the whole with itself: 9 of 9.
#[test]
fn parts_merge_to_the_whole() {
    let folder = Folder::new();
    let settings = BuildSettings { sky_fine: 512, probe: 16, ..BuildSettings::default() };
    let all = many();
    folder.build("whole.helio", &all, &settings, 0.4);
    let whole = folder.bytes("whole.helio");
    let every = |n: usize, rest: usize| -> Vec<Receiver> {
        all.iter().enumerate().filter(|(i, _)| i % n == rest).map(|(_, r)| r.clone()).collect()
    };
    let pairs = [
        (all[..70].to_vec(), all[70..].to_vec(), 0),
        (all[..85].to_vec(), all[65..].to_vec(), 20),
        (every(2, 0), every(2, 1), 0),
        (all[77..78].to_vec(), all.clone(), 1),
    ];
    for (number, (a, b, shared)) in pairs.into_iter().enumerate() {
        folder.build("a.helio", &a, &settings, 0.4);
        folder.build("b.helio", &b, &settings, 0.4);
        for (first, second) in [("a.helio", "b.helio"), ("b.helio", "a.helio")] {
            assert_eq!(folder.merge(first, second, "c.helio").expect("a merge"), [150, shared]);
            assert!(folder.bytes("c.helio") == whole, "pair {number}: {first} and {second} give other bytes");
        }
    }
    assert_eq!(folder.merge("whole.helio", "whole.helio", "c.helio").expect("a merge"), [150, 150]);
    assert!(folder.bytes("c.helio") == whole);
}

/// Returns the number of cases of the property test; `tools/transfer-cases` sets more.
fn cases() -> u64 {
    std::env::var("HELIOTILE_TRANSFER_CASES").ok().and_then(|count| count.parse().ok()).unwrap_or(100)
}

/// For 100 random selections of 150 receivers, of 1 to 149, scattered or in a row, the extract and
/// its complement merge to the original bytes, and an extract of the extract has the bytes of the
/// extract itself.
#[test]
fn extract_and_complement_merge_to_the_original() {
    let folder = Folder::new();
    let all = many();
    folder.build("whole.helio", &all, &coarse(), 0.4);
    let whole = folder.bytes("whole.helio");
    for case in 0..cases() {
        let share = 1 + mix(case, 1) % 99;
        let start = mix(case, 2) % 150;
        let chosen = |i: u64| match case % 3 {
            0 => (i + 150 - start) % 150 < share * 3 / 2,
            _ => mix(mix(case, 3), i) % 100 < share,
        };
        let (mut some, mut rest): (Vec<_>, Vec<_>) = (0..150).partition(|&i| chosen(i));
        // Neither side may be empty.
        if some.is_empty() {
            some.extend(rest.pop());
        } else if rest.is_empty() {
            rest.extend(some.pop());
        }
        let names = |list: &[u64]| -> Vec<&str> { list.iter().map(|&i| all[i as usize].id.as_str()).collect() };
        let (some, rest) = (names(&some), names(&rest));
        assert_eq!(folder.extract("whole.helio", "a.helio", &some).expect("an extract"), some.len() as u64);
        assert_eq!(folder.extract("whole.helio", "b.helio", &rest).expect("an extract"), rest.len() as u64);
        let (first, second) = if case % 2 == 0 { ("a.helio", "b.helio") } else { ("b.helio", "a.helio") };
        assert_eq!(folder.merge(first, second, "c.helio").expect("a merge"), [150, 0], "case {case}");
        assert!(folder.bytes("c.helio") == whole, "case {case}: other bytes");
        if case % 10 == 0 {
            folder.extract("a.helio", "again.helio", &some).expect("an extract");
            assert!(folder.bytes("again.helio") == folder.bytes("a.helio"), "case {case}: another extract");
        }
    }
}

/// An extract is the build of its receivers: for 1, 64 and 100 of 150 receivers it has the same
/// bytes, and the same irradiance to the bit as the original, under 2 skies, for all bounces and
/// for 2.
#[test]
fn an_extract_is_a_build() {
    let folder = Folder::new();
    let all = many();
    folder.build("whole.helio", &all, &coarse(), 0.4);
    let light = |name: &str, sky, depth| -> BTreeMap<String, Vec<Row>> {
        let conditions = [sun(150.0, 35.0, 700.0, 120.0), sun(260.0, 8.0, 300.0, 60.0)];
        replay(&folder.path(name), &conditions, sky, depth, 145)
    };
    for some in [&all[42..43], &all[30..94], &all[50..]] {
        folder.extract("whole.helio", "part.helio", &ids(some)).expect("an extract");
        folder.build("built.helio", some, &coarse(), 0.4);
        assert!(folder.bytes("part.helio") == folder.bytes("built.helio"), "{} receivers", some.len());
        for (sky, depth) in [(SkyModel::Perez, MaxBounces::All), (SkyModel::Uniform, MaxBounces::Count(2))] {
            let (part, whole) = (light("part.helio", sky, depth), light("whole.helio", sky, depth));
            assert_eq!(part.len(), some.len());
            assert!(part.iter().all(|(id, rows)| whole[id] == *rows));
            assert!(part.values().any(|rows| rows[0].sun_reflected > 1.0));
        }
    }
}

/// An archive does not differ from itself or from its parts merged. From an extract it differs by
/// the 50 receivers left out, 20 of them named, and by cells of one side only.
#[test]
fn diff_finds_nothing_or_what_is_missing() {
    let folder = Folder::new();
    let all = many();
    folder.build("whole.helio", &all, &coarse(), 0.4);
    folder.extract("whole.helio", "a.helio", &ids(&all[..100])).expect("an extract");
    let same = folder.diff("whole.helio", "whole.helio");
    assert!(same.is_equal() && same.same_root);
    let less = folder.diff("whole.helio", "a.helio");
    assert!(!less.is_equal() && !less.same_root && less.statements.is_empty());
    let counts = |p: &heliotile_archives::transfer::Parted| [p.only_a.count, p.only_b.count, p.different.count];
    assert_eq!((counts(&less.receivers), less.receivers.only_a.first.len()), ([50, 0, 0], 20));
    let probes = |name: &str| Archive::open(&folder.path(name)).expect("an archive").manifest().counts.probes;
    assert_eq!(counts(&less.probes), [probes("whole.helio") - probes("a.helio"), 0, 0]);
    // Compressed at another level, the content is the same.
    let repack = |block: &Block| {
        let entry = block.entry();
        Some(encode(entry.kind, entry.tile, entry.schema, entry.items, block.bytes(), 1).expect("a block"))
    };
    folder.forge("whole.helio", "fast.helio", repack, Vec::new(), |_| {});
    let packed = folder.diff("whole.helio", "fast.helio");
    assert!(packed.is_equal() && !packed.same_root);
    // A merge compresses it as the build does.
    folder.merge("fast.helio", "fast.helio", "merged.helio").expect("a merge");
    assert!(folder.bytes("merged.helio") == folder.bytes("whole.helio"));
}

/// A changed reflectance, a changed setting, and three changed receivers (moved, turned, of another
/// area) are reported, each by its name and nothing else: 3 of 3.
#[test]
fn diff_names_what_changed() {
    let folder = Folder::new();
    let some = many()[..70].to_vec();
    folder.build("a.helio", &some, &coarse(), 0.4);
    let items = |found: &Differences| -> Vec<String> {
        found.statements.iter().map(|d| format!("{} {} {}", d.item, d.values[0], d.values[1])).collect()
    };

    folder.build("b.helio", &some, &coarse(), 0.5);
    let found = folder.diff("a.helio", "b.helio");
    let told = items(&found);
    assert!(told.len() == 2 && told[0] == "materials.m1.diffuse 0.4 0.5", "{told:?}");
    assert!(told[1].starts_with("scene.content_hash "), "{told:?}");
    assert!(found.receivers.different.first.iter().all(|name| name.ends_with(" (response)")));
    let counts = (found.receivers.different.count, found.probes.different.count, found.bounces.different.count);
    // The responses agree: some 20 receivers see sky or far ground only, lie in a block or change
    // by less than a step, and keep their light.
    let responses = |name: &str| -> Vec<Response> {
        let archive = Archive::open(&folder.path(name)).expect("an archive");
        (0..archive.tiles())
            .flat_map(|tile| OpenSite::open(&archive).expect("a site").tile_responses(tile).expect("responses"))
            .collect()
    };
    let (before, after) = (responses("a.helio"), responses("b.helio"));
    let changed = before.iter().zip(&after).filter(|(a, b)| a != b).count();
    assert_eq!(counts, (changed as u64, 0, 0));
    assert!((48..=52).contains(&changed), "{changed}");

    folder.build("b.helio", &some, &BuildSettings { hit: 16, ..coarse() }, 0.4);
    let found = folder.diff("a.helio", "b.helio");
    assert_eq!(items(&found), ["settings.hit 8 16"]);

    let mut changed = some.clone();
    changed[3].position.z += 1e-9;
    changed[4].normal = tilted(1.0, 2.0);
    changed[5].area = Some(2.5);
    folder.build("b.helio", &changed, &coarse(), 0.4);
    let found = folder.diff("a.helio", "b.helio");
    assert!(found.statements.is_empty() && found.receivers.only_a.count + found.receivers.only_b.count == 0);
    let names = &found.receivers.different.first;
    assert!(names.len() == 3 && names[0].starts_with("r003 (place"), "{names:?}");
    assert!(names[1].starts_with("r004 (place") && names[2] == "r005 (receivers)", "{names:?}");
}

/// Archives of another scene or with other settings are refused by the names of 3 differing items
/// with both values.
#[test]
fn other_sites_are_not_merged() {
    let folder = Folder::new();
    let some = many()[..5].to_vec();
    folder.build("a.helio", &some, &coarse(), 0.4);
    folder.build("b.helio", &some, &BuildSettings { hit: 16, ..coarse() }, 0.5);
    let message = folder.refused("a.helio", "b.helio");
    for part in [
        "settings.hit is 8 in that archive and 16 in this one",
        "materials.m1.diffuse is 0.4 in that archive and 0.5 in this one",
        "content_hash",
    ] {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
    assert!(message.starts_with(&folder.path("b.helio").display().to_string()), "{message}");
}

/// 12 moved receivers, one of another area and one with another sky are 14 conflicts, of which 10
/// are named; a changed probe and a changed bounce cell are 2 more kinds. No file is written.
#[test]
fn conflicts_are_named() {
    let folder = Folder::new();
    let some = many()[..80].to_vec();
    folder.build("a.helio", &some, &coarse(), 0.4);
    let mut changed = some.clone();
    changed[0].area = Some(1.0);
    changed[20..32].iter_mut().for_each(|receiver| receiver.position.x += 0.5);
    folder.build("b.helio", &changed, &coarse(), 0.4);
    let message = folder.refused("a.helio", "b.helio");
    assert!(message.contains("13 conflicts: receiver r000 (receivers), receiver r020 (at "), "{message}");
    assert!(message.contains("r028") && !message.contains("r029") && message.contains(", ..."), "{message}");

    let change = |kind: BlockKind| {
        move |block: &Block| -> Option<EncodedBlock> {
            (block.entry().kind == kind && block.entry().tile == TileNumber::FIRST).then(|| {
                let mut table = tables::CellsTable::from_block(block).expect("cells");
                table.bits[0] ^= 1;
                table.encode(kind, TileNumber::FIRST, 9).expect("a block")
            })
        }
    };
    for (kind, name) in [(format::PROBES, "1 conflict: probe "), (format::BOUNCE, "1 conflict: bounce cell ")] {
        folder.forge("a.helio", "b.helio", change(kind), Vec::new(), |_| {});
        let message = folder.refused("a.helio", "b.helio");
        assert!(message.contains(name), "{message}");
        let found = folder.diff("a.helio", "b.helio");
        assert_eq!(found.probes.different.count + found.bounces.different.count, 1);
    }
    let response = |block: &Block| -> Option<EncodedBlock> {
        let entry = *block.entry();
        (entry.key() == (format::RESPONSE, TileNumber(1))).then(|| {
            let tile = response::unpack(block.bytes(), entry.items as usize, coarse().probe);
            let mut tile = tile.expect("responses");
            tile[0].values.iter_mut().for_each(|value| *value += 0.1);
            let raw = response::pack(&tile).expect("a side of eights");
            encode(entry.kind, TileNumber(1), entry.schema, entry.items, &raw, 9).expect("a block")
        })
    };
    folder.forge("a.helio", "b.helio", response, Vec::new(), |_| {});
    let message = folder.refused("b.helio", "a.helio");
    assert!(message.contains("1 conflict: receiver ") && message.contains("(response)"), "{message}");
}

/// Two blocks of unknown kinds and keys of the manifest on 4 levels pass through extract and merge.
/// An equal block is kept once; a different one is a conflict, and so is a different key.
#[test]
fn unknown_blocks_and_keys_are_kept() {
    let folder = Folder::new();
    let all = many();
    folder.build("whole.helio", &all, &coarse(), 0.4);
    let later = |tile: u32, raw: &[u8]| encode(BlockKind(77), TileNumber(tile), 9, 5, raw, 9).expect("a block");
    let state = |key: &'static str| {
        move |manifest: &mut Manifest| {
            let Manifest { other, scene, receivers, settings, .. } = manifest;
            for other in [other, &mut scene.other, &mut receivers.other, &mut settings.other] {
                other.insert("later".into(), json!({ "key": key }));
            }
        }
    };
    let none = |_: &Block| None;
    folder.forge("whole.helio", "a.helio", none, vec![later(0, b"equal"), later(1, b"one")], state("x"));
    folder.forge("whole.helio", "b.helio", none, vec![later(0, b"equal"), later(2, b"two")], state("x"));
    folder.extract("a.helio", "part.helio", &ids(&all[..100])).expect("an extract");
    folder.merge("part.helio", "b.helio", "c.helio").expect("a merge");
    let merged = Archive::open(&folder.path("c.helio")).expect("an archive");
    let kept: Vec<Vec<u8>> = merged.scan(BlockKind(77)).map(|block| block.expect("a block").bytes().to_vec()).collect();
    assert_eq!(kept, [&b"equal"[..], b"one", b"two"]);
    let json = String::from_utf8(merged.manifest().to_json().expect("a manifest")).expect("UTF-8");
    assert_eq!(json.matches("\"later\"").count(), 4);
    assert!(merged.has(format::RESPONSE, TileNumber(2)) && !Blocks::has(&merged, format::RESPONSE, TileNumber(3)));

    folder.forge("whole.helio", "b.helio", none, vec![later(1, b"other")], state("x"));
    assert!(folder.refused("a.helio", "b.helio").contains("1 conflict: block kind-77/1"));
    folder.forge("whole.helio", "b.helio", none, vec![], state("y"));
    assert!(
        folder
            .refused("a.helio", "b.helio")
            .contains("settings.later.key is \"x\" in that archive and \"y\" in this one")
    );
}

/// An archive whose receivers are not in the order of a build is refused by the name of the block,
/// not merged wrongly: 1 of 1.
#[test]
fn other_orders_are_refused() {
    let folder = Folder::new();
    let some = many()[..5].to_vec();
    folder.build("a.helio", &some, &coarse(), 0.4);
    let swap = |block: &Block| {
        (block.entry().kind == format::RECEIVERS).then(|| {
            let mut table = tables::ReceiversTable::from_block(block).expect("receivers");
            table.position.swap(0, 1);
            table.encode(format::RECEIVERS, TileNumber::FIRST, 9).expect("a block")
        })
    };
    folder.forge("a.helio", "b.helio", swap, Vec::new(), |_| {});
    let message = folder.refused("a.helio", "b.helio");
    assert!(message.contains("block receivers/0") && message.contains("Morton"), "{message}");
}

/// Parts of a town with mirrors and glass merge to the bytes of the whole, in both orders, halves
/// apart and with 10 shared receivers; an extract of 30 of 70 has the bytes of its own build, with
/// all 3 kinds of blocks of mirrors: 5 of 5.
#[test]
fn mirrors_are_merged_and_extracted() {
    let folder = Folder::new();
    let all = many()[..70].to_vec();
    folder.build_mirrors("whole.helio", &all);
    let whole = folder.bytes("whole.helio");
    for (a, b, shared) in [(&all[..35], &all[35..], 0), (&all[..45], &all[35..], 10)] {
        folder.build_mirrors("a.helio", a);
        folder.build_mirrors("b.helio", b);
        for (first, second) in [("a.helio", "b.helio"), ("b.helio", "a.helio")] {
            assert_eq!(folder.merge(first, second, "c.helio").expect("a merge"), [70, shared]);
            assert!(folder.bytes("c.helio") == whole, "{first} and {second}, {shared} shared: other bytes");
        }
    }
    folder.extract("whole.helio", "part.helio", &ids(&all[20..50])).expect("an extract");
    folder.build_mirrors("built.helio", &all[20..50]);
    assert!(folder.bytes("part.helio") == folder.bytes("built.helio"));
    let part = Archive::open(&folder.path("part.helio")).expect("an archive");
    let kinds = [format::MIRROR, format::PROBE_MIRROR, format::BOUNCE_MIRROR, format::MIRRORS, format::OPTICS];
    assert!(kinds.iter().all(|&kind| !part.entries_of(kind).is_empty()));
}

/// For 170 archives with a changed byte, 10 of each of 17 kinds of block, under right checksums,
/// extract, merge and diff end with a result or an error, none panics, and no partial file stays.
#[test]
fn hostile_archives_are_survived() {
    let folder = Folder::new();
    let some = many()[..70].to_vec();
    folder.build_mirrors("a.helio", &some);
    let archive = Archive::open(&folder.path("a.helio")).expect("an archive");
    let entries = archive.entries();
    let mut kinds: Vec<BlockKind> = entries.iter().map(|entry| entry.kind).collect();
    kinds.dedup();
    assert_eq!(kinds.len(), 17);
    let (mut refused, mut done) = (0, 0);
    for case in 0..170 {
        // Each kind gets its turn, with a change near the end of the block, where the columns of
        // tables are named, or anywhere.
        let kind = kinds[case as usize % kinds.len()];
        let of_kind: Vec<_> = entries.iter().filter(|entry| entry.kind == kind).collect();
        let entry = of_kind[(mix(case, 1) % of_kind.len() as u64) as usize];
        let length = u64::from(entry.raw);
        let from_end = mix(case, 2) % if case % 3 == 0 { length.min(80) } else { length };
        let change = |block: &Block| {
            (block.entry().key() == entry.key()).then(|| {
                let mut raw = block.bytes().to_vec();
                let place = raw.len() - 1 - from_end as usize;
                raw[place] ^= 1 << (mix(case, 3) % 8);
                encode(entry.kind, entry.tile, entry.schema, entry.items, &raw, 9).expect("a block")
            })
        };
        folder.forge("a.helio", "bad.helio", change, Vec::new(), |_| {});
        let compared = folder.try_diff("a.helio", "bad.helio");
        assert!(compared.as_ref().map_or(true, |found| !found.is_equal() || !found.same_root));
        let merged = folder.merge("bad.helio", "a.helio", "c.helio");
        let extracted = folder.extract("bad.helio", "d.helio", &["r001", "r069"]);
        for failed in [compared.is_err(), merged.is_err(), extracted.is_err()] {
            *if failed { &mut refused } else { &mut done } += 1;
        }
    }
    assert!(refused + done == 510 && refused > 150 && done > 50, "{refused} refused, {done} done");
    assert!(files(folder.0.path()).iter().all(|name| !name.contains("partial")));
}

/// Returns the names of the files in a folder.
fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Ids that do not exist are named with their lines, 10 of 12. The archive that is read is not
/// replaced, and the folder holds no other file afterwards.
#[test]
fn wrong_selections_are_refused() {
    let folder = Folder::new();
    let some = many()[..5].to_vec();
    folder.build("a.helio", &some, &coarse(), 0.4);
    let before = folder.bytes("a.helio");
    let wrong: Vec<String> = (0..12).map(|i| format!("x{i:02}")).collect();
    let mut ids: Vec<&str> = wrong.iter().map(String::as_str).collect();
    ids.insert(1, "r001");
    let message = folder.extract("a.helio", "b.helio", &ids).expect_err("a refusal").to_string();
    assert!(message.contains("ids.csv: ") && message.contains("12 receivers: x00 (line 2), x01 (line 4)"), "{message}");
    assert!(message.contains("x09") && !message.contains("x10") && message.contains(", ..."), "{message}");
    let message = folder.extract("a.helio", "a.helio", &["r001"]).expect_err("a refusal").to_string();
    assert!(message.contains("is also an input"), "{message}");
    let message = folder.merge("a.helio", "a.helio", "a.helio").expect_err("a refusal").to_string();
    assert!(message.contains("is also an input"), "{message}");
    assert!(folder.bytes("a.helio") == before);
    assert_eq!(files(folder.0.path()), ["a.helio", "ids.csv"]);
}
