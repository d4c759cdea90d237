//! Times of results and their provenance: zones, years, stamps, provenance in every file.

use std::fs;
use std::path::Path;

use heliotile_core::weather::time::calendar::Date;

use crate::cli::{Folder, golden, stderr, stdout};
use crate::weather::{data, days, epw, replay};

/// Returns the first cells of a table's rows of one receiver.
fn labels(table: &str, receiver: &str) -> Vec<String> {
    let rows = table.lines().skip(1).filter_map(|line| line.split_once(','));
    rows.filter(|(_, rest)| rest.starts_with(&format!("{receiver},"))).map(|(label, _)| label.to_string()).collect()
}

/// Returns a table without its first column.
fn values(table: &str) -> Vec<&str> {
    table.lines().skip(1).filter_map(|line| line.split_once(',')).map(|(_, rest)| rest).collect()
}

/// Under a constant DNI a horizontal receiver gets most in the hour of solar noon, 12 h -
/// (longitude / 15 - zone) - equation of time: in Sydney's summer, The Hague's and Golden's, in
/// Pune at +05:30 and in Darwin at +09:30; 5 of 5, each with its offset.
#[test]
fn noon_is_in_the_right_hour() {
    // The equation of time, minutes: +2 on 21 December, -2 on 21 June (Meeus, "Astronomical
    // algorithms", 1998, chapter 28).
    for (place, longitude, zone, month, equation_min, offset) in [
        ("-33.87,151.21,10", 151.21, 10.0, 12, 2.0, "+10:00"),
        ("52.08,4.3,1", 4.3, 1.0, 6, -2.0, "+01:00"),
        ("39.74,-105.18,-7", -105.18, -7.0, 6, -2.0, "-07:00"),
        ("18.52,73.86,5.5", 73.86, 5.5, 12, 2.0, "+05:30"),
        ("-12.46,130.84,9.5", 130.84, 9.5, 12, 2.0, "+09:30"),
    ] {
        let date = Date::new(2019, month, 21).expect("a date");
        let light = |_, hour| if (5..20).contains(&hour) { [9999.0, 500.0, 50.0] } else { [0.0; 3] };
        let (rows, _) = replay(&epw(place, &[date], light), "--steps 12");
        let up = rows.iter().filter(|((_, id), _)| id == "up");
        let brightest = up.max_by(|a, b| a.1[0].total_cmp(&b.1[0])).map(|((label, _), _)| label.as_str());
        let noon_h = 12.0 - (longitude / 15.0 - zone) - equation_min / 60.0;
        let expected = format!("2019-{month:02}-21T{:02}:00{offset}", noon_h as u32);
        assert_eq!(brightest, Some(expected.as_str()), "{place}, noon at {noon_h:.2}");
    }
}

/// A typical year keeps the years of its months, 1991 to 2004, and one note says so. `--year 2019`
/// puts its 8760 hours into one year, in order and without gaps, and 2020 lacks the 24 hours of 29
/// February with one warning. The values are the same bytes. Days and months of a typical year get
/// dates, and `--from` accepts them.
#[test]
fn a_typical_year_is_put_into_one_year_on_request() {
    let folder = Folder::new();
    folder.build();
    let year = data("golden_tmy3.epw");
    let replay = |rest: &str| {
        let output = folder.run(&format!("replay site.helio --columns total --weather {} {rest}", year.display()));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (stdout(&output), stderr(&output))
    };
    let (mixed, said) = replay("");
    assert!(
        said.lines().count() == 1 && said.contains("years, 1991 to 2004") && said.contains("--year 2019"),
        "{said}"
    );
    assert_eq!(labels(&mixed, "roof")[0], "1999-01-01T00:00-07:00");
    for (year, odd) in [(2019, 0), (2020, 1)] {
        let (put, said) = replay(&format!("--year {year}"));
        assert_eq!((values(&put) == values(&mixed), said.lines().count()), (true, odd), "{said}");
        let labels = labels(&put, "roof");
        let hours = days(year, 0).into_iter().filter(|d| year == 2019 || (d.month, d.day) != (2, 29));
        let hours = hours.flat_map(|date| (0..24).map(move |hour| format!("{}-07:00", date.label(60 * hour))));
        assert_eq!(labels.len(), 8760);
        assert!(labels.into_iter().eq(hours), "{year}");
    }
    let (months, said) = replay("--year 2019 --every month");
    assert_eq!((labels(&months, "roof")[11].as_str(), said.as_str()), ("2019-12", ""));
    let (words, said) = replay("--every month");
    assert_eq!((labels(&words, "roof")[11].as_str(), values(&words)), ("12", values(&months)));
    assert!(said.contains("days and months show no year"), "{said}");
    assert_eq!(replay("--every total").1, "");
    let (day, _) = replay("--year 2019 --from 2019-07-04 --to 2019-07-04");
    assert_eq!((labels(&day, "roof").len(), labels(&day, "roof")[0].as_str()), (24, "2019-07-04T00:00-07:00"));
}

