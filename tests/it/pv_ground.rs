//! The ground among rows of modules: sky and shade by closed forms, light for plants, places left
//! out, and wrong input.

use std::collections::HashMap;

use crate::cli::{Folder, golden, stderr};
use crate::pv::{EVEN, PLACE, good, number, table};
use crate::scenes::data;

/// Distance between rows of modules in a cut from south to north, metres. Rows are 2 m up a slope
/// of 30 degrees; below: the first lower edge lies at -13 m, and 9 rows stand on 26 m; 0.5 m above
/// the ground.
const PITCH_M: f64 = 3.0;
const FIRST_M: f64 = -13.0;
const LOW_M: f64 = 0.5;

/// Returns the ends of rows in the cut, `[y, z]`: lower edge, upper edge.
fn cut(rows: std::ops::Range<i32>) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let tilt = 30.0_f64.to_radians();
    let (deep, high) = (2.0 * tilt.cos(), 2.0 * tilt.sin());
    rows.map(move |row| {
        let y = FIRST_M + f64::from(row) * PITCH_M;
        [[y, LOW_M], [y + deep, LOW_M + high]]
    })
}

/// Writes a black meadow with black rows, 120 m wide in all, in the same areas: the western and
/// eastern ones have no receivers on the ground, the middle metre has them 0.5 m apart, 6 a pitch.
fn meadow() -> Folder {
    let folder = Folder::new();
    folder.write("even.csv", EVEN);
    folder.write("field.obj", "v -100 -100 0\nv 100 -100 0\nv 100 100 0\nv -100 100 0\nusemtl grass\nf 1 2 3 4\n");
    folder.write("field.toml", "[grass]\ndiffuse = 0\nclass = \"ground\"\n[endless_ground]\ndiffuse = 0\n");
    let rows = |name: &str, from: f64, to: f64, more: &str| {
        format!(
            "[[rows]]\nname = \"{name}\"\narea = [[{from}, -13], [{to}, -13], [{to}, 13], [{from}, 13]]\ntilt = 30\nazimuth = 180\n\
             pitch = {PITCH_M}\nwidth = {}\nheight = 2\nclearance = {LOW_M}\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = 1\n{more}",
            to - from
        )
    };
    let text =
        [rows("west", -60.0, -0.5, ""), rows("middle", -0.5, 0.5, "ground = 0.5\n"), rows("east", 0.5, 60.0, "")];
    folder.write("rows.toml", &text.concat());
    folder
}

/// Returns the places of the middle pitch, from a lower edge to the next.
fn in_the_middle(rows: &[HashMap<String, String>]) -> Vec<&HashMap<String, String>> {
    let middle = FIRST_M + 4.0 * PITCH_M;
    rows.iter().filter(|row| (middle..middle + PITCH_M).contains(&number(row, "y"))).collect()
}

/// Returns the share of a uniform sky that a place of the ground sees among endless rows, by
/// crossed strings: the rest between the rows' edges as seen from there.
fn open_sky(y: f64) -> f64 {
    let mut hidden: Vec<[f64; 2]> = cut(-60..70)
        .map(|ends| {
            let [a, b] = ends.map(|[to, z]| (to - y).atan2(z).sin());
            [a.min(b), a.max(b)]
        })
        .collect();
    hidden.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut open, mut last) = (0.0, -1.0_f64);
    for [from, to] in hidden {
        open += (from - last).max(0.0);
        last = last.max(to);
    }
    0.5 * (open + (1.0 - last).max(0.0))
}

