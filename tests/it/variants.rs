//! Variants of a site: a build from an archive of the scene before it was changed gives the bytes
//! of a build without it.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use heliotile_builder::pipeline::{BuildReport, ReusedArchives, ReusedCounts};
use heliotile_builder::settings::{BuildSettings, Quality, Rungs};
use heliotile_core::archive::Archive;
use heliotile_core::hemisphere::{mix, unit};
use heliotile_core::site::material::{Class, Glass, Material};
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::read_receivers_with_warnings;

use crate::cli::failure;
use crate::scenes::*;

/// Returns settings that are cheap to trace.
pub fn coarse() -> BuildSettings {
    BuildSettings { sky_base: 32, sky_fine: 128, ..Rungs::new(Quality::Draft).settings() }
}

/// A site that can be edited.
#[derive(Clone)]
pub struct Model {
    pub objects: Vec<Triangles>,
    pub materials: Vec<Material>,
    pub receivers: Vec<Receiver>,
}

impl Model {
    pub fn scene(&self) -> Scene {
        Scene::from_triangles(&self.objects.concat(), self.materials.clone()).expect("a scene")
    }

    pub fn build(&self, path: &Path, before: Option<&Archive>) -> BuildReport {
        let (scene, sources) = (self.scene(), ReusedArchives { before, ..ReusedArchives::default() });
        let receivers = &mut tiles(&self.receivers, &scene);
        build_with(&scene, receivers, &plan(&coarse(), path), &sources).expect("a build")
    }

    /// Returns the number of a material, added if there is none of its name.
    fn material(&mut self, material: Material) -> u16 {
        let found = self.materials.iter().position(|old| old.name == material.name);
        found.unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        }) as u16
    }
}

/// Number of kinds of edits.
pub const EDITS: usize = 14;

/// Random numbers of one edit.
pub struct Dice(pub u64);

impl Dice {
    fn up_to(&mut self, most: f64) -> f64 {
        self.0 = mix(self.0, 17);
        unit(self.0) * most
    }

    fn one_of(&mut self, count: usize) -> usize {
        (self.up_to(count as f64) as usize).min(count - 1)
    }
}

/// Changes a model in one of 14 ways.
pub fn edit(model: &mut Model, way: usize, dice: &mut Dice) {
    let which = dice.one_of(model.objects.len());
    let low = model.objects[which].iter().flat_map(|t| t.0).fold(DVec3::INFINITY, DVec3::min);
    let shift = v(dice.up_to(8.0) - 4.0, dice.up_to(8.0) - 4.0, 0.0);
    let map = |object: &mut Triangles, to: &dyn Fn(DVec3) -> DVec3| {
        object.iter_mut().for_each(|(corners, _)| *corners = corners.map(to));
    };
    let beside = low + shift * 3.0;
    let size = v(2.0 + dice.up_to(6.0), 2.0 + dice.up_to(6.0), 3.0 + dice.up_to(30.0));
    let wall = |name: &str| Material::matt(name, 0.5, Class::Obstruction);
    match way {
        0 if model.objects.len() > 2 => drop(model.objects.remove(which)),
        1 => map(&mut model.objects[which], &|p| p + shift),
        2 => map(&mut model.objects[which], &|p| v(p.x, p.y, low.z + (p.z - low.z) * 1.5)),
        3 => {
            let paint = model.material(wall("a new paint"));
            model.objects[which].iter_mut().for_each(|(_, material)| *material = paint);
        }
        4 => model.objects.push(block(beside, beside + size, 0)),
        5 => {
            let new = model.material(wall("tower"));
            model.objects.push(block(beside, beside + size, new));
        }
        6 => {
            let glass = model.material(Material { glass: Some(Glass::Single), ..wall("pane") });
            model.objects.push(quad(beside, v(size.x, 0.0, 0.0), v(0.0, 0.0, size.z), glass));
        }
        7 => {
            let leaf = Material { transmittance: Some(0.4), ..Material::matt("leaf", 0.0, Class::Obstruction) };
            let leaf = model.material(leaf);
            model.objects.push(block(beside + v(0.0, 0.0, 2.0), beside + size, leaf));
        }
        8 => model.materials.iter_mut().for_each(|material| material.diffuse *= 0.7),
        9 => {
            // A matt material becomes a mirror, or the other way round.
            let of = dice.one_of(model.materials.len());
            let material = &mut model.materials[of];
            let shines = material.mirrors() || material.transmittance.is_some();
            let specular = if shines { 0.0 } else { 0.6 };
            *material = Material { diffuse: 0.1, specular, ..Material::matt(&material.name, 0.1, material.class) };
        }
        10 => {
            // The first object, ground and whatever belongs to it, is lowered.
            let down = -0.3 - dice.up_to(1.0);
            map(&mut model.objects[0], &|p| p + v(0.0, 0.0, down));
        }
        11 => {
            let far = low + v(700.0, 600.0, 0.0);
            model.objects.push(block(far, far + size, 0));
        }
        12 => {
            // One triangle is removed: a hole, through which light enters a closed object.
            let object = &mut model.objects[which];
            if object.len() > 1 {
                object.remove(dice.one_of(object.len()));
            }
        }
        _ => {
            let all = model.receivers.len();
            model.receivers.remove(dice.one_of(all));
            let of = dice.one_of(all - 1);
            let near = Receiver { id: "one more".into(), ..model.receivers[of].clone() };
            model.receivers.retain(|receiver| receiver.id != "one more");
            model.receivers.push(Receiver { position: near.position + v(0.0, 0.0, 1.5), ..near });
        }
    }
}

