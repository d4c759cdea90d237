//! Regions in parts. In: the folder of an atlas, or arguments of a command line. Out: the parts of
//! the atlas, listed or built; the program, run in this process.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;

use crate::asked::Memory;
use crate::selection::bounds_of;
use crate::work;
use heliotile::Error;
use heliotile::atlas::{PartRequest, build_parts, parts};

/// Name, low and high corner of the square, state, archive, and reach beyond the square in metres.
type PartRow = (String, (f64, f64), (f64, f64), &'static str, Option<String>, f64);

/// Returns the parts of an atlas that a box `xmin, ymin, xmax, ymax[, zmin, zmax]` touches, or all
/// parts if there is no box.
#[pyfunction]
#[pyo3(signature = (atlas, bbox=None))]
pub fn atlas_parts(py: Python<'_>, atlas: PathBuf, bbox: Option<Vec<f64>>) -> PyResult<Vec<PartRow>> {
    let listed = work::run(py, None, |_| parts(&atlas, bbox.map(bounds_of).transpose()?))?;
    let row = |part: &heliotile::atlas::ListedPart| {
        let archive = part.archive().map(|path| path.to_string_lossy().into_owned());
        (part.name.clone(), part.low.into(), part.high.into(), part.state.word(), archive, part.reach_m)
    };
    Ok(listed.iter().map(row).collect())
}

/// Builds a part of an atlas, by its name or number, on `threads` threads of its own; `None`: on
/// those of this process.
#[pyfunction]
#[pyo3(signature = (atlas, part, fresh, threads, memory, progress))]
pub fn build_part(
    py: Python<'_>,
    atlas: PathBuf,
    part: &str,
    fresh: bool,
    threads: Option<usize>,
    memory: Memory,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    work::run(py, progress.as_ref(), |watch| {
        let request = PartRequest { part, fresh, memory: memory.0, from: None };
        let build = || build_parts(&atlas, &request, watch);
        let Some(threads) = threads else { return build() };
        let refuse = |what: String| Error::argument("threads", what, "give a number of threads from 1 to 1024");
        if !(1..=MAX_THREADS).contains(&threads) {
            return Err(refuse(format!("is {threads}")));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_err(|error| refuse(error.to_string()))?.install(build)
    })
}

/// Largest number of threads that a build may be given.
const MAX_THREADS: usize = 1024;

/// Returns the name of a place for messages: an address without password and signature.
#[pyfunction]
pub fn shown(place: &str) -> String {
    heliotile::remote::shown(Path::new(place)).to_string_lossy().into_owned()
}

/// Runs the program with these arguments, the program's name first. Returns its exit code.
#[pyfunction]
pub fn program(py: Python<'_>, words: Vec<String>) -> u8 {
    py.detach(|| heliotile_program::program(&words.into_iter().map(Into::into).collect::<Vec<_>>()))
}
