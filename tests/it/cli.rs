//! The command line: names and columns that stay stable, exit codes, messages that a user can act
//! on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A scratch folder with a small valid site: a 10 m cube on a 60 m square, three receivers, two
/// conditions.
pub struct Folder(TempDir);

const SCENE: &str = "\
v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 0 0 10\nv 10 0 10\nv 10 10 10\nv 0 10 10\n\
usemtl wall\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nusemtl roof\nf 5 6 7 8\n\
v -30 -30 0\nv 30 -30 0\nv 30 30 0\nv -30 30 0\nusemtl grass\nf -4 -3 -2 -1\n";
const MATERIALS: &str = "[wall]\ndiffuse = 0.4\n[roof]\ndiffuse = 0.2\n[grass]\ndiffuse = 0.25\n";
const RECEIVERS: &str = "receiver,x,y,z,nx,ny,nz\nroof,5,5,10.02,0,0,1\nsouth,5,-0.02,4,0,-1,0\nlawn,15,5,0.02,0,0,2\n";
const CONDITIONS: &str =
    "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,50,800,100\novercast,180,30,0,200\n";

impl Folder {
    pub fn new() -> Self {
        let folder = Folder(tempfile::tempdir().expect("a scratch folder"));
        folder.write("scene.obj", SCENE);
        folder.write("materials.toml", MATERIALS);
        folder.write("receivers.csv", RECEIVERS);
        folder.write("conditions.csv", CONDITIONS);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("a writable folder");
    }

    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command
    }

    /// Runs a command. No message of it holds a name in braces that a face has a word for.
    pub fn run(&self, arguments: &str) -> Output {
        let output = self.command(arguments).output().expect("the program");
        let said = stderr(&output);
        assert_eq!(bare(&said), [] as [&str; 0], "{arguments}: {said}");
        output
    }

    pub fn build(&self) -> Output {
        self.run("build scene.obj --materials materials.toml --receivers receivers.csv -o site.helio")
    }

    /// Checks that a command fails with an error; see [`failure`].
    #[track_caller]
    pub fn fails(&self, arguments: &str, expected: &str) {
        assert_eq!(failure(&mut self.command(arguments)), expected, "{arguments}");
    }

    /// Runs a command that must fail with exit code 2 and a message that holds every one of
    /// `parts`.
    pub fn refused(&self, arguments: &str, parts: &[&str]) {
        let output = self.run(arguments);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {message}");
        for part in parts {
            assert!(message.contains(part), "{arguments}: `{part}` is not in: {message}");
        }
        assert!(!message.contains("panicked") && message.matches("to fix: ").count() <= 1, "{message}");
    }
}

