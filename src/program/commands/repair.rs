//! `heliotile repair`: traces the damaged parts of an archive again.

use super::console::terminal::Terminal;
use super::{Outcome, remark};
use crate::cli::RepairArgs;
use heliotile::memory::SystemTemp;
use heliotile::scene::input;
use heliotile::{Resources, Result};

/// `heliotile repair`.
pub fn run(args: &RepairArgs) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let memory = args.memory.into();
    let resources = Resources { memory, storage: &SystemTemp, files: &input::read, observer: &terminal };
    remark(&args.request().write(&resources)?.text())?;
    Ok(Outcome::Fine)
}
