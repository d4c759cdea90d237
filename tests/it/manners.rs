//! Behaviour towards users: files that are kept, names that are refused before any work, and the
//! amount of messages.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cli::{Folder, golden, stderr, stdout};
use crate::site::{houses, names};

/// Returns a folder with two houses and the weather of three days under a name of its own.
fn town() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", &houses(false));
    fs::copy(golden(), folder.path("golden.epw")).expect("copied");
    folder
}

const RUN: &str = "run a.obj --weather golden.epw --quality draft --spacing 5m";

fn good(folder: &Folder, arguments: &str) -> (String, String) {
    let output = folder.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    (stdout(&output), stderr(&output))
}

/// Returns all files below a folder with their bytes.
fn bytes(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    for name in names(folder) {
        let path = folder.join(name);
        match path.is_dir() {
            true => files.extend(bytes(&path)),
            false => files.push((path.clone(), fs::read(&path).expect("a file"))),
        }
    }
    files
}

/// Other spacing, accuracy, one setting, another scene, and an edited table of receivers: 5 runs
/// into a folder with other results are refused with the difference and a hint, and no byte of its
/// 8 files changes. `--replace` puts the new results there.
#[test]
fn results_of_other_inputs_are_kept() {
    let folder = town();
    good(&folder, RUN);
    let made = folder.path("a.sun");
    let before = bytes(&made);
    assert_eq!(before.len(), 8);
    let to_do = ["a.sun: holds results of other inputs", "--output FOLDER", "--replace"];
    let refused = |arguments: &str, parts: &[&str]| {
        folder.refused(arguments, &[&to_do, parts].concat());
        assert!(bytes(&made) == before, "{arguments}");
    };
    refused(&RUN.replace("5m", "4m"), &["receivers.csv differs from line", "the table of receivers now holds"]);
    refused(&RUN.replace("draft", "fine"), &["site.helio was built with --quality draft, not --quality fine\n"]);
    refused(&format!("{RUN} --set hit=64"), &["not --quality draft and hit=64"]);
    folder.write("b.obj", &houses(false).replace("v -99 -99 1", "v -98 -99 1"));
    refused(&format!("{} -o a.sun", RUN.replace("a.obj", "b.obj")), &["the scene or its materials have changed"]);
    let table = fs::read_to_string(made.join("receivers.csv")).expect("a table");
    let edited: String = table.lines().take(9).map(|line| format!("{line}\n")).collect();
    fs::write(made.join("receivers.csv"), &edited).expect("written");
    folder.refused(RUN, &["receivers.csv differs from line 10 on", "--receivers uses it as it is"]);
    assert_eq!(fs::read_to_string(made.join("receivers.csv")).ok().as_deref(), Some(edited.as_str()));

    let (said, _) = good(&folder, &format!("{} --replace -v", RUN.replace("5m", "4m")));
    assert!(said.contains(", root ") && !said.contains("up to date"), "{said}");
    let after = bytes(&made);
    assert!(after.iter().zip(&before).filter(|(a, b)| a.0 == b.0 && a.1 != b.1).count() == 8);
    let (said, _) = good(&folder, &RUN.replace("5m", "4m"));
    assert!(said.contains("up to date, nothing is traced again") && bytes(&made) == after, "{said}");
}

