//! The way into an archive, or into an atlas that is asked like one. In: a place. Out: an open
//! site, whose light is computed for requests and written to files.

mod light;
mod opening;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use opening::{sources_at, working_folder};

use heliotile_archives::Workspace;
use heliotile_archives::transfer::{self, ExtractContent, Extracted, Selection};
use heliotile_atlas::plan::is_atlas;
use heliotile_atlas::{CheckedArchive, ExportRequest, VerifyRequest};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::site::material::Material;
use heliotile_files::writing::claim::OutputGuard;
use heliotile_files::writing::guards::{guard_archive, guard_output, is_archive};
use heliotile_results::{
    Archives, BeforeSide, BuildingsRequest, BuildingsSummary, ComfortDone, ComfortRequest, CompareRequest,
    CompareSummary, Every, FactorsRequest, LightSource, OutputRequest, PlacesRequest, PlacesSummary, Provenance,
    QueryRequest, ReceiverChoice, ReceiverSet, ReplayRequest, Resources, ShadingRequest, ShadingSummary, Sources, Tile,
};
use heliotile_studies::{
    AuditReport, AuditRequest, EnvelopeDone, EnvelopeRequest, SunlightDone, SunlightRequest, SunlightSite, UpdateDone,
    UpdateRequest,
};

pub use light::{ReceiverTotal, SiteReplay};
pub use opening::SiteOptions;

/// An open archive, or the open parts of an atlas. Clones share the open files, and several threads
/// may read them at once.
///
/// ```no_run
/// use heliotile::{ReplayRequest, Resources, Site};
/// let site = Site::open("site.helio")?;
/// for receiver in site.totals(&ReplayRequest::new("rotterdam.epw"), &Resources::usual())? {
///     println!("{}: {:.0} kWh/m2", receiver.id, receiver.kwh_m2);
/// }
/// # Ok::<(), heliotile::Error>(())
/// ```
#[derive(Clone)]
pub struct Site {
    sources: Arc<Sources>,
    place: PathBuf,
    options: SiteOptions,
}

impl Site {
    /// Opens the archive or the atlas at a path or an address.
    ///
    /// ```no_run
    /// # use heliotile::Site;
    /// let site = Site::open("https://example.org/quarter.helio")?;
    /// println!("{} receivers", site.count());
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn open(place: impl Into<PathBuf>) -> Result<Site> {
        Site::open_with(place, SiteOptions::default())
    }

