//! Commands that compute light from archives: `query`, `replay`, `compare`, `buildings`, `places`,
//! `factors`. In: arguments. Out: requests that are run, and a summary sentence.

use std::io::IsTerminal;
use std::path::Path;

use super::console::terminal::Terminal;
use super::console::voice::remark_aside;
use super::{Outcome, remark};
use crate::cli::{BuildingsArgs, CompareArgs, FactorsArgs, PlacesArgs, QueryArgs, ReplayArgs, SiteArgs};
use heliotile::memory::SystemTemp;
use heliotile::scene::input;
use heliotile::text::counted;
use heliotile::{Error, Provenance, Resources, Result};

/// `heliotile query`.
pub fn query(args: &QueryArgs, about: Provenance) -> Result<Outcome> {
    let table = &args.common.table;
    with_resources(&table.site, |resources| {
        table.open(about, resources.observer)?.query(&args.request()?, &args.common.files(), resources)
    })?;
    Ok(Outcome::Fine)
}

/// `heliotile replay`.
pub fn replay(args: &ReplayArgs, about: Provenance) -> Result<Outcome> {
    // A year of hours is thousands of lines a receiver: a table for programs, not for a terminal.
    if args.prints_hours() && std::io::stdout().is_terminal() {
        let hint = "name a file with {output}, give {every} year, month or total, or pipe the table into a program";
        return Err(Error::argument("output", "would print every hour of every receiver to the terminal", hint));
    }
    let table = &args.common.table;
    let done = with_resources(&table.site, |resources| {
        table.open(about, resources.observer)?.replay(&args.request()?, &args.files(), resources)
    })?;
    done.map_or(Ok(()), |done| remark(&done))?;
    Ok(Outcome::Fine)
}

/// `heliotile compare`.
pub fn compare(args: &CompareArgs, about: Provenance) -> Result<Outcome> {
    let (table, request, files) = (&args.common.table, args.request()?, args.common.files());
    let done = with_resources(&table.site, |resources| {
        table.open(about, resources.observer)?.compare(&request, &files, resources)
    })?;
    let stdout = Path::new("-");
    let has_table = request.has_details(&files) && files.output == stdout && files.plots.is_empty();
    let is_taken = has_table || [&request.summary, &request.unmatched].into_iter().flatten().any(|to| to == stdout);
    if is_taken {
        remark_aside(&done.text())
    } else {
        remark(&done.text())?
    }
    Ok(Outcome::Fine)
}

/// `heliotile buildings`.
pub fn buildings(args: &BuildingsArgs, about: Provenance) -> Result<Outcome> {
    let year = &args.year;
    let done = with_resources(&year.site, |resources| {
        year.site.open(about, resources.observer)?.buildings(&year.request(), &args.request(), resources)
    })?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(&format!("{} with {}\n", counted(done.buildings, "building"), counted(done.faces, "roof face")));
    Ok(Outcome::Fine)
}

/// `heliotile places`.
pub fn places(args: &PlacesArgs, about: Provenance) -> Result<Outcome> {
    let year = &args.year;
    let done = with_resources(&year.site, |resources| {
        year.site.open(about, resources.observer)?.places(&year.request(), &args.request(), resources)
    })?;
    remark_aside(&format!("{} chosen among {}\n", counted(done.places, "place"), counted(done.receivers, "receiver")));
    Ok(Outcome::Fine)
}

/// `heliotile factors`.
pub fn factors(args: &FactorsArgs, about: Provenance) -> Result<Outcome> {
    let table = &args.table;
    with_resources(&table.site, |resources| {
        table.open(about, resources.observer)?.factors(&args.request(), resources)
    })?;
    Ok(Outcome::Fine)
}

/// Calls `then` with the resources of a computation on an archive.
pub fn with_resources<T>(site: &SiteArgs, then: impl FnOnce(&Resources) -> Result<T>) -> Result<T> {
    let (storage, terminal) = (SystemTemp, Terminal::default());
    then(&Resources { memory: site.memory.into(), storage: &storage, files: &input::read, observer: &terminal })
}

#[cfg(test)]
mod tests {
    use crate::cli::{Cli, Command};
    use clap::Parser;

    /// Without an output and a period, `replay` prints hours, so that it is refused on a terminal;
    /// sums, a file, a picture and a Honeybee folder are not: 1 of 5.
    #[test]
    fn only_hours_without_a_file_are_printed() {
        let prints = |options: &str| {
            let line = format!("heliotile replay a.helio -w w.epw {options}");
            match Cli::try_parse_from(line.split_whitespace()).expect("a command line").command {
                Command::Replay(args) => args.prints_hours(),
                _ => false,
            }
        };
        let found = ["", "--every month", "-o t.csv", "--plot map.png", "--honeybee out"].map(prints);
        assert_eq!(found, [true, false, false, false, false]);
    }
}