/// Under a uniform sky the ground among black rows sees the sky that crossed strings of endless
/// rows leave open, at 6 positions of the middle pitch, two places each, within 1 % of the open
/// sky: by its light, by its PAR beside that of an open plain, and by `sky_view`. There are 104
/// places, 52 lines of 2, the modules keep their names, and 0.6 kWh/m2 in 6 hours of a day are
/// 0.5296 of them in PAR and 4.57 umol per joule of that.
#[test]
fn ground_sees_the_sky_of_crossed_strings() {
    let folder = meadow();
    let done =
        good(&folder, &format!("pv field.obj -m field.toml {PLACE} -w even.csv --rows rows.toml --sky uniform -o out"));
    let places = table(&folder, "out/ground.csv");
    assert_eq!(places.len(), 52 * 2);
    assert!(places.iter().all(|row| row["receiver"].starts_with("middle/ground/")), "{places:?}");
    let middle = in_the_middle(&places);
    assert_eq!(middle.len(), 6 * 2);
    for row in middle {
        let (behind, y) = (number(row, "behind_m"), number(row, "y"));
        assert!((y - (FIRST_M + 4.0 * PITCH_M) - behind).abs() < 1e-4, "{row:?}");
        let expected = open_sky(y);
        for (column, found) in [
            ("total_kwh_m2", number(row, "total_kwh_m2") / 0.6),
            ("par_of_open_percent", number(row, "par_of_open_percent") / 100.0),
            ("sky_view", number(row, "sky_view")),
        ] {
            assert!((found - expected).abs() < 0.01, "{column} {behind} m behind: {found}, not {expected}");
        }
        let (par, photons) = (number(row, "total_par_kwh_m2"), number(row, "ppfd_mol_m2"));
        assert!((par - 0.5296 * number(row, "total_kwh_m2")).abs() < 2e-3, "{row:?}");
        assert!((photons - 4.57 * 3.6 * par).abs() < 0.02 && number(row, "dli_mol_m2_d") == photons, "{row:?}");
        assert!((number(row, "open_par_kwh_m2") - 0.5296 * 0.6).abs() < 1e-3, "{row:?}");
    }
    assert_eq!(table(&folder, "out/points.csv").len(), 3 * 9 * 2);
    assert_eq!(table(&folder, "out/hourly.csv").len(), 3 * 9 * 6);
    assert!(done.contains("ground among") && done.contains("\nmiddle                  104"), "{done}");
}

/// Under a sun in the south, 60 degrees high, and one 40 degrees to the west of it, 50 high, each
/// row's shadow lies where its edges throw it. At each of the 12 places of the middle pitch that
/// lie more than 5 cm from the shadow's ends the sun is there or not, and the width of the shade by
/// the 6 positions is that of the closed form within their distance.
#[test]
fn shadows_of_rows_lie_where_their_edges_throw_them() {
    let folder = meadow();
    good(&folder, &format!("pv field.obj -m field.toml {PLACE} -w even.csv --rows rows.toml --no-hourly -o out"));
    let places = table(&folder, "out/ground.csv");
    for (azimuth_deg, altitude_deg) in [(180.0_f64, 60.0_f64), (220.0, 50.0)] {
        folder.write(
            "sun.csv",
            &format!(
                "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nsun,{azimuth_deg},{altitude_deg},1000,0\n"
            ),
        );
        good(
            &folder,
            "replay out/site.helio --conditions sun.csv --receivers out/ground.csv --columns sun_direct,total -o lit.csv",
        );
        let lit: HashMap<String, f64> =
            table(&folder, "lit.csv").iter().map(|row| (row["receiver"].clone(), number(row, "total"))).collect();
        assert_eq!(lit.len(), places.len());
        // Shadows fall away from the sun, northwards by this length for each metre of height.
        let reach = (azimuth_deg - 180.0).to_radians().cos() / altitude_deg.to_radians().tan();
        let shades: Vec<[f64; 2]> = cut(-60..70).map(|ends| ends.map(|[y, z]| y + z * reach)).collect();
        let (mut shaded, mut checked) = (0, 0);
        for row in in_the_middle(&places) {
            let (y, found) = (number(row, "y"), lit[&row["receiver"]]);
            let is_shaded = found < 500.0 * altitude_deg.to_radians().sin();
            shaded += usize::from(is_shaded);
            if shades.iter().flatten().all(|end| (end - y).abs() > 0.05) {
                checked += 1;
                let hidden = shades.iter().any(|[from, to]| (*from..*to).contains(&y));
                let expected = if hidden { 0.0 } else { 1000.0 * altitude_deg.to_radians().sin() };
                assert!((found - expected).abs() < 5.0, "{azimuth_deg} {y}: {found}, not {expected}");
            }
        }
        let (width, found) = (shades[0][1] - shades[0][0], 0.25 * shaded as f64);
        assert!((found - width).abs() <= 0.5 && checked >= 8, "{found} {width} {checked}");
    }
}