/// Each weather file has a folder of its own: a second one leaves the first's files alone. Another
/// file of the same name is refused before any work, and so is a folder that does not state its
/// source. A new archive warns of results of the old one.
#[test]
fn weather_is_kept_apart() {
    let folder = town();
    good(&folder, RUN);
    let made = folder.path("a.sun");
    let first = bytes(&made.join("golden"));
    fs::create_dir(folder.path("other")).expect("a folder");
    for name in ["pvgis.epw", "other/golden.epw"] {
        fs::copy(golden().with_file_name("pvgis_4_days.epw"), folder.path(name)).expect("copied");
    }
    let (said, _) = good(&folder, &RUN.replace("golden.epw", "pvgis.epw"));
    assert!(said.contains("pvgis/annual.csv, pvgis/annual.png"), "{said}");
    assert_eq!(names(&made), ["golden", "pvgis", "receivers.csv", "site.helio"]);
    assert!(bytes(&made.join("golden")) == first && first.len() == 6);
    let other = RUN.replace("golden.epw", "other/golden.epw");
    folder.fails(&other, "input other-inputs a.sun/golden");
    assert!(bytes(&made.join("golden")) == first);

    let (_, said) = good(&folder, &format!("{} --replace", RUN.replace("5m", "4m")));
    assert!(said.contains("results in a.sun/pvgis are of an earlier archive"), "{said}");
    fs::remove_file(made.join("pvgis/made-from.json")).expect("removed");
    let pvgis = RUN.replace("golden.epw", "pvgis.epw").replace("5m", "4m");
    folder.fails(&pvgis, "input exists a.sun/pvgis/annual.csv");
    fs::write(made.join("pvgis/made-from.json"), "{\"weather\": 7}").expect("written");
    folder.fails(&pvgis, "input other-kind a.sun/pvgis/made-from.json:1 not of heliotile");
}

/// `run --every month,day` writes the rows of `replay`: the shortest period to the byte, longer
/// ones, which are sums of these, to 0.001 kWh/m2; also by surface and as Parquet, under names that
/// say so.
#[test]
fn run_writes_the_tables_of_replay() {
    let folder = town();
    let (said, _) = good(&folder, &format!("{RUN} --every month,day"));
    assert!(said.contains("golden/months.csv, golden/days.csv"), "{said}");
    good(&folder, &format!("{RUN} --every hour --by surface --format parquet"));
    let made = folder.path("a.sun/golden");
    assert_eq!(
        names(&made),
        [
            "annual.csv",
            "annual.csv-metadata.json",
            "annual.png",
            "days.csv",
            "days.csv-metadata.json",
            "hours.surface.parquet",
            "index.html",
            "made-from.json",
            "months.csv",
            "months.csv-metadata.json",
            "months.svg"
        ]
    );
    for (every, name) in [("month", "months.csv"), ("day", "days.csv"), ("hour --by surface", "hours.surface.parquet")]
    {
        good(&folder, &format!("replay a.sun/site.helio --weather golden.epw --every {every} -o {name}"));
        let [ours, theirs] = [made.join(name), folder.path(name)].map(|path| fs::read(path).expect("a table"));
        // The end of a Parquet file states the command that wrote it.
        let same = if name.ends_with(".csv") { ours.len() } else { ours.len() / 2 };
        assert!(same > 500, "{name}");
        match every {
            "month" => assert!(are_near(&ours, &theirs), "{name}"),
            _ => assert!(ours[..same] == theirs[..same], "{name}"),
        }
    }
    // Results of replaced inputs are replaced, too.
    good(&folder, &format!("{} --replace", RUN.replace("5m", "4m")));
    assert_eq!(
        names(&made),
        ["annual.csv", "annual.csv-metadata.json", "annual.png", "index.html", "made-from.json", "months.svg"]
    );
}

/// Returns true if two tables have the same cells, numbers within 0.001.
fn are_near(ours: &[u8], theirs: &[u8]) -> bool {
    let cells = |bytes: &[u8]| String::from_utf8_lossy(bytes).split([',', '\n']).map(str::to_owned).collect::<Vec<_>>();
    let near = |(a, b): (&String, &String)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() < 1.001e-3,
        _ => a == b,
    };
    let (ours, theirs) = (cells(ours), cells(theirs));
    ours.len() == theirs.len() && ours.iter().zip(&theirs).all(near)
}

