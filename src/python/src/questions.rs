//! Questions that an open site answers by files. In: a site, keywords. Out: files, and a summary as
//! JSON.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::archive::{ARCHIVE, ArchiveHandle};
use crate::asked::Keywords;
use crate::selection::PySelection;
use heliotile::cases::{Buildings, Compare, Envelope, Glare, PeopleOfSite, Places, Replay, Shading, Sunlight};
use heliotile::tables::{Cell, Records};
use heliotile::{Provenance, Result, Site};

/// Answers the question of a command, such as `write` or `glare`, for some receivers. Returns its
/// summary as JSON: a sentence or null, numbers, the results of rules, or the rows and the text of
/// a comparison.
#[pyfunction]
#[pyo3(signature = (site, question, asked, receivers, progress))]
pub fn ask(
    py: Python<'_>,
    site: &Bound<'_, ArchiveHandle>,
    question: &str,
    asked: Keywords,
    receivers: Option<PySelection>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (site, progress) = (site.get(), progress.as_ref());
    let chosen = |about: Provenance| -> Result<Site> { Ok(site.chosen(receivers)?.stating(about)) };
    let found: PyResult<Value> = match question {
        "write" => asked.run::<Replay, _>(py, ARCHIVE, progress, |args, about, resources| {
            Ok(json!(chosen(about)?.write(&args.under()?, &args.files, resources)?))
        }),
        "compare" => asked.run::<Compare, _>(py, ARCHIVE, progress, |args, about, resources| {
            let done = chosen(about)?.compare(&args.request()?, &args.files, resources)?;
            Ok(json!([rows_of(&done.table()), done.text()]))
        }),
        "buildings" => asked.run::<Buildings, _>(py, ARCHIVE, progress, |args, about, resources| {
            let done = chosen(about)?.buildings(&args.year(), &args.request, resources)?;
            Ok(json!([done.buildings, done.faces]))
        }),
        "places" => asked.run::<Places, _>(py, ARCHIVE, progress, |args, about, resources| {
            let done = chosen(about)?.places(&args.year(), &args.request, resources)?;
            Ok(json!([done.places, done.receivers]))
        }),
        "shading" => asked.run::<Shading, _>(py, ARCHIVE, progress, |args, about, resources| {
            Ok(json!(chosen(about)?.shading(&args.replay, &args.request, resources)?.text()))
        }),
        "comfort" => asked.run::<PeopleOfSite, _>(py, &[], progress, |args, about, resources| {
            let done = chosen(about)?.comfort(&args.request(), &args.files, resources)?;
            Ok(json!([done.points, done.hours]))
        }),
        "sunlight" => asked.run::<Sunlight, _>(py, ARCHIVE, progress, |args, about, resources| {
            Ok(json!(chosen(about)?.sunlight(&args.request, &args.files, resources)?))
        }),
        "envelope" => asked.run::<Envelope, _>(py, ARCHIVE, progress, |args, about, resources| {
            Ok(json!(chosen(about)?.envelope(&args.request, resources)?))
        }),
        "glare" => asked.run::<Glare, _>(py, ARCHIVE, progress, |args, about, resources| {
            Ok(json!(chosen(about)?.sunlight(&args.request(), &args.files, resources)?))
        }),
        other => Err(PyValueError::new_err(format!("`{other}` is no question"))),
    };
    found.map(|found| found.to_string())
}

/// Returns the rows of a table as JSON objects, keyed by the names of the columns; an empty cell is
/// null.
fn rows_of(records: &Records) -> Value {
    let cell = |cell: &Cell| match cell {
        Cell::Text(text) => text.as_str().into(),
        Cell::Count(count) => (*count).into(),
        Cell::Number(number) => (*number).into(),
    };
    let row = |row: &Vec<Cell>| {
        let cells = records.columns.iter().zip(row).map(|(column, value)| (column.name.clone(), cell(value)));
        Value::Object(cells.collect())
    };
    records.rows.iter().map(row).collect()
}