/// 29 February of 2020 is left out of 2019, 24 of 8784 hours, with one warning; wrong years are
/// refused, 3 of 3.
#[test]
fn leap_days_are_left_out_of_other_years() {
    let leap =
        epw("40,-105,-7", &days(2020, 0), |_, hour| [9999.0, 0.0, if (9..15).contains(&hour) { 10.0 } else { 0.0 }]);
    let (rows, said) = replay(&leap, "--year 2019");
    assert_eq!(rows.keys().filter(|(_, id)| id == "up").count(), 8760);
    assert!(
        said.contains("29 February is left out, because 2019 has no such day: 24 of 8784 rows")
            && said.lines().count() == 1,
        "{said}"
    );
    let (rows, said) = replay(&leap, "--every day --year 2024");
    assert_eq!((rows.keys().filter(|(_, id)| id == "up").count(), said.as_str()), (366, ""));
    let folder = Folder::new();
    folder.build();
    let replay = format!("replay site.helio --weather {}", golden().display());
    folder.fails(&format!("{replay} --year 0"), "argument out-of-range --year 0.0");
    folder.fails(&format!("{replay} --year 2019 --to 1998-03-20"), "input lacks golden_3_days.epw hours");
    let two: Vec<Date> = [2007, 2008].iter().filter_map(|year| Date::new(*year, 1, 1)).collect();
    folder.write(
        "two.epw",
        &epw("40,-105,-7", &two, |_, _| [9999.0, 0.0, 10.0]).replace("DATA PERIODS,1,", "DATA PERIODS,2,"),
    );
    folder.fails("replay site.helio --weather two.epw --year 2019", "input lacks two.epw year");
}

/// The last of 72 hours is labelled 23:00, 23:30 or 00:00 of the next day; sums of days are
/// labelled alike by all three.
#[test]
fn stamps_label_the_start_middle_or_end() {
    let folder = Folder::new();
    folder.build();
    let run = |rest: &str| stdout(&folder.run(&format!("replay site.helio --weather {} {rest}", golden().display())));
    for (stamp, last) in [("start", "22T23:00"), ("middle", "22T23:30"), ("end", "23T00:00")] {
        let labels = labels(&run(&format!("--stamp {stamp}")), "roof");
        assert_eq!((labels.len(), labels[71].as_str()), (72, format!("1998-03-{last}-07:00").as_str()));
        assert_eq!(run(&format!("--stamp {stamp} --every day")), run("--every day"));
    }
    folder.fails(&format!("replay site.helio -w {} --stamp noon", golden().display()), "argument unknown --stamp noon");
}