    /// Opens the archive or the atlas at a path or an address, with options.
    ///
    /// ```no_run
    /// # use heliotile::Site;
    /// use heliotile::{Bounds, ReceiverChoice, Selection, SiteOptions};
    /// let square = Bounds::new(&[0.0, 0.0, 200.0, 200.0]).ok().map(Selection::Bounds);
    /// let receivers = ReceiverChoice { selection: square, ..ReceiverChoice::default() };
    /// let options = SiteOptions { receivers, ..SiteOptions::default() };
    /// let square = Site::open_with("atlas", options)?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
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
    ///
    /// ```no_run
    /// # use heliotile::{Selection, Site};
    /// let site = Site::open("site.helio")?;
    /// let roofs = site.select(Some(Selection::Surfaces(vec!["roof".into()])));
    /// # Ok::<(), heliotile::Error>(())
    /// ```
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
            Error::argument("archive", "is an atlas of several archives", hint).because(Problem::other_kind("atlas"))
        })
    }

    /// Returns the number of receivers of the open archives, chosen or not.
    pub fn count(&self) -> u64 {
        self.archives().iter().map(|archive| archive.manifest().receivers.count).sum()
    }

    /// Returns the materials, each name once.
    ///
    /// ```no_run
    /// # use heliotile::Site;
    /// for material in Site::open("site.helio")?.materials()? {
    ///     println!("{}: {}", material.name, material.diffuse);
    /// }
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn materials(&self) -> Result<Vec<Material>> {
        let mut all: Vec<Material> = Vec::new();
        for archive in self.archives().iter() {
            for material in OpenSite::open(archive)?.materials() {
                if all.iter().all(|known| known.name != material.name) {
                    all.push(material.clone());
                }
            }
        }
        Ok(all)
    }

    /// Returns the chosen receivers; data that does not fit into memory goes beside `output`.
    ///
    /// ```no_run
    /// # use heliotile::{MemoryBudget, Site};
    /// let site = Site::open("site.helio")?;
    /// let receivers = site.receivers("-".as_ref(), MemoryBudget::DEFAULT)?;
    /// println!("{} of {}", receivers.names()?.len(), site.count());
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn receivers(&self, output: &Path, memory: MemoryBudget) -> Result<ReceiverSet<'_>> {
        self.options.receivers.of(self.archives(), &working_folder(output), memory)
    }

    /// Reads and checks suns and skies; nothing is computed yet. `output` is the file of results,
    /// `-` if there is none.
    ///
    /// ```no_run
    /// # use heliotile::{ReplayRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// let year = ReplayRequest::new("rotterdam.epw").into();
    /// let replay = site.under(&year, "-".as_ref(), &Resources::usual())?;
    /// println!("{} hours", replay.bins().len());
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn under<'a>(
        &'a self,
        request: &LightSource,
        output: &Path,
        resources: &Resources<'a>,
    ) -> Result<SiteReplay<'a>> {
        let (about, archives) = (self.options.about.clone(), self.archives());
        let _guard = OutputGuard::new(&self.inputs(&request.files()), &[])?;
        let series = match request {
            LightSource::Conditions(query) => {
                query.check()?;
                query.series(archives, about, resources)?
            }
            LightSource::Weather(replay) => {
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
    ///
    /// ```no_run
    /// # use heliotile::{OutputRequest, QueryRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// let suns = QueryRequest::new("conditions.csv");
    /// site.query(&suns, &OutputRequest::new("suns.csv"), &Resources::usual())?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn query(
        &self,
        request: &QueryRequest,
        files: &OutputRequest,
        resources: &Resources,
    ) -> Result<Option<String>> {
        self.write(&request.clone().into(), files, resources)
    }

    /// Writes the irradiance over a weather file. Returns a sentence about what was written, if
    /// there is one.
    ///
    /// ```no_run
    /// # use heliotile::{Every, OutputRequest, ReplayRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// let year = ReplayRequest { every: Every::Month, ..ReplayRequest::new("rotterdam.epw") };
    /// site.replay(&year, &OutputRequest::new("months.parquet"), &Resources::usual())?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn replay(
        &self,
        request: &ReplayRequest,
        files: &OutputRequest,
        resources: &Resources,
    ) -> Result<Option<String>> {
        self.write(&request.clone().into(), files, resources)
    }

    /// Writes the irradiance under suns and skies.
    pub fn write(&self, under: &LightSource, files: &OutputRequest, resources: &Resources) -> Result<Option<String>> {
        let inputs = under.files();
        files.check(under.light().chosen_columns().as_ref(), under.every(), &self.inputs(&inputs))?;
        self.under(under, &files.output, resources)?.write(files)
    }

    /// Writes how a change of the site changes its light. This is the site before; the request
    /// holds the places of the sites after.
    ///
    /// ```no_run
    /// # use heliotile::{CompareRequest, OutputRequest, ReplayRequest, Resources, Site};
    /// let before = Site::open("before.helio")?;
    /// let under = ReplayRequest::new("rotterdam.epw").into();
    /// let (after, summary) = (vec!["after.helio".into()], Some("gains.csv".into()));
    /// let request = CompareRequest { after, under, summary, unmatched: None };
    /// let change = OutputRequest::new("change.csv");
    /// let done = before.compare(&request, &change, &Resources::usual())?;
    /// println!("{}", done.text());
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn compare(
        &self,
        request: &CompareRequest,
        files: &OutputRequest,
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
        let light = request.light.only(ComponentList::new(Component::Total));
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
    ///
    /// ```no_run
    /// # use heliotile::{ReplayRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// site.each_tile(&ReplayRequest::new("rotterdam.epw"), &Resources::usual(), |tile| {
    ///     println!("{} receivers", tile.ids.len());
    ///     Ok(true)
    /// })?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn each_tile(
        &self,
        request: &ReplayRequest,
        resources: &Resources,
        take: impl FnMut(&Tile) -> Result<bool>,
    ) -> Result<()> {
        let under = request.clone().into();
        self.under(&under, Path::new("-"), resources)?.each(request.light.columns().set(), take)
    }

    /// Writes a solar cadastre from the sums of a year.
    ///
    /// ```no_run
    /// # use heliotile::{BuildingsRequest, Every, ReplayRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// let year = ReplayRequest { every: Every::Year, ..ReplayRequest::new("rotterdam.epw") };
    /// let roofs = BuildingsRequest { output: "roofs.csv".into(), ..BuildingsRequest::default() };
    /// println!("{} buildings", site.buildings(&year, &roofs, &Resources::usual())?.buildings);
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn buildings(
        &self,
        year: &ReplayRequest,
        request: &BuildingsRequest,
        resources: &Resources,
    ) -> Result<BuildingsSummary> {
        request.check(&self.inputs(&year.files().collect::<Vec<_>>()))?;
        let under = year.clone().into();
        let replay = self.under(&under, &request.output, resources)?;
        request.write(&replay.stream(), self.archives(), &self.place)
    }

    /// Writes the best places of modules by the sums of a year.
    ///
    /// ```no_run
    /// # use heliotile::{Every, PlacesRequest, ReplayRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// let year = ReplayRequest { every: Every::Year, ..ReplayRequest::new("rotterdam.epw") };
    /// let best = PlacesRequest { output: "best.csv".into(), ..PlacesRequest::default() };
    /// println!("{} places", site.places(&year, &best, &Resources::usual())?.places);
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn places(
        &self,
        year: &ReplayRequest,
        request: &PlacesRequest,
        resources: &Resources,
    ) -> Result<PlacesSummary> {
        request.check(&self.inputs(&year.files().collect::<Vec<_>>()))?;
        let under = year.clone().into();
        let replay = self.under(&under, &request.output, resources)?;
        request.write(&replay.stream(), self.archives(), &self.place)
    }

    /// Writes the light that each object takes from the receivers and reflects to them.
    ///
    /// ```no_run
    /// # use heliotile::{Every, ReplayRequest, Resources, ShadingRequest, Site};
    /// let site = Site::open("site.helio")?;
    /// let months = ReplayRequest { every: Every::Month, ..ReplayRequest::new("rotterdam.epw") };
    /// let table = ShadingRequest { output: "takers.csv".into(), ..ShadingRequest::default() };
    /// println!("{} objects", site.shading(&months, &table, &Resources::usual())?.takers);
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn shading(
        &self,
        under: &ReplayRequest,
        request: &ShadingRequest,
        resources: &Resources,
    ) -> Result<ShadingSummary> {
        request.check(&self.inputs(&under.files().collect::<Vec<_>>()))?;
        let under = under.clone().into();
        let replay = self.under(&under, &request.output, resources)?;
        request.write(&replay.stream(), self.archives(), &self.place)
    }

    /// Writes the thermal comfort of people at points with six planes each.
    ///
    /// ```no_run
    /// # use heliotile::{ComfortRequest, OutputRequest, Resources, Site};
    /// let people = ComfortRequest::new("rotterdam.epw");
    /// let site = Site::open("square.helio")?;
    /// site.comfort(&people, &OutputRequest::new("utci.csv"), &Resources::usual())?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn comfort(
        &self,
        request: &ComfortRequest,
        files: &OutputRequest,
        resources: &Resources,
    ) -> Result<ComfortDone> {
        let read: Vec<&Path> = request.files().collect();
        let inputs = self.inputs(&read);
        request.check(files, &inputs)?;
        let _guard = OutputGuard::new(&inputs, &[])?;
        let under = request.stream().into();
        let replay = self.under(&under, &files.output, resources)?;
        request.write(files, &replay.stream(), self.archives(), &self.place)
    }

    /// Writes the light that surroundings reflect, over the sun's position.
    ///
    /// ```no_run
    /// # use heliotile::{FactorsRequest, Resources, Site};
    /// let table = FactorsRequest { output: "factors.csv".into(), ..FactorsRequest::default() };
    /// Site::open("site.helio")?.factors(&table, &Resources::usual())?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn factors(&self, request: &FactorsRequest, resources: &Resources) -> Result<()> {
        request.check(&self.inputs(&[]))?;
        let receivers = self.receivers(&request.output, resources.memory)?;
        request.write(&receivers, self.archives().told_in(self.options.about.clone(), &self.place), resources)
    }

    /// Writes the hours of possible sun, or of glare, and the results of rules.
    ///
    /// ```no_run
    /// # use heliotile::{OutputRequest, Resources, Site, SunlightRequest};
    /// let site = Site::open("site.helio")?;
    /// let march = SunlightRequest { dates: vec!["03-21".parse()?], ..SunlightRequest::default() };
    /// let done = site.sunlight(&march, &OutputRequest::new("hours.csv"), &Resources::usual())?;
    /// println!("{} places", done.places);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sunlight(
        &self,
        request: &SunlightRequest,
        files: &OutputRequest,
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

    /// Writes the largest building on a plot that leaves the receivers their hours of sun.
    ///
    /// ```no_run
    /// # use heliotile::covering::AreaSource;
    /// # use heliotile::{EnvelopeRequest, Resources, Site};
    /// let mut plot = EnvelopeRequest { hours: Some(2.0), ..EnvelopeRequest::default() };
    /// plot.plot = Some(AreaSource::File("plot.geojson".into()));
    /// plot.sun.dates = vec!["03-21".parse()?];
    /// println!("{}", Site::open("site.helio")?.envelope(&plot, &Resources::usual())?.text());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn envelope(&self, request: &EnvelopeRequest, resources: &Resources) -> Result<EnvelopeDone> {
        request.check(&self.inputs(&[]))?;
        let receivers = self.receivers(&request.output, resources.memory)?;
        let site = self.sunlight_site(&receivers, Path::new(""));
        request.write(&site, self.options.about.clone(), resources)
    }

    fn sunlight_site<'a>(&'a self, receivers: &'a ReceiverSet<'a>, folder: &'a Path) -> SunlightSite<'a> {
        SunlightSite { archives: self.archives(), receivers, place: &self.place, folder }
    }

    /// Writes an archive of the chosen receivers, or of all without hits and cells. An atlas of
    /// several archives is refused.
    ///
    /// ```no_run
    /// # use heliotile::{ExtractContent, MemoryBudget, Selection, Silent, Site};
    /// let window = Selection::Ids(vec!["south/window#3".into()]);
    /// let site = Site::open("site.helio")?.select(Some(window));
    /// let content = ExtractContent { scene: true, replay_only: false };
    /// site.extract("window.helio".as_ref(), content, MemoryBudget::DEFAULT, &Silent)?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn extract(
        &self,
        output: &Path,
        content: ExtractContent,
        memory: MemoryBudget,
        observer: &dyn Observer,
    ) -> Result<Extracted> {
        let selection = self.options.receivers.selection.as_ref();
        if selection.is_none() && !content.replay_only {
            let hint = "choose some by names, objects, surfaces or a box";
            return Err(Error::argument("receivers", "no receivers are chosen", hint));
        }
        guard_output(output, &self.inputs(&[]))?;
        guard_archive(output)?;
        let workspace = Workspace { folder: working_folder(output), memory };
        transfer::extract(self.only()?, selection, content, output, &workspace, observer)
    }

    /// Writes the layers of a receiver as a picture or as values, or a table of view factors. The
    /// archive and its access are those of this site.
    ///
    /// ```no_run
    /// # use heliotile::{atlas::ExportRequest, Resources, Site};
    /// let site = Site::open("site.helio")?;
    /// let (output, receiver) = ("fisheye.png".into(), Some("south/window#3".into()));
    /// let picture = ExportRequest { output, receiver, ..ExportRequest::default() };
    /// site.export(&picture, &Resources::usual())?;
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn export(&self, request: &ExportRequest, resources: &Resources) -> Result<()> {
        let request = ExportRequest { place: self.place.clone(), ..request.clone() };
        request.write(self.options.about.clone(), resources)
    }

    /// Checks every block of the archive, or of the archives of an atlas; `deep` decodes every
    /// layer, too.
    ///
    /// ```no_run
    /// # use heliotile::Site;
    /// for checked in Site::open("site.helio")?.verify(true)? {
    ///     println!("{}", checked.text());
    /// }
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn verify(&self, deep: bool) -> Result<Vec<CheckedArchive>> {
        let mut found = Vec::new();
        let request = VerifyRequest { place: self.place.clone(), deep, ..VerifyRequest::default() };
        request.each(|checked| {
            found.push(checked);
            Ok(())
        })?;
        Ok(found)
    }

    /// Compares the archive with the reference path tracer.
    ///
    /// ```no_run
    /// # use heliotile::{AuditRequest, Resources, SceneRequest, Site};
    /// let scene = SceneRequest::of(["block.city.json"]);
    /// let request = AuditRequest { scene, samples: Some(64), ..AuditRequest::default() };
    /// println!("{}", Site::open("site.helio")?.audit(&request, &Resources::usual())?.text());
    /// # Ok::<(), heliotile::Error>(())
    /// ```
    pub fn audit(&self, request: &AuditRequest, resources: &Resources) -> Result<AuditReport> {
        AuditRequest { archive: self.place.clone(), ..request.clone() }.run(resources)
    }

    /// Writes the archive of an edited scene, and opens it. This is the site before.
    ///
    /// ```no_run
    /// # use heliotile::{Resources, Site, UpdateRequest};
    /// let mut request = UpdateRequest::default();
    /// request.output = "after.helio".into();
    /// request.edits.heights.push("tower=+3m".parse()?);
    /// let (after, done) = Site::open("site.helio")?.update(&request, &Resources::usual())?;
    /// println!("{} receivers, {}", after.count(), done.text());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update(&self, request: &UpdateRequest, resources: &Resources) -> Result<(Site, UpdateDone)> {
        let done = UpdateRequest { before: self.place.clone(), ..request.clone() }.write(resources)?;
        Ok((Site::open_with(&done.archive, self.options_beside())?, done))
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
