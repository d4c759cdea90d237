//! Changes of light by a change of a site. In: open archives before, the paths of others after,
//! suns and skies. Out: tables, maps and pictures of before, after and change, and a summary of the
//! receivers, windows and buildings that lose light.
//!
//! Receivers are matched first ([`heliotile_core::opened::ReceiverMatching`]); those that exist on
//! both sides are replayed. Values after wait in sorted runs, which go to temporary files if they
//! do not fit into memory, until the same receivers come before.

mod pass;
mod summary;
mod tally;
mod variant;

use std::path::{Path, PathBuf};

use super::buildings::check_table;
use super::files::OutputRequest;
use super::request::{LightRequest, QueryRequest, ReplayRequest};
use crate::outputs::periods::Every;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_files::writing::claim::same_place;

pub use pass::BeforeSide;
pub use summary::{CompareSummary, VariantSummary};
pub use tally::{LOSSES_PERCENT, LossCounts};
pub use variant::check_memory;

/// Request for a comparison of archives with one before them.
#[derive(Clone, Debug)]
pub struct CompareRequest {
    /// Paths of archives or atlases after, at least one. Files of results take exactly one; a
    /// summary has a row for each.
    pub after: Vec<PathBuf>,
    /// Suns and skies, and the light that counts; without columns: the total.
    pub under: LightSource,
    /// Table with a row for each archive after.
    pub summary: Option<PathBuf>,
    /// Table of the receivers that exist on one side only.
    pub unmatched: Option<PathBuf>,
}

/// Source of suns and skies.
#[derive(Clone, Debug)]
pub enum LightSource {
    /// Suns and skies of a weather file.
    Weather(Box<ReplayRequest>),
    /// Suns and skies of a table of conditions.
    Conditions(Box<QueryRequest>),
}

impl From<ReplayRequest> for LightSource {
    fn from(request: ReplayRequest) -> Self {
        LightSource::Weather(Box::new(request))
    }
}

impl From<QueryRequest> for LightSource {
    fn from(request: QueryRequest) -> Self {
        LightSource::Conditions(Box::new(request))
    }
}

impl LightSource {
    /// Returns the light that counts.
    pub fn light(&self) -> &LightRequest {
        match self {
            LightSource::Weather(request) => &request.light,
            LightSource::Conditions(request) => &request.light,
        }
    }

    /// Returns the period of a row; `None` under conditions.
    pub fn every(&self) -> Option<Every> {
        match self {
            LightSource::Weather(request) => Some(request.every),
            LightSource::Conditions(_) => None,
        }
    }

    /// Returns the files that are read besides archives.
    pub fn files(&self) -> Vec<&Path> {
        match self {
            LightSource::Weather(request) => request.files().collect(),
            LightSource::Conditions(request) => request.files().collect(),
        }
    }
}

impl CompareRequest {
    /// Refuses choices that exclude each other, and files that would replace an input or each
    /// other, before anything is read.
    pub fn check(&self, files: &OutputRequest, inputs: &[&Path]) -> Result<()> {
        let every = match &self.under {
            LightSource::Weather(request) => request.check().map(|()| Some(request.every))?,
            LightSource::Conditions(request) => request.check().map(|()| None)?,
        };
        if self.after.is_empty() {
            return Err(Error::argument(
                "summary",
                "no archive of the changed site is given",
                "give one archive, or several",
            ));
        }
        if files.model.is_some() || files.honeybee.is_some() || files.percentiles {
            let hint = "write a table or a map of the change";
            return Err(Error::argument("model, honeybee, percentiles", "hold the results of one archive only", hint));
        }
        let has_details = files.output != Path::new("-") || !files.plots.is_empty();
        if self.after.len() > 1 && has_details {
            let what = format!("hold the change to one archive only, and {} are given", self.after.len());
            let hint = "give one changed archive, or {summary} FILE for a row for each of them";
            return Err(Error::argument("output, plot", what, hint).because(Problem::excludes("after")));
        }
        let inputs: Vec<&Path> = inputs.iter().copied().chain(self.after.iter().map(PathBuf::as_path)).collect();
        files.check(self.under.light().chosen_columns().as_ref(), every, &inputs)?;
        let tables = [self.summary.as_deref(), self.unmatched.as_deref()];
        let written = tables.into_iter().flatten().chain([files.output.as_path()]);
        let written: Vec<&Path> = written.filter(|path| *path != Path::new("-")).collect();
        for (number, path) in written.iter().enumerate() {
            if written.iter().take(number).any(|other| same_place(other, path)) {
                let what = format!("`{}` is written twice", path.display());
                return Err(Error::argument("output, summary, unmatched", what, "give each table a name of its own"));
            }
        }
        tables.into_iter().flatten().try_for_each(|table| check_table(table, &inputs))
    }

    /// Returns true if rows of places are written, which needs exactly one archive after. If a
    /// summary or pictures are requested, the default `-` does not count as a request for standard
    /// output.
    pub fn has_details(&self, files: &OutputRequest) -> bool {
        let is_asked = files.output != Path::new("-") || !files.plots.is_empty() || self.summary.is_none();
        self.after.len() == 1 && is_asked
    }

    /// Returns the columns that are compared.
    fn columns(&self) -> ComponentList {
        self.under.light().columns_or(ComponentList::new(Component::Total))
    }
}
