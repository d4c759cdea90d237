//! The archive of a scene's receivers: planned, built, or kept in a folder. In: a scene, a table of
//! receivers, how light is traced. Out: a forecast, or an archive. In a folder the existing archive
//! serves if a build would give the same; files of other inputs are kept, unless they may be
//! replaced.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::covering::{self, CoverRequest, PlacedReceivers};
use heliotile_archives::Workspace;
use heliotile_builder::pipeline::{Build, Output, PreparedScene, Start, holds_objects, read_receivers, sort_receivers};
use heliotile_builder::planning::{AccuracyRequest, BuildDone, BuildRequest, EffectsUnder, PlanReport};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::{BuildSettings, EffectChoice, Effects, Share};
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::{Observer, Tone};
use heliotile_core::replay::schedule_csv::ReadFile;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{Message, message};
use heliotile_files::input;
use heliotile_files::writing::copy::folder_of;
use heliotile_files::writing::guards::{check_archive_name, guard_archive};
use heliotile_remote::naming::{is_address, shown};
use heliotile_remote::places::open_archive;
use heliotile_results::horizon::black_below_horizon;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::ReceiverCsv;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;
use heliotile_scene::site::guard_site;

/// Hint for a folder that holds other results.
pub const KEEP_OR_REPLACE: &str = "give {output} FOLDER to keep both, or {replace} to replace the old results";

/// Receivers of a build.
#[derive(Clone, Copy)]
pub enum ReceiverSource<'a> {
    /// Table of receivers, a file or its text in memory.
    Table(ReceiverCsv<'a>),
    /// Receivers in memory, in coordinates of the scene.
    Rows(&'a [Receiver]),
    /// Receivers on surfaces. [`SiteBuild::ensure`] writes their table too.
    Placed {
        /// Receivers, with those that get no light.
        placed: &'a PlacedReceivers,
        /// Distance off the surfaces, metres.
        offset_m: f64,
        /// Table to write.
        table: &'a Path,
    },
}

impl<'a> From<&'a Path> for ReceiverSource<'a> {
    fn from(table: &'a Path) -> Self {
        ReceiverSource::Table(table.into())
    }
}

impl<'a> From<&'a PathBuf> for ReceiverSource<'a> {
    fn from(table: &'a PathBuf) -> Self {
        ReceiverSource::from(table.as_path())
    }
}

impl<'a> From<ReceiverCsv<'a>> for ReceiverSource<'a> {
    fn from(table: ReceiverCsv<'a>) -> Self {
        ReceiverSource::Table(table)
    }
}

impl<'a> From<&'a [Receiver]> for ReceiverSource<'a> {
    fn from(rows: &'a [Receiver]) -> Self {
        ReceiverSource::Rows(rows)
    }
}

/// A scene, its receivers, and how its light is traced.
#[derive(Clone, Copy)]
pub struct SiteBuild<'a> {
    /// Scene to trace.
    pub scene: &'a Scene,
    /// Receivers.
    pub receivers: ReceiverSource<'a>,
    /// Accuracy of the archive.
    pub accuracy: &'a AccuracyRequest,
    /// Light paths that are traced; an archive with more of them serves, too.
    pub effects: EffectChoice,
    /// Weather that effects are weighed under, and the share of light below which they may be left
    /// out.
    pub under: Option<EffectsUnder<'a>>,
    /// Sharing of probes among receivers.
    pub share: Share,
    /// True if the archive holds the scene's triangles.
    pub with_scene: bool,
    /// Archive of the scene before it was changed: a path or an address.
    pub from: Option<&'a Path>,
    /// Memory for all that a build holds besides the scene and its tree.
    pub memory: MemoryBudget,
    /// Function that reads the weather of an error target.
    pub files: ReadFile<'a>,
}

/// Files of an archive that is kept in a folder for later runs.
#[derive(Clone, Copy)]
pub struct SiteFolder<'a> {
    /// Folder, which is created if it is missing.
    pub folder: &'a Path,
    /// Archive in it.
    pub archive: &'a Path,
    /// True if files of other inputs are replaced.
    pub replace: bool,
    /// Option that names the folder.
    pub named_by: FolderOption,
}

/// Option of a command that names the folder of its archive, which messages give as a way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FolderOption {
    /// The output is the folder.
    Output,
    /// The output is a table, and the folder has an option of its own.
    Folder,
    /// The folder belongs to a part of an atlas.
    Part,
}