/// Options of the clock of `--weather` do not apply to `--error-weather`: with a shift of 3 hours
/// an archive keeps its bytes if errors are estimated under another file, and changes if they are
/// estimated under the same one. Both files are protected from being replaced.
#[test]
fn clock_options_leave_the_error_weather_alone() {
    let folder = town();
    fs::copy(golden().with_file_name("pvgis_4_days.epw"), folder.path("pvgis.epw")).expect("copied");
    let archive = |more: &str| {
        let run = "run a.obj --weather golden.epw --spacing 8m --error 30% --replace";
        good(&folder, &format!("{run} {more}"));
        fs::read(folder.path("a.sun/site.helio")).expect("an archive")
    };
    let shift = "--shift 3h";
    let other = "--error-weather pvgis.epw";
    assert!(archive(other) == archive(&format!("{other} {shift}")));
    fs::remove_dir_all(folder.path("a.sun")).expect("removed");
    let same = archive("--error-weather golden.epw");
    fs::remove_dir_all(folder.path("a.sun")).expect("removed");
    assert!(same != archive(&format!("--error-weather ./golden.epw {shift}")));
    let table = "a.sun/golden/annual.csv";
    let run = format!("run a.obj --weather golden.epw --replace --error 30% --error-weather {table}");
    fs::copy(folder.path("pvgis.epw"), folder.path(table)).expect("copied");
    folder.fails(&run, &format!("input same-file {table} {table}"));
}

/// `run --every month,hour --year 2019` gives its tables that year, as `replay` does: hours to the
/// byte, months, which `replay` sums without hours, within 0.001 kWh/m2. It does not advise the
/// year again, and hours are labelled with their end. The commands that it prints at the end quote
/// a path with a blank, and leave out what was done.
#[test]
fn run_gives_its_tables_the_stated_year() {
    let folder = town();
    fs::rename(folder.path("golden.epw"), folder.path("my golden.epw")).expect("renamed");
    let run = |more: &str| {
        let mut command = folder.command("run a.obj --quality draft --spacing 8m --weather");
        let output = command.arg("my golden.epw").args(more.split_whitespace()).output().expect("the program");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (stdout(&output), stderr(&output))
    };
    let (said, _) = run("");
    let replay = "heliotile replay a.sun/site.helio --weather 'my golden.epw'";
    assert!(said.contains(&format!("the same command with --every month, or {replay} --every hour")), "{said}");
    let (said, noted) = run("--every month,hour --year 2019 --stamp end");
    assert!(said.contains(&format!("\nother periods: {replay} --year 2019 --every hour")), "{said}");
    assert!(!noted.contains("--year"), "{noted}");
    let made = folder.path("a.sun/my golden");
    let table = |name: &str| fs::read_to_string(made.join(name)).expect("a table");
    let months: Vec<String> = table("months.csv").lines().skip(1).map(|line| line.chars().take(5).collect()).collect();
    assert!(!months.is_empty() && months.iter().all(|month| month == "2019-"), "{months:?}");
    for (every, name) in [("month", "months.csv"), ("hour", "hours.csv")] {
        let mut command = folder.command("replay a.sun/site.helio --year 2019 --stamp end -o same.csv --every");
        command.args([every, "--weather", "my golden.epw"]).output().expect("the program");
        let (same, ours) = (fs::read(folder.path("same.csv")).expect("a table"), table(name).into_bytes());
        assert!(if every == "hour" { same == ours } else { are_near(&same, &ours) }, "{name}");
    }
    assert!(table("hours.csv").contains("T13:00") && table("hours.csv").contains("T00:00"));
    folder.fails("run a.obj --weather b.epw --year 2019", "argument missing --every");
}

