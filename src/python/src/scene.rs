//! A scene, and the archive that is traced of it. In: files of the world, receivers, how exact it is to be. Out: a scene; an archive.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::archive::ArchiveHandle;
use crate::errors::{raised, wrong};
use crate::work::{self, Watch};
use heliotile::covering::{CoverRequest, Density, check_name, cover_scene, save, summary};
use heliotile::files::{is_address, read_receivers, read_weather_as, shown};
use heliotile::guards::{check_archive_name, guard_archive, guard_site};
use heliotile::{
    Build, EffectChoice, Error, ErrorTarget, MemoryBudget, Observer, Output, PlanRequest, PreparedScene, Quality,
    Result, Rungs, Scene, Start, Workspace, by_name, nothing_seen,
};
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::trace::placement::Lying;
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_scene::placing::frame::{SiteFrame, check_elevation, check_epsg, check_rotation, check_scale};
use heliotile_scene::site::{MissingGround, Site};

/// A scene that was read.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct SceneHandle {
    scene: Arc<Scene>,
    site: Site,
}

/// Files, and what is said about them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SceneArgs {
    files: Vec<PathBuf>,
    materials: Option<PathBuf>,
    materials_only: bool,
    assume_ground: bool,
    crs: Option<u32>,
    latitude: Option<f64>,
    longitude: Option<f64>,
    rotate_deg: Option<f64>,
    elevation: Option<f64>,
    scale: Option<f64>,
}

/// Points that get light: a file, or the bytes of one.
#[derive(FromPyObject)]
pub enum ReceiverSource {
    Table(PyBackedBytes),
    File(PathBuf),
}

/// How an archive is built.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct BuildArgs {
    output: PathBuf,
    quality: String,
    error: Option<f64>,
    error_weather: Option<PathBuf>,
    settings: Vec<String>,
    effects: String,
    with_scene: bool,
    fresh: bool,
    checkpoint: f64,
    memory: u64,
}

