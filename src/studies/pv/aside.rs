//! Archives beside the one of a study. In: a scene, receivers. Out: a temporary archive of them.

use std::path::Path;

use tempfile::TempDir;

use heliotile_archives::Workspace;
use heliotile_builder::pipeline::{Build, Output, Plan, PreparedScene, ReusedArchives};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::observer::Observer;
use heliotile_core::site::receiver::Receiver;

/// Temporary archive; dropping this value removes it.
pub struct TracedAside {
    archive: Archive,
    _folder: TempDir,
}

impl TracedAside {
    pub fn archive(&self) -> &Archive {
        &self.archive
    }
}

/// Traces receivers of a scene into a temporary archive.
pub fn trace_aside(
    prepared: &PreparedScene,
    receivers: &[Receiver],
    settings: &BuildSettings,
    folder: &Path,
    observer: &dyn Observer,
) -> Result<TracedAside> {
    let beside = tempfile::Builder::new().prefix(".pv").tempdir_in(folder);
    let beside = beside.map_err(Error::io(folder, "make a folder in"))?;
    let workspace = Workspace { folder: beside.path().into(), memory: MemoryBudget::DEFAULT };
    let budget = workspace.memory.length(Use::SortedReceivers);
    let mut tiles = ReceiverTiles::from_receivers(receivers, prepared.scene.mesh.origin, beside.path(), budget)?;
    let path = beside.path().join("aside.helio");
    let mut build = Build { scene: prepared, receivers: &mut tiles, workspace: &workspace, observer };
    build.write(
        &Plan { with_scene: false, ..Plan::new(*settings) },
        &Output::new(&path),
        &ReusedArchives::default(),
    )?;
    let archive = Archive::open_with(&path, Access::Read)?;
    Ok(TracedAside { archive, _folder: beside })
}
