//! Audits: archives beside the reference path tracer, which follows single paths of light.

use std::fs;

use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::pipeline::{Plan, PreparedScene};
use heliotile_builder::reference::comparison::{Pair, deviation, mean_w_m2};
use heliotile_builder::reference::{AuditInputs, Audited, audit};
use heliotile_builder::settings::{Quality, Rungs};
use heliotile_core::archive::Archive;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Silent;
use heliotile_core::sky::model::SkyModel;
use heliotile_files::spill::TempFiles;
use heliotile_scene::Scene;
use heliotile_scene::site::SceneFiles;

use crate::cli::{Folder, golden, stderr, stdout};
use crate::scenes::{build, fine, many, mirror_town, plan, site, tiles};

/// On a town with mirrors and glass, 60 receivers at `fine` are within 1.2 % of the reference path
/// tracer, with a bias below 0.4 % and an interval narrower than 1 %. Each of the six components is
/// above 0 in both, and none is off by more than 1 % RMSE.
#[test]
fn mirrors_and_glass_agree_with_the_reference() {
    let scene = mirror_town();
    // Of five neighbours two, so that all heights and tilts stay.
    let some: Vec<_> = many().into_iter().enumerate().filter(|(i, _)| i % 5 < 2).map(|(_, one)| one).collect();
    let (prepared, built) = (PreparedScene::new(&scene).expect("a tree"), site(&scene, &some, &fine()));
    let conditions = ErrorConditions::Spread.some(64);
    let archive = Archive::open(&built.path).expect("an archive");
    let audited = audit(&AuditInputs {
        archive: &archive,
        scene: &prepared,
        conditions: &conditions,
        hours: 8,
        sky: SkyModel::Perez,
        samples: 60,
        time: None,
        paths: 1024,
        seed: 1,
        memory: MemoryBudget::DEFAULT,
        storage: &TempFiles::new(std::env::temp_dir()),
        observer: &Silent,
    });
    let Audited { pairs, suns, .. } = audited.expect("an audit");
    let mean = mean_w_m2(&pairs);
    for part in 0..7 {
        let found = deviation(&pairs, &suns, part);
        let [bias, rmse] = [found.bias_w_m2, found.rmse_w_m2].map(|known| known.times(100.0 / mean));
        let light = |of: fn(&Pair, usize) -> f64| pairs.iter().map(|pair| of(pair, part)).sum::<f64>();
        assert!(light(|pair, part| pair.result[part]) > 0.0 && light(|pair, part| pair.reference.mean[part]) > 0.0);
        let most = if part == 6 { 1.2 } else { 1.0 };
        assert!(rmse.value < most && bias.value.abs() < 0.4 && rmse.high - rmse.low < 1.0, "{part} {bias:?} {rmse:?}");
    }
}

/// The program writes a page, a table of 8 hours a receiver and two pictures, the same on one
/// thread. An archive that claims 0.01 % is refuted with exit code 1, one that claims 20 % is not.
/// With a table of 3 conditions each receiver is checked in all of them. Another scene, a sky that
/// has no radiance and a word for a number are refused.
#[test]
fn an_audit_refutes_false_claims_only() {
    let folder = Folder::new();
    let files = [folder.path("scene.obj")];
    let scene = SceneFiles::new(&files, Some(&folder.path("materials.toml"))).and_then(|site| Scene::load_site(&site));
    let scene = scene.expect("a scene");
    for (name, rmse_percent) in [("modest.helio", 20.0), ("bold.helio", 0.01)] {
        let (plan, output) = plan(&Rungs::new(Quality::Draft).settings(), &folder.path(name));
        let plan = Plan { accuracy: Some(Accuracy { rmse_percent, ..Accuracy::default() }), ..plan };
        build(&scene, &mut tiles(&many(), &scene), &(plan, output)).expect("a build");
    }
    let inputs = "scene.obj -m materials.toml --weather golden.epw --samples 30 --paths 512";
    fs::copy(golden(), folder.path("golden.epw")).expect("a copy");
    let modest = folder.run(&format!("archive audit modest.helio {inputs} -o report"));
    let said = stdout(&modest);
    assert_eq!(modest.status.code(), Some(0), "{}", stderr(&modest));
    assert!(said.contains("30 receivers, 240 hours of golden.epw in all") && said.contains("not refuted"), "{said}");
    let read = |name: &str| fs::read_to_string(folder.path("report").join(name)).expect(name);
    let table = read("audit.csv");
    assert_eq!((table.lines().count(), table.lines().next().map(|line| line.split(',').count())), (241, Some(24)));
    assert_eq!(read("index.html").matches("<svg").count(), 2);
    let mut alone = folder.command(&format!("archive audit modest.helio {inputs} -o alone"));
    assert!(alone.env("RAYON_NUM_THREADS", "1").status().expect("the program").success());
    assert_eq!(fs::read_to_string(folder.path("alone/audit.csv")).expect("a table"), table);

    let bold = folder.run(&format!("archive audit bold.helio {inputs} --paths 8192").replace("--paths 512 ", ""));
    assert_eq!((bold.status.code(), stdout(&bold).contains("REFUTED")), (Some(1), true), "{}", stdout(&bold));

    folder.write(
        "three.csv",
        "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\na,180,40,800,90\nb,90,10,300,50\nc,0,-5,0,20\n",
    );
    let three = "scene.obj -m materials.toml --conditions three.csv --samples 20 --paths 512";
    let said = stdout(&folder.run(&format!("archive audit modest.helio {three}")));
    assert!(said.contains("20 receivers, 60 hours of three.csv in all"), "{said}");
    folder.fails(
        &format!("archive audit modest.helio {three} --weather golden.epw"),
        "argument excludes --conditions --weather",
    );

    folder.write("other.toml", "[wall]\ndiffuse = 0.5\n[roof]\ndiffuse = 0.2\n[grass]\ndiffuse = 0.25\n");
    folder.fails("archive audit bold.helio scene.obj -m other.toml", "input other-inputs scene.obj");
    folder.fails("archive audit bold.helio scene.obj -m materials.toml --sky perez1990", "argument other --sky");
    folder.fails(
        "archive audit bold.helio scene.obj -m materials.toml --seconds soon",
        "argument unreadable --seconds soon",
    );
    folder.fails("archive audit none.helio scene.obj -m materials.toml", "missing-file none.helio");
}
