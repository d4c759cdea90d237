//! Story one: scene -> trace -> layers -> archive.

mod cells;
mod manifest;
mod tiles;

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;

use super::progress::bar;
use super::{Outcome, warn};
use crate::archive::{EncodedBlock, Writer, encode, format};
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
    /// Edges of the first tier of bounce cells and of the closed system.
    pub tier_m: f64,
    pub closed_m: f64,
    /// Side of the bounce cells' sky texture and of their square of hit rays.
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
            tier_m: 4.0,
            closed_m: 8.0,
            bounce_sky: 16,
            bounce_hits: 8,
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
        Shape { hit: self.hit, probe: self.probe, bounce_sky: self.bounce_sky, tier_level: level_of(self.tier_m) }
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
    let scene = Scene::load(&args.scene, args.materials.as_deref())?;
    scene.report.warnings.iter().for_each(|w| warn(w));
    let mut warnings = Vec::new();
    let receivers = read_receivers_with_warnings(&args.receivers, &mut warnings)?;
    warnings.iter().for_each(|w| warn(w));
    let settings = BuildSettings { share: args.share, ..BuildSettings::default() };
    let report = build(&scene, &receivers, &settings, &args.output)?;
    report.warnings.iter().for_each(|w| warn(w));
    print(&report, &scene, &args.output);
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
    let mut writer = Writer::create(output)?;
    let tracer = Tracer::new(&scene.mesh)?;
    let job = Job { scene, tracer: &tracer, settings };
    lap("tree");

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
    let probes = job.trace_probes(&keys, &mut rays);
    lap("probes");
    let bounces = job.trace_bounces(&keys, &mut rays);
    lap("bounces");
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
    let summary = writer.finish(&manifest)?;
    lap("finish");
    Ok(BuildReport { counts, seconds, bytes: summary.bytes, root: summary.root, warnings: tiles::warnings(&misplaced) })
}

/// The summary that a build ends with.
fn print(report: &BuildReport, scene: &Scene, output: &Path) {
    let counts = &report.counts;
    let total: f64 = report.seconds.iter().map(|s| s.1).sum();
    let rays = counts.rays.sky + counts.rays.hit + counts.rays.probe + counts.rays.bounce;
    println!("{}: {} receivers, {} triangles", output.display(), counts.receivers, scene.mesh.triangles.len());
    println!(
        "  {} probes, {} bounce cells, {:.1} Mray ({:.0} a receiver), {:.2} MB ({:.0} bytes a receiver)",
        counts.probes,
        counts.bounce_cells,
        rays as f64 / 1e6,
        rays as f64 / counts.receivers.max(1) as f64,
        report.bytes as f64 / 1e6,
        report.bytes as f64 / counts.receivers.max(1) as f64,
    );
    let stages: Vec<String> = report.seconds.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    println!("  {total:.2} s: {}", stages.join(", "));
    println!("  root {}", format::hex(&report.root));
}
