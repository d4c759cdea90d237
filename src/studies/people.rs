//! Points where people stand. In: a scene, a table of points or surfaces to stand on. Out: six
//! receivers a point, and the archive of the scene with them.

use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::covering::{CoverRequest, cover_scene};
use crate::pv::placed;
use crate::site_build::{FolderOption, SiteBuild, SiteFolder};
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::planning::AccuracyRequest;
use heliotile_builder::siting::Siting;
use heliotile_comfort::people::columns::PLANES;
use heliotile_comfort::people::points::receiver_name;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::observer::Observer;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::north::North;
use heliotile_core::site::patch::Patch;
use heliotile_core::text::counted;
use heliotile_core::units::parse_metres;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::ComfortRequest;
use heliotile_results::outputs::receivers::{ReceiverRow, ReceiverTable};
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::covering::cover::Density;
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::points::places::{PointDefaults, read_points};
use heliotile_scene::region_part::RegionPart;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;

/// Value of the column `kind` for receivers of people.
const PERSON: &str = "person";
/// Area of a point of a table, m2: a map draws it as a square of one metre.
const POINT_M2: f64 = 1.0;

/// Allowed distances between points, metres; `HEIGHTS_M` are the allowed heights of people.
const SPACINGS_M: RangeInclusive<f64> = 0.1..=1000.0;
const HEIGHTS_M: RangeInclusive<f64> = 0.05..=10.0;

/// Request for the archive of a scene with people.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct ComfortSiteRequest {
    /// Scene with the people.
    #[field(flatten, without("grid_north"))]
    pub scene: SceneRequest,
    /// Positions of people, CSV with columns point,x,y and optionally z or height [default: on the
    /// ground, --spacing apart].
    #[field(metavar = "FILE", conflicts("on", "spacing"), input = Any)]
    pub points: Option<PathBuf>,
    /// Kinds of surfaces, or materials, that people stand on; several with commas.
    #[field(metavar = "KINDS", delimiter = ',', default = "ground")]
    pub on: Vec<String>,
    /// Distance between people, such as 2m.
    #[field(metavar = "LENGTH", default = "2m", parse = parse_metres, range = SPACINGS_M, says = "give a length from 10cm to 1km")]
    pub spacing_m: f64,
    /// Height of the middle of a person above the ground.
    #[field(metavar = "LENGTH", default = "1.1m", parse = parse_metres, name = "body_height", range = HEIGHTS_M, says = "give a length from 5cm to 10m")]
    pub height_m: f64,
    /// Accuracy of the archive.
    #[field(flatten)]
    pub accuracy: AccuracyRequest,
    /// Folder to write: receivers.csv and site.helio, which a later call with the same inputs uses
    /// again [default: the name of the first scene file, with .people].
    #[field(metavar = "FOLDER", output = Folder(&["receivers.csv"]))]
    pub folder: PathBuf,
    /// Replace results in the folder that are of another scene, points or accuracy; without this
    /// option they are an error.
    #[field(neutral)]
    pub replace: bool,
}

/// Point where a person stands.
struct Stand {
    name: String,
    position: DVec3,
    area_m2: Option<f64>,
    patch: Patch,
}

/// Loaded scene and its objects.
struct LoadedScene {
    scene: Scene,
    soup: ObjectTriangles,
    within: Option<RegionPart>,
}

impl LoadedScene {
    fn new(site: &SceneFiles, observer: &dyn Observer) -> Result<Self> {
        let (scene, soup) = Scene::load_with_objects(site)?;
        scene.report.tell(observer);
        Ok(LoadedScene { scene, soup, within: site.within })
    }
}

impl ComfortSiteRequest {
    /// Returns a request for people on the ground, 2 m apart.
    pub fn new(scene: SceneRequest, folder: impl Into<PathBuf>) -> Self {
        ComfortSiteRequest { scene, folder: folder.into(), ..ComfortSiteRequest::default() }
    }