/// 14 impossible names of outputs are refused before anything is read, and no file is written.
#[test]
fn output_extensions_are_checked_first() {
    let folder = Folder::new();
    folder.build();
    let before = names(&folder.path(""));
    let build = "build none.obj -m materials.toml -r receivers.csv -o";
    folder.fails(&format!("{build} m.obj"), "input ending m.obj");
    folder.fails(&format!("{build} m"), "input ending m");
    folder.fails(&format!("{build} no/such/m.helio"), "input lacks no/such/m.helio folder");
    folder.fails(&format!("{build} scene.obj/m.helio"), "input lacks scene.obj/m.helio folder");
    folder.fails("archive extract none.helio --surface a -o m.csv", "input ending m.csv");
    folder.fails("archive merge none.helio none.helio -o m.zip", "input ending m.zip");
    folder.fails("archive repair none.helio scene.obj -o m.bin", "input ending m.bin");
    folder.fails("receivers none.obj -o m.xlsx", "input ending m.xlsx");
    folder.fails("receivers none.obj --buried m.txt", "input ending m.txt");
    folder.fails("replay none.helio -c conditions.csv -o m.xlsx", "unsupported `m.xlsx`");
    folder.fails("replay none.helio -w none.epw -o no/such/m.csv", "input lacks no/such/m.csv folder");
    folder.fails("run none.obj -w none.epw -o m.csv", "input ending m.csv");
    folder.fails("tradeoff none.obj -r none.csv -o m.html", "input ending m.html");
    folder.fails("export site.helio --view-factors -o no/such/m.csv", "input lacks no/such/m.csv folder");
    // An existing file is refused as the kind that it is, also by `repair`.
    folder.fails("archive repair site.helio scene.obj -o conditions.csv", "input exists conditions.csv");
    assert_eq!(names(&folder.path("")), before);
}

/// 13 files that are given in place of another kind are named with their kind, and with the command
/// that takes them.
#[test]
fn files_of_another_kind_are_named_with_their_kind() {
    let folder = town();
    folder.build();
    ["hills.tif.gz", "m.hbjson", "hills.asc"].iter().for_each(|name| folder.write(name, "{}"));
    for (arguments, parts) in [
        ("run golden.epw -w golden.epw", ["golden.epw: is weather (EPW), not a scene", "--weather golden.epw"]),
        ("run a.obj golden.epw -w golden.epw", ["golden.epw: is weather (EPW)", "--weather golden.epw"]),
        ("run site.helio -w golden.epw", ["is an archive of heliotile, not a scene", "heliotile replay site.helio"]),
        ("run a.obj -w a.obj", ["a.obj: is a scene (OBJ), not weather", "heliotile run a.obj --weather"]),
        ("run a.obj -w hills.tif.gz", ["hills.tif.gz: is a scene (TIFF), not weather", "heliotile run hills.tif.gz"]),
        ("run a.obj -w m.hbjson", ["m.hbjson: is a scene (Honeybee), not weather", "heliotile run m.hbjson"]),
        ("replay hills.asc -w golden.epw", ["is a scene (ASCII grid), not an archive", "heliotile run hills.asc"]),
        ("replay a.obj -w golden.epw", ["is a scene (OBJ), not an archive", "heliotile run a.obj"]),
        ("replay golden.epw -w golden.epw", ["is weather (EPW), not an archive", "--weather golden.epw"]),
        ("replay site.helio -c golden.epw", ["not a table of conditions", "heliotile replay SITE.helio --weather"]),
        ("build a.obj -r a.obj -o b.helio", ["not a table of receivers", "heliotile receivers a.obj"]),
        ("build a.obj -r conditions.csv -o b.helio", ["is a table of conditions", "heliotile replay"]),
        ("info receivers.csv", ["is a table of receivers, not an archive or a scene", "--receivers receivers.csv"]),
    ] {
        folder.refused(arguments, &parts);
    }
}

/// For a missing file the message names a similar file, 6 of 6, or the missing folder; if no name
/// is similar, none is proposed. A command that does not come first gets a hint on the order.
#[test]
fn missing_files_are_answered_with_a_similar_name() {
    let folder = town();
    folder.refused("run a.obj -w golden.csv", &["golden.csv: No such file", "did you mean golden.epw?"]);
    folder.refused("run a.obj -w Goldn.epw", &["did you mean golden.epw?"]);
    folder.refused(
        "build scenes.obj -r receivers.csv -o b.helio",
        &["scenes.obj: No such file", "did you mean scene.obj?"],
    );
    folder.refused("run a.obj -w weather/golden.epw", &["there is no folder `weather` in ."]);
    let output = folder.run("run a.obj -w zzz.epw");
    assert!(!stderr(&output).contains("did you mean"), "{}", stderr(&output));
    let replay = "replay site.helio -w golden.epw";
    folder.build();
    for option in ["--schedule grass=scne.obj", "--transmittance tree=scne.obj", "--temperature ground=scne.obj"] {
        folder
            .refused(&format!("{replay} {option}"), &["cannot read scne.obj: No such file", "did you mean scene.obj?"]);
    }
    folder.refused("a.obj --weather golden.epw", &["a command comes first, such as heliotile run a.obj --weather"]);
    folder.refused("a.obj run --weather golden.epw", &["the command comes first", "heliotile run ..."]);
}

