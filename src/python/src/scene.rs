//! A scene, and the archive that is traced from it. In: scene files, receivers, accuracy. Out: a
//! scene; an archive.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::archive::ArchiveHandle;
use crate::asked::Memory;
use crate::errors::{raised, worded_text, wrong};
use crate::studies::request;
use crate::work;
use heliotile::covering::{check_name, cover_scene, save, summary};
use heliotile::names::by_name;
use heliotile::output::guard_site;
use heliotile::tracing::Placement;
use heliotile::{
    AccuracyRequest, CoverRequest, Density, EffectChoice, FootprintOptions, HeightAbove, HeightSource, Observer,
    Output, Quality, ReceiverCsv, Result, Scene, SceneFiles, SceneRequest, SiteBuild, SiteFrame, Start, SurfaceRasters,
    UpAxis, check_output,
};

/// A scene that was read from files.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct SceneHandle {
    scene: Arc<Scene>,
    site: SceneFiles,
}

/// Files of a scene, and options of how to read them.
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
    grid_north: bool,
    elevation: Option<f64>,
    scale: Option<f64>,
    up: Option<String>,
    height: Vec<String>,
    storey_height: Option<f64>,
    base: Option<String>,
    height_above: Option<String>,
    layer: Vec<String>,
    dsm: Option<PathBuf>,
    dem: Option<PathBuf>,
    canopy: Option<PathBuf>,
    landcover: Option<PathBuf>,
}

/// Table of receivers: a file, or its text.
#[derive(FromPyObject)]
pub enum ReceiverTable {
    Text(PyBackedBytes),
    File(PathBuf),
}

impl ReceiverTable {
    fn csv(&self) -> ReceiverCsv<'_> {
        match self {
            ReceiverTable::Text(text) => ReceiverCsv::Text { name: Path::new("receivers"), text },
            ReceiverTable::File(file) => ReceiverCsv::File(file),
        }
    }

    fn file(&self) -> Option<&Path> {
        if let ReceiverTable::File(file) = self { Some(file) } else { None }
    }
}

/// Options of a build.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct BuildArgs {
    output: PathBuf,
    quality: String,
    error: Option<f64>,
    error_weather: Option<PathBuf>,
    /// Options for reading `error_weather`, as JSON.
    about_error_weather: String,
    settings: Vec<String>,
    effects: String,
    with_scene: bool,
    /// Archive of the scene before it was changed.
    before: Option<PathBuf>,
    /// Bound of a preview, percent of the light on open ground.
    preview: Option<f64>,
    fresh: bool,
    checkpoint: f64,
    memory: Memory,
}