/// Runs a command that must fail with exit code 2. Returns its error as `HELIOTILE_ERRORS=json`
/// states it: kind, problem, options or file and line, and what was found, as in
/// `input value r.csv:2 ny nan`. An absolute path loses its folders.
pub fn failure(command: &mut Command) -> String {
    let output = command.env("HELIOTILE_ERRORS", "json").output().expect("the program");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{command:?}: {said}");
    let facts: serde_json::Value = serde_json::from_str(said.lines().last().unwrap_or_default()).expect(&said);
    assert!(bare(&said).is_empty() && facts["message"].as_str().is_some_and(|text| !text.is_empty()), "{said}");
    let words = |name: &str| match &facts[name] {
        serde_json::Value::Null => None,
        serde_json::Value::String(word) if word.starts_with('/') => word.rsplit('/').next().map(str::to_owned),
        serde_json::Value::String(word) => Some(word.clone()),
        serde_json::Value::Array(words) => {
            Some(words.iter().filter_map(|word| word.as_str()).collect::<Vec<_>>().join(","))
                .filter(|all| !all.is_empty())
        }
        other => Some(other.to_string()),
    };
    let line = words("line").map_or(String::new(), |line| format!(":{line}"));
    let [kind, problem, fields, file, block, name, found, others] =
        ["kind", "problem", "fields", "file", "block", "name", "found", "others"].map(words);
    let place = file.map(|file| file + &line);
    [kind, problem, fields, place, block, name, found, others].into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// Returns the names in braces for which a face has a word.
fn bare(said: &str) -> Vec<&str> {
    let names = said.split('{').skip(1).filter_map(|behind| Some(behind.split_once('}')?.0));
    names.filter(|name| name.starts_with("command:") || heliotile_program::option_of(name).is_some()).collect()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn golden() -> PathBuf {
    Path::new(crate::ROOT).join("tests/data/weather/golden_3_days.epw")
}

/// Programs get errors as a line of JSON: kind, problem, and what it is about, 12 of 12; the same
/// words as people, and the fix apart.
#[test]
fn errors_are_json_on_request() {
    let folder = Folder::new();
    folder.build();
    folder.write("bad.csv", "condition,sun_azimuth_deg\nnoon,180\n");
    folder.write("nan.csv", "receiver,x,y,z,nx,ny,nz\na,NaN,0,0,0,0,1\n");
    for (arguments, kind, problem, about) in [
        ("nothing", "argument", "unknown", "nothing"),
        ("info --nothing", "argument", "unknown", "--nothing"),
        ("build scene.obj --quality best", "argument", "unknown", "--quality"),
        ("replay site.helio --steps 99", "argument", "out-of-range", "--steps"),
        ("build scene.obj", "argument", "missing", "--receivers"),
        ("build scene.obj -r receivers.csv -o a.helio --set nothing=1", "argument", "unknown", "set"),
        ("build scene.obj -r nan.csv -o a.helio", "input", "value", "nan.csv"),
        ("build scene.obj -r receivers.csv -o receivers.csv", "input", "same-file", "receivers.csv"),
        ("replay site.helio --conditions bad.csv", "input", "no-column", "bad.csv"),
        ("replay nowhere.helio --conditions conditions.csv", "missing-file", "", "nowhere.helio"),
        ("replay site.helio --conditions conditions.csv -o a.xyz", "unsupported", "", ""),
        ("replay scene.obj --conditions conditions.csv", "input", "other-kind", "scene.obj"),
    ] {
        let words = folder.run(arguments);
        let output = folder.command(arguments).env("HELIOTILE_ERRORS", "json").output().expect("the program");
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        let said = stderr(&output);
        let facts: serde_json::Value = serde_json::from_str(said.lines().last().unwrap_or_default()).expect(&said);
        let text = |name: &str| facts[name].as_str().unwrap_or_default().to_owned();
        assert_eq!((text("kind").as_str(), text("problem").as_str()), (kind, problem), "{arguments}: {said}");
        let found = format!("{} {}", facts["fields"], text("file"));
        assert!(found.contains(about), "{arguments}: {said}");
        let first = text("message").lines().next().unwrap_or_default().to_owned();
        assert!(stderr(&words).contains(&first) && !first.is_empty(), "{arguments}: {said}");
        assert!(!first.contains("to fix"), "{arguments}: {said}");
    }
}

/// Names of files are shown as they are, also those in braces that are names of options: of 2
/// folders and a material.
#[test]
fn names_in_braces_are_no_options() {
    let folder = Folder::new();
    fs::create_dir(folder.path("{weather}")).expect("a folder");
    let said = |arguments: &str| stderr(&folder.command(arguments).output().expect("the program"));
    let missing = said("info {weather}/{command:verify}.helio");
    assert!(missing.contains("{weather}/{command:verify}.helio"), "{missing}");
    fs::copy(folder.path("receivers.csv"), folder.path("{weather}/{every}.txt")).expect("a file");
    let wrong = said("run scene.obj --weather {weather}/{every}.txt");
    assert!(wrong.contains("{weather}/{every}.txt") && wrong.contains("--"), "{wrong}");
}

/// Build, query and replay give the stable columns: 9 columns, 6 rows of a query, 216 of three
/// days.
#[test]
fn build_query_and_replay_keep_their_columns() {
    let folder = Folder::new();
    let built = folder.build();
    assert_eq!(built.status.code(), Some(0), "{}", String::from_utf8_lossy(&built.stderr));

    let table = stdout(&folder.run("replay site.helio --conditions conditions.csv"));
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "condition,receiver,sun_direct,sky_direct,sun_reflected,sky_reflected,sun_mirrored,sky_mirrored,total"
    );
    assert_eq!(lines.len(), 1 + 2 * 3);
    let roof = lines.iter().find(|l| l.starts_with("noon,roof,")).expect("the roof at noon");
    let direct: f64 = roof.split(',').nth(2).and_then(|t| t.parse().ok()).expect("a number");
    assert!((direct - 800.0 * 50.0_f64.to_radians().sin()).abs() < 0.01, "{roof}");

    let weather = golden();
    let replay = |rest: &str| folder.run(&format!("replay site.helio --weather {} {rest}", weather.display()));
    let hourly = stdout(&replay("--every hour"));
    assert_eq!(hourly.lines().count(), 1 + 72 * 3);
    assert!(hourly.starts_with("time,receiver,sun_direct,"));
    assert_eq!(replay("-o year.csv --every year").status.code(), Some(0));
    let year = fs::read_to_string(folder.path("year.csv")).expect("the table");
    assert!(year.starts_with("time,receiver,sun_direct_kwh_m2,"), "{year}");
    assert_eq!(year.lines().count(), 4);
    // Sums of the year are the sums of the hours' means.
    let sum = |table: &str, from: f64| -> f64 {
        let totals = table.lines().skip(1).filter_map(|l| l.rsplit(',').next()?.parse::<f64>().ok());
        totals.sum::<f64>() * from
    };
    let (hours, sums) = (sum(&hourly, 1e-3), sum(&year, 1.0));
    assert!((hours - sums).abs() < 1e-3 * sums, "{hours} {sums}");
    assert_eq!(replay("-o hours.parquet").status.code(), Some(0));
    assert!(fs::metadata(folder.path("hours.parquet")).expect("the table").len() > 1000);
}

/// `--io map` and `--io pread` print the same bytes from query, replay, info and verify, 4 of 4;
/// another word is refused.
#[test]
fn both_ways_of_reading_agree() {
    let folder = Folder::new();
    folder.build();
    let replay = format!("replay site.helio --every day --weather {}", golden().display());
    for command in
        ["replay site.helio --conditions conditions.csv", &replay, "info site.helio", "archive verify site.helio"]
    {
        let [map, pread] = ["map", "pread"].map(|io| folder.run(&format!("{command} --io {io}")));
        assert_eq!((map.status.code(), pread.status.code()), (Some(0), Some(0)), "{command}");
        assert!(!map.stdout.is_empty() && map.stdout == pread.stdout, "{command}");
    }
    folder.fails("info site.helio --io mmap", "argument unknown --io mmap");
}

/// `info --weather` states 8760 hours and 1619.948 kWh/m2 of GHI for Golden, the sum of its column,
/// and 52.730 for December. A scene there, and a weather file without its option, are refused with
/// the command to give.
#[test]
fn info_of_weather_states_sums_of_months() {
    let folder = Folder::new();
    let golden = format!("{}/tests/data/weather/golden_tmy3.epw", crate::ROOT);
    let said = stdout(&folder.run(&format!("info --weather {golden}")));
    let line = |start: &str| said.lines().find(|line| line.starts_with(start)).map(str::split_whitespace);
    let cells = |start: &str, skip: usize| line(start).into_iter().flatten().skip(skip).collect::<Vec<_>>();
    assert_eq!(cells("  all ", 1), ["8760", "1619.948", "1866.531", "577.938"], "{said}");
    assert_eq!(cells("  1996-12 ", 1), ["744", "52.730", "72.060", "29.018"], "{said}");
    folder.write("a.obj", "v 0 0 0\n");
    folder.fails("info --weather a.obj", "input other-kind a.obj a scene (OBJ)");
    folder.fails(&format!("info {golden}"), "input other-kind golden_tmy3.epw weather (EPW)");
    folder
        .fails("info a.obj --time-zone 1", "argument needs --time-zone,--shift,--weather-stamp,--date-order --weather");
}

/// `info` names all 7 layers, the counts and the 12 settings as `--set` takes them. `verify` finds
/// nothing in a good archive and the damaged block in a bad one, and warns of 99 bytes behind the
/// end of one.
#[test]
fn info_lists_layers_and_verify_finds_damage() {
    let folder = Folder::new();
    folder.build();
    let info = stdout(&folder.run("info site.helio"));
    let unknown = folder.run("build scene.obj -m materials.toml -r receivers.csv -o x.helio --set sky=1");
    let message = String::from_utf8_lossy(&unknown.stderr).into_owned();
    let names: Vec<&str> = message.split("set one of ").nth(1).expect("names").trim().split(", ").collect();
    assert_eq!(names.len(), 12);
    assert!(names.iter().all(|name| info.contains(&format!(" {name}="))), "{names:?}: {info}");
    for part in ["receivers", "sky", "hit", "response", "probes", "bounce", "materials", "3 in 1 tile of"] {
        assert!(info.contains(part), "{part}: {info}");
    }
    for options in ["--materials materials.toml", "--materials-only", "--no-ground"] {
        folder.fails(&format!("info site.helio {options}"), "input other-kind site.helio archive");
    }
    assert_eq!(folder.run("archive verify site.helio").status.code(), Some(0));
    let mut bytes = fs::read(folder.path("site.helio")).expect("the archive");
    fs::write(folder.path("long.helio"), [&bytes[..], &[7; 99]].concat()).expect("a writable folder");
    let verified = folder.run("archive verify long.helio");
    let message = String::from_utf8_lossy(&verified.stderr).into_owned();
    assert_eq!(verified.status.code(), Some(0));
    assert!(message.contains("long.helio: ignored 99 bytes after the archive's end; harmless"), "{message}");
    bytes[8192 + 10] ^= 1;
    fs::write(folder.path("bad.helio"), &bytes).expect("a writable folder");
    let verified = folder.run("archive verify bad.helio");
    assert_eq!(verified.status.code(), Some(1));
    assert!(stdout(&verified).contains("receivers/0"), "{}", stdout(&verified));
    folder.fails("replay bad.helio --conditions conditions.csv", "corrupt bad.helio receivers/0");
}

/// 7 wrong options of a build are refused with the value that was found.
#[test]
fn wrong_build_options_name_the_allowed_values() {
    let folder = Folder::new();
    let build = "build scene.obj -m materials.toml -r receivers.csv -o site.helio";
    for seconds in ["0.5", "-1", "soon"] {
        folder
            .fails(&format!("{build} --checkpoint={seconds}"), &format!("argument unreadable --checkpoint {seconds}"));
    }
    for memory in ["512", "1KiB", "1.2.3MiB", "-1GB"] {
        folder.fails(&format!("{build} --memory={memory}"), &format!("argument unreadable --memory {memory}"));
    }
    assert!(!folder.path("site.helio").exists());
}

/// 17 wrong inputs each end with exit code 2 and a message that names the file, the place and what
/// was found.
#[test]
fn wrong_inputs_name_file_place_and_finding() {
    let folder = Folder::new();
    let build = "build scene.obj --materials materials.toml --materials-only --receivers receivers.csv -o site.helio";
    folder.fails(&build.replace("scene.obj", "none.obj"), "missing-file none.obj");
    let with = |name: &str, text: &str, expected: &str| {
        let folder = Folder::new();
        folder.write(name, text);
        folder.fails(build, expected);
        assert!(!folder.path("site.helio").exists() && !folder.path("site.helio.partial").exists());
    };
    with("materials.toml", "[wall]\ndiffuse = 0.4\n[roof]\ndiffuse = 0.2\n", "input unknown materials.toml grass");
    with("materials.toml", "[wall]\ndifuse = 0.4\n", "input unknown materials.toml:2 difuse");
    with(
        "materials.toml",
        &MATERIALS.replace("0.4", "1.4"),
        "input value materials.toml:2 `diffuse` of material `wall` 1.4",
    );
    with("receivers.csv", &RECEIVERS.replace("0,-1,0", "0,0,0"), "input value receivers.csv:3 nx,ny,nz 0,0,0");
    with("receivers.csv", &RECEIVERS.replace("0,-1,0", "0,nan,0"), "input value receivers.csv:3 ny nan");
    with("receivers.csv", &RECEIVERS.replace("10.02", "high"), "input value receivers.csv:2 z high");
    with("receivers.csv", &RECEIVERS.replace("lawn", "roof"), "input duplicate receivers.csv:4 roof");
    with("scene.obj", &SCENE.replace("v 10 10 0\n", "v 10 x 0\n"), "input value scene.obj:3 y x");
    with("scene.obj", &SCENE.replace("f 1 2 6 5", "f 1 2 6 500"), "input value scene.obj:10 f 500");
    with("scene.obj", &SCENE.replace("v 10 10 0\n", "v 10 nan 0\n"), "input value scene.obj:3 y nan");
    with("scene.obj", &SCENE.replace("v 10 10 0\n", "v 10 1e30 0\n"), "input value scene.obj:3 y 1e30");
    with("scene.obj", "", "input empty scene.obj");
    with("scene.obj", "v 0 0 0\n", "input empty scene.obj");

    folder.build();
    let query = "replay site.helio --conditions conditions.csv";
    folder.write("conditions.csv", &CONDITIONS.replace("800", "-800"));
    folder.fails(query, "input value conditions.csv:2 dni_w_m2 -800");
    // The output is checked before anything is read.
    folder.fails(&format!("{query} -o out.xlsx"), "unsupported `out.xlsx`");
    folder.write("conditions.csv", CONDITIONS);
    folder.fails(&format!("{query} -o out.xlsx"), "unsupported `out.xlsx`");
    folder.fails(&format!("{query} --sky cie:17"), "argument unknown --sky cie:17");
    folder.fails("replay scene.obj --conditions conditions.csv", "input other-kind scene.obj a scene (OBJ)");
}

/// 5 outputs that would destroy something (an input, another kind of file, a device, a folder) are
/// refused, and nothing is lost.
#[test]
fn outputs_never_replace_inputs() {
    let folder = Folder::new();
    folder.build();
    let build = "build scene.obj --materials materials.toml --receivers receivers.csv -o ";
    folder.fails(&format!("{build}scene.obj"), "input same-file scene.obj scene.obj");
    folder.fails(&format!("{build}conditions.csv"), "input exists conditions.csv");
    folder.fails(&format!("{build}/dev/null"), "input other-kind null folder or device");
    folder.fails(
        "replay site.helio --conditions conditions.csv -o conditions.csv",
        "input same-file conditions.csv conditions.csv",
    );
    folder.fails(&format!("{build}."), "input other-kind . folder or device");
    assert_eq!(fs::read_to_string(folder.path("scene.obj")).ok().as_deref(), Some(SCENE));
    assert_eq!(fs::read_to_string(folder.path("conditions.csv")).ok().as_deref(), Some(CONDITIONS));
}

/// A receiver inside the cube and one that faces a wall from 0.3 mm are named, 2 of 2, and the
/// build goes on; the first is also named by a build from the archive.
#[test]
fn misplaced_receivers_are_named() {
    let folder = Folder::new();
    folder.write("receivers.csv", &format!("{RECEIVERS}buried,5,5,5,0,0,1\nclose,5,-0.0003,5,0,1,0\n"));
    let built = folder.build();
    let message = String::from_utf8_lossy(&built.stderr).into_owned();
    assert_eq!(built.status.code(), Some(0), "{message}");
    assert!(message.contains("inside a solid") && message.contains("buried"), "{message}");
    assert!(message.contains("close (0.30 mm)"), "{message}");
    let known = folder.run("build scene.obj -m materials.toml -r receivers.csv --from site.helio -o again.helio -v");
    assert!(stdout(&known).contains("  reused: "), "{}", stdout(&known));
    let message = String::from_utf8_lossy(&known.stderr).into_owned();
    assert!(message.contains("1 receiver lies inside a solid") && message.contains("buried"), "{message}");
}

/// `extract` by list, box and surface, `merge` and `diff` work from the command line: the merged
/// file has the bytes of the original, `diff` ends with 0 and 1, and 9 wrong calls end with 2.
#[test]
fn merged_parts_have_the_bytes_of_the_original() {
    let folder = Folder::new();
    let rows = RECEIVERS.replace("nz\n", "nz,surface\n").replace(",0,1\n", ",0,1,top\n");
    folder.write("receivers.csv", &rows.replace("-1,0\n", "-1,0,front\n").replace("0,2\n", "0,2,garden\n"));
    folder.write("few.csv", "note,receiver\nx,lawn\n,roof\n");
    assert_eq!(folder.build().status.code(), Some(0));
    let extract = |rest: &str| {
        let output = folder.run(&format!("archive extract site.helio {rest}"));
        assert_eq!(output.status.code(), Some(0), "{rest}: {}", String::from_utf8_lossy(&output.stderr));
        stdout(&output)
    };
    assert!(extract("--receivers few.csv -o few.helio").contains("few.helio: 2 of 3 receivers in 1 tile,"));
    extract("--surface front -o front.helio");
    for (select, count) in
        [("--bbox 4,-1,6,6", 2), ("--bbox -10,-10,20,20,3,5", 1), ("--bbox 15,5,15,5", 1), ("--surface top garden", 2)]
    {
        assert!(extract(&format!("{select} -o box.helio")).contains(&format!(": {count} of 3 receivers")), "{select}");
    }
    let merged = stdout(&folder.run("archive merge few.helio front.helio -o merged.helio"));
    assert!(
        merged.contains("3 receivers in 1 tile,") && merged.contains("2 from few.helio, 1 from front.helio, 0 in both")
    );
    let bytes = |name: &str| fs::read(folder.path(name)).expect("an archive");
    assert!(bytes("merged.helio") == bytes("site.helio"));

    let same = folder.run("archive diff site.helio merged.helio");
    assert_eq!((same.status.code(), stdout(&same).as_str()), (Some(0), "equal, and so are the roots\n"));
    let other = folder.run("archive diff site.helio few.helio");
    assert_eq!(other.status.code(), Some(1));
    assert!(stdout(&other).contains("only in A  1 receiver: south\n"), "{}", stdout(&other));

    folder.fails("archive extract site.helio -o x.helio", "argument missing --receivers");
    folder.fails(
        "archive extract site.helio --bbox 0,0,1,1 --surface top -o x.helio",
        "argument excludes --bbox --surface",
    );
    folder.fails("archive extract site.helio --bbox 0,0,1 -o x.helio", "argument unreadable --bbox 0,0,1");
    folder.fails("archive extract site.helio --bbox 5,0,1,1 -o x.helio", "argument unreadable --bbox 5,0,1,1");
    folder.fails("archive extract site.helio --bbox 90,90,91,91 -o x.helio", "input empty site.helio");
    folder.fails("archive extract site.helio --surface top attic -o x.helio", "input unknown site.helio attic");
    folder.fails(
        "archive extract site.helio --receivers conditions.csv -o x.helio",
        "input no-column conditions.csv:1 receiver",
    );
    folder.fails("archive extract site.helio --receivers few.csv -o few.csv", "input same-file few.csv few.csv");
    folder.fails("archive diff site.helio none.helio", "missing-file none.helio");
    assert!(!folder.path("x.helio").exists() && !folder.path("x.helio.partial").exists());
}