/// Splits a scene into objects, whose triangles have corners in common; the largest one comes
/// first.
fn objects(scene: &Scene) -> Vec<Triangles> {
    let mesh = &scene.mesh;
    let mut of: Vec<usize> = (0..mesh.vertices.len()).collect();
    fn root(of: &mut [usize], mut at: usize) -> usize {
        while of[at] != at {
            of[at] = of[of[at]];
            at = of[at];
        }
        at
    }
    for corners in &mesh.triangles {
        let first = root(&mut of, corners[0] as usize);
        for corner in &corners[1..] {
            let other = root(&mut of, *corner as usize);
            of[other] = first;
        }
    }
    let mut parts: BTreeMap<usize, Triangles> = BTreeMap::new();
    for (i, corners) in mesh.triangles.iter().enumerate() {
        let triangle = (mesh.triangle_points(i).map(|p| p + mesh.origin), mesh.triangle_material[i]);
        parts.entry(root(&mut of, corners[0] as usize)).or_default().push(triangle);
    }
    let mut parts: Vec<Triangles> = parts.into_values().collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.len()));
    parts
}

/// Returns the cut of The Hague with its receivers.
pub fn hague() -> Model {
    let scene = Scene::load(&data("scene.obj"), Some(&data("materials.toml"))).expect("a scene");
    let receivers =
        read_receivers_with_warnings(&data("receivers.csv"), North::default(), &mut Vec::new()).expect("receivers");
    Model { objects: objects(&scene), materials: scene.materials, receivers }
}

/// Returns the town with mirrors and glass, and leaves.
fn mirrors() -> Model {
    let mut objects = objects(&mirror_town());
    let mut materials = mirror_materials();
    materials.sort_by(|a, b| a.name.cmp(&b.name));
    materials.push(Material { transmittance: Some(0.3), ..Material::matt("tree", 0.0, Class::Obstruction) });
    objects.push(block(v(-10.0, -60.0, 2.0), v(-4.0, -54.0, 8.0), 4));
    Model { objects, materials, receivers: many().into_iter().step_by(3).collect() }
}

