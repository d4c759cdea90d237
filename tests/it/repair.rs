//! Repair of damaged archives.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use heliotile_archives::writing::{Job, Writer};
use heliotile_core::archive::{Archive, format};
use heliotile_core::site::north::North;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::read_receivers;

use crate::scenes::{data, hague, hague_of, tiles};

/// A scratch folder with the receivers of The Hague in two halves that share a third of them.
struct Halves(tempfile::TempDir);

impl Halves {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let text = fs::read_to_string(data("receivers.csv")).expect("receivers");
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows.len(), 78);
        for (name, part) in [("a.csv", &rows[..52]), ("b.csv", &rows[26..])] {
            let header = text.lines().next().expect("a header");
            fs::write(folder.path().join(name), format!("{header}\n{}\n", part.join("\n"))).expect("written");
        }
        Halves(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes the materials of The Hague with roofs of glass.
    fn shiny(&self) -> PathBuf {
        let materials = fs::read_to_string(data("materials.toml")).expect("materials");
        let path = self.path("shiny.toml");
        let glass = materials.replacen("diffuse = 0.20\nspecular = 0.0", "diffuse = 0.1\nglass = true", 1);
        assert!(glass.contains("glass"));
        fs::write(&path, glass).expect("written");
        path
    }

    /// Builds `output` for `csv`; returns its bytes.
    fn build(&self, csv: &str, output: &str) -> Vec<u8> {
        good(&mut hague(&self.path(output), &self.path(csv)));
        fs::read(self.path(output)).expect("an archive")
    }
}

fn good(command: &mut Command) -> Output {
    let output = command.output().expect("the program");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn heliotile(arguments: &[&str], paths: &[&Path]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
    command.args(arguments).args(paths);
    command
}

/// One damaged block of each of the 18 kinds of a site with mirrors, one kind at a time, is
/// repaired to the original bytes. If receivers are damaged the receivers file is asked for.
/// Another scene, other receivers, and the same ones with one other area or surface are refused. A
/// good archive is left alone.
#[test]
fn repair_gives_the_same_bytes() {
    let site = Halves::new();
    let (path, materials) = (site.path("a.helio"), site.shiny());
    good(&mut hague_of(&materials, &path, &site.path("a.csv")));
    let whole = fs::read(&path).expect("an archive");
    let rows = fs::read_to_string(site.path("a.csv")).expect("receivers");
    fs::write(site.path("area"), rows.replacen("15.027", "15.028", 1)).expect("written");
    fs::write(site.path("surface"), rows.replacen(",roof\n", ",attic\n", 1)).expect("written");
    let entries: Vec<_> = Archive::open(&path).expect("an archive").entries().to_vec();
    let repair = |more: &[&str]| {
        let mut command = heliotile(&["archive", "repair"], &[&path, &data("scene.obj"), Path::new("-m"), &materials]);
        command.args(more).output().expect("the program")
    };
    let first_of = |(kind, name, _)| Some((kind, name, entries.iter().find(|entry| entry.kind == kind)?));
    let kinds: Vec<_> = format::KINDS.into_iter().filter_map(first_of).collect();
    assert_eq!(kinds.len(), 18);
    for (kind, name, entry) in kinds {
        let mut bytes = whole.clone();
        bytes[entry.offset as usize + entry.stored as usize / 2] ^= 4;
        fs::write(&path, &bytes).expect("written");
        if kind == format::RECEIVERS {
            let refused = repair(&[]);
            assert_eq!(refused.status.code(), Some(2));
            let said = String::from_utf8_lossy(&refused.stderr);
            assert!(said.contains("--receivers") && said.matches("to fix: ").count() == 1, "{said}");
        }
        let refused = repair(&["-r", &site.path("b.csv").to_string_lossy()]);
        assert_eq!(refused.status.code(), Some(2), "{name}: other receivers");
        assert!(fs::read(&path).expect("an archive") == bytes, "{name}: a refused repair changed the archive");
        if kind != format::RECEIVERS {
            for other in ["area", "surface"] {
                let refused = repair(&["-r", &site.path(other).to_string_lossy()]);
                let said = String::from_utf8_lossy(&refused.stderr).into_owned();
                assert!(said.contains("other receivers than tile 0"), "{name}, {other}: {said}");
            }
        }
        let csv = site.path("a.csv");
        let output = repair(&["-r", &csv.to_string_lossy()]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && said.contains("root as before"), "{name}: {said}");
        assert!(fs::read(&path).expect("an archive") == whole, "{name} has other bytes");
    }
    assert!(String::from_utf8_lossy(&repair(&[]).stdout).contains("nothing to repair"));
    let mut bytes = whole.clone();
    bytes[8192] ^= 1;
    fs::write(&path, &bytes).expect("written");
    let other = heliotile(&["archive", "repair"], &[&path, &data("scene.obj")]).output().expect("the program");
    assert_eq!(other.status.code(), Some(2));
    assert!(fs::read(&path).expect("an archive") == bytes, "a refused repair changed the archive");
}

/// A repair that was interrupted after its first tile is resumed: the repaired archive has the
/// original bytes, 3 blocks of them from the interrupted one. `extract` and `merge`, which have no
/// `--fresh`, do not name it if another build lies there: 2 of 2.
#[test]
fn interrupted_repairs_are_resumed() {
    let site = Halves::new();
    let whole = site.build("a.csv", "a.helio");
    let path = site.path("a.helio");
    let archive = Archive::open(&path).expect("an archive");
    let scene = Scene::load(&data("scene.obj"), Some(&data("materials.toml"))).expect("a scene");
    let receivers = read_receivers(&site.path("a.csv"), North::default()).expect("receivers");
    let job = Job {
        scene: scene.named_hash(),
        receivers: tiles(&receivers, &scene).content_hash(),
        settings: archive.manifest().settings.hash().expect("a hash"),
    };
    let interrupt = |name: &str| {
        let mut writer = Writer::create(&site.path(name), &job).expect("a writer");
        for kind in [format::RECEIVERS, format::SKY, format::HIT] {
            writer.append(archive.copy(&archive.entries_of(kind)[0]).expect("a block")).expect("appended");
        }
        writer.keep().expect("a checkpoint");
    };
    for (command, inputs) in [("extract", vec![&path]), ("merge", vec![&path, &path])] {
        interrupt("other.helio");
        let mut line = heliotile(&["archive", command], &[]);
        line.args(inputs).arg("-o").arg(site.path("other.helio"));
        if command == "extract" {
            line.args(["--surface", "roof"]);
        }
        let said = String::from_utf8_lossy(&line.output().expect("the program").stderr).into_owned();
        assert!(said.contains("finish it with the build that began it") && !said.contains("--fresh"), "{said}");
        fs::remove_file(site.path("other.helio.partial")).expect("removed");
    }
    interrupt("a.helio.repaired");
    let damaged = archive.entries_of(format::PROBES)[0];
    let mut bytes = whole.clone();
    bytes[damaged.offset as usize + 9] ^= 1;
    // The file is replaced, not changed: this test has the old one open.
    fs::remove_file(&path).expect("removed");
    fs::write(&path, bytes).expect("written");
    let output = good(&mut heliotile(
        &["archive", "repair"],
        &[&path, &data("scene.obj"), Path::new("-m"), &data("materials.toml")],
    ));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("continuing an interrupted build after 3 blocks"), "{said}");
    assert!(fs::read(&path).expect("an archive") == whole);
}
