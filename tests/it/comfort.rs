//! Thermal comfort through the program: closed forms on a plain and below a roof, periods, archives
//! without people, wrong input.

use std::fs;

use crate::cli::{Folder, golden, stderr, stdout};

/// Stefan-Boltzmann constant, W/m2 K4.
const SIGMA: f64 = 5.670_374_419e-8;

/// Angular factor of a side of a standing person; below, of the planes up and down.
const SIDE: f64 = 0.22;
const UP: f64 = 0.06;

fn black(celsius: f64) -> f64 {
    SIGMA * (celsius + 273.15).powi(4)
}

/// Returns the mean radiant temperature of a standing box from planes up, down, north, east, south,
/// west.
fn box_c(shortwave: [f64; 6], longwave: [f64; 6]) -> f64 {
    let on = |planes: [f64; 6]| UP * (planes[0] + planes[1]) + SIDE * planes[2..].iter().sum::<f64>();
    ((0.7 / 0.97 * on(shortwave) + on(longwave)) / SIGMA).powf(0.25) - 273.15
}

fn slab(name: &str, half: f64, z: f64, first: usize, is_down: bool) -> String {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let vertices: String = corners.iter().map(|(x, y)| format!("v {x} {y} {z}\n")).collect();
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
    let face = if is_down { format!("f {d} {c} {b} {a}\n") } else { format!("f {a} {b} {c} {d}\n") };
    format!("o {name}\nusemtl {name}\n{vertices}{face}")
}

/// Writes a plain of 2 km with a point in its middle, and above it a roof at 3 m if asked for.
fn plain(folder: &Folder, with_roof: bool) {
    let roof = if with_roof { slab("roof", 500.0, 3.0, 5, true) } else { String::new() };
    folder.write("plain.obj", &(slab("ground", 1000.0, 0.0, 1, false) + &roof));
    folder.write("m.toml", "[ground]\ndiffuse = 0.2\n[roof]\ndiffuse = 0.3\n");
    folder.write("p.csv", "point,x,y\nhere,0.3,0.2\n");
    let planes = [
        ("", "0,0,1"),
        ("/down", "0,0,-1"),
        ("/north", "0,1,0"),
        ("/east", "1,0,0"),
        ("/south", "0,-1,0"),
        ("/west", "-1,0,0"),
    ];
    let receivers: String =
        planes.iter().map(|(plane, normal)| format!("here{plane},0.3,0.2,1.1,{normal}\n")).collect();
    folder.write("r.csv", &format!("receiver,x,y,z,nx,ny,nz\n{receivers}"));
}

/// Returns rows of hours: `[hour]`, the numbers behind time and point.
fn hours(folder: &Folder, arguments: &str) -> Vec<Vec<f64>> {
    let place = "--latitude 39.7 --longitude -105.2 -m m.toml";
    let scene = if arguments.contains(".helio") { String::new() } else { format!("plain.obj {place} ") };
    let command = format!("comfort {scene}{arguments} --weather {} --quality draft", golden().display());
    let command = if scene.is_empty() { command.replace(" --quality draft", "") } else { command };
    let output = folder.run(&command);
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    let text = stdout(&output);
    let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
    text.lines().skip(1).map(|row| row.split(',').skip(2).map(number).collect()).collect()
}

/// Returns six numbers of a row from a place on.
fn six(row: &[f64], first: usize) -> [f64; 6] {
    std::array::from_fn(|i| row[first + i])
}

/// On an open plain whose ground is as warm as the air, in all 72 hours of Golden, longwave from
/// above is the sky of the weather file, and from below 0.95 sigma T^4 + 0.05 of the sky. Shortwave
/// from below is 0.2 of that from above. The mean radiant temperature follows from the twelve
/// columns within 0.02 K. By night it is that of the sky and the air alone within 0.2 K.
#[test]
fn an_open_plain_has_the_longwave_of_sky_and_ground() {
    let folder = Folder::new();
    plain(&folder, false);
    let options = "--points p.csv --surfaces air --sun-on box --columns air,mrt,shortwave,longwave";
    let rows = hours(&folder, options);
    assert_eq!(rows.len(), 72);
    let epw = fs::read_to_string(golden()).expect("weather");
    let weather: Vec<Vec<f64>> = epw
        .lines()
        .filter(|line| line.starts_with(|first: char| first.is_ascii_digit()))
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    let mut nights = 0;
    for (row, weather) in rows.iter().zip(&weather) {
        let (air, mrt, shortwave, longwave) = (row[0], row[1], six(row, 2), six(row, 8));
        assert!((air - weather[6]).abs() < 0.01, "{air} {}", weather[6]);
        let sky = longwave[0];
        assert!(
            weather[12] >= 9999.0 || weather[12] == 0.0 || (sky - weather[12]).abs() < 0.01,
            "{sky} {}",
            weather[12]
        );
        let below = 0.95 * black(air) + 0.05 * sky;
        assert!((longwave[1] - below).abs() < 0.02, "{} {below}", longwave[1]);
        assert!((shortwave[1] - 0.2 * shortwave[0]).abs() < 0.004 * shortwave[0] + 0.01, "{shortwave:?}");
        let expected = box_c(shortwave, longwave);
        assert!((mrt - expected).abs() < 0.02, "{mrt} {expected}");
        if shortwave[0] == 0.0 {
            // Sides see ground in half of their view. A wall misses 0.345 of what the sky lacks
            // beside a black body at air temperature.
            let side = 0.5 * below + 0.5 * black(air) - 0.345 * (black(air) - sky);
            let expected = box_c([0.0; 6], [sky, below, side, side, side, side]);
            assert!((mrt - expected).abs() < 0.2, "{mrt} {expected}");
            nights += 1;
        }
    }
    assert!(nights > 24, "{nights}");
}

