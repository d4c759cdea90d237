//! Single-axis trackers of `pv` beside pvlib: angles, light on fronts, energy; surroundings that
//! hide the sun; and wrong input.

use std::fs;

use crate::cli::Folder;
use crate::pv::{good, number, table};

/// Eleven hours of 21 March.
const HOURS: &str = "time,dni,dhi,temp_air,wind_speed\n\
                     2019-03-21T07:00+01:00,180,60,3,2\n2019-03-21T08:00+01:00,420,90,5,2\n\
                     2019-03-21T09:00+01:00,590,100,7,2\n2019-03-21T10:00+01:00,700,110,9,2\n\
                     2019-03-21T11:00+01:00,780,115,11,2\n2019-03-21T12:00+01:00,820,120,12,2\n\
                     2019-03-21T13:00+01:00,800,118,13,2\n2019-03-21T14:00+01:00,760,115,14,2\n\
                     2019-03-21T15:00+01:00,650,105,13,2\n2019-03-21T16:00+01:00,500,95,12,2\n\
                     2019-03-21T17:00+01:00,230,70,9,2\n";
const PLACE: &str = "--latitude 40 --longitude 15";
const BLACK: &str = "[ground]\ndiffuse = 0\nclass = \"ground\"\n[wall]\ndiffuse = 0\n";

/// Returns nine rows of black trackers 2 m high and 5 m apart.
fn rows(tracker: &str) -> String {
    format!(
        "[[rows]]\nname = \"r\"\nrows = 9\nmodules = 1\ntracker = {{ hub = 1.5, {tracker} }}\npitch = 5\nwidth = 300\n\
         height = 2\nthickness = 0.001\nfront = 0\nrear = 0\nkwp = 1\n"
    )
}

/// Returns a folder with the hours and a file of rows.
fn folder(tracker: &str) -> Folder {
    let folder = Folder::new();
    folder.write("hours.csv", HOURS);
    folder.write("black.toml", BLACK);
    folder.write("rows.toml", &rows(tracker));
    folder
}

fn pv(rest: &str) -> String {
    format!("pv -m black.toml {PLACE} -w hours.csv --rows rows.toml --sky uniform --bifaciality 0 -o out {rest}")
}

/// Angles of the middle row, the beam and the sky on its front are those of pvlib 0.16.1
/// (`tracking.singleaxis`, `bifacial.infinite_sheds`, isotropic sky, black ground) in eleven hours:
/// angles within 0.01 degrees, the beam within 0.01 %, the sky within 1.5 %. With backtracking, and
/// without it about axes of another direction. A day's DC of nine rows is that of `iam.physical`,
/// `sapm_cell` and `pvwatts_dc` for an inner row, or up to 6 % more: outer rows see more of the
/// sky. A second run traces nothing.
#[test]
fn trackers_have_the_light_of_pvlib() {
    let turns_back = [
        [-29.417, 122.005, 53.610],
        [-58.292, 388.203, 60.749],
        [-46.744, 512.731, 77.164],
        [-30.382, 569.206, 98.049],
        [-12.014, 605.845, 112.525],
        [7.347, 633.535, 118.730],
        [26.072, 641.884, 108.243],
        [42.935, 649.978, 92.215],
        [56.929, 594.250, 72.098],
        [39.200, 393.734, 78.267],
        [11.523, 72.946, 68.594],
    ];
    let shades = [
        [-60.000, 118.331, 39.617],
        [-52.043, 308.103, 65.494],
        [-31.538, 412.867, 88.303],
        [-10.359, 499.339, 108.066],
        [8.866, 599.462, 113.503],
        [25.020, 692.597, 110.877],
        [38.462, 735.014, 98.679],
        [50.076, 739.796, 85.630],
        [59.039, 647.896, 70.200],
        [60.000, 396.702, 62.726],
        [60.000, 72.946, 46.219],
    ];
    for (tracker, expected, dc_kwh) in
        [("step = 15", turns_back, 5.1787), ("step = 15, axis_azimuth = 155, backtrack = false", shades, 5.1604)]
    {
        let folder = folder(tracker);
        good(&folder, &pv(""));
        let hours = table(&folder, "out/hourly.csv");
        let middle = hours.iter().filter(|row| row["point"] == "r/5/1");
        for (row, [theta, beam, sky]) in middle.zip(expected) {
            let found = |column: &str| number(row, column);
            assert!((found("tracker_theta") - theta).abs() < 0.01, "{row:?}");
            assert!((found("poa_front_direct") / beam - 1.0).abs() < 1e-4, "{beam} {row:?}");
            assert!((found("poa_front_diffuse") / sky - 1.0).abs() < 0.015, "{sky} {row:?}");
            assert_eq!(found("poa_back_direct"), 0.0);
        }
        let sums = table(&folder, "out/points.csv");
        let front = sums.iter().find(|row| row["point"] == "r/5/1" && row["side"] == "front").expect("a front");
        let direct: f64 = expected.iter().map(|hour| hour[1] / 1000.0).sum();
        assert!((number(front, "sun_direct_kwh_m2") / direct - 1.0).abs() < 1e-3 && front["tilt_deg"].is_empty());
        let energy = table(&folder, "out/energy.csv");
        let each = number(&energy[0], "dc_kwh") / 9.0;
        // The outer rows see more sky and, without backtracking, more sun.
        assert!(each >= 0.995 * dc_kwh && each < 1.06 * dc_kwh, "{each}");
        let again = good(&folder, &pv(""));
        assert_eq!(again.matches("up to date").count(), 9, "{again}");
    }
}

