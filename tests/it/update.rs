//! Edits of an archive by the names of its objects: the new archive is that of a scene file that
//! was edited by hand.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cli::failure;
use heliotile_core::archive::Archive;
use heliotile_core::replay::components::Component;

/// A folder with the files of a small town, in which the program runs.
struct Town(tempfile::TempDir);

/// A box as an object of OBJ.
struct Block<'a> {
    name: &'a str,
    at: [f64; 3],
    size: [f64; 3],
    wall: &'a str,
}

impl Block<'_> {
    fn obj(&self) -> String {
        let Block { name, at: [x, y, z], size: [w, d, h], wall } = *self;
        let corner = |i: usize, z: f64| {
            let (dx, dy) = [(0.0, 0.0), (w, 0.0), (w, d), (0.0, d)][i];
            format!("v {} {} {z}\n", x + dx, y + dy)
        };
        let corners: String = (0..4).map(|i| corner(i, z)).chain((0..4).map(|i| corner(i, z + h))).collect();
        let walls = "f -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n";
        format!("o {name}\n{corners}usemtl {wall}\n{walls}usemtl roof\nf -4 -3 -2 -1\n")
    }
}

const HOUSE: Block = Block { name: "house", at: [2.0, 0.0, 0.0], size: [6.0, 5.0, 7.0], wall: "wall" };
const SHED: Block = Block { name: "shed", at: [-12.0, 1.0, 0.0], size: [4.0, 4.0, 3.0], wall: "wall" };
const TOWER: Block = Block { name: "tower", at: [0.0, -20.0, 0.0], size: [6.0, 6.0, 32.0], wall: "wall" };
const LAWN: &str = "o lawn\nusemtl lawn\nv -30 -30 0\nv 30 -30 0\nv 30 30 0\nv -30 30 0\nf 1 2 3 4\n";
const MATERIALS: &str =
    "[wall]\ndiffuse = 0.4\n[roof]\ndiffuse = 0.2\n[lawn]\ndiffuse = 0.2\nclass = \"ground\"\n[white]\ndiffuse = 0.8\n";

