//! `heliotile energyplus`: an EnergyPlus model with the sun that its surroundings reflect.

use super::Outcome;
use super::console::terminal::Terminal;
use crate::cli::EnergyplusArgs;
use heliotile::memory::SystemTemp;
use heliotile::scene::input;
use heliotile::{Resources, Result};

/// `heliotile energyplus`.
pub fn run(args: &EnergyplusArgs) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let memory = args.memory.into();
    let resources = Resources { memory, storage: &SystemTemp, files: &input::read, observer: &terminal };
    args.request().write(&resources)?;
    Ok(Outcome::Fine)
}
