//! `heliotile repair`: traces the damaged parts of an archive again.

use super::console::terminal::Terminal;
use super::{Outcome, remark};
use crate::cli::RepairArgs;
use heliotile_builder::spill::SystemTemp;
use heliotile_core::error::Result;
use heliotile_results::Resources;
use heliotile_scene::input;

/// `heliotile repair`.
pub fn run(args: &RepairArgs) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let memory = args.memory.into();
    let resources = Resources { memory, storage: &SystemTemp, files: &input::read, observer: &terminal };
    remark(&args.request().write(&resources)?.text())?;
    Ok(Outcome::Fine)
}