/// The southern half of a plain is metal of emissivity 0.2 and as warm as the air. Longwave from
/// below is e sigma T^4 + (1 - e) of the sky, where e is the mean over the ground that a person
/// sees: 0.95 far in the north, 0.2 far in the south, 0.575 on the seam, within 0.5 W/m2 in 72
/// hours. With `--emissivity ground=0.95` all three are alike. The metadata of the table state the
/// range.
#[test]
fn emissivity_is_the_mean_over_the_seen_ground() {
    let folder = Folder::new();
    let half = |name: &str, low: f64, high: f64, first: usize| {
        let corners = [(-2000.0, low), (2000.0, low), (2000.0, high), (-2000.0, high)];
        let vertices: String = corners.iter().map(|(x, y)| format!("v {x} {y} 0\n")).collect();
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
        format!("o {name}\nusemtl {name}\n{vertices}f {a} {b} {c} {d}\n")
    };
    folder.write("plain.obj", &(half("ground", 0.0, 2000.0, 1) + &half("metal", -2000.0, 0.0, 5)));
    folder.write("m.toml", "[ground]\ndiffuse = 0.2\n[metal]\ndiffuse = 0.2\nemissivity = 0.2\nclass = \"ground\"\n");
    folder.write("p.csv", "point,x,y\nnorth,0.3,900\nseam,0.3,0\nsouth,0.3,-900\n");
    let options = "--points p.csv --surfaces air --columns air,longwave";
    let check = |rows: &[Vec<f64>], emissivities: [f64; 3]| {
        assert_eq!(rows.len(), 3 * 72);
        for (hours, emissivity) in rows.chunks(72).zip(emissivities) {
            for row in hours {
                let (sky, below) = (row[1], row[2]);
                let expected = emissivity * black(row[0]) + (1.0 - emissivity) * sky;
                assert!((below - expected).abs() < 0.5, "{emissivity}: {below} {expected}");
            }
        }
    };
    // Rows of a table stand point by point, in the order of the archive: along y here.
    let points = |rows: Vec<Vec<f64>>| {
        let mut points: Vec<Vec<Vec<f64>>> = rows.chunks(72).map(<[Vec<f64>]>::to_vec).collect();
        let below = |point: &Vec<Vec<f64>>| point[0][2];
        points.sort_by(|a, b| below(b).total_cmp(&below(a)));
        points.concat()
    };
    check(&points(hours(&folder, options)), [0.95, 0.575, 0.2]);
    check(&hours(&folder, &format!("{options} --emissivity ground=0.95")), [0.95; 3]);
    let output = folder
        .run(&format!("comfort plain.people/site.helio --weather {} --every total -o people.csv", golden().display()));
    assert!(output.status.success(), "{}", stderr(&output));
    let about = fs::read_to_string(folder.path("people.csv-metadata.json")).expect("metadata");
    assert!(about.contains("0.2 to 0.95 by material"), "{about}");
    let told = stdout(&folder.run("info plain.people/site.helio"));
    assert!(told.contains("bands       1 values of metal"), "{told}");
}

