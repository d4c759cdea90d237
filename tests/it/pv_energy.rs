//! Energy of arrays that `pv` computes: years beside pvlib, hours by hand, strings, worth, and two
//! runs compared.

use std::path::Path;

use crate::cli::{Folder, stderr};
use crate::pv::{EVEN, PLACE, good, number, table};

/// Far from anything, on endless ground that reflects 0.2.
fn plain() -> Folder {
    let folder = Folder::new();
    folder.write("far.obj", "v 9000 9000 -9\nv 9000.01 9000 -9\nv 9000 9000.01 -9\nusemtl far\nf 1 2 3\n");
    folder.write("far.toml", "[far]\ndiffuse = 0\n[endless_ground]\ndiffuse = 0.2\n");
    folder
}

fn near(found: f64, right: f64, most_percent: f64) {
    assert!((found / right - 1.0).abs() < most_percent / 100.0, "{found}, not {right}");
}

/// A year of 4 kW on an open plain in Golden is that of pvlib 0.16.1, ModelChain.with_pvwatts under
/// Perez 1990 with the temperature model `sapm`: AC within 0.5 % of 6002.96 kWh at 35 degrees
/// south, its months within 1 %; DC of two strings within 0.5 %, 6271.74 and 4639.28 kWh, which add
/// up to the array. `tools/peers/power` computed the right values.
#[test]
fn a_year_on_an_open_plain_has_the_energy_of_pvlib() {
    let folder = plain();
    let weather = Path::new(crate::ROOT).join("tests/data/weather/golden_tmy3.epw");
    let pv = |rest: &str| {
        let weather = weather.display();
        let options = "--sky perez1990 --temperature-coefficient=-0.47 --no-hourly --replace -o out";
        good(&folder, &format!("pv far.obj -m far.toml -w {weather} --points points.csv {options} {rest}"))
    };
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,35,180\n");
    let text = pv("--kwp 4 --price 0.25EUR");
    let year = &table(&folder, "out/energy.csv")[0];
    near(number(year, "ac_kwh"), 6002.962, 0.5);
    near(number(year, "dc_kwh"), 6271.740, 0.5);
    near(number(year, "ac_kwh_kwp"), number(year, "ac_kwh") / 4.0, 0.001);
    near(number(year, "value_eur"), number(year, "ac_kwh") / 4.0, 0.001);
    let words = format!("{:.0} kWh a year", number(year, "ac_kwh"));
    assert!(text.contains(&words) && text.contains("EUR a year"), "{text}");
    let right = [425.21, 421.68, 600.02, 579.03, 560.58, 529.35, 529.86, 561.4, 535.63, 471.75, 492.71, 295.75];
    let months = table(&folder, "out/energy_months.csv");
    assert_eq!(months.len(), 12);
    months.iter().zip(right).for_each(|(month, right)| near(number(month, "ac_kwh"), right, 1.0));
    let points =
        "point,x,y,z,tilt,azimuth,kwp,string\np,0,0,1,35,180,4,south\nq,9,0,1,60,250,1,west\nr,9,9,1,60,250,3,west\n";
    folder.write("points.csv", points);
    pv("");
    let rows = table(&folder, "out/energy.csv");
    let names: Vec<&str> = rows.iter().map(|row| row["string"].as_str()).collect();
    assert_eq!(names, ["array", "south", "west"]);
    near(number(&rows[1], "dc_kwh"), 6271.740, 0.5);
    near(number(&rows[2], "dc_kwh"), 4639.283, 0.5);
    for column in ["kwp", "dc_kwh", "ac_kwh", "clipped_kwh"] {
        let all = number(&rows[0], column);
        assert!((number(&rows[1], column) + number(&rows[2], column) - all).abs() < 0.01, "{column}: {rows:?}");
    }
}

/// Returns six hours of an even sky of 100 W/m2 at 10 degrees Celsius and 2 m/s.
fn cold() -> String {
    let rows = EVEN.lines().skip(1).map(|row| format!("{row},10,2\n")).collect::<String>();
    format!("time,ghi,dni,dhi,temp_air,wind_speed\n{rows}")
}

