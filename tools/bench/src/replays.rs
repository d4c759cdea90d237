//! What replay costs on one core: receiver-years a second by length of the sums, sun positions an hour and component, with responses stored
//! and derived anew, beside what the machine can do: a product of matrices and a copy.

use std::path::Path;

use cpu_time::ProcessTime;
use heliotile_core::archive::Archive;
use heliotile_core::light::states::Schedule;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_files::input::weather::read_weather;
use ndarray::Array2;

/// Runs of each measurement; the median counts.
const RUNS: usize = 5;

/// Sun positions an hour, as the program has it.
const STEPS: usize = 12;

/// Seconds of the processor: other work of the machine does not count.
fn once_s(run: impl FnOnce()) -> f64 {
    let start = ProcessTime::now();
    run();
    start.elapsed().as_secs_f64()
}

fn median_s(mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..RUNS).map(|_| once_s(&mut run)).collect();
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

/// Sums in kWh/m2 of the conditions of each month, or of all.
fn sums(conditions: &[Condition], monthly: bool) -> Bins {
    let month = |c: &Condition| c.stamp.filter(|_| monthly).map_or(0, |stamp| stamp.date.month as usize - 1);
    let of_condition = conditions.iter().map(|c| (month(c), 1e-3)).collect();
    Bins { count: if monthly { 12 } else { 1 }, of_condition }
}

/// Prints the table for one archive.
pub fn run(path: &Path, weather: &Path) {
    let (peak, copy) = machine();
    println!("one core: product of matrices {peak:.1} GFLOP/s, copy {copy:.1} GB/s");
    let archive = Archive::open(path).expect("an archive");
    let series = read_weather(weather).expect("weather");
    let conditions = series.conditions(STEPS);
    let receivers = archive.manifest().receivers.count as f64;
    println!("{}: {receivers} receivers, {} hours", path.display(), conditions.len());
    decoding(&archive);
    let (year, months) = (sums(&conditions, false), sums(&conditions, true));
    let hours = Bins::each(conditions.len());
    let anew = [Schedule { materials: vec![0], values: vec![0.31; conditions.len()] }];
    use Component::*;
    let all = ComponentSet::ALL;
    let of = |components: &[Component]| ComponentSet::new(components);
    println!("{:34} {:>10} {:>14} {:>12} {:>9}", "", "set-up, s", "receivers/s", "us/receiver", "GFLOP/s");
    let (few, many) = (series.conditions(4), series.conditions(60));
    for (name, conditions, bins, components, schedules) in [
        ("yearly sums, 4 suns an hour", &few, &year, all, &[][..]),
        ("yearly sums, 12", &conditions, &year, all, &[]),
        ("yearly sums, 60", &many, &year, all, &[]),
        ("  12: sun_direct", &conditions, &year, of(&[SunDirect]), &[]),
        ("  sky_direct", &conditions, &year, of(&[SkyDirect]), &[]),
        ("  sun_reflected", &conditions, &year, of(&[SunReflected]), &[]),
        ("  sky_reflected", &conditions, &year, of(&[SkyReflected]), &[]),
        ("monthly sums", &conditions, &months, all, &[]),
        ("hours", &conditions, &hours, all, &[]),
        ("  sun_direct", &conditions, &hours, of(&[SunDirect]), &[]),
        ("  sky_direct", &conditions, &hours, of(&[SkyDirect]), &[]),
        ("  sun_reflected", &conditions, &hours, of(&[SunReflected]), &[]),
        ("  sky_reflected", &conditions, &hours, of(&[SkyReflected]), &[]),
        ("yearly sums, responses anew", &conditions, &year, all, &anew),
    ] {
        let settings = ReplaySettings { components, ..ReplaySettings::default() };
        let site = OpenSite::open(&archive).expect("a site");
        let make = || {
            Replay::builder(&site, conditions, settings).summed(bins).scheduled(schedules).build().expect("a replay")
        };
        // Deriving takes long: once is enough.
        let mut made = None;
        let mut setup = once_s(|| made = Some(make()));
        if schedules.is_empty() {
            setup = median_s(|| made = Some(make()));
        }
        let replay = made.expect("a replay");
        let all_tiles = || {
            for tiles in (0..replay.tiles()).collect::<Vec<_>>().chunks(16) {
                std::hint::black_box(replay.run(tiles.iter().copied()).expect("results"));
            }
        };
        let mut seconds = once_s(all_tiles);
        if seconds < 2.0 {
            seconds = median_s(all_tiles);
        }
        // Patches times results with a sky, for the direct and the reflected part.
        let parts = [SkyDirect, SkyReflected].iter().filter(|c| components.needs(**c)).count() as f64;
        let skies = if bins.count == conditions.len() { lit(conditions) } else { bins.count as f64 };
        let flop = 2.0 * parts * receivers * 577.0 * skies;
        println!(
            "{name:34} {setup:10.3} {:14.0} {:12.1} {:9.1}",
            receivers / seconds,
            seconds / receivers * 1e6,
            flop / seconds / 1e9
        );
    }
}

/// What layers take from the bytes of their blocks to what a replay looks up, checksums, zstd and memory included.
fn decoding(archive: &Archive) {
    let site = OpenSite::open(archive).expect("a site");
    let rows: Vec<usize> = (0..site.tiles()).map(|tile| site.tile_receivers(tile).expect("receivers").rows()).collect();
    let time = |name: &str, decode: &dyn Fn(u32, usize)| {
        let all = || rows.iter().enumerate().for_each(|(tile, rows)| decode(tile as u32, *rows));
        println!("decoding {name:10} {:6.2} us/receiver", median_s(all) / rows.iter().sum::<usize>() as f64 * 1e6);
    };
    time("sky", &|tile, rows| drop(std::hint::black_box(site.tile_sky(tile, rows).expect("skies"))));
    time("hit", &|tile, rows| drop(std::hint::black_box(site.tile_hits(tile, rows).expect("hits"))));
    time("response", &|tile, _| drop(std::hint::black_box(site.tile_responses(tile).expect("responses"))));
}

/// Conditions with a sky.
fn lit(conditions: &[Condition]) -> f64 {
    conditions.iter().filter(|c| c.dhi_w_m2 > 0.0).count() as f64
}
