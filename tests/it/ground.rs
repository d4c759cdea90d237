//! The endless ground, of `materials.toml` and of EnergyPlus models, against closed forms.

use heliotile_builder::settings::BuildSettings;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::sky::model::SkyModel;
use heliotile_scene::Scene;

use crate::cli::{Folder, stderr, stdout};
use crate::scenes::*;

/// Open receivers at seven tilts stand 300 m from a small black box and 2 m above an endless ground
/// of albedo 0.2 at 31.5 m. The light of the ground is 0.2 x (1 - cos)/2 of a uniform sky's and of
/// the sun's horizontal irradiance, that of the sky (1 + cos)/2, all within 0.3 % of the open sky's
/// and of the sun's.
#[test]
fn endless_ground_lights_tilts_by_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let corners = "v 300 0 32\nv 301 0 32\nv 301 1 32\nv 300 1 32\nv 300 0 33\nv 301 0 33\nv 301 1 33\nv 300 1 33\n";
    let faces = "usemtl box\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let obj = write("s.obj", &format!("{corners}{faces}"));
    let toml = write("m.toml", "[box]\ndiffuse = 0\n[endless_ground]\nelevation = 31.5\ndiffuse = 0.2\n");
    let scene = Scene::load(&obj, Some(&toml)).expect("a scene");
    let tilts = [0.0, 20.0, 37.0, 60.0, 90.0, 135.0, 180.0];
    let receivers: Vec<_> =
        tilts.iter().map(|&t| receiver(&format!("{t}"), v(3.3, 1.7, 33.5), tilted(t, 140.0))).collect();
    let site = site(&scene, &receivers, &BuildSettings::default());
    let (dhi, dni, altitude) = (100.0, 800.0, 35.0_f64);
    let rows = site.replay(&[sun(200.0, altitude, dni, dhi)], SkyModel::Uniform, MaxBounces::All);
    let direct = dni * altitude.to_radians().sin();
    for tilt in tilts {
        let (row, cos) = (rows[&format!("{tilt}")][0], tilt.to_radians().cos());
        let ground = 0.2 * (1.0 - cos) / 2.0;
        let errors = [
            (row.sky_direct / dhi - (1.0 + cos) / 2.0).abs(),
            (row.sky_reflected / dhi - ground).abs(),
            (row.sun_reflected / direct - ground).abs(),
        ];
        println!("tilt {tilt}: sky, its ground, the sun's ground off by {errors:.4?}");
        assert!(errors.iter().all(|error| *error < 0.003), "{tilt}: {errors:?}");
    }
}

/// A model whose ground reflects 0.6 in March, half of that under 0.3 cm of snow, sends 0.6 and 0.3
/// of the global horizontal irradiance up to a receiver that looks down and half of it to a wall,
/// in the sum of three days within 0.5 %. `--reflectance` takes precedence over it, `extract` and
/// `merge` carry it, and `repair` keeps it even if a model now states April. Without ground a build
/// says that the wall sees nothing in 50 % of its hemisphere, and `repair` recognises that scene.
#[test]
fn ground_reflectance_follows_months_and_snow() {
    let folder = Folder::new();
    folder.write(
        "m.idf",
        "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World;\n\
         Site:GroundReflectance,0,0,0.6,0,0,0,0,0,0,0,0,0; Site:GroundReflectance:SnowModifier,0.5;\n\
         Shading:Site,Post,180,90,300,300,0,0.5,1;\n",
    );
    folder.write("r.csv", "receiver,x,y,z,nx,ny,nz\ndown,0,0,2,0,0,-1\nwall,0,0,2,0,-1,0\n");
    for name in ["down", "wall"] {
        folder.write(&format!("{name}.csv"), &format!("receiver\n{name}\n"));
    }
    let days = std::fs::read_to_string(std::path::Path::new(crate::ROOT).join("tests/data/weather/golden_3_days.epw"))
        .expect("weather");
    let (mut snowy, mut expected) = (Vec::new(), 0.0);
    for line in days.lines() {
        let mut cells: Vec<&str> = line.split(',').collect();
        if let (Some(&day), Some(ghi), true) = (cells.get(2), cells.get(13), cells.len() > 30) {
            let ghi: f64 = ghi.parse().expect("GHI");
            expected += ghi / 1e3 * if day == "20" { 0.3 } else { 0.6 };
            cells[30] = if day == "20" { "0.3" } else { "0" };
        }
        snowy.push(cells.join(","));
    }
    assert!(expected > 3.0, "{expected}");
    folder.write("w.epw", &(snowy.join("\n") + "\n"));
    let run = |arguments: &str| {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
        output
    };
    let totals = |options: &str| -> Vec<f64> {
        let csv =
            stdout(&run(&format!("replay {options} -w w.epw --every year --columns sun_reflected,sky_reflected")));
        let row = |line: &str| line.split(',').skip(2).map(|cell| cell.parse::<f64>().expect("a number")).sum();
        // Rows sorted by name: `down`, `wall`.
        let mut lines: Vec<&str> = csv.lines().skip(1).collect();
        lines.sort_unstable();
        lines.into_iter().map(row).collect()
    };
    let built = stderr(&run("build m.idf -r r.csv -o m.helio"));
    assert!(built.contains("reflects 0 to 0.6 by month, times 0.5 under snow, as m.idf states"), "{built}");
    let found = totals("m.helio");
    let off = [(found[0] / expected - 1.0).abs(), (found[1] / (0.5 * expected) - 1.0).abs()];
    println!("{found:?} for {expected}: off by {off:?}");
    assert!(off.iter().all(|off| *off < 0.005), "{off:?}");
    let constant = totals("m.helio --reflectance ground=0.05");
    assert!(constant[0] < 0.2 * found[0], "{constant:?}");

    for name in ["down", "wall"] {
        run(&format!("archive extract m.helio -r {name}.csv -o {name}.helio"));
    }
    run("archive merge down.helio wall.helio -o both.helio");
    run("archive diff m.helio both.helio");
    assert_eq!(totals("both.helio"), found);
    assert!(stdout(&run("info both.helio")).contains("0 0 0.6 0 0 0 0 0 0 0 0 0 by month, times 0.5 under snow; 0.05"));

    let whole = std::fs::read(folder.path("m.helio")).expect("an archive");
    let model = std::fs::read_to_string(folder.path("m.idf")).expect("a model");
    folder.write("april.idf", &model.replace("0,0,0.6,0,", "0,0,0,0.6,"));
    let mut bytes = whole.clone();
    bytes[whole.len() / 2] ^= 1;
    std::fs::write(folder.path("m.helio"), bytes).expect("written");
    run("archive repair m.helio april.idf -r r.csv");
    assert!(std::fs::read(folder.path("m.helio")).expect("repaired") == whole);

    let bare = run("build m.idf --no-ground -r r.csv -o bare.helio");
    assert!(stderr(&bare).contains("walls see no surface in 50.0 % of their hemisphere"), "{}", stderr(&bare));
    assert!(stdout(&run("info bare.helio")).contains("horizon     walls see no surface in 50.0 %"));
    assert!(!stdout(&run("info m.helio")).contains("see no surface"));
    let mut bytes = std::fs::read(folder.path("bare.helio")).expect("an archive");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(folder.path("bare.helio"), bytes).expect("written");
    let repaired = run("archive repair bare.helio m.idf");
    assert!(stdout(&repaired).contains("root as before"), "{}", stdout(&repaired));
}

