//! Receivers above the ground, in place of surfaces: along lines, each looking in the direction of
//! travel, or within areas, level. In: a scene, a file of lines or areas. Out: the table of
//! receivers that builds read.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use heliotile_archives::transfer::Bounds;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_core::text::counted;
use heliotile_files::input;
use heliotile_requests::{Form, Parse, Wrong};
use heliotile_results::outputs::receivers::{ReceiverRow, ReceiverTable};
use heliotile_scene::Scene;
use heliotile_scene::covering::cover::MAX_POINTS;
use heliotile_scene::points::areas::{GroundArea, read_areas};
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

/// Request for level receivers within areas.
#[derive(Clone, Debug, PartialEq)]
pub struct WithinRequest {
    pub areas: AreaSource,
    /// Distance between receivers, metres.
    pub spacing_m: f64,
    /// Height above the ground, metres.
    pub above_m: f64,
}

/// Areas that get receivers.
#[derive(Clone, Debug, PartialEq)]
pub enum AreaSource {
    /// File of polygons, or CSV file of their corners: columns `x` and `y`, and optionally `area`.
    File(PathBuf),
    /// A box in plan.
    Box(Bounds),
}

/// Receiver above the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundPoint {
    /// Name of the receiver: the name of its line or area with a number.
    pub name: String,
    /// Position in input coordinates.
    pub position: DVec3,
    /// Direction that it faces.
    pub normal: DVec3,
    /// Area that it stands for, m2, and the name of this area; `None` on a line.
    pub part: Option<(f64, String)>,
}

impl GroundPoint {
    /// Returns the name of its area, if it lies in one.
    pub fn area(&self) -> Option<&str> {
        self.part.as_ref().map(|(_, name)| name.as_str())
    }
}

/// Ending of the name of a line that is travelled backwards.
const BACK: &str = "-back";

/// Name of the area of a box.
const BOX: &str = "box";

/// Height above the ground from which something stands on it, metres: less is the thickness of a
/// paving stone.
const STANDS_M: f64 = 0.01;

/// Ground of a scene.
pub(crate) struct Ground<'a> {
    siting: Siting<'a>,
    highest_m: f64,
    /// EPSG number of the scene's coordinates, if they have one.
    system: Option<u32>,
}

impl<'a> Ground<'a> {
    /// Returns the ground of a scene.
    pub(crate) fn new(prepared: &'a PreparedScene<'a>) -> Self {
        let mesh = &prepared.scene.mesh;
        let system = prepared.scene.place.and_then(|place| place.epsg);
        Ground { siting: Siting::new(prepared), highest_m: mesh.origin.z + mesh.bounds().1.z, system }
    }

    /// Hands the ground of a site to `take`.
    fn of<T>(site: &SceneFiles, observer: &dyn Observer, take: impl FnOnce(&Ground) -> Result<T>) -> Result<T> {
        let scene = Scene::load_site(site)?;
        scene.report.tell(observer);
        take(&Ground::new(&PreparedScene::new(&scene)?))
    }

    /// Returns the height of the ground at a place, whatever stands on it.
    pub(crate) fn height_m(&self, at: DVec2) -> Option<f64> {
        self.siting.ground_below(at.extend(self.highest_m + 1.0)).map(|below| below.z)
    }

    /// Returns the height of what stands above the ground at a place; 0 if nothing does.
    pub(crate) fn built_m(&self, at: DVec2, ground_m: f64) -> f64 {
        self.siting.top(at.x, at.y).map_or(0.0, |top| top.z - ground_m).max(0.0)
    }

    /// Returns true if a point above the ground lies inside of something that stands there.
    fn is_built(&self, point: DVec3) -> bool {
        let top = self.siting.top(point.x, point.y);
        top.is_some_and(|top| top.z > point.z + STANDS_M) && self.siting.enclosed(point).is_some()
    }
}

/// Refuses distances out of range, and more than [`MAX_POINTS`] receivers.
fn check_distances(metres: [(&str, f64); 2], count: f64) -> Result<()> {
    for (field, metres) in metres {
        if !(0.001..=10_000.0).contains(&metres) {
            return Err(Error::argument(field, format!("is {metres} m"), "give 0.001 to 10000 metres"));
        }
    }
    if count > MAX_POINTS {
        let what = format!("{} m would give {:.0} million receivers", metres[0].1, count / 1e6);
        return Err(Error::argument(metres[0].0, what, "give a wider spacing, or shorter lines and smaller areas"));
    }
    Ok(())
}

impl AlongRequest {
    /// Returns the receivers on the scene of `site`. Errors: numbers out of range, lines that
    /// cannot be read, no ground below a point.
    pub fn points(&self, site: &SceneFiles, observer: &dyn Observer) -> Result<Vec<GroundPoint>> {
        let lines = read_lines(&self.lines)?;
        let count: f64 = lines.iter().map(|line| line.length_m() / self.spacing_m).sum();
        check_distances([("spacing", self.spacing_m), ("eye_height", self.height_m)], count)?;
        Ground::of(site, observer, |ground| self.on(ground, &lines))
    }

