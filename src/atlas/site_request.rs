//! Requests to the archive or the atlas at a place. In: requests, and the files that results go to.
//! Out: these files, and summaries.

use std::fs;
use std::path::{Path, PathBuf};

use crate::opened::Atlas;
use crate::plan::is_atlas;
use crate::sources::sources_of;
use heliotile_builder::transfer::Selection;
use heliotile_builder::writing::copy::folder_of;
use heliotile_builder::writing::guards::is_archive;
use heliotile_core::archive::Access;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::replay::components::{Component, ComponentList, ComponentSet};
use heliotile_core::weather::series::Weather;
use heliotile_remote::places::open_archive;
use heliotile_results::{
    Archives, BeforeSide, BuildingsRequest, BuildingsSummary, ComfortDone, ComfortRequest, CompareRequest,
    CompareSummary, Every, FactorsRequest, FileRequest, Illumination, PlacesRequest, PlacesSummary, Provenance,
    QueryRequest, ReceiverChoice, ReceiverSet, ReplayRequest, Resources, Sources, SunlightDone, SunlightRequest,
    SunlightSite, Tile, TileStream,
};

/// An archive, or an atlas whose parts are queried like one archive.
#[derive(Clone, Debug)]
pub struct SiteRequest {
    /// Path or address of the archive or atlas.
    pub place: PathBuf,
    /// How files are read; `None`: through a mapping, unless the archive is large compared with the
    /// memory budget.
    pub access: Option<Access>,
    /// Receivers that results are computed for.
    pub receivers: ReceiverChoice,
}

/// Sum of a receiver over a weather file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverTotal {
    /// Name of the receiver.
    pub id: String,
    /// Irradiation, kWh/m2.
    pub kwh_m2: f64,
}

/// Divisor of the memory budget: an archive of up to this share is mapped. Pages of a mapping count
/// as memory for as long as the system likes.
const MAPPED_SHARE: u64 = 4;

/// A site that is open.
struct OpenedSite<'a> {
    request: &'a SiteRequest,
    sources: Sources,
}

impl SiteRequest {
    /// Requests all receivers at a place.
    pub fn of(place: impl Into<PathBuf>) -> Self {
        SiteRequest { place: place.into(), access: None, receivers: ReceiverChoice::default() }
    }

