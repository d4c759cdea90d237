//! Building one part of a region. In: an atlas, the name or number of a part. Out: its receivers
//! and its archive in a folder of its own, from nothing but the plan and the scene files near the
//! part. A part that is there is not traced again, and two processes that build one part do so one
//! after the other. Below an address, the archive is published when it is whole, unless one is
//! there.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use crate::opened::Atlas;
use crate::plan::{FILE, PlannedPart, is_atlas};
use crate::state::{ARCHIVE, FOLDER, NOTHING};
use heliotile_builder::trace::placement::Placement;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_core::text::message;
use heliotile_files::writing::file_lock::FileLock;
use heliotile_remote::naming::{is_address, shown};
use heliotile_results::outputs::sink::write_texts;
use heliotile_studies::covering::cover_site;
use heliotile_studies::site_build::{FolderOption, ReceiverSource, SiteBuild, SiteFolder};

/// Lock file in the folder of a part, held by the process that builds the part.
const LOCK: &str = ".lock";

/// Interval between two attempts to take the lock.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// Parts to build.
#[derive(Clone, Copy, Debug)]
pub struct PartRequest<'a> {
    /// Name or number of a part, or `all`.
    pub part: &'a str,
    /// True if a part that was built from other inputs is replaced.
    pub fresh: bool,
    /// Memory for the build of each part.
    pub memory: MemoryBudget,
    /// Archive or atlas of the region before it was changed; in an atlas, the part of the same name
    /// is used.
    pub from: Option<&'a Path>,
}

/// Builds parts of the atlas at a place.
pub fn build_parts(place: &Path, request: &PartRequest, observer: &dyn Observer) -> Result<()> {
    if !is_address(place) && !is_atlas(place) {
        let what = format!("is not a folder of an atlas: it holds no {FILE}");
        return Err(
            Error::input(place, None, what, "make one with `{command:atlas partition}`").because(Problem::Lacks(FILE))
        );
    }
    let atlas = Atlas::open(place)?;
    let before = request.from.map(Atlas::find).transpose()?.flatten();
    let build = |part| PartBuild { request, atlas: &atlas, before: before.as_ref(), part, observer }.run();
    match request.part {
        "all" => atlas.plan.parts.iter().try_for_each(build),
        asked => build(atlas.plan.part(asked, &atlas.shown())?),
    }
}

/// A part that is to be built.
struct PartBuild<'a> {
    request: &'a PartRequest<'a>,
    atlas: &'a Atlas,
    /// The region before it was changed, if that is an atlas.
    before: Option<&'a Atlas>,
    part: &'a PlannedPart,
    observer: &'a dyn Observer,
}

