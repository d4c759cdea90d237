//! Folder of a run: the files it holds, and checks before they are written. In: a request, the
//! results. Out: names, and a refusal if results of another scene, spacing, accuracy or weather
//! would be lost.

use std::fs;
use std::path::{Path, PathBuf};

use super::made_from::MadeFrom;
use super::request::{RunRequest, folder_beside};
use super::{RunMap, maps};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::named::name_of;
use heliotile_core::observer::Observer;
use heliotile_core::text::message;
use heliotile_files::writing::guards::guard_archive;
use heliotile_results::outputs::periods::Every;
use heliotile_results::outputs::tables::format::files_of;
use heliotile_results::outputs::tables::layout::By;
use heliotile_scene::site::SceneFiles;
use heliotile_scene::site::guard_site;
use heliotile_weather::series::Weather;

/// Files of the folder.
pub struct RunFiles {
    pub folder: PathBuf,
    pub receivers: PathBuf,
    pub archive: PathBuf,
    /// Folder of the weather's results, which holds the files below.
    pub results: PathBuf,
    pub table: PathBuf,
    /// Map as a picture, from above and from the side.
    pub picture: PathBuf,
    /// Chart with bars of the months.
    pub chart: PathBuf,
    /// City model of the scene with sums.
    pub city_model: PathBuf,
    /// Page that shows the archive in a browser, under this weather.
    pub page: PathBuf,
}

impl RunFiles {
    /// Returns the files of a request, named after the scene and the weather.
    pub fn new(request: &RunRequest, site: &SceneFiles) -> RunFiles {
        let folder = request.folder.clone().unwrap_or_else(|| folder_beside(request.scene.first(), "sun"));
        let results = folder.join(weather_name(&request.weather));
        RunFiles {
            receivers: request.receivers.clone().unwrap_or_else(|| folder.join("receivers.csv")),
            archive: folder.join("site.helio"),
            table: results.join("annual.csv"),
            picture: results.join("annual.png"),
            chart: results.join("months.svg"),
            city_model: results.join(if maps::is_sequence(site) { "annual.city.jsonl" } else { "annual.city.json" }),
            page: results.join("index.html"),
            results,
            folder,
        }
    }

    /// Returns the path of the table of a period.
    pub fn periods(&self, every: Every, request: &RunRequest) -> PathBuf {
        self.table_of(every.periods(), request)
    }

    /// Returns the path of the table of sunlight rules.
    pub fn rules(&self, request: &RunRequest) -> PathBuf {
        self.table_of("rules", request)
    }

    fn table_of(&self, stem: &str, request: &RunRequest) -> PathBuf {
        let by = if request.by == By::default() { String::new() } else { format!(".{}", name_of(&request.by)) };
        self.results.join(format!("{stem}{by}.{}", request.format))
    }

    /// Returns the path of a map.
    pub fn map(&self, map: RunMap) -> PathBuf {
        match map {
            RunMap::Map(format) => self.table.with_extension(format.ending()),
            RunMap::CityModel => self.city_model.clone(),
        }
    }

    /// Returns all files that are written into the weather's folder.
    fn written(&self, request: &RunRequest) -> Vec<PathBuf> {
        let periods = request.every.iter().map(|every| self.periods(*every, request));
        let maps = request.maps.iter().map(|format| self.map(*format));
        let rules = (!request.rules.is_empty()).then(|| self.rules(request));
        let always = [&self.table, &self.picture, &self.chart, &self.page];
        always.into_iter().cloned().chain(maps).chain(periods).chain(rules).collect()
    }

    /// Returns all files that are written into the weather's folder, with their metadata files.
    fn written_and_beside(&self, request: &RunRequest) -> Vec<PathBuf> {
        self.written(request).iter().flat_map(|file| files_of(file)).collect()
    }

