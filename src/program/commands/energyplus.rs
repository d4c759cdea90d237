//! `heliotile energyplus`: an EnergyPlus model with the sun that its surroundings reflect.

use super::Outcome;
use super::console::terminal::Terminal;
use heliotile::cases::Energyplus;
use heliotile::{Provenance, Resources, Result};

/// `heliotile energyplus`.
pub fn run(args: &Energyplus, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    args.request.write(&resources)?;
    Ok(Outcome::Fine)
}
