//! The response texture against plain definitions that do not use it.

use glam::DVec3;
use heliotile_builder::settings::{BuildSettings, Share};
use heliotile_core::archive::Archive;
use heliotile_core::error::Error;
use heliotile_core::hemisphere::bit;
use heliotile_core::hemisphere::{HEMISPHERE_SR, bilinear, texel_centres};
use heliotile_core::layers::cells::Cells;
use heliotile_core::layers::response::Response;
use heliotile_core::light::radiosity::{MaxBounces, TOLERANCE, centres_f32, seen, surround};
use heliotile_core::light::reflector::Reflector;
use heliotile_core::light::response::hit_weights;
use heliotile_core::light::response_solver::ResponseSolver;
use heliotile_core::light::scratch::{InMemory, Scratch, ScratchSpace};
use heliotile_core::light::tables::Tables;
use heliotile_core::light::tile_view::TileView;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::CellSource;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::time::bins::Bins;
use heliotile_files::spill::TempFiles;
use heliotile_scene::Scene;

use crate::scenes::*;

/// Returns three blocks on a plain: neighbours, corners, a narrow gap.
fn blocks() -> Scene {
    let mut triangles = ground(300.0, 0.0, 0);
    triangles.extend(block(v(-30.0, -10.0, 0.0), v(-10.0, 25.0, 18.0), 1));
    triangles.extend(block(v(4.0, -12.0, 0.0), v(17.0, 9.0, 11.0), 1));
    triangles.extend(block(v(-6.0, 30.0, 0.0), v(20.0, 42.0, 25.0), 1));
    scene(&triangles, &[0.25, 0.5])
}

/// Returns the diffuse irradiance per unit normal irradiance of a source in direction `s`,
/// interpolated between four texels.
pub fn respond(response: &[[f32; 3]], s: DVec3, corners: &[(usize, f64); 4]) -> f64 {
    corners.iter().map(|&(t, w)| w * s.dot(DVec3::from(response[t].map(f64::from)))).sum()
}

fn twenty() -> Vec<Receiver> {
    (0..20)
        .map(|i| {
            let along = f64::from(i) / 20.0;
            match i % 4 {
                0 => receiver(&format!("r{i}"), v(4.0, -11.0 + 19.0 * along, 0.5 + 10.0 * along), DVec3::NEG_X),
                1 => receiver(&format!("r{i}"), v(-10.0, -9.0 + 30.0 * along, 1.0 + 15.0 * along), DVec3::X),
                2 => receiver(&format!("r{i}"), v(-8.0 + 10.0 * along, -20.0 + 45.0 * along, 0.0), DVec3::Z),
                _ => receiver(&format!("r{i}"), v(-5.0 + 20.0 * along, 30.0, 1.0 + 20.0 * along), DVec3::NEG_Y),
            }
        })
        .collect()
}

fn suns() -> Vec<DVec3> {
    (0..50)
        .map(|i| {
            heliotile_core::units::direction_from_degrees(
                f64::from(i) * 137.5,
                3.0 + 82.0 * (f64::from(i) * 0.618).fract(),
            )
        })
        .collect()
}

/// Computes the radiosity of every coarse cell for one source whose visibility and cosine
/// `lit(cell)` gives: the plain scalar system, with `steps` reflections between cells.
fn radiosities(
    cells: &Cells,
    sky: usize,
    rho: &dyn Fn(usize) -> f64,
    lit: &dyn Fn(&[u8], [f32; 3]) -> f64,
    steps: usize,
) -> Vec<f64> {
    let centres = centres_f32(sky);
    let bits = |i: usize| cells.bits_of(i);
    let row_of: Vec<usize> = cells.seen.iter().map(|k| cells.keys.binary_search(k).expect("a closed system")).collect();
    let source: Vec<f64> = (0..cells.keys.len()).map(|i| rho(i) * lit(bits(i), cells.normals[i])).collect();
    let mut now = source.clone();
    for _ in 0..steps {
        let next: Vec<f64> = (0..now.len())
            .map(|i| {
                let around = surround(cells.keys[i], cells.normals[i], bits(i), &centres);
                let (above, below) = seen(cells.hits_of(i), None);
                let gather =
                    |l: &[(u32, f32)]| l.iter().map(|&(c, w)| f64::from(w) * now[row_of[c as usize]]).sum::<f64>();
                source[i] + rho(i) * (around.up * gather(&above) + around.down * gather(&below))
            })
            .collect();
        let change = next.iter().zip(&now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        now = next;
        if change < 1e-12 {
            break;
        }
    }
    now
}

/// All cells of an archive.
struct All<'a> {
    tables: Tables<'a>,
    probes: Cells,
    bounces: Cells,
}