impl FolderOption {
    /// Returns the hint for a folder that holds other results.
    fn for_results(self) -> &'static str {
        match self {
            FolderOption::Output => KEEP_OR_REPLACE,
            FolderOption::Folder => "give {folder} FOLDER to keep both, or {replace} to replace the old archive",
            FolderOption::Part => BUILD_AGAIN,
        }
    }

    /// Returns the tone of the archive's summary: a part of an atlas is a result; other commands
    /// make results from the archive.
    fn tone(self) -> Tone {
        if self == FolderOption::Part { Tone::Report } else { Tone::Detail }
    }

    /// Returns the hint for a folder in which a build of other inputs was interrupted.
    fn for_interrupted(self) -> &'static str {
        match self {
            FolderOption::Output => {
                "repeat the command that started it to continue, or give {replace} to discard it, or {output} FOLDER to keep it"
            }
            FolderOption::Folder => {
                "repeat the command that started it to continue, or give {replace} to discard it, or {folder} FOLDER to keep it"
            }
            FolderOption::Part => BUILD_AGAIN,
        }
    }
}

/// Hint for a part of an atlas with files of other inputs.
const BUILD_AGAIN: &str =
    "{fresh} builds the part again from the present inputs; other built parts keep the old inputs";

/// Hint for an interrupted build of other inputs.
const OTHER_INPUTS: &str =
    "give the inputs that the build was started with to resume it, {fresh} to discard it, or another {output}";

/// Checks the archive that a build of `site` will write, before anything is read: its name, its
/// folder, and that it is none of the inputs.
pub fn check_output(output: &Path, site: &SceneFiles, inputs: &[Option<&Path>]) -> Result<()> {
    if is_address(output) {
        let hint = "write a file, and then: {command:archive copy} FILE ADDRESS";
        return Err(Error::input(
            &shown(output),
            None,
            "is an address, and only `archive copy` writes to addresses",
            hint,
        ));
    }
    check_archive_name(output)?;
    guard_site(output, site, inputs)?;
    guard_archive(output)
}

impl<'a> SiteBuild<'a> {
    /// Returns a build of the light paths that count, with 4 GiB of memory.
    pub fn new(scene: &'a Scene, receivers: impl Into<ReceiverSource<'a>>, accuracy: &'a AccuracyRequest) -> Self {
        SiteBuild {
            scene,
            receivers: receivers.into(),
            accuracy,
            effects: EffectChoice::Auto,
            under: None,
            share: Share::default(),
            with_scene: true,
            from: None,
            memory: MemoryBudget::DEFAULT,
            files: &input::read,
        }
    }

    fn request<'b>(&'b self, before: Option<&'b Archive>) -> Result<BuildRequest<'b>> {
        Ok(BuildRequest {
            accuracy: self.accuracy,
            share: self.share,
            effects: self.effects,
            under: self.under,
            with_scene: self.with_scene,
            from: before,
            files: self.files,
        })
    }

    fn workspace(&self, folder: &Path) -> Workspace {
        Workspace { folder: folder.to_path_buf(), memory: self.memory }
    }

    /// Reads the receivers into tiles. Returns the table of those on surfaces too, which waits in
    /// `folder`.
    fn tiles(
        &self,
        workspace: &Workspace,
        folder: &Path,
        observer: &dyn Observer,
    ) -> Result<(ReceiverTiles, Option<PlannedReceivers>)> {
        let scene = self.scene;
        match self.receivers {
            ReceiverSource::Table(table) => Ok((read_receivers(workspace, table, scene, observer)?, None)),
            ReceiverSource::Rows(rows) => Ok((sort_receivers(workspace, rows, scene, observer)?, None)),
            ReceiverSource::Placed { placed, offset_m, .. } => {
                let planned = PlannedReceivers::write(placed, offset_m, folder)?;
                Ok((read_receivers(workspace, planned.path(), scene, observer)?, Some(planned)))
            }
        }
    }

