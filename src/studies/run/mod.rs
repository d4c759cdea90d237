//! Run from scene files to a year's sun. In: a scene, weather. Out: a folder with receivers, the
//! archive, sums and a map. An existing archive that still fits is not traced again.

mod folder;
pub mod made_from;
mod maps;
mod passes;
mod request;

use std::path::PathBuf;

use crate::covering::cover_site;
use crate::site_build::{FolderOption, ReceiverSource, SiteBuild, SiteFolder};
use crate::sunlight::{SunlightRequest, SunlightSite};
use folder::RunFiles;
use heliotile_results::archives::Archives;
use heliotile_results::files::OutputRequest;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::viewer_page::ViewerPage;
use heliotile_results::receivers::ReceiverSet;
use heliotile_results::resources::Resources;

use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::planning::EffectsUnder;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_remote::places::hold;
use heliotile_scene::Scene;
use heliotile_scene::site::SceneFiles;
use heliotile_weather::distance::far_apart;
use heliotile_weather::series::Weather;
use passes::RunResults;

pub use maps::RunMap;
pub use request::{RunRequest, folder_beside};

/// Result of a run.
#[derive(Clone, Debug)]
pub struct RunDone {
    /// Folder with all files.
    pub folder: PathBuf,
    /// Path of the archive.
    pub archive: PathBuf,
    /// Names of all files, relative to the folder.
    pub files: Vec<String>,
    /// Sums by kind of surface and side, as a text.
    pub table: String,
}

impl RunRequest {
    /// Writes the folder; `about` is the provenance that results state.
    pub fn write(&self, about: Provenance, resources: &Resources) -> Result<RunDone> {
        check_ranges(self)?;
        if self.weather.is_dir() {
            let what = format!("`{}` is a folder, and a run is of one weather file", self.weather.display());
            let hint = "give a file in it, then {command:replay} the archive with the folder";
            return Err(Error::argument("weather", what, hint).because(Problem::other_kind("a folder")));
        }
        let site = self.scene.site()?;
        let files = RunFiles::new(self, &site);
        files.guard(&site, self)?;
        let sunlight = self.sunlight();
        let rules = OutputRequest { by: self.by, ..OutputRequest::new(files.rules(self)) };
        sunlight.iter().try_for_each(|request| request.check(&rules, &[&self.weather]))?;
        let city_model = self.maps.contains(&RunMap::CityModel).then(|| maps::city_model_of(&site)).transpose()?;
        let (archive, weather) = self.archive(&site, &files, resources)?;
        resources.observer.stop_if_cancelled("after site.helio was complete")?;
        files.claim(&archive, &weather, self, resources.observer)?;
        let results =
            RunResults { request: self, files: &files, city_model, archive: &archive, weather: &weather, about };
        let table = results.write(resources)?;
        if let Some(request) = &sunlight {
            let receivers = ReceiverSet::all_of(&archive)?;
            let (archives, place, folder) = (Archives::one(&archive), &*files.archive, &*files.folder);
            let site = SunlightSite { archives, receivers: &receivers, place, folder };
            let done = request.write(&rules, &site, None, results.about.clone(), resources)?;
            resources.observer.report(done.text());
        }
        self.write_page(&files, resources)?;
        Ok(RunDone { files: files.names(self), folder: files.folder, archive: files.archive, table })
    }

    /// Returns the request for rules of sunlight, if there are rules.
    fn sunlight(&self) -> Option<SunlightRequest> {
        (!self.rules.is_empty()).then(|| SunlightRequest {
            rules: self.rules.clone(),
            weather: Some(self.weather.clone()),
            about_weather: self.about_weather,
            ..SunlightRequest::default()
        })
    }

    /// Builds or opens the archive of the scene, and reads the weather. The scene is dropped
    /// afterwards, which frees its memory.
    fn archive(&self, site: &SceneFiles, files: &RunFiles, resources: &Resources) -> Result<(Archive, Weather)> {
        let observer = resources.observer;
        let load = || match self.receivers {
            Some(_) => {
                let scene = Scene::load_site(site)?;
                scene.report.tell(observer);
                Ok((scene, None))
            }
            None => cover_site(site, &self.cover, observer).map(|(scene, covered)| (scene, Some(covered))),
        };
        // Weather is read before the scene, which takes longer: a wrong weather file fails at once.
        let mut loaded = None;
        let mut place = || Ok(loaded.insert(load()?).0.place);
        let weather = resources.weather(&self.weather, &self.about_weather, &mut place)?;
        files.check_weather(&weather, self)?;
        let (scene, covered) = loaded.map_or_else(load, Ok)?;
        scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| observer.warn(apart));
        maps::check(&self.maps, scene.place.as_ref())?;
        if scene.place.is_none() {
            observer.note(
                "no file states the place of the scene: y is taken for north, and maps have no coordinate system \
                 ({crs}, or {latitude} and {longitude})",
            );
        }
        let under = match self.negligible_percent {
            Some(_) => Some(ErrorConditions::of_weather(&self.weather, weather.clone())?),
            None => None,
        };
        let negligible_percent = self.negligible_percent;
        let table = &files.receivers;
        let receivers = match &covered {
            Some(placed) => ReceiverSource::Placed { placed, offset_m: self.cover.offset_m, table },
            None => ReceiverSource::from(table),
        };
        let accuracy = self.accuracy.beside(Some(&self.weather), &self.about_weather);
        let build = SiteBuild {
            under: under.as_ref().map(|weather| EffectsUnder { weather, negligible_percent }),
            with_scene: self.with_scene,
            from: self.from.as_deref(),
            memory: resources.memory,
            files: resources.files,
            ..SiteBuild::new(&scene, receivers, &accuracy)
        };
        let folder = SiteFolder {
            folder: &files.folder,
            archive: &files.archive,
            replace: self.replace,
            named_by: FolderOption::Output,
        };
        let archive = build.ensure(&folder, observer)?;
        Ok((archive, weather))
    }

    /// Writes the page that shows the archive under this weather. The page reads a large archive
    /// from its file.
    fn write_page(&self, files: &RunFiles, resources: &Resources) -> Result<()> {
        let page = ViewerPage::default()
            .with_archive(&files.archive, hold(&files.archive)?.as_ref())?
            .with_weather(&self.weather, &(resources.files)(&self.weather)?)?
            .with_weather_options(&self.about_weather);
        let page = if page.holds_archive() { page } else { page.with_option("archive", "../site.helio") };
        page.write(&files.page)
    }
}