/// Below an endless roof of 25 degrees over ground of 30, both gray, planes get the exchange of two
/// endless plates, and the mean radiant temperature follows from it within 0.2 K. Where ground and
/// roof have 20 degrees it is 20 degrees within 0.02 K.
#[test]
fn below_a_roof_longwave_is_that_of_two_plates() {
    let folder = Folder::new();
    plain(&folder, true);
    // `comfort` puts no people where there is no light, but receivers may stand there.
    let built = folder
        .run("build plain.obj --latitude 39.7 --longitude -105.2 -m m.toml -r r.csv --quality draft -o people.helio");
    assert!(built.status.success(), "{}", stderr(&built));
    let options = "people.helio --columns mrt,shortwave";
    for (ground, roof) in [(30.0, 25.0), (20.0, 20.0)] {
        let rows = hours(&folder, &format!("{options} --temperature ground={ground} --temperature obstruction={roof}"));
        let of_roof = (0.9 * black(roof) + 0.1 * 0.95 * black(ground)) / (1.0 - 0.1 * 0.05);
        let of_ground = 0.95 * black(ground) + 0.05 * of_roof;
        let side = 0.5 * (of_roof + of_ground);
        let expected = box_c([0.0; 6], [of_roof, of_ground, side, side, side, side]);
        let nights: Vec<f64> = rows.iter().filter(|row| row[1] == 0.0).map(|row| row[0]).collect();
        assert!(nights.len() > 24);
        let tolerance = if ground == roof { 0.02 } else { 0.2 };
        for mrt in nights {
            assert!((mrt - expected).abs() < tolerance, "{ground} {roof}: {mrt} {expected}");
        }
    }
}

/// Days of an archive count the hours above a threshold and have the means of its hours. A cylinder
/// and a box differ by day alone. People on a grid of the ground are 1.1 m above it.
#[test]
fn days_have_the_means_of_their_hours() {
    let folder = Folder::new();
    plain(&folder, false);
    let by_hour = hours(&folder, "--points p.csv --columns utci");
    let by_day = hours(&folder, "plain.people/site.helio --columns utci --every day --above 0,10");
    assert_eq!(by_day.len(), 3);
    for (day, hours) in by_day.iter().zip(by_hour.chunks(24)) {
        let hours: Vec<f64> = hours.iter().map(|row| row[0]).collect();
        let mean = hours.iter().sum::<f64>() / 24.0;
        let most = hours.iter().copied().fold(f64::MIN, f64::max);
        let above = |limit: f64| hours.iter().filter(|value| **value > limit).count() as f64;
        let expected = [mean, most, above(0.0), above(10.0)];
        assert!(
            day.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.011),
            "{day:?} {expected:?}"
        );
    }
    let cylinder = hours(&folder, "plain.people/site.helio --columns mrt,shortwave");
    let boxed = hours(&folder, "plain.people/site.helio --columns mrt --sun-on box");
    let off = |day: bool| {
        let pairs = cylinder.iter().zip(&boxed).filter(|(row, _)| (row[1] > 100.0) == day && (day || row[1] == 0.0));
        pairs.map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max)
    };
    assert!(off(true) > 0.3 && off(true) < 5.0 && off(false) < 0.011, "{} {}", off(true), off(false));
    folder.write("small.obj", &slab("ground", 10.0, 5.0, 1, false));
    let output = folder.run(&format!(
        "comfort small.obj --latitude 39.7 --longitude -105.2 --spacing 5m --quality draft --every total -o map.csv --weather {}",
        golden().display()
    ));
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(fs::read_to_string(folder.path("map.csv")).expect("a table").lines().count(), 1 + 16);
    let receivers = fs::read_to_string(folder.path("small.people/receivers.csv")).expect("receivers");
    assert_eq!(receivers.lines().count(), 1 + 6 * 16);
    assert!(receivers.lines().skip(1).all(|row| row.contains(",6.1000,")), "{receivers}");
}

/// Below leaves that let a tenth of the light through, longwave from above is that of a black body
/// at air temperature less 0.1 of what the sky lacks on the open plain, within 2 %.
#[test]
fn leaves_radiate_like_a_black_body() {
    let folder = Folder::new();
    plain(&folder, false);
    let leaves = slab("leaves", 400.0, 4.0, 5, false);
    folder.write("trees.obj", &(slab("ground", 1000.0, 0.0, 1, false) + &leaves));
    folder.write("m.toml", "[ground]\ndiffuse = 0.2\n[leaves]\ntransmittance = 0.1\n");
    let place = "--latitude 39.7 --longitude -105.2 -m m.toml -r r.csv --quality draft";
    for (scene, site) in [("plain.obj", "open.helio"), ("trees.obj", "trees.helio")] {
        let scene = if scene == "plain.obj" { "plain.obj --no-ground" } else { scene };
        let materials = if site == "open.helio" {
            "[ground]\ndiffuse = 0.2\n"
        } else {
            "[ground]\ndiffuse = 0.2\n[leaves]\ntransmittance = 0.1\n"
        };
        folder.write("m.toml", materials);
        let built = folder.run(&format!("build {scene} {place} -o {site}"));
        assert!(built.status.success(), "{}", stderr(&built));
    }
    let asked = "--surfaces air --columns air,longwave,shortwave";
    let (open, below) =
        (hours(&folder, &format!("open.helio {asked}")), hours(&folder, &format!("trees.helio {asked}")));
    for (open, below) in open.iter().zip(&below) {
        let lacks = black(open[0]) - open[1];
        assert!((black(open[0]) - below[1] - 0.1 * lacks).abs() < 0.02 * lacks.abs() + 0.05, "{open:?} {below:?}");
    }
}