impl<'a> All<'a> {
    fn load(archive: &'a Archive) -> Self {
        let tables = Tables::new(&OpenSite::open(archive).expect("a site")).expect("tables");
        let all = |source: &CellSource| {
            let chunk = |chunk| source.chunk(chunk).expect("a chunk");
            Cells::join(&(0..source.chunks()).map(chunk).collect::<Vec<_>>())
        };
        let (probes, bounces) = (all(&tables.probes), all(&tables.bounces));
        All { tables, probes, bounces }
    }
}

/// Computes the light of a source at a receiver by a plain loop over the cells that it sees.
fn plain(all: &All, view: &TileView, index: usize, sky: &Source, cells: &[f64]) -> f64 {
    let (shape, hits, probes) = (all.tables.settings, &view.hits, &all.probes);
    let per = shape.hit * shape.hit;
    let texels = &hits.texels[index * per..(index + 1) * per];
    let centres = centres_f32(shape.probe);
    let row_of = |c: u32| all.bounces.keys.binary_search(&probes.seen[c as usize]).expect("a bounce cell");
    let mut sum = 0.0;
    for (cell, weight) in hit_weights(texels, &view.viewers[index], None).cells {
        let key = hits.palette[cell];
        let probe = probes.keys.binary_search(&key).expect("every hit has its probe");
        let bits = probes.bits_of(probe);
        let around = surround(probes.keys[probe], probes.normals[probe], bits, &centres);
        let (above, below) = seen(probes.hits_of(probe), None);
        let gather = |l: &[(u32, f32)]| l.iter().map(|&(c, w)| f64::from(w) * cells[row_of(c)]).sum::<f64>();
        let indirect = around.up * gather(&above) + around.down * gather(&below);
        let rho = all.tables.mirrors.reflectors[usize::from(key.material)].diffuse;
        sum += weight * rho * (sky(shape.probe, bits, probes.normals[probe]) + indirect);
    }
    sum
}

/// Returns a cell's sky bits at a source, interpolated.
fn bit_at(bits: &[u8], corners: &[(usize, f64); 4]) -> f64 {
    corners.iter().map(|&(t, w)| if bit(bits, t) { w } else { 0.0 }).sum()
}

/// Irradiance of a cell with n x n sky bits and a normal.
type Source<'a> = dyn Fn(usize, &[u8], [f32; 3]) -> f64 + 'a;

fn cosine(normal: [f32; 3], d: DVec3) -> f64 {
    f64::from(normal[0]) * d.x + f64::from(normal[1]) * d.y + f64::from(normal[2]) * d.z
}

