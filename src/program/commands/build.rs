//! `heliotile build` and `plan`. In: a scene, receivers. Out: a forecast, or an archive.

use super::console::terminal::Terminal;
use super::{Outcome, load_scene, say};
use heliotile::cases::{Build, Plan};
use heliotile::{Provenance, ReceiverCsv, Result};

/// `heliotile build`.
pub fn run(args: &Build, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    if let Some(part) = &args.part {
        args.parts(part, &terminal)?;
        return Ok(Outcome::Fine);
    }
    let (output, receivers) = args.check()?;
    args.trace(&load_scene(&args.scene)?, ReceiverCsv::File(receivers), output, &terminal)?;
    Ok(Outcome::Fine)
}

/// `heliotile plan`.
pub fn plan(args: &Plan, _: Provenance) -> Result<Outcome> {
    let scene = load_scene(&args.scene)?;
    say(&args.forecast(&scene, ReceiverCsv::File(&args.receivers), &Terminal::default())?.text)?;
    Ok(Outcome::Fine)
}
