//! Studies: the measurements of the paper, repeated with this program. In: parameters to vary. Out:
//! tables and pictures. Studies trace scenes of their own and use no archive.

mod wall;

use super::Outcome;
use crate::cli::{StudyArgs, StudyCommand};
use heliotile::Result;

/// `heliotile study`.
pub fn run(args: &StudyArgs) -> Result<Outcome> {
    match &args.command {
        StudyCommand::Wall(args) => wall::run(args),
    }
}
