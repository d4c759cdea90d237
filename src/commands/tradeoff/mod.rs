//! `heliotile tradeoff`: what accuracy costs on the user's own site. In: a scene, receivers. Out: a folder with the ladder of settings as
//! a table, as pictures, and as a page for people.

mod ladder;
mod report;
mod sources;

use super::accuracy::conditions::Suns;
use super::accuracy::trial::Bench;
use super::accuracy::{CONDITIONS, sample};
use super::build::{Ready, left_out};
use super::{Outcome, load_scene, say, temporary_folder, warn};
use crate::cli::TradeoffArgs;
use crate::outputs::sink::write_texts;
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::receiver::Receiver;
use ladder::Ladder;

/// `heliotile tradeoff`.
pub fn run(args: &TradeoffArgs) -> Result<Outcome> {
    let scene = load_scene(&args.scene)?;
    let suns = Suns::of(args.weather.as_deref())?;
    let conditions = suns.some(CONDITIONS);
    let (mut warnings, folder) = (Vec::new(), &args.output);
    let (budget, beside) = (args.memory.0 as usize / 8, temporary_folder(folder));
    let mut receivers = ReceiverTiles::open(&args.receivers, scene.mesh.origin, beside, budget, &mut warnings)?;
    warnings.iter().for_each(|w| warn(w));
    let ready = Ready::new(&scene)?;
    let left_out = left_out(&scene, &ready, &mut receivers, folder, args.effects)?;
    let some: Vec<Receiver> = sample(&mut receivers, usize::from(args.sample))?.into_iter().map(|s| s.1).collect();
    // Not before the inputs are known to be good.
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    let trials = tempfile::Builder::new().prefix("trials").tempdir_in(folder);
    let trials = trials.map_err(Error::io(folder, "make a folder in"))?;
    let bench = Bench {
        scene: &scene,
        ready: &ready,
        receivers: &some,
        conditions: &conditions,
        folder: trials.path(),
        memory_bytes: args.memory.0,
    };
    let ladder = Ladder::climb(&bench, left_out, &suns)?;
    say(&ladder.table())?;
    let sources = match args.sources {
        true => Some(sources::each_alone(&bench, left_out, &suns)?),
        false => None,
    };
    if let Some(sources) = &sources {
        say(&sources::table(sources))?;
    }
    let site = report::Site {
        scene: args.scene.first(),
        receivers: receivers.count(),
        sample: some.len(),
        weather: suns.name(),
    };
    write_texts(folder, &report::files(&site, &ladder, sources.as_deref())?)?;
    say(&format!("{}: read it with a browser\n", folder.join(report::PAGE).display()))?;
    Ok(Outcome::Fine)
}
