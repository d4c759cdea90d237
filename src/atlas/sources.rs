//! The archives that results are computed from. In: the place of an archive or of an atlas, and a
//! box. Out: the archive, or the archives of the parts that the box touches.

use std::path::Path;

use crate::opened::Atlas;
use heliotile_archives::Workspace;
use heliotile_archives::transfer::{Bounds, Selection};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::OpenSite;
use heliotile_remote::places::open_archive;
use heliotile_results::Sources;

/// Opens the archives of the parts of an atlas that a box touches. An error: a part that is not
/// built.
pub fn archives(atlas: &Path, within: Option<Bounds>, access: Access) -> Result<Sources> {
    sources_of(&Atlas::open(atlas)?, within, access)
}

/// Opens the archive at a place; in an atlas, the archive of the part that holds the chosen
/// receivers, or any. An error: several parts hold some.
pub fn holding(place: &Path, chosen: Option<&Selection>, access: Access, workspace: &Workspace) -> Result<Archive> {
    let Some(atlas) = Atlas::find(place)? else { return open_archive(place, access) };
    let within = if let Some(Selection::Bounds(bounds)) = chosen { Some(*bounds) } else { None };
    let sources = sources_of(&atlas, within, access)?;
    let counts = {
        let sites = sources.borrowed().iter().map(OpenSite::open).collect::<Result<Vec<_>>>()?;
        let budget = workspace.memory.length(Use::ReceiverList);
        let kept = match chosen {
            Some(chosen) => chosen.resolve(&sites, &workspace.folder, budget)?,
            None => vec![true; sites.iter().map(OpenSite::receivers).sum::<u64>() as usize],
        };
        let mut kept = kept.into_iter();
        let count = |site: &OpenSite| kept.by_ref().take(site.receivers() as usize).filter(|kept| *kept).count();
        sites.iter().map(count).collect::<Vec<_>>()
    };
    let archives = sources.into_archives().zip(counts);
    let mut holding: Vec<Archive> = archives.filter_map(|(archive, count)| (count > 0).then_some(archive)).collect();
    match (holding.pop(), holding.len()) {
        (Some(only), 0) => Ok(only),
        (last, others) => {
            let what = format!("{} parts hold chosen receivers, but only one part can be used", others + 1);
            let named = last.map(|archive| archive.path().display().to_string()).unwrap_or_default();
            Err(Error::input(
                &atlas.shown(),
                None,
                what,
                format!("give the archive of each part by itself, such as {named}"),
            )
            .because(Problem::other_kind("atlas")))
        }
    }
}

/// Opens the archive at a place, or the archives of all parts of an atlas there.
pub fn open(place: &Path, access: Access) -> Result<Sources> {
    match Atlas::find(place)? {
        Some(atlas) => sources_of(&atlas, None, access),
        None => open_archive(place, access).map(Sources::from),
    }
}

/// Opens the archives of the parts that a box touches, for an open atlas.
pub fn sources_of(atlas: &Atlas, within: Option<Bounds>, access: Access) -> Result<Sources> {
    Sources::new(atlas.archives(within, access)?, || {
        let what = "no part of the atlas holds a requested receiver";
        Error::input(&atlas.shown(), None, what, "give a box in coordinates of the scene files").because(Problem::Empty)
    })
}
