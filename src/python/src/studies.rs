//! Work that reads and writes files. In: requests. Out: files, and a summary: plain values, JSON,
//! or text for people.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use serde::Serialize;

use crate::asked::Keywords;
use crate::errors::worded_text;
use heliotile::archive::Problem;
use heliotile::atlas::{PartitionRequest, VerifyRequest};
use heliotile::cases::{
    Audit, Build, Catalogue, Comfort, Diff, Energyplus, Export, Merge, Pv, Receivers, Repair, Run, Tradeoff, Update,
    View,
};
use heliotile::{Access, Error, PageRequest, ReportRequest, Result, Scene, SceneRequest};

/// Folder, archive, names of files, and a table as text.
type Study = (PathBuf, PathBuf, Vec<String>, String);

/// Block, offset in bytes and reason of a problem.
type ProblemRow = (String, u64, String);

/// Archive, number of its blocks, their bytes, bytes behind its end, problems, the reason why it is
/// not the archive of its part, and all of this as text.
type CheckedRow = (PathBuf, u64, u64, u64, Vec<ProblemRow>, Option<String>, String);

/// New archive; counts of receivers kept, moved, gone and new; names of buried receivers; rays
/// traced; and these as text.
type UpdateRow = (PathBuf, [usize; 4], Vec<String>, u64, String);

/// Returns a result as JSON.
fn json(found: &impl Serialize) -> Result<String> {
    serde_json::to_string(found).map_err(|error| Error::io(Path::new("the result"), "write")(error.into()))
}

fn rows(problems: Vec<Problem>) -> Vec<ProblemRow> {
    problems.into_iter().map(|problem| (problem.part, problem.offset, problem.reason)).collect()
}

