//! Small scenes with known answers, and the shortest way from a scene to irradiance: through a real
//! archive.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use glam::DVec3;
use heliotile_archives::Workspace;
use heliotile_builder::pipeline::{Build, BuildReport, Output, Plan, PreparedScene, ReusedArchives};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_builder::settings::Quality;
use heliotile_builder::settings::ladder::Rungs;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::scratch::InMemory;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Silent;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::{Class, Glass, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::conditions::Condition;
use heliotile_scene::Scene;

pub type Triangles = Vec<([DVec3; 3], u16)>;

pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Returns two triangles of a parallelogram with corner `at` and sides `a`, `b`; its normal is a x
/// b.
pub fn quad(at: DVec3, a: DVec3, b: DVec3, material: u16) -> Triangles {
    vec![([at, at + a, at + a + b], material), ([at, at + a + b, at + b], material)]
}

/// Returns the six outward faces of a box.
pub fn block(low: DVec3, high: DVec3, material: u16) -> Triangles {
    let d = high - low;
    let (x, y, z) = (v(d.x, 0.0, 0.0), v(0.0, d.y, 0.0), v(0.0, 0.0, d.z));
    [
        quad(low, y, x, material),
        quad(low + z, x, y, material),
        quad(low, x, z, material),
        quad(low + y, z, x, material),
        quad(low, z, y, material),
        quad(low + x, y, z, material),
    ]
    .concat()
}

/// Returns a horizontal square of the given half side around (0, 0, z), facing up.
pub fn ground(half: f64, z: f64, material: u16) -> Triangles {
    quad(v(-half, -half, z), v(2.0 * half, 0.0, 0.0), v(0.0, 2.0 * half, 0.0), material)
}

/// Returns a street along y of the given width between two walls of the given height, `length`
/// long, floor at z = 0.
pub fn canyon(width: f64, height: f64, length: f64) -> Triangles {
    let half = length / 2.0;
    [
        quad(v(-width / 2.0, -half, 0.0), v(width, 0.0, 0.0), v(0.0, length, 0.0), 0),
        quad(v(-width / 2.0, -half, 0.0), v(0.0, length, 0.0), v(0.0, 0.0, height), 1),
        quad(v(width / 2.0, -half, 0.0), v(0.0, 0.0, height), v(0.0, length, 0.0), 1),
    ]
    .concat()
}

/// Returns a scene whose materials 0, 1, ... have the given diffuse reflectances; material 0 counts
/// as ground.
pub fn scene(triangles: &Triangles, diffuse: &[f64]) -> Scene {
    let materials = diffuse
        .iter()
        .enumerate()
        .map(|(i, &diffuse)| {
            Material::matt(format!("m{i}"), diffuse, if i == 0 { Class::Ground } else { Class::Obstruction })
        })
        .collect();
    Scene::from_triangles(triangles, materials).expect("a valid scene")
}

/// Returns twelve blocks on a square.
pub fn town() -> Triangles {
    let mut triangles = ground(200.0, 0.0, 0);
    for i in 0..12 {
        let (x, y) = (f64::from(i % 4) * 22.0 - 44.0, f64::from(i / 4) * 25.0 - 37.0);
        triangles.extend(block(v(x, y, 0.0), v(x + 12.0, y + 10.0, 6.0 + f64::from(i * 7 % 11)), 1));
    }
    triangles
}

/// Returns the town with a block that mirrors half of the light and one of double glass.
pub fn mirror_triangles() -> Triangles {
    let mut triangles = town();
    triangles.extend(block(v(-60.0, -30.0, 0.0), v(-52.0, 20.0, 17.0), 2));
    triangles.extend(block(v(46.0, -30.0, 0.0), v(52.0, 20.0, 21.0), 3));
    triangles
}

pub fn mirror_materials() -> Vec<Material> {
    let wall = |name| Material::matt(name, 0.3, Class::Obstruction);
    vec![
        Material::matt("ground", 0.2, Class::Ground),
        wall("wall"),
        Material { specular: 0.5, ..wall("mirror") },
        Material { glass: Some(Glass::Double), ..wall("glass") },
    ]
}

pub fn mirror_town() -> Scene {
    Scene::from_triangles(&mirror_triangles(), mirror_materials()).expect("a valid scene")
}

/// Returns 150 receivers, three tiles.
pub fn many() -> Vec<Receiver> {
    (0..150)
        .map(|i| {
            let (a, b) = (f64::from(i % 15) * 6.1 - 45.0, f64::from(i / 15) * 7.3 - 40.0);
            receiver(
                &format!("r{i:03}"),
                v(a, b, 20.0 * f64::from(i % 3)),
                tilted(f64::from(i % 4) * 30.0, f64::from(i)),
            )
        })
        .collect()
}

pub fn receiver(id: &str, position: DVec3, normal: DVec3) -> Receiver {
    Receiver::new(id.into(), position, normal.normalize())
}

/// Returns a receiver's normal tilted by `tilt_deg` from the zenith towards `azimuth_deg`.
pub fn tilted(tilt_deg: f64, azimuth_deg: f64) -> DVec3 {
    direction_from_degrees(azimuth_deg, 90.0 - tilt_deg)
}

pub fn sun(azimuth_deg: f64, altitude_deg: f64, dni_w_m2: f64, dhi_w_m2: f64) -> Condition {
    let sun = direction_from_degrees(azimuth_deg, altitude_deg);
    Condition::new("c".into(), &[sun], sun, dni_w_m2, dhi_w_m2)
}

/// Returns a condition of DHI 100 W/m2 without sun.
pub fn sky_only() -> Condition {
    sun(180.0, 45.0, 0.0, 100.0)
}

/// Components of one receiver and condition, W/m2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub sun_direct: f64,
    pub sky_direct: f64,
    pub sun_reflected: f64,
    pub sky_reflected: f64,
    pub total: f64,
}