impl Town {
    fn new() -> Self {
        let town = Town(tempfile::tempdir().expect("a scratch folder"));
        town.write("m.toml", MATERIALS);
        town.write(
            "c.csv",
            "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,40,800,120\neast,95,20,500,80\n",
        );
        town.scene("before", &[HOUSE, SHED]);
        town.fresh("before");
        town
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    fn scene(&self, name: &str, blocks: &[Block]) {
        let blocks: String = blocks.iter().map(Block::obj).collect();
        self.write(&format!("{name}.obj"), &format!("{LAWN}{blocks}"));
    }

    /// Runs a command line; returns exit code, standard output and messages.
    fn run(&self, line: &str) -> (Option<i32>, String, String) {
        let output = self.command(line).output().expect("the program");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    }

    fn done(&self, line: &str) -> String {
        let (code, out, said) = self.run(line);
        assert_eq!(code, Some(0), "{line}: {said}");
        format!("{out}{said}")
    }

    fn fails(&self, line: &str, expected: &str) {
        assert_eq!(failure(&mut self.command(line)), expected, "{line}");
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        command.current_dir(self.0.path()).args(line.split(' '));
        command
    }

    /// Covers and builds `NAME.obj` from nothing.
    fn fresh(&self, name: &str) {
        self.cover(name);
        self.build(name);
    }

    fn cover(&self, name: &str) {
        self.done(&format!("receivers {name}.obj -m m.toml -o {name}.csv"));
    }

    /// Writes the receivers of the town before, with those of the house moved, for the objects that
    /// `NAME.obj` has.
    fn shifted(&self, name: &str, by: [f64; 3]) {
        let objects = fs::read_to_string(self.path(&format!("{name}.obj"))).expect("an OBJ file");
        let table = fs::read_to_string(self.path("before.csv")).expect("a table");
        let mut lines = table.lines();
        let mut text = format!("{}\n", lines.next().expect("names"));
        for line in lines {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            let object = line.split('/').next().expect("a name").to_owned();
            if object == "house" {
                for (cell, by) in cells[1..4].iter_mut().zip(by) {
                    *cell = format!("{:.4}", cell.parse::<f64>().expect("a number") + by);
                }
            }
            if objects.contains(&format!("o {object}\n")) {
                text += &format!("{}\n", cells.join(","));
            }
        }
        self.write(&format!("{name}.csv"), &text);
    }

    fn build(&self, name: &str) {
        self.done(&format!("build {name}.obj -m m.toml -r {name}.csv --set hit=16 --set sky_fine=128 -o {name}.helio"));
    }

    fn root(&self, name: &str) -> [u8; 32] {
        Archive::open(&self.path(name)).expect("an archive").root()
    }

    fn scene_hash(&self, name: &str) -> String {
        Archive::open(&self.path(name)).expect("an archive").manifest().scene.content_hash.clone()
    }

    /// Returns the lines of `query`, sorted.
    fn rows(&self, archive: &str) -> Vec<String> {
        let mut rows: Vec<String> =
            self.run(&format!("replay {archive} -c c.csv")).1.lines().map(str::to_owned).collect();
        rows.sort();
        rows
    }
}

/// A house is moved, a shed is removed, a tower is added and a wall is painted: the archives have
/// the root of a build from nothing of an OBJ file that was edited by hand, 3 of 4. With the tower,
/// whose faces have other line numbers, they give the same irradiance, since new receivers are as
/// far apart as those before.
#[test]
fn edits_have_the_bytes_of_an_edited_file() {
    let town = Town::new();
    town.write("tower.obj", &TOWER.obj());
    for (name, blocks, edit) in [
        ("moved", vec![Block { at: [5.0, 2.5, 0.5], ..HOUSE }, SHED], "--move house=3,2.5,0.5"),
        ("removed", vec![HOUSE], "--remove shed"),
        ("added", vec![HOUSE, SHED, TOWER], "--add tower.obj -m m.toml"),
        ("painted", vec![Block { wall: "white", ..HOUSE }, SHED], "--material house=white -m m.toml"),
    ] {
        town.scene(name, &blocks);
        if name == "painted" {
            // The edit paints all of the object.
            let text = fs::read_to_string(town.path("painted.obj")).expect("an OBJ file");
            town.write("painted.obj", &text.replacen("usemtl roof", "usemtl white", 1));
        }
        let shift = if name == "moved" { [3.0, 2.5, 0.5] } else { [0.0; 3] };
        match name {
            "added" => town.cover(name),
            _ => town.shifted(name, shift),
        }
        town.build(name);
        let said = town.done(&format!("update before.helio {edit} -o after-{name}.helio"));
        assert_eq!(
            town.scene_hash(&format!("after-{name}.helio")),
            town.scene_hash(&format!("{name}.helio")),
            "{name}"
        );
        assert!(town.rows(&format!("after-{name}.helio")) == town.rows(&format!("{name}.helio")), "{name}: {said}");
        if name != "added" {
            assert_eq!(
                town.root(&format!("after-{name}.helio")),
                town.root(&format!("{name}.helio")),
                "{name}: {said}"
            );
        }
    }
}

/// With a storey of 3 m more, or the height of 10 m, the scene and the irradiance of all receivers
/// are those of a file with a house of 10 m; the shed's receivers stay.
#[test]
fn a_storey_is_added() {
    let town = Town::new();
    town.scene("high", &[Block { size: [6.0, 5.0, 10.0], ..HOUSE }, SHED]);
    town.fresh("high");
    for (file, height) in [("up.helio", "+3m"), ("to.helio", "10m")] {
        let said = town.done(&format!("update before.helio --height house={height} -o {file}"));
        assert!(said.contains(" receivers kept, ") && said.contains(" new"), "{said}");
        assert_eq!(town.scene_hash(file), town.scene_hash("high.helio"));
        assert!(town.rows(file) == town.rows("high.helio"), "{said}");
    }
    assert_eq!(town.root("up.helio"), town.root("to.helio"));
}

/// A tower of 6 m takes the noon sun from 6 or more of the 11 receivers on the south wall of the
/// house behind it, which is 6 m wide and reaches 2 m beyond its shadow, and no morning sun from
/// the shed.
#[test]
fn a_tower_takes_sun_from_what_is_behind_it() {
    let town = Town::new();
    town.write("tower.obj", &TOWER.obj());
    town.done("update before.helio --add tower.obj -m m.toml --spacing 8m -o after.helio");
    let value = |archive: &str, receiver: &str, condition: &str| -> f64 {
        let (_, rows, _) = town.run(&format!("replay {archive} -c c.csv"));
        let row =
            rows.lines().find(|row| row.starts_with(&format!("{condition},{receiver},"))).expect("a row").to_owned();
        let names = rows.lines().next().expect("names").split(',');
        let place = names.into_iter().position(|name| name == Component::SunDirect.name());
        row.split(',').nth(place.expect("a column")).expect("a value").parse().expect("a number")
    };
    let south: Vec<String> = (1..=11).map(|i| format!("house/wall2#{i}")).collect();
    assert!(south.iter().all(|receiver| value("before.helio", receiver, "noon") > 600.0));
    let dark = south.iter().filter(|receiver| value("after.helio", receiver, "noon") == 0.0).count();
    assert!((6..11).contains(&dark), "{dark}");
    assert_eq!(value("before.helio", "shed/roof1#1", "east"), value("after.helio", "shed/roof1#1", "east"));
}

/// If an object is put over another one, the receivers that it swallows are left out and counted,
/// and those on its own faces move with it. Edits that change nothing are reported, and give the
/// archive before.
#[test]
fn swallowed_receivers_are_left_out_and_counted() {
    let town = Town::new();
    let said = town.done("update before.helio --move shed=15,0.5,0 -v -o inside.helio");
    assert!(said.contains("receivers left out: the edits put them inside an object, or cover them"), "{said}");
    assert!(said.contains("shed/"), "{said}");
    let said = town.done("update before.helio --move shed=0,0,0 -o same.helio");
    assert!(said.contains("the edits change nothing"), "{said}");
    assert_eq!(town.root("same.helio"), town.root("before.helio"));
}

/// Wrong edits are refused and leave no file: 12 of 12.
#[test]
fn wrong_edits_are_refused() {
    let town = Town::new();
    town.done("build before.obj -m m.toml -r before.csv --no-scene --set hit=16 -o bare.helio");
    town.write("twice.obj", &Block { at: [20.0, 20.0, 0.0], ..HOUSE }.obj());
    for (edit, expected) in [
        ("", "argument missing --add"),
        ("--remove hose", "argument unknown --remove hose"),
        ("--move house=1,2", "argument unreadable --move house=1,2"),
        ("--move house=1,2,nan", "argument unreadable --move house=1,2,nan"),
        ("--move house=1,0,0 --move house=2,0,0", "argument duplicate --move house"),
        ("--remove house --height house=+3m", "argument excludes --height --remove"),
        ("--height house=tall", "argument unreadable --height house=tall"),
        ("--height house=-6.95m", "argument other --height"),
        ("--height lawn=+3m", "argument lacks --height roof"),
        ("--material house=wal", "argument unknown --material wal"),
        ("--add twice.obj -m m.toml", "input duplicate twice.obj house"),
        ("--add nowhere.obj", "missing-file nowhere.obj"),
    ] {
        let edit = if edit.is_empty() { String::new() } else { format!(" {edit}") };
        town.fails(&format!("update before.helio{edit} -o c.helio"), expected);
    }
    town.fails("update bare.helio --remove house -o c.helio", "input lacks bare.helio scene");
    town.fails("update before.helio --remove house -o before.helio", "input same-file before.helio before.helio");
    town.fails("update before.helio --remove house -o c.zip", "input ending c.zip");
    assert!(!Path::new(&town.path("c.helio")).exists());
}
