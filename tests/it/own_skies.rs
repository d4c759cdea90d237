//! Skies and clouds from files, through the program: matrices of Radiance, tables, photographs and
//! masks beside sums of other programs and closed forms, and refusals.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;

use glam::DVec3;

use crate::cli::{Folder, stderr, stdout};
use crate::scenes::{data, tilted};

/// Tilts and azimuths, degrees: flat and four tilts.
const SURFACES: [(u32, u32); 5] = [(0, 0), (30, 180), (60, 90), (90, 270), (90, 0)];

const CONDITIONS: &str = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,45,800,100\n";

/// Builds an archive of the surfaces over one black triangle of 1 cm, `open.helio`, and conditions.
fn open_surfaces() -> Folder {
    let folder = Folder::new();
    folder.write("far.obj", "v 0 0 -9\nv 0.01 0 -9\nv 0 0.01 -9\nusemtl far\nf 1 2 3\n");
    folder.write("far.toml", "[far]\ndiffuse = 0\n");
    let row = |(i, &(tilt, azimuth)): (usize, &(u32, u32))| {
        let n = tilted(f64::from(tilt), f64::from(azimuth));
        format!("sky_{tilt}_{azimuth},{},0,0,{},{},{}\n", 3 * i, n.x, n.y, n.z)
    };
    let rows: String = SURFACES.iter().enumerate().map(row).collect();
    folder.write("tilts.csv", &format!("receiver,x,y,z,nx,ny,nz\n{rows}"));
    folder.write("one.csv", CONDITIONS);
    let built = folder.run("build far.obj --materials far.toml --receivers tilts.csv -o open.helio --no-ground");
    assert!(built.status.success(), "{}", stderr(&built));
    folder
}

/// Values of a table by column name, for each `(condition or time, receiver)`.
type Rows = BTreeMap<(String, String), BTreeMap<String, f64>>;