/// A level point under an even sky of 100 W/m2 has by hand, with PVWatts and King's coefficients, a
/// DC power of 2 kW x 0.1 x 0.9 x (1 - 0.004 (T - 25)) in each of 6 hours, within 0.1 %. An hour is
/// worth its price, a load takes what it needs, and a small inverter clips: all by hand.
#[test]
fn six_hours_of_an_even_sky_are_those_of_a_hand() {
    let folder = plain();
    folder.write("cold.csv", &cold());
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\nq,5,0,1,0,0\n");
    let values: String = (0..6).map(|hour| format!("2019-06-21T{:02}:00,{},0.05\n", hour + 9, hour / 3)).collect();
    folder.write("values.csv", &format!("time,eur_per_kwh,load_kw\n{values}"));
    let pv = format!(
        "pv far.obj -m far.toml {PLACE} -w cold.csv --points points.csv --sky uniform --kwp 2 --replace -o out"
    );
    let options = "--losses 10% --temperature-coefficient=-0.4 --value values.csv --price 0.3";
    good(&folder, &format!("{pv} {options}"));
    let year = &table(&folder, "out/energy.csv")[0];
    let cell_c = 10.0 + 100.0 * (-3.56_f64 - 0.075 * 2.0).exp() + 0.3;
    let dc_kw = 2.0 * 0.1 * 0.9 * (1.0 - 0.004 * (cell_c - 25.0));
    let load = dc_kw * 1.1 * 0.96 / 2.0;
    let ac_kw = 2.0 / 1.1 * ((0.9858 - 0.0162 * load) * load - 0.0059) / 0.9637;
    near(number(year, "dc_kwh"), 6.0 * dc_kw, 0.1);
    near(number(year, "ac_kwh"), 6.0 * ac_kw, 0.1);
    near(number(year, "value"), 6.0 * 0.3 * ac_kw, 0.1);
    near(number(year, "value_eur"), 3.0 * ac_kw, 0.1);
    near(number(year, "used_kwh"), 6.0 * 0.05, 0.1);
    assert_eq!(number(year, "clipped_kwh"), 0.0);
    folder.write("cold.csv", &cold().replace(",100,0,100,", ",500,0,500,"));
    good(&folder, &format!("{pv} {options} --dc-ac-ratio 10 --mounting roof"));
    let year = &table(&folder, "out/energy.csv")[0];
    near(number(year, "ac_kwh"), 6.0 * 2.0 / 10.0, 0.1);
    let cell_c = 10.0 + 500.0 * (-2.98_f64 - 0.0471 * 2.0).exp() + 0.5;
    let dc_kw = 2.0 * 0.5 * 0.9 * (1.0 - 0.004 * (cell_c - 25.0));
    near(number(year, "dc_kwh"), 6.0 * dc_kw, 0.1);
    near(number(year, "clipped_kwh"), 6.0 * (0.96 * dc_kw - 0.2), 0.2);
}

/// A module of a row adds the light on its rear times the bifaciality, and a rated power in the
/// file of rows counts once a module: 2 modules of 0.4 kW under an even sky.
#[test]
fn rows_have_power_on_both_sides() {
    let folder = plain();
    folder.write("cold.csv", &cold());
    let rows = "[[rows]]\nname = \"r\"\narea = [[0, 0], [4.2, 0], [4.2, 2], [0, 2]]\ntilt = 0\nazimuth = 180\npitch = 3\nwidth = 2\n\
                height = 1\nclearance = 1.5\nthickness = 0.001\nkwp = 0.4\nstring = \"s\"\n";
    folder.write("rows.toml", rows);
    folder.write("field.obj", "v -100 -100 0\nv 100 -100 0\nv 100 100 0\nv -100 100 0\nusemtl grass\nf 1 2 3 4\n");
    folder.write("field.toml", "[grass]\ndiffuse = 0.5\nclass = \"ground\"\n");
    let pv = format!("pv field.obj -m field.toml {PLACE} -w cold.csv --rows rows.toml --sky uniform --replace -o out");
    let energy = |rest: &str| {
        good(&folder, &format!("{pv} {rest}"));
        table(&folder, "out/energy.csv")
    };
    let (both, front) = (energy(""), energy("--bifaciality 0"));
    assert_eq!((both.len(), both[1]["string"].as_str()), (2, "s"));
    assert!((number(&both[0], "kwp") - 0.8).abs() < 1e-9);
    let hours = table(&folder, "out/hourly.csv");
    let sum = |column: &str| hours.iter().map(|hour| number(hour, column)).sum::<f64>();
    let gain = number(&both[0], "dc_kwh") / number(&front[0], "dc_kwh") - 1.0;
    // The rear warms the module, too.
    assert!((gain / (0.8 * sum("poa_back") / sum("poa_front")) - 1.0).abs() < 0.02, "{gain}");
    // The loss of the array is that of its modules, which have equal ratings.
    let points = table(&folder, "out/points.csv");
    let losses: Vec<f64> =
        points.iter().filter(|row| row["side"] == "front").map(|row| number(row, "shading_loss_percent")).collect();
    let mean = losses.iter().sum::<f64>() / losses.len() as f64;
    assert!((number(&front[0], "shading_loss_percent") - mean).abs() < 0.01, "{losses:?}");
    assert_eq!(front[0]["shading_loss_percent"], front[1]["shading_loss_percent"]);
    // Hours of another bifaciality do not stay beside sums of this one.
    let said = stderr(&folder.run(&format!("{pv} --no-hourly --bifaciality 0.5").replace(" --replace", "")));
    assert!(said.contains("hourly.csv") && said.contains("are removed"), "{said}");
    assert!(!folder.path("out/hourly.csv").exists() && folder.path("out/energy.csv").exists());
    folder.write("rows.toml", &rows.replace("kwp = 0.4", "kwp = 400"));
    let said = stderr(&folder.run(&format!("{pv} --no-hourly").replace("-o out", "-o watts")));
    assert!(said.contains("a module has 200.0 kW a square metre"), "{said}");
}

