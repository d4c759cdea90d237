//! Light by band, through the program: furnaces, screens and mirrors beside closed forms, bands
//! that add up, photons and lux, blocks of bands in archives, and refusals.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;

use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Archive, format};

use crate::cli::{Folder, golden, stderr, stdout};
use crate::scenes::data;

/// Shares of the sky's light: ultraviolet, visible, near infrared.
const SKY: [f64; 3] = [0.1047, 0.6436, 0.2517];

/// Conditions: a uniform sky of 1,000 W/m2 without sun.
const OVERCAST: &str = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nu,180,30,0,1000\n";

/// Values by column name, for each `(condition or time, receiver)`.
type Rows = BTreeMap<(String, String), BTreeMap<String, f64>>;

fn run(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", stderr(&output));
    stdout(&output)
}

fn rows(folder: &Folder, arguments: &str) -> Rows {
    let text = run(folder, arguments);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().expect("a header").clone();
    let row = |record: csv::StringRecord| {
        let cells =
            header.iter().zip(&record).skip(2).filter_map(|(name, cell)| Some((name.into(), cell.parse().ok()?)));
        ((record[0].to_owned(), record[1].to_owned()), cells.collect())
    };
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

/// Returns the values of a receiver in the only condition.
fn only(folder: &Folder, arguments: &str, receiver: &str) -> BTreeMap<String, f64> {
    rows(folder, arguments).remove(&("u".to_owned(), receiver.to_owned())).expect("the receiver")
}

fn near(what: &str, found: f64, expected: f64, share: f64) {
    assert!((found - expected).abs() <= share * expected.abs(), "{what}: {found} for {expected}");
}

/// Builds a scene as `site.helio`, and writes `OVERCAST`, from faces, materials and receivers.
fn built(obj: &str, materials: &str, receivers: &str) -> Folder {
    let folder = Folder::new();
    folder.write("own.obj", obj);
    folder.write("own.toml", materials);
    folder.write("own.csv", &format!("receiver,x,y,z,nx,ny,nz\n{receivers}"));
    folder.write("u.csv", OVERCAST);
    run(&folder, "build own.obj --materials own.toml --receivers own.csv --no-ground -o site.helio");
    folder
}

fn archive(version: &str) -> PathBuf {
    data(&format!("../archives/{version}.helio"))
}

const QUERY: &str = "replay site.helio --conditions u.csv --sky uniform --columns total";

/// Returns the inside of a sphere of 100 m with a hole of 30 degrees around the zenith.
fn sphere() -> String {
    let (rings, sectors, hole) = (36, 72, 6);
    let point = |ring: usize, sector: usize| {
        let (zenith, azimuth) = (PI * ring as f64 / rings as f64, 2.0 * PI * sector as f64 / sectors as f64);
        let (x, y, z) = (zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos());
        format!("v {:.6} {:.6} {:.6}\n", 100.0 * x, 100.0 * y, 100.0 * z)
    };
    let mut text = "usemtl wall\n".to_owned();
    for ring in hole..rings {
        for sector in 0..sectors {
            for (corner, next) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
                text += &point(ring + corner, sector + next);
            }
            text += if ring + 1 == rings { "f -4 -3 -2\n" } else { "f -4 -3 -2 -1\n" };
        }
    }
    text
}

/// In a sphere that light enters by a hole of a share f of it, the first reflection is
/// rho f x DHI x the band's share, within 0.5 %, and the light reflected again is
/// `rho (1 - f) / (1 - rho (1 - f))` of that, in each band by its own reflectance: 0.5, 0.2 and 0.8
/// give 0.875, 0.230 and 2.942 (f = 0.067), within 6 %: a large cell sees the hole in some eight
/// texels.
#[test]
fn a_furnace_reflects_by_band() {
    let folder =
        built(&sphere(), "[wall]\ndiffuse = { solar = 0.5, visible = 0.2, nir = 0.8 }\n", "down,0,0,0,0,0,-1\n");
    let all = only(&folder, &format!("{QUERY} --bands visible,nir"), "down");
    let once = only(&folder, &format!("{QUERY} --bands visible,nir --bounces 1"), "down");
    let hole = 0.5 * (1.0 - (PI / 6.0).cos());
    for (column, rho, share) in [("total", 0.5, 1.0), ("total_visible", 0.2, SKY[1]), ("total_nir", 0.8, SKY[2])] {
        let again = rho * (1.0 - hole) / (1.0 - rho * (1.0 - hole));
        let first = 1000.0 * rho * hole * share;
        near(column, once[column], first, 0.005);
        near(column, all[column] - once[column], first * again, 0.06);
    }
}

