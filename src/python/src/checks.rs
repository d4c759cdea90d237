//! Checks and edits of archives, and the cost of accuracy. In: requests as JSON, which
//! `heliotile/checks.py` and `heliotile/studies.py` make of keyword arguments. Out: results as JSON
//! or plain values, and as text for people.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use serde::Serialize;

use crate::asked::Memory;
use crate::errors::worded_text;
use crate::studies::{about, request, resources};
use crate::work;
use heliotile::archive::Problem;
use heliotile::atlas::{ExportRequest, VerifyRequest};
use heliotile::{Access, AuditRequest, Error, PageRequest, RepairRequest, Result, TradeoffRequest, UpdateRequest};

/// Block, offset in bytes and reason of a problem.
type ProblemRow = (String, u64, String);

/// Archive, number of its blocks, their bytes, bytes behind its end, problems, the reason why it is
/// not the archive of its part, and all of this as text.
type CheckedRow = (PathBuf, u64, u64, u64, Vec<ProblemRow>, Option<String>, String);

/// Returns a result as JSON.
fn json(found: &impl Serialize) -> Result<String> {
    serde_json::to_string(found).map_err(|error| Error::io(Path::new("the result"), "write")(error.into()))
}

fn rows(problems: Vec<Problem>) -> Vec<ProblemRow> {
    problems.into_iter().map(|problem| (problem.part, problem.offset, worded_text(&problem.reason))).collect()
}

/// Compares an archive with the reference path tracer. Returns the result as JSON and a table as
/// text. Writes the table of pairs, pictures and a page to `folder`, if given.
#[pyfunction]
pub fn audit(
    py: Python<'_>,
    text: String,
    folder: Option<PathBuf>,
    memory: Memory,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, String)> {
    work::run(py, progress.as_ref(), |watch| {
        let report = request::<AuditRequest>(&text)?.run(&resources(memory, watch))?;
        if let Some(folder) = &folder {
            report.write(folder, about("Archive.audit", &text))?;
        }
        Ok((json(&report)?, report.text()))
    })
}

/// Checks every block of an archive, or of all archives of an atlas.
#[pyfunction]
pub fn verify(py: Python<'_>, place: PathBuf, deep: bool) -> PyResult<Vec<CheckedRow>> {
    work::run(py, None, |_| {
        let mut found = Vec::new();
        VerifyRequest { place, deep, access: Access::Read }.each(|checked| {
            let text = worded_text(&checked.text());
            let (misplaced, report) = (checked.misplaced.map(|error| worded_text(&error.to_string())), checked.report);
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
    text: &str,
    memory: Memory,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(PathBuf, Vec<ProblemRow>, u64, String)> {
    work::run(py, progress.as_ref(), |watch| {
        let done = request::<RepairRequest>(text)?.write(&resources(memory, watch))?;
        let said = done.text();
        Ok((done.archive, rows(done.problems), done.rays, said))
    })
}

/// New archive; counts of receivers kept, moved, gone and new; names of buried receivers; rays
/// traced; and these as text.
type UpdateRow = (PathBuf, [usize; 4], Vec<String>, u64, String);

/// Edits the scene of an archive. Returns the new archive, what became of the receivers, the number
/// of rays traced, and these as text.
#[pyfunction]
pub fn update(py: Python<'_>, text: &str, memory: Memory, progress: Option<Bound<'_, PyAny>>) -> PyResult<UpdateRow> {
    work::run(py, progress.as_ref(), |watch| {
        let done = request::<UpdateRequest>(text)?.write(&resources(memory, watch))?;
        let said = done.text();
        Ok((done.archive, [done.kept, done.moved, done.gone, done.new], done.buried, done.report.rays.total(), said))
    })
}

/// Tries settings on a site. Returns their cost and accuracy as JSON.
#[pyfunction]
pub fn tradeoff(py: Python<'_>, text: String, memory: Memory, progress: Option<Bound<'_, PyAny>>) -> PyResult<String> {
    work::run(py, progress.as_ref(), |watch| {
        let request = request::<TradeoffRequest>(&text)?;
        json(&request.write(about("tradeoff", &text), &resources(memory, watch), |_| Ok(()))?)
    })
}

/// Writes the layers of a receiver, or the view factors of all receivers.
#[pyfunction]
pub fn export(py: Python<'_>, text: String, memory: Memory) -> PyResult<()> {
    work::run(py, None, |watch| {
        request::<ExportRequest>(&text)?.write(about("Archive.export", &text), &resources(memory, watch))
    })
}

/// Writes the web page that shows an archive.
#[pyfunction]
pub fn view(py: Python<'_>, text: &str, memory: Memory) -> PyResult<()> {
    work::run(py, None, |watch| request::<PageRequest>(text)?.write(&resources(memory, watch)))
}
