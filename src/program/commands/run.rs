//! `heliotile run`: a year's sun from scene files in one go.

use std::path::Path;

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use crate::cli::{RunArgs, quoted};
use heliotile::memory::SystemTemp;
use heliotile::scene::input;
use heliotile::{Provenance, Resources, Result, RunDone};

/// `heliotile run`.
pub fn run(args: &RunArgs, about: Provenance) -> Result<Outcome> {
    let terminal = Terminal::watching();
    let memory = args.memory.into();
    let resources = Resources { memory, storage: &SystemTemp, files: &input::read, observer: &terminal };
    let done = args.request().write(about, &resources)?;
    say(&format!("\nIrradiation through {}, kWh/m2 (means by area):\n{}", args.weather.display(), done.table))?;
    remark(&summary(args, &done))?;
    Ok(Outcome::Fine)
}

/// Returns a remark on the files that were written, with the next command.
fn summary(args: &RunArgs, done: &RunDone) -> String {
    let next = match args.every.as_slice() {
        [] => "months or hours: the same command with --every month, or ",
        _ => "other periods: ",
    };
    let word = |path: &Path| quoted(&path.to_string_lossy());
    let year = args.year.map_or(String::new(), |year| format!(" --year {year}"));
    format!(
        "{}: {}; annual.ply is the map, annual.png a picture of it, index.html shows all of it in a browser\n{next}heliotile replay {} \
         --weather {}{}{year} --every hour -o hours.parquet\n",
        done.folder.display(),
        done.files.join(", "),
        word(&done.archive),
        word(&args.weather),
        args.about_weather
    )
}
