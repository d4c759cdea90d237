//! The archive of a scene's receivers in a folder. In: a scene, the receivers on it, a request.
//! Out: the existing archive, if a build would give the same, or a new one. Files of other inputs
//! are kept, unless the request says to replace them.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::covering::{self, CoverRequest, PlacedReceivers};
use crate::horizon::black_below_horizon;
use heliotile_builder::pipeline::{Build, Output, PreparedScene, Start, Workspace, holds_objects};
use heliotile_builder::planning::{AccuracyRequest, BuildRequest, EffectsUnder};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::{BuildSettings, EffectChoice, Effects, Share};
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_remote::places::open_archive;
use heliotile_scene::Scene;
use heliotile_scene::request::SceneRequest;

/// Hint for a folder that holds other results.
pub const KEEP_OR_REPLACE: &str = "give {output} FOLDER to keep both, or {replace} to replace the old results";

/// Hints of a command for a folder that holds files of other inputs.
pub struct WaysOut {
    /// Hint for a folder that holds other results.
    pub results: &'static str,
    /// Hint for a folder in which a build of other inputs was interrupted.
    pub started: &'static str,
}

impl WaysOut {
    /// Hints of commands with an output option.
    pub const USUAL: WaysOut = WaysOut {
        results: KEEP_OR_REPLACE,
        started: "repeat the command that started it to continue, or give {replace} to discard it, or {output} FOLDER to keep it",
    };

    /// Hints of commands whose output option names a table, and whose archive has a folder.
    pub const WITH_FOLDER: WaysOut = WaysOut {
        results: "give {folder} FOLDER to keep both, or {replace} to replace the old archive",
        started: "repeat the command that started it to continue, or give {replace} to discard it, or {folder} FOLDER to keep it",
    };
}

/// Request for an archive, with the paths of its files.
pub struct TraceRequest<'a> {
    pub folder: &'a Path,
    pub receivers: &'a Path,
    pub archive: &'a Path,
    pub accuracy: &'a AccuracyRequest,
    /// Light paths that are traced; an archive with more of them serves, too.
    pub effects: EffectChoice,
    /// True if the archive holds the scene's triangles.
    pub with_scene: bool,
    /// Distance of receivers off their surfaces, metres.
    pub offset_m: f64,
    /// True if files of other inputs are replaced.
    pub replace: bool,
    pub ways_out: WaysOut,
    pub memory: MemoryBudget,
    /// Weather that effects are weighed under, and the share of light below which they may be left
    /// out.
    pub under: Option<EffectsUnder<'a>>,
    /// Archive of the scene before it was changed.
    pub from: Option<&'a Path>,
}

/// Request for the archive of a scene that is covered with receivers, in a folder with the table of
/// these receivers.
#[derive(Clone, Debug)]
pub struct SiteArchiveRequest {
    /// Scene to trace.
    pub scene: SceneRequest,
    /// Surfaces that get receivers, and their density.
    pub cover: CoverRequest,
    /// Accuracy of the archive.
    pub accuracy: AccuracyRequest,
    /// Folder that gets `receivers.csv` and `site.helio`.
    pub folder: PathBuf,
    /// True if files of other inputs in the folder are replaced.
    pub replace: bool,
    /// Memory for all that a build holds besides the scene and its tree.
    pub memory: MemoryBudget,
}

impl SiteArchiveRequest {
    /// Returns a request with default receivers and accuracy.
    pub fn of(scene: SceneRequest, folder: impl Into<PathBuf>) -> Self {
        let (cover, accuracy) = (CoverRequest::default(), AccuracyRequest::default());
        SiteArchiveRequest {
            scene,
            cover,
            accuracy,
            folder: folder.into(),
            replace: false,
            memory: MemoryBudget::DEFAULT,
        }
    }

    /// Builds the archive, unless the existing one has the same inputs, and returns its path.
    pub fn build(&self, observer: &dyn Observer) -> Result<PathBuf> {
        let (scene, covered) = covering::cover_site(&self.scene.site()?, &self.cover, observer)?;
        let archive = self.folder.join("site.helio");
        let asked = TraceRequest {
            folder: &self.folder,
            receivers: &self.folder.join("receivers.csv"),
            archive: &archive,
            accuracy: &self.accuracy,
            effects: EffectChoice::Auto,
            with_scene: true,
            offset_m: self.cover.offset_m,
            replace: self.replace,
            ways_out: WaysOut::USUAL,
            memory: self.memory,
            under: None,
            from: None,
        };
        let built = build_or_reuse(&asked, &scene, Some(&covered), observer)?;
        black_below_horizon(&built)?.iter().for_each(|lost| observer.warn(lost));
        Ok(archive)
    }
}

