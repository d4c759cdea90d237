//! Studies: what the paper measured, done again with this program. In: what to vary. Out: tables and pictures. They trace scenes of their
//! own and touch no archive.

mod wall;

use super::Outcome;
use crate::cli::{StudyArgs, StudyCommand};
use heliotile_core::error::Result;

/// `heliotile study`.
pub fn run(args: &StudyArgs) -> Result<Outcome> {
    match &args.command {
        StudyCommand::Wall(args) => wall::run(args),
    }
}
