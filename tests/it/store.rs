//! Reuse of traces: the store that builds share, and repair.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use heliotile_builder::writing::{Job, Writer};
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

    /// Builds `output` for `csv`; returns its bytes and the millions of rays that were cast.
    fn build(&self, csv: &str, output: &str, store: Option<&str>) -> (Vec<u8>, f64) {
        let mut command = hague(&self.path(output), &self.path(csv));
        store.map(|store| command.arg("--store").arg(self.path(store)));
        let rays = mrays(&good(&mut command));
        (fs::read(self.path(output)).expect("an archive"), rays)
    }
}

/// Returns the millions of rays that a build reports.
fn mrays(output: &Output) -> f64 {
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let before = said.split(" Mray").next().and_then(|s| s.rsplit(' ').next()).expect("rays");
    before.parse().expect("a number")
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

fn archives(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() { found.extend(archives(&path)) } else { found.push(path) }
    }
    found
}

/// A second project that shares half of its 52 receivers with the first casts at most 70 % of the
/// rays, one with the same receivers none, and both have the bytes of builds without a store. So
/// has one from a store whose archives are damaged in 40 places, and it replaces the damaged
/// archives.
#[test]
fn nothing_is_traced_twice() {
    let site = Halves::new();
    let (alone, all_rays) = site.build("b.csv", "alone.helio", None);
    site.build("a.csv", "a.helio", Some("store"));
    let (shared, rays) = site.build("b.csv", "b.helio", Some("store"));
    assert!(shared == alone && rays < 0.7 * all_rays, "{rays} of {all_rays} Mray");
    let (again, rays) = site.build("b.csv", "again.helio", Some("store"));
    assert!(again == alone && rays == 0.0, "{rays} Mray");

    let stored = archives(&site.path("store"));
    assert_eq!(stored.len(), 2);
    for path in &stored {
        // The bytes are copied first: the store holds links to the archives of this test.
        let mut bytes = fs::read(path).expect("an archive");
        let length = bytes.len();
        (0..40).for_each(|i| bytes[8192 + i * (length - 40_000) / 40] ^= 1);
        fs::remove_file(path).expect("removed");
        fs::write(path, bytes).expect("written");
    }
    let found = heliotile(&["store", "verify"], &[&site.path("store")]).output().expect("the program");
    assert_eq!(found.status.code(), Some(1));
    let (mended, rays) = site.build("b.csv", "mended.helio", Some("store"));
    assert!(mended == alone && rays > 0.0, "{rays} Mray");
    let (_, rays) = site.build("b.csv", "healed.helio", Some("store"));
    assert!(rays == 0.0, "the store was not healed: {rays} Mray");
}

/// An archive of other settings, one of another scene and a file that is no archive, put into a
/// store under the name of one that fits, are named and not used, 3 of 3: the build casts all rays
/// and has the bytes of a build alone.
#[test]
fn folder_names_are_not_believed() {
    let site = Halves::new();
    let (alone, all_rays) = site.build("b.csv", "alone.helio", None);
    let others = [site.path("settings.helio"), site.path("scene.helio"), site.path("none.helio")];
    good(hague(&others[0], &site.path("b.csv")).args(["--set", "hit=32"]));
    let [scene, materials] =
        ["scene.obj", "materials.toml"].map(|name| fs::read_to_string(data(name)).expect("a scene"));
    fs::write(site.path("scene.obj"), scene).expect("written");
    fs::write(site.path("materials.toml"), materials.replacen("diffuse = 0.", "diffuse = 0.0", 1)).expect("written");
    let mut other = heliotile(&["build"], &[&site.path("scene.obj"), Path::new("-m"), &site.path("materials.toml")]);
    let settings = ["--set", "sky_fine=256", "--set", "hit=16", "--set", "probe=16"];
    good(other.arg("-r").arg(site.path("b.csv")).arg("-o").arg(&others[1]).args(settings));
    fs::write(&others[2], "nothing").expect("written");

    for (other, why) in others.iter().zip(["other settings", "another scene", "not a heliotile archive"]) {
        let store = site.path("store");
        site.build("a.csv", "a.helio", Some("store"));
        let stored = archives(&store);
        assert_eq!(stored.len(), 1);
        // The file is a copy: the store holds a link to the archive of this test.
        fs::remove_file(&stored[0]).expect("removed");
        fs::copy(other, &stored[0]).expect("copied");
        let mut command = hague(&site.path("b.helio"), &site.path("b.csv"));
        let output = good(command.arg("--store").arg(&store));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let name = stored[0].file_name().expect("a name").to_string_lossy().into_owned();
        assert!(said.contains("is not used: ") && said.contains(&name) && said.contains(why), "{said}");
        assert!(fs::read(site.path("b.helio")).expect("an archive") == alone, "{why}");
        assert_eq!(mrays(&output), all_rays, "{why}");
        fs::remove_dir_all(&store).expect("removed");
    }
}