/// Under an endless screen and beside an endless mirror, the light of bands follows their
/// transmittances, 0.5, 0.2 and by difference 0.855, and their reflectances, 0.8 and 0.4, within
/// 0.3 %.
#[test]
fn screens_and_mirrors_let_bands_through() {
    let screen = "v -4000 -4000 1\nv 4000 -4000 1\nv 4000 4000 1\nv -4000 4000 1\nusemtl screen\nf 1 2 3 4\n";
    let folder = built(screen, "[screen]\ntransmittance = { solar = 0.5, visible = 0.2 }\n", "r,0,0,0,0,0,1\n");
    let found = only(&folder, &format!("{QUERY} --bands uv,visible,nir"), "r");
    let nir = (0.5 - (0.0226 + 0.5197) * 0.2) / 0.4577;
    for (column, expected) in [
        ("total", 500.0),
        ("total_uv", 200.0 * SKY[0]),
        ("total_visible", 200.0 * SKY[1]),
        ("total_nir", 1000.0 * nir * SKY[2]),
    ] {
        near(column, found[column], expected, 0.003);
    }
    let mirror = "v 1 -4000 -4000\nv 1 4000 -4000\nv 1 4000 4000\nv 1 -4000 4000\nusemtl mirror\nf 1 2 3 4\n";
    let folder = built(mirror, "[mirror]\ndiffuse = 0\nspecular = { solar = 0.8, nir = 0.4 }\n", "r,0,0,0,0,0,1\n");
    let found = only(&folder, &format!("{QUERY} --bands visible,nir"), "r");
    for (column, rho, share) in [("total", 0.8, 1.0), ("total_visible", 0.8, SKY[1]), ("total_nir", 0.4, SKY[2])] {
        near(column, found[column], 1000.0 * share * 0.5 * (1.0 + rho), 0.003);
    }
}

/// Bands that reflect alike and share all of the light add up to all of it within 1e-5: two halves
/// from a file, and ultraviolet, visible and near infrared. This holds by hours, months and
/// conditions, on an archive with glass and leaves.
#[test]
fn bands_add_up() {
    let folder = Folder::new();
    let half = |name: &str| format!("[[band]]\nname = \"{name}\"\nsun = 0.5\nsky = 0.5\n");
    folder.write("own.toml", &format!("partition = true\n{}{}", half("half"), half("rest")));
    let site = archive("v1.7-mirrors").display().to_string();
    let conditions = data("../archives/v1.7-mirrors.conditions.csv").display().to_string();
    let weather = golden().display().to_string();
    let bands = "--columns total --bands own.toml,uv,visible,nir";
    for (command, unit) in [
        (format!("replay {site} --conditions {conditions} {bands}"), ""),
        (format!("replay {site} --conditions {conditions} {bands} --bounces 2 --reflectance wall=0.7"), ""),
        (format!("replay {site} --weather {weather} {bands}"), ""),
        (
            format!("replay {site} --weather {weather} {bands} --every month --snow albedo --transmittance leaves=0.6"),
            "_kwh_m2",
        ),
    ] {
        let mut compared = 0;
        for row in rows(&folder, &command).values() {
            let of = |name: &str| row[&format!("{name}{unit}")];
            // A CSV has three decimals for hours.
            let close = |sum: f64| (sum - of("total")).abs() <= 1e-5 * of("total") + 0.0016;
            assert!(close(of("total_half") + of("total_rest")), "{command}: {row:?}");
            assert!(close(of("total_uv") + of("total_visible") + of("total_nir")), "{command}: {row:?}");
            compared += usize::from(of("total") > 0.0);
        }
        assert!(compared >= 6, "{command}: {compared}");
    }
}

/// The two halves in all digits: 432 values of hours in NumPy's format differ from the total by at
/// most 1e-5 of it.
#[test]
fn two_halves_sum_to_the_total_in_all_digits() {
    let folder = Folder::new();
    folder.write(
        "own.toml",
        "[[band]]\nname = \"half\"\nsun = 0.5\nsky = 0.5\n[[band]]\nname = \"rest\"\nsun = 0.5\nsky = 0.5\n",
    );
    let command = format!("replay {} --weather {}", archive("v1.7-mirrors").display(), golden().display());
    run(&folder, &format!("{command} --columns total --bands own.toml -o out.npy"));
    let bytes = fs::read(folder.path("out.npy")).expect("an array");
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let values: Vec<f32> = bytes[10 + header..].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    assert_eq!(values.len(), 6 * 72 * 3);
    for row in values.as_chunks::<3>().0 {
        let [total, half, rest] = row.map(f64::from);
        assert!((half + rest - total).abs() <= 1e-5 * total, "{row:?}");
    }
}

