//! Pictures of results: their numbers, read back from pixels and rectangles, are those of the CSV;
//! results that cannot be drawn are refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use heliotile_results::outputs::pictures::colours::{COMPONENTS, viridis};
use heliotile_results::outputs::pictures::drawing::SCALE;

use crate::cli::{Folder, golden, stderr, stdout};

/// Returns the path of a typical year of hours.
pub fn year() -> PathBuf {
    Path::new(crate::ROOT).join("tests/data/weather/golden_tmy3.epw")
}

fn good(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    stdout(&output)
}

/// Builds a cube of 10 m on a square of 60 m, its roof covered with 16 receivers and its walls with
/// 64.
fn cube() -> Folder {
    let folder = Folder::new();
    good(&folder, "receivers scene.obj --on wall,roof --spacing 2.5 -o r.csv");
    good(&folder, "build scene.obj -m materials.toml -r r.csv --quality draft -o site.helio");
    folder
}

/// Reads rows of a CSV by the names of its header.
fn table(folder: &Folder, name: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.path(name)).expect("a table");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

fn number(row: &BTreeMap<String, String>, name: &str) -> f64 {
    row[name].parse().expect("a number")
}

/// Reads a PNG: width, pixels, and texts by name.
pub fn png(path: &Path) -> (usize, Vec<[u8; 3]>, BTreeMap<String, String>) {
    let bytes = fs::read(path).expect("a picture");
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let frame = reader.next_frame(&mut pixels).expect("pixels");
    let texts = &reader.info().uncompressed_latin1_text;
    let texts = texts.iter().map(|text| (text.keyword.clone(), text.text.clone())).collect();
    (frame.width as usize, pixels.as_chunks().0.to_vec(), texts)
}

/// Corner of the view from above, and height of the space below the views, points.
const PANEL: [usize; 2] = [16, 86];
const FOOT: usize = 122;

/// Returns the step, of 255, that a colour of the map stands for.
fn step(colour: [u8; 3]) -> Option<f64> {
    (0..=255).find(|step| viridis(*step) == colour).map(f64::from)
}

/// The view from above has north up and is true to scale: its coloured square is as wide as high
/// within 3 %, and the colours at the middles of the 16 patches of the roof stand for the sums of
/// the CSV within one of 255 steps. The oblique view has colours of its own, and white around.
#[test]
fn a_map_shows_the_sums() {
    let folder = cube();
    let weather = year();
    good(&folder, &format!("replay site.helio -w {} --every total --plot map.png -o map.csv", weather.display()));
    let (width, pixels, texts) = png(&folder.path("map.png"));
    let top: f64 = texts["heliotile.colours_to"].parse().expect("a number");
    let at = |x: usize, y: usize| pixels[y * width + x];
    // The ground fills the panel, which starts at the point (16, 86).
    let [left, first] = PANEL.map(|points| points * SCALE);
    let across = (left..width).take_while(|x| at(*x, first + 2) != [255; 3]).count();
    let down = (first..).take_while(|y| at(left + 2, *y) != [255; 3]).count();
    let coloured = |x: usize, y: usize| at(x, y)[0] != at(x, y)[1] || at(x, y)[1] != at(x, y)[2];
    let (mut low, mut high) = ((usize::MAX, usize::MAX), (0, 0));
    for (x, y) in
        (first..first + down).flat_map(|y| (left..left + across).map(move |x| (x, y))).filter(|(x, y)| coloured(*x, *y))
    {
        (low, high) = ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)));
    }
    let [wide, tall] = [high.0 - low.0 + 1, high.1 - low.1 + 1].map(|points| points as f64);
    assert!(wide > 200.0 && (wide / tall - 1.0).abs() < 0.03, "{wide} x {tall}");
    let places: BTreeMap<String, BTreeMap<String, String>> =
        table(&folder, "r.csv").into_iter().map(|row| (row["receiver"].clone(), row)).collect();
    let roof: Vec<(f64, f64, f64)> = table(&folder, "map.csv")
        .iter()
        .filter(|row| number(&places[&row["receiver"]], "nz") > 0.5)
        .map(|row| (row, &places[&row["receiver"]]))
        .map(|(row, place)| (number(place, "x"), number(place, "y"), number(row, "total_kwh_m2")))
        .collect();
    assert_eq!(roof.len(), 16);
    let least = |of: fn(&(f64, f64, f64)) -> f64| roof.iter().map(of).fold(f64::INFINITY, f64::min) - 1.25;
    let corner = (least(|place| place.0), least(|place| place.1));
    for (x, y, total) in &roof {
        let column = low.0 as f64 + (x - corner.0) / 10.0 * wide;
        let row = high.1 as f64 - (y - corner.1) / 10.0 * tall;
        let found = step(at(column as usize, row as usize)).expect("a colour of the map");
        assert!((found - 255.0 * total / top).abs() <= 1.0, "{found}, not {total} of {top}");
    }
    let elsewhere = (0..pixels.len()).filter(|i| i % width > left + across || i / width > first + down);
    let seen = elsewhere.filter(|i| coloured(i % width, i / width)).count();
    assert!(seen > 10_000, "{seen}");
}

