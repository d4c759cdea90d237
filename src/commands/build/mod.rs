//! Story one: scene -> trace -> layers -> archive.

mod cells;
mod manifest;
mod tiles;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;

use super::progress::bar;
use super::{Outcome, guard_output, say, warn};
use crate::archive::{self, EncodedBlock, Writer, encode, format};
use crate::cli::BuildArgs;
pub use crate::cli::Share;
use crate::error::{Error, Result};
use crate::hemisphere::texel_centres;
use crate::recombine::bounces::Depth;
use crate::recombine::load::TileView;
use crate::recombine::response::{Reflector, Responder, Shape};
use crate::scene::Scene;
use crate::scene::cells::{CellKey, level_of};
use crate::scene::receivers::{Receiver, TILE, morton_order, read_receivers_with_warnings};
use crate::trace::Tracer;
pub use manifest::Counts;
use tiles::TracedTile;

/// Everything that decides what an archive of a scene holds. The defaults are the row "1 %" of the accuracy ladder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildSettings {
    /// Side of the receivers' sky texture before and after refinement.
    pub sky_base: usize,
    pub sky_fine: usize,
    /// Side of the hit texture.
    pub hit: usize,
    /// Edge of a fine cell in units of the hit texel's footprint, and its smallest value.
    pub cell_factor: f64,
    pub cell_floor_m: f64,
    /// Side of the probes' sky texture and of the response.
    pub probe: usize,
    /// Rays of a probe to the surfaces around it.
    pub probe_hits: usize,
    /// Edge of the bounce cells at middle distance: the closed system.
    pub closed_m: f64,
    /// Side of the bounce cells' sky texture, and their rays to the surfaces around them.
    pub bounce_sky: usize,
    pub bounce_hits: usize,
    pub share: Share,
}

impl Default for BuildSettings {
    fn default() -> Self {
        BuildSettings {
            sky_base: 128,
            sky_fine: 1024,
            hit: 32,
            cell_factor: 4.0,
            cell_floor_m: 0.5,
            probe: 32,
            probe_hits: 16,
            closed_m: 8.0,
            bounce_sky: 16,
            bounce_hits: 32,
            share: Share::Cells,
        }
    }
}

/// What a build did.
#[derive(Clone, Debug)]
pub struct BuildReport {
    pub counts: Counts,
    /// Seconds by stage.
    pub seconds: Vec<(&'static str, f64)>,
    pub bytes: u64,
    pub root: [u8; 32],
    pub warnings: Vec<String>,
}

/// Rays cast, by purpose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rays {
    pub sky: u64,
    pub hit: u64,
    pub probe: u64,
    pub bounce: u64,
}

impl BuildSettings {
    /// Shape of the tables that responses are derived from.
    fn shape(&self) -> Shape {
        Shape { hit: self.hit, probe: self.probe, bounce_sky: self.bounce_sky, closed_level: level_of(self.closed_m) }
    }

    /// Edge of a fine cell in footprints; 0 when every hit has a probe of its own.
    fn cell_factor(&self) -> f64 {
        if self.share == Share::None { 0.0 } else { self.cell_factor }
    }
}

/// Level of the block compressor: textures are written once and read for years.
const COMPRESSION: i32 = 9;

/// What every part of a build works on.
struct Job<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer,
    settings: &'a BuildSettings,
}

impl Job<'_> {
    fn reflectors(&self) -> Vec<Reflector> {
        self.scene.materials.iter().map(|m| Reflector { diffuse: m.diffuse, class: m.class }).collect()
    }

    fn encode(&self, kind: u32, tile: u32, items: usize, raw: &[u8]) -> Result<EncodedBlock> {
        let items = u32::try_from(items).map_err(|_| Error::Limit {
            what: "items of one block".into(),
            value: items as u64,
            max: u64::from(u32::MAX),
        })?;
        encode(kind, tile, 1, items, raw, COMPRESSION)
    }
}

/// `heliotile build`.
pub fn run(args: &BuildArgs) -> Result<Outcome> {
    let inputs: Vec<&Path> = [Some(&args.scene), Some(&args.receivers), args.materials.as_ref()]
        .into_iter()
        .flatten()
        .map(|p| &**p)
        .collect();
    guard_output(&args.output, &inputs)?;
    guard_archive(&args.output)?;
    let scene = Scene::load(&args.scene, args.materials.as_deref())?;
    scene.report.warnings.iter().for_each(|w| warn(w));
    let mut warnings = Vec::new();
    let receivers = read_receivers_with_warnings(&args.receivers, &mut warnings)?;
    warnings.iter().for_each(|w| warn(w));
    let settings = BuildSettings { share: args.share, ..BuildSettings::default() };
    let report = build(&scene, &receivers, &settings, &args.output)?;
    report.warnings.iter().for_each(|w| warn(w));
    say(&summary(&report, &scene, &args.output))?;
    Ok(Outcome::Fine)
}