/// On 20 receivers, for 50 suns and a uniform sky, s . G equals a plain loop over probes, cells and
/// bounces to 1e-5 of the source.
#[test]
fn response_equals_plain_loop() {
    let site = site(&blocks(), &twenty(), &BuildSettings::default());
    let archive = Archive::open(&site.path).expect("an archive");
    let all = All::load(&archive);
    let (tables, bounces) = (&all.tables, &all.bounces);
    let view = TileView::read(&OpenSite::open(&archive).expect("a site"), 0).expect("a tile");
    let responder =
        ResponseSolver::new(tables, MaxBounces::All, MemoryBudget::DEFAULT, &InMemory).expect("a responder");
    let rho = |i: usize| tables.mirrors.reflectors[usize::from(bounces.keys[i].material)].diffuse;
    let tiles = responder.derive(tables, std::slice::from_ref(&view)).expect("responses");
    let responses: Vec<Vec<[f32; 3]>> = tiles[0][0].iter().map(|response| response.vectors()).collect();

    let mut worst = 0.0_f64;
    let mut largest = 0.0_f64;
    for s in suns() {
        // Bounce cells have coarser textures, read at the finer texel centres first, as the
        // response is.
        let corners = bilinear(s, tables.settings.probe);
        let sun = |n: usize, bits: &[u8], normal: [f32; 3]| {
            if n == tables.settings.probe {
                return bit_at(bits, &corners) * cosine(normal, s);
            }
            let fine = texel_centres(tables.settings.probe);
            let at = |t: usize| bit_at(bits, &bilinear(fine[t], n));
            corners.iter().map(|&(t, w)| at(t) * w).sum::<f64>() * cosine(normal, s)
        };
        let cells = radiosities(
            bounces,
            tables.settings.bounce_sky,
            &rho,
            &|bits, normal| sun(tables.settings.bounce_sky, bits, normal),
            200,
        );
        for (r, response) in responses.iter().enumerate() {
            let expected = plain(&all, &view, r, &sun, &cells);
            worst = worst.max((respond(response, s, &corners) - expected).abs());
            largest = largest.max(expected);
        }
    }
    assert!(worst < 1e-5, "sun: off by {worst:.1e}");
    assert!(largest > 0.05, "nothing was reflected");

    let sky = |n: usize, bits: &[u8], normal: [f32; 3]| {
        let centres = texel_centres(n);
        let sum: f64 = (0..n * n).filter(|&t| bit(bits, t)).map(|t| cosine(normal, centres[t])).sum();
        sum * HEMISPHERE_SR / (n * n) as f64
    };
    // A uniform sky of unit radiance; the coarse cells' textures are read at the response's texels
    // here too.
    let fine = texel_centres(tables.settings.probe);
    let coarse = |bits: &[u8], normal: [f32; 3]| {
        let n = tables.settings.bounce_sky;
        let sum: f64 = fine.iter().map(|d| bit_at(bits, &bilinear(*d, n)) * cosine(normal, *d)).sum();
        sum * HEMISPHERE_SR / fine.len() as f64
    };
    let cells = radiosities(bounces, tables.settings.bounce_sky, &rho, &coarse, 200);
    for (r, response) in responses.iter().enumerate() {
        let flux = |(d, g): (&DVec3, &[f32; 3])| d.dot(DVec3::from(g.map(f64::from)));
        let got = fine.iter().zip(response).map(flux).sum::<f64>() * HEMISPHERE_SR / fine.len() as f64;
        let expected = plain(&all, &view, r, &sky, &cells);
        assert!(
            (got - expected).abs() < 1e-5 * std::f64::consts::PI + TOLERANCE * expected,
            "sky at {r}: {got} for {expected}"
        );
    }
}

/// `--bounces` 1, 2 and 3 equal a plain loop over the probes that a receiver sees: with the source
/// alone in each probe, with the radiosity of the cells that probes see, and with that of the cells
/// these see, within 1e-5 of the source on 20 receivers and 10 suns; each bounce adds more than
/// 0.001 somewhere.
#[test]
fn few_bounces_equal_plain_loop() {
    let site = site(&blocks(), &twenty(), &BuildSettings::default());
    let archive = Archive::open(&site.path).expect("an archive");
    let all = All::load(&archive);
    let (tables, bounces) = (&all.tables, &all.bounces);
    let view = TileView::read(&OpenSite::open(&archive).expect("a site"), 0).expect("a tile");
    let rho = |i: usize| tables.mirrors.reflectors[usize::from(bounces.keys[i].material)].diffuse;
    let (probe, coarse) = (tables.settings.probe, tables.settings.bounce_sky);
    let fine = texel_centres(probe);
    let mut before = vec![0.0; 200];
    for count in 1..=3 {
        let responder = ResponseSolver::new(tables, MaxBounces::Count(count), MemoryBudget::DEFAULT, &InMemory)
            .expect("a responder");
        let tiles = responder.derive(tables, std::slice::from_ref(&view)).expect("responses");
        let responses: Vec<Vec<[f32; 3]>> = tiles[0][0].iter().map(|response| response.vectors()).collect();
        let (mut worst, mut added) = (0.0_f64, 0.0_f64);
        for (i, s) in suns().into_iter().step_by(5).enumerate() {
            let corners = bilinear(s, probe);
            let sun = |n: usize, bits: &[u8], normal: [f32; 3]| {
                let at = |t: usize| bit_at(bits, &bilinear(fine[t], n));
                let lit =
                    if n == probe { bit_at(bits, &corners) } else { corners.iter().map(|&(t, w)| at(t) * w).sum() };
                lit * cosine(normal, s)
            };
            let cells = match count {
                1 => vec![0.0; bounces.keys.len()],
                _ => radiosities(bounces, coarse, &rho, &|bits, n| sun(coarse, bits, n), count as usize - 2),
            };
            for (r, response) in responses.iter().enumerate() {
                let expected = plain(&all, &view, r, &sun, &cells);
                worst = worst.max((respond(response, s, &corners) - expected).abs());
                added = added.max(expected - before[20 * i + r]);
                before[20 * i + r] = expected;
            }
        }
        println!("{count} bounces: off by {worst:.1e}, the last adds up to {added:.4}");
        assert!(worst < 1e-5 && added > 1e-3, "{count} bounces: off by {worst:.1e}, the last adds up to {added:.4}");
    }
}