/// Returns the bytes of a file without the zeros of UTF-32, as text.
fn text_of(path: &Path) -> String {
    let bytes: Vec<u8> = fs::read(path).expect("a file").into_iter().filter(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Each of 10 files, or the one beside it, names the archive's root, the program's version and the
/// command; 8 name the weather too. Neither the output's name nor the memory changes a byte.
#[test]
fn every_file_states_its_sources() {
    let folder = Folder::new();
    folder.build();
    let info = stdout(&folder.run("info site.helio"));
    let root = info.lines().find_map(|line| line.trim().strip_prefix("root        ")).expect("a root").to_string();
    let weather = golden();
    let replay = format!("replay site.helio --weather {}", weather.display());
    let export = "export site.helio";
    for (command, name, said_in) in [
        (replay.as_str(), "t.parquet", "t.parquet"),
        (&replay, "t.arrow", "t.arrow"),
        (&replay, "t.feather", "t.feather"),
        (&replay, "t.npz", "t.npz"),
        (&replay, "t.npy", "t.axes.json"),
        (&replay, "t.csv", "t.csv-metadata.json"),
        (&format!("{export} -r south --weather {}", weather.display()), "t.png", "t.png"),
        (&format!("{export} -r south"), "t.exr", "t.exr"),
        (&format!("{export} --view-factors"), "v.csv", "v.csv-metadata.json"),
    ] {
        let output = folder.run(&format!("{command} -o {name}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let text = text_of(&folder.path(said_in));
        let verb = command.split(' ').next().unwrap_or_default();
        let of_weather = command.contains("--weather");
        assert!(text.contains(&root) && text.contains("heliotile.version"), "{name}");
        assert!(text.contains(&format!("heliotile {verb} site.helio")), "{name}");
        assert_eq!(text.contains("heliotile.weather_place"), of_weather, "{name}");
        let before = fs::read(folder.path(said_in)).expect("a file");
        let other = if said_in == name { format!("other.{name}") } else { name.to_string() };
        assert_eq!(folder.run(&format!("{command} --memory 1GiB -o {other}")).status.code(), Some(0));
        let again = if said_in == name { other } else { said_in.to_string() };
        assert!(before == fs::read(folder.path(&again)).expect("a file"), "{name}");
    }
    let run =
        format!("run scene.obj -m materials.toml --weather {} --quality draft --map ply -o out", weather.display());
    assert_eq!(folder.run(&run).status.code(), Some(0));
    for name in ["out/golden_3_days/annual.ply", "out/golden_3_days/annual.csv-metadata.json"] {
        let text = text_of(&folder.path(name));
        assert!(text.contains("heliotile.archive_root") && text.contains("heliotile.weather_place"), "{name}");
    }
    let head = text_of(&folder.path("out/golden_3_days/annual.ply"));
    assert!(head.contains("\ncomment heliotile.weather golden_3_days.epw\n"));
    // Options are resolved as in `replay`: to the values of a draft.
    let options = head.lines().find(|line| line.starts_with("comment heliotile.options")).unwrap_or_default();
    assert!(options.contains("\"patches\":145") && options.contains("\"steps\":6"), "{options}");
    // The file states the shift that was found, not the word `auto`.
    let moved = format!("replay site.helio --weather {} --shift auto -o m.csv", data("pvgis_4_days.epw").display());
    assert_eq!(folder.run(&moved).status.code(), Some(0));
    let about = text_of(&folder.path("m.csv-metadata.json"));
    assert!(about.contains("40min"), "{about}");
}

/// The file beside a CSV file replaces no input: of a query and of an export, 2 of 2 are refused,
/// and no file lies beside the standard output.
#[test]
fn a_file_beside_a_table_replaces_no_input() {
    let folder = Folder::new();
    folder.build();
    folder.write("t.csv-metadata.json", "receiver\nroof\n");
    let query = "replay site.helio -c conditions.csv";
    folder.fails(
        &format!("{query} --receivers t.csv-metadata.json -o t.csv"),
        "input same-file t.csv-metadata.json t.csv-metadata.json",
    );
    fs::copy(folder.path("site.helio"), folder.path("v.csv-metadata.json")).expect("copied");
    folder.fails(
        "export v.csv-metadata.json --view-factors -o v.csv",
        "input same-file v.csv-metadata.json v.csv-metadata.json",
    );
    let count = || fs::read_dir(folder.path(".")).expect("a folder").count();
    let before = count();
    assert_eq!(folder.run(&format!("{query} -o -")).status.code(), Some(0));
    assert_eq!(count(), before);
}

/// P90 of eleven years of one day each, with DHI from 100 to 200 W/m2 in a mixed order, is the sum
/// of the second darkest, P50 that of the sixth and P10 that of the second brightest, in tables of
/// receivers and of surfaces; a twelfth year of half a day is left out. Typical years, months and
/// changes have no percentiles.
#[test]
fn percentiles_of_years_are_those_of_their_sums() {
    let folder = Folder::new();
    folder.write("receivers.csv", "receiver,x,y,z,nx,ny,nz,surface\na,15,5,0.02,0,0,1,lawn\nb,13,5,0.02,0,0,1,lawn\n");
    folder.build();
    let mut weather = String::from("time,ghi,dni,dhi\n");
    for year in 0..12 {
        let dhi = 100 + 10 * (year * 7 % 11);
        let hours = if year == 11 { 0..12 } else { 0..24 };
        for hour in hours {
            let light = if (8..16).contains(&hour) { dhi } else { 0 };
            weather.push_str(&format!("{}-06-21T{hour:02}:00Z,{light},0,{light}\n", 2001 + year));
        }
    }
    fs::write(folder.path("w.csv"), weather).expect("a file");
    for by in ["receiver", "surface"] {
        let replay = |rest: &str| {
            let words = format!(
                "replay site.helio --columns total,sky_direct --weather w.csv --by {by} --latitude 52 --longitude 5 {rest}"
            );
            let output = folder.run(&words);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            (stdout(&output), stderr(&output))
        };
        let total = |table: &str, label: &str, place: &str| -> f64 {
            let found = table.lines().find_map(|line| line.strip_prefix(&format!("{label},{place},")));
            found.and_then(|rest| rest.split(',').next()?.parse().ok()).expect("a number")
        };
        let ((years, _), (few, told)) = (replay("--every year"), replay("--every year --percentiles"));
        assert!(told.contains("percentiles of 11 years, 2001 to 2011; 1 incomplete year left out"), "{told}");
        let places: Vec<&str> = few.lines().skip(1).filter_map(|line| line.split(',').nth(1)).take(1).collect();
        assert_eq!(few.lines().count() - 1, 3 * (years.lines().count() - 1) / 12, "{few}");
        let mut sums: Vec<f64> = (2001..2012).map(|year| total(&years, &year.to_string(), places[0])).collect();
        sums.sort_by(f64::total_cmp);
        for (label, right) in [("P90", sums[1]), ("P50", sums[5]), ("P10", sums[9])] {
            let found = total(&few, label, places[0]);
            assert!((found / right - 1.0).abs() < 1e-4 && right > 0.1, "{label}: {found} {right}");
        }
    }
    let year = data("golden_tmy3.epw");
    for (words, told) in [
        (
            "replay site.helio --weather w.csv --latitude 52 --longitude 5 --every month --percentiles".into(),
            "are those of years",
        ),
        (format!("replay site.helio --weather {} --every year --percentiles", year.display()), "has 1 complete year"),
        ("compare site.helio site.helio --weather w.csv --every year --percentiles".into(), "--percentiles"),
    ] {
        let output = folder.run(&words);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(told), "{}", stderr(&output));
    }
}

/// The EPW files of June of three years in a folder are one series, whatever their names: its sums
/// by year are those of the files, its percentiles lie between them, and tables name each file. A
/// file of another place, a folder without EPW files, and a folder where one file is read are
/// refused.
#[test]
fn a_folder_of_years_is_one_series() {
    let folder = Folder::new();
    folder.write("receivers.csv", "receiver,x,y,z,nx,ny,nz,surface\na,15,5,0.02,0,0,1,lawn\n");
    folder.build();
    fs::create_dir(folder.path("years")).expect("a folder");
    let write = |name: &str, place: &str, year: i32, dhi: f64| {
        let text = epw(place, &days(year, 6), |_, hour| [9999.0, 0.0, if (8..16).contains(&hour) { dhi } else { 0.0 }]);
        fs::write(folder.path(name), text).expect("a file");
    };
    write("years/a.epw", "52,5,0", 2003, 100.0);
    write("years/b.epw", "52,5,0", 2001, 300.0);
    write("years/c.EPW", "52,5,0", 2002, 200.0);
    fs::write(folder.path("years/notes.txt"), "of one station").expect("a file");
    let rows = |rest: &str| -> Vec<String> {
        let output = folder.run(&format!("replay site.helio --columns total --every year --weather {rest}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output).lines().skip(1).map(str::to_owned).collect()
    };
    let of_files: Vec<String> =
        ["b.epw", "c.EPW", "a.epw"].iter().flat_map(|name| rows(&format!("years/{name}"))).collect();
    assert_eq!((rows("years"), of_files.len()), (of_files.clone(), 3));
    let total = |row: &String| -> f64 { row.rsplit(',').next().and_then(|cell| cell.parse().ok()).expect("a number") };
    let found: Vec<f64> = rows("years --percentiles").iter().map(total).collect();
    let [third, second, first] = [0, 1, 2].map(|row| total(&of_files[row]));
    let right = [first + 0.2 * (second - first), second, second + 0.8 * (third - second)];
    assert!(found.iter().zip(right).all(|(found, right)| (found / right - 1.0).abs() < 1e-4), "{found:?} {right:?}");
    rows("years -o sums.csv");
    let about = fs::read_to_string(folder.path("sums.csv-metadata.json")).expect("a file");
    assert!(["a.epw", "b.epw", "c.EPW"].iter().all(|name| about.contains(&format!("years/{name}"))), "{about}");
    folder.fails("info --weather years", "input other-kind years a folder");
    folder.fails("run scene.obj --weather years", "argument other-kind --weather a folder");
    write("years/d.epw", "40,-105,-7", 2004, 100.0);
    folder.refused("replay site.helio --weather years", &["d.epw: is of another place than years/a.epw"]);
    folder.refused("replay site.helio --weather .", &["holds no .epw"]);
}