/// State of the archive in the folder.
enum Found {
    Nothing,
    /// Archive that equals what a build would give.
    Same(Box<Archive>),
    /// Differences of the archive from what a build would give, a sentence each.
    Other(Vec<String>),
}

/// Returns the archive of these inputs: the existing one, or a new one. Files of other inputs are
/// kept, unless `asked.replace` is true.
pub fn build_or_reuse(
    asked: &TraceRequest,
    scene: &Scene,
    covered: Option<&PlacedReceivers>,
    observer: &dyn Observer,
) -> Result<Archive> {
    fs::create_dir_all(asked.folder).map_err(Error::io(asked.folder, "create"))?;
    let before = asked.from.map(|from| open_archive(from, Access::Read)).transpose()?;
    // The new table waits beside the one in the folder, which is replaced only if nothing is
    // refused.
    let planned = match covered {
        Some(covered) => Some(PlannedReceivers::write(covered, asked)?),
        None => None,
    };
    let workspace = Workspace { folder: folder_of(asked.archive).to_path_buf(), memory: asked.memory };
    let path = planned.as_ref().map_or(asked.receivers, PlannedReceivers::path);
    let mut receivers = workspace.read_receivers(path, scene, observer)?;
    let settings = asked.accuracy.settings()?;
    let mut differences = planned.as_ref().map_or(Ok(Vec::new()), |planned| planned.differences(asked.receivers))?;
    let found = archive_of(asked, scene, &mut receivers, &settings)?;
    if let Found::Other(others) = &found {
        differences.extend_from_slice(others);
    }
    if !asked.replace && !differences.is_empty() {
        return Err(refuse(asked, &differences));
    }
    if let (Some(planned), Some(covered)) = (planned, covered) {
        planned.place(asked.receivers)?;
        observer.report(&format!("{}: {}", asked.receivers.display(), covering::summary(covered, scene)));
    }
    if let Found::Same(archive) = found {
        observer.report(&format!("{}: up to date, nothing is traced again\n", asked.archive.display()));
        return Ok(*archive);
    }
    let prepared = PreparedScene::new(scene)?;
    let wanted = BuildRequest {
        accuracy: asked.accuracy,
        share: Share::default(),
        effects: asked.effects,
        under: asked.under,
        with_scene: asked.with_scene,
        store: None,
        from: before.as_ref(),
        preview_percent: None,
    };
    let mut write = |start: Start| {
        let build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer };
        build.plan_and_write(&wanted, &Output { start, ..Output::new(asked.archive.to_owned()) }).map(drop)
    };
    match write(Start::Resume) {
        Err(Error::Incomplete { .. }) if asked.replace => write(Start::Fresh)?,
        done => done.map_err(|error| error.advise(asked.ways_out.started))?,
    }
    Archive::open_with(asked.archive, Access::Read)
}

/// Compares the archive in the folder with what a build would give.
fn archive_of(
    asked: &TraceRequest,
    scene: &Scene,
    receivers: &mut ReceiverTiles,
    settings: &BuildSettings,
) -> Result<Found> {
    if !asked.archive.exists() {
        return Ok(Found::Nothing);
    }
    let archive = match Archive::open_with(asked.archive, Access::Read) {
        Ok(archive) => archive,
        Err(error) => return Ok(Found::Other(vec![format!("site.helio cannot be read ({error})")])),
    };
    let mut others = Vec::new();
    if archive.manifest().scene.content_hash != format::hex(&scene.content_hash()) {
        others.push("the scene or its materials have changed since site.helio was built".to_owned());
    }
    if asked.with_scene && !holds_objects(&archive, scene) {
        others.push("objects of the scene have other names than when site.helio was built".to_owned());
    }
    if archive.manifest().preview.is_some() {
        others.push("site.helio is a preview of a changed scene".to_owned());
    }
    if archive.manifest().ground != scene.ground {
        others.push("the ground of the scene has changed since site.helio was built".to_owned());
    }
    // Positions of the sun depend on the place.
    let same_place = match (&archive.manifest().place, &scene.place) {
        (Some(stated), Some(place)) => stated.is_same(place),
        (stated, place) => stated.is_none() && place.is_none(),
    };
    if !same_place {
        others.push("the place of the scene has changed since site.helio was built".to_owned());
    }
    if archive.manifest().settings.tracing != settings.stated().tracing {
        others.push("site.helio was traced by another release of heliotile, whose light differs".to_owned());
    }
    if let Some(difference) = receivers.difference(&archive)? {
        others.push(format!("the table of receivers now {difference}"));
    }
    others.extend(other_accuracy(&archive, settings, asked.accuracy));
    others.extend(other_effects(&archive, asked.under));
    if archive.has(format::SCENE, TileNumber::FIRST) != asked.with_scene {
        let there = if asked.with_scene { "leaves out" } else { "holds" };
        others.push(format!("site.helio {there} the triangles of the scene"));
    }
    Ok(if others.is_empty() { Found::Same(Box::new(archive)) } else { Found::Other(others) })
}