/// With shared cells instead of a hemisphere of its own for every hit, over 8 receivers and 50
/// suns, the reflected sun differs by less than 1 % of the direct normal irradiance (root mean
/// square), its mean by less than 0.2 %.
#[test]
fn sharing_costs_little() {
    let receivers: Vec<Receiver> = twenty().into_iter().take(8).collect();
    let shared = site(&blocks(), &receivers, &BuildSettings::default());
    let alone = site(&blocks(), &receivers, &BuildSettings { share: Share::None, ..BuildSettings::default() });
    let conditions: Vec<_> = suns()
        .into_iter()
        .map(|s| heliotile_core::weather::conditions::Condition::new("c".into(), &[s], s, 1000.0, 0.0))
        .collect();
    let a = shared.replay(&conditions, SkyModel::Perez, MaxBounces::All);
    let b = alone.replay(&conditions, SkyModel::Perez, MaxBounces::All);
    let (mut square, mut bias, mut count) = (0.0, 0.0, 0.0);
    for (id, rows) in &a {
        for (x, y) in rows.iter().zip(&b[id]) {
            let d = x.sun_reflected - y.sun_reflected;
            square += d * d;
            bias += d;
            count += 1.0;
        }
    }
    let (rmse, bias) = ((square / count).sqrt() / 10.0, bias / count / 10.0);
    println!("sharing: RMSE {rmse:.3} % and bias {bias:.3} % of DNI");
    assert!(rmse < 1.0 && bias.abs() < 0.2, "RMSE {rmse:.3} %, bias {bias:.3} % of DNI");
}

/// Sums of 200 hours in 5 periods, made from summed skies and one lookup a sun, are the sums of the
/// hourly results in f64: within 1e-5 of the largest sum, for 20 receivers and all components.
#[test]
fn sums_are_the_sums_of_hours() {
    let site = site(&blocks(), &twenty(), &BuildSettings::default());
    let archive = Archive::open(&site.path).expect("an archive");
    let conditions: Vec<_> = (0..200)
        .map(|i| {
            let i = f64::from(i);
            sun(i * 137.5, 70.0 * (i * 0.618).fract() - 5.0, 900.0 * (i * 0.37).fract(), 300.0 * (i * 0.73).fract())
        })
        .collect();
    let settings = ReplaySettings {
        sky: SkyModel::Perez,
        patches: 577,
        paths: MaxBounces::All.into(),
        components: ComponentSet::ALL,
        memory: MemoryBudget::new(1 << 28),
        storage: &InMemory,
    };
    let weight = |i: usize| 0.5 + 0.01 * i as f64;
    let bins = Bins { count: 5, of_condition: (0..200).map(|i| (i * 7 % 5, weight(i))).collect() };
    let run = |replay: Replay| replay.run(0..1).expect("a tile").remove(0).1;
    let hours = run(Replay::new(&OpenSite::open(&archive).expect("a site"), &conditions, settings).expect("a replay"));
    let sums = run(Replay::builder(&OpenSite::open(&archive).expect("a site"), &conditions, settings)
        .summed(&bins)
        .build()
        .expect("a replay"));
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for component in Component::ALL {
        for receiver in 0..20 {
            let mut plain = [0.0_f64; 5];
            for (i, mean) in hours.row(component, receiver).iter().enumerate() {
                plain[i * 7 % 5] += f64::from(*mean) * weight(i);
            }
            for (sum, plain) in sums.row(component, receiver).iter().zip(plain) {
                worst = worst.max((f64::from(*sum) - plain).abs());
                largest = largest.max(plain);
            }
        }
    }
    println!("worst {worst:.2e} of {largest:.1}");
    assert!(largest > 1e4 && worst < 1e-5 * largest, "{worst} of {largest}");
}

