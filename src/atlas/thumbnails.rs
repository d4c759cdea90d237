//! Thumbnails of parts in a clear year. In: archives, whose stored sums are drawn without a replay.
//! Out: PNG, one for each part and one of all, in the same colours.

use std::path::Path;

use rayon::prelude::*;

use heliotile_archives::transfer::{ArchiveReceivers, Shown};
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::receiver::Receiver;
use heliotile_remote::places::open_archive;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::shapes::group_patches::polygons;
use heliotile_results::outputs::shapes::picture::thumbnail::ThumbnailFrame;
use heliotile_results::outputs::shapes::row::{MapPolygon, MapRow};
use heliotile_results::surroundings;

/// Pictures of some archives, drawn on demand.
pub struct Thumbnails<'a> {
    /// Archives, each with the frame of its picture; `None` for an archive without sums.
    parts: Vec<(&'a Path, Option<ThumbnailFrame>)>,
    /// Frame of the picture of all archives; `None` if no archive has sums.
    all: Option<ThumbnailFrame>,
    /// Provenance that the pictures state.
    about: Provenance,
}

impl<'a> Thumbnails<'a> {
    /// Reads the range of the sums of each archive and the area that they cover.
    pub fn new(paths: &[&'a Path], about: Provenance) -> Result<Self> {
        let frame = |path: &&'a Path| Ok((*path, frame(&open_archive(path, Access::Read)?)?));
        let parts: Vec<_> = paths.par_iter().map(frame).collect::<Result<_>>()?;
        let all = parts.iter().filter_map(|(_, frame)| *frame).reduce(|all, frame| all.union(&frame));
        Ok(Thumbnails { parts, all, about })
    }

    /// Returns the value of the brightest colour of all pictures, kWh/m2.
    pub fn top_kwh_m2(&self) -> f64 {
        self.all.map_or(0.0, |all| all.top())
    }

    /// Returns the number of archives without a picture.
    pub fn without(&self) -> usize {
        self.parts.iter().filter(|(_, frame)| frame.is_none()).count()
    }

    /// Draws one of the archives as PNG, with the surroundings of its receivers.
    pub fn part(&self, number: usize) -> Result<Option<Vec<u8>>> {
        let (Some((path, Some(frame))), Some(all)) = (self.parts.get(number), self.all) else { return Ok(None) };
        let archive = open_archive(path, Access::Read)?;
        let site = OpenSite::open(&archive)?;
        let about = self.about.clone().with_archive(path, &archive);
        let around = surroundings(&archive, &site);
        frame.in_colours_of(&all).png(around.as_ref(), &about, |draw| each(&site, draw)).map(Some)
    }

    /// Draws all archives as one PNG.
    pub fn all(&self) -> Result<Option<Vec<u8>>> {
        let draw = |draw: &mut dyn FnMut(&MapRow)| {
            let paths = self.parts.iter().filter(|(_, frame)| frame.is_some()).map(|(path, _)| path);
            paths.into_iter().try_for_each(|path| each(&OpenSite::open(&open_archive(path, Access::Read)?)?, draw))
        };
        self.all.map(|all| all.png(None, &self.about, draw)).transpose()
    }
}

/// Returns the frame of an archive's picture, or `None` where it has no sums.
fn frame(archive: &Archive) -> Result<Option<ThumbnailFrame>> {
    let site = OpenSite::open(archive)?;
    let (mut frame, mut count) = (ThumbnailFrame::new(site.north()), 0_u64);
    each(&site, &mut |row| {
        frame.add(row);
        count += 1;
    })?;
    Ok((count > 0).then_some(frame))
}

/// Passes the places of all receivers with their sums to `take`, up to the first receiver without a
/// sum.
fn each(site: &OpenSite, take: &mut dyn FnMut(&MapRow)) -> Result<()> {
    for row in ArchiveReceivers::<Shown>::new(site) {
        let row = row?;
        let Some(kwh_m2) = row.layers.clear_year else { break };
        let receiver = Receiver { patch: row.layers.patch, ..row.receiver };
        let polygons = polygons(&receiver).unwrap_or_else(|| vec![MapPolygon::point(receiver.position)]);
        take(&MapRow { texts: Vec::new(), numbers: vec![kwh_m2], polygons });
    }
    Ok(())
}