/// Returns hills, and a house with a cellar in them that juts out over its own wall.
fn hills() -> Model {
    let height = |x: f64, y: f64| 4.0 * (x / 37.0).sin() + 5.0 * (y / 29.0).cos();
    let at = |i: i32, k: i32| {
        let (x, y) = (f64::from(i) * 12.0 - 120.0, f64::from(k) * 12.0 - 120.0);
        v(x, y, height(x, y))
    };
    let mut terrain = Triangles::new();
    for (i, k) in (0..20).flat_map(|i| (0..20).map(move |k| (i, k))) {
        let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
        terrain.extend([([a, b, c], 0), ([a, c, d], 0)]);
    }
    let house = block(v(-8.0, -6.0, -3.0), v(4.0, 5.0, 11.0), 1);
    let jetty = quad(v(4.0, -6.0, 8.0), v(3.0, 0.0, 0.0), v(0.0, 11.0, 0.0), 1);
    let neighbour = block(v(4.0, -6.0, -3.0), v(13.0, 5.0, 7.0), 2);
    let materials = ["grass", "roof", "wall"].map(|name| Material::matt(name, 0.3, Class::Obstruction)).to_vec();
    let receivers = (0..70)
        .map(|i| {
            let (x, y) = (f64::from(i % 10) * 9.0 - 41.0, f64::from(i / 10) * 11.0 - 30.0);
            let normal = tilted(f64::from(i % 4) * 30.0, f64::from(i) * 40.0);
            receiver(&format!("r{i}"), v(x, y, height(x, y) + 1.0 + f64::from(i % 3) * 5.0), normal)
        })
        .collect();
    Model { objects: vec![terrain, house, jetty, neighbour], materials, receivers }
}

/// Returns the number of edits in a test; `tools/variants/run` sets more.
fn count() -> usize {
    std::env::var("HELIOTILE_EDITS").ok().and_then(|text| text.parse().ok()).unwrap_or(2 * EDITS)
}

/// Edits of all 14 kinds, one or two at a time, are made on three sites: the root of a build from
/// the archive before is that of a fresh build every time, and on each site some receivers, probes
/// and bounce cells are taken from there.
#[test]
fn a_variant_has_the_bytes_of_a_fresh_build() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    for (number, (name, base)) in
        [("hague", hague()), ("mirrors", mirrors()), ("hills", hills())].into_iter().enumerate()
    {
        let path = folder.path().join(format!("{name}.helio"));
        base.build(&path, None);
        let before = Archive::open(&path).expect("an archive");
        let (mut kept, mut all) = (ReusedCounts::default(), ReusedCounts::default());
        let edits = count() / 3 + usize::from(number < count() % 3);
        // One edit grows the site to a side: its origin moves, and cells of 1024 m are among those
        // that stay.
        let grown = (name == "hills" && edits < 30).then_some(29);
        for i in (0..edits).chain(grown) {
            let mut dice = Dice(mix(number as u64 + 7, i as u64));
            let mut variant = base.clone();
            edit(&mut variant, (i + number * 5) % EDITS, &mut dice);
            if i % 2 == 1 {
                let way = dice.one_of(EDITS);
                edit(&mut variant, way, &mut dice);
            }
            let [fresh, from] = ["fresh.helio", "from.helio"].map(|file| folder.path().join(file));
            let expected = variant.build(&fresh, None);
            let found = variant.build(&from, Some(&before));
            assert_eq!(found.root, expected.root, "{name}, edit {i}: {:?}", found.kept);
            let some = found.kept.unwrap_or_default();
            kept.receivers += some.receivers;
            kept.probes += some.probes;
            kept.bounce_cells += some.bounce_cells;
            all.receivers += found.counts.receivers;
            all.probes += found.counts.probes;
            all.bounce_cells += found.counts.bounce_cells;
        }
        eprintln!("{name}: {edits} edits, kept {kept:?} of {all:?}");
        assert!(
            kept.probes > 0 && kept.bounce_cells > 0 && (kept.receivers > 0 || name == "mirrors"),
            "{name} {kept:?}"
        );
    }
}

/// Runs the program in a folder: its exit code and its messages.
pub fn run(folder: &Path, line: &str) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_heliotile"))
        .current_dir(folder)
        .args(line.split(' '))
        .output()
        .expect("the program");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// `build --from` an archive without reflections, where no hit is stored, or without further ones,
