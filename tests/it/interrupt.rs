//! Builds that are killed or stopped, and resumed.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::thread::sleep;
use std::time::{Duration, Instant};

use heliotile_archives::writing::{Job, Writer};
use heliotile_builder::pipeline::{Output as Target, Start};
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::{Archive, format};
use heliotile_core::hemisphere::{mix, unit};

use crate::scenes::{data, hague, plan, receiver, scene, site, tiles, tilted, town, v};

/// Returns a quick build of the cut of The Hague with a checkpoint after every batch of blocks.
fn build(output: &Path, more: &[&str]) -> Command {
    let mut command = hague(output, &data("receivers.csv"));
    command.args(more);
    command
}

fn message(output: Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").arg(name).arg(child.id().to_string()).status().expect("the command `kill`");
    assert!(status.success());
}

/// A build that is killed at 12 random times and started again each time ends with the bytes of an
/// undisturbed one, and no archive has its name before it is finished. (`tools/kill-loop` does it
/// 200 times.)
#[test]
fn killed_builds_resume_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, site) = (folder.path().join("whole.helio"), folder.path().join("site.helio"));
    let start = Instant::now();
    assert!(build(&whole, &[]).output().expect("a build").status.success());
    let length = start.elapsed();
    let expected = fs::read(&whole).expect("an archive");
    for round in 0..12_u64 {
        let mut child = build(&site, &[]).spawn().expect("a build");
        sleep(length.mul_f64(unit(mix(round, 7))));
        child.kill().expect("a kill");
        child.wait().expect("its end");
        if let Ok(bytes) = fs::read(&site) {
            assert!(bytes == expected, "round {round} published something else");
            fs::remove_file(&site).expect("removed");
        }
    }
    let last = build(&site, &[]).output().expect("a build");
    assert!(last.status.success(), "{}", message(last));
    assert!(fs::read(&site).expect("an archive") == expected);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "left-overs");
}

/// SIGINT ends a build with exit code 130, SIGTERM with 143, and one line gives the command that
/// resumes it. Other settings are refused by name and nothing is lost. The same command resumes the
/// build, 2 of 2, and --fresh starts anew.
#[test]
fn stopped_builds_name_the_command_to_resume() {
    for (name, code) in [("-INT", 130), ("-TERM", 143)] {
        stopped_by(name, code);
    }
}

fn stopped_by(name: &str, code: i32) {
    let folder = tempfile::tempdir().expect("a folder");
    let (site, log) = (folder.path().join("site.helio"), folder.path().join("site.helio.partial.log"));
    let child = build(&site, &[]).spawn().expect("a build");
    let start = Instant::now();
    while !log.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint");
        sleep(Duration::from_millis(2));
    }
    signal(&child, name);
    let stopped = child.wait_with_output().expect("its end");
    assert_eq!(stopped.status.code(), Some(code));
    let said = message(stopped);
    let last = said.lines().last().unwrap_or_default();
    assert!(last.starts_with("heliotile: stopped after ") && last.contains(" blocks of "), "{said}");
    let (_, again) = last.split_once("; to go on: ").expect("a command");
    assert!(again.contains(" build ") && again.contains("--checkpoint 0"), "{said}");
    let refused = |more: &[&str], parts: &[&str]| {
        let output = build(&site, more).output().expect("a build");
        assert_eq!(output.status.code(), Some(2));
        let said = message(output);
        assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    };
    refused(&["--set", "hit=32"], &["settings", "--fresh", "-o"]);
    assert!(!site.exists());
    let kept = fs::read(&log).expect("a journal");
    // The printed line, run by a shell, resumes the build.
    let on = Command::new("sh").args(["-c", again]).output().expect("a shell");
    let said = message(on.clone());
    assert!(on.status.success() && said.contains("continuing an interrupted build after"), "{said}");
    let whole = fs::read(&site).expect("an archive");
    fs::remove_file(&site).expect("removed");
    assert!(!kept.is_empty() && !log.exists());
    let fresh = build(&site, &["--fresh"]).output().expect("a build");
    assert!(fresh.status.success() && !log.exists(), "{}", message(fresh));
    assert!(fs::read(&site).expect("an archive") == whole);
}

/// A build whose files may take at most 250 kB ends with exit code 2 and says how to resume it;
/// with room it is resumed to the bytes of an undisturbed one.
#[test]
fn full_disks_cost_what_follows_the_checkpoint() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, site) = (folder.path().join("whole.helio"), folder.path().join("site.helio"));
    assert!(build(&whole, &[]).output().expect("a build").status.success());
    let expected = fs::read(&whole).expect("an archive");
    assert!(expected.len() > 400_000, "{}", expected.len());
    // A shell's limit counts in blocks of 512 bytes; with its signal ignored, writing fails.
    let mut limited = Command::new("sh");
    limited.args(["-c", "trap '' XFSZ; ulimit -f 500; exec \"$0\" \"$@\""]);
    let full = build(&site, &[]);
    let stopped = limited.arg(full.get_program()).args(full.get_args()).output().expect("a shell");
    assert_eq!(stopped.status.code(), Some(2));
    let said = message(stopped);
    assert!(said.contains("site.helio.partial: ") && said.contains("repeat the command to continue after"), "{said}");
    let done = build(&site, &[]).output().expect("a build");
    assert!(done.status.success(), "{}", message(done));
    assert!(fs::read(&site).expect("an archive") == expected);
}

/// A build that is resumed after its first tile was written names the receiver in it that lies
/// inside a block, 1 of 2, and ends with the bytes of an undisturbed one.
#[test]
fn resumed_builds_name_misplaced_receivers() {
    let scene = scene(&town(), &[0.2, 0.4]);
    let receivers = [
        receiver("buried", v(-38.0, -32.0, 3.0), tilted(0.0, 0.0)),
        receiver("free", v(-28.0, 0.0, 1.0), tilted(0.0, 0.0)),
    ];
    let settings = BuildSettings { sky_fine: 256, hit: 16, probe: 16, ..BuildSettings::default() };
    let (whole, folder) = (site(&scene, &receivers, &settings), tempfile::tempdir().expect("a folder"));
    let (archive, path) = (Archive::open(&whole.path).expect("an archive"), folder.path().join("site.helio"));
    let job = Job {
        scene: scene.named_hash(),
        receivers: tiles(&receivers, &scene).content_hash(),
        settings: settings.stated().hash().expect("a hash"),
    };
    let mut writer = Writer::create(&path, &job).expect("a writer");
    for kind in [format::RECEIVERS, format::SKY, format::HIT] {
        let entry = archive.entries_of(kind)[0];
        writer.append(archive.copy(&entry).expect("a block")).expect("appended");
    }
    writer.keep().expect("a checkpoint");
    let (what, output) = plan(&settings, &path);
    let plan = (what, Target { start: Start::Resume, ..output });
    let report = crate::scenes::build(&scene, &mut tiles(&receivers, &scene), &plan).expect("a build");
    assert_eq!((report.rays.sky, report.rays.hit), (0, 0));
    let named: Vec<_> = report.warnings.iter().filter(|w| w.contains("inside a solid")).collect();
    assert!(
        named.len() == 1 && named[0].plain().starts_with("1 receiver lies") && named[0].plain().ends_with("buried"),
        "{:?}",
        report.warnings
    );
    assert!(fs::read(&path).expect("an archive") == fs::read(&whole.path).expect("an archive"));
}