    /// Decides what a build would trace, without writing anything. Returns the number of receivers
    /// too.
    pub fn plan(&self, observer: &dyn Observer) -> Result<(PlanReport, usize)> {
        let workspace = self.workspace(&std::env::temp_dir());
        let (mut receivers, _planned) = self.tiles(&workspace, &workspace.folder, observer)?;
        let prepared = PreparedScene::new(self.scene)?;
        let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer };
        let plan = build.decide(&self.request(None)?)?;
        Ok((plan, receivers.count()))
    }

    /// Traces the receivers and writes the archive, which [`check_output`] has checked.
    pub fn build(&self, output: &Output, observer: &dyn Observer) -> Result<BuildDone> {
        let before = self.from.map(|from| open_archive(from, Access::Read)).transpose()?;
        let workspace = self.workspace(folder_of(&output.path));
        let (mut receivers, _planned) = self.tiles(&workspace, &workspace.folder, observer)?;
        let prepared = PreparedScene::new(self.scene)?;
        let build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer };
        let done = build.plan_and_write(&self.request(before.as_ref())?, output);
        let done = done.map_err(|error| error.advise(OTHER_INPUTS))?;
        done.report.tell(self.scene, &output.path, Tone::Report, observer);
        let archive = Archive::open_with(&output.path, Access::Read)?;
        black_below_horizon(&archive)?.iter().for_each(|lost| observer.warn(lost));
        Ok(done)
    }
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
    pub fn new(scene: SceneRequest, folder: impl Into<PathBuf>) -> Self {
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
        let table = &self.folder.join("receivers.csv");
        let receivers = ReceiverSource::Placed { placed: &covered, offset_m: self.cover.offset_m, table };
        let build = SiteBuild { memory: self.memory, ..SiteBuild::new(&scene, receivers, &self.accuracy) };
        build.ensure(
            &SiteFolder {
                folder: &self.folder,
                archive: &archive,
                replace: self.replace,
                named_by: FolderOption::Output,
            },
            observer,
        )?;
        Ok(archive)
    }
}

/// State of the archive in the folder.
enum ArchiveState {
    Nothing,
    /// Archive that equals what a build would give.
    Same(Box<Archive>),
    /// Differences of the archive from what a build would give, a sentence each.
    Other(Vec<Message>),
}

impl SiteBuild<'_> {
    /// Returns the archive of these inputs in a folder: the existing one, or a new one. Files of
    /// other inputs are kept, unless `folder` says to replace them.
    pub fn ensure(&self, folder: &SiteFolder, observer: &dyn Observer) -> Result<Archive> {
        fs::create_dir_all(folder.folder).map_err(Error::io(folder.folder, "create"))?;
        let before = self.from.map(|from| open_archive(from, Access::Read)).transpose()?;
        // The new table waits beside the one in the folder, which is replaced only if nothing is
        // refused.
        let workspace = self.workspace(folder_of(folder.archive));
        let (mut receivers, planned) = self.tiles(&workspace, folder.folder, observer)?;
        let settings = self.accuracy.settings()?;
        let mut differences = match (self.receivers, &planned) {
            (ReceiverSource::Placed { table, .. }, Some(planned)) => planned.differences(table)?,
            _ => Vec::new(),
        };
        let found = self.archive_at(folder.archive, &mut receivers, &settings)?;
        if let ArchiveState::Other(others) = &found {
            differences.extend_from_slice(others);
        }
        if !folder.replace && !differences.is_empty() {
            let what = Message::from("holds results of other inputs: ").and(Message::joined(differences, "; "));
            return Err(
                Error::input(folder.folder, None, what, folder.named_by.for_results()).because(Problem::OtherInputs)
            );
        }
        if let (ReceiverSource::Placed { placed, table, .. }, Some(planned)) = (self.receivers, planned) {
            planned.place(table)?;
            observer.detail(message!("{}: ", table.display()).and(covering::summary(placed)));
        }
        let archive = match found {
            ArchiveState::Same(archive) => {
                observer.report(format!("{}: up to date, nothing is traced again\n", folder.archive.display()));
                *archive
            }
            _ => {
                let prepared = PreparedScene::new(self.scene)?;
                let request = self.request(before.as_ref())?;
                let mut write = |start: Start| {
                    let build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer };
                    build.plan_and_write(&request, &Output { start, ..Output::new(folder.archive.to_owned()) })
                };
                let done = match write(Start::Resume) {
                    Err(Error::Incomplete { .. }) if folder.replace => write(Start::Fresh)?,
                    done => done.map_err(|error| error.advise(folder.named_by.for_interrupted()))?,
                };
                done.report.tell(self.scene, folder.archive, folder.named_by.tone(), observer);
                Archive::open_with(folder.archive, Access::Read)?
            }
        };
        black_below_horizon(&archive)?.iter().for_each(|lost| observer.warn(lost));
        Ok(archive)
    }

    /// Compares the archive at `path` with what a build would give.
    fn archive_at(&self, path: &Path, receivers: &mut ReceiverTiles, settings: &BuildSettings) -> Result<ArchiveState> {
        if !path.exists() {
            return Ok(ArchiveState::Nothing);
        }
        let archive = match Archive::open_with(path, Access::Read) {
            Ok(archive) => archive,
            Err(error) => {
                return Ok(ArchiveState::Other(vec![message!("{} cannot be read ({error:#})", name_of(path))]));
            }
        };
        let mut others: Vec<Message> = Vec::new();
        let name = &name_of(path);
        if archive.manifest().scene.content_hash != format::hex(&self.scene.content_hash()) {
            others.push(message!("the scene or its materials have changed since {name} was built"));
        }
        if self.with_scene && !holds_objects(&archive, self.scene) {
            others.push(message!("objects of the scene have other names than when {name} was built"));
        }
        if archive.manifest().ground != self.scene.ground {
            others.push(message!("the ground of the scene has changed since {name} was built"));
        }
        // Positions of the sun depend on the place.
        let same_place = match (&archive.manifest().place, &self.scene.place) {
            (Some(stated), Some(place)) => stated.is_same(place),
            (stated, place) => stated.is_none() && place.is_none(),
        };
        if !same_place {
            others.push(message!("the place of the scene has changed since {name} was built"));
        }
        if archive.manifest().settings.tracing != settings.stated().tracing {
            others.push(message!("{name} was traced by another release of heliotile, whose light differs"));
        }
        if let Some(difference) = receivers.difference(&archive)? {
            others.push(message!("the table of receivers now {difference}"));
        }
        others.extend(other_accuracy(&archive, settings, self.accuracy));
        others.extend(other_effects(&archive, self.under));
        if archive.has(format::SCENE, TileNumber::FIRST) != self.with_scene {
            let there = if self.with_scene { "leaves out" } else { "holds" };
            others.push(message!("{name} {there} the triangles of the scene"));
        }
        Ok(if others.is_empty() { ArchiveState::Same(Box::new(archive)) } else { ArchiveState::Other(others) })
    }
}

