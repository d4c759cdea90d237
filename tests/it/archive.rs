//! The archive as a whole: equal inputs, equal bytes; cached and derived layers agree.

use std::fs;

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::light::radiosity::Depth;
use heliotile_core::light::response_solver::Responder;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::light::tables::Tables;
use heliotile_core::light::tile_view::TileView;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;

use crate::scenes::*;

/// One and two threads, receivers and faces in another order: one root hash and the same bytes.
#[test]
fn bytes_depend_on_content_only() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let settings = BuildSettings { sky_fine: 512, probe: 16, ..fine() };
    let with = |name: &str, threads: usize, reversed: bool| {
        let path = folder.path().join(name);
        let (mut triangles, mut receivers) = (town(), many());
        if reversed {
            triangles.reverse();
            receivers.reverse();
        }
        let scene = scene(&triangles, &[0.2, 0.4]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let report =
            pool.install(|| build(&scene, &mut tiles(&receivers, &scene), &plan(&settings, &path))).expect("a build");
        (report.root, fs::read(path).expect("the archive"))
    };
    let first = with("a.helio", 1, false);
    for (name, threads, reversed) in [("b.helio", 2, false), ("c.helio", 2, true)] {
        let other = with(name, threads, reversed);
        assert_eq!(first.0, other.0, "{name}");
        assert!(first.1 == other.1, "{name} has other bytes");
    }
}

/// The response layer of the archive is the derived response rounded to 16-bit floats: within 5e-4 of each value.
#[test]
fn cached_response_is_the_derived_one() {
    let site = site(&scene(&town(), &[0.2, 0.4]), &many(), &fine());
    let archive = Archive::open(&site.path).expect("an archive");
    let tables = Tables::of(&OpenSite::of(&archive).expect("a site")).expect("tables");
    let responder = Responder::new(&tables, Depth::All, MemoryBudget::DEFAULT, &InMemory).expect("a responder");
    let views: Vec<_> = (0..archive.tiles())
        .map(|tile| TileView::read(&OpenSite::of(&archive).expect("a site"), tile).expect("a tile"))
        .collect();
    let mut compared = 0;
    for (tile, states) in responder.derive(&tables, &views).expect("responses").iter().enumerate() {
        let derived = &states[0];
        for (derived, cached) in
            derived.iter().zip(&OpenSite::of(&archive).expect("a site").tile_responses(tile as u32).expect("responses"))
        {
            for (a, b) in derived.values.iter().zip(&cached.values) {
                assert!((a - b).abs() <= 5e-4 * a.abs() + 1e-7, "{a} {b}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 150 * 2 * 3 * 1024);
}

/// More bounces, more light: on every receiver 1 <= 2 <= 3 <= all, and the third adds less than the second.
#[test]
fn bounces_add_up() {
    let site = site(
        &scene(&canyon(10.0, 14.0, 400.0), &[0.5, 0.5]),
        &[receiver("r", v(0.1, 0.2, 0.0), tilted(0.0, 0.0))],
        &fine(),
    );
    let light = |depth| {
        site.replay(&[sun(90.0, 60.0, 800.0, 100.0)], heliotile_core::sky::model::SkyModel::Perez, depth)["r"][0].total
    };
    let [one, two, three, all] = [Depth::Count(1), Depth::Count(2), Depth::Count(3), Depth::All].map(light);
    assert!(one < two && two < three && three < all, "{one} {two} {three} {all}");
    assert!(three - two < two - one && all - three < two - one, "{one} {two} {three} {all}");
}
