//! Commands from scene files to results in one go: `heliotile run`, a year's sun; `heliotile
//! energyplus`, an EnergyPlus model with the sun that its surroundings reflect; `heliotile
//! tradeoff`, the cost of accuracy on the user's own site.

use std::path::Path;

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use crate::cli::quoted;
use heliotile::cases::{Energyplus, Run, Tradeoff};
use heliotile::{Provenance, Resources, Result, RunDone, TimeShift, WeatherOptions};

/// `heliotile run`.
pub fn run(args: &Run, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    let done = args.request.write(about, &resources)?;
    say(&format!("Irradiation through {}, kWh/m2 (means by area):\n{}", args.request.weather.display(), done.table))?;
    remark(summary(args, &done))?;
    Ok(Outcome::Fine)
}

/// `heliotile energyplus`.
pub fn energyplus(args: &Energyplus, _: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let resources = Resources::new(args.memory, &terminal);
    args.request.write(&resources)?;
    Ok(Outcome::Fine)
}

/// `heliotile tradeoff`.
pub fn tradeoff(args: &Tradeoff, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::default();
    let resources = Resources::new(args.memory, &terminal);
    let done = args.request.write(about, &resources, say)?;
    say(&format!("{}: open it in a browser\n", done.page.display()))?;
    Ok(Outcome::Fine)
}

/// Returns a remark on the files that were written, with the next command.
fn summary(args: &Run, done: &RunDone) -> String {
    let next = match args.request.every.as_slice() {
        [] => "months or hours: the same command with --every month, or ",
        _ => "other periods: ",
    };
    let word = |path: &Path| quoted(&path.to_string_lossy());
    let year = args.request.year.map_or(String::new(), |year| format!(" --year {year}"));
    format!(
        "{}: {}; annual.png is a map, index.html shows all of it in a browser\n{next}heliotile replay {} \
         --weather {}{}{year} --every hour -o hours.parquet\n",
        done.folder.display(),
        done.files.join(", "),
        word(&done.archive),
        word(&args.request.weather),
        words_of(&args.request.about_weather)
    )
}

/// Writes statements about a weather file as on the command line, each behind a space.
fn words_of(about: &WeatherOptions) -> String {
    let zone = about.zone.map(|zone| format!(" --time-zone {}", zone.option()));
    let shift = match about.shift {
        TimeShift::Auto => Some(" --shift auto".to_owned()),
        TimeShift::Minutes(minutes) => (minutes != 0.0).then(|| format!(" --shift {minutes}min")),
    };
    let stamp = about.stamped_at.map(|at| format!(" --weather-stamp {}", at.name()));
    let order = about.date_order.map(|order| format!(" --date-order {}", order.name()));
    [zone, shift, stamp, order].into_iter().flatten().collect()
}
