//! `heliotile tradeoff`: what accuracy costs on the user's own site. In: a scene, receivers. Out: a folder with the ladder of settings as
//! a table, as pictures, and as a page for people.

mod ladder;
mod report;
mod sources;

use super::console::terminal::Terminal;
use super::{Outcome, load_scene, say, workspace, workspace_beside};
use crate::cli::TradeoffArgs;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::accuracy::trial::Bench;
use heliotile_builder::accuracy::{CONDITIONS, sample};
use heliotile_builder::pipeline::{Build, PreparedScene};
use heliotile_builder::settings::BuildSettings;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::receiver::Receiver;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::sink::write_texts;
use ladder::LadderTable;

/// `heliotile tradeoff`.
pub fn run(args: &TradeoffArgs, about: Provenance) -> Result<Outcome> {
    let scene = load_scene(&args.scene)?;
    let terminal = Terminal::default();
    let suns =
        ErrorConditions::read(args.weather.as_deref(), &args.about_weather.options(false), scene.place, &terminal)?;
    let (conditions, folder) = (suns.some(CONDITIONS), &args.output);
    let beside = workspace_beside(folder, args.memory);
    let mut receivers = beside.read_receivers(&args.receivers, &scene, &terminal)?;
    let prepared = PreparedScene::new(&scene)?;
    let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &beside, observer: &terminal };
    let left_out = build.forecast(&BuildSettings::default(), args.effects, None)?.left_out;
    let some: Vec<Receiver> = sample(&mut receivers, usize::from(args.sample))?.into_iter().map(|s| s.1).collect();
    // Not before the inputs are known to be good.
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    let trials = tempfile::Builder::new().prefix("trials").tempdir_in(folder);
    let trials = trials.map_err(Error::io(folder, "make a folder in"))?;
    let bench = Bench {
        scene: &prepared,
        receivers: &some,
        conditions: &conditions,
        workspace: &workspace(trials.path(), args.memory),
        observer: &terminal,
    };
    let ladder = LadderTable::climb(&bench, left_out, &suns)?;
    say(&ladder.table())?;
    let sources = match args.sources {
        true => Some(sources::each_alone(&bench, left_out, &suns)?),
        false => None,
    };
    if let Some(sources) = &sources {
        say(&sources::table(sources))?;
    }
    let site = report::SiteSummary {
        scene: args.scene.first(),
        receivers: receivers.count(),
        sample: some.len(),
        weather: suns.name(),
    };
    let about = match args.weather {
        Some(_) => about.with("weather", suns.name()),
        None => about,
    };
    write_texts(folder, &report::files(&site, &ladder, sources.as_deref(), &about)?)?;
    say(&format!("{}: read it with a browser\n", folder.join(report::PAGE).display()))?;
    Ok(Outcome::Fine)
}
