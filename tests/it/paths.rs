//! Light by the surface seen first and by light paths, and the factors that are made of both.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::light::paths::LightPaths;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::states::Schedule;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::factors::SunGrid;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::Class;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_scene::Scene;

use crate::cli::failure;
use crate::scenes::*;

fn coarse() -> BuildSettings {
    BuildSettings { sky_base: 32, sky_fine: 128, hit: 16, probe: 16, ..BuildSettings::default() }
}

fn conditions() -> Vec<Condition> {
    let one = |i: i32| {
        let i = f64::from(i);
        sun(i * 97.0, 5.0 + 60.0 * (i * 0.618).fract(), 300.0 + 500.0 * (i * 0.37).fract(), 150.0)
    };
    (0..24).map(one).collect()
}

/// Returns a schedule that gives the ground one reflectance in all conditions.
fn ground_of(site: &OpenSite, value: f64, conditions: usize) -> Schedule {
    let is_ground = |m: &usize| site.materials()[*m].class == Class::Ground;
    Schedule { materials: (0..site.materials().len()).filter(is_ground).collect(), values: vec![value; conditions] }
}

/// Returns irradiances of all receivers and conditions, `[component]`, by receiver.
fn light(site: &Site, paths: LightPaths, schedules: &[Schedule]) -> BTreeMap<String, Vec<Vec<f64>>> {
    let archive = Archive::open(&site.path).expect("an archive");
    let all: Vec<Component> = Component::ALL.into_iter().chain(Component::FURTHER).collect();
    let all: Vec<Component> = all.into_iter().filter(|c| *c != Component::Longwave).collect();
    let settings = ReplaySettings {
        sky: SkyModel::Uniform,
        paths,
        components: ComponentSet::new(&all),
        ..ReplaySettings::default()
    };
    let (conditions, opened) = (conditions(), OpenSite::open(&archive).expect("a site"));
    let bins = Bins::each(conditions.len());
    let replay =
        Replay::builder(&opened, &conditions, settings).summed(&bins).scheduled(schedules).build().expect("a replay");
    let tiles = replay.run(0..replay.tiles()).expect("tiles");
    let rows = tiles.iter().flat_map(|(ids, values)| {
        ids.iter().enumerate().map(|(r, id)| {
            let of = |c: &Component| values.row(*c, r).iter().map(|v| f64::from(*v)).collect();
            let mut row = vec![Vec::new(); Component::COUNT];
            all.iter().for_each(|c| row[*c as usize] = of(c));
            (id.clone(), row)
        })
    });
    rows.collect()
}

/// Returns the largest difference between the sum of some components and one component, W/m2.
fn off(
    a: &BTreeMap<String, Vec<Vec<f64>>>,
    parts: &[Component],
    b: &BTreeMap<String, Vec<Vec<f64>>>,
    of: Component,
) -> f64 {
    let pairs = a.values().zip(b.values()).flat_map(|(a, b)| {
        (0..b[of as usize].len()).map(|i| {
            let sum: f64 = parts.iter().map(|part| a[*part as usize][i]).sum();
            (sum - b[of as usize][i]).abs()
        })
    });
    pairs.fold(0.0, f64::max)
}