/// Photons are 4.57 umol per joule of PAR, mol/m2 in sums (3 days: 259,200 s). Lux of an open roof
/// follow the two efficacies of Perez et al., and their sum over the hours is the sum over the
/// file, within 1e-4.
#[test]
fn photons_and_lux_follow_from_irradiance() {
    let folder = built(
        "v -4000 -4000 0\nv 4000 -4000 0\nv 4000 4000 0\nv -4000 4000 0\nusemtl roof\nf 1 2 3 4\n",
        "[roof]\ndiffuse = 0\n",
        "up,0,0,1,0,0,1\n",
    );
    let weather = golden().display().to_string();
    let bands = "--columns total --bands visible,par";
    let hours = rows(&folder, &format!("replay site.helio --weather {weather} {bands}"));
    let sums = rows(&folder, &format!("replay site.helio --weather {weather} {bands} --every total"));
    let total = sums.values().next().expect("a sum");
    let sum = |column: &str| hours.values().map(|row| row[column]).sum::<f64>();
    for row in hours.values() {
        assert!((row["ppfd"] - 4.57 * row["total_par"]).abs() < 0.004, "{row:?}");
    }
    near("photons", total["ppfd_mol_m2"], sum("ppfd") * 3600e-6, 1e-4);
    near("photons", total["ppfd_mol_m2"], 4.57 * 3.6 * total["total_par_kwh_m2"], 1e-4);
    near("lux", total["illuminance_klx_h"], sum("illuminance") / 1000.0, 1e-4);
    let efficacy = total["illuminance_klx_h"] / total["total_kwh_m2"];
    assert!((105.0..120.0).contains(&efficacy), "{efficacy} lm/W");
    // Overcast at 60 degrees from the zenith: epsilon 1, delta 1000 x 1.993 / 1367 is more than the
    // 0.6 of the data; 2 cm of water.
    let found = only(&folder, &format!("{QUERY} --bands visible"), "up");
    let expected = 97.24 - 0.46 * 2.0 + 12.0 * 0.5 - 8.91 * 0.6_f64.ln();
    near("lux", found["illuminance"], 1000.0 * expected, 1e-3);
}

/// An option counts in every band, and a material that it leaves alone keeps its values by band. A
/// wall of 0.5 (0.2 in the visible band) that is set to 0.8 gives 4.0 times the visible light of
/// one reflection; snow without ground gives 1.0 times.
#[test]
fn options_count_in_every_band() {
    let wall = "v 1 -4000 -4000\nv 1 4000 -4000\nv 1 4000 4000\nv 1 -4000 4000\nusemtl wall\nf 1 2 3 4\n";
    let folder = built(wall, "[wall]\ndiffuse = { solar = 0.5, visible = 0.2 }\n", "r,0,0,0,1,0,0\n");
    let seen = |more: &str| only(&folder, &format!("{QUERY} --bands visible --bounces 1 {more}"), "r")["total_visible"];
    near("changed", seen("--reflectance wall=0.8") / seen(""), 4.0, 1e-3);
    let weather = golden().display().to_string();
    let snow = |more: &str| {
        let found =
            rows(&folder, &format!("replay site.helio --weather {weather} --bands visible --every total {more}"));
        found.values().next().expect("a sum")["total_visible_kwh_m2"]
    };
    near("snow", snow("--snow albedo") / snow(""), 1.0, 1e-5);
}

/// An archive of materials without values by band has the root of one whose materials state a
/// single number, and no block of bands; one value for a band is a block of some 60 bytes. A copy,
/// a part and two parts merged keep it, `diff` and `info` show it, `verify` finds nothing.
#[test]
fn archives_hold_bands_only_where_they_are_stated() {
    let folder = Folder::new();
    run(&folder, "build scene.obj --materials materials.toml --receivers receivers.csv -o plain.helio");
    let stated = fs::read_to_string(folder.path("materials.toml")).expect("materials");
    let table = |seen: &str| -> String {
        let line = |line: &str| match line.strip_prefix("diffuse = ") {
            Some(value) => format!("diffuse = {{ solar = {value}{seen} }}\n"),
            None => format!("{line}\n"),
        };
        stated.lines().map(line).collect()
    };
    for (name, seen) in [("solar", ""), ("seen", ", visible = 0.05")] {
        folder.write(&format!("{name}.toml"), &table(seen));
        run(&folder, &format!("build scene.obj --materials {name}.toml --receivers receivers.csv -o {name}.helio"));
    }
    let open = |name: &str| Archive::open(&folder.path(name)).expect("an archive");
    let bytes = |name: &str| fs::read(folder.path(name)).expect("an archive");
    let bands = |name: &str| {
        let archive = open(name);
        let block =
            archive.has(format::BANDS, TileNumber::FIRST).then(|| archive.block(format::BANDS, TileNumber::FIRST));
        block.map(|block| block.expect("a block").bytes().to_vec())
    };
    assert_eq!(bytes("plain.helio"), bytes("solar.helio"));
    assert_eq!(bands("plain.helio"), None);
    let stored = open("seen.helio").entries_of(format::BANDS)[0].stored;
    assert!(stored < 100, "{stored}");
    run(&folder, "archive verify seen.helio --deep");
    assert!(run(&folder, "info seen.helio").contains("  bands "), "info");
    let (first, second) = (open("seen.helio"), stdout(&folder.run("archive diff plain.helio seen.helio")));
    assert!(second.contains("diffuse.visible"), "{second}");
    assert_eq!(first.entries_of(format::BANDS).len(), 1);
    run(&folder, "archive extract seen.helio --bbox=-1000,-1000,1000,1000 -o part.helio");
    run(&folder, "archive merge seen.helio part.helio -o both.helio");
    for name in ["part.helio", "both.helio"] {
        assert_eq!(bands(name), bands("seen.helio"), "{name}");
    }
}

