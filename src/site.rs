//! The way into an archive, or into an atlas that is asked like one. In: a place. Out: an open
//! site, whose light is computed for requests and written to files.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use heliotile_archives::Workspace;
use heliotile_archives::transfer::{self, Extracted, Selection};
use heliotile_atlas::Atlas;
use heliotile_atlas::plan::is_atlas;
use heliotile_atlas::sources::sources_of;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentList, ComponentSet};
use heliotile_core::site::material::Material;
use heliotile_files::writing::claim::OutputGuard;
use heliotile_files::writing::copy::folder_of;
use heliotile_files::writing::guards::{guard_archive, guard_output, is_archive};
use heliotile_remote::places::open_archive;
use heliotile_results::{
    Archives, BeforeSide, BinLabels, BuildingsRequest, BuildingsSummary, ComfortDone, ComfortRequest, CompareRequest,
    CompareSummary, Every, FactorsRequest, FileRequest, Illumination, LightChoice, PlacesRequest, PlacesSummary,
    Provenance, QueryRequest, ReceiverChoice, ReceiverSet, ReplayRequest, Resources, Series, Sources, Tile, TileStream,
};
use heliotile_studies::{SunlightDone, SunlightRequest, SunlightSite};

/// Options of how a site is opened.
#[derive(Clone, Debug)]
pub struct SiteOptions {
    /// How files are read; `None`: through a mapping, unless the archive is large compared with
    /// `memory`.
    pub access: Option<Access>,
    /// Memory budget that decides on `access`.
    pub memory: MemoryBudget,
    /// Receivers that results are computed for. Of an atlas, a box opens only the parts that it
    /// touches.
    pub receivers: ReceiverChoice,
    /// Program and options that files of results state.
    pub about: Provenance,
}

impl Default for SiteOptions {
    fn default() -> Self {
        let (receivers, about) = (ReceiverChoice::default(), Provenance::default());
        SiteOptions { access: None, memory: MemoryBudget::DEFAULT, receivers, about }
    }
}

/// An open archive, or the open parts of an atlas. Clones share the open files, and several threads
/// may read them at once.
///
/// ```no_run
/// # fn main() -> heliotile::Result<()> {
/// use heliotile::{ReplayRequest, Resources, Site};
/// let site = Site::open("site.helio")?;
/// for receiver in site.totals(&ReplayRequest::of("rotterdam.epw"), &Resources::usual())? {
///     println!("{}: {:.0} kWh/m2", receiver.id, receiver.kwh_m2);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Site {
    sources: Arc<Sources>,
    place: PathBuf,
    options: SiteOptions,
}

/// Light of the chosen receivers of a site under suns and skies. Nothing is computed before it is
/// asked for.
pub struct SiteReplay<'a> {
    site: &'a Site,
    receivers: ReceiverSet<'a>,
    light: LightChoice,
    series: Series,
    resources: Resources<'a>,
    /// No file that is written meanwhile may replace an input.
    _guard: OutputGuard,
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

impl Site {
    /// Opens the archive or the atlas at a path or an address.
    pub fn open(place: impl Into<PathBuf>) -> Result<Site> {
        Site::open_with(place, SiteOptions::default())
    }

    /// Opens the archive or the atlas at a path or an address, with options.
    pub fn open_with(place: impl Into<PathBuf>, options: SiteOptions) -> Result<Site> {
        let place = place.into();
        Ok(Site { sources: Arc::new(sources_at(&place, &options)?), place, options })
    }

    /// Returns true if an archive or an atlas is at a place, judged by its name or its first bytes.
    /// Every address counts as an archive.
    pub fn is_at(place: &Path) -> bool {
        is_archive(place) || is_atlas(place)
    }

    /// Returns this site with some of its receivers; `None`: with all that were opened.
    #[must_use]
    pub fn select(&self, receivers: Option<Selection>) -> Site {
        let mut site = self.clone();
        site.options.receivers.selection = receivers;
        site
    }

    /// Returns this site, whose files of results state `about`: the program and its options.
    #[must_use]
    pub fn stating(&self, about: Provenance) -> Site {
        let mut site = self.clone();
        site.options.about = about;
        site
    }

