//! Arguments that choose receivers of an archive.

use std::path::PathBuf;

use clap::Args;

use crate::cli::values::parse_bounds;
use heliotile::{Bounds, Selection};

/// Choice of receivers: one of these options, or none for all receivers.
#[derive(Args, Debug)]
#[group(id = "selection", multiple = false)]
pub struct SelectionArgs {
    /// Only the receivers listed in a CSV file: ids in a column `receiver`
    #[arg(long, short, value_name = "FILE")]
    pub receivers: Option<PathBuf>,
    /// Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and
    /// optionally zmin,zmax; of an atlas, only parts that touch it are opened
    #[arg(long, value_name = "BOX", allow_hyphen_values = true, value_parser = parse_bounds)]
    pub bbox: Option<Bounds>,
    /// Only the receivers of these surfaces
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub surface: Vec<String>,
    /// Only the receivers of these objects or buildings
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub object: Vec<String>,
}

impl SelectionArgs {
    /// Returns the selection, or `None` for all receivers.
    pub fn selection(&self) -> Option<Selection> {
        let names = |names: &Vec<String>| (!names.is_empty()).then(|| names.clone());
        let listed = self.receivers.clone().map(Selection::Receivers);
        let named = names(&self.surface).map(Selection::Surfaces).or(names(&self.object).map(Selection::Objects));
        listed.or(self.bbox.map(Selection::Bounds)).or(named)
    }
}