/// `--quiet` leaves the table of sums and the warnings; `-v` shows the 5 materials that one warning
/// counts; `--threads` changes no byte.
#[test]
fn quiet_and_verbose_change_messages_only() {
    let folder = town();
    let (said, warned) = good(&folder, &format!("{RUN} --quiet"));
    assert!(said.trim_start().starts_with("Irradiation through golden.epw"), "{said}");
    assert!(!said.contains("root") && !said.contains("site.helio"), "{said}");
    assert!(warned.lines().all(|line| line.starts_with("warning: ")) && !warned.is_empty(), "{warned}");
    let (said, _) = good(&folder, "build scene.obj -m materials.toml -r receivers.csv -o site.helio -q");
    assert_eq!(said, "");

    let faces: String = (0..5).map(|i| format!("v {i} 0 0\nv {i} 9 0\nv {i} 0 9\nusemtl m{i}\nf -1 -2 -3\n")).collect();
    folder.write("many.obj", &faces);
    let about = |more: &str| good(&folder, &format!("info many.obj --no-ground {more}")).1;
    let short = about("");
    assert!(short.contains("how much light 5 materials reflect") && short.contains("(-v lists them)"), "{short}");
    assert_eq!((short.lines().count(), short.matches("`m").count()), (1, 0), "{short}");
    let long = about("-v");
    assert_eq!((long.lines().count(), long.matches("\n  `m").count()), (6, 5), "{long}");
    folder.fails("info many.obj -v -q", "argument excludes --verbose --quiet");

    let build = "build scene.obj -m materials.toml -r receivers.csv";
    good(&folder, &format!("--threads 1 {build} -o one.helio"));
    good(&folder, &format!("{build} -o two.helio --threads 2"));
    assert!(fs::read(folder.path("one.helio")).ok() == fs::read(folder.path("two.helio")).ok());
    let (said, _) = good(&folder, "build --dry-run scene.obj -m materials.toml -r receivers.csv --threads 3");
    assert!(said.contains("3 threads"), "{said}");
    folder.fails(&format!("{build} -o x.helio --threads 0"), "argument other --threads 0");
}

/// README's first command prints at most 25 lines in a pipe: its table, its files, and last 2
/// warnings and a note. None is progress. With `-v` effects and the root come too.
#[test]
fn readmes_first_command_prints_results_and_then_assumptions() {
    let folder = Folder::new();
    let data = Path::new(crate::ROOT).join("tests/data");
    let run = |more: &str| {
        let script = format!(
            "exec 2>&1; \"$0\" run \"$1/cityjson/hague.city.json\" --weather \"$1/weather/golden_tmy3.epw\" {more}"
        );
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_heliotile")]).arg(&data).current_dir(folder.path(""));
        let output = command.output().expect("a shell");
        assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
        stdout(&output)
    };
    let said = run("");
    let is_last = |line: &&str| line.starts_with("warning: ") || line.starts_with("note: ");
    let lines: Vec<&str> = said.trim().lines().collect();
    let last = lines.iter().rev().take_while(|line| is_last(line)).count();
    assert!(lines.len() <= 25, "{said}");
    assert_eq!((last, lines.iter().filter(|line| is_last(line)).count()), (3, 3), "{said}");
    assert!(lines[lines.len() - 3..].iter().all(|line| line.contains("--")), "{said}");
    for detail in ["get light", "effect  ", "Mray", "root ", " s: tree", " % (", " so far"] {
        assert!(!said.contains(detail), "{detail}: {said}");
    }
    let said = run("-v --replace --quality draft");
    for detail in ["get light", "effect  ", "Mray", ", root ", " s: tree"] {
        assert!(said.contains(detail), "{detail}: {said}");
    }
}

