//! Replay against a plain computation of one condition's irradiance, which shares only the stored
//! textures with the kernels.

use glam::DVec3;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Archive, format, tables};
use heliotile_core::hemisphere::bilinear;
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::replay::tile::visible_cosines;
use heliotile_core::sky::disc::disc_texels;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::sky::patches::Patches;
use heliotile_core::sky::projection::Projection;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_files::input::weather::read_weather;
use rayon::prelude::*;

use crate::response::respond;
use crate::scenes::*;

/// Number of receivers that are compared.
const RECEIVERS: usize = 50;

/// Textures of a receiver, decoded whole.
struct Receiver {
    normal: DVec3,
    sky: BitSquare,
    response: Response,
}

/// Returns the first receivers of an archive's first tile.
fn receivers(archive: &Archive) -> Vec<Receiver> {
    let settings = &archive.manifest().settings;
    let table =
        tables::ReceiversTable::from_block(&archive.block(format::RECEIVERS, TileNumber::FIRST).expect("receivers"))
            .expect("a table");
    let (base, fine) = (settings.sky_base as usize, settings.sky_fine as usize);
    let raw = archive.block(format::SKY, TileNumber::FIRST).expect("sky");
    let sky = SkyTexture::unpack(raw.bytes(), table.ids.len(), base, fine).expect("bits");
    let responses = OpenSite::open(archive).expect("a site").tile_responses(0).expect("responses");
    let rows = table.normal.iter().zip(sky).zip(responses).take(RECEIVERS);
    rows.map(|((n, sky), response)| Receiver { normal: DVec3::from(*n), sky, response }).collect()
}

/// Returns the mean radiance of each of 577 patches: 64 points a patch, evaluated one by one,
/// scaled to DHI.
fn radiances(condition: &Condition, points: &[Vec<DVec3>], open: &[f64]) -> Vec<f64> {
    let sky = SkyModel::Perez.distribution(condition);
    let mean = |points: &Vec<DVec3>| {
        points.iter().map(|d| sky.relative_radiance(*d, condition.sky_sun)).sum::<f64>() / points.len() as f64
    };
    let relative: Vec<f64> = points.iter().map(mean).collect();
    let sum: f64 = relative.iter().zip(open).map(|(l, w)| l * w).sum();
    relative.into_iter().map(|l| l * condition.dhi_w_m2 / sum).collect()
}

/// Returns 8 x 8 points of equal solid angle in each of Reinhart's 577 patches: 14 rows of 6.2
/// degrees and a cap.
fn points() -> Vec<Vec<DVec3>> {
    let row = 90.0 / 14.5;
    let of_patch = |k: usize, patch: usize, count: usize| -> Vec<DVec3> {
        let low = (k as f64 * row).to_radians().sin();
        let high = if k == 14 { 1.0 } else { ((k + 1) as f64 * row).to_radians().sin() };
        let at = |i: usize| (i as f64 + 0.5) / 8.0;
        let point = |i: usize| {
            let azimuth = 360.0 * (patch as f64 + at(i % 8) - 0.5) / count as f64;
            direction_from_degrees(azimuth, (low + (high - low) * at(i / 8)).asin().to_degrees())
        };
        (0..64).map(point).collect()
    };
    let counts = [60, 60, 60, 60, 48, 48, 48, 48, 36, 36, 24, 24, 12, 12, 1];
    counts.iter().enumerate().flat_map(|(k, &n)| (0..n).map(move |patch| of_patch(k, patch, n))).collect()
}