/// The coding of stored responses, compared with those derived again in f32, adds little to
/// replays. On 20 receivers under 400 suns of 558 W/m2 (the RMS of a year in Golden) it adds 1e-3
/// to 0.11 W/m2 RMS to light of the sun, which the steps allow for (0.0032 / 16 of it), and less
/// than 0.05 % of the mean total to every column.
#[test]
fn coding_adds_little() {
    let site = site(&blocks(), &twenty(), &BuildSettings::default());
    let archive = Archive::open(&site.path).expect("an archive");
    let conditions: Vec<_> = (0..400)
        .map(|i| {
            let i = f64::from(i);
            sun(i * 137.5, 90.0 * (i * 0.618).fract(), 558.0, 163.0)
        })
        .collect();
    let run = |depth: MaxBounces| {
        let settings = ReplaySettings {
            sky: SkyModel::Perez,
            patches: 577,
            paths: depth.into(),
            components: ComponentSet::ALL,
            memory: MemoryBudget::new(1 << 28),
            storage: &InMemory,
        };
        let replay = Replay::new(&OpenSite::open(&archive).expect("a site"), &conditions, settings).expect("a replay");
        replay.run(0..1).expect("a tile").remove(0).1
    };
    let (coded, plain) = (run(MaxBounces::All), run(MaxBounces::Count(100)));
    let mean = |of: &dyn Fn(usize, usize) -> f64| (0..8000).map(|i| of(i / 400, i % 400)).sum::<f64>() / 8000.0;
    let total = mean(&|r, c| f64::from(plain.row(Component::Total, r)[c]));
    for component in Component::ALL {
        let off = |r: usize, c: usize| f64::from(coded.row(component, r)[c]) - f64::from(plain.row(component, r)[c]);
        let rms = mean(&|r, c| off(r, c).powi(2)).sqrt();
        println!("{component:?}: {rms:.4} of {total:.1} W/m2");
        assert!(rms < 5e-4 * total, "{component:?}: {rms} of {total}");
        // The bound holds for the mean of all directions: 400 suns are off it by some hundredths.
        assert!(component != Component::SunReflected || (1e-3..1.05 * 0.0032 / 16.0 * 558.0).contains(&rms), "{rms}");
    }
}

/// Radiosities that do not fit into 8 kB are read back from temporary files and from memory to the
/// bit: the responses of 20 receivers in two states are those of a solution that fits.
#[test]
fn stored_radiosities_keep_every_bit() {
    let site = site(&blocks(), &twenty(), &BuildSettings::default());
    let archive = Archive::open(&site.path).expect("an archive");
    let opened = OpenSite::open(&archive).expect("a site");
    let (tables, view) = (Tables::new(&opened).expect("tables"), TileView::read(&opened, 0).expect("a tile"));
    let folder = tempfile::tempdir().expect("a folder");
    let derived = |bytes: u64, storage: &dyn ScratchSpace| {
        let stored: Vec<f64> = tables.mirrors.reflectors.iter().map(Reflector::variable).collect();
        let states = vec![stored.clone(), stored.iter().map(|value| value / 2.0).collect()];
        let responder =
            ResponseSolver::with_states(&tables, states, MaxBounces::All, MemoryBudget::new(bytes), storage)
                .expect("a responder");
        responder.derive(&tables, std::slice::from_ref(&view)).expect("responses")
    };
    let bits = |responses: Vec<Vec<Vec<Response>>>| -> Vec<u32> {
        responses.into_iter().flatten().flatten().flat_map(|r| r.values).map(f32::to_bits).collect()
    };
    let fits = bits(derived(1 << 30, &NoStorage));
    assert_eq!(fits.len(), 2 * 20 * Response::len(tables.settings.probe));
    assert!(bits(derived(8 << 10, &TempFiles::new(folder.path()))) == fits);
    assert!(bits(derived(8 << 10, &InMemory)) == fits);
    let states = vec![tables.mirrors.reflectors.iter().map(Reflector::variable).collect()];
    let refused =
        ResponseSolver::with_states(&tables, states, MaxBounces::All, MemoryBudget::new(8 << 10), &NoStorage).err();
    assert!(matches!(refused, Some(Error::Limit { value: 1, .. })), "8 kB must not be enough");
}

/// Temporary storage that refuses all use.
#[derive(Debug)]
struct NoStorage;

impl ScratchSpace for NoStorage {
    fn scratch(&self) -> Result<Box<dyn Scratch>, Error> {
        Err(Error::Limit { what: "temporary storage".into(), value: 1, max: 0 })
    }
}