/// A spacing of 1 mm is refused with the one that gives at most 100 million receivers, and that one
/// is accepted. So are too many receivers on each surface. If no surface is large enough the
/// message says so.
#[test]
fn a_refused_spacing_comes_with_one_that_fits() {
    let folder = town();
    let output = folder.run("receivers a.obj --on all --spacing 1mm -o x.csv");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("--spacing: 0.001 m would give 40404 million receivers on 40404 m2 of surfaces, and the limit is 100 million"), "{said}");
    let proposed =
        said.split("--spacing ").nth(1).and_then(|text| text.split("m would give ").next()).expect("a spacing");
    let metres: f64 = proposed.parse().expect("a number");
    // 198 x 198 m of meadow, and 1,200 m2 of houses with both sides of the wall between them.
    assert!((40_404.0 / (metres * metres)) <= 100e6 && (40_404.0 / (metres - 0.001).powi(2)) > 100e6, "{said}");
    assert!(said.contains("million, or cover less with --on"), "{said}");
    folder.fails(
        "receivers a.obj --on all --per-surface 1000000 --min-area 0 -o x.csv --spacing 1m",
        "argument excludes --per-surface --spacing",
    );
    let none = "receivers a.obj --on wall --min-area 1000 -o x.csv";
    folder.refused(none, &["no receiver is left: ", "lower --min-area"]);
    assert!(!folder.path("x.csv").exists());
}

/// For semicolons, tabs and decimal commas in tables of receivers and conditions, 4 of 4, the
/// message says what to write instead.
#[test]
fn semicolons_and_decimal_commas_are_explained() {
    let folder = Folder::new();
    folder.build();
    let table = |separator: &str| "receiver,x,y,z,nx,ny,nz\nroof,5,5,10.02,0,0,1\n".replace(',', separator);
    let build = "build scene.obj -m materials.toml -r r.csv -o b.helio";
    folder.write("r.csv", &table(";"));
    folder.refused(build, &["r.csv, line 1", "commas in place of semicolons", "1.5 in place of 1,5"]);
    folder.write("r.csv", &table("\t"));
    folder.refused(build, &["commas in place of tabs"]);
    folder.write("r.csv", &table(",").replace("10.02", "10,02"));
    folder.refused(build, &["r.csv, line 2", "has 8 cells, the header 7", "decimals with a point: 1,5 is two cells"]);
    let conditions = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,50,800,100\n";
    folder.write("c.csv", &conditions.replace(',', ";"));
    folder.refused("replay site.helio -c c.csv", &["c.csv, line 1", "commas in place of semicolons"]);
}

/// 5 shells get a script that names all commands, bash parses its own, and 33 pages of the manual
/// begin as man pages do.
#[test]
fn completions_and_manual_cover_all_commands() {
    let folder = Folder::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let (script, _) = good(&folder, &format!("--completions {shell}"));
        for word in ["replay", "tradeoff", "spacing", "quiet"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
        folder.write(shell, &script);
    }
    let checked = Command::new("bash").arg("-n").arg(folder.path("bash")).status().expect("bash");
    assert!(checked.success());
    folder.fails("--completions tcsh", "argument unknown --completions tcsh");

    let (said, _) = good(&folder, "--man deep/pages");
    let pages = names(&folder.path("deep/pages"));
    assert_eq!(pages.len(), 34, "{pages:?}");
    assert!(said.contains("34 pages"), "{said}");
    for page in &pages {
        let text = fs::read_to_string(folder.path("deep/pages").join(page)).expect("a page");
        assert!(text.contains(".TH ") && text.contains(".SH NAME"), "{page}");
    }
    let page = fs::read_to_string(folder.path("deep/pages/heliotile-run.1")).expect("a page");
    assert!(page.contains("\\-\\-spacing") && page.contains("\\-\\-quiet"), "{page}");
}