    /// Returns the path or the address.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Returns the open archives.
    pub fn archives(&self) -> Archives<'_> {
        self.sources.borrowed()
    }

    /// Returns true if the y axis counts as north.
    pub fn has_grid_north(&self) -> bool {
        self.options.receivers.grid_north
    }

    /// Returns the archive. An error: the site is an atlas of several.
    pub fn only(&self) -> Result<&Archive> {
        self.archives().only().ok_or_else(|| {
            let hint = "open the archive of each part by itself";
            Error::argument("archive", "is an atlas of several archives", hint)
        })
    }

    /// Returns the number of receivers of the open archives, chosen or not.
    pub fn count(&self) -> u64 {
        self.archives().iter().map(|archive| archive.manifest().receivers.count).sum()
    }

    /// Returns the materials, each name once.
    pub fn materials(&self) -> Result<Vec<Material>> {
        let mut all: Vec<Material> = Vec::new();
        for archive in self.archives().iter() {
            for material in OpenSite::of(archive)?.materials() {
                if all.iter().all(|known| known.name != material.name) {
                    all.push(material.clone());
                }
            }
        }
        Ok(all)
    }

    /// Returns the chosen receivers; data that does not fit into memory goes beside `output`.
    pub fn receivers(&self, output: &Path, memory: MemoryBudget) -> Result<ReceiverSet<'_>> {
        self.options.receivers.of(self.archives(), &working_folder(output), memory)
    }

    /// Reads and checks suns and skies; nothing is computed yet. `output` is the file of results,
    /// `-` if there is none.
    pub fn under<'a>(
        &'a self,
        request: &Illumination,
        output: &Path,
        resources: &Resources<'a>,
    ) -> Result<SiteReplay<'a>> {
        let (about, archives) = (self.options.about.clone(), self.archives());
        let _guard = OutputGuard::new(&self.inputs(&request.files()), &[])?;
        let series = match request {
            Illumination::Conditions(query) => {
                query.check()?;
                query.series(archives, about, resources)?
            }
            Illumination::Weather(replay) => {
                replay.check()?;
                let weather = replay.read_weather(resources, &mut || Ok(archives.manifest().place))?;
                let dated = replay.dated(&weather, resources.observer)?;
                replay.tell_misfits(archives, &weather, resources.observer)?;
                replay.series(archives, &weather, &dated, about, resources)?
            }
        };
        let receivers = self.receivers(output, resources.memory)?;
        Ok(SiteReplay { site: self, receivers, light: request.light().clone(), series, resources: *resources, _guard })
    }

    /// Writes the irradiance under the conditions of a table. Returns a sentence about what was
    /// written, if there is one.
    pub fn query(&self, request: &QueryRequest, files: &FileRequest, resources: &Resources) -> Result<Option<String>> {
        self.write(&Illumination::Conditions(Box::new(request.clone())), files, resources)
    }

    /// Writes the irradiance over a weather file. Returns a sentence about what was written, if
    /// there is one.
    pub fn replay(
        &self,
        request: &ReplayRequest,
        files: &FileRequest,
        resources: &Resources,
    ) -> Result<Option<String>> {
        self.write(&Illumination::Weather(Box::new(request.clone())), files, resources)
    }

    /// Writes the irradiance under suns and skies.
    pub fn write(&self, under: &Illumination, files: &FileRequest, resources: &Resources) -> Result<Option<String>> {
        let inputs = under.files();
        files.check(under.light().chosen_columns().as_ref(), under.every(), &self.inputs(&inputs))?;
        self.under(under, &files.output, resources)?.write(files)
    }

    /// Writes how a change of the site changes its light. This is the site before; the request
    /// holds the places of the sites after.
    pub fn compare(
        &self,
        request: &CompareRequest,
        files: &FileRequest,
        resources: &Resources,
    ) -> Result<CompareSummary> {
        request.check(files, &self.inputs(&request.under.files()))?;
        let replay = self.under(&request.under, &files.output, resources)?;
        let folder = working_folder(&files.output);
        let side = BeforeSide {
            stream: &replay.stream(),
            archives: self.archives(),
            place: &self.place,
            choice: &self.options.receivers,
            folder: &folder,
        };
        request.write(files, &side, &|place| sources_at(place, &self.options_beside()))
    }

    /// Returns the options for another site: all of its receivers, in the same box if there is one,
    /// read as this one.
    fn options_beside(&self) -> SiteOptions {
        let selection = self.options.receivers.within().map(Selection::Bounds);
        let receivers = ReceiverChoice { selection, ..self.options.receivers };
        SiteOptions { receivers, ..self.options.clone() }
    }

    /// Returns the irradiation of each chosen receiver over a weather file, kWh/m2, in the order of
    /// the archive. Memory grows with the number of receivers.
    pub fn totals(&self, request: &ReplayRequest, resources: &Resources) -> Result<Vec<ReceiverTotal>> {
        let light = request.light.only(ComponentList::of(Component::Total));
        let request = ReplayRequest { every: Every::Total, light, ..request.clone() };
        let mut totals = Vec::new();
        self.each_tile(&request, resources, |tile| {
            totals.extend(tile.ids.iter().enumerate().map(|(row, id)| {
                let kwh_m2 = tile.values.row(Component::Total, row).iter().copied().map(f64::from).sum();
                ReceiverTotal { id: id.clone(), kwh_m2 }
            }));
            Ok(true)
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
        let under = Illumination::Weather(Box::new(request.clone()));
        self.under(&under, Path::new("-"), resources)?.each(request.light.columns().set(), take)
    }

    /// Writes a solar cadastre from the sums of a year.
    pub fn buildings(
        &self,
        year: &ReplayRequest,
        request: &BuildingsRequest,
        resources: &Resources,
    ) -> Result<BuildingsSummary> {
        request.check(&self.inputs(&year.files().collect::<Vec<_>>()))?;
        let under = Illumination::Weather(Box::new(year.clone()));
        let replay = self.under(&under, &request.output, resources)?;
        request.write(&replay.stream(), self.archives(), &self.place)
    }

    /// Writes the best places of modules by the sums of a year.
    pub fn places(
        &self,
        year: &ReplayRequest,
        request: &PlacesRequest,
        resources: &Resources,
    ) -> Result<PlacesSummary> {
        request.check(&self.inputs(&year.files().collect::<Vec<_>>()))?;
        let under = Illumination::Weather(Box::new(year.clone()));
        let replay = self.under(&under, &request.output, resources)?;
        request.write(&replay.stream(), self.archives(), &self.place)
    }

    /// Writes the thermal comfort of people at points with six planes each.
    pub fn comfort(&self, request: &ComfortRequest, files: &FileRequest, resources: &Resources) -> Result<ComfortDone> {
        let read: Vec<&Path> = request.files().collect();
        let inputs = self.inputs(&read);
        request.check(files, &inputs)?;
        let _guard = OutputGuard::new(&inputs, &[])?;
        let under = Illumination::Weather(Box::new(request.stream()));
        let replay = self.under(&under, &files.output, resources)?;
        request.write(files, &replay.stream(), self.archives(), &self.place)
    }

    /// Writes the light that surroundings reflect, over the sun's position.
    pub fn factors(&self, request: &FactorsRequest, resources: &Resources) -> Result<()> {
        request.check(&self.inputs(&[]))?;
        let receivers = self.receivers(&request.output, resources.memory)?;
        request.write(&receivers, self.archives().told_in(self.options.about.clone(), &self.place), resources)
    }

    /// Writes the hours of possible sun, or of glare, and the results of rules.
    pub fn sunlight(
        &self,
        request: &SunlightRequest,
        files: &FileRequest,
        resources: &Resources,
    ) -> Result<SunlightDone> {
        request.check(files, &self.inputs(&[]))?;
        let folder = working_folder(&files.output);
        let receivers = self.receivers(&files.output, resources.memory)?;
        let site = self.sunlight_site(&receivers, &folder);
        let about = self.options.about.clone();
        let Some(place) = &request.before else { return request.write(files, &site, None, about, resources) };
        let beside = Site::open_with(place, self.options_beside())?;
        let receivers = beside.receivers(&files.output, resources.memory)?;
        request.write(files, &site, Some(&beside.sunlight_site(&receivers, &folder)), about, resources)
    }

    fn sunlight_site<'a>(&'a self, receivers: &'a ReceiverSet<'a>, folder: &'a Path) -> SunlightSite<'a> {
        SunlightSite { archives: self.archives(), receivers, place: &self.place, folder }
    }

    /// Writes an archive of the chosen receivers. An atlas of several archives is refused.
    pub fn extract(
        &self,
        output: &Path,
        with_scene: bool,
        memory: MemoryBudget,
        observer: &dyn Observer,
    ) -> Result<Extracted> {
        let Some(selection) = &self.options.receivers.selection else {
            let hint = "choose some by names, objects, surfaces or a box";
            return Err(Error::argument("receivers", "no receivers are chosen", hint));
        };
        guard_output(output, &self.inputs(&[]))?;
        guard_archive(output)?;
        let workspace = Workspace { folder: working_folder(output), memory };
        transfer::extract(self.only()?, selection, with_scene, output, &workspace, observer)
    }

    /// Returns the files that are read: the archive, the list of receivers, and `others`.
    fn inputs<'a>(&'a self, others: &[&'a Path]) -> Vec<&'a Path> {
        let list = match &self.options.receivers.selection {
            Some(Selection::Receivers(list)) => Some(list.as_path()),
            _ => None,
        };
        [Some(self.place.as_path()), list].into_iter().flatten().chain(others.iter().copied()).collect()
    }

    /// Returns a sentence about the direction of true north, if suns are turned to it.
    pub fn note_of_north(&self) -> Option<String> {
        let place = self.archives().manifest().place.filter(|_| !self.has_grid_north())?;
        place.note()
    }
}

impl SiteReplay<'_> {
    /// Returns the receivers.
    pub fn receivers(&self) -> &ReceiverSet<'_> {
        &self.receivers
    }

    /// Returns the labels of the bins: names of conditions, or times.
    pub fn bins(&self) -> &BinLabels {
        &self.series.labels
    }

    /// Returns the columns, in the order of results.
    pub fn columns(&self) -> ComponentList {
        self.light.columns()
    }

    /// Returns the provenance that files of these results state.
    pub fn provenance(&self) -> Provenance {
        self.stream().about(self.site.archives(), &self.site.place)
    }

    /// Returns the tiles, ready to be computed.
    pub fn stream(&self) -> TileStream<'_> {
        TileStream { receivers: &self.receivers, light: &self.light, series: &self.series, resources: self.resources }
    }

    /// Computes all tiles and hands each to `take`, until it returns false.
    pub fn each(&self, components: ComponentSet, take: impl FnMut(&Tile) -> Result<bool>) -> Result<()> {
        self.stream().each(components, take)
    }

    /// Writes tables, maps, charts and models of other programs in one pass. Returns a sentence
    /// about what was written, if there is one.
    pub fn write(&self, files: &FileRequest) -> Result<Option<String>> {
        files.write(&self.stream(), self.site.archives(), &self.site.place)
    }
}

/// Opens the archive at a place, or the parts of an atlas there that a box touches.
fn sources_at(place: &Path, options: &SiteOptions) -> Result<Sources> {
    match Atlas::find(place)? {
        Some(atlas) => sources_of(&atlas, options.receivers.within(), options.access.unwrap_or_default()),
        None => Ok(Sources::from(open_archive(place, access_of(place, options))?)),
    }
}

/// Returns how the archive at a place is read.
fn access_of(place: &Path, options: &SiteOptions) -> Access {
    let is_large = || fs::metadata(place).is_ok_and(|about| about.len() > options.memory.total() / MAPPED_SHARE);
    options.access.unwrap_or_else(|| if is_large() { Access::Read } else { Access::Mapped })
}

/// Returns the folder for data that does not fit into memory: beside the output, or the system's
/// temporary folder.
fn working_folder(output: &Path) -> PathBuf {
    if output == Path::new("-") { std::env::temp_dir() } else { folder_of(output).into() }
}
