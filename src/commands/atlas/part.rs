//! `heliotile build --part`: one part of a region. In: an atlas, the name or number of a part. Out: its receivers and its archive, in a
//! folder of its own, from nothing but the plan and the scene files near the part. A part that is there is not traced again, and two processes
//! that build one part do so one after the other. Below an address, the archive is published when it is whole, unless one is there.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use super::opened::Atlas;
use super::plan::{FILE, PlannedPart, is_atlas};
use crate::cli::BuildArgs;
use crate::commands::receivers::cover_site;
use crate::commands::terminal::Terminal;
use crate::commands::traced::{TraceRequest, WaysOut, up_to_date};
use crate::commands::{Outcome, interrupt, remark, warn};
use crate::files::{self, is_address, shown};
use crate::outputs::sink::write_texts;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::trace::placement::Lying;
use heliotile_core::error::{Error, Result};

/// The folder of parts in that of an atlas.
const FOLDER: &str = "parts";

/// The archive of a part.
const ARCHIVE: &str = "site.helio";

/// Locked by who builds a part.
const LOCK: &str = ".lock";

/// How often the lock is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// Says that no receiver lies in a part.
const NOTHING: &str = "no-receivers.txt";

/// What to do where a part of other inputs is.
const FRESH: &str = "--fresh to build it of today's inputs in its place; other parts may be of those of then";

/// What is there of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartState<A = PathBuf> {
    /// Nothing that is finished.
    Missing,
    /// It has no receiver.
    Empty,
    /// Its archive.
    Built(A),
}

impl PlannedPart {
    /// Its archive, by its name in the folder of the atlas.
    pub fn archive(&self) -> String {
        self.beside(ARCHIVE)
    }

    /// What stands there instead if no receiver lies in it.
    pub fn says_nothing(&self) -> String {
        self.beside(NOTHING)
    }

    /// Another file of its folder, likewise.
    pub fn beside(&self, file: &str) -> String {
        format!("{FOLDER}/{}/{file}", self.name)
    }
}

/// `heliotile build ATLAS --part K`.
pub fn build(args: &BuildArgs, asked: &str) -> Result<Outcome> {
    let [place] = args.scene.scene.as_slice() else {
        let what = format!("{} scene files are named beside a part", args.scene.scene.len());
        return Err(Error::argument(
            "--part",
            what,
            "name the folder or the address of the atlas, which knows its files",
        ));
    };
    if !is_address(place) && !is_atlas(place) {
        let what = format!("is no folder of an atlas: it holds no {FILE}");
        return Err(Error::input(place, None, what, "make one with `heliotile partition`"));
    }
    let atlas = Atlas::open(place)?;
    match asked {
        "all" => atlas.plan.parts.iter().try_for_each(|part| build_part(args, &atlas, part))?,
        asked => build_part(args, &atlas, atlas.plan.part(asked, &atlas.shown())?)?,
    }
    Ok(Outcome::Fine)
}

fn build_part(args: &BuildArgs, atlas: &Atlas, part: &PlannedPart) -> Result<()> {
    if atlas.folder.is_afar() {
        return publish_part(args, atlas, part);
    }
    let folder = atlas.folder.join(FOLDER).join(&part.name);
    fs::create_dir_all(&folder).map_err(Error::io(&folder, "create"))?;
    let _alone = alone(&folder)?;
    trace_part(args, atlas, part, &folder)
}

