//! Tables of results: the columns, receivers, surfaces and hours that a user can choose, and their
//! values.

use std::collections::BTreeMap;
use std::process::Output;

use crate::cli::{Folder, golden, stdout};

/// Builds the site of the command line tests with two receivers on a surface `front` of 1 and 3 m2
/// and two without areas on `top`.
fn site() -> Folder {
    let folder = Folder::new();
    let rows = "roof,5,5,10.02,0,0,1,,top\nridge,7,7,10.02,0,0,1,,top\nlow,5,-0.02,2,0,-1,0,1,front\n\
                high,5,-0.02,8,0,-1,0,3,front\n";
    folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz,area,surface\n{rows}"));
    assert_eq!(folder.build().status.code(), Some(0));
    folder
}

/// Builds a roof with 90 receivers in two tiles, on five surfaces.
fn roof() -> Folder {
    let folder = Folder::new();
    let row = |i: usize| format!("r{i},{},{},10.02,0,0,1,{},s{}\n", i % 10, i / 10, 1 + i % 3, i % 5);
    let rows: String = (0..90).map(row).collect();
    folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz,area,surface\n{rows}"));
    assert_eq!(folder.build().status.code(), Some(0));
    folder
}

fn replay(folder: &Folder, rest: &str) -> Output {
    folder.run(&format!("replay site.helio --weather {} {rest}", golden().display()))
}

/// Parses a table: the header, and values by label and receiver.
fn table(output: &Output) -> (String, BTreeMap<(String, String), Vec<f64>>) {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = stdout(output);
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default().to_string();
    let row = |line: &str| {
        let mut cells = line.split(',').map(str::to_string);
        let key = (cells.next().unwrap_or_default(), cells.next().unwrap_or_default());
        (key, cells.map(|cell| cell.parse().expect("a number")).collect())
    };
    (header, lines.map(row).collect())
}

fn key(label: &str, place: &str) -> (String, String) {
    (label.to_string(), place.to_string())
}

/// `--columns` writes two chosen columns, in that order, with the values of the whole table, also
/// with the suffix of sums; 3 wrong lists end with exit code 2.
#[test]
fn chosen_columns_are_written_in_their_order() {
    let folder = site();
    let (_, whole) = table(&replay(&folder, "--every day"));
    let (header, two) = table(&replay(&folder, "--every day --columns total_kwh_m2,sky_direct"));
    assert_eq!(header, "time,receiver,total_kwh_m2,sky_direct_kwh_m2");
    assert_eq!((whole.len(), two.len()), (12, 12));
    for (place, values) in &two {
        assert_eq!(values[..], [whole[place][6], whole[place][1]]);
    }
    let (header, one) = table(&folder.run("replay site.helio -c conditions.csv --columns sun_reflected"));
    assert_eq!((header.as_str(), one.len()), ("condition,receiver,sun_reflected", 8));
    let query = "replay site.helio -c conditions.csv --columns";
    folder.fails(&format!("{query} sun"), "argument unknown --columns sun");
    folder.fails(&format!("{query} total,total"), "argument duplicate --columns total");
    folder.fails(&format!("{query} total,"), "argument unknown --columns ");
}

/// Spans of the three days give their hours, one day or two, and `total` is the sum of the days. 5
/// wrong spans end with exit code 2, and a typical year accepts no years.
#[test]
fn spans_give_their_hours_and_days() {
    let folder = site();
    let (_, days) = table(&replay(&folder, "--every day"));
    for (span, hours) in [
        ("--from 1998-03-21 --to 1998-03-21", 24),
        ("--from 03-21", 48),
        ("--to 03-20T06:00", 6),
        ("--from 03-22 --to 03-20", 48),
    ] {
        let (_, rows) = table(&replay(&folder, span));
        assert_eq!(rows.len(), 4 * hours, "{span}");
    }
    let (_, total) = table(&replay(&folder, "--every total --from 03-21"));
    assert_eq!(total.len(), 4);
    let (sum, parts) =
        (total[&key("total", "roof")][6], ["1998-03-21", "1998-03-22"].map(|d| days[&key(d, "roof")][6]));
    assert!((sum - parts[0] - parts[1]).abs() < 1e-5 * sum, "{sum} {parts:?}");

    let refused = |span: &str, expected: &str| {
        folder.fails(&format!("replay site.helio --weather {} {span}", golden().display()), expected);
    };
    refused("--from 07-01 --to 08-31", "input lacks golden_3_days.epw hours");
    refused("--from 1998-03-22 --to 1998-03-20", "unsupported from 1998-03-22 to 1998-03-20");
    refused("--from 1998-03-22 --to 03-22", "unsupported from 1998-03-22 to 03-22");
    refused("--from 02-30", "argument unreadable --from 02-30");
    let year = golden().with_file_name("golden_tmy3.epw");
    let replay = format!("replay site.helio --weather {} --every", year.display());
    folder.fails(&format!("{replay} month --from 1999-01-15 --to 1999-01-31"), "input lacks golden_tmy3.epw hours");
    let (_, winter) = table(&folder.run(&format!("{replay} month --from 11-16 --to 01-31")));
    assert_eq!(
        winter.keys().filter(|(_, r)| r == "roof").map(|(m, _)| m.as_str()).collect::<Vec<_>>(),
        ["01", "11", "12"]
    );
}