/// For every hour of the Golden year on 50 receivers of The Hague, each component and the total are
/// those of the plain computation within 1e-4 of the value (or of a hundredth of the open sky's
/// light, where there is less). Sums of the year are within 1e-5 of the largest, of its twelfths
/// within 4e-5 and of its days within 1e-4, of the sums of the hours.
#[test]
fn replay_equals_the_plain_computation() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("hague.helio");
    let built = hague(&path, &data("receivers.csv")).output().expect("runs");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let archive = Archive::open(&path).expect("an archive");
    let weather = data("../weather/golden_tmy3.epw");
    let conditions = read_weather(&weather).expect("weather").conditions(1);
    let replay = |bins: &Bins| {
        let settings = ReplaySettings::default();
        let replay = Replay::builder(&OpenSite::open(&archive).expect("a site"), &conditions, settings)
            .summed(bins)
            .build()
            .expect("a replay");
        replay.run(0..1).expect("a tile").remove(0).1
    };
    let hours = replay(&Bins::each(conditions.len()));

    let settings = &archive.manifest().settings;
    let (probe, fine) = (settings.probe as usize, settings.sky_fine as usize);
    let patches = Patches::new(577).expect("patches");
    let project = |side: usize| Projection::new(&patches, side, 8);
    let (sky_map, response_map) = (project(settings.sky_base as usize), project(probe));
    let receivers = receivers(&archive);
    let gather = |map: &Projection, values: &[f64]| -> Vec<f64> {
        let mut sums = vec![0.0; 577];
        for (texel, value) in values.iter().enumerate() {
            map.of_texel(texel).iter().for_each(|&(p, share)| sums[usize::from(p)] += value * f64::from(share));
        }
        sums.into_iter().map(|s| s * map.texel_sr()).collect()
    };
    let coefficients: Vec<[Vec<f64>; 2]> = receivers
        .iter()
        .map(|r| {
            let flux = |(d, g): (&DVec3, [f32; 3])| d.dot(DVec3::from(g.map(f64::from)));
            let reflected: Vec<f64> = response_map.mean_directions.iter().zip(r.response.vectors()).map(flux).collect();
            let direct = visible_cosines(r.normal, &r.sky, &sky_map.mean_directions);
            [gather(&sky_map, &direct), gather(&response_map, &reflected)]
        })
        .collect();
    let points = points();
    let worst = conditions
        .par_iter()
        .enumerate()
        .map(|(hour, c)| {
            let sky =
                if c.dhi_w_m2 > 0.0 { radiances(c, &points, &sky_map.open_horizontal_sr) } else { vec![0.0; 577] };
            let mut worst = 0.0_f64;
            for (i, receiver) in receivers.iter().enumerate() {
                let dot = |k: usize| sky.iter().zip(&coefficients[i][k]).map(|(l, w)| l * w).sum::<f64>().max(0.0);
                let mut expected = [0.0, dot(0), 0.0, dot(1)];
                for sun in c.suns.iter().filter(|_| c.dni_w_m2 > 0.0) {
                    let seen = |t: &(u32, u32, f32)| receiver.sky.get(t.0 as usize, t.1 as usize);
                    let visible: f64 =
                        disc_texels(sun.sun, fine).iter().filter(|t| seen(t)).map(|t| f64::from(t.2)).sum();
                    expected[0] += c.dni_w_m2 * sun.weight * receiver.normal.dot(sun.sun).max(0.0) * visible;
                    let corners = bilinear(sun.sun, probe);
                    expected[2] += c.dni_w_m2 * sun.weight * respond(&receiver.response.vectors(), sun.sun, &corners);
                }
                expected[2] = expected[2].max(0.0);
                let floor = 0.01 * (c.dhi_w_m2 + c.dni_w_m2 * c.sky_sun.z);
                let error = |got: f32, expected: f64| (f64::from(got) - expected).abs() / expected.max(floor).max(1e-9);
                for (k, &value) in expected.iter().enumerate() {
                    worst = worst.max(error(hours.row(Component::ALL[k], i)[hour], value));
                }
                worst = worst.max(error(hours.row(Component::Total, i)[hour], expected.iter().sum()));
            }
            worst
        })
        .reduce(|| 0.0, f64::max);
    println!("50 receivers, {} hours: off by at most {worst:.1e}", conditions.len());
    assert!(worst < 1e-4, "{worst:.1e}");

    // Few results, and many. Sums clip light from behind a surface by texels, hours do by suns, and
    // hours clip light that coding makes negative: the fewer suns, the more that shows.
    for (count, hours_of_one, most) in [(1, 8760, 1e-5), (12, 730, 4e-5), (365, 24, 1e-4)] {
        let of_condition: Vec<(usize, f64)> = (0..conditions.len()).map(|hour| (hour / hours_of_one, 1e-3)).collect();
        let sums = replay(&Bins { count, of_condition });
        let largest = sums.component(Component::Total).iter().copied().fold(0.0, f32::max);
        for i in 0..RECEIVERS {
            for k in 0..7 {
                let of_hours = hours.row(Component::ALL[k], i).chunks(hours_of_one);
                for (got, hours) in sums.row(Component::ALL[k], i).iter().zip(of_hours) {
                    let summed: f64 = hours.iter().map(|v| f64::from(*v) * 1e-3).sum();
                    let off = (f64::from(*got) - summed).abs();
                    assert!(off < most * f64::from(largest), "{count} {k} {i}: {got} {summed}");
                }
            }
        }
    }
}