/// Returns the rectangles of an SVG: fill and height in pixels.
fn rectangles(svg: &str) -> Vec<(String, f64)> {
    let value = |line: &str, name: &str| -> String {
        let rest = line.split_once(&format!(" {name}=\"")).expect("an attribute").1;
        rest.split('"').next().expect("a value").to_owned()
    };
    let rects = svg.lines().filter(|line| line.starts_with("<rect"));
    rects.map(|line| (value(line, "fill"), value(line, "height").parse().expect("a number"))).collect()
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Returns the largest number that stands alone in a picture: the end of its scale.
fn end_of_scale(svg: &str) -> f64 {
    let words = svg.lines().filter_map(|line| line.strip_suffix("</text>")?.rsplit_once('>'));
    words.filter_map(|(_, words)| words.parse().ok()).fold(0.0, f64::max)
}

/// For 12 months and 4 components, 48 bars are as high as the means by area of the CSV, within 0.2
/// % of the axis, and a map of the same replay is written in the same pass.
#[test]
fn bars_are_the_sums_of_months() {
    let folder = cube();
    let plots = "--plot months.svg --plot sum.png";
    good(&folder, &format!("replay site.helio -w {} --every month {plots} -o months.csv", year().display()));
    let areas: BTreeMap<String, f64> =
        table(&folder, "r.csv").iter().map(|row| (row["receiver"].clone(), number(row, "area_m2"))).collect();
    let whole: f64 = areas.values().sum();
    let svg = fs::read_to_string(folder.path("months.svg")).expect("a chart");
    let (top, rects, rows) = (end_of_scale(&svg), rectangles(&svg), table(&folder, "months.csv"));
    let mut checked = 0;
    for (component, colour, _) in COMPONENTS {
        let name = format!("{}_kwh_m2", component.name());
        let mut months: BTreeMap<String, f64> = BTreeMap::new();
        for row in &rows {
            *months.entry(row["time"].clone()).or_default() += number(row, &name) * areas[&row["receiver"]] / whole;
        }
        // The last rectangle is the legend's.
        let mut bars: Vec<f64> =
            rects.iter().filter(|(fill, _)| *fill == hex(colour)).map(|(_, height)| height / 360.0 * top).collect();
        bars.pop();
        for (bar, (month, mean)) in bars.iter().zip(&months) {
            assert!((bar - mean).abs() < 0.002 * top, "{name} {month}: {bar}, not {mean}");
            checked += 1;
        }
        assert_eq!(bars.is_empty(), months.values().all(|mean| *mean == 0.0), "{name}");
    }
    assert_eq!(checked, 48);
    let (_, _, texts) = png(&folder.path("sum.png"));
    let most = rows.iter().fold(BTreeMap::<&str, f64>::new(), |mut sums, row| {
        *sums.entry(&row["receiver"]).or_default() += number(row, "total_kwh_m2");
        sums
    });
    let (most, end) =
        (most.values().copied().fold(0.0, f64::max), texts["heliotile.colours_to"].parse().unwrap_or(0.0));
    assert!(end >= most && end < 1.6 * most, "{end} {most}");
}

/// The 288 cells of hours by month have the colours of the means of the CSV's hours, within one of
/// 255 steps; three days have 3 columns, 72 cells.
#[test]
fn carpets_are_the_means_of_hours() {
    let folder = cube();
    let replay = |weather: &Path| {
        let options = "--every hour --columns total --plot hours.svg -o hours.csv";
        good(&folder, &format!("replay site.helio -w {} {options}", weather.display()));
        let svg = fs::read_to_string(folder.path("hours.svg")).expect("a chart");
        let cells: Vec<String> = rectangles(&svg).into_iter().skip(1).map(|(fill, _)| fill).collect();
        (end_of_scale(&svg), cells[..cells.len() - 256].to_vec())
    };
    let (top, cells) = replay(&year());
    assert_eq!(cells.len(), 288);
    let areas: BTreeMap<String, f64> =
        table(&folder, "r.csv").iter().map(|row| (row["receiver"].clone(), number(row, "area_m2"))).collect();
    let whole: f64 = areas.values().sum();
    let mut means: BTreeMap<(String, String), (f64, BTreeMap<String, ()>)> = BTreeMap::new();
    for row in table(&folder, "hours.csv") {
        // A time such as 1999-01-31T23:00-07:00.
        let time = &row["time"];
        let cell = means.entry((time[5..7].to_owned(), time[11..13].to_owned())).or_default();
        cell.0 += number(&row, "total") * areas[&row["receiver"]] / whole;
        cell.1.insert(time[..10].to_owned(), ());
    }
    let steps: BTreeMap<String, f64> = (0..=255).map(|step| (hex(viridis(step)), f64::from(step))).collect();
    for (cell, (when, (sum, days))) in cells.iter().zip(&means) {
        let mean = sum / days.len() as f64;
        assert!((steps[cell] - 255.0 * mean / top).abs() <= 1.0, "{when:?}: {}, not {mean} of {top}", steps[cell]);
    }
    assert_eq!(replay(&golden()).1.len(), 72);
}

/// Through a year the sun is up for 4,380 to 4,430 hours, and the hours seen, hidden and behind the
/// surface add up to them, at 3 of 3 receivers. Rows with direct sun are those whose `sun_direct`
/// is not 0 in `replay`, exactly.
#[test]
fn hours_seen_and_hidden_add_up_to_the_hours_of_sun() {
    let folder = Folder::new();
    folder.build();
    let weather = year();
    let replay = format!("replay site.helio -w {} --columns sun_direct -o hours.csv", weather.display());
    good(&folder, &replay);
    let hours = table(&folder, "hours.csv");
    let receivers: Vec<String> = table(&folder, "receivers.csv").iter().map(|row| row["receiver"].clone()).collect();
    assert_eq!(receivers.len(), 3);
    let mut behind = 0.0;
    for receiver in &receivers {
        good(&folder, &format!("export site.helio -r {receiver} -w {} -o sun.png", weather.display()));
        let (_, _, texts) = png(&folder.path("sun.png"));
        let hour = |name: &str| -> f64 { texts[&format!("heliotile.{name}")].parse().expect("hours") };
        let [up, seen, hidden] = ["sun_up_h", "sun_seen_h", "sun_hidden_h"].map(hour);
        assert!((4380.0..4430.0).contains(&up) && seen > 0.0 && hidden > -0.001, "{receiver}: {up} {seen} {hidden}");
        assert!((seen + hidden + hour("sun_behind_h") - up).abs() < 0.003);
        behind += hour("sun_behind_h");
        let sunny = hours.iter().filter(|row| row["receiver"] == *receiver && number(row, "sun_direct") > 0.0).count();
        assert_eq!(texts["heliotile.sunny_rows"], sunny.to_string(), "{receiver}");
        assert!(sunny > 500);
    }
    assert!(behind > 500.0, "{behind}");
}

/// Receivers without areas are marks, 3 of 3 on the map; names with `<script>` are text in charts,
/// and the bars of a query are conditions.
#[test]
fn points_are_marks_and_names_stay_text() {
    let folder = Folder::new();
    folder.build();
    let table = stdout(&folder.run("replay site.helio -c conditions.csv"));
    fs::rename(folder.path("site.helio"), folder.path("a<script>.helio")).expect("renamed");
    let one = fs::read_to_string(folder.path("conditions.csv")).expect("conditions");
    folder.write("one.csv", &one.lines().take(2).map(|line| format!("{line}\n")).collect::<String>());
    let said = good(&folder, "replay a<script>.helio -c one.csv --plot map.png");
    assert!(said.is_empty() && !table.is_empty(), "{said}");
    let (width, pixels, _) = png(&folder.path("map.png"));
    let colours = |from: usize, to: usize| {
        let rows = pixels[from * width..to * width].iter();
        rows.filter(|p| p[0] != p[1] || p[1] != p[2]).collect::<std::collections::BTreeSet<_>>().len()
    };
    // Values may be equal, so colours are counted from 3 on.
    assert!(colours(PANEL[1] * SCALE, pixels.len() / width - FOOT * SCALE) >= 3);
    good(&folder, "replay a<script>.helio -c conditions.csv --plot bars.svg");
    let svg = fs::read_to_string(folder.path("bars.svg")).expect("a chart");
    assert!(
        !svg.contains("<script") && svg.matches("a&lt;script&gt;.helio under conditions.csv").count() == 1,
        "{svg}"
    );
    assert!(svg.contains(">noon</text>") && svg.contains("W/m\u{b2}"));
}

/// 9 results that cannot be drawn, or outputs that would replace a file, are refused,
/// and no file is written.
#[test]
fn what_cannot_be_drawn_is_refused() {
    let folder = Folder::new();
    folder.build();
    folder.write("w.epw", &fs::read_to_string(golden()).expect("weather"));
    for (rest, expected) in [
        ("--plot x.jpg", "unsupported `x.jpg`"),
        ("--plot x", "unsupported `x`"),
        ("--every total --plot x.svg", "argument excludes --plot --every"),
        ("--every hour --plot x.png", "argument excludes --plot --every"),
        ("--every total -o x.png", "unsupported `x.png`"),
        ("--every total --plot x.png --plot x.png", "input same-file x.png x.png"),
        ("--every total --plot no/x.png", "input lacks no/x.png folder"),
        ("--every total --plot x.png --model m.city.json -o n.city.json", "argument excludes --plot --model"),
    ] {
        folder.fails(&format!("replay site.helio -w w.epw {rest}"), expected);
    }
    folder.fails("replay site.helio -c conditions.csv --plot x.png", "argument excludes --plot --every");
    let left: Vec<String> = fs::read_dir(folder.path(""))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with('x'))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

/// `run` writes the map and the chart of the months, and a city model with --map cityjson: the
/// features of `replay --model`, line for line. A scene that is no CityJSON is refused before
/// anything is traced.
#[test]
fn run_leaves_pictures() {
    let folder = Folder::new();
    let model = Path::new(crate::ROOT).join("tests/data/cityjson/small.city.jsonl");
    let scene = model.display();
    let options = format!("--weather {} --quality draft --spacing 4m", golden().display());
    good(&folder, &format!("run {scene} {options} -o a.sun --map cityjson"));
    let made = folder.path("a.sun/golden_3_days");
    let names = ["annual.png", "months.svg", "annual.city.jsonl"];
    let [map, chart, city] = names.map(|name| fs::read(made.join(name)).expect("a result"));
    assert!(map.len() > 5000 && chart.starts_with(b"<svg width=\"900\""));
    let again = format!("replay a.sun/site.helio -w {} --every total --model {scene}", golden().display());
    good(&folder, &format!("{again} -o b.city.jsonl"));
    let other = fs::read(folder.path("b.city.jsonl")).expect("a city model");
    let lines = |bytes: &[u8]| -> Vec<String> {
        String::from_utf8(bytes.to_vec()).expect("text").lines().skip(1).map(str::to_owned).collect()
    };
    assert_eq!(lines(&city), lines(&other));
    assert_eq!(lines(&city).iter().filter(|line| line.contains("heliotile_total_kwh_m2")).count(), 3);
    folder.fails(&format!("run scene.obj {options} -o c.sun --map cityjson"), "argument other-kind --map not CityJSON");
    folder.write("odd.json", "{\"type\": \"Other\"}");
    folder.fails(&format!("run odd.json {options} -o c.sun --map cityjson"), "argument other-kind --map not CityJSON");
    assert!(!folder.path("c.sun").exists());
}