/// Over three days places without reflected light get 0.4164 of the sun's light and 0.5296 of the
/// sky's as PAR, within 1e-4 of them, which is 41 to 53 % of all; days are means of three, and
/// months add up. On a slope with grass that is dark to plants PAR is that of `replay`, which takes
/// `ground.csv` for its list of receivers, and the months' sum is the year's.
#[test]
fn par_is_its_share_of_sun_and_sky() {
    let folder = meadow();
    let weather = golden();
    let weather = weather.display();
    good(&folder, &format!("pv field.obj -m field.toml -w {weather} --rows rows.toml --no-hourly -o out"));
    for row in table(&folder, "out/ground.csv") {
        let [sun, sky, par] =
            ["sun_direct_kwh_m2", "sky_direct_kwh_m2", "total_par_kwh_m2"].map(|column| number(&row, column));
        assert!((par - 0.4164 * sun - 0.5296 * sky).abs() < 1.1e-3 + 1e-4 * par, "{row:?}");
        assert!((0.41..0.531).contains(&(par / number(&row, "total_kwh_m2"))), "{row:?}");
        assert!((3.0 * number(&row, "dli_mol_m2_d") - number(&row, "ppfd_mol_m2")).abs() < 2e-3, "{row:?}");
    }
    folder.write("slope.obj", "v -50 -50 0\nv 50 -50 5\nv 50 50 25\nv -50 50 20\nusemtl grass\nf 1 2 3 4\n");
    folder.write("slope.toml", "[grass]\ndiffuse = { solar = 0.25, par = 0.06 }\nclass = \"ground\"\n");
    folder.write(
        "rows.toml",
        "[[rows]]\nname = \"s\"\narea = [[-8, -8], [8, -8], [8, 8], [-8, 8]]\ntilt = 25\nazimuth = 200\npitch = 5\nwidth = 2\nheight = 2\n\
         clearance = 1.5\nground = 1.7\nsamples = 2\n",
    );
    good(&folder, &format!("pv slope.obj -m slope.toml -w {weather} --rows rows.toml --no-hourly -o slope"));
    good(
        &folder,
        &format!(
            "replay slope/site.helio -w {weather} --every total --columns total --bands par --receivers slope/ground.csv -o par.csv"
        ),
    );
    let (places, replayed) = (table(&folder, "slope/ground.csv"), table(&folder, "par.csv"));
    let months = table(&folder, "slope/ground_months.csv");
    assert!(places.len() > 80 && replayed.len() == places.len(), "{} {}", places.len(), replayed.len());
    for row in &places {
        let of = |table: &[HashMap<String, String>], column: &str| -> f64 {
            table.iter().filter(|other| other["receiver"] == row["receiver"]).map(|other| number(other, column)).sum()
        };
        for column in ["total_kwh_m2", "total_par_kwh_m2", "ppfd_mol_m2"] {
            let value = number(row, column);
            assert!((of(&replayed, column) - value).abs() < 2e-3, "{column}: {row:?}");
            assert!((of(&months, column) - value).abs() < 2e-3, "{column}: {row:?}");
        }
        // The slope is 0.05 to the east and 0.2 to the north.
        let ground = 0.05 * (number(row, "x") + 50.0) + 0.2 * (number(row, "y") + 50.0);
        assert!((number(row, "z") - ground - 0.005).abs() < 2e-3, "{row:?}");
    }
    let reflected = places.iter().map(|row| number(row, "sun_reflected_kwh_m2")).fold(0.0, f64::max);
    assert!(reflected > 0.01, "{reflected}");
}

