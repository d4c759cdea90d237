//! Building: scene -> trace -> layers -> archive. In: a prepared scene, its receivers, settings.
//! Out: a finished archive and a report. The steps are [`Build::plan`](crate::planning), which
//! makes a forecast first ([`Build::forecast`]), then [`Build::write`]. Never: printing, command
//! lines.

mod canopies;
mod cells;
mod forecast;
mod geometry;
mod layer_cache;
mod manifest;
mod mirrors;
mod output;
mod plan;
mod prepared;
mod previous_build;
mod report;
mod sample;
mod site_tracer;
mod tiles;
mod unaltered;

use std::cell::OnceCell;
use std::path::Path;
use std::sync::atomic::Ordering;

use crate::receiver_tiles::ReceiverTiles;
use crate::settings::{BuildSettings, EffectChoice};
use crate::trace::Tracer;
use crate::trace::canopy::in_hulls;
use heliotile_archives::Workspace;
use heliotile_archives::writing::{Job, Writer};
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::manifest::ReceiverSummary;
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::archive::{Archive, Manifest, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::opened::SiteFacts;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{Message, message};
use heliotile_scene::Scene;
use heliotile_scene::placing::plausible::{FarReceivers, far_receivers};
use heliotile_scene::points::receivers::{ReceiverCsv, ReceiverRows};
use layer_cache::LayerCache;
use previous_build::PreviousBuild;
use report::Clock;
use site_tracer::SiteTracer;

pub use forecast::{Forecast, Line, NEGLIGIBLE_W_M2, SKY_W_M2, SUN_W_M2};
pub use geometry::holds_objects;
pub use manifest::BuildCounts;
pub use output::{Output, Start};
pub use plan::Plan;
pub use prepared::{Below, PreparedScene};
pub use report::{BuildReport, RayCounts, ReusedCounts};

/// Reads the receivers of a table into tiles. Warns of ignored columns and of receivers far
/// from the scene.
pub fn read_receivers<'a>(
    workspace: &Workspace,
    table: impl Into<ReceiverCsv<'a>>,
    scene: &Scene,
    observer: &dyn Observer,
) -> Result<ReceiverTiles> {
    let table = table.into();
    let mut warnings = Vec::new();
    let budget = workspace.memory.length(Use::SortedReceivers);
    // Only a table of heights needs the scene's tree.
    let prepared: OnceCell<PreparedScene> = OnceCell::new();
    let surface = |x: f64, y: f64| -> Result<Option<f64>> {
        if prepared.get().is_none() {
            // The cell was empty, so that nothing is lost.
            let _ = prepared.set(PreparedScene::new(scene)?);
        }
        Ok(prepared.get().and_then(|prepared| prepared.top(x, y)).map(|top| top.z))
    };
    let rows = ReceiverRows::open(table, scene.table_north(), &mut warnings)?.over(&surface);
    let receivers = ReceiverTiles::open(rows, scene.mesh.origin, &workspace.folder, budget)?;
    warnings.iter().for_each(|warning| observer.warn(warning));
    judge_distance(&receivers, scene, table.name(), observer)?;
    Ok(receivers)
}

/// Sorts receivers that are in memory into tiles. Warns of receivers far from the scene.
pub fn sort_receivers(
    workspace: &Workspace,
    rows: &[Receiver],
    scene: &Scene,
    observer: &dyn Observer,
) -> Result<ReceiverTiles> {
    let budget = workspace.memory.length(Use::SortedReceivers);
    let receivers = ReceiverTiles::checked(rows, scene.mesh.origin, &workspace.folder, budget)?;
    judge_distance(&receivers, scene, Path::new("receivers"), observer)?;
    Ok(receivers)
}

/// Warns of receivers far from the scene; `table` names them. Refuses those that would all lie in
/// it with their coordinates swapped or in another unit.
fn judge_distance(receivers: &ReceiverTiles, scene: &Scene, table: &Path, observer: &dyn Observer) -> Result<()> {
    let far = |farthest| far_receivers(scene, receivers.bounds(), farthest, receivers.count());
    match receivers.farthest().and_then(far) {
        Some(FarReceivers { what, is_mistake: true }) => {
            let hint = "give x, y and z of receivers in metres and in the coordinates of the scene";
            Err(Error::input(table, None, what, hint).because(Problem::Misplaced))
        }
        Some(FarReceivers { what, .. }) => {
            observer.warn(format!("{}: {what}", table.display()));
            Ok(())
        }
        None => Ok(()),
    }
}