/// A missing weather file, one without humidity, a file that is no weather and one without the
/// requested hours are refused before the scene is traced: neither a folder nor a table is left, 8
/// of 8. Without humidity the mean radiant temperature is still computed.
#[test]
fn wrong_weather_is_refused_before_the_trace() {
    let folder = Folder::new();
    plain(&folder, false);
    let hour = |hour: usize| format!("2019-07-01T{hour:02}:00,800,700,100,25,2,350\n");
    let dry = format!("time,ghi,dni,dhi,temp_air,wind_speed,longwave_down\n{}{}", hour(12), hour(13));
    folder.write("dry.csv", &dry);
    let place = "--latitude 39.7 --longitude -105.2 -m m.toml --quality draft --time-zone -7 -o table.csv";
    let golden = golden().display().to_string();
    for people in ["--points p.csv", "--spacing 500m"] {
        for (weather, expected) in [
            ("none.epw".to_owned(), "missing-file none.epw"),
            ("dry.csv".to_owned(), "input lacks dry.csv humidity"),
            ("plain.obj".to_owned(), "input other-kind plain.obj a scene (OBJ)"),
            (format!("{golden} --from 07-01 --to 07-02"), "input lacks golden_3_days.epw hours"),
        ] {
            folder.fails(&format!("comfort plain.obj {place} {people} -w {weather}"), expected);
            for left in ["plain.people", "table.csv"] {
                assert!(!folder.path(left).exists(), "{left} after {weather}");
            }
        }
    }
    let output = folder.run(&format!("comfort plain.obj {place} --points p.csv -w dry.csv --columns mrt"));
    assert!(output.status.success() && folder.path("plain.people/site.helio").exists(), "{}", stderr(&output));
}

/// Ten wrong requests are refused: no humidity, no wind, an archive without people,
/// points inside of things, numbers out of range.
#[test]
fn wrong_questions_are_refused() {
    let folder = Folder::new();
    plain(&folder, false);
    let weather = golden().display().to_string();
    let place = "--latitude 39.7 --longitude -105.2 -m m.toml --quality draft";
    let light = "time,ghi,dni,dhi,temp_air,opaque_sky_cover";
    let hour = "2019-07-01T12:00,800,700,100,25,0";
    folder.write("dry.csv", &format!("{light},wind_speed\n{hour},2\n2019-07-01T13:00,800,700,100,25,0,2\n"));
    folder.write("still.csv", &format!("{light},relative_humidity\n{hour},40\n2019-07-01T13:00,800,700,100,25,0,40\n"));
    folder.write("r.csv", "receiver,x,y,z,nx,ny,nz\nroof,0,0,1,0,0,1\n");
    folder.run(&format!("build plain.obj {place} -r r.csv -o roof.helio"));
    folder.write("low.csv", "point,x,y,z\nhere,0,0,-1\n");
    for (arguments, expected) in [
        (
            format!("comfort plain.obj {place} --points p.csv -w dry.csv --time-zone -7"),
            "input lacks dry.csv:2 infrared",
        ),
        (
            format!("comfort plain.obj {place} --points p.csv -w still.csv --time-zone -7"),
            "input lacks still.csv wind speed",
        ),
        (format!("comfort roof.helio -w {weather}"), "input lacks roof.helio receivers"),
        (
            format!("comfort roof.helio -w {weather} --points p.csv"),
            "argument other-kind --points,--folder,--replace archive",
        ),
        (format!("comfort plain.obj {place} --points low.csv -w {weather}"), "input misplaced low.csv:2"),
        (format!("comfort plain.obj {place} --points p.csv -w {weather} --film 0"), "argument out-of-range --film 0.0"),
        (format!("comfort plain.obj {place} --on roof -w {weather}"), "argument empty --on"),
        (
            format!("comfort plain.obj {place} --points p.csv -w {weather} --emissivity wall=0.9"),
            "argument unreadable --emissivity wall=0.9",
        ),
        (format!("comfort plain.obj {place} --points p.csv -w {weather} --wind 9"), "argument unreadable --wind 9"),
        (format!("comfort plain.obj {place} --points p.csv -w {weather} --plot year.svg"), "argument ending --plot"),
    ] {
        folder.fails(&arguments, expected);
    }
    // The mean radiant temperature needs neither wind nor humidity, only the air's temperature and
    // the sky's radiation.
    let output =
        folder.run(&format!("comfort plain.obj {place} --points p.csv -w still.csv --time-zone -7 --columns mrt"));
    assert!(output.status.success(), "{}", stderr(&output));
}