fn rows(folder: &Folder, arguments: &str) -> Rows {
    let output = folder.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", stderr(&output));
    let text = stdout(&output);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().expect("a header").clone();
    let row = |record: csv::StringRecord| {
        let cells = header.iter().zip(&record).skip(2);
        let cells = cells.filter_map(|(name, cell)| Some((name.replace("_kwh_m2", ""), cell.parse().ok()?)));
        ((record[0].to_owned(), record[1].to_owned()), cells.collect())
    };
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

fn value(rows: &Rows, condition: &str, receiver: &str, column: &str) -> f64 {
    rows[&(condition.to_owned(), receiver.to_owned())][column]
}

/// For eight hours of gendaymtx, 145 patches as text and 577 as floats, flat ground and four tilts
/// get the sums that NumPy computes from the same files (`tools/peers/skies --cut`) within 0.5 % of
/// the hour's diffuse light, 0.05 % on flat ground. Scaled to DHI, flat ground gets the weather's
/// DHI, within 1e-5.
#[test]
fn gendaymtx_skies_give_the_sums_of_numpy() {
    let folder = open_surfaces();
    let skies = data("../skies");
    let expected = fs::read_to_string(skies.join("sums.csv")).expect("sums");
    let dhi = [110.0, 90.0, 120.0, 160.0, 180.0, 140.0, 100.0, 70.0];
    let mut compared = 0;
    for (matrix, patches) in [("m1.mtx", 145), ("m2_float.mtx", 577)] {
        let (weather, sky) = (skies.join("hours.wea"), skies.join(matrix));
        let command = |more: &str| {
            let (weather, sky) = (weather.display(), sky.display());
            format!(
                "replay open.helio --weather {weather} --sky {sky} --patches {patches} --columns sky_direct,sun_direct {more}"
            )
        };
        let (found, scaled) = (rows(&folder, &command("")), rows(&folder, &command("--sky-scale dhi")));
        let times: Vec<String> = found.keys().map(|(time, _)| time.clone()).collect();
        let mut times = times.chunk_by(|a, b| a == b).map(|all| all[0].clone()).collect::<Vec<_>>();
        times.sort();
        assert_eq!(times.len(), 8);
        for line in expected.lines().filter(|line| line.starts_with(matrix)) {
            let cells: Vec<&str> = line.split(',').collect();
            let hour: usize = cells[1].parse().expect("an hour");
            for (cell, (tilt, azimuth)) in cells[2..].iter().zip(SURFACES) {
                let sum: f64 = cell.parse().expect("a sum");
                let value = value(&found, &times[hour], &format!("sky_{tilt}_{azimuth}"), "sky_direct");
                let off = (value - sum).abs() / dhi[hour];
                assert!(off < if tilt == 0 { 5e-4 } else { 5e-3 }, "{matrix} {hour} {tilt}: {value} {sum}");
                compared += 1;
            }
            let flat = value(&scaled, &times[hour], "sky_0_0", "sky_direct");
            assert!((flat / dhi[hour] - 1.0).abs() < 1e-5, "{hour}: {flat}");
        }
    }
    assert_eq!(compared, 80);
}

/// A matrix is replayed on other patches, for sums of all hours, and with the sun in it: flat
/// ground gets the same light on 145, 577 and 2305 patches (1e-5), and the total is the sum of the
/// hours (1e-5). A sky three times as bright as DHI gives a warning that it seems to hold the sun.
#[test]
fn a_matrix_gives_the_same_light_on_other_patches() {
    let folder = open_surfaces();
    let (weather, sky) = (data("../skies/hours.wea"), data("../skies/m1.mtx"));
    let command = |more: &str| format!("replay open.helio --weather {} --columns sky_direct {more}", weather.display());
    let mine = |more: &str| rows(&folder, &command(&format!("--sky {} {more}", sky.display())));
    let flat = |rows: &Rows| -> f64 {
        rows.iter().filter(|((_, receiver), _)| receiver == "sky_0_0").map(|(_, row)| row["sky_direct"]).sum()
    };
    let own = flat(&mine("--patches 145"));
    for patches in [577, 2305] {
        let found = flat(&mine(&format!("--patches {patches}")));
        assert!((found / own - 1.0).abs() < 1e-5, "{patches}: {found} {own}");
    }
    let total = flat(&mine("--patches 145 --every total"));
    assert!((1000.0 * total / own - 1.0).abs() < 1e-5, "{total} {own}");
    let text = fs::read_to_string(&sky).expect("a matrix");
    let (head, body) = text.split_once("\n\n").expect("a header");
    let brighter = |line: &str| {
        let triple = |word: &str| format!("{} ", 5.0 * word.parse::<f64>().expect("a number"));
        line.split_whitespace().map(triple).collect::<String>() + "\n"
    };
    folder.write("sun.mtx", &format!("{head}\n\n{}", body.lines().map(brighter).collect::<String>()));
    let output = folder.run(&command("--sky sun.mtx"));
    assert!(output.status.success() && stderr(&output).contains("they seem to contain the sun"), "{}", stderr(&output));
    assert!(stderr(&output).contains("gendaymtx -s"), "{}", stderr(&output));
}

/// Returns true for the bright pixels of a square of 512: columns 150 to 189, rows 200 to 239,
/// about 14 degrees wide, in the north-east.
fn is_bright(column: usize, row: usize) -> bool {
    (150..190).contains(&column) && (200..240).contains(&row)
}

/// The only light of a Radiance picture is a square of 255 W/m2/sr: flat ground and four tilts get
/// its integral over the square, taken at 16 points a pixel, within 0.2 % of the flat ground's on
/// 2305 patches. Scaled to DHI flat ground gets 100 W/m2 (1e-5). Turned by a quarter, walls get the
/// light of their neighbours.
#[test]
fn a_picture_gives_the_integral_of_its_radiance() {
    let folder = open_surfaces();
    let pixel = |i: usize| if is_bright(i % 512, i / 512) { [127, 127, 127, 137] } else { [0; 4] };
    let head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 512 +X 512\n".to_vec();
    let picture = [head, (0..512 * 512).flat_map(pixel).collect()].concat();
    fs::write(folder.path("square.hdr"), picture).expect("a picture");
    // The camera looks upwards with north at the top, so east is left.
    let direction = |column: f64, row: f64| {
        let (right, down) = (column / 256.0 - 1.0, row / 256.0 - 1.0);
        let radius = (right * right + down * down).sqrt();
        let (zenith, azimuth) = (radius * FRAC_PI_2, (-right).atan2(-down));
        let d = DVec3::new(zenith.sin() * azimuth.sin(), zenith.sin() * azimuth.cos(), zenith.cos());
        // Solid angle of a pixel: sine over angle x the square of radians a pixel.
        (d, zenith.sin() / zenith * (FRAC_PI_2 / 256.0).powi(2))
    };
    let integral = |normal: DVec3| -> f64 {
        let quarter = |i: usize| (i as f64 + 0.5) / 4.0;
        let inside = (0..512 * 512_usize).filter(|i| is_bright(i % 512, i / 512)).flat_map(|i| {
            (0..16).map(move |k| direction((i % 512) as f64 + quarter(k % 4), (i / 512) as f64 + quarter(k / 4)))
        });
        inside.map(|(d, sr)| 255.0 * normal.dot(d).max(0.0) * sr / 16.0).sum()
    };
    let flat = integral(DVec3::Z);
    let given = "replay open.helio --conditions one.csv --sky square.hdr --patches 2305 --columns sky_direct";
    let found = rows(&folder, &format!("{given} --sky-scale given"));
    let turned = rows(&folder, &format!("{given} --sky-scale given --image-top 90"));
    for (tilt, azimuth) in SURFACES {
        let name = format!("sky_{tilt}_{azimuth}");
        let expected = integral(tilted(f64::from(tilt), f64::from(azimuth)));
        let value = value(&found, "noon", &name, "sky_direct");
        assert!((value - expected).abs() < 2e-3 * flat, "{name}: {value} {expected}");
        let expected = integral(tilted(f64::from(tilt), f64::from(azimuth) - 90.0));
        let value = self::value(&turned, "noon", &name, "sky_direct");
        assert!((value - expected).abs() < 2e-3 * flat, "{name} turned: {value} {expected}");
    }
    let scaled = rows(&folder, given);
    assert!((value(&scaled, "noon", "sky_0_0", "sky_direct") - 100.0).abs() < 1e-3);
}

/// Writes a picture of clouds, white where it is clear.
fn mask(side: usize, is_clear: impl Fn(usize, usize) -> bool) -> Vec<u8> {
    let pixels: Vec<u8> = (0..side * side).map(|i| if is_clear(i % side, i / side) { 255 } else { 0 }).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side as u32, side as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels)).expect("a PNG");
    bytes
}