/// Traces a scene for its receivers and writes the archive; equal inputs give equal bytes, whatever the order of receivers
/// or the number of threads.
pub fn build(scene: &Scene, receivers: &[Receiver], settings: &BuildSettings, output: &Path) -> Result<BuildReport> {
    let mut seconds = Vec::new();
    let mut clock = Instant::now();
    let mut lap = |name| {
        seconds.push((name, clock.elapsed().as_secs_f64()));
        clock = Instant::now();
    };
    // Nothing is checkpointed yet, so nothing is compared with these.
    let hashes = archive::Job { scene: scene.content_hash(), receivers: [0; 32], settings: [0; 32] };
    let mut writer = Writer::create(output, &hashes)?;
    let tracer = Tracer::new(&scene.mesh)?;
    let job = Job { scene, tracer: &tracer, settings };
    lap("tree");
    let mut warnings: Vec<String> = far_away(&tracer, scene, receivers).into_iter().collect();

    let order = morton_order(receivers, scene.mesh.origin);
    let tiles: Vec<Vec<&Receiver>> =
        order.chunks(TILE).map(|tile| tile.iter().map(|&i| &receivers[i]).collect()).collect();
    let mut rays = Rays::default();
    let mut misplaced = Vec::new();
    let mut keys: BTreeSet<CellKey> = BTreeSet::new();
    let progress = bar("receivers", Some(receivers.len() as u64));
    let directions = texel_centres(settings.sky_base);
    for (batch, chunk) in tiles.chunks(rayon::current_num_threads() * 2).enumerate() {
        let first = batch * rayon::current_num_threads() * 2;
        let traced: Vec<Result<TracedTile>> = chunk
            .par_iter()
            .enumerate()
            .map(|(i, tile)| job.trace_tile((first + i) as u32, tile, &directions))
            .collect();
        for tile in traced {
            let tile = tile?;
            tile.blocks.into_iter().try_for_each(|block| writer.append(block))?;
            keys.extend(tile.cells);
            rays.sky += tile.rays.sky;
            rays.hit += tile.rays.hit;
            misplaced.extend(tile.misplaced);
        }
        progress.inc(chunk.iter().map(|t| t.len() as u64).sum());
    }
    progress.finish_and_clear();
    lap("receivers");

    let keys: Vec<CellKey> = keys.into_iter().collect();
    let (probes, bounces) = job.trace_cells(&keys, &mut rays);
    lap("cells");
    for block in job.probe_blocks(&probes)?.into_iter().chain(job.bounce_blocks(&bounces)?) {
        writer.append(block)?;
    }

    writer.append(job.materials_block()?)?;
    let counts = Counts {
        receivers: receivers.len(),
        tiles: tiles.len(),
        probes: probes.keys.len(),
        bounce_cells: bounces.keys.len(),
        rays,
    };
    let responder = Responder::new(probes, bounces, settings.shape(), job.reflectors(), Depth::All);
    lap("solve");
    for number in 0..tiles.len() as u32 {
        let receivers = writer.read_back(format::RECEIVERS, number)?;
        let hits = writer.read_back(format::HIT, number)?;
        let view = TileView::new(&receivers, &hits, scene.mesh.origin, settings.hit)?;
        writer.append(job.response_block(number, &view, &responder)?)?;
    }
    lap("response");
    let manifest = job.manifest(&counts, writer.layers());
    warnings.extend(tiles::warnings(&misplaced));
    let summary = writer.finish(&manifest)?;
    lap("finish");
    Ok(BuildReport { counts, seconds, bytes: summary.bytes, root: summary.root, warnings })
}

/// Rays start this far off surfaces (metres) before it is worth a warning.
const LARGE_OFFSET_M: f64 = 0.01;

/// A warning if some receiver lies so far from the scene's origin that details near it are lost.
fn far_away(tracer: &Tracer, scene: &Scene, receivers: &[Receiver]) -> Option<String> {
    let offset_m = |r: &Receiver| tracer.offset_m(r.position - scene.mesh.origin);
    let worst = receivers.iter().max_by(|a, b| offset_m(a).total_cmp(&offset_m(b)))?;
    let (offset_m, o) = (offset_m(worst), scene.mesh.origin);
    (offset_m > LARGE_OFFSET_M).then(|| {
        format!(
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

/// Refuses to replace a file that is not an archive.
fn guard_archive(output: &Path) -> Result<()> {
    let mut head = [0; format::MAGIC.len()];
    match File::open(output).and_then(|mut file| file.read_exact(&mut head)) {
        Ok(()) if head != format::MAGIC => {
            let hint = "give the archive a name of its own, or remove the file";
            Err(Error::input(output, None, "exists and is not an archive, it would be replaced", hint))
        }
        _ => Ok(()),
    }
}

/// The summary that a build ends with.
fn summary(report: &BuildReport, scene: &Scene, output: &Path) -> String {
    let counts = &report.counts;
    let total: f64 = report.seconds.iter().map(|s| s.1).sum();
    let rays = counts.rays.sky + counts.rays.hit + counts.rays.probe + counts.rays.bounce;
    let each = |x: f64| x / counts.receivers.max(1) as f64;
    let stages: Vec<String> = report.seconds.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    format!(
        "{}: {} receivers, {} triangles\n  {} probes, {} bounce cells, {:.1} Mray ({:.0} a receiver), {:.2} MB ({:.0} bytes a \
         receiver)\n  {total:.2} s: {}\n  root {}\n",
        output.display(),
        counts.receivers,
        scene.mesh.triangles.len(),
        counts.probes,
        counts.bounce_cells,
        rays as f64 / 1e6,
        each(rays as f64),
        report.bytes as f64 / 1e6,
        each(report.bytes as f64),
        stages.join(", "),
        format::hex(&report.root),
    )
}