    fn on(&self, ground: &Ground, lines: &[TravelLine]) -> Result<Vec<GroundPoint>> {
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
                let z = at.z.or_else(|| ground.height_m(at.at)).ok_or_else(|| {
                    let what = format!("there is no ground below line `{}` at {}, {}", line.name, at.at.x, at.at.y);
                    Error::input(&self.lines, None, what, "give a column z, or a scene with ground there")
                        .because(Problem::Misplaced)
                })?;
                let name = format!("{}#{number}", line.name);
                points.push(GroundPoint { name, position: at.at.extend(z + self.height_m), normal: ahead, part: None });
            }
        }
        Ok(points)
    }
}

impl WithinRequest {
    /// Returns the receivers on the scene of `site`. Places inside of buildings, and those without
    /// ground, are left out and counted in a warning. Errors: numbers out of range, areas that
    /// cannot be read, no receiver at all.
    pub fn points(&self, site: &SceneFiles, observer: &dyn Observer) -> Result<Vec<GroundPoint>> {
        self.areas.check()?;
        let (points, [built, bare]) = Ground::of(site, observer, |ground| {
            let areas = self.areas.read(ground.system, observer)?;
            let count = areas.iter().map(|area| area.most_places(self.spacing_m)).sum();
            check_distances([("spacing", self.spacing_m), ("offset", self.above_m)], count)?;
            Ok(self.on(ground, &areas))
        })?;
        for (count, why) in [(built, "inside a building"), (bare, "without ground below them")] {
            if count > 0 {
                observer.warn(format!("{} left out: {why}", counted(count, "place")));
            }
        }
        if points.is_empty() {
            let hint = "give areas on free ground of the scene, in its coordinates, or a smaller spacing";
            return Err(Error::argument("within", "no receiver lies there", hint).because(Problem::Misplaced));
        }
        Ok(points)
    }

    /// Returns the receivers, and the numbers of places in buildings and without ground.
    fn on(&self, ground: &Ground, areas: &[GroundArea]) -> (Vec<GroundPoint>, [u64; 2]) {
        let (mut points, mut left_out) = (Vec::new(), [0; 2]);
        let area_m2 = self.spacing_m * self.spacing_m;
        for area in areas {
            for (number, at) in (1..).zip(area.places(self.spacing_m)) {
                let Some(z) = ground.height_m(at) else {
                    left_out[1] += 1;
                    continue;
                };
                let position = at.extend(z + self.above_m);
                if ground.is_built(position) {
                    left_out[0] += 1;
                    continue;
                }
                let (name, part) = (format!("{}#{number}", area.name), Some((area_m2, area.name.clone())));
                points.push(GroundPoint { name, position, normal: DVec3::Z, part });
            }
        }
        (points, left_out)
    }
}

impl AreaSource {
    /// Refuses a file that is not there.
    pub(crate) fn check(&self) -> Result<()> {
        if let AreaSource::File(file) = self { input::check(file) } else { Ok(()) }
    }

    /// Returns the areas, in metres of the plane system `scene` (an EPSG number).
    pub(crate) fn read(&self, scene: Option<u32>, observer: &dyn Observer) -> Result<Vec<GroundArea>> {
        match self {
            AreaSource::File(file) => {
                let (areas, said) = read_areas(file, scene)?;
                said.into_iter().for_each(|said| observer.warn(said));
                Ok(areas)
            }
            AreaSource::Box(Bounds { low, high }) => {
                Ok(vec![GroundArea::of_box(BOX.to_owned(), low.truncate(), high.truncate())])
            }
        }
    }
}

/// Four numbers are a box in plan, xmin,ymin,xmax,ymax; any other text is a path.
impl Parse for AreaSource {
    fn form() -> Form {
        Form::PATH
    }

    fn parse(text: &str) -> std::result::Result<Self, Wrong> {
        let is_number = |part: &str| part.trim().parse::<f64>().is_ok();
        match text.contains(',') && text.split(',').all(is_number) {
            true => Bounds::parse(text).map(AreaSource::Box),
            false => PathBuf::parse(text).map(AreaSource::File),
        }
    }

    fn path(&self) -> Option<&Path> {
        if let AreaSource::File(file) = self { Some(file) } else { None }
    }
}

/// Writes `points` as a table of receivers to `path`; `-` is the standard output.
pub fn write_points(path: &Path, points: &[GroundPoint]) -> Result<()> {
    let mut table = ReceiverTable::create(path, false)?;
    for GroundPoint { name, position, normal, part } in points {
        table.write(&ReceiverRow {
            name,
            position: *position,
            normal: *normal,
            area_m2: part.as_ref().map(|(area_m2, _)| *area_m2),
            surface: part.as_ref().map_or("", |(_, name)| name),
            part: ModelPart::default(),
            patch: Patch::default(),
            reason: None,
        })?;
    }
    table.finish()
}
