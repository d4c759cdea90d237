//! Selections of receivers, as Python states them. In: ids, a file, names or a box. Out: selections
//! of the library.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;

use heliotile::{Bounds, Error, Result, Selection};

/// Selection of receivers: a list of ids, a file of ids, or one of `objects`, `surfaces` and `bbox`
/// with its values.
#[derive(FromPyObject)]
pub enum PySelection {
    Ids(Vec<String>),
    File(PathBuf),
    Mapping(BTreeMap<String, SelectionValues>),
}

/// Names of objects or surfaces, or the numbers of a box.
#[derive(FromPyObject)]
pub enum SelectionValues {
    Names(Vec<String>),
    Numbers(Vec<f64>),
}

impl PySelection {
    /// Returns the selection of the library.
    pub fn selection(&self) -> Result<Selection> {
        let of = match self {
            PySelection::Ids(ids) if ids.is_empty() => {
                return Err(Error::argument("receivers", "the list is empty", "leave it out for all receivers"));
            }
            PySelection::Ids(ids) => return Ok(Selection::Ids(ids.clone())),
            PySelection::File(file) => return Ok(Selection::Receivers(file.clone())),
            PySelection::Mapping(of) => of,
        };
        let mut all = of.iter();
        match (all.next(), all.next()) {
            (Some((by, SelectionValues::Names(names))), None) if by == "objects" => {
                Ok(Selection::Objects(names.clone()))
            }
            (Some((by, SelectionValues::Names(names))), None) if by == "surfaces" => {
                Ok(Selection::Surfaces(names.clone()))
            }
            (Some((by, SelectionValues::Numbers(numbers))), None) if by == "bbox" => {
                bounds_of(numbers.clone()).map(Selection::Bounds)
            }
            _ => Err(Error::argument("receivers", "the mapping is not a selection of receivers", HINT)),
        }
    }
}

/// Hint about the valid selections of receivers.
const HINT: &str = "give one of {\"objects\": names}, {\"surfaces\": names} and {\"bbox\": (xmin, ymin, xmax, ymax)}";

/// Returns the box of `xmin, ymin, xmax, ymax[, zmin, zmax]`.
pub fn bounds_of(numbers: Vec<f64>) -> Result<Bounds> {
    Bounds::new(&numbers).map_err(|found| Error::argument("receivers", found, HINT))
}