/// Finished archives from which a build copies layers.
#[derive(Clone, Copy, Default)]
pub struct ReusedArchives<'a> {
    /// Archive of the same scene with the same settings, complete or damaged.
    pub earlier: Option<&'a Archive>,
    /// Archive of the scene before it was changed.
    pub before: Option<&'a Archive>,
}

/// Scene with its receivers, ready to be traced.
pub struct Build<'a> {
    /// Scene to trace.
    pub scene: &'a PreparedScene<'a>,
    /// Receivers, cut into tiles.
    pub receivers: &'a mut ReceiverTiles,
    /// Folder of temporary files and memory budget.
    pub workspace: &'a Workspace,
    /// Gets progress and warnings, and can stop the build.
    pub observer: &'a dyn Observer,
}

impl Build<'_> {
    /// Returns the facts of the site that are known before the archive is complete.
    fn facts(&self, settings: &BuildSettings, path: &Path) -> Result<SiteFacts> {
        let (scene, mirrors) = (self.scene.scene, &self.scene.mirrors);
        let receivers = ReceiverSummary {
            count: self.receivers.count() as u64,
            tiles: self.receivers.tile_count() as u32,
            ..ReceiverSummary::default()
        };
        let orientations = if self.scene.reflects(settings) { mirrors.orientations.clone() } else { Vec::new() };
        let (stated, origin, materials) = (settings.stated(), scene.mesh.origin, scene.materials.clone());
        SiteFacts::given(path, &stated, origin, &receivers, materials, orientations)
    }

    /// Forecasts what a build with some settings would trace, from a sample of its receivers,
    /// without writing an archive. With [`EffectChoice::Auto`], `negligible` decides on effects in
    /// place of the bounds.
    pub fn forecast(
        &mut self,
        settings: &BuildSettings,
        effects: EffectChoice,
        negligible: Option<&Negligible>,
    ) -> Result<Forecast> {
        let (facts, known) = (self.facts(settings, &self.workspace.folder)?, LayerCache::default());
        let tracer = SiteTracer::new(self.scene, settings, self.workspace, self.observer, facts, known, None);
        tracer.forecast(self.receivers, self.scene.mirrors.orientations.len(), effects, negligible)
    }

    /// Traces the receivers and writes the archive. Layers that `sources` hold are copied. Equal
    /// inputs give equal bytes, whatever the sources, the order of receivers, the number of threads
    /// or the memory. If work fails or is stopped, what was written up to the last checkpoint, if
    /// there was one, remains for [`Start::Resume`].
    pub fn write(&mut self, plan: &Plan, output: &Output, sources: &ReusedArchives) -> Result<BuildReport> {
        let (scene, settings) = (self.scene.scene, &plan.settings);
        let mut clock = Clock::after("tree", self.scene.seconds);
        let facts = self.facts(settings, &output.path)?;
        let known = LayerCache::new(sources.earlier, &facts);
        let open = |archive| PreviousBuild::open(archive, self.scene, settings, self.observer);
        let before = sources.before.map(open).transpose()?.flatten();
        if before.is_some() {
            clock.lap("compare");
        }
        let mut writer = output.writer(&Job {
            scene: scene.named_hash(),
            receivers: self.receivers.content_hash(),
            settings: plan.hash()?,
        })?;
        if let Some(done) = writer.resumed() {
            let megabytes = done.bytes as f64 / 1e6;
            self.observer
                .warn(format!("continuing an interrupted build after {} blocks of {megabytes:.1} MB", done.blocks));
        }
        let tracer = SiteTracer::new(self.scene, settings, self.workspace, self.observer, facts, known, before);
        let traced = trace(&tracer, plan, self.receivers, &mut writer, &mut clock);
        if matches!(traced, Err(Error::Io { .. })) {
            // If another file failed, such as a temporary one, the blocks written so far can be
            // kept.
            let _ = writer.checkpoint();
        }
        let kept = writer.committed();
        let finish = |traced: Traced| {
            let summary = writer.finish(&traced.manifest)?;
            clock.lap("finish");
            let Traced { counts, rays, warnings, lost_in_mirrors, .. } = traced;
            let (bytes, root) = (summary.bytes, summary.root);
            let kept = tracer.before.as_ref().map(PreviousBuild::reused);
            Ok(BuildReport { counts, rays, seconds: clock.laps, bytes, root, warnings, lost_in_mirrors, kept })
        };
        traced.and_then(finish).map_err(|error| output::kept(error, kept))
    }
}

