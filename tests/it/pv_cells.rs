//! Cells of modules in partial shade: substrings with bypass diodes by hand, modules in series,
//! wrong tables.

use crate::cli::{Folder, stderr};
use crate::pv::{good, number, table};

/// Ten minutes at noon, the sun 63 degrees high in the south, without a sky.
const CLEAR: &str =
    "time,dni,dhi,temp_air,wind_speed\n2019-06-21T12:00+01:00,1000,0,10,2\n2019-06-21T12:05+01:00,1000,0,10,2\n";

/// Returns two upright black modules side by side, 1 m x 1.8 m, whose fronts face south, 200 kW
/// each for the sake of digits, with keys of cells; `slab` is a roof that shades the first one.
fn facade(cells: &str, slab: &str) -> Folder {
    let folder = Folder::new();
    folder.write("clear.csv", CLEAR);
    folder.write(
        "ground.obj",
        &format!("v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nusemtl soil\nf 1 2 3 4\n{slab}"),
    );
    folder.write("ground.toml", "[soil]\ndiffuse = 0\nclass = \"ground\"\n[slab]\ndiffuse = 0\n");
    folder.write(
        "rows.toml",
        &format!(
            "[[rows]]\nname = \"r\"\nrows = 1\nmodules = 2\ntilt = 90\nazimuth = 180\npitch = 3\nwidth = 1\nheight = 1.8\n\
             clearance = 1\nfront = 0\nrear = 0\nkwp = 200\n{cells}"
        ),
    );
    folder
}

const RUN: &str = "pv ground.obj --latitude 50 --longitude 15 -m ground.toml -w clear.csv --rows rows.toml --sky uniform --bifaciality 0 --losses 0% \
                   --temperature-coefficient=0 --replace -o out";

/// Returns a black roof over the first module, 0.1 m above its upper edge: at noon of 21 June the
/// lower 5/9 of the module are lit.
fn roof() -> String {
    let corners = [(-1.5, -0.02), (0.0, -0.02), (0.0, -0.45), (-1.5, -0.45)];
    let corners = corners.map(|(x, y)| format!("v {x} {y} 2.9\n")).concat();
    format!("{corners}usemtl slab\nf 5 6 7 8\n")
}

/// Without shade cells take nothing, and the energy is that of modules without cells, within 0.1 %.
/// Under a roof over one of two modules the DC energy, in modules of full light, is that of a hand
/// within 1 %: of upright substrings (6 x 9 cells) none gives anything; of those on their side (9 x
/// 6) one of three does, less the voltage of two diodes; the lower halves (6 x 18) give half, nine
/// tenths of the light. In series with the other module the shaded one is bypassed by three
/// diodes.
#[test]
fn a_roof_over_a_module_costs_its_substrings() {
    let run = |cells: &str, slab: &str| {
        let folder = facade(cells, slab);
        let text = good(&folder, RUN);
        (text, table(&folder, "out/energy.csv").remove(0), table(&folder, "out/points.csv"))
    };
    let (_, even, _) = run("", "");
    let even_kwh = number(&even, "dc_kwh");
    assert!(!even.contains_key("mismatch_kwh"));
    let (text, energy, points) = run("cells = { across = 6, up = 9 }\n", "");
    assert!((number(&energy, "dc_kwh") / even_kwh - 1.0).abs() < 1e-3, "{energy:?}, not {even_kwh}");
    assert!(number(&energy, "mismatch_kwh") < 1e-3 * even_kwh, "{energy:?}");
    assert!(text.contains("partial shade of cells takes 0.0 % of the DC energy"), "{text}");
    assert_eq!(number(&points[0], "partial_shade_h"), 0.0);
    let diode = 0.88 / 18.0;
    for (cells, lit, right, lost_percent) in [
        ("across = 6, up = 9", 5.0 / 9.0, 1.0, 100.0),
        ("across = 9, up = 6", 0.5, 1.0 + (1.0 - 2.0 * diode) / 3.0, 100.0 * (1.0 - (1.0 - 2.0 * diode) / 1.5)),
        ("across = 6, up = 18, half_cut = true", 5.0 / 9.0, 1.5, 10.0),
        ("across = 6, up = 9, series = 2", 5.0 / 9.0, 1.0 - diode, 100.0),
    ] {
        let (_, energy, points) = run(&format!("cells = {{ {cells} }}\n"), &roof());
        let [dc, mismatch] = ["dc_kwh", "mismatch_kwh"].map(|column| 2.0 * number(&energy, column) / even_kwh);
        assert!((dc - right).abs() < 0.01, "{cells}: {dc}, not {right}");
        assert!((mismatch - (1.0 + lit - right)).abs() < 0.01, "{cells}: {mismatch}");
        let own = number(&points[0], "mismatch_loss_percent");
        assert!((own - lost_percent).abs() < 1.5, "{cells}: {own}, not {lost_percent}");
        let hours = number(&points[0], "partial_shade_h");
        assert_eq!(hours > 0.1, lost_percent > 1.5, "{cells}: {hours}");
    }
}

/// Cells without a rated power, on trackers, that substrings do not share, and an unknown key are
/// refused by name, and nothing is written.
#[test]
fn wrong_cells_are_refused() {
    for (cells, named) in [
        ("cells = { across = 5, up = 9 }\n", "5 is no multiple of 3"),
        ("cells = { across = 6, up = 9, serie = 2 }\n", "unknown field `serie`"),
        ("cells = 6\n", "as in { across = 6, up = 10 }"),
    ] {
        let folder = facade(cells, "");
        let output = folder.run(RUN);
        assert_eq!(output.status.code(), Some(2), "{cells}");
        assert!(stderr(&output).contains(named), "{cells}: {}", stderr(&output));
        assert!(!folder.path("out").exists(), "{cells}");
    }
    let folder = facade("cells = { across = 6, up = 9 }\n", "");
    let rows = std::fs::read_to_string(folder.path("rows.toml")).expect("rows");
    folder.write("rows.toml", &rows.replace("kwp = 200\n", ""));
    let output = folder.run(RUN);
    assert!(stderr(&output).contains("`cells` needs the rated power of the array"), "{}", stderr(&output));
    let turned = rows.replace("tilt = 90\nazimuth = 180\n", "tracker = { hub = 1.5 }\n").replace("clearance = 1\n", "");
    folder.write("rows.toml", &turned);
    let output = folder.run(RUN);
    assert!(stderr(&output).contains("`cells` is for fixed rows"), "{}", stderr(&output));
}