/// Builds a part here and sends what others read of it; of two who do so one is first, and both have the same bytes.
fn publish_part(args: &BuildArgs, atlas: &Atlas, part: &PlannedPart) -> Result<()> {
    files::check_writable(atlas.folder.place())?;
    let there = atlas.folder.has(&[part.archive(), part.says_nothing()], atlas.plan.parts.len())?;
    if !args.fresh && there.contains(&true) {
        return remark(&format!("{}: is there, nothing is traced again (--fresh replaces it)\n", part.name));
    }
    let folder = tempfile::tempdir().map_err(Error::io(&std::env::temp_dir(), "make a folder in"))?;
    trace_part(args, atlas, part, folder.path()).map_err(|error| match error {
        Error::Stopped { what } => {
            Error::Stopped { what: format!("{what}, of which nothing is kept: the part begins anew") }
        }
        error => error,
    })?;
    for file in [ARCHIVE, NOTHING] {
        let built = folder.path().join(file);
        if built.is_file() {
            if file == NOTHING && there.first() == Some(&true) {
                let place = shown(&atlas.folder.join(&part.archive()));
                let what = "is of a part that has no receiver now";
                return Err(Error::input(&place, None, what, "remove that object, and build the part again"));
            }
            let place = atlas.folder.join(&part.beside(file));
            let copied = files::copy(&built, &place, args.fresh, &Terminal::default())?;
            let megabytes = copied.bytes as f64 / 1e6;
            let was_there = if copied.was_there { ", sent by another meanwhile" } else { "" };
            remark(&format!("{}: {megabytes:.2} MB{was_there}\n", shown(&place).display()))?;
        }
    }
    Ok(())
}

/// Waits until nobody else builds there; a builder that was killed holds nothing.
fn alone(folder: &Path) -> Result<File> {
    let path = folder.join(LOCK);
    let file = File::create(&path).map_err(Error::io(&path, "create"))?;
    for turn in 0_u64.. {
        match file.try_lock() {
            Ok(()) => break,
            Err(TryLockError::Error(source)) => return Err(Error::io(&path, "lock")(source)),
            Err(TryLockError::WouldBlock) if turn == 0 => {
                remark(&format!("{}: another process builds it, waiting\n", folder.display()))?;
            }
            Err(TryLockError::WouldBlock) => {}
        }
        interrupt::stop_if_requested("while another process built the part")?;
        thread::sleep(LOOK_EVERY);
    }
    Ok(file)
}

/// Builds a part in a folder.
fn trace_part(args: &BuildArgs, atlas: &Atlas, part: &PlannedPart, folder: &Path) -> Result<()> {
    let plan = &atlas.plan;
    let site = plan.site(plan.region_part(part), &atlas.shown())?;
    let files = site.parts.len();
    if let Some(file) = plan.changed(&site)? {
        let what = "is another file than when the region was cut: other parts are of that one, or will be";
        if !args.fresh {
            let hint = "make another atlas with `heliotile partition`, put the file of then back, or build the part all the same with --fresh";
            return Err(Error::input(&file, None, what, hint));
        }
        warn(&format!("{}: {what}", file.display()));
    }
    let (scene, covered) = cover_site(&site, &plan.cover)?;
    if covered.count(Lying::Free) == 0 {
        let archive = folder.join(ARCHIVE);
        if archive.exists() {
            if !args.fresh {
                let what = "is of a part that has no receiver now";
                return Err(Error::input(&archive, None, what, "--fresh to remove it"));
            }
            fs::remove_file(&archive).map_err(Error::io(&archive, "remove"))?;
        }
        write_texts(folder, &[(NOTHING, "No surface that is asked for gets light here.\n".to_owned())])?;
        return remark(&format!("{}: no receiver, nothing to build\n", part.name));
    }
    let accuracy = plan.accuracy()?;
    let request = TraceRequest {
        folder,
        receivers: &folder.join("receivers.csv"),
        archive: &folder.join(ARCHIVE),
        accuracy: &accuracy,
        effects: EffectChoice::Auto,
        with_scene: !plan.no_scene,
        offset_m: plan.cover.offset.0,
        replace: args.fresh,
        ways_out: WaysOut { results: FRESH, started: FRESH },
        memory: args.memory,
        under: None,
        about_error_weather: None,
    };
    remark(&format!("{}: {files} of {} files near it\n", part.name, plan.files.len()))?;
    up_to_date(&request, &scene, Some(&covered))?;
    interrupt::stop_if_requested("after a part was complete")
}