/// Four builds that fill one store at once all succeed with the bytes of a build alone, and leave
/// one archive for each content: 2. `gc` keeps the archives that fit: 2 in 1 GiB, none in 0.
#[test]
fn builds_share_a_store_at_once() {
    let site = Halves::new();
    let (alone, _) = site.build("b.csv", "alone.helio", None);
    let children: Vec<_> = [("a.csv", "a0.helio"), ("b.csv", "b0.helio"), ("a.csv", "a1.helio"), ("b.csv", "b1.helio")]
        .map(|(csv, output)| {
            let mut command = hague(&site.path(output), &site.path(csv));
            command.arg("--store").arg(site.path("store")).spawn().expect("the program")
        })
        .into();
    for child in children {
        let output = child.wait_with_output().expect("its end");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(
        fs::read(site.path("b0.helio")).expect("b0") == alone && fs::read(site.path("b1.helio")).expect("b1") == alone
    );
    let stored = archives(&site.path("store"));
    assert_eq!(stored.len(), 2, "{stored:?}");
    let listed = good(&mut heliotile(&["store", "ls"], &[&site.path("store")]));
    assert_eq!(String::from_utf8_lossy(&listed.stdout).lines().count(), 3);
    good(&mut heliotile(&["store", "verify"], &[&site.path("store")]));
    good(&mut heliotile(&["store", "gc", "--keep", "1GiB"], &[&site.path("store")]));
    assert_eq!(archives(&site.path("store")).len(), 2);
    good(&mut heliotile(&["store", "gc", "--keep", "0MiB"], &[&site.path("store")]));
    assert_eq!(archives(&site.path("store")).len(), 0);
    let refused = heliotile(&["store", "ls"], &[&site.path("nowhere")]).output().expect("the program");
    assert_eq!(refused.status.code(), Some(2));
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
        let mut command = heliotile(&["repair"], &[&path, &data("scene.obj"), Path::new("-m"), &materials]);
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
            assert!(String::from_utf8_lossy(&refused.stderr).contains("--receivers"));
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
    let other = heliotile(&["repair"], &[&path, &data("scene.obj")]).output().expect("the program");
    assert_eq!(other.status.code(), Some(2));
    assert!(fs::read(&path).expect("an archive") == bytes, "a refused repair changed the archive");
}

/// A repair that was interrupted after its first tile is resumed: the repaired archive has the
/// original bytes, 3 blocks of them from the interrupted one. `extract` and `merge`, which have no
/// `--fresh`, do not name it if another build lies there: 2 of 2.
#[test]
fn interrupted_repairs_are_resumed() {
    let site = Halves::new();
    let (whole, _) = site.build("a.csv", "a.helio", None);
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
        let mut command = heliotile(&[command], &[]);
        command.args(inputs).arg("-o").arg(site.path("other.helio"));
        if command.get_args().next() == Some("extract".as_ref()) {
            command.args(["--surface", "roof"]);
        }
        let said = String::from_utf8_lossy(&command.output().expect("the program").stderr).into_owned();
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
    let output =
        good(&mut heliotile(&["repair"], &[&path, &data("scene.obj"), Path::new("-m"), &data("materials.toml")]));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("continuing an interrupted build after 3 blocks"), "{said}");
    assert!(fs::read(&path).expect("an archive") == whole);
}