    /// Builds the archive, unless the existing one has the same inputs, and returns its path.
    /// `asked` is the request that will be made of the archive: a wrong weather file in it is
    /// refused before anything is traced or written.
    pub fn build(&self, asked: Option<&ComfortRequest>, resources: &Resources) -> Result<PathBuf> {
        let observer = resources.observer;
        check_ranges(self)?;
        let site = self.scene.site()?;
        let (load, mut loaded) = (|| LoadedScene::new(&site, observer), None);
        // Weather is checked before the scene is loaded, which takes longer. A weather file that
        // states no place takes the scene's, which loads the scene.
        if let Some(asked) = asked {
            asked.check_weather(resources, &mut || Ok(loaded.insert(load()?).scene.place))?;
        }
        let load = || loaded.map_or_else(load, Ok);
        let (scene, stands) = match &self.points {
            Some(table) => self.on_points(table, load, observer)?,
            None => self.on_surfaces(load, observer)?,
        };
        let archive = self.folder.join("site.helio");
        fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create"))?;
        let beside = tempfile::Builder::new().prefix(".comfort").tempdir_in(&self.folder);
        let beside = beside.map_err(Error::io(&self.folder, "make a folder in"))?;
        let receivers = beside.path().join("receivers.csv");
        write_receivers(&receivers, &stands, North::new(scene.place.as_ref()))?;
        let build = SiteBuild {
            memory: resources.memory,
            files: resources.files,
            ..SiteBuild::new(&scene, &receivers, &self.accuracy)
        };
        let folder = SiteFolder {
            folder: &self.folder,
            archive: &archive,
            replace: self.replace,
            named_by: FolderOption::Folder,
        };
        build.ensure(&folder, observer)?;
        let to = self.folder.join("receivers.csv");
        fs::rename(&receivers, &to).map_err(Error::io(&to, "rename to"))?;
        Ok(archive)
    }

    /// Returns the points of a table; refuses a point inside an object.
    fn on_points(
        &self,
        table: &Path,
        load: impl FnOnce() -> Result<LoadedScene>,
        observer: &dyn Observer,
    ) -> Result<(Scene, Vec<Stand>)> {
        let mut warnings = Vec::new();
        let defaults = PointDefaults { needs_turns: false, height_m: Some(self.height_m) };
        let points = read_points(table, defaults, &mut warnings)?;
        warnings.iter().for_each(|text| observer.warn(text));
        let LoadedScene { scene, .. } = load()?;
        let prepared = PreparedScene::new(&scene)?;
        let siting = Siting::new(&prepared);
        let stand = |point| {
            let spot = placed(table, point, &siting)?;
            Ok(Stand { name: spot.name, position: spot.position, area_m2: Some(POINT_M2), patch: Patch::default() })
        };
        let stands = points.iter().map(stand).collect::<Result<_>>()?;
        Ok((scene, stands))
    }

    /// Returns points above surfaces, without those inside objects.
    fn on_surfaces(
        &self,
        load: impl FnOnce() -> Result<LoadedScene>,
        observer: &dyn Observer,
    ) -> Result<(Scene, Vec<Stand>)> {
        let LoadedScene { scene, soup, within } = load()?;
        let density = Density::Spacing(self.spacing_m);
        let cover = CoverRequest { on: self.on.clone(), density, within, ..CoverRequest::default() };
        let covered = cover_scene(&scene, soup, &cover, observer)?;
        let prepared = PreparedScene::new(&scene)?;
        let siting = Siting::new(&prepared);
        let (mut stands, mut inside) = (Vec::new(), 0);
        for (name, piece, ..) in covered.free() {
            let position = piece.position + self.height_m * DVec3::Z;
            if siting.enclosed(position).is_some() {
                inside += 1;
                continue;
            }
            let patch = Patch::of_triangles(position, piece.normal, &piece.triangles);
            stands.push(Stand { name, position, area_m2: Some(piece.area_m2), patch });
        }
        if inside > 0 {
            let counted = counted(inside, "point");
            observer.note(format!("{counted} of {} left out: inside of objects", stands.len() as u64 + inside));
        }
        if stands.is_empty() {
            let what = "no point is left: all points lie inside of objects";
            return Err(Error::argument("on", what, "choose other surfaces, or give a table of points"));
        }
        Ok((scene, stands))
    }
}

/// Writes six receivers a point; the sides face true north, east, south and west.
fn write_receivers(path: &Path, stands: &[Stand], north: North) -> Result<()> {
    let normals = [DVec3::Z, DVec3::NEG_Z, DVec3::Y, DVec3::X, DVec3::NEG_Y, DVec3::NEG_X];
    let part = ModelPart { kind: PERSON.to_owned(), ..ModelPart::default() };
    let mut table = ReceiverTable::create(path, false)?;
    for stand in stands {
        for (plane, normal) in normals.into_iter().enumerate().take(PLANES.len()) {
            let is_up = plane == 0;
            table.write(&ReceiverRow {
                name: &receiver_name(&stand.name, plane),
                position: stand.position,
                normal: north.to_axes(normal),
                area_m2: stand.area_m2.filter(|_| is_up),
                surface: &stand.name,
                part: part.clone(),
                patch: if is_up { stand.patch.clone() } else { Patch::default() },
                reason: None,
            })?;
        }
    }
    table.finish()
}