/// Archive, seconds by stage, number of rays, bytes, and the estimated error in percent.
type Built = (ArchiveHandle, Vec<(&'static str, f64)>, u64, u64, Option<f64>);

/// Options of where receivers are placed.
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

impl CoverArgs {
    fn request(self) -> Result<CoverRequest> {
        let CoverArgs { on, types, spacing, per_surface, offset: offset_m, min_area: min_area_m2 } = self;
        let density = per_surface.map_or(Density::Spacing(spacing), Density::PerSurface);
        let request = CoverRequest { on, types, density, offset_m, min_area_m2, ..CoverRequest::default() };
        request.check().map(|()| request)
    }
}

impl SceneArgs {
    fn request(self) -> Result<SceneRequest> {
        let up = self.up.map(|name| by_name::<UpAxis>("up", &name)).transpose()?;
        let source = |field: &'static str, text: &String| {
            text.parse::<HeightSource>().map_err(wrong(field, "give the name of a column, or metres such as 9.5m"))
        };
        let footprints = FootprintOptions {
            height: self.height.iter().map(|text| source("height", text)).collect::<Result<_>>()?,
            storey_height_m: self.storey_height,
            base: self.base.as_ref().map(|text| source("base", text)).transpose()?,
            height_above: self.height_above.map(|name| by_name::<HeightAbove>("height_above", &name)).transpose()?,
            layer: self.layer,
        };
        Ok(SceneRequest {
            footprints,
            files: self.files,
            materials: self.materials,
            materials_only: self.materials_only,
            no_ground: !self.assume_ground,
            assume_version: None,
            frame: SiteFrame {
                epsg: self.crs,
                latitude_deg: self.latitude,
                longitude_deg: self.longitude,
                rotate_deg: self.rotate_deg,
                grid_north: self.grid_north,
                elevation_m: self.elevation,
                scale: self.scale,
                up,
            },
            surface: SurfaceRasters::of_files(self.dsm, self.dem, self.canopy, self.landcover).unwrap_or_default(),
        })
    }
}

#[pymethods]
impl SceneHandle {
    /// Reads a scene.
    #[staticmethod]
    fn load(py: Python<'_>, args: SceneArgs) -> PyResult<Self> {
        work::run(py, None, |watch| {
            let site = args.request()?.site()?;
            let scene = Scene::load_site(&site)?;
            scene.report.warnings.iter().for_each(|w| watch.warn(w));
            Ok(SceneHandle { scene: Arc::new(scene), site })
        })
    }

    #[getter]
    fn triangles(&self) -> usize {
        self.scene.mesh.triangles.len()
    }

    /// Name, diffuse and specular reflectance of each material.
    #[getter]
    fn materials(&self) -> Vec<(String, f64, f64)> {
        self.scene.materials.iter().map(|m| (m.name.clone(), m.diffuse, m.specular)).collect()
    }

    /// Latitude and longitude, degrees.
    #[getter]
    fn place(&self) -> Option<(f64, f64)> {
        self.scene.place.map(|place| (place.latitude_deg, place.longitude_deg))
    }

    /// Decisions that the reader took by itself.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.scene.report.notes.iter().map(|note| worded_text(note)).collect()
    }

    /// Writes a table of receivers on surfaces. Returns their number and a summary.
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
            Ok((covered.count(Placement::Free), worded_text(&summary(&covered, &scene))))
        })
    }

    /// Traces an archive. Returns its handle, seconds by stage, number of rays, bytes, and the
    /// estimated error in percent.
    #[pyo3(signature = (receivers, args, progress))]
    fn build(
        &self,
        py: Python<'_>,
        receivers: ReceiverTable,
        args: BuildArgs,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Built> {
        let accuracy = args.accuracy().map_err(|error| raised(py, error))?;
        work::run(py, progress.as_ref(), |watch| {
            let inputs = [receivers.file(), args.error_weather.as_deref(), args.before.as_deref()];
            // A wrong output is an error before the long work starts.
            check_output(&args.output, &self.site, &inputs)?;
            let effects = args.effects.parse::<EffectChoice>();
            let build = SiteBuild {
                effects: effects.map_err(wrong("effects", "give \"auto\", \"all\", \"none\" or some names"))?,
                with_scene: args.with_scene,
                from: args.before.as_deref(),
                preview_percent: args.preview,
                memory: args.memory.0,
                ..SiteBuild::new(&self.scene, receivers.csv(), &accuracy)
            };
            let output = Output {
                path: args.output.clone(),
                start: if args.fresh { Start::Fresh } else { Start::Resume },
                checkpoint_every: Duration::try_from_secs_f64(args.checkpoint)
                    .map_err(wrong("checkpoint", "give a number of seconds, 0 or more"))?,
            };
            let done = build.build(&output, watch)?;
            let archive = ArchiveHandle::of(&args.output)?;
            let error = done.plan.accuracy.map(|accuracy| accuracy.rmse_percent);
            let report = done.report;
            Ok((archive, report.seconds, report.rays.total(), report.bytes, error))
        })
    }
}

impl BuildArgs {
    /// Returns the accuracy request. Wrong arguments are errors here, before any file is read.
    fn accuracy(&self) -> Result<AccuracyRequest> {
        let accuracy = AccuracyRequest {
            quality: by_name::<Quality>("quality", &self.quality)?,
            set: self.settings.clone(),
            error_percent: self.error,
            error_weather: self.error_weather.clone(),
            weather_options: request(&self.about_error_weather)?,
        };
        accuracy.settings().map(|_| accuracy)
    }
}
