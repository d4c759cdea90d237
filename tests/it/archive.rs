//! Whole archives: equal inputs give equal bytes; stored and derived layers agree.

use std::fs;

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Archive, format};
use heliotile_core::hemisphere::texel_centres;
use heliotile_core::layers::response;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::response_solver::ResponseSolver;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::light::tables::Tables;
use heliotile_core::light::tile_view::TileView;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;

use crate::scenes::*;

/// Builds on one and on two threads, and with receivers and faces in another order, give one root
/// hash and the same bytes.
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

/// The response layer of the archive is the derived response coded, to the byte. Along the
/// directions of its texels it is within 0.62 steps of 2^-12 RMS of the derived one for the 150
/// receivers.
#[test]
fn cached_response_is_the_derived_one() {
    let site = site(&scene(&town(), &[0.2, 0.4]), &many(), &fine());
    let archive = Archive::open(&site.path).expect("an archive");
    let open = OpenSite::open(&archive).expect("a site");
    let tables = Tables::new(&open).expect("tables");
    let responder =
        ResponseSolver::new(&tables, MaxBounces::All, MemoryBudget::DEFAULT, &InMemory).expect("a responder");
    let views: Vec<_> = (0..archive.tiles()).map(|tile| TileView::read(&open, tile).expect("a tile")).collect();
    let centres = texel_centres(fine().probe);
    let along = |v: [f32; 3], s: &glam::DVec3| s.dot(glam::DVec3::from(v.map(f64::from)));
    let (mut square, mut compared) = (0.0, 0);
    for (tile, states) in (0..).zip(&responder.derive(&tables, &views).expect("responses")) {
        let block = archive.block(format::RESPONSE, TileNumber(tile)).expect("a block");
        assert!(response::pack(&states[0]).as_deref() == Some(block.bytes()), "tile {tile}");
        for (derived, cached) in states[0].iter().zip(&open.tile_responses(tile).expect("responses")) {
            for ((a, b), s) in derived.vectors().into_iter().zip(cached.vectors()).zip(&centres) {
                square += (along(a, s) - along(b, s)).powi(2);
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 150 * 1024);
    let rms = (square / f64::from(compared)).sqrt();
    assert!(rms > 0.0 && rms < 0.62 / 4096.0, "{rms}");
}

/// With more bounces there is more light on a receiver in a street: 1 < 2 < 3 < all, and the third
/// bounce adds less than the second.
#[test]
fn more_bounces_bring_more_light() {
    let site = site(
        &scene(&canyon(10.0, 14.0, 400.0), &[0.5, 0.5]),
        &[receiver("r", v(0.1, 0.2, 0.0), tilted(0.0, 0.0))],
        &fine(),
    );
    let light = |depth| {
        site.replay(&[sun(90.0, 60.0, 800.0, 100.0)], heliotile_core::sky::model::SkyModel::Perez, depth)["r"][0].total
    };
    let [one, two, three, all] =
        [MaxBounces::Count(1), MaxBounces::Count(2), MaxBounces::Count(3), MaxBounces::All].map(light);
    assert!(one < two && two < three && three < all, "{one} {two} {three} {all}");
    assert!(three - two < two - one && all - three < two - one, "{one} {two} {three} {all}");
}