/// Tables, maps, charts and comparisons name light by its unit.
#[test]
fn all_outputs_name_light_by_its_unit() {
    let folder = built(
        "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nusemtl roof\nf 1 2 3 4\n",
        "[roof]\ndiffuse = { solar = 0.3, visible = 0.1 }\n",
        "up,0,0,1,0,0,1\n",
    );
    folder.write("own.csv", "receiver,x,y,z,nx,ny,nz,area\nup,0,0,1,0,0,1,4\n");
    run(&folder, "build own.obj --materials own.toml --receivers own.csv --no-ground -o site.helio");
    let replay = format!("replay site.helio --weather {} --every month --bands visible,par", golden().display());
    run(&folder, &format!("{replay} --columns illuminance -o map.vtu"));
    let map = String::from_utf8_lossy(&fs::read(folder.path("map.vtu")).expect("a map")).into_owned();
    for name in ["illuminance_klx_h", "ppfd_mol_m2", "total_visible_kwh_m2"] {
        assert!(map.contains(name), "{name}");
    }
    run(&folder, &format!("{replay} --columns illuminance -o rows.parquet --plot bars.svg"));
    let chart = fs::read_to_string(folder.path("bars.svg")).expect("a chart");
    assert!(chart.contains("klx h"), "{chart}");
    let compared = run(&folder, &format!("compare site.helio site.helio --weather {} --bands par", golden().display()));
    let header = compared.lines().next().unwrap_or_default();
    assert!(header.contains("change_total_kwh_m2") && header.contains("before_ppfd_mol_m2"), "{header}");
}

/// A note says that no material states values by band, another one that a value derived from the
/// others is no share: 2 of 2. A wrong name, a repeated one, a missing file, shares beyond 1 and a
/// partition that does not add up end with exit code 2 and a message, 7 of 7. A Honeybee folder
/// cannot hold bands.
#[test]
fn wrong_bands_are_refused_and_doubtful_ones_noted() {
    let roof = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nusemtl roof\nf 1 2 3 4\n";
    let folder = built(roof, "[roof]\ndiffuse = { solar = 0.2, visible = 0.9 }\n", "up,0,0,1,0,0,1\n");
    let said = stderr(&folder.run(&format!("{QUERY} --bands nir")));
    assert!(
        said.contains("in nir that follow from their other values") && said.contains("`roof`: `diffuse` would be -0."),
        "{said}"
    );
    let said = stderr(&folder.run(&format!("{QUERY} --bands visible")));
    assert!(!said.contains("note"), "{said}");
    folder.write("plain.toml", "[roof]\ndiffuse = 0.2\n");
    run(&folder, "build own.obj --materials plain.toml --receivers own.csv --no-ground -o plain.helio");
    let said = stderr(&folder.run("replay plain.helio --conditions u.csv --bands visible"));
    assert!(said.contains("no material has values by band"), "{said}");
    folder.write("much.toml", "[[band]]\nname = \"a\"\nsun = 1.5\nsky = 0.5\n");
    folder.write("part.toml", "partition = true\n[[band]]\nname = \"a\"\nsun = 0.5\nsky = 0.5\n");
    for (bands, expected) in [
        ("visible,red", "argument unreadable --bands visible,red"),
        ("par,par", "argument unreadable --bands par,par"),
        ("none.toml", "argument unreadable --bands none.toml"),
        ("much.toml", "argument unreadable --bands much.toml"),
        ("part.toml", "argument unreadable --bands part.toml"),
    ] {
        folder.fails(&format!("{QUERY} --bands {bands}"), expected);
    }
    folder.fails(&format!("{QUERY},total_red"), "argument unknown --columns total_red");
    let weather = golden().display().to_string();
    let honeybee = format!("replay site.helio --weather {weather} --bands par --honeybee out");
    folder.fails(&honeybee, "argument excludes --columns --honeybee");
    folder.write("wrong.toml", "[roof]\ndiffuse = { visible = 0.9 }\n");
    let build = "build own.obj --materials wrong.toml --receivers own.csv --no-ground -o wrong.helio";
    folder.fails(build, "input no-column wrong.toml:2 solar");
}
