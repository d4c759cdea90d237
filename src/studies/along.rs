//! Receivers along lines, each looking in the direction of travel. In: a scene, a file of lines.
//! Out: the table of receivers that builds read.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::DVec3;

use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_results::outputs::receivers::{ReceiverRow, ReceiverTable};
use heliotile_scene::Scene;
use heliotile_scene::covering::cover::MAX_POINTS;
use heliotile_scene::points::lines::{TravelLine, TravelPoint, read_lines};
use heliotile_scene::site::SceneFiles;

/// Request for receivers along lines of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct AlongRequest {
    /// CSV file of the lines: columns `x` and `y`, and optionally `z` and `line`.
    pub lines: PathBuf,
    /// Distance between receivers, metres.
    pub spacing_m: f64,
    /// Height of eyes above the road, metres.
    pub height_m: f64,
    /// True if people also travel back along each line.
    pub both_ways: bool,
}

/// Receiver at eye height that looks in the direction of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct EyePoint {
    /// Name of the receiver: the name of its line with a number.
    pub name: String,
    /// Position in input coordinates.
    pub position: DVec3,
    /// Direction of travel.
    pub ahead: DVec3,
}

/// Ending of the name of a line that is travelled backwards.
const BACK: &str = "-back";

impl AlongRequest {
    /// Returns the receivers on the scene of `site`. Errors: numbers out of range, lines that
    /// cannot be read, no ground below a point.
    pub fn points(&self, site: &SceneFiles, observer: &dyn Observer) -> Result<Vec<EyePoint>> {
        for (field, metres) in [("spacing", self.spacing_m), ("eye_height", self.height_m)] {
            if !(0.001..=10_000.0).contains(&metres) {
                return Err(Error::argument(field, format!("is {metres} m"), "give 0.001 to 10000 metres"));
            }
        }
        let lines = read_lines(&self.lines)?;
        let count: f64 = lines.iter().map(|line| line.length_m() / self.spacing_m).sum();
        if count > MAX_POINTS {
            let what = format!("{} m would give {:.0} million receivers", self.spacing_m, count / 1e6);
            return Err(Error::argument("spacing", what, "give a wider spacing, or shorter lines"));
        }
        let scene = Scene::load_site(site)?;
        scene.report.tell(observer);
        let prepared = PreparedScene::new(&scene)?;
        let siting = Siting::new(&prepared);
        let mesh = &scene.mesh;
        // Points without a z get the ground below them; the search starts above all of the scene.
        let highest_m = mesh.origin.z + mesh.bounds().1.z;
        let back = |line: &TravelLine| line.back(format!("{}{BACK}", line.name));
        let all = lines.iter().flat_map(|line| [Some(line.clone()), self.both_ways.then(|| back(line))]).flatten();
        let (mut points, mut names) = (Vec::new(), BTreeSet::new());
        for line in all {
            if !names.insert(line.name.clone()) {
                let what = format!("`{}` names two lines: one of the file, and the way back of another", line.name);
                return Err(Error::input(&self.lines, None, what, "rename one of the two lines")
                    .because(Problem::duplicate(&line.name)));
            }
            for (number, TravelPoint { at, ahead }) in (1..).zip(line.points(self.spacing_m)) {
                let ground = || siting.ground_below(at.at.extend(highest_m + 1.0)).map(|below| below.z);
                let z = at.z.or_else(ground).ok_or_else(|| {
                    let what = format!("there is no ground below line `{}` at {}, {}", line.name, at.at.x, at.at.y);
                    Error::input(&self.lines, None, what, "give a column z, or a scene with ground there")
                        .because(Problem::Misplaced)
                })?;
                let name = format!("{}#{number}", line.name);
                points.push(EyePoint { name, position: at.at.extend(z + self.height_m), ahead });
            }
        }
        Ok(points)
    }
}

/// Writes `points` as a table of receivers to `path`; `-` is the standard output.
pub fn write_points(path: &Path, points: &[EyePoint]) -> Result<()> {
    let mut table = ReceiverTable::create(path, false)?;
    for EyePoint { name, position, ahead } in points {
        table.write(&ReceiverRow {
            name,
            position: *position,
            normal: *ahead,
            area_m2: None,
            surface: "",
            part: ModelPart::default(),
            patch: Patch::default(),
            reason: None,
        })?;
    }
    table.finish()
}