fn mean(of: &BTreeMap<String, Vec<Vec<f64>>>, component: Component) -> f64 {
    let all: Vec<f64> = of.values().flat_map(|row| row[component as usize].clone()).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

/// Reflected sun and sky are the sums of the light of ground and obstructions, to 1e-4 W/m2, for
/// all bounces and for one. With one bounce the part of obstructions is the light that is left when
/// the ground is black, and the part of the ground doubles with its reflectance, to 1e-3 W/m2.
#[test]
fn reflected_light_splits_into_ground_and_obstructions() {
    let site = site(&mirror_town(), &many()[..64], &coarse());
    let archive = Archive::open(&site.path).expect("an archive");
    let of_ground = |value: f64| [ground_of(&OpenSite::open(&archive).expect("a site"), value, 24)];
    let wholes = [Component::SunReflected, Component::SkyReflected];
    for paths in [LightPaths::ALL, LightPaths::FIRST] {
        let found = light(&site, paths, &[]);
        for whole in wholes {
            let parts = whole.parts().expect("two");
            assert!(off(&found, &parts, &found, whole) < 1e-4, "{whole:?}");
            assert!(parts.iter().all(|part| mean(&found, *part) > 0.5), "{whole:?}");
        }
    }
    let [black, lit, twice] = [0.0, 0.2, 0.4].map(|value| light(&site, LightPaths::FIRST, &of_ground(value)));
    for whole in wholes {
        let [ground, obstruction] = whole.parts().expect("two");
        assert!(off(&lit, &[obstruction], &black, whole) < 1e-3, "{whole:?}");
        assert!(off(&lit, &[ground, ground], &twice, ground) < 1e-3, "{whole:?}");
        assert_eq!(mean(&black, ground), 0.0);
    }
}

/// Without mirrored paths a town with mirrors reflects the light of the same town with matt walls,
/// to 2e-3 W/m2, sees no sky in mirrors and as much sun in them as before. Each path that is left
/// out takes light away.
#[test]
fn paths_left_out_take_their_light_away() {
    let matt = mirror_materials().into_iter().map(|m| heliotile_core::site::material::Material {
        specular: 0.0,
        glass: None,
        ..m
    });
    let matt = Scene::from_triangles(&mirror_triangles(), matt.collect()).expect("a scene");
    let [mirrors, matt] = [mirror_town(), matt].map(|scene| site(&scene, &many()[..64], &coarse()));
    let (all, none) = (light(&mirrors, LightPaths::ALL, &[]), light(&mirrors, LightPaths::FIRST, &[]));
    let one = light(&matt, MaxBounces::Count(1).into(), &[]);
    for part in [Component::SunReflected, Component::SkyReflected] {
        assert!(mean(&one, part) > 1.0);
        assert!(off(&none, &[part], &one, part) < 2e-3, "{part:?}: {}", off(&none, &[part], &one, part));
    }
    assert_eq!(off(&none, &[Component::SunMirrored], &all, Component::SunMirrored), 0.0);
    assert!(mean(&all, Component::SunMirrored) > 1.0 && mean(&all, Component::SkyMirrored) > 1.0);
    assert_eq!(mean(&none, Component::SkyMirrored), 0.0);
    let total = |text: &str| mean(&light(&mirrors, text.parse().expect("paths"), &[]), Component::Total);
    let whole = total("all");
    for (text, component) in [
        ("bounces,mirror-diffuse", "sky in mirrors"),
        ("bounces,mirror-sky", "mirror-lit surfaces"),
        ("mirror-diffuse,mirror-sky", "further bounces"),
    ] {
        assert!(total(text) < whole - 0.05, "{component}: {} of {whole}", total(text));
    }
}

/// Factors put together again are the irradiances of a replay with EnergyPlus's paths: 20 suns,
/// ground of 0.3, within 2e-3 W/m2 of up to 200.
#[test]
fn factors_add_up() {
    let site = site(&mirror_town(), &many()[..64], &coarse());
    let archive = Archive::open(&site.path).expect("an archive");
    let opened = OpenSite::open(&archive).expect("a site");
    let grid = SunGrid::new(72.0, 30.0).expect("a grid");
    let factors = grid.replay(&opened, ReplaySettings::default()).expect("factors");
    let mut conditions = grid.conditions(700.0);
    conditions.iter_mut().for_each(|c| c.dhi_w_m2 = 90.0);
    let settings = ReplaySettings { sky: SkyModel::Uniform, paths: LightPaths::FIRST, ..ReplaySettings::default() };
    let (ground, bins) = ([ground_of(&opened, 0.3, conditions.len())], Bins::each(conditions.len()));
    let replay =
        Replay::builder(&opened, &conditions, settings).summed(&bins).scheduled(&ground).build().expect("a replay");
    let (expected, parts) = (replay.run(0..1).expect("a tile"), factors.run(0..1).expect("a tile"));
    let (mut largest, mut most) = (0.0_f64, 0.0_f64);
    for receiver in 0..64 {
        let of: Vec<[f64; 5]> = grid.factors(|part| parts[0].1.row(part, receiver)).collect();
        for (sun, (([sun_o, sun_g, sky_o, sky_g, mirrored], (_, altitude)), _)) in
            of.iter().zip(grid.suns()).zip(&conditions).enumerate()
        {
            let of_sun = 700.0 * (sun_o + mirrored + 0.3 * altitude.to_radians().sin() * sun_g);
            let found = of_sun + 90.0 * (sky_o + 0.3 * sky_g);
            let three = [Component::SunReflected, Component::SkyReflected, Component::SunMirrored];
            let direct: f64 = three.iter().map(|c| f64::from(expected[0].1.row(*c, receiver)[sun])).sum();
            (largest, most) = (largest.max((found - direct).abs()), most.max(direct));
        }
    }
    assert!(largest < 2e-3 && most > 50.0, "{largest} of {most}");
}

/// `factors` writes 703 rows for each of 3 surfaces with the five names of EnergyPlus, twice the
/// same. A step of 7 degrees and .xlsx are refused with exit code 2. `query --schedule` with a
/// value for each of 2 conditions gives the results of --reflectance for each alone.
#[test]
fn factors_have_a_row_for_each_surface_and_direction() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let rows: Vec<String> =
        fs::read_to_string(data("receivers.csv")).expect("receivers").lines().map(str::to_owned).collect();
    let some = [&rows[0], &rows[1], &rows[22], &rows[61]].map(|row| format!("{row}\n")).concat();
    let surfaces = some.replacen(",wall\n", ",east\n", 1);
    fs::write(path("r.csv"), surfaces).expect("written");
    assert!(hague(&path("s.helio"), &path("r.csv")).status().expect("a build").success());
    let command = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        command.current_dir(folder.path()).args(args);
        command
    };
    let run = |args: &[&str]| {
        let out = command(args).output().expect("a run");
        (
            out.status.code(),
            String::from_utf8_lossy(&out.stdout).into_owned(),
            String::from_utf8_lossy(&out.stderr).into_owned(),
        )
    };
    let (code, table, said) = run(&["energyplus", "factors", "s.helio", "--by", "surface"]);
    assert_eq!((code, table.lines().count()), (Some(0), 1 + 3 * 703), "{said}");
    assert_eq!(
        table.lines().next(),
        Some(
            "surface,sun_azimuth_deg,sun_altitude_deg,ReflFacBmToDiffSolObs,ReflFacBmToDiffSolGnd,ReflFacSkySolObs,ReflFacSkySolGnd,ReflFacBmToBmSolObs"
        )
    );
    assert_eq!(run(&["energyplus", "factors", "s.helio", "--by", "surface"]).1, table);
    for args in [["--azimuth-step", "7"], ["-o", "f.xlsx"]] {
        assert_eq!(run(&["energyplus", "factors", "s.helio", args[0], args[1]]).0, Some(2));
    }
    fs::write(
        path("c.csv"),
        "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\none,150,40,800,100\ntwo,150,40,800,100\n",
    )
    .expect("written");
    fs::write(path("albedo.csv"), "reflectance\n0.1\n0.6\n").expect("written");
    let rows = |args: &[&str]| -> Vec<String> {
        let (code, table, said) = run(&[&["replay", "s.helio", "-c", "c.csv"], args].concat());
        assert_eq!(code, Some(0), "{said}");
        table.lines().skip(1).map(str::to_owned).collect()
    };
    let both = rows(&["--schedule", "terrain=albedo.csv"]);
    for (place, value) in [(0, "terrain=0.1"), (1, "terrain=0.6")] {
        let alone = rows(&["--reflectance", value]);
        for receiver in 0..3 {
            assert_eq!(both[2 * receiver + place], alone[2 * receiver + place]);
        }
    }
    let reflected = |row: usize| both[row].split(',').nth(4);
    assert!((0..3).any(|receiver| reflected(2 * receiver) != reflected(2 * receiver + 1)), "{both:?}");
    fs::write(path("albedo.csv"), "reflectance\n0.1\n").expect("written");
    for (more, expected) in [
        (&["--schedule", "terrain=albedo.csv"][..], "input out-of-range albedo.csv 1.0"),
        (&["--paths", "none", "--bounces", "3"], "argument other --bounces"),
    ] {
        assert_eq!(failure(&mut command(&[&["replay", "s.helio", "-c", "c.csv"], more].concat())), expected);
    }
}
