//! Cost of accuracy on the user's own site. In: a scene, receivers. Out: a folder with the ladder
//! of settings as a table, as pictures, and as a page for people.

mod ladder;
mod report;
mod sources;

use std::path::PathBuf;

use serde::Serialize;

use heliotile_archives::Workspace;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::accuracy::trial::Bench;
use heliotile_builder::accuracy::{CONDITIONS, sample};
use heliotile_builder::pipeline::{Build, PreparedScene, read_receivers};
use heliotile_builder::settings::{BuildSettings, EffectChoice};
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_files::writing::copy::folder_of;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::request::SceneRequest;

pub use ladder::{LadderStep, LadderTable};
use report::SiteSummary;
pub use sources::SettingPoint;

/// Request for a trade-off.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct TradeoffRequest {
    /// Scene to trace.
    #[field(flatten)]
    pub scene: SceneRequest,
    /// Table of receivers, CSV with columns receiver,x,y,z, tilt_deg,azimuth_deg (from true north)
    /// or nx,ny,nz, and optionally area_m2,surface; height (above the roof or ground below) may
    /// stand for z.
    #[field(short = 'r', input = Receivers, required)]
    pub receivers: PathBuf,
    /// Folder to write tradeoff.csv, pictures and index.html into.
    #[field(name = "output", short = 'o', metavar = "FOLDER", output = Folder(&["tradeoff.csv"]), required)]
    pub folder: PathBuf,
    /// Number of receivers to try settings on, spread over the site.
    #[field(default = 32, range = 1..=4096)]
    pub sample: u16,
    /// Weather file under which errors are estimated and replays are timed [default: suns from all
    /// sides].
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file", needs("weather"))]
    pub about_weather: WeatherOptions,
    /// Also try each setting alone, and write sources.csv and a picture (takes several times as
    /// long).
    pub sources: bool,
    /// Light paths to trace besides direct sun and sky: `auto` (those that can matter in the
    /// scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves.
    #[field(metavar = "LIST", default = EffectChoice::Auto)]
    pub effects: EffectChoice,
}

/// Result of a trade-off.
#[derive(Clone, Debug, Serialize)]
pub struct TradeoffDone {
    /// Page that shows all results.
    pub page: PathBuf,
    /// Results as text.
    pub table: String,
    /// Ladder of settings: the named qualities and some steps between them.
    pub ladder: LadderTable,
    /// Points of each setting alone, if requested.
    pub sources: Option<Vec<SettingPoint>>,
}

impl TradeoffRequest {
    /// Tries the settings and writes the folder; `about` is the provenance that files state. Each
    /// table is passed to `tell` as soon as it is known.
    pub fn write(
        &self,
        about: Provenance,
        resources: &Resources,
        tell: impl Fn(&str) -> Result<()>,
    ) -> Result<TradeoffDone> {
        check_ranges(self)?;
        let (observer, folder, memory) = (resources.observer, &self.folder, resources.memory);
        let scene = Scene::load_site(&self.scene.site()?)?;
        scene.report.tell(observer);
        let weather = self.weather.as_deref();
        let suns = ErrorConditions::read(weather, &self.about_weather, scene.place, resources.files, observer)?;
        let beside = Workspace { folder: folder_of(folder).into(), memory };
        let mut receivers = read_receivers(&beside, self.receivers.as_path(), &scene, observer)?;
        let prepared = PreparedScene::new(&scene)?;
        let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &beside, observer };
        let left_out = build.forecast(&BuildSettings::default(), self.effects, None)?.left_out;
        let some: Vec<Receiver> = sample(&mut receivers, self.sample.into())?.into_iter().map(|some| some.1).collect();
        // The folder is created only after the inputs are known to be good.
        std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
        let trials = tempfile::Builder::new().prefix("trials").tempdir_in(folder);
        let trials = trials.map_err(Error::io(folder, "make a folder in"))?;
        let bench = Bench {
            scene: &prepared,
            receivers: &some,
            conditions: &suns.some(CONDITIONS),
            workspace: &Workspace { folder: trials.path().into(), memory },
            observer,
        };
        let ladder = LadderTable::climb(&bench, left_out, &suns)?;
        let mut table = ladder.table();
        tell(&table)?;
        let sources = self.sources.then(|| sources::each_alone(&bench, left_out, &suns)).transpose()?;
        if let Some(sources) = &sources {
            let of_sources = sources::table(sources);
            tell(&of_sources)?;
            table += &of_sources;
        }
        let site = SiteSummary {
            scene: self.scene.first(),
            receivers: receivers.count(),
            sample: some.len(),
            weather: suns.name(),
            observer,
        };
        let about = if weather.is_some() { about.with("weather", suns.name()) } else { about };
        let page = report::folder(&site, &ladder, sources.as_deref()).write(folder, &about)?;
        Ok(TradeoffDone { page, table, ladder, sources })
    }
}
