//! The archives of an atlas that results are made of. In: the place of an archive or of an atlas, and the box that is asked for. Out: the archive,
//! or those of the parts that the box touches.

use std::path::Path;

use crate::opened::Atlas;
use heliotile_builder::pipeline::Workspace;
use heliotile_builder::transfer::{Bounds, Selection};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::OpenSite;
use heliotile_remote::places::open_archive;
use heliotile_results::Sources;

/// Those of the parts of an atlas, at its place, that a box touches. A part that is not built is an error.
pub fn archives(atlas: &Path, within: Option<Bounds>, access: Access) -> Result<Sources> {
    sources_of(&Atlas::open(atlas)?, within, access)
}

/// The archive at a place; of an atlas there that of the part which holds the receivers that are chosen. An error: several parts hold some.
pub fn holding(place: &Path, chosen: &Selection, access: Access, workspace: &Workspace) -> Result<Archive> {
    let Some(atlas) = Atlas::find(place)? else { return open_archive(place, access) };
    let within = if let Selection::Bounds(bounds) = chosen { Some(*bounds) } else { None };
    let sources = sources_of(&atlas, within, access)?;
    let counts = {
        let sites = sources.borrowed().iter().map(OpenSite::of).collect::<Result<Vec<_>>>()?;
        let kept = chosen.resolve(&sites, &workspace.folder, workspace.memory.length(Use::ReceiverList))?;
        let mut kept = kept.into_iter();
        let count = |site: &OpenSite| kept.by_ref().take(site.receivers() as usize).filter(|kept| *kept).count();
        sites.iter().map(count).collect::<Vec<_>>()
    };
    let archives = sources.into_archives().zip(counts);
    let mut holding: Vec<Archive> = archives.filter_map(|(archive, count)| (count > 0).then_some(archive)).collect();
    match (holding.pop(), holding.len()) {
        (Some(only), 0) => Ok(only),
        (last, others) => {
            let what = format!("{} parts of it hold receivers that are chosen, and one is taken", others + 1);
            let named = last.map(|archive| archive.path().display().to_string()).unwrap_or_default();
            Err(Error::input(&atlas.shown(), None, what, format!("name the archives one by one, such as {named}")))
        }
    }
}

/// The archive at a place, or those of all parts of an atlas there.
pub fn open(place: &Path, access: Access) -> Result<Sources> {
    match Atlas::find(place)? {
        Some(atlas) => sources_of(&atlas, None, access),
        None => open_archive(place, access).map(Sources::from),
    }
}

/// Archives of the parts of an atlas that a box touches.
pub fn sources_of(atlas: &Atlas, within: Option<Bounds>, access: Access) -> Result<Sources> {
    Sources::of(atlas.archives(within, access)?, || {
        let what = "no part of it holds a receiver of what is asked for";
        Error::input(&atlas.shown(), None, what, "a box is in the coordinates of the scene files")
    })
}