/// Returns the refusal to replace what is in the folder.
fn refuse(asked: &TraceRequest, differences: &[String]) -> Error {
    let what = format!("holds results of other inputs: {}", differences.join("; "));
    Error::input(asked.folder, None, what, asked.ways_out.results)
}

/// Returns how an archive's accuracy differs from the requested one; `None` if it does not.
fn other_accuracy(archive: &Archive, settings: &BuildSettings, asked: &AccuracyRequest) -> Option<String> {
    let manifest = archive.manifest();
    let accuracy = manifest.accuracy.as_ref();
    let there = match accuracy {
        Some(accuracy) => format!("{{error}} {}%", accuracy.target_percent),
        None if manifest.settings.quality.is_empty() => "custom settings".to_owned(),
        None => format!("{{quality}} {}", manifest.settings.quality),
    };
    let wanted = match asked.error_percent {
        Some(target) if accuracy.is_some_and(|accuracy| accuracy.target_percent == target) => return None,
        Some(target) => format!("{{error}} {target}%"),
        None => {
            let stated = BuildSettings { left_out: Effects::default(), ..BuildSettings::of(&manifest.settings) };
            if stated == *settings && accuracy.is_none() {
                return None;
            }
            let now = settings.stated();
            let pairs = manifest.settings.numbers().zip(now.numbers());
            let others = pairs.filter(|((_, there), (_, now))| there != now);
            let list: Vec<String> = others.map(|((setting, _), (_, now))| format!("{}={now}", setting.name)).collect();
            match now.quality.as_str() {
                "" => format!("{{quality}} {} and {}", asked.quality.name(), list.join(" ")),
                quality => format!("{{quality}} {quality}"),
            }
        }
    };
    Some(format!("site.helio was built with {there}, not {wanted}"))
}

/// Returns how the effects that an archive leaves out differ from those that `asked` allows; `None`
/// if they do not. An archive that leaves out nothing serves, too.
fn other_effects(archive: &Archive, asked: Option<EffectsUnder>) -> Option<String> {
    let there = archive.manifest().negligible.as_ref()?;
    let allowed = asked.and_then(|asked| Some((asked.weather.name(), asked.negligible_percent?)));
    if allowed == Some((there.weather.as_str(), there.percent)) {
        return None;
    }
    let now =
        allowed.map_or("all effects".into(), |(weather, percent)| format!("{{negligible}} {percent}% and {weather}"));
    Some(format!("site.helio was built with {{negligible}} {}% and {}, not {now}", there.percent, there.weather))
}

/// Table of receivers that is written but not yet in its place.
struct PlannedReceivers {
    /// Folder of the table; dropping this value removes it.
    _beside: TempDir,
    file: PathBuf,
}

impl PlannedReceivers {
    /// Writes the receivers that get light.
    fn write(covered: &PlacedReceivers, asked: &TraceRequest) -> Result<Self> {
        let beside = tempfile::Builder::new().prefix(".receivers").tempdir_in(asked.folder);
        let beside = beside.map_err(Error::io(asked.folder, "make a folder in"))?;
        let file = beside.path().join("receivers.csv");
        covering::save(&file, covered, asked.offset_m)?;
        Ok(PlannedReceivers { _beside: beside, file })
    }

    fn path(&self) -> &Path {
        &self.file
    }

    /// Compares the table with the one at `there`: no difference if none is there or they are
    /// equal, otherwise one sentence.
    fn differences(&self, there: &Path) -> Result<Vec<String>> {
        if !there.exists() {
            return Ok(Vec::new());
        }
        let lines = |path: &Path| File::open(path).map(|file| BufReader::new(file).split(b'\n'));
        let (mut old, mut new) = (
            lines(there).map_err(Error::io(there, "read"))?,
            lines(&self.file).map_err(Error::io(&self.file, "read"))?,
        );
        for line in 1_u64.. {
            let of =
                |next: Option<std::io::Result<Vec<u8>>>, path: &Path| next.transpose().map_err(Error::io(path, "read"));
            match (of(old.next(), there)?, of(new.next(), &self.file)?) {
                (None, None) => break,
                (a, b) if a == b => {}
                _ => {
                    return Ok(vec![format!(
                        "receivers.csv differs from line {line} on (other surfaces or spacing, or it was edited: {{receivers}} uses it as it is)"
                    )]);
                }
            }
        }
        Ok(Vec::new())
    }

    /// Moves the table to `to`.
    fn place(self, to: &Path) -> Result<()> {
        fs::rename(&self.file, to).map_err(Error::io(to, "rename to"))
    }
}