/// Two runs with their archives before and after a wall are compared by kind and by string: the
/// point loses half of an even sky, within 0.5 %.
#[test]
fn two_runs_are_compared_by_kind() {
    let folder = plain();
    folder.write("cold.csv", &cold());
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\n");
    folder.write("wall.obj", "v -4000 0.5 0\nv 4000 0.5 0\nv 4000 0.5 4000\nv -4000 0.5 4000\nusemtl far\nf 1 2 3 4\n");
    for (scene, name) in [("far.obj", "before"), ("wall.obj", "after")] {
        good(
            &folder,
            &format!("pv {scene} -m far.toml {PLACE} -w cold.csv --points points.csv --sky uniform --kwp 2 -o {name}"),
        );
    }
    for (by, name) in [("kind", "module"), ("object", "array"), ("surface", "p")] {
        let options = format!("{PLACE} --weather cold.csv --sky uniform --every total --by {by} -o change.csv");
        good(&folder, &format!("compare before/site.helio after/site.helio {options}"));
        let row = &table(&folder, "change.csv")[0];
        assert_eq!(row[by], name);
        assert!((number(row, "change_total_percent") + 50.0).abs() < 0.5, "{row:?}");
    }
    let [before, after] = ["before", "after"].map(|run| table(&folder, &format!("{run}/energy.csv")));
    let share = number(&after[0], "dc_kwh") / number(&before[0], "dc_kwh");
    assert!(share > 0.49 && share < 0.52, "{share}");
}

/// Wrong requests are refused by kind, 12 of 12: a power twice, missing or zero, worth without
/// power, weather without temperature, tables that do not fit.
#[test]
fn wrong_powers_and_values_are_refused() {
    let folder = plain();
    folder.write("cold.csv", &cold());
    folder.write("even.csv", EVEN);
    let head = "point,x,y,z,tilt,azimuth";
    let pv = |rest: &str| {
        format!("pv far.obj -m far.toml {PLACE} -w cold.csv --points points.csv --no-hourly -o out {rest}")
    };
    for (rows, rest, expected) in [
        (",kwp\np,0,0,1,0,0,4\n", "--kwp 4", "argument excludes --kwp points, rows"),
        (",kwp\np,0,0,1,0,0,4\nq,9,0,1,0,0,\n", "", "input lacks points.csv kwp"),
        (",kwp\np,0,0,1,0,0,-4\n", "", "input value points.csv:2 kwp -4"),
        (",kwp\np,0,0,1,0,0,0\n", "", "input value points.csv kwp 0"),
        (",kwp,string\np,0,0,1,0,0,4,array\n", "", "input duplicate points.csv array"),
        ("\np,0,0,1,0,0\n", "--price 0.3", "argument needs --price,--value --kwp"),
        ("\np,0,0,1,0,0\n", "--kwp 4 --price EUR", "argument unreadable --price EUR"),
        ("\np,0,0,1,0,0\n", "--kwp 4 --losses 120%", "argument unreadable --losses 120%"),
    ] {
        folder.write("points.csv", &format!("{head}{rows}"));
        folder.fails(&pv(rest), expected);
    }
    folder.fails(&pv("--kwp 4").replace("cold.csv", "even.csv"), "input lacks even.csv:2 temperature");
    let values = |time: &str| (9..15).map(|hour| format!("2019-06-21T{:02}{time},1\n", hour)).collect::<String>();
    for (text, expected) in [
        (format!("time,price\n{}", values(":00")), "input no-column values.csv:1 _per_kwh"),
        ("time,eur_per_kwh\n2019-06-21T09:00,1\n".to_owned(), "input out-of-range values.csv 1.0"),
        (
            format!("time,eur_per_kwh\n{}", values(":00").replace("T09", "T08")),
            "input value values.csv:2 time 2019-06-21T08:00",
        ),
    ] {
        folder.write("values.csv", &text);
        folder.fails(&pv("--kwp 4 --value values.csv"), expected);
    }
    assert!(!folder.path("out/energy.csv").exists());
}