/// `--receivers` gives the rows of the whole table for the 2 listed receivers. An unknown id, a
/// missing column and an output that would replace the list, also beside an array, are refused, 4
/// of 4.
#[test]
fn listed_receivers_keep_the_rows_of_the_table() {
    let folder = site();
    folder.write("few.csv", "note,receiver\nx,high\n,roof\n");
    let (_, whole) = table(&replay(&folder, ""));
    let (_, few) = table(&replay(&folder, "--receivers few.csv"));
    assert_eq!((whole.len(), few.len()), (4 * 72, 2 * 72));
    assert!(few.iter().all(|(place, values)| whole[place] == *values));
    folder.write("odd.csv", "receiver\nroof\nattic\n");
    let query = "replay site.helio -c conditions.csv --receivers";
    folder.fails(&format!("{query} odd.csv"), "input unknown odd.csv attic");
    folder.fails(&format!("{query} conditions.csv"), "input no-column conditions.csv:1 receiver");
    folder.fails(&format!("{query} few.csv -o few.csv"), "input same-file few.csv few.csv");
    folder.write("few.axes.json", "receiver\nroof\n");
    folder.fails(&format!("{query} few.axes.json -o few.npy"), "input same-file few.axes.json few.axes.json");
}

/// In two tiles any selection gives the rows of the whole table: one receiver of either tile, one
/// of each, all 90; Arrow files name those alone.
#[test]
fn selections_keep_the_rows_of_two_tiles() {
    let folder = roof();
    let query = "replay site.helio -c conditions.csv";
    let (_, whole) = table(&folder.run(query));
    // Rows in the order of the archive, which ends in the second tile.
    let text = stdout(&folder.run(query));
    let ids: Vec<&str> = text.lines().skip(1).step_by(2).filter_map(|line| line.split(',').nth(1)).collect();
    assert_eq!(ids.len(), 90);
    for list in [vec![ids[3]], vec![ids[80]], vec![ids[88], ids[10]], ids.clone()] {
        folder.write("list.csv", &format!("receiver\n{}\n", list.join("\n")));
        let (_, rows) = table(&folder.run(&format!("{query} --receivers list.csv")));
        assert_eq!(rows.len(), 2 * list.len());
        assert!(rows.iter().all(|(place, values)| whole[place] == *values));
        let written = folder.run(&format!("{query} --receivers list.csv -o t.arrow"));
        assert_eq!(written.status.code(), Some(0), "{}", String::from_utf8_lossy(&written.stderr));
    }
}

/// `--by surface` is (1 x low + 3 x high) / 4 on `front`, the plain mean on `top` without areas. A
/// selection is weighted by its own receivers. Receivers without a surface and a surface with some
/// areas only are refused.
#[test]
fn surfaces_are_means_weighted_by_area() {
    let folder = site();
    let (_, single) = table(&replay(&folder, "--every month"));
    let (header, surfaces) = table(&replay(&folder, "--every month --by surface"));
    assert!(header.starts_with("time,surface,sun_direct_kwh_m2,"), "{header}");
    assert_eq!(surfaces.len(), 2);
    for (surface, [(a, weight_a), (b, weight_b)]) in
        [("front", [("low", 0.25), ("high", 0.75)]), ("top", [("roof", 0.5), ("ridge", 0.5)])]
    {
        let at = |place: &str| &single[&key("1998-03", place)];
        // The 7 means are followed by area, tilt, azimuth and energy.
        for (c, mean) in surfaces[&key("1998-03", surface)].iter().take(7).enumerate() {
            let expected = weight_a * at(a)[c] + weight_b * at(b)[c];
            assert!((mean - expected).abs() <= 2e-5 * expected, "{surface} {c}: {mean} {expected}");
        }
    }
    folder.write("few.csv", "receiver\nhigh\n");
    let (_, part) = table(&folder.run("replay site.helio -c conditions.csv --by surface --receivers few.csv"));
    let (_, all) = table(&folder.run("replay site.helio -c conditions.csv"));
    assert_eq!((part.len(), &part[&key("noon", "front")][..7]), (2, &all[&key("noon", "high")][..]));

    let query = "replay site.helio -c conditions.csv --by surface";
    for (rows, expected) in [
        ("a,5,5,10.02,0,0,1,1,\n", "input lacks site.helio surface"),
        ("a,5,5,10.02,0,0,1,1,top\nb,7,7,10.02,0,0,1,,top\n", "input lacks site.helio area"),
    ] {
        folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz,area,surface\n{rows}"));
        assert_eq!(folder.build().status.code(), Some(0));
        folder.fails(query, expected);
    }
}

