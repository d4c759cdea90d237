//! The page that shows one archive in a browser, or two of them before and after a change. In:
//! archives, weather. Out: an HTML file that holds the archives, or asks for those that are too
//! large for it.

use std::path::{Path, PathBuf};

use crate::doubts::check_one_site;
use crate::outputs::viewer_page::ViewerPage;
use crate::receivers::ReceiverSet;
use crate::resources::Resources;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::opened::{OpenSite, ReceiverMatching, ReceiverPlace};
use heliotile_core::weather::options::WeatherOptions;
use heliotile_files::writing::guards::guard_output;
use heliotile_remote::naming::shown;
use heliotile_remote::places::{hold, open_archive};
use heliotile_requests::Request;
use heliotile_weather::distance::far_apart;

/// Request for a page.
#[derive(Clone, Debug, Default, Request)]
pub struct PageRequest {
    /// Archive to show, or folder of an atlas.
    #[field(positional, required, input = Archive)]
    pub archive: PathBuf,
    /// Archive of the same site after a change: the page shows before, after and the change, under
    /// one sun, weather and camera.
    #[field(python = "with_", metavar = "AFTER", input = Archive)]
    pub with: Option<PathBuf>,
    /// Mode in which archives are read.
    #[field(skip)]
    pub access: Access,
    /// Weather file whose hours and sums are shown: EPW, TMY3, SAM, PVGIS or CSV, packed with gzip
    /// or not.
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file", needs("weather"))]
    pub about_weather: WeatherOptions,
    /// HTML file to write.
    #[field(skip)]
    pub output: PathBuf,
}

impl PageRequest {
    /// Writes the page.
    pub fn write(&self, resources: &Resources) -> Result<()> {
        let observer = resources.observer;
        let inputs = [Some(self.archive.as_path()), self.with.as_deref(), self.weather.as_deref()];
        let inputs: Vec<&Path> = inputs.into_iter().flatten().collect();
        guard_output(&self.output, &inputs)?;
        let archive = open_archive(&self.archive, self.access)?;
        OpenSite::open(&archive)?;
        let mut page = ViewerPage::default().with_archive(&shown(&self.archive), hold(&self.archive)?.as_ref())?;
        if let Some(with) = &self.with {
            let after = open_after(&archive, with, self.access, observer)?;
            page = page.with_after(&shown(with), hold(with)?.as_ref())?;
            if !page.holds_after() {
                let what = "does not fit into the 50 MB of a page: open it there with `Compare with`";
                observer.warn(format!("{} {what}", after.path().display()));
            }
        }
        if let Some(file) = &self.weather {
            let place = archive.manifest().place;
            let weather = resources.weather(file, &self.about_weather, &mut || Ok(place))?;
            place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| observer.warn(apart));
            page = page.with_weather(file, &(resources.files)(file)?)?;
            if self.about_weather != WeatherOptions::default() {
                page = page.with_weather_options(&self.about_weather);
            }
        }
        if !page.holds_archive() {
            observer.warn(format!(
                "{} is larger than 50 MB: the page does not contain it, and asks for it when opened",
                archive.path().display()
            ));
        }
        page.write(&self.output)
    }
}

/// Opens the archive of a changed site, to be shown beside `before`. Errors: an archive of another
/// place or coordinate system, and one without a receiver of `before`. Warns if both archives are
/// equal.
pub fn open_after(before: &Archive, after: &Path, access: Access, observer: &dyn Observer) -> Result<Archive> {
    let archive = open_archive(after, access)?;
    let refuse = |what: String, hint: &'static str| {
        Err(Error::input(archive.path(), None, what, hint).because(Problem::OtherSite))
    };
    let first = before.path().display();
    check_one_site(before, &archive)?;
    if before.root() == archive.root() {
        observer.warn(format!("{} and {first} are equal: nothing changes", archive.path().display()));
        return Ok(archive);
    }
    let [one, other] = [before, &archive].map(receiver_places);
    if ReceiverMatching::new(&one?, &other?).pairs.is_empty() {
        let what = format!("has no receiver in common with {first}: no change can be shown");
        return refuse(what, "build both archives with receivers of the same places or names");
    }
    Ok(archive)
}

/// Returns the places by which receivers of two archives are matched, in the archive's order.
fn receiver_places(archive: &Archive) -> Result<Vec<ReceiverPlace>> {
    ReceiverSet::all_of(archive)?.receivers().map(|receiver| Ok((&receiver?).into())).collect()
}