    /// Refuses to replace an input, a folder or a device.
    pub fn guard(&self, site: &SceneFiles, request: &RunRequest) -> Result<()> {
        let mut outputs = self.written_and_beside(request);
        outputs.push(self.archive.clone());
        let weather = [Some(request.weather.as_path()), request.accuracy.error_weather.as_deref()];
        for output in &outputs {
            guard_site(output, site, &[&weather[..], &[request.receivers.as_deref()]].concat())?;
        }
        guard_archive(&self.archive)?;
        if request.receivers.is_none() {
            guard_site(&self.receivers, site, &weather)?;
        }
        for folder in [&self.folder, &self.results] {
            if folder.exists() && !folder.is_dir() {
                let what = "is a file, but the output is a folder";
                return Err(Error::input(folder, None, what, "give the folder another name with {output}"));
            }
        }
        Ok(())
    }

    /// Refuses to replace results of other weather, before any work.
    pub fn check_weather(&self, weather: &Weather, request: &RunRequest) -> Result<()> {
        if request.replace {
            return Ok(());
        }
        MadeFrom::check(&self.results, weather, self.written(request))
    }

    /// Records that the weather's folder belongs to this archive and weather, so that results can
    /// be written there.
    pub fn claim(
        &self,
        archive: &Archive,
        weather: &Weather,
        request: &RunRequest,
        observer: &dyn Observer,
    ) -> Result<()> {
        fs::create_dir_all(&self.results).map_err(Error::io(&self.results, "create"))?;
        let names = self
            .written_and_beside(request)
            .into_iter()
            .filter_map(|file| file.file_name()?.to_str().map(str::to_owned));
        let mut now = MadeFrom::new(archive, weather, &request.weather, names.collect());
        now.claim(&self.results, request.replace, observer)?;
        let stale = self.stale(&now);
        if !stale.is_empty() {
            observer.warn(message!(
                "results in {} are of an earlier archive: run their weather again with {{replace}}",
                stale.join(", ")
            ));
        }
        Ok(())
    }

    /// Returns the folders of other weather whose results come from an archive that is no longer
    /// there.
    fn stale(&self, now: &MadeFrom) -> Vec<String> {
        let folders = fs::read_dir(&self.folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
        let old = |folder: &PathBuf| MadeFrom::read(folder).ok().flatten().is_some_and(|made| !made.is_of_archive(now));
        let mut stale: Vec<String> = folders
            .filter(|folder| folder.is_dir() && old(folder))
            .map(|folder| folder.display().to_string())
            .collect();
        stale.sort();
        stale
    }

    /// Returns the names of all files that were written, relative to the folder.
    pub fn names(&self, request: &RunRequest) -> Vec<String> {
        let name = |file: &PathBuf| file.strip_prefix(&self.folder).unwrap_or(file).display().to_string();
        let table = request.receivers.is_none().then(|| "receivers.csv".to_owned());
        let files = table.into_iter().chain(["site.helio".to_owned()]);
        files.chain(self.written(request).iter().map(name)).collect()
    }
}

/// Names in the folder that are not those of weather.
const OWN: [&str; 2] = ["receivers.csv", "site.helio"];

/// Returns the name of a weather file without its ending: `golden_tmy3.epw` gives `golden_tmy3`.
/// Other points in the name stay. A name that would be another file or another folder keeps its
/// ending: `receivers.csv.epw`, `...epw`.
fn weather_name(weather: &Path) -> PathBuf {
    let packed = weather.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"));
    let plain = if packed { weather.with_extension("") } else { weather.to_owned() };
    let stem = plain.file_stem().unwrap_or_default().to_string_lossy();
    let is_own = OWN.iter().any(|own| stem.to_lowercase().starts_with(own)) || stem.bytes().all(|byte| byte == b'.');
    let name = if is_own { plain.file_name() } else { plain.file_stem() };
    name.map_or_else(|| "weather".into(), PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 names of weather files lose their ending and nothing else; 3 that would be another file or
    /// the folder above keep it.
    #[test]
    fn folders_are_named_after_weather() {
        for (file, name) in [
            ("a/golden_tmy3.epw", "golden_tmy3"),
            ("NLD_Den.Haag.062100_IWEC.epw", "NLD_Den.Haag.062100_IWEC"),
            ("w.csv.gz", "w"),
            ("plain", "plain"),
            ("receivers.csv.epw", "receivers.csv.epw"),
            ("Site.helio.epw.gz", "Site.helio.epw"),
            ("...epw", "...epw"),
        ] {
            assert_eq!(weather_name(Path::new(file)), PathBuf::from(name));
        }
    }
}
