//! A scene, and the archive that is traced from it. In: scene files, receivers, accuracy. Out: a
//! scene; an archive.

use std::sync::Arc;

use pyo3::prelude::*;

use crate::archive::ArchiveHandle;
use crate::asked::Keywords;
use crate::errors::worded_text;
use crate::studies::loaded;
use heliotile::cases::Build;
use heliotile::{Scene, SceneRequest};

/// A scene that was read from files.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct SceneHandle {
    scene: Arc<Scene>,
}

/// Archive, seconds by stage, number of rays, bytes, and the estimated error in percent.
type Built = (ArchiveHandle, Vec<(&'static str, f64)>, u64, u64, Option<f64>);

#[pymethods]
impl SceneHandle {
    /// Reads a scene.
    #[staticmethod]
    fn load(py: Python<'_>, asked: Keywords) -> PyResult<Self> {
        asked.run::<SceneRequest, _>(py, &[], None, |request, _, resources| {
            Ok(SceneHandle { scene: Arc::new(loaded(request, resources.observer)?) })
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
        self.scene.report.notes.iter().map(worded_text).collect()
    }

    /// Traces an archive. Returns its handle, seconds by stage, number of rays, bytes, and the
    /// estimated error in percent.
    #[pyo3(signature = (asked, progress))]
    fn build(&self, py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<Built> {
        asked.run::<Build, _>(py, &[], progress.as_ref(), |args, _, resources| {
            let (output, receivers) = args.check()?;
            let done = args.trace(&self.scene, asked.table(receivers), output, resources)?;
            let (error, report) = (done.plan.accuracy.map(|accuracy| accuracy.rmse_percent), done.report);
            Ok((ArchiveHandle::just_written(output)?, report.seconds, report.rays.total(), report.bytes, error))
        })
    }
}