    /// Writes the irradiance under the conditions of a table.
    pub fn query(
        &self,
        request: &QueryRequest,
        files: &FileRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<Option<String>> {
        request.check()?;
        let read: Vec<&Path> = request.light.files().chain([request.conditions.as_path()]).collect();
        files.check(request.light.chosen_columns().as_ref(), None, &self.inputs(&read))?;
        self.query_stream(request, &files.output, about, resources, |stream, archives| {
            files.write(stream, archives, &self.place)
        })
    }

    /// Writes the irradiance over a weather file.
    pub fn replay(
        &self,
        request: &ReplayRequest,
        files: &FileRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<Option<String>> {
        request.check()?;
        let read: Vec<&Path> = request.files().collect();
        files.check(request.light.chosen_columns().as_ref(), Some(request.every), &self.inputs(&read))?;
        self.stream(request, &files.output, about, resources, |stream, archives| {
            files.write(stream, archives, &self.place)
        })
    }

    /// Writes how a change of the site changes its light. This is the site before; the request
    /// holds the places of the sites after.
    pub fn compare(
        &self,
        request: &CompareRequest,
        files: &FileRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<CompareSummary> {
        request.check(files, &self.inputs(&request.under.files()))?;
        let output = files.output.as_path();
        let folder = working_folder(output);
        let compare = |stream: &TileStream, archives: Archives| {
            let side = BeforeSide { stream, archives, place: &self.place, choice: &self.receivers, folder: &folder };
            request.write(files, &side, &|place| Ok(self.beside(place).open(resources.memory)?.sources))
        };
        match &request.under {
            Illumination::Weather(replay) => self.stream(replay, output, about, resources, compare),
            Illumination::Conditions(query) => self.query_stream(query, output, about, resources, compare),
        }
    }

    /// Returns the request for all receivers of another site, in the same box if there is one, read
    /// like this one.
    fn beside(&self, place: &Path) -> SiteRequest {
        let selection = self.receivers.within().map(Selection::Bounds);
        let receivers = ReceiverChoice { selection, ..self.receivers };
        SiteRequest { place: place.into(), access: self.access, receivers }
    }

    /// Returns the irradiation of each receiver over a weather file, kWh/m2, in the order of the
    /// archive. Memory grows with the number of receivers.
    pub fn totals(&self, request: &ReplayRequest, resources: &Resources) -> Result<Vec<ReceiverTotal>> {
        let light = request.light.only(ComponentList::of(Component::Total));
        let request = ReplayRequest { every: Every::Total, light, ..request.clone() };
        request.check()?;
        let mut totals = Vec::new();
        self.stream(&request, Path::new("-"), Provenance::default(), resources, |stream, _| {
            stream.each(ComponentSet::of(&[Component::Total]), |tile| {
                totals.extend(tile.ids.iter().enumerate().map(|(row, id)| {
                    let kwh_m2 = tile.values.row(Component::Total, row).iter().copied().map(f64::from).sum();
                    ReceiverTotal { id: id.clone(), kwh_m2 }
                }));
                Ok(true)
            })
        })?;
        Ok(totals)
    }

    /// Computes the irradiance over a weather file and calls `take` for each tile, until `take`
    /// returns false.
    pub fn each_tile(
        &self,
        request: &ReplayRequest,
        resources: &Resources,
        take: impl FnMut(&Tile) -> Result<bool>,
    ) -> Result<()> {
        request.check()?;
        let components = request.light.columns().set();
        self.stream(request, Path::new("-"), Provenance::default(), resources, |stream, _| {
            stream.each(components, take)
        })
    }

    /// Writes a solar cadastre from the sums of a year.
    pub fn buildings(
        &self,
        year: &ReplayRequest,
        request: &BuildingsRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<BuildingsSummary> {
        request.check(&self.inputs(&[&year.weather]))?;
        self.stream(year, &request.output, about, resources, |stream, archives| {
            request.write(stream, archives, &self.place)
        })
    }

    /// Writes the best places of modules by the sums of a year.
    pub fn places(
        &self,
        year: &ReplayRequest,
        request: &PlacesRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<PlacesSummary> {
        request.check(&self.inputs(&[&year.weather]))?;
        self.stream(year, &request.output, about, resources, |stream, archives| {
            request.write(stream, archives, &self.place)
        })
    }

    /// Writes the thermal comfort of people at points with six planes each.
    pub fn comfort(
        &self,
        request: &ComfortRequest,
        files: &FileRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<ComfortDone> {
        let read: Vec<&Path> = request.files().collect();
        request.check(files, &self.inputs(&read))?;
        self.stream(&request.stream(), &files.output, about, resources, |stream, archives| {
            request.write(files, stream, archives, &self.place)
        })
    }

    /// Returns true if an archive or an atlas is at a place, judged by its name or its first bytes.
    /// Every address counts as an archive.
    pub fn is_at(place: &Path) -> bool {
        is_archive(place) || is_atlas(place)
    }

    /// Writes the light that surroundings reflect, over the sun's position.
    pub fn factors(&self, request: &FactorsRequest, about: Provenance, resources: &Resources) -> Result<()> {
        request.check(&self.inputs(&[]))?;
        let opened = self.open(resources.memory)?;
        opened.tell_north(resources);
        let receivers = opened.receivers(&request.output, resources.memory)?;
        request.write(&receivers, opened.archives().told_in(about, &self.place), resources)
    }

    /// Writes the hours of possible sun, and the results of sunlight rules.
    pub fn sunlight(
        &self,
        request: &SunlightRequest,
        files: &FileRequest,
        about: Provenance,
        resources: &Resources,
    ) -> Result<SunlightDone> {
        request.check(files, &self.inputs(&[]))?;
        let opened = self.open(resources.memory)?;
        opened.tell_north(resources);
        let receivers = opened.receivers(&files.output, resources.memory)?;
        let folder = working_folder(&files.output);
        let site =
            SunlightSite { archives: opened.archives(), receivers: &receivers, place: &self.place, folder: &folder };
        let Some(place) = &request.before else { return request.write(files, &site, None, about, resources) };
        let beside = self.beside(place);
        let opened = beside.open(resources.memory)?;
        let receivers = opened.receivers(&files.output, resources.memory)?;
        let before = SunlightSite { archives: opened.archives(), receivers: &receivers, place, folder: &folder };
        request.write(files, &site, Some(&before), about, resources)
    }

    /// Returns the files that are read: the archive, the list of receivers, and `others`.
    fn inputs<'a>(&'a self, others: &[&'a Path]) -> Vec<&'a Path> {
        let list = match &self.receivers.selection {
            Some(Selection::Receivers(list)) => Some(list.as_path()),
            _ => None,
        };
        [Some(self.place.as_path()), list].into_iter().flatten().chain(others.iter().copied()).collect()
    }

    /// Opens the files of a query and passes its stream to `then`; reports oddities of conditions
    /// and archives.
    fn query_stream<T>(
        &self,
        request: &QueryRequest,
        output: &Path,
        about: Provenance,
        resources: &Resources,
        then: impl FnOnce(&TileStream, Archives) -> Result<T>,
    ) -> Result<T> {
        let opened = self.open(resources.memory)?;
        let series = request.series(opened.archives(), about, resources)?;
        opened.tell_north(resources);
        let receivers = opened.receivers(output, resources.memory)?;
        let stream =
            TileStream { receivers: &receivers, light: &request.light, series: &series, resources: *resources };
        then(&stream, opened.archives())
    }

    /// Opens the files of a replay and passes its stream to `then`; reports oddities of weather and
    /// archives.
    fn stream<T>(
        &self,
        request: &ReplayRequest,
        output: &Path,
        about: Provenance,
        resources: &Resources,
        then: impl FnOnce(&TileStream, Archives) -> Result<T>,
    ) -> Result<T> {
        let mut found = None;
        // The weather file comes first, so that a wrong one is found before an archive is opened.
        let weather: Weather = request.read_weather(resources, &mut || {
            Ok(found.insert(self.open(resources.memory)?).archives().manifest().place)
        })?;
        let dated = request.dated(&weather, resources.observer)?;
        let opened = found.map_or_else(|| self.open(resources.memory), Ok)?;
        request.tell_misfits(opened.archives(), &weather, resources.observer)?;
        opened.tell_north(resources);
        let series = request.series(opened.archives(), &weather, &dated, about, resources)?;
        let receivers = opened.receivers(output, resources.memory)?;
        let stream =
            TileStream { receivers: &receivers, light: &request.light, series: &series, resources: *resources };
        then(&stream, opened.archives())
    }

    /// Opens the archive, or the parts of the atlas that hold requested receivers.
    fn open(&self, memory: MemoryBudget) -> Result<OpenedSite<'_>> {
        let sources = match Atlas::find(&self.place)? {
            Some(atlas) => sources_of(&atlas, self.receivers.within(), self.access.unwrap_or_default())?,
            None => Sources::from(open_archive(&self.place, self.access_of(memory))?),
        };
        Ok(OpenedSite { request: self, sources })
    }

    fn access_of(&self, memory: MemoryBudget) -> Access {
        let is_large = || fs::metadata(&self.place).is_ok_and(|about| about.len() > memory.total() / MAPPED_SHARE);
        self.access.unwrap_or_else(|| if is_large() { Access::Read } else { Access::Mapped })
    }
}

/// Returns the folder for data that does not fit into memory: beside the output, or the system's
/// temporary folder.
fn working_folder(output: &Path) -> PathBuf {
    if output == Path::new("-") { std::env::temp_dir() } else { folder_of(output).into() }
}

impl OpenedSite<'_> {
    fn archives(&self) -> Archives<'_> {
        self.sources.borrowed()
    }

    /// Returns the requested receivers; data that does not fit into memory goes beside the output.
    fn receivers(&self, output: &Path, memory: MemoryBudget) -> Result<ReceiverSet<'_>> {
        self.request.receivers.of(self.archives(), &working_folder(output), memory)
    }

    /// Reports the direction of true north, if suns are turned to it.
    fn tell_north(&self, resources: &Resources) {
        let place = self.archives().manifest().place.filter(|_| !self.request.receivers.grid_north);
        place.and_then(|place| place.note()).iter().for_each(|note| resources.observer.note(note));
    }
}