/// South of an endless wall 10 m high and 10 m away, the beam at a level point arrives above the
/// wall's edge in every direction and not below, a uniform sky loses (1 - cos 45) / 2 within 0.5 %,
/// and the horizons of all layouts are 45 degrees in the north, within 1.
#[test]
fn the_shade_of_a_wall_is_in_all_layouts() {
    let folder = plain();
    folder.write("cold.csv", &cold());
    folder.write("wall.obj", "v -9000 10 0\nv 9000 10 0\nv 9000 10 10\nv -9000 10 10\nusemtl far\nf 1 2 3 4\n");
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,0.001,0,0\n");
    let pv = format!("pv wall.obj -m far.toml {PLACE} -w cold.csv --points points.csv --no-hourly --shade -o out");
    good(&folder, &pv);
    let beam = table(&folder, "out/shade/beam.csv");
    assert_eq!(beam.len(), 180 * 45);
    for row in &beam {
        let (azimuth, altitude) = (number(row, "azimuth_deg").to_radians(), number(row, "altitude_deg").to_radians());
        // The wall's edge in the profile of a direction.
        let edge = azimuth.cos().max(0.0).atan();
        let share = number(row, "beam");
        let off_deg = (altitude - edge).to_degrees();
        assert!(off_deg.abs() < 0.5 || (share - f64::from(off_deg > 0.0)).abs() < 0.01, "{row:?}");
    }
    let text = |name: &str| std::fs::read_to_string(folder.path(&format!("out/shade/{name}"))).expect("a file");
    let sam: serde_json::Value = serde_json::from_str(&text("sam.json")).expect("JSON");
    let loss = sam["shading_diff"].as_f64().expect("a loss");
    assert!((loss - 50.0 * (1.0 - 45.0_f64.to_radians().cos())).abs() < 0.5, "{loss}");
    let list: Vec<f64> = text("userhorizon.txt").trim().split(',').map(|h| h.parse().expect("a height")).collect();
    let pairs = text("horizon.txt");
    let first: f64 = pairs.lines().next().and_then(|line| line.split_once('\t')?.1.parse().ok()).expect("a height");
    assert!((list[0] - 45.0).abs() < 1.0 && (first - 45.0).abs() < 1.0 && list[24] == 0.0, "{list:?}");
}

/// Three years of which each has six hours of an even sky, 100, 300 and 200 W/m2, give a level kW
/// without losses 0.6, 1.8 and 1.2 kWh of DC; P90, P50 and P10 are 0.72, 1.2 and 1.68, linear
/// between years. One year has no such table.
#[test]
fn years_have_their_percentiles() {
    let folder = plain();
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\n");
    let year = |(year, light): (i32, i32)| {
        cold().replace("2019", &year.to_string()).replace(",100,0,100,", &format!(",{light},0,{light},"))
    };
    let years = [(2017, 100), (2018, 300), (2019, 200)].map(year);
    let rows = |years: &[String]| {
        let lines = years.iter().flat_map(|year| year.lines().skip(1));
        format!("time,ghi,dni,dhi,temp_air,wind_speed\n{}\n", lines.collect::<Vec<_>>().join("\n"))
    };
    folder.write("years.csv", &rows(&years));
    let pv = |weather: &str| {
        good(
            &folder,
            &format!(
                "pv far.obj -m far.toml {PLACE} -w {weather} --points points.csv --sky uniform --kwp 1 --losses 0% \
             --temperature-coefficient=0 --no-hourly --replace -o out"
            ),
        )
    };
    let text = pv("years.csv");
    let rows_of = table(&folder, "out/energy_years.csv");
    let labels: Vec<&str> = rows_of.iter().map(|row| row["year"].as_str()).collect();
    assert_eq!(labels, ["2017", "2018", "2019", "P90", "P50", "P10"]);
    let right = [0.6, 1.8, 1.2, 0.72, 1.2, 1.68];
    rows_of.iter().zip(right).for_each(|(row, right)| near(number(row, "dc_kwh"), right, 0.5));
    assert!(text.contains("in 9 of 10 years at least") && text.contains("(P90 of 3 years)"), "{text}");
    folder.write("one.csv", &rows(&years[..1]));
    assert!(!pv("one.csv").contains("P90") && !folder.path("out/energy_years.csv").exists());
}
