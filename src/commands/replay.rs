//! What archives are asked for: `query`, `replay`, `buildings`, `places`, `factors`. In: arguments. Out: requests that are run, and a sentence on
//! what was done.

use std::fs;
use std::path::Path;

use super::atlas::opened::Atlas;
use super::atlas::sources::sources_of;
use super::terminal::Terminal;
use super::voice::remark_aside;
use super::{Outcome, remark, temporary_files};
use crate::cli::{BuildingsArgs, FactorsArgs, PlacesArgs, QueryArgs, ReplayArgs, SiteArgs, YearArgs};
use crate::files::{open_archive, read_file};
use crate::outputs::factors::FactorTable;
use crate::results::{
    Archives, FactorRows, Provenance, ReceiverChoice, ReceiverSet, ReplayRequest, Resources, Sources, TileStream,
};
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::archive::{Access, Manifest};
use heliotile_core::error::Result;
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::text::counted;
use heliotile_core::weather::series::Weather;

/// What every command here has open.
struct Opened<'a> {
    site: &'a SiteArgs,
    sources: Sources,
}

/// `heliotile query`.
pub fn query(args: &QueryArgs, about: Provenance) -> Result<Outcome> {
    let (request, files) = (args.request()?, args.common.files());
    request.check()?;
    let inputs: Vec<&Path> = request.light.files().chain([request.conditions.as_path()]).collect();
    files.check(request.light.columns.as_ref(), None, &args.common.table.inputs(&inputs))?;
    let opened = Opened::open(&args.common.table.site, &args.common.table.choice())?;
    let (storage, terminal) = (temporary_files(), Terminal::default());
    let resources = resources(&args.common.table.site, &storage, &terminal);
    let series = request.series(opened.archives(), about, &resources)?;
    opened.say_north();
    let receivers = opened.receivers(&args.common.table.choice(), &files.output)?;
    let stream = TileStream { receivers: &receivers, light: &request.light, series: &series, resources };
    files.write(&stream, opened.archives(), opened.place())?;
    Ok(Outcome::Fine)
}

/// `heliotile replay`.
pub fn replay(args: &ReplayArgs, about: Provenance) -> Result<Outcome> {
    let (request, files) = (args.request()?, args.files());
    request.check()?;
    let inputs: Vec<&Path> = request.files().collect();
    files.check(request.light.columns.as_ref(), Some(request.every), &args.common.table.inputs(&inputs))?;
    let table = &args.common.table;
    let done = with_stream(&table.site, &request, &table.choice(), &files.output, about, |stream, opened| {
        files.write(stream, opened.archives(), opened.place())
    })?;
    done.map_or(Ok(()), |done| remark(&done))?;
    Ok(Outcome::Fine)
}

/// `heliotile buildings`.
pub fn buildings(args: &BuildingsArgs, about: Provenance) -> Result<Outcome> {
    let request = args.request();
    request.check(&args.year.inputs())?;
    let done = of_year(&args.year, &request.output, about, |stream, opened| {
        request.write(stream, opened.archives(), opened.place())
    })?;
    // Standard output may be the table.
    remark_aside(&format!("{} with {}\n", counted(done.buildings, "building"), counted(done.faces, "roof face")));
    Ok(Outcome::Fine)
}

/// `heliotile places`.
pub fn places(args: &PlacesArgs, about: Provenance) -> Result<Outcome> {
    let request = args.request();
    request.check(&args.year.inputs())?;
    let done = of_year(&args.year, &request.output, about, |stream, opened| {
        request.write(stream, opened.archives(), opened.place())
    })?;
    remark_aside(&format!("{} of {}\n", counted(done.places, "place"), counted(done.receivers, "receiver")));
    Ok(Outcome::Fine)
}

/// Hands on the sums of a year.
fn of_year<T>(
    year: &YearArgs,
    output: &Path,
    about: Provenance,
    then: impl FnOnce(&TileStream, &Opened) -> Result<T>,
) -> Result<T> {
    with_stream(&year.site, &year.request(), &year.choice(), output, about, then)
}