/// where cells cast no rays, has the bytes of a build without, also if nothing has changed. Other
/// settings and an archive of another site are reported and not used. An archive without its scene,
/// and the archive that is to be written, are refused. A folder of `run --from` holds the archive
/// of `run`.
#[test]
fn build_from_an_archive_has_the_bytes_of_a_build() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let at = folder.path();
    let house = |x: f64| {
        let corners = [(x, 0.0), (x + 6.0, 0.0), (x + 6.0, 5.0), (x, 5.0)];
        let low: String = corners.iter().map(|(x, y)| format!("v {x} {y} 0\nv {x} {y} 7\n")).collect();
        format!(
            "o house\nusemtl wall\n{low}f -8 -6 -5 -7\nf -6 -4 -3 -5\nf -4 -2 -1 -3\nf -2 -8 -7 -1\nf -7 -5 -3 -1\n"
        )
    };
    let ground = "o lawn\nusemtl lawn\nv -30 -30 0\nv 30 -30 0\nv 30 30 0\nv -30 30 0\nf 1 2 3 4\n";
    std::fs::write(at.join("a.obj"), format!("{ground}{}", house(2.0))).expect("written");
    std::fs::write(at.join("b.obj"), format!("{ground}{}{}", house(2.0), house(-9.0))).expect("written");
    std::fs::write(at.join("far.obj"), house(9000.0)).expect("written");
    std::fs::write(at.join("m.toml"), "[wall]\ndiffuse = 0.4\n[lawn]\ndiffuse = 0.2\nclass = \"ground\"\n")
        .expect("written");
    let table = "receiver,x,y,z,nx,ny,nz\nlawn,0,-3,0.02,0,0,1\nwall,1.98,2,3,-1,0,0\nroof,5,2,7.02,0,0,1\n";
    std::fs::write(at.join("r.csv"), table).expect("written");
    let bytes = |name: &str| std::fs::read(at.join(name)).expect("an archive");
    let done = |line: &str| {
        let (code, said) = run(at, line);
        assert_eq!(code, Some(0), "{line}: {said}");
        said
    };
    for effects in ["none", "diffuse", "all"] {
        let build =
            |scene: &str, more: &str| done(&format!("build {scene}.obj -m m.toml -r r.csv --effects {effects} {more}"));
        build("a", &format!("-o a-{effects}.helio"));
        build("a", &format!("--from a-{effects}.helio -o again-{effects}.helio"));
        assert!(bytes(&format!("a-{effects}.helio")) == bytes(&format!("again-{effects}.helio")), "{effects}");
        build("b", &format!("-o b-{effects}.helio"));
        let said = build("b", &format!("--from a-{effects}.helio -o from-{effects}.helio"));
        assert!(said.contains("0 triangles of its 12 were removed, 10 added"), "{said}");
        assert!(bytes(&format!("b-{effects}.helio")) == bytes(&format!("from-{effects}.helio")), "{effects}");
    }
    let said = done("build b.obj -m m.toml -r r.csv --effects all --set hit=16 --from a-all.helio -o other.helio");
    assert!(said.contains("a-all.helio: it was built with other settings (hit 32, now 16"), "{said}");
    let said = done("build far.obj -m m.toml -r r.csv --no-ground --effects all --from a-all.helio -o far.helio");
    assert!(said.contains("a-all.helio: ") && said.contains("nothing of it is reused"), "{said}");
    done("build a.obj -m m.toml -r r.csv --no-scene -o bare.helio");
    let fails = |line: &str, expected: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        assert_eq!(failure(command.current_dir(at).args(line.split(' '))), expected, "{line}");
    };
    fails("build b.obj -m m.toml -r r.csv --from bare.helio -o c.helio", "input lacks bare.helio scene");
    fails(
        "build b.obj -m m.toml -r r.csv --from a-all.helio -o a-all.helio",
        "input same-file a-all.helio a-all.helio",
    );
    fails("build b.obj -m m.toml -r r.csv --from nowhere.helio -o c.helio", "missing-file nowhere.helio");
    assert!(!at.join("c.helio").exists());
    std::fs::copy(Path::new(crate::ROOT).join("tests/data/weather/golden_3_days.epw"), at.join("w.epw"))
        .expect("weather");
    done("run a.obj -m m.toml -w w.epw -r r.csv -o before");
    done("run b.obj -m m.toml -w w.epw -r r.csv -o fresh");
    done("run b.obj -m m.toml -w w.epw -r r.csv --from before/site.helio -o from");
    assert!(bytes("fresh/site.helio") == bytes("from/site.helio"));
}