/// Clouds over the southern half of a uniform sky hide the sun in the south: sun_direct is 0, flat
/// ground gets half of DHI, the wall to the north the light without clouds, the wall to the west
/// half of that, all within 0.1 W/m2 of 100.
#[test]
fn clouds_in_the_south_hide_the_sun_there() {
    let folder = open_surfaces();
    fs::write(folder.path("south.png"), mask(800, |_, row| row < 400)).expect("a mask");
    let found = rows(&folder, "replay open.helio --conditions one.csv --sky uniform --clouds south.png");
    for (name, expected) in [("sky_0_0", 50.0), ("sky_90_0", 50.0), ("sky_90_270", 25.0)] {
        let sky = value(&found, "noon", name, "sky_direct");
        assert!((sky - expected).abs() < 0.1, "{name}: {sky}");
        assert_eq!(value(&found, "noon", name, "sun_direct"), 0.0);
    }
    let north =
        rows(&folder, "replay open.helio --conditions one.csv --sky uniform --clouds south.png --image-top 180");
    let sun = value(&north, "noon", "sky_0_0", "sun_direct");
    assert!((sun / (800.0 * 0.5_f64.sqrt()) - 1.0).abs() < 1e-4, "{sun}");
}

/// For a cube with a mirror front on grass, under clouds by condition that let a quarter through
/// and all of it, each of the six columns is a quarter of that under a clear sky (1e-5 of the
/// total), or the same; sun_reflected and sun_mirrored are among them.
#[test]
fn clouds_dim_every_path() {
    let folder = Folder::new();
    folder.write(
        "materials.toml",
        "[wall]\ndiffuse = 0.1\nspecular = 0.6\n[roof]\ndiffuse = 0.2\n[grass]\ndiffuse = 0.25\n",
    );
    folder.write(
        "conditions.csv",
        "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,50,800,100\nlater,200,40,700,90\n",
    );
    folder.write("receivers.csv", "receiver,x,y,z,nx,ny,nz\nlawn,5,-4,0.02,0,0,1\nsouth,5,-8,2,0,1,0\n");
    assert!(folder.build().status.success());
    let names: String = (0..145).map(|i| format!(",p{i}")).collect();
    let (quarter, clear) = (",0.25".repeat(145), ",1".repeat(145));
    folder.write("clouds.csv", &format!("condition{names}\nlater{clear}\nnoon{quarter}\n"));
    let (plain, dimmed) = (
        rows(&folder, "replay site.helio --conditions conditions.csv"),
        rows(&folder, "replay site.helio --conditions conditions.csv --clouds clouds.csv"),
    );
    let columns =
        ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored", "total"];
    for (condition, share) in [("noon", 0.25), ("later", 1.0)] {
        for receiver in ["lawn", "south"] {
            let of = |rows: &Rows, column: &str| value(rows, condition, receiver, column);
            for column in columns {
                let (before, after) = (of(&plain, column), of(&dimmed, column));
                assert!((after - share * before).abs() < 1e-5 * of(&plain, "total"), "{column}: {before} {after}");
            }
        }
    }
    for column in ["sun_reflected", "sun_mirrored", "sky_mirrored"] {
        assert!(plain.values().any(|row| row[column] > 1.0), "{column}");
    }
}