/// Brighter ground adds reflected light and changes nothing else: constants, a schedule of twelve
/// equal months, and snow by albedo. Golden's three days have an albedo and no snow (a warning). 9
/// wrong requests end with exit code 2 and name what was found.
#[test]
fn brighter_ground_adds_reflected_light_only() {
    let folder = site();
    let year = |rest: &str| table(&replay(&folder, &format!("--every total -o - {rest}"))).1;
    let months = |value: f64| format!("reflectance\n{}", format!("{value}\n").repeat(12));
    folder.write("months.csv", &months(0.6));
    let (stored, constant) = (year(""), year("--reflectance ground=0.6"));
    assert_eq!(constant, year("--schedule ground=months.csv"));
    assert_eq!(constant, year("--schedule ground=months.csv --reflectance ground=0.1"));
    let albedo = year("--snow albedo");
    for (place, before) in &stored {
        for changed in [&constant[place], &albedo[place]] {
            assert_eq!((before[0], before[1]), (changed[0], changed[1]), "{place:?}");
        }
        if place.1 == "low" {
            assert!(constant[place][2] > 1.5 * before[2] && constant[place][3] > 1.5 * before[3], "{place:?}");
        }
    }
    let output = replay(&folder, "--every total -o - --snow depth");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(0) && said.contains("never has 1 cm of snow"), "{said}");

    folder.write("short.csv", "reflectance\n0.5\n");
    folder.write("bad.csv", &months(1.5));
    for (rest, expected) in [
        ("--reflectance lawn=0.5", "input unknown site.helio lawn"),
        ("--reflectance ground=1.5", "argument unreadable --reflectance ground=1.5"),
        ("--reflectance ground", "argument unreadable --reflectance ground"),
        ("--reflectance ground=x", "argument unreadable --reflectance ground=x"),
        ("--schedule ground=none.csv", "missing-file none.csv"),
        ("--schedule ground=short.csv", "input out-of-range short.csv 1.0"),
        ("--schedule ground=bad.csv", "input value bad.csv:2 reflectance 1.5"),
        ("--snow deep", "argument unknown --snow deep"),
        ("--snow-reflectance 0.5", "argument missing --snow"),
    ] {
        let weather = golden();
        folder.fails(&format!("replay site.helio --weather {} --every total -o - {rest}", weather.display()), expected);
    }
}

/// The bytes of all 6 formats do not depend on the number of threads, by receiver and by surface:
/// 12 pairs, and an array has its axes beside it.
#[test]
fn threads_change_nothing() {
    let folder = roof();
    for by in ["receiver", "surface"] {
        for ending in ["csv", "parquet", "arrow", "feather", "npy", "npz"] {
            let [one, two] = [1, 2].map(|threads| {
                let name = format!("{by}{threads}.{ending}");
                let replay = format!("replay site.helio --weather {} --by {by} -o {name}", golden().display());
                let output = folder.command(&replay).env("RAYON_NUM_THREADS", threads.to_string()).output();
                assert_eq!(output.expect("the program").status.code(), Some(0), "{name}");
                std::fs::read(folder.path(&name)).expect("a table")
            });
            assert!(one == two && one.len() > 2000, "{by} {ending} {} {}", one.len(), one == two);
        }
        let axes = std::fs::read_to_string(folder.path(&format!("{by}1.axes.json"))).expect("axes");
        let unit = if by == "receiver" { "\"W/m2\"" } else { "[\"W/m2\"," };
        assert!(axes.starts_with(&format!("{{\"axes\": [\"{by}\",\"time\",\"column\"], \"unit\": {unit}")), "{axes}");
    }
}
