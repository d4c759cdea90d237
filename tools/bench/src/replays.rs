//! What replay costs on one core: receiver-years a second by component, with responses stored and derived anew, beside what the machine
//! can do: a product of matrices and a copy.

use std::path::Path;
use std::time::Instant;

use heliotile_core::opened::OpenSite;
use heliotile_core::archive::Archive;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::weather::conditions::Condition;
use heliotile::files::read_weather;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::light::states::Schedule;
use ndarray::Array2;

/// Runs of each measurement; the median counts.
const RUNS: usize = 5;

fn median_s(mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

/// GFLOP/s of a product of 1024 x 1024 matrices, and GB/s of a copy of 256 MB (bytes read and written).
fn machine() -> (f64, f64) {
    let a = Array2::from_shape_fn((1024, 1024), |(i, j)| ((i * 31 + j * 17) % 97) as f32);
    let product = median_s(|| {
        std::hint::black_box(a.dot(&a.t()));
    });
    let (from, mut to) = (vec![1_u8; 256 << 20], vec![0_u8; 256 << 20]);
    let copy = median_s(|| to.copy_from_slice(std::hint::black_box(&from)));
    (2.0 * 1024_f64.powi(3) / product / 1e9, 2.0 * from.len() as f64 / copy / 1e9)
}

/// Prints the table for one archive.
pub fn run(path: &Path, weather: &Path) {
    let (peak, copy) = machine();
    println!("one core: product of matrices {peak:.1} GFLOP/s, copy {copy:.1} GB/s");
    let archive = Archive::open(path).expect("an archive");
    let conditions = read_weather(weather).expect("weather").conditions(1);
    let receivers = archive.manifest().receivers.count as f64;
    println!("{}: {receivers} receivers, {} hours", path.display(), conditions.len());
    let year = Bins { count: 1, of_condition: vec![(0, 1e-3); conditions.len()] };
    let hours = Bins::each(conditions.len());
    let anew = [Schedule { materials: vec![0], values: vec![0.31; conditions.len()] }];
    use Component::*;
    let all = ComponentSet::ALL;
    let of = |components: &[Component]| ComponentSet::of(components);
    println!("{:34} {:>10} {:>14} {:>12} {:>9}", "", "set-up, s", "receivers/s", "us/receiver", "GFLOP/s");
    for (name, bins, components, schedules) in [
        ("yearly sums", &year, all, &[][..]),
        ("  sun_direct", &year, of(&[SunDirect]), &[]),
        ("  sky_direct", &year, of(&[SkyDirect]), &[]),
        ("  sun_diffuse", &year, of(&[SunDiffuse]), &[]),
        ("  sky_diffuse", &year, of(&[SkyDiffuse]), &[]),
        ("hours", &hours, all, &[]),
        ("  sun_direct", &hours, of(&[SunDirect]), &[]),
        ("  sky_direct", &hours, of(&[SkyDirect]), &[]),
        ("  sun_diffuse", &hours, of(&[SunDiffuse]), &[]),
        ("  sky_diffuse", &hours, of(&[SkyDiffuse]), &[]),
        ("yearly sums, responses anew", &year, all, &anew),
    ] {
        let settings = ReplaySettings { components, ..ReplaySettings::default() };
        let make = || Replay::scheduled(&OpenSite::of(&archive).expect("a site"), &conditions, settings, bins, schedules).expect("a replay");
        // Deriving takes long: once is enough.
        let start = Instant::now();
        let mut replay = make();
        let mut setup = start.elapsed().as_secs_f64();
        if schedules.is_empty() {
            setup = median_s(|| replay = make());
        }
        let all_tiles = || {
            for tiles in (0..replay.tiles()).collect::<Vec<_>>().chunks(16) {
                std::hint::black_box(replay.run(tiles.iter().copied()).expect("results"));
            }
        };
        let start = Instant::now();
        all_tiles();
        let mut seconds = start.elapsed().as_secs_f64();
        if seconds < 2.0 {
            seconds = median_s(all_tiles);
        }
        // Patches times results with a sky, for the direct and the reflected part.
        let parts = [SkyDirect, SkyDiffuse].iter().filter(|c| components.needs(**c)).count() as f64;
        let skies = if bins.count == 1 { 1.0 } else { lit(&conditions) };
        let flop = 2.0 * parts * receivers * 577.0 * skies;
        println!(
            "{name:34} {setup:10.3} {:14.0} {:12.1} {:9.1}",
            receivers / seconds,
            seconds / receivers * 1e6,
            flop / seconds / 1e9
        );
    }
}

/// Conditions with a sky.
fn lit(conditions: &[Condition]) -> f64 {
    conditions.iter().filter(|c| c.dhi_w_m2 > 0.0).count() as f64
}
