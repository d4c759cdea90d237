//! Extract of an archive. In: an archive, a selection of receivers. Out: the archive of these
//! receivers, with only the cells that they need, or without any for replay only.

use std::path::Path;

use crate::Workspace;
use crate::transfer::output::{ArchiveAssembly, Assembled};
use crate::transfer::reach::{Keys, Marks};
use crate::transfer::rows::{ArchiveReceivers, Shown, TracedLayers, cells};
use crate::transfer::selection::Selection;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::{Archive, Manifest};
use heliotile_core::error::Result;
use heliotile_core::layers::response::Response;
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::opened::{CellSource, OpenSite};

/// Report of an extract.
#[derive(Clone, Debug)]
pub struct Extracted {
    /// Content of the new archive.
    pub written: Assembled,
    /// Content of the archive that it was taken from.
    pub of: Whole,
}

/// Content of the archive that was extracted from.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    /// Number of receivers.
    pub receivers: u64,
    /// Number of cells that receivers see.
    pub probes: u64,
    /// Number of coarser cells that probes and other coarse cells see.
    pub bounce_cells: u64,
}

/// Layers that an extract takes besides those of its receivers.
#[derive(Clone, Copy, Debug)]
pub struct ExtractContent {
    /// True with the triangles of the scene.
    pub scene: bool,
    /// True without hits and cells. An archive that has none gives only such.
    pub replay_only: bool,
}

/// Writes the archive of some receivers, or of all. With hits and cells it has the same bytes as a
/// build of these receivers alone.
pub fn extract(
    archive: &Archive,
    selection: Option<&Selection>,
    content: ExtractContent,
    path: &Path,
    workspace: &Workspace,
    observer: &dyn Observer,
) -> Result<Extracted> {
    let Workspace { folder, memory } = workspace;
    let mut site = OpenSite::open(archive)?;
    if content.replay_only {
        site = site.for_replay_only();
    }
    let kept = match selection {
        None => vec![true; site.receivers() as usize],
        Some(some) => some.resolve(std::slice::from_ref(&site), folder, memory.length(Use::ReceiverList))?,
    };
    let budget = memory.length(Use::ExtractedKeys);
    let keys = || Keys::new(folder, budget);

    let mut output = ArchiveAssembly::create(path, &[archive], observer)?;
    let mut hits = keys();
    output.tiles(ArchiveReceivers::<TracedLayers>::chosen(&site, archive, &kept).map(|row| {
        let row = row?;
        let mut seen: Vec<_> = row.layers.reached().collect();
        seen.sort_unstable();
        seen.dedup();
        seen.into_iter().try_for_each(|key| hits.push(key))?;
        Ok(row)
    }))?;
    let manifest = archive.manifest();
    if !site.is_replay_only() {
        let (of_probes, of_bounces) = (CellSource::probes(&site)?, CellSource::bounces(&site)?);
        let (mut probes, mut bounces, mut seen) = (Marks::default(), Marks::default(), keys());
        probes.add(&of_probes, "hit", hits, |key| seen.push(key))?;
        bounces.add_reachable(&of_bounces, "probes", seen, keys)?;
        let settings = &manifest.settings;
        output.probes(settings, cells(&of_probes, probes.chunks(), |chunk, row| probes.contains(chunk, row)))?;
        output.bounces(settings, cells(&of_bounces, bounces.chunks(), |chunk, row| bounces.contains(chunk, row)))?;
    }
    output.materials(archive)?;
    if content.scene {
        output.scene(&[archive])?;
    }
    // Receivers are read again for each layer, so that memory stays bounded.
    output.responses(ArchiveReceivers::<Response>::chosen(&site, archive, &kept))?;
    if content.scene {
        output.overview(&[archive], ArchiveReceivers::<Shown>::chosen(&site, archive, &kept))?;
    }
    output.name_index(workspace, ArchiveReceivers::<()>::chosen(&site, archive, &kept))?;
    output.copy_unknown(&[archive])?;
    let accuracy = manifest.accuracy.clone().map(Accuracy::without_tiles);
    let written = output.finish(Manifest { accuracy, replay_only: site.is_replay_only(), ..manifest.clone() })?;
    let of = Whole {
        receivers: manifest.receivers.count,
        probes: manifest.counts.probes,
        bounce_cells: manifest.counts.bounce_cells,
    };
    Ok(Extracted { written, of })
}
