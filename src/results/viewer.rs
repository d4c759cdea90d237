//! The page that shows an archive in a browser, as one file. In: an archive, weather. Out: an HTML file that holds both, or asks for an archive that is
//! too large for it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::outputs::viewer_page::ViewerPage;
use crate::resources::Resources;
use heliotile_builder::writing::guards::guard_output;
use heliotile_core::archive::Access;
use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_remote::naming::shown;
use heliotile_remote::places::{hold, open_archive};
use heliotile_scene::input;
use heliotile_scene::input::weather::read_weather_as;

/// What is asked of a page.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PageRequest {
    /// Path or address of the archive.
    pub archive: PathBuf,
    /// How it is read.
    pub access: Access,
    /// Weather file whose hours and sums are shown.
    pub weather: Option<PathBuf>,
    /// What is known of that file that it does not state.
    pub about_weather: WeatherOptions,
    /// The file to write.
    pub output: PathBuf,
}

impl PageRequest {
    /// Writes the page.
    pub fn write(&self, resources: &Resources) -> Result<()> {
        let observer = resources.observer;
        let inputs: Vec<&Path> =
            [Some(self.archive.as_path()), self.weather.as_deref()].into_iter().flatten().collect();
        guard_output(&self.output, &inputs)?;
        let archive = open_archive(&self.archive, self.access)?;
        OpenSite::of(&archive)?;
        let mut page = ViewerPage::default().with_archive(&shown(&self.archive), hold(&self.archive)?.as_ref())?;
        if let Some(file) = &self.weather {
            let place = archive.manifest().place;
            let weather = read_weather_as(file, &self.about_weather, &mut || Ok(place))?;
            weather.report.warnings.iter().for_each(|text| observer.warn(text));
            place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| observer.warn(apart));
            page = page.with_weather(file, &input::read(file)?)?;
            if self.about_weather != WeatherOptions::default() {
                page = page.with_clock(&self.about_weather);
            }
        }
        if !page.holds_archive() {
            observer.warn(&format!("{} is larger than 50 MB: the page asks for it", archive.path().display()));
        }
        page.write(&self.output)
    }
}
