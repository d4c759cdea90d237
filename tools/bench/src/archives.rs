//! What trust costs: opening an archive of 100,000 blocks, and the checksums of a query.

use std::path::Path;
use std::time::Instant;

use heliotile_archives::writing::{Job, Writer};
use heliotile_core::archive::format;
use heliotile_core::archive::format::{BlockKind, TileNumber, kind_name};
use heliotile_core::archive::{Access, Archive, Manifest, encode};
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::sky::model::SkyModel;
use heliotile_files::input::weather::read_conditions;

/// Median of some runs, milliseconds.
fn median_ms(mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..31)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Opening an archive of `blocks` small blocks.
pub fn open(blocks: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("many.helio");
    let mut writer =
        Writer::create(&path, &Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] }).expect("created");
    for tile in 0..blocks {
        let raw: Vec<u8> = (0..64).map(|i| (tile.wrapping_mul(2_654_435_761) >> (i % 24)) as u8).collect();
        writer
            .append(encode(BlockKind(0x8000_0000), TileNumber(tile), 1, 1, &raw, 1).expect("packed"))
            .expect("written");
    }
    let mut manifest = Manifest::new();
    manifest.receivers.tile_size = 64;
    manifest.layers = writer.layers();
    writer.finish(&manifest).expect("finished");
    for access in [Access::Mapped, Access::Read] {
        let ms = median_ms(|| drop(Archive::open_with(&path, access).expect("an archive")));
        println!("open {blocks} blocks, {access:?}: {ms:.2} ms");
    }
}

/// One condition against an archive, and what of it are checksums.
pub fn query(archive: &Path, conditions: &Path) {
    let conditions = read_conditions(conditions).expect("conditions").conditions;
    let archive = Archive::open_with(archive, Access::Mapped).expect("an archive");
    let settings = ReplaySettings {
        sky: SkyModel::Perez,
        patches: 577,
        paths: MaxBounces::All.into(),
        components: ComponentSet::ALL,
        memory: MemoryBudget::new(1 << 30),
        storage: &InMemory,
    };
    let whole = median_ms(|| {
        let replay = Replay::new(&OpenSite::open(&archive).expect("a site"), &conditions, settings).expect("a replay");
        replay.run(0..replay.tiles()).expect("results");
    });
    let stored: Vec<Vec<u8>> = [format::RECEIVERS, format::SKY, format::RESPONSE]
        .iter()
        .flat_map(|&kind| archive.entries_of(kind))
        .map(|entry| archive.copy(entry).unwrap_or_else(|_| panic!("{}", kind_name(entry.kind))).stored().to_vec())
        .collect();
    let bytes: usize = stored.iter().map(Vec::len).sum();
    let sums = median_ms(|| {
        stored.iter().for_each(|bytes| {
            std::hint::black_box(format::checksum(bytes));
        });
    });
    println!("replay of {} conditions: {whole:.1} ms; checksums of its {bytes} bytes: {sums:.2} ms", conditions.len());
}
