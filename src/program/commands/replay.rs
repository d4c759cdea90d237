//! Commands that compute light from archives: `replay`, `compare`, `shading`, `buildings`,
//! `places`, `factors`. In: arguments. Out: requests that are run, and a summary sentence.

use std::io::IsTerminal;
use std::path::Path;

use super::console::terminal::Terminal;
use super::console::voice::remark_aside;
use super::{Outcome, remark};
use heliotile::cases::{Buildings, Compare, Factors, Places, Replay, Shading, SiteRequest};
use heliotile::text::counted;
use heliotile::{Error, Every, OutputRequest, Provenance, Resources, Result};

/// `heliotile replay`.
pub fn replay(args: &Replay, about: Provenance) -> Result<Outcome> {
    // A year of hours is thousands of lines a receiver: a table for programs, not for a terminal.
    if prints_hours(args) && std::io::stdout().is_terminal() {
        let hint = "name a file with {output}, give {every} year, month or total, or pipe the table into a program";
        return Err(Error::argument("output", "would print every hour of every receiver to the terminal", hint));
    }
    let done = with_resources(&args.site, |resources| {
        let site = args.site.open(&args.receivers, about, resources.observer)?;
        site.write(&args.under()?, &args.files, resources)
    })?;
    done.map_or(Ok(()), |done| remark(&done))?;
    Ok(Outcome::Fine)
}

/// Returns true if the hours of all receivers would go to standard output as text.
fn prints_hours(args: &Replay) -> bool {
    let OutputRequest { output, plots, honeybee, .. } = &args.files;
    let has_hours = args.under.weather.is_some() && args.request.every == Every::Hour;
    has_hours && output == Path::new("-") && plots.is_empty() && honeybee.is_none()
}

/// `heliotile compare`.
pub fn compare(args: &Compare, about: Provenance) -> Result<Outcome> {
    let (request, files) = (args.request()?, &args.files);
    let done = with_resources(&args.site, |resources| {
        args.site.open(&args.receivers, about, resources.observer)?.compare(&request, files, resources)
    })?;
    let stdout = Path::new("-");
    let has_table = request.has_details(files) && files.output == stdout && files.plots.is_empty();
    let is_taken = has_table || [&request.summary, &request.unmatched].into_iter().flatten().any(|to| to == stdout);
    if is_taken {
        remark_aside(done.text())
    } else {
        remark(done.text())?
    }
    Ok(Outcome::Fine)
}

/// `heliotile shading`.
pub fn shading(args: &Shading, about: Provenance) -> Result<Outcome> {
    let done = with_resources(&args.site, |resources| {
        let site = args.site.open(&args.receivers, about, resources.observer)?;
        site.shading(&args.replay, &args.request, resources)
    })?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(format!("{}\n", done.text()));
    Ok(Outcome::Fine)
}

/// `heliotile buildings`.
pub fn buildings(args: &Buildings, about: Provenance) -> Result<Outcome> {
    let done = with_resources(&args.site, |resources| {
        let site = args.site.open(&args.receivers, about, resources.observer)?;
        site.buildings(&args.year(), &args.request, resources)
    })?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(format!("{} with {}\n", counted(done.buildings, "building"), counted(done.faces, "roof face")));
    Ok(Outcome::Fine)
}

/// `heliotile places`.
pub fn places(args: &Places, about: Provenance) -> Result<Outcome> {
    let done = with_resources(&args.site, |resources| {
        let site = args.site.open(&args.receivers, about, resources.observer)?;
        site.places(&args.year(), &args.request, resources)
    })?;
    remark_aside(format!(
        "{} on surfaces with {}\n",
        counted(done.places, "place"),
        counted(done.receivers, "receiver")
    ));
    Ok(Outcome::Fine)
}

/// `heliotile energyplus factors`.
pub fn factors(args: &Factors, about: Provenance) -> Result<Outcome> {
    with_resources(&args.site, |resources| {
        args.site.open(&args.receivers, about, resources.observer)?.factors(&args.request, resources)
    })?;
    Ok(Outcome::Fine)
}

/// Calls `then` with the resources of a computation on an archive.
pub fn with_resources<T>(site: &SiteRequest, then: impl FnOnce(&Resources) -> Result<T>) -> Result<T> {
    then(&Resources::new(site.memory, &Terminal::default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{command_line, given};
    use heliotile::cases::Command;
    use heliotile::requests::filled;

    /// Without an output and a period, `replay` prints hours, so that it is refused on a terminal;
    /// sums, a file, a picture and a Honeybee folder are not: 1 of 5.
    #[test]
    fn only_hours_without_a_file_are_printed() {
        let prints = |options: &str| {
            let line = format!("heliotile replay a.helio -w w.epw {options}");
            let matches = command_line().try_get_matches_from(line.split_whitespace()).expect("a command line");
            let (name, inside) = matches.subcommand().expect("a command");
            let given = given(Command::by_name(name).expect("a command"), inside);
            prints_hours(&filled::<Replay>(&given).expect("a request"))
        };
        let found = ["", "--every month", "-o t.csv", "--plot map.png", "--honeybee out"].map(prints);
        assert_eq!(found, [true, false, false, false, false]);
    }
}