/// Facts about an archive whose blocks are all written.
struct Traced {
    counts: BuildCounts,
    rays: RayCounts,
    warnings: Vec<Message>,
    manifest: Manifest,
    lost_in_mirrors: [f64; 2],
}

/// Writes all blocks that the writer does not hold yet.
fn trace(
    tracer: &SiteTracer,
    plan: &Plan,
    receivers: &mut ReceiverTiles,
    writer: &mut Writer,
    clock: &mut Clock,
) -> Result<Traced> {
    let farthest = receivers.farthest().and_then(|receiver| far_away(tracer.tracer, tracer.scene, receiver));
    let mut warnings: Vec<Message> = farthest.into_iter().collect();
    let mut rays = RayCounts::default();

    let mut misplaced = Vec::new();
    // Each stage finds the cells that the next one traces.
    let keys = tracer.write_receivers(receivers, writer, &mut rays, &mut misplaced)?;
    clock.lap("receivers");
    let probes = tracer.write_probes(keys, writer, &mut rays)?;
    let bounce_cells = tracer.write_bounces(probes.seen, writer, &mut rays)?;
    clock.lap("cells");

    if !writer.has(format::MATERIALS, TileNumber::FIRST) {
        writer.append(tracer.materials_block()?)?;
        for block in tracer.optics_blocks()? {
            writer.append(block)?;
        }
    }
    if plan.with_scene {
        for (chunk, block) in (0..).zip(tracer.scene_blocks()) {
            if !writer.has(format::SCENE, TileNumber(chunk)) {
                writer.append(block?)?;
            }
        }
        for (chunk, block) in (0..).zip(tracer.object_blocks()) {
            if !writer.has(format::OBJECTS, TileNumber(chunk)) {
                writer.append(block?)?;
            }
        }
    }
    let tiles = receivers.tile_count() as u32;
    let counts = BuildCounts { receivers: receivers.count() as u64, tiles, probes: probes.count, bounce_cells };
    tracer.write_responses(tiles, writer, clock)?;
    if plan.with_scene {
        tracer.write_overview(receivers, writer, clock)?;
    }
    tracer.write_name_index(receivers, writer)?;
    let manifest = tracer.manifest(&counts, plan, writer.layers());
    warnings.extend(tiles::warnings(&misplaced));
    warnings.extend(in_hulls(tracer.count_in_hulls(receivers)?).into_iter().map(Message::from));
    let lost_in_mirrors = tracer.lost.each_ref().map(|lost| f64::from_bits(lost.load(Ordering::Relaxed)));
    Ok(Traced { counts, rays, warnings, manifest, lost_in_mirrors })
}

/// Offset of ray origins from surfaces above which a warning is given, metres.
const LARGE_OFFSET_M: f64 = 0.01;

/// Returns a warning if a receiver is so far from the scene's origin that details near it are lost.
fn far_away(tracer: &Tracer, scene: &Scene, worst: &Receiver) -> Option<Message> {
    let (offset_m, o) = (tracer.grid().offset_m(worst.position), scene.mesh.origin);
    (offset_m > LARGE_OFFSET_M).then(|| {
        message!(
            "receiver {} lies far from the scene's centre ({:.0}, {:.0}, {:.0}): rays start {:.1} mm off its surface and finer \
             details are lost; look for stray geometry, or build the site in parts",
            worst.id,
            o.x,
            o.y,
            o.z,
            offset_m * 1e3
        )
    })
}