/// Returns how an archive's accuracy differs from the requested one; `None` if it does not.
fn other_accuracy(archive: &Archive, settings: &BuildSettings, asked: &AccuracyRequest) -> Option<Message> {
    let manifest = archive.manifest();
    let accuracy = manifest.accuracy.as_ref();
    let there = match accuracy {
        Some(accuracy) => message!("{{error}} {}%", accuracy.target_percent),
        None if manifest.settings.quality.is_empty() => "custom settings".into(),
        None => message!("{{quality}} {}", manifest.settings.quality),
    };
    let wanted = match asked.error_percent {
        Some(target) if accuracy.is_some_and(|accuracy| accuracy.target_percent == target) => return None,
        Some(target) => message!("{{error}} {target}%"),
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
                "" => message!("{{quality}} {} and {}", asked.quality.name(), list.join(" ")),
                quality => message!("{{quality}} {quality}"),
            }
        }
    };
    let name = name_of(archive.path());
    Some(message!("{name} was built with ").and(there).and(", not ").and(wanted))
}

/// Returns how the effects that an archive leaves out differ from those that `asked` allows; `None`
/// if they do not. An archive that leaves out nothing serves, too.
fn other_effects(archive: &Archive, asked: Option<EffectsUnder>) -> Option<Message> {
    let there = archive.manifest().negligible.as_ref()?;
    let allowed = asked.and_then(|asked| Some((asked.weather.name(), asked.negligible_percent?)));
    if allowed == Some((there.weather.as_str(), there.percent)) {
        return None;
    }
    let now =
        allowed.map_or("all effects".into(), |(weather, percent)| message!("{{negligible}} {percent}% and {weather}"));
    let name = name_of(archive.path());
    Some(message!("{name} was built with {{negligible}} {}% and {}, not ", there.percent, there.weather).and(now))
}

/// Returns the name of a file without its folder.
fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Table of receivers that is written but not yet in its place.
struct PlannedReceivers {
    /// Folder of the table; dropping this value removes it.
    _beside: TempDir,
    file: PathBuf,
}

impl PlannedReceivers {
    /// Writes the receivers that get light.
    fn write(placed: &PlacedReceivers, offset_m: f64, folder: &Path) -> Result<Self> {
        let beside = tempfile::Builder::new().prefix(".receivers").tempdir_in(folder);
        let beside = beside.map_err(Error::io(folder, "make a folder in"))?;
        let file = beside.path().join("receivers.csv");
        covering::save(&file, placed, offset_m)?;
        Ok(PlannedReceivers { _beside: beside, file })
    }

    fn path(&self) -> &Path {
        &self.file
    }

    /// Compares the table with the one at `there`: no difference if none is there or they are
    /// equal, otherwise one sentence.
    fn differences(&self, there: &Path) -> Result<Vec<Message>> {
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
                    return Ok(vec![message!(
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
