//! A copy of an atlas: to a store, from a store, between two. In: an atlas, a destination. Out:
//! archives and catalogue there, and the plan last, so that a reader never finds an atlas with a
//! part still under way. Files that are there and are the same stay. So the same command resumes
//! after an interruption, and brings parts that were built since.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use crate::catalogue::ITEM;
use crate::listed::PARTS;
use crate::opened::Atlas;
use crate::plan::FILE;
use crate::state::PartState;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::{Observer, Silent, Stage};
use heliotile_core::text::counted;
use heliotile_remote::Directory;
use heliotile_remote::naming::shown;
use heliotile_results::outputs::stac::{COLLECTION, THUMBNAIL, VIEWER};

/// Files that are copied between two checks for cancellation.
const STEP: usize = 64;

/// Copies an atlas, file by file.
pub fn copy(atlas: &Atlas, to: &Path, replace: bool, observer: &dyn Observer) -> Result<()> {
    let to = Directory::at(to);
    let plan = atlas.plan.to_json()?;
    let is_there = check_place(&to, &plan)?;
    let (names, missing) = names_of(atlas)?;
    if !to.is_remote() {
        for name in &names {
            let path = to.join(name);
            let folder = path.parent().unwrap_or(to.place());
            fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
        }
    }
    // If one of the two places is remote, its folder runs many copies at a time.
    let remote = if to.is_remote() { &to } else { &atlas.folder };
    let stage = Stage::begin(observer, "files", Some(names.len() as u64 + 1));
    let one = |name: &String| {
        let copy = |replace| heliotile_remote::copy(&atlas.folder.join(name), &to.join(name), replace, &Silent);
        let file = name.rsplit('/').next().unwrap_or(name);
        let is_of_catalogue = [ITEM, COLLECTION, THUMBNAIL, PARTS, VIEWER].contains(&file);
        let copied = match copy(replace) {
            // The files of a catalogue follow from the parts, so they are replaced by the new ones.
            Err(Error::Input { .. }) if is_there && is_of_catalogue => copy(true)?,
            copied => copied?,
        };
        stage.advance(1);
        Ok(if copied.was_there { (0, 0) } else { (1, copied.bytes) })
    };
    let (mut sent, mut bytes) = (0, 0);
    for some in names.chunks(STEP) {
        for (count, length) in remote.each(some, one)? {
            sent += count;
            bytes += length;
        }
        observer.stop_if_cancelled("before all of the atlas was copied")?;
    }
    if Atlas::open(atlas.folder.place())?.plan != atlas.plan {
        let what = "its atlas.json changed during the copy".to_owned();
        return Err(Error::SourceChanged { path: atlas.shown(), what });
    }
    let (count, _) = one(&FILE.to_owned())?;
    drop(stage);
    if missing > 0 {
        observer.warn(format!("{} not built yet, and not copied", counted(missing, "part")));
    }
    let megabytes = bytes as f64 / 1e6;
    let all = counted(names.len() as u64 + 1, "file");
    let place = shown(to.place());
    observer.report(format!("{}: {all}, {} of them new, {megabytes:.2} MB\n", place.display(), sent + count));
    Ok(())
}

/// Returns true if the same atlas is already at `to`. An error: another atlas is there, as parts of
/// two must not lie under one plan.
fn check_place(to: &Directory, plan: &str) -> Result<bool> {
    let refuse =
        |what: &'static str| Err(Error::input(&shown(to.place()), None, what, "copy the atlas to another place"));
    if !to.is_remote() && to.place().exists() && !to.place().is_dir() {
        return refuse("is a file, and an atlas is a folder");
    }
    match Atlas::find(to.place())? {
        Some(there) if there.plan.to_json()? != plan => refuse("holds another atlas, which is not replaced"),
        there => Ok(there.is_some()),
    }
}

/// Returns the names of all files of an atlas but its plan, archives first, and the number of parts
/// that are not built.
fn names_of(atlas: &Atlas) -> Result<(Vec<String>, u64)> {
    let there = atlas.folder.names()?;
    let is_there = |name: &String| there.as_ref().map(|names| names.binary_search(name).is_ok());
    let (mut names, mut beside, mut missing) = (Vec::new(), Vec::new(), 0);
    let look = |archives: &[String]| match &there {
        Some(_) => Ok(archives.iter().map(|name| (is_there(name) == Some(true)).then_some(())).collect()),
        None => {
            let found = atlas.folder.has(archives, archives.len())?.into_iter();
            Ok(found.map(|found| found.then_some(())).collect())
        }
    };
    for (part, state) in atlas.states(None, look)? {
        match state {
            PartState::Built(()) => names.push(part.archive()),
            PartState::Empty => names.push(part.empty_marker()),
            PartState::Missing => missing += 1,
        }
        beside.push(part.beside(ITEM));
    }
    // Where the store gives no list, each file that a catalogue may have is asked for.
    match &there {
        Some(there) => {
            let parts: HashSet<&str> =
                names.iter().filter_map(|name| name.rsplit_once('/')).map(|(folder, _)| folder).collect();
            // Only files of a catalogue are copied; other files in the folder belong to the user.
            let is_beside = |name: &&String| match name.rsplit_once('/') {
                None => [COLLECTION, THUMBNAIL, PARTS, VIEWER].contains(&name.as_str()),
                Some((folder, file)) => [ITEM, THUMBNAIL].contains(&file) && parts.contains(folder),
            };
            let more: Vec<String> = there.iter().filter(is_beside).cloned().collect();
            names.extend(more);
        }
        None => {
            beside.extend(names.iter().filter_map(|name| Some(format!("{}/{THUMBNAIL}", name.rsplit_once('/')?.0))));
            beside.extend([COLLECTION, THUMBNAIL, PARTS, VIEWER].map(str::to_owned));
            let found = atlas.folder.has(&beside, beside.len())?;
            names.extend(beside.into_iter().zip(found).filter_map(|(name, found)| found.then_some(name)));
        }
    }
    Ok((names, missing))
}
