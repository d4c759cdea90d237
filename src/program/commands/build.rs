//! `heliotile build`. In: a scene, receivers. Out: an archive, or its forecast.

use super::console::terminal::Terminal;
use super::{Outcome, load_scene, say};
use heliotile::cases::Build;
use heliotile::{Provenance, ReceiverCsv, Resources, Result};

/// `heliotile build`.
pub fn run(args: &Build, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    if let Some(part) = &args.part {
        args.parts(part, &terminal)?;
        return Ok(Outcome::Fine);
    }
    if args.dry_run {
        let (receivers, scene) = (args.receivers()?, load_scene(&args.scene)?);
        let terminal = Terminal::default();
        let resources = Resources::new(args.memory, &terminal);
        say(&args.forecast(&scene, ReceiverCsv::File(receivers), &resources)?.text)?;
        return Ok(Outcome::Fine);
    }
    let (output, receivers) = args.check()?;
    args.trace(
        &load_scene(&args.scene)?,
        ReceiverCsv::File(receivers),
        output,
        &Resources::new(args.memory, &terminal),
    )?;
    Ok(Outcome::Fine)
}