/// A garden of 12 x 10 m reaches 4 m into a long house on its north side. South of the house it
/// has 72 receivers at 1 m, 2 cm above the ground; the 48 in the house are left out. A box beside
/// it has 6. At the equinox half of the garden or more has two hours of sun (BRE 209), and the yard
/// north of the house, 8 m2, has not.
#[test]
fn areas_of_the_ground_get_receivers() {
    let folder = Folder::new();
    let mut house = String::from("v -60 -60 0\nv 60 -60 0\nv 60 60 0\nv -60 60 0\n");
    for z in [0, 6] {
        house.push_str(&format!("v -40 6 {z}\nv 40 6 {z}\nv 40 10 {z}\nv -40 10 {z}\n"));
    }
    house.push_str("o lawn\nusemtl lawn\nf 1 2 3 4\no house\nusemtl brick\nf 9 10 11 12\n");
    house.push_str("f 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n");
    folder.write("s.obj", &house);
    let areas = "area,x,y\ngarden,0,0\ngarden,12,0\ngarden,12,10\ngarden,0,10\n\
                 yard,4,10\nyard,8,10\nyard,8,12\nyard,4,12\n";
    folder.write("areas.csv", areas);
    let run = |arguments: &str| {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
        output
    };
    let made = run("receivers s.obj --within areas.csv --spacing 1m -o r.csv");
    assert!(stdout(&made).contains("80 receivers in 2 areas"), "{}", stdout(&made));
    assert!(stderr(&made).contains("48 places left out: inside a building"), "{}", stderr(&made));
    let table = std::fs::read_to_string(folder.path("r.csv")).expect("receivers");
    assert!(table.contains("garden#1,0.5000,0.5000,0.0200,0.000000,0.000000,1.000000,1.0000,garden,"), "{table}");
    let boxed = run("receivers s.obj --within 20,0,23,2 --spacing 1m -o -");
    assert_eq!(stdout(&boxed).lines().filter(|line| line.starts_with("box#")).count(), 6);
    run("build s.obj -r r.csv --latitude 52 --longitude 5 -o s.helio");
    let judged = stdout(&run("sunlight s.helio --rule bre-ground --by surface"));
    let verdict = |name: &str| -> &str {
        let row = judged.lines().find(|line| line.contains(&format!(",{name},"))).expect("a row");
        row.split(',').nth(5).expect("a verdict")
    };
    assert_eq!((verdict("garden"), verdict("yard")), ("met", "broken"), "{judged}");
    folder.fails("receivers s.obj --within 200,0,210,9 -o x.csv", "argument misplaced --within");
    folder.fails("receivers s.obj --within areas.csv -o areas.csv", "input same-file areas.csv areas.csv");
}