/// Places inside of modules that lie on the ground are left out, with a message; the others are
/// there. Without `ground` there is no table of it, and the table of an earlier `ground` is removed
/// when the folder is replaced.
#[test]
fn places_inside_of_modules_are_left_out() {
    let folder = meadow();
    let rows = |more: &str| {
        format!(
            "[[rows]]\nname = \"f\"\narea = [[0, 0], [6, 0], [6, 6], [0, 6]]\ntilt = 0\nazimuth = 180\npitch = 2\nwidth = 1\nheight = 1\n{more}"
        )
    };
    folder.write("rows.toml", &rows("ground = 0.5\n"));
    let pv = format!(
        "pv field.obj -m field.toml {PLACE} -w even.csv --rows rows.toml --quality draft --no-hourly --replace -o out"
    );
    let output = folder.run(&pv);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("the rows `f`: 72 of 144 places on the ground are left out"), "{said}");
    let places = table(&folder, "out/ground.csv");
    assert_eq!(places.len(), 72);
    assert!(places.iter().all(|row| number(row, "behind_m") > 1.0), "{places:?}");
    folder.write("rows.toml", &rows(""));
    good(&folder, &pv);
    assert!(!folder.path("out/ground.csv").exists() && !folder.path("out/ground_months.csv").exists());
}

/// Nine wrong inputs are refused with the reason and leave no folder: distances of 0, below it, no
/// number, or so small that there would be more than a million places; no place in the area; rows
/// on a wall; an unknown word for `ground`, in a list.
#[test]
fn wrong_ground_inputs_are_refused() {
    let folder = Folder::new();
    let weather = golden();
    let pv = format!("pv scene.obj -m materials.toml -w {} -o out --rows rows.toml", weather.display());
    let rows = |area: &str, more: &str| {
        format!(
            "[[rows]]\nname = \"a\"\n{area}\ntilt = 30\nazimuth = 180\npitch = 3\nwidth = 1\nheight = 2\nclearance = 1\n{more}\n"
        )
    };
    let lawn = "area = [[12, -20], [28, -20], [28, 20], [12, 20]]";
    for (area, more, parts) in [
        (lawn, "ground = 0", &["rows.toml", "the rows `a`: `ground` is 0, not from 0.01 to 1000"][..]),
        (lawn, "ground = -0.5", &["`ground` is -0.5, not from 0.01 to 1000"]),
        (lawn, "ground = nan", &["`ground` is NaN"]),
        (lawn, "ground = 1e-9", &["not from 0.01 to 1000"]),
        (lawn, "ground = \"0.5\"", &["rows.toml, line 10"]),
        (lawn, "ground = 0.02", &["the number of places on the ground among rows", "1000000"]),
        (lawn, "grund = 0.5", &["rows.toml, line 10", "unknown field `grund`", "samples, ground"]),
        (
            "area = [[12, -20], [15, -20], [15, -11], [28, -11], [28, -20], [29, -20], [29, -10], [12, -10]]",
            "ground = 1000",
            &["the rows `a`: their area has no free place on the ground"],
        ),
    ] {
        folder.write("rows.toml", &rows(area, more));
        folder.refused(&pv, parts);
    }
    let wall = "surface = \"GUID_27168863-26F1-4D62-9693-A9E9D13EFC11_1/wall3\"";
    folder.write("rows.toml", &rows(wall, "ground = 0.5"));
    let city = data("../cityjson/hague.city.json");
    folder.refused(
        &format!("pv {} -w {} -o out --rows rows.toml", city.display(), weather.display()),
        &["rows.toml: the rows `a`: no module fits"],
    );
    assert!(!folder.path("out").exists());
}
