//! Outputs of two runs at a time, and outputs that are inputs: files of one run, or a refusal.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};

use crate::ROOT;
use crate::cli::{Folder, stderr};

/// Number of races.
const RACES: usize = 6;

/// Returns the contents of a folder's files that start with `start`, hidden ones too, by name.
fn contents(folder: &Path, start: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let named = entries.map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path()));
    let ours = named.filter(|(name, path)| name.trim_start_matches('.').starts_with(start) && path.is_file());
    ours.map(|(name, path)| (name, fs::read(path).expect("a file"))).collect()
}

fn started(folder: &Folder, arguments: &str) -> Child {
    let mut command = folder.command(arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a program")
}

/// Two runs write one table with different columns, in 6 races: the table and the metadata
/// beside it are those of one run, 0 other files stay, and a run that did not write says so with
/// exit code 2.
#[test]
fn two_runs_into_one_table_leave_files_of_one() {
    let folder = Folder::new();
    let archive = format!("{ROOT}/tests/data/archives/v1.7-box.helio");
    let weather = format!("{ROOT}/tests/data/weather/golden_tmy3.epw");
    let command =
        |column: &str| format!("replay {archive} --weather {weather} --columns {column} --every hour -o t.csv");
    let alone = ["sun_direct", "sky_direct"].map(|column| {
        assert_eq!(folder.run(&command(column)).status.code(), Some(0));
        contents(&folder.path("."), "t.csv")
    });
    assert_eq!(alone.each_ref().map(BTreeMap::len), [2, 2]);
    for race in 0..RACES {
        let runs = ["sun_direct", "sky_direct"].map(|column| started(&folder, &command(column)));
        let done = runs.map(|run| run.wait_with_output().expect("an end"));
        let codes = done.each_ref().map(|output| output.status.code());
        let found = contents(&folder.path("."), "t.csv");
        let winner = alone.iter().position(|files| *files == found).unwrap_or_else(|| {
            panic!("race {race}: files of neither run: {:?} {codes:?}", found.keys().collect::<Vec<_>>())
        });
        assert_eq!(codes[winner], Some(0), "race {race}");
        for output in done.iter().filter(|output| output.status.code() != Some(0)) {
            assert_eq!(output.status.code(), Some(2), "race {race}");
            assert!(stderr(output).contains("is being written by another run"), "race {race}: {}", stderr(output));
        }
    }
}

/// 5 command lines that name one file twice are refused, in other spellings too; the files that
/// they would have replaced keep their bytes.
#[test]
fn one_file_is_not_two() {
    let folder = Folder::new();
    let archive = format!("{ROOT}/tests/data/archives/v1.7-box.helio");
    let weather = format!("{ROOT}/tests/data/weather/golden_3_days.epw");
    fs::create_dir(folder.path("d")).expect("made");
    fs::copy(&archive, folder.path("z.helio.partial")).expect("copied");
    folder.write("a.obj", "v 0 0 0\nv 9 0 0\nv 9 9 0\nusemtl roof\nf 1 2 3\n");
    folder.write("d/tradeoff.csv", "receiver,x,y,z,nx,ny,nz\na,1,1,1,0,0,1\n");
    folder.write("d/audit.csv", "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\na,180,40,500,100\n");
    let kept =
        || ["z.helio.partial", "d/tradeoff.csv", "d/audit.csv"].map(|name| fs::read(folder.path(name)).expect("kept"));
    let before = kept();
    folder.fails("receivers a.obj -o zz.csv --buried ./zz.csv", "input same-file ./zz.csv zz.csv");
    folder.fails(
        &format!("buildings {archive} --weather {weather} -o z.csv --faces d/../z.csv"),
        "input same-file d/../z.csv z.csv",
    );
    folder.fails("tradeoff a.obj -r d/tradeoff.csv -o d", "input same-file d/tradeoff.csv d/tradeoff.csv");
    folder.fails(
        &format!("archive audit {archive} a.obj --conditions d/audit.csv -o d"),
        "input same-file d/audit.csv d/audit.csv",
    );
    folder.fails(
        "archive extract z.helio.partial --bbox 0,0,9,9 -o z.helio",
        "input same-file z.helio.partial z.helio.partial",
    );
    assert_eq!(kept(), before);
}

/// A weather file named like an unfinished table keeps its bytes while the table is written, and a
/// link there leads to a file that keeps its 4.
#[test]
#[cfg(unix)]
fn files_beside_an_output_keep_their_bytes() {
    let folder = Folder::new();
    let archive = format!("{ROOT}/tests/data/archives/v1.7-box.helio");
    let weather = format!("{ROOT}/tests/data/weather/golden_3_days.epw");
    fs::copy(&weather, folder.path("y.csv.partial")).expect("copied");
    folder.write("mine.txt", "mine");
    std::os::unix::fs::symlink(folder.path("mine.txt"), folder.path("x.csv.partial")).expect("a link");
    for (read, written) in [("y.csv.partial", "y.csv"), (weather.as_str(), "x.csv")] {
        let output = folder.run(&format!("replay {archive} --weather {read} --every day -o {written}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    assert_eq!(fs::read(folder.path("y.csv.partial")).expect("kept"), fs::read(&weather).expect("read"));
    assert_eq!(fs::read(folder.path("mine.txt")).expect("kept"), b"mine");
}

/// Where standard error cannot be written, a refusal still ends with exit code 2.
#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_error_is_no_panic() {
    let folder = Folder::new();
    let full = fs::File::options().write(true).open("/dev/full").expect("a device");
    let status = folder.command("info no-such.obj").stderr(full).status().expect("a program");
    assert_eq!(status.code(), Some(2));
}
