//! Regions in parts. In: the folder of an atlas, or arguments of a command line. Out: the parts of
//! the atlas; the program, run in this process.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;

use crate::archive::bounds_of;
use crate::work;
use heliotile_atlas::parts;

/// Name, low and high corner of the square, state, archive, and reach beyond the square in metres.
type PartRow = (String, (f64, f64), (f64, f64), &'static str, Option<String>, f64);

/// Returns the parts of an atlas that a box `xmin, ymin, xmax, ymax[, zmin, zmax]` touches, or all
/// parts if there is no box.
#[pyfunction]
#[pyo3(signature = (atlas, bbox=None))]
pub fn atlas_parts(py: Python<'_>, atlas: PathBuf, bbox: Option<Vec<f64>>) -> PyResult<Vec<PartRow>> {
    let listed = work::run(py, None, |_| parts(&atlas, bbox.map(bounds_of).transpose()?))?;
    let row = |part: &heliotile_atlas::ListedPart| {
        let archive = part.archive().map(|path| path.to_string_lossy().into_owned());
        (part.name.clone(), part.low.into(), part.high.into(), part.state.word(), archive, part.reach_m)
    };
    Ok(listed.iter().map(row).collect())
}

/// Returns the name of a place for messages: an address without password and signature.
#[pyfunction]
pub fn shown(place: &str) -> String {
    heliotile_remote::naming::shown(Path::new(place)).to_string_lossy().into_owned()
}

/// Runs the program with these arguments, the program's name first. Returns its exit code.
#[pyfunction]
pub fn program(py: Python<'_>, words: Vec<String>) -> u8 {
    py.detach(|| heliotile_program::program(&words.into_iter().map(Into::into).collect::<Vec<_>>()))
}