/// A wall 20 m high, 30 m west of a single tracker, hides the sun across the axis below 31.7
/// degrees: from half past three on. Before 15:00 the beam is that of a tracker without a wall,
/// from 16:00 on it is 0, and the hour between loses a part. Without a wall there is no loss
/// against an open plain.
#[test]
fn a_wall_hides_the_sun_of_trackers() {
    let folder = folder("backtrack = false, step = 30");
    let ground = "v -500 -500 0\nv 500 -500 0\nv 500 500 0\nv -500 500 0\nusemtl ground\nf 1 2 3 4\n";
    folder.write(
        "scene.obj",
        &format!("{ground}v -30 -500 0\nv -30 500 0\nv -30 500 20\nv -30 -500 20\nusemtl wall\nf 5 6 7 8\n"),
    );
    folder.write("rows.toml", &rows("backtrack = false, step = 30").replace("rows = 9", "rows = 1"));
    folder.write("plain.obj", ground);
    let of = |scene: &str, out: &str| {
        good(&folder, &pv("").replace("pv -m", &format!("pv {scene} -m")).replace("-o out", &format!("-o {out}")));
        let hours = table(&folder, &format!("{out}/hourly.csv"));
        hours.iter().map(|hour| number(hour, "poa_front_direct")).collect::<Vec<f64>>()
    };
    let (open, walled) = (of("plain.obj", "open"), of("scene.obj", "walled"));
    for hour in 0..8 {
        assert!(open[hour] > 50.0 && (walled[hour] / open[hour] - 1.0).abs() < 1e-3, "{hour}: {walled:?} {open:?}");
    }
    assert!(walled[8] < 0.9 * open[8] && walled[8] > 0.1 * open[8], "{walled:?} {open:?}");
    assert!(walled[9].max(walled[10]) < 0.5 && open[10] > 50.0, "{walled:?} {open:?}");
    let loss = |name: &str| number(&table(&folder, &format!("{name}/points.csv"))[0], "shading_loss_percent");
    assert!(loss("open").abs() < 0.5 && loss("walled") > 10.0, "{} {}", loss("open"), loss("walled"));
}

/// The shade file is refused for trackers, and so are results of other modules in the folder, until
/// they may be replaced, and 6,400 trackers over a year; nothing is written or lost.
#[test]
fn wrong_requests_for_trackers_are_refused() {
    let folder = folder("step = 60");
    folder.fails(&pv("--shade"), "argument excludes --shade tracker");
    let many = rows("step = 60").replace("rows = 9\nmodules = 1", "rows = 80\nmodules = 80");
    folder.write("many.toml", &many.replace("width = 300", "width = 1"));
    let year = format!("{}/tests/data/weather/golden_tmy3.epw", crate::ROOT);
    folder.fails(&pv("").replace("hours.csv", &year).replace("rows.toml", "many.toml"), "limit 2691072000");
    assert!(!folder.path("out").exists());
    good(&folder, &pv("--no-hourly"));
    let there = fs::read_dir(folder.path("out/angles")).expect("a folder").count();
    assert_eq!(there, 3);
    folder.write("rows.toml", &rows("step = 60").replace("hub = 1.5", "hub = 1.6"));
    let before = fs::read(folder.path("out/points.csv")).expect("a table");
    folder.fails(&pv("--no-hourly"), "input other-inputs out");
    let other = rows("step = 60").replace("tracker = { hub = 1.5, step = 60 }", "tilt = 20\nazimuth = 180");
    folder.write("rows.toml", &other);
    folder.fails(&pv("--no-hourly"), "input other-inputs out");
    assert_eq!(fs::read(folder.path("out/points.csv")).expect("a table"), before);
    good(&folder, &pv("--no-hourly --replace"));
    assert!(folder.path("out/site.helio").exists() && !folder.path("out/angles/0.helio").exists());
}
