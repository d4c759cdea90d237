//! `heliotile update`: an archive after edits of its scene.

use super::console::terminal::Terminal;
use super::{Outcome, remark};
use crate::cli::UpdateArgs;
use heliotile::memory::SystemTemp;
use heliotile::scene::input;
use heliotile::{Resources, Result};

/// `heliotile update`.
pub fn run(args: &UpdateArgs) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let memory = args.memory.into();
    let resources = Resources { memory, storage: &SystemTemp, files: &input::read, observer: &terminal };
    remark(&args.request().write(&resources)?.text())?;
    Ok(Outcome::Fine)
}
