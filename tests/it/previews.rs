//! Previews of changed scenes: the light that they keep is off by less than they state, and no
//! command takes them for whole archives.

use std::path::Path;
use std::process::Command;

use heliotile_builder::pipeline::{BuildReport, Plan, ReusedArchives};
use heliotile_core::archive::Archive;
use heliotile_core::hemisphere::mix;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::sky::model::SkyModel;

use crate::cli::failure;
use crate::scenes::{block, build_with, data, plan, quad, receiver, replay, sky_only, tiles, v};
use crate::variants::{Dice, EDITS, Model, coarse, edit, hague, run};

/// Returns streets of 9 x 9 houses on a meadow, and receivers on their roofs, their walls and the
/// ground, 220 m wide.
fn town() -> Model {
    let mut objects = vec![quad(v(-130.0, -130.0, 0.0), v(260.0, 0.0, 0.0), v(0.0, 260.0, 0.0), 0)];
    let mut receivers = Vec::new();
    for (i, k) in (0..9).flat_map(|i| (0..9).map(move |k| (i, k))) {
        let [x, y] = [i, k].map(|n| f64::from(n) * 25.0 - 108.0);
        let height = 5.0 + f64::from((i * 7 + k * 5) % 6) * 2.0;
        objects.push(block(v(x, y, 0.0), v(x + 12.0, y + 11.0, height), 1));
        let mut put = |what: &str, place, normal| receivers.push(receiver(&format!("{what}{i}-{k}"), place, normal));
        put("roof", v(x + 5.0, y + 4.0, height + 0.02), v(0.0, 0.0, 1.0));
        put("south", v(x + 6.0, y - 0.02, 2.0), v(0.0, -1.0, 0.0));
        put("west", v(x - 0.02, y + 5.0, 3.0), v(-1.0, 0.0, 0.0));
        put("street", v(x - 5.0, y - 6.0, 0.02), v(0.0, 0.0, 1.0));
    }
    let materials = vec![Material::matt("meadow", 0.2, Class::Ground), Material::matt("wall", 0.4, Class::Obstruction)];
    Model { objects, materials, receivers }
}

fn preview(model: &Model, path: &Path, before: &Archive, percent: f64) -> BuildReport {
    let (scene, (plan, output)) = (model.scene(), plan(&coarse(), path));
    let plan = (Plan { preview_percent: Some(percent), ..plan }, output);
    let sources = ReusedArchives { before: Some(before), ..ReusedArchives::default() };
    build_with(&scene, &mut tiles(&model.receivers, &scene), &plan, &sources).expect("a preview")
}

/// Returns the totals of all receivers under a uniform sky of 100 W/m2, so in percent of the light
/// on open ground.
fn totals(path: &Path) -> Vec<f64> {
    let rows = replay(path, &[sky_only()], SkyModel::Uniform, MaxBounces::All, 577);
    rows.values().map(|row| row[0].total).collect()
}

/// Returns the number of edits in a test; `tools/variants/run` sets more.
fn count() -> usize {
    std::env::var("HELIOTILE_PREVIEWS").ok().and_then(|text| text.parse().ok()).unwrap_or(8)
}