impl PartBuild<'_> {
    fn run(&self) -> Result<()> {
        if self.atlas.folder.is_remote() {
            return self.publish();
        }
        let folder = self.atlas.folder.join(FOLDER).join(&self.part.name);
        fs::create_dir_all(&folder).map_err(Error::io(&folder, "create"))?;
        let _lock = lock_part(&folder, self.observer)?;
        self.trace(&folder)
    }

    /// Builds a part in a temporary folder and publishes its archive or its marker. If two
    /// processes do so, the first one publishes, and both have the same bytes.
    fn publish(&self) -> Result<()> {
        let PartBuild { request, atlas, part, observer, .. } = *self;
        heliotile_remote::check_writable(atlas.folder.place())?;
        let there = atlas.folder.has(&[part.archive(), part.empty_marker()], atlas.plan.parts.len())?;
        if !request.fresh && there.contains(&true) {
            observer
                .report(message!("{}: built already, nothing is traced again ({{fresh}} replaces it)\n", part.name));
            return Ok(());
        }
        // The part is built here first, so that readers never find one that is incomplete.
        let folder = tempfile::tempdir().map_err(Error::io(&std::env::temp_dir(), "make a folder in"))?;
        self.trace(folder.path()).map_err(|error| match error {
            Error::Stopped { what } => Error::Stopped {
                what: format!("{what}; nothing of it is kept, and the next build starts the part again"),
            },
            error => error,
        })?;
        for file in [ARCHIVE, NOTHING] {
            let built = folder.path().join(file);
            if built.is_file() {
                if file == NOTHING && there.first() == Some(&true) {
                    let place = shown(&atlas.folder.join(&part.archive()));
                    let what = "belongs to a part that has no receivers now";
                    return Err(Error::input(&place, None, what, "remove that object, and build the part again"));
                }
                let place = atlas.folder.join(&part.beside(file));
                let copied = heliotile_remote::copy(&built, &place, request.fresh, observer)?;
                let megabytes = copied.bytes as f64 / 1e6;
                let was_there = if copied.was_there { ", uploaded by another process already" } else { "" };
                observer.report(format!("{}: {megabytes:.2} MB{was_there}\n", shown(&place).display()));
            }
        }
        Ok(())
    }

    /// Returns the archive of this part before the region was changed, or `None` if its atlas has
    /// no such part that is built.
    fn before_part(&self) -> Result<Option<PathBuf>> {
        let Some(atlas) = self.before else { return Ok(self.request.from.map(Path::to_path_buf)) };
        let name = &self.part.name;
        let found = match atlas.plan.parts.iter().find(|part| part.name == *name) {
            Some(part) if atlas.folder.has(&[part.archive()], 1)? == [true] => Some(atlas.folder.join(&part.archive())),
            _ => None,
        };
        if found.is_none() {
            self.observer
                .note(format!("{} has no built part {name}: the whole part is traced", atlas.shown().display()));
        }
        Ok(found)
    }

    /// Builds a part in a folder.
    fn trace(&self, folder: &Path) -> Result<()> {
        let PartBuild { request, atlas, part, observer, .. } = *self;
        let plan = &atlas.plan;
        let site = plan.site(plan.region_part(part), &atlas.shown())?;
        let files = site.parts.len();
        if let Some(file) = plan.changed(&site)? {
            let what = "changed since the region was cut: other parts use the earlier file";
            if !request.fresh {
                let hint = "make another atlas with `{command:atlas partition}`, restore the earlier file, or build this part from the present file with {fresh}";
                return Err(Error::input(&file, None, what, hint).because(Problem::OtherInputs));
            }
            observer.warn(format!("{}: {what}", file.display()));
        }
        let (scene, covered) = cover_site(&site, &plan.cut.cover, observer)?;
        if covered.count(Placement::Free) == 0 {
            let archive = folder.join(ARCHIVE);
            if archive.exists() {
                if !request.fresh {
                    let what = "belongs to a part that has no receivers now";
                    return Err(Error::input(&archive, None, what, "remove it with {fresh}"));
                }
                fs::remove_file(&archive).map_err(Error::io(&archive, "remove"))?;
            }
            write_texts(folder, &[(NOTHING, "No requested surface gets light here.\n".to_owned())])?;
            observer.report(format!("{}: no receiver, nothing to build\n", part.name));
            return Ok(());
        }
        let before = self.before_part()?;
        let table = &folder.join("receivers.csv");
        let receivers = ReceiverSource::Placed { placed: &covered, offset_m: plan.cut.cover.offset_m, table };
        let build = SiteBuild {
            with_scene: !plan.cut.no_scene,
            from: before.as_deref(),
            memory: request.memory,
            ..SiteBuild::new(&scene, receivers, &plan.cut.accuracy)
        };
        let within =
            SiteFolder { folder, archive: &folder.join(ARCHIVE), replace: request.fresh, named_by: FolderOption::Part };
        observer.report(format!("{}: {files} of {} files near it\n", part.name, plan.files.len()));
        build.ensure(&within, observer)?;
        observer.stop_if_cancelled("after a part was complete")
    }
}

/// Locks the folder of a part, and waits while another process builds there. The lock of a process
/// that was killed is free.
fn lock_part(folder: &Path, observer: &dyn Observer) -> Result<FileLock> {
    let path = folder.join(LOCK);
    let mut is_waiting = false;
    loop {
        let file = File::create(&path).map_err(Error::io(&path, "create"))?;
        if let Some(lock) = FileLock::try_new(file).map_err(Error::io(&path, "lock"))? {
            return Ok(lock);
        }
        if !is_waiting {
            observer.report(format!("{}: another process builds it, waiting\n", folder.display()));
            is_waiting = true;
        }
        observer.stop_if_cancelled("while another process built the part")?;
        thread::sleep(LOOK_EVERY);
    }
}
