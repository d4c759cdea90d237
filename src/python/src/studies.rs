//! Work that writes files. In: requests as JSON, which `heliotile/studies.py` makes of keyword
//! arguments. Out: files, and a summary. Each request is the type that the command line fills, too.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::asked::Memory;
use crate::work;
use heliotile::archive::{open_archive, transfer};
use heliotile::atlas::{CatalogueRequest, PartitionRequest};
use heliotile::memory::SystemTemp;
use heliotile::output::{guard_archive, guard_output};
use heliotile::scene::input;
use heliotile::tracing::Workspace;
use heliotile::{
    Access, ComfortRequest, ComfortSiteRequest, EnergyplusRequest, Error, Observer, Provenance, PvRequest,
    ReplayRequest, Resources, Result, RunRequest, WeatherOptions,
};

/// Folder, archive, names of files, and a table as text.
type Study = (PathBuf, PathBuf, Vec<String>, String);

/// Reads a request from JSON.
pub fn request<T: DeserializeOwned>(text: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|error| {
        let what = error.to_string();
        let what = what.rsplit_once(" at line").map_or(what.as_str(), |(what, _)| what);
        Error::argument("arguments", what, "see the function's documentation")
    })
}

/// Returns the provenance of results: the Python function and its arguments.
pub fn about(function: &str, text: &str) -> Provenance {
    let options: Map<String, Value> = serde_json::from_str(text).unwrap_or_default();
    Provenance::new(format!("heliotile.{function}"), options)
}

/// Returns the resources for work: memory in bytes, scratch space, a reader of files, and an
/// observer.
pub fn resources<'a>(memory: Memory, observer: &'a dyn Observer) -> Resources<'a> {
    Resources { memory: memory.0, storage: &SystemTemp, files: &input::read, observer }
}

/// Writes a year's results of scene files to a folder.
#[pyfunction]
pub fn run(py: Python<'_>, text: String, memory: Memory, progress: Option<Bound<'_, PyAny>>) -> PyResult<Study> {
    work::run(py, progress.as_ref(), |watch| {
        let done = request::<RunRequest>(&text)?.write(about("run", &text), &resources(memory, watch))?;
        Ok((done.folder, done.archive, done.files, done.table))
    })
}

/// Writes the irradiance on solar modules to a folder.
#[pyfunction]
pub fn pv(py: Python<'_>, text: String, memory: Memory, progress: Option<Bound<'_, PyAny>>) -> PyResult<Study> {
    work::run(py, progress.as_ref(), |watch| {
        let done = request::<PvRequest>(&text)?.write(about("pv", &text), &resources(memory, watch))?;
        Ok((done.folder, done.archive, done.files, done.table))
    })
}

/// Request for an archive with people, and the weather of its later replays.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PeopleArgs {
    site: ComfortSiteRequest,
    weather: Option<PathBuf>,
    #[serde(default)]
    about_weather: WeatherOptions,
}

/// Builds the archive of a scene with people. Returns its path.
#[pyfunction]
pub fn comfort(py: Python<'_>, text: &str, memory: Memory, progress: Option<Bound<'_, PyAny>>) -> PyResult<PathBuf> {
    work::run(py, progress.as_ref(), |watch| {
        let PeopleArgs { site, weather, about_weather } = request(text)?;
        let asked = weather.map(|weather| {
            let usual = ComfortRequest::of(weather);
            ComfortRequest { replay: ReplayRequest { about_weather, ..usual.replay }, ..usual }
        });
        site.build(asked.as_ref(), &resources(memory, watch))
    })
}

/// Writes an EnergyPlus model with the sunlight that its surroundings reflect.
#[pyfunction]
pub fn energyplus(py: Python<'_>, text: String, memory: Memory, progress: Option<Bound<'_, PyAny>>) -> PyResult<()> {
    work::run(py, progress.as_ref(), |watch| request::<EnergyplusRequest>(&text)?.write(&resources(memory, watch)))
}

/// Cuts a region into parts. Returns their number and a sentence on the error of the halo, if it
/// was estimated.
#[pyfunction]
#[pyo3(signature = (text, atlas, replace, sample, memory, progress))]
pub fn partition(
    py: Python<'_>,
    text: &str,
    atlas: PathBuf,
    replace: bool,
    sample: usize,
    memory: Memory,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(usize, Option<String>)> {
    work::run(py, progress.as_ref(), |watch| {
        let (cut, memory) = (request(text)?, memory.0);
        let plan = heliotile::atlas::partition(&PartitionRequest { cut, atlas, replace, sample, memory }, watch)?;
        Ok((plan.parts.len(), plan.seams.map(|seams| seams.words())))
    })
}

/// Writes the catalogue of an atlas.
#[pyfunction]
pub fn catalogue(py: Python<'_>, atlas: PathBuf, title: Option<String>, license: String) -> PyResult<()> {
    work::run(py, None, |watch| {
        let about = Provenance::new("heliotile.Atlas.catalogue".to_owned(), Map::new());
        heliotile::atlas::catalogue(&atlas, &CatalogueRequest { title, license }, about, watch)
    })
}

/// Writes the union of two archives of one scene.
#[pyfunction]
pub fn merge(
    py: Python<'_>,
    archives: [PathBuf; 2],
    output: PathBuf,
    memory: Memory,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    work::run(py, progress.as_ref(), |watch| {
        guard_output(&output, &archives.each_ref().map(PathBuf::as_path))?;
        guard_archive(&output)?;
        let [a, b] = archives.each_ref().map(|path| open_archive(path, Access::Read));
        transfer::merge([&a?, &b?], &output, &workspace_of(&output, memory), watch).map(drop)
    })
}

/// Compares two archives. Returns true if they are equal, and their differences as text.
#[pyfunction]
pub fn diff(py: Python<'_>, archives: [PathBuf; 2], memory: Memory) -> PyResult<(bool, String)> {
    work::run(py, None, |_| {
        let [a, b] = archives.each_ref().map(|path| open_archive(path, Access::Read));
        let (a, b) = (a?, b?);
        let found = transfer::diff(&a, &b, &workspace_of(Path::new("-"), memory))?;
        Ok((found.is_equal(), found.table([a.path(), b.path()])))
    })
}

/// Returns the folder and the memory for work on an archive; a folder for temporary files if
/// `output` is `-`.
pub fn workspace_of(output: &Path, memory: Memory) -> Workspace {
    let folder = match output == Path::new("-") {
        true => std::env::temp_dir(),
        false => heliotile::output::folder_of(output).to_path_buf(),
    };
    Workspace { folder, memory: memory.0 }
}