/// An archive in a scratch folder.
pub struct Site {
    _folder: tempfile::TempDir,
    pub path: PathBuf,
}

/// Returns settings for tests whose bounds the default ones do not keep.
pub fn fine() -> BuildSettings {
    Rungs::new(Quality::Fine).settings()
}

/// Returns three times the error, W/m2, that the coding of responses of n x n texels may add to the
/// light of a source of `source_w_m2` at normal incidence: its bound is an RMS over directions
/// (`layers::response`).
pub fn coded_w_m2(n: usize, source_w_m2: f64) -> f64 {
    3.0 * 0.0032 / n as f64 * source_w_m2
}

/// Returns receivers in tiles, ready for a build.
pub fn tiles(receivers: &[Receiver], scene: &Scene) -> ReceiverTiles {
    ReceiverTiles::from_receivers(receivers, scene.mesh.origin, &std::env::temp_dir(), 1 << 20).expect("receivers")
}

/// Returns the workspace of a test.
pub fn workspace(folder: &Path, bytes: u64) -> Workspace {
    Workspace { folder: folder.to_path_buf(), memory: MemoryBudget::new(bytes) }
}

/// Returns the plan and output of an archive with some settings.
pub fn plan(settings: &BuildSettings, path: &Path) -> (Plan, Output) {
    (Plan::new(*settings), Output::new(path))
}

/// Traces receivers by a plan.
pub fn build(scene: &Scene, receivers: &mut ReceiverTiles, plan: &(Plan, Output)) -> Result<BuildReport> {
    build_with(scene, receivers, plan, &ReusedArchives::default())
}

/// Traces receivers by a plan, but for the blocks that other archives hold.
pub fn build_with(
    scene: &Scene,
    receivers: &mut ReceiverTiles,
    (plan, output): &(Plan, Output),
    sources: &ReusedArchives,
) -> Result<BuildReport> {
    let workspace = workspace(output.path.parent().expect("a folder"), 1 << 30);
    let scene = &PreparedScene::new(scene)?;
    Build { scene, receivers, workspace: &workspace, observer: &Silent }.write(plan, output, sources)
}

pub fn site(scene: &Scene, receivers: &[Receiver], settings: &BuildSettings) -> Site {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("site.helio");
    build(scene, &mut tiles(receivers, scene), &plan(settings, &path)).expect("a build");
    Site { _folder: folder, path }
}

impl Site {
    /// Returns the irradiance per receiver id: one row a condition.
    pub fn replay(&self, conditions: &[Condition], sky: SkyModel, depth: MaxBounces) -> BTreeMap<String, Vec<Row>> {
        self.replay_with(conditions, sky, depth, 577)
    }

    /// Returns the irradiance per receiver id with a number of sky patches: one row a condition.
    pub fn replay_with(
        &self,
        conditions: &[Condition],
        sky: SkyModel,
        depth: MaxBounces,
        patches: usize,
    ) -> BTreeMap<String, Vec<Row>> {
        replay(&self.path, conditions, sky, depth, patches)
    }

    /// Returns the irradiance of one condition under a uniform sky, all bounces.
    pub fn uniform(&self) -> BTreeMap<String, Row> {
        let rows = self.replay(&[sky_only()], SkyModel::Uniform, MaxBounces::All);
        rows.into_iter().map(|(id, rows)| (id, rows[0])).collect()
    }
}

/// Returns the path of a file of the cut of The Hague.
pub fn data(name: &str) -> PathBuf {
    Path::new(crate::ROOT).join("tests/data/hague").join(name)
}

/// Returns a command that builds the cut of The Hague for some receivers, coarsely, in less than a
/// second.
pub fn hague(output: &Path, receivers: &Path) -> Command {
    hague_of(&data("materials.toml"), output, receivers)
}

/// Returns a command that builds the cut of The Hague with other materials.
pub fn hague_of(materials: &Path, output: &Path, receivers: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
    command.arg("build").arg(data("scene.obj")).arg("-m").arg(materials);
    command.arg("-r").arg(receivers).arg("-o").arg(output);
    command.args(["--checkpoint", "0", "--set", "sky_fine=256", "--set", "hit=16", "--set", "probe=16"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Returns the irradiance of an archive per receiver id: one row a condition.
pub fn replay(
    path: &Path,
    conditions: &[Condition],
    sky: SkyModel,
    depth: MaxBounces,
    patches: usize,
) -> BTreeMap<String, Vec<Row>> {
    let archive = Archive::open(path).expect("an archive");
    let settings = ReplaySettings {
        sky,
        patches,
        paths: depth.into(),
        components: ComponentSet::ALL,
        memory: MemoryBudget::new(1 << 30),
        storage: &InMemory,
    };
    let replay = Replay::new(&OpenSite::open(&archive).expect("a site"), conditions, settings).expect("a replay");
    let mut rows = BTreeMap::new();
    for (ids, values) in replay.run(0..replay.tiles()).expect("tiles") {
        for (r, id) in ids.into_iter().enumerate() {
            let at = |component: Component, c: usize| f64::from(values.row(component, r)[c]);
            let row = |c: usize| Row {
                sun_direct: at(Component::SunDirect, c),
                sky_direct: at(Component::SkyDirect, c),
                sun_reflected: at(Component::SunReflected, c),
                sky_reflected: at(Component::SkyReflected, c),
                total: at(Component::Total, c),
            };
            rows.insert(id, (0..conditions.len()).map(row).collect());
        }
    }
    rows
}