/// With a table of radiances, 100 W/m2/sr in each of 577 patches, flat ground gets 100 pi W/m2,
/// walls half of it (1e-4). A table without a row for a condition is refused.
#[test]
fn equal_radiances_give_pi_times_the_radiance() {
    let folder = open_surfaces();
    let names: String = (0..577).map(|i| format!(",p{i}")).collect();
    folder.write("sky.csv", &format!("condition{names}\nnoon{}\n", ",100".repeat(577)));
    let found = rows(&folder, "replay open.helio --conditions one.csv --sky sky.csv --columns sky_direct");
    for (name, expected) in [("sky_0_0", 100.0 * PI), ("sky_90_0", 50.0 * PI), ("sky_90_270", 50.0 * PI)] {
        let sky = value(&found, "noon", name, "sky_direct");
        assert!((sky / expected - 1.0).abs() < 1e-4, "{name}: {sky}");
    }
    folder.write("others.csv", &format!("condition{names}\nx{}\ny{}\n", ",1".repeat(577), ",1".repeat(577)));
    folder.fails("replay open.helio --conditions one.csv --sky others.csv", "input unknown others.csv noon");
}

/// Bad files and choices are refused with exit code 2, the file, the finding and a hint: a matrix
/// of MF:3, one of five hours for eight, a negative radiance, NaN, a photograph that is not square,
/// a PNG whose levels would be radiances, a cloud of 1.5, clouds with `perez1990`, a scale without
/// a file, a word that is no model.
#[test]
fn bad_sky_files_are_refused() {
    let folder = open_surfaces();
    let weather = format!("replay open.helio --weather {}", data("../skies/hours.wea").display());
    let head =
        |rows: usize, columns: usize| format!("#?RADIANCE\nNROWS={rows}\nNCOLS={columns}\nNCOMP=1\nFORMAT=ascii\n\n");
    folder.write("mf3.mtx", &(head(1298, 8) + &"1\n".repeat(8 * 1298)));
    folder.write("five.mtx", &(head(146, 5) + &"1\n".repeat(5 * 146)));
    folder.write("below.mtx", &(head(146, 8) + &"1\n".repeat(8 * 146 - 1) + "-2\n"));
    folder.write("nan.mtx", &(head(146, 8) + &"1\n".repeat(8 * 146 - 1) + "nan\n"));
    let names: String = (0..145).map(|i| format!(",p{i}")).collect();
    folder.write("thick.csv", &format!("condition{names}\nnoon{}\n", ",1.5".repeat(145)));
    folder.write("holes.csv", &format!("condition{names}\nnoon,NaN{}\n", ",1".repeat(144)));
    fs::write(folder.path("sky.png"), mask(9, |_, _| true)).expect("a picture");
    let mut wide = Vec::new();
    let mut encoder = png::Encoder::new(&mut wide, 4, 3);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&[9; 12])).expect("a PNG");
    fs::write(folder.path("wide.png"), wide).expect("a picture");
    for (matrix, found, fix) in [
        ("mf3.mtx", "1298 rows, not the 146", "gendaymtx -s -O1"),
        ("five.mtx", "5 columns of time for a weather file of 8 rows", "one row for each of these rows"),
        ("below.mtx", "row 146, column 8, is -2", "0 or more"),
        ("nan.mtx", "row 146, column 8, is NaN", "make the matrix again"),
    ] {
        folder.refused(&format!("{weather} --sky {matrix}"), &[matrix, found, "to fix: ", fix]);
    }
    let query = "replay open.helio --conditions one.csv";
    for (more, parts) in [
        ("--sky wide.png", ["wide.png", "4 x 3 pixels are not a square", "crop it"]),
        ("--sky sky.png --sky-scale given", ["sky.png", "levels of a PNG are not radiances", "--sky-white"]),
        ("--clouds thick.csv", ["thick.csv, line 2", "patch 1 is `1.5`", "from 0 to 1"]),
        ("--sky holes.csv", ["holes.csv, line 2", "patch 1 is `NaN`", "0 or more"]),
        ("--sky perez1990 --clouds sky.png", ["--sky", "`perez1990` adds light at the sun", "choose another sky"]),
        ("--sky-scale dhi", ["--sky-scale", "the sky is a model", "give a file with --sky"]),
        ("--sky missing.mtx", ["missing.mtx", "", ""]),
    ] {
        folder.refused(&format!("{query} {more}"), &parts);
    }
}
