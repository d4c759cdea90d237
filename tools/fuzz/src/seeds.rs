//! Valid inputs for every target, from a tiny site: run it after a change of the format.

use std::fs;
use std::path::Path;
use std::time::Duration;

use heliotile::archive::format::{self, FIRST_BLOCK, SLOT_SIZE};
use heliotile::archive::{Access, Archive};
use heliotile::commands::build::{BuildPlan, BuildSettings, Start, build};
use heliotile::scene::Scene;
use heliotile::scene::receiver_tiles::ReceiverTiles;
use heliotile::scene::receivers::read_receivers;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nv 5 5 0\nv 9 5 0\nv 9 5 6\nv 5 5 6\n\
                   usemtl ground\nf 1 2 3 4\n# steep\nusemtl wall\nf 5/1/1 6//2 7/3 -1\nf 1 3 \\\n 2\n";
const MATERIALS: &str =
    "[ground]\ndiffuse = 0.2\nclass = \"ground\"\n[wall]\ndiffuse = 0.3\nspecular = 0.1\ngroup = \"a\"\n";
const MTL: &str = "# by hand\nnewmtl wall\nKd 0.4 0.5 0.6\nKs 0.1 0.1 0.1\nNs 10\nd 1.0\nillum 2\nmap_Kd \"a b.png\"\n\
                   newmtl roof\nKd 0.2\nTr 0\n";
const RECEIVERS: &str = "receiver,x,y,z,nx,ny,nz,area,surface\nr1,7,3,1,0,0,1,2.5,roof\n\"r,2\",7,4.9,2,0,-1,0,,\n";
const CONDITIONS: &str =
    "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,55.5,800,100\nnight,0,-30,0,0\n";

/// Writes `seed-*` into the folders of the corpus.
pub fn write() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("written");
        path
    };
    let scene = Scene::load(&put("town.obj", OBJ), Some(&put("materials.toml", MATERIALS))).expect("a scene");
    let receivers = read_receivers(&put("receivers.csv", RECEIVERS)).expect("receivers");
    let settings = BuildSettings {
        sky_base: 8,
        sky_fine: 16,
        hit: 4,
        cell_floor_m: 8.0,
        probe: 4,
        probe_hits: 4,
        closed_m: 16.0,
        bounce_sky: 4,
        bounce_hits: 4,
        ..BuildSettings::default()
    };
    let site = folder.path().join("site.helio");
    let origin = scene.mesh.origin;
    let mut tiles = ReceiverTiles::from_receivers(&receivers, origin, folder.path(), 1 << 20).expect("receivers");
    let plan = BuildPlan {
        settings,
        output: site.clone(),
        memory_bytes: 1 << 27,
        start: Start::New,
        checkpoint_every: Duration::from_secs(30),
        accuracy: None,
    };
    build(&scene, &mut tiles, &plan).expect("an archive");
    let bytes = fs::read(&site).expect("read");
    seed("archive", &bytes);
    seed("sealed", &[&bytes[..SLOT_SIZE], &bytes[FIRST_BLOCK as usize..]].concat());

    let archive = Archive::open_with(&site, Access::Read).expect("opened");
    let raw = |kind| archive.block(kind, 0).expect("a block");
    for (target, kind) in [
        ("receivers_table", format::RECEIVERS),
        ("cells_table", format::PROBES),
        ("index_table", format::INDEX),
        ("materials_table", format::MATERIALS),
    ] {
        seed(target, &[&[raw(kind).items() as u8], raw(kind).bytes()].concat());
    }
    let count = receivers.len() as u8;
    for (target, kind, sides) in
        [("sky", format::SKY, 8 | 1 << 6), ("hit", format::HIT, 4), ("response", format::RESPONSE, 4)]
    {
        seed(target, &[&[count, sides], raw(kind).bytes()].concat());
    }
    for entry in archive.entries() {
        let stored = &bytes[entry.offset as usize..][..entry.stored as usize];
        let head = [&[u8::from(entry.codec == format::CODEC_RAW)], &entry.raw.to_le_bytes()[..]].concat();
        if entry.kind == format::SKY || entry.kind == format::PROBES {
            save("block", &format!("seed-{}", entry.kind), &[&head, stored].concat());
        }
    }

    seed("obj", OBJ.as_bytes());
    seed("mtl", MTL.as_bytes());
    seed("materials", MATERIALS.as_bytes());
    seed("receivers", RECEIVERS.as_bytes());
    seed("conditions", CONDITIONS.as_bytes());
    let weather = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_3_days.epw");
    let epw = fs::read_to_string(weather).expect("weather");
    let day: Vec<&str> = epw.lines().take(8 + 24).collect();
    let day = day.join("\r\n");
    seed("epw", day.as_bytes());
    seed("weather", day.as_bytes());
}

fn seed(target: &str, bytes: &[u8]) {
    save(target, "seed", bytes);
}

fn save(target: &str, name: &str, bytes: &[u8]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/corpus").join(target);
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join(name), bytes).expect("written");
}