/// The archive, seconds by stage, rays, bytes, and the estimated error in percent.
type Built = (ArchiveHandle, Vec<(&'static str, f64)>, u64, u64, Option<f64>);

/// Where receivers are put.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct CoverArgs {
    on: Vec<String>,
    types: Vec<String>,
    spacing: f64,
    per_surface: Option<u32>,
    offset: f64,
    min_area: f64,
}

/// Lengths of distances between receivers and off surfaces, metres, as on the command line.
const LENGTHS: std::ops::RangeInclusive<f64> = 0.001..=10_000.0;

impl CoverArgs {
    fn request(self) -> Result<CoverRequest> {
        for (name, metres) in [("spacing", self.spacing), ("offset", self.offset)] {
            if !LENGTHS.contains(&metres) {
                return Err(Error::argument(name, format!("is {metres} m"), "give 0.001 to 10000 metres"));
            }
        }
        if !(0.0..=1e9).contains(&self.min_area) {
            return Err(Error::argument("min_area", format!("is {} m2", self.min_area), "give 0 to 1e9 m2"));
        }
        let density = match self.per_surface {
            None => Density::Spacing(self.spacing),
            Some(count @ 1..=1_000_000) => Density::PerSurface(count),
            Some(count) => {
                return Err(Error::argument("per_surface", format!("is {count}"), "give 1 to 1000000 receivers"));
            }
        };
        let CoverArgs { on, types, offset: offset_m, min_area: min_area_m2, .. } = self;
        Ok(CoverRequest { on, types, density, offset_m, min_area_m2, within: None })
    }
}

/// Errors that can be aimed at, percent, as on the command line.
const ERRORS: std::ops::RangeInclusive<f64> = 0.1..=50.0;

impl SceneArgs {
    fn site(&self) -> Result<Site> {
        let hint = "give what the scene's coordinates are in";
        let checked = |name, value: Option<f64>, check: fn(f64) -> std::result::Result<f64, String>| {
            value.map(check).transpose().map_err(wrong(name, hint))
        };
        let degrees = |name, value: Option<f64>, most: f64| match value {
            Some(value) if !(-most..=most).contains(&value) => {
                Err(Error::argument(name, format!("is {value}"), format!("give degrees from -{most} to {most}")))
            }
            value => Ok(value),
        };
        if self.latitude.is_some() != self.longitude.is_some() {
            return Err(Error::argument("latitude, longitude", "one is given without the other", "give both"));
        }
        let frame = SiteFrame {
            epsg: self.crs.map(check_epsg).transpose().map_err(wrong("crs", hint))?,
            latitude_deg: degrees("latitude", self.latitude, 90.0)?,
            longitude_deg: degrees("longitude", self.longitude, 180.0)?,
            rotate_deg: checked("rotate_deg", self.rotate_deg, check_rotation)?,
            elevation_m: checked("elevation", self.elevation, check_elevation)?,
            scale: checked("scale", self.scale, check_scale)?,
            up: None,
        };
        let mut site = Site::of(&self.files, self.materials.as_deref())?;
        if self.assume_ground {
            site.missing_ground = MissingGround::Assume;
        }
        site.parts.iter_mut().for_each(|part| part.materials_only |= self.materials_only);
        Ok(site.framed(&frame))
    }
}

#[pymethods]
impl SceneHandle {
    /// Reads a scene.
    #[staticmethod]
    fn load(py: Python<'_>, args: SceneArgs) -> PyResult<Self> {
        work::run(py, None, |watch| {
            let site = args.site()?;
            let scene = Scene::load_site(&site)?;
            scene.report.warnings.iter().for_each(|w| watch.warn(w));
            Ok(SceneHandle { scene: Arc::new(scene), site })
        })
    }

    #[getter]
    fn triangles(&self) -> usize {
        self.scene.mesh.triangles.len()
    }

    /// Names, diffuse and specular reflectance.
    #[getter]
    fn materials(&self) -> Vec<(String, f64, f64)> {
        self.scene.materials.iter().map(|m| (m.name.clone(), m.diffuse, m.specular)).collect()
    }

    /// Latitude and longitude, degrees.
    #[getter]
    fn place(&self) -> Option<(f64, f64)> {
        self.scene.place.map(|place| (place.latitude_deg, place.longitude_deg))
    }

    /// What was decided that nobody asked for.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.scene.report.notes.clone()
    }

    /// Writes the table of receivers on surfaces: their number, and what was covered in words.
    fn cover(
        &self,
        py: Python<'_>,
        output: PathBuf,
        args: CoverArgs,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<(usize, String)> {
        let request = args.request().map_err(|error| raised(py, error))?;
        work::run(py, progress.as_ref(), |watch| {
            check_name(&output)?;
            guard_site(&output, &self.site, &[])?;
            let (scene, soup) = Scene::load_with_objects(&self.site)?;
            let covered = cover_scene(&scene, soup, &request, watch)?;
            save(&output, &covered, request.offset_m)?;
            Ok((covered.count(Lying::Free), summary(&covered, &scene)))
        })
    }

    /// Traces an archive: its handle, seconds by stage, rays, bytes and the estimated error in percent.
    #[pyo3(signature = (receivers, args, progress))]
    fn build(
        &self,
        py: Python<'_>,
        receivers: ReceiverSource,
        args: BuildArgs,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Built> {
        let settings = args.settings().map_err(|error| raised(py, error))?;
        work::run(py, progress.as_ref(), |watch| {
            let folder = folder_of(&args.output);
            let given = Given::of(&receivers)?;
            let inputs = [given.user_file(), args.error_weather.as_deref()];
            if is_address(&args.output) {
                let hint = "write a file, and then: heliotile copy FILE ADDRESS";
                return Err(Error::input(
                    &shown(&args.output),
                    None,
                    "is an address, to which only `copy` writes",
                    hint,
                ));
            }
            check_archive_name(&args.output)?;
            guard_site(&args.output, &self.site, &inputs)?;
            guard_archive(&args.output)?;
            let workspace = Workspace { folder: folder.into(), memory: MemoryBudget::new(args.memory) };
            let (mut receivers, warnings) = read_receivers(given.path(), &self.scene, &workspace)?;
            warnings.iter().for_each(|w| watch.warn(w));
            let prepared = PreparedScene::new(&self.scene)?;
            let mut build =
                Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: watch };
            let suns = args.error.map(|_| args.suns(&self.scene, watch)).transpose()?;
            let target = args.error.zip(suns.as_ref()).map(|(percent, suns)| ErrorTarget { percent, suns });
            let effects = args.effects.parse::<EffectChoice>();
            let effects = effects.map_err(wrong("effects", "give \"auto\", \"all\", \"none\" or some names"))?;
            let mut plan = build.plan(&PlanRequest { settings, effects, under: None, target })?.plan;
            plan.with_scene = args.with_scene;
            let output = Output {
                path: args.output.clone(),
                start: if args.fresh { Start::Fresh } else { Start::Resume },
                checkpoint_every: Duration::try_from_secs_f64(args.checkpoint)
                    .map_err(wrong("checkpoint", "give seconds from 0"))?,
            };
            let advice = "give the inputs that it was started with to go on with it, fresh=True to discard it, or another output";
            let report = build.write(&plan, &output, &[]).map_err(|error| error.advise(advice))?;
            report.warnings.iter().for_each(|w| watch.warn(w));
            let archive = ArchiveHandle::of(&args.output)?;
            nothing_seen(archive.archive())?.iter().for_each(|w| watch.warn(w));
            let error = plan.accuracy.map(|accuracy| accuracy.rmse_percent);
            Ok((archive, report.seconds, report.rays.total(), report.bytes, error))
        })
    }
}

impl BuildArgs {
    fn settings(&self) -> Result<heliotile::BuildSettings> {
        if self.error.is_some_and(|percent| !ERRORS.contains(&percent)) {
            return Err(Error::argument("error", "is no error to aim at", "give 0.1 to 50 percent, as in error=2"));
        }
        let mut settings = Rungs::of(by_name::<Quality>("quality", &self.quality)?).settings();
        self.settings.iter().try_for_each(|text| settings.set(text))?;
        settings.check()?;
        Ok(settings)
    }

    /// What errors are estimated under.
    fn suns(&self, scene: &Scene, watch: &Watch) -> Result<ErrorConditions> {
        let Some(path) = self.error_weather.as_deref() else { return Ok(ErrorConditions::Spread) };
        let weather = read_weather_as(path, &WeatherOptions::default(), &mut || Ok(scene.place))?;
        weather.report.warnings.iter().for_each(|w| watch.warn(w));
        ErrorConditions::of_weather(path, weather)
    }
}

/// A table of receivers on a disk.
enum Given<'a> {
    File(&'a PathBuf),
    Written {
        path: PathBuf,
        /// It goes with the value.
        _folder: tempfile::TempDir,
    },
}

impl<'a> Given<'a> {
    fn of(source: &'a ReceiverSource) -> Result<Self> {
        let bytes = match source {
            ReceiverSource::File(file) => return Ok(Given::File(file)),
            ReceiverSource::Table(bytes) => bytes,
        };
        let system = std::env::temp_dir();
        let folder = tempfile::tempdir().map_err(Error::io(&system, "make a folder in"))?;
        let path = folder.path().join("receivers.csv");
        let mut file = std::fs::File::create(&path).map_err(Error::io(&path, "create"))?;
        file.write_all(bytes).map_err(Error::io(&path, "write to"))?;
        Ok(Given::Written { path, _folder: folder })
    }

    fn path(&self) -> &std::path::Path {
        match self {
            Given::File(file) => file,
            Given::Written { path, .. } => path,
        }
    }

    fn user_file(&self) -> Option<&std::path::Path> {
        match self {
            Given::File(file) => Some(file),
            Given::Written { .. } => None,
        }
    }
}