/// `heliotile factors`.
pub fn factors(args: &FactorsArgs, about: Provenance) -> Result<Outcome> {
    let table = &args.table;
    let files = table.files();
    files.check(None, None, &table.inputs(&[]))?;
    let opened = Opened::open(&table.site, &table.choice())?;
    opened.say_north();
    let receivers = opened.receivers(&table.choice(), &files.output)?;
    let (storage, terminal) = (temporary_files(), Terminal::default());
    let rows = FactorRows::new(&receivers, args.steps_deg(), table.by, &resources(&table.site, &storage, &terminal))?;
    let about = opened.archives().told_in(about, opened.place());
    let mut to = FactorTable::create(&files.output, table.by.name(), rows.grid(), rows.count(), &about)?;
    rows.each(&terminal, |name, factors| {
        to.write(name, factors)?;
        Ok(!to.is_closed())
    })?;
    to.finish()?;
    Ok(Outcome::Fine)
}

/// Opens what a replay reads and hands on its stream; tells what is odd about weather and archives.
fn with_stream<T>(
    site: &SiteArgs,
    request: &ReplayRequest,
    choice: &ReceiverChoice,
    output: &Path,
    about: Provenance,
    then: impl FnOnce(&TileStream, &Opened) -> Result<T>,
) -> Result<T> {
    let (storage, terminal) = (temporary_files(), Terminal::default());
    let resources = resources(site, &storage, &terminal);
    let mut found = None;
    // A wrong weather file is found before an archive is opened.
    let weather: Weather = request
        .read_weather(&resources, &mut || Ok(found.insert(Opened::open(site, choice)?).archives().manifest().place))?;
    let dated = request.dated(&weather, &terminal)?;
    let opened = found.map_or_else(|| Opened::open(site, choice), Ok)?;
    request.tell_misfits(opened.archives(), &weather, &terminal);
    opened.say_north();
    let series = request.series(opened.archives(), (&weather, &dated), about, &resources)?;
    let receivers = opened.receivers(choice, output)?;
    then(&TileStream { receivers: &receivers, light: &request.light, series: &series, resources }, &opened)
}

/// What a computation on an archive may use.
fn resources<'a>(site: &SiteArgs, storage: &'a dyn ScratchSpace, terminal: &'a Terminal) -> Resources<'a> {
    Resources { memory: MemoryBudget::new(site.memory.0), storage, files: &read_file, observer: terminal }
}

impl<'a> Opened<'a> {
    /// Opens the archive, or the parts of the atlas that a box touches.
    fn open(site: &'a SiteArgs, choice: &ReceiverChoice) -> Result<Self> {
        let sources = match Atlas::find(&site.archive)? {
            Some(atlas) => sources_of(&atlas, choice.within(), site.io.unwrap_or_default())?,
            None => Sources::from(open_archive(&site.archive, access(site))?),
        };
        Ok(Opened { site, sources })
    }

    fn archives(&self) -> Archives<'_> {
        self.sources.borrowed()
    }

    fn place(&self) -> &Path {
        &self.site.archive
    }

    /// The receivers that are asked for; what does not fit into memory goes beside the output.
    fn receivers(&self, choice: &ReceiverChoice, output: &Path) -> Result<ReceiverSet<'_>> {
        let folder = if output == Path::new("-") { std::env::temp_dir() } else { folder_of(output).into() };
        choice.of(self.archives(), &folder, MemoryBudget::new(self.site.memory.0))
    }

    /// Says where true north is, if suns are turned to it.
    fn say_north(&self) {
        let Manifest { place, .. } = self.archives().manifest();
        let place = place.filter(|_| !self.site.grid_north);
        // Standard output may be the table.
        place.and_then(|place| place.note()).iter().for_each(|note| remark_aside(&format!("{note}\n")));
    }
}

/// Pages of a mapping count as memory of the program for as long as the system likes: a large archive is read instead.
fn access(site: &SiteArgs) -> Access {
    let large = || fs::metadata(&site.archive).is_ok_and(|about| about.len() > site.memory.0 / 4);
    site.io.unwrap_or_else(|| if large() { Access::Read } else { Access::Mapped })
}