/// Edits of two sites are previewed within 1 and 5 %: every receiver's total under a uniform sky is
/// off by less, and some responses and chunks are kept. If nothing can be bounded the archive is
/// whole. Built again from the archive before, it is that of a fresh build.
#[test]
fn errors_stay_below_the_bound() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let [path, fresh, from] = ["before.helio", "fresh.helio", "from.helio"].map(|file| folder.path().join(file));
    let (mut kept, mut rays) = (0, [0, 0]);
    for (number, (name, base)) in [("hague", hague()), ("town", town())].into_iter().enumerate() {
        base.build(&path, None);
        let before = Archive::open(&path).expect("an archive");
        for i in 0..count().div_ceil(2) {
            let mut variant = base.clone();
            edit(&mut variant, (i + number * 5) % EDITS, &mut Dice(mix(number as u64 + 70, i as u64)));
            let expected = variant.build(&fresh, None);
            let whole = totals(&fresh);
            for percent in [1.0, 5.0] {
                let found = preview(&variant, &from, &before, percent);
                let Some(preview) = &found.preview else {
                    assert_eq!(found.root, expected.root, "{name}, edit {i}");
                    continue;
                };
                let differ = totals(&from).iter().zip(&whole).map(|(a, b)| (a - b).powi(2)).collect::<Vec<f64>>();
                let worst = differ.iter().copied().fold(0.0, f64::max).sqrt();
                let rmse = (differ.iter().sum::<f64>() / differ.len() as f64).sqrt();
                eprintln!(
                    "{name}, edit {i}, within {percent} %: RMSE {rmse:.4}, worst {worst:.3}, {} of {} kept, {:.1} of {:.1} Mray",
                    preview.kept_receivers,
                    found.counts.receivers,
                    found.rays.total() as f64 / 1e6,
                    expected.rays.total() as f64 / 1e6
                );
                assert!(worst <= percent && preview.bound_percent == percent, "{name}, edit {i}: {worst}");
                kept += preview.kept_receivers;
                rays = [rays[0] + found.rays.total(), rays[1] + expected.rays.total()];
            }
            assert_eq!(variant.build(&from, Some(&before)).root, expected.root, "{name}, edit {i}");
        }
    }
    assert!(kept > 0 && rays[0] < rays[1], "{kept} {rays:?}");
}

/// A preview is reported by `info`, `query` and `compare`; `merge`, `--from` and `update` refuse
/// it; the command without `--preview` completes it, to the byte. Wrong bounds, and a bound without
/// an archive before, are refused.
#[test]
fn previews_are_reported_and_completed() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let at = folder.path();
    for file in ["scene.obj", "materials.toml", "receivers.csv"] {
        std::fs::copy(data(file), at.join(file)).expect("an input");
    }
    let tower =
        "o tower\nusemtl wall\nv 78500 457900 0\nv 78510 457900 0\nv 78510 457900 60\nv 78500 457900 60\nf 1 2 3 4\n";
    std::fs::write(at.join("tower.obj"), tower).expect("written");
    let conditions = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,50,700,100\n";
    std::fs::write(at.join("c.csv"), conditions).expect("written");
    let done = |line: &str| {
        let (code, said) = run(at, line);
        assert_eq!(code, Some(0), "{line}: {said}");
        said
    };
    let fails = |line: &str, expected: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        assert_eq!(failure(command.current_dir(at).args(line.split(' '))), expected, "{line}");
    };
    let common = "-m materials.toml -r receivers.csv --quality draft";
    done(&format!("build scene.obj {common} -o before.helio"));
    let after = format!("build scene.obj tower.obj {common} --from before.helio");
    done(&format!("{after} -o whole.helio"));
    done(&format!("{after} --preview 1% -o after.helio"));
    let info = Command::new(env!("CARGO_BIN_EXE_heliotile")).current_dir(at).args(["info", "after.helio"]).output();
    let info = String::from_utf8(info.expect("the program").stdout).expect("text");
    assert!(info.contains("  preview     light is off by at most 1 % of that on open ground"), "{info}");
    let said = done("replay after.helio --conditions c.csv -o out.csv");
    assert!(said.contains("after.helio is a preview: light is off by at most 1 %"), "{said}");
    let said = done("compare before.helio after.helio -c c.csv -o change.csv");
    assert!(said.contains("after.helio is a preview: light is off by at most 1 %"), "{said}");
    for line in
        ["archive merge after.helio before.helio -o m.helio", "archive merge whole.helio after.helio -o m.helio"]
    {
        fails(line, "input other-kind after.helio preview");
    }
    fails("update after.helio --remove tower -o m.helio", "input other-kind after.helio preview");
    fails(&format!("build scene.obj {common} --from after.helio -o m.helio"), "input other-kind after.helio preview");
    assert!(!at.join("m.helio").exists());
    fails(&format!("build scene.obj {common} --preview 1% -o m.helio"), "argument missing --from");
    for percent in ["0%", "80%", "some"] {
        fails(&format!("{after} --preview {percent} -o m.helio"), &format!("argument unreadable --preview {percent}"));
    }
    let bytes = |name: &str| std::fs::read(at.join(name)).expect("an archive");
    assert!(bytes("after.helio") != bytes("whole.helio"));
    done(&format!("{after} -o after.helio"));
    assert!(bytes("after.helio") == bytes("whole.helio"));
}