/// Writes a year's results of scene files to a folder.
#[pyfunction]
pub fn run(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<Study> {
    asked.run::<Run, _>(py, &[], progress.as_ref(), |args, about, resources| {
        let done = args.request.write(about, resources)?;
        Ok((done.folder, done.archive, done.files, done.table))
    })
}

/// Writes the irradiance on solar modules to a folder.
#[pyfunction]
pub fn pv(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<Study> {
    asked.run::<Pv, _>(py, &[], progress.as_ref(), |args, about, resources| {
        let done = args.request.write(about, resources)?;
        Ok((done.folder, done.archive, done.files, done.table))
    })
}

/// Builds the archive of a scene with people, for later replays of the weather, if it is given.
/// Returns its path.
#[pyfunction]
pub fn comfort(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<PathBuf> {
    asked.run::<Comfort, _>(py, &["weather"], progress.as_ref(), |args, _, resources| {
        let later = Some(args.request()).filter(|request| !request.replay.weather.as_os_str().is_empty());
        args.archive(later.as_ref(), resources)
    })
}

/// Writes an EnergyPlus model with the sunlight that its surroundings reflect.
#[pyfunction]
pub fn energyplus(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<()> {
    asked.run::<Energyplus, _>(py, &[], progress.as_ref(), |args, _, resources| args.request.write(resources))
}

/// Cuts a region into parts. Returns their number and a sentence on the error of the halo, if it
/// was estimated.
#[pyfunction]
pub fn partition(
    py: Python<'_>,
    asked: Keywords,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(usize, Option<String>)> {
    asked.run::<PartitionRequest, _>(py, &[], progress.as_ref(), |request, _, resources| {
        let plan = heliotile::atlas::partition(request, resources.observer)?;
        Ok((plan.parts.len(), plan.seams.map(|seams| seams.words())))
    })
}

/// Writes the catalogue of an atlas.
#[pyfunction]
pub fn catalogue(py: Python<'_>, asked: Keywords) -> PyResult<()> {
    asked.run::<Catalogue, _>(py, &[], None, |args, about, resources| {
        heliotile::atlas::catalogue(&args.atlas, &args.request, about, resources.observer)
    })
}

/// Writes the union of two archives of one scene.
#[pyfunction]
pub fn merge(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<()> {
    asked.run::<Merge, _>(py, &[], progress.as_ref(), |args, _, resources| args.write(resources.observer).map(drop))
}

/// Compares two archives. Returns true if they are equal, and their differences as text.
#[pyfunction]
pub fn diff(py: Python<'_>, asked: Keywords) -> PyResult<(bool, String)> {
    asked.run::<Diff, _>(py, &[], None, |args, _, _| args.found())
}

/// Writes a table of receivers on surfaces or along lines. Returns a summary.
#[pyfunction]
pub fn receivers(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<String> {
    asked.run::<Receivers, _>(py, &[], progress.as_ref(), |args, _, resources| {
        args.write(resources.observer).map(|text| worded_text(&text))
    })
}

/// Forecasts a build. Returns the number of receivers, and the forecast as text.
#[pyfunction]
pub fn plan(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<(usize, String)> {
    asked.run::<Build, _>(py, &[], progress.as_ref(), |args, _, resources| {
        let scene = loaded(&args.scene, resources.observer)?;
        let planned = args.forecast(&scene, asked.table(args.receivers()?), resources)?;
        Ok((planned.receivers, planned.text))
    })
}

/// Reads a scene and warns of doubts about its files.
pub fn loaded(request: &SceneRequest, observer: &dyn heliotile::Observer) -> Result<Scene> {
    let scene = Scene::load_site(&request.site()?)?;
    scene.report.warnings.iter().for_each(|text| observer.warn(text));
    Ok(scene)
}

/// Compares an archive with the reference path tracer. Returns the result as JSON and a table as
/// text. Writes the table of pairs, pictures and a page to a folder, if one is given.
#[pyfunction]
pub fn audit(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<(String, String)> {
    asked.run::<Audit, _>(py, &[], progress.as_ref(), |args, about, resources| {
        let report = args.request.run(resources)?;
        if let Some(folder) = &args.output {
            report.write(folder, about)?;
        }
        Ok((json(&report)?, report.text()))
    })
}

/// Checks every block of an archive, or of all archives of an atlas.
#[pyfunction]
pub fn verify(py: Python<'_>, asked: Keywords) -> PyResult<Vec<CheckedRow>> {
    asked.run::<VerifyRequest, _>(py, &[], None, |request, _, _| {
        let mut found = Vec::new();
        request.each(|checked| {
            let text = checked.text();
            let (misplaced, report) = (checked.misplaced.map(|error| error.to_string()), checked.report);
            let sizes = (report.blocks, report.stored_bytes, report.trailing_bytes);
            found.push((checked.archive, sizes.0, sizes.1, sizes.2, rows(report.problems), misplaced, text));
            Ok(())
        })?;
        Ok(found)
    })
}

/// Repairs a damaged archive. Returns the archive, its problems, the number of rays traced, and
/// these as text.
#[pyfunction]
pub fn repair(
    py: Python<'_>,
    asked: Keywords,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(PathBuf, Vec<ProblemRow>, u64, String)> {
    asked.run::<Repair, _>(py, &[], progress.as_ref(), |args, _, resources| {
        let done = args.request.write(resources)?;
        let said = done.text();
        Ok((done.archive, rows(done.problems), done.rays, said))
    })
}

/// Edits the scene of an archive. Returns the new archive, what became of the receivers, the number
/// of rays traced, and these as text.
#[pyfunction]
pub fn update(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<UpdateRow> {
    asked.run::<Update, _>(py, &[], progress.as_ref(), |args, _, resources| {
        let done = args.request().write(resources)?;
        let said = done.text();
        Ok((done.archive, [done.kept, done.moved, done.gone, done.new], done.buried, done.report.rays.total(), said))
    })
}

/// Tries settings on a site. Returns their cost and accuracy as JSON.
#[pyfunction]
pub fn tradeoff(py: Python<'_>, asked: Keywords, progress: Option<Bound<'_, PyAny>>) -> PyResult<String> {
    asked.run::<Tradeoff, _>(py, &[], progress.as_ref(), |args, about, resources| {
        json(&args.request.write(about, resources, |_| Ok(()))?)
    })
}

/// Writes the layers of a receiver, or the view factors of all receivers.
#[pyfunction]
pub fn export(py: Python<'_>, asked: Keywords) -> PyResult<()> {
    asked.run::<Export, _>(py, &[], None, |args, about, resources| args.request().write(about, resources))
}

/// Writes a statement about tables. Returns a sentence about it.
#[pyfunction]
pub fn report(py: Python<'_>, asked: Keywords) -> PyResult<String> {
    asked.run::<ReportRequest, _>(py, &[], None, |args, about, resources| {
        args.write(&about, resources.observer).map(|done| done.text())
    })
}

/// Writes the web page that shows an archive.
#[pyfunction]
pub fn view(py: Python<'_>, asked: Keywords, output: PathBuf, access: Option<&str>) -> PyResult<()> {
    let access: Option<Access> = access
        .map(|name| heliotile::names::by_name("access", name))
        .transpose()
        .map_err(|error| crate::errors::raised(py, error))?;
    asked.run::<View, _>(py, &[], None, |args, _, resources| {
        PageRequest { output, access: access.unwrap_or_default(), ..args.page.clone() }.write(resources)
    })
}
